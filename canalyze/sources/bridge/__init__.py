"""The bridge to python-can: frames as records of the core and as its messages; files that it alone reads, and adapters.

reading.py   MF4, CSV and SQLite
buses.py     channels of adapters

Everything that receives, reads or writes through python-can converts here; the layout of a record is documented in the
core's `readers/packed.rs`. Here python-can is imported, when it is needed, and what it logs is collected. It imports
asammdf if that is installed, which takes four times as long as everything else and is needed for MF4 alone; so it is
hidden until then. Must not: read or write anything, or know a format.
"""

import importlib
import importlib.util
import io
import logging
import struct
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from itertools import chain
from types import ModuleType
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from can import Message

_FRAME_HEAD: Final = struct.Struct("<BBBBBBBxIIq")
"""Of a frame: kind, flags, bus, length, raw DLC, decimals, bytes of data behind it, identifier, line, stamp in ns."""
_OTHER_HEAD: Final = struct.Struct("<BBHIqq")
"""Of every other kind: kind, which, bytes of text behind it, 0, number, further number."""
FRAME, BUS, DAMAGE, UNREADABLE, DIALECT, DROPPED = 1, 2, 4, 5, 7, 8
"""Kinds of records."""
_STAMP, _FD, _BRS, _ESI, _RX, _TX = 1, 2, 4, 8, 16, 32
"""Flags of a frame."""
_EFF, _RTR, _ERR = 0x8000_0000, 0x4000_0000, 0x2000_0000
"""Bits of an identifier: 29 bits, remote, error frame."""
_pack: Final = _FRAME_HEAD.pack
_MOST_ID: Final = 0x1FFF_FFFF
_MOST_BUSES: Final = 256
_MOST_SECONDS: Final = 9.2e9
"""Seconds whose ns fit 64 bits."""
_STEPS: Final = tuple(10 ** (9 - decimals) for decimals in range(10))
"""The ns of the last digit of a stamp, by its number of decimals."""
_NAME: Final = 32
"""Maximum length of the name of a bus."""
_MESSAGE: Final = ("arbitration_id", "data", "timestamp", "dlc")
"""Attributes that only a message of python-can has together."""

PROPERTIES: Final = ("reader", "version", "application", "channels")
"""Properties of a dialect, as the core numbers them."""
CUT, CHECKSUM, STRUCTURE, COMPRESSION, REST = range(5)
"""Kinds of damage, as the core numbers them."""
NO_FRAME, IDENTIFIER, LENGTH, DATA, CUT_LINE = range(5)
"""Reasons for an unreadable line, as the core numbers them."""

SURE_BELOW: Final = 4e6
"""Seconds below which a float is exact to the ns (2**53 ns are 104 days); above, as for dates, to the µs."""


def nanoseconds(seconds: float) -> int:
    """Returns a stamp in ns, rounded to the precision of a float. Raises ValueError or OverflowError if it is none."""
    if -SURE_BELOW < seconds < SURE_BELOW:
        return round(seconds * 1e9)
    return round(seconds * 1e6) * 1000


def bus_name(channel: object) -> str:
    """Returns the name of a channel in listings: its name without the folder; channel 0 is can0, None is ""."""
    if channel is None:
        return ""
    text = str(channel)
    if text.isdecimal():
        return f"can{int(text)}"
    name = text.rstrip("/\\").replace("\\", "/").rpartition("/")[2]
    name = "".join(char if "!" <= char <= "~" and char not in "#," else "_" for char in name)[:_NAME]
    return name if name[:1].isalnum() else f"can{name}"


def damage(kind: int, offset: int, size: int | None = None) -> bytes:
    """Returns the record for a lost part of the file, of `size` bytes."""
    return _other(DAMAGE, kind, offset, -1 if size is None else size)


def unreadable(reason: int, line: int) -> bytes:
    """Returns the record for a line or row that cannot be read."""
    return _other(UNREADABLE, reason, line)


