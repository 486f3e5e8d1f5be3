"""Compares a description with a device in the traffic, object by object.

It is not decided which of the two is wrong. Properties that the traffic cannot show are no difference: an object
that was not accessed, a type of the same size, a value that was written before it was read. Must not: read a file
or a capture, or put anything into words.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Final, NamedTuple

from canalyze import _core
from canalyze.dictionary import (
    ARRAY,
    BYTES,
    NAMES,
    RECORD,
    Address,
    Dictionary,
    Entry,
    NodeOffset,
    Value,
    comparable,
    decoded,
    packed,
)
from canalyze.errors import SourceError
from canalyze.records import records
from canalyze.records.objects import Head, Object, Pdo

ERROR, WARNING, INFO = "error", "warning", "info"
SEVERITIES: Final = {
    "identity": ERROR,
    "absent": ERROR,
    "size": ERROR,
    "device-type": WARNING,
    "revision": WARNING,
    "not-readable": WARNING,
    "not-writable": WARNING,
    "readable": WARNING,
    "writable": WARNING,
    "mapping": WARNING,
    "pdo-length": WARNING,
    "mappable": WARNING,
    "limits": WARNING,
    "parameter": WARNING,
    "unlisted": WARNING,
    "default": INFO,
    "unseen": INFO,
}
"""The kinds of differences, worst first, and their severities."""

_FIRST_OBJECT: Final = 0x1000
_STRUCTURE: Final = 0xFF
"""Sub-index that a device may offer at any index and that descriptions do not list."""
_ABSENT: Final = frozenset({"06020000", "06090011"})
_UNSET: Final = frozenset({None, 0, 0xFFFFFFFF})
"""Identity values of templates."""
_DEVICE_TYPE, _IDENTITY = 0x1000, 0x1018
_PROFILE: Final = 0xFFFF
_IDENTIFYING: Final = ((_DEVICE_TYPE, 0), (_IDENTITY, 1), (_IDENTITY, 2), (_IDENTITY, 3))
"""Device type, vendor-ID, product code, revision number."""
_COMMUNICATION: Final = range(0x1000, 0x2000)
_MOST_MAPPED: Final = 64
_PDO_PARAMETERS: Final = range(0x1400, 0x1C00)
_OF_MAPPINGS: Final = (range(0x1600, 0x1800), range(0x1A00, 0x1C00))
_CHANGING: Final = frozenset(
    {_DEVICE_TYPE, 0x1001, 0x1002, 0x1003, 0x1010, 0x1011, 0x1013, _IDENTITY, 0x1020, *range(0x1023, 0x1027)}
    | set(range(0x1F50, 0x1F60))
)
"""Objects of CiA 301 and 302 with an insignificant default: states, counters, commands, device-specific data."""


class Difference(NamedTuple):
    """One property in which description and traffic disagree."""

    kind: str
    """A key of SEVERITIES."""
    severity: str
    index: int  # type: ignore[assignment]  # of a tuple it is a method
    sub: int | None
    """None is the whole object."""
    name: str
    filed: str
    """The value in the description, the same in all languages; empty if it has none."""
    shown: str
    """The value in the traffic."""
    frame: int | None
    """A frame that shows it."""


class Comparison(NamedTuple):
    """A description compared with a device."""

    bus: str | None
    node: int
    differences: tuple[Difference, ...]
    """Worst first, then by address."""
    seen: int
    """Number of objects of the description that occur in the traffic."""
    unseen: tuple[Address, ...]
    """Those that do not."""


class _Case(NamedTuple):
    """An object in both the description and the traffic."""

    entry: Entry
    seen: Object
    node: int
    structural: bool
    """True if it is the number of sub-indices."""
    carried: bool
    """True if it is mapped to a PDO of the description."""

    @property
    def width(self) -> int:
        """Its size in bytes; 0 for a type without a fixed size."""
        return -(-(_core.DATA_TYPES.get(self.entry.type, ("", None))[1] or 0) // 8)

    def says(self, kind: str, filed: object, shown: object) -> Iterator[Difference]:
        """Yields a difference."""
        yield _difference(kind, (self.entry.index, self.entry.sub), self.entry.name, filed, shown, self.seen)


def device(result: bytes, found: Dictionary) -> tuple[str | None, int]:
    """Returns bus and node-ID of the device: the description's node, or else the only one. Raises SourceError."""
    nodes = [(one.bus, one.node) for one in records(result, Head)]
    senders = [(one.bus, one.node) for one in records(result, Pdo)]
    there = nodes or list(dict.fromkeys(senders))
    if found.node is not None:
        there = [one for one in dict.fromkeys([*there, *senders]) if one[1] == found.node]
        if not there:
            raise SourceError("against.no_node", name=found.file, node=found.node)
    if not there:
        raise SourceError("against.nothing", name=found.file)
    if len(there) > 1:
        several = len({bus for bus, _ in there}) > 1
        listed = ", ".join(f"{node} {bus}" if several else str(node) for bus, node in there)
        raise SourceError("against.which", name=found.file, nodes=listed)
    return there[0]


