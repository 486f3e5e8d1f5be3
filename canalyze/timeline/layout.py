"""The initial layout of a recording in Rerun.

It is made only from the contents of the recording, so that nothing empty is shown: an overview (lanes and plots on
linked time axes, log and frames beside them), then the pages of the nodes. Changes by the user are kept by Rerun.
Must not: read the recording, or know the meaning of a state.
"""

import itertools
import uuid
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from canalyze.output.layout import width
from canalyze.timeline import charts
from canalyze.timeline.charts import LINES, WINDOW, Chart, Line
from canalyze.timeline.stream import Contents, Lane, path
from canalyze.words import Words

Place = tuple[str, int]
"""A bus as in paths, "" if the capture has no names, and a node of it."""

Part = rrb.Container | rrb.View
Sized = tuple[Part, float]
"""A part and its desired height in points; only proportions count."""

LANE: Final = 38
BAR: Final = 50
TEXT: Final = 400
"""Heights in points: of a lane, of the surroundings of lanes, of a log."""
TABS: Final = 8
"""Maximum number of nodes with tabs beside the overview; the tabs of more nodes are within one tab."""
LINKED: Final = rrb.archetypes.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal)
"""A time axis that zooms with all others."""
_GLOBAL: Final = "view/5c0dca6a-e63f-9cf7-f657-2602590474cc/TimeAxis"
"""The range that linked axes share: Rerun's own id, not public. If it changes, only the initial zoom is lost."""

SPAN: Final = "/time_span"
"""Two points without a value, at the recording's ends, which make a plot as wide as the recording."""
CLOCK: Final = "time_since_start"
"""The initial timeline if there are stamps; its column in logs is as wide as its name."""
TOGETHER: Final = 12
"""Maximum number of lanes in two views, NMT first; a title bar per kind would take their place."""
FILLED: Final = 8
"""Maximum number of lanes to which values of signals are added."""
FAULTS: Final = 6
"""Maximum number of lanes with faults that are shown before all others, if not all are visible at once."""
ROOM: Final = 8
"""Maximum number of plots of signals in the overview, beside those of SYNC and load."""
PAGE: Final = 10
"""Number of plots on one page of a node."""
MOST: Final = 1152
"""Maximum number of views of all pages: about that of a full bus; each takes 30 kB of a layout."""
TITLE: Final = 48
"""Columns of text that fit above a plot of the overview."""
WIDE: Final = 72
"""The same on a page of a node, where plots have the full width."""

KINDS: Final = ("nmt", "drive", "emcy", "sdo")
"""Kinds of lanes that the overview shows completely, from the top."""

_PLOT: Final = 120
_READ: Final = 180
"""From this height on a plot has numbers beside its axis for any range, and room for a legend."""
_AXIS: Final = 75
_ENTRY: Final = 21
_FEW: Final = 2 * BAR + LANE * TOGETHER
_LINES: Final = 300
"""Minimum height of frames below plots."""
_BOTTOM: Final = 3
"""Number of plots of SYNC and load in a row."""
_HEIGHT: Final = 880
"""Height of a window on a screen of 1000 points, without its bars; a lower one cuts lanes off."""
_SEEN: Final = 10
"""Number of lanes on one page of a node, above its plots."""
_ALONE: Final = 18
"""The same without plots."""
_TOLD: Final = 220
"""Height of a node's findings and transfers."""
_LOAD_NS: Final = 300_000_000
"""Minimum duration of a capture for a plot of the load, which is measured over 100 ms."""
_HIDDEN: Final = "…"
"""Legend entry of hidden lines, which share one entry."""
_IDS: Final = uuid.UUID("6b0e2b52-1f0c-4d0e-9d39-0d7a3c2f6c11")


@dataclass(frozen=True, slots=True)
class Plot:
    """A plot whose height is not known yet."""

    title: str
    lines: dict[str, list[str | None]]
    """The names of its lines by entity; None: not shown in this plot."""
    end: float | None = None
    """The upper end of its axis, which begins at 0."""
    limit: str = ""
    """The entity that is a limit for the others."""
    renamed: bool = False
    """True if its lines have other names than elsewhere."""
    points: bool = False
    """True if it has points, whose style is fixed."""
    span: tuple[float, float] | None = None
    """The least and the greatest value of its lines, if they are final."""


