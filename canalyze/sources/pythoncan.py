"""Reads MF4, CSV and SQLite through python-can, in batches of records for the core.

Only this module and `pieces` use its readers, which return one message at a time and are not made for damaged
files. Text is therefore passed to them line by line (`pieces`); an exception becomes damage, the frames before it
are kept, and everything that the library prints, logs or warns becomes a remark. asammdf may crash the process on a
damaged file, so that MF4 is read in a child process, which runs `main` and writes pieces: a tag, a size and the
payload. If it ends without a final piece, it has crashed. Must not: decode a format itself beyond that.

| form | channel | direction | stamps |
|---|---|---|---|
| mf4 | its number is the name's | yes | absolute, µs |
| csv, sqlite | `can0` | no | as they are, µs where they are dates |
"""

import contextlib
import gc
import io
import logging
import os
import signal
import struct
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections.abc import Generator, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Self

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources import packed
from canalyze.sources.database import Copy, bound, copied, heed
from canalyze.sources.library import has_asammdf, library
from canalyze.sources.packed import Packer, Unfit
from canalyze.sources.pieces import CsvText

if TYPE_CHECKING:
    from canalyze.sources.compressed import Damage as Damaged
    from canalyze.sources.format import Capture


RECORDS: Final = b"R"
REMARK: Final = b"S"
REFUSED: Final = b"X"
_END: Final = b"E"
_HEAD: Final = struct.Struct("<cI")
_START: Final = """import sys
sys.path[:] = sys.argv[2:]
from canalyze.sources.file import Source
from canalyze.sources.format import Capture
from canalyze.sources.pythoncan import main
main(Capture(Source(sys.argv[1])))
"""


class BroughtDown(Exception):
    """The child process crashed; the message is the name of the signal, or its exit code."""


def from_process(path: Path, scratch: Path) -> Iterator[tuple[bytes, bytes]]:
    """Yields the tagged pieces that the child process writes for a file. Raises BroughtDown if it crashes.

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
            while len(head := process.stdout.read(_HEAD.size)) == _HEAD.size:
                tag, size = _HEAD.unpack(head)
                piece = process.stdout.read(size)
                if tag == _END:
                    return
                if len(piece) == size:
                    yield tag, piece
            code = process.wait()
        finally:
            process.kill()
    name = str(code)
    with suppress(ValueError):
        name = signal.Signals(-code).name
    raise BroughtDown(name)


def from_this_process(source: "Capture") -> Iterator[tuple[bytes, bytes]]:
    """Yields the same pieces as `from_process`, read in this process."""
    with PythonCanCapture(source, "mf4", trusting=True) as capture:
        data, refusal = b"-", None
        while data and not refusal:
            try:
                data = capture.read()
            except CanalyzeError as error:
                refusal = error
            for remark in capture.remarks():
                yield REMARK, _problem(remark)
            if refusal:
                yield REFUSED, _problem(refusal)
            elif data:
                yield RECORDS, data


def _problem(error: CanalyzeError) -> bytes:
    return str(error.facts.get("problem", error)).encode("utf-8", "replace")


def main(source: "Capture") -> None:
    """Reads a file and writes the pieces to standard output; the entry point of the child process."""
    out = sys.stdout.buffer
    for tag, piece in from_this_process(source):
        out.write(_HEAD.pack(tag, len(piece)) + piece)
        out.flush()
    out.write(_HEAD.pack(_END, 0))
    out.flush()


_REMARKS: Final = 20
"""Maximum number of lines of the libraries that are passed on."""


class Heard(logging.Handler):
    """A context manager that collects the log, warnings and output of the libraries."""

    def __init__(self) -> None:
        """Starts with no lines."""
        super().__init__(logging.WARNING)
        self.errors = False
        """True if an error was logged."""
        self._lines: dict[str, None] = {}
        self._stack = contextlib.ExitStack()
        self._printed = io.StringIO()
        self._total = 0

    def emit(self, record: logging.LogRecord) -> None:
        """Collects a log record."""
        self._keep(record.getMessage())
        self.errors |= record.levelno >= logging.ERROR

    def _keep(self, text: str) -> None:
        line = " ".join(text.split())[:200]
        if line and line not in self._lines and self._total < _REMARKS:
            self._total += 1
            self._lines[line] = None

    def take(self) -> list[str]:
        """Returns the lines since the last call, without duplicates."""
        lines, self._lines = list(self._lines), {}
        return lines

    def __enter__(self) -> Self:
        """Begins to collect."""
        for name in ("can", "asammdf"):
            logger = logging.getLogger(name)
            self._stack.callback(setattr, logger, "handlers", logger.handlers)
            self._stack.callback(setattr, logger, "propagate", logger.propagate)
            logger.handlers, logger.propagate = [self], False
        self._stack.enter_context(contextlib.redirect_stdout(self._printed))
        self._stack.enter_context(contextlib.redirect_stderr(self._printed))
        self._stack.callback(setattr, sys, "unraisablehook", sys.unraisablehook)
        sys.unraisablehook = lambda _: None  # of objects half made
        caught = self._stack.enter_context(warnings.catch_warnings(record=True))
        warnings.simplefilter("always")
        self._caught = caught or []
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Restores logging, warnings and output."""
        self._stack.close()
        for warning in self._caught:
            self._keep(str(warning.message))
        for line in self._printed.getvalue().splitlines():
            self._keep(line)
        self._printed.seek(0)
        self._printed.truncate()


