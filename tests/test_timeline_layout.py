"""The first layout of a timeline: what is in it, by what a recording holds.

What it must not do: look at pictures, which `test_timeline_render.py` does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rerun")

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader
from timeline_contents import EVERY, drive, hundreds, lanes, network, plot, series, stamped

from canalyze.output.layout import width
from canalyze.timeline import charts
from canalyze.timeline.layout import CLOCK, PAGE, ROOM, SPAN, TITLE, WIDE, fit, layout, listed
from canalyze.timeline.stream import Contents, Series
from canalyze.words import LANGUAGES, Words

ALL = pytest.mark.parametrize("contents", EVERY.values(), ids=EVERY.keys())


@pytest.fixture(autouse=True)
def strict(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the library raise what it would only warn of."""
    monkeypatch.setenv("RERUN_STRICT", "1")


def tabs(contents: Contents, lang: str = "en") -> list[rrb.Container]:
    root = layout(contents, Words(lang)).root_container
    assert isinstance(root, rrb.Tabs)
    return [part for part in root.contents if isinstance(part, rrb.Container)]


def views(part: rrb.Container | rrb.View) -> Iterator[rrb.View]:
    if isinstance(part, rrb.View):
        yield part
    else:
        for inner in part.contents:
            yield from views(inner)


def of(view: rrb.View) -> set[str]:
    """The entities that a view names, one by one."""
    assert isinstance(view.contents, list)
    return set(view.contents)


def listed_in(view: rrb.View) -> list[Any]:
    """The same in their order."""
    assert isinstance(view.contents, list)
    return list(view.contents)


def names(part: rrb.Container | rrb.View) -> list[str]:
    return [str(view.name) for view in views(part)]


def shown(view: rrb.View, contents: Contents) -> dict[str, list[str]]:
    """The lines that a plot shows, by entity."""
    found: dict[str, list[str]] = {}
    if not isinstance(view, rrb.TimeSeriesView):
        return found
    overrides: dict[Any, Any] = view.visualizer_overrides
    for entity in of(view) - {SPAN}:
        found[entity] = [one.name for one in contents.plots[entity].series] if entity in contents.plots else [entity]
        if entity in overrides:
            style = {
                str(one.component_descriptor()): one.as_arrow_array().to_pylist() for one in overrides[entity].overrides
            }
            (names,) = (values for name, values in style.items() if "names" in name)
            (visible,) = (values for name, values in style.items() if "visible_series" in name)
            found[entity] = [name for name, one in zip(names, visible, strict=True) if one]
    return found


def entities(contents: Contents) -> set[str]:
    """Every entity that a recording of it has."""
    found = {*contents.plots, *contents.lanes, *contents.delays, SPAN}
    found |= {*contents.durations}
    for bus in contents.sync:
        found.add("/".join(["/sync", *filter(None, [bus]), "period"]))
    for bus in contents.windows:
        found.add("/".join(["/sync", *filter(None, [bus]), "window"]))
    found |= {"/".join(["/load", *filter(None, [bus])]) for bus in contents.load}
    found |= {"/log/findings/**"} if contents.findings else set()
    there = {"/frames": contents.frames, "/summary": contents.summary, "/log": contents.logged}
    return found | {entity for entity, some in there.items() if some}


@ALL
def test_every_view_has_something_in_it(contents: Contents) -> None:
    there = entities(contents)
    for part in tabs(contents):
        for view in views(part):
            if view.origin == "/":
                assert of(view) <= there
                assert not isinstance(view, rrb.TimeSeriesView) or any(shown(view, contents).values())
            else:
                assert any(entity == view.origin or entity.startswith(f"{view.origin}/") for entity in there)