def dialect(name: str, value: str) -> bytes:
    """Returns the record for a property of the file, one of PROPERTIES."""
    return _other(DIALECT, PROPERTIES.index(name), text=value)


def _other(kind: int, which: int, number: int = 0, further: int = 0, *, text: str = "") -> bytes:
    behind = text.encode("utf-8", "backslashreplace")[:200]
    return _OTHER_HEAD.pack(kind, which, len(behind), 0, number, further) + behind


class Unfit(Exception):
    """A message that is no valid frame; `reason` is one of the core's."""

    def __init__(self, reason: int) -> None:
        """Creates the error for a reason."""
        super().__init__(reason)
        self.reason = reason


class Packer:
    """Packs the messages of one file; keeps its buses and the resolution of its stamps."""

    def __init__(self, decimals: int, *, directed: bool, bus: Callable[[object], str]) -> None:
        """Creates a packer for a format.

        decimals: minimum number of decimals of a stamp. directed: the format contains the direction of a frame. bus:
        returns the name of the bus for a channel.
        """
        self.frames = 0
        self._decimals = decimals
        self._received, self._sent = (_RX, _TX) if directed else (0, 0)
        self._bus = bus
        self._indices: dict[object, int] = {}

    def record(self, message: "Message", number: int) -> bytes:
        """Returns the record of a frame, or that of an unreadable row with this number."""
        try:
            return self.frame(message)
        except Unfit as unfit:
            return unreadable(unfit.reason, number)

    def frame(self, message: "Message", line: int = 0, bare: bool = False) -> bytes:
        """Returns the record of a frame, preceded by that of its bus if it is new. Raises Unfit for an invalid frame.

        bare: the identifier and data of error frames are not SocketCAN's and are dropped.
        """
        try:
            identifier, data = message.arbitration_id, message.data
            length = size = len(data)
            flags, raw = self._received if message.is_rx else self._sent, 0
            if (
                message.dlc != size
                or size > 8
                or not 0 <= identifier <= 0x7FF
                or message.is_extended_id
                or message.is_fd
                or message.is_remote_frame
                or message.is_error_frame
            ):
                identifier, further, length, raw, size = _unusual(message, bare)
                flags |= further
                data = data[:size]
            decimals, seconds = self._decimals, message.timestamp
            if -SURE_BELOW < seconds < SURE_BELOW:
                ns = round(seconds * 1e9)
                if ns % _STEPS[decimals]:
                    self._decimals = decimals = 9 if ns % 1000 else 6
                flags |= _STAMP
            elif -_MOST_SECONDS < seconds < _MOST_SECONDS:
                ns = round(seconds * 1e6) * 1000
                if decimals > 6:  # of the digits behind a date's microseconds none is sure
                    decimals = 6
                flags |= _STAMP
            else:  # also not a number
                ns, decimals = 0, 0
            before, index = b"", self._indices.get(message.channel)
            self.frames += 1
            if index is None:
                before, index = self._index(message.channel)
            return before + _pack(FRAME, flags, index, length, raw, decimals, size, identifier, line, ns) + data
        except (TypeError, ValueError, OverflowError, struct.error) as error:
            raise Unfit(DATA) from error

    def _index(self, channel: object) -> tuple[bytes, int]:
        # The last index is of no channel for long: it is named again for each frame of a further one.
        index = min(len(self._indices), _MOST_BUSES - 1)
        name = self._bus(channel)
        if index < _MOST_BUSES - 1:
            self._indices[channel] = index
        return _other(BUS, index, text=name), index


