"""Every key of `canalyze monitor`, and what it does to the screen; and whole screens, in both languages.

`python tests/regenerate.py` writes the screens anew.
"""

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES
from monitor_screens import FOLDER, SCREENS, SIZES, golden, goldens, on_screen, replayed, screens, settle, text
from msgspec.structs import replace
from rich.cells import cell_len

from canalyze.monitor.app import Monitor
from canalyze.monitor.around import KEYS, VIEWS
from canalyze.words import Words

DRIVE = SAMPLES / "network" / "sync-and-pdos.log"
FAULTY = SAMPLES / "rules" / "HBT001.log"
Act = Callable[[Monitor, Any], Awaitable[None]]


def run(act: Act, capture: Any = DRIVE, lang: str = "en", size: tuple[int, int] = (80, 24), **more: Any) -> None:
    on_screen(replayed(capture, lang), lang, size, act, **more)


async def press(app: Monitor, pilot: Any, *keys: str) -> str:
    await pilot.press(*keys)
    await settle(app, pilot)
    return text(app)


def lines_of(screen: str, heading: str) -> list[str]:
    """The lines below the heading that holds this text, up to the foot."""
    lines = screen.splitlines()
    at = next(number for number, line in enumerate(lines) if heading in line)
    return lines[at + 1 : -1]


def test_views() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        assert "DEV" not in await press(app, pilot, "2")
        assert "heartbeat" in text(app) and "annotation" not in text(app)
        assert "jitter" in await press(app, pilot, "3")
        assert "outcome" in await press(app, pilot, "4")
        assert "no findings" in await press(app, pilot, "5")
        assert len(lines_of(await press(app, pilot, "6"), "annotation")) == 20
        overview = await press(app, pilot, "1")
        assert all(heading in overview for heading in ("heartbeat", "jitter", "annotation"))

    run(act)


def test_tab_goes_round_the_rooms_that_are_seen() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        seen = []
        for _ in range(4):
            seen.append(app.focused.id if app.focused else "")
            await press(app, pilot, "tab")
        assert seen == ["trace", "nodes", "objects", "trace"]
        await press(app, pilot, "shift+tab")
        assert app.focused is app.trace

    run(act)


def test_cursor_shows_the_whole_row_and_escape_takes_it_away() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "3")
        assert "(EDS default mapping)" not in text(app)
        shown = await press(app, pilot, "down", "down", "down", "j")
        assert "186" in shown.splitlines()[-3] + shown.splitlines()[-2]
        assert "(EDS default mapping)" in shown.replace("\n", " ")
        assert "185  5 TPDO1" in await press(app, pilot, "k")
        assert "(EDS default mapping)" not in await press(app, pilot, "escape")

    run(act)


def test_pages_and_edges_of_a_table() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "3")
        grid = app.grids["objects"]
        await press(app, pilot, "end")
        assert grid.current is not None and grid.current.key == grid.rows[-1].key
        await press(app, pilot, "home")
        assert grid.current.key == grid.rows[0].key
        await press(app, pilot, "pagedown")
        places = [row.key for row in grid.rows]
        assert grid.body - 3 <= places.index(grid.current.key) <= grid.body + 1
        await press(app, pilot, "pageup", "pageup")
        assert grid.current.key == grid.rows[0].key

    run(act)


def test_trace_is_scrolled_back_and_follows_again() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "6")
        newest = app.trace.rows[-1].key
        await press(app, pilot, "up")
        assert not app.trace.follows and app.trace.current is not None
        assert app.trace.current.key == newest
        for _ in range(30):
            await pilot.press("up")
        await settle(app, pilot)
        assert app.trace.current.key[0] == newest[0] - 30
        numbers = [row.key[0] for row in app.trace.rows]
        assert numbers == list(range(numbers[0], numbers[0] + app.trace.body))
        assert "(paused, End = follow)" in text(app)
        await press(app, pilot, "pagedown", "pagedown")
        assert app.trace.rows[-1].key == newest
        await press(app, pilot, "home")
        assert app.trace.rows[0].key[0] == 1
        await press(app, pilot, "end")
        assert app.trace.follows and app.trace.rows[-1].key == newest and "paused" not in text(app)

    run(act)


def test_wheel_scrolls_the_trace() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        newest = app.trace.rows[-1].key[0]
        app.trace.roll(-3)
        await settle(app, pilot)
        assert app.trace.rows[-1].key[0] == newest - 3
        app.trace.roll(3)
        app.trace.roll(3)
        await settle(app, pilot)
        assert app.trace.follows

    run(act)


