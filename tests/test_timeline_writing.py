"""How a timeline is written: batches made by hand in, what a reader of the recording finds out.

What it must not do: test what the core says of a capture.
"""

from __future__ import annotations

import math
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

pytest.importorskip("rerun")

from recordings import Recording, recording
from timeline_batches import pdo, table
from timeline_viewer import RERUN

from canalyze.errors import OutputError
from canalyze.timeline.charts import PLAIN
from canalyze.timeline.recording import Timeline
from canalyze.words import Words

START = 1_700_000_000 * 10**9
MS = 1_000_000
SECOND = 1000 * MS
DAY = 86_400 * SECOND


def listed(frame: int, t_ns: int | None, **more: Any) -> dict[str, Any]:
    return {"frame": frame, "t_ns": t_ns, "node": 5, "service": "pdo", "line": f"line {frame}", **more}


def written(tmp_path: Path, *takes: list[tuple[str, Any]], **options: Any) -> tuple[Timeline, Recording]:
    """A timeline of batches, and what is in its file."""
    out = tmp_path / "out.rrd"
    timeline = Timeline(Words("en"), name="capture.log", save=str(out), **options)
    for batches in takes:
        timeline.take(batches)
    timeline.finish()
    return timeline, recording(out)


def test_quantities_of_a_pdo(tmp_path: Path) -> None:
    signals: dict[str, Any] = {
        "Velocity": (pa.int16(), {"object": "606C:00", "unit": "rpm", "factor": "0.5"}, [10, None, -30]),
        "Statusword": (pa.uint16(), {"object": "6041:00", "quantity": "false"}, [1, 2, 3]),
        "2000h:01": (pa.float32(), {"object": "2000:01"}, [1.5, 2.5, 2.5]),
    }
    rows = [{"t_ns": START + at * MS, "frame": at + 1, "cycle": at, "delay_ns": at * 1000} for at in range(3)]
    batches = [table("listing", [listed(1, START)]), pdo(5, "TPDO1", signals, rows)]
    timeline, found = written(tmp_path, batches)
    values = found.rows("/pdo/can0/node5/TPDO1", "Scalars:scalars")
    assert [(row["time_since_start"], row["frame"], row["sync_cycle"], row["capture_time"]) for row in values] == [
        (at * MS, at + 1, at, START + at * MS) for at in range(3)
    ]
    assert values[0]["value"] == [5.0, 1.5]
    assert math.isnan(values[1]["value"][0])
    assert values[2]["value"] == [-15.0, 2.5]
    assert found.static("/pdo/can0/node5/TPDO1", "SeriesLines:names") == ["Velocity [rpm]", "2000h:01"]
    step_after = 2
    assert found.static("/pdo/can0/node5/TPDO1", "SeriesLines:interpolation_mode") == [step_after]
    plot = timeline.contents.plots["/pdo/can0/node5/TPDO1"]
    assert (plot.node, plot.pdo, plot.rows) == (5, "TPDO1", 3)
    assert [(one.unit, one.described, one.least, one.greatest) for one in plot.series] == [
        ("rpm", True, -15.0, 5.0),
        ("", False, 1.5, 2.5),
    ]
    delays = found.rows("/sync/can0/delay/node5/TPDO1", "Scalars:scalars")
    assert [row["value"] for row in delays] == [[0.0], [1.0], [2.0]]


def test_a_long_name_is_cut_and_still_its_own(tmp_path: Path) -> None:
    """A title of two thousand characters leaves no room for anything."""
    signals: dict[str, Any] = {
        "n" * 2000: (pa.int16(), {"object": "2000:01", "unit": "V"}, [1]),
        "n" * 2000 + "!": (pa.int16(), {"object": "2000:02"}, [2]),
        "n" * 64: (pa.int16(), {"object": "2000:03"}, [3]),
    }
    batches = [table("listing", [listed(1, START)]), pdo(5, "TPDO1", signals, [{"t_ns": START, "frame": 1}])]
    _, found = written(tmp_path, batches)
    names = found.static("/pdo/can0/node5/TPDO1", "SeriesLines:names")
    assert names == [f"{'n' * 64}… (2000:01) [V]", f"{'n' * 64}… (2000:02)", "n" * 64]


