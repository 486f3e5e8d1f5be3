"""Recorded stories whose stamps say little: none, all the same, or rounded, to whole seconds at most.

What rests on time cannot be said then, and nothing else is said in its place. The truth stands beside each recording.
What it must not do: test how much is still found.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from captures import Row, session_output
from diagnoses import Diagnosed, diagnosed
from test_stories import STORIES, nodes

STAMP = re.compile(rb"\((\d+)\.(\d{6})\) ")
SECOND_US = 1_000_000
TIMED = frozenset(
    {"node-silent", "segment-lost", "heartbeat-stopped", "heartbeat-irregular", "consumer-time-too-short"}
    | {
        "sync-irregular",
        "sync-stopped",
        "two-sync-producers",
        "two-masters",
        "node-floods",
        "capture-gap",
        "bus-silent",
    }
)
"""Kinds that only time shows."""


def stamped(text: bytes, stamp: Callable[[int], int]) -> bytes:
    """The capture with other stamps, in us."""

    def other(found: re.Match[bytes]) -> bytes:
        return b"(%d.%06d) " % divmod(stamp(int(found[1]) * SECOND_US + int(found[2])), SECOND_US)

    return STAMP.sub(other, text)


@cache
def text_of(path: Path) -> bytes:
    return path.with_suffix(".log").read_bytes()


@cache
def told(path: Path, how: str) -> Diagnosed:
    return diagnosed(WAYS[how](text_of(path)))


WAYS: dict[str, Callable[[bytes], bytes]] = {
    "as it was": lambda text: text,
    "none": lambda text: STAMP.sub(b"", text),
    "the same": lambda text: stamped(text, lambda _: 1_700_000_000 * SECOND_US),
    "zero": lambda text: stamped(text, lambda _: 0),
    "1 s": lambda text: stamped(text, lambda us: us // SECOND_US * SECOND_US),
    "100 ms": lambda text: stamped(text, lambda us: us // 100_000 * 100_000),
    "10 ms": lambda text: stamped(text, lambda us: us // 10_000 * 10_000),
    "1 ms": lambda text: stamped(text, lambda us: us // 1_000 * 1_000),
}


def gist(found: Diagnosed) -> list[str]:
    """What is told but for times, and what is no problem."""
    by_id = {one["id"]: one for one in found.incidents}

    def said(one: Row) -> list[object]:
        return [one["problem"], one["subject"], one["status"], one["begin"]["frame"]]

    rows = (
        [*said(one), said(by_id[one["cause"]["id"]]) if one["cause"] else None]
        for one in found.incidents
        if one["status"] != "harmless"
    )
    return sorted(json.dumps(row) for row in rows)


@pytest.mark.parametrize("how", ["the same", "zero"])
@pytest.mark.parametrize("path", STORIES, ids=lambda path: path.stem)
def test_stamps_of_no_use_are_as_good_as_none(path: Path, how: str) -> None:
    found = told(path, how)
    assert gist(found) == gist(told(path, "none"))
    assert (found.whole["begin"], found.whole["end"]) == (None, None)
    assert not TIMED & {one["problem"] for one in found.incidents}


@pytest.mark.parametrize("path", STORIES, ids=lambda path: path.stem)
def test_without_time_no_wrong_cause_is_named(path: Path) -> None:
    truth = json.loads(path.read_text())["stories"]
    right = {
        (node, cause)
        for story in truth
        if story["caused_by"] is not None
        for node in nodes(story["subject"])
        for cause in nodes(truth[story["caused_by"]]["subject"]) or {0}
    }
    concerned = {node for story in truth for node in nodes(story["subject"])}
    whole = {node for one in told(path, "as it was").incidents for node in nodes(one["subject"])}
    found = told(path, "none")
    by_id = {one["id"]: one for one in found.incidents}
    for one in found.incidents:
        assert one["status"] == "harmless" or nodes(one["subject"]) <= concerned | whole, one["message"]
        if one["cause"] is not None:
            mine, causes = nodes(one["subject"]), nodes(by_id[one["cause"]["id"]]["subject"])
            linked = {(node, cause) for node in mine for cause in causes or {0}}
            assert linked & right or mine & causes or by_id[one["cause"]["id"]]["status"] == "harmless", one["message"]


@pytest.mark.parametrize("how", ["1 ms", "10 ms"])
@pytest.mark.parametrize("path", STORIES, ids=lambda path: path.stem)
def test_rounded_stamps_change_nothing(path: Path, how: str) -> None:
    assert gist(told(path, how)) == gist(told(path, "as it was"))


WRONG = {("1 s", "t06-consumer-too-short")}
"""A consumer reports that a node was silent: whole seconds do not show that its time is too short for the period."""


SAME = {"heartbeat-irregular": "node-silent"}
"""Of a silence, coarse stamps may show the heartbeats that never came."""


@pytest.mark.parametrize("how", ["100 ms", "1 s"])
@pytest.mark.parametrize("path", STORIES, ids=lambda path: path.stem)
def test_coarse_stamps_show_nothing_that_did_not_happen(path: Path, how: str, request: pytest.FixtureRequest) -> None:
    if (how, path.stem) in WRONG:
        request.applymarker(pytest.mark.xfail(strict=True, reason="see WRONG"))

    def timed(found: Diagnosed) -> set[tuple[str, str]]:
        real = (one for one in found.incidents if one["status"] != "harmless" and one["problem"] in TIMED)
        kinds: list[tuple[str, Row]] = [(one["problem"], one["subject"]) for one in real]
        return {(SAME.get(kind, kind), json.dumps(subject)) for kind, subject in kinds}

    assert timed(told(path, how)) <= timed(told(path, "as it was"))


def test_coarse_stamps_still_show_who_is_gone() -> None:
    """Of the stories in which a node stays silent, nearly all; without stamps, none."""
    ways = ("as it was", "100 ms", "1 s", "none")
    lost = {how: {path.stem for path in STORIES if gone(told(path, how))} for how in ways}
    assert lost["100 ms"] == lost["as it was"]
    assert len(lost["1 s"]) * 4 >= len(lost["as it was"]) * 3
    assert not lost["none"]


def gone(found: Diagnosed) -> bool:
    return any(one["problem"] == "node-silent" and one["status"] == "open" for one in found.incidents)


def lines(count: int, step_us: int, each: int) -> bytes:
    """Heartbeats of nodes, so many at one stamp, that much apart."""
    rows = (
        f"({1_700_000_000 + place * step_us // SECOND_US}.{place * step_us % SECOND_US:06d}) can0 {0x701 + node:X}#05\n"
        for place in range(count)
        for node in range(each)
    )
    return "".join(rows).encode()


def test_round_times_are_not_coarse_ones() -> None:
    text = lines(20, SECOND_US, 2)
    lost = b"".join(line for at, line in enumerate(text.splitlines(keepends=True)) if at < 20 or b" 702#" not in line)
    found = diagnosed(lost)
    assert [one["problem"] for one in found.incidents] == ["node-silent"], "two frames a second say when they came"
    assert found.whole["begin"] is not None


def test_what_is_printed_keeps_its_stamps() -> None:
    text = STAMP.sub(b"(1700000000.000000) ", text_of(STORIES[0]))
    for form in ("jsonl", "check", "transfers"):
        rows = [
            json.loads(line) for line in session_output([text], output_format=form, lang="en").decode().splitlines()
        ]
        timed = [row for row in rows if "t" in row]
        assert timed and all(row["t"] == "1700000000.000000" for row in timed), form
