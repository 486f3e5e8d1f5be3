"""Converts descriptions from and to python-canopen, and to the core's flat table for decoding.

No other module imports python-canopen. In the table `$NODEID` stays unresolved; the core interprets mappings and
COB-IDs.
"""

import io
import os
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, cast

from canalyze import _core
from canalyze.dictionary.model import (
    ARRAY,
    RECORD,
    Dictionary,
    Entry,
    NodeOffset,
    Object,
    Value,
)

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
            yield _row(entry)


def _row(entry: Entry) -> Row:
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


def variables(dictionary: "ObjectDictionary", index: int) -> "dict[int, ODVariable]":
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
