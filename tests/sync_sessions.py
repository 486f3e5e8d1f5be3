"""Clean sessions that run on SYNC, as a train of SYNCs, the PDOs that answer it, and everything else.

Why it exists: a fault of SYNC moves all that follows from it, and a capture in which the followers stay where they were
is no capture of that fault. What it must not do: contain a fault.
"""

from __future__ import annotations

import random
import struct
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

from captures import CanFrame
from clean_sessions import beside, recorded
from network import OPERATIONAL, START, Follower, Network, jittered
from network_sessions import SESSIONS
from plants import MASTERS, Session, as_made, built, counted

from canalyze import _core

SYNC = 0x080
SHORTEST = 16
"""Least number of SYNCs in a run that a fault is put into."""
SPREAD_US = 2500
"""Most difference between the delays of a PDO that answers SYNC."""
NO_ANSWERS = {"sync-counter": {0x187}, "plant": {0x186, 0x286}}
"""PDOs of an event timer whose period happens to be several of SYNC."""


@dataclass(frozen=True, slots=True)
class Answering:
    """A PDO that answers every n-th SYNC."""

    can_id: int
    every: int
    first: int
    """The number of the first SYNC of the run that it answers, from 0."""
    frames: tuple[CanFrame, ...]
    delays_us: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Tick:
    """A SYNC when it is due: whether it is sent, whether it is in the capture, and whether the nodes have it."""

    t_us: int
    data: bytes = b""
    sent: bool = True
    shown: bool = True
    heard: bool = True


