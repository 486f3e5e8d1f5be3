"""The tables of the screen: room for columns, widths of Chinese, escapes, and that only what changed is drawn."""

import asyncio
from collections.abc import Iterator
from typing import Any

import pytest
from filled_records import filled
from monitor_screens import on_screen, settle, text
from msgspec import convert
from rich.cells import cell_len
from textual.app import App, ComposeResult
from textual.geometry import Region

from canalyze.monitor import grid, views
from canalyze.monitor.app import Monitor
from canalyze.monitor.grid import STYLES, Column, Grid, Row, cell, draw, fit
from canalyze.records import SEVERITIES
from canalyze.records.live import NodeDetails, Snapshot
from canalyze.words import Words

COLUMNS = [Column("id"), Column("name", least=4, leaves=1), Column("text", least=10, most=400)]


@pytest.mark.parametrize(
    ("room", "widths"),
    [
        (60, [(0, 3), (1, 20), (2, 35)]),
        (30, [(0, 3), (1, 15), (2, 10)]),
        (19, [(0, 3), (1, 4), (2, 10)]),
        (18, [(0, 3), (2, 14)]),
        (5, [(0, 3), (2, 10)]),
    ],
)
def test_columns_shrink_then_leave(room: int, widths: list[tuple[int, int]]) -> None:
    assert fit(COLUMNS, [3, 20, 30], room) == widths


@pytest.mark.parametrize("right", [False, True])
@pytest.mark.parametrize("content", ["", "a", "abcdef", "心跳停止", "a心跳b停止", "é́x", "位置实际值=1800 rpm"])
def test_a_cell_takes_its_columns_exactly(content: str, right: bool) -> None:
    for columns in range(1, 24):
        drawn = draw(cell(content), columns, STYLES[""], right=right)
        assert sum(cell_len(segment.text) for segment in drawn) == columns


def test_what_could_drive_a_terminal_is_escaped() -> None:
    drawn = draw(cell("\x1b[31m\r\n\x07[b]\u202e\x9b"), 60, STYLES[""])
    shown = "".join(segment.text for segment in drawn).rstrip()
    assert shown == r"\x1b[31m\x0d\x0a\x07[b]\u202e\x9b"
    assert all(segment.control is None for segment in drawn)


class Watched(Grid):
    """A table that keeps what it drew anew."""

    regions: list[tuple[Region, ...]]

    def refresh(self, *regions: Region, **more: Any) -> Any:
        if not hasattr(self, "regions"):
            self.regions = []
        self.regions.append(regions)
        return super().refresh(*regions, **more)


class OneGrid(App[None]):
    """An application of one table."""

    def __init__(self) -> None:
        """Make it."""
        super().__init__()
        self.grid = Watched("grid")

    def compose(self) -> ComposeResult:
        yield self.grid


def rows(count: int, changed: str = "1") -> list[Row]:
    return [
        Row(number, (cell(number), cell("heartbeat"), cell(changed if number == 1 else "0"))) for number in range(count)
    ]


def test_only_cells_that_changed_are_drawn() -> None:
    async def act() -> None:
        app = OneGrid()
        async with app.run_test(size=(60, 10)) as pilot:
            grid = app.grid
            grid.show(COLUMNS, rows(3))
            await pilot.pause()
            grid.regions.clear()
            grid.show(COLUMNS, rows(3))
            assert not grid.regions
            grid.show(COLUMNS, rows(3, "2"))
            assert grid.regions == [(Region(13, 2, 47, 1),)]

    asyncio.run(act())


class Still:
    """A source of one snapshot."""

    crash = None
    replay = None
    over = False
    failure = None
    badge = "live"
    away: frozenset[str] = frozenset()
    recording = ""

    def __init__(self, **parts: Any) -> None:
        """Take what the snapshot has beyond nothing."""
        counts = {"findings": dict.fromkeys(SEVERITIES, 0)}
        self._snapshot = convert(filled(Snapshot, {"tally": counts, **parts}), Snapshot)

    def complaints(self) -> list[str]:
        return []

    def snapshot(self) -> Snapshot:
        return self._snapshot

    def page(self, *_: Any) -> NodeDetails:
        return NodeDetails((), ())

    def trace(self, *_: Any) -> list[Any]:
        return []


RUNNING = {
    "bus": "can0",
    "node": 5,
    "direction": "download",
    "mode": "block",
    "index": "1F50",
    "sub": 1,
    "name": "program data",
    "size": 100_000,
    "bytes": 45_000,
    "since_ns": 2_000_000_000,
}


