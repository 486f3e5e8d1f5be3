"""Chooses the signals that share a plot, the plots of the overview, and the colours of states and lines.

A plot has one Y axis: lines of one unit and one kind of object share it; lines without a unit share it if they have
a similar magnitude. Varying signals come before constant ones, named signals before those with only an index.

Colours are by the classes of the core: the same state has the same colour in every lane. Green runs, amber waits, red
is a fault, violet is lost, grey is unknown or off. Must not: name anything, or know words for people.
"""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from canalyze.timeline.stream import Contents, Series

_GREY, _LIGHT, _BLUE, _GREEN, _AMBER, _ORANGE, _RED, _VIOLET = (
    0x8A8F98FF,
    0x5B6470FF,
    0x3D85D6FF,
    0x3FA34DFF,
    0xE0A526FF,
    0xE8772EFF,
    0xD6453DFF,
    0x8E5BD0FF,
)

_DRIVE: Final = {
    "not-ready-to-switch-on": _LIGHT,
    "switch-on-disabled": _GREY,
    "ready-to-switch-on": _AMBER,
    "switched-on": _BLUE,
    "operation-enabled": _GREEN,
    "quick-stop-active": _ORANGE,
    "fault-reaction-active": _RED,
    "fault": _RED,
}

COLOURS: Final[dict[str, dict[str, int]]] = {
    "nmt": {
        "initialising": _BLUE,
        "pre-operational": _AMBER,
        "operational": _GREEN,
        "stopped": _RED,
        "lost": _VIOLET,
        "unknown": _GREY,
    },
    "drive": _DRIVE,
    "sdo": {"ok": _BLUE, "aborted": _RED, "failed": _RED, "incomplete": _GREY},
    "emcy": {"active": _RED},
    "problems": {"open": _RED, "unknown": _ORANGE, "ended": _AMBER, "harmless": _GREY},
    # A statusword's lane has the colours of the drive's.
    "value": {"0": _LIGHT, "1": _GREEN, **_DRIVE},
}
"""By kind of lane and class."""

FAULTS: Final = frozenset({"lost", "fault", "fault-reaction-active", "active"})
"""Classes of states that an engineer looks for first, without SDO transfers, which are too short to see in a lane."""

PLAIN: Final = (0x4F7CACFF, 0x3E8E8EFF, 0x8D6E63FF, 0x7A6FA8FF, 0x9C8A4AFF, 0x5F7A8AFF, 0xA0698AFF)
"""Colours of values of signals: distinct, and unlike running, waiting or a fault."""

WINDOW: Final = _RED
"""The synchronous window; values above it are late."""

LINES: Final = (
    0x3D85D6FF,
    0xE8772EFF,
    0x3FA34DFF,
    0xD6453DFF,
    0x8E5BD0FF,
    0x1FA6B8FF,
    0xD65A9DFF,
    0x9A9A2EFF,
    0xA9836BFF,
    0x7C8AA0FF,
)
"""Colours of lines that share a plot, in their order: distinct on black and on white."""


_MOST: Final = 4
"""Maximum number of lines of a plot with a choice, limited by the legend."""
_NUMBER: Final = 22.0
"""Height of a number beside an axis, in points."""
_MARGIN: Final = 0.08
_NODE: Final = re.compile(r"node\d+")


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a chart."""

    entity: str
    """Path of its entity."""
    index: int
    """Its index in the entity's rows."""
    bus: str
    """The bus as in paths; "" if the capture has no names."""
    node: int
    series: Series = field(compare=False)

    @property
    def title(self) -> str:
        """Its name without its unit."""
        return self.series.name.removesuffix(f" [{self.series.unit}]") if self.series.unit else self.series.name


@dataclass(frozen=True, slots=True)
class Chart:
    """Lines that share a plot: of one node, or the same signal of several."""

    unit: str
    lines: tuple[Line, ...]
    varies: bool
    described: bool

    @property
    def shared(self) -> bool:
        """True for a signal of several nodes, false for signals of one."""
        return len({(line.bus, line.node) for line in self.lines}) > 1


def place(entity: str) -> tuple[str, int]:
    """Returns the bus and the node of an entity: /nmt/can0/node5, /value/node5/TPDO1/signal."""
    parts = entity.split("/")[2:5]
    at = 1 if len(parts) > 1 and _NODE.fullmatch(parts[1]) else 0
    if at >= len(parts) or not _NODE.fullmatch(parts[at]):
        return "", 0
    return parts[0] if at else "", int(parts[at].removeprefix("node"))