def test_another_mapping_is_another_entity(tmp_path: Path) -> None:
    rows = [{"t_ns": START, "frame": 1}]
    batches = [
        table("listing", [listed(1, START)]),
        pdo(5, "TPDO1", {"A": (pa.uint8(), {}, [1])}, rows),
        pdo(5, "TPDO1", {"B": (pa.uint8(), {}, [2])}, rows, version=2),
        pdo(6, "RPDO1", {"C": (pa.uint8(), {}, [3])}, rows, bus=""),
    ]
    _, found = written(tmp_path, batches)
    for entity, value in (("/pdo/can0/node5/TPDO1", 1), ("/pdo/can0/node5/TPDO1/v2", 2), ("/pdo/node6/RPDO1", 3)):
        assert [row["value"] for row in found.rows(entity, "Scalars:scalars")] == [[value]]


def test_states(tmp_path: Path) -> None:
    lane, other = "nmt/can0/node5", "value/can0/node5/TPDO1/Digital_inputs.3"
    rows: list[dict[str, Any]] = [
        {"lane": lane, "state": "Pre-operational", "class": "pre-operational"},
        {"lane": other, "state": "0", "class": "0"},
        {"lane": lane, "state": "Operational", "class": "operational"},
        {"lane": other, "state": "", "class": None},
        {"lane": lane, "state": None, "class": None},
    ]
    stamped = [{**row, "t_ns": START + at * MS, "frame": at + 1} for at, row in enumerate(rows)]
    timeline, found = written(tmp_path, [table("listing", [listed(1, START)]), table("lanes", stamped)])
    assert [(row["frame"], row["value"]) for row in found.rows("/nmt/can0/node5", "StateChange:state")] == [
        (1, ["Pre-operational"]),
        (3, ["Operational"]),
        (5, [""]),
    ]
    assert found.static("/nmt/can0/node5", "StateConfiguration:values") == ["Pre-operational", "Operational"]
    assert len(set(found.static("/nmt/can0/node5", "StateConfiguration:colors"))) == 2
    bits = found.rows("/value/can0/node5/TPDO1/Digital_inputs.3", "StateChange:state")
    assert [row["value"] for row in bits] == [["0"], ['""']]
    assert [one.kind for one in timeline.contents.lanes.values()] == ["nmt", "value"]


def test_values_of_signals_have_quiet_colours(tmp_path: Path) -> None:
    """None of them looks like a fault, and one text has one colour in all lanes."""
    ends = [("value/node5/TPDO1/mode", "3 profile velocity"), ("value/node6/TPDO1/mode", "1 profile position")]
    rows = [
        {"lane": lane, "frame": at + 1, "state": state, "class": None}
        for at, (lane, state) in enumerate([(ends[0][0], ends[1][1]), ends[0], ends[1], ("nmt/node5", "x")])
    ]
    _, found = written(tmp_path, [table("listing", [listed(1, START)]), table("lanes", rows)])
    one, other = (
        {value: found.static(f"/{lane}", "StateConfiguration:colors")[at] for at, value in enumerate(values)}
        for lane, _ in ends
        for values in [found.static(f"/{lane}", "StateConfiguration:values")]
    )
    assert set(one.values()) <= set(PLAIN) and len(set(one.values())) == 2
    assert other == {"1 profile position": one["1 profile position"]}


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_new_state_has_its_colour_at_once(tmp_path: Path) -> None:
    """Until it is told, the viewer shows one of its own: Operational in red."""
    timeline = Timeline(Words("en"), name="can0", save=str(tmp_path / "out.rrd"), live=True)
    timeline.take([table("listing", [listed(1, START)])])
    told: list[str] = []
    always = timeline._stream.always

    def tell(entity: str, what: Any) -> None:
        told.append(entity)
        always(entity, what)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timeline._stream, "always", tell)
        row = {"lane": "nmt/node5", "frame": 1, "state": "Operational", "class": "operational"}
        timeline.take([table("lanes", [row])])
    timeline.close()
    assert told == ["/nmt/node5"]