@ALL
def test_everything_has_a_view(contents: Contents) -> None:
    """Lanes and lines that the overview has no room for stand in their node's tab."""
    covered: set[str] = set()
    lines: set[tuple[str, str]] = set()
    for part in tabs(contents):
        for view in views(part):
            covered |= of(view) if view.origin == "/" else {str(view.origin)}
            lines |= {
                (entity, name.rpartition(" TPDO")[0] or name)
                for entity, ones in shown(view, contents).items()
                for name in ones
            }
    below = tuple(f"{entity}/" for entity in covered)
    assert {one for one in entities(contents) if one not in covered and not one.startswith(below)} <= {SPAN}
    for entity, one in contents.plots.items():
        assert {(entity, line.name) for line in one.series} <= lines


@ALL
@pytest.mark.parametrize("lang", LANGUAGES)
def test_titles_fit(contents: Contents, lang: str) -> None:
    overview, *others = tabs(contents, lang)
    assert all(width(name) <= TITLE for name in names(overview)), names(overview)
    assert all(width(name) <= WIDE for part in others for name in names(part))
    assert not {name for part in [overview, *others] for name in names(part) if name in ("", "None")}


@ALL
def test_one_axis_one_unit(contents: Contents) -> None:
    units = {line.name: line.unit for one in contents.plots.values() for line in one.series}
    by_chart = charts.overview(charts.lines(contents), ROOM)
    assert all({line.series.unit for line in chart.lines} == {chart.unit} for chart in by_chart)
    for part in tabs(contents)[1:]:
        for view in views(part):
            named = [name.rpartition(" TPDO")[0] or name for ones in shown(view, contents).values() for name in ones]
            assert len({units[name] for name in named if name in units}) <= 1


def test_the_overview_of_a_drive() -> None:
    overview, node = tabs(drive())
    assert [overview.name, node.name] == ["Overview", "Node 5"]
    assert names(overview) == [
        "NMT states",
        "States",
        "Velocity, Target velocity [rpm]",
        "Torque [%]",
        "Position",
        "Gear",
        "SYNC period [µs]",
        "Synchronous PDOs: delay and window [µs]",
        "Frames per second",
        "SDO transfer duration [ms] (red: failed)",
        "Findings and EMCY",
        "Summary",
        "Frames",
    ]
    states = next(view for view in views(overview) if view.name == "States")
    assert of(next(views(overview))) == {"/nmt/node5"}
    assert "/value/node5/TPDO1/Statusword" in of(states)
    assert "2101h:03" in names(node) and "2101h:03" not in names(overview)


def test_few_plots_leave_room_for_frames() -> None:
    contents = stamped()
    lanes(contents, "/nmt/node5")
    contents.load["can0"] = True
    assert names(tabs(contents)[0]) == ["NMT states", "Bus load [%]", "Frames", "Summary"]


def test_a_short_capture_has_no_course_of_load() -> None:
    contents = drive()
    contents.last_ns = 200_000_000
    assert "Frames per second" in names(tabs(drive())[0])
    assert "Frames per second" not in names(tabs(contents)[0])


def test_lanes_of_signals_where_there_is_room() -> None:
    contents = network(4)
    bits = [f"/value/can0/node{node}/TPDO3/Inputs{bit}" for node in (1, 2) for bit in ("", ".0", ".1")]
    lanes(contents, *bits)
    overview = tabs(contents)[0]
    assert names(overview)[:5] == [
        "NMT states",
        "Drive states",
        "EMCY: active errors",
        "SDO transfers",
        "Signal values",
    ]
    values = next(view for view in views(overview) if view.name == "Signal values")
    assert {entity for entity in bits if entity.endswith("s")} <= of(values) <= set(bits)


def test_many_nodes_share_plots_and_a_tab() -> None:
    contents = network(30)
    overview, nodes = tabs(contents)
    kinds = ["NMT states", "Drive states", "EMCY: active errors", "SDO transfers"]
    assert names(overview)[:8] == [
        *kinds,
        "Velocity (30 nodes) [rpm]",
        "Torque (30 nodes) [%]",
        "Position (30 nodes)",
        "Temperature (30 nodes) [°C]",
    ]
    assert [part.name for part in nodes.contents] == [f"Node {node}" for node in range(1, 31)]
    velocity = next(view for view in views(overview) if view.name == "Velocity (30 nodes) [rpm]")
    assert shown(velocity, contents)["/pdo/can0/node7/TPDO1"] == ["Node 7"]


