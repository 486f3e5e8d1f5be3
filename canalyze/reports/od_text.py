"""Objects of devices for people, by what the traffic shows of them: a heading and a table a node, or all values.

It lays out the records that the core hands over (`canalyze/core/src/tables/jsonl/inventory.rs` documents them). Must
not: decide what an object is.
"""

from collections.abc import Iterator
from typing import Final

from canalyze.output import Output, dyed, printable
from canalyze.output.layout import definitions
from canalyze.records import records
from canalyze.records.inventory import Head, Object, ObjectValue, Refusal
from canalyze.reports.table import EMPTY, SPARE, Column, Row, Table
from canalyze.words import Words

SOURCES: Final = ("read", "written", "tpdo", "rpdo", "emcy", "refused", "unconfirmed")
_IDENTITY: Final = ("device_name", "device_type", "vendor_id", "product_code", "revision", "serial")
_OBJECTS: Final = ("object", "name", "type", "bits", "access", "value", "in_force", "seen", "aborts", "time")
_HISTORY: Final = ("time", "bus", "node", "object", "name", "seen", "value", "aborts", "frame")
_RIGHT: Final = frozenset({"bits", "time", "frame", "node"})
_FOLDS: Final = frozenset({"value", "seen", "aborts", "in_force"})
_LEAVING: Final = {"time": 1, "bits": 2, "frame": 3, "seen": SPARE, "type": SPARE + 1, "name": SPARE + 2}
"""In which order columns leave a terminal that is too narrow."""


def show(result: bytes, out: Output, words: Words) -> None:
    """Writes the JSON lines of one capture: each node, and its objects."""
    first = True
    for node, objects in _by_node(result):
        if not first:
            out.text("\n")
        first = False
        key = "od.node" if node.bus is None else "od.node_of_bus"
        heading = words(key, node=node.node, bus=node.bus, objects=node.objects, values=node.values)
        out.text(dyed(printable(heading), "own", out=out) + "\n")
        facts = [(words(f"od.{key}"), printable(_fact(node, key, words))) for key in _IDENTITY if getattr(node, key)]
        out.text("".join(f"{line}\n" for line in definitions(facts)))
        rows = [_object(one, words) for one in objects]
        kept = [place for place, _ in enumerate(_OBJECTS) if any(row[place] != EMPTY for row in rows)]
        table = Table([_column(_OBJECTS[place], words) for place in kept], out, live=False)
        table.add([Row([row[place] for place in kept], number) for number, row in enumerate(rows)])
        table.close()
        if node.further:
            out.text(words("od.further", count=node.further) + "\n")


class History:
    """All values in order, on their way to an output."""

    def __init__(self, out: Output, words: Words, *, live: bool) -> None:
        """Begins a table on an output. live: rows may not wait for others."""
        self._words = words
        self._table = Table([_column(key, words) for key in _HISTORY], out, live=live)
        self._rows = 0

    def put(self, lines: bytes) -> None:
        """Writes values that the core has seen, as JSON lines."""
        rows = []
        for one in records(lines, ObjectValue):
            self._rows += 1
            rows.append(Row(_value(one, self._words), self._rows))
        self._table.add(rows)

    def close(self) -> None:
        """Writes the gathered rows."""
        self._table.close()


def _by_node(result: bytes) -> Iterator[tuple[Head, list[Object]]]:
    """Yields the devices that have objects."""
    found: Iterator[Head | Object] = records(result, Head, Object)
    node, objects = None, list[Object]()
    for one in found:
        if isinstance(one, Object):
            objects.append(one)
            continue
        if node and objects:
            yield node, objects
        node, objects = one, []
    if node and objects:
        yield node, objects


def _fact(node: Head, key: str, words: Words) -> str:
    fact = getattr(node, key)
    if key == "device_name":
        return str(fact)
    if key == "device_type" and node.profile is not None:
        return words("od.profile", type=fact, profile=node.profile)
    return f"{fact}h"


def _column(key: str, words: Words) -> Column:
    return Column(
        words(f"col.{key}"),
        right=key in _RIGHT,
        folds=key in _FOLDS,
        leaves=_LEAVING.get(key, 0),
        if_alike=key in ("bus", "node"),
    )


def _object(one: Object, words: Words) -> list[str]:
    """Returns the cells of one object."""
    kind = one.type
    if one.type_from == "inferred":
        kind = words("od.inferred", type=kind)
    cells = (
        f"{one.index}h:{one.sub:02X}",
        one.name,
        kind,
        one.bits,
        one.access,
        _last(one, words),
        _in_force(one, words),
        ", ".join(f"{words.of('seen', source)} {getattr(one, source)}" for source in SOURCES if getattr(one, source)),
        ", ".join(_abort(abort, words) for abort in one.aborts),
        one.t,
    )
    return [EMPTY if cell in (None, "") else str(cell) for cell in cells]


def _last(one: Object, words: Words) -> str | None:
    if one.text is not None:
        return str(one.text)
    if one.requested is not None:
        return words("od.requested", value=one.requested)
    return words("od.absent") if one.exists is False else None


def _in_force(one: Object, words: Words) -> str | None:
    """Returns the value of the object where it is not the one seen last."""
    held = one.in_force
    if held is None or one.source is None or held.text == one.text:
        return None
    return words("od.unknown") if held.text is None else str(held.text)


def _abort(abort: Refusal, words: Words) -> str:
    asked = words.of("access", abort.request)
    by = "" if abort.by == "server" else f" ({words.of('by', abort.by)})"
    times = f" x{abort.count}" if abort.count > 1 else ""
    return f"{asked}{by} {abort.code}h{times} {abort.text or ''}".rstrip()


def _value(one: ObjectValue, words: Words) -> list[str]:
    """Returns the cells of one value."""
    abort = one.abort
    cells = (
        one.t,
        one.bus,
        one.node,
        f"{one.index}h:{one.sub:02X}",
        one.name,
        words.of("seen", one.source),
        one.text,
        abort and f"{abort.code}h {abort.text or ''}".rstrip(),
        one.frame,
    )
    return [EMPTY if cell in (None, "") else str(cell) for cell in cells]
