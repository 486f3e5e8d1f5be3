"""The view of SDO transfers: running ones with their progress, then ended ones, newest first."""

from typing import Final

from canalyze.monitor.grid import Cell, Column, Row, bar, cell, leads, period, seconds, size, texts
from canalyze.records.live import Done, Running, Snapshot
from canalyze.words import Words

_BAR: Final = 10
_LOOKS: Final = {"ok": "good", "aborted": "error", "failed": "error", "incomplete": "warning"}


def columns(words: Words, *, buses: bool) -> list[Column]:
    """Returns the columns; that of the bus only with several buses."""
    given = [
        Column(words("col.time"), most=10, right=True, leaves=3),
        Column(words("col.node"), right=True),
        Column(words("col.read_write")),
        Column(words("col.object")),
        Column(words("col.name"), least=8, most=40, leaves=1),
        Column(words("col.mode"), most=10, leaves=4),
        Column(words("col.size"), most=12, right=True),
        Column(words("col.duration"), most=8, right=True, leaves=2),
        Column(words("col.outcome"), least=24, most=60),
    ]
    return [Column(words("col.bus"), most=10), *given] if buses else given


def rows(snapshot: Snapshot, words: Words, *, buses: bool) -> list[Row]:
    """Returns the running transfers, then the ended ones, newest first."""
    start = snapshot.start_ns
    found = snapshot.transfers
    running = [_running(one, snapshot, words, buses=buses) for one in found.running]
    done = [_done(one, start, words, buses=buses) for one in reversed(found.done)]
    return running + done


def _running(one: Running, snapshot: Snapshot, words: Words, *, buses: bool) -> Row:
    start, now, since = snapshot.start_ns, snapshot.now_ns, one.since_ns
    cells = (
        _since(since, start),
        cell(one.node, "strong"),
        cell(words.of("access", one.direction)),
        cell(one.object),
        cell(one.name),
        cell(words.of("mode", one.mode)),
        cell(_progress(one), "info"),
        cell(period(None if since is None or now is None else max(0, now - since))),
        _bar(one, words),
    )
    key = ("runs", one.bus, one.node, one.direction, one.index, one.sub)
    whole = texts([one.object, one.name, _progress(one)])
    where = leads(one.bus if buses else "", service="sdo", node=one.node)
    return Row(key, (cell(one.bus), *cells) if buses else cells, whole, leads=where)


def _since(at: int | None, start: int | None) -> Cell:
    return cell(seconds(None if at is None or start is None else at - start, 3), "dim")


def _progress(one: Running) -> str:
    return size(one.bytes) if one.size is None else f"{size(one.bytes)}/{size(one.size)}"


def _bar(one: Running, words: Words) -> Cell:
    if not one.size:
        return cell(words("monitor.runs"), "info")
    part = one.bytes / one.size
    return ((f"{min(part, 1.0):4.0%} ", ""), (bar(part, _BAR), "info"))


def _done(one: Done, start: int | None, words: Words, *, buses: bool) -> Row:
    status = words.of("status", one.status)
    abort = one.abort
    outcome = texts([status, f"{abort.digits}h", abort.text] if abort else [status, one.text])
    cells = (
        _since(one.t_ns, start),
        cell(one.node, "strong"),
        cell(words.of("access", one.direction)),
        cell(one.object),
        cell(one.name),
        cell(words.of("mode", one.mode)),
        cell(size(one.size)),
        cell(period(one.duration_ns)),
        cell(outcome, _LOOKS.get(one.status, "")),
    )
    return Row(
        ("ended", one.number, one.last_frame),
        (cell(one.bus), *cells) if buses else cells,
        texts([one.object, one.name, outcome]),
        leads=one.first_frame,
    )
