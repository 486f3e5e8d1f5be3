"""The room of objects: one line for each COB-ID, updated in place, with its last data and what they mean."""

from typing import Any, Final

from canalyze.monitor.figures import period, rate
from canalyze.monitor.grid import Cell, Column, Row, cell, leads, texts
from canalyze.words import Words

_SPACED: Final = 110
"""Columns of the terminal from which the bytes of the data stand apart."""


def columns(words: Words, *, buses: bool, width: int) -> list[Column]:
    """Give the columns; that of the bus only where there are several."""
    given = [
        Column("ID"),
        Column(words("monitor.object"), least=7, most=24),
        Column(words("col.count"), most=9, right=True, leaves=4),
        Column(words("col.period"), most=8, right=True, leaves=2),
        Column(words("monitor.jitter"), most=8, right=True, leaves=3),
        Column(words("col.rate"), most=8, right=True, leaves=5),
        Column(words("monitor.data"), least=16, most=16 if width < _SPACED else 48),
        Column(words("col.meaning"), least=24, most=400),
    ]
    return [Column(words("col.bus"), most=10), *given] if buses else given


def rows(snapshot: dict[str, Any], words: Words, *, buses: bool, width: int) -> list[Row]:
    """Give a row an object."""
    return [_row(one, words, buses=buses, spaced=width >= _SPACED) for one in snapshot["objects"]]


def _row(one: dict[str, Any], words: Words, *, buses: bool, spaced: bool) -> Row:
    name = _name(one, words)
    cells = (
        cell(one["id"], "strong"),
        cell(name),
        cell(one["count"]),
        cell(period(one["period_ns"])),
        cell(period(one["jitter_ns"]), "dim"),
        cell(rate(one["rate"])),
        _data(one["data"], one["changed"], " " if spaced else ""),
        cell(_meaning(one), one["severity"] if one["severity"] in ("error", "warning") else ""),
    )
    key = (one["bus"], one["id"], one["rtr"])
    whole = texts([one["id"], name, one["data"], one["text"]])
    where = leads(one["bus"] if buses else "", id=one["id"])
    return Row(key, (cell(one["bus"]), *cells) if buses else cells, whole, leads=where)


def _name(one: dict[str, Any], words: Words) -> str:
    """Give what it is called: the PDO or the service, with the node where there is one."""
    name = one["name"] or one["service"] or ""
    return name if one["node"] is None else words("monitor.of_node", node=one["node"], name=name)


def _meaning(one: dict[str, Any]) -> str:
    """Give what its last frame means, without the name that stands in the line already."""
    head, colon, rest = str(one["text"]).partition(": ")
    return rest if colon and rest and one["name"] and one["name"] in head else str(one["text"])


def _data(data: str, changed: str, gap: str) -> Cell:
    """Give the bytes, those marked that changed."""
    pieces: list[tuple[str, str]] = []
    for place in range(0, len(data), 2):
        look = "changed" if changed[place : place + 2].upper() == "FF" else ""
        text = data[place : place + 2].upper() + (gap if place + 2 < len(data) else "")
        if pieces and pieces[-1][1] == look:
            pieces[-1] = (pieces[-1][0] + text, look)
        else:
            pieces.append((text, look))
    return tuple(pieces)
