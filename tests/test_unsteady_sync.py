"""A SYNC that becomes unsteady, up to drives that cannot follow, and stops: what is its cause, and what is still so.

Over periods and magnitudes; beside it drives with the same emergency where SYNC is steady.
"""

from __future__ import annotations

import random

import pytest
from diagnoses import Diagnosed, diagnosed
from test_neighbouring_verdicts import Frames, beats, log, statuses

LENGTH, FROM, STOP = 14.0, 6.0, 11.0


def capture(period: float, most: float, stop: float, emergency: bool) -> Diagnosed:
    """SYNC with jitter that grows from FROM on, to a part of the period, and ends at a time; two drives follow it."""
    chance, rows, at = random.Random(period), [], 0.01
    while at < stop:
        part = max(0.0, at - FROM) / (STOP - FROM) * most
        shifted = at + period * (0.002 + part) * chance.uniform(-1, 1)
        rows.append((shifted, "080#"))
        rows.extend((shifted + 0.0003 * node, f"{0x180 + node:03X}#3702{len(rows) % 256:02X}00") for node in (5, 6))
        at += period
    said: Frames = [(STOP - 0.5, "085#0087200000000000")] if emergency else []
    alive = [frame for node in (1, 5, 6) for frame in beats(node, 0.1, LENGTH, start=node / 1000)]
    return diagnosed(log(rows, said, alive))


def roots(capture: Diagnosed) -> set[tuple[str, str]]:
    return set(statuses(capture))


@pytest.mark.parametrize("period", [0.005, 0.01, 0.02])
@pytest.mark.parametrize("most", [0.4, 0.8])
def test_jitter_up_to_the_end_of_sync(period: float, most: float) -> None:
    found = roots(capture(period, most, STOP, emergency=True))
    assert ("sync-stopped", "open") in found
    assert not any(kind == "device-error" for kind, _ in found)


@pytest.mark.parametrize("period", [0.005, 0.01, 0.02])
def test_a_steady_sync_that_ends_and_one_that_goes_on(period: float) -> None:
    assert ("sync-stopped", "open") in roots(capture(period, 0.0, STOP, emergency=False))
    assert not roots(capture(period, 0.0, LENGTH, emergency=False))
    # The emergency is a problem of its own.
    assert [status for _, status in statuses(capture(period, 0.0, LENGTH, emergency=True))] == ["open"]
