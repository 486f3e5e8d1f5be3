"""Changes of when a node is heard: late, slow or missing heartbeats, boot-ups, nodes that do not come back.

Why it exists: these faults are gaps in what a node sends by itself, and a gap says nothing where the node was reset or
the recorder stood still. What it must not do: know codes; `test_changes.py` does.
"""

from __future__ import annotations

import struct
from dataclasses import replace
from random import Random

from faulty_captures import Faulty
from traffic import MS, RESETS, Traffic, chosen

LEAST_LATE_US = 25 * MS
"""A heartbeat late by less may be so on any host."""


# Heartbeats


def heartbeat_gap(traffic: Traffic, rng: Random, periods: float) -> Faulty | None:
    """So many periods between two heartbeats, anywhere between two of an even series."""
    found = []
    for node, period in traffic.producers.items():
        even = traffic.even_gaps(node)
        found += [(node, period, before) for before, _ in even if room_for_gap(traffic, node, before, period, periods)]
    drawn = chosen(rng, found)
    return None if drawn is None else gap_from(traffic, drawn[0], drawn[2], drawn[1], periods)


def room_for_gap(traffic: Traffic, node: int, before: int, period: int, periods: float) -> bool:
    """True if a gap from a heartbeat on is in one boot, and the capture goes on long enough to show it."""
    until = before + round((periods + 0.2) * period)
    goes_on = until < traffic.heartbeats(node)[-1] + period // 4
    booted = any(before <= at <= until and of == node for at, of in traffic.boots)
    reset = any(before <= at <= until and to in (0, node) and cs in RESETS for at, cs, to in traffic.commands)
    late = (periods - 1) * period > LEAST_LATE_US
    return goes_on and not booted and not reset and late and traffic.heard(before, until, node)


def gap_from(traffic: Traffic, node: int, since: int, period: int, periods: float) -> Faulty:
    """No heartbeat of a node for so many periods; a part of one delays the next."""
    whole, part = int(periods), periods % 1
    can_id, until = 0x700 + node, since + (whole - 0.5) * period
    kept = traffic.without(lambda f: f.can_id == can_id and not f.remote and since < f.t_us < until)
    if part:
        late = next(f for f in kept if f.can_id == can_id and f.t_us > since)
        kept[kept.index(late)] = replace(late, t_us=late.t_us + round(part * period))
    return traffic.faulty(kept, since, since + round((periods + 1.6) * period))


def first_gap(traffic: Traffic, rng: Random, periods: float) -> Faulty | None:
    """The first heartbeats missing after a write of 1017h that begins them."""
    found = []
    for request, answer, node in traffic.exchanges:
        asked = traffic.frames[request]
        if asked.data[:4] != b"\x2b\x17\x10\x00" or node not in traffic.producers:
            continue
        period, at = struct.unpack_from("<H", asked.data, 4)[0] * MS, traffic.frames[answer].t_us
        beats = [beat for beat in traffic.heartbeats(node) if beat > at]
        soon = bool(beats) and beats[0] - at < 1.2 * period
        if soon and period and room_for_gap(traffic, node, at, period, periods):
            found.append((node, period, at))
    drawn = chosen(rng, found)
    if drawn is None or (periods - 1) * drawn[1] < LEAST_LATE_US:
        return None
    return silent_from(traffic, drawn[0], drawn[2], drawn[1], periods)


def silent_from(traffic: Traffic, node: int, at: int, period: int, periods: float) -> Faulty:
    """No heartbeat of a node for so many periods after a time."""
    until = at + (periods - 0.05) * period
    kept = traffic.without(lambda f: f.can_id == 0x700 + node and f.data != b"\0" and at < f.t_us < until)
    return traffic.faulty(kept, at - 1, at + round((periods + 2.6) * period))


def slowed(traffic: Traffic, node: int, since: int, origin: int, ratio: float, first: int) -> Faulty:
    """Heartbeats after a time as far from an origin as the ratio says, in the state of that time."""
    can_id, kept, states = 0x700 + node, [], []
    for frame in traffic.frames:
        beat = frame.can_id == can_id and not frame.remote and frame.data != b"\0"
        states += [(frame.t_us, frame.data)] if beat else []
        if beat and frame.t_us > since:
            at = origin + round((frame.t_us - origin) * ratio)
            if at < traffic.end_us:
                kept.append(replace(frame, t_us=at))
        else:
            kept.append(frame)
    changed = [
        replace(frame, data=[data for at, data in states if at <= frame.t_us][-1])
        if frame.can_id == can_id and frame.t_us > since and not frame.remote
        else frame
        for frame in kept
    ]
    return traffic.faulty(changed, first, traffic.end_us)