def test_lanes_with_faults_are_known(tmp_path: Path) -> None:
    rows = [
        {"lane": "nmt/node5", "frame": 1, "state": "Operational", "class": "operational"},
        {"lane": "nmt/node6", "frame": 2, "state": "heartbeat lost", "class": "lost"},
        {"lane": "emcy/node6", "frame": 3, "state": "8130h", "class": "active"},
        {"lane": "sdo/node6", "frame": 4, "state": "1008h:00 read", "class": "aborted"},
    ]
    timeline, _ = written(tmp_path, [table("listing", [listed(1, START)]), table("lanes", rows)])
    assert [one.entity for one in timeline.contents.lanes.values() if one.fault] == ["/nmt/node6", "/emcy/node6"]


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_file_of_a_great_many_nodes_has_no_index(tmp_path: Path) -> None:
    """Rerun 0.41 fails on one that is as wide as 127 nodes make it."""
    for nodes, tail in ((100, True), (101, False)):
        out = tmp_path / f"{nodes}.rrd"
        timeline = Timeline(Words("en"), name="capture.log", save=str(out))
        timeline.take([table("listing", [listed(node, START, node=node) for node in range(1, nodes + 1)])])
        timeline.finish()
        done = subprocess.run([RERUN, "rrd", "verify", out], capture_output=True, text=True, check=False)
        assert (done.returncode == 0) is tail, done.stderr


def test_one_text_of_two_classes(tmp_path: Path) -> None:
    lane = "sdo/node5"
    rows: list[dict[str, Any]] = [
        {"lane": lane, "frame": 1, "state": "1008h:00 read", "class": "ok"},
        {"lane": lane, "frame": 2, "state": "1008h:00 read", "class": "aborted"},
    ]
    _, found = written(tmp_path, [table("listing", [listed(1, None)]), table("lanes", rows)])
    states = [row["value"] for row in found.rows("/sdo/node5", "StateChange:state")]
    assert states == [["1008h:00 read"], ["1008h:00 read (aborted)"]]
    assert found.static("/sdo/node5", "StateConfiguration:labels") == ["1008h:00 read"] * 2


def test_rows_without_a_stamp_stand_on_the_frames_only(tmp_path: Path) -> None:
    rows = [listed(1, START), listed(2, None), listed(3, START + MS)]
    timeline, found = written(tmp_path, [table("listing", rows)])
    lines = {row["frame"]: row for row in found.rows("/frames", "TextLog:text")}
    assert [lines[frame]["value"] for frame in (1, 2, 3)] == [["line 1"], ["line 2"], ["line 3"]]
    assert "time_since_start" not in lines[2]
    assert lines[3]["time_since_start"] == MS
    assert (timeline.contents.timed, timeline.contents.dated, timeline.contents.cycles) == (True, True, False)
    assert (timeline.contents.first_frame, timeline.contents.last_frame, timeline.contents.last_ns) == (1, 3, MS)


def test_no_stamp_at_all(tmp_path: Path) -> None:
    timeline, found = written(tmp_path, [table("listing", [listed(1, None), listed(2, None)])])
    assert [set(row) for row in found.rows("/frames", "TextLog:text")] == [{"frame", "value"}] * 2
    assert [set(row) for row in found.rows("/time_span", "Scalars:scalars")] == [{"frame", "value"}] * 2
    assert not timeline.contents.timed


def test_stamps_that_are_no_dates(tmp_path: Path) -> None:
    _, found = written(tmp_path, [table("listing", [listed(1, 5 * MS), listed(2, 7 * MS)])])
    rows = found.rows("/frames", "TextLog:text")
    assert [(row["frame"], row["time_since_start"]) for row in rows] == [(1, 0), (2, 2 * MS)]
    assert "capture_time" not in rows[0]


@pytest.mark.parametrize(
    ("stamps", "elapsed"),
    [
        ([0, DAY], [0, DAY]),
        ([-(2**63), 0, DAY], [1, 2**63 - 1, 2**63 - 1]),
        ([-(2**63), DAY, 2**63 - 1], [1, 2**63 - 1, 2**63 - 1]),
        ([START, 2**63 - 1], [0, 2**63 - 1 - START]),
        ([2**63 - 1, START, -(2**63), 0], [0, START - 2**63 + 1, 1, 2**63 - 1]),
    ],
)
def test_stamps_at_the_limits(tmp_path: Path, stamps: list[int], elapsed: list[int]) -> None:
    """A clock that jumps by centuries, either way: what cannot be said stands at the end of what can."""
    rows = [listed(number, t_ns) for number, t_ns in enumerate(stamps, 1)]
    _, found = written(tmp_path, [table("listing", rows)])
    assert [row["time_since_start"] for row in found.rows("/frames", "TextLog:text")] == elapsed


