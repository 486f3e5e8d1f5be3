"""The room of nodes: one line each, what it is, its state, its heartbeat against its period, EMCY, drive, rate."""

from typing import Any, Final

from canalyze.monitor.figures import BLANK, rate, seconds
from canalyze.monitor.grid import NOTHING, Cell, Column, Row, cell, leads, texts
from canalyze.words import Words

STATES: Final = {
    "05": "good",
    "7F": "warning",
    "04": "error",
    "00": "info",
}
"""Looks of the states, by the byte that a heartbeat has: operational, pre-operational, stopped, initialising."""
_SECOND: Final = 1_000_000_000
_LATE: Final = 1.5
"""Periods without a heartbeat after which its age stands out. The verdict is the core's finding, not this colour."""


def columns(words: Words, *, buses: bool) -> list[Column]:
    """Give the columns; that of the bus only where there are several."""
    given = [
        Column(words("col.node"), right=True),
        Column(words("col.name"), least=6, most=28, leaves=3),
        Column(words("col.node_state"), most=18),
        Column(words("col.heartbeat"), most=14),
        Column("EMCY", least=16, most=48),
        Column(words("monitor.drive"), least=10, most=30, leaves=2),
        Column(words("col.boot_ups"), most=8, right=True, leaves=5),
        Column(words("col.rate"), most=8, right=True, leaves=4),
        Column(words("col.findings"), most=10),
    ]
    return [Column(words("col.bus"), most=10), *given] if buses else given


def rows(snapshot: dict[str, Any], words: Words, *, buses: bool) -> list[Row]:
    """Give a row a node."""
    return [_row(node, words, buses=buses) for node in snapshot["nodes"]]


def _row(node: dict[str, Any], words: Words, *, buses: bool) -> Row:
    state = node["state_text"] or BLANK
    cells = [
        cell(node["node"], "strong"),
        cell(node["name"]),
        cell(state, STATES.get(node["state"] or "", "dim")),
        _heartbeat(node),
        _emcy(node["emcy"]),
        cell(node["drive"]),
        cell(node["boot_ups"] or BLANK, "" if node["boot_ups"] else "dim"),
        cell(rate(node["frames_per_s"])),
        tally(node["findings"]),
    ]
    key = (node["bus"], node["node"])
    whole = texts(
        [
            words("monitor.node", node=node["node"]),
            node["name"],
            state,
            _emcy_text(node["emcy"]),
            node["drive"],
        ]
    )
    where = leads(node["bus"] if buses else "", node=node["node"])
    return Row(key, (cell(node["bus"]), *cells) if buses else tuple(cells), whole, leads=where)


def _heartbeat(node: dict[str, Any]) -> Cell:
    """Give the age of the last heartbeat against its period."""
    age, period = node["heartbeat_age_ns"], node["heartbeat_period_ns"]
    if age is None:
        return cell(BLANK, "dim")
    if not period:
        return cell(f"{seconds(age)}s")
    digits = 1 if period >= _SECOND else 2
    look = "error" if age > period * _LATE else "good"
    return ((seconds(age, digits), look), (f"/{seconds(period, digits)}s", "dim"))


def _emcy(emcy: dict[str, Any] | None) -> Cell:
    if emcy is None:
        return NOTHING
    return cell(_emcy_text(emcy), "error" if emcy["active"] else "dim")


def _emcy_text(emcy: dict[str, Any] | None) -> str:
    if emcy is None:
        return ""
    more = f" (+{emcy['active'] - 1})" if emcy["active"] > 1 else ""
    return f"{emcy['code']}h {emcy['text']}{more}"


def tally(found: dict[str, int]) -> Cell:
    """Give how many findings there are of each severity, those that there are."""
    pieces: list[tuple[str, str]] = []
    for severity, mark in (("error", "✖"), ("warning", "▲")):
        if found.get(severity):
            pieces.append((f"{' ' if pieces else ''}{mark}{found[severity]}", severity))
    return tuple(pieces)
