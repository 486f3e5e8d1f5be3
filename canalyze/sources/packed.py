"""The records in which frames are passed to the core: the Python side of the core's `readers/packed.rs`.

The layout of a record is documented there; this module packs messages of python-can. Must not: know a format.
"""

import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from can import Message

FRAME_HEAD: Final = struct.Struct("<BBBBBBBxIIq")
"""Of a frame: kind, flags, bus, length, raw DLC, decimals, bytes of data behind it, identifier, line, stamp in ns."""
OTHER_HEAD: Final = struct.Struct("<BBHIqq")
"""Of every other kind: kind, which, bytes of text behind it, 0, number, further number."""
FRAME, BUS, START, DAMAGE, UNREADABLE, PASSED_OVER, DIALECT, DROPPED, LEFT_OUT = range(1, 10)
"""Kinds of records."""
STAMP, FD, BRS, ESI, RX, TX = 1, 2, 4, 8, 16, 32
"""Flags of a frame."""
EFF, RTR, ERR = 0x8000_0000, 0x4000_0000, 0x2000_0000
"""Bits of an identifier: 29 bits, remote, error frame."""
_pack: Final = FRAME_HEAD.pack
_MOST_ID: Final = 0x1FFF_FFFF
_MOST_BUSES: Final = 256
_MOST_SECONDS: Final = 9.2e9
"""Seconds whose ns fit 64 bits."""
_STEPS: Final = tuple(10 ** (9 - decimals) for decimals in range(10))
"""The ns of the last digit of a stamp, by its number of decimals."""

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
    return OTHER_HEAD.pack(kind, which, len(behind), 0, number, further) + behind


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
        self.decimals = decimals
        self.frames = 0
        self._received = self._sent = 0
        self.directed = directed
        self._bus = bus
        self._indices: dict[object, int] = {}

    @property
    def directed(self) -> bool:
        """True if the format contains the direction of a frame."""
        return self._sent != 0

    @directed.setter
    def directed(self, directed: bool) -> None:
        self._received, self._sent = (RX, TX) if directed else (0, 0)

    def frame(self, message: "Message", line: int = 0, bare: bool = False) -> bytes:
        """Returns the record of a frame, preceded by that of its bus if it is new. Raises Unfit for an invalid frame.

        bare: the identifier and data of error frames are not SocketCAN's and are dropped.
        """
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
        decimals = self.decimals
        try:
            seconds = message.timestamp
            if -SURE_BELOW < seconds < SURE_BELOW:
                ns = round(seconds * 1e9)
                if ns % _STEPS[decimals]:
                    self.decimals = decimals = 9 if ns % 1000 else 6
                flags |= STAMP
            elif -_MOST_SECONDS < seconds < _MOST_SECONDS:
                ns = round(seconds * 1e6) * 1000
                if decimals > 6:  # of the digits behind a date's microseconds none is sure
                    decimals = 6
                flags |= STAMP
            else:
                ns, decimals = 0, 0
        except ValueError:  # not a number
            ns, decimals = 0, 0
        channel = message.channel
        index = self._indices.get(channel)
        self.frames += 1
        if index is None:
            before, index = self._index(channel)
            return before + _pack(FRAME, flags, index, length, raw, decimals, size, identifier, line, ns) + data
        return _pack(FRAME, flags, index, length, raw, decimals, size, identifier, line, ns) + data

    def _index(self, channel: object) -> tuple[bytes, int]:
        index = self._indices.get(channel)
        if index is not None:
            return b"", index
        # The last index is of no channel for long: it is named anew for each frame of those beyond.
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
        identifier |= EFF
    if message.is_error_frame:
        return (ERR, 0, 0, 0, 0) if bare else (identifier | ERR, 0, length, 0, size)
    if message.is_fd or size > 8:  # only an FD frame holds more
        flags = FD | (BRS if message.bitrate_switch else 0) | (ESI if message.error_state_indicator else 0)
    elif message.is_remote_frame:
        identifier |= RTR
        length, size = max(0, min(message.dlc, 8)), 0
        raw = message.dlc if 8 < message.dlc < 16 else 0
    elif message.dlc != size:
        if size < 8 or message.dlc < 8:
            raise Unfit(DATA)
        raw = message.dlc if message.dlc < 16 else 0
    return identifier, flags, length, raw, size
