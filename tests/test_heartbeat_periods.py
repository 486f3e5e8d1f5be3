"""The period of a heartbeat producer: as configured or not, changed by itself, or not known yet behind a boot-up.

Each capture is made, so that the truth is known: the fault at every magnitude, and beside it what is none. What it must
not do: test a node that is silent with everything, or a single late heartbeat.
"""

from __future__ import annotations

import re

import pytest
from captures import analyze
from test_first_screen import Line, beats, log, told

OTHERS = [*beats(3, 5, 0, 30, 0.1), *beats(4, 5, 0.03, 30, 0.1)]
"""Other nodes: neither the bus nor its recorder pauses."""
CHANGE = 3.0


def written(at: float, ms: int) -> list[Line]:
    return [(at, f"605#2B171000{ms.to_bytes(2, 'little').hex()}0000"), (at + 0.001, "585#6017100000000000")]


def uneven(lines: list[Line], by: float) -> list[Line]:
    """Every third heartbeat is late by so many seconds."""
    return [(at + by * (place % 3 == 0), frame) for place, (at, frame) in enumerate(lines)]


def problems(*lines: list[Line], until: float = 25) -> list[tuple[str, str, str]]:
    said = told(log([one for one in [*OTHERS, *(line for part in lines for line in part)] if one[0] < until]))
    return [(status, kind, re.sub("node 5: (.*?),? since .*", r"\1", words)) for status, kind, words in said]


def codes(*lines: list[Line], until: float = 25) -> list[str]:
    frames = [one for one in [*OTHERS, *(line for part in lines for line in part)] if one[0] < until]
    return [row["code"] for row in analyze(log(frames)).findings if row["because_of"] is None]


@pytest.mark.parametrize("ms", [100, 150, 200, 210, 225, 250, 300, 400, 500, 600, 800, 1000, 3000])
@pytest.mark.parametrize("late", [0, 0.005])
def test_a_period_that_does_not_follow_its_configuration(ms: int, late: float) -> None:
    """1017h is written, and the heartbeats stay at 200 ms, whatever it was before; from an eighth on they differ."""
    before = beats(5, 5, 0.1, CHANGE, 0.2)
    same = uneven(beats(5, 5, before[-1][0] + 0.2, 25, 0.2), late)
    differs = not 176 <= ms <= 228
    said = problems(before, written(CHANGE, ms), same)
    assert [(status, kind) for status, kind, _ in said] == [("open", "heartbeat-irregular")] * differs
    assert all(f"1017h holds {ms if ms < 1000 else ms // 1000} " in words for *_, words in said)
    assert all(words.startswith("heartbeat period is 200") or late for *_, words in said)
    # The same without heartbeats before it.
    assert [kind for _, kind, _ in problems(written(0.05, ms), same)] == ["heartbeat-irregular"] * differs


@pytest.mark.parametrize(
    "ms", [20, 50, 67, 100, 150, 170, 180, 200, 220, 240, 300, 400, 500, 600, 700, 1000, 2000, 3000, 5000]
)
def test_a_period_that_changes_by_itself(ms: int) -> None:
    """It is one fault, faster or slower, and open; from an eighth on it is another period."""
    before = beats(5, 5, 0.1, CHANGE, 0.2)
    said = problems(before, beats(5, 5, before[-1][0] + max(ms, 200) / 1000, 25, ms / 1000))
    differs = not 176 <= ms <= 228
    assert [(status, kind) for status, kind, _ in said] == [("open", "heartbeat-irregular")] * differs
    assert all(words.startswith("heartbeat period changed from 200 ms to ") for *_, words in said)


@pytest.mark.parametrize("ms", [50, 100, 300, 400, 1000])
def test_a_period_that_is_as_before_in_the_end(ms: int) -> None:
    before = beats(5, 5, 0.1, CHANGE, 0.2)
    change = beats(5, 5, before[-1][0] + max(ms, 200) / 1000, 15, ms / 1000)
    said = problems(before, change, beats(5, 5, change[-1][0] + 0.2, 30, 0.2), until=30)
    assert [(status, kind) for status, kind, _ in said] == [("ended", "heartbeat-irregular")]


@pytest.mark.parametrize("behind", [0.02, 0.05, 0.085, 0.115, 0.15, 0.18])
@pytest.mark.parametrize("ms", [None, 200])
def test_a_second_node_is_no_other_period(behind: float, ms: int | None) -> None:
    """Two nodes with one node-ID, each with heartbeats every 200 ms, from the beginning or from later on."""
    first = written(0.01, ms) if ms else []
    one = beats(5, 5, 0.1, 25, 0.2)
    assert codes(first, one, beats(5, 5, CHANGE + 0.1 + behind, 25, 0.2)) == ["HBT004"]
    if ms:  # What is learnt of two from the beginning may be the shorter time between them.
        found = codes(first, one, beats(5, 5, 0.1 + behind, 25, 0.2))
        assert "HBT004" in found and not {"HBT001", "HBT007"} & {*found}


@pytest.mark.parametrize("ms", [30, 70, 500, 1000])
def test_a_second_node_with_another_period(ms: int) -> None:
    one, other = beats(5, 5, 0.1, 25, 0.2), beats(5, 5, CHANGE + 0.137, 25, ms / 1000)
    assert codes(one, other) == ["HBT004"]


@pytest.mark.parametrize("after", [0.05, 0.1, 0.37])
def test_additional_heartbeats_are_legal(after: float) -> None:
    one = [*written(0.01, 500), *beats(5, 5, 0.1, 25)]
    assert codes(one, [(at + after, "705#05") for at in (3.1, 9.1, 9.6, 17.1)]) == []


@pytest.mark.parametrize("ms", [20, 100, 500, 1000, 2000, 4000])
@pytest.mark.parametrize("booted", [0.2, 0.5])
def test_a_boot_up_may_bring_another_period(ms: int, booted: float) -> None:
    """The program that starts then has its own period; once it is known, it is kept."""
    before = [*beats(5, 5, 0.1, CHANGE, 0.2), (CHANGE, "000#8105"), (CHANGE + booted, "705#00")]
    beat = beats(5, 0x7F, CHANGE + booted + ms / 1000, 25, ms / 1000)
    assert codes(before, beat) == []
    if ms <= 1000:
        assert codes(before, beat[:6]) == ["HBT002"]


@pytest.mark.parametrize(("beat", "lost"), [(0, False), (1, True), (2, True), (5, True)])
def test_a_node_that_boots_and_falls_silent_is_lost(beat: int, lost: bool) -> None:
    """Without any heartbeat there is none to be missed, but the node is mute."""
    before = [*beats(5, 5, 0.1, CHANGE, 0.2), (CHANGE, "000#8105"), (CHANGE + 0.3, "705#00")]
    after = beats(5, 0x7F, CHANGE + 0.5, 25, 0.2)[:beat]
    assert codes(before, after) == ["HBT002"] * lost
    assert [status for status, *_ in problems(before, after) if status != "harmless"] == ["open"]
