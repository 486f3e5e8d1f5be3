"""Writes capture files through python-can (BLF, TRC, MF4, CSV, SQLite) from the core's records.

No other module does. A file is written under a temporary name and renamed when complete. Data that a form cannot hold
is counted in `losses`, by names of the core's `Loss`. Where the library would lose data that the format could hold,
it gets values that it keeps: stamps relative to a date of whole ms, because a double cannot hold the ns of a date;
FD and remote rows of TRC as text. Must not: decode.
"""

import contextlib
import errno
import os
import threading
import time
from collections import Counter
from types import TracebackType
from typing import TYPE_CHECKING, Final, NamedTuple, Self

from canalyze.errors import CanalyzeError, OutputError
from canalyze.output import FileOutput
from canalyze.sources import packed
from canalyze.sources.library import library
from canalyze.sources.packed import FRAME_HEAD, nanoseconds
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


class Row(NamedTuple):
    """A frame to write."""

    message: "Message"
    ns: int
    """Its stamp."""


def open_sink(name: str, form: str, *, force: bool) -> "Sink":
    """Returns a writer for a new file of one of the forms of LOSSES; a context manager.

    Raises OutputError if the file exists and is not to be replaced, or cannot be written, or if a package that the form
    needs is not installed.
    """
    return Sink(name, form, force=force)


class Sink:
    """Writes records of the core, in any chunking, to a file; complete when its block ends without an error."""

    def __init__(self, name: str, form: str, *, force: bool) -> None:
        """Creates the file `name`."""
        self.name = name
        self.losses: Counter[str] = Counter()
        """Number of losses by kind."""
        self.frames = 0
        self._form = form
        self._rest = b""
        self._names: dict[int, str] = {}
        self._channels: dict[int, tuple[int, bool]] = {}
        try:
            library(mf4=form == "mf4")
        except ImportError as error:
            raise OutputError("bridge.mf4", name=name, line="pip install 'canalyze[mf4]'") from error
        self._file = FileOutput(name, force=force)
        try:
            self._into = _INTO[form](self._file.path, name, self.losses)
        except BaseException as error:
            self._file.__exit__(type(error), error, None)
            raise self._failure(error) from error

    def write(self, records: bytes) -> None:
        """Appends records. Raises OutputError if the file cannot be written."""
        data = self._rest + records
        at, end = 0, len(data)
        while at + FRAME_HEAD.size <= end:
            kind, flags, bus, length, raw, decimals, size, identifier, line, ns = FRAME_HEAD.unpack_from(data, at)
            del decimals, line
            behind = size if kind == packed.FRAME else bus | length << 8
            if at + FRAME_HEAD.size + behind > end:
                break
            text = data[at + FRAME_HEAD.size : at + FRAME_HEAD.size + behind]
            at += FRAME_HEAD.size + behind
            if kind == packed.BUS:
                self._names[flags] = text.decode("utf-8", "replace")
            elif kind == packed.FRAME:
                row = self._row(flags, bus, length, raw, identifier, ns, text)
                try:
                    self._into.put(row)
                except Exception as error:
                    raise self._failure(error) from error
        self._rest = data[at:]

    def leave(self) -> str | None:
        """Keeps the written data as a part of a file; returns its name."""
        return self._file.leave()

    def close(self) -> None:
        """Writes the end of the file; the end of the block then renames it."""
        try:
            self._into.finish(aborted=False)
        except Exception as error:
            raise self._failure(error) from error

    def __enter__(self) -> Self:
        """Returns the sink."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Renames the complete file, or removes it after an error."""
        if kind is None:
            try:
                self.close()
            except OutputError as failure:
                self._file.__exit__(type(failure), failure, None)
                raise
        else:
            with contextlib.suppress(Exception):
                self._into.finish(aborted=True)
        self._file.__exit__(kind, error, trace)

    def _failure(self, error: BaseException) -> BaseException:
        if isinstance(error, CanalyzeError) or not isinstance(error, Exception):
            return error
        if getattr(error, "sqlite_errorname", "") == "SQLITE_FULL":
            error = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        reason = error if isinstance(error, OSError) else " ".join(f"{type(error).__name__}: {error}".split())[:200]
        return OutputError("output.write", name=self.name, error=reason)

    def _row(self, flags: int, bus: int, length: int, raw: int, identifier: int, ns: int, data: bytes) -> Row:
        from can import Message

        losses, into = self.losses, self._into
        channel, named = self._channels.get(bus) or self._channel(bus)
        if not named:
            losses["bus_name"] += 1
        if into.directed:
            losses["unknown_direction"] += not flags & (packed.RX | packed.TX)
        else:
            losses["direction"] += bool(flags & (packed.RX | packed.TX))
        if not flags & packed.STAMP:
            losses["no_stamp"] += 1
            ns = self.frames * 1_000_000
        self.frames += 1
        message = Message(
            timestamp=ns / 1e9,
            arbitration_id=identifier & 0x1FFF_FFFF,
            is_extended_id=bool(identifier & packed.EFF),
            is_remote_frame=bool(identifier & packed.RTR),
            is_error_frame=bool(identifier & packed.ERR),
            channel=channel,
            dlc=raw if raw > 8 else length,
            data=data,
            is_fd=bool(flags & packed.FD),
            is_rx=not flags & packed.TX,
            bitrate_switch=bool(flags & packed.BRS),
            error_state_indicator=bool(flags & packed.ESI),
        )
        return Row(message, ns)

    def _channel(self, bus: int) -> tuple[int, bool]:
        """Returns the channel of a bus, counted from 0, and true if it implies its name: can0, can1 and so on."""
        name = self._names.get(bus, "")
        taken = {channel for channel, _ in self._channels.values()}
        digits = name[len(name.rstrip("0123456789")) :]
        wanted = int(digits) if digits and len(digits) <= 5 else 0
        if wanted in taken or wanted > self._into.most_channels:
            wanted = next((free for free in range(self._into.most_channels) if free not in taken), 0)
        named = name == f"can{wanted}" and (self._into.most_channels > 0 or wanted == 0)
        self._channels[bus] = wanted, named or not name
        return self._channels[bus]


