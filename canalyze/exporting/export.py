"""Writes a capture to files of columns: one `Export` per capture.

    with Export(target, About(capture="night-17"), force=True) as made:
        for result in Reading(session, ...).over(names):   # or the `take` of a Run
            made.take(session, result)
        made.take(session)
        written = made.complete()

`session` has SETTINGS and the target's tables (`target.core`). Files are parts until `complete` renames them,
`captures` last; without `complete` they are removed. In a folder a file is

    TABLE/date=2026-11-20/device=DEVICE/CAPTURE.parquet          signals/message=TPDO1_drive/date=.../...

Each grows in groups of rows of bounded size. If a new column appears, a further piece begins; pieces are joined at the
end, one group at a time. Must not: read a capture, print, or choose the names of columns.
"""

import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from decimal import Decimal
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self
from urllib.parse import quote

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

from canalyze import __version__
from canalyze.errors import OutputError
from canalyze.exporting import FOLDER, TABLES, Target
from canalyze.exporting.shaping import RAW, Message, Of, fixed, identifier, joined, kind_of, plain, said_of, texts, wide
from canalyze.library.columns import columns
from canalyze.output.files import Part
from canalyze.records import records
from canalyze.records.summary import Bus, Capture, Node
from canalyze.values import DATES_NS

if TYPE_CHECKING:
    from canalyze._core import Session

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
        self.waiting = 0
        """Bytes of rows that wait to be written."""
        self._fields: dict[str, pa.Field] = {}
        self._schema: Any = None
        self._beside = beside
        self._form = form
        self._replace = replace
        self._waiting: list[pa.RecordBatch] = []
        self._rows = 0
        """Number of rows that wait to be written."""
        self._pieces: list[Part] = []
        self._writer: Any = None
        self._written: Any = None
        """The columns of the current piece."""

    @property
    def is_open(self) -> bool:
        """True if a piece is being written."""
        return self._writer is not None

    def take(self, batch: pa.RecordBatch) -> None:
        """Appends rows, which may have new columns."""
        batch = texts(batch) if self._form == "csv" else plain(batch) if self._form == "arrow" else batch
        for field in batch.schema:
            self._know(field)
        self.rows += len(batch)
        self._rows += len(batch)
        self.waiting += batch.nbytes
        self._waiting.append(batch)
        if self._rows >= ROWS:
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
        self._waiting, self._rows, self.waiting = [], 0, 0
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


SETTINGS: Final = {"format": "summary"}
"""Settings of the session beside its tables."""
_WAITING: Final = 64 << 20
"""Maximum bytes of rows of all files that wait to be written."""
_OPEN: Final = 100
"""Maximum number of open files, which take memory and descriptors."""
_NONE: Final = "__HIVE_DEFAULT_PARTITION__"
"""The name of a Hive partition folder for null."""
_SUFFIX: Final = ".parquet"
_EPOCH: Final = datetime(1970, 1, 1, tzinfo=UTC)
_NAMES: Final = {table: name for name, table in TABLES.items()}


class About(NamedTuple):
    """The properties of a capture that are known before it is read."""

    capture: str
    """Its name among others: that of its files, and the value of the column `capture`."""
    device: str = ""
    """The place of the recording; "" if unknown."""
    files: tuple[str, ...] = ()
    """The files that are read."""
    described: Mapping[tuple[str | None, int], str] = {}
    """The names of device descriptions, by bus (None: all) and node; messages are named after them."""


class Written(NamedTuple):
    """The result of an export."""

    files: tuple[Path, ...]
    rows: Mapping[str, int]
    """By table."""
    size: int
    """Bytes of all files."""


