"""`diff` by stories: problems of one capture only, and those that both have and that are others in each.

What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from captures import SAMPLES, CanFrame, Row, console_text, log_text
from comparing import Compared, compared, renamed
from conftest import Runner

START = 1_700_000_000_000_000


def beats(gaps: tuple[range, ...] = (), *, count: int = 80, more: tuple[CanFrame, ...] = ()) -> list[CanFrame]:
    """Heartbeats of nodes 5 and 6 every 100 ms, but for those of node 5 in some gaps; and further frames."""
    frames = [
        CanFrame("can0", 0x700 + node, b"\x05", START + beat * 100_000 + node * 500)
        for beat in range(count)
        for node in (5, 6)
        if node == 6 or not any(beat in gap for gap in gaps)
    ]
    # What tells one moment from another: each is written once.
    for number in range(0, count, 4):
        at, data = START + number * 100_000 + 7000, bytes([number, 0x20, 0, number])
        frames.append(CanFrame("can0", 0x606, b"\x2f" + data + bytes(3), at))
        frames.append(CanFrame("can0", 0x586, b"\x60" + data[:3] + bytes(4), at + 400))
    return sorted([*frames, *more], key=lambda frame: frame.t_us)


def told(said: Compared) -> list[tuple[str, int | None, list[str], bool, bool]]:
    return [
        (row["problem"], row["node"], row["differs"], row["a"] is not None, row["b"] is not None)
        for row in said.incidents
    ]


def emcy(beat: int, data: str, node: int = 5) -> CanFrame:
    return CanFrame("can0", 0x080 + node, bytes.fromhex(data), START + beat * 100_000 + 9000)


WELL, LOST, BACK = beats(), beats((range(30, 80),)), beats((range(30, 42),))
RAISED = emcy(20, "1023030000000000")
BRIEFLY, LONGER = (emcy(beat, "0000000000000000") for beat in (26, 40))


def test_a_problem_of_one_capture_only() -> None:
    said = compared(log_text(WELL), log_text(LOST))
    assert told(said) == [("node-silent", 5, [], False, True)]
    assert said.closing["problems"] == 1 and not said.closing["same"]
    assert said.incidents[0]["b"]["status"] == "open"
    assert LOST[said.incidents[0]["b"]["frame"] - 1].can_id == 0x705
    assert told(compared(log_text(LOST), log_text(WELL))) == [("node-silent", 5, [], True, False)]
    assert said.text.startswith("differing problems: 1\n  only in B:\n    node 5: ")


def test_what_both_have_is_no_difference() -> None:
    for frames in (LOST, BACK, beats(more=(RAISED, BRIEFLY))):
        said = compared(log_text(frames), log_text(renamed(frames, "slcan")))
        assert not said.incidents and said.closing["same"]


def test_how_it_stands_and_how_long_it_lasted() -> None:
    def errors(*more: CanFrame) -> bytes:
        return log_text(beats(more=(RAISED, *more)))

    said = compared(log_text(BACK), log_text(LOST))
    assert told(said) == [("node-silent", 5, ["status"], True, True)]
    assert "in both but different:" in said.text and "status A ended, B open" in said.text
    assert told(compared(errors(BRIEFLY), errors(LONGER))) == [("device-error", 5, ["duration"], True, True)]
    both = compared(errors(BRIEFLY), errors(LONGER)).incidents[0]
    assert (both["a"]["duration_ns"], both["b"]["duration_ns"]) == (600_000_000, 2_000_000_000)
    assert "duration A 600 ms, B 2000 ms" in compared(errors(BRIEFLY), errors(LONGER)).text
    assert told(compared(errors(BRIEFLY), errors())) == [("device-error", 5, ["status"], True, True)]


def test_how_often_it_came() -> None:
    often = beats((range(20, 30), range(40, 50), range(60, 70)))
    rows = told(compared(log_text(beats((range(20, 30),))), log_text(often)))
    assert [(kind, node) for kind, node, *_ in rows] == [("node-silent", 5)]
    assert "count" in rows[0][2]


def test_from_what_it_comes() -> None:
    """Node 6 watches node 5 (1016h) and reports its loss; the same report without one comes from nothing."""
    setup = (
        CanFrame("can0", 0x606, bytes.fromhex("23161001C8000500"), START + 1000),
        CanFrame("can0", 0x586, bytes.fromhex("6016100100000000"), START + 1400),
    )
    report = CanFrame("can0", 0x086, bytes.fromhex("3081110000000000"), START + 2_900_000 + 2500 + 202_000)
    caused, alone = beats((range(30, 80),), more=(*setup, report)), beats(more=(*setup, report))
    said = compared(log_text(caused), log_text(alone))
    assert ("heartbeat-consumer-error", 6, ["cause"], True, True) in told(said), told(said)
    (row,) = (row for row in said.incidents if row["node"] == 6)
    assert (row["a"]["cause"], row["b"]["cause"]) == ("node-silent", None)
    # What follows from a story that one capture lacks is told with that story.
    assert told(compared(log_text(caused), log_text(beats(more=setup)))) == [("node-silent", 5, [], True, False)]


def test_what_the_other_capture_does_not_cover_is_not_judged() -> None:
    for part in (WELL[: len(WELL) // 3], [frame for frame in WELL if frame.t_us > START + 4_000_000]):
        for pair in ((LOST, part), (part, LOST)):
            said = compared(*map(log_text, pair))
            assert not said.incidents, told(said)
    assert not compared(log_text(LOST), console_text(WELL)).incidents, "without stamps silence does not show"


def test_captures_that_do_not_begin_together() -> None:
    """What shows by its own frames is judged at once; what something before may explain is not."""
    early = tuple(CanFrame("can0", 0x705, b"\x05", START - 900_000 + beat * 100_000) for beat in range(9))
    for at in (2, 40):
        said = compared(log_text(beats(more=early)), log_text(beats(more=(emcy(at, "1023030000000000"),))))
        assert told(said) == [("device-error", 5, [], False, True)]
    soon, late = beats((range(20, 30),)), beats((range(50, 60),))
    assert not compared(log_text(beats(more=early)), log_text(soon)).incidents
    said = compared(log_text(beats(more=early)), log_text(late))
    assert told(said) == [("node-silent", 5, [], False, True)]


def test_it_is_a_difference_in_both_languages(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_bytes(log_text(BACK))
    (tmp_path / "b.log").write_bytes(log_text(LOST))
    for lang, words in (("en", "differing problems: 1"), ("zh", "问题的差异: 1")):
        done = canalyze("diff", "--lang", lang, "a.log", "b.log")
        assert done.code == 1 and done.lines[0] == words
    rows = [json.loads(line) for line in canalyze("diff", "--format", "jsonl", "a.log", "b.log").lines]
    assert rows[0]["kind"] == "problem_difference" and rows[-1]["problems"] == 1
    filtered = canalyze("diff", "--filter", "node=6", "a.log", "b.log")
    assert filtered.code == 0, "behind a filter problems are not compared"


RULES = ["HBT002", "GRD005", "EMC008", "DRV005", "SDO002"]


@pytest.mark.parametrize("code", RULES)
def test_samples_of_rules_against_their_neighbours(code: str, canalyze: Runner) -> None:
    pair = [str(SAMPLES / "rules" / f"{code}{suffix}.log") for suffix in ("", ".clean")]
    rows: list[Row] = [json.loads(line) for line in canalyze("diff", "--format", "jsonl", *pair).lines]
    assert rows[0]["kind"] == "problem_difference" and rows[0]["b"] is None
    other = [json.loads(line) for line in canalyze("diff", "--format", "jsonl", *pair[::-1]).lines]
    assert [row["b"]["text"] for row in other if row["kind"] == "problem_difference"] == [
        row["a"]["text"] for row in rows if row["kind"] == "problem_difference"
    ]
