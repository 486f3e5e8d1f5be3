"""Frames and the values in them, and everything that a capture yields in the order of its frames."""

from collections.abc import Iterator, Mapping
from sys import intern
from typing import Any, Final, Literal, TypeAlias

from msgspec import Struct, field
from msgspec.json import decode
from msgspec.structs import force_setattr

from canalyze.records import Value, decoder
from canalyze.records.objects import Transfer
from canalyze.records.problems import Finding, Overview, Problem, ProblemChange
from canalyze.values import ObjectRef, Timed


class Fd(Struct, frozen=True, gc=False):
    """The flags of a CAN FD frame."""

    brs: bool
    esi: bool


class Frame(Timed, Struct, frozen=True, gc=False, tag_field="kind", tag="frame"):
    """A frame of the bus, and what it means given everything before it."""

    frame: int
    """Number in the capture, from 1, over all of its files."""
    line: int | None
    """The line of the file, from 1, where its format has lines."""
    file: str
    """The file."""
    t: str | None
    """Time in seconds as the capture has it, a decimal string with all its digits; None without stamps."""
    bus: str | None
    """The bus, where the capture names it."""
    direction: Literal["rx", "tx"] | None = field(name="dir")
    """Received or sent by the capturing host, where the capture tells."""
    _id: str = field(name="id")
    extended: bool = field(name="ext")
    """True if the identifier has 29 bits."""
    remote: bool = field(name="rtr")
    """True for a remote frame (RTR)."""
    _fd: Fd | bool = field(name="fd")
    error: bool = field(name="err")
    """True for an error frame of the interface, which was not on the bus as such."""
    length: int = field(name="len")
    """Bytes of data; of a remote frame those asked for."""
    _data: str = field(name="data")
    service: str
    """The service it belongs to, by the names of --filter: nmt, sync, emcy, pdo, sdo, heartbeat ..."""
    node: int | None
    """The node-ID, 1 to 127, where a node is concerned."""
    text: str
    """The meaning, in words."""
    _rest: bytes = b"}"
    """The end of the object from its findings on: most readers never ask for it, and it is most of the work."""

    @property
    def id(self) -> int:
        """The CAN identifier (COB-ID), 11 or 29 bits."""
        return int(self._id, 16)

    @property
    def data(self) -> bytes:
        """The data."""
        return bytes.fromhex(self._data)

    @property
    def fd(self) -> bool:
        """True for a CAN FD frame."""
        return self._fd is not False

    @property
    def brs(self) -> bool:
        """Bit rate switch, of CAN FD frames."""
        return isinstance(self._fd, Fd) and self._fd.brs

    @property
    def esi(self) -> bool:
        """Error state indicator, of CAN FD frames."""
        return isinstance(self._fd, Fd) and self._fd.esi

    @property
    def findings(self) -> tuple[str, ...]:
        """Codes of the findings raised at it; each follows as a `Finding`."""
        return () if self._rest.startswith(_NO_FINDINGS) else tuple(self._behind.get("findings", ()))

    @property
    def fields(self) -> Mapping[str, Any]:
        """The fields of its service, as the object of that name in `decode --format jsonl`."""
        return self._behind.get(self.service) or {}

    @property
    def _behind(self) -> dict[str, Any]:
        """The rest of the object."""
        return decode(b"{" + self._rest.removeprefix(b","), type=dict[str, Any])

    def __repr__(self) -> str:
        number = f"{self.id:08X}" if self.extended else f"{self.id:03X}"
        data = f" {self.data.hex(' ').upper()}" if self.data else ""
        return f"<Frame {self.frame}: {number} [{self.length}]{data}: {self.text}>"


class Note(Struct, frozen=True, gc=False, tag_field="kind", tag="note"):
    """A fact that became known only later, at the frame that proves it."""

    note: str
    """request_not_captured, lost_by_reset, node_id_changed ..."""
    frame: int
    """The frame that proves it."""
    line: int | None
    """Its line, where the format has lines."""
    about_frame: int
    """The earlier frame that it is about, or the same."""
    about_line: int | None
    """The line of that frame."""
    bus: str | None
    """The bus, where the capture names it."""
    node: int | None
    """The node-ID, where a node is concerned."""
    transfer: int | None
    """The number of the SDO transfer, where one is concerned."""
    text: str
    """The fact, in words."""
    facts: Mapping[str, Any]
    """The measured values, by the names of `decode --format jsonl`."""

    def __repr__(self) -> str:
        return f"<Note at frame {self.frame}, about frame {self.about_frame}: {self.text}>"


class Signal(Timed, Struct, frozen=True, gc=False, tag_field="kind", tag="signal"):
    """One value of one signal."""

    t: str | None
    """Time of the frame in seconds, a decimal string with all its digits; None without stamps."""
    frame: int
    """Number of the frame, from 1."""
    bus: str | None
    """The bus, where the capture names it."""
    node: int
    """Node-ID of the PDO's owner."""
    pdo: str
    """The PDO: TPDO1."""
    signal: str
    """The signal's name, as a line of `decode` has it."""
    value: Value
    """The value with sign, type and factor applied, in `unit`."""
    raw: Value
    """The unsigned number in the payload."""
    unit: str | None
    """The unit, by the description of the device."""
    provenance: str
    """The source of the mapping: observed, option, dcf or eds."""
    index: str
    """Index of the mapped object, four hexadecimal digits."""
    sub: int
    """Its sub-index."""
    text: str | None
    """The value in words."""

    @property
    def object(self) -> ObjectRef:
        """The object as the standard writes it, 6041h:00."""
        return ObjectRef(int(self.index, 16), self.sub)

    def __repr__(self) -> str:
        value = f"{self.value!r} {self.unit}" if self.unit else repr(self.value)
        return f"<Signal {self.node}.{self.pdo}.{self.signal} = {value}, frame {self.frame}>"


Event: TypeAlias = Frame | Note | Finding | Transfer | ProblemChange
"""Anything that a capture yields, in order; a `ProblemChange` only while it is listened to."""

_FRAME: Final = b'{"kind":"frame",'
_CHANGE: Final = b'{"kind":"problem","phase":'
_FINAL: Final = b'{"kind":"problem","phase":"final"'
_FINDINGS: Final = b',"findings":['
"""Stands in a frame's object once: within a text its quotes would be escaped."""
_NO_FINDINGS: Final = _FINDINGS + b"]"


def events(result: bytes) -> Iterator[Event | Problem | Overview]:
    """Yields everything in complete JSON lines of the core, at their end the problems and the overview."""
    frame, change = decoder(Frame), decoder(ProblemChange)
    other = decoder(Note, Finding, Transfer, Problem, Overview)
    end = -1
    while (start := end + 1) < len(result):
        end = result.index(b"\n", start)
        if result.startswith(_FRAME, start):
            rest = result.index(_FINDINGS, start, end)
            one: Frame = frame(result[start:rest] + b"}")
            # There are few different words, and each frame has its own copy.
            force_setattr(one, "file", intern(one.file))
            force_setattr(one, "service", intern(one.service))
            if one.bus is not None:
                force_setattr(one, "bus", intern(one.bus))
            force_setattr(one, "_rest", result[rest:end])
            yield one
        elif result.startswith(_CHANGE, start) and not result.startswith(_FINAL, start):
            yield change(result[start:end])
        else:
            yield other(result[start:end])