def test_filter() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        shown = await press(app, pilot, "f")
        assert "Filter (as --filter" in shown
        shown = await press(app, pilot, *"node=5", "space", *"service=sdo", "enter")
        assert "filter node=5 service=sdo" in shown
        assert app.trace.rows and all(row.cells[1][0][0] in ("585", "605") for row in app.trace.rows)
        shown = await press(app, pilot, "f", *"=x", "enter")
        assert "sdo=x" in shown and app.trace.filter == "node=5 service=sdo"
        await press(app, pilot, "escape")
        assert app.trace.filter == "node=5 service=sdo"
        await press(app, pilot, "f", "ctrl+u", "enter")
        assert not app.trace.filter and "filter " not in text(app).splitlines()[1]

    run(act)


@pytest.mark.parametrize("key", ["f", "slash"])
def test_a_line_is_typed_from_every_view(key: str) -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        field = app.query_one("Input")
        for view in "1234567":
            await press(app, pilot, view, key, *"id=185")
            assert app.focused is field and field.value == "id=185", view  # type: ignore[attr-defined]
            app.trace.focus()  # as a click does
            await settle(app, pilot)
            await press(app, pilot, "0")
            assert field.value == "id=1850", view  # type: ignore[attr-defined]
            await press(app, pilot, "escape")
            assert app.focused is app.trace and not app._prompt.display, view

    run(act)


def test_first_filter_is_that_of_the_command_line() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        assert "filter id=080" in text(app)
        await press(app, pilot, "escape")
        assert not app.trace.filter

    run(act, expression="id=080")


def test_search_goes_from_place_to_place() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "6")
        shown = await press(app, pilot, "slash", *"NMT", "space", "enter")
        assert "search NMT" in shown
        first = app.trace.current
        assert first is not None and "NMT" in first.whole
        assert any(look == "found" for cell in first.cells for _, look in cell)
        await press(app, pilot, "N")
        second = app.trace.current
        assert second is not None and "NMT" in second.whole and second.key[0] < first.key[0]
        assert "no more 'NMT" in await press(app, pilot, "N")
        await press(app, pilot, "n")
        assert app.trace.current == first
        assert "not found" in await press(app, pilot, "escape", "slash", "ctrl+u", *"nowhere", "enter")
        await press(app, pilot, "escape", "escape", "escape")
        assert not app.trace.search

    run(act)


def test_next_without_a_search_asks_for_one() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        assert "Search:" in await press(app, pilot, "n")
        assert "Search:" not in await press(app, pilot, "escape")

    run(act)


def test_finding_leads_to_its_frame() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "5", "down")
        row = app.grids["findings"].current
        assert row is not None and isinstance(row.leads, int)
        assert "CiA 301" in await press(app, pilot, "enter"), "what the rule says"
        shown = await press(app, pilot, "enter")
        assert app.focused is app.trace and "annotation" in shown
        assert app.trace.current is not None and app.trace.current.key[0] == row.leads

    run(act, FAULTY)


def test_finding_whose_frame_does_not_fit_the_filter_takes_it_away() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        shown = await press(app, pilot, "5", "down", "enter", "enter")
        assert "filter, which was cleared" in shown and not app.trace.filter

    run(act, FAULTY, expression="id=123")


def test_transfer_leads_to_its_first_frame() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "4", "down", "enter")
        assert app.trace.current is not None and " 605 " in app.trace.current.whole

    run(act)


@pytest.mark.parametrize(("view", "condition"), [("2", "node=5"), ("3", "id=000")])
def test_node_and_object_show_their_frames_only(view: str, condition: str) -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        keys = ["enter", "enter"] if view == "2" else ["enter"]
        assert f"filter {condition}" in await press(app, pilot, view, "down", *keys)
        assert app.trace.filter == condition and app.focused is app.trace

    run(act)


def test_pause_lets_the_screen_stand() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        replay = app._watch.replay
        assert replay is not None
        await press(app, pilot, "space")
        assert app.paused and replay.paused and app.trace.limit == 329
        await press(app, pilot, "p")
        assert not app.paused and not replay.paused and app.trace.limit is None

    run(act)


def test_speed() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        replay = app._watch.replay
        assert replay is not None
        replay.speed = 1.0
        await press(app, pilot, "plus")
        assert replay.speed == 2.0
        await press(app, pilot, "minus", "minus")
        assert replay.speed == 0.5

    run(act)


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_help_has_every_key(lang: str) -> None:
    words = Words(lang)

    async def act(app: Monitor, pilot: Any) -> None:
        shown = await press(app, pilot, "question_mark")
        for key in KEYS:
            if key.name:
                assert words(key.name)[:20] in shown
        assert "┌" not in shown
        await pilot.press("x")
        await settle(app, pilot)
        assert words(KEYS[len(VIEWS)].name) not in text(app)

    run(act, lang=lang)


