"""EDS and DCF (CiA 306), XDD and concise DCF -> a frozen `Dictionary`; and descriptions from and to python-canopen.

The core reads them as they are found: repairs and unusable parts become a `Defect`. A file is an error (`SourceError`)
only if it contains no object at all or cannot be read. python-canopen is imported only where its own objects are
converted, and nowhere else. In the core's flat table for decoding `$NODEID` stays unresolved; the core interprets
mappings and COB-IDs.
"""

import io
import os
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final, cast

from canalyze import _core
from canalyze.dictionary.model import (
    ARRAY,
    RECORD,
    Access,
    Defect,
    Device,
    Dictionary,
    Entry,
    FileInfo,
    NodeOffset,
    Object,
    Value,
)
from canalyze.errors import SourceError

if TYPE_CHECKING:
    from canopen import ObjectDictionary
    from canopen.objectdictionary import ODVariable

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
    from canalyze.sources.file import Source

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


__all__ = ["contents", "describes", "load", "model", "read", "taken"]