def slower_than_written(traffic: Traffic, rng: Random, ratio: float) -> Faulty | None:
    """All heartbeats of a node so many times slower than the 1017h that was written."""
    found = []
    for request, answer, node in traffic.exchanges:
        asked = traffic.frames[request]
        if asked.data[:4] != b"\x2b\x17\x10\x00" or node not in traffic.producers:
            continue
        period, at = struct.unpack_from("<H", asked.data, 4)[0] * MS, traffic.frames[answer].t_us
        again = any(of == node and when > at for when, of in traffic.boots)
        before = [beat for beat in traffic.heartbeats(node) if beat < at]
        if period and not again and not before and traffic.end_us - at > 9 * ratio * period:
            found.append((node, period, at))
    drawn = chosen(rng, found)
    if drawn is None or (ratio - 1) * drawn[1] < LEAST_LATE_US:
        return None
    node, _, at = drawn
    return slowed(traffic, node, at, at, ratio, at - 5 * MS)


def lost(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """A node that falls silent for ever; it is not asked any more, nor commanded."""
    found = []
    for node, period in traffic.producers.items():
        found += [
            (node, period, before)
            for before, _ in traffic.even_gaps(node)
            if traffic.end_us - before > 5 * period and not traffic.commanded(node, before, traffic.end_us)
            if traffic.heard(before, before + 5 * period, node)
        ]
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, _, since = drawn
    own = {*traffic.of_node(node), 0x600 + node}
    kept = traffic.without(lambda f: f.can_id in own and f.t_us > since)
    return traffic.faulty(kept, since, traffic.end_us)


# Boot-ups and resets


def boots_after_reset(traffic: Traffic) -> list[tuple[int, int, int]]:
    """Node, reset, and boot-up of nodes whose heartbeats were seen before the one and after the other."""
    found = []
    for at, cs, to in traffic.commands:
        if cs not in RESETS:
            continue
        for node in [to] if to else traffic.nodes:
            boot = next((when for when, of in traffic.boots if of == node and when > at), None)
            again = [w for w, c, t in traffic.commands if w > at and c in RESETS and t in (0, node)]
            before = [beat for beat in traffic.heartbeats(node) if beat < at]
            if boot is not None and not again and len(before) >= 5 and node not in traffic.guarded:
                found.append((node, at, boot))
    return found


def mute_after_reset(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """A node that boots after a reset, and then never sends its heartbeat, although it did before."""
    found = [
        row
        for row in boots_after_reset(traffic)
        if row[0] in traffic.producers and traffic.end_us - row[2] > 5 * traffic.producers[row[0]]
    ]
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, reset, boot = drawn
    kept = traffic.without(lambda f: f.can_id in traffic.of_node(node) and f.t_us > boot and f.can_id < 0x580)
    kept = [f for f in kept if f.can_id != 0x700 + node or f.t_us <= boot]
    return traffic.faulty(kept, reset, traffic.end_us)


def never_back(traffic: Traffic, rng: Random, asked: float) -> Faulty | None:
    """A node that never comes back after a reset; asked: its client goes on asking."""
    found = [row for row in boots_after_reset(traffic) if traffic.end_us - row[1] > 1200 * MS]
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, reset, _ = drawn
    own = {*traffic.of_node(node), *([] if asked else [0x600 + node])}
    kept = traffic.without(lambda f: f.can_id in own and f.t_us > reset + MS)
    return traffic.faulty(kept, reset, traffic.end_us)


def boot_up_twice(traffic: Traffic, rng: Random, milliseconds: float) -> Faulty | None:
    """A second boot-up so long after one."""
    found = []
    for at, node in traffic.boots:
        second = at + round(milliseconds * MS)
        later = [f.t_us for f in traffic.frames if f.can_id & 0x7F == node and 0x580 < f.can_id < 0x780 and f.t_us > at]
        commands = [f.t_us for f in traffic.frames if f.can_id in (0, 0x7E4, 0x7E5) and f.t_us > at - MS]
        asked = [f.t_us for f in traffic.frames if f.can_id == 0x600 + node and at < f.t_us < second]
        answered = [f.t_us for f in traffic.frames if f.can_id == 0x580 + node and at < f.t_us < second]
        heard = traffic.frames[-1].t_us > second + 60 * MS
        if second < min([*commands, traffic.end_us]) and len(asked) == len(answered) and heard and later:
            found.append((at, node))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    at, node = drawn
    second = at + round(milliseconds * MS)
    # What it sent between is kept: a node may be asked before it restarts.
    added = [*traffic.frames, traffic.frame(0x700 + node, b"\0", second)]
    return traffic.faulty(added, at, second)