@pytest.mark.parametrize("before", [(), ("question_mark",), ("f",)])
@pytest.mark.parametrize("key", ["q", "ctrl+c"])
def test_quit(before: tuple[str, ...], key: str) -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, *before)
        await pilot.press(key)
        await pilot.pause()
        assert app.return_value == (0 if key == "ctrl+c" or not before else None)

    run(act)


def test_every_key_with_an_action_is_known_to_the_application() -> None:
    for key in KEYS:
        if key.action:
            assert callable(getattr(Monitor, f"action_{key.action.split('(')[0]}"))


def test_adapter_lost_is_said_and_the_screen_stays() -> None:
    watch = replayed(DRIVE, "en")
    watch.complain("canalyze: can0: the adapter is gone")
    watch.failure = "gone"

    async def act(app: Monitor, pilot: Any) -> None:
        assert text(app).startswith(" LOST ")
        assert "the adapter is gone" in text(app)
        assert "the adapter is gone" not in await press(app, pilot, "escape")
        assert "TPDO1" in text(app)

    on_screen(watch, "en", (80, 24), act)


def test_small_and_large_terminals() -> None:
    for size in ((20, 6), (40, 10), (80, 24), (160, 50), (300, 90)):

        async def act(app: Monitor, pilot: Any) -> None:
            for key in "123456":
                shown = await press(app, pilot, key)
                assert len(shown.splitlines()) == app.size.height

        run(act, size=size)


def test_resizing_keeps_the_screen_whole() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        for size in ((160, 50), (80, 24), (100, 30)):
            await pilot.resize_terminal(*size)
            await pilot.pause()
            await settle(app, pilot)
            shown = text(app)
            assert len(shown.splitlines()) == size[1] and "SYNC" in shown
            assert ("no SDO" in shown or "6041h" in shown) == (size[0] >= 120)

    run(act)


def test_crash_of_the_reading_ends_the_screen() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        app._watch.crash = ZeroDivisionError()
        app.beat()
        await pilot.pause()
        assert app.return_value == 2

    run(act)


def test_what_is_typed_right_behind_a_key_that_asks_goes_into_the_prompt() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        from textual import events

        for key, character in (
            ("f", "f"),
            *((one, one) for one in "id"),
            ("equals_sign", "="),
            *zip("185", "185", strict=True),
        ):
            app.post_message(events.Key(key, character))
        await settle(app, pilot)
        assert app.query_one("Input").value == "id=185"  # type: ignore[attr-defined]
        assert app.focused is app.query_one("Input") and app._view == "overview"
        assert "no longer" not in await press(app, pilot, "enter") and app.trace.filter == "id=185"

    run(act)


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("columns", [30, 40, 60, 80, 120])
def test_the_foot_never_loses_help_and_the_end(lang: str, columns: int) -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        foot = text(app).splitlines()[-1]
        words = Words(lang)
        assert f"? {words('monitor.key_help')}" in foot and f"q {words('monitor.key_quit')}" in foot and "…" not in foot
        assert ("Enter" in foot) == (columns == 120 or (columns == 80 and lang == "zh"))

    run(act, lang=lang, size=(columns, 15))


@pytest.mark.parametrize(("lang", "silent"), [("zh", "无心跳"), ("en", "no heartbeat")])
def test_a_node_that_is_lost_is_seen_first(lang: str, silent: str) -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        shown = text(app).splitlines()
        assert shown[2].startswith(" ✖ 1.000  HBT002  ")
        assert silent in shown[4] and {"zh": "预操作", "en": "Pre-op"}[lang] not in shown[4]
        look = {piece.strip(): look for cells in app.grids["nodes"].rows[0].cells for piece, look in cells}
        assert look[silent] == "error"
        # Where the findings themselves are seen, they are not said twice; nor in another view, or without room.
        assert "HBT002" not in "".join((await press(app, pilot, "2")).splitlines()[:4])
        await pilot.resize_terminal(80, 10)
        assert "HBT002" not in "".join((await press(app, pilot, "1")).splitlines()[:3])
        await pilot.resize_terminal(140, 40)
        await settle(app, pilot)
        assert text(app).count(" HBT002 ") == 2 and not app.query_one("#latest").display

    run(act, SAMPLES / "rules" / "HBT002.log", lang)


def test_states_are_unknown_while_the_bus_is_away() -> None:
    from canalyze.monitor import views

    watch = replayed(FAULTY, "en")
    snapshot, words = watch.snapshot(), Words("en")
    bus = frozenset([snapshot.nodes[0].bus])
    here, away, other = (
        views.node_rows(snapshot, words, buses=False, away=away)[0]
        for away in (frozenset[str](), bus, frozenset(["can7"]))
    )
    assert here.cells[2] == other.cells[2] == (("Pre-operational", "warning"),)
    assert away.cells[2] == (("unknown", "warning"),) and "last state: Pre-operational" in away.whole


