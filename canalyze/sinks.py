"""The target of a conversion: its format by its name or by request, and its writer.

The core returns the bytes of its own formats; BLF, TRC, MF4, CSV and SQLite are written through python-can from the
core's records, and nowhere else. A file is written under a temporary name and renamed when complete. Data that a form
cannot hold is counted in `losses`, by names of the core's `Loss`. Where the library would lose data that the format
could hold, it gets values that it keeps: stamps relative to a date of whole ms, because a double cannot hold the ns of
a date; FD and remote rows of TRC as text. Must not: know a frame.
"""

import errno
import os
import threading
import time
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from pathlib import PurePath
from types import TracebackType
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple

from canalyze.errors import CanalyzeError, OutputError, as_error, one_line
from canalyze.output import FileOutput, Output, open_output
from canalyze.sources.bridge import Record, Unpacker, library, nanoseconds
from canalyze.sources.compressed import COMPRESSIONS
from canalyze.values import DATES_NS

if TYPE_CHECKING:
    from can import Message

_BOUND: Final = ("unknown_direction", "bus_name", "no_stamp")
_TABLE: Final = ("direction", "bus_name", "stamp_digits", "no_stamp", "fd_flags", "fd_format")
LOSSES: Final[dict[str, tuple[str, ...]]] = {
    "blf": (*_BOUND, "direction", "order", "stamp_digits"),
    "trc": (*_BOUND, "stamp_digits", "no_date", "error_frame"),
    "mf4": (*_BOUND, "order", "stamp_digits", "raw_dlc"),
    "csv": _TABLE,
    "db": _TABLE,
}
"""The forms and their possible losses, found by reading back: names of the core's `Loss`."""

_AHEAD: Final = 50_000
"""Maximum number of frames that wait for the database."""


def open_sink(name: str, form: str, *, force: bool) -> "Sink":
    """Returns a writer for a new file of one of the forms of LOSSES; a context manager.

    Raises OutputError if the file exists and is not to be replaced, or cannot be written, or if a package that the form
    needs is not installed.
    """
    return _SINKS[form](name, force=force)


