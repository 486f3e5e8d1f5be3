"""Nodes behind a hole of the recording: what it lost excuses nobody who is missing for long behind it."""

from __future__ import annotations

import pytest
from captures import analyze
from test_neighbouring_verdicts import Frames, beats, log


@pytest.mark.parametrize("hole", [0.05, 0.4, 2.0])
@pytest.mark.parametrize("dies", [-0.1, 0.0])
@pytest.mark.parametrize("period", [0.1, 0.5])
def test_a_node_that_is_not_there_behind_a_hole_of_the_recording(hole: float, dies: float, period: float) -> None:
    at, length = 6.0, 20.0
    others = [(place * 0.01, "186#0102") for place in range(int(length / 0.01))]
    others += [frame for node in (6, 7, 8) for frame in beats(node, 0.1, length, start=node / 1000)]

    def silent(node: Frames) -> bool:
        kept = [frame for frame in sorted(others + node) if not at <= frame[0] < at + hole]
        return any(one["code"] == "HBT002" and one["node"] == 5 for one in analyze(log(kept)).findings)

    before = beats(5, period, at + dies, start=0.0013)
    assert silent(before)
    # It comes again at once, or boots where frames are missing.
    assert not silent(before + beats(5, period, length, start=at + hole + 0.0013))
    assert not silent(before + beats(5, period, length, start=at + hole + 2.5))