def test_pages_as_long_as_there_is_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """A layout of thousands of nodes would be gigabytes, and nobody reads it; which ones it has, it says."""
    asked: list[str] = []
    whose = charts.place

    def place(entity: str) -> tuple[str, int]:
        asked.append(entity)
        return whose(entity)

    monkeypatch.setattr(charts, "place", place)
    monkeypatch.setattr("canalyze.timeline.layout.MOST", 128)
    contents = network(30, ("can0", "can1"))
    _, nodes = tabs(contents)
    count = len(list(nodes.contents))
    assert 20 < count < 60
    assert nodes.name == f"Nodes (first {count} of 60)"
    assert 110 < len(list(views(nodes))) <= 128
    # Not for each node anew.
    assert len(asked) <= 3 * (len(contents.lanes) + len(contents.plots))


def test_a_bus_full_of_nodes_has_a_page_for_each() -> None:
    _, nodes = tabs(network(127))
    assert (nodes.name, len(list(nodes.contents))) == ("Nodes", 127)


def test_lanes_with_faults_come_first() -> None:
    """Where there are more lanes than are in sight; where all are, they stand once."""
    contents = network(30)
    for entity in ("/nmt/can0/node17", "/emcy/can0/node30", "/drive/can0/node9"):
        contents.lanes[entity].fault = True
    first = next(views(tabs(contents)[0]))
    assert first.name == "Lanes with faults"
    assert of(first) == {"/nmt/can0/node17", "/emcy/can0/node30", "/drive/can0/node9"}
    contents = network(3)
    contents.lanes["/nmt/can0/node1"].fault = True
    assert names(tabs(contents)[0])[:2] == ["NMT states", "States"]


def test_what_has_failed_is_in_sight() -> None:
    """Not below a screen full of what is only information; the title says what is left out."""
    contents = drive()
    for logged, title in (
        ({"INFO": 10, "ERROR": 1}, "Findings and EMCY"),
        ({"INFO": 500}, "Findings and EMCY"),
        ({"INFO": 500, "ERROR": 1}, "Findings and EMCY (errors, warnings)"),
        ({"INFO": 11, "WARN": 40}, "Findings and EMCY (errors, warnings)"),
    ):
        contents.logged = dict(logged)
        (log,) = (view for view in views(tabs(contents)[0]) if view.origin == "/log")
        assert log.name == title
        rows = log.properties["TextLogRows"].as_component_batches()
        (levels,) = (one.as_arrow_array().to_pylist() for one in rows if "level" in str(one.component_descriptor()))
        assert ("INFO" in levels) == (title == "Findings and EMCY")


def test_a_finding_stands_with_its_frame() -> None:
    """Also one that is told of an earlier frame, which is listed already."""
    for findings, there in ((1, {"/frames", "/log/findings/**"}), (0, {"/frames"})):
        contents = drive()
        contents.findings = findings
        (frames,) = (view for view in views(tabs(contents)[0]) if view.name == "Frames")
        assert of(frames) == there


def test_short_transfers_are_points() -> None:
    title = "SDO transfer duration [ms] (red: failed)"
    contents = drive()
    for took, seen in ((10**6, True), (10**7, False)):
        contents.transferring_ns = contents.transfers * took
        overview, node = tabs(contents)
        assert (title in names(overview)) == seen
        # Of two that are alike, a lane that has room for them shows one.
        assert title in names(node)
    contents = network(30)
    assert "SDO transfers" in names(tabs(contents)[0])
    contents.transfers = 1
    assert "SDO transfers" not in names(tabs(contents)[0])
    assert title in names(tabs(contents)[0])


