"""What is diagnosed: no problem in clean traffic, one for one fault, and the keys that other programs rely on.

Nodes of clean sessions may report errors of themselves, and refuse writes: those are problems that are there.
Recorded stories with their causes are in `test_stories.py`. What it must not do: test how findings come to be.
"""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest
from captures import CanFrame, Row, log_text, run_canalyze, session_output, spaced
from clean_sessions import sessions
from diagnoses import diagnosed
from fault_table import TABLE, AnyFault
from faulty_captures import Capture
from network_sessions import SESSIONS
from plants import EVENT, EVENT_PDO, UP, built

import canalyze
from canalyze import _core
from canalyze.records.problems import KEYS
from canalyze.running.reading import SessionOptions

REPORTED = {
    "boot-and-states": ["overrun", "supply-voltage"],
    "drive-states": ["device-error"],
    "a2-selfstart-heartbeat": ["device-error"],
    "c3-pdo-remap-master-sync": ["mapping-refused"],
    "emergencies": ["overrun", "supply-voltage"],
    "transfers": ["access-refused", "access-refused"],
}
"""What nodes of clean sessions report of themselves, by the truth of these: emergencies, and refused writes."""

BESIDE = {
    "recorded: frames lost silently: 30": 10,
    "recorded: frames lost silently: 100": 4,
    "recorded: node lost: for ever": 2,
    "synchronous PDO missing: 3 cycles after a refused write": 6,
}
"""Cases in which one fault has a second root: what is lost breaks the transfers of several nodes, or leaves a mapping
half written; a refused write is part of the fault's making."""


@pytest.mark.parametrize("name", sessions())
def test_clean_sessions_have_no_problem(name: str) -> None:
    session = sessions()[name]
    found = diagnosed(log_text(session.frames), session.network)
    assert sorted(one["problem"] for one in found.roots) == REPORTED.get(name, []), found.said


def own(name: str) -> Counter[str]:
    """The kinds that are in a recorded session without the fault, with its descriptions or without them."""
    return Counter([*REPORTED.get(name, []), *(["axis-fault"] if name == "drive-states" else [])])


@pytest.mark.parametrize("fault", TABLE, ids=lambda fault: fault.row)
def test_one_fault_is_at_most_one_problem(fault: AnyFault) -> None:
    beside = 0
    said: list[str] = []
    for case in fault.cases():
        found = diagnosed(log_text(case.faulty.frames), case.network)
        kinds = Counter(one["problem"] for one in found.roots)
        recorded = case.where.rsplit(" at ", 1)[0] if fault.row.startswith("recorded") else ""
        if (kinds - own(recorded)).total() > 1:
            beside += 1
            said += [case.where, *found.said]
    assert beside <= BESIDE.get(fault.row, 0), "\n".join(said)


def frames_of(name: str) -> bytes:
    return log_text(SESSIONS[name]().frames())


def test_json_lines_have_these_keys(tmp_path: Path) -> None:
    folder = tmp_path
    (folder / "a.log").write_bytes(frames_of("emergencies"))
    lines = run_canalyze(["diagnose", "a.log", "--format", "jsonl"], folder=folder).decode().splitlines()
    rows: list[Row] = [json.loads(line) for line in lines]
    assert rows
    for row in rows:
        assert list(row) == list(KEYS)
        assert (row["kind"], row["phase"]) == ("problem", "final")
        assert row["status"] in {"open", "ended", "harmless", "unknown"}
        assert row["impact"] in set("ABCDE")
        assert row["grade"] in {"certain", "likely", "possible"}
        assert "bus" in row["subject"]
        assert set(row["begin"]) == {"frame", "t"}
        assert set(row["noticed"]) == {"frame", "t", "delay"}
        assert row["repeats"]["count"] >= 1


def lost(count: int, *, until: int = 40) -> bytes:
    """Two producers of heartbeats; after `count` of them node 5 is silent."""
    frames = []
    for beat in range(until):
        for node in (5, 6):
            if node == 6 or beat < count:
                at = 1_700_000_000_000_000 + beat * 100_000 + node * 500
                frames.append(CanFrame("can0", 0x700 + node, b"\x05", at))
    return log_text(frames)


def test_a_node_is_silent_since_its_last_frame() -> None:
    found = diagnosed(lost(20))
    (one,) = found.roots
    assert (one["problem"], one["status"], one["subject"]["node"]) == ("node-silent", "open", 5)
    assert one["begin"]["frame"] == 39
    assert one["end"] is None
    assert [entry["code"] for entry in one["findings"]] == ["HBT002"]
    assert found.whole["counts"] == {"open": 1, "unknown": 0, "ended": 0, "harmless": 0}


def test_a_node_that_goes_on_is_not_silent() -> None:
    assert not diagnosed(lost(40)).incidents


