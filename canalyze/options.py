"""Options that several commands have, and what becomes of them.

Descriptions stand in `words.py`. An option of one command only stands in that command's file.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from canalyze.words import LANGUAGES, Words

if TYPE_CHECKING:
    from canalyze._core import Session


class OneOf(click.Choice[str]):
    """A choice whose error is in the words of the run."""

    def __init__(self, values: Sequence[str], words: Words) -> None:
        """Take the values in the order in which help shows them."""
        super().__init__(list(values))
        self._words = words

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """Give the values, as help shows them."""
        return "|".join(self.choices)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Give the value if it is one of ours."""
        if value in self.choices:
            return str(value)
        option = param.opts[-1] if param else ""
        choices = ", ".join(self.choices)
        raise click.UsageError(self._words("usage.choice", option=option, value=value or '""', choices=choices), ctx)


def common_options(words: Words) -> list[click.Parameter]:
    """Give the options that every command has. Language and configuration are settled before click sees them."""
    return [
        click.Option(["--lang"], type=OneOf(LANGUAGES, words), expose_value=False, help=words("opt.lang")),
        click.Option(["--config"], type=click.Path(), metavar="FILE", expose_value=False, help=words("opt.config")),
        click.Option(
            ["-h", "--help"],
            is_flag=True,
            is_eager=True,
            expose_value=False,
            callback=_show_help,
            help=words("opt.help"),
        ),
    ]


def _show_help(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from canalyze.output import Output

        Output().text(ctx.get_help() + "\n")
        ctx.exit()


def capture_options(words: Words) -> list[click.Parameter]:
    """Give what every command that reads captures has."""
    return [
        click.Argument(["files"], nargs=-1, type=click.Path(allow_dash=True), metavar="FILE"),
        click.Option(["--filter", "expression"], metavar="EXPR", help=words("opt.filter")),
        click.Option(
            ["--stamps"],
            type=OneOf(("auto", "absolute", "zero", "delta"), words),
            default="auto",
            help=words("opt.stamps"),
        ),
        *output_options(words),
    ]


def output_options(words: Words) -> list[click.Parameter]:
    """Give what every command that may write a file has."""
    return [
        click.Option(["-o", "--output"], type=click.Path(allow_dash=True), metavar="FILE", help=words("opt.output")),
        click.Option(["--force"], is_flag=True, help=words("opt.force")),
    ]


def format_option(words: Words, command: str) -> click.Option:
    """Give --format text|jsonl with the command's own description."""
    return click.Option(
        ["--format", "form"], type=OneOf(("text", "jsonl"), words), default="text", help=words(f"{command}.format")
    )


class CoreUsageError(click.UsageError):
    """What the core cannot accept, in its own words."""


def open_session(words: Words, **settings: Any) -> "Session":
    """Start the core with these settings; what it cannot accept (a filter) is a usage error."""
    from canalyze._core import Session

    try:
        return Session(lang=words.lang, **settings)
    except ValueError as error:
        raise CoreUsageError(str(error), click.get_current_context()) from error


def inputs(files: tuple[str, ...], words: Words) -> tuple[str, ...]:
    """Give the inputs: those named, else standard input if it is a pipe or a file; none is a usage error."""
    from canalyze.run import piped
    from canalyze.sources.file import STDIN

    if files:
        return files
    if piped():
        return (STDIN,)
    raise click.UsageError(words("usage.no_input"), click.get_current_context())
