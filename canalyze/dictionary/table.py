"""Converts the objects of a description made by a program to the core's flat table for decoding.

`$NODEID` stays unresolved; mappings and COB-IDs are interpreted by the core.
"""

import os
from collections.abc import Iterable, Iterator
from typing import Any

from canalyze import _core
from canalyze.dictionary.model import Entry, NodeOffset, Object

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
        entry.factor or 1.0,  # 0 would make every value 0: it stands for none
    )
