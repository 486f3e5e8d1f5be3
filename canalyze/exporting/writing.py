"""One growing file of an export: rows are written in groups of bounded size to a part, until the export is complete.

If a new column appears, a further piece begins; pieces are joined at the end, one group at a time. Must not: know
the content of a table.
"""

import os
from pathlib import Path
from typing import Any, Final

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

from canalyze.exporting.shaping import joined, plain, texts
from canalyze.output.writing import Part

ROWS: Final = 1 << 17
"""Rows of a group, at most one batch more."""
_LEVEL: Final = 3
_STEADY: Final = frozenset({"t", "t_ns", "frame", "line"})
"""Columns whose numbers mostly grow, so that their differences are small."""


class File:
    """A growing file."""

    def __init__(self, beside: Path, form: str, *, replace: bool) -> None:
        """Prepares the file. beside: the part is created in its folder. form: parquet, arrow or csv."""
        self.rows = 0
        self._fields: dict[str, pa.Field] = {}
        self._schema: Any = None
        self._beside = beside
        self._form = form
        self._replace = replace
        self._waiting: list[pa.RecordBatch] = []
        self._pieces: list[Part] = []
        self._writer: Any = None
        self._written: Any = None
        """The columns of the current piece."""

    @property
    def waiting(self) -> int:
        """Bytes of rows that wait to be written."""
        return sum(batch.nbytes for batch in self._waiting)

    def take(self, batch: pa.RecordBatch) -> None:
        """Appends rows, which may have new columns."""
        batch = texts(batch) if self._form == "csv" else plain(batch) if self._form == "arrow" else batch
        for field in batch.schema:
            self._know(field)
        self.rows += len(batch)
        self._waiting.append(batch)
        if sum(map(len, self._waiting)) >= ROWS:
            self.flush()

    def _know(self, field: pa.Field) -> None:
        known = self._fields.get(field.name)
        if known is None or not known.equals(field):
            both = [pa.schema([one]) for one in (known, field) if one is not None]
            self._fields[field.name] = pa.unify_schemas(both, promote_options="permissive").field(0)
            self._schema = None

    @property
    def schema(self) -> Any:
        """The columns of all rows so far; None before the first."""
        if self._schema is None and self._fields:
            self._schema = pa.schema(list(self._fields.values()))
        return self._schema

    def flush(self) -> None:
        """Writes the waiting rows as one group."""
        if self._writer is None or self._written != self.schema:
            self.close()
            self._pieces.append(part := Part(self._beside, replace=self._replace))
            os.close(part.fd)
            self._writer, self._written = self._open(part.path, self.schema), self.schema
        table = joined(self._waiting, self._written)
        self._waiting = []
        if len(table):  # a file without rows has its columns, and no group
            self._writer.write_table(table, len(table))

    def close(self) -> None:
        """Ends the current piece."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None

    def finish(self) -> int:
        """Writes the rest and joins the pieces; returns the size of the file in bytes."""
        if self._waiting:
            self.flush()
        self.close()
        if len(self._pieces) > 1:
            pieces, self._pieces = self._pieces, []
            try:
                for piece in pieces:
                    for batch in pq.ParquetFile(piece.path).iter_batches(ROWS):
                        self._waiting = [batch]
                        self.flush()
            finally:
                for piece in pieces:
                    piece.discard()
            self.close()
        return self.path.stat().st_size

    @property
    def path(self) -> Path:
        """The path of the finished part."""
        return self._pieces[0].path

    def complete(self, final: Path) -> None:
        """Renames the part to the file. Raises FileExistsError if that exists and is not to be replaced."""
        self._pieces[0].complete(final)

    def discard(self) -> None:
        """Removes the file."""
        self.close()
        for piece in self._pieces:
            piece.discard()

    def _open(self, path: Path, schema: pa.Schema) -> Any:
        if self._form == "csv":
            return pyarrow.csv.CSVWriter(path, schema)
        if self._form == "arrow":
            return pa.ipc.new_file(str(path), schema, options=pa.ipc.IpcWriteOptions(compression="zstd"))
        steady = {name for name in schema.names if name in _STEADY}
        return pq.ParquetWriter(
            path,
            schema,
            compression="zstd",
            compression_level=_LEVEL,
            use_dictionary=[name for name in schema.names if name not in steady],
            column_encoding=dict.fromkeys(steady, "DELTA_BINARY_PACKED"),
        )
