"""Objects of devices: what the traffic shows of them, how two sides differ, and a device from its description.

It lays out the records that the core hands over (`canalyze/core/src/tables/jsonl/inventory.rs` documents them), and
what `canalyze/dictionary/` finds in them. Must not: decide what an object is, or what counts. JSON lines are the same
in every language but for `text`; tests freeze the keys.

Of `od diff`: `od_diff_object`, `kind bus node node_b index sub name reason a b`, an object that differs, with a reason
where that does not count. `a` and `b` are `{"data","text","configured","exists","base"}`, or null where the side does
not have the object, or does not show it; `base`: a COB-ID without the node-ID, where the nodes are not the same.
`od_diff_node`, `kind side bus node objects`: a node that one side has. Last `od_diff`, `kind same differences compared
ignored a b`; `ignored` counts by reason, `a` and `b` are `{"file","form"}`.

Of `od against`:
    od_difference   bus node file what severity index sub name described shown text frame
    od_against      bus node file error warning info objects seen unseen
`what` is the kind of difference, a key of `SEVERITIES` in `dictionary/against.py`; `described` is what the file says,
`shown` what the traffic shows. `sub` is null for a whole object. `od_against` comes last.
"""

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from canalyze._core import object_text, standard_object
from canalyze.dictionary import against
from canalyze.dictionary.difference import IDENTIFIER, Compared, Difference, Held, Node, Pair, relative
from canalyze.output import Output, dyed, json_line, printable
from canalyze.output.layout import definitions
from canalyze.records import records
from canalyze.records.objects import Head, Object, ObjectValue, Refusal
from canalyze.reports.table import EMPTY, SPARE, Column, Row, Table, columns, write
from canalyze.words import Words

SOURCES: Final = ("read", "written", "tpdo", "rpdo", "emcy", "refused", "unconfirmed")
_IDENTITY: Final = ("device_name", "device_type", "vendor_id", "product_code", "revision", "serial")
_OBJECTS: Final = ("object", "name", "type", "bits", "access", "value", "in_force", "seen", "aborts", "time")
_HISTORY: Final = ("time", "bus", "node", "object", "name", "seen", "value", "aborts", "frame")
_RIGHT: Final = frozenset({"bits", "time", "frame", "node"})
_FOLDS: Final = frozenset({"value", "seen", "aborts", "in_force"})
_LEAVING: Final = {"time": 1, "bits": 2, "frame": 3, "seen": SPARE, "type": SPARE + 1, "name": SPARE + 2}
"""In which order columns leave a terminal that is too narrow."""
_NAMED: Final = 8
"""Objects that are listed where only their number and the reason are reported."""


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
        write(_columns([_OBJECTS[place] for place in kept], words), _cells(rows, kept), out)
        if node.further:
            out.text(words("od.further", count=node.further) + "\n")


class History:
    """All values in order, on their way to an output."""

    def __init__(self, out: Output, words: Words, *, live: bool) -> None:
        """Begins a table on an output. live: rows may not wait for others."""
        self._words = words
        self._table = Table(_columns(_HISTORY, words), out, live=live)
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


def _by_node(result: bytes) -> Iterator[tuple[Head, Iterator[Object]]]:
    """Yields the devices that have objects, each with its objects, which are read before the next device."""
    found: Iterator[Head | Object] = records(result, Head, Object)
    after: Head | None = None

    def objects(first: Object) -> Iterator[Object]:
        nonlocal after
        yield first
        for one in found:
            if isinstance(one, Head):
                after = one
                return
            yield one

    node = next(found, None)
    while isinstance(node, Head):
        after, one = None, next(found, None)
        if isinstance(one, Object):
            yield node, objects(one)
            node = after
        else:
            node = one


def _fact(node: Head, key: str, words: Words) -> str:
    fact = getattr(node, key)
    if key == "device_name":
        return str(fact)
    if key == "device_type" and node.profile is not None:
        return words("od.profile", type=fact, profile=node.profile)
    return f"{fact}h"


def _columns(keys: Sequence[str], words: Words) -> list[Column]:
    return columns(words, keys, right=_RIGHT, folds=_FOLDS, leaves=_LEAVING)


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


def _cells(rows: list[list[str]], kept: list[int]) -> Iterator[list[str]]:
    """Yields the kept cells of each row; the rows are used up, since a device may have very many."""
    rows.reverse()
    while rows:
        row = rows.pop()
        yield [row[place] for place in kept]


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


