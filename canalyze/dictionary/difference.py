"""Configurations of devices, of two captures or descriptions -> in what they differ, object by object.

What a capture shows is a part of what a device has: an object that it does not show need not be missing, but what was
written in the one and never in the other is a difference. A description has all of its objects. What changes by nature
is set apart, with the reason, unless somebody has configured it. Must not: read a file, or write words.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, Literal, NamedTuple

from canalyze.dictionary.model import Address, Dictionary, Entry
from canalyze.dictionary.nature import Nature, standard_nature
from canalyze.dictionary.values import BYTES, CODES, REAL, SIGNED, STRINGS, packed
from canalyze.records import records
from canalyze.records.inventory import Head, Object

Reason = Nature | Literal["pdo", "read-only", "varies", "unknown", "unseen"]
"""Why a difference does not count; pdo: PDOs carry the value; varies: it changed though nobody wrote it; unknown: no
value is known of it on one side; unseen: the capture does not show it."""

_DESCRIBES: Final = (range(0x1000, 0x1001), range(0x1008, 0x100B), range(0x1018, 0x1019))
"""What can only be read, and says which device it is."""
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
"""Of a COB-ID the bits of the CAN-ID."""
_NODE: Final = 0x7F


class Held(NamedTuple):
    """What one side knows of an object."""

    name: str
    kind: int
    """Code of its type, 0 where neither a description nor a standard has one."""
    data: bytes | None
    """Its value as it is transferred; None where it is not known, or not all of it."""
    configured: bool
    """It was written and accepted, or is the ParameterValue of a file."""
    exists: bool = True
    """The device has not said that there is no such object."""
    changes: Reason | None = None
    """Why its value says nothing of the configuration, as far as this side knows, unless somebody has configured it."""
    commanded: bool = False
    """RPDOs write it."""
    refused: bool = False
    """The device has refused to have it read or written."""


class Node(NamedTuple):
    """What one side knows of a node."""

    bus: str | None
    node: int | None
    """None: a description that says of no node."""
    profile: int
    objects: Mapping[Address, Held]


class Side(NamedTuple):
    """A capture or a description."""

    nodes: Sequence[Node]
    form: str
    """capture, or the form of a description."""

    @property
    def whole(self) -> bool:
        """Whether an object that is not there is missing."""
        return self.form not in ("capture", "concise")


class Difference(NamedTuple):
    """An object that differs."""

    address: Address
    held: tuple[Held | None, Held | None]
    reason: Reason | None
    """Why it does not count."""


class Pair(NamedTuple):
    """A node on both sides."""

    nodes: tuple[Node, Node]
    differences: list[Difference]
    """By index and sub-index."""
    compared: int
    """Objects whose values were compared."""


class Compared(NamedTuple):
    """Two sides, and how they compare."""

    sides: tuple[Side, Side]
    pairs: list[Pair]
    alone: tuple[list[Node], list[Node]]
    """Nodes that only one of them has."""


def captured(result: bytes) -> Side:
    """Take what a capture has shown."""
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
    """Compare A and B. chosen: only this node of A with that node of B. filtered: captures show chosen objects only.

    A description that says of no node is of the chosen one, else of the only one that the other side has.
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
    """Give a COB-ID without the node-ID that it contains; None where it is no COB-ID, or contains it not."""
    number = int.from_bytes(data, "little")
    holds = any(address[0] in indices and address[1] in subs for indices, subs in _COB_IDS)
    contains = node is not None and number & _NODE == node and _NODE < number & IDENTIFIER < 0x800
    return number - (node or 0) if holds and contains else None


def _described(found: Dictionary, node: int | None) -> Side:
    """Take what a description says of a node."""
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
    """Tell whether it is a parameter of a PDO: a fixed one is part of the configuration, too."""
    return 0x1400 <= index < 0x1C00


def _pairs(
    a: Side, b: Side, wanted: tuple[int | None, int | None]
) -> tuple[list[tuple[Node, Node]], tuple[list[Node], list[Node]]]:
    """Settle which nodes are compared: the same node-ID on the same bus, else wherever there is one of that node-ID."""
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
    """Tell why a difference does not count; None where it does."""
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
        # A description without a value says nothing; a capture, that nobody has configured it.
        only = len(unknown) == 1 and not whole[unknown[0]] and not there[unknown[0]].configured
        return None if only and there[1 - unknown[0]].configured else "unknown"
    if any(side.configured for side in there):
        return None
    return next((side.changes for side in there if side.changes), None)


def _meaning(address: Address, held: Held, kind: int, node: int | None) -> object:
    """Give what is equal where two values are, by one type. node: a COB-ID counts without it; None: as it is."""
    data = held.data or b""
    if kind in STRINGS:
        return data.rstrip(b"\0")
    if kind in BYTES or kind in REAL or len(data) > 8:
        return data
    base = relative(address, data, node)
    return int.from_bytes(data, "little", signed=kind in SIGNED) if base is None else ("relative", base)