class Sink(FileOutput):
    """A file written from the core's records, in any chunking; complete when its block ends without an error."""

    writer: ClassVar[str]
    """The name of the library's class."""
    directed = True
    most_channels = 0

    def __init__(self, name: str, *, force: bool) -> None:
        """Creates the file `name`."""
        with as_error(OutputError, "bridge.mf4", ImportError, name=name, line="pip install 'canalyze[mf4]'"):
            can = library(mf4=self.writer == "MF4Writer")
        super().__init__(name, force=force)
        self.losses: Counter[str] = Counter()
        """Number of losses by kind."""
        self.frames = 0
        self._unpacker = Unpacker()
        self._channels: dict[int, tuple[int, bool]] = {}
        try:
            self._writer: Any = getattr(can, self.writer)(self.path)
        except BaseException as error:
            super().__exit__(type(error), error, None)
            raise self._failure(error) from error

    def write(self, data: bytes) -> None:
        """Appends records. Raises OutputError if the file cannot be written."""
        try:
            for record, message in self._unpacker.messages(data):
                self._put(message, self._counted(record, message))
                self.frames += 1
        except Exception as error:
            raise self._failure(error) from error

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Writes the end of the file and renames it, or removes it after an error."""
        if kind is None:
            try:
                self._finish(aborted=False)
            except Exception as cause:
                failure = self._failure(cause)
                super().__exit__(type(failure), failure, None)
                raise failure from cause
        else:
            with suppress(Exception):
                self._finish(aborted=True)
        super().__exit__(kind, error, trace)

    def _put(self, message: "Message", ns: int) -> None:
        """Writes a frame with its stamp."""
        raise NotImplementedError

    def _finish(self, *, aborted: bool) -> None:
        """Writes the end of the file."""
        del aborted
        self._writer.stop()

    def _failure(self, error: BaseException) -> BaseException:
        if isinstance(error, CanalyzeError) or not isinstance(error, Exception):
            return error
        if getattr(error, "sqlite_errorname", "") == "SQLITE_FULL":
            error = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        reason = error if isinstance(error, OSError) else one_line(error)
        return OutputError("output.write", name=self.name, error=reason)

    def _counted(self, record: Record, message: "Message") -> int:
        """Completes a message with its channel and stamp, and counts what every form loses; returns the stamp in ns."""
        losses = self.losses
        message.channel, named = self._channels.get(record.bus) or self._channel(record.bus)
        if not named:
            losses["bus_name"] += 1
        if self.directed:
            losses["unknown_direction"] += not record.is_directed
        else:
            losses["direction"] += record.is_directed
        if record.is_stamped:
            return record.number
        losses["no_stamp"] += 1
        message.timestamp = self.frames / 1e3
        return self.frames * 1_000_000

    def _channel(self, bus: int) -> tuple[int, bool]:
        """Returns the channel of a bus, counted from 0, and true if it implies its name: can0, can1 and so on."""
        name = self._unpacker.names.get(bus, "")
        taken = {channel for channel, _ in self._channels.values()}
        digits = name[len(name.rstrip("0123456789")) :]
        wanted = int(digits) if digits and len(digits) <= 5 else 0
        if wanted in taken or wanted > self.most_channels:
            wanted = next((free for free in range(self.most_channels) if free not in taken), 0)
        named = name == f"can{wanted}" and (self.most_channels > 0 or wanted == 0)
        self._channels[bus] = wanted, named or not name
        return self._channels[bus]


def _start(ns: int) -> int:
    """Returns the date in whole ms from which stamps count; 0 if the first of them is no date."""
    return ns // 1_000_000 * 1_000_000 if ns >= DATES_NS else 0


class _Blf(Sink):
    """Vector BLF; ns, relative to a date in ms."""

    writer = "BLFWriter"
    most_channels = 65_534
    _date: int | None = None
    _last = 0

    def _put(self, message: "Message", ns: int) -> None:
        if self._date is None:
            self._date = _start(ns)
            self._writer.start_timestamp = 0.0
        since = ns - self._date
        if since < 0:
            self.losses["order"] += 1
            since = 0
        # Error frames have no direction there, and come back as received.
        self.losses["direction"] += message.is_error_frame and not message.is_rx
        # The writer cuts off what is behind a ns: half a one more, so that no ns is lost to a double.
        message.timestamp = (since + 0.5) / 1e9
        self.losses["stamp_digits"] += int(message.timestamp * 1e9) != since
        self._last = max(self._last, ns)
        self._writer.on_message_received(message)

    def _finish(self, *, aborted: bool) -> None:
        self._writer.start_timestamp = self._date / 1e9 if self._date else None
        self._writer.stop_timestamp = self._last / 1e9 if self._date else None
        super()._finish(aborted=aborted)


class _Trc(Sink):
    """PEAK TRC 2.1; µs, relative to a date in ms."""

    writer = "TRCWriter"
    most_channels = 98
    _date: int | None = None

    def _begin(self, date: int) -> None:
        self._date = date
        self.losses["no_date"] += date == 0
        self._writer.filepath = self.name.encode("ascii", "backslashreplace").decode().replace("\n", " ")
        self._writer.write_header(date / 1e9)
        self._writer.first_timestamp = 0.0

    def _put(self, message: "Message", ns: int) -> None:
        if self._date is None:
            self._begin(_start(ns))
        if message.is_error_frame:
            self.losses["error_frame"] += 1
            return
        since = ns - (self._date or 0)
        self.losses["stamp_digits"] += since % 1000 != 0
        message.timestamp = since / 1e9
        if message.is_fd or message.is_remote_frame:
            self._write_row(message, since)
        else:
            self._writer.on_message_received(message)

    def _write_row(self, message: "Message", since: int) -> None:
        """Writes a row of a kind that the library does not write."""
        from can.util import channel2int, len2dlc

        kind = "RR"
        if message.is_fd:
            kind = {0: "FD", 1: "FB", 2: "BI", 3: "FE"}[message.bitrate_switch + 2 * message.error_state_indicator]
        identifier = f"{message.arbitration_id:0{7 if message.is_extended_id else 4}X}"
        dlc = message.dlc if message.is_remote_frame else len2dlc(len(message.data))
        data = message.data.hex(" ").upper()
        way = "Rx" if message.is_rx else "Tx"
        channel = (channel2int(message.channel) or 0) + 1
        place = f"{self._writer.msgnr:>7} {since / 1e6:13.3f} {kind} {channel:>2}"
        self._writer.log_event(f"{place} {identifier:>8} {way} -  {dlc:<4} {data}".rstrip(), message.timestamp)
        self._writer.msgnr += 1

    def _finish(self, *, aborted: bool) -> None:
        if self._date is None and not aborted:
            self._begin(0)
        super()._finish(aborted=aborted)


class _Mf4(Sink):
    """MF4; µs."""

    writer = "MF4Writer"
    most_channels = 254
    _last: int | None = None

    def _put(self, message: "Message", ns: int) -> None:
        self.losses["stamp_digits"] += ns % 1000 != 0
        self.losses["order"] += self._last is not None and ns < self._last
        self.losses["raw_dlc"] += message.dlc > 8 and not message.is_fd
        self._last = ns
        self._writer.on_message_received(message)


class _Csv(Sink):
    """python-can's table of seven columns, where more than eight bytes imply FD; as many digits as a double has."""

    writer = "CSVWriter"
    directed = False

    def _put(self, message: "Message", ns: int) -> None:
        self.losses["stamp_digits"] += nanoseconds(message.timestamp) != ns
        if message.is_fd:
            short = len(message.data) <= 8
            self.losses["fd_format"] += short
            self.losses["fd_flags"] += not short and (message.bitrate_switch or message.error_state_indicator)
        self._writer.on_message_received(message)