def differences(found: Compared) -> int:
    """Returns the number of differences; a node that only one side has counts once."""
    return sum(len(_told(pair)) for pair in found.pairs) + sum(map(len, found.alone))


def show_differences(found: Compared, out: Output, words: Words, *, every: bool) -> None:
    """Writes the differences, and the number of objects set apart with the reason; every: these too, one by one."""
    compared = 0
    for pair in found.pairs:
        compared += pair.compared
        told, apart = _told(pair), [one for one in pair.differences if one.reason is not None]
        if not told and not apart:
            continue
        out.text(dyed(printable(_heading(pair, words)), "own", out=out) + "\n")
        shown = pair.differences if every else told
        keys = ("object", "name", "a", "b", *(("reason",) if every else ()))
        rows = [_difference(one, pair, found, words, every=every) for one in shown]
        if rows:
            write(columns(words, keys, folds=("name", "a", "b")), rows, out)
        if apart and not every:
            out.text("".join(f"{line}\n" for line in _apart(apart, words)))
        out.text("\n")
    for side, nodes in zip("AB", found.alone, strict=True):
        for node in nodes:
            out.text(printable(words("od.alone", side=side, node=_name(node, words), count=len(node.objects))) + "\n")
    out.text(words("od.differences", count=differences(found), compared=compared) + "\n")


def difference_lines(found: Compared, names: tuple[str, str]) -> bytes:
    """Returns the JSON lines."""
    return b"".join(json_line(record, compact=True) for record in _records(found, names))


def _records(found: Compared, names: tuple[str, str]) -> Iterator[dict[str, Any]]:
    for pair in found.pairs:
        for one in pair.differences:
            a, b = (
                None if held is None else _json(held, text, base)
                for held, (text, base) in zip(one.held, _texts(one, pair, "en"), strict=True)
            )
            yield {
                "kind": "od_diff_object",
                "bus": pair.nodes[0].bus,
                "node": pair.nodes[0].node,
                "node_b": pair.nodes[1].node,
                "index": f"{one.address[0]:04X}",
                "sub": one.address[1],
                "name": _object_name(one, pair, "en") or None,
                "reason": one.reason,
                "a": a,
                "b": b,
            }
    for side, nodes in zip("ab", found.alone, strict=True):
        for node in nodes:
            objects = len(node.objects)
            yield {"kind": "od_diff_node", "side": side, "bus": node.bus, "node": node.node, "objects": objects}
    reasons = Counter(one.reason for pair in found.pairs for one in pair.differences if one.reason is not None)
    a, b = ({"file": name, "form": side.form} for name, side in zip(names, found.sides, strict=True))
    yield {
        "kind": "od_diff",
        "same": not differences(found),
        "differences": differences(found),
        "compared": sum(pair.compared for pair in found.pairs),
        "ignored": reasons,
        "a": a,
        "b": b,
    }


def _json(held: Held, text: str, base: int | None) -> dict[str, Any]:
    return {
        "data": None if held.data is None else held.data.hex().upper(),
        "text": None if held.data is None else text,
        "configured": held.configured,
        "exists": held.exists,
        "base": None if base is None else f"{base:X}",
    }


def _told(pair: Pair) -> list[Difference]:
    return [one for one in pair.differences if one.reason is None]


def _heading(pair: Pair, words: Words) -> str:
    a, b = pair.nodes
    same = a.node == b.node and (a.bus == b.bus or a.bus is None or b.bus is None)
    name = _name(a._replace(bus=a.bus or b.bus) if same else a, words)
    return words("od.node_compared", node=name if same else f"{name} / {_name(b, words)}", count=pair.compared)


def _name(node: Node, words: Words) -> str:
    number = words("eds.no_node") if node.node is None else str(node.node)
    return number if node.bus is None else words("od.on_bus", node=number, bus=node.bus)


def _difference(one: Difference, pair: Pair, found: Compared, words: Words, *, every: bool) -> list[str]:
    texts = []
    for held, (text, base), side in zip(one.held, _texts(one, pair, words.lang), found.sides, strict=True):
        if held is None:
            texts.append(words("od.missing" if side.whole else "od.unseen"))
        elif not held.exists:
            texts.append(words("od.absent"))
        elif held.data is None:
            texts.append(words.of("seen", "refused") if held.refused else words("od.no_value"))
        else:
            texts.append(text if base is None else f"{text} $NODEID+{base:X}h")
    why = [words.of("reason", one.reason or "")] if every else []
    return [_place(one), _object_name(one, pair, words.lang) or EMPTY, *texts, *why]


