"""MF4, CSV and SQLite, read through python-can in batches of records for the core.

Its readers return one message at a time and are not made for damaged files. Rows of CSV are therefore passed one by
one; an exception becomes damage, the frames before it are kept, and what the libraries print, log or warn becomes a
remark. asammdf may crash the process on a damaged file, so that MF4 is read in a child process, which runs `main`.

Opening an SQLite database rolls back an unfinished transaction of another program and writes to the file; here this
happens to a private copy, so that reading cannot change or lock the file. In the copy of a truncated database the
number of pages is corrected, so that the rows of whole pages can still be read: SQLite itself would read none, or take
the missing half of a page for zeros. The work that a file can cause in SQLite is bounded: nothing that the file
computes is read, and a signal ends every query. Must not: decode a format itself beyond that.

| form | channel | direction | stamps |
|---|---|---|---|
| mf4 | its number is the name's | yes | absolute, µs |
| csv, sqlite | `can0` | no | as they are, µs where they are dates |
"""

import io
import marshal
import os
import re
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import tempfile
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import closing, suppress
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from canalyze.errors import CanalyzeError, SourceError, as_error, one_line
from canalyze.sources.bridge import (
    CUT,
    CUT_LINE,
    NO_FRAME,
    REMARKS,
    REST,
    STRUCTURE,
    Heard,
    Packer,
    Unfit,
    damage,
    dialect,
    has_asammdf,
    library,
    unreadable,
)

if TYPE_CHECKING:
    from can import Message

    from canalyze.sources.compressed import Damage, Layer

_HEAD: Final = 100
_JOURNALS: Final = ("-journal", "-wal")
"""Suffixes of the files beside a database that is being written, or whose writer has crashed."""
_LEAST_ROW: Final = 8
"""Minimum size of a row of seven columns, in bytes."""
_LIMITS: Final = (
    (sqlite3.SQLITE_LIMIT_LENGTH, 1 << 16),
    (sqlite3.SQLITE_LIMIT_COLUMN, 100),
    (sqlite3.SQLITE_LIMIT_EXPR_DEPTH, 50),
    (sqlite3.SQLITE_LIMIT_COMPOUND_SELECT, 5),
    (sqlite3.SQLITE_LIMIT_ATTACHED, 0),
    (sqlite3.SQLITE_LIMIT_WORKER_THREADS, 0),
)
"""Limits well above the needs of a table of frames, whose rows have less than 200 bytes."""
_ERRORS: Final = (sqlite3.Error, UnicodeError)
"""Exceptions that SQLite raises for damaged files, also for undecodable text."""
_STEPS: Final = 10_000
"""Steps of SQLite between two checks for signals: less than a millisecond."""


class Copy:
    """A copy of a database, and where it is truncated."""

    def __init__(self, original: Path, directory: Path) -> None:
        """Copies a database to a directory, unless it is there already. Raises OSError if that fails."""
        self.path = original if original.parent == directory else directory / "copy.sqlite"
        if self.path != original:
            shutil.copyfile(original, self.path)
        self.cut: tuple[int, int] | None = None
        """The place of an incomplete page, and the bytes of it that are there; None if the database is whole."""
        if self.path == original or not _journals(original, self.path):
            self.cut = _recounted(self.path)
        self.most_rows = self.path.stat().st_size // _LEAST_ROW
        """Maximum number of rows; more mean that its pages form a circle."""

    def computes(self, table: str) -> bool:
        """Returns true if `table` is a view or has computed columns."""
        try:
            with closing(sqlite3.connect(self.path)) as connection:
                bound(connection)
                kinds = connection.execute(
                    "SELECT type = 'table' AND rootpage > 0 FROM sqlite_master WHERE name = ? COLLATE NOCASE"
                    " AND type IN ('table', 'view')",
                    (table,),
                ).fetchall()
                hidden = connection.execute("SELECT max(hidden) FROM pragma_table_xinfo(?)", (table,)).fetchall()
        except _ERRORS as error:
            heed(error)
            return False  # the reader reports it
        return any(not stored for (stored,) in kinds) or any(most for (most,) in hidden)

    def sound(self) -> bool:
        """Returns true if SQLite's quick check finds no damage."""
        try:
            with closing(sqlite3.connect(self.path)) as connection:
                interruptible(connection)
                connection.execute("PRAGMA ignore_check_constraints = ON")  # they may compute what they like
                return connection.execute("PRAGMA quick_check(1)").fetchall() == [("ok",)]
        except _ERRORS as error:
            heed(error)
            return False


