"""A capture as files of columns: Parquet, Arrow's file format, CSV; the core's tables in the layout of a data lake.

    core --batches--> export.Export --> shaping (columns, names, units) --> writing (one growing file each)

What is exported where stands here, and needs nothing but Python; `export`, `shaping` and `writing` need pyarrow (the
extra `parquet`) and are imported once something is written. No Python object a row on the way. Must not: read a
capture, or know what a frame means.
"""

from pathlib import Path
from typing import Final, NamedTuple

from canalyze.errors import CanalyzeError

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
"""The tables that may be asked for, and the core's tables that they are made of."""
FORMS: Final = {".parquet": "parquet", ".arrow": "arrow", ".csv": "csv"}
"""What a file is, by the end of its name."""
FOLDER: Final = "folder"
"""A folder, with a file of Parquet for each table and message."""
FIRST: Final = "frames"
"""The table that a single file holds unless another is asked for."""


class Target(NamedTuple):
    """Where a capture is exported to."""

    path: Path
    form: str
    """FOLDER, or one of FORMS: a single file."""
    tables: tuple[str, ...]
    """Some of TABLES; of a single file exactly one, which is not `signals`: that is a table for each message."""

    @property
    def core(self) -> list[str]:
        """The tables that a session has to build."""
        return [TABLES[name] for name in self.tables]


def form_of(name: str) -> str | None:
    """Say by its name what an output is; None where its suffix is that of nothing that can be written."""
    path = Path(name)
    suffix = path.suffix.lower()
    if suffix in FORMS and not path.is_dir():
        return FORMS[suffix]
    return FOLDER if not suffix or path.is_dir() or name.endswith(("/", "\\")) else None


def require() -> None:
    """Make sure that pyarrow is there; CanalyzeError that names the extra where it is not."""
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError as error:
        raise CanalyzeError("library.extra", name="pyarrow", line="pip install 'canalyze[parquet]'") from error