class Export:
    """The files of one capture; a context manager. All methods raise OutputError if something cannot be written."""

    def __init__(self, target: Target, about: About, *, force: bool = False) -> None:
        """Checks for existing files. force: files of the same capture are replaced."""
        self._target = target
        self._about = about
        self._force = force
        self._folder = target.path if target.form == FOLDER else target.path.parent
        self._made = False
        self._of = Of(about.capture, exact=target.form not in (FOLDER, "parquet"))
        self._files: dict[str, File] = {}
        """By table, a wide one as signals/MESSAGE; in the order of the last write."""
        self._messages: dict[str, Message] = {}
        self.left_out: Counter[str] = Counter()
        """Number of PDOs of each message whose signals are left out, since it would have too many columns."""
        self._catalog: dict[tuple[str, ...], dict[str, Any]] = {}
        self._findings = dict.fromkeys(("error", "warning", "info"), 0)
        self._summary: list[Capture | Bus | Node] = []
        if not force and (there := self._earlier()):
            raise OutputError("output.exists", name=str(there[0]))

    def __enter__(self) -> Self:
        """Creates the folder, if the target is one."""
        if self._target.form == FOLDER and not self._folder.is_dir():
            with _said(self._folder):
                self._folder.mkdir(parents=True)
                self._made = True
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Removes incomplete files."""
        for file in self._files.values():
            with suppress(OSError, pa.ArrowException):
                file.discard()
        if self._made:
            with suppress(OSError):  # it is not empty
                self._folder.rmdir()

    def take(self, session: "Session", result: bytes = b"") -> None:
        """Appends the complete batches, and the session's result: lines of its summary."""
        self._summary += records(result, Capture, Bus, Node)
        self._of = self._of._replace(date_ns=session.date_ns or 0)
        with _said(self._target.path):
            for name, batch in session.batches():
                self._take(name, pa.record_batch(batch))
            if sum(file.waiting for file in self._files.values()) > _WAITING:
                max(self._files.values(), key=lambda file: file.waiting).flush()
            for file in [file for file in self._files.values() if file.is_open][:-_OPEN]:
                file.close()

    def complete(self, bring: Callable[[Path, str], None] | None = None) -> Written:
        """Writes the rest and renames all files; an existing file raises OutputError.

        bring: moves each file to its name in a folder elsewhere, where no valid files of the capture exist yet.
        """
        capture = next((one for one in self._summary if isinstance(one, Capture)), None)
        day = self._moment(capture.first_t if capture else None)
        if self._target.form == FOLDER:
            own = {"captures": lambda: [self._capture(capture)], "catalog": self._columns}
            for name, listed in own.items():
                made = fixed(pa.RecordBatch.from_pylist(listed(), _SCHEMAS[name]), {"seconds": "s"}, self._of)
                self._remember(name, "", made.schema)
                self._file(name).take(made)
            self._files["captures"] = self._files.pop("captures")  # it says that the others are complete
        with _said(self._target.path):
            size = sum(file.finish() for file in self._files.values())
            rows = {name: file.rows for name, file in self._files.items()}
            written = []
            for name, file in self._files.items():
                final = (
                    self._place(name, day.date().isoformat() if day else None)
                    if self._target.form == FOLDER
                    else self._target.path
                )
                if bring:
                    bring(file.path, final.relative_to(self._folder).as_posix())
                else:
                    final.parent.mkdir(parents=True, exist_ok=True)
                    file.complete(final)
                written.append(final)
            self._files = {}
            for stale in set(self._earlier()) - set(written):
                stale.unlink()
        return Written(tuple(written), rows, size)

    def _take(self, name: str, batch: pa.RecordBatch) -> None:
        about = self._about
        if name == "findings":
            for counted in batch.column("severity").value_counts().to_pylist():
                self._findings[counted["values"]] += counted["counts"]
        if "/" not in name:
            table = _NAMES[name]
            units = {column.name: column.unit for column in columns(name)}
            made = fixed(batch, units, self._of)
            self._remember(table, "", made.schema)
            self._file(table).take(made)
            return
        said = said_of(batch.schema)
        described = about.described
        file = described.get((said["bus"], int(said["node"])), described.get((None, int(said["node"])), ""))
        message = "_".join(filter(None, (said["pdo"], identifier(Path(file).stem))))
        names = self._messages.setdefault(message, Message()).names(name, batch.schema)
        if names is None:
            self.left_out[message] += len(batch)
            return
        made = wide(batch, names, self._of)
        self._remember("signals", message, made.schema, set(names.values()))
        for signal, column in names.items():
            self._signal(message, column, batch.schema.field(signal), said, (file, signal))
        self._file(f"signals/{message}").take(made)

    def _file(self, table: str) -> File:
        """Returns the file of a table, and makes it the last written one."""
        file = self._files.pop(table, None)
        if file is None:
            form = self._target.form
            beside = self._folder / table.replace("/", "-") if form == FOLDER else self._target.path
            file = File(beside, "parquet" if form == FOLDER else form, replace=self._force)
        self._files[table] = file
        return file

    def _remember(self, table: str, message: str, schema: pa.Schema, but: Set[str] = frozenset()) -> None:
        """Adds the fixed columns of a table to the catalog."""
        for field in schema:
            if field.name not in but:
                row = {"table_name": table, "message": message or None, "column_name": field.name}
                self._catalog.setdefault((table, message, field.name), row | {"unit": said_of(field).get("unit")})

    def _signal(self, message: str, column: str, field: pa.Field, said: dict[str, str], named: tuple[str, str]) -> None:
        """Adds a signal of one mapping of one PDO to the catalog."""
        key = ("signals", message, column, said["bus"], said["node"], said["pdo"], said["version"])
        if key in self._catalog:
            return
        file, signal = named
        of, raw = said_of(field), signal.endswith(RAW)
        self._catalog[key] = {
            "table_name": "signals",
            "message": message,
            "column_name": column,
            "unit": None if raw else of.get("unit"),
            "name": signal.removesuffix(RAW),
            "bus": said["bus"] or None,
            "node": int(said["node"]),
            "pdo": said["pdo"],
            "mapping": int(said["version"]),
            "index": int(of["index"]),
            "sub": int(of["sub"]),
            "data_type": of.get("type"),
            "bits": int(of["bits"]),
            "bit_offset": int(of["offset"]),
            "factor": float(of["factor"]),
            "description": file or None,
        }

    def _columns(self) -> list[dict[str, Any]]:
        """Returns the rows of the catalog, with the final types of the columns."""
        schemas = {name: file.schema for name, file in self._files.items()}
        tables = (
            schemas["/".join(filter(None, (row["table_name"], row["message"])))] for row in self._catalog.values()
        )
        return [
            row | {"type": kind_of(schema.field(row["column_name"]).type)}
            for row, schema in zip(self._catalog.values(), tables, strict=True)
        ]

    def _capture(self, said: Capture | None) -> dict[str, Any]:
        """Returns the row of the capture."""
        counted = "findings" in self._target.tables
        return {
            "t": self._moment(said.first_t if said else None),
            "end_t": self._moment(said.last_t if said else None),
            "seconds": float(said.seconds) if said and said.seconds is not None else None,
            "frames": said.frames if said else 0,
            "buses": [one.bus for one in self._summary if isinstance(one, Bus) and one.bus],
            "nodes": sorted({one.node for one in self._summary if isinstance(one, Node)}),
            **{f"{severity}s": count if counted else None for severity, count in self._findings.items()},
            "files": [os.fsencode(name).decode("utf-8", "replace") for name in self._about.files],
            "version": __version__,
        }

    def _moment(self, t: str | None) -> datetime | None:
        """Returns a time of the summary; None without a known date."""
        t_ns = None if t is None else int(Decimal(t) * 10**9)
        if t_ns is not None and t_ns < DATES_NS:
            t_ns = t_ns + self._of.date_ns if self._of.date_ns else None
        return None if t_ns is None else _EPOCH + timedelta(microseconds=t_ns // 1000)

    def _place(self, table: str, date: str | None) -> Path:
        """Returns the path of a table of this capture."""
        about = self._about
        name, _, message = table.partition("/")
        folder = self._folder / name / f"message={message}" if message else self._folder / name
        return folder / f"date={date or _NONE}" / self._device / f"{about.capture}{_SUFFIX}"

    def _earlier(self) -> list[Path]:
        """Returns the existing files of this capture."""
        if self._target.form != FOLDER:
            return [self._target.path] if os.path.lexists(self._target.path) else []
        found: list[Path] = []
        for table in ("*", "signals/message=*"):
            for day in self._folder.glob(f"{table}/date=*"):
                path = day / self._device / f"{self._about.capture}{_SUFFIX}"
                found += [path] if os.path.lexists(path) else []
        return found

    @property
    def _device(self) -> str:
        return f"device={quote(self._about.device, safe=' ') or _NONE}"


@contextmanager
def _said(path: Path) -> Iterator[None]:
    """Converts exceptions of an output to OutputError."""
    try:
        yield
    except FileExistsError as error:
        raise OutputError("output.exists", name=error.filename or str(path)) from error
    except OSError as error:
        raise OutputError("output.write", name=str(path), error=error) from error


def _schema(text: str) -> pa.Schema:
    """Returns the schema of name:type pairs; all but the first may be null."""
    kinds = {"word": pa.dictionary(pa.int32(), pa.string()), "time": pa.timestamp("us", "UTC")}
    kinds |= {"real": pa.float64(), "words": pa.list_(pa.string()), "numbers": pa.list_(pa.int16())}
    pairs = (one.split(":") for one in text.split())
    return pa.schema([pa.field(name, kinds.get(kind) or getattr(pa, kind)()) for name, kind in pairs])


_SCHEMAS: Final = {
    "catalog": _schema(
        "table_name:string message:string column_name:string type:string unit:string name:string bus:string node:int16"
        " pdo:string mapping:int16 index:int32 sub:int16 data_type:string bits:int16 bit_offset:int16 factor:real"
        " description:string"
    ),
    "captures": _schema(
        "t:time end_t:time seconds:real frames:int64 buses:words nodes:numbers errors:int64 warnings:int64"
        " infos:int64 files:words version:string"
    ),
}
"""The tables that only an export has."""
