"""Help pages and usage errors in the language of the run, on top of click; and the pager, as git has one.

click's own pages are English and measure text in characters; these are laid out by `layout`. The pager is between
standard output and the terminal: it is started by the first output, so that a command without output has none, and
until its end it also gets standard error if that is the terminal. Sentences are in `words`; nothing here knows a
command.
"""

import os
import signal
import stat
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Self

import click

from canalyze.configuration.config import Config
from canalyze.configuration.options import COMMON, PROBLEM, SHORT, CoreUsageError, HelpOption, Parameter, built
from canalyze.output import Output, complain, terminal_encoding
from canalyze.output.layout import definitions, width, wrap
from canalyze.words import Words

if TYPE_CHECKING:
    import subprocess

_MARGIN: Final = 2
_FEW: Final = 8
"""Maximum number of options without headings."""
_TERM: Final = 24
"""Maximum width of an option with its explanation beside it."""
_USUAL: Final = 5
"""Options that stand first."""
_TOPICS: Final = (
    *("usual", "own", "chosen", "time", "network", "input"),
    *("bus", "recording", "timeline", "output", "general"),
)
"""The headings in their order."""
_STREAMS: Final = (1, 2)
"""Standard output and standard error."""
_PAGER: Final = "less -FRX"
_OPTIONS: Final = "FRX"
"""Options for a `less` that the user has chosen without options: it ends if all fits the screen, and keeps colours."""


class Located(click.Command):
    """A command that adds its context to usage errors, which click's parser leaves out of some."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parses the arguments."""
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            error.ctx = error.ctx or ctx
            raise


class Command(Located):
    """A command whose help is a page in the language of the run."""

    def __init__(self, name: str, words: Words, run: Callable[..., int], rows: Iterable[Parameter]) -> None:
        """Takes the command's words by its name; `run` returns the exit code."""
        super().__init__(name, callback=run, params=built((*rows, *COMMON), _key(name), words), add_help_option=False)
        self._words = words

    def invoke(self, ctx: click.Context) -> Any:
        """Runs it."""
        short = [one.name for one in (PROBLEM, *SHORT)]
        if any(ctx.params.get(name) is not None for name in short):
            from canalyze.running.diagnosing import choose

            choose(ctx, self._words)
        for name in short:
            ctx.params.pop(name, None)
        if ctx.params.pop("eds_from_traffic", False):
            from canalyze.running.diagnosing import describe

            describe(ctx, self._words)
        return super().invoke(ctx)

    def get_help(self, ctx: click.Context) -> str:
        """Returns the page."""
        return page(self, ctx, self._words)

    def get_short_help_str(self, limit: int = 0) -> str:
        """Returns what a list of commands says of it, of any length."""
        return self._words(f"{_key(self.name or '')}.short")


def pager_line() -> list[str]:
    """Returns the command line of the pager that the environment selects; empty for none."""
    import shlex
    import shutil

    found = os.environ.get
    asked = next((value for name in ("CANALYZE_PAGER", "PAGER") if (value := found(name)) is not None), None)
    if asked is None:
        return _PAGER.split() if shutil.which("less") else []
    try:
        words = shlex.split(asked, posix=os.name == "posix")
    except ValueError:
        words = [asked]
    return [] if words == ["cat"] else words