class _Blf:
    """Vector BLF; ns, relative to a date in ms."""

    directed = True
    most_channels = 65_534

    def __init__(self, path: str, _: str, losses: Counter[str]) -> None:
        from can import BLFWriter

        self._losses = losses
        self._writer: BLFWriter = BLFWriter(path)
        self._date = -1
        self._last = 0

    def put(self, row: Row) -> None:
        if self._date < 0:
            self._date = row.ns // 1_000_000 * 1_000_000 if row.ns >= DATES_NS else 0
            self._writer.start_timestamp = 0.0
        since = row.ns - self._date
        if since < 0:
            self._losses["order"] += 1
            since = 0
        # Error frames have no direction there, and come back as received.
        self._losses["direction"] += row.message.is_error_frame and not row.message.is_rx
        # The writer cuts off what is behind a ns: half a one more, so that no ns is lost to a double.
        row.message.timestamp = (since + 0.5) / 1e9
        self._losses["stamp_digits"] += int(row.message.timestamp * 1e9) != since
        self._last = max(self._last, row.ns)
        self._writer.on_message_received(row.message)

    def finish(self, *, aborted: bool) -> None:
        del aborted
        dated = self._date > 0
        self._writer.start_timestamp = self._date / 1e9 if dated else None
        self._writer.stop_timestamp = self._last / 1e9 if dated else None
        self._writer.stop()


