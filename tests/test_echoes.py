"""Recordings that list what their host sends twice, the frame and its echo from the bus, and the frames of others once.

Why it exists: neither the copies of a whole bus nor a second sender explain such a recording, and nothing may be said
of the copies; what two senders do, or one that repeats itself, must not be taken for it, over distances and drifts.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest
from captures import Analysis, CanFrame, analyze, log_text
from network import OPERATIONAL, PRE_OPERATIONAL, START, Follower, Network
from sdo_wire import Channel, block_download

MASTER, NODE, OTHER = 1, 5, 6
APART_US = [(5, 20), (30, 200), (50, 100), (200, 400), (300, 440)]
"""The shortest and the longest time to the echo, in us."""
SEEDS = range(3)


def beside(net: Network, seconds: float) -> Network:
    """The heartbeats of all, the master's first."""
    started = net.now
    for number, node in enumerate((MASTER, NODE, OTHER)):
        net.now = started + 0.013 * number
        states = [(0.0, OPERATIONAL if node == MASTER else PRE_OPERATIONAL), (0.4 - 0.013 * number, OPERATIONAL)]
        net.live(node, period=0.1, seconds=seconds, states=states)
    net.now = started
    return net


def booted(seconds: float = 3.0) -> Network:
    """The master and two nodes boot, are read and started."""
    net = beside(Network().boot(MASTER, NODE, OTHER), seconds).wait(0.1)
    for node in (NODE, OTHER):
        for index, sub in ((0x1000, 0), (0x1018, 1), (0x1018, 2)):
            net.read(node, index, sub, 0x192 + sub, 4)
    return net.wait(0.3).nmt(START)