def compared(found: Dictionary, result: bytes, bus: str | None, node: int, *, unseen: bool = False) -> Comparison:
    """Compares a description with the device of this node-ID on this bus.

    unseen: objects that do not occur in the traffic are differences, too.
    """
    seen = {one.address: one for one in records(result, Object) if (one.bus, one.node) == (bus, node)}
    entries = {(entry.index, entry.sub): entry for thing in found.objects for entry in thing.entries}
    structural = {thing.index for thing in found.objects if thing.code in (ARRAY, RECORD)}
    carried = {(mapped.index, mapped.sub) for pdo in found.pdos for mapped in pdo.mapped}
    differences = [*_identity(found, entries, seen)]
    for address, one in seen.items():
        entry = entries.get(address)
        if entry is not None:
            whole = address[1] == 0 and address[0] in structural
            case = _Case(entry, one, node, whole, address in carried)
            differences += _of_object(case)
        elif one.exists and address[0] >= _FIRST_OBJECT and address[1] != _STRUCTURE and address not in carried:
            shown = "sub-index" if found.object(address[0]) else "index"
            differences.append(_difference("unlisted", address, one.name or "", "", shown, one))
    booted = any(one.booted for one in records(result, Head) if (one.bus, one.node) == (bus, node))
    by_id = {(one.id, one.extended): one for one in records(result, Pdo) if one.bus == bus}
    for pdo in found.pdos:
        differences += _mapping(found, pdo, node, seen)
        differences += _length(pdo, node, seen, by_id, booted=booted)
    missing = [address for address in entries if address not in seen and address[0] >= _FIRST_OBJECT]
    if unseen:
        differences += [_difference("unseen", address, entries[address].name, "", "", None) for address in missing]
    order = list(SEVERITIES)
    differences.sort(key=lambda one: (_rank(one), order.index(one.kind), one.index, one.sub or 0))
    return Comparison(bus, node, tuple(differences), len(entries.keys() & seen.keys()), tuple(missing))


def _rank(one: Difference) -> int:
    return (ERROR, WARNING, INFO).index(one.severity)


def _difference(
    kind: str, address: tuple[int, int | None], name: str, filed: object, shown: object, seen: Object | None
) -> Difference:
    frame = None
    if seen is not None:
        aborted = (one.frame for one in seen.aborts if one.code in str(shown))
        first = seen.first.frame if kind == "default" and seen.first else None
        frame = first or next(aborted, None) or seen.frame or seen.last_frame
    return Difference(kind, SEVERITIES[kind], *address, name, str(filed), str(shown), frame)


def _identity(
    found: Dictionary, entries: Mapping[Address, Entry], seen: Mapping[Address, Object]
) -> Iterator[Difference]:
    """Compares the identity. Vendor, product and revision may be in two places of a file; either may match."""
    of = found.device
    numbers = (None, of.vendor_number, of.product_number, of.revision_number)
    for address, number in zip(_IDENTIFYING, numbers, strict=True):
        entry, one = entries.get(address), seen.get(address)
        data = (one and one.data) or b""
        both = (entry and entry.value, number)
        said = [value for value in both if isinstance(value, int) and value not in _UNSET]
        shown = int.from_bytes(data, "little")
        if len(data) != 4 or not said or shown in both:
            continue
        kind = "revision" if address == (_IDENTITY, 3) else "identity"
        if address == (_DEVICE_TYPE, 0) and any(shown & _PROFILE == value & _PROFILE for value in said):
            kind = "device-type"
        made = _difference(kind, address, entry.name if entry else "", f"{said[0]:08X}h", f"{shown:08X}h", one)
        # Another minor revision behaves alike (CiA 301, 7.5.2.19).
        minor = kind == "revision" and any(shown >> 16 == value >> 16 for value in said)
        yield made._replace(severity=INFO) if minor else made


