"""Objects of a description that a program has put together -> the flat table that the core reads frames by.

Only a change of form: `$NODEID` stays unresolved, and what a mapping or a COB-ID means is the core's.
"""

import os
from collections.abc import Iterable, Iterator
from typing import Any

from canalyze import _core
from canalyze.dictionary.model import Entry, NodeOffset, Object

Row = tuple[int, int, str, int, str, int | None, bool, bool, bool, str, float]
"""Index, sub, name, data type, access, value, relative, configured, mappable, unit, factor; see `_core.Dictionary`."""


def table(file: str, form: str, product: str | None, objects: Iterable[Object]) -> _core.Dictionary:
    """Give the core's table of a description."""
    return _core.Dictionary(**arguments(file, form, product, objects))


def arguments(file: str, form: str, product: str | None, objects: Iterable[Object]) -> dict[str, Any]:
    """Return what the core's table is made of."""
    name = os.fsencode(file).decode("utf-8", "backslashreplace")
    return {"file": name, "form": form, "device": product or "", "rows": list(rows(objects))}


def rows(objects: Iterable[Object]) -> Iterator[Row]:
    """Give one row a sub-object, in order of index and sub-index."""
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