def bound(connection: sqlite3.Connection) -> None:
    """Limits the work that a file can cause on a new connection."""
    for limit, most in _LIMITS:
        connection.setlimit(limit, most)
    interruptible(connection)


def interruptible(connection: sqlite3.Connection) -> None:
    """Makes queries of a connection interruptible by signals; `heed` raises their exceptions."""
    connection.set_progress_handler(lambda: 0, _STEPS)


def heed(error: BaseException) -> None:
    """Raises KeyboardInterrupt if it ended the query, because SQLite swallows exceptions raised in its callbacks."""
    if isinstance(error, sqlite3.Error) and getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_INTERRUPT:
        raise KeyboardInterrupt from None


def _journals(original: Path, database: Path) -> bool:
    """Copies the journals of a database after it, so that changes made meanwhile are rolled back with them."""
    there = False
    for suffix in _JOURNALS:
        beside = original.with_name(original.name + suffix)
        with suppress(FileNotFoundError):
            shutil.copyfile(beside, database.with_name(database.name + suffix))
            there |= beside.stat().st_size > 0
    return there


def _recounted(database: Path) -> tuple[int, int] | None:
    """Reduces a truncated database to its whole pages.

    Returns where it was cut and the number of bytes behind, or None if it is whole.
    """
    with database.open("r+b") as file:
        head = file.read(_HEAD)
        if len(head) < _HEAD:
            return None
        (size,) = struct.unpack_from(">H", head, 16)
        size = 65_536 if size == 1 else size
        if size < 512 or size & (size - 1):
            return None
        whole, rest = divmod(database.stat().st_size, size)
        changes, pages = struct.unpack_from(">II", head, 24)
        (valid_for,) = struct.unpack_from(">I", head, 92)
        counted = pages > 0 and changes == valid_for  # programs before 2010 do not count
        if whole == 0 or (whole >= pages if counted else rest == 0):
            return None
        file.seek(28)
        file.write(struct.pack(">I", whole))
        file.truncate(whole * size)
    return whole * size, rest


RECORDS, REMARK, REFUSED, CRASHED, _END = "records", "remark", "refused", "crashed", "end"
"""Kinds of pieces of an MF4 file."""
_START: Final = """import sys
sys.path[:] = sys.argv[2:]
from canalyze.sources.bridge.reading import main
main(sys.argv[1])
"""
TITLES: Final = {"mf4": "MF4", "csv": "CSV", "sqlite": "SQLite"}
"""The name of a form in a sentence."""
_BYTES: Final = 128 << 10
"""Size of a batch in bytes."""
_TABLE: Final = "messages"
"""The table that python-can writes."""
_COMMAS: Final = 6
"""Number of commas in a row of python-can's table."""
_LONGEST: Final = 64 << 10
"""Maximum length of a row; longer ones are unreadable."""
_CONTROL: Final = re.compile(r"[\0-\x08\x0a-\x1f\x7f]")
"""Control characters that no row contains, as in a block of zeros."""


def from_process(path: Path, scratch: Path) -> Iterator[tuple[str, Any]]:
    """Yields the pieces that a child process reads from an MF4 file; the last one is CRASHED if it does.

    scratch: a directory for the temporary files of the child process.
    """
    # Not in this session: a Ctrl-C is for this process, which ends the other one.
    with subprocess.Popen(
        [sys.executable, "-c", _START, str(path), *sys.path],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"TMPDIR": str(scratch)},
        start_new_session=True,
    ) as process:
        assert process.stdout is not None
        try:
            while (piece := marshal.load(process.stdout))[0] != _END:
                yield piece
        except (EOFError, ValueError, TypeError):
            code = process.wait()
            name = str(code)
            with suppress(ValueError):
                name = signal.Signals(-code).name
            yield CRASHED, f"asammdf: {name}"
        finally:
            process.kill()