def _of_object(case: _Case) -> Iterator[Difference]:
    if case.seen.exists is False:
        codes = sorted({one.code for one in case.seen.aborts} & _ABSENT)
        yield from case.says("absent", "", ", ".join(f"{code}h" for code in codes))
        return
    for judge in _JUDGES:
        yield from judge(case)


def _size(case: _Case) -> Iterator[Difference]:
    """Compares the size; sizes read have precedence, because a device may accept longer values than its object."""
    sizes = case.seen.sizes
    least, most = sizes.read or sizes.written or (case.width, case.width)
    if case.width and (least, most) != (case.width, case.width):
        yield from case.says("size", NAMES[case.entry.type], least if least == most else f"{least}-{most}")


def _access(case: _Case) -> Iterator[Difference]:
    access, seen = case.entry.access, case.seen
    if access == "wo" and seen.read:
        yield from case.says("readable", access, seen.read)
    if access in ("ro", "const") and seen.written:
        yield from case.says("writable", access, seen.written)
    if access != "wo" and seen.readable is False:
        yield from case.says("not-readable", access, "06010001h")
    if access not in ("ro", "const") and seen.writable is False:
        # Parameters of a PDO that is in use may be refused so, too.
        state = INFO if case.entry.index in _PDO_PARAMETERS else WARNING
        yield from (one._replace(severity=state) for one in case.says("not-writable", access, "06010002h"))


def _mappable(case: _Case) -> Iterator[Difference]:
    pdos = [name for name in ("tpdo", "rpdo") if getattr(case.seen, name)]
    if pdos and not case.entry.mappable and not case.carried:
        yield from case.says("mappable", "", pdos[0].upper())


def _limits(case: _Case) -> Iterator[Difference]:
    low, high, default = case.entry.low, case.entry.high, case.entry.value
    least, most = (float("-inf") if low is None else low), (float("inf") if high is None else high)
    template = (low, high) == (0, 0) or least > most
    own = isinstance(default, int | float) and not least <= default <= most
    if template or own:  # no real limits
        return
    values = (decoded(data, case.entry.type) for data in case.seen.extremes)
    beyond = [value for value in values if isinstance(value, int | float) and (value < least or value > most)]
    whole = all(len(data) == case.width for data in case.seen.extremes)
    if beyond and whole:
        filed = f"{'' if low is None else low}..{'' if high is None else high}"
        yield from case.says("limits", filed, ", ".join(map(str, sorted(beyond))))