def test_lanes_stand_once_where_they_are_many() -> None:
    contents = network(30)
    lanes(contents, "/emcy/can0/node9")
    contents.lanes["/emcy/can0/node30"].fault = True
    assert "EMCY: active errors" in names(tabs(contents)[0])
    contents.lanes["/emcy/can0/node9"].fault = True
    assert "EMCY: active errors" not in names(tabs(contents)[0])


def test_a_low_load_has_an_axis_of_its_own() -> None:
    contents = network(3)
    for peak, end in ((3.0, 21.0), (20.1, 52.5), (42.0, 52.5), (51.0, 105.0)):
        contents.peaks["can0"] = peak
        load = next(view for view in views(tabs(contents)[0]) if view.name == "Bus load [%]")
        (axis,) = (
            one.as_arrow_array().to_pylist()[0]
            for one in load.properties["ScalarAxis"].as_component_batches()
            if "range" in str(one.component_descriptor())
        )
        assert list(axis) == [0.0, end]


def test_buses_are_named_where_there_are_several() -> None:
    parts = tabs(network(2, ("can0", "can1")))
    assert [part.name for part in parts[1:]] == ["can0 Node 1", "can0 Node 2", "can1 Node 1", "can1 Node 2"]
    assert "can1 SYNC period [µs]" in names(parts[0])


def test_hundreds_of_signals() -> None:
    contents = hundreds()
    overview, *nodes = tabs(contents)
    plots = [view for view in views(overview) if isinstance(view, rrb.TimeSeriesView)]
    assert 4 <= len(plots) <= ROOM
    assert [str(view.name)[:6] for view in plots] == [f"Node {node}" for node in range(1, len(plots) + 1)]
    chosen = {(entity, name) for view in plots for entity, ones in shown(view, contents).items() for name in ones}
    by_name = {(entity, line.name): line for entity, one in contents.plots.items() for line in one.series}
    assert all(by_name[one].varies and by_name[one].described for one in chosen)
    for page in nodes:
        pages = [part for part in page.contents if isinstance(part, rrb.Tabs)]
        assert all(len(list(views(one))) <= PAGE for tab in pages for one in tab.contents)


@pytest.mark.parametrize("nodes", [1, 2, 3, 5, 9, 30, 127])
def test_the_overview_has_room(nodes: int) -> None:
    contents = network(nodes)
    overview = tabs(contents)[0]
    plots = [view for view in views(overview) if isinstance(view, rrb.TimeSeriesView)]
    assert len(plots) <= ROOM + 3
    assert len(charts.overview(charts.lines(contents), 3)) <= 3


def test_no_two_lines_of_a_plot_have_one_name() -> None:
    contents = stamped()
    for pdo in ("TPDO1", "TPDO2"):
        plot(contents, 5, pdo, [series("Velocity", "rpm"), series("Position")])
    for view in views(tabs(contents)[0]):
        every = [name for ones in shown(view, contents).values() for name in ones]
        assert len(set(every)) == len(every)
    assert {"Velocity [rpm] TPDO1", "Velocity [rpm] TPDO2"} <= {
        name for view in views(tabs(contents)[0]) for ones in shown(view, contents).values() for name in ones
    }


def test_lines_of_unlike_magnitude_have_plots_of_their_own() -> None:
    contents = stamped()
    plot(contents, 5, "TPDO1", [series("A", greatest=5e6), series("B", greatest=40), series("C", greatest=7e6)])
    assert [[line.title for line in chart.lines] for chart in charts.overview(charts.lines(contents), ROOM)] == [
        ["A", "C"],
        ["B"],
    ]


@pytest.mark.parametrize(
    ("entity", "place"),
    [
        ("/nmt/can0/node5", ("can0", 5)),
        ("/nmt/node5", ("", 5)),
        ("/value/node5/TPDO1/node6", ("", 5)),
        ("/drive/can0/node127/axis2", ("can0", 127)),
        ("/sdo/node4/node5", ("node4", 5)),
        ("/load/can0", ("", 0)),
    ],
)
def test_whose_an_entity_is(entity: str, place: tuple[str, int]) -> None:
    assert charts.place(entity) == place


