"""A capture as files of columns (Parquet, Arrow, CSV): the core's tables in the layout of a data lake.

    core --batches--> export.Export --> shaping (columns, names, units) --> writing (one growing file each)

The tables and targets are defined here, without further packages; `export`, `shaping` and `writing` need pyarrow
(the extra `parquet`) and are imported when something is written. No Python object is made per row. Must not: read a
capture, or know the meaning of a frame.
"""

from pathlib import Path
from typing import Final, NamedTuple

from canalyze.errors import CanalyzeError, needed

TABLES: Final = {
    "frames": "frames",
    "signals": "wide",
    "objects": "objects",
    "transfers": "transfers",
    "findings": "findings",
    "problems": "problems",
    "states": "states",
    "emcy": "emcy",
    "sync_cycles": "sync_cycles",
}
"""The tables that can be exported, with the core's tables that they are made from."""
FORMS: Final = {".parquet": "parquet", ".arrow": "arrow", ".csv": "csv"}
"""Formats by the suffix of a file."""
FOLDER: Final = "folder"
"""A folder, with a Parquet file for each table and message."""
FIRST: Final = "frames"
"""The default table of a single file."""


class Target(NamedTuple):
    """The target of an export."""

    path: Path
    form: str
    """FOLDER, or one of FORMS: a single file."""
    tables: tuple[str, ...]
    """Some of TABLES; for a single file exactly one other than `signals`, which is a table per message."""

    @property
    def core(self) -> list[str]:
        """The tables that a session has to build."""
        return [TABLES[name] for name in self.tables]


def form_of(name: str) -> str | None:
    """Returns the format of an output by its name; None for an unknown suffix."""
    path = Path(name)
    suffix = path.suffix.lower()
    if suffix in FORMS and not path.is_dir():
        return FORMS[suffix]
    return FOLDER if not suffix or path.is_dir() or name.endswith(("/", "\\")) else None


def require() -> None:
    """Checks that pyarrow is installed. Raises CanalyzeError with the name of the extra otherwise."""
    with needed(CanalyzeError, "pyarrow", "parquet"):
        import pyarrow.parquet  # noqa: F401