def _unusual(message: "Message", bare: bool) -> tuple[int, int, int, int, int]:
    """Returns identifier with its bits, flags, length, raw DLC and data size of a message. Raises Unfit."""
    identifier, size, flags, raw = message.arbitration_id, len(message.data), 0, 0
    length = size
    if not 0 <= identifier <= _MOST_ID:
        raise Unfit(IDENTIFIER)
    if size > 64:
        raise Unfit(LENGTH)
    if message.is_extended_id or identifier > 0x7FF:
        identifier |= _EFF
    if message.is_error_frame:
        return (_ERR, 0, 0, 0, 0) if bare else (identifier | _ERR, 0, length, 0, size)
    if message.is_fd or size > 8:  # only an FD frame holds more
        flags = _FD | (_BRS if message.bitrate_switch else 0) | (_ESI if message.error_state_indicator else 0)
    elif message.is_remote_frame:
        identifier |= _RTR
        length, size = max(0, min(message.dlc, 8)), 0
        raw = message.dlc if 8 < message.dlc < 16 else 0
    elif message.dlc != size:
        if size < 8 or message.dlc < 8:
            raise Unfit(DATA)
        raw = message.dlc if message.dlc < 16 else 0
    return identifier, flags, length, raw, size


def is_message(one: object) -> bool:
    """Returns true for a message of python-can, or an object with its attributes."""
    return all(hasattr(one, name) for name in _MESSAGE)


def of_messages(messages: Iterable["Message"]) -> bytes:
    """Returns the records of messages in memory. Raises TypeError for other objects.

    If no message has a stamp above 0, all are without stamps.
    """
    packer = Packer(6, directed=True, bus=bus_name)
    out = bytearray(dialect("reader", "python-can"))
    for number, message in enumerate(_stamped(messages), 1):
        if not is_message(message):
            raise TypeError(f"source: item {number} is no can.Message but {type(message).__name__}")
        out += packer.record(message, number)
    return bytes(out)


def _stamped(messages: Iterable["Message"]) -> Iterator["Message"]:
    """Yields the messages; if all stamps are 0, they were never set and are removed."""
    from copy import copy

    waiting: list[Message] = []
    rest = iter(messages)
    for message in rest:
        waiting.append(message)
        if getattr(message, "timestamp", 1.0) != 0:
            yield from chain(waiting, rest)
            return
    for message in waiting:
        bare = copy(message)
        bare.timestamp = float("nan")
        yield bare


class Record(NamedTuple):
    """The head of a record, and where its data or text is."""

    kind: int
    bus: int
    """The index of the bus of a frame, of a name and of dropped frames."""
    number: int
    """The stamp of a frame in ns, or the number of another record."""
    begin: int
    end: int
    flags: int = 0
    length: int = 0
    raw: int = 0
    identifier: int = 0

    @property
    def is_stamped(self) -> bool:
        """True for a frame with a stamp."""
        return bool(self.flags & _STAMP)

    @property
    def is_directed(self) -> bool:
        """True for a frame that is known to be received, or to be sent."""
        return bool(self.flags & (_RX | _TX))


def records(data: bytes, at: int = 0) -> Iterator[Record]:
    """Yields the records from an offset on, without an incomplete last one."""
    while (begin := at + _FRAME_HEAD.size) <= len(data):
        kind, flags, bus, length, raw, _, size, identifier, _, ns = _FRAME_HEAD.unpack_from(data, at)
        if kind == FRAME:
            record = Record(kind, bus, ns, begin, begin + size, flags, length, raw, identifier)
        else:
            _, bus, size, _, number, _ = _OTHER_HEAD.unpack_from(data, at)
            record = Record(kind, bus, number, begin, begin + size)
        at = record.end
        if at > len(data):
            return
        yield record