@pytest.mark.parametrize(("size", "said"), [(100_000, " 45% ████▌"), (None, "running")])
def test_running_transfer_shows_how_far_it_is(size: int | None, said: str) -> None:
    parts = {"start_ns": 0, "now_ns": 5_000_000_000}
    watch = Still(transfers={"running": [RUNNING | {"size": size}], "done": []}, **parts)

    async def act(app: Monitor, pilot: Any) -> None:
        await pilot.press("4")
        await settle(app, pilot)
        shown = text(app)
        assert said in shown and "1F50h:01" in shown and "3.00s" in shown
        assert "4 SDO 1" in shown

    on_screen(watch, "en", (100, 24), act)


@pytest.mark.parametrize(("lang", "said"), [("en", (" REC ", " REC FAILED ")), ("zh", (" 录制中 ", " 录制失败 "))])
def test_it_is_seen_whether_what_is_received_is_recorded(lang: str, said: tuple[str, str]) -> None:
    class Recorded(Still):
        recording = "records"

    async def act(app: Monitor, pilot: Any) -> None:
        assert said[0] in text(app).splitlines()[0]
        Recorded.recording = "unrecorded"
        await settle(app, pilot)
        first = text(app).splitlines()[0]
        assert said[1] in first

    on_screen(Recorded(), lang, (80, 24), act)


def test_empty_rooms_say_what_is_not_there_yet() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        assert text(app).count("no frames yet") == 2 and "no nodes yet" in text(app)
        app.trace.choose("node=5")
        await settle(app, pilot)
        assert "no matching frames" in text(app)

    on_screen(Still(), "en", (80, 24), act)


def test_figures_of_the_status_line_stay_where_they_are() -> None:
    def watch(rate: float) -> Still:
        bus = {"name": "can0", "frames_per_s": rate, "load_percent": rate / 10, "error_frames": 7, "dropped": 0}
        return Still(buses=[bus | {"state": None}])

    shown = watch(1234.0)

    async def act(app: Monitor, pilot: Any) -> None:
        places = set()
        for rate in (1234.0, 99.96, 99.9, 0.0, 12.3):
            shown._snapshot = watch(rate)._snapshot
            await settle(app, pilot)
            first = text(app).splitlines()[0]
            places.add((first.index("err"), first.index(" fr")))
        assert len(places) == 1, places

    on_screen(shown, "en", (80, 24), act)


def test_a_bus_in_trouble_is_seen_however_many_there_are() -> None:
    buses: list[dict[str, Any]] = [
        {
            "name": f"can{number}",
            "frames_per_s": 9.0,
            "load_percent": 4.0,
            "error_frames": 0,
            "dropped": 0,
            "state": None,
        }
        for number in range(5)
    ]
    buses[3]["state"] = "bus-off"

    async def act(app: Monitor, pilot: Any) -> None:
        assert text(app).startswith(" LIVE   can3 4.0% bus-off  can0 4.0%  +3  0 fr ")

    on_screen(Still(buses=buses), "en", (80, 24), act)


def test_nothing_is_asked_any_more_when_all_was_seen() -> None:
    asked = 0

    class Counted(Still):
        def snapshot(self) -> Snapshot:
            nonlocal asked
            asked += 1
            return super().snapshot()

    watch = Counted()

    async def act(app: Monitor, pilot: Any) -> None:
        before = asked
        await settle(app, pilot)
        assert asked == before + 2
        watch.over = True
        for _ in range(3):
            await settle(app, pilot)
        assert asked == before + 3  # once more, for what came last

    on_screen(watch, "en", (80, 24), act)


def test_buses_have_columns_only_where_there_are_several() -> None:
    for buses, columns in ((False, 9), (True, 10)):
        assert len(views.transfer_columns(Words("en"), buses=buses)) == columns


@pytest.mark.parametrize(
    ("ns", "shown"),
    [
        (None, "-"),
        (0, "0"),
        (999, "999ns"),
        (9_060, "9.06µs"),
        (10_000_000, "10.0ms"),
        (999_600_000, "1000ms"),
        (1_500_000_000, "1.50s"),
        (3_723_000_000_000, "1:02:03"),
    ],
)
def test_periods(ns: int | None, shown: str) -> None:
    assert grid.period(ns) == shown


def test_bars() -> None:
    def bars() -> Iterator[str]:
        for part in (-1.0, 0.0, 0.5, 0.55, 1.0, 2.0):
            yield grid.bar(part, 10)

    assert list(bars()) == ["░" * 10, "░" * 10, "█████░░░░░", "█████▌░░░░", "█" * 10, "█" * 10]


@pytest.mark.parametrize(("octets", "shown"), [(None, "-"), (9999, "9999"), (100_000, "97.7Ki"), (5 << 20, "5.00Mi")])
def test_sizes(octets: int | None, shown: str) -> None:
    assert grid.size(octets) == shown
