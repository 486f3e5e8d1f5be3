"""Compares the configurations of devices in two captures or descriptions, object by object.

A capture shows only a part of a device: an object that it does not show need not be missing, but one written in
one capture and never in the other is a difference. A description contains all of its objects. Volatile objects are
reported separately with a reason, unless they were configured. Must not: read a file, or write words.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, Final, Literal, NamedTuple

from canalyze.dictionary import CODES, Address, Dictionary, Entry, comparable, packed
from canalyze.records import records
from canalyze.records.objects import Head, Object

Nature = Literal["state", "history", "time", "command", "serial", "process", "set-point"]

_BATTERY: Final[dict[Nature, str]] = {
    "state": "6000-6001 6090",
    "process": "6010 6050-6054 6060 6070 6080-6081",
    "serial": "6030-6031 6040-6041",
}
_TABLE: Final[dict[int, dict[Nature, str]]] = {
    0: {
        "state": "1001-1002 1F57",
        "history": "1003",
        "time": "1013 1020",
        "command": "1010-1011 1023-1026 1F25 1F50-1F51 1F82-1F83",
    },
    401: {
        "process": "6000 6020-6027 6100 6120 6400-6403",
        "set-point": "6200 6220-6227 6300 6320 6410-6413",
        "state": "6422",
    },
    402: {
        "state": "603F 6041 6061 60B9",
        "command": "6040",
        "process": "6043 6044 6053 6054 6062-6064 6069 606B 606C 6074 6077-6079"
        " 60BA-60BD 60D1-60D8 60F4 60FA 60FC 60FD",
        "set-point": "6042 6071 607A 60C1 60FE-60FF",
    },
    404: {"process": "6100 6130 6140", "state": "6150"},
    406: {
        "process": "6004 6008 600C 6020 6030 6040 6050",
        "state": "6300 6400 6500 6503 6505",
        "time": "6508",
        "serial": "650B",
    },
    410: {"process": "6010 6020 6110 6120"},
    418: _BATTERY,
    419: _BATTERY,
}
"""By profile, 0 for all devices: indices, and ranges of them, in hexadecimal."""
_PROFILES: Final = range(0x6000, 0xA000)
_SERIAL_NUMBER: Final = (0x1018, 4)
_AXIS: Final = 0x800
"""Distance between the objects of two axes of a drive."""


def standard_nature(address: Address, profile: int) -> Nature | None:
    """Returns the reason for which an object's value is no configuration; None if it may be.

    profile: that of the device; with 0 (unknown) its objects are read as those of a drive.
    """
    index = address[0]
    if address == _SERIAL_NUMBER:
        return "serial"
    if index not in _PROFILES:
        return _natures(0).get(index)
    if profile in (0, 402):
        return _natures(402).get(_PROFILES[index % _AXIS])
    return _natures(profile).get(index)


@cache
def _natures(profile: int) -> dict[int, Nature]:
    found: dict[int, Nature] = {}
    for nature, spans in _TABLE.get(profile, {}).items():
        for span in spans.split():
            first, _, last = span.partition("-")
            found |= dict.fromkeys(range(int(first, 16), int(last or first, 16) + 1), nature)
    return found


Reason = Nature | Literal["pdo", "read-only", "varies", "unknown", "unseen"]
"""Reasons for which a difference does not count.

