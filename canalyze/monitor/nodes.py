"""The view of nodes: name, state, heartbeat and its period, EMCY, drive, rate and problem of each."""

from collections.abc import Mapping
from typing import Final

from canalyze.monitor.grid import BLANK, Cell, Column, Row, cell, leads, rate, seconds, texts
from canalyze.monitor.problems import of_node
from canalyze.records.live import Emergency, Node, Snapshot
from canalyze.words import Words

STATES: Final = {
    "05": "good",
    "7F": "warning",
    "04": "warning",
    "00": "info",
}
"""Styles of the states, by the byte of the heartbeat: operational, pre-operational, stopped, booted up."""
_SECOND: Final = 1_000_000_000
_LATE: Final = 1.5
"""Number of periods without a heartbeat after which its age is highlighted; a missing one is `silent`."""


def columns(words: Words, *, buses: bool) -> list[Column]:
    """Returns the columns; that of the bus only with several buses."""
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


def rows(snapshot: Snapshot, words: Words, *, buses: bool, away: frozenset[str] = frozenset()) -> list[Row]:
    """Returns one row per node; away: lost buses, whose nodes have an unknown state."""
    return [_row(node, snapshot, words, buses=buses, away=node.bus in away) for node in snapshot.nodes]


def about(node: Node) -> tuple[str, ...]:
    """Returns the subject of the page of a node."""
    return "node", node.bus, str(node.node)


def _row(node: Node, snapshot: Snapshot, words: Words, *, buses: bool, away: bool) -> Row:
    state, look = node.state_text or BLANK, STATES.get(node.state or "", "dim")
    unknown = (away or node.unknown) and not node.silent
    last = words("monitor.last_state", state=state)
    if unknown:
        state, look = words("monitor.unknown"), "warning"
    elif _is_late(node):
        look = "dim"
    silent = words.of("monitor_silent", node.silent) if node.silent else ""
    trouble = of_node(node)
    cells = [
        cell(node.node, "strong"),
        cell(node.name),
        cell(silent or state, "error" if silent else look),
        _heartbeat(node, unknown=unknown),
        _emcy(node.emcy, words),
        cell(node.drive),
        cell(node.boot_ups or BLANK, "" if node.boot_ups else "dim"),
        cell(rate(node.frames_per_s)),
        cell(trouble, "error") if trouble else tally(node.findings),
    ]
    key = (node.bus, node.node)
    whole = texts(
        [
            words("monitor.node", node=node.node),
            node.name,
            trouble,
            silent,
            state if unknown else "",
            last if silent or unknown else state,
            _emcy_text(node.emcy, words),
            _since(node.emcy, snapshot.start_ns),
            node.drive,
        ]
    )
    where = leads(node.bus if buses else "", node=node.node)
    return Row(key, (cell(node.bus), *cells) if buses else tuple(cells), whole, leads=where, about=about(node))


def _is_late(node: Node) -> bool:
    age, period = node.heartbeat_age_ns, node.heartbeat_period_ns
    return bool(period and age is not None and age > period * _LATE)


def _heartbeat(node: Node, *, unknown: bool) -> Cell:
    """Returns the age of the last heartbeat and its period; unknown: it may have been missed."""
    age, period = node.heartbeat_age_ns, node.heartbeat_period_ns
    if age is None:
        return cell(BLANK, "dim")
    if not period:
        return cell(f"{seconds(age)}s")
    digits = 1 if period >= _SECOND else 2
    look = "dim" if unknown else "error" if node.silent else "warning" if _is_late(node) else "good"
    return ((seconds(age, digits), look), (f"/{seconds(period, digits)}s", "dim"))


def _emcy(emcy: Emergency | None, words: Words) -> Cell:
    return cell(_emcy_text(emcy, words), "error" if emcy and emcy.active else "dim")


def _emcy_text(emcy: Emergency | None, words: Words) -> str:
    """Returns the last emergency, the number of further active ones, and its end."""
    if emcy is None:
        return ""
    text = f"{emcy.code}h {emcy.text}".rstrip()
    if not emcy.active:
        return words("monitor.emcy_over", text=text)
    return f"{text} (+{emcy.active - 1})" if emcy.active > 1 else text


def _since(emcy: Emergency | None, start_ns: int | None) -> str:
    """Returns the time of an emergency, as in the trace."""
    if emcy is None or emcy.t_ns is None or start_ns is None:
        return ""
    return f"@ {seconds(emcy.t_ns - start_ns, 3)}s"


def tally(found: Mapping[str, int]) -> Cell:
    """Returns the numbers of findings by severity, without zeros."""
    pieces: list[tuple[str, str]] = []
    for severity, mark in (("error", "✖"), ("warning", "▲")):
        if found.get(severity):
            pieces.append((f"{' ' if pieces else ''}{mark}{found[severity]}", severity))
    return tuple(pieces)