class Blueprint(rrb.Blueprint):
    """A layout whose linked time axes open on a range of their own."""

    def __init__(self, root: Part, timeline: str, shown: rr.TimeRange, *, follows: bool = False) -> None:
        """Shows `root` over a timeline. shown: its initial range. follows: it continues with new rows."""
        super().__init__(
            root,
            rrb.BlueprintPanel(state="collapsed"),
            rrb.SelectionPanel(state="collapsed"),
            rrb.TimePanel(state="collapsed", timeline=timeline, play_state="following" if follows else "paused"),
            auto_views=False,
            auto_layout=False,
        )
        self.shown = shown

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        super()._log_to_stream(stream)
        stream.log(_GLOBAL, rrb.archetypes.TimeAxis(view_range=self.shown))


def column(parts: Iterable[Sized], name: str | None = None) -> rrb.Container:
    """Arranges parts below each other, in proportion to their desired heights."""
    parts = list(parts)
    return rrb.Vertical(*(part for part, _ in parts), row_shares=[height for _, height in parts], name=name)


def layout(contents: Contents, words: Words, *, live: bool = False) -> rrb.Blueprint:
    """Returns the initial layout of a recording; `live`: it shows the last minute and follows new rows."""
    views = _Views(contents, words, live=live)
    root = views.whole()
    _identify(root, "", "", set())
    bound = rr.TimeRangeBoundary
    shown = (
        rr.TimeRange(bound.cursor_relative(seconds=-60), bound.cursor_relative(seconds=1))
        if live and contents.timed
        else rr.TimeRange(bound.infinite(), bound.infinite())
    )
    return Blueprint(root, views.clock(), shown, follows=live)


def fit(text: str, columns: int) -> str:
    """Cuts a text to `columns` of a terminal's width."""
    if width(text) <= columns:
        return text
    while text and width(text) >= columns:
        text = text[:-1]
    return text.rstrip() + "…"


def listed(names: Sequence[str], comma: str, columns: int) -> str:
    """Joins the names that fit in `columns`; the first one is cut if it alone does not fit."""
    for count in range(len(names), 0, -1):
        text = comma.join(names[:count]) + ("…" if count < len(names) else "")
        if width(text) <= columns:
            return text
    return fit(names[0], columns)