def test_a_clock_that_is_not_set_gives_no_dates(tmp_path: Path) -> None:
    batch = table("listing", [listed(1, START), listed(2, 5 * MS), listed(3, None), listed(4, START + MS)])
    timeline, found = written(tmp_path, [batch])
    rows = found.rows("/frames", "TextLog:text")
    assert [row.get("capture_time") for row in rows] == [START, None, None, START + MS]
    assert [row.get("time_since_start") for row in rows] == [0, 0, None, MS]
    assert timeline.contents.dated


@pytest.mark.parametrize("takes", [1, 4])
@pytest.mark.parametrize("stamps", [(30 * SECOND, START), (START, 30 * SECOND)])
def test_a_clock_that_is_set_in_the_middle_makes_no_gap(tmp_path: Path, stamps: tuple[int, int], takes: int) -> None:
    """From 1970 to now or back, in one batch or in several: the frame after it is where the one before it was."""
    times = [start + at * MS for start in stamps for at in (0, 100, 200, 300)]
    rows = [listed(number, t_ns) for number, t_ns in enumerate(times, 1)]
    size = len(rows) // takes
    batches = [[table("listing", rows[at : at + size])] for at in range(0, len(rows), size)]
    timeline, found = written(tmp_path, *batches)
    lines = found.rows("/frames", "TextLog:text")
    elapsed = [0, 100, 200, 300, 300, 400, 500, 600]
    assert [row["time_since_start"] for row in lines] == [at * MS for at in elapsed]
    assert [row.get("capture_time") for row in lines] == [t_ns if t_ns >= START else None for t_ns in times]
    assert (timeline.contents.first_ns, timeline.contents.last_ns) == (0, 600 * MS)
    ends = found.rows("/time_span", "Scalars:scalars")
    assert [row["time_since_start"] for row in ends] == [0, 600 * MS]
    assert [row["capture_time"] for row in ends] == [START, START + 300 * MS]


@pytest.mark.parametrize("stamps", [(30 * SECOND, START), (START, 30 * SECOND)])
def test_the_last_state_counts_where_a_clock_is_set(tmp_path: Path, stamps: tuple[int, int]) -> None:
    first, second = stamps
    rows = [(1, first, "one"), (2, first + MS, "two"), (3, second, "three")]
    states = [
        {"lane": "nmt/node5", "t_ns": t_ns, "frame": frame, "state": state, "class": "unknown"}
        for frame, t_ns, state in rows
    ]
    lines = [listed(frame, t_ns) for frame, t_ns, _ in rows]
    _, found = written(tmp_path, [table("listing", lines), table("lanes", states)])
    shown = found.rows("/nmt/node5", "StateChange:state")
    assert [(row["time_since_start"], row["value"]) for row in shown] == [(0, ["one"]), (MS, ["two"]), (MS, ["three"])]


@pytest.mark.parametrize("size", [1, 2, 9])
def test_transfers_last_until_the_next_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int) -> None:
    """Also where that comes with a later batch; of one whose end nobody knows, nobody knows how long it took."""
    course: list[tuple[int, str | None, str | None]] = [
        (0, "1000h:00 read", "ok"),
        (2, None, None),
        (5, "1000h:00 read", "ok"),
        (6, "1000h:00 read", "aborted"),
        (10, None, None),
        (11, "2000h:00 read", "incomplete"),
        (13, "2000h:00 read", "failed"),
        (18, None, None),
        (20, "2000h:00 read", "ok"),
    ]
    rows = [
        {"lane": "sdo/can0/node5", "t_ns": START + at * MS, "frame": at + 1, "state": state, "class": of_class}
        for at, state, of_class in course
    ]
    monkeypatch.setattr("canalyze.timeline.lanes._TOGETHER", 1)
    batches = [[table("lanes", rows[at : at + size])] for at in range(0, len(rows), size)]
    timeline, found = written(tmp_path, [table("listing", [listed(1, START)])], *batches)
    points = found.rows("/sdo_duration/can0/node5", "Scalars:scalars")
    took = {row["frame"]: [one for one in row["value"] if not math.isnan(one)] for row in points}
    assert took == {1: [2.0], 6: [1.0], 7: [4.0], 14: [5.0]}
    assert [math.isnan(row["value"][0]) for row in points] == [False, False, True, True]
    assert (timeline.contents.transfers, timeline.contents.transferring_ns) == (4, 12 * MS)
    assert not timeline.contents.brief
    # Each can be read besides, with what became of it.
    read = [found.rows("/sdo_list/can0/node5", f"TextLog:{what}") for what in ("text", "level")]
    assert [(text["frame"], text["value"][0], level["value"][0]) for text, level in zip(*read, strict=True)] == [
        (1, "Node 5  1000h:00 read", "INFO"),
        (6, "Node 5  1000h:00 read", "INFO"),
        (7, "Node 5  1000h:00 read", "ERROR"),
        (12, "Node 5  2000h:00 read", "WARN"),
        (14, "Node 5  2000h:00 read", "ERROR"),
        (21, "Node 5  2000h:00 read", "INFO"),
    ]
    assert timeline.contents.listed == {"/sdo_list/can0/node5": {"INFO", "WARN", "ERROR"}}
    without = [{**row, "t_ns": None} for row in rows]
    timeline, _ = written(tmp_path, [table("listing", [listed(1, None)]), table("lanes", without)])
    assert not timeline.contents.durations


