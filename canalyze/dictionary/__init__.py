"""Device descriptions, typed and frozen, read from EDS and DCF (CiA 306), XDD and concise DCF, and of python-canopen.

The core reads files as they are found: repairs and unusable parts become a `Defect`. A file is an error (`SourceError`)
only if it contains no object at all or cannot be read. python-canopen is imported only where its own objects are
converted, and nowhere else. `$NODEID` stays unresolved (`NodeOffset`), also in the core's flat table for decoding, so
that one description serves several nodes; the core interprets mappings and COB-IDs. Values are bytes as SDO transfers
them, and back. All types are named tuples, which keeps the start of `decode` fast.
"""

import io
import math
import os
import struct
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, cast

from canalyze import _core
from canalyze._core import DATA_TYPES
from canalyze.errors import SourceError

if TYPE_CHECKING:
    from canopen import ObjectDictionary
    from canopen.objectdictionary import ODVariable

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


Row = tuple[int, int, str, int, str, int | None, bool, bool, bool, str, float]
"""Index, sub, name, data type, access, value, relative, configured, mappable, unit, factor; see `_core.Dictionary`."""


def table(file: str, form: str, product: str | None, objects: Iterable[Object]) -> _core.Dictionary:
    """Returns the core's table of a description."""
    return _core.Dictionary(**arguments(file, form, product, objects))


def arguments(file: str, form: str, product: str | None, objects: Iterable[Object]) -> dict[str, Any]:
    """Returns the arguments of the core's table."""
    name = os.fsencode(file).decode("utf-8", "backslashreplace")
    return {"file": name, "form": form, "device": product or "", "rows": list(rows(objects))}


def rows(objects: Iterable[Object]) -> Iterator[Row]:
    """Yields one row per sub-object, in order of index and sub-index."""
    for thing in objects:
        for entry in thing.entries:
            yield _table_row(entry)


def _table_row(entry: Entry) -> Row:
    value = entry.value
    relative = isinstance(value, NodeOffset)
    return (
        entry.index,
        entry.sub,
        entry.name,
        entry.type,
        entry.access,
        value.offset if isinstance(value, NodeOffset) else value if isinstance(value, int) else None,
        relative,
        entry.parameter is not None,
        entry.mappable,
        entry.unit,
        entry.factor or 1.0,  # 0 means that there is no factor
    )


def written(dictionary: "ObjectDictionary") -> str:
    """Returns the EDS that python-canopen writes."""
    import canopen

    stream = io.StringIO()
    canopen.export_od(dictionary, stream, "eds")
    return stream.getvalue()


def _variables(dictionary: "ObjectDictionary", index: int) -> "dict[int, ODVariable]":
    """Returns the variables of an object by their sub-index."""
    from canopen.objectdictionary import ODVariable

    given = dictionary.indices.get(index)
    if given is None:
        return {}
    return {0: given} if isinstance(given, ODVariable) else dict(given.subindices)


def given(described: Dictionary, node: int) -> "ObjectDictionary":
    """Returns a description as python-canopen's object for a node, with values relative to the node-ID resolved."""
    from canopen import ObjectDictionary
    from canopen.objectdictionary import ODArray, ODRecord, ODVariable

    made = ObjectDictionary()  # type: ignore[no-untyped-call]
    made.node_id = node
    made.bitrate = described.bit_rate
    device = made.device_information
    device.vendor_name, device.vendor_number = described.device.vendor_name, described.device.vendor_number
    device.product_name, device.product_number = described.device.product_name, described.device.product_number
    device.revision_number, device.order_code = described.device.revision_number, described.device.order_code
    for one in described.objects:
        own: list[ODVariable] = []
        for entry in one.entries:
            variable = ODVariable(entry.name, entry.index, entry.sub)
            variable.data_type = entry.type
            variable.access_type = entry.access
            variable.default = cast(Any, _at(entry.default, node))
            variable.value = cast(Any, _at(entry.parameter, node))
            variable.relative = isinstance(entry.value, NodeOffset)
            variable.pdo_mappable, variable.unit, variable.factor = entry.mappable, entry.unit, entry.factor
            variable.min, variable.max = entry.low, entry.high  # type: ignore[assignment]  # of REAL types they are floats
            own.append(variable)
        if one.code in (ARRAY, RECORD) or len(own) > 1:
            whole = (ODArray if one.code == ARRAY else ODRecord)(one.name, one.index)
            for variable in own:
                whole.add_member(variable)
            made.add_object(whole)
        elif own:
            made.add_object(own[0])
    return made


