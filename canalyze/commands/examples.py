"""`canalyze examples`: five small captures to try the program on, and what to type; also all files of the pages."""

from pathlib import Path

import click

from canalyze.configuration.options import ANY_PATH
from canalyze.errors import OutputError
from canalyze.output import FileOutput, Output
from canalyze.output.help import Command
from canalyze.reports import wording
from canalyze.words import Words


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(directory: str | None, pages: bool, force: bool) -> int:
        from canalyze.examples import EXAMPLES, of_pages

        folder = Path(directory or ".")
        out = Output()
        for name, make in EXAMPLES.items():
            path = _write(folder / name, make().encode(), force=force)
            out.text(f"{wording.capture_name(path)}  {words.of('example', name.removesuffix('.log'))}\n")
        if pages:
            files = of_pages()
            for name, data in files.items():
                _write(folder / name, data, force=force)
            out.text(words("examples.of_pages", count=len(files)) + "\n")
        first = wording.capture_name(str(folder / next(iter(EXAMPLES))))
        out.text(words("examples.next", file=first) + "\n")
        return 0

    return Command(
        "examples",
        words,
        run,
        [
            click.Argument(["directory"], required=False, type=ANY_PATH, metavar="DIR"),
            click.Option(["--pages"], is_flag=True, help=words("examples.pages")),
            click.Option(["--force"], is_flag=True, help=words("opt.force")),
        ],
    )


def _write(path: Path, data: bytes, *, force: bool) -> str:
    """Write a file and the folder that it is in; return its name."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError("output.write", name=path.parent, error=error) from error
    with FileOutput(str(path), force=force) as file:
        file.write(data)
    return str(path)
