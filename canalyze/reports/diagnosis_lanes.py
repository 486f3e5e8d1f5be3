"""Pictures below that of causes, on the same axis: the states of nodes and drives, and values around a moment.

What is drawn comes from the core's tables of lanes and signals. Must not: judge, or find out a state by itself.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from canalyze.reports.diagnosis_axis import (
    LEFT,
    RIGHT,
    WIDTH,
    Axis,
    Record,
    grid,
    head,
    moments_of,
    shortened,
    text,
    title,
)
from canalyze.reports.diagnosis_chain import Key, keys_of, named
from canalyze.values import nanoseconds
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Batch

TABLES: Final = ("lanes", "findings")
"""What of the core's tables is taken."""
SIGNALS: Final = "signals"
"""And where nodes are concerned whose values are shown."""
KINDS: Final = {"nmt": "diagnose.html_nmt", "drive": "diagnose.html_drive"}
"""What a kind of lane is called."""
LANES: Final = 16
"""Lanes that are drawn."""
PLOTS: Final = 6
"""Values that are drawn of one story."""
STORIES: Final = 8
"""Stories of which values are drawn."""
_SERIES: Final = 48
"""Signals that are kept of one story."""
_POINTS: Final = 240
"""Samples of a signal that are kept, about twice: then of two neighbours the one that says more."""
_PAD_NS: Final = 1_000_000_000
_OTHERS: Final = 200
_LANE: Final = re.compile(r"(nmt|drive)/(?:(.*)/)?node(\d+)(?:/axis(\d+))?")
_HEIGHT: Final = 16
_NARROW: Final = (0.3, 1.5, 4.0, 12.0, 50.0)
"""States narrower than this are left out, in units: the first with which a lane is not too long counts."""
_LONGEST: Final = 20_000
"""Characters of a lane."""
_FAULTS: Final = frozenset({"lost", "fault", "fault-reaction-active", "stopped"})
"""States that are looked for."""


@dataclass(slots=True)
class Lane:
    """States of one node or drive: when each began; None where nothing is known."""

    kind: str
    key: Key
    axis: int
    changes: list[tuple[int, str | None, str | None]] = field(default_factory=list)
    """Time in ns, state in words, class."""


@dataclass(slots=True)
class Plot:
    """Values of one signal around a moment."""

    name: str
    key: Key
    unit: str | None
    points: list[tuple[int, float]] = field(default_factory=list)

    def add(self, t_ns: int, value: float) -> None:
        """Take a sample; where there are too many, every second one goes that is neither highest nor lowest."""
        self.points.append((t_ns, value))
        if len(self.points) >= 2 * _POINTS:
            first, *inner, last = self.points
            fours = (inner[place : place + 4] for place in range(0, len(inner), 4))
            kept = (point for four in fours for point in sorted({min(four, key=_value), max(four, key=_value)}))
            self.points = [first, *kept, last]


@dataclass(slots=True)
class Other:
    """Findings of one rule on one node that belong to no incident."""

    code: str
    severity: str
    node: int | None
    bus: str | None
    frame: int
    message: str
    count: int = 1


@dataclass(slots=True)
class Beside:
    """What the page shows beside incidents, in one language."""

    lanes: list[Lane] = field(default_factory=list)
    plots: dict[int, list[Plot]] = field(default_factory=dict)
    """By the number of the story."""
    others: list[Other] = field(default_factory=list)


def _value(point: tuple[int, float]) -> float:
    return point[1]


@dataclass(frozen=True)
class _Story:
    """The moment of a story and who is concerned."""

    root: int
    begin_ns: int
    end_ns: int
    nodes: tuple[Key, ...]


