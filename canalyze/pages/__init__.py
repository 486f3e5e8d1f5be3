"""The pages for users, as data: `LANG/TOPIC.md`, for the web and for `canalyze help TOPIC`.

This module lists the topics in their order, and the commands of each. Must not: hold a sentence of its own, or lay
anything out.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

FOLDER: Final = Path(__file__).parent
TOPICS: Final[Mapping[str, tuple[str, ...]]] = {
    "decode": ("decode", "explain"),
    "sdo": ("sdo",),
    "pdo": ("signals", "eds"),
    "od": ("od",),
    "summary": ("summary",),
    "diagnosis": ("diagnose", "page", "examples"),
    "standstill": (),
    "recording": (),
    "live": ("sniff",),
    "monitor": ("monitor",),
    "timeline": ("view",),
    "ci": ("check", "diff"),
    "fleet": ("fleet",),
    "expectations": ("expect",),
    "formats": ("convert", "info"),
    "export": ("export",),
    "configuration": (),
    "agents": ("mcp",),
    "library": (),
    "pytest": (),
    "columns": (),
    "rules": ("rules",),
    "problems": (),
    "glossary": (),
}
"""The topics, and the commands that lead to each."""
README: Final = "README"
"""The page that leads to the topics; it is no topic, but is shown as well."""


def page(topic: str, lang: str) -> str:
    """Returns the markdown of a topic, one of TOPICS, or of README; the English README is that of the distribution."""
    if topic == README and lang == "en":
        if (beside := FOLDER.parents[1] / f"{README}.md").exists():
            return beside.read_text(encoding="utf-8")
        from importlib.metadata import metadata

        return metadata("canalyze")["Description"]
    return (FOLDER / lang / f"{topic}.md").read_text(encoding="utf-8")


def title(topic: str, lang: str) -> str:
    """Returns the title of a page, its first line."""
    return page(topic, lang).partition("\n")[0].removeprefix("# ")


def topic_of(name: str) -> str | None:
    """Returns the topic of a name or a command; None for other names."""
    name = name.lower().removesuffix(".md")
    if name == README.lower():
        return README
    if name in TOPICS:
        return name
    return next((topic for topic, commands in TOPICS.items() if name in commands), None)
