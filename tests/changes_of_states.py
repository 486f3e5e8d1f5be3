"""Changes that contradict a node's NMT state: commands that it ignores, PDOs that it sends while not Operational.

Why it exists: a state is known by commands, boot-ups and heartbeats together, and these faults need a time in which it
is certain. What it must not do: know codes; `test_changes.py` does.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import replace
from itertools import pairwise
from random import Random
from statistics import median

from faulty_captures import Faulty
from network import OPERATIONAL, PRE_OPERATIONAL, START, STOPPED
from traffic import MS, STATES, Frames, Traffic, chosen


def ignored(traffic: Traffic, rng: Random, count: float) -> Faulty | None:
    """A node that ignores a command for so many heartbeats: they go on in its former state."""
    found = []
    for at, cs, to in traffic.commands:
        if cs not in STATES:
            continue
        for node, period in traffic.producers.items():
            if to not in (0, node):
                continue
            shown = [(f.t_us, f.data[0] & 0x7F) for f in traffic.frames if f.can_id == 0x700 + node and f.data]
            before = [state for when, state in shown if when < at]
            after = [(when, state) for when, state in shown if when > at]
            wanted = STATES[cs]
            same = len(after) >= count and all(state == wanted for _, state in after[: int(count)])
            until = after[int(count) - 1][0] if same else 0
            other = [w for w, c, t in traffic.commands if at < w <= until + period and t in (0, node)]
            if before and before[-1] not in (wanted, 0) and same and not other and after[0][0] - at < 1.2 * period:
                found.append((node, at, before[-1], until, wanted))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, at, state, until, wanted = drawn
    frames = []
    for frame in traffic.frames:
        own = frame.can_id & 0x7F == node and at < frame.t_us <= until
        if own and frame.can_id == 0x700 + node:
            frame = replace(frame, data=bytes([state]))
        elif own and frame.can_id in traffic.tpdos(node) and wanted == OPERATIONAL:
            continue
        frames.append(frame)
    if state == OPERATIONAL:
        for can_id in traffic.tpdos(node):
            frames += continued(traffic, can_id, at, until + MS)
    return traffic.faulty(frames, at, until + MS)


def continued(traffic: Traffic, can_id: int, at: int, until: int) -> Frames:
    """Frames of a TPDO that goes on after a time as before."""
    own = [frame for frame in traffic.frames if frame.can_id == can_id and frame.t_us < at]
    if len(own) < 4:
        return []
    syncs = traffic.times.get(0x080, [])
    behind = [
        frame.t_us - syncs[bisect_right(syncs, frame.t_us) - 1] for frame in own if syncs and syncs[0] < frame.t_us
    ]
    if len(behind) == len(own) and max(behind) < 5 * MS:
        per = max(1, round(len([sync for sync in syncs if own[0].t_us < sync < at]) / (len(own) - 1)))
        due = [sync + round(median(behind)) for sync in syncs if own[-1].t_us < sync < until][per - 1 :: per]
    else:
        gap = round(median(after.t_us - before.t_us for before, after in pairwise(own)))
        due = list(range(own[-1].t_us + gap, until, gap))
    return [replace(own[-1], t_us=when) for when in due if at < when < until]


def pdo_not_operational(traffic: Traffic, rng: Random, count: float) -> Faulty | None:
    """So many TPDOs of a node that two heartbeats, or a command, show in another state than Operational."""
    found = []
    for node in traffic.nodes:
        shown = [
            (f.t_us, STATES.get(f.data[0], 0), 2) for f in traffic.frames if f.can_id == 0 and f.data[1] in (0, node)
        ]
        own = [f for f in traffic.frames if f.can_id == 0x700 + node and len(f.data) == 1]
        shown += [(f.t_us, f.data[0] & 0x7F, 1) for f in own]
        seen = 0
        for (at, state, weight), (until, *_) in pairwise([*sorted(shown), (traffic.end_us, 0, 0)]):
            seen = seen + weight if state in (PRE_OPERATIONAL, STOPPED) else 0
            if seen >= 2 and until - at > 40 * MS:
                found += [(can_id, at + 15 * MS, until - 15 * MS) for can_id in traffic.tpdos(node)]
    return placed_pdos(traffic, rng, found, count)


def pdo_after_boot_up(traffic: Traffic, rng: Random, count: float) -> Faulty | None:
    """So many TPDOs after a boot-up and before the command that starts the node, which shows no state between."""
    found = []
    for at, node in traffic.boots:
        if node in traffic.producers or node in traffic.guarded:
            continue
        start = next((w for w, cs, to in traffic.commands if w > at and cs == START and to in (0, node)), None)
        other = any(at < w < (start or 0) and to in (0, node) for w, _, to in traffic.commands)
        before = any(at < w < (start or 0) for can_id in traffic.tpdos(node) for w in traffic.times[can_id])
        if start is not None and not other and not before and start - at > 40 * MS:
            found += [(can_id, at + 15 * MS, start - 15 * MS) for can_id in traffic.tpdos(node)]
    return placed_pdos(traffic, rng, found, count)


def placed_pdos(traffic: Traffic, rng: Random, found: list[tuple[int, int, int]], count: float) -> Faulty | None:
    """Frames of a PDO as it was sent before or is after, 60 ms apart, behind a SYNC where there are any."""
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    can_id, since, until = drawn
    own = [frame for frame in traffic.frames if frame.can_id == can_id and not frame.remote]
    if len({len(frame.data) for frame in own}) != 1:
        return None
    times: list[int] = []
    syncs, at = traffic.times.get(0x080, []), rng.randrange(since, until)
    places = [(when, bisect_right(syncs, when)) for when in traffic.times[can_id]]
    after = [when - syncs[place - 1] for when, place in places if place]
    answers = bool(after) and max(after) < 5 * MS
    while at < until and len(times) < count:
        sync = next((sync for sync in syncs if sync >= at), traffic.end_us)
        times.append(sync + round(median(after)) if answers and sync < until else at)
        at = times[-1] + 60 * MS
    if not times or times[-1] > until + 5 * MS:
        return None
    added = [replace(own[0], t_us=at) for at in times]
    return traffic.faulty([*traffic.frames, *added], since - 15 * MS, times[-1])