class Pager:
    """The pager of this process; a context manager that waits for it at the end."""

    def __init__(self, unusable: Callable[[str, OSError], None]) -> None:
        """Prepares the pager. unusable: called if it cannot be started."""
        self._unusable = unusable
        self._process: subprocess.Popen[bytes] | None = None
        self._kept: dict[int, int] = {}
        self._columns: str | None = None

    def __enter__(self) -> Self:
        """Lets standard output start the pager."""
        Output.pager = self
        return self

    def __exit__(self, *_: object) -> None:
        """Restores the terminal, and waits until the user closes the pager."""
        Output.pager = None
        if self._process is None:
            return
        for stream, kept in self._kept.items():
            os.dup2(kept, stream)
            os.close(kept)
        if self._columns is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = self._columns
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is the pager's, which has the terminal
        try:
            self._process.wait()
        finally:
            if self._process.poll() is None:
                self._process.terminate()
            signal.signal(signal.SIGINT, before)

    def begin(self) -> None:
        """Starts the pager, if one is configured and the terminal can show it."""
        import shutil
        import subprocess

        Output.pager = None
        line = pager_line()
        if not line or os.environ.get("TERM", "dumb") == "dumb":
            return
        wide = str(shutil.get_terminal_size().columns)
        environment = {"LESS": _OPTIONS} | os.environ
        if (sys.stdout.encoding or "").lower().replace("_", "-") in ("utf-8", "utf8"):
            environment = {"LESSCHARSET": "utf-8"} | environment
        try:
            self._process = subprocess.Popen(line, stdin=subprocess.PIPE, env=environment)
        except OSError as error:
            self._unusable(line[0], error)
            return
        assert self._process.stdin is not None
        pipe = self._process.stdin
        for stream in _STREAMS:
            if os.isatty(stream):
                self._kept[stream] = os.dup(stream)
                os.dup2(pipe.fileno(), stream, inheritable=False)
        pipe.close()
        # Layouts still use the terminal's width, although standard output is a pipe now.
        self._columns = os.environ.get("COLUMNS")
        os.environ["COLUMNS"] = wide


class Listing(Command):
    """A command whose text is shown in a pager on a terminal, if it has an end."""

    def invoke(self, ctx: click.Context) -> Any:
        """Runs it."""
        if not _is_paged(ctx):
            return super().invoke(ctx)

        def unusable(name: str, error: OSError) -> None:
            complain(f"canalyze: {self._words('output.no_pager', name=name, error=error.strerror)}")

        with Pager(unusable):
            return super().invoke(ctx)


def simple_command(
    name: str, run: Callable[..., int], *rows: Parameter, paged: bool = False
) -> Callable[[Words], click.Command]:
    """Returns how a command is made in one language; `run` gets the words, then the parameters by their names."""
    kind = Listing if paged else Command
    return lambda words: kind(name, words, partial(run, words), rows)


def _is_paged(ctx: click.Context) -> bool:
    """Returns true on a terminal, unless an option says no or the input comes while it is shown."""
    config = ctx.find_object(Config) or Config()
    if not config.pager or terminal_encoding() is None or sys.stdin is None or not sys.stdin.isatty():
        return False
    return not any(name == "-" or _is_stream(name) for name in ctx.params.get("files") or ())


def _is_stream(name: str) -> bool:
    """Returns true for a pipe or a device."""
    try:
        mode = os.stat(name).st_mode  # noqa: PTH116 - as in `sources.file`
    except (OSError, ValueError):
        return False
    return not stat.S_ISREG(mode) and not stat.S_ISDIR(mode)


def page(
    command: click.Command, ctx: click.Context, words: Words, topics: Mapping[str, Sequence[str]] | None = None
) -> str:
    """Lays out the help of a command; its words are found by its name. topics: its commands, where it is a group."""
    import shutil

    name = _key(command.name or "")
    columns = max(40, min(shutil.get_terminal_size().columns, 100))
    lines = [words("heading.usage") + f"{ctx.command_path} {words(f'{name}.usage')}", ""]
    for paragraph in words(f"{name}.help").splitlines():
        lines += [" " * _MARGIN + line for line in wrap(paragraph, columns - _MARGIN)]
    sections = [
        (words(f"heading.{topic}"), [(other, words(f"{other}.short")) for other in names])
        for topic, names in (topics or {}).items()
    ]
    left = max((width(name) for _, rows in sections for name, _ in rows), default=0)
    for heading, rows in sections:
        lines += ["", heading, *definitions(rows, left=left, columns=columns)]
    shown = [one for one in command.params if isinstance(one, HelpOption) and not one.hidden]
    sections = [
        (words(f"heading.{topic}"), [_record(option, ctx) for option in options])
        for topic, options in _grouped(shown).items()
    ]
    left = min(max(width(name) for _, rows in sections for name, _ in rows), _TERM)
    for heading, rows in sections:
        lines += ["", heading, *definitions(rows, left=left, columns=columns)]
    lines += ["", words("heading.examples"), *_verbatim(words(f"{name}.examples"))]
    if isinstance(command, click.Group):
        lines += ["", words("heading.completion"), *_verbatim(words(f"{name}.completion"))]
    return "\n".join(lines)


