"""Problems on the screen of `canalyze monitor`: their room, the line above, the rows of nodes, the bell.

That a snapshot has what `diagnose` says stands here, too. What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES, SHARED, Row
from diagnoses import diagnosed
from monitor_screens import on_screen, replayed, settle, text
from msgspec.structs import replace
from test_monitor_grid import Still

from canalyze import _core
from canalyze.monitor.app import Monitor
from canalyze.running.reading import SessionOptions

PROBLEMS = SAMPLES / "problems.log"
CAPTURES = [PROBLEMS, SAMPLES / "sdo-abort.log", *sorted((SHARED / "stories").glob("*.log"))]
LOST, REPORTED = 126, 134
"""Frames of the sample: the last of a node, and the report of the one that watches it."""


def session_of(lines: list[bytes], lang: str = "en") -> _core.Session:
    """A capture that is watched and goes on."""
    session = _core.Session(SessionOptions(format="monitor", lang=lang))
    session.begin("capture.log", False, "candump")
    session.feed(b"".join(lines))
    session.rest()
    return session


def shown(session: _core.Session) -> Any:
    return json.loads(session.snapshot())


def so_far(count: int, lang: str = "en") -> Any:
    """What is shown of the sample after so many frames."""
    return shown(session_of(PROBLEMS.read_bytes().splitlines(keepends=True)[:count], lang))


def of_row(one: Row) -> tuple[object, ...]:
    return one["id"], one["kind"], one["status"], one["frame"], one["end_frame"], one["cause"], one["text"]


def of_record(one: Row) -> tuple[object, ...]:
    end, cause = one["end"] or {}, one["cause"] or {}
    return (
        *(one["id"], one["problem"], one["status"], one["begin"]["frame"], end.get("frame"), cause.get("id")),
        one["message"],
    )


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_at_the_end_it_is_what_diagnose_says(path: Path) -> None:
    session = session_of([path.read_bytes()])
    session.end()
    session.finish()
    snapshot, found = shown(session), diagnosed(path.read_bytes())
    assert sorted(map(of_row, snapshot["problems"])) == sorted(map(of_record, found.incidents))
    assert [one["id"] for one in snapshot["problems"] if not one["depth"]] == found.whole["order"]
    assert not any(one["provisional"] for one in snapshot["problems"])
    above: list[int] = []
    for one in snapshot["problems"]:
        del above[one["depth"] :]
        assert one["cause"] == (above[-1] if above else None), "each stands below its cause"
        above.append(one["id"])


@pytest.mark.parametrize("count", range(50, 175, 5))
def test_on_the_way_it_is_what_diagnose_says_of_what_there_is(count: int) -> None:
    lines = PROBLEMS.read_bytes().splitlines(keepends=True)[:count]
    snapshot, found = shown(session_of(lines)), diagnosed(b"".join(lines))
    told = {of_record(one) for one in found.incidents}
    assert {of_row(one) for one in snapshot["problems"]} == told, "and nothing that only the end brings"


def test_what_may_change_is_marked() -> None:
    def marks(count: int) -> dict[int, bool]:
        return {one["id"]: one["provisional"] for one in so_far(count)["problems"]}

    assert marks(REPORTED) == {1: True, 2: True, 3: True, 4: False}, "2 may be taken back at once"
    late = {1: True, 2: False, 3: True, 4: False, 5: False}
    assert marks(REPORTED + 5) == late, "for 1 a cause may be found yet, 2 has one, 3 was just found"


def test_a_number_that_was_shown_stays() -> None:
    lines = PROBLEMS.read_bytes().splitlines(keepends=True)
    session, numbers = session_of(lines[:1]), dict[tuple[str, int], int]()
    for line in lines[1:]:
        session.feed(line)
        for one in shown(session)["problems"]:
            assert numbers.setdefault((one["kind"], one["frame"]), one["id"]) == one["id"]
    assert sorted(numbers.values()) == [1, 2, 3, 4, 5], "and none is left out"
    whole = {(one["kind"], one["frame"]): one["id"] for one in so_far(len(lines))["problems"]}
    assert whole.keys() == numbers.keys() and whole != numbers, "who looks at the end reads them in order"


def test_nodes_have_the_word_of_their_problem() -> None:
    words = {node["node"]: node["problem"] and node["problem"]["word"] for node in so_far(174)["nodes"]}
    reported = "heartbeat consumer reports a loss"
    assert words == {3: None, 4: reported, 5: None, 9: "node silent"}

    async def act(app: Monitor, pilot: Any) -> None:
        await pilot.press("2")
        await settle(app, pilot)
        rows = text(app).splitlines()[3:7]
        assert [row.rstrip().endswith(end) for row, end in zip(rows, ("", reported, "✖1", "is silent"), strict=True)]
        assert "✖" not in rows[1] + rows[3]

    on_screen(replayed(PROBLEMS, "en"), "en", (140, 40), act)


@pytest.mark.parametrize(
    ("lang", "size", "said"),
    [
        ("en", (140, 40), "✖1 node 9: silent since 5.78 s, previously"),
        ("en", (80, 24), "✖1 node 9: silent since 5.78 s"),
        ("zh", (80, 24), "✖1 节点9: 5.78 s起没有任何报文"),
    ],
)
def test_the_first_line_says_how_many_stand_and_which_came_last(lang: str, size: tuple[int, int], said: str) -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        lines = text(app).splitlines()
        assert said in lines[0]
        assert lines[1].rstrip().endswith(("7 问题 ✖1", "7 problems ✖1"))

    on_screen(replayed(PROBLEMS, lang), lang, size, act)


@pytest.mark.parametrize(
    ("lang", "words"), [("en", ("open", "ended", "harmless")), ("zh", ("仍存在", "已恢复", "无害"))]
)
def test_harmless_ones_are_one_row_until_asked_for(lang: str, words: tuple[str, ...]) -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        async def states() -> list[str]:
            await settle(app, pilot)
            return ["".join(piece for piece, _ in row.cells[1]) for row in app.grids["problems"].rows]

        await pilot.press("7")
        stands, over, harmless = words
        assert await states() == [stands, stands, over, over, ""]
        await pilot.press("end", "enter")
        assert await states() == [stands, stands, over, over, "", harmless]
        await pilot.press("enter")
        assert await states() == [stands, stands, over, over, ""]
        assert app.grids["problems"].has_focus

    on_screen(replayed(PROBLEMS, lang), lang, (80, 24), act)


def test_enter_goes_to_the_first_evidence_and_the_row_is_told_in_full() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await pilot.press("7", "down", "down")
        await settle(app, pilot)
        said = " ".join(" ".join(text(app).splitlines()[-4:-1]).split())
        assert "502 ms later certain caused by 1 check first:" in said
        for frame, key in ((REPORTED, "enter"), (LOST, "up")):
            await pilot.press("7")
            await pilot.press(*([key, "enter"] if key != "enter" else [key]))
            await settle(app, pilot)
            assert app.trace.current is not None and app.trace.current.key[0] == frame

    on_screen(replayed(PROBLEMS, "en"), "en", (80, 24), act)


@pytest.mark.parametrize(("lang", "said"), [("en", "open?"), ("zh", "仍存在?")])
def test_the_age_of_what_stands_runs_and_what_may_change_has_a_mark(lang: str, said: str) -> None:
    watch = Still(**so_far(REPORTED, lang))

    async def act(app: Monitor, pilot: Any) -> None:
        await pilot.press("7")
        await settle(app, pilot)
        row = next(line for line in text(app).splitlines() if str(LOST) in line)
        assert said in row and " 502ms " in row
        now_ns = watch._snapshot.now_ns
        assert now_ns is not None
        watch._snapshot = replace(watch._snapshot, now_ns=now_ns + 1_000_000_000)
        await settle(app, pilot)
        assert " 1.50s " in next(line for line in text(app).splitlines() if str(LOST) in line)

    on_screen(watch, lang, (80, 24), act)


def rings(snapshots: list[Any], *, bell: bool) -> list[int]:
    """How often the bell has rung after each of them."""
    watch, rung, seen = Still(**so_far(1)), 0, []

    async def act(app: Monitor, pilot: Any) -> None:
        def ring() -> None:
            nonlocal rung
            rung += 1

        app.bell = ring  # type: ignore[method-assign]
        for one in snapshots:
            watch._snapshot = Still(**one).snapshot()
            await settle(app, pilot)
            seen.append(rung)

    on_screen(watch, "en", (80, 24), act, bell=bell)
    return seen


def test_the_bell_rings_once_for_each_new_problem_that_stops_something() -> None:
    degraded, both = so_far(120), so_far(174)
    lost = both | {"problems": [one for one in both["problems"] if one["id"] != 2]}
    assert [one["impact"] for one in degraded["problems"]] == ["C", "E"]
    assert rings([so_far(1), degraded, lost, lost, both, both], bell=True) == [0, 0, 1, 1, 2, 2]
    assert rings([degraded, both], bell=True) == [0, 1], "two of one moment ring once"
    assert rings([lost, both], bell=False) == [0, 0]


def test_a_bus_without_problems_says_so() -> None:
    async def act(app: Monitor, pilot: Any) -> None:
        await pilot.press("7")
        await settle(app, pilot)
        assert "no problems" in text(app) and "✖" not in text(app)

    on_screen(Still(), "en", (80, 24), act)