class _Database(_Csv):
    """SQLite; written by a thread of the library, which drops frames if it is stopped before it is done."""

    writer = "SqliteWriter"

    def __init__(self, name: str, *, force: bool) -> None:
        self._failed: list[BaseException] = []
        self._hook = threading.excepthook
        threading.excepthook = self._take_failure
        try:
            super().__init__(name, force=force)
        except BaseException:
            threading.excepthook = self._hook
            raise
        self._writer.MAX_BUFFER_SIZE_BEFORE_WRITES = 10_000

    def _take_failure(self, args: threading.ExceptHookArgs) -> None:
        self._failed.append(args.exc_value or RuntimeError(args.exc_type.__name__))

    def _put(self, message: "Message", ns: int) -> None:
        super()._put(message, ns)
        self._wait(self.frames - _AHEAD)

    def _wait(self, frames: int) -> None:
        """Waits until this number of frames is written."""
        while self._writer.num_frames < frames:
            if self._failed:
                raise self._failed[0]
            time.sleep(0.005)

    def _finish(self, *, aborted: bool) -> None:
        try:
            if not aborted:
                self._wait(self.frames)
            super()._finish(aborted=aborted)
            if self._failed and not aborted:
                raise self._failed[0]
        finally:
            threading.excepthook = self._hook


_SINKS: Final[dict[str, type[Sink]]] = {"blf": _Blf, "trc": _Trc, "mf4": _Mf4, "csv": _Csv, "db": _Database}


class CompressedOutput(FileOutput):
    """A compressed file; complete when its block ends without an error."""

    def __init__(self, name: str, compression: str, *, force: bool) -> None:
        """Creates the file `name`; `compression` is one of COMPRESSIONS."""
        self._compressor = COMPRESSIONS[compression].compressor()
        super().__init__(name, force=force)

    def write(self, data: bytes) -> None:
        """Compresses and writes."""
        super().write(self._compressor.compress(data))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Writes the remaining output of the compressor, then ends as every file."""
        if kind is None:
            try:
                super().write(self._compressor.flush())
            except BaseException as failure:
                super().__exit__(type(failure), failure, failure.__traceback__)
                raise
        super().__exit__(kind, error, at)


STDOUT: Final = "-"
RECORDS: Final = "packed"
"""The core's format for a writer outside of it."""

_SUFFIXES: Final[dict[str, tuple[str, ...]]] = {
    "candump": (".log", ".candump"),
    "console": (".txt",),
    "db": (".db", ".sqlite", ".sqlite3"),
}
"""Suffixes of formats whose suffix is not their name."""
_TEXT: Final = frozenset({"candump", "console", "asc"})
"""Formats that a terminal can show."""


class Target(NamedTuple):
    """A file or standard output with its format."""

    name: str
    form: str
    """One of `forms()`."""
    compression: str | None
    """One of COMPRESSIONS."""

    @property
    def written(self) -> str:
        """The format that the core has to write."""
        return self.form if self.form in _own() else RECORDS

    @property
    def fits_terminal(self) -> bool:
        """True if a terminal can show it."""
        return self.form in _TEXT


def _own() -> tuple[str, ...]:
    from canalyze._core import WRITERS

    return tuple(WRITERS)


def forms() -> tuple[str, ...]:
    """Returns the names of all formats that can be written."""
    return (*_own(), *LOSSES)


def suffixes() -> dict[str, str]:
    """Returns the formats by the suffixes of names."""
    return {suffix: form for form in forms() for suffix in _SUFFIXES.get(form, (f".{form}",))}


def compressions() -> dict[str, str]:
    """Returns the compressions by the suffixes of names."""
    return {one.suffix: name for name, one in COMPRESSIONS.items()}


def target(name: str, form: str | None) -> Target | None:
    """Returns the target of a name, with the requested format or that of its suffix; None if neither is known."""
    if name == STDOUT:
        return Target(name, form, None) if form else None
    path = PurePath(name)
    compression = compressions().get(path.suffix.lower())
    inner = path.with_suffix("") if compression else path
    form = form or suffixes().get(inner.suffix.lower())
    return Target(name, form, compression) if form else None


def open_target(where: Target, *, force: bool) -> tuple[Output, Mapping[str, int]]:
    """Returns the output for the core's bytes, a context manager, and its losses by names of the core's losses.

    Raises OutputError if the file exists and is not to be replaced, or cannot be written.
    """
    if where.written == RECORDS:
        sink = open_sink(where.name, where.form, force=force)
        return sink, sink.losses
    if where.compression:
        return CompressedOutput(where.name, where.compression, force=force), {}
    return open_output(where.name, force=force), {}
