"""An SRDO that pauses or stops, with its times configured or learnt, at every magnitude; and what is no fault of it.

Each capture is made, so that the truth is known. What it must not do: test the data and the order of the two frames.
"""

from __future__ import annotations

import pytest
from captures import analyze
from test_first_screen import Line, beats, log, told

PERIOD = 0.025
STOP = 3.0
END = 8.0
CONFIGURED: list[Line] = [
    (0.01, "60A#4001130100000000"),
    (0.011, "58A#4F01130101000000"),
    (0.02, "60A#4001130200000000"),
    (0.021, "58A#4B01130232000000"),
    (0.03, "60A#4001130300000000"),
    (0.031, "58A#4F01130314000000"),
    (0.04, "60A#4001130500000000"),
    (0.041, "58A#4301130513010000"),
    (0.05, "60A#4001130600000000"),
    (0.051, "58A#4301130614010000"),
    (0.1, "000#0100"),
]
"""SRDO10 of node 10: a safeguard cycle time of 50 ms, and a validation time of 20 ms."""
LEARNT: list[Line] = [(0.1, "000#0100")]


def pairs(begin: float, end: float, period: float = PERIOD, number: int = 10, constant: int = 20) -> list[Line]:
    """The data change with some of the pairs."""
    rows: list[Line] = []
    for place in range(round((end - begin) / period)):
        at, value = begin + place * period, place // constant & 0xFF
        rows.append((at, f"{0xFF + 2 * number:03X}#{value:02X}55"))
        rows.append((at + 0.0006, f"{0x100 + 2 * number:03X}#{0xFF ^ value:02X}AA"))
    return rows


def network(state: int = 5, until: float = END, changed: float = STOP) -> list[Line]:
    """Heartbeats of node 10, in another state from the change on; those of others, and another SRDO."""
    own = [*beats(10, 5, 0.2, changed, 0.2), *beats(10, state, changed, until, 0.2)]
    return [*own, *beats(11, 5, 0.25, END, 0.2), *beats(1, 5, 0.15, END, 0.1), *pairs(0.5, END, number=11)]


def problems(*parts: list[Line]) -> list[tuple[str, str]]:
    lines = [line for part in parts for line in part]
    return [(status, kind) for status, kind, _ in told(log(lines)) if status != "harmless"]


def roots(*parts: list[Line]) -> list[str]:
    rows = analyze(log([line for part in parts for line in part])).findings
    return [row["code"] for row in rows if row["because_of"] is None]


@pytest.mark.parametrize("known", [CONFIGURED, LEARNT])
@pytest.mark.parametrize("rest", [0.0, 0.02, 0.04, 0.2, 0.9, 1.1, 5.0])
def test_one_that_stops(known: list[Line], rest: float) -> None:
    """At the end of the capture, too, once it is overdue there."""
    lines = [one for one in [*known, *network(), *pairs(0.5, STOP)] if one[0] < STOP + rest]
    overdue = rest > (0.05 if known is CONFIGURED else 0.1)
    assert problems(lines) == [("open", "srdo-invalid")] * overdue


@pytest.mark.parametrize("known", [CONFIGURED, LEARNT])
@pytest.mark.parametrize("pause", [0.025, 0.045, 0.07, 0.12, 0.25, 0.9, 1.5, 4])
def test_one_that_pauses(known: list[Line], pause: float) -> None:
    """It is one fault that has ended, whether it was noticed in the pause or behind it."""
    lines = [*known, *network(), *pairs(0.5, STOP), *pairs(STOP - PERIOD + pause, END)]
    late = pause > (0.056 if known is CONFIGURED else 0.1)
    assert problems(lines) == [("ended", "srdo-invalid")] * late
    assert roots(lines) == ["SRD003"] * late


@pytest.mark.parametrize("delay", [0.0006, 0.015, 0.03, 0.06, 0.2])
@pytest.mark.parametrize("known", [CONFIGURED, LEARNT])
def test_an_inverse_that_is_late(known: list[Line], delay: float) -> None:
    half = [(STOP, "113#0755"), (STOP + delay, "114#F8AA")]
    lines = [*known, *network(), *pairs(0.5, STOP), *half, *pairs(STOP + delay + PERIOD, END)]
    late = delay > (0.021 if known is CONFIGURED else 0.051)
    assert ("SRD002" in roots(lines)) == late


@pytest.mark.parametrize("known", [CONFIGURED, LEARNT])
@pytest.mark.parametrize(
    ("what", "beside"),
    [
        ("stopped by command", [(STOP, "000#020A"), *network(4)]),
        ("all stopped by command", [(STOP, "000#0200"), *network(4)]),
        ("Pre-operational by command", [(STOP, "000#800A"), *network(0x7F)]),
        ("reset", [(STOP, "000#810A"), (STOP + 0.5, "70A#00"), *network(0x7F, changed=STOP + 0.6)]),
    ],
)
def test_one_that_is_commanded_to_stop(known: list[Line], what: str, beside: list[Line]) -> None:
    assert "SRD003" not in roots(known, beside, pairs(0.5, STOP)), what


@pytest.mark.parametrize("known", [CONFIGURED, LEARNT])
@pytest.mark.parametrize("ahead", [0.0, 0.15])
def test_one_whose_node_is_lost_or_falls_back(known: list[Line], ahead: float) -> None:
    """It follows from the loss, or from the state, of its node."""
    lost = [*network(until=STOP), *pairs(0.5, STOP - ahead)]
    assert roots(known, lost) == ["HBT002"]
    fallen = [*network(0x7F), *pairs(0.5, STOP - ahead)]
    assert "SRD003" not in roots(known, fallen)


@pytest.mark.parametrize("known", [CONFIGURED, LEARNT])
@pytest.mark.parametrize("silence", [0.3, 1.5, 3.0])
def test_a_silence_of_the_whole_bus(known: list[Line], silence: float) -> None:
    """Of the bus, or of its recorder: nobody has stopped."""
    every = [*network(), *pairs(0.5, END)]
    heard = [one for one in [*known, *every] if not STOP < one[0] < STOP + silence]
    assert "SRD003" not in roots(heard)


def test_changes_are_no_period() -> None:
    """Pairs that come with each change show nothing of the time for which nothing changes."""
    busy = [row for burst in range(6) for row in pairs(0.5 + burst, 0.9 + burst, 0.01, constant=1)]
    assert problems(LEARNT, network(), busy) == []


@pytest.mark.parametrize("known", [CONFIGURED, LEARNT])
def test_two_of_one_node_are_two(known: list[Line]) -> None:
    """One that comes again does not end the problem of the other."""
    lines = [*known, *network(), *pairs(0.5, STOP), *pairs(STOP + 2, END)]
    other = [(at, frame.replace("115", "119").replace("116", "11A")) for at, frame in pairs(0.5, STOP, number=11)]
    found = problems(lines, other)
    assert sorted(found) == [("ended", "srdo-invalid"), ("open", "srdo-invalid")]
