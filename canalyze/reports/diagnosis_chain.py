"""The picture of what caused what: nodes as rows, time as x, spans of incidents, arrows from causes to consequences.

SVG made here, with classes instead of colours: the page has those. Must not: judge, or take a word from a capture but
names, which are escaped.
"""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from canalyze.reports.diagnosis_axis import LEFT, RIGHT, WIDTH, Axis, Record, Texts, extent, grid, head, text, title
from canalyze.reports.diagnosis_text import root
from canalyze.values import nanoseconds
from canalyze.words import Words

Key = tuple[str | None, int | None]
"""A row: bus and node; no node: the bus itself."""

_BAR: Final = 16
_BETWEEN: Final = 18
"""Room between two rows: the delays stand there."""
_TOP: Final = 8
_ROWS: Final = 24
"""Nodes that are drawn."""
_SPANS: Final = 60
"""Problems that are drawn: whole stories, as they are read, so far as there is room."""
_NEAR: Final = 40
"""A delay that finds no place so near to its arrow is left to the text."""
_DIGIT: Final = 7
"""A digit of the number in a span is so wide; a span has room for it."""


class _Place(NamedTuple):
    """Where a span is: its begin, its middle, its row and the line of the row."""

    x: float
    y: float
    key: Key
    level: int


def chain(told: Mapping[str, Sequence[Record]], whole: Record, axis: Axis | None, words: Mapping[str, Words]) -> str:
    """Give the picture; nothing where there is nothing to draw. told: the incidents, by language."""
    incidents = next(iter(told.values()))
    drawn = _foremost(incidents, whole["order"])
    if axis is None or not drawn:
        return ""
    keys = sorted({key for one in drawn for key in keys_of(one)}, key=lambda key: (key[0] or "", key[1] or 0))[:_ROWS]
    spans = {one["id"]: _span(one, axis) for one in drawn}
    levels, heights = _levels(drawn, keys, spans)
    tops: dict[Key, float] = {}
    y = float(_TOP)
    for key in keys:
        tops[key] = y
        y += heights[key] * (_BAR + 2) + _BETWEEN
    bottom = y - _BETWEEN + 4
    several = len(whole["buses"]) > 1
    parts = [head(bottom + 20), grid(axis, 0, bottom, named=True)]
    for key in keys:
        parts.append(text(named(key, several, words), 4, tops[key] + 12))
    by_id = {lang: {one["id"]: one for one in each} for lang, each in told.items()}
    own = next(iter(by_id.values()))
    middles: dict[int, list[_Place]] = {}
    for one in drawn:
        number = one["id"]
        left, right = spans[number]
        said = {lang: f"{number} {each[number]['message']}" for lang, each in by_id.items()}
        for key in keys_of(one):
            if key not in tops:
                continue
            top = tops[key] + levels[number, key] * (_BAR + 2)
            middles.setdefault(number, []).append(_Place(left, top + _BAR / 2, key, levels[number, key]))
            parts.append(
                f'<a href="#problem-{root(one, own)["id"]}"><rect class="{one["status"]}" x="{left:.1f}" y="{top:.1f}" '
                f'width="{right - left:.1f}" height="{_BAR}" rx="2">{title(said)}</rect>'
                f'<text class="on" x="{left + 4:.1f}" y="{top + 12:.1f}">{number}</text></a>'
            )
    parts += _arrows(drawn, incidents, middles, {number: right for number, (_, right) in spans.items()})
    parts.append("</svg>")
    return "".join(parts)


def _foremost(incidents: Sequence[Record], order: Sequence[int]) -> list[Record]:
    """Give the incidents that are drawn, in order of their numbers."""
    by_id = {one["id"]: one for one in incidents if nanoseconds(one["begin"]["t"]) is not None}
    chosen: dict[int, Record] = {}
    for first in order:
        waiting = [first]
        while waiting and len(chosen) < _SPANS:
            one = by_id.get(waiting.pop(0))
            if one is not None and one["id"] not in chosen:
                chosen[one["id"]] = one
                waiting += [effect for effect in one["effects"] if effect in by_id and not by_id[effect]["root"]]
    return [chosen[number] for number in sorted(chosen)]


def keys_of(one: Record) -> list[Key]:
    """Give the rows of an incident."""
    subject = one["subject"]
    nodes = subject.get("nodes") or ([subject["node"]] if "node" in subject else [])
    return [(subject["bus"], node) for node in nodes] or [(subject["bus"], None)]


