"""`canalyze examples`: five small captures to try the program on, and what to type; also all files of the pages."""

from pathlib import Path

from canalyze.configuration.options import ANY_PATH, FORCE, argument, option
from canalyze.errors import OutputError, as_error
from canalyze.output import FileOutput, Output
from canalyze.output.help import simple_command
from canalyze.reports import wording
from canalyze.words import Words


def run(words: Words, *, directory: str | None, pages: bool, force: bool) -> int:
    """Writes the captures, and says what to type."""
    from canalyze.examples import EXAMPLES, FOLDER, of_pages

    folder = Path(directory or ".")
    out = Output()
    for name in EXAMPLES:
        path = _write(folder / name, (FOLDER / name).read_bytes(), force=force)
        out.text(f"{wording.capture_name(path)}  {words.of('example', name.removesuffix('.log'))}\n")
    if pages:
        files = of_pages()
        for name, data in files.items():
            _write(folder / name, data, force=force)
        out.text(words("examples.of_pages", count=len(files)) + "\n")
    first = wording.capture_name(str(folder / EXAMPLES[0]))
    out.text(words("examples.next", file=first) + "\n")
    return 0


def _write(path: Path, data: bytes, *, force: bool) -> str:
    """Writes a file and the folder that it is in; returns its name."""
    with as_error(OutputError, "output.write", name=path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
    with FileOutput(str(path), force=force) as file:
        file.write(data)
    return str(path)


command = simple_command(
    "examples", run, argument("directory", "DIR", required=False, type=ANY_PATH), option("--pages"), FORCE
)
