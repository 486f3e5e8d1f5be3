"""`canalyze examples`: five small captures to try the program on, and what to type."""

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

    def run(directory: str | None, force: bool) -> int:
        from canalyze.examples import EXAMPLES

        folder = Path(directory or ".")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError("output.write", name=folder, error=error) from error
        out = Output()
        for name, make in EXAMPLES.items():
            path = str(folder / name)
            with FileOutput(path, force=force) as file:
                file.write(make().encode())
            out.text(f"{wording.capture_name(path)}  {words.of('example', name.removesuffix('.log'))}\n")
        first = wording.capture_name(str(folder / next(iter(EXAMPLES))))
        out.text(words("examples.next", file=first) + "\n")
        return 0

    return Command(
        "examples",
        words,
        run,
        [
            click.Argument(["directory"], required=False, type=ANY_PATH, metavar="DIR"),
            click.Option(["--force"], is_flag=True, help=words("opt.force")),
        ],
    )