class Gatherer:
    """Takes batches of the core's tables, and keeps what the page shows of them."""

    def __init__(self, incidents: Sequence[Record], order: Sequence[int]) -> None:
        """Take the incidents, of any language: what is kept is about them. order: the roots as they are read."""
        self._stories = list(_stories(incidents, order))
        self._told = {(entry["code"], entry["frame"]) for one in incidents for entry in one["findings"]}
        self._lanes: dict[str, Lane] = {}
        self._series: dict[tuple[int, Any], Plot] = {}
        self._counts: dict[int, int] = {}
        self._others: dict[tuple[str, str | None, int | None], Other] = {}

    @property
    def select(self) -> str | None:
        """Which signals are asked for, as the core's sessions have it; None: no signal is."""
        nodes = sorted({node for story in self._stories for _, node in story.nodes if node is not None})
        return ",".join(f"{node}.*" for node in nodes) or None

    def take(self, batches: "Sequence[tuple[str, Batch]]") -> None:
        """Take batches as they come."""
        for name, batch in batches:
            _TAKES[name](self, batch)

    def beside(self) -> Beside:
        """Give what is shown."""
        plots: dict[int, list[Plot]] = {}
        for story in self._stories:
            kept = [plot for (root, _), plot in self._series.items() if root == story.root and len(plot.points) > 1]
            alive = [plot for plot in kept if len({value for _, value in plot.points}) > 1]
            plots[story.root] = _in_turn(alive, story.nodes)
        return Beside(list(self._lanes.values()), plots, list(self._others.values())[:_OTHERS])

    def _states(self, batch: "Batch") -> None:
        names = batch.column("lane")
        times, states, classes = (batch.column(name) for name in ("t_ns", "state", "class"))
        for name, t_ns, state, of_class in zip(names, times, states, classes, strict=True):
            found = _LANE.fullmatch(name)
            if found is None or t_ns is None:
                continue
            if name not in self._lanes:
                key = (found[2], int(found[3]))
                self._lanes[name] = Lane(found[1], key, int(found[4] or 0))
            self._lanes[name].changes.append((t_ns, state, of_class))

    def _signals(self, batch: "Batch") -> None:
        times = batch.column("t_ns")
        known = [t_ns for t_ns in times if t_ns is not None]
        stories = [one for one in self._stories if known and known[0] <= one.end_ns and known[-1] >= one.begin_ns]
        if not stories:
            return
        columns = (batch.column(name) for name in ("bus", "node", "pdo", "object", "signal", "unit", "value"))
        for t_ns, bus, node, pdo, index, name, unit, value in zip(times, *columns, strict=True):
            if t_ns is None or value is None:
                continue
            for story in stories:
                if not story.begin_ns <= t_ns <= story.end_ns or (bus, node) not in story.nodes:
                    continue
                key = (story.root, (bus, node, pdo, index, name))
                if key not in self._series:
                    if self._counts.get(story.root, 0) >= _SERIES:
                        continue
                    self._counts[story.root] = self._counts.get(story.root, 0) + 1
                    self._series[key] = Plot(f"{node}.{pdo} {name}", (bus, node), unit)
                self._series[key].add(t_ns, float(value))

    def _findings(self, batch: "Batch") -> None:
        columns = (
            batch.column(name) for name in ("code", "severity", "frame", "about_frame", "bus", "node", "message")
        )
        for code, severity, frame, about, bus, node, message in zip(*columns, strict=True):
            if (code, frame) in self._told:
                continue
            known = self._others.get((code, bus, node))
            if known is None:
                self._others[code, bus, node] = Other(code, severity, node, bus, about or frame or 0, message)
            else:
                known.count += 1


_TAKES: Final = {"lanes": Gatherer._states, "signals": Gatherer._signals, "findings": Gatherer._findings}