def test_samples_do_not_hold_on(tmp_path: Path) -> None:
    rows = [{"t_ns": START, "frame": 1}, {"t_ns": START + 2 * MS, "frame": 3}]
    column: dict[str, Any] = {"A": (pa.uint8(), {}, [1, 2])}
    end = {"lane": "pdo/can0/node5/TPDO1", "t_ns": START + MS, "frame": 2, "state": None, "class": None}
    batches = [
        table("listing", [listed(1, START)]),
        table("lanes", [end, {**end, "lane": "pdo/can0/node6/TPDO1"}]),
        pdo(5, "TPDO1", column, rows),
        pdo(5, "TPDO1", column, rows, version=2),
    ]
    timeline, found = written(tmp_path, batches)
    for entity in ("/pdo/can0/node5/TPDO1", "/pdo/can0/node5/TPDO1/v2"):
        (one, none, two) = found.rows(entity, "Scalars:scalars")
        assert (one["value"], two["value"]) == ([1], [2])
        assert none["frame"] == 2 and none["time_since_start"] == MS and math.isnan(none["value"][0])
    assert "/pdo/can0/node6/TPDO1" not in found.entities()
    assert not timeline.contents.lanes
    assert [plot.rows for plot in timeline.contents.plots.values()] == [2, 2]


def test_time_begins_with_the_earliest_frame_whatever_comes_first(tmp_path: Path) -> None:
    later = [{"t_ns": START + 9 * MS, "frame": 10}]
    first = [pdo(5, "TPDO1", {"A": (pa.uint8(), {}, [1])}, later)]
    _, found = written(tmp_path, first, [table("listing", [listed(1, START), listed(10, START + 9 * MS)])])
    assert [row["time_since_start"] for row in found.rows("/pdo/can0/node5/TPDO1", "Scalars:scalars")] == [9 * MS]


def test_lines(tmp_path: Path) -> None:
    lines = [
        listed(1, START, severity="error"),
        listed(2, START, bus="can1", severity="warning"),
        listed(3, START, bus=None, severity="info"),
        listed(4, START),
    ]
    logged = [
        {"frame": 1, "t_ns": START, "level": "error", "source": "finding", "code": "SDO001", "text": "one"},
        {"frame": 2, "t_ns": START, "level": "info", "source": "emcy", "code": "0000", "text": "two", "node": 7},
    ]
    timeline, found = written(tmp_path, [table("listing", lines), table("log", logged)])
    assert [row["value"] for row in found.rows("/frames", "TextLog:level")] == [
        ["ERROR"],
        ["WARN"],
        ["INFO"],
        ["TRACE"],
    ]
    texts = [row["value"] for row in found.rows("/frames", "TextLog:text")]
    assert texts == [["can0  line 1"], ["can1  line 2"], ["-  line 3"], ["can0  line 4"]]
    assert [row["value"] for row in found.rows("/log/findings/can0", "TextLog:text")] == [["SDO001  one"]]
    assert [row["value"] for row in found.rows("/log/emcy/can0/node7", "TextLog:level")] == [["INFO"]]
    # The code of an emergency is in its text.
    assert [row["value"] for row in found.rows("/log/emcy/can0/node7", "TextLog:text")] == [["two"]]
    assert (timeline.contents.frames, timeline.contents.logged) == (4, {"ERROR": 1, "INFO": 1})
    # What belongs to a node can be shown beside it.
    assert timeline.contents.told == {("can0", 7): {"/log/emcy/can0/node7": None}}


