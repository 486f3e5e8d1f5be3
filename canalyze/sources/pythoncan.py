"""What python-can reads (BLF, TRC, MF4, CSV, SQLite), in batches of records for the core: only this file reads by it.

Its readers give one message at a time and were not made for damaged files. So they get BLF object by object that is
sound, and text line by line (`blf`, `trace`); what an exception ends is told as damage, what came before it stays, and
what the library prints, logs or warns becomes one line each. Must not: decode a format itself beyond that.

| form | channel | direction | stamps |
|---|---|---|---|
| blf | channel 1 of the file is `can0` | yes | from the header's date, 10 µs or 1 ns |
| trc | bus 1 is `can0`, also without a column | from 1.1 on | from the header's date, as many digits as there |
| mf4 | its number is the name's | yes | absolute, µs |
| csv, sqlite | `can0` | no | as they are, µs where they are dates |
"""

import contextlib
import gc
import io
import logging
import struct
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Protocol, Self, TextIO, cast

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources import apart, packed
from canalyze.sources.blf import PYTHON_CAN, Damage, Objects
from canalyze.sources.database import Copy, bound, copied, heed
from canalyze.sources.library import has_asammdf, library
from canalyze.sources.packed import Packer, Unfit
from canalyze.sources.trace import DAMAGED, PASSED_OVER, Lines, Rows, Trc, is_damaged, number_of

if TYPE_CHECKING:
    from can import Message

    from canalyze.sources.compressed import Damage as Damaged
    from canalyze.sources.format import Opened

TITLES: Final = {"blf": "Vector BLF", "trc": "PEAK TRC", "mf4": "MF4", "csv": "CSV", "sqlite": "SQLite"}
"""How a form is called in a sentence."""
_BATCH: Final = 4096
"""Most frames that are joined at once."""
_BYTES: Final = 128 << 10
"""Bytes of a batch."""
_TABLE: Final = "messages"
"""The table that python-can writes."""
_COMMAS: Final = 6
"""Of a row of python-can's table."""
_REMARKS: Final = 20
"""Most lines of the library's that are passed on."""


