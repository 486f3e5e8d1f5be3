"""Heartbeats and guarding beside the other frames of a node: what is silent, what only answers late, what is not asked.

Over magnitudes, each beside what looks like it. Must not: test the words of a problem.
"""

from __future__ import annotations

import pytest
from captures import Row, log_text
from diagnoses import ABOVE_HARMLESS, diagnosed
from kinds_of_nodes import PERIOD
from network import START, Frames, Network

NODE, OTHER = 3, 4
BEAT, GUARD, LIFE = 0.5, 0.5, 1.5


def roots(frames: Frames) -> list[Row]:
    """Each root above harmless."""
    said = diagnosed(log_text(frames))
    return [one for one in said.incidents if not one["cause"] and one["status"] in ABOVE_HARMLESS]


def kinds(frames: Frames) -> list[tuple[str, str]]:
    return [(one["problem"], one["status"]) for one in roots(frames)]


def interrupted(away: float, nodes: tuple[int, ...] = (NODE,), *, pdos_go_on: bool = False) -> Frames:
    """Nodes with a heartbeat each 0.5 s and a TPDO each 0.1 s; some send nothing, or PDOs only, from 6 s on."""
    net = Network().boot(NODE, OTHER, 5)
    for node in (NODE, OTHER, 5):
        net.write(node, 0x1017, 0, round(BEAT * 1000), 2)
    begin = net.nmt(START).now
    for node in (NODE, OTHER, 5):
        net.now = begin + node * 0.003
        net.live(node, period=BEAT, seconds=14, states=((0, 5),))
        net.cyclic(0x180 + node, period=0.1, payloads=[bytes([at % 251, node]) for at in range(140)])
    gone = range(round((net.start + begin + 6) * 1e6), round((net.start + begin + 6 + away) * 1e6))
    kept = [0x180 + node for node in nodes] if pdos_go_on else []
    own = [base + node for node in nodes for base in (0x180, 0x700) if base + node not in kept]
    return [frame for frame in net.frames() if frame.t_us not in gone or frame.can_id not in own]


@pytest.mark.parametrize("away", [0.65, 0.8, 0.9, 1.2, 1.4, 2.0, 3.0])
def test_a_node_whose_frames_all_fail_is_silent(away: float) -> None:
    assert kinds(interrupted(away)) == [("node-silent", "ended")]
    ((one, status),) = kinds(interrupted(away, (NODE, OTHER)))
    assert (one, status) == ("segment-lost", "ended")


@pytest.mark.parametrize("later", [0.0, 0.13, 0.22, 0.35])
def test_a_segment_is_back_with_its_last_node(later: float) -> None:
    first, last = interrupted(0.9), interrupted(0.9 + later, (OTHER,))
    own = [base + NODE for base in (0x180, 0x700)]
    frames = [frame for frame in last if frame.can_id not in own] + [frame for frame in first if frame.can_id in own]
    frames.sort(key=lambda frame: frame.t_us)
    (one,) = roots(frames)
    lost = max(frame.t_us for frame in frames if frame.t_us < frames[0].t_us + 6_000_000)
    back = [next(at for at, f in enumerate(frames, 1) if f.t_us > lost and f.can_id & 0x7F == node) for node in (3, 4)]
    assert (one["problem"], one["status"], one["end"]["frame"]) == ("segment-lost", "ended", max(back))


@pytest.mark.parametrize("away", [0.65, 0.9, 1.2, 1.4, 2.0, 3.0])
def test_a_node_whose_other_frames_go_on_is_not_silent(away: float) -> None:
    assert not any(kind in ("node-silent", "segment-lost") for kind, _ in kinds(interrupted(away, pdos_go_on=True)))


def guarded(*nodes: int) -> Network:
    """Nodes that are guarded from the start, with a life time."""
    net = Network().boot(*nodes)
    for node in nodes:
        net.write(node, 0x100C, 0, round(GUARD * 1000), 2)
        net.write(node, 0x100D, 0, round(LIFE / GUARD), 1)
    return net.nmt(START)