def main(path: str) -> None:
    """Writes the pieces of an MF4 file to standard output; the entry point of the child process."""
    out = sys.stdout.buffer
    sys.stdout = sys.stderr  # for what is printed at the end
    for piece in chain(from_this_process(Path(path)), [(_END, "")]):
        marshal.dump(piece, out)
        out.flush()


def from_this_process(path: Path) -> Iterator[tuple[str, Any]]:
    """Yields the same pieces as `from_process`, read in this process."""
    heard = Heard()
    packer = Packer(6, directed=True, bus=lambda channel: f"can{channel}" if isinstance(channel, int) else "can0")
    problem = None
    with heard.everything():
        try:
            can = library(mf4=True)
            yield RECORDS, dialect("reader", f"python-can {can.__version__}")
            with can.MF4Reader(str(path)) as reader:
                for batch in _batched(packer.record(_dated(message), row) for row, message in enumerate(reader, 1)):
                    yield from ((REMARK, line) for line in heard.take())
                    yield RECORDS, batch
        except Exception as error:  # a damaged file may cause any exception in the library
            problem = one_line(error)
    if problem and not packer.frames:
        yield REFUSED, problem
        return
    for line in (*([problem] if problem else ()), *heard.take()):
        yield REMARK, line
    if problem or heard.errors:  # asammdf goes on without what it could not read
        yield RECORDS, damage(REST if problem else STRUCTURE, 0)


def _dated(message: "Message") -> "Message":
    """Returns the message with its stamp in µs: the date was added to it, and more is noise."""
    message.timestamp = round(message.timestamp, 6)
    return message


def _batched(records: Iterable[bytes]) -> Iterator[bytes]:
    """Joins records to batches; records before an error are yielded before it is raised."""
    batch: list[bytes] = []
    size = 0
    stopped: Exception | None = None
    try:
        for record in records:
            batch.append(record)
            size += len(record)
            if size >= _BYTES:
                yield b"".join(batch)
                batch, size = [], 0
    except Exception as error:
        stopped = error
    if size:
        yield b"".join(batch)
    if stopped:
        raise stopped


