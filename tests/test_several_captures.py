"""Several captures at once: which are parts of one recording, and how the others are diagnosed.

What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import json
import os
import threading
from pathlib import Path

import pytest
from conftest import Runner
from test_diagnosis import lost

from canalyze.sources.recordings import APART_NS, Span, recordings

S = 1_000_000_000
T = 1_700_000_000 * S
CAN0 = frozenset({"can0"})


def _span(name: str, begin: int | None, end: int | None, buses: frozenset[str] = CAN0, at: int = T) -> Span:
    return Span(name, None if begin is None else at + begin, None if end is None else at + end, buses)


@pytest.mark.parametrize("apart_ns", [0, 1, S, APART_NS])
def test_files_that_follow_one_another_are_one_recording(apart_ns: int) -> None:
    first, second = _span("a.10", 5 * S, 9 * S), _span("a.9", 0, 5 * S - apart_ns)
    assert recordings([first, second]) == [("a.9", "a.10")], "in the order of time, however they are named"


@pytest.mark.parametrize(
    "second",
    [
        _span("b", 5 * S + APART_NS + 1, 90 * S),
        _span("b", 5 * S - 1, 9 * S),
        _span("b", 0, 5 * S),
        _span("b", 5 * S, 9 * S, frozenset({"can1"})),
        _span("b", None, None),
    ],
    ids=["too late", "too early", "at the same time", "another bus", "without stamps"],
)
def test_others_are_recordings_of_their_own(second: Span) -> None:
    assert recordings([_span("a", 0, 5 * S), second]) == [("a",), ("b",)]


def test_clocks_that_begin_at_zero_tell_nothing() -> None:
    assert recordings([_span("a", 0, 5 * S, at=0), _span("b", 5 * S, 9 * S, at=0)]) == [("a",), ("b",)]


def test_a_file_of_the_same_time_is_no_part_and_parts_nothing() -> None:
    """Of two networks with one name of their bus nobody knows which part follows which."""
    parts = [_span("a", 0, 5 * S), _span("b", 5 * S, 9 * S), _span("other", 6 * S, 9 * S)]
    assert recordings(parts) == [("a",), ("b",), ("other",)]
    later = _span("later", 20 * S, 30 * S)
    assert recordings([*parts[:2], later]) == [("a", "b"), ("later",)]


def test_two_recorders_that_were_split_are_told_apart() -> None:
    can1 = frozenset({"can1"})
    parts = [_span("a1", 0, 5), _span("b1", 1, 6, can1), _span("a2", 6, 9), _span("b2", 7, 9, can1)]
    assert recordings(parts) == [("a1", "a2"), ("b1", "b2")]


@pytest.fixture
def captures(tmp_path: Path) -> Path:
    """A node that is lost, twice, an hour apart; a healthy capture; and what is no capture."""
    folder = tmp_path / "captures"
    (folder / "night").mkdir(parents=True)
    (folder / "lost.log").write_bytes(lost(20))
    (folder / "night" / "well.log").write_text("".join(f"({1_600_000_000 + n}.5) can0 702#05\n" for n in range(9)))
    (folder / "notes.md").write_text("nothing")
    return folder


def test_a_folder_is_one_line_a_recording_the_worst_first(canalyze: Runner, captures: Path) -> None:
    done = canalyze("--lang", "en", "captures")
    assert (done.code, done.err) == (0, "")
    first, second, total, more = done.lines
    assert first.startswith("✖ 1 open problem") and "lost.log" in first and "node 5: silent since" in first
    assert second.startswith("✔ no problems found") and "well.log" in second
    assert total == "2 recordings: 1 with open problems, 1 without open problems"
    assert "canalyze captures/lost.log" in more and "--join" in more
    spoken = canalyze("captures")
    assert "2个记录" in spoken.out and "节点5" in spoken.out


def test_parts_are_diagnosed_together(canalyze: Runner, captures: Path, tmp_path: Path) -> None:
    lines = (captures / "lost.log").read_bytes().splitlines(keepends=True)
    (tmp_path / "x.2").write_bytes(b"".join(lines[:40]))
    (tmp_path / "x.1").write_bytes(b"".join(lines[40:]))
    whole = canalyze("--lang", "en", "captures/lost.log").lines
    assert canalyze("--lang", "en", "x.1", "x.2").lines[:-1] == whole[:-1], "all but the names"


def test_joined_they_are_one(canalyze: Runner, captures: Path) -> None:
    done = canalyze("--lang", "en", "--join", "captures")
    assert "OPEN" in done.lines or "UNKNOWN" in done.lines or "no problems found" in done.lines[0]
    assert "recordings" not in done.out and "all files are read as one capture" in done.err


def test_json_lines_name_the_files(canalyze: Runner, captures: Path) -> None:
    rows = [json.loads(line) for line in canalyze("captures", "--format", "jsonl").lines]
    assert rows and all(row["files"] == ["captures/lost.log"] for row in rows)
    assert all("files" not in json.loads(line) for line in canalyze("captures/lost.log", "--format", "jsonl").lines)


def test_exit_codes(canalyze: Runner, captures: Path) -> None:
    assert canalyze("captures", "--fail-on", "open").code == 1
    assert canalyze("captures/night", "--fail-on", "ended").code == 0
    done = canalyze("--lang", "en", "captures", "missing.log")
    assert done.code == 2 and "missing.log" in done.err and "3 recordings" in done.out and "1 unreadable" in done.out


def test_what_is_of_one_recording_says_so(canalyze: Runner, captures: Path) -> None:
    done = canalyze("--lang", "en", "captures", "-n", "1")
    assert done.code == 2 and "-n" in done.err and "--join" in done.err and not done.out


def test_a_folder_without_captures_is_one_line(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    done = canalyze("empty")
    assert done.code == 2 and len(done.complaints) == 1


def test_a_fleet_is_counted_by_kind_and_node(canalyze: Runner, captures: Path, tmp_path: Path) -> None:
    (captures / "again.log").write_bytes(lost(20))
    done = canalyze("--lang", "en", "fleet", "diagnose", "captures", "-o", "out")
    assert done.code == 0
    row = next(line.split() for line in done.lines if line.startswith("node-silent"))
    assert row[1:6] == ["5", "2", "2", "0", "0"] and row[6].endswith(".log")
    assert "3 recordings: 2 with open problems, 1 without open problems" in done.out
    whole = (tmp_path / "out" / "diagnose.txt").read_text()
    assert whole.index("lost.log   ") < whole.index("well.log"), "the worst first"
    records = [json.loads(line) for line in (tmp_path / "out" / "diagnose.jsonl").read_text().splitlines()]
    assert {Path(one["capture"]).name for one in records} == {"again.log", "lost.log"}
    again = canalyze("--lang", "en", "fleet", "diagnose", "captures", "-o", "out")
    assert "3 captures done, 3 of them before" in again.out


@pytest.mark.parametrize(
    ("former", "now"),
    [
        (("captures/lost.log", "--fail-on", "stands"), ("captures/lost.log", "--fail-on", "open")),
        (("captures/lost.log", "--fail-on=over"), ("captures/lost.log", "--fail-on=ended")),
        (("check", "--incidents", "stands", "captures/lost.log"), ("check", "--problems", "open", "captures/lost.log")),
        (("check", "--incidents=never", "captures/lost.log"), ("check", "--problems=never", "captures/lost.log")),
        (("decode", "--incidents", "captures/lost.log"), ("decode", "--problems", "captures/lost.log")),
        (
            ("export", "--table", "incidents", "captures/lost.log", "-o", "a.csv", "--force"),
            ("export", "--table=problems", "captures/lost.log", "-o", "a.csv", "--force"),
        ),
    ],
)
@pytest.mark.usefixtures("captures")
def test_former_spellings_are_accepted(canalyze: Runner, former: tuple[str, ...], now: tuple[str, ...]) -> None:
    assert canalyze(*former) == canalyze(*now)


def test_what_can_be_read_once_is_read_once(canalyze: Runner, captures: Path, tmp_path: Path) -> None:
    """A named pipe is read as part of one recording, as it was."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    content = (captures / "lost.log").read_bytes()
    writer = threading.Thread(target=pipe.write_bytes, args=(content,))
    writer.start()
    done = canalyze("--lang", "en", "captures/night/well.log", "pipe")
    writer.join()
    assert done.code == 0 and "silent since" in done.out and "recordings" not in done.out
