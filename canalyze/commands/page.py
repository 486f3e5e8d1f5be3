"""`canalyze page`: the program as one HTML file, empty or with captures inside."""

from pathlib import Path

import click

from canalyze.configuration.options import ANY_PATH
from canalyze.errors import SourceError
from canalyze.output import FileOutput, Output
from canalyze.output.help import Command
from canalyze.reports import wording
from canalyze.words import Words


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(files: tuple[str, ...], output: str | None, force: bool) -> int:
        from canalyze import html

        if output is None:
            raise click.UsageError(words("page.needs_output"), click.get_current_context())
        made = html.page(words.lang, {}, [(Path(name).name, _read(name)) for name in files])
        with FileOutput(output, force=force) as file:
            file.write(made)
        name = wording.capture_name(output)
        Output().text(words("page.written", name=name, megabytes=f"{len(made) / 1e6:.1f}") + "\n")
        return 0

    return Command(
        "page",
        words,
        run,
        [
            click.Argument(["files"], nargs=-1, type=ANY_PATH, metavar="FILE"),
            click.Option(["-o", "--output"], type=ANY_PATH, metavar="FILE", help=words("page.output")),
            click.Option(["--force"], is_flag=True, help=words("opt.force")),
        ],
    )


def _read(name: str) -> bytes:
    try:
        return Path(name).read_bytes()
    except OSError as error:
        raise SourceError("source.open", name=name, error=error) from error