class Bridged:
    """The content of a file as records, with the interface of `compressed.Layer`."""

    def __init__(self, below: "Layer", name: str, form: str, path: Path | None, *, formats: Sequence[str] = ()) -> None:
        """Creates the layer; `form` is one of TITLES.

        name: that of the file in messages. path: the file itself, unless it is packed or comes through a pipe. formats:
        those to choose from, if the user has given the form. Raises SourceError if a package that the form needs is not
        installed.
        """
        self.begins = False
        self._below = below
        self._name = name
        self._form = form
        self._path = path
        self._formats = formats
        self._remarks: list[CanalyzeError] = []
        self._begun = False
        readers = {"mf4": self._mf4, "csv": self._csv, "sqlite": self._sqlite}
        self._records = readers[form]()
        if form == "mf4" and not has_asammdf():
            raise SourceError("bridge.mf4", name=name, line="pip install 'canalyze[mf4]'")

    @property
    def damage(self) -> "Damage | None":
        """The damage of the layer below."""
        return self._below.damage

    def read(self) -> bytes:
        """Returns the next records, b"" at the end. Raises SourceError if the file cannot be read."""
        batch = next(self._records, b"")
        self.begins, self._begun = not self._begun, True
        return batch

    def remarks(self) -> list[CanalyzeError]:
        """Returns the remarks on the file since the last call, for standard error."""
        remarks, self._remarks = self._remarks, []
        return remarks

    def close(self) -> None:
        """Ends the child process and removes copies."""
        self._records.close()

    def _mf4(self) -> Generator[bytes, None, None]:
        with tempfile.TemporaryDirectory(prefix="canalyze-") as scratch:
            batches = 0
            for kind, piece in from_process(self._path or self._spooled(scratch), Path(scratch)):
                if kind == RECORDS:
                    batches += 1
                    yield piece
                elif kind == REFUSED or (kind == CRASHED and batches < 2):  # the first says whose they are
                    raise self._refused(piece)
                else:
                    self._remark(piece)
                    if kind == CRASHED:
                        yield damage(REST, 0)

    def _sqlite(self) -> Generator[bytes, None, None]:
        yield dialect("reader", f"python-can {library().__version__}")
        with tempfile.TemporaryDirectory(prefix="canalyze-") as scratch:
            with as_error(SourceError, "source.read", name=self._name):
                copy = Copy(self._path or self._spooled(scratch), Path(scratch))
            if copy.computes(_TABLE):
                raise SourceError("bridge.computed", name=self._name, table=_TABLE)
            yield from _batched(self._rows(copy))

    def _rows(self, copy: Copy) -> Iterator[bytes]:
        packer = Packer(6, directed=False, bus=lambda _: "can0")
        problem = None
        try:
            with library().SqliteReader(str(copy.path), _TABLE) as reader:
                bound(reader._conn)
                for row, message in enumerate(reader, 1):
                    if row > copy.most_rows:
                        break
                    yield packer.record(message, row)
        except Exception as error:  # a damaged file may cause any exception in the library
            heed(error)
            problem = one_line(error)
        if problem and not packer.frames:
            raise self._refused(problem)
        if copy.cut:
            if not self.damage:
                yield damage(CUT, *copy.cut)
        elif problem:
            self._remark(problem)
            yield damage(REST, 0)
        elif not copy.sound():
            yield damage(STRUCTURE, 0)

    def _csv(self) -> Generator[bytes, None, None]:
        can = library()
        yield dialect("reader", f"python-can {can.__version__}")
        reader = can.CSVReader(io.StringIO())
        packer = Packer(6, directed=False, bus=lambda _: "can0")

        def record(text: str, number: int, *, cut: bool) -> bytes:
            """Returns the record of a row; one that the library cannot read costs only itself."""
            if number == 1:
                text = text.removeprefix("\xef\xbb\xbf")
            text = text.strip() if len(text) <= _LONGEST else "\0"
            if not text or (text.startswith("timestamp,") and text.count(",") <= _COMMAS):
                return b""
            reason = NO_FRAME
            if text.isprintable() or not _CONTROL.search(text):
                try:
                    reader.file = iter(("", text))  # it skips its headings
                    return packer.frame(next(iter(reader)), number)
                except Unfit as unfit:
                    reason = unfit.reason
                except Exception:  # its message says nothing that the row does not
                    pass
            return unreadable(CUT_LINE if cut else reason, number)

        rest, number, over = "", 0, False
        while not over:
            data = self._below.read()
            over = not data
            *rows, rest = (rest + data.decode("latin-1")).split("\n")
            if over and rest and not self.damage:
                rows = [rest]  # without line end: it may be cut
            if batch := b"".join([record(text, line, cut=over) for line, text in enumerate(rows, number + 1)]):
                yield batch
            number += len(rows)
            rest = rest[: _LONGEST + 1]

    def _spooled(self, scratch: str) -> Path:
        """Returns a temporary file with the content, for a reader that opens by name."""
        path = Path(scratch, f"spool.{self._form}")
        with as_error(SourceError, "source.read", name=self._name), path.open("wb") as spool:
            while data := self._below.read():
                spool.write(data)
        return path

    def _remark(self, problem: str) -> None:
        if len(self._remarks) < REMARKS:
            self._remarks.append(SourceError("bridge.said", name=self._name, problem=problem))

    def _refused(self, problem: str) -> SourceError:
        """Returns the error for a file that cannot be read at all."""
        said: dict[str, str] = {"name": self._name, "form": TITLES[self._form], "problem": problem}
        if self._formats:
            return SourceError("bridge.unfit", **said, formats=", ".join(self._formats))
        return SourceError("bridge.unreadable", **said)