class Pieces(Protocol):
    """What becomes of the bytes of one form."""

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Take the next bytes; give records."""

    def end(self, *, broken: bool) -> Iterator[bytes]:
        """Take the end of the file; give the rest. `broken`: it was unpacked only so far, which is told elsewhere."""


class PythonCanCapture:
    """An open input that python-can reads; a context manager with the face of `format.Capture`."""

    format: Final = "packed"

    def __init__(
        self, source: "Opened", head: bytes, form: str, *, trusting: bool = False, asked: bool = False
    ) -> None:
        """Take over the source; `head` is what was read of it already, `form` one of TITLES.

        trusting: in this process whatever the form, though the file may bring it down. asked: the user says that it has
        this form. SourceError if what the form
        needs is not installed.
        """
        self.name = source.name
        self.compression = source.compression
        """gzip, xz, bzip2 or zstd, if it is compressed."""
        self.regular = source.regular
        self._source = source
        self._form = form
        self._asked = asked
        self._heard = _Heard()
        self._remarks: list[CanalyzeError] = []
        self._apart = form == "mf4" and not trusting
        self._records = self._batches(head)
        self._first = self._begun = False
        """The records given last were the first; some were given."""
        if form == "mf4" and not has_asammdf():
            raise SourceError("bridge.mf4", name=self.name, line="pip install 'canalyze[mf4]'")

    @property
    def taken(self) -> int:
        """Bytes of the file behind it that have been read: what progress counts."""
        return self._source.taken

    @property
    def kind(self) -> str:
        """The name of its format."""
        return self._form

    @property
    def damage(self) -> "Damaged | None":
        """Why the file could be unpacked no further; known when nothing comes any more."""
        return self._source.damage

    @property
    def begins(self) -> bool:
        """Whether the records given last begin under a check sum: of rows read ahead only the first can be told."""
        return self._first and self.compression is not None

    @property
    def checked(self) -> bool | None:
        """Whether all that was unpacked so far has a check sum; None: nothing is."""
        return self._source.checked

    @property
    def _broken(self) -> bool:
        return self._source.damage is not None

    def read(self) -> bytes:
        """Give the next records, b"" at the end; SourceError if the system refuses or nothing can be read."""
        with self._heard:
            batch = next(self._records, b"")
        self._first, self._begun = not self._begun, True
        for line in self._heard.take():
            self._remarks.append(SourceError("bridge.said", name=self.name, problem=line))
        return batch

    def rests(self) -> bool:
        """Tell whether nothing more comes at the moment: python-can reads what is there at once."""
        return False

    def remarks(self) -> list[CanalyzeError]:
        """Give what is to be told of the file since the last call, for standard error."""
        remarks, self._remarks = self._remarks, []
        return remarks

    def __enter__(self) -> Self:
        """Give the capture itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Close it."""
        self._records.close()
        self._source.close()

    def _batches(self, head: bytes) -> Generator[bytes, None, None]:
        if self._apart:
            yield from self._from_path(head)
            return
        can = library()
        yield packed.dialect("reader", f"python-can {can.__version__}")
        if self._form in ("mf4", "sqlite"):
            yield from self._from_path(head)
            return
        pieces: Pieces = _Blf() if self._form == "blf" else _Trc(self) if self._form == "trc" else _Csv(self)
        data = head
        while data:
            yield from _batched(pieces.feed(data))
            data = self._source.read()
        yield from _batched(pieces.end(broken=self._broken))

    def _from_path(self, head: bytes) -> Iterator[bytes]:
        """Read what its reader opens by name: the file itself, or what was in it put down elsewhere."""
        with tempfile.TemporaryDirectory(prefix="canalyze-") as directory:
            path = self._source.path
            copy = None
            try:
                if path is None:
                    path = Path(directory, f"spool.{self._form}")
                    self._put_down(path, head)
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
            for tag, piece in apart.pieces(path, scratch):
                if tag == apart.RECORDS:
                    batches += 1
                    yield piece
                elif tag == apart.REMARK:
                    self.remark(piece.decode())
                elif tag == apart.REFUSED:
                    raise self.refused(piece.decode())
        except apart.BroughtDown as error:
            problem = f"asammdf: {error}"
            if batches < 2:  # the first says whose they are
                raise self.refused(problem) from error
            self.remark(problem)
            yield packed.damage(packed.REST, 0)

    def _put_down(self, path: Path, data: bytes) -> None:
        with path.open("wb") as spool:
            while data:
                spool.write(data)
                data = self._source.read()

    def _messages(self, path: Path, copy: Copy | None) -> Iterator[bytes]:
        can = library(mf4=self._form == "mf4")
        packer = Packer(6, directed=self._form == "mf4", bus=_as_numbered if self._form == "mf4" else _only)
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
        except Exception as error:  # whatever a stranger's file makes the library raise
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

    def remark(self, problem: str) -> None:
        """Have something told that was wrong with the file."""
        if len(self._remarks) < _REMARKS:
            self._remarks.append(SourceError("bridge.said", name=self.name, problem=problem))

    def refused(self, problem: str) -> SourceError:
        """Give the error of a file that cannot be read at all."""
        said: dict[str, str] = {"name": self.name, "form": TITLES[self._form], "problem": problem}
        if self._asked:
            from canalyze.sources.format import input_formats

            return SourceError("bridge.unfit", **said, formats=", ".join(input_formats()))
        return SourceError("bridge.unreadable", **said)


def _batched(records: Iterator[bytes]) -> Iterator[bytes]:
    """Join records to batches; what was there before an error comes before it."""
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
    """Give an exception of the library in one line."""
    text = " ".join(str(error).split())[:200]
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def _vector(channel: object) -> str:
    """Give the bus of a channel that python-can has counted from 0: channel 1 of the file is can0."""
    return f"can{max(channel, 0)}" if isinstance(channel, int) else "can0"


def _peak(channel: object) -> str:
    """Give the bus of a channel counted from 1, as PEAK does."""
    return f"can{max(channel - 1, 0)}" if isinstance(channel, int) else "can0"


def _as_numbered(channel: object) -> str:
    """Give the bus of a channel by its number as it stands."""
    return f"can{channel}" if isinstance(channel, int) else "can0"


def _channels(packer: Packer, more: int) -> Iterator[bytes]:
    """Say which bus a channel of the file is; `more` is how far the file's numbers are above the library's."""
    known = [f"{channel + more} = {bus}" for channel, bus in packer.buses.items() if isinstance(channel, int)]
    if known:
        yield packed.dialect("channels", ", ".join(known))


def _only(_: object) -> str:
    """Give the bus of a form that has no channels."""
    return "can0"


class _Blf:
    """Sound objects of a BLF file, through python-can's reader."""

    def __init__(self) -> None:
        self._objects = Objects()
        self._packer = Packer(5, directed=True, bus=_vector)
        self._started = False

    def feed(self, data: bytes) -> Iterator[bytes]:
        for piece in self._objects.feed(data):
            yield from self._start()
            yield from self._piece(piece)

    def end(self, *, broken: bool) -> Iterator[bytes]:
        for piece in self._objects.end():
            yield from self._start()
            if not (broken and isinstance(piece, Damage) and piece.kind == packed.CUT):
                yield from self._piece(piece)
        yield from _channels(self._packer, 1)
        for what, count in sorted(self._objects.passed_over.items()):
            yield packed.passed_over(what, count)

    def _start(self) -> Iterator[bytes]:
        if self._started or self._objects.header is None:
            return
        self._started = True
        yield packed.dialect("application", str(self._objects.application))
        if self._objects.date_ns is not None:
            yield packed.start(self._objects.date_ns)

    def _piece(self, piece: bytes | Damage) -> Iterator[bytes]:
        if isinstance(piece, Damage):
            yield piece.record
            return
        header = self._objects.header
        if not piece or header is None:
            return
        if not self._objects.coarse:
            self._packer.decimals = 9
        bare = self._objects.application != PYTHON_CAN
        size = 32 + len(piece)
        container = struct.pack("<4sHHLLH6xL4x", b"LOBJ", 16, 1, size, 10, 0, len(piece))
        file = io.BytesIO(header + container + piece + bytes(size % 4))
        batch: list[bytes] = []
        frame = self._packer.frame
        try:
            for message in library().BLFReader(file):
                try:
                    batch.append(frame(message, 0, bare))
                except Unfit:
                    batch.append(packed.damage(packed.STRUCTURE, self._objects.offset))
                if len(batch) >= _BATCH:
                    yield b"".join(batch)
                    batch = []
        except Exception:  # nothing that is known; what comes behind it is still read
            batch.append(packed.damage(packed.STRUCTURE, self._objects.offset))
        yield b"".join(batch)


