"""The picture of what caused what: nodes as rows, time as x, spans of incidents, arrows from causes to consequences.

SVG made here, with classes instead of colours: the page has those. Must not: judge, or take a word from a capture but
names, which are escaped.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final
from xml.sax.saxutils import escape

from canalyze.output import printable

Record = Mapping[str, Any]

_LEFT: Final = 110
_WIDTH: Final = 1000
_ROW: Final = 26
_TOP: Final = 18
_ROWS: Final = 24
"""Nodes that are drawn."""
_SPANS: Final = 200
"""Incidents that are drawn."""
_TICKS: Final = 8


def chain(incidents: Sequence[Record], whole: Record, bus_word: str, node_word: str) -> str:
    """Give the picture; nothing where there are no stamps or nothing to draw. The words name the rows."""
    if whole["begin"] is None or whole["end"] is None:
        return ""
    begin, end = float(whole["begin"]), float(whole["end"])
    drawn = [one for one in incidents if one["begin"]["t"] is not None][:_SPANS]
    if not drawn or end <= begin:
        return ""
    rows: dict[tuple[str | None, int | None], int] = {}
    for one in drawn:
        for key in _keys(one):
            if len(rows) < _ROWS:
                rows.setdefault(key, len(rows))
    order = sorted(rows, key=lambda key: (key[0] or "", key[1] or 0))
    rows = {key: place for place, key in enumerate(order)}
    height = _TOP + _ROW * len(rows) + 22

    def x(t: float) -> float:
        return _LEFT + (t - begin) / (end - begin) * (_WIDTH - _LEFT - 20)

    def y(key: tuple[str | None, int | None]) -> float:
        return _TOP + _ROW * rows[key]

    parts = [f'<svg viewBox="0 0 {_WIDTH} {height}" role="img" xmlns="http://www.w3.org/2000/svg">']
    several = len(whole["buses"]) > 1
    for key in order:
        name = bus_word if key[1] is None else f"{node_word}{key[1]}"
        name = f"{key[0]} {name}" if several and key[0] else name
        parts.append(f'<text x="4" y="{y(key) + 14:.0f}">{escape(printable(name))}</text>')
        parts.append(
            f'<line class="axis" x1="{_LEFT}" x2="{_WIDTH - 20}" y1="{y(key) + 10:.0f}" y2="{y(key) + 10:.0f}"/>'
        )
    for tick in range(_TICKS + 1):
        t = begin + (end - begin) * tick / _TICKS
        left = x(t) - (28 if tick == _TICKS else 8)
        parts.append(f'<text class="soft" x="{left:.0f}" y="{height - 6}">{t - begin:.1f} s</text>')
    places: dict[int, tuple[float, float]] = {}
    for one in drawn:
        keys = [key for key in _keys(one) if key in rows]
        first = float(one["begin"]["t"])
        last = end if one["end"] is None or one["end"]["t"] is None else float(one["end"]["t"])
        for key in keys:
            size = max(x(last) - x(first), 3)
            parts.append(
                f'<rect class="{one["status"]}" x="{x(first):.1f}" y="{y(key) + 3:.0f}" width="{size:.1f}" height="14">'
                f"<title>{escape(printable(one['message']))}</title></rect>"
            )
        if keys:
            places[one["id"]] = (x(first), y(keys[0]) + 10)
    for one in drawn:
        cause = one["cause"]
        if cause is None or cause["id"] not in places or one["id"] not in places:
            continue
        (x1, y1), (x2, y2) = places[cause["id"]], places[one["id"]]
        bend = (x1 + x2) / 2 + 14
        parts.append(
            f'<path class="arrow" d="M{x1:.1f} {y1:.1f} C{bend:.1f} {y1:.1f} {bend:.1f} {y2:.1f} {x2:.1f} {y2:.1f}"/>'
        )
        parts.append(f'<path class="tip" d="M{x2:.1f} {y2:.1f} l6 -3 l0 6 z"/>')
        delay = _delay(one, incidents)
        if delay:
            parts.append(f'<text class="soft" x="{bend + 3:.1f}" y="{(y1 + y2) / 2:.1f}">{delay}</text>')
    parts.append("</svg>")
    return "".join(parts)


def _keys(one: Record) -> list[tuple[str | None, int | None]]:
    subject = one["subject"]
    nodes = subject.get("nodes") or ([subject["node"]] if "node" in subject else [])
    return [(subject["bus"], node) for node in nodes] or [(subject["bus"], None)]


def _delay(one: Record, incidents: Sequence[Record]) -> str:
    cause = next((other for other in incidents if other["id"] == one["cause"]["id"]), None)
    if cause is None or cause["begin"]["t"] is None:
        return ""
    ms = (float(one["begin"]["t"]) - float(cause["begin"]["t"])) * 1000
    return f"{ms:+.0f} ms" if ms else ""
