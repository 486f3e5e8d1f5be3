"""The first layout of a recording in Rerun: what an engineer sees without touching anything.

Made from what stands in the recording and nothing else, so nothing empty is shown: an overview (lanes and plots on
linked time axes, log and frames beside them), then all there is of each node. What the user rearranges is kept by
Rerun. Must not: read the recording, or know what a state means.
"""

import uuid
from collections.abc import Iterable
from typing import Final

import rerun as rr
import rerun.blueprint as rrb

from canalyze.layout import width
from canalyze.timeline import charts
from canalyze.timeline.charts import Chart, Line
from canalyze.timeline.contents import Contents, Lane
from canalyze.words import Words

Part = rrb.Container | rrb.View
Sized = tuple[Part, float]
"""A part and the height that it wants, in points; only proportions count."""

ROOM: Final = 8
"""Plots of signals in the overview, besides those of SYNC and load."""
TOGETHER: Final = 8
"""Up to so many lanes share one view whatever their kinds: a title bar for each kind would take their place."""
PAGE: Final = 12
"""Plots on one page of a node."""
TABS: Final = 8
"""Up to so many nodes have tabs beside the overview; more of them have theirs in one tab."""
LEGEND: Final = 10
"""Lines up to which a plot has a legend; a longer one would cover it."""

KINDS: Final = ("nmt", "drive", "emcy", "sdo")
"""Kinds of lanes that the overview shows whole, from the top."""

_LANE: Final = 38
_BAR: Final = 50
_PLOT: Final = 130
_LINKED: Final = rrb.archetypes.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal)
_GLOBAL: Final = "view/5c0dca6a-e63f-9cf7-f657-2602590474cc/TimeAxis"
"""The range that linked axes share. Rerun's own id, not public: under another one, only the first zoom is lost."""
_IDS: Final = uuid.UUID("6b0e2b52-1f0c-4d0e-9d39-0d7a3c2f6c11")


class Blueprint(rrb.Blueprint):
    """A blueprint whose linked time axes open on a range of their own."""

    shown: rr.TimeRange

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        super()._log_to_stream(stream)
        stream.log(_GLOBAL, rrb.archetypes.TimeAxis(view_range=self.shown))


def layout(contents: Contents, words: Words, *, live: bool = False) -> rrb.Blueprint:
    """Make the first layout of a recording; `live`: it shows the last minute and follows what comes."""
    views = _Views(contents, words)
    root = views.whole()
    _identify(root, "")
    made = Blueprint(
        root,
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(
            state="collapsed",
            timeline="elapsed" if contents.timed else "frame",
            play_state="following" if live else "paused",
        ),
        auto_views=False,
        auto_layout=False,
    )
    bound = rr.TimeRangeBoundary
    made.shown = (
        rr.TimeRange(bound.cursor_relative(seconds=-60), bound.cursor_relative(seconds=1))
        if live and contents.timed
        else rr.TimeRange(bound.infinite(), bound.infinite())
    )
    return made


def fit(text: str, columns: int) -> str:
    """Cut a text to `columns` of a terminal's width."""
    if width(text) <= columns:
        return text
    while text and width(text) >= columns:
        text = text[:-1]
    return text.rstrip(" ,、·") + "…"


