"""Changes that harm no session: jitter, a scan, a read again, a node that is powered on late.

Why it exists: a rule that finds every fault may do so by finding too much. Each of these looks like a fault that the
files `changes_of_*.py` hold, and is none. What it must not do: make a change that a standard forbids.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from random import Random

from changes_of_nodes import gap_from
from faulty_captures import Faulty
from network import PRE_OPERATIONAL, STOP
from traffic import MS, RESETS, STATES, Traffic, chosen


def jittered_heartbeats(traffic: Traffic, rng: Random, part: float) -> Faulty | None:
    """Every heartbeat earlier or later by up to a part of its period."""
    if not traffic.producers:
        return None
    frames = []
    for frame in traffic.frames:
        period = traffic.producers.get(frame.can_id - 0x700, 0)
        off = round(rng.uniform(-part, part) * period) if frame.data != b"\0" else 0
        near = [at for at, _, _ in traffic.commands if abs(at - frame.t_us) < part * period + MS]
        frames.append(replace(frame, t_us=frame.t_us + off) if off and not near else frame)
    return traffic.faulty(frames, 0, 0)


def late_once(traffic: Traffic, rng: Random, periods: float) -> Faulty | None:
    """One heartbeat a little late."""
    found = []
    for node, period in traffic.producers.items():
        found += [(node, period, before) for before, after in traffic.even_gaps(node) if after < traffic.end_us]
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, period, before = drawn
    until = before + round((periods + 0.1) * period)
    if traffic.commanded(node, before, until):
        return None
    return gap_from(traffic, node, before, period, periods)


def scan(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """A master that looks for all nodes, of which most are absent."""
    if traffic.end_us - traffic.start_us < 2_000 * MS:
        return None
    first = rng.randrange(traffic.start_us, traffic.end_us - 1600 * MS)
    absent = [node for node in range(1, 128) if node not in traffic.nodes and node & 0x7F not in traffic.in_transfers]
    absent = [node for node in absent if not any(f.can_id & 0x7F == node for f in traffic.frames if f.can_id < 0x780)]
    asked = [
        traffic.frame(0x600 + node, b"\x40\0\x10\0\0\0\0\0", first + number * 12 * MS)
        for number, node in enumerate(absent)
    ]
    return traffic.faulty([*traffic.frames, *asked], 0, 0)


def read_again(traffic: Traffic, rng: Random, milliseconds: float) -> Faulty | None:
    """The same read much later, answered as before."""
    later, found = round(milliseconds * MS), []
    for asked, answered, node in traffic.exchanges:
        at = traffic.frames[asked].t_us + later
        stopped = [cs for w, cs, to in traffic.commands if w < at and to in (0, node)][-1:] == [STOP]
        reset = any(
            at - 2_000 * MS < w < at + 50 * MS and to in (0, node) and cs in RESETS for w, cs, to in traffic.commands
        )
        if traffic.frames[asked].data[0] == 0x40 and traffic.quiet_of(node, at) and at < traffic.end_us - 5 * MS:
            found += [] if stopped or reset else [(asked, answered)]
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    again = [replace(traffic.frames[place], t_us=traffic.frames[place].t_us + later) for place in drawn]
    return traffic.faulty([*traffic.frames, *again], 0, 0)


def command_again(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """An NMT command for the state that a node is in."""
    found = []
    for node in traffic.producers:
        shown = [(f.t_us, f.data[0]) for f in traffic.frames if f.can_id == 0x700 + node and f.data]
        for (at, state), (after, following) in pairwise(shown):
            command = {state: cs for cs, state in STATES.items()}.get(state)
            if command and state == following and not traffic.commanded(node, at - 200 * MS, after):
                found.append((node, command, at, after))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, command, at, after = drawn
    added = traffic.frame(0, bytes([command, node]), rng.randrange(at + 1, after))
    return traffic.faulty([*traffic.frames, added], 0, 0)


def powered_on_late(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """Another node that boots somewhere in the capture, and sends heartbeats from then on."""
    node = rng.choice([node for node in range(20, 127) if not any(f.can_id & 0x7F == node for f in traffic.frames)])
    at = rng.randrange(traffic.start_us, traffic.end_us)
    period = rng.choice((100, 250, 500)) * MS
    beats = range(at + period, traffic.end_us, period)
    state = PRE_OPERATIONAL
    commands = [(w, STATES.get(cs)) for w, cs, to in traffic.commands if to == 0 and w > at]
    if any(new is None for _, new in commands):
        return None
    added = [traffic.frame(0x700 + node, b"\0", at)]
    for beat in beats:
        now = [new for w, new in commands if w < beat - 3 * MS and new is not None]
        added.append(traffic.frame(0x700 + node, bytes([now[-1] if now else state]), beat))
    return traffic.faulty([*traffic.frames, *added], 0, 0)