class _Text:
    """Lines through one of python-can's readers of text."""

    def __init__(self, capture: PythonCanCapture, lines: Lines, packer: Packer) -> None:
        self.lines = lines
        self.packer = packer
        self.capture = capture
        self.counts: Counter[str] = Counter()
        self.out: list[bytes] = []
        """Records that are not given yet."""
        self.before: Callable[[Message], None] | None = None
        """Looks at a message before it is packed."""
        lines.unanswered = self._unanswered

    def reader(self) -> "Iterator[Message]":
        """Give a reader that goes on with the next line."""
        raise NotImplementedError

    def feed(self, data: bytes) -> Iterator[bytes]:
        self.lines.feed(data)
        yield from self.drain()

    def end(self, *, broken: bool) -> Iterator[bytes]:
        if not broken:
            self.lines.end()
        yield from self.drain()
        for what, count in sorted(self.counts.items()):
            yield packed.passed_over(what, count)

    def drain(self) -> Iterator[bytes]:
        """Read the lines that are there; one that the library cannot read costs only itself."""
        lines, frame, before = self.lines, self.packer.frame, self.before
        out = self.out
        append = out.append
        while lines.waiting:
            try:
                for message in self.reader():
                    lines.answered = True
                    try:
                        if before:
                            before(message)
                        append(frame(message, lines.number))
                    except (Unfit, TypeError, struct.error) as error:
                        reason = error.reason if isinstance(error, Unfit) else packed.DATA
                        out.append(self._unreadable(reason))
            except Exception:  # of the line: its message says nothing that the line does not
                lines.answered = True
                out.append(self._unreadable(packed.NO_FRAME))
            lines.settle()
        yield b"".join(out)
        out.clear()

    def _unanswered(self) -> None:
        self.out.append(self.nothing())

    def nothing(self) -> bytes:
        """Give the record of a line of which nothing came."""
        return self._unreadable(packed.NO_FRAME)

    def _unreadable(self, reason: int) -> bytes:
        """Say of the last line that it cannot be read; one without its end was cut."""
        number = self.lines.number
        return packed.unreadable(packed.CUT_LINE if number == self.lines.endless else reason, number)