def lines(contents: Contents) -> list[Line]:
    """Returns every line, by bus and node, in the order of their PDOs."""
    found = [
        Line(plot.entity, index, *place(plot.entity), series)
        for plot in contents.plots.values()
        if plot.rows
        for index, series in enumerate(plot.series)
        if series.least <= series.greatest
    ]
    return sorted(found, key=lambda line: (line.bus, line.node))


def of_node(every: Iterable[Line]) -> list[Chart]:
    """Returns the charts of one node's lines, the most informative first."""
    groups: dict[tuple[bool, bool, str, str, int], list[Line]] = {}
    for line in every:
        series = line.series
        key = (
            not series.varies,
            not series.described and not series.unit,
            series.unit,
            series.kind,
            _magnitude(series),
        )
        groups.setdefault(key, []).append(line)
    return [chart for key in sorted(groups, key=lambda key: key[:2]) for chart in _filled(groups[key])]


def overview(every: list[Line], room: int) -> list[Chart]:
    """Returns at most `room` charts: each node's own if all fit, or else the signals common to the nodes."""
    varying = [line for line in every if line.series.varies]
    named = [line for line in varying if line.series.described]
    for some in (varying, named):
        charts = [of_node(one) for one in _by_node(some).values()]
        if some and sum(map(len, charts)) <= room:
            return [chart for of_one in charts for chart in of_one]
    some = named or varying or [line for line in every if line.series.described] or every
    common = _common(some)[:room]
    taken = {line for chart in common for line in chart.lines}
    charts = [of_node(one) for one in _by_node([line for line in some if line not in taken]).values()]
    # The nodes in turn: the best of each, then the second best, until there is no room.
    turns = [(turn, place) for place, of_one in enumerate(charts) for turn in range(len(of_one))]
    chosen = sorted(sorted(turns)[: room - len(common)], key=lambda one: (one[1], one[0]))
    return [*common, *(charts[place][turn] for turn, place in chosen)]


def labelled(least: float, greatest: float, height: float) -> tuple[float, float] | None:
    """Returns the ends of an axis with at least three numbers beside it; None if the default has them.

    Numbers are at multiples of a power of ten, if the height suffices for each.
    """
    span = greatest - least
    if not (math.isfinite(span) and span > 0):
        return None
    most = max(height / _NUMBER, 3.0)
    step = 10.0 ** math.ceil(math.log10(span / most))
    first, last = math.floor(least / step), math.ceil(greatest / step)
    if math.floor(greatest / step) - math.ceil(least / step) >= 2:
        return None
    if last - first < 2:
        last += 1
    # A little more than the outermost numbers, which would be cut off.
    margin = _MARGIN * (last - first) * step
    return first * step - margin, last * step + margin


def axis(peak: float) -> float:
    """Returns the end of an axis of percent, so that a low load has numbers beside it, too."""
    return next((end for end in (20.0, 50.0) if peak <= end), 100.0)


def _by_node(every: Iterable[Line]) -> dict[tuple[str, int], list[Line]]:
    nodes: dict[tuple[str, int], list[Line]] = {}
    for line in every:
        nodes.setdefault((line.bus, line.node), []).append(line)
    return nodes


def _common(every: Iterable[Line]) -> list[Chart]:
    """Returns the signals with the same name in three or more nodes, those of most nodes first."""
    groups: dict[tuple[str, str], list[Line]] = {}
    for line in every:
        if line.series.described:
            groups.setdefault((line.series.name, line.series.unit), []).append(line)
    shared = [group for group in groups.values() if len(_by_node(group)) >= 3]
    return [_chart(group) for group in sorted(shared, key=lambda group: -len(_by_node(group)))]


def _filled(group: list[Line]) -> Iterable[Chart]:
    """Splits lines into charts of at most _MOST lines, of similar size."""
    count = math.ceil(len(group) / _MOST)
    size = math.ceil(len(group) / count)
    return (_chart(group[start : start + size]) for start in range(0, len(group), size))


def _chart(group: list[Line]) -> Chart:
    first = group[0].series
    return Chart(first.unit, tuple(group), any(line.series.varies for line in group), first.described)


def _magnitude(series: Series) -> int:
    """Returns a class of magnitude for lines without a unit, in steps of a factor of 100."""
    if series.unit:
        return 0
    most = max(abs(series.least), abs(series.greatest))
    return 0 if not math.isfinite(most) or most < 1 else 1 + int(math.log10(most)) // 2
