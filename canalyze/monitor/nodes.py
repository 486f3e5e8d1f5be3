"""The room of nodes: one line each, what it is, its state, heartbeat against its period, EMCY, drive, rate, problem."""

from typing import Any, Final

from canalyze.monitor.figures import BLANK, rate, seconds
from canalyze.monitor.grid import Cell, Column, Row, cell, leads, texts
from canalyze.monitor.incidents import of_node
from canalyze.words import Words

STATES: Final = {
    "05": "good",
    "7F": "warning",
    "04": "warning",
    "00": "info",
}
"""Looks of the states, by the byte that a heartbeat has: operational, pre-operational, stopped, booted up."""
_SECOND: Final = 1_000_000_000
_LATE: Final = 1.5
"""Periods without a heartbeat after which its age stands out; that it is missing is said by the core (`silent`)."""


def columns(words: Words, *, buses: bool) -> list[Column]:
    """Give the columns; that of the bus only where there are several."""
    given = [
        Column(words("col.node"), right=True),
        Column(words("col.name"), least=6, most=28, leaves=3),
        Column(words("col.node_state"), most=25),
        Column(words("col.heartbeat"), most=14),
        Column("EMCY", least=20, most=48),
        Column(words("monitor.drive"), least=10, most=30, leaves=2),
        Column(words("col.boot_ups"), most=8, right=True, leaves=5),
        Column(words("col.rate"), most=8, right=True, leaves=4),
        Column(words("col.findings"), least=16),
    ]
    return [Column(words("col.bus"), most=10), *given] if buses else given


def rows(snapshot: dict[str, Any], words: Words, *, buses: bool, away: frozenset[str] = frozenset()) -> list[Row]:
    """Give a row a node; away: the buses that cannot be listened to, of which nobody knows what their nodes do."""
    return [_row(node, snapshot, words, buses=buses, away=node["bus"] in away) for node in snapshot["nodes"]]


def about(node: dict[str, Any]) -> tuple[str, ...]:
    """Give what the page of a node is made of."""
    return "node", node["bus"], str(node["node"])


def _row(node: dict[str, Any], snapshot: dict[str, Any], words: Words, *, buses: bool, away: bool) -> Row:
    state, look = node["state_text"] or BLANK, STATES.get(node["state"] or "", "dim")
    unknown = (away or node["unknown"]) and not node["silent"]
    last = words("monitor.last_state", state=state)
    if unknown:
        state, look = words("monitor.unknown"), "warning"
    elif _is_late(node):
        look = "dim"
    silent = words.of("monitor_silent", node["silent"]) if node["silent"] else ""
    trouble = of_node(node)
    cells = [
        cell(node["node"], "strong"),
        cell(node["name"]),
        cell(silent or state, "error" if silent else look),
        _heartbeat(node, unknown=unknown),
        _emcy(node["emcy"], words),
        cell(node["drive"]),
        cell(node["boot_ups"] or BLANK, "" if node["boot_ups"] else "dim"),
        cell(rate(node["frames_per_s"])),
        cell(trouble, "error") if trouble else tally(node["findings"]),
    ]
    key = (node["bus"], node["node"])
    whole = texts(
        [
            words("monitor.node", node=node["node"]),
            node["name"],
            trouble,
            silent,
            state if unknown else "",
            last if silent or unknown else state,
            _emcy_text(node["emcy"], words),
            _since(node["emcy"], snapshot["start_ns"]),
            node["drive"],
        ]
    )
    where = leads(node["bus"] if buses else "", node=node["node"])
    return Row(key, (cell(node["bus"]), *cells) if buses else tuple(cells), whole, leads=where, about=about(node))


def _is_late(node: dict[str, Any]) -> bool:
    age, period = node["heartbeat_age_ns"], node["heartbeat_period_ns"]
    return bool(period and age is not None and age > period * _LATE)


def _heartbeat(node: dict[str, Any], *, unknown: bool) -> Cell:
    """Give the age of the last heartbeat against its period; unknown: it may have been missed."""
    age, period = node["heartbeat_age_ns"], node["heartbeat_period_ns"]
    if age is None:
        return cell(BLANK, "dim")
    if not period:
        return cell(f"{seconds(age)}s")
    digits = 1 if period >= _SECOND else 2
    look = "dim" if unknown else "error" if node["silent"] else "warning" if _is_late(node) else "good"
    return ((seconds(age, digits), look), (f"/{seconds(period, digits)}s", "dim"))


def _emcy(emcy: dict[str, Any] | None, words: Words) -> Cell:
    return cell(_emcy_text(emcy, words), "error" if emcy and emcy["active"] else "dim")


def _emcy_text(emcy: dict[str, Any] | None, words: Words) -> str:
    """Give the last emergency, how many stand beside it, and whether it is over."""
    if emcy is None:
        return ""
    text = f"{emcy['code']}h {emcy['text']}".rstrip()
    if not emcy["active"]:
        return words("monitor.emcy_over", text=text)
    return f"{text} (+{emcy['active'] - 1})" if emcy["active"] > 1 else text


def _since(emcy: dict[str, Any] | None, start_ns: int | None) -> str:
    """Give when that was, as the trace has it."""
    if emcy is None or emcy["t_ns"] is None or start_ns is None:
        return ""
    return f"@ {seconds(emcy['t_ns'] - start_ns, 3)}s"


def tally(found: dict[str, int]) -> Cell:
    """Give how many findings there are of each severity, those that there are."""
    pieces: list[tuple[str, str]] = []
    for severity, mark in (("error", "✖"), ("warning", "▲")):
        if found.get(severity):
            pieces.append((f"{' ' if pieces else ''}{mark}{found[severity]}", severity))
    return tuple(pieces)
