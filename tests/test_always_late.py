"""PDOs that are wrong each time: outside the synchronous window, or with another transmission type than configured.

Where the recording host sends the SYNC and lists its own frames late by chance, a PDO seems to come before its SYNC, so
that nothing is said of it. One that is late each time is reported once exchanges show that requests are listed in time.
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
    assert not late(session(window * beyond, window, 0))
    # A few tell by how much all own frames may be away from their place: less than by an answer's time.
    assert (late(session(window * beyond, window, 4)) > 0) == (window * (beyond - 1) > 0.00105)


@pytest.mark.parametrize("window", [0.001, 0.002, 0.004])
@pytest.mark.parametrize("part", [0.3, 0.8])
@pytest.mark.parametrize("listed", [0.0, 0.0012, 0.003])
def test_one_that_is_in_time(window: float, part: float, listed: float) -> None:
    assert not late(session(window * part, window, 20, listed))


@pytest.mark.parametrize(("written", "answers"), [(1, 2), (2, 4), (1, 6), (3, 6)])
def test_another_transmission_type_than_written_is_no_gap(written: int, answers: int) -> None:
    """Configured with its own type first, as of a device that takes the write and goes on as before."""
    configured = [(0.1, f"605#2F001802{written:02X}000000"), (0.101, "585#6000180200000000"), (0.2, "000#0100")]
    syncs: Frames = [(0.3 + place / 100, "080#") for place in range(300)]
    rates = [written] * 60 + [answers] * 240
    pdos: Frames = []
    cycle = 0
    while cycle < 300:
        pdos.append((0.301 + cycle / 100, f"185#{cycle % 251:02X}00"))
        cycle += rates[cycle]
    said = analyze(log(configured, syncs, pdos, beats(5, 0.1, 3.3, "05", 0.21)))
    found = {finding["code"] for finding in said.findings if finding["severity"] != "info"}
    # Beyond twice its type its first gaps are told before the third shows that they are no gaps.
    assert found - {"SYN008"} == {"PDO023"} and (answers > 2 or found == {"PDO023"}), said.complaint()


@pytest.mark.parametrize("times", [1, 2, 3, 6, 20])
@pytest.mark.parametrize("back", [False, True])
def test_a_tpdo_that_skips_syncs_for_a_while_is_told(times: int, back: bool) -> None:
    configured = [(0.1, "605#2F00180201000000"), (0.101, "585#6000180200000000"), (0.2, "000#0100")]
    cycles = [*range(60), *range(61, 61 + 2 * times, 2), *(range(61 + 2 * times, 61 + 2 * times + 60) if back else [])]
    syncs: Frames = [(0.3 + place / 100, "080#") for place in range(cycles[-1] + 1)]
    pdos: Frames = [(0.301 + cycle / 100, f"185#{cycle % 251:02X}00") for cycle in cycles]
    said = analyze(log(configured, syncs, pdos, beats(5, 0.1, 0.3 + cycles[-1] / 100, "05", 0.21)))
    assert {finding["code"] for finding in said.above_info()} & {"SYN008", "SYN010", "PDO023"}, said.findings
