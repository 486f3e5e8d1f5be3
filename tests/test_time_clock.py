"""The clock that TIME distributes (TIM002): it jumps, stands still, or runs at another rate; and sound clocks.

Each fault over magnitudes, beside what looks like it: a clock that drifts as quartzes do, one that counts seconds, a
producer that is late.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from captures import analyze
from test_neighbouring_verdicts import Frames, beats, log

DAY = (14_494).to_bytes(2, "little").hex()
FROM = 45_296_000
"""The first time of day, in ms."""
LENGTH = 120.0
"""Seconds of a capture."""


def about_the_clock(shown: Callable[[float], float], every: float, late: float = 0.0) -> list[int]:
    """The frames that the findings are about.

    shown: the producer's clock at a time, both in seconds; late: by how much at most.
    """
    rows: Frames = []
    for place in range(int(LENGTH / every)):
        at = place * every
        ms = FROM + round(shown(at) * 1000)
        rows.append((at + late * (place * 37 % 11) / 10, f"100#{ms.to_bytes(4, 'little').hex()}{DAY}"))
    said = analyze(log(rows, beats(5, 1.0, LENGTH, start=0.05))).findings
    return [one["about_frame"] for one in said if one["code"] == "TIM002"]


@pytest.mark.parametrize("every", [0.25, 1.0, 5.0])
@pytest.mark.parametrize("rate", [0.0, 0.5, 0.9, 0.96, 1.04, 1.1, 2.0])
def test_a_clock_that_stands_still_or_runs_at_another_rate(every: float, rate: float) -> None:
    assert about_the_clock(lambda at: at * rate, every)


@pytest.mark.parametrize("every", [0.25, 1.0, 5.0])
@pytest.mark.parametrize("since", [10.0, 60.0])
def test_a_clock_that_stops_is_told_from_there(every: float, since: float) -> None:
    first, *_ = about_the_clock(lambda at: min(at, since), every)
    # These TIMEs come before, and a heartbeat behind each second.
    assert first == round(since / every) + 1 + round(since)


@pytest.mark.parametrize("every", [0.25, 1.0, 5.0])
@pytest.mark.parametrize("rate", [0.992, 0.9999, 1.0, 1.0001, 1.008])
@pytest.mark.parametrize(("step", "late"), [(0.001, 0.0), (0.001, 0.2), (0.1, 0.2), (1.0, 0.0), (1.0, 0.01)])
def test_a_sound_clock(every: float, rate: float, step: float, late: float) -> None:
    assert not about_the_clock(lambda at: at * rate // step * step, every, late)


@pytest.mark.parametrize("by", [-3600.0, -5.0, 5.0, 3600.0])
def test_a_clock_that_is_set_is_told_once(by: float) -> None:
    assert len(about_the_clock(lambda at: at + by * (at > 50), 1.0)) == 1