def screen(command: click.Command, words: Words, topics: Mapping[str, Sequence[str]]) -> str:
    """Returns what a group prints without a command: usual command lines, its commands by name, and how to get help."""
    import shutil

    name = command.name or ""
    columns = max(40, min(shutil.get_terminal_size().columns, 100))
    lines = [f"{words('heading.usage')}{name} {words(f'{name}.usage')}", ""]
    lines += [" " * _MARGIN + line for line in wrap(words(f"{name}.first"), columns - _MARGIN)]
    lines += ["", *_verbatim(words(f"{name}.usual")), ""]
    rows = [(words(f"heading.{topic}"), "  ".join(names)) for topic, names in topics.items()]
    lines += [*definitions(rows, columns=columns, margin=_MARGIN), "", *_verbatim(words(f"{name}.more"))]
    return "\n".join(lines)


def _key(name: str) -> str:
    """Returns what the keys of a command's words begin with."""
    return name.replace(" ", "_")


def _grouped(options: list[HelpOption]) -> dict[str, list[HelpOption]]:
    """Returns the options under the headings that help shows, in their order."""
    if len(options) <= _FEW:
        return {"options": options}
    usual = sorted((one for one in options if one.usual is not None), key=lambda one: one.usual or 0)[:_USUAL]
    found: dict[str, list[HelpOption]] = {topic: [] for topic in _TOPICS} | {"usual": usual}
    for option in options:
        if option not in usual:
            found[option.topic].append(option)
    return {topic: chosen for topic, chosen in found.items() if chosen}


def _record(option: click.Option, ctx: click.Context) -> tuple[str, str]:
    names = ", ".join(sorted(option.opts, key=len))
    if not option.is_flag:
        names += f" {option.make_metavar(ctx)}"
    return names, option.help or ""


def _verbatim(text: str) -> list[str]:
    return [(" " * _MARGIN + line).rstrip() for line in text.splitlines()]


def usage_line(error: click.UsageError, words: Words) -> str:
    """Returns a usage error as one line: what is wrong, and where help is."""
    command = error.ctx.command_path if error.ctx else "canalyze"
    key = "usage.core_line" if isinstance(error, CoreUsageError) else "usage.line"
    return words(key, command=command, problem=_problem(error, words))


def _near(error: click.NoSuchOption) -> list[str]:
    """Returns the options that may have been meant: those that begin so, or are spelt alike without their dashes."""
    from difflib import get_close_matches

    typed = error.option_name.lstrip("-").lower()
    known = (
        [name for param in error.ctx.command.params if not getattr(param, "hidden", False) for name in param.opts]
        if error.ctx
        else []
    )
    names = {name.lstrip("-").lower(): name for name in known if name.startswith("--")}
    begun = [names[name] for name in names if len(typed) > 1 and name.startswith(typed)]
    return begun or [names[name] for name in get_close_matches(typed, names, cutoff=0.7)]


def _problem(error: click.UsageError, words: Words) -> str:
    if isinstance(error, click.NoSuchOption):
        if near := _near(error):
            return words("usage.no_option_near", option=error.option_name, near=words("usage.or").join(near))
        return words("usage.no_option", option=error.option_name)
    if isinstance(error, click.BadOptionUsage):
        option = error.ctx and next((p for p in error.ctx.command.params if error.option_name in p.opts), None)
        flag = isinstance(option, click.Option) and option.is_flag
        return words("usage.takes_no_value" if flag else "usage.needs_value", option=error.option_name)
    if isinstance(error, click.MissingParameter) and error.param is not None:
        return words("usage.missing", what=error.param.make_metavar(error.ctx or click.Context(click.Command(None))))
    return error.format_message().rstrip(".")