TITLES: Final = {"mf4": "MF4", "csv": "CSV", "sqlite": "SQLite"}
"""The name of a form in a sentence."""
_BATCH: Final = 4096
"""Maximum number of frames joined at once."""
_BYTES: Final = 128 << 10
"""Size of a batch in bytes."""
_TABLE: Final = "messages"
"""The table that python-can writes."""
_COMMAS: Final = 6
"""Number of commas in a row of python-can's table."""


class PythonCanCapture:
    """An open input that python-can reads; a context manager with the interface of `format.Capture`."""

    format: Final = "packed"

    def __init__(self, source: "Capture", form: str, *, trusting: bool = False, formats: Sequence[str] = ()) -> None:
        """Takes ownership of the source; `form` is one of TITLES.

        trusting: read in this process, though the file may crash it. formats: those to choose from, if the
        user has given the form. Raises SourceError if a package that the form needs is not installed.
        """
        self.name = source.name
        self.compression = source.compression
        """gzip, xz, bzip2 or zstd; None if it is not compressed."""
        self.regular = source.regular
        self._source = source
        self._form = form
        self._formats = formats
        self._heard = Heard()
        self._remarks: list[CanalyzeError] = []
        self._apart = form == "mf4" and not trusting
        self._records = self._batches()
        self._first = self._begun = False
        """True if the records returned last were the first, and true if any were returned."""
        if form == "mf4" and not has_asammdf():
            raise SourceError("bridge.mf4", name=self.name, line="pip install 'canalyze[mf4]'")

    @property
    def taken(self) -> int:
        """Number of bytes of the underlying file that have been read, for the progress display."""
        return self._source.taken

    @property
    def kind(self) -> str:
        """The name of its format."""
        return self._form

    @property
    def damage(self) -> "Damaged | None":
        """The damage that ended the data, if any; known at the end."""
        return self._source.damage

    @property
    def begins(self) -> bool:
        """True if the records returned last begin under a checksum; known only for the first ones."""
        return self._first and self.compression is not None

    @property
    def checked(self) -> bool | None:
        """True if everything unpacked so far has a checksum; None if the file is not compressed."""
        return self._source.checked

    @property
    def _broken(self) -> bool:
        return self._source.damage is not None

    def read(self) -> bytes:
        """Returns the next records, b"" at the end. Raises SourceError if the file cannot be read."""
        with self._heard:
            batch = next(self._records, b"")
        self._first, self._begun = not self._begun, True
        for line in self._heard.take():
            self._remarks.append(SourceError("bridge.said", name=self.name, problem=line))
        return batch

    def rests(self) -> bool:
        """Returns false; python-can reads everything at once."""
        return False

    def remarks(self) -> list[CanalyzeError]:
        """Returns the remarks on the file since the last call, for standard error."""
        remarks, self._remarks = self._remarks, []
        return remarks

    def __enter__(self) -> Self:
        """Returns the capture."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Closes the capture."""
        self._records.close()
        self._source.close()

    def _batches(self) -> Generator[bytes, None, None]:
        if self._apart:
            yield from self._from_path()
            return
        can = library()
        yield packed.dialect("reader", f"python-can {can.__version__}")
        if self._form in ("mf4", "sqlite"):
            yield from self._from_path()
            return
        text = CsvText()
        while data := self._source.read():
            if records := text.feed(data):
                yield records
        if records := text.end(broken=self._broken):
            yield records

    def _from_path(self) -> Iterator[bytes]:
        """Reads through a reader that opens by name: the file itself, or its unpacked content in a temporary file."""
        with tempfile.TemporaryDirectory(prefix="canalyze-") as directory:
            path = self._source.path
            copy = None
            try:
                if path is None:
                    path = Path(directory, f"spool.{self._form}")
                    self._put_down(path)
                    copy = Copy(path, None) if self._form == "sqlite" else None
                elif self._form == "sqlite":  # its reader would write in the file
                    copy = copied(path, Path(directory))
            except OSError as error:
                raise SourceError("source.read", name=self.name, error=error) from error
            if copy and copy.computes(_TABLE):
                raise SourceError("bridge.computed", name=self.name, table=_TABLE)
            if self._apart:
                yield from self._from_other_process(path, Path(directory))
            else:
                yield from _batched(self._messages(copy.path if copy else path, copy))

    def _from_other_process(self, path: Path, scratch: Path) -> Iterator[bytes]:
        batches = 0
        try:
            for tag, piece in from_process(path, scratch):
                if tag == RECORDS:
                    batches += 1
                    yield piece
                elif tag == REMARK:
                    self.remark(piece.decode())
                elif tag == REFUSED:
                    raise self.refused(piece.decode())
        except BroughtDown as error:
            problem = f"asammdf: {error}"
            if batches < 2:  # the first says whose they are
                raise self.refused(problem) from error
            self.remark(problem)
            yield packed.damage(packed.REST, 0)

    def _put_down(self, path: Path) -> None:
        with path.open("wb") as spool:
            while data := self._source.read():
                spool.write(data)

    def _messages(self, path: Path, copy: Copy | None) -> Iterator[bytes]:
        can = library(mf4=self._form == "mf4")
        packer = Packer(6, directed=self._form == "mf4", bus=self._bus)
        row = 0
        problem = None
        try:
            reader: Any = can.MF4Reader(str(path)) if self._form == "mf4" else can.SqliteReader(str(path), _TABLE)
            if copy:
                bound(reader._conn)
            with reader:
                for message in reader:
                    if copy and row >= copy.most_rows:
                        break
                    row += 1
                    try:
                        if packer.directed:  # the date was added to it: more than µs is noise
                            message.timestamp = round(message.timestamp, 6)
                        yield packer.frame(message)
                    except (Unfit, TypeError, ValueError, struct.error) as error:
                        yield packed.unreadable(error.reason if isinstance(error, Unfit) else packed.DATA, row)
        except Exception as error:  # a damaged file may cause any exception in the library
            heed(error)
            problem = _said(error)
            traceback.clear_frames(error.__traceback__)
        if problem:
            reader = None
            gc.collect()  # what the library says when it is thrown away is heard as well
            if packer.frames == 0:
                raise self.refused(problem)
        if copy and copy.cut:
            if not self._broken:
                yield packed.damage(packed.CUT, *copy.cut)
        elif problem:
            self.remark(problem)
            yield packed.damage(packed.REST, 0)
        elif self._heard.errors or (copy and not copy.sound()):  # asammdf goes on without what it could not read
            yield packed.damage(packed.STRUCTURE, 0)

    def _bus(self, channel: object) -> str:
        """Returns the bus of a channel; only MF4 has channels."""
        return f"can{channel}" if self._form == "mf4" and isinstance(channel, int) else "can0"

    def remark(self, problem: str) -> None:
        """Appends a remark on the file."""
        if len(self._remarks) < _REMARKS:
            self._remarks.append(SourceError("bridge.said", name=self.name, problem=problem))

    def refused(self, problem: str) -> SourceError:
        """Returns the error for a file that cannot be read at all."""
        said: dict[str, str] = {"name": self.name, "form": TITLES[self._form], "problem": problem}
        if self._formats:
            return SourceError("bridge.unfit", **said, formats=", ".join(self._formats))
        return SourceError("bridge.unreadable", **said)


def _batched(records: Iterator[bytes]) -> Iterator[bytes]:
    """Joins records to batches; records before an error are yielded before it is raised."""
    batch: list[bytes] = []
    size = 0
    stopped: SourceError | None = None
    try:
        for record in records:
            batch.append(record)
            size += len(record)
            if size >= _BYTES:
                yield b"".join(batch)
                batch, size = [], 0
    except SourceError as error:
        stopped = error
    if size:
        yield b"".join(batch)
    if stopped:
        raise stopped


def _said(error: BaseException) -> str:
    """Returns an exception of the library in one line."""
    text = " ".join(str(error).split())[:200]
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
