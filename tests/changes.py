"""Single changes of clean sessions, drawn at random: what a fault does to the frames of a service, and what harms none.

Why it exists: a class of faults that is found in the session that it was written for is not found elsewhere. A change
is drawn for any clean session that has what it needs, at any magnitude and place that leave it visible. What it must
not do: know codes; `test_changes.py` does.
"""

from __future__ import annotations

import struct
from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from random import Random
from statistics import median

from captures import CanFrame
from faulty_captures import Faulty
from network import OPERATIONAL, PRE_OP, PRE_OPERATIONAL, RESET_COMMUNICATION, RESET_NODE, START, STOP, STOPPED
from plants import Session

RESETS = (RESET_NODE, RESET_COMMUNICATION)
STATES = {START: OPERATIONAL, STOP: STOPPED, PRE_OP: PRE_OPERATIONAL}
MS = 1000
"""Microseconds of a millisecond."""
LEAST_LATE_US = 25 * MS
"""A heartbeat late by less may be so on any host."""
EVEN_PART = 8
"""Gaps that differ from their median by at most this part of it are even."""

Frames = list[CanFrame]
Draw = Callable[["Traffic", Random, float], Faulty | None]
"""A change of a session, of one magnitude; none where the session has no place for it."""


@dataclass(frozen=True)
class Traffic:
    """A clean session, and what can be seen in it."""

    session: Session

    @cached_property
    def frames(self) -> Frames:
        return list(self.session.frames)

    @cached_property
    def start_us(self) -> int:
        return self.frames[0].t_us

    @cached_property
    def end_us(self) -> int:
        return self.frames[-1].t_us

    @cached_property
    def times(self) -> dict[int, list[int]]:
        """The stamps of data frames by CAN-ID."""
        found: dict[int, list[int]] = defaultdict(list)
        for frame in self.frames:
            if not frame.extended and not frame.remote:
                found[frame.can_id].append(frame.t_us)
        return found

    @cached_property
    def guarded(self) -> set[int]:
        return {frame.can_id & 0x7F for frame in self.frames if frame.remote and 0x700 < frame.can_id < 0x780}

    @cached_property
    def boots(self) -> list[tuple[int, int]]:
        """Stamps and nodes of boot-ups."""
        return [(f.t_us, f.can_id & 0x7F) for f in self.frames if 0x700 < f.can_id < 0x780 and f.data == b"\0"]

    @cached_property
    def commands(self) -> list[tuple[int, int, int]]:
        """Stamp, specifier and node of NMT commands."""
        return [(f.t_us, f.data[0], f.data[1]) for f in self.frames if f.can_id == 0 and len(f.data) == 2]

    @cached_property
    def exchanges(self) -> list[tuple[int, int, int]]:
        """Places of a request and its answer, and the node: expedited transfers on default channels."""
        found: list[tuple[int, int, int]] = []
        asked: dict[int, int] = {}
        for place, frame in enumerate(self.frames):
            node, group = frame.can_id & 0x7F, frame.can_id & ~0x7F
            if frame.extended or not node or len(frame.data) != 8:
                continue
            if group == 0x600:
                asked[node] = place
            elif group == 0x580 and node in asked:
                request = self.frames[asked.pop(node)]
                read = request.data[0] == 0x40 and frame.data[0] & 0xF3 == 0x43
                wrote = request.data[0] & 0xF3 == 0x23 and frame.data[0] == 0x60
                if (read or wrote) and request.data[1:4] == frame.data[1:4]:
                    found.append((self.frames.index(request), place, node))
        return found

    @cached_property
    def in_transfers(self) -> dict[int, list[tuple[int, int]]]:
        """Times by node in which its default channel is busy with something else than an expedited transfer."""
        short = {place for request, answer, _ in self.exchanges for place in (request, answer)}
        found: dict[int, list[tuple[int, int]]] = defaultdict(list)
        for place, frame in enumerate(self.frames):
            if 0x580 < frame.can_id < 0x680 and frame.can_id != 0x600 and place not in short:
                found[frame.can_id & 0x7F].append((frame.t_us - 20 * MS, frame.t_us + 20 * MS))
        return found

    def heartbeats(self, node: int) -> list[int]:
        """Stamps of a node's heartbeats, boot-ups left out."""
        can_id = 0x700 + node
        return [f.t_us for f in self.frames if f.can_id == can_id and not f.remote and f.data not in (b"", b"\0")]

    @cached_property
    def producers(self) -> dict[int, int]:
        """Nodes with even heartbeats, and the period in us."""
        found = {}
        for can_id in sorted(self.times):
            node = can_id - 0x700
            if not 0 < node < 0x80 or node in self.guarded:
                continue
            gaps = [later - before for before, later in self.even_gaps(node)]
            if len(gaps) >= 5:
                found[node] = round(median(gaps))
        return found

    def even_gaps(self, node: int) -> list[tuple[int, int]]:
        """The ends of a node's gaps between heartbeats that are about as long as most."""
        beats = self.heartbeats(node)
        gaps = list(pairwise(beats))
        if not gaps:
            return []
        usual = median(later - before for before, later in gaps)
        return [(b, e) for b, e in gaps if abs(e - b - usual) <= usual / EVEN_PART]

    @cached_property
    def nodes(self) -> list[int]:
        """Nodes that send error control frames."""
        return sorted(can_id - 0x700 for can_id in self.times if 0x700 < can_id < 0x780)

    def tpdos(self, node: int) -> list[int]:
        """CAN-IDs of a node's TPDOs, as far as they are those of the pre-defined connection set."""
        return [can_id for can_id in (0x180 + node, 0x280 + node, 0x380 + node, 0x480 + node) if can_id in self.times]

    def of_node(self, node: int) -> set[int]:
        """CAN-IDs of the frames that a node sends."""
        return {0x080 + node, 0x700 + node, 0x580 + node, *self.tpdos(node)}

    def commanded(self, node: int, since: int, until: int) -> bool:
        """Whether a command to a node, or to all, is within a time, or its boot-up."""
        return any(since <= at <= until and to in (0, node) for at, _, to in self.commands) or any(
            since <= at <= until and of == node for at, of in self.boots
        )

    def heard(self, since: int, until: int, node: int) -> bool:
        """Whether other nodes are heard all the time, so that the recorder did not stand still."""
        others = [f.t_us for f in self.frames if f.can_id & 0x7F != node and since < f.t_us < until]
        times = [since, *others, until]
        return max(after - before for before, after in pairwise(times)) < (until - since) / 2

    def quiet_of(self, node: int, at: int) -> bool:
        """Whether a node's default SDO channel is idle for some time around a stamp."""
        near = [place for can_id in (0x600 + node, 0x580 + node) for place in self.times.get(can_id, [])]
        return all(abs(place - at) > 15 * MS for place in near)

    # -- changed sessions

    def without(self, gone: Callable[[CanFrame], bool]) -> Frames:
        return [frame for frame in self.frames if not gone(frame)]

    def faulty(self, frames: Iterable[CanFrame], first_us: int, last_us: int) -> Faulty:
        """The changed capture in the order of its stamps; the fault is about the frames from a time to another."""
        ordered = sorted(frames, key=lambda frame: frame.t_us)
        times = [frame.t_us for frame in ordered]
        first, last = bisect_left(times, first_us) + 1, bisect_right(times, last_us)
        return Faulty(ordered, first, max(first, min(last, len(ordered))))

    def bus(self) -> str:
        return self.frames[0].bus

    def frame(self, can_id: int, data: bytes, t_us: int) -> CanFrame:
        return CanFrame(self.bus(), can_id, data, t_us)