class Unpacker:
    """Makes messages of records that come in any chunking."""

    def __init__(self) -> None:
        """Begins without records."""
        from can import Message

        self.names: dict[int, str] = {}
        """The names of the buses so far, by their index."""
        self._message = Message
        self._rest = b""

    def messages(self, data: bytes) -> Iterator[tuple[Record, "Message"]]:
        """Yields each frame as a message, without its channel."""
        data = self._rest + data
        at = 0
        for record in records(data):
            at = record.end
            if record.kind == BUS:
                self.names[record.bus] = data[record.begin : at].decode("utf-8", "replace")
            elif record.kind == FRAME:
                yield (
                    record,
                    self._message(
                        timestamp=record.number / 1e9,
                        arbitration_id=record.identifier & _MOST_ID,
                        is_extended_id=bool(record.identifier & _EFF),
                        is_remote_frame=bool(record.identifier & _RTR),
                        is_error_frame=bool(record.identifier & _ERR),
                        dlc=record.raw if record.raw > 8 else record.length,
                        data=data[record.begin : at],
                        is_fd=bool(record.flags & _FD),
                        is_rx=not record.flags & _TX,
                        bitrate_switch=bool(record.flags & _BRS),
                        error_state_indicator=bool(record.flags & _ESI),
                    ),
                )
        self._rest = data[at:]


_MF4: Final = "can.io.mf4"
_ASAMMDF: Final = "asammdf"
REMARKS: Final = 20
"""Maximum number of lines of the libraries that are passed on."""


def library(*, mf4: bool = False) -> ModuleType:
    """Returns the module `can`. With `mf4` its MF4 classes work; raises ImportError if asammdf is not installed."""
    if not mf4:
        return _without_asammdf()
    import can

    importlib.import_module(_ASAMMDF)  # after python-can: it may import that, which then would miss it
    module = importlib.import_module(_MF4)
    if module.asammdf is None:  # python-can was imported without it
        module = importlib.reload(module)
        for name in ("MF4Reader", "MF4Writer"):
            setattr(can, name, getattr(module, name))
    return can


def has_asammdf() -> bool:
    """Returns true if asammdf is installed."""
    return importlib.util.find_spec(_ASAMMDF) is not None


def _without_asammdf() -> ModuleType:
    if "can" not in sys.modules and _ASAMMDF not in sys.modules:
        sys.modules[_ASAMMDF] = None  # type: ignore[assignment]  # as the import system has it: this cannot be imported
        try:
            return importlib.import_module("can")
        finally:
            del sys.modules[_ASAMMDF]
    return importlib.import_module("can")


class Heard(logging.Handler):
    """Collects what the libraries log, each line once."""

    def __init__(self) -> None:
        """Starts with no lines."""
        super().__init__(logging.WARNING)
        self.errors = False
        """True if an error was logged."""
        self._lines: dict[str, None] = {}
        self._new: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Collects a log record."""
        self._keep(record.getMessage())
        self.errors |= record.levelno >= logging.ERROR

    def _keep(self, text: object) -> None:
        line = " ".join(str(text).split())[:200]
        if line and line not in self._lines and len(self._lines) < REMARKS:
            self._lines[line] = None
            self._new.append(line)

    def take(self) -> list[str]:
        """Returns the lines since the last call."""
        self.acquire()  # as `emit` has it: channels have threads of their own
        try:
            new, self._new = self._new, []
        finally:
            self.release()
        return new

    @contextmanager
    def everything(self) -> Iterator[None]:
        """Within its block nothing but the collected lines is logged, and warnings and output are collected too."""
        printed = io.StringIO()
        with ExitStack() as stack:
            for name in ("can", _ASAMMDF):
                logger = logging.getLogger(name)
                stack.callback(setattr, logger, "handlers", logger.handlers)
                stack.callback(setattr, logger, "propagate", logger.propagate)
                logger.handlers, logger.propagate = [self], False
            stack.enter_context(redirect_stdout(printed))
            stack.enter_context(redirect_stderr(printed))
            stack.callback(setattr, sys, "unraisablehook", sys.unraisablehook)
            sys.unraisablehook = lambda _: None  # of objects half made
            stack.enter_context(warnings.catch_warnings())
            warnings.simplefilter("always")
            warnings.showwarning = lambda message, *_: self._keep(message)
            try:
                yield
            finally:
                for line in printed.getvalue().splitlines():
                    self._keep(line)