def test_objects_that_have_stopped_are_dim_and_show_their_age() -> None:
    from canalyze.monitor import views

    snapshot, words = replayed(FAULTY, "en").snapshot(), Words("en")
    one = replace(snapshot.objects[0], period_ns=100_000_000, jitter_ns=1_000_000, severity=None)

    def row(age_ns: int, **more: Any) -> Any:
        last = replace(one, last_ns=5_000_000_000, **more)
        shown = replace(snapshot, objects=(last,), now_ns=5_000_000_000 + age_ns)
        return views.object_rows(shown, words, buses=False, width=140)[0]

    fresh, old = row(300_000_000), row(2_500_000_000)
    assert fresh.cells[3] == (("100ms", ""),) and fresh.cells[0][0][1] == "strong"
    assert old.cells[3] == (("2.50s ago", "warning"),) and "2.50s ago" in old.whole
    assert {look for content in (old.cells[0], old.cells[1], old.cells[6], old.cells[7]) for _, look in content} == {
        "dim"
    }
    assert row(2_500_000_000, jitter_ns=60_000_000).cells[3] == (("100ms", ""),), "it never came evenly"
    assert row(2_500_000_000, period_ns=None, jitter_ns=None).cells[3] == (("-", ""),)


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_findings_by_severity(lang: str) -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "5")
        grid = app.grids["findings"]
        looks = [{row.cells[2][0][1] for row in grid.rows}]
        for _ in range(3):
            await press(app, pilot, "s")
            looks.append({row.cells[2][0][1] for row in grid.rows})
        everything = {"info", "warning", "error"}
        assert looks == [everything, {"warning", "error"}, {"error"}, everything]
        assert (Words(lang).of("monitor_severity", "error") in text(app)) is False
        assert Words(lang).of("monitor_severity", "warning") in await press(app, pilot, "s")

    run(act, SAMPLES / "problems.log", lang)


def test_a_frame_is_explained_field_by_field() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        shown = await press(app, pilot, "6", "home", "enter")
        assert "COB-ID" in shown and "bits 7-5" in shown
        shown = await press(app, pilot, "x")
        assert "bits 7-5" not in shown and app.focused is app.trace, "any key goes back"

    run(act, FAULTY)


def test_a_node_shows_what_it_is_and_its_pdos() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "2", "home")
        for row in app.grids["nodes"].rows:
            app.grids["nodes"].cursor = row.key
            shown = await press(app, pilot, "enter")
            if row.key[1] == 5:
                break
            await press(app, pilot, "x")
        assert "PDO mapping" in shown and "6041h:00" in shown and "16 bits" in shown, shown

    run(act, SAMPLES / "network" / "sync-and-pdos.log", size=(140, 40))


def test_the_last_emergency_is_shown_after_it_is_over() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await press(app, pilot, "2")
        assert any("was 8130h life guard" in line for line in text(app).splitlines())

    run(act, SAMPLES / "services.log", size=(160, 40))


@pytest.mark.parametrize(("lang", "said"), [("zh", "启动(Boot-up)"), ("en", "Pre-operational (boot-up)")])
def test_a_node_that_has_only_booted_is_not_said_to_be_initialising(lang: str, said: str, tmp_path: Path) -> None:
    from canalyze.monitor import views

    (tmp_path / "boot.log").write_text("(1700000000.000000) can0 705#00\n")
    row = views.node_rows(replayed(tmp_path / "boot.log", lang).snapshot(), Words(lang), buses=False)[0]
    assert row.cells[2] == ((said, "info"),) and said in row.whole


@pytest.mark.parametrize(("capture", "size", "lang"), goldens(), ids=lambda one: getattr(one, "stem", str(one)))
def test_screen_is_the_golden_one(capture: Path, size: tuple[int, int], lang: str) -> None:
    assert screens(capture, size, lang) == golden(capture, size, lang).read_text()


@pytest.mark.parametrize(("capture", "size", "lang"), goldens(), ids=lambda one: getattr(one, "stem", str(one)))
def test_golden_screen_fits_the_terminal(capture: Path, size: tuple[int, int], lang: str) -> None:
    pages = golden(capture, size, lang).read_text().split("--- ")[1:]
    assert len(pages) == 8
    for page in pages:
        lines = page.splitlines()[1:]
        assert len(lines) == size[1]
        assert all(cell_len(line) <= size[0] for line in lines)


def test_every_golden_screen_is_compared() -> None:
    assert {path.name for path in FOLDER.iterdir()} == {golden(*one).name for one in goldens()}
    assert len(SCREENS) * len(SIZES) * 2 == len(goldens())