class _Trc:
    """PEAK TRC 2.1; µs, relative to a date in ms."""

    directed = True
    most_channels = 98

    def __init__(self, path: str, name: str, losses: Counter[str]) -> None:
        from can import TRCWriter

        self._losses = losses
        self._writer: TRCWriter = TRCWriter(path)
        self._writer.filepath = name.encode("ascii", "backslashreplace").decode().replace("\n", " ")
        self._date = -1

    def _begin(self, date: int) -> None:
        self._date = date
        self._losses["no_date"] += date == 0
        self._writer.write_header(date / 1e9)
        self._writer.first_timestamp = 0.0

    def put(self, row: Row) -> None:
        message, writer = row.message, self._writer
        if self._date < 0:
            self._begin(row.ns // 1_000_000 * 1_000_000 if row.ns >= DATES_NS else 0)
        if message.is_error_frame:
            self._losses["error_frame"] += 1
            return
        since = row.ns - self._date
        self._losses["stamp_digits"] += since % 1000 != 0
        message.timestamp = since / 1e9
        if not (message.is_fd or message.is_remote_frame):
            writer.on_message_received(message)
            return
        from can.util import channel2int

        kind = "RR"
        if message.is_fd:
            kind = {0: "FD", 1: "FB", 2: "BI", 3: "FE"}[message.bitrate_switch + 2 * message.error_state_indicator]
        identifier = f"{message.arbitration_id:0{7 if message.is_extended_id else 4}X}"
        dlc = message.dlc if message.is_remote_frame else _code(len(message.data))
        data = message.data.hex(" ").upper()
        way = "Rx" if message.is_rx else "Tx"
        channel = (channel2int(message.channel) or 0) + 1
        place = f"{writer.msgnr:>7} {since / 1e6:13.3f} {kind} {channel:>2}"
        writer.log_event(f"{place} {identifier:>8} {way} -  {dlc:<4} {data}".rstrip(), message.timestamp)
        writer.msgnr += 1

    def finish(self, *, aborted: bool) -> None:
        if self._date < 0 and not aborted:
            self._begin(0)
        self._writer.stop()


def _code(length: int) -> int:
    """Returns the DLC of a length."""
    from can.util import len2dlc

    return len2dlc(length)


class _Mf4:
    """MF4; µs."""

    directed = True
    most_channels = 254

    def __init__(self, path: str, _: str, losses: Counter[str]) -> None:
        from can import MF4Writer

        self._losses = losses
        self._writer: MF4Writer = MF4Writer(path)
        self._last: int | None = None

    def put(self, row: Row) -> None:
        message = row.message
        self._losses["stamp_digits"] += row.ns % 1000 != 0
        self._losses["order"] += self._last is not None and row.ns < self._last
        self._losses["raw_dlc"] += message.dlc > 8 and not message.is_fd
        self._last = row.ns
        self._writer.on_message_received(message)

    def finish(self, *, aborted: bool) -> None:
        del aborted
        self._writer.stop()


class _Csv:
    """python-can's table; as many digits as a double has."""

    directed = False
    most_channels = 0

    def __init__(self, path: str, _: str, losses: Counter[str]) -> None:
        from can import CSVWriter

        self._losses = losses
        self._writer: CSVWriter = CSVWriter(path)

    def put(self, row: Row) -> None:
        _in_table(row, self._losses)
        self._writer.on_message_received(row.message)

    def finish(self, *, aborted: bool) -> None:
        del aborted
        self._writer.stop()


class _Database:
    """SQLite; written by a thread of the library, which drops frames if it is stopped before it is done."""

    directed = False
    most_channels = 0

    def __init__(self, path: str, _: str, losses: Counter[str]) -> None:
        from can import SqliteWriter

        self._losses = losses
        self._sent = 0
        self._failed: list[BaseException] = []
        self._hook = threading.excepthook
        threading.excepthook = self._take_failure
        self._writer: SqliteWriter = SqliteWriter(path)
        self._writer.MAX_BUFFER_SIZE_BEFORE_WRITES = 10_000

    def _take_failure(self, args: threading.ExceptHookArgs) -> None:
        self._failed.append(args.exc_value or RuntimeError(args.exc_type.__name__))

    def put(self, row: Row) -> None:
        _in_table(row, self._losses)
        self._writer.on_message_received(row.message)
        self._sent += 1
        self._wait(_AHEAD)

    def _wait(self, behind: int) -> None:
        while self._sent - self._writer.num_frames > behind:
            if self._failed:
                raise self._failed[0]
            time.sleep(0.005)

    def finish(self, *, aborted: bool) -> None:
        try:
            if not aborted:
                self._wait(0)
            self._writer.stop()
            if self._failed and not aborted:
                raise self._failed[0]
        finally:
            threading.excepthook = self._hook


def _in_table(row: Row, losses: Counter[str]) -> None:
    """Counts the losses of a row of seven columns; more than eight bytes imply FD."""
    message = row.message
    losses["stamp_digits"] += nanoseconds(message.timestamp) != row.ns
    if message.is_fd:
        short = len(message.data) <= 8
        losses["fd_format"] += short
        losses["fd_flags"] += not short and (message.bitrate_switch or message.error_state_indicator)


_INTO: Final[dict[str, type[_Blf] | type[_Trc] | type[_Mf4] | type[_Csv] | type[_Database]]] = {
    "blf": _Blf,
    "trc": _Trc,
    "mf4": _Mf4,
    "csv": _Csv,
    "db": _Database,
}
