"""The view of objects: one line per COB-ID, updated in place, with its last data and their meaning."""

from typing import Final

from canalyze.monitor.grid import Cell, Column, Row, cell, leads, period, rate, texts
from canalyze.records.live import Object, Snapshot
from canalyze.words import Words

_STALE: Final = 3
"""Number of periods after which a periodic object is old."""
_LEAST_NS: Final = 200_000_000
"""Minimum age of an old object, for short periods."""
_SPACED: Final = 110
"""Minimum columns of the terminal for blanks between the bytes of the data."""


def columns(words: Words, *, buses: bool, width: int) -> list[Column]:
    """Returns the columns; that of the bus only with several buses."""
    given = [
        Column("ID"),
        Column(words("monitor.object"), least=7, most=24),
        Column(words("col.count"), most=9, right=True, leaves=4),
        Column(words("col.period"), most=12, right=True, leaves=2),
        Column(words("monitor.jitter"), most=8, right=True, leaves=3),
        Column(words("col.rate"), most=8, right=True, leaves=5),
        Column(words("monitor.data"), least=16, most=16 if width < _SPACED else 48),
        Column(words("col.meaning"), least=24, most=400),
    ]
    return [Column(words("col.bus"), most=10), *given] if buses else given


def rows(snapshot: Snapshot, words: Words, *, buses: bool, width: int) -> list[Row]:
    """Returns one row per object."""
    now = snapshot.now_ns
    return [_row(one, now, words, buses=buses, spaced=width >= _SPACED) for one in snapshot.objects]


def _row(one: Object, now: int | None, words: Words, *, buses: bool, spaced: bool) -> Row:
    name = _name(one, words)
    age = _age(one, now)
    ago = "" if age is None else words("monitor.ago", age=period(age))
    fresh = "" if age is None else "dim"
    cells = (
        cell(one.id, fresh or "strong"),
        cell(name, fresh),
        cell(one.count, fresh),
        cell(ago, "warning") if ago else cell(period(one.period_ns)),
        cell(period(one.jitter_ns), "dim"),
        cell(rate(one.rate), fresh),
        cell(_closer(one.data, " " if spaced else ""), fresh)
        if ago
        else _data(one.data, one.changed, " " if spaced else ""),
        cell(_meaning(one), one.severity if one.severity in ("error", "warning") else fresh),
    )
    key = (one.bus, one.id, one.rtr)
    whole = texts([one.id, name, ago, one.data, one.text])
    where = leads(one.bus if buses else "", id=one.id)
    return Row(key, (cell(one.bus), *cells) if buses else cells, whole, leads=where)


def _age(one: Object, now: int | None) -> int | None:
    """Returns the age of the last frame if a periodic object has stopped, or else None."""
    last, usual, jitter = one.last_ns, one.period_ns, one.jitter_ns
    if now is None or last is None or usual is None or jitter is None or jitter > usual // 2:
        return None
    age = now - last
    return age if age > max(_STALE * usual, _LEAST_NS) else None


def _closer(data: str, gap: str) -> str:
    return gap.join(data[place : place + 2].upper() for place in range(0, len(data), 2))


def _name(one: Object, words: Words) -> str:
    """Returns the name of an object: the PDO or the service, with its node if it has one."""
    name = one.name or one.service
    return name if one.node is None else words("monitor.of_node", node=one.node, name=name)


def _meaning(one: Object) -> str:
    """Returns the meaning of its last frame, without a name that is shown already."""
    head, colon, rest = one.text.partition(": ")
    return rest if colon and rest and one.name and one.name in head else one.text


def _data(data: str, changed: str, gap: str) -> Cell:
    """Returns the bytes, with the changed ones highlighted."""
    pieces: list[tuple[str, str]] = []
    for place in range(0, len(data), 2):
        look = "changed" if changed[place : place + 2].upper() == "FF" else ""
        text = data[place : place + 2].upper() + (gap if place + 2 < len(data) else "")
        if pieces and pieces[-1][1] == look:
            pieces[-1] = (pieces[-1][0] + text, look)
        else:
            pieces.append((text, look))
    return tuple(pieces)
