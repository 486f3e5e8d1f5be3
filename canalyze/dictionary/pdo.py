"""The objects of PDOs -> the PDO table. The one place in Python that knows object layouts and COB-ID arithmetic.

Communication parameters 1400h to 15FFh and 1800h to 19FFh, mapping parameters 1600h to 17FFh and 1A00h to 1BFFh
(CiA 301 7.5.2.35 to 7.5.2.38). Only what a description says is settled here; frames are the core's.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Final, Literal

from canalyze.configuration.network import MOST_PDOS
from canalyze.dictionary.model import CobId, Direction, Entry, Mapped, NodeOffset, Object, Pdo, Value
from canalyze.dictionary.values import UNSIGNED, UNSIGNED8, UNSIGNED32, WIDTHS

_PREDEFINED: Final = 4
_COMMUNICATION: Final[dict[Direction, int]] = {"rpdo": 0x1400, "tpdo": 0x1800}
_TO_MAPPING: Final = 0x200
_FIRST_ID: Final[dict[Direction, int]] = {"rpdo": 0x200, "tpdo": 0x180}
_STEP: Final = 0x100

_INVALID: Final = 1 << 31
_NO_RTR: Final = 1 << 30
_EXTENDED: Final = 1 << 29
_ID: Final = (1 << 29) - 1
_STANDARD_ID: Final = (1 << 11) - 1

_LONGEST: Final = 64
"""Bits of a payload."""
_MULTIPLEX: Final[dict[int, Literal["sam", "dam"]]] = {254: "sam", 255: "dam"}
"""Values of sub 0 of a mapping parameter."""
_DUMMIES_END: Final = 0x20
"""Indices below are data types."""

_SUBS: Final = (
    ("COB-ID", UNSIGNED32),
    ("Transmission type", UNSIGNED8),
    ("Inhibit time", 0x06),
    ("Compatibility entry", UNSIGNED8),
    ("Event timer", 0x06),
    ("SYNC start value", UNSIGNED8),
)
"""Subs 1 to 6 of a communication parameter."""

Complain = Callable[..., None]


def cob_id(value: Value | None, number: int, direction: Direction) -> CobId:
    """Take a COB-ID entry apart; one that the file does not have is what the pre-defined connection set says."""
    if isinstance(value, NodeOffset):
        bits, relative = value.offset, True
    elif isinstance(value, int):
        bits, relative = value, False
    elif number <= _PREDEFINED:
        return CobId(True, True, False, _FIRST_ID[direction] + _STEP * (number - 1), relative=True, assumed=True)
    else:
        return CobId(False, True, False, 0, relative=False, assumed=True)
    extended = bool(bits & _EXTENDED)
    identifier = bits & (_ID if extended else _STANDARD_ID)
    return CobId(not bits & _INVALID, not bits & _NO_RTR, extended, identifier, relative)


def table(objects: Mapping[int, Object], dummies: frozenset[int], complain: Complain) -> tuple[Pdo, ...]:
    """Give the PDOs of all communication parameters."""
    found = []
    for direction, first in _COMMUNICATION.items():
        for number in range(1, MOST_PDOS + 1):
            communication = objects.get(first + number - 1)
            if communication:
                found.append(_pdo(communication, number, direction, objects, dummies, complain))
    return tuple(found)


def _pdo(
    communication: Object,
    number: int,
    direction: Direction,
    objects: Mapping[int, Object],
    dummies: frozenset[int],
    complain: Complain,
) -> Pdo:
    name = f"{'RT'[direction == 'tpdo']}PDO{number}"
    cob = communication.entry(1)
    identifier = cob_id(cob.value if cob else None, number, direction)
    if cob and isinstance(cob.value, int) and not identifier.extended and cob.value & _ID & ~_STANDARD_ID:
        complain(cob.line, "cob-id", pdo=name, value=f"{cob.value:08X}h")
    mapping = objects.get(communication.index + _TO_MAPPING)
    multiplex: Literal["sam", "dam"] | None = None
    mapped: tuple[Mapped, ...] = ()
    if mapping is None:
        complain(communication.line, "mapping-missing", pdo=name, object=f"{communication.index + _TO_MAPPING:04X}h")
    else:
        count = mapping.entry(0)
        multiplex = _MULTIPLEX.get(_whole(count) or 0)
        mapped = () if multiplex else _mapped(mapping, name, objects, dummies, complain)
    return Pdo(
        number,
        direction,
        identifier,
        transmission=_whole(communication.entry(2)),
        inhibit=_whole(communication.entry(3)),
        event_timer=_whole(communication.entry(5)),
        sync_start=_whole(communication.entry(6)),
        multiplex=multiplex,
        mapped=mapped,
        line=communication.line,
    )


def _mapped(
    mapping: Object, name: str, objects: Mapping[int, Object], dummies: frozenset[int], complain: Complain
) -> tuple[Mapped, ...]:
    entries = {
        entry.sub: word & 0xFFFFFFFF for entry in mapping.entries if entry.sub and (word := _whole(entry)) is not None
    }
    count = _whole(mapping.entry(0))
    if count is None:  # not said: all that is there, up to the first gap
        count = next(sub for sub in range(256) if sub + 1 not in entries)
    elif missing := [sub for sub in range(1, min(count, _LONGEST) + 1) if sub not in entries]:
        facts = {"object": f"{mapping.index:04X}h", "said": count, "found": min(count, _LONGEST) - len(missing)}
        complain(mapping.line, "mapping-count", pdo=name, **facts)
    found: list[Mapped] = []
    offset = 0
    for sub in range(1, min(count, _LONGEST) + 1):  # an entry has one bit at least
        if not entries.get(sub):  # 00000000h: nothing mapped here
            continue
        index, mapped_sub, bits = entries[sub] >> 16, entries[sub] >> 8 & 0xFF, entries[sub] & 0xFF
        target = objects[index].entry(mapped_sub) if index in objects else None
        dummy = index < _DUMMIES_END
        found.append(Mapped(index, mapped_sub, offset, bits, target, dummy))
        offset += bits
        entry = mapping.entry(sub)
        facts = {"pdo": name, "object": f"{index:04X}h:{mapped_sub:02X}"}
        line = entry.line if entry else mapping.line
        width = WIDTHS.get(index if dummy else target.type if target else 0)
        if target is None and (not dummy or index not in dummies | set(UNSIGNED)):
            complain(line, "mapped-unknown", **facts)
        elif width is not None and width != bits:
            complain(line, "mapped-size", **facts, bits=bits, width=width)
    if offset > _LONGEST:
        complain(mapping.line, "mapping-length", pdo=name, bits=offset, most=_LONGEST)
    return tuple(found)


def _whole(entry: Entry | None) -> int | None:
    value = entry.value if entry else None
    return value if isinstance(value, int) else None


def title(index: int) -> str | None:
    """Give what a parameter of a PDO is called; None for another object."""
    for direction, first in _COMMUNICATION.items():
        for start, kind in ((first, "communication"), (first + _TO_MAPPING, "mapping")):
            if index in range(start, start + _TO_MAPPING):
                return f"{direction.upper()} {kind} parameter"
    return None


def mapping_of(index: int) -> int | None:
    """Give the mapping parameter of the PDO of a communication parameter; None for another object."""
    is_one = any(index in range(first, first + _TO_MAPPING) for first in _COMMUNICATION.values())
    return index + _TO_MAPPING if is_one else None


def mapped_by(index: int, sub: int, value: object) -> tuple[int, int, int] | None:
    """Give the object that an entry of a mapping parameter maps, and its bits; None for a dummy, and for no entry."""
    if mapping_of(index - _TO_MAPPING) is None or not sub or not isinstance(value, int):
        return None
    mapped = value >> 16, value >> 8 & 0xFF, value & 0xFF
    return mapped if mapped[0] >= _DUMMIES_END else None


def implied(
    mask: int, numbers: tuple[int, int], existing: set[int]
) -> Iterator[tuple[int, str, dict[int, dict[str, str]]]]:
    """Give the objects of PDOs that exist by CompactPDO alone: index, name, and the keys of each sub-index.

    Bit k-1 of the mask stands for sub k (CiA 306 4.5.2).
    """
    mask &= (1 << len(_SUBS)) - 1
    if not mask:
        return
    for direction, count in zip(_COMMUNICATION, numbers, strict=True):
        for number in range(1, min(count, MOST_PDOS) + 1):
            index = _COMMUNICATION[direction] + number - 1
            if index not in existing:
                subs = {0: _sub("Highest sub-index supported", UNSIGNED8, "const", f"{mask.bit_length()}")}
                base = _FIRST_ID[direction] + _STEP * (number - 1)
                default = f"$NODEID+{base:#x}" if number <= _PREDEFINED else f"{_INVALID:#x}"
                for sub, (name, width) in enumerate(_SUBS, 1):
                    if mask & 1 << (sub - 1):
                        subs[sub] = _sub(name, width, "rw", default if sub == 1 else "")
                yield index, title(index) or "", subs
            index += _TO_MAPPING
            if index not in existing:
                subs = {0: _sub("Number of mapped objects", UNSIGNED8, "rw", "0")}
                subs |= {sub: _sub(f"Application object {sub}", UNSIGNED32, "rw", "") for sub in range(1, _LONGEST + 1)}
                yield index, title(index) or "", subs


def _sub(name: str, kind: int, access: str, default: str) -> dict[str, str]:
    return {"ParameterName": name, "DataType": f"{kind:#06x}", "AccessType": access, "DefaultValue": default}
