"""Changes of PDOs: late by the event timer, no longer sent, sent by a second node under one CAN-ID.

Why it exists: these faults are faults only by a PDO's configuration, which a session writes or a description names.
What it must not do: know codes; `test_changes.py` does.
"""

from __future__ import annotations

import struct
from dataclasses import replace
from itertools import pairwise
from random import Random
from statistics import median

from faulty_captures import Faulty
from network import START
from traffic import MS, Traffic, chosen

# Event timers


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
