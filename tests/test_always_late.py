"""PDOs that are outside the synchronous window each time, in a recording of the host that sends the SYNC.

Where such a host lists its own frames late by chance, a PDO seems to come before its SYNC, and nothing is said of it.
One that is late each time is told as soon as exchanges show that requests are listed in time.
"""

from __future__ import annotations

import pytest
from captures import analyze
from test_neighbouring_verdicts import Frames, beats, log


def session(delay: float, window: float, exchanges: int, listed: float = 0.0) -> bytes:
    """SYNC every 10 ms, a TPDO after each, and reads before. listed: by how much own frames are listed late."""
    reads = [(0.1 + place / 100 + listed, "605#4000100000000000") for place in range(exchanges)]
    answers = [(0.101 + place / 100, "585#4300100092010000") for place in range(exchanges)]
    configured = [
        *((1.0 + listed, "605#2306100010270000"), (1.001, "585#6006100000000000")),
        *((1.01 + listed, f"605#23071000{round(window * 1e6).to_bytes(4, 'little').hex().upper()}"),),
        *((1.011, "585#6007100000000000"), (1.02 + listed, "605#2F00180201000000"), (1.021, "585#6000180200000000")),
        (1.05 + listed, "000#0100"),
    ]
    syncs: Frames = [(1.1 + place / 100 + listed, "080#") for place in range(200)]
    uneven = [place * 37 % 11 / 1e5 for place in range(200)]
    pdos = [(1.1 + place / 100 + delay + uneven[place], f"185#{place:02X}00") for place in range(200)]
    return log(reads, answers, configured, syncs, pdos, beats(5, 0.1, 3.1, "05", 1.06))


def late(log: bytes) -> int:
    return sum(finding["code"] == "SYN004" for finding in analyze(log).findings)


@pytest.mark.parametrize("window", [0.001, 0.002, 0.004])
@pytest.mark.parametrize("beyond", [1.3, 1.6, 1.9])
def test_one_that_is_late_each_time(window: float, beyond: float) -> None:
    assert late(session(window * beyond, window, 20)) > 0
    # Requests that are listed behind their answers, or too few of them.
    assert not late(session(window * beyond, window, 20, listed=0.0012))
    assert not late(session(window * beyond, window, 4))


@pytest.mark.parametrize("window", [0.001, 0.002, 0.004])
@pytest.mark.parametrize("part", [0.3, 0.8])
@pytest.mark.parametrize("listed", [0.0, 0.0012, 0.003])
def test_one_that_is_in_time(window: float, part: float, listed: float) -> None:
    assert not late(session(window * part, window, 20, listed))
