"""Concise DCF (object 1F22h, CiA 302-3): values in the order in which a configuration manager writes them to a device.

The number of entries (4 bytes), then of each entry index (2), sub-index (1), size (4) and data, the least byte first.
It has neither types nor names: where it is read as a description, those are the standard's. Must not: know where the
values come from, or which of them are worth keeping.
"""

import struct
from collections.abc import Iterator, Mapping
from typing import Final

from canalyze._core import DATA_TYPES, standard_object
from canalyze.dictionary.ini import Ini, Key, Section
from canalyze.dictionary.model import RECORD, VAR, Address
from canalyze.dictionary.values import BY_WIDTH, CODES, spelled

_COUNT: Final = struct.Struct("<I")
_ENTRY: Final = struct.Struct("<HBI")
_OBJECTS: Final = 0x1000
"""The first index that is no data type."""
_PDOS: Final = range(0x1400, 0x1C00)
_MAPPING: Final = 0x200
"""Bit of the index by which the mapping parameter of a PDO differs from its communication parameter."""
_INVALID: Final = 0x80
"""Bit 31 of a COB-ID, in its last byte: it is not in use."""
_TEXT, _OCTETS = 0x09, 0x0A


def concise(values: Mapping[Address, bytes]) -> bytes:
    """Put values into a concise DCF; values: in the order in which the device has accepted them.

    A PDO is put together by the rules of CiA 301 (7.5.2.36, 7.5.2.38), at the place of its last value: it is disabled
    by its COB-ID, the number of mapped objects is set to 0, and both get their values when all others have theirs. A
    COB-ID that may not be changed while it is in use is taken out of use first.
    """
    written = list(_written(values))
    return _COUNT.pack(len(written)) + b"".join(_ENTRY.pack(*address, len(data)) + data for address, data in written)


def entries(data: bytes) -> list[tuple[Address, bytes]] | None:
    """Give what a concise DCF has written, in its order; None for bytes that are none."""
    if len(data) < _COUNT.size + _ENTRY.size:
        return None
    (count,), place = _COUNT.unpack_from(data), _COUNT.size
    found: list[tuple[Address, bytes]] = []
    while len(found) < count and place + _ENTRY.size <= len(data):
        index, sub, size = _ENTRY.unpack_from(data, place)
        place += _ENTRY.size
        if index < _OBJECTS or place + size > len(data):
            return None
        found.append(((index, sub), data[place : place + size]))
        place += size
    return found if len(found) == count > 0 and place == len(data) else None


def sections(found: list[tuple[Address, bytes]]) -> Ini:
    """Give the sections that a DCF of the same values has; of an object that is written twice the last one counts."""
    ini = Ini()
    objects: dict[int, dict[int, bytes]] = {}
    for (index, sub), data in found:
        objects.setdefault(index, {})[sub] = data
    for index, subs in sorted(objects.items()):
        if set(subs) == {0}:
            _put(ini, f"{index:04X}", {"ObjectType": str(VAR), **_entry(index, 0, subs[0])})
            continue
        name = standard_object(index, 0, 0, "en")[0] or f"{index:04X}h"
        _put(ini, f"{index:04X}", {"ObjectType": str(RECORD), "ParameterName": name})
        for sub, data in sorted(subs.items()):
            _put(ini, f"{index:04X}sub{sub:X}", _entry(index, sub, data))
    return ini


def _put(ini: Ini, name: str, keys: Mapping[str, str]) -> None:
    """Add a section that stands on no line."""
    ini.sections[name.lower()] = Section(name, 0, {key.lower(): Key(key, value, 0) for key, value in keys.items()})


def _entry(index: int, sub: int, data: bytes) -> dict[str, str]:
    name, standard = standard_object(index, sub, 0, "en")
    kinds = (CODES.get(standard or "", 0), BY_WIDTH.get(8 * len(data), _TEXT if data.isascii() else _OCTETS), _OCTETS)
    kind, value = next(((kind, value) for kind in kinds if (value := _fitting(data, kind)) is not None), (_OCTETS, ""))
    return {
        "ParameterName": name or f"{index:04X}h:{sub:02X}",
        "DataType": f"{kind:#06x}",
        "AccessType": "rw",
        "ParameterValue": value,
    }


def _fitting(data: bytes, kind: int) -> str | None:
    """Give a value as a type has it that is as long."""
    bits = DATA_TYPES.get(kind, ("", None))[1]
    return spelled(data, kind) if bits is None or -(-bits // 8) == len(data) else None


def _written(values: Mapping[Address, bytes]) -> Iterator[tuple[Address, bytes]]:
    """Give everything that is to be written, in order."""
    pdos: dict[int, list[Address]] = {}
    for index, sub in values:
        if index in _PDOS:
            pdos.setdefault(index & ~_MAPPING, []).append((index, sub))
    for address, data in values.items():
        communication = address[0] & ~_MAPPING
        if address[0] not in _PDOS:
            if _is_fixed_in_use(address) and _invalid(data) != data:
                yield address, _invalid(data)
            yield address, data
        elif address == pdos[communication][-1]:
            yield from _pdo(communication, {one: values[one] for one in pdos[communication]})


def _pdo(communication: int, values: dict[Address, bytes]) -> Iterator[tuple[Address, bytes]]:
    """Give what is to be written of one PDO."""
    cob_id, number = (communication, 1), (communication | _MAPPING, 0)
    last = {address: values.pop(address) for address in (number, cob_id) if address in values}
    first = {cob_id: _invalid(last[cob_id])} if cob_id in last else {}
    parameters = {address: data for address, data in values.items() if address[0] == communication}
    mapped = {address: data for address, data in values.items() if address[0] != communication}
    if number in last:
        mapped = {number: bytes(len(last[number])), **mapped}
    yield from {**first, **parameters, **mapped}.items()
    yield from ((address, data) for address, data in last.items() if {**first, **mapped}.get(address) != data)


def _invalid(cob_id: bytes) -> bytes:
    return cob_id[:3] + bytes([cob_id[3] | _INVALID]) if len(cob_id) == 4 else cob_id


def _is_fixed_in_use(address: Address) -> bool:
    """Tell whether an object holds a COB-ID, beside those of PDOs, that may not be changed while it is in use."""
    return address == (0x1014, 0) or (0x1201 <= address[0] <= 0x12FF and address[1] in (1, 2))