def _place(one: Difference) -> str:
    return f"{one.address[0]:04X}h:{one.address[1]:02X}"


def _object_name(one: Difference, pair: Pair, lang: str) -> str:
    known = next((held.name for held in one.held if held and held.name), "")
    return known or standard_object(*one.address, _profile(pair), lang)[0] or ""


def _profile(pair: Pair) -> int:
    return pair.nodes[0].profile or pair.nodes[1].profile


def _texts(one: Difference, pair: Pair, lang: str) -> list[tuple[str, int | None]]:
    """Returns the value of each side in words, both by one type, and the COB-ID without the node-ID."""
    apart = pair.nodes[0].node != pair.nodes[1].node
    kind = next((held.kind for held in one.held if held and held.kind), 0)
    texts: list[tuple[str, int | None]] = []
    for held, node in zip(one.held, pair.nodes, strict=True):
        data = b"" if held is None or held.data is None else held.data
        base = relative(one.address, data, node.node) if apart and data else None
        base = None if base is None else base & IDENTIFIER
        texts.append((object_text(*one.address, data, kind, _profile(pair), lang), base))
    return texts


def _apart(apart: Sequence[Difference], words: Words) -> list[str]:
    """Returns a line for each reason: how many objects, and the first of them."""
    rows = []
    for reason, count in Counter(one.reason for one in apart).items():
        places = [_place(one) for one in apart if one.reason == reason]
        more = f" +{count - _NAMED}" if count > _NAMED else ""
        rows.append((words.of("reason", reason or ""), f"{count}: {', '.join(places[:_NAMED])}{more}"))
    return definitions(rows)


def show_against(held: against.Comparison, file: str, out: Output, words: Words) -> None:
    """Writes a heading, a table, and how much of the description the traffic shows."""
    counts = Counter(one.severity for one in held.differences)
    said = [dyed(words(f"check.{key}", count=counts[key]), key, out=out) for key in counts]
    told = words("check.then").join(said) or words("against.alike")
    out.text(words("against.head", node=held.node, name=printable(Path(file).name), said=told) + "\n")
    colours = {words.of("severity", key): key for key in counts}
    keys, leaves = ("severity", "object", "name", "frame"), {"frame": 1, "name": 2}
    severity, *middle, frame = columns(words, keys, right=["frame"], folds=["name"], leaves=leaves)
    shown = [severity._replace(colour=colours.__getitem__), *middle, Column(words("against.col"), folds=True), frame]
    if held.differences:
        write(shown, (_against_cells(one, words) for one in held.differences), out)
    unseen = len(held.unseen)
    out.text(words("against.seen", all=held.seen + unseen, seen=held.seen, unseen=unseen) + "\n")


def against_lines(held: against.Comparison, file: str, words: Words) -> bytes:
    """Returns the JSON lines."""
    head = {"bus": held.bus, "node": held.node, "file": os.fsencode(file).decode("utf-8", "backslashreplace")}
    found = [
        {"kind": "od_difference", **head}
        | {"what": one.kind, "severity": one.severity, "index": f"{one.index:04X}", "sub": one.sub, "name": one.name}
        | {"described": one.filed, "shown": one.shown, "text": _against(one, words), "frame": one.frame}
        for one in held.differences
    ]
    counts = Counter(one.severity for one in held.differences)
    figures = {"objects": held.seen + len(held.unseen), "seen": held.seen, "unseen": len(held.unseen)}
    last = {"kind": "od_against", **head, **{key: counts[key] for key in ("error", "warning", "info")}, **figures}
    return b"".join(map(json_line, [*found, last]))


def _against_cells(one: against.Difference, words: Words) -> list[str]:
    place = f"{one.index:04X}h" + ("" if one.sub is None else f":{one.sub:02X}")
    frame = EMPTY if one.frame is None else str(one.frame)
    return [words.of("severity", one.severity), place, one.name or EMPTY, _against(one, words), frame]


def _against(one: against.Difference, words: Words) -> str:
    return words(f"against.{one.kind}", filed=one.filed, shown=one.shown)