def test_sync_and_load(tmp_path: Path) -> None:
    cycles: list[dict[str, Any]] = [
        {"cycle": 1, "frame": 1, "t_ns": START, "period_ns": None, "window_ns": None},
        {"cycle": 2, "frame": 3, "t_ns": START + MS, "period_ns": MS, "window_ns": 2 * MS},
        {"cycle": 3, "frame": 5, "t_ns": START + 2 * MS, "period_ns": MS, "window_ns": 2 * MS},
        {"cycle": 4, "frame": 7, "t_ns": START + 3 * MS, "period_ns": MS, "window_ns": 2 * MS},
    ]
    load: list[dict[str, Any]] = [
        {"frame": 3, "t_ns": START + MS, "bus": bus, "frames_per_s": 12.0, "load_percent": percent}
        for bus, percent in (("can0", 3.5), ("can1", None))
    ]
    batches = [table("listing", [listed(1, START)]), table("sync_cycles", cycles)]
    timeline, found = written(tmp_path, batches, [table("load", load)], [table("load", load[1:])])
    periods = [row["value"][0] for row in found.rows("/sync/can0/period", "Scalars:scalars")]
    assert math.isnan(periods[0])
    assert periods[1:] == [1000.0] * 3
    window = [(row["sync_cycle"], row["value"]) for row in found.rows("/sync/can0/window", "Scalars:scalars")]
    assert window == [(2, [2000.0]), (4, [2000.0])]
    # The first window is drawn from its begin, which is not before the capture's.
    assert [(row["value"], row["frame"]) for row in found.rows("/load/can0", "Scalars:scalars")] == [([3.5], 3)] * 2
    assert timeline.contents.peaks == {"can0": 3.5}
    assert timeline.contents.first_ns == 0
    assert timeline.contents.load == {"can0": True, "can1": False}
    assert [row["value"] for row in found.rows("/load/can1", "Scalars:scalars")] == [[12.0]] * 3
    assert timeline.contents.windows == {"can0"}


def test_empty(tmp_path: Path) -> None:
    timeline, found = written(tmp_path, [table("listing", [])])
    assert found.entities() <= {"/__properties", "/time_span"}
    assert timeline.contents.last_frame == 0


def test_names_that_are_no_paths(tmp_path: Path) -> None:
    rows = [{"lane": "value/can%2F1/node5/TPDO1/速度_[x]", "frame": 1, "state": "1", "class": None}]
    timeline, found = written(tmp_path, [table("listing", [listed(1, None)]), table("lanes", rows)])
    (entity,) = timeline.contents.lanes
    assert [row["value"] for row in found.rows(entity, "StateChange:state")] == [["1"]]


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
@pytest.mark.parametrize("live", [False, True])
def test_the_application_is_the_network(tmp_path: Path, live: bool) -> None:
    def application(rows: list[dict[str, Any]], *configuration: str) -> str:
        batches = [table("listing", rows)]
        return written(tmp_path, batches, configuration=configuration, live=live)[1].application

    one = application([listed(1, START), listed(2, START, node=6)])
    assert one.startswith("canalyze-can0-")
    assert set(one) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")
    assert application([listed(1, START + MS, node=6), listed(9, START + MS)]) == one
    assert (application([listed(1, START)]) == one) == live
    assert application([listed(1, START, bus="can1"), listed(2, START, bus="can1", node=6)]) != one
    assert application([listed(1, START), listed(2, START, node=6)], "5=drive.eds") != one


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
@pytest.mark.parametrize("name", ["/dev/full", "missing/out.rrd"])
def test_what_cannot_be_written(tmp_path: Path, name: str) -> None:
    timeline = Timeline(Words("en"), name="capture.log", save=str(tmp_path / name))
    with pytest.raises(OutputError) as failed:
        timeline.take([table("listing", [listed(1, START)])])
        timeline.finish()
    assert failed.value.in_words(Words("en")).startswith(f"{tmp_path / name}: cannot write: ")
    with suppress(OutputError):
        timeline.close()


def test_a_summary_has_times_of_day() -> None:
    """Where stamps are dates; seconds of a clock that began at 0 stay."""
    from canalyze.timeline.series import _date

    assert _date("1795232031.749143") == "2026-11-21 03:33:51.749143"
    assert _date("no number") == "no number"
