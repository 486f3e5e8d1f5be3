"""A layout for the decoded topics of an MCAP as Rerun itself reads them: `rerun OUT.mcap - < OUT.rbl`.

Rerun makes a struct of each message, which nothing draws by itself. The layout says which fields are lines of a plot,
which are lanes of states and which are text: made of the file's own definitions and values. Must not: read frames, or
know what a value means.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import McapReader

from canalyze._core import class_of
from canalyze.errors import SourceError
from canalyze.output.layout import width
from canalyze.timeline import charts
from canalyze.timeline.blueprint import BAR, LANE, LINKED, TABS, TEXT, Blueprint, Part, Sized, column
from canalyze.timeline.charts import Chart, Line
from canalyze.timeline.colours import COLOURS
from canalyze.timeline.contents import Series
from canalyze.timeline.layout import ROOM, TITLE, fit
from canalyze.words import Words

NMT, DRIVE, SDO, LOG = (
    "canalyze_msgs/msg/NmtState",
    "canalyze_msgs/msg/DriveState",
    "canalyze_msgs/msg/SdoTransfer",
    "rcl_interfaces/msg/Log",
)
"""Types of messages that `convert --decoded` writes, besides those of PDOs."""

CLOCK: Final = "message_log_time"
"""The timeline that all topics have."""

_PLACE: Final = re.compile(r"/(?:(.*)/)?node(\d+)/(\w+)(?:/\w+)?")
_PDO: Final = re.compile(r"[tr]pdo\d+(_v\d+)?")
_FIELD: Final = re.compile(r"# (?:(.*), )?([0-9A-F]{4}h:[0-9A-F]{2})(?:, (.*))?\n(\S+) (\w+)\n(?:string (\w+_text)\n)?")
_PLOT: Final = 110
"""Height of a plot in points; only proportions count."""
_LEGEND: Final = 6
"""Lines up to which a plot has a legend; a longer one would cover it."""
_COLUMNS: Final = rrb.TextLogColumns(timeline_columns=[CLOCK], text_log_columns=["LogLevel", "Body"])
_NUMBERS: Final = re.compile(r"u?int\d+|float\d+")


@dataclass(slots=True)
class Topic:
    """A topic with decoded messages."""

    entity: str
    """Its path in Rerun."""
    kind: str
    """The type of its messages: canalyze_msgs/msg/NmtState."""
    bus: str
    node: int
    """0 for a topic of the whole file."""
    states: list[str] = field(default_factory=list)
    """Fields that are lanes."""
    lines: list[tuple[str, Series]] = field(default_factory=list)
    """Fields that are lines, in the order of the message."""

    text: str = ""
    """The field that says in words what happened; files of earlier versions only have values."""

    @property
    def component(self) -> str:
        """As Rerun calls the messages of this topic."""
        return self.kind.replace("/", ".") + ":message"


@dataclass(slots=True)
class Topics:
    """What an MCAP has for the layout."""

    found: list[Topic] = field(default_factory=list)
    colours: dict[str, dict[str, int]] = field(default_factory=lambda: {NMT: {}, DRIVE: {}})
    """By type of message: states in the words of the file, and their colours."""
    first_ns: int = 0
    last_ns: int = 0
    """Times of the first and the last message of the file."""

    def of(self, kind: str) -> list[Topic]:
        """Give the topics with one type of message."""
        return [topic for topic in self.found if topic.kind == kind]


def application(path: str) -> str:
    """Give the application id under which Rerun shows a file that it is given by name; layouts go by it."""
    return Path(path).stem.replace(".", "_")


def layout(path: str, words: Words) -> rrb.Blueprint:
    """Make the layout for a file that `convert --decoded` wrote; SourceError where it is none."""
    try:
        Path(path).open("rb").close()
        topics = read(path)
    except OSError as error:
        raise SourceError("source.open", name=path, error=error) from error
    except (ValueError, RuntimeError) as error:
        raise SourceError("topics.damaged", name=path) from error
    if not topics.found:
        raise SourceError("topics.none", name=path)
    return _Views(topics, words).layout()


def read(path: str) -> Topics:
    """Read what topics there are, and the ranges of their values."""
    topics = Topics()
    known = McapReader(path).info()
    topics.first_ns, topics.last_ns = known.message_start_time_ns or 0, known.message_end_time_ns or 0
    for topic, definition in _definitions(path):
        if _PDO.fullmatch(_last(topic.entity)) is None and topic.kind not in (NMT, DRIVE, SDO, LOG):
            continue
        if topic.kind == DRIVE:
            topic.states.append("state")
        elif topic.kind == NMT:
            topic.states.append("name")
        elif topic.kind == SDO:
            topic.text = "text" if "\nstring text\n" in definition else "value"
        elif topic.kind != LOG:
            _fields(topic, definition)
        topics.found.append(topic)
    topics.found.sort(key=lambda topic: (topic.bus, topic.node, topic.entity))
    by_entity = {topic.entity: topic for topic in topics.found}
    for entity, messages in _messages(path):
        topic = by_entity[entity]
        if topic.kind in topics.colours:
            _colours(topics.colours[topic.kind], topic.kind, messages)
        for name, series in topic.lines:
            _range(series, messages.field(name))
    return topics


def _definitions(path: str) -> Iterator[tuple[Topic, str]]:
    """Give each topic with the definition of its messages."""
    for chunk in McapReader(path, decoders=["schema"]).stream():
        batch = chunk.to_record_batch()
        if "McapSchema:data" not in batch.schema.names:
            continue
        place = _PLACE.fullmatch(chunk.entity_path)
        bus, node = (place[1] or "", int(place[2])) if place else ("", 0)
        kind = batch.column("McapSchema:name")[0].as_py()[0]
        text = bytes(batch.column("McapSchema:data")[0].as_py()[0]).decode("utf-8", "replace")
        yield Topic(chunk.entity_path, kind, bus, node), text


def _messages(path: str) -> Iterator[tuple[str, Any]]:
    """Give the messages of PDOs and of states, some at a time, as an Arrow array of structs."""
    wanted = r"/node\d+/([tr]pdo\d+|nmt_state$|drive_state)"
    reader = McapReader(path, decoders=["ros2_reflection"], include_topic_regex=[wanted])
    for chunk in reader.stream():
        for column_of in chunk.to_record_batch().columns:
            if pa.types.is_list(column_of.type) and pa.types.is_struct(column_of.type.value_type):
                yield chunk.entity_path, column_of.flatten()


def _last(entity: str) -> str:
    place = _PLACE.fullmatch(entity)
    return place[3] if place else ""


def _fields(topic: Topic, definition: str) -> None:
    """Sort the fields of a PDO: those with words of their own and the true-or-false ones are states."""
    for name, address, unit, form, key, text in _FIELD.findall(definition.partition("====")[0]):
        if text or form == "bool":
            topic.states.append(text or key)
        elif _NUMBERS.fullmatch(form):
            shown = name or address
            topic.lines.append((key, Series(f"{shown} [{unit}]" if unit else shown, unit, bool(name))))


def _colours(known: dict[str, int], kind: str, messages: Any) -> None:
    """Add the colours of the states that some messages show."""
    words, numbers, lane = ("name", "state", "nmt") if kind == NMT else ("state", "statusword", "drive")
    for word in pc.unique(messages.field(words)).to_pylist():
        at = pc.index(messages.field(words), word).as_py()
        colour = COLOURS[lane].get(class_of(lane, messages.field(numbers)[at].as_py()) or "")
        if word and colour is not None:
            known[word] = colour


def _range(series: Series, values: Any) -> None:
    """Widen a signal's range by some of its values."""
    found = pc.min_max(values).as_py()
    if found["min"] is not None and found["min"] <= found["max"]:
        series.least = min(series.least, float(found["min"]))
        series.greatest = max(series.greatest, float(found["max"]))


