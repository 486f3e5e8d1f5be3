"""MF4, CSV and SQLite, read through python-can in batches of records for the core.

Its readers return one message at a time and are not made for damaged files. Rows of CSV are therefore passed one by
one; an exception becomes damage, the frames before it are kept, and what the libraries print, log or warn becomes a
remark. asammdf may crash the process on a damaged file, so that MF4 is read in a child process, which runs `main`.
Must not: decode a format itself beyond that.

| form | channel | direction | stamps |
|---|---|---|---|
| mf4 | its number is the name's | yes | absolute, µs |
| csv, sqlite | `can0` | no | as they are, µs where they are dates |
"""

import io
import marshal
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from canalyze.errors import CanalyzeError, SourceError, one_line
from canalyze.sources.bridge import REMARKS, Heard, has_asammdf, library, packed
from canalyze.sources.bridge.database import Copy, bound, heed
from canalyze.sources.bridge.packed import Packer, Unfit

if TYPE_CHECKING:
    from can import Message

    from canalyze.sources.compressed import Damage, Layer

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
            yield RECORDS, packed.dialect("reader", f"python-can {can.__version__}")
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
        yield RECORDS, packed.damage(packed.REST if problem else packed.STRUCTURE, 0)


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
                        yield packed.damage(packed.REST, 0)

    def _sqlite(self) -> Generator[bytes, None, None]:
        yield packed.dialect("reader", f"python-can {library().__version__}")
        with tempfile.TemporaryDirectory(prefix="canalyze-") as scratch:
            try:
                copy = Copy(self._path or self._spooled(scratch), Path(scratch))
            except OSError as error:
                raise SourceError("source.read", name=self._name, error=error) from error
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
                yield packed.damage(packed.CUT, *copy.cut)
        elif problem:
            self._remark(problem)
            yield packed.damage(packed.REST, 0)
        elif not copy.sound():
            yield packed.damage(packed.STRUCTURE, 0)

    def _csv(self) -> Generator[bytes, None, None]:
        can = library()
        yield packed.dialect("reader", f"python-can {can.__version__}")
        reader = can.CSVReader(io.StringIO())
        packer = Packer(6, directed=False, bus=lambda _: "can0")

        def record(text: str, number: int, *, cut: bool) -> bytes:
            """Returns the record of a row; one that the library cannot read costs only itself."""
            if number == 1:
                text = text.removeprefix("\xef\xbb\xbf")
            text = text.strip() if len(text) <= _LONGEST else "\0"
            if not text or (text.startswith("timestamp,") and text.count(",") <= _COMMAS):
                return b""
            reason = packed.NO_FRAME
            if text.isprintable() or not _CONTROL.search(text):
                try:
                    reader.file = iter(("", text))  # it skips its headings
                    return packer.frame(next(iter(reader)), number)
                except Unfit as unfit:
                    reason = unfit.reason
                except Exception:  # its message says nothing that the row does not
                    pass
            return packed.unreadable(packed.CUT_LINE if cut else reason, number)

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
        try:
            with path.open("wb") as spool:
                while data := self._below.read():
                    spool.write(data)
        except OSError as error:
            raise SourceError("source.read", name=self._name, error=error) from error
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
