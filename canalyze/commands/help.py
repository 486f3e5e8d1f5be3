"""`canalyze help`: the list of topics, or the page of one, rendered on a terminal and as it is elsewhere."""

import re
import shutil
from typing import Final

import click

from canalyze.configuration.options import argument
from canalyze.output import Output, complain
from canalyze.output.help import simple_command
from canalyze.words import Words

_WIDEST: Final = 110
_PAGE_LINK: Final = re.compile(r"\[([^\]]+)\]\((\w+)\.md(?:#[^)]*)?\)")
_FILE_LINK: Final = re.compile(r"!?\[([^\]]+)\]\((?!https?:)[^)]*\)")

_FENCE: Final = re.compile(r"^```(\w+)[^\n]*$", re.M)


def run(words: Words, *, topic: str | None) -> int:
    """Shows the topics, or the page of one."""
    from canalyze import pages

    out = Output()
    if topic is None:
        left = max(map(len, pages.TOPICS))
        lines = [f"  {name:<{left}}  {pages.title(name, words.lang)}" for name in pages.TOPICS]
        out.text("\n".join([words("help.topics"), *lines, words("help.try_them")]) + "\n")
        return 0
    found = pages.topic_of(topic)
    if found is None:
        complain(f"canalyze: {_unknown(topic, words)}")
        return 2
    text = _FENCE.sub(_plain, pages.page(found, words.lang))
    out.text(_rendered(text) if out.is_terminal else text)
    return 0


def _completed(_: click.Context, __: click.Parameter, begun: str) -> list[str]:
    """Returns the topics that begin so, for a shell."""
    from canalyze.pages import TOPICS

    return [topic for topic in TOPICS if topic.startswith(begun.lower())]


def _unknown(topic: str, words: Words) -> str:
    from difflib import get_close_matches

    from canalyze.pages import TOPICS, topic_of

    names = [*TOPICS, *(name for commands in TOPICS.values() for name in commands)]
    near = get_close_matches(topic.lower(), names, n=1)
    found = near and topic_of(near[0])
    return words("help.near", topic=topic or '""', near=found) if found else words("help.unknown", topic=topic or '""')


def _plain(fence: re.Match[str]) -> str:
    """Returns the line that opens a block without what only the tests of the pages need."""
    return "```" if fence[1] in ("text", "console") else f"```{fence[1]}"


def _asked_for(link: re.Match[str]) -> str:
    """Returns a link to another page as what shows that page here."""
    asked = f"`canalyze help {link[2]}`"
    return asked if link[1] == link[2] else f"{link[1]} ({asked})"


def _rendered(text: str) -> str:
    """Lays the page out for this terminal; what it links to is named as it is asked for here."""
    import io

    from rich.console import Console
    from rich.markdown import Markdown
    from rich.theme import Theme

    text = _FILE_LINK.sub(r"\1", _PAGE_LINK.sub(_asked_for, text))
    columns = min(shutil.get_terminal_size().columns, _WIDEST)
    theme = Theme({"markdown.code": "bold", "markdown.h1": "bold", "markdown.h2": "bold underline"})
    console = Console(file=io.StringIO(), force_terminal=True, width=columns, theme=theme)
    console.print(Markdown(text, code_theme="ansi_dark", hyperlinks=False))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


command = simple_command("help", run, argument("topic", "TOPIC", required=False, shell_complete=_completed), paged=True)
