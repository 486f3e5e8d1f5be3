"""What a capture contains, typed: frames, notes, findings and SDO transfers, in the order in which they came.

Read from the core's JSON lines and never made here: what something means, the core says. Identifiers and bytes are
numbers and bytes; words are in the language of the capture. It must not read, judge or print.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from sys import intern
from typing import Any, Final, Literal, TypeAlias

from canalyze.finding import Finding
from canalyze.problem import Problem, ProblemChange, problem, problem_change
from canalyze.values import ObjectRef, Timed, object_ref


@dataclass(frozen=True, slots=True)
class Frame(Timed):
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
    direction: Literal["rx", "tx"] | None
    """Received or sent by the capturing host, where the capture tells."""
    id: int
    """The CAN identifier (COB-ID), 11 or 29 bits."""
    extended: bool
    """Whether it has 29 bits."""
    remote: bool
    """Whether it is a remote frame (RTR)."""
    fd: bool
    """Whether it is a CAN FD frame."""
    brs: bool
    """Bit rate switch, of CAN FD frames."""
    esi: bool
    """Error state indicator, of CAN FD frames."""
    error: bool
    """Whether it is an error frame of the interface, which was not on the bus as such."""
    length: int
    """Bytes of data; of a remote frame those asked for."""
    data: bytes
    """The data."""
    service: str
    """What it belongs to, by the names of --filter: nmt, sync, emcy, pdo, sdo, heartbeat ..."""
    node: int | None
    """The node-ID, 1 to 127, where a node is concerned."""
    text: str
    """What it means, in words."""
    findings: tuple[str, ...]
    """Codes of the findings raised at it; each follows as a `Finding`."""
    _fields: bytes = field(repr=False)
    """The rest of the core's object: most readers never ask for it, and it is most of the work."""

    @property
    def fields(self) -> Mapping[str, Any]:
        """What the service reads in it, as the object of that name in `decode --format jsonl`."""
        rest: dict[str, Any] = json.loads(b"{" + self._fields.removeprefix(b","))
        return rest.get(self.service) or {}

    def __repr__(self) -> str:
        number = f"{self.id:08X}" if self.extended else f"{self.id:03X}"
        data = f" {self.data.hex(' ').upper()}" if self.data else ""
        return f"<Frame {self.frame}: {number} [{self.length}]{data}: {self.text}>"


@dataclass(frozen=True, slots=True)
class Note:
    """What became known only later, said at the frame that proves it."""

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
    """What it says, in words."""
    facts: Mapping[str, Any]
    """What was measured, by the names of `decode --format jsonl`."""

    def __repr__(self) -> str:
        return f"<Note at frame {self.frame}, about frame {self.about_frame}: {self.text}>"


@dataclass(frozen=True, slots=True)
class Abort:
    """How an SDO transfer was aborted."""

    code: int
    """The SDO abort code (CiA 301 table 22)."""
    by: Literal["client", "server"]
    """Who aborted it."""
    text: str | None
    """What the code means; None for codes that the standard does not have."""

    def __str__(self) -> str:
        return f"{self.code:08X}h by the {self.by}" + (f": {self.text}" if self.text else "")


@dataclass(frozen=True, slots=True)
class Hole:
    """Bytes of a transfer that the capture does not show."""

    offset: int
    """Where they begin in the transfer's data; their end where nothing behind was seen."""
    length: int | None
    """How many they are. None: not known; such a hole takes no room in the data, and what stands behind it has no known
    offset in the object."""


@dataclass(frozen=True, slots=True)
class Transfer(Timed):
    """An SDO or USDO transfer, as far as the capture has it."""

    number: int
    """Number in the capture, from 1, in the order in which transfers begin."""
    bus: str | None
    """The bus, where the capture names it."""
    node: int
    """Node-ID of the server, 1 to 127."""
    client: int | None
    """Node-ID of the client of a USDO transfer (CANopen FD); None for SDO."""
    session: int | None
    """Session-ID of a USDO transfer, 1 to 255; None for SDO."""
    direction: Literal["upload", "download"]
    """upload reads from the server, download writes to it."""
    mode: str
    """expedited, segmented or block."""
    index: str | None
    """Index of the object, four hexadecimal digits; None where its first frame is not in the capture."""
    sub: int | None
    """Its sub-index."""
    name: str | None
    """The object's name, by the description of the node or the standard."""
    type: str | None
    """Its data type, such as UNSIGNED16, where it is known."""
    size_indicated: int | None
    """Bytes as announced, where they were."""
    size: int
    """Bytes that were transferred, up to the last one that was seen; holes of known length count."""
    data: bytes
    """The bytes, the first 65536 of them; 0 in holes."""
    value: int | float | str | bool | None
    """The value by its data type; None for bytes, for unknown types and for transfers that are not ok."""
    text: str | None
    """The value in words."""
    status: Literal["ok", "aborted", "incomplete", "failed"]
    """incomplete: the capture has not all of it, which is no fault."""
    abort: Abort | None
    """How it was aborted, if it was."""
    first_frame: int
    """Its first frame."""
    last_frame: int
    """Its last frame."""
    t: str | None
    """Time of its first frame in seconds, a decimal string with all its digits; None without stamps."""
    duration: float | None
    """Seconds from its first frame to its last; None without stamps."""
    reordered: bool
    """Whether a request was captured after its response."""
    retransmissions: int
    """Segments of a block transfer that were sent again."""
    crc_negotiated: bool | None
    """Whether a block transfer has a CRC; None for other modes."""
    findings: tuple[str, ...]
    """Codes of the findings about it."""
    holes: tuple[Hole, ...] = ()
    """What is missing of its data, by the place: empty where nothing is, or where no byte was seen."""

    @property
    def object(self) -> ObjectRef | None:
        """The object as the standard writes it, 1017h:00; None where it is not known."""
        return object_ref(self.index, self.sub)

    @property
    def duration_ns(self) -> int | None:
        """Nanoseconds from its first frame to its last; None without stamps."""
        return None if self.duration is None else round(self.duration * 1e9)

    def __repr__(self) -> str:
        if self.status == "ok":
            shown = repr(self.value) if self.value is not None else f"{self.size} bytes"
            outcome = f"= {shown}"
        else:
            outcome = f"{self.status} {self.abort.code:08X}h" if self.abort else self.status
        frames = f"frames {self.first_frame}-{self.last_frame}"
        return f"<Transfer {self.number}: node {self.node} {self.direction} {self.object or '?'} {outcome}, {frames}>"