def polled() -> Network:
    net = booted()
    for number in range(40):
        net.wait(0.02).read(NODE if number % 2 else OTHER, 0x2000, 1, number // 4, 4)
    return net


def synchronous(overflow: int) -> Network:
    net = booted()
    net.wait(0.05)
    followers = [Follower(0x180 + node, lambda cycle: bytes([cycle & 0xFF, 7]), delay=0.0007) for node in (NODE, OTHER)]
    return net.sync(period=0.02, count=122, overflow=overflow, followers=followers)


def downloaded() -> Network:
    net = booted().wait(0.1)
    for frame in block_download(Channel(NODE), 0x2004, 0, bytes(range(200)), blksize=20):
        net.wait(0.0012).send(frame.can_id, frame.data)
    return net


def guarded() -> Network:
    net = Network().boot(MASTER, NODE, OTHER).wait(0.05)
    for node in (NODE, OTHER):
        net.wait(0.007).guarding(node, period=0.1, count=30)
    return net.wait(0.2)


NETWORKS: dict[str, Callable[[], Network]] = {
    "polled": polled,
    "sync": lambda: synchronous(0),
    "sync counter": lambda: synchronous(10),
    "block download": downloaded,
    "guarded": guarded,
}


def is_own(frame: CanFrame) -> bool:
    """True if the master sends it."""
    request = 0x600 < frame.can_id < 0x680 or frame.remote
    return request or frame.can_id in (0x000, 0x080, 0x701)


def echoed(
    frames: Sequence[CanFrame], apart_us: tuple[int, int], seed: int, own: Callable[[CanFrame], bool] = is_own
) -> list[CanFrame]:
    """The capture of a host that lists its own frames twice."""
    chance = random.Random(seed)
    copies = [replace(frame, t_us=frame.t_us + chance.randint(*apart_us)) for frame in frames if own(frame)]
    return sorted([*frames, *copies], key=lambda frame: frame.t_us)


def codes(said: Analysis) -> set[str]:
    return {finding["code"] for finding in said.above_info()}


@pytest.mark.parametrize("apart_us", APART_US)
@pytest.mark.parametrize("name", NETWORKS)
def test_nothing_is_said_of_an_echo(name: str, apart_us: tuple[int, int]) -> None:
    frames = NETWORKS[name]().frames()
    once = analyze(log_text(frames))
    assert not once.above_info(), once.complaint()
    for seed in SEEDS:
        said = analyze(log_text(echoed(frames, apart_us, seed)))
        assert not said.above_info(), said.complaint()
        assert len(said.transfers) == len(once.transfers)


@pytest.mark.parametrize("cut", [40, 200, 333])
@pytest.mark.parametrize("name", NETWORKS)
def test_nothing_is_said_of_an_excerpt(name: str, cut: int) -> None:
    frames = echoed(NETWORKS[name]().frames(), (30, 200), 1)
    said = analyze(log_text(frames[min(cut, len(frames) // 2) :]))
    assert not said.above_info(), said.complaint()


@pytest.mark.parametrize("apart_us", [(50, 60), (100, 100), (200, 300), (420, 440)])
@pytest.mark.parametrize("overflow", [0, 10])
def test_a_sync_that_alone_is_listed_twice_has_one_producer(overflow: int, apart_us: tuple[int, int]) -> None:
    frames = synchronous(overflow).frames()
    said = analyze(log_text(echoed(frames, apart_us, 2, lambda frame: frame.can_id == 0x080)))
    assert not said.above_info(), said.complaint()


def also(frames: Sequence[CanFrame], *added: tuple[float, int, bytes]) -> list[CanFrame]:
    """The capture with the frames of another sender, at these seconds."""
    first = frames[0].t_us
    others = [CanFrame("can0", can_id, data, first + round(at * 1e6)) for at, can_id, data in added]
    return sorted([*frames, *others], key=lambda frame: frame.t_us)


@pytest.mark.parametrize("echo", [False, True])
@pytest.mark.parametrize("behind", [0.0001, 0.0004, 0.003])
def test_two_producers_that_count_are_two(behind: float, echo: bool) -> None:
    """The second one begins after 40 SYNCs of the first."""
    frames = synchronous(10).frames()
    syncs = [frame.t_us for frame in frames if frame.can_id == 0x080]
    began = (syncs[0] - frames[0].t_us) / 1e6
    second = [(began + behind + 0.02 * n, 0x080, bytes([(n + 6) % 10 + 1])) for n in range(40, len(syncs))]
    both = also(echoed(frames, (30, 60), 1) if echo else frames, *second)
    assert "SYN006" in codes(analyze(log_text(both)))


@pytest.mark.parametrize("ppm", [300, 1_000])
def test_two_producers_drift_apart(ppm: int) -> None:
    """They begin within the time of an echo, and are found once they are apart."""
    net = booted(20.0).wait(0.05).sync(period=0.02, count=950)
    began = net.now
    second = [(began + 0.0001 + 0.02 * (1 + ppm / 1e6) * n, 0x080, b"") for n in range(950)]
    assert codes(analyze(log_text(also(net.frames(), *second)))) & {"SYN006", "SYN003"}


@pytest.mark.parametrize("echo", [False, True])
@pytest.mark.parametrize("ppm", [200, 2_000])
@pytest.mark.parametrize("apart", [0.000_093, 0.000_4])
def test_two_nodes_with_one_node_id_are_two(apart: float, ppm: int, echo: bool) -> None:
    """Both boot at one time; their heartbeats drift apart."""
    net = booted(8.0)
    booting = next(frame for frame in net.frames() if frame.can_id == 0x700 + NODE)
    at = (booting.t_us - net.frames()[0].t_us) / 1e6
    beats = [frame for frame in net.frames() if frame.can_id == 0x700 + NODE][1:]
    first = net.frames()[0].t_us
    drifting = [
        ((beat.t_us - first) / 1e6 + apart + n * 0.1 * ppm / 1e6, beat.can_id, beat.data)
        for n, beat in enumerate(beats)
    ]
    frames = echoed(net.frames(), (30, 200), 1) if echo else net.frames()
    said = analyze(log_text(also(frames, (at + apart, 0x700 + NODE, b"\0"), *drifting)))
    assert codes(said) & {"HBT004", "HBT001"}, said.findings


@pytest.mark.parametrize("apart", [0.000_1, 0.000_4])
def test_two_boot_ups_of_nodes_with_one_node_id_are_two(apart: float) -> None:
    """The second one boots and is never heard again."""
    net = booted()
    booting = next(frame for frame in net.frames() if frame.can_id == 0x700 + NODE)
    at = (booting.t_us - net.frames()[0].t_us) / 1e6
    said = analyze(log_text(also(net.frames(), (at + apart, 0x700 + NODE, b"\0"))))
    assert "HBT004" in codes(said), said.findings


@pytest.mark.parametrize("apart", [0.000_1, 0.000_4])
def test_requests_that_are_answered_twice_were_sent_twice(apart: float) -> None:
    frames = polled().frames()
    first = frames[0].t_us
    again = [
        ((frame.t_us - first) / 1e6 + apart, frame.can_id, frame.data)
        for frame in frames
        if frame.can_id in (0x600 + NODE, 0x580 + NODE)
    ]
    once, twice = analyze(log_text(frames)), analyze(log_text(also(frames, *again)))
    assert len(twice.transfers) == len(once.transfers) * 3 // 2


@pytest.mark.parametrize("apart", [0.000_1, 0.000_3, 0.001])
def test_a_flood_of_equal_frames_is_one(apart: float) -> None:
    net = polled()
    first = net.frames()[0].t_us
    began = (net.frames()[-1].t_us - first) / 1e6 / 2
    flood = [(began + n * apart, 0x180 + NODE, b"\1\2") for n in range(2000)]
    before = analyze(log_text(net.frames()))
    said = analyze(log_text(also(net.frames(), *flood)))
    assert len(said.frames) == len(before.frames) + 2000


@pytest.mark.parametrize("gap_us", [100, 150])
def test_an_adapter_that_is_read_now_and_then_lists_no_echo(gap_us: int) -> None:
    """Two cycles at a time, in a row: each SYNC was sent, and each is answered by a PDO that does not change."""
    net = booted(0.1).wait(0.5)
    for batch in range(200):
        for number, can_id in enumerate((0x080, 0x180 + NODE, 0x080, 0x180 + NODE)):
            data = b"" if can_id == 0x080 else b"\1\2"
            net.send(can_id, data, after=0.016 * batch + number * gap_us / 1e6)
    assert "SYN006" not in codes(analyze(log_text(net.frames())))