def test_titles_are_cut_between_names() -> None:
    assert listed(["Velocity", "Torque", "Position"], ", ", 20) == "Velocity, Torque…"
    assert listed(["速度实际值", "转矩实际值"], "、", 12) == "速度实际值…"
    assert listed(["Velocity actual value"], ", ", 10) == "Velocity…"
    assert fit("速度实际值", 6) == "速度…"


@ALL
def test_ids_are_the_same_each_time(contents: Contents) -> None:
    first, again = ([view.id for part in tabs(contents) for view in views(part)] for _ in range(2))
    assert first == again and len(set(first)) == len(first)


def test_a_new_plot_leaves_the_others_their_ids() -> None:
    """Live, a layout is sent anew: what the viewer knows of a view is kept by its id."""
    before, after = drive(), drive()
    plot(after, 5, "TPDO4", [series("Current", "A")])
    ids = [{str(view.name): view.id for view in views(tabs(one)[0])} for one in (before, after)]
    assert ids[0].items() <= ids[1].items()


def test_a_layout_is_small(tmp_path: Path) -> None:
    """It is part of every recording, and sent anew where one grows."""
    layout(network(30), Words("en")).save("canalyze-test", tmp_path / "out.rbl")
    assert (tmp_path / "out.rbl").stat().st_size < 4_500_000


@pytest.mark.parametrize(("timed", "timeline"), [(True, CLOCK), (False, "frame")])
@pytest.mark.parametrize("live", [False, True])
def test_what_a_reader_finds(timed: bool, timeline: str, live: bool, tmp_path: Path) -> None:
    recording = rr.RecordingStream("canalyze-test", recording_id="test")
    recording.save(tmp_path / "out.rrd", default_blueprint=layout(drive(timed=timed), Words("zh"), live=live))
    recording.log("x", rr.TextDocument("x"), static=True)
    recording.flush()
    recording.disconnect()
    reader = RrdReader(str(tmp_path / "out.rrd"))
    (store,) = reader.blueprints()
    found = [(chunk.entity_path, chunk.to_record_batch()) for chunk in reader.stream(store=store)]
    timelines = [
        batch.column(name)[0].as_py()
        for path, batch in found
        for name in batch.schema.names
        if path == "/time_panel" and name.endswith(":timeline")
    ]
    assert timelines == [[timeline]]
    assert any(path == "/view/5c0dca6a-e63f-9cf7-f657-2602590474cc/TimeAxis" for path, _ in found)


@pytest.mark.parametrize(
    ("least", "greatest"),
    [(0, 6000), (-70000, 50000), (-900, 900), (8190, 8290), (0.0021, 0.0024), (0, 1), (99, 101), (-1e9, 3), (5, 9.99)],
)
@pytest.mark.parametrize("height", [50.0, 90.0, 140.0, 600.0])
def test_three_numbers_stand_beside_an_axis(least: float, greatest: float, height: float) -> None:
    """At multiples of a power of ten that are far enough apart; all values are in sight."""
    ends = charts.labelled(least, greatest, height) or (least, greatest)
    assert ends[0] <= least and greatest <= ends[1]
    steps = [10.0**power for power in range(-6, 12)]
    room = [step for step in steps if (ends[1] - ends[0]) / step * 14 <= max(height, 3.6 * 14)]
    counts = [math.floor(ends[1] / step + 1e-9) - math.ceil(ends[0] / step - 1e-9) + 1 for step in room]
    assert max(counts) >= 3, (ends, counts)


def test_a_constant_has_the_axis_that_the_viewer_gives_it() -> None:
    assert charts.labelled(5, 5, 100) is None
    assert charts.labelled(float("inf"), float("-inf"), 100) is None