def ended(by: tuple[int, int] | None, *, heartbeat: bool = False) -> Frames:
    """Guarding that ends after 4 s, behind a write of 0 to 100Ch or 100Dh or without one; heartbeats instead."""
    net = guarded(NODE, OTHER)
    begin = net.now
    for node in (NODE, OTHER):
        net.now = begin + node * 0.01
        net.guarding(node, period=GUARD, count=8, state=5)
    net.now = begin + 4.1
    for node in (NODE, OTHER):
        if by is not None:
            net.write(node, by[0], 0, 0, by[1])
        if heartbeat:
            net.write(node, 0x1017, 0, round(PERIOD * 1000), 2)
    net.now = begin + 4.2
    for node in (NODE, OTHER):
        if heartbeat:
            net.wait(0.005).live(node, period=PERIOD, seconds=8, states=((0, 5),))
        net.cyclic(0x180 + node, period=0.2, payloads=[bytes([at % 251, node]) for at in range(40)])
    return net.frames()


@pytest.mark.parametrize("by", [(0x100C, 2), (0x100D, 1)])
def test_guarding_that_is_switched_off_is_not_missed(by: tuple[int, int]) -> None:
    assert kinds(ended(by)) == []
    assert kinds(ended(by, heartbeat=True)) == []


def test_guarding_that_only_ends_is_missed() -> None:
    assert kinds(ended(None)) == [("guarding-stopped", "open")]


@pytest.mark.parametrize("times", [1, 2, 8])
def test_guarding_that_ends_behind_another_guard_time_is_missed(times: int) -> None:
    """The life time is longer from the write on; requests come as seldom then, or not at all."""

    def guard(count: int) -> Frames:
        net = guarded(NODE, OTHER)
        begin = net.now
        net.guarding(OTHER, period=GUARD, count=56, state=5).guarding(NODE, period=GUARD, count=8, state=5)
        net.now = begin + 3.8
        net.write(NODE, 0x100C, 0, round(GUARD * times * 1000), 2)
        net.now = begin + 3.5 + GUARD * times
        return net.guarding(NODE, period=GUARD * times, count=count, state=5).frames()

    assert kinds(guard(0)) == [("guarding-stopped", "open")]
    assert kinds(guard(int(23.9 / GUARD / times))) == []


def asked_in_vain(period: float, *, pdos: bool, heartbeat: bool) -> Frames:
    """Requests to a node that answers none, from the beginning on; it sends TPDOs, and perhaps heartbeats."""
    net = Network().boot(NODE, OTHER)
    if heartbeat:
        net.write(NODE, 0x1017, 0, round(PERIOD * 1000), 2)
    net.nmt(START)
    begin = net.now
    net.guarding(OTHER, period=period, count=round(10 / period), state=5)
    for number in range(round(10 / period)):
        net.send(0x700 + NODE, after=0.31 + number * period, remote=True)
    if heartbeat:
        net.live(NODE, period=PERIOD, seconds=10, states=((0, 5),))
    if pdos:
        net.now = begin + 0.01
        net.cyclic(0x180 + NODE, period=0.2, payloads=[bytes([at % 251, 1]) for at in range(50)])
    return net.frames()


@pytest.mark.parametrize("period", [0.2, 0.333, 0.5, 0.7, 1.0])
def test_a_heartbeat_is_no_answer_to_guarding(period: float) -> None:
    for pdos in (True, False):
        assert kinds(asked_in_vain(period, pdos=pdos, heartbeat=True)) == [("guarding-and-heartbeat", "open")]


@pytest.mark.parametrize("period", [0.333, 0.5, 1.0])
def test_a_node_that_sends_without_answering_is_not_off(period: float) -> None:
    (one,) = roots(asked_in_vain(period, pdos=True, heartbeat=False))
    assert (one["problem"], one["status"], one["checks"]) == ("guarding-unanswered", "open", ["remote-frames"])


def test_a_master_does_not_ask_a_node_that_is_gone() -> None:
    net = guarded(NODE, OTHER)
    begin = net.now
    net.guarding(NODE, period=GUARD, count=8, state=5)
    for number in range(8, 11):
        net.send(0x700 + NODE, after=number * GUARD, remote=True)
    net.now = begin + 0.01
    net.guarding(OTHER, period=GUARD, count=24, state=5)
    assert kinds(net.frames()) == [("guarding-unanswered", "open")]
