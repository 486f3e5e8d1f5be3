"""Frames that the recording lacks, as other frames tell: a counter, a toggle bit, the next report of a state.

Why it exists: what the recording lacks is no fault of a sender; and a sender that miscounts, does not toggle, does not
answer or sends PDOs in a wrong state must be found beside it, over the same magnitudes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from captures import Analysis, CanFrame, analyze, log_text
from network import OPERATIONAL, PRE_OPERATIONAL, START, Follower, Network

NODE, OTHER = 5, 6


def codes(said: Analysis) -> set[str]:
    return {finding["code"] for finding in said.above_info()}


def judged(frames: Sequence[CanFrame]) -> Analysis:
    return analyze(log_text(frames))


# -- a counter of SYNC


def counting(overflow: int = 10) -> Network:
    """SYNC each 20 ms with two TPDOs behind it, heartbeats each 200 ms, and an object read each 30 ms."""
    net = Network().boot(NODE, OTHER)
    for number, node in enumerate((NODE, OTHER)):
        net.now = 0.05 + 0.013 * number
        net.live(node, period=0.2, seconds=6.0, states=[(0.0, PRE_OPERATIONAL), (0.1, OPERATIONAL)])
    net.now = 0.1
    net.nmt(START).wait(0.02)
    began = net.now
    for number in range(190):
        net.now = began + 0.006 + 0.03 * number + 0.004 * (number % 3)
        net.read(NODE if number % 2 else OTHER, 0x6041, 0, 0x237, 2)
    net.now = began
    followers = [
        Follower(0x180 + node, lambda cycle: bytes([cycle & 0xFF, 1]), delay=0.0004 + 0.0002 * number)
        for number, node in enumerate((NODE, OTHER))
    ]
    return net.sync(period=0.02, count=290, overflow=overflow, followers=followers)


def without_time(frames: Sequence[CanFrame], from_s: float, lasts_s: float) -> list[CanFrame]:
    first = frames[0].t_us
    return [frame for frame in frames if not from_s <= (frame.t_us - first) / 1e6 < from_s + lasts_s]


@pytest.mark.parametrize("overflow", [7, 10, 240])
@pytest.mark.parametrize("lasts", [0.06, 0.1, 0.19, 0.4, 1.5])
def test_a_counter_that_goes_on_by_the_time_is_a_hole(overflow: int, lasts: float) -> None:
    frames = counting(overflow).frames()
    assert not judged(frames).above_info()
    for from_s in (2.001, 2.127, 2.4105, 3.033):
        said = judged(without_time(frames, from_s, lasts))
        assert codes(said) <= {"CAP007", "CAP009"}, (from_s, said.complaint())


@pytest.mark.parametrize("lasts", [0.0, 0.06, 0.1])
@pytest.mark.parametrize("jump", [1, 2])
def test_a_counter_that_jumps_by_more_than_the_time_is_told(jump: int, lasts: float) -> None:
    """The producer miscounts once, in a silence of the recording or without one."""
    frames = without_time(counting().frames(), 2.127, lasts)
    first = frames[0].t_us

    def wrong(frame: CanFrame) -> CanFrame:
        if frame.can_id != 0x080 or frame.t_us - first < 2_127_000:
            return frame
        return replace(frame, data=bytes([(frame.data[0] - 1 + jump) % 10 + 1]))

    assert "SYN002" in codes(judged([wrong(frame) for frame in frames]))


@pytest.mark.parametrize("missing", [1, 2, 4])
def test_a_counter_that_jumps_while_others_are_heard_is_told(missing: int) -> None:
    """The producer counts what it does not send, and nobody answers it; the nodes are read all the time."""
    frames = counting().frames()
    syncs = [frame for frame in frames if frame.can_id == 0x080][100 : 100 + missing]
    gone = [(frame.t_us, frame.t_us + 2_000) for frame in syncs]
    left = [
        frame
        for frame in frames
        if not any(from_us <= frame.t_us < to_us and frame.can_id < 0x200 for from_us, to_us in gone)
    ]
    assert codes(judged(left)) & {"SYN002", "SYN003"}


# -- node guarding


def guarded(period: float, answers: Sequence[int | None], seen: Sequence[bool] | None = None) -> list[CanFrame]:
    """Requests each period; toggle bits of the answers, None: it does not answer. seen: which requests are there."""
    net = Network().boot(NODE).wait(0.05)
    for number, toggle in enumerate(answers):
        if seen is None or seen[number]:
            net.send(0x700 + NODE, after=number * period, remote=True)
            if toggle is not None:
                net.send(0x700 + NODE, bytes([PRE_OPERATIONAL | toggle << 7]), after=number * period + 0.0004)
    return net.frames()


PERIODS = [0.05, 0.2, 0.8, 2.0]
COUNT = 30
TOGGLES: list[int | None] = [number % 2 for number in range(COUNT)]


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("lost", [1, 2, 3])
@pytest.mark.parametrize("at", [8, 15, 24])
def test_lost_pairs_are_no_fault_of_the_node(period: float, lost: int, at: int) -> None:
    seen = [not at <= number < at + lost for number in range(COUNT)]
    said = judged(guarded(period, TOGGLES, seen))
    assert not said.above_info(), said.complaint()


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("at", [8, 15, 24])
def test_a_lost_answer_is_shown_by_the_next_toggle_bit(period: float, at: int) -> None:
    answers = [None if number == at else toggle for number, toggle in enumerate(TOGGLES)]
    said = judged(guarded(period, answers))
    assert not said.above_info(), said.complaint()


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("missed", [1, 2, 3, 10])
@pytest.mark.parametrize("at", [8, 15])
def test_a_node_that_does_not_answer_is_told(period: float, missed: int, at: int) -> None:
    """It toggles for each answer that it sends."""
    answers: list[int | None] = [
        None if at <= number < at + missed else (number - (missed if number >= at else 0)) % 2
        for number in range(COUNT)
    ]
    assert "GRD002" in codes(judged(guarded(period, answers)))


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("missed", [2, 3, 10])
def test_a_node_that_toggles_without_answering_is_told(period: float, missed: int) -> None:
    answers = [None if 8 <= number < 8 + missed else toggle for number, toggle in enumerate(TOGGLES)]
    assert "GRD002" in codes(judged(guarded(period, answers)))


@pytest.mark.parametrize("period", PERIODS)
def test_a_node_that_falls_silent_is_told_at_the_end(period: float) -> None:
    for last in (1, 2, 5):
        answers = [None if number >= COUNT - last else toggle for number, toggle in enumerate(TOGGLES)]
        frames = guarded(period, answers)
        frames.append(CanFrame("can0", 0x77F, b"\x05", frames[-1].t_us + 3_000_000))
        assert "GRD002" in codes(judged(frames)), last


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("same", [1, 3, 20])
def test_a_node_that_does_not_toggle_is_told(period: float, same: int) -> None:
    answers: list[int | None] = [
        0 if 8 <= number < 8 + same else (number - max(0, min(number - 8, same))) % 2 for number in range(COUNT)
    ]
    answers[7] = 0
    assert "GRD001" in codes(judged(guarded(period, answers)))


# -- a command


def started(period: float, *, pdo_after: float, states: Sequence[tuple[float, int]], start: float | None) -> Analysis:
    """Node 5 boots, reports its states, and sends a TPDO each 50 ms so long after 1 s; node 6 is started beside it."""
    net = Network().boot(OTHER, NODE)
    for node, those in ((NODE, states), (OTHER, [(0.0, PRE_OPERATIONAL), (1.0, OPERATIONAL)])):
        net.now = 0.02 + 0.003 * node
        net.live(node, period=period, seconds=6.0, states=those)
    net.now = 0.5
    net.read(NODE, 0x1000, 0, 0x192, 4).read(OTHER, 0x1000, 0, 0x192, 4)
    net.now = 1.0
    net.nmt(START, OTHER)
    if start is not None:
        net.now = start
        net.nmt(START, NODE)
    net.now = 1.0 + pdo_after
    net.cyclic(0x180 + NODE, period=0.05, payloads=[bytes([number, 7]) for number in range(80)])
    return judged(net.frames())


@pytest.mark.parametrize("period", [0.1, 0.2, 0.5, 1.0])
@pytest.mark.parametrize("pdo_after", [0.003, 0.02, 0.09])
def test_a_start_that_is_missing_is_no_fault_of_the_node(period: float, pdo_after: float) -> None:
    states = [(0.0, PRE_OPERATIONAL), (1.0, OPERATIONAL)]
    assert "PDO002" not in codes(started(period, pdo_after=pdo_after, states=states, start=None))


@pytest.mark.parametrize("period", [0.1, 0.2, 0.5, 1.0])
@pytest.mark.parametrize("pdo_after", [0.003, 0.02, 0.09])
def test_pdos_of_a_node_that_goes_on_reporting_pre_operational_are_told(period: float, pdo_after: float) -> None:
    states = [(0.0, PRE_OPERATIONAL)]
    assert "PDO002" in codes(started(period, pdo_after=pdo_after, states=states, start=None))


@pytest.mark.parametrize("period", [0.2, 0.5, 1.0])
def test_pdos_before_a_start_that_is_there_are_told(period: float) -> None:
    """The report after it says Operational, because of a command that came later than the PDOs."""
    states = [(0.0, PRE_OPERATIONAL), (1.145, OPERATIONAL)]
    said = started(period, pdo_after=0.003, states=states, start=1.14)
    reports = [1.0 <= 0.035 + number * period < 1.14 for number in range(20)]
    assert any(reports) or "PDO002" in codes(said), said.findings