Event: TypeAlias = Frame | Note | Finding | Transfer | ProblemChange
"""Anything that a capture yields, in order; an `ProblemChange` only while it is listened to."""
Record: TypeAlias = Event | Problem | tuple[int, ...]
"""An event, or what is known at the end: incidents, and in which order their roots are read."""


def _frame(row: Mapping[str, Any], rest: bytes) -> Frame:
    """Take a frame's object up to its findings, and what stands behind them."""
    fd, bus = row["fd"], row["bus"]
    return Frame(
        row["frame"],
        row["line"],
        intern(row["file"]),
        row["t"],
        bus and intern(bus),
        row["dir"],
        int(row["id"], 16),
        row["ext"],
        row["rtr"],
        fd is not False,
        bool(fd and fd["brs"]),
        bool(fd and fd["esi"]),
        row["err"],
        row["len"],
        bytes.fromhex(row["data"]),
        intern(row["service"]),
        row["node"],
        row["text"],
        tuple(row["findings"]),
        rest,
    )


def note(row: Mapping[str, Any]) -> Note:
    """Take a note's object."""
    return Note(**{name: row[name] for name in _NOTE})


def transfer(row: Mapping[str, Any]) -> Transfer:
    """Take a transfer's object."""
    abort = row["abort"]
    duration = row["duration"]
    given = {name: row[name] for name in _TRANSFER}
    given["number"] = row["transfer"]
    given["data"] = bytes.fromhex(row["data"] or "")
    given["value"] = _number(row["value"], row["type"])
    given["abort"] = Abort(int(abort["code"], 16), abort["by"], abort["text"]) if abort else None
    given["duration"] = None if duration is None else float(duration)
    given["findings"] = tuple(row["findings"])
    given["holes"] = tuple(Hole(hole["offset"], hole["length"]) for hole in row.get("holes", ()))
    return Transfer(**given)


def _number(value: Any, kind: str | None) -> Any:
    """Give a value; integers beyond 2^53 are strings in JSON."""
    whole = isinstance(value, str) and kind is not None and kind.startswith(("INTEGER", "UNSIGNED"))
    return int(value) if whole else value


_NOTE: Final = tuple(Note.__dataclass_fields__)
_MADE: Final = frozenset({"number", "data", "value", "abort", "duration", "findings", "holes"})
_TRANSFER: Final = tuple(name for name in Transfer.__dataclass_fields__ if name not in _MADE)

_OF_KIND: Final[Mapping[str, Callable[[Mapping[str, Any]], Record]]] = {
    "note": note,
    "finding": Finding.from_json,
    "transfer": transfer,
    "problem": lambda row: problem(row) if row["phase"] == "final" else problem_change(row),
    "diagnosis": lambda row: tuple(row["order"]),
}
"""What makes a record of an object that is no frame's, by its kind."""
_TOGETHER: Final = 256
"""Objects that are read at once: each by itself takes longer, all of them more memory."""
_IS_FRAME: Final = b'{"kind":"frame",'
_FINDINGS: Final = b',"findings":['
"""Stands in a frame's object once: within a text its quotes would be escaped."""


def records(result: bytes) -> Iterator[Record]:
    """Take complete JSON lines of the core."""
    lines = result.splitlines()
    for start in range(0, len(lines), _TOGETHER):
        yield from _together(lines[start : start + _TOGETHER])


def _together(lines: Sequence[bytes]) -> Iterator[Record]:
    heads: list[bytes] = []
    rests: list[bytes] = []
    for line in lines:
        end = line.index(b"]", line.index(_FINDINGS)) + 1 if line.startswith(_IS_FRAME) else -1
        heads.append(line[:end])
        rests.append(line[end:])
    for row, rest in zip(json.loads(b"[" + b"},".join(heads) + b"}]"), rests, strict=True):
        kind = row["kind"]
        yield _frame(row, rest) if kind == "frame" else _OF_KIND[kind](row)


def objects(result: bytes) -> Iterator[dict[str, Any]]:
    """Take complete JSON lines of the core, whatever their kind."""
    lines = result.splitlines()
    for start in range(0, len(lines), _TOGETHER):
        yield from json.loads(b"[" + b",".join(lines[start : start + _TOGETHER]) + b"]")
