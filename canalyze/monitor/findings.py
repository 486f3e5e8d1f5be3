"""The room of findings: the last one first; each leads to its frame."""

from typing import Any

from canalyze.monitor.figures import seconds
from canalyze.monitor.grid import NOTHING, Cell, Column, Row, cell, texts
from canalyze.monitor.status import MARKS
from canalyze.words import Words


def columns(words: Words, *, buses: bool) -> list[Column]:
    """Give the columns; that of the bus only where there are several."""
    given = [
        Column(words("col.time"), most=12, right=True, leaves=2),
        Column(words("monitor.frame"), right=True, leaves=1),
        Column(words("monitor.rule")),
        Column(words("col.node"), right=True),
        Column(words("monitor.finding"), least=30, most=400),
    ]
    return [given[0], Column(words("col.bus"), most=10), *given[1:]] if buses else given


def rows(snapshot: dict[str, Any], *, buses: bool) -> list[Row]:
    """Give a row a finding."""
    start = snapshot["start_ns"]
    found = []
    for place, one in enumerate(snapshot["findings"]):
        at = None if one["t_ns"] is None or start is None else one["t_ns"] - start
        look = one["severity"] if one["severity"] in ("error", "warning", "info") else ""
        cells = [
            cell(seconds(at, 3), "dim"),
            cell(one["frame"]),
            cell(one["code"], look),
            cell("" if one["node"] is None else one["node"]),
            cell(one["text"], look if look == "error" else ""),
        ]
        if one.get("count", 1) > 1:
            cells[4] = (*cells[4], (f" x{one['count']}", "strong"))
        if buses:
            cells.insert(1, cell(one["bus"]))
        key = (one["frame"], one["code"], one["t_ns"], one["node"], place if one["frame"] is None else 0)
        found.append(Row(key, tuple(cells), texts([one["code"], one["text"]]), leads=one["frame"]))
    found.reverse()
    return found


def latest(snapshot: dict[str, Any]) -> Cell:
    """Give the last error or warning in a line, else the last info; nothing where there is none."""
    found = snapshot["findings"]
    if not found:
        return NOTHING
    one = next((one for one in reversed(found) if one["severity"] in ("error", "warning")), found[-1])
    start, look = snapshot["start_ns"], one["severity"]
    at = "" if one["t_ns"] is None or start is None else f"{seconds(one['t_ns'] - start, 3)}  "
    return ((f" {MARKS.get(look, '')} ", look), (at, "dim"), (f"{one['code']}  ", look), (one["text"], ""))
