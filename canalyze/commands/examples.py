"""`canalyze examples`: five small captures to try the program on, and what to type; also all files of the pages.

A capture has one scenario, in candump's log form. The files of the pages for users are in `demo/`, under their names in
the checkout.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from canalyze.configuration.options import ANY_PATH, FORCE, argument, option
from canalyze.errors import OutputError, as_error
from canalyze.output import FileOutput, Output
from canalyze.output.help import simple_command
from canalyze.reports import wording
from canalyze.words import Words

FOLDER: Final = Path(__file__).parents[1] / "examples"
EXAMPLES: Final = ("node-lost.log", "node-restarted.log", "mapping-refused.log", "drive-fault.log", "all-well.log")
"""The captures, in the order in which they are listed."""

DEMO: Final = FOLDER.with_name("demo")
_NAMES: Final[Mapping[str, str]] = {
    "capture.log": "samples/network/sync-and-pdos.log",
    "boot.log": "samples/network/sync-and-pdos.log",
    "machine1.log": "samples/network/sync-and-pdos.log",
    "machine2.log": "samples/network/remapping.log",
    "other-firmware.log": "samples/od/other-firmware.log",
    "good.log": "samples/network/drive-states.log",
    "captures/good.log": "samples/network/sync-and-pdos.log",
    "captures/zephyr.log": "samples/zephyr-sdo.log",
    "captures/late.log": "samples/rules/HBT001.log",
    "part1.log": "samples/rules/HBT001.log",
    "part2.log": "samples/rules/HBT001.clean.log",
    "drive.eds": "eds/drive.eds",
    "encoder.eds": "eds/encoder.eds",
    "io.eds": "eds/io.eds",
}
"""Names used on pages, and the files that they stand for."""


def of_pages() -> dict[str, bytes]:
    """Returns the files that the examples on the pages need in addition to the five captures, by their names."""
    files = {path.relative_to(DEMO).as_posix(): path.read_bytes() for path in sorted(DEMO.rglob("*")) if path.is_file()}
    return {name: files[source] for name, source in _NAMES.items()} | files


def run(words: Words, *, directory: str | None, pages: bool, force: bool) -> int:
    """Writes the captures, and says what to type."""
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