def _at(value: Value | None, node: int) -> int | float | str | bytes | None:
    return value.at(node) if isinstance(value, NodeOffset) else value


_NAMES: Final = (".eds", ".dcf", ".xdd", ".xdc", ".cdcf")
_HEAD: Final = 1 << 16
_LARGEST: Final = 8 << 20
_Filed = int | float | str | bytes | tuple[int] | None


def load(name: str, node: int | None = None) -> Dictionary:
    """Reads a file ('-' is standard input); `node` overrides the node-ID of a DCF."""
    return read(*contents(name), node)


def describes(name: str) -> bool:
    """Returns true if a file is a description and not a capture, by its name or its first bytes."""
    if name.lower().endswith(_NAMES):
        return True
    try:
        with open(name, "rb") as file:
            data = file.read(_HEAD)
    except OSError:  # standard input, or an unreadable file
        return False
    return _core.is_description(data)


def contents(name: str) -> tuple[bytes, str]:
    """Returns the bytes of a file ('-' is standard input), and its name for messages."""
    from canalyze.sources import Source

    data = bytearray()
    with Source(name) as source:
        while piece := source.read():
            data += piece
            if len(data) > _LARGEST:
                raise SourceError("eds.large", name=source.name, most=_LARGEST >> 20)
    return bytes(data), source.name


def read(data: bytes, name: str, node: int | None = None) -> Dictionary:
    """Reads a description from its bytes; `name` is used in messages."""
    try:
        form, encoding, info, device, comments, filed, node_name, rate, objects, dummies, table, pdos, defects = (
            _core.description(data, os.fsencode(name).decode("utf-8", "backslashreplace"))
        )
    except _core.DescriptionError as error:
        key, facts = error.args
        raise SourceError(key, name=name, **facts) from None
    return Dictionary(
        file=name,
        form=form,
        encoding=encoding,
        info=FileInfo(*info),
        device=Device(*device),
        comments=comments,
        node=filed if node is None else node,
        node_name=node_name,
        bit_rate=rate,
        objects=tuple(
            Object(index, title, code, tuple(_entry(*entry) for entry in entries), line)
            for index, title, code, entries, line in objects
        ),
        dummies=frozenset(dummies),
        table=table,
        pdos=tuple(pdos),
        defects=tuple(Defect(*defect) for defect in defects),
    )


def _entry(
    index: int, sub: int, name: str, kind: int, access: Access, default: _Filed, parameter: _Filed, *rest: Any
) -> Entry:
    """Returns an entry of the core's; a tuple is an offset to the node-ID."""
    return Entry(
        index,
        sub,
        name,
        kind,
        access,
        NodeOffset(*default) if isinstance(default, tuple) else default,
        NodeOffset(*parameter) if isinstance(parameter, tuple) else parameter,
        *rest,
    )


def taken(given: "ObjectDictionary", name: str) -> Dictionary:
    """Converts a dictionary of python-canopen, through the EDS that it writes."""
    found = read(written(given).encode(), name)
    objects = []
    for one in found.objects:  # of what that EDS leaves out, the unit and the factor count
        variables = _variables(given, one.index)
        entries = (
            entry._replace(unit=variables[entry.sub].unit, factor=float(variables[entry.sub].factor))
            if entry.sub in variables
            else entry
            for entry in one.entries
        )
        objects.append(one._replace(entries=tuple(entries)))
    made = table(name, found.form, found.device.product_name, objects)
    return found._replace(objects=tuple(objects), table=made, node=given.node_id)