class _Views:
    """What is in the recording, as views with titles."""

    def __init__(self, contents: Contents, words: Words) -> None:
        self.contents = contents
        self.words = words
        self.lines = charts.lines(contents)
        self.lanes: dict[str, list[Lane]] = {}
        for lane in contents.lanes.values():
            if lane.rows:
                self.lanes.setdefault(lane.kind, []).append(lane)
        self.buses = {bus for bus, _ in self.nodes()}

    def whole(self) -> rrb.Container:
        """Overview, then the nodes."""
        tabs = [self.overview()]
        nodes = [page for bus, node in self.nodes() if (page := self.node(bus, node))]
        if len(nodes) > TABS:
            tabs.append(rrb.Tabs(*nodes, name=self.words("timeline.nodes")))
        elif len(nodes) > 1 or self.more_than_overview():
            tabs += nodes
        return rrb.Tabs(*tabs, active_tab=0)

    def nodes(self) -> list[tuple[str, int]]:
        """Every node that something is shown of, in order."""
        entities = [*self.contents.plots, *(lane.entity for lanes in self.lanes.values() for lane in lanes)]
        return sorted({place for entity in entities if (place := charts.place(entity))[1]})

    def more_than_overview(self) -> bool:
        """Whether the tab of an only node has anything that the overview has not."""
        return bool(self.lines or self.lanes.get("value"))

    # The overview.

    def overview(self) -> Part:
        """Lanes above plots; log, summary and frames beside them."""
        chosen = charts.overview(self.lines, ROOM)
        plots = [*(self.plot(chart) for chart in chosen), *self.syncs(), *self.loads()]
        left = [*self.kinds(), *_grid(plots)]
        right = self.texts()
        if self.contents.frames and not plots:
            # Without plots there is room for frames below the lanes, and they are what is to be read.
            left.append((self.frames(), 500))
            right = [one for one in right if one.name != self.words("timeline.frames")]
        name = self.words("timeline.overview")
        if not left or not right:
            return _column([*left, *((one, 500.0) for one in right)], name)
        beside = _column([(one, 500.0) for one in right])
        return rrb.Horizontal(_column(left), beside, column_shares=[3, 2], name=name)

    def kinds(self) -> list[Sized]:
        """Lanes of all nodes: few of them in one view, else a view a kind."""
        kinds = [kind for kind in KINDS if kind in self.lanes]
        every = [lane for kind in kinds for lane in self.lanes[kind]]
        if len(every) <= TOGETHER:
            every += self.values(TOGETHER - len(every))
            return [self.states(every)] if every else []
        return [
            (
                rrb.StateTimelineView(origin=f"/{kind}", name=self.words(f"timeline.{kind}"), time_view=_LINKED),
                _BAR + _LANE * min(len(self.lanes[kind]), 8 if kind == "nmt" else 4),
            )
            for kind in kinds
        ]

    def values(self, room: int) -> list[Lane]:
        """Lanes of signals that change and are no quantities: whole signals before single bits."""
        changing = [lane for lane in self.lanes.get("value", ()) if lane.rows > 1]
        return sorted(changing, key=lambda lane: lane.entity.rpartition(".")[2].isdecimal())[:room]

    def states(self, lanes: list[Lane]) -> Sized:
        """Some lanes in one view."""
        view = rrb.StateTimelineView(
            origin="/",
            contents=[lane.entity for lane in lanes],
            name=self.words("timeline.states"),
            time_view=_LINKED,
        )
        return view, _BAR + _LANE * min(len(lanes), 12)

    def syncs(self) -> list[rrb.View]:
        """Per bus the period of SYNC, and when synchronous PDOs came against the window."""
        found = []
        for bus in sorted(self.contents.sync):
            path = f"/sync/{bus}" if bus else "/sync"
            delays = [entity for entity in self.contents.delays if entity.startswith(f"{path}/delay/")]
            name = self.titled(self.words("timeline.period"), bus)
            found.append(_series(name, [f"{path}/period"], 1))
            if delays:
                window = [f"{path}/window"] if bus in self.contents.windows else []
                name = self.titled(self.words("timeline.delay"), bus)
                found.append(_series(name, [*window, *delays], len(delays) + 1))
        return found

    def loads(self) -> list[rrb.View]:
        """The load of all buses: those in percent, and those of which the bit rate is not known."""
        found = []
        for percent in (True, False):
            paths = [f"/load/{bus}" if bus else "/load" for bus, one in self.contents.load.items() if one is percent]
            if paths:
                name = self.words("timeline.load" if percent else "timeline.rate")
                axis = rrb.ScalarAxis(range=(0, 100)) if percent else None
                found.append(_series(name, paths, len(paths), axis=axis))
        return found

    def texts(self) -> list[rrb.View | rrb.Container]:
        """Log, summary, frames."""
        above: list[rrb.View] = []
        if self.contents.logged:
            above.append(self.log())
        if self.contents.summary:
            above.append(rrb.TextDocumentView(origin="/summary", name=self.words("timeline.summary")))
        parts: list[rrb.View | rrb.Container] = list(above)
        if len(above) > 1:
            parts = [rrb.Tabs(*above, active_tab=0)]
        return [*parts, self.frames()] if self.contents.frames else parts

    def log(self) -> rrb.View:
        """Findings and emergencies."""
        return rrb.TextLogView(
            origin="/log",
            name=self.words("timeline.log"),
            columns=rrb.TextLogColumns(timeline_columns=[self.clock()], text_log_columns=["LogLevel", "Body"]),
            rows=rrb.TextLogRows(filter_by_log_level=["ERROR", "WARN", "INFO"]),
        )

    def frames(self) -> rrb.View:
        """Annotated frames."""
        return rrb.TextLogView(
            origin="/frames",
            name=self.words("timeline.frames"),
            columns=rrb.TextLogColumns(timeline_columns=[self.clock()], text_log_columns=["Body"]),
            rows=rrb.TextLogRows(filter_by_log_level=["ERROR", "WARN", "INFO", "TRACE"]),
            format_options=rrb.TextLogFormat(monospace_body=True),
        )

    def clock(self) -> str:
        """The timeline that is shown first."""
        return "elapsed" if self.contents.timed else "frame"

    # The nodes.

    def node(self, bus: str, node: int) -> Part | None:
        """All lanes and all plots of a node, on pages where they are many."""
        lanes = [
            lane
            for kind in (*KINDS, "value")
            for lane in self.lanes.get(kind, ())
            if charts.place(lane.entity) == (bus, node)
        ]
        plots = [
            self.plot(chart, of_node=True)
            for chart in charts.of_node(line for line in self.lines if (line.bus, line.node) == (bus, node))
        ]
        parts: list[Sized] = [self.states(lanes)] if lanes else []
        pages = [plots[start : start + PAGE] for start in range(0, len(plots), PAGE)]
        if len(pages) > 1:
            tabs = [_column(_grid(page), str(number)) for number, page in enumerate(pages, 1)]
            parts.append((rrb.Tabs(*tabs, active_tab=0), _PLOT * PAGE / 2))
        elif pages:
            parts += _grid(pages[0])
        return _column(parts, fit(self.node_name(bus, node), 24)) if parts else None

    def node_name(self, bus: str, node: int) -> str:
        """Node 5; with its bus where there are several."""
        return self.titled(self.words("timeline.node", node=node), bus)

    def titled(self, title: str, bus: str) -> str:
        """A title with its bus where there are several."""
        return f"{bus} {title}" if len(self.buses) > 1 else title

    # Plots of signals.

    def plot(self, chart: Chart, *, of_node: bool = False) -> rrb.View:
        """One plot: the lines that it has; the others of their PDOs stay hidden."""
        overrides = {}
        for entity in dict.fromkeys(line.entity for line in chart.lines):
            shown = {line.index: line for line in chart.lines if line.entity == entity}
            series = self.contents.plots[entity].series
            names = [
                self.node_name(shown[at].bus, shown[at].node) if chart.shared and at in shown else one.name
                for at, one in enumerate(series)
            ]
            style = rr.SeriesLines(names=names, visible_series=[at in shown for at in range(len(series))])
            overrides[entity] = style.visualizer()
        return _series(self.title(chart, of_node), list(overrides), len(chart.lines), overrides=overrides)

    def title(self, chart: Chart, of_node: bool) -> str:
        """Whose signals, which, and their unit, which is never cut off."""
        first = chart.lines[0]
        before = "" if of_node or chart.shared else self.node_name(first.bus, first.node) + " "
        unit = f" [{chart.unit}]" if chart.unit else ""
        names = self.words("timeline.comma").join(dict.fromkeys(line.title for line in chart.lines))
        return before + fit(names, 48 - width(before + unit)) + unit


