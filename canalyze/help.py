"""Help pages and usage errors in our words, on top of click.

click's own pages are English and measure text in characters; these speak the language of the run and are laid out by
`layout`. Sentences stand in `words`; nothing here knows a command.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

import click

from canalyze.layout import pad, width, wrap
from canalyze.options import CoreUsageError, common_options
from canalyze.words import Words

_MARGIN: Final = 2


class Command(click.Command):
    """A command whose help is a page in the language of the run."""

    def __init__(self, name: str, words: Words, run: Callable[..., int], params: list[click.Parameter]) -> None:
        """Take the command's words by its name; `run` gives the exit code."""
        super().__init__(
            name,
            callback=run,
            params=[*params, *common_options(words)],
            add_help_option=False,
            short_help=words(f"{name}.short"),
        )
        self._words = words

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse; an error knows then in which command it is."""
        with located(ctx):
            return super().parse_args(ctx, args)

    def get_help(self, ctx: click.Context) -> str:
        """Give the page."""
        return page(self, ctx, self._words)


@contextmanager
def located(ctx: click.Context) -> Iterator[None]:
    """Give a usage error its context, which click's parser leaves out of some."""
    try:
        yield
    except click.UsageError as error:
        error.ctx = error.ctx or ctx
        raise


def page(command: click.Command, ctx: click.Context, words: Words) -> str:
    """Lay out the help of a command; its words are found by its name."""
    import shutil

    name = command.name or ""
    columns = max(40, min(shutil.get_terminal_size().columns, 100))
    lines = [words("help.usage") + f"{ctx.command_path} {words(f'{name}.usage')}", ""]
    lines += [" " * _MARGIN + line for line in wrap(words(f"{name}.help"), columns - _MARGIN)]
    if isinstance(command, click.Group):
        rows = [(other, words(f"{other}.short")) for other in command.list_commands(ctx)]
        lines += ["", words("help.commands"), *_definitions(rows, columns)]
    rows = [_record(option, ctx) for option in command.params if isinstance(option, click.Option)]
    lines += ["", words("help.options"), *_definitions(rows, columns)]
    lines += ["", words("help.examples"), *_verbatim(words(f"{name}.examples"))]
    if isinstance(command, click.Group):
        lines += ["", words("help.completion"), *_verbatim(words(f"{name}.completion"))]
    return "\n".join(lines)


def _record(option: click.Option, ctx: click.Context) -> tuple[str, str]:
    names = ", ".join(sorted(option.opts, key=len))
    if not option.is_flag:
        names += f" {option.make_metavar(ctx)}"
    return names, option.help or ""


def _definitions(rows: list[tuple[str, str]], columns: int) -> list[str]:
    """Lay out terms with their explanations, side by side; a long term stands alone above."""
    left = min(max(width(term) for term, _ in rows), 24)
    indent = " " * (_MARGIN + left + 2)
    lines = []
    for term, text in rows:
        wrapped = wrap(text, columns - len(indent))
        if width(term) > left:
            lines.append(" " * _MARGIN + term)
        else:
            lines.append(" " * _MARGIN + pad(term, left) + "  " + wrapped.pop(0))
        lines += [indent + line for line in wrapped]
    return lines


def _verbatim(text: str) -> list[str]:
    return [(" " * _MARGIN + line).rstrip() for line in text.splitlines()]


def usage_line(error: click.UsageError, words: Words) -> str:
    """Give a usage error as one line: what is wrong, and where help is."""
    command = error.ctx.command_path if error.ctx else "canalyze"
    key = "usage.core_line" if isinstance(error, CoreUsageError) else "usage.line"
    return words(key, command=command, problem=_problem(error, words))


def _near(error: click.NoSuchOption) -> list[str]:
    """Give the options that may have been meant: those that begin so, or are spelt nearly so without their dashes."""
    from difflib import get_close_matches

    typed = error.option_name.lstrip("-").lower()
    known = [name for param in error.ctx.command.params for name in param.opts] if error.ctx else []
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
