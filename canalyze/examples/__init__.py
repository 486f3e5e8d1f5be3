"""Five small captures, one scenario each, as files in candump's log form; and the files of the pages.

The files of the pages for users are in `demo/`, under their names in the checkout. Must not: write a file, or know the
program's output.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

FOLDER: Final = Path(__file__).parent
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
