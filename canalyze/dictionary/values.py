"""Values of descriptions -> bytes as SDO transfers them, and back; the data types by their codes."""

import math
import struct
from typing import Final

from canalyze._core import DATA_TYPES
from canalyze.dictionary.model import NodeOffset, Value

UNSIGNED8, UNSIGNED32, OPAQUE = 0x05, 0x07, 0x0F
NAMES: Final = {kind: name for kind, (name, _) in DATA_TYPES.items()}
_WIDTHS: Final = {kind: bits for kind, (_, bits) in DATA_TYPES.items() if bits}
CODES: Final = {name: kind for kind, name in NAMES.items()}
BY_WIDTH: Final = {
    bits: kind for kind, (name, bits) in DATA_TYPES.items() if bits and name.startswith(("UNSIGNED", "BOOLEAN"))
}
"""Unsigned data types by their width in bits."""
SIGNED: Final = {kind: bits for kind, bits in _WIDTHS.items() if NAMES[kind].startswith("INTEGER")}
REAL: Final = {kind: bits for kind, bits in _WIDTHS.items() if NAMES[kind].startswith("REAL")}
_REALS: Final = {32: "<f", 64: "<d"}
_UNICODE: Final = 0x0B
STRINGS: Final = frozenset({0x09, _UNICODE})
_PADDING: Final = b"\0 \t\r\n"
BYTES: Final = frozenset({0x0A, OPAQUE})


def packed(value: Value, kind: int, node: int) -> bytes:
    """Returns a value of a file as it is transferred."""
    if isinstance(value, NodeOffset):
        value = value.at(node)
    if isinstance(value, str):
        return value.encode("utf-16-le" if kind == _UNICODE else "utf-8")
    if isinstance(value, bytes):
        return value
    if kind in REAL:
        try:
            return struct.pack(_REALS[REAL[kind]], value)
        except OverflowError:  # more than this type holds
            return struct.pack(_REALS[REAL[kind]], math.copysign(math.inf, value))
    bits = _WIDTHS.get(kind, 64)
    return (int(value) & (1 << bits) - 1).to_bytes(-(-bits // 8), "little")


def decoded(data: bytes, kind: int) -> int | float | str | bytes | None:
    """Returns the value of transferred bytes; None if they are invalid for that type."""
    if kind in STRINGS:
        return data.decode("utf-16-le" if kind == _UNICODE else "utf-8", "replace").rstrip("\0")
    if kind in BYTES:
        return data
    if kind in REAL:
        return float(struct.unpack(_REALS[REAL[kind]], data)[0]) if len(data) * 8 == REAL[kind] else None
    number, bits = int.from_bytes(data, "little", signed=kind in SIGNED), _WIDTHS.get(kind, 0)
    least, beyond = (-1 << bits - 1, 1 << bits - 1) if kind in SIGNED else (0, 1 << bits)
    return number if 0 < len(data) <= 8 and bits and least <= number < beyond else None


def comparable(data: bytes, kind: int) -> int | bytes:
    """Returns a value as it is transferred in a form for comparison: numbers by their value, texts without padding."""
    if kind in STRINGS:
        return data.strip(_PADDING)
    if kind in BYTES or kind in REAL or len(data) > 8:
        return data
    return int.from_bytes(data, "little", signed=kind in SIGNED)
