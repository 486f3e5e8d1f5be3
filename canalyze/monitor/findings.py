"""The view of findings, newest first; each leads to its frame."""

from typing import Final

from canalyze.monitor.grid import NOTHING, Cell, Column, Row, cell, seconds, texts
from canalyze.monitor.status import MARKS
from canalyze.records.live import Snapshot
from canalyze.words import Words

LEVELS: Final = ("info", "warning", "error")
"""Severities, from the least on."""


def columns(words: Words, *, buses: bool, least: str = LEVELS[0]) -> list[Column]:
    """Returns the columns; that of the bus only with several buses. least: the least severity shown."""
    heading = words("monitor.finding")
    if least != LEVELS[0]:
        heading += f"  {words.of('monitor_severity', least)}"
    given = [
        Column(words("col.time"), most=12, right=True, leaves=2),
        Column(words("monitor.frame"), right=True, leaves=1),
        Column(words("monitor.rule")),
        Column(words("col.node"), right=True),
        Column(heading, least=30, most=400),
    ]
    return [given[0], Column(words("col.bus"), most=10), *given[1:]] if buses else given


def rows(snapshot: Snapshot, *, buses: bool, least: str = LEVELS[0]) -> list[Row]:
    """Returns one row per finding of at least this severity."""
    start = snapshot.start_ns
    found = []
    for place, one in enumerate(snapshot.findings):
        if one.severity not in LEVELS[LEVELS.index(least) :]:
            continue
        at = None if one.t_ns is None or start is None else one.t_ns - start
        look = one.severity
        cells = [
            cell(seconds(at, 3), "dim"),
            cell(one.frame),
            cell(one.code, look),
            cell("" if one.node is None else one.node),
            cell(one.text, look if look == "error" else ""),
        ]
        if one.count > 1:
            cells[4] = (*cells[4], (f" x{one.count}", "strong"))
        if buses:
            cells.insert(1, cell(one.bus))
        key = (one.frame, one.code, one.t_ns, one.node, place if one.frame is None else 0)
        about = ("finding", one.code, one.text)
        found.append(Row(key, tuple(cells), texts([one.code, one.text]), leads=one.frame, about=about))
    found.reverse()
    return found


def latest(snapshot: Snapshot) -> Cell:
    """Returns the last error or warning in a line, or else the last info; nothing without findings."""
    found = snapshot.findings
    if not found:
        return NOTHING
    one = next((one for one in reversed(found) if one.severity in ("error", "warning")), found[-1])
    start, look = snapshot.start_ns, one.severity
    at = "" if one.t_ns is None or start is None else f"{seconds(one.t_ns - start, 3)}  "
    return ((f" {MARKS.get(look, '')} ", look), (at, "dim"), (f"{one.code}  ", look), (one.text, ""))