class _Views:
    """The contents of the recording as views with titles."""

    def __init__(self, contents: Contents, words: Words, *, live: bool) -> None:
        self.contents = contents
        self.words = words
        self.live = live
        self.lines = charts.lines(contents)
        self.lanes: dict[str, list[Lane]] = {}
        """By kind."""
        self.nodes: dict[Place, tuple[list[Lane], list[Line]]] = {}
        """By bus and node."""
        for lane in contents.lanes.values():
            if lane.rows:
                self.lanes.setdefault(lane.kind, []).append(lane)
                self.of_node(charts.place(lane.entity))[0].append(lane)
        for line in self.lines:
            self.of_node((line.bus, line.node))[1].append(line)
        for entity in contents.plots:
            self.of_node(charts.place(entity))
        self.timed: dict[Place, list[str]] = {}
        """Durations of SDO transfers, by bus and node."""
        for entity in contents.durations:
            self.timed.setdefault(charts.place(entity), []).append(entity)
        self.places = sorted(place for place in self.nodes if place[1])
        self.many = sum(len(self.lanes.get(kind, ())) for kind in KINDS) > TOGETHER
        """True if there are more lanes than are visible at once."""
        self.buses = max(len({bus for bus, _ in self.places}), len(contents.sync), len(contents.load))

    def of_node(self, place: Place) -> tuple[list[Lane], list[Line]]:
        """Returns the lanes and lines of a node."""
        return self.nodes.setdefault(place, ([], []))

    def whole(self) -> rrb.Container:
        """Returns the overview and the nodes."""
        tabs = [self.overview()]
        nodes = self.pages()
        if len(nodes) > TABS:
            name = self.words("timeline.nodes")
            if len(nodes) < len(self.places):
                name = self.words("timeline.some_nodes", count=len(nodes), every=len(self.places))
            tabs.append(rrb.Tabs(*nodes, name=name))
        elif len(nodes) > 1 or self.more_than_overview():
            tabs += nodes
        return rrb.Tabs(*tabs, active_tab=0)

    def pages(self) -> list[Part]:
        """Returns the pages of the nodes, as long as the number of their views is allowed."""
        found: list[Part] = []
        count = 0
        for bus, node in self.places:
            page = self.node(bus, node)
            if page is not None:
                count += _count(page)
                if count > MOST:
                    break
                found.append(page)
        return found

    def more_than_overview(self) -> bool:
        """Returns true if the tab of an only node has more than the overview."""
        return bool(self.lines or self.lanes.get("value"))

    # The overview.

    def overview(self) -> Part:
        """Returns lanes, plots and texts; few lanes are above the plots on the same time axis, many have a column."""
        lanes = self.kinds()
        used = sum(height for _, height in lanes)
        few = used <= _FEW
        # With many lanes, the points of SDO transfers replace theirs.
        others = [*self.syncs(), *self.loads(), *([] if self.many else self.durations())]
        bottom = -(-len(others) // _BOTTOM)
        places = 2 * (int((_HEIGHT - used) // _READ) - bottom) if few else _HEIGHT // _PLOT - len(others)
        chosen = [self.plot(chart) for chart in charts.overview(self.lines, min(max(places, 4), ROOM))]
        plots = [*chosen, *others]
        frames = self.frames()
        texts = [*self.log(), *frames]
        if few and plots:
            room = _HEIGHT - used
            left = [*lanes, _over(chosen, others, room)]
            if len(plots) * _READ + _LINES <= room and frames:
                # Few plots leave room for frames below them.
                high = len(plots) * _READ
                below = [(view, room - high) for view, _ in frames]
                left, texts = [*lanes, _grid(plots, high, 1), *below], self.log(whole=True)
            columns = [(left, 3), (texts, 2)]
        elif few and lanes:
            columns = [([*lanes, *frames], 3), (self.log(whole=True), 2)]
        else:
            columns = [(lanes, 2), ([_grid(plots, _HEIGHT, 1)] if plots else [], 2), (texts, 3)]
        columns = [column for column in columns if column[0]]
        name = self.words("timeline.overview")
        if len(columns) == 1:
            return column(columns[0][0], name)
        return rrb.Horizontal(
            *(column(parts) for parts, _ in columns), column_shares=[share for _, share in columns], name=name
        )

    def kinds(self) -> list[Sized]:
        """Returns lanes of all nodes: few of them below each other, or else a view per kind and one for faults."""
        kinds = [kind for kind in KINDS if kind in self.lanes]
        every = [lane for kind in kinds for lane in self.lanes[kind]]
        if not self.many:
            # Rerun sorts the lanes of a view by their paths, which begin with their kinds: problems are above NMT.
            others = [lane for lane in every if lane.kind != "nmt"] + self.values(FILLED - len(every))
            wrong, nmt = self.lanes.get("problems", []), self.lanes.get("nmt", [])
            first = self.states([*wrong, *nmt], "timeline.problems_nmt" if wrong and nmt else None)
            return [*([first] if wrong or nmt else []), *([self.states(others)] if others else [])]
        faulty = [lane for lane in every if lane.fault][:FAULTS]
        wrong = self.lanes.get("problems", [])[:FAULTS]
        views: list[Sized] = [self.states(wrong)] if wrong else []
        views += [self.states(faulty, "timeline.faults")] if faulty else []
        # No empty lanes, and none twice, where there are too many: those of EMCY are among the ones with faults.
        kinds = [kind for kind in kinds if kind == "nmt" or any(lane not in faulty for lane in self.lanes[kind])]
        points: list[Sized] = []
        if short := self.durations():
            kinds = [kind for kind in kinds if kind != "sdo"]
            points = [_grid(short, _READ, 1)]
        if not kinds:
            return [*views, *points]
        room = _HEIGHT - sum(height for _, height in [*views, *points])
        heights = _share({kind: float(BAR + LANE * len(self.lanes[kind])) for kind in kinds}, room)
        views += [
            (rrb.StateTimelineView(origin=f"/{kind}", name=self.words(f"timeline.{kind}"), time_view=LINKED), height)
            for kind, height in heights.items()
        ]
        values = self.values(int((room - sum(heights.values()) - BAR) // LANE))
        return [*views, *([self.states(values)] if values else []), *points]

    def values(self, room: int) -> list[Lane]:
        """Returns lanes of signals that change and are no quantities: whole signals before single bits."""
        if room <= 0:
            return []
        changing = [lane for lane in self.lanes.get("value", ()) if lane.rows > 1]
        return sorted(changing, key=lambda lane: lane.entity.rpartition(".")[2].isdecimal())[:room]

    def states(self, lanes: list[Lane], title: str | None = None) -> Sized:
        """Returns some lanes in one view."""
        kinds = {lane.kind for lane in lanes}
        title = title or (f"timeline.{kinds.pop()}" if len(kinds) == 1 else "timeline.states")
        view = rrb.StateTimelineView(
            origin="/", contents=[lane.entity for lane in lanes], name=self.words(title), time_view=LINKED
        )
        return view, BAR + LANE * len(lanes)

    def syncs(self) -> list[Plot]:
        """Returns per bus the period of SYNC, and the delays of synchronous PDOs with the window."""
        found = []
        for bus in sorted(self.contents.sync):
            period = self.titled(self.words("timeline.period"), bus)
            entity = path("sync", bus, "period")
            found.append(Plot(period, {entity: [period]}, span=self.span([entity])))
            before = path("sync", bus, "delay") + "/"
            delays: dict[str, list[str | None]] = {}
            for entity in self.contents.delays:
                if entity.startswith(before):
                    node, _, pdo = entity.removeprefix(before).partition("/")
                    delays[entity] = [f"{self.words('timeline.node', node=node.removeprefix('node'))} {pdo}"]
            limit = path("sync", bus, "window") if bus in self.contents.windows else ""
            if delays and limit:
                delays[limit] = [self.words("timeline.window")]
            if delays:
                title = self.words("timeline.delay" if bus in self.contents.windows else "timeline.delay_only")
                found.append(Plot(self.titled(title, bus), delays, limit=limit, span=self.span(delays)))
        return found

    def loads(self) -> list[Plot]:
        """Returns the load of all buses: those in percent, and those with an unknown bit rate."""
        if self.contents.last_ns - self.contents.first_ns < _LOAD_NS:
            return []
        found = []
        for percent in (True, False):
            name = self.words("timeline.load" if percent else "timeline.rate")
            lines: dict[str, list[str | None]] = {
                path("load", bus): [bus or name] for bus, one in self.contents.load.items() if one is percent
            }
            if lines:
                peak = max(self.contents.peaks.get(bus, 100.0) for bus in self.contents.load)
                # A little more than the last number, which would be cut off.
                found.append(Plot(name, lines, charts.axis(peak) * 1.05 if percent else None, span=self.span(lines)))
        return found

    def durations(self, place: Place | None = None) -> list[Plot]:
        """Returns the durations of SDO transfers of one node, or of all if they are too short to see in their lanes."""
        if place is None and not self.contents.brief:
            return []
        mine = self.timed.get(place, []) if place else list(self.contents.durations)
        lines: dict[str, list[str | None]] = {one: [one] for one in mine}
        title = self.words("timeline.durations")
        return [Plot(title, lines, points=True, span=self.span(mine))] if mine else []

    def span(self, entities: Iterable[str]) -> tuple[float, float] | None:
        """Returns the range of the values of some entities; None if more may come."""
        known = [self.contents.ranges[one] for one in entities if one in self.contents.ranges]
        if self.live or not known:
            return None
        return min(least for least, _ in known), max(greatest for _, greatest in known)

    def log(self, *, whole: bool = False) -> list[Sized]:
        """Returns findings and emergencies with the summary behind them, or below them if `whole`."""
        views: list[Part] = []
        if self.contents.logged:
            levels, title = ["ERROR", "WARN", "INFO"], "timeline.log"
            if self.contents.crowded:
                levels, title = levels[:2], "timeline.faults_log"
            views.append(
                self.read(["$origin/**"], title, set(self.contents.logged) & set(levels), only=levels, origin="/log")
            )
        if self.contents.summary:
            views.append(rrb.TextDocumentView(origin="/summary", name=self.words("timeline.summary")))
        if self.contents.diagnosis:
            diagnosis = rrb.TextDocumentView(origin="/diagnosis", name=self.words("timeline.diagnosis"))
            if whole:
                # Beside the summary, in front of it.
                views = [*views[:-1], rrb.Tabs(diagnosis, *views[-1:], active_tab=0)] if views else [diagnosis]
            else:
                views.insert(0, diagnosis)
        if len(views) > 1 and not whole:
            return [(rrb.Tabs(*views, active_tab=0), TEXT)]
        return [(view, TEXT) for view in views]

    def frames(self) -> list[Sized]:
        """Returns the annotated frames."""
        if not self.contents.frames:
            return []
        # A finding is shown at its frame, even if it was reported later; its code distinguishes it from
        # frames, which have no level.
        found = self.contents.findings > 0
        view = rrb.TextLogView(
            origin="/",
            contents=["/frames", "/log/findings/**"] if found else ["/frames"],
            name=self.words("timeline.frames"),
            columns=rrb.TextLogColumns(timeline_columns=[self.clock()], text_log_columns=["Body"]),
            rows=rrb.TextLogRows(filter_by_log_level=["ERROR", "WARN", "INFO", "TRACE"]),
            format_options=rrb.TextLogFormat(monospace_body=True),
        )
        parts = [view, *self.transfers(list(self.contents.listed))]
        return [(rrb.Tabs(*parts, active_tab=0) if len(parts) > 1 else view, _HEIGHT - TEXT)]

    def transfers(self, entities: Sequence[str]) -> list[rrb.View]:
        """Returns SDO transfers in words."""
        if not entities:
            return []
        levels = set().union(*(self.contents.listed[entity] for entity in entities))
        return [self.read(list(entities), "timeline.sdo_list", levels)]

    def read(
        self,
        entities: list[str],
        title: str,
        levels: set[str],
        *,
        only: Sequence[str] = ("ERROR", "WARN", "INFO"),
        origin: str = "/",
    ) -> rrb.View:
        """Returns lines of text; their level is shown if there are several."""
        told: list[Literal["LogLevel", "Body"]] = ["LogLevel", "Body"] if len(levels) > 1 else ["Body"]
        return rrb.TextLogView(
            origin=origin,
            contents=entities,
            name=self.words(title),
            columns=rrb.TextLogColumns(timeline_columns=[self.clock()], text_log_columns=told),
            rows=rrb.TextLogRows(filter_by_log_level=list(only)),
        )

    def clock(self) -> str:
        """Returns the initial timeline."""
        return CLOCK if self.contents.timed else "frame"

    # The nodes.

    def node(self, bus: str, node: int) -> Part | None:
        """Returns all lanes and plots of a node, on several pages if there are many."""
        own, lines = self.of_node((bus, node))
        lanes = [lane for kind in ("problems", *KINDS, "value") for lane in own if lane.kind == kind]
        plots = [self.plot(chart, of_node=True) for chart in charts.of_node(lines)] + self.durations((bus, node))
        read = self.told(bus, node)
        parts: list[Sized] = self.paged(lanes, alone=not plots)
        room = _HEIGHT - sum(height for _, height in [*parts, *read])
        pages = [plots[start : start + PAGE] for start in range(0, len(plots), PAGE)]
        if len(pages) > 1:
            tabs = [column([_grid(page, room)], f"{number}/{len(pages)}") for number, page in enumerate(pages, 1)]
            parts.append((rrb.Tabs(*tabs, active_tab=0), room))
        elif pages:
            parts.append(_grid(pages[0], room))
        parts += read
        return column(parts, fit(self.node_name(bus, node), 24)) if parts else None

    def told(self, bus: str, node: int) -> list[Sized]:
        """Returns findings and emergencies of a node, and its SDO transfers beside them."""
        mine = (bus, node)
        found = list(self.contents.told.get(mine, ()))
        views = [self.read(found, "timeline.log", {"ERROR", "WARN"})] if found else []
        views += self.transfers([one for one in self.contents.listed if charts.place(one) == mine])
        if not views:
            return []
        return [(rrb.Horizontal(*views) if len(views) > 1 else views[0], _TOLD)]

    def paged(self, lanes: list[Lane], *, alone: bool) -> list[Sized]:
        """Returns lanes on pages of fully visible ones, single bits after the signals that contain them."""
        most = _ALONE if alone else _SEEN
        lanes = sorted(lanes, key=lambda lane: lane.entity.rpartition(".")[2].isdecimal())
        pages = [lanes[start : start + most] for start in range(0, len(lanes), most)]
        if len(pages) < 2:
            return [self.states(page) for page in pages]
        states = [self.states(page) for page in pages]
        tabs = [column([one], f"{number}/{len(pages)}") for number, one in enumerate(states, 1)]
        return [(rrb.Tabs(*tabs, active_tab=0), max(height for _, height in states) + BAR / 2)]

    def node_name(self, bus: str, node: int) -> str:
        """Returns the name of a node, with its bus if there are several."""
        return self.titled(self.words("timeline.node", node=node), bus)

    def titled(self, title: str, bus: str) -> str:
        """Returns a title, with its bus if there are several."""
        return f"{bus} {title}" if self.buses > 1 else title

    # Plots of signals.

    def plot(self, chart: Chart, *, of_node: bool = False) -> Plot:
        """Returns one plot with its lines; the other lines of their PDOs are hidden."""
        lines: dict[str, list[str | None]] = {}
        named = [self.node_name(line.bus, line.node) if chart.shared else line.series.name for line in chart.lines]
        for line, name in zip(chart.lines, named, strict=True):
            plot = self.contents.plots[line.entity]
            names = lines.setdefault(line.entity, [None] * len(plot.series))
            names[line.index] = f"{name} {plot.pdo}" if named.count(name) > 1 else name
        least = min(line.series.least for line in chart.lines)
        greatest = max(line.series.greatest for line in chart.lines)
        span = None if self.live else (least, greatest)
        return Plot(self.title(chart, of_node), lines, renamed=chart.shared, span=span)

    def title(self, chart: Chart, of_node: bool) -> str:
        """Returns the title: node, signals, and unit, which is never cut off."""
        unit = f" [{chart.unit}]" if chart.unit else ""
        names = list(dict.fromkeys(line.title for line in chart.lines))
        first = chart.lines[0]
        if chart.shared:
            around = self.words("timeline.of_nodes", count=len(chart.lines), name="\0")
        elif of_node or len(self.places) == 1:
            around = "\0"
        else:
            around = f"{self.node_name(first.bus, first.node)} \0"
        room = (WIDE if of_node else TITLE) - width(around.replace("\0", "") + unit)
        return around.replace("\0", listed(names, self.words("timeline.comma"), room)) + unit


def _grid(plots: list[Plot], room: float, columns: int | None = None) -> Sized:
    """Arranges plots below each other, in two columns if there are many."""
    if columns is None:
        columns = 1 if len(plots) <= 4 else 2
    rows = [plots[start : start + columns] for start in range(0, len(plots), columns)]
    height = max(room, _PLOT * len(rows))
    views = [[_series(plot, height / len(rows)) for plot in row] for row in rows]
    return rrb.Vertical(*(rrb.Horizontal(*row) if len(row) > 1 else row[0] for row in views)), height


def _over(signals: list[Plot], others: list[Plot], room: float) -> Sized:
    """Arranges plots of signals above those of the bus."""
    count = len(signals) + len(others)
    if count <= _BOTTOM or not signals or len(others) <= 1:
        return _grid([*signals, *others], room, 1 if count <= _BOTTOM else 2)
    columns = 1 if len(signals) <= 2 else 2
    upper, lower = -(-len(signals) // columns), -(-len(others) // _BOTTOM)
    share = room / (upper + lower)
    parts = [_grid(signals, share * upper, columns), _grid(others, share * lower, min(len(others), _BOTTOM))]
    return column(parts), sum(height for _, height in parts)


def _series(plot: Plot, height: float) -> rrb.View:
    """Returns a plot of some height, with a legend if it says more than the title and fits.

    An override takes three chunks of some kilobytes, and is used only if an entity's own style does not suffice.
    """
    room = int((height - _AXIS) / _ENTRY)
    every = [name for names in plot.lines.values() for name in names]
    shown = [name for name in every if name is not None]
    legend = not plot.points and len(shown) > 1 and len(shown) + (None in every) <= room
    colours = itertools.cycle(colour for colour in LINES if not plot.limit or colour != WINDOW)
    overrides: dict[Any, rrb.Visualizer] = {}
    for entity, names in plot.lines.items():
        if legend or None in names or plot.renamed:
            style = rr.SeriesLines(
                names=[_HIDDEN if name is None else name for name in names],
                visible_series=[name is not None for name in names],
                # An array: a list of three or four numbers would be taken for one colour.
                colors=np.array([next(colours) if name is not None else LINES[0] for name in names], np.uint32)
                if entity != plot.limit
                else np.array([WINDOW] * len(names), np.uint32),
            )
            overrides[entity] = style.visualizer()
    if legend:
        # With the name of another line the span has no entry of its own.
        overrides[SPAN] = rr.SeriesLines(names=shown[:1], visible_series=[False]).visualizer()
    ends = (0.0, plot.end) if plot.end else charts.labelled(*plot.span, height - _AXIS) if plot.span else None
    return rrb.TimeSeriesView(
        origin="/",
        contents=[*plot.lines, SPAN],
        name=plot.title,
        axis_x=LINKED,
        axis_y=rrb.ScalarAxis(range=ends) if ends else None,
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.LeftTop, visible=legend),
        overrides=overrides,
    )


def _share(wanted: dict[str, float], height: float) -> dict[str, float]:
    """Divides a height: half to the first, the rest equally, but to none more than wanted while others want it."""
    first, *others = wanted
    given = {first: min(wanted[first], max(height / 2, height - sum(wanted[one] for one in others)))}
    for one in sorted(others, key=wanted.__getitem__):
        given[one] = min(wanted[one], (height - sum(given.values())) / (len(wanted) - len(given)))
    return {one: given[one] for one in wanted}


def _count(part: Part) -> int:
    """Returns the number of views of a part."""
    return sum(map(_count, part.contents)) if isinstance(part, rrb.Container) else 1


def _identify(part: Part, tab: str, place: str, taken: set[str]) -> None:
    """Sets ids that are the same in every layout of the same contents, so that a new one does not rebuild everything.

    A view is identified by its tab and its title, even if it moves within the tab.
    """
    name = f"{tab}/{place}" if isinstance(part, rrb.Container) else f"{tab}/{part.name}"
    while name in taken:
        name += "'"
    taken.add(name)
    part.id = uuid.uuid5(_IDS, name)
    if isinstance(part, rrb.Container):
        for at, inner in enumerate(part.contents):
            own = isinstance(inner, rrb.Container) and inner.name
            _identify(inner, f"{tab}/{inner.name}" if own else tab, "" if own else f"{place}.{at}", taken)
