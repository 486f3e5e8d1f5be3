"""Problems that are told live: at the end those of the file, and on the way each as it begins, is linked and ends.

The time is that of the stamps: no clock of this machine comes into it, but where a process listens to python-can's
virtual bus. What it must not do: test what is diagnosed of a file.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import pytest
from captures import SAMPLES, SHARED, Row, described_beside, log_text
from diagnoses import diagnosed
from kinds_of_drives import DISABLED, FAULT, POSITION, cycles, drive
from live_blocks import live_output
from test_sniff import ATTEMPTS, sniffed

PROBLEMS = SAMPLES / "problems.log"
STORIES = sorted((SHARED / "stories").glob("*.log"))
CAPTURES = [
    *STORIES,
    *(path for path in sorted(SAMPLES.glob("*.log")) if path.stem != "dialects"),
    *sorted((SAMPLES / "stacks").glob("*.log")),
    *(path for path in sorted((SAMPLES / "rules").glob("*.log")) if ".clean." not in path.name),
]
SILENCES = {"bus-silent", "capture-gap"}
"""Of a bus that is silent as a whole."""
OTHERWISE = {"s20-recorder-stall", "CAP007", "HBT005", "CAP002", "CAP008"}
"""Captures in which that is told otherwise live. Who listens knows that nothing came, and says so at once; a file may
have been written by a recorder that stood still, which only what comes after the silence shows. Where frames were
dropped, live has a frame before it, a file has not; and only a text has lines that were left out."""
LINE = re.compile(r"# (✖|↳|✔) (?:problem |ended |问题|已恢复 ?)(\d+): (.+)")


def ended_as(rows: list[Row]) -> list[tuple[object, ...]]:
    """What must be the same: all that is said of problems but when they could be noticed, and so their numbers.

    Silences of the whole bus are left out.
    """

    def said(one: Row) -> tuple[object, ...]:
        return (
            *(one["problem"], json.dumps(one["subject"]), one["begin"]["frame"], one["end"] and one["end"]["frame"]),
            *(one["status"], one["grade"], one["message"]),
        )

    by_id = {one["id"]: one for one in rows}
    found = []
    for one in rows:
        cause = one["cause"]
        because = (said(by_id[cause["id"]]), cause["link"], cause["grade"]) if cause else None
        found.append((*said(one), because))
    return sorted((one for one in found if one[0] not in SILENCES), key=repr)


def told_live(path: Path, **how: object) -> list[Row]:
    """The lines about problems."""
    out = live_output(path.read_bytes(), network=described_beside(path), **how)  # type: ignore[arg-type]
    return [row for row in map(json.loads, out.splitlines()) if row["kind"] == "problem"]


def final(rows: list[Row]) -> list[Row]:
    return [row for row in rows if row["phase"] == "final"]


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_the_stories_are_those_of_the_file(path: Path) -> None:
    live = final(told_live(path))
    file = diagnosed(path.read_bytes(), described_beside(path)).incidents
    assert ended_as(live) == ended_as(file)
    silences = [
        sorted((one["problem"], one["begin"]["frame"]) for one in some if one["problem"] in SILENCES)
        for some in (live, file)
    ]
    assert (silences[0] != silences[1]) == (path.stem in OTHERWISE)
    told = [row["id"] for row in told_live(path)]
    assert {*told} == {*range(1, max(told, default=0) + 1)}, "numbers are given in the order of telling, without gaps"
    assert [one["id"] for one in file] == [*range(1, len(file) + 1)]


@pytest.mark.parametrize("tick_ms", [1, 20, 1000])
@pytest.mark.parametrize("path", [PROBLEMS, *STORIES], ids=lambda path: path.stem)
def test_however_often_the_time_is_told_they_end_the_same(path: Path, tick_ms: int) -> None:
    often, seldom = (final(told_live(path, tick_ns=tick * 1_000_000)) for tick in (100, tick_ms))
    assert ended_as(often) == ended_as(seldom)


@pytest.mark.parametrize("path", [PROBLEMS, SAMPLES / "sdo-abort.log", *STORIES], ids=lambda path: path.stem)
def test_each_problem_is_opened_then_linked_or_over_and_final_once(path: Path) -> None:
    rows = told_live(path)
    finals = {row["id"]: row for row in final(rows)}
    parts = {part: row["id"] for row in finals.values() for part in row.get("parts", ())}
    assert len(finals) == len(final(rows)) and not parts.keys() & finals.keys()
    phases: dict[int, list[str]] = {}
    causes: dict[int, int | None] = {}
    for row in rows:
        phases.setdefault(row["id"], []).append(row["phase"])
        if row["phase"] in ("opened", "linked"):
            cause = row["cause"] and row["cause"]["id"]
            assert row["phase"] == "opened" or cause is not None
            causes[row["id"]] = cause
    for number, told in phases.items():
        if number in parts:
            assert parts[number] in finals and "final" not in told
            continue
        assert told[-1] == "final" and told.count("final") == 1
        # What is harmless is told at the end only.
        assert told[0] == ("opened" if len(told) > 1 else "final")
        if len(told) == 1:
            assert finals[number]["status"] == "harmless"
            continue
        last = [phase for phase in told if phase in ("opened", "ended")][-1]
        assert (last == "ended") == (finals[number]["status"] == "ended")
        cause = finals[number]["cause"] and finals[number]["cause"]["id"]
        assert parts.get(causes[number] or 0, causes[number]) == cause, "the cause that was told last is the final one"


@pytest.mark.parametrize("path", [PROBLEMS, *STORIES], ids=lambda path: path.stem)
def test_lines_for_people_tell_the_same_in_both_languages(path: Path) -> None:
    marks = {"opened": "✖", "linked": "↳", "ended": "✔"}
    wanted = [(marks[row["phase"]], row["id"]) for row in told_live(path) if row["phase"] in marks]
    for lang in ("zh", "en"):
        lines = live_output(path.read_bytes(), lang=lang, output_format="text").decode().splitlines()
        told = [found for line in lines if (found := LINE.fullmatch(line))]
        assert [(one[1], int(one[2])) for one in told] == wanted
        assert len(told) == sum(line.startswith(("# ✖", "# ↳", "# ✔")) for line in lines)


@pytest.mark.parametrize(
    ("lang", "sure", "likely"),
    [("en", "caused by 2 (", "probably caused by"), ("zh", "起因是问题2 (", "起因很可能是问题")],
)
def test_a_certain_cause_is_told_at_once(lang: str, sure: str, likely: str) -> None:
    out = live_output(PROBLEMS.read_bytes(), lang=lang, output_format="text").decode()
    line = next(line for line in out.splitlines() if "8130h" in line and line.startswith("# ✖"))
    later = [line for line in out.splitlines() if line.startswith("# ↳") and sure in line]
    assert sure in line and "?" not in line and likely not in line and not later


def beside(lang: str) -> str:
    """A SYNC producer dies, a drive reports it before anybody can know: its cause is found later."""
    lines = []
    for beat in range(80):
        at = 1_700_000_000.0 + beat * 0.1
        if beat < 40:
            lines.append((at, "702#05" if beat % 3 == 0 else "182#01"))
            lines.append((at + 0.001, "080#"))
        lines.append((at + 0.002, "703#05"))
        if beat == 41:
            lines.append((at + 0.003, "083#0081110000000000"))
    text = "".join(f"({at:.6f}) can0 {frame}\n" for at, frame in sorted(lines))
    return live_output(text.encode(), lang=lang, output_format="text").decode()


@pytest.mark.parametrize(
    ("lang", "first", "then"),
    [
        ("en", "# ↳ problem 1: probably caused by 3? (no SYNC ", "# ↳ problem 1: probably caused by 3 (no SYNC "),
        ("zh", "# ↳ 问题1: 起因很可能是问题3? (", "# ↳ 问题1: 起因很可能是问题3 ("),
    ],
)
def test_a_cause_that_is_found_later_has_a_question_mark_until_it_is_settled(lang: str, first: str, then: str) -> None:
    told = [line for line in beside(lang).splitlines() if line.startswith(("# ↳ problem 1:", "# ↳ 问题1:"))]
    assert [line[: len(wanted)] for line, wanted in zip(told, (first, then), strict=True)] == [first, then]


def test_a_problem_that_comes_again_and_again_is_told_once() -> None:
    """Not each time that it is over for a moment."""
    lines = []
    for beat in range(100):
        at = 1_700_000_000.0 + beat * 0.2
        lines += [(at, "705#05"), (at + 0.001, "706#05")]
        if beat in range(20, 100, 4):
            lines += [(at + 0.002, "085#1023020000000000"), (at + 0.302, "085#0000000000000000")]
    text = "".join(f"({at:.6f}) can0 {frame}\n" for at, frame in sorted(lines)).encode()
    rows = [row for row in map(json.loads, live_output(text).splitlines()) if row["kind"] == "problem"]
    assert [row["phase"] for row in rows] == ["opened", "ended", "opened", "ended", "opened", "final"]
    assert (rows[-1]["repeats"]["count"], rows[-1]["status"]) == (20, "open")


@pytest.mark.parametrize(
    ("in_fault", "then", "phases"),
    [
        (80, FAULT, ["opened", "final"]),
        (50, DISABLED, ["opened", "ended", "final"]),
        (20, FAULT, ["opened", "final"]),
        (20, DISABLED, []),
    ],
    ids=["stays", "is left", "too short to tell", "as drives are switched on"],
)
def test_a_drive_in_fault_when_first_seen_is_told_once_that_lasts(in_fault: int, then: int, phases: list[str]) -> None:
    """After 3 s: a drive that was just switched on is reset by then. The states are those of tenths of a second."""
    net = cycles(cycles(drive(), 0, FAULT, POSITION, count=in_fault), 0, then, POSITION, count=5)
    frames = net.frames()
    text = log_text(frames)
    rows = list(map(json.loads, live_output(text).splitlines()))
    told = [row for row in rows if row["kind"] == "problem"]
    assert [row["phase"] for row in told] == phases
    assert {row["problem"] for row in told} <= {"axis-fault"}
    if told:
        first = next(frame for frame in frames if frame.can_id == 0x185)
        before = [row for row in rows[: rows.index(told[0])] if row["kind"] == "frame"]
        after = (frames[len(before) - 1].t_us - first.t_us) / 1e6
        assert 3 <= after < 3.2 if in_fault > 30 else len(before) == len(frames)
        assert "already in fault when first seen" in told[0]["message"]
    assert ended_as(final(told)) == ended_as(diagnosed(text).incidents)


@pytest.mark.parametrize("path", [PROBLEMS], ids=lambda path: path.stem)
def test_what_a_process_that_listens_has_told_is_what_its_recording_says(path: Path, tmp_path: Path) -> None:
    wanted = Counter(one["problem"] for one in diagnosed(path.read_bytes()).incidents)
    for _ in range(ATTEMPTS):
        done = sniffed(str(path), "bus", "--format", "jsonl", "--record", "bus.log", "--force", cwd=tmp_path)
        rows = [row for row in map(json.loads, done.lines) if row["kind"] == "problem"]
        recorded = diagnosed((tmp_path / "bus.log").read_bytes()).incidents
        if Counter(row["problem"] for row in final(rows)) == wanted:
            break  # else the machine stalled, and nodes were late by that
    assert done.code == 0
    assert ended_as(final(rows)) == ended_as(recorded)
    assert Counter(row["problem"] for row in recorded) == wanted
    assert Counter(row["phase"] for row in rows)["opened"] == 4