class _Views:
    """The views of a file's topics."""

    def __init__(self, topics: Topics, words: Words) -> None:
        self.topics = topics
        self.words = words
        self.lines = [
            Line(topic.entity, at, topic.bus, topic.node, series)
            for topic in topics.found
            for at, (_, series) in enumerate(topic.lines)
            if series.least <= series.greatest
        ]
        self.by_entity = {topic.entity: topic for topic in topics.found}
        self.nodes = sorted({(topic.bus, topic.node) for topic in topics.found if topic.node})
        self.several = len({bus for bus, _ in self.nodes}) > 1

    def layout(self) -> Blueprint:
        """Overview, then the nodes."""
        pages = [page for bus, node in self.nodes if (page := self.page(bus, node))]
        tabs = [self.overview(), *pages]
        if len(pages) > TABS:
            tabs[1:] = [rrb.Tabs(*pages, name=self.words("timeline.nodes"))]
        bound = rr.TimeRangeBoundary.absolute
        first, last = self.topics.first_ns, max(self.topics.last_ns, self.topics.first_ns + 1_000_000)
        return Blueprint(rrb.Tabs(*tabs, active_tab=0), CLOCK, rr.TimeRange(bound(nanos=first), bound(nanos=last)))

    def overview(self) -> Part:
        """States of all nodes above the plots that tell most; log and SDO transfers of each node beside them."""
        states = [*self.topics.of(NMT), *self.topics.of(DRIVE)]
        left = [self.states(states)] if states else []
        left += _grid([self.plot(chart) for chart in charts.overview(self.lines, ROOM)])
        right: list[Part] = [self.log()] if self.topics.of(LOG) else []
        transfers = self.topics.of(SDO)
        if 0 < len(transfers) <= TABS:
            right.append(rrb.Tabs(*map(self.transfers, transfers), active_tab=0))
        name = self.words("timeline.overview")
        if not left or not right:
            return column([*left, *((view, TEXT) for view in right)], name)
        beside = column([(view, TEXT) for view in right])
        return rrb.Horizontal(column(left), beside, column_shares=[3, 2], name=name)

    def page(self, bus: str, node: int) -> rrb.Container | None:
        """All states and all plots of a node."""
        states = [topic for topic in self.topics.found if topic.states and (topic.bus, topic.node) == (bus, node)]
        parts = [self.states(states)] if states else []
        mine = [line for line in self.lines if (line.bus, line.node) == (bus, node)]
        parts += _grid([self.plot(chart, of_node=True) for chart in charts.of_node(mine)])
        parts += [
            (self.transfers(topic), TEXT) for topic in self.topics.of(SDO) if (topic.bus, topic.node) == (bus, node)
        ]
        return column(parts, self.node_name(bus, node)) if parts else None

    def node_name(self, bus: str, node: int) -> str:
        """Node 5; with its bus where there are several."""
        name = self.words("timeline.node", node=node)
        return f"{bus} {name}" if self.several else name

    def states(self, topics: list[Topic]) -> Sized:
        """Lanes, several of one topic where its messages have several states."""
        overrides: dict[Any, list[rrb.Visualizer]] = {
            topic.entity: [self.lane(topic, name) for name in topic.states] for topic in topics
        }
        count = sum(len(topic.states) for topic in topics)
        view = rrb.StateTimelineView(
            origin="/",
            contents=list(overrides),
            name=self.words("timeline.states"),
            time_view=LINKED,
            overrides=overrides,
        )
        return view, BAR + LANE * min(count, 12)

    def lane(self, topic: Topic, name: str) -> rrb.Visualizer:
        """One lane: a field as a state."""
        style = rr.StateConfiguration()
        if known := self.topics.colours.get(topic.kind):
            colours = np.array(list(known.values()), np.uint32)
            style = rr.StateConfiguration(values=list(known), labels=list(known), colors=colours)
        return style.visualizer(mappings=[_mapping("StateChange:state", topic, name)])

    def plot(self, chart: Chart, *, of_node: bool = False) -> rrb.View:
        """One plot, each line a field."""
        overrides: dict[Any, list[rrb.Visualizer]] = {}
        for line in chart.lines:
            topic = self.by_entity[line.entity]
            name = self.node_name(line.bus, line.node) if chart.shared else line.series.name
            style = rr.SeriesLines(names=name, interpolation_mode="StepAfter")
            mapping = _mapping("Scalars:scalars", topic, topic.lines[line.index][0])
            overrides.setdefault(line.entity, []).append(style.visualizer(mappings=[mapping]))
        first = chart.lines[0]
        before = "" if of_node or chart.shared else self.node_name(first.bus, first.node) + " "
        unit = f" [{chart.unit}]" if chart.unit else ""
        names = self.words("timeline.comma").join(dict.fromkeys(line.title for line in chart.lines))
        return rrb.TimeSeriesView(
            origin="/",
            contents=list(overrides),
            name=before + fit(names, TITLE - width(before + unit)) + unit,
            axis_x=LINKED,
            plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.LeftTop, visible=1 < len(chart.lines) <= _LEGEND),
            overrides=overrides,
        )

    def log(self) -> rrb.View:
        """Findings and emergencies, which Rerun draws as they are."""
        return rrb.TextLogView(
            origin="/",
            contents=[topic.entity for topic in self.topics.of(LOG)],
            name=self.words("timeline.log"),
            columns=_COLUMNS,
        )

    def transfers(self, topic: Topic) -> rrb.View:
        """SDO transfers of a node in words, with what became of them for a level."""
        mappings = [_mapping("TextLog:text", topic, topic.text), _mapping("TextLog:level", topic, "status")]
        return rrb.TextLogView(
            origin="/",
            contents=[topic.entity],
            name=f"{self.node_name(topic.bus, topic.node)} {self.words('timeline.sdo')}",
            columns=_COLUMNS,
            overrides={topic.entity: rr.TextLog.from_fields().visualizer(mappings=mappings)},
        )


def _grid(plots: list[rrb.View]) -> list[Sized]:
    """Put plots below each other, in two columns where they are many."""
    if not plots:
        return []
    columns = 1 if len(plots) <= 4 else 2
    height = _PLOT * -(-len(plots) // columns)
    return [(rrb.Vertical(*plots) if columns == 1 else rrb.Grid(*plots, grid_columns=columns), height)]


def _mapping(what: str, topic: Topic, name: str) -> Any:
    """Say that a field of a topic's messages is a component that Rerun draws."""
    return rrb.encodings.VisualizerComponentMapping(
        what,
        rrb.encodings.ComponentSourceKind.SourceComponent,
        source_component=topic.component,
        selector=f".{name}",
    )