def test_while_it_grows_no_axis_is_fixed() -> None:
    contents = drive()
    plots = [view for view in views(layout(contents, Words("en"), live=True).root_container) if _has_range(view)]
    assert [str(view.name) for view in plots] == []
    assert any(_has_range(view) for part in tabs(contents) for view in views(part))


def _has_range(view: rrb.View) -> bool:
    axis = view.properties.get("ScalarAxis") if isinstance(view, rrb.TimeSeriesView) else None
    return axis is not None and any("range" in str(one.component_descriptor()) for one in axis.as_component_batches())


def test_signals_share_a_plot_by_unit_and_kind() -> None:
    contents = stamped()
    one = [
        Series("Target position", "", True, 0, 1000, kind="position"),
        Series("Position", "", True, 0, 2000, kind="position"),
        Series("Input", "", True, 0, 1500, kind="analogue input"),
        Series("Speed [rpm]", "rpm", True, 0, 1500, kind="velocity"),
        Series("Limit [rpm]", "rpm", True, 0, 1500, kind="other"),
    ]
    plot(contents, 5, "TPDO1", one)
    found = [{line.title for line in chart.lines} for chart in charts.of_node(charts.lines(contents))]
    assert sorted(found, key=sorted) == [{"Input"}, {"Limit"}, {"Position", "Target position"}, {"Speed"}]


def test_findings_and_transfers_stand_beside_their_node() -> None:
    contents = network(2)
    contents.told[("can0", 1)] = {"/log/findings/can0/node1": None, "/log/emcy/can0/node1": None}
    contents.listed = {"/sdo_list/can0/node1": {"INFO", "ERROR"}, "/sdo_list/can0/node2": {"INFO"}}
    overview, first, second = tabs(contents)
    logs = [view for view in views(first) if isinstance(view, rrb.TextLogView)]
    assert [of(view) for view in logs] == [set(contents.told[("can0", 1)]), {"/sdo_list/can0/node1"}]
    assert [of(view) for view in views(second) if isinstance(view, rrb.TextLogView)] == [{"/sdo_list/can0/node2"}]
    assert {"/sdo_list/can0/node1", "/sdo_list/can0/node2"} in [
        of(view) for view in views(overview) if isinstance(view.contents, list)
    ]


def test_a_level_is_told_where_there_are_several() -> None:
    contents = network(1)
    contents.listed = {"/sdo_list/can0/node1": {"INFO"}}
    for levels, logged in (({"INFO"}, {"WARN": 3}), ({"INFO", "ERROR"}, {"WARN": 3, "ERROR": 1})):
        contents.listed["/sdo_list/can0/node1"], contents.logged = levels, logged
        texts = [view for view in views(tabs(contents)[0]) if isinstance(view, rrb.TextLogView)]
        shows = {str(view.name): _level_shown(view) for view in texts}
        several = len(levels) > 1
        assert shows == {"SDO list": several, "Findings and EMCY": several, "Frames": False}


def _level_shown(view: rrb.View) -> bool:
    """Kind 2 is that of a level."""
    columns = view.properties["TextLogColumns"].as_component_batches()
    (kinds,) = (one.as_arrow_array().to_pylist() for one in columns if "text_log" in str(one.component_descriptor()))
    return 2 in [one["kind"] for one in kinds]


def test_no_lane_of_a_node_is_cut_off() -> None:
    """Many stand on pages, single bits behind what they are bits of."""
    contents = drive()
    whole = [f"/value/node5/TPDO{number}/Statusword" for number in range(1, 9)]
    lanes(contents, *(f"{one}.{bit}" for one in whole for bit in range(8)), *whole)
    pages = [view for view in views(tabs(contents)[1]) if isinstance(view, rrb.StateTimelineView)]
    assert all(len(of(view)) <= 10 for view in pages)
    shown_lanes = [str(lane) for view in pages for lane in listed_in(view)]
    assert set(shown_lanes) == {one.entity for one in contents.lanes.values() if one.rows}
    bits = [lane.rpartition(".")[2].isdecimal() for lane in shown_lanes]
    assert bits == sorted(bits)