@dataclass(frozen=True, slots=True)
class SyncRun:
    """A capture up to the end of a run of SYNCs without an NMT command in it."""

    name: str
    before: tuple[CanFrame, ...]
    """All frames before the run, and others in it that do not answer SYNC."""
    syncs: tuple[CanFrame, ...]
    answering: tuple[Answering, ...]
    end_us: int
    """The time of the last frame of the run."""
    own: frozenset[int]
    network: _core.Network | None
    knows_window_us: int | None
    """The window, where the capture or a description has it."""
    knows_types: bool
    """Whether the transmission types of the PDOs are in the capture or in a description."""

    @property
    def period_us(self) -> int:
        gaps = sorted(after.t_us - before.t_us for before, after in pairwise(self.syncs))
        return gaps[len(gaps) // 2]

    @property
    def overflow(self) -> int:
        """The highest value of the counter; 0: there is none."""
        return max((frame.data[0] for frame in self.syncs if frame.data), default=0)

    def ticks(self) -> list[Tick]:
        return [Tick(frame.t_us, frame.data) for frame in self.syncs]

    def frames(self, ticks: Sequence[Tick] | None = None) -> list[CanFrame]:
        """The capture with another train of SYNCs, and with what answers it."""
        made = list(self.before)
        trains = [tick for tick in ticks or self.ticks() if tick.t_us <= self.end_us]
        template = self.syncs[0]
        made += [replace(template, t_us=tick.t_us, data=tick.data) for tick in trains if tick.sent and tick.shown]
        heard = [tick for tick in trains if tick.sent and tick.heard]
        end_us = self.end_us
        for one in self.answering:
            due = heard[one.first :: one.every]
            for tick, frame, delay_us in zip(due, one.frames, one.delays_us, strict=False):
                made.append(replace(frame, t_us=tick.t_us + delay_us))
            if len(due) > len(one.frames):
                # More SYNCs than the session has answers for: it ends here.
                end_us = min(end_us, due[len(one.frames)].t_us - 1)
        end_us = min(end_us, trains[-1].t_us + self.period_us * 9 // 10)
        return sorted((frame for frame in made if frame.t_us <= end_us), key=lambda frame: frame.t_us)


def renumbered(ticks: Sequence[Tick], overflow: int) -> list[Tick]:
    """The same SYNCs with a counter that counts those that are sent."""
    if not overflow:
        return list(ticks)
    new, value = [], ticks[0].data[0]
    for tick in ticks:
        new.append(replace(tick, data=bytes([value])))
        value = value % overflow + 1 if tick.sent else value
    return new


def runs(
    name: str,
    session: Session,
    network: _core.Network | None = None,
    *,
    window_us: int | None = None,
    types: bool = True,
) -> Iterator[SyncRun]:
    """The runs of SYNCs of a session."""
    frames = session.frames
    borders = [at for at, frame in enumerate(frames) if _changes_all(frame)]
    for number, (first, last) in enumerate(zip([0, *borders], [*borders, len(frames)], strict=True)):
        syncs = tuple(frame for frame in frames[first:last] if frame.can_id == SYNC and not frame.extended)
        if len(syncs) < SHORTEST:
            continue
        apart = NO_ANSWERS.get(name.split()[0], set())
        answering = tuple(one for one in _answering(frames[first:last], syncs) if one.can_id not in apart)
        kept = {id(frame) for one in answering for frame in one.frames} | {id(frame) for frame in syncs}
        before = tuple(frame for frame in frames[:last] if id(frame) not in kept)
        end_us = frames[last - 1].t_us
        known = types and bool(answering)
        yield SyncRun(f"{name} {number}", before, syncs, answering, end_us, session.own, network, window_us, known)


def _changes_all(frame: CanFrame) -> bool:
    """Whether a frame is an NMT command, or writes a mapping: what comes after it is something else."""
    writes = 0x600 < frame.can_id < 0x680 and frame.data[:1] in (b"\x23", b"\x2f") and frame.data[2:3] == b"\x1a"
    return not frame.extended and (frame.can_id == 0 or writes)


def _answering(frames: Sequence[CanFrame], syncs: Sequence[CanFrame]) -> Iterator[Answering]:
    """The PDOs that answer each n-th SYNC with an even delay."""
    times = [frame.t_us for frame in syncs]
    period_us = (times[-1] - times[0]) // (len(times) - 1)
    for can_id in sorted({frame.can_id for frame in frames if 0x180 < frame.can_id < 0x580 and not frame.extended}):
        own = tuple(frame for frame in frames if frame.can_id == can_id and frame.t_us >= times[0])
        cycles = [bisect_right(times, frame.t_us) - 1 for frame in own]
        delays = tuple(frame.t_us - times[cycle] for frame, cycle in zip(own, cycles, strict=True))
        apart = {after - before for before, after in pairwise(cycles)}
        even = len(apart) == 1 and min(apart) > 0 and max(delays) - min(delays) < min(SPREAD_US, period_us // 3)
        if even and max(delays) < period_us * 6 // 10:
            yield Answering(can_id, apart.pop(), cycles[0], own, delays)


def on_sync(seed: int) -> Session:
    """A network that runs on SYNC: drives and inputs whose PDOs answer it, few heartbeats, now and then an SDO read."""
    chance = random.Random(seed)
    period = chance.choice((0.005, 0.005, 0.01, 0.01, 0.02, 0.05))
    nodes = sorted(chance.sample(range(2, 60), chance.randint(1, 4)))
    window = round(period * chance.choice((0.2, 0.4, 0.5)), 6)
    overflow = chance.choice((0, 0, 10, 60, 240))
    producer = nodes[0] if chance.random() < 0.3 else None
    net = Network().boot(*nodes)
    followers = []
    beats = chance.choice((0.1, 0.25, 1.0))
    slot = 0.0003
    for node in nodes:
        net.write(node, 0x1017, 0, round(beats * 1000), 2)
        net.write(node, 0x1006, 0, round(period * 1_000_000), 4).write(node, 0x1007, 0, round(window * 1_000_000), 4)
        if overflow:
            net.write(node, 0x1019, 0, overflow, 1)
        for number in range(1, chance.randint(1, 3) + 1):
            every = chance.choice((1, 1, 1, 2, 4))
            net.set_pdo(node, number, [(0x6041, 0, 16), (0x6064, 0, 32)], kind=every)
            data = _position(node * number)
            followers.append(Follower(0x180 + 0x100 * (number - 1) + node, data, slot, every=every))
            slot += chance.uniform(0.0001, 0.0003)
    if producer is not None:
        net.write(producer, 0x1005, 0, 0x4000_0080, 4)
    net.nmt(START)
    for node in nodes:
        net.live(node, period=beats, seconds=2.6 + 120 * period, states=[(0, OPERATIONAL)]).wait(0.0011)
    net.wait(chance.uniform(0.01, 0.03))
    since = net.now
    count = chance.randint(110, 160)
    net.sync(period=period, count=count, overflow=overflow, followers=followers)
    if chance.random() < 0.5:
        for number in range(int(count * period / 0.15)):
            net.now = since + 0.1 + number * 0.15 + chance.uniform(0, 0.02)
            net.read(chance.choice(nodes), 0x2001, 0, number, 2)
    until_us = net.frames()[0].t_us + round((since + count * period) * 1_000_000)
    frames = [frame for frame in net.frames() if frame.t_us < until_us]
    own = MASTERS - {SYNC} if producer is not None else MASTERS
    return as_made(jittered(frames, most_us=chance.choice((20, 60, 150)), seed=seed), own)


def _position(scale: int) -> Callable[[int], bytes]:
    return lambda cycle: struct.pack("<Hi", 0x0237, cycle * scale)


WINDOWS_US = {"sync-and-pdos": 6000, "synchronous": 2000, "synchronous_counted": 2000, "sync_alone": 2000}


@cache
def sync_runs(drawn: tuple[int, ...]) -> tuple[SyncRun, ...]:
    """Runs of every clean session with SYNC, and of networks drawn by these seeds."""
    found: list[SyncRun] = []
    for name, session in recorded().items():
        for network in beside(name)[-1:]:
            found += runs(name, session, network, window_us=WINDOWS_US.get(name))
    for name in ("sync_alone", "synchronous", "synchronous_counted"):
        found += runs(name, as_made(SESSIONS[name]().frames()), window_us=WINDOWS_US[name])
    for known in ("traffic", "written", "described"):
        told = known != "traffic"
        session = built("plant", known)
        window_us = 5000 if told else None
        found += runs(f"plant {known}", session, session.network, window_us=window_us, types=told)
    found += runs("counted", counted(), types=False)
    for seed in drawn:
        session = on_sync(seed)
        window_us = next(int.from_bytes(f.data[4:], "little") for f in session.frames if f.data[:3] == b"\x23\x07\x10")
        found += runs(f"on SYNC {seed}", session, window_us=window_us)
    return tuple(found)
