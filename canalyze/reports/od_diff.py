"""In what the configurations of two sides differ, for people and as JSON lines: by node and object.

It lays out what `canalyze/dictionary/difference.py` has found. Must not: decide what counts.

JSON lines: `od_diff_object`, `kind bus node node_b index sub name reason a b`, an object that differs, with a reason
where that does not count. `a` and `b` are `{"data","text","configured","exists","base"}`, or null where the side does
not have the object, or does not show it; `base`: a COB-ID without the node-ID, where the nodes are not the same.
`od_diff_node`, `kind side bus node objects`: a node that one side has. Last `od_diff`, `kind same differences compared
ignored a b`; `ignored` counts by reason, `a` and `b` are `{"file","form"}`.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, Final

from canalyze._core import object_text, standard_object
from canalyze.dictionary.difference import IDENTIFIER, Compared, Difference, Held, Node, Pair, relative
from canalyze.output import Output, dyed, jsonl, printable
from canalyze.output.layout import definitions
from canalyze.reports.table import EMPTY, Column, write
from canalyze.words import Words

_NAMED: Final = 8
"""Objects that are listed where only their number and the reason are reported."""


def count(found: Compared) -> int:
    """Returns the number of differences; a node that only one side has counts once."""
    return sum(len(_told(pair)) for pair in found.pairs) + sum(map(len, found.alone))


def show(found: Compared, out: Output, words: Words, *, every: bool) -> None:
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
        rows = [_row(one, pair, found, words, every=every) for one in shown]
        if rows:
            write([Column(words(f"col.{key}"), folds=key in ("name", "a", "b")) for key in keys], rows, out)
        if apart and not every:
            out.text("".join(f"{line}\n" for line in _apart(apart, words)))
        out.text("\n")
    for side, nodes in zip("AB", found.alone, strict=True):
        for node in nodes:
            out.text(printable(words("od.alone", side=side, node=_name(node, words), count=len(node.objects))) + "\n")
    out.text(words("od.differences", count=count(found), compared=compared) + "\n")


def lines(found: Compared, names: tuple[str, str]) -> bytes:
    """Returns the JSON lines."""
    return b"".join(jsonl.line(record, compact=True) for record in _records(found, names))


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
        "same": not count(found),
        "differences": count(found),
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


def _row(one: Difference, pair: Pair, found: Compared, words: Words, *, every: bool) -> list[str]:
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
