"""Repaired text -> objects, by python-canopen: the only file that imports it.

It reads the text for node 0, so that what depends on the node-ID comes out as an offset; `relative` and the raw texts
tell which values those are.
"""

import io
from typing import TYPE_CHECKING, Any, cast

from canalyze.dictionary.model import ARRAY, DOMAIN, RECORD, VAR, Access, Entry, NodeOffset, Object, Value
from canalyze.dictionary.objects import Written
from canalyze.dictionary.values import OPAQUE, unguarded

if TYPE_CHECKING:
    from canopen import ObjectDictionary
    from canopen.objectdictionary import ODVariable

FIRST_OBJECT = 0x1000
"""Indices below are data types: python-canopen puts dummies there."""


def read(text: str) -> "ObjectDictionary":
    """Let python-canopen read the repaired text."""
    import canopen

    stream = io.StringIO(text)
    stream.name = "repaired.eds"
    return canopen.import_od(stream, 0)


def objects(dictionary: "ObjectDictionary", written: Written) -> dict[int, Object]:
    """Give the objects by index, ascending."""
    from canopen.objectdictionary import ODArray, ODVariable

    found = {}
    for index, given in sorted(dictionary.indices.items()):
        if index < FIRST_OBJECT:
            continue
        if isinstance(given, ODVariable):
            entries: tuple[Entry, ...] = (_entry(given, written),)
            opaque = given.data_type == OPAQUE and written.codes[index] == DOMAIN
            code = DOMAIN if opaque else VAR
        else:
            entries = tuple(_entry(variable, written) for _, variable in sorted(given.subindices.items()))
            code = ARRAY if isinstance(given, ODArray) else RECORD
        found[index] = Object(index, unguarded(given.name), code, entries, written.places[index])
    return found


def _entry(variable: "ODVariable", written: Written) -> Entry:
    beside = written.beside[variable.index, variable.subindex]
    return Entry(
        variable.index,
        variable.subindex,
        unguarded(variable.name),
        beside.type,
        cast(Access, variable.access_type),
        default=_value(variable.default, getattr(variable, "default_raw", "")),
        parameter=_value(variable.value, getattr(variable, "value_raw", "")),
        mappable=variable.pdo_mappable,
        low=beside.low,
        high=beside.high,
        unit=unguarded(variable.unit),
        factor=float(variable.factor),
        line=beside.line,
    )


def _value(value: Any, raw: str) -> Value | None:
    if isinstance(value, str):
        return unguarded(value)
    if isinstance(value, int) and raw.startswith("$NODEID"):
        return NodeOffset(value)
    return cast(Value | None, value)
