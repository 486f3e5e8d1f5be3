"""A description -> the flat table that the core reads frames by.

Only a change of form: `$NODEID` stays unresolved, and what a mapping or a COB-ID means is the core's.
"""

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from canalyze.dictionary.model import Dictionary, Entry, NodeOffset
from canalyze.dictionary.values import WIDTHS

if TYPE_CHECKING:
    from canalyze import _core

Row = tuple[int, int, str, int, str, int | None, bool, bool, bool, str, float]
"""Index, sub, name, data type, access, value, relative, configured, mappable, unit, factor; see `_core.Dictionary`."""

_WIDEST = 64


def flat(found: Dictionary) -> "_core.Dictionary":
    """Give the core's table of a description."""
    from canalyze import _core

    return _core.Dictionary(
        file=os.fsencode(found.file).decode("utf-8", "backslashreplace"),
        form=found.form,
        device=found.device.product_name or "",
        rows=list(rows(found)),
    )


def rows(found: Dictionary) -> Iterator[Row]:
    """Give one row a sub-object, in order of index and sub-index."""
    for thing in found.objects:
        for entry in thing.entries:
            yield _row(entry)


def _row(entry: Entry) -> Row:
    value = entry.value
    relative = isinstance(value, NodeOffset)
    number = value.offset if isinstance(value, NodeOffset) else value if isinstance(value, int) else None
    return (
        entry.index,
        entry.sub,
        entry.name,
        entry.type,
        entry.access,
        None if number is None else number & ((1 << WIDTHS.get(entry.type, _WIDEST)) - 1),
        relative,
        entry.parameter is not None,
        entry.mappable,
        entry.unit,
        entry.factor or 1.0,  # 0 would make every value 0: it stands for none
    )
