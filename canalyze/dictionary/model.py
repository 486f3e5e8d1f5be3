"""The content of a device description, typed and frozen; its values as bytes as SDO transfers them, and back.

`$NODEID` stays unresolved (`NodeOffset`), so that one description serves several nodes. All types are named tuples,
which keeps the start of `decode` fast. Must not: know files, python-canopen or words.
"""

import math
import struct
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from canalyze._core import DATA_TYPES

if TYPE_CHECKING:
    from canalyze import _core

Access = Literal["ro", "wo", "rw", "rwr", "rww", "const"]
Effect = Literal["repaired", "unused", "noted"]
Form = Literal["eds", "dcf", "xdd", "concise"]

Address = tuple[int, int]
"""Index and sub-index."""

ARRAY, RECORD = 8, 9
"""Object codes, CiA 301 7.4.3."""


class NodeOffset(NamedTuple):
    """A number relative to the node-ID."""

    offset: int

    def at(self, node: int) -> int:
        """Returns the number for one node."""
        return self.offset + node


Value = int | float | str | bytes | NodeOffset


class Entry(NamedTuple):
    """One sub-object, or an object that is a single variable (sub 0)."""

    index: int  # type: ignore[assignment]  # of a tuple it is a method
    sub: int
    name: str
    type: int
    """The data type code in the file (CiA 301 7.4.7); 0 if it has none."""
    access: Access
    default: Value | None
    """DefaultValue, None if empty or missing."""
    parameter: Value | None
    """ParameterValue of a DCF, None if empty or missing."""
    mappable: bool
    low: int | float | None
    high: int | float | None
    unit: str
    factor: float
    line: int

    @property
    def value(self) -> Value | None:
        """The initial value: the parameter value of a DCF, or else the default."""
        return self.default if self.parameter is None else self.parameter


class Object(NamedTuple):
    """One index of the dictionary."""

    index: int  # type: ignore[assignment]  # of a tuple it is a method
    name: str
    code: int
    """Object code: 2 (DOMAIN), 7 (VAR), ARRAY or RECORD."""
    entries: tuple[Entry, ...]
    """By sub-index, ascending."""
    line: int

    def entry(self, sub: int) -> Entry | None:
        """Returns the entry of a sub-index."""
        return next((entry for entry in self.entries if entry.sub == sub), None)


class FileInfo(NamedTuple):
    """Section FileInfo, as written."""

    name: str = ""
    version: str = ""
    revision: str = ""
    eds_version: str = ""
    description: str = ""
    created: str = ""
    """Date, time and author."""
    modified: str = ""
    """Date, time and author."""


class Device(NamedTuple):
    """Section DeviceInfo; None for missing keys."""

    vendor_name: str | None
    vendor_number: int | None
    product_name: str | None
    product_number: int | None
    revision_number: int | None
    order_code: str | None
    bit_rates: tuple[int, ...]
    """In bit/s."""
    rpdos: int | None
    """NrOfRXPDO."""
    tpdos: int | None
    lss: bool | None


class Defect(NamedTuple):
    """An inconsistency or error in a file, which was repaired if possible."""

    line: int
    """0 if it has no line."""
    code: str
    """A key of EFFECTS; its words are `defect.CODE`."""
    facts: Mapping[str, object]

    @property
    def effect(self) -> Effect:
        """Its effect."""
        return EFFECTS[self.code]


class Dictionary(NamedTuple):
    """One device description."""

    file: str
    form: Form
    encoding: str
    info: FileInfo
    device: Device
    comments: tuple[str, ...]
    node: int | None
    """The requested one, or else that of a DCF."""
    node_name: str
    bit_rate: int | None
    """That of a DCF, in bit/s."""
    objects: tuple[Object, ...]
    """By index, ascending."""
    dummies: frozenset[int]
    """Data types that may be mapped to skip bits."""
    table: "_core.Dictionary"
    """The core's table for decoding frames."""
    pdos: "tuple[_core.Pdo, ...]"
    """RPDOs, then TPDOs, by number."""
    defects: tuple[Defect, ...]
    """By line."""

    def object(self, index: int) -> Object | None:
        """Returns the object of an index."""
        from bisect import bisect_left

        place = bisect_left(self.objects, index, key=lambda found: found.index)
        return self.objects[place] if place < len(self.objects) and self.objects[place].index == index else None

    def entry(self, index: int, sub: int) -> Entry | None:
        """Returns the entry of an index and sub-index."""
        found = self.object(index)
        return found.entry(sub) if found else None


EFFECTS: Final[dict[str, Effect]] = {
    # The text.
    "encoding": "repaired",
    "bom": "repaired",
    "no-equals": "unused",
    "no-section": "unused",
    "section-bracket": "repaired",
    "section-name": "repaired",
    "section-unused": "unused",
    "duplicate-section": "repaired",
    "duplicate-key": "repaired",
    "commissioning": "repaired",
    "modules": "unused",
    "more": "noted",
    # Numbers and values.
    "not-a-number": "unused",
    "not-bytes": "unused",
    "octal": "repaired",
    "trailing-comment": "repaired",
    "nodeid-form": "repaired",
    "real-as-hex": "repaired",
    "wrapped": "repaired",
    "out-of-range": "unused",
    "node-id": "unused",
    # Objects.
    "missing-key": "repaired",
    "access": "repaired",
    "unknown-type": "repaired",
    "object-type": "repaired",
    "no-index-section": "repaired",
    "no-lists": "noted",
    "unlisted": "noted",
    "not-there": "unused",
    "count": "noted",
    "no-such-sub": "unused",
    "dummy-missing": "repaired",
    "too-many": "unused",
    # PDOs.
    "cob-id": "noted",
    "mapping-missing": "noted",
    "mapping-count": "noted",
    "mapping-length": "noted",
    "mapped-unknown": "noted",
    "mapped-size": "noted",
}
"""The codes of defects and their effects."""


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