def named(key: Key, several: bool, words: Mapping[str, Words]) -> Texts:
    """Give what a row is called; several: the bus is named, too."""
    bus, node = key
    before = f"{bus} " if several and bus else ""
    return {
        lang: before + (each("diagnose.html_bus") if node is None else f"{each('diagnose.html_node')}{node}")
        for lang, each in words.items()
    }


def _span(one: Record, axis: Axis) -> tuple[float, float]:
    begin = nanoseconds(one["begin"]["t"]) or 0
    end = None if one["end"] is None else nanoseconds(one["end"]["t"])
    least = 8 + _DIGIT * len(str(one["id"]))
    left = min(axis.x(begin), WIDTH - RIGHT - least)
    right = axis.x(axis.end_ns if end is None else end)
    return left, max(right, left + least)


def _levels(
    drawn: Sequence[Record], keys: Sequence[Key], spans: Mapping[int, tuple[float, float]]
) -> tuple[dict[tuple[int, Key], int], dict[Key, int]]:
    """Give in which line of its row each span stands, so that none covers another, and how many lines a row has."""
    taken: dict[Key, list[float]] = {key: [] for key in keys}
    levels: dict[tuple[int, Key], int] = {}
    for one in sorted(drawn, key=lambda one: spans[one["id"]]):
        left, right = spans[one["id"]]
        for key in keys_of(one):
            if key not in taken:
                continue
            ends = taken[key]
            level = next((place for place, end in enumerate(ends) if end < left), len(ends))
            ends[level : level + 1] = [right]
            levels[one["id"], key] = level
    return levels, {key: max(len(ends), 1) for key, ends in taken.items()}


def _arrows(
    drawn: Sequence[Record],
    incidents: Sequence[Record],
    middles: Mapping[int, Sequence[_Place]],
    ends: Mapping[int, float],
) -> list[str]:
    """Give an arrow a cause and consequence, with the delay and its limit beside the tip. ends: where spans end."""
    parts: list[str] = []
    labels: list[tuple[float, float, float]] = []
    for one in drawn:
        cause = one["cause"]
        if cause is None or cause["id"] not in middles or one["id"] not in middles:
            continue
        place, goal = min(
            ((start, goal) for start in middles[cause["id"]] for goal in middles[one["id"]]),
            key=lambda both: abs(both[0].y - both[1].y),
        )
        (x1, y1), (x2, y2) = place[:2], goal[:2]
        said = one["texts"]["delay"]
        if place.key == goal.key or goal.level:  # between the spans of one row there is no room for an arrow
            said, room = f"← {cause['id']} {said}".rstrip(), 9 + _DIGIT * len(str(one["id"]))
            if x2 + room + extent(said) < min(WIDTH - RIGHT, ends[one["id"]]):
                parts.append(f'<a><text class="on" x="{x2 + room:.1f}" y="{y2 + 4:.1f}">{said}</text></a>')
            continue
        down = y2 > y1
        start, edge = (y1 + _BAR / 2, y2 - _BAR / 2) if down else (y1 - _BAR / 2, y2 + _BAR / 2)
        tip, back = x2 + 5, -6 if down else 6
        parts.append(
            f'<path class="arrow" d="M{x1 + 5:.1f} {start:.1f}C{x1 + 5:.1f} {edge:.1f} {tip:.1f} {start:.1f} '
            f'{tip:.1f} {edge + back:.1f}"/><path class="tip" d="M{tip:.1f} {edge:.1f}l-4 {back}h8z"/>'
        )
        if said:
            y = edge - 5 if down else edge + 12
            x = _free(labels, tip + 7, y, extent(said))
            if x is not None:
                parts.append(f'<text class="soft halo" x="{x:.1f}" y="{y:.1f}">{said}</text>')
    return parts


def _free(labels: list[tuple[float, float, float]], wanted: float, y: float, size: float) -> float | None:
    """Give where a label covers no other: there, or a little further right; None where it would be too far away."""
    x = min(wanted, WIDTH - RIGHT - size)
    for left, right, line in sorted(labels):
        if abs(line - y) < 10 and left < x + size and x < right:
            x = right + 8
    if x > wanted + _NEAR or x + size > WIDTH:
        return None
    labels.append((x, x + size, y))
    return max(x, LEFT)