class _Trc(_Text):
    """PEAK's traces."""

    def __init__(self, capture: PythonCanCapture) -> None:
        from canalyze._core import omission

        self._trc = Trc()
        super().__init__(capture, Lines(self._trc.change), Packer(3, directed=False, bus=_peak))
        self.before = self._settle
        self._begun = False
        self._rows = Rows()
        self._omission = omission
        self.lines.aside = self._aside
        self._reader = library().TRCReader(cast("TextIO", self.lines))

    def feed(self, data: bytes) -> Iterator[bytes]:
        self.lines.feed(data)
        if self.lines.waiting and self._trc.decided:
            yield from self._begin()
            yield from self.drain()

    def _begin(self) -> Iterator[bytes]:
        if self._begun:
            return
        self._begun = True
        trc = self._trc
        if not trc.known:
            raise self.capture.refused(f"$FILEVERSION={trc.version}")
        self.packer.directed = bool(trc.version) and trc.version != "1.0"
        self.lines.begin(*trc.header)
        yield packed.dialect("version", trc.version or "1.0")
        if trc.date_ns is not None:
            yield packed.start(trc.date_ns)

    def end(self, *, broken: bool) -> Iterator[bytes]:
        if not broken:
            self.lines.end()
        if self.lines.waiting:
            yield from self._begin()
        yield from super().end(broken=broken)
        self._left_out(self._rows.settle())
        yield b"".join(self.out)
        yield from _channels(self.packer, 0)

    def _aside(self) -> bool:
        """Follow the numbers of the rows; take a line that only says that rows were left out."""
        at, line = self.lines.number, self.lines.line
        number = number_of(line)
        if number is None and (left_out := self._omission(line.encode("latin-1"))) is not None:
            self._rows.mark(left_out, at)
            return True
        if missing := self._rows.row(number, at):
            self._left_out(missing)
        return False

    def _left_out(self, missing: tuple[int | None, int, int | None] | None) -> None:
        if missing:
            self.out.append(packed.left_out(*missing))

    def reader(self) -> "Iterator[Message]":
        return iter(self._reader)

    def _settle(self, message: "Message") -> None:
        decimals = self._trc.decimals(self.lines.line)
        if decimals > self.packer.decimals:
            self.packer.decimals = decimals
        if message.is_fd:
            size = self._trc.size(self.lines.line)
            message.dlc = len(message.data)  # the library leaves the code there
            if size is not None and size != message.dlc:
                raise Unfit(packed.DATA)
        if self.lines.number == self.lines.endless and self._trc.may_go_on(self.lines.line):
            raise Unfit(packed.CUT_LINE)

    def nothing(self) -> bytes:
        line, trc = self.lines.line, self._trc
        kind = trc.kind(line)
        try:
            if kind in ("ER", "Error"):
                self.packer.decimals = max(self.packer.decimals, trc.decimals(line))
                return self.packer.error(trc.channel(line), trc.seconds(line), self.lines.number)
        except (ValueError, OverflowError, struct.error):
            kind = ""
        if kind not in PASSED_OVER or (trc.numbered and number_of(line) is None):
            return super().nothing()
        self.counts[kind] += 1
        return b""


class _Csv(_Text):
    """python-can's own table."""

    def __init__(self, capture: PythonCanCapture) -> None:
        super().__init__(capture, Lines(self._change), Packer(6, directed=False, bus=_only))
        self._reader = library().CSVReader(cast("TextIO", self.lines))

    @staticmethod
    def _change(line: str) -> str | None:
        if not line.isprintable() and is_damaged(line):
            return DAMAGED
        return None if line.startswith("timestamp,") and line.count(",") <= _COMMAS else line

    def reader(self) -> "Iterator[Message]":
        self.lines.begin("headings")
        return iter(self._reader)


class _Heard(logging.Handler):
    """Keeps what the libraries log, warn of and print, while they work, from the terminal; a context manager."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.errors = False
        """Something was logged as an error."""
        self._lines: dict[str, None] = {}
        self._stack = contextlib.ExitStack()
        self._printed = io.StringIO()
        self._total = 0

    def emit(self, record: logging.LogRecord) -> None:
        # Of a line of text that cannot be read the core says more.
        if record.name != "can.io.trc":
            self._keep(record.getMessage())
            self.errors |= record.levelno >= logging.ERROR

    def _keep(self, text: str) -> None:
        line = " ".join(text.split())[:200]
        if line and line not in self._lines and self._total < _REMARKS:
            self._total += 1
            self._lines[line] = None

    def take(self) -> list[str]:
        lines, self._lines = list(self._lines), {}
        return lines

    def __enter__(self) -> Self:
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
        self._stack.close()
        for warning in self._caught:
            self._keep(str(warning.message))
        for line in self._printed.getvalue().splitlines():
            self._keep(line)
        self._printed.seek(0)
        self._printed.truncate()
