"""Concise DCF (object 1F22h, CiA 302-3): values in the order in which a configuration manager writes them to a device.

The number of entries (4 bytes), then for each entry index (2), sub-index (1), size (4) and data, little-endian.
This module writes it; the core reads it. Must not: know the source of the values, or select them.
"""

import struct
from collections.abc import Iterator, Mapping
from typing import Final

from canalyze.dictionary.model import Address

_COUNT: Final = struct.Struct("<I")
_ENTRY: Final = struct.Struct("<HBI")
_PDOS: Final = range(0x1400, 0x1C00)
_MAPPING: Final = 0x200
"""The index bit in which the mapping parameter of a PDO differs from its communication parameter."""
_INVALID: Final = 0x80
"""Bit 31 of a COB-ID, in its last byte: not in use."""


def concise(values: Mapping[Address, bytes]) -> bytes:
    """Returns a concise DCF; `values` are in the order in which the device accepted them.

    A PDO is configured by the rules of CiA 301 (7.5.2.36, 7.5.2.38), at the place of its last value: its COB-ID
    disables it, the number of mapped objects is set to 0, and both get their values after all others. A COB-ID that
    may not be changed while in use is disabled first.
    """
    written = list(_written(values))
    return _COUNT.pack(len(written)) + b"".join(_ENTRY.pack(*address, len(data)) + data for address, data in written)


def _written(values: Mapping[Address, bytes]) -> Iterator[tuple[Address, bytes]]:
    """Yields all values to write, in order."""
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
    """Yields the values of one PDO."""
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
    """Returns true for a COB-ID, other than that of a PDO, that may not be changed while in use."""
    return address == (0x1014, 0) or (0x1201 <= address[0] <= 0x12FF and address[1] in (1, 2))
