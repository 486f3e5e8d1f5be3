"""TPDOs of unknown transmission type that stop, sent with SYNC or by a timer. And those that may stop.

Each over cycles, over periods of the node's heartbeats, which come at another time behind the last TPDO each, and over
the number of frames before.
"""

from __future__ import annotations

import pytest
from diagnoses import diagnosed
from test_neighbouring_verdicts import Frames, beats, log, statuses

LENGTH = 12.0


def missing(*frames: Frames) -> list[str]:
    """The statuses of problems of PDOs that are missing."""
    return [status for kind, status in statuses(diagnosed(log(*frames))) if kind == "pdo-missing"]


def syncs(cycle: float) -> Frames:
    return [(place * cycle, "080#") for place in range(int(LENGTH / cycle))]


def tpdo(node: int, gap: float, count: int, start: float = 0.0, *, changes: bool) -> Frames:
    """Frames of TPDO1 at even times, but for a few 100 µs."""
    rows: Frames = []
    for place in range(count):
        data = place * 7919 % 65536 if changes else 0x1234
        rows.append((start + place * gap + place * 37 % 11 / 50_000, f"{0x180 + node:03X}#{data:04X}"))
    return rows


@pytest.mark.parametrize("cycle", [0.005, 0.02])
@pytest.mark.parametrize("heartbeat", [0.1, 0.45, 1.0, 3.0])
@pytest.mark.parametrize("count", [110, 150, 300])
@pytest.mark.parametrize("changes", [False, True])
def test_one_with_sync(cycle: float, heartbeat: float, count: int, changes: bool) -> None:
    others = (syncs(cycle), tpdo(6, cycle, int(LENGTH / cycle), 0.0012, changes=True))
    alive = (beats(5, heartbeat, LENGTH, start=0.003), beats(6, heartbeat, LENGTH, start=0.004))
    assert missing(*others, *alive, tpdo(5, cycle, count, 0.001, changes=changes)) == ["open"]
    # It comes again in time.
    again = tpdo(5, cycle, int(LENGTH / cycle) - count - 10, 0.001 + (count + 10) * cycle, changes=changes)
    assert not missing(*others, *alive, tpdo(5, cycle, count, 0.001, changes=changes), again)


@pytest.mark.parametrize(("gap", "heartbeat"), [(0.03, 0.2), (0.03, 0.5), (0.1, 0.2), (0.1, 0.5)])
def test_a_signal_that_rests(gap: float, heartbeat: float) -> None:
    """It is sampled while it changes, as a position is: its node goes on, and may have nothing to say."""
    others = (beats(1, 0.5, LENGTH), tpdo(6, gap, int(LENGTH / gap), changes=True))
    alive = beats(5, heartbeat, LENGTH, start=0.013)
    assert not missing(*others, alive, tpdo(5, gap, 60, changes=True))
    # A timer sends it, since it repeats what it has said.
    assert missing(*others, alive, tpdo(5, gap, 60, changes=False)) == ["open"]
    # Nothing comes of the node any more; its heartbeats are not missed at once.
    dead = [frame for frame in alive if frame[0] < 60 * gap]
    kinds = statuses(diagnosed(log(*others, dead, tpdo(5, gap, 60, changes=True))))
    assert any(status == "open" for _, status in kinds)


@pytest.mark.parametrize("away", [0.3, 1.5, 4.0])
@pytest.mark.parametrize("first", [0.0, 0.015])
def test_a_node_that_comes_back(away: float, first: float) -> None:
    """Its first frame may be a heartbeat. The problem is its absence, and not a missing TPDO."""
    back = 4.0 + away
    node = beats(5, 0.1, 4.0, start=0.003) + beats(5, 0.1, LENGTH, start=back)
    pdos = tpdo(5, 0.02, 200, 0.001, changes=True) + tpdo(
        5, 0.02, int((LENGTH - back) / 0.02), back + first, changes=True
    )
    others = (syncs(0.02), tpdo(6, 0.02, 600, 0.0012, changes=True), beats(6, 0.1, LENGTH))
    assert not missing(*others, node, pdos)