pdo: PDOs carry the value; varies: it changed without a write; unknown: one side has no value; unseen: the capture
does not show it.
"""

_DESCRIBES: Final = (range(0x1000, 0x1001), range(0x1008, 0x100B), range(0x1018, 0x1019))
"""Read-only objects that identify the device."""
_COB_IDS: Final = (
    (range(0x1005, 0x1006), (0,)),
    (range(0x1012, 0x1013), (0,)),
    (range(0x1014, 0x1015), (0,)),
    (range(0x1200, 0x1300), (1, 2)),
    (range(0x1301, 0x1341), (5, 6)),
    (range(0x1400, 0x1600), (1,)),
    (range(0x1800, 0x1A00), (1,)),
)
IDENTIFIER: Final = 0x1FFF_FFFF
"""The bits of the CAN-ID in a COB-ID."""
_NODE: Final = 0x7F


class Held(NamedTuple):
    """An object as one side knows it."""

    name: str
    kind: int
    """The code of its type; 0 if neither a description nor a standard defines it."""
    data: bytes | None
    """Its value as it is transferred; None if it is unknown or incomplete."""
    configured: bool
    """True if it was written and accepted, or is the ParameterValue of a file."""
    exists: bool = True
    """False if the device has reported that there is no such object."""
    changes: Reason | None = None
    """The reason for which its value is no configuration unless it was written, as far as this side knows."""
    commanded: bool = False
    """True if RPDOs write it."""
    refused: bool = False
    """True if the device has refused to have it read or written."""


class Node(NamedTuple):
    """A node as one side knows it."""

    bus: str | None
    node: int | None
    """None for a description without a node-ID."""
    profile: int
    objects: Mapping[Address, Held]


class Side(NamedTuple):
    """A capture or a description."""

    nodes: Sequence[Node]
    form: str
    """capture, or the form of a description."""

    @property
    def whole(self) -> bool:
        """True if an object that is not there is missing."""
        return self.form not in ("capture", "concise")


class Difference(NamedTuple):
    """An object that differs."""

    address: Address
    held: tuple[Held | None, Held | None]
    reason: Reason | None
    """The reason for which it does not count, if any."""


class Pair(NamedTuple):
    """A node on both sides."""

    nodes: tuple[Node, Node]
    differences: list[Difference]
    """By index and sub-index."""
    compared: int
    """Objects whose values were compared."""


class Compared(NamedTuple):
    """The result of comparing two sides."""

    sides: tuple[Side, Side]
    pairs: list[Pair]
    alone: tuple[list[Node], list[Node]]
    """Nodes that only one of them has."""


def captured(result: bytes) -> Side:
    """Returns the nodes of a capture."""
    nodes: list[Node] = []
    objects: dict[Address, Held] = {}
    found: Iterator[Head | Object] = records(result, Head, Object)
    for one in found:
        if isinstance(one, Head):
            objects = {}
            nodes.append(Node(one.bus, one.node, one.profile or 0, objects))
        else:
            objects[one.address] = _seen(one)
    return Side(nodes, "capture")


def compare(both: Sequence[Side | Dictionary], chosen: tuple[int, int] | None, *, filtered: bool) -> Compared:
    """Compares A and B.

    chosen: only this node of A with that node of B. filtered: captures show selected objects only. A description
    without a node-ID is of the chosen node, or else of the only one of the other side.
    """
    known = [[node.node for node in one.nodes] if isinstance(one, Side) else [one.node] for one in both]
    wanted = chosen or (None, None)
    sides = []
    for one, want, others in zip(both, wanted, reversed(known), strict=True):
        only = others[0] if len(others) == 1 else None
        sides.append(one if isinstance(one, Side) else _described(one, want or one.node or only))
    left, right = sides
    pairs, alone = _pairs(left, right, wanted)
    strict = not filtered or all(side.form == "capture" for side in sides)
    compared = [_pair(one, (left.whole, right.whole), strict) for one in pairs]
    return Compared((left, right), compared, alone)


def relative(address: Address, data: bytes, node: int | None) -> int | None:
    """Returns a COB-ID without the node-ID that it contains; None if it is no COB-ID, or does not contain it."""
    if node is None or not any(address[0] in indices and address[1] in subs for indices, subs in _COB_IDS):
        return None
    number = int.from_bytes(data, "little")
    return number - node if number & _NODE == node and _NODE < number & IDENTIFIER < 0x800 else None


def _described(found: Dictionary, node: int | None) -> Side:
    """Returns the node of a description."""
    carried = {(one.index, one.sub): pdo.direction for pdo in found.pdos if pdo.cob_id.valid for one in pdo.mapped}
    objects = {
        (entry.index, entry.sub): _entry(entry, node, carried.get((entry.index, entry.sub)))
        for thing in found.objects
        for entry in thing.entries
    }
    kind = objects.get((0x1000, 0))
    profile = int.from_bytes(kind.data[:2], "little") if kind and kind.data else 0
    return Side([Node(None, node, profile, objects)], found.form)


def _seen(one: Object) -> Held:
    written = one.configured
    data = None if written is None else written.whole
    if written is None and one.data is not None and len(one.data) * 8 >= (one.bits or 0):
        data = one.data
    changes: tuple[tuple[Any, Reason], ...] = (
        (one.tpdo, "pdo"),
        (one.writable is False and not _describes(one.address[0]), "read-only"),
        (one.varies, "varies"),
    )
    return Held(
        one.name or "",
        CODES.get(one.type or "", 0) if one.type_from != "inferred" else 0,
        data,
        bool(written),
        one.exists is not False,
        next((reason for holds, reason in changes if holds), None),
        one.rpdo > 0,
        one.refused > 0,
    )


def _entry(entry: Entry, node: int | None, carried: str | None) -> Held:
    readable = entry.access in ("ro", "const")
    fixed = readable and not _describes(entry.index) and not _is_of_pdo(entry.index)
    return Held(
        entry.name,
        entry.type,
        None if entry.value is None else packed(entry.value, entry.type, node or 0),
        entry.parameter is not None and not readable,
        changes="pdo" if carried == "tpdo" else "read-only" if fixed else None,
        commanded=carried == "rpdo",
    )


def _describes(index: int) -> bool:
    return any(index in indices for indices in _DESCRIBES)


def _is_of_pdo(index: int) -> bool:
    """Returns true for a parameter of a PDO, whose fixed values are part of the configuration, too."""
    return 0x1400 <= index < 0x1C00


def _pairs(
    a: Side, b: Side, wanted: tuple[int | None, int | None]
) -> tuple[list[tuple[Node, Node]], tuple[list[Node], list[Node]]]:
    """Returns the nodes to compare: same node-ID and bus, or else the only ones of that node-ID."""
    left, right = (
        [one for one in side.nodes if want is None or one.node == want]
        for side, want in zip((a, b), wanted, strict=True)
    )
    if len(left) == len(right) == 1:
        return [(left[0], right[0])], ([], [])
    found = []
    for buses in (True, False):
        for one in list(left):
            partners = [two for two in right if two.node == one.node and not (buses and two.bus != one.bus)]
            if len(partners) == 1:
                found.append((one, partners[0]))
                left.remove(one)
                right.remove(partners[0])
    # A description is of one node, and so is what was chosen: what else there is, the other side does not lack.
    if wanted != (None, None) or not a.form == b.form == "capture":
        left, right = [], []
    return found, (left, right)


def _pair(nodes: tuple[Node, Node], whole: tuple[bool, bool], strict: bool) -> Pair:
    differences = []
    compared = 0
    a, b = nodes
    profile = a.profile or b.profile
    ids = (None, None) if a.node == b.node else (a.node, b.node)
    for address in sorted(set(a.objects) | set(b.objects)):
        held = a.objects.get(address), b.objects.get(address)
        one, two = held
        known = [side is not None and side.exists and side.data is not None for side in held]
        if one and two and all(known):
            compared += 1
            kind = one.kind or two.kind
            if _meaning(address, one, kind, ids[0]) == _meaning(address, two, kind, ids[1]):
                continue
        if one and two and not any(known) and one.exists == two.exists:
            continue
        if not any(side and side.exists for side in held):
            continue
        differences.append(Difference(address, held, _reason(address, held, whole, profile, strict)))
    return Pair(nodes, differences, compared)


def _reason(
    address: Address, held: tuple[Held | None, Held | None], whole: tuple[bool, bool], profile: int, strict: bool
) -> Reason | None:
    """Returns the reason for which a difference does not count; None if it counts."""
    there = [side for side in held if side]
    nature = standard_nature(address, profile)
    if len(there) == 1:
        missing = whole[held.index(None)] or (there[0].configured and strict and nature is None)
        return None if missing else "unseen"
    if not all(side.exists for side in there):
        return None
    if nature is not None:
        return nature
    if any(side.commanded for side in there):
        return "pdo"
    unknown = [place for place, side in enumerate(held) if side and side.data is None]
    if unknown:
        # A missing value means nothing in a description, and "not configured" in a capture.
        only = len(unknown) == 1 and not whole[unknown[0]] and not there[unknown[0]].configured
        return None if only and there[1 - unknown[0]].configured else "unknown"
    if any(side.configured for side in there):
        return None
    return next((side.changes for side in there if side.changes), None)


def _meaning(address: Address, held: Held, kind: int, node: int | None) -> object:
    """Returns the value of an object for comparison. node: removed from a COB-ID, unless None."""
    data = held.data or b""
    base = relative(address, data, node)
    return comparable(data, kind) if base is None else ("relative", base)