def chosen(rng: Random, found: Iterable[tuple[int, ...]]) -> tuple[int, ...] | None:
    rows = sorted(found)
    return rng.choice(rows) if rows else None


def within(frame: CanFrame, since: int, until: int) -> bool:
    return since < frame.t_us < until


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
    """Whether a gap from a heartbeat on is in one boot, and the capture goes on long enough to show it."""
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


def slower_for_good(traffic: Traffic, rng: Random, ratio: float) -> Faulty | None:
    """All heartbeats of a node so many times slower from one on."""
    found = []
    for node, period in traffic.producers.items():
        even = traffic.even_gaps(node)
        found += [
            (node, period, before)
            for place, (before, _) in enumerate(even)
            if place >= 6 and traffic.end_us - before > 9 * ratio * period and (ratio - 1) * period > LEAST_LATE_US
            if not any(of == node and at > before for at, of in traffic.boots)
        ]
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, period, since = drawn
    return slowed(traffic, node, since, since, ratio, since - 1)


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


# NMT


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


# SDO


def sdo_no_answer(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """An expedited transfer without its answer; the client asks this node nothing for a second, or to the end."""
    found = []
    for request, answer, node in traffic.exchanges:
        asked = traffic.frames[request]
        # What a write without answer leaves unknown is another matter.
        if asked.data[0] == 0x40 and traffic.end_us - asked.t_us > 1300 * MS:
            found.append((request, answer, node))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    request, answer, _ = drawn
    at = traffic.frames[request].t_us
    frames = [*traffic.frames[:answer], *traffic.frames[answer + 1 :]]
    return traffic.faulty(frames, at, at)


def unanswered_before_reset(traffic: Traffic, rng: Random, milliseconds: float) -> Faulty | None:
    """A read without answer, and so long after it a reset of its node, or of all."""
    found = []
    answering = {node for _, _, node in traffic.exchanges}
    for at, cs, to in traffic.commands:
        since = at - round(milliseconds * MS)
        if cs not in RESETS:
            continue
        for node in [to] if to else sorted(answering):
            busy = any(
                since - 20 * MS < when < at
                for can_id in (0x600 + node, 0x580 + node)
                for when in traffic.times.get(can_id, [])
            )
            stopped = [c for w, c, t in traffic.commands if w < since and t in (0, node)][-1:] == [STOP]
            gone = traffic.commanded(node, since, at - 1)
            heard = [b for b in traffic.times.get(0x700 + node, []) if b < since]
            if node in answering and not busy and not stopped and not gone and heard:
                found.append((node, since))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, since = drawn
    request = traffic.frame(0x600 + node, b"\x40\x01\x20\x00\0\0\0\0", since)
    return traffic.faulty([*traffic.frames, request], since, since)


def request_repeated(traffic: Traffic, rng: Random, milliseconds: float) -> Faulty | None:
    """A client that sends its request once more, so long after the answer; the server answers once."""
    return twin(traffic, rng, milliseconds, request=True)


def answer_repeated(traffic: Traffic, rng: Random, milliseconds: float) -> Faulty | None:
    """A server that sends its answer once more, so long after it."""
    return twin(traffic, rng, milliseconds, request=False)


def twin(traffic: Traffic, rng: Random, milliseconds: float, *, request: bool) -> Faulty | None:
    later = round(milliseconds * MS)
    found = []
    for asked, answered, node in traffic.exchanges:
        at = traffic.frames[answered].t_us
        channel = sorted(traffic.times[0x600 + node] + traffic.times[0x580 + node])
        following = [when for when in channel if when > at]
        free = not following or following[0] > at + later + MS
        # A request without answer at the end of a capture may be answered after it.
        ends = following[0] < traffic.end_us if following else traffic.end_us - at > 1500 * MS + later
        if free and (ends or not request):
            found.append((asked, answered))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    asked, answered = drawn
    at = traffic.frames[answered].t_us
    again = replace(traffic.frames[asked if request else answered], t_us=at + later)
    return traffic.faulty([*traffic.frames, again], traffic.frames[asked].t_us, at + later)


# PDO


def written_pdos(traffic: Traffic) -> dict[int, tuple[int, int]]:
    """TPDOs by CAN-ID with the event timer, in ms, that was written for them last, and when."""
    found: dict[int, tuple[int, int]] = {}
    ids: dict[tuple[int, int], int] = {}
    timers: dict[tuple[int, int], tuple[int, int]] = {}
    for request, answer, node in traffic.exchanges:
        data, at = traffic.frames[request].data, traffic.frames[answer].t_us
        index, sub = struct.unpack_from("<HB", data, 1)
        if not 0x1800 <= index < 0x1A00 or data[0] == 0x40:
            continue
        value = struct.unpack_from("<I", data, 4)[0]
        if sub == 1 and not value & 0x8000_0000:
            ids[node, index] = value & 0x7FF
        if sub == 5:
            timers[node, index] = value & 0xFFFF, at
    for key, (timer, at) in timers.items():
        if timer and key in ids:
            found[ids[key]] = timer, at
    return found


def known_timers(traffic: Traffic) -> dict[int, tuple[int, int]]:
    """The same where a description names it: the plants' event-driven PDO."""
    found = written_pdos(traffic)
    if traffic.session.network is not None and 0x286 in traffic.times:
        found[0x286] = 100, traffic.start_us
    return found


def event_timer(traffic: Traffic, rng: Random, ratio: float) -> Faulty | None:
    """A PDO that comes so many event times after the one before."""
    found = []
    for can_id, (timer, since) in known_timers(traffic).items():
        times = [at for at in traffic.times[can_id] if at > since]
        for before, after in pairwise(times):
            until = before + round((ratio + 0.5) * timer * MS)
            steady = [at for at in times if before < at <= until]
            even = len(steady) >= int(ratio) and all(
                abs(b - a - timer * MS) < timer * MS / 8 for a, b in pairwise([before, *steady])
            )
            node = can_id & 0x7F
            if even and after < traffic.end_us and not traffic.commanded(node, before - 20 * MS, until):
                found.append((can_id, before, timer))
    drawn = chosen(rng, found)
    if drawn is None or (ratio - 1) * drawn[2] < 25:
        return None
    can_id, before, timer = drawn
    until = round(before + (int(ratio) - 0.5) * timer * MS)
    kept = traffic.without(lambda f: f.can_id == can_id and before < f.t_us < until)
    if ratio % 1:
        # Its timer goes on from there.
        stop = [w for w, _, to in traffic.commands if w > before and to in (0, can_id & 0x7F)]
        end = min([*stop, traffic.end_us + 1])
        late = round(ratio % 1 * timer * MS)
        kept = [
            replace(f, t_us=f.t_us + late) if f.can_id == can_id and before < f.t_us < end else f
            for f in kept
            if not (f.can_id == can_id and before < f.t_us < end <= f.t_us + late)
        ]
    return traffic.faulty(kept, before, before + round((ratio + 0.1) * timer * MS))


def pdo_stops(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """A PDO with an event timer that comes no more, although its node goes on and stays Operational."""
    found = []
    for can_id, (timer, since) in known_timers(traffic).items():
        node = can_id & 0x7F
        for at in traffic.times[can_id]:
            goes_on = [when for other in traffic.of_node(node) for when in traffic.times.get(other, []) if when > at]
            last = max(goes_on, default=0)
            stopped = [w for w, cs, to in traffic.commands if w > at and cs != START and to in (0, node)]
            free = min([*stopped, traffic.end_us]) - at > 4 * timer * MS and last - at > 4 * timer * MS
            if at > since + 2 * timer * MS and free:
                found.append((can_id, at, timer))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    can_id, at, _ = drawn
    kept = traffic.without(lambda f: f.can_id == can_id and f.t_us > at)
    return traffic.faulty(kept, at, traffic.end_us)


# LSS

ANSWERED = {0x43: 0x44, 0x11: 0x11, 0x13: 0x13, 0x17: 0x17, 0x5A: 0x5A, 0x5B: 0x5B, 0x5C: 0x5C, 0x5D: 0x5D, 0x5E: 0x5E}
"""Requests of an LSS master that one slave answers, with the command of the answer."""


def lss_no_answer(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """An LSS request to one slave without its answer."""
    found = []
    asked: int | None = None
    for place, frame in enumerate(traffic.frames):
        if frame.can_id == 0x7E5:
            asked = place
        elif frame.can_id == 0x7E4 and asked is not None:
            if ANSWERED.get(traffic.frames[asked].data[0]) == frame.data[0]:
                found.append((asked, place))
            asked = None
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    request, answer = drawn
    frames = [*traffic.frames[:answer], *traffic.frames[answer + 1 :]]
    at = traffic.frames[request].t_us
    if traffic.end_us - at < 1100 * MS:
        return None
    return traffic.faulty(frames, at, at)


# The recording


def stamps_forward(traffic: Traffic, rng: Random, seconds: float) -> Faulty | None:
    """The clock of the recording is put on."""
    place = rng.randrange(len(traffic.frames) // 8, len(traffic.frames) * 7 // 8)
    later = round(seconds * 1_000_000)
    moved = [replace(frame, t_us=frame.t_us + later) for frame in traffic.frames[place:]]
    return Faulty([*traffic.frames[:place], *moved], max(1, place - 2), min(place + 6, len(traffic.frames)))


# Two senders


def known_since(traffic: Traffic, can_id: int) -> int:
    """When the CAN-ID of a TPDO was written last; the start where it is described, the end where it is unknown."""
    if traffic.session.network is not None:
        return traffic.start_us
    writes = [traffic.frames[place] for place, _, _ in traffic.exchanges if traffic.frames[place].data[2] == 0x18]
    ids = [(f.t_us, struct.unpack_from("<I", f.data, 4)[0]) for f in writes if f.data[0] == 0x23 and f.data[3] == 1]
    return max((at for at, value in ids if value & 0x8000_07FF == can_id), default=traffic.end_us)


def identifier_taken(traffic: Traffic, rng: Random, size: float) -> Faulty | None:
    """A node's TPDO is moved to the CAN-ID of another's; its frames have so many bytes."""
    found = []
    for node in sorted({of for _, _, of in traffic.exchanges}):
        for can_id in [i for other in traffic.nodes if other != node for i in traffic.tpdos(other)]:
            times = [at for at in traffic.times[can_id] if at > known_since(traffic, can_id)]
            gaps = [b - a for a, b in pairwise(times)]
            if len(times) < 20 or median(gaps) < 4 * MS:
                continue
            # The node is quiet on SDO there, and the other's PDO comes again and again.
            for at in times[5:-12]:
                steady = [when for when in times if at < when < at + 12 * median(gaps)]
                if traffic.quiet_of(node, at + MS) and len(steady) >= 9 and not traffic.commanded(node, at, steady[-1]):
                    found.append((node, can_id, at, round(median(gaps))))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, can_id, at, gap = drawn
    moved = []
    for number, cob_id in enumerate((0x8000_0000 | 0x180 + node, 0x4000_0000 | can_id)):
        when = at + MS + 2 * MS * number
        request = b"\x23\x03\x18\x01" + struct.pack("<I", cob_id)
        moved += [traffic.frame(0x600 + node, request, when)]
        moved += [traffic.frame(0x580 + node, b"\x60\x03\x18\x01\0\0\0\0", when + 300)]
    sent = [traffic.frame(can_id, bytes(int(size)), at + 6 * MS + gap // 3 + number * gap) for number in range(8)]
    return traffic.faulty([*traffic.frames, *moved, *sent], at, sent[-1].t_us + gap)


# What harms none


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