def _stories(incidents: Sequence[Record], order: Sequence[int]) -> Iterator[_Story]:
    by_id = {one["id"]: one for one in incidents}
    for root in [number for number in order if number in by_id][:STORIES]:
        tree = tree_of(by_id[root], by_id)
        moments = [t_ns for one in tree for t_ns in moments_of(one)]
        nodes = dict.fromkeys(key for one in tree for key in keys_of(one) if key[1] is not None)
        if moments and nodes:
            pad = max(_PAD_NS, (max(moments) - min(moments)) // 4)
            yield _Story(root, min(moments) - pad, max(moments) + pad, tuple(nodes))


def _in_turn(plots: Sequence[Plot], nodes: Sequence[Key]) -> list[Plot]:
    """Give first one of each node, then a second; of a node first what it sends."""
    ranked = []
    for key in nodes:
        mine = sorted((plot for plot in plots if plot.key == key), key=lambda plot: ".RPDO" in plot.name)
        ranked += [(place, nodes.index(key), plot) for place, plot in enumerate(mine)]
    chosen = sorted(ranked, key=lambda one: one[:2])[:PLOTS]
    return [plot for _, _, plot in sorted(chosen, key=lambda one: (one[1], one[0]))]


def tree_of(root: Record, by_id: Mapping[int, Record]) -> list[Record]:
    """Give an incident with all that comes from it, the nearest first."""
    found, waiting = list[Record](), [root]
    while waiting:
        one = waiting.pop(0)
        found.append(one)
        waiting += [by_id[effect] for effect in one["effects"] if effect in by_id and not by_id[effect]["root"]]
    return found


def lanes(
    told: Mapping[str, Sequence[Lane]],
    incidents: Sequence[Record],
    whole: Record,
    axis: Axis | None,
    words: Mapping[str, Words],
) -> str:
    """Give the states over time; nothing where none is known. told: the same lanes in each language."""
    if axis is None or not next(iter(told.values()), ()):
        return ""
    concerned = {key for one in incidents for key in keys_of(one)}
    every = list(zip(*told.values(), strict=True))
    every = [
        same for same in every if any(axis.begin_ns <= change[0] <= axis.end_ns for change in _within(same[0], axis))
    ]
    every.sort(
        key=lambda same: (
            same[0].key not in concerned,
            same[0].key[0] or "",
            same[0].key[1] or 0,
            -ord(same[0].kind[0]),
        )
    )
    shown = every[:LANES]
    if not shown:
        return ""
    several = len(whole["buses"]) > 1
    bottom = 4.0 + len(shown) * (_HEIGHT + 4)
    parts = [head(bottom + 20), grid(axis, 0, bottom, named=True)]
    for place, same in enumerate(shown):
        top = 4.0 + place * (_HEIGHT + 4)
        first = same[0]
        of_axis = f" {first.axis}" if first.axis else ""
        names = {
            lang: f"{name} {words[lang](KINDS[first.kind])}{of_axis}"
            for lang, name in named(first.key, several, words).items()
        }
        parts.append(text(names, 4, top + 12))
        for least in _NARROW:
            drawn = _periods(dict(zip(told, same, strict=True)), axis, top, least)
            if sum(map(len, drawn)) < _LONGEST:
                break
        parts += drawn
    parts.append("</svg>")
    left_out = len(every) - len(shown)
    if left_out:
        more = (
            f'<span lang="{lang}">{each("diagnose.node_more", count=left_out)}</span>' for lang, each in words.items()
        )
        parts.append(f'<p class="because">{"".join(more)}</p>')
    return "".join(parts)


def _within(lane: Lane, axis: Axis) -> list[tuple[int, str | None, str | None]]:
    """Give the changes on the axis, with the state in which the lane comes to it."""
    before = [change for change in lane.changes if change[0] < axis.begin_ns][-1:]
    entered = [(axis.begin_ns, state, of_class) for _, state, of_class in before]
    return entered + [change for change in lane.changes if axis.begin_ns <= change[0] <= axis.end_ns]


def _periods(same: Mapping[str, Lane], axis: Axis, top: float, least: float) -> list[str]:
    """Give the states of a lane; least: what is narrower is left out, behind another such one, unless it is a fault."""
    within = {lang: _within(lane, axis) for lang, lane in same.items()}
    first = next(iter(within.values()))
    parts = []
    drawn_to = 0.0
    for place, (t_ns, state, of_class) in enumerate(first):
        if state is None:
            continue
        end = first[place + 1][0] if place + 1 < len(first) else axis.end_ns
        left, right = axis.x(t_ns), axis.x(end)
        narrow = least / 4 if of_class in _FAULTS else least
        if right - left < narrow and right - drawn_to < narrow:
            continue
        drawn_to = right
        said = {lang: changes[place][1] or "" for lang, changes in within.items()}
        spoken = {
            lang: f"{one} {(t_ns - axis.origin_ns) / 1e9:.3f}-{(end - axis.origin_ns) / 1e9:.3f} s"
            for lang, one in said.items()
        }
        parts.append(
            f'<rect class="state s-{of_class or "unknown"}" x="{left:.1f}" y="{top:.0f}" '
            f'width="{max(right - left, 0.8):.1f}" height="{_HEIGHT}">{title(spoken)}</rect>'
        )
        inside = {lang: shortened(one, right - left - 6) for lang, one in said.items()}
        if any(inside.values()):
            parts.append(text(inside, left + 3, top + 12, "on"))
    return parts


_PLOT: Final = 48
_NAME: Final = 24
"""Room for the name of a plot above it."""
_STOPS: Final = 6
"""Samples so many times further apart than usual are not joined: nobody knows what was between."""


def plots(told: Mapping[str, Sequence[Plot]], story: Sequence[Record], origin_ns: int) -> str:
    """Give the values around a story; nothing where none is known. story: its incidents, the root first."""
    every = list(zip(*told.values(), strict=True))
    if not every:
        return ""
    times = [t_ns for same in every for t_ns, _ in same[0].points]
    axis = Axis(origin_ns, min(times), max(times))
    if axis.end_ns <= axis.begin_ns:
        return ""
    bottom = 4.0 + len(every) * (_PLOT + _NAME)
    parts = [head(bottom + 20), grid(axis, 0, bottom, named=True)]
    for one in story:
        begin = nanoseconds(one["begin"]["t"])
        if begin is not None and axis.begin_ns <= begin <= axis.end_ns:
            parts.append(
                f'<path class="moment" d="M{axis.x(begin):.1f} 0V{bottom:.0f}"><title>{one["id"]}</title></path>'
            )
    for place, same in enumerate(every):
        parts.append(_plot(dict(zip(told, same, strict=True)), axis, 20.0 + place * (_PLOT + _NAME)))
    parts.append("</svg>")
    return "".join(parts)


def _plot(same: Mapping[str, Plot], axis: Axis, top: float) -> str:
    first = next(iter(same.values()))
    values = [value for _, value in first.points]
    least, most = min(values), max(values)
    scale = (_PLOT - 4) / (most - least)

    def y(value: float) -> float:
        return top + 2 + (most - value) * scale

    gaps = sorted(later[0] - one[0] for one, later in pairwise(first.points))
    longest = gaps[len(gaps) // 2] * _STOPS
    steps = [f"M{axis.x(first.points[0][0]):.1f} {y(first.points[0][1]):.1f}"]
    for (before, _), (t_ns, value) in pairwise(first.points):
        steps.append(
            f"M{axis.x(t_ns):.1f} {y(value):.1f}" if t_ns - before > longest else f"H{axis.x(t_ns):.1f}V{y(value):.1f}"
        )
    unit = f" {first.unit}" if first.unit else ""
    names = {lang: plot.name + unit for lang, plot in same.items()}
    return (
        text(names, LEFT, top - 4, "soft halo")
        + f'<text class="soft" text-anchor="end" x="{LEFT - 6}" y="{top + 12:.0f}">{most:g}</text>'
        + f'<text class="soft" text-anchor="end" x="{LEFT - 6}" y="{top + _PLOT:.0f}">{least:g}</text>'
        + f'<path class="frame" d="M{LEFT} {top:.0f}H{WIDTH - RIGHT}v{_PLOT}H{LEFT}z"/>'
        + f'<path class="line" d="{"".join(steps)}"/>'
    )