def _value(case: _Case) -> Iterator[Difference]:
    """Compares the value: a DCF's parameter with the current value, a default with the first value after a boot."""
    entry, seen = case.entry, case.seen
    if _is_of_mapping(entry.index) or (entry.index, entry.sub) in _IDENTIFYING or not _is_configuration(case):
        return
    if entry.parameter is not None:
        if seen.source in ("read", "written") and seen.data is not None:
            yield from _other(case, "parameter", entry.parameter, seen.data, (seen.bits or 0) // 8)
    elif entry.default is not None and seen.first and seen.first.booted:
        yield from _other(case, "default", entry.default, seen.first.data, seen.first.size)


def _is_configuration(case: _Case) -> bool:
    """Returns true if the value of an object is configured, and not an actual value or process data."""
    entry, seen = case.entry, case.seen
    if entry.index in _CHANGING or case.carried or seen.tpdo or seen.rpdo:
        return False
    return entry.access != "ro" or case.structural or entry.index in _COMMUNICATION


def _other(case: _Case, kind: str, filed: Value, data: bytes, size: int) -> Iterator[Difference]:
    entry = case.entry
    if len(data) != size or case.width not in (0, size) or entry.type in BYTES:
        return  # its size differs, or a part of it is missing
    known = packed(filed, entry.type, case.node), data
    one, other = (decoded(value, entry.type) for value in known)
    if None not in (one, other) and len({comparable(value, entry.type) for value in known}) > 1:
        yield from case.says(kind, _spelled(one, entry), _spelled(other, entry))


def _spelled(value: object, entry: Entry) -> str:
    """Returns a value as text: an UNSIGNED32 of the communication profile in hexadecimal, text in quotes."""
    if isinstance(value, str):
        return f'"{value.strip()}"'
    word = entry.index in _COMMUNICATION and NAMES.get(entry.type) == "UNSIGNED32" and isinstance(value, int)
    return f"{value:08X}h" if word else str(value)


_JUDGES: Final[tuple[Callable[[_Case], Iterator[Difference]], ...]] = (_size, _access, _mappable, _limits, _value)


def _is_of_mapping(index: int) -> bool:
    return any(index in one for one in _OF_MAPPINGS)


def _mapping(found: Dictionary, pdo: _core.Pdo, node: int, seen: Mapping[Address, Object]) -> Iterator[Difference]:
    """Compares the mapping of a PDO as a whole; only entries in the traffic count."""
    index = _core.mapping_parameter(pdo.direction, pdo.number)
    thing = found.object(index)
    if thing is None:
        return
    filed, shown, booted = {}, {}, True
    for entry in thing.entries:
        one = seen.get((index, entry.sub))
        value = entry.value.at(node) if isinstance(entry.value, NodeOffset) else entry.value
        if isinstance(value, int):
            filed[entry.sub] = value
        if one is None:
            continue
        if entry.parameter is not None:
            data = one.data if one.source in ("read", "written") else None
        else:
            data = None if one.first is None else one.first.data
            booted = booted and one.first is not None and one.first.booted
        if data:
            shown[entry.sub] = int.from_bytes(data, "little")
    most = filed.get(0, 0)
    if filed.get(0) != shown.get(0, filed.get(0)):
        differs = 0 in filed
    else:
        differs = any(shown[sub] != filed[sub] for sub in shown if 0 < sub <= most and sub in filed)
    if differs:
        count = shown.get(0, most)
        first = next(iter(one for (at, _), one in seen.items() if at == index))
        made = _difference("mapping", (index, None), thing.name, _mapped(filed, most), _mapped(shown, count), first)
        yield made if booted else made._replace(severity=INFO)


def _mapped(words: Mapping[int, int], count: int) -> str:
    """Returns the entries of a mapping as text: object and bits each, "?" for an unknown one."""
    if count > _MOST_MAPPED:
        return str(count)  # such as that of an MPDO
    known = (words.get(sub) for sub in range(1, count + 1))
    return ", ".join("?" if w is None else f"{w >> 16:04X}h:{w >> 8 & 255:02X}/{w & 255}" for w in known) or "0"


def _length(
    pdo: _core.Pdo, node: int, seen: Mapping[Address, Object], by_id: Mapping[tuple[int, bool], Pdo], *, booted: bool
) -> Iterator[Difference]:
    """Compares the length of a PDO with the file's mapping, unless the traffic shows a mapping.

    A receiver accepts more than its mapping.
    """
    index = _core.mapping_parameter(pdo.direction, pdo.number)
    known = any(one.values or one.unconfirmed for (at, _), one in seen.items() if at == index)
    cob = seen.get((pdo.communication, 1))
    can_id = pdo.cob_id.at(node)
    one = by_id.get((can_id, pdo.cob_id.extended)) if can_id is not None else None
    if known or cob is not None or one is None or not pdo.cob_id.valid or not pdo.bits or pdo.multiplex:
        return
    mapped, length = -(-pdo.bits // 8), one.length_max
    if one.length_min != length or length == mapped or (pdo.direction == "rpdo" and length > mapped):
        return
    made = _difference("pdo-length", (index, None), f"{pdo.direction.upper()}{pdo.number}", mapped, length, None)
    yield made if booted else made._replace(severity=INFO)