def test_who_asked_for_the_reset_makes_it_harmless() -> None:
    operational = [CanFrame("can0", 0x705, b"\x05")] * 8
    heartbeat = [CanFrame("can0", 0, b"\x01\x05"), *operational]
    boot = [CanFrame("can0", 0x705, b"\0"), *heartbeat]
    booted = [CanFrame("can0", 0, b"\x81\x05"), CanFrame("can0", 0x705, b"\0"), CanFrame("can0", 0, b"\x01\x05")]
    asked = spaced([*heartbeat, *booted[:1]], step_us=100_000)
    start = asked[-1].t_us
    asked += spaced(booted[1:], start_us=start + 50_000)
    asked += spaced(operational, start_us=start + 150_000, step_us=100_000)
    commanded = diagnosed(log_text(asked))
    assert [(one["problem"], one["status"]) for one in commanded.incidents] == [("commanded-reset", "harmless")]
    by_itself = diagnosed(log_text(spaced([*heartbeat, *boot], step_us=100_000)))
    assert [(one["problem"], one["status"]) for one in by_itself.incidents] == [("node-restarted", "ended")]
    stays = [*heartbeat, CanFrame("can0", 0x705, b"\0"), *([CanFrame("can0", 0x705, b"\x7f")] * 80)]
    forgotten = diagnosed(log_text(spaced(stays, step_us=100_000)))
    assert [(one["problem"], one["status"]) for one in forgotten.incidents] == [("node-restarted", "open")]
    early = diagnosed(log_text(spaced(stays[:30], step_us=100_000)))
    assert [(one["problem"], one["status"]) for one in early.incidents] == [("node-restarted", "unknown")]


@pytest.mark.parametrize("missing", [6, 10, 15])
@pytest.mark.parametrize("after", [0.06, 0.3, 1.0, 1.8])
def test_a_command_that_is_over_excuses_no_pdo_that_stops_later(after: float, missing: int) -> None:
    """All nodes are stopped and started again, and the PDO has come since; or it has not come since the command."""
    capture = Capture(built("plant", "written"))
    first = capture.next(EVENT_PDO, UP + after)
    capture.drop(first + 0.01, first + 0.01 + missing * EVENT, EVENT_PDO)
    told = [one for one in diagnosed(log_text(capture.frames)).incidents if one["problem"] == "pdo-missing"]
    assert [(one["status"], one["cause"]) for one in told] == [("ended", None)]


def test_a_command_excuses_the_pdos_that_it_stops() -> None:
    capture = Capture(built("plant", "written"))
    capture.drop(UP, UP + 1.5, EVENT_PDO)
    told = [one for one in diagnosed(log_text(capture.frames)).incidents if one["problem"] == "pdo-missing"]
    assert [one["status"] for one in told] in ([], ["harmless"])


def test_incidents_of_the_library(tmp_path: Path) -> None:
    (tmp_path / "a.log").write_bytes(lost(20))
    capture = canalyze.open(tmp_path / "a.log")
    (one,) = capture.problems.roots
    assert capture.problems.open == [one]
    assert capture.diagnosis() == capture.diagnosis([one]) and one.message in capture.diagnosis()[0]
    assert capture.gave(one)
    table = capture.tables("problems")["problems"]
    assert (table.column("problem"), table.column("begin_frame")) == (["node-silent"], [one.begin.frame])
    assert capture.problems.of(node=5, kind="node-silent", bus="can0", status="open") == [one]
    assert not capture.problems.of(node=6)
    assert (one.begin.frame, one.end, one.nodes, one.cause, one.effects) == (39, None, (5,), None, ())
    assert capture.problems.cause_of(one) is None and not capture.problems.effects_of(one)
    assert 39 in one.frames
    assert "node 5" in repr(capture.problems)
    with pytest.raises(ValueError, match="status"):
        capture.problems.of(status="gone")  # type: ignore[arg-type]
    with pytest.raises(KeyError):
        capture.problems.by_id(7)


def test_incidents_are_told_as_they_begin_and_end() -> None:
    text = lost(20, until=30) + lost(60, until=60).replace(b"(170000000", b"(170000001")
    session = _core.Session(SessionOptions(lang="en", format="text", incidents=True))
    session.begin("a.log", True, "candump", 0)
    out = b"".join([session.feed(text, 0), session.end(False, 0), session.finish()]).decode()
    told = [line for line in out.splitlines() if line.startswith(("# ✖", "# ✔"))]
    assert len(told) == 2
    assert told[0].startswith("# ✖ problem 1: node 5: silent since")
    assert told[1].startswith("# ✔ ended 1: node 5: silent for")
    session = _core.Session(SessionOptions(lang="en", format="jsonl", incidents=True))
    session.begin("a.log", True, "candump", 0)
    out = b"".join([session.feed(text, 0), session.end(False, 0), session.finish()]).decode()
    rows = [json.loads(line) for line in out.splitlines() if '"kind":"problem"' in line]
    assert [row["phase"] for row in rows if row["id"] == 1] == ["opened", "ended", "final"]
    assert next(row for row in rows if row["phase"] == "final")["status"] == "ended"


@pytest.mark.parametrize("size", [1, 7, 100])
def test_in_any_chunks_the_same(size: int) -> None:
    text = frames_of("emergencies") + lost(20)
    whole = session_output([text], output_format="diagnosis", lang="en")
    chunks = [text[at : at + size] for at in range(0, len(text), size)]
    assert session_output(chunks, output_format="diagnosis", lang="en") == whole