def _series(
    name: str,
    entities: list[str],
    lines: int,
    *,
    axis: rrb.ScalarAxis | None = None,
    overrides: dict[str, rrb.Visualizer] | None = None,
) -> rrb.View:
    """Make a plot as wide in time as the recording, by the two points of /span."""
    return rrb.TimeSeriesView(
        origin="/",
        contents=[*entities, "/span"],
        name=name,
        axis_x=_LINKED,
        axis_y=axis,
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.LeftTop, visible=lines <= LEGEND),
        overrides=overrides,
    )


def _grid(plots: list[rrb.View]) -> list[Sized]:
    """Put plots below each other; in two columns where they are many."""
    if not plots:
        return []
    columns = 1 if len(plots) <= 4 else 2
    height = _PLOT * -(-len(plots) // columns)
    return [(rrb.Vertical(*plots) if columns == 1 else rrb.Grid(*plots, grid_columns=columns), height)]


def _column(parts: Iterable[Sized], name: str | None = None) -> rrb.Container:
    """Put parts below each other, in proportion to the heights that they want."""
    parts = list(parts)
    return rrb.Vertical(*(part for part, _ in parts), row_shares=[height for _, height in parts], name=name)


def _identify(part: Part, path: str) -> None:
    """Give the same ids in every layout of the same, so that one sent anew does not rebuild what stays."""
    part.id = uuid.uuid5(_IDS, path)
    for place, inner in enumerate(part.contents if isinstance(part, rrb.Container) else ()):
        _identify(inner, f"{path}/{inner.name or place}")
