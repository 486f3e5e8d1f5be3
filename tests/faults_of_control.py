"""Single faults of SYNC, heartbeat, guarding and NMT, each put into a clean session at a time.

What it must not do: name codes or magnitudes; `fault_table.py` does.
"""

from __future__ import annotations

import random
import struct
from dataclasses import replace
from itertools import zip_longest

from captures import CanFrame
from faulty_captures import Capture, Faulty, Make, later, quiet, us, with_data
from network import PRE_OPERATIONAL, RESET_NODE, START
from plants import (
    DRIVE,
    DRIVE_PDO,
    EVENT_PDO,
    GUARDED,
    HEARTBEAT,
    INHIBITED_PDO,
    IO,
    SECONDS,
    SLOW_PDO,
    SYNC_PERIOD,
    UP,
    Known,
    built,
    plant,
    sync_times,
)
from sdo_wire import Channel, expedited_upload

# SYNC


def sync_period(ratio: float, cycles: int, wobble: bool = False) -> Make:
    """SYNC in another period for so many cycles; or in turns early and late by as much. Its PDOs go with it."""

    def make(known: Known, at: float) -> Faulty:
        first = next(number for number, sent in enumerate(sync_times()) if sent >= at)

        def gap(number: int, _: float) -> float:
            off = first <= number < first + cycles
            part = ratio if not wobble or number % 2 else 2 - ratio
            return SYNC_PERIOD * (part if off else 1)

        syncs = sync_times(gap)
        return Capture(plant(known, syncs)).faulty(syncs[first - 1], syncs[min(first + cycles + 1, len(syncs) - 1)])

    return make


def sync_at_random(part: float, cycles: int) -> Make:
    """SYNC that comes early or late by up to a part of its period, each time anew. Its PDOs go with it."""

    def make(known: Known, at: float) -> Faulty:
        rng = random.Random(7)
        first = next(number for number, sent in enumerate(sync_times()) if sent >= at)
        off = [0.0] * first + [rng.uniform(-part, part) for _ in range(cycles)]
        syncs = [sent + SYNC_PERIOD * by for sent, by in zip_longest(sync_times(), off, fillvalue=0.0)]
        return Capture(plant(known, syncs)).faulty(syncs[first - 1], syncs[min(first + cycles + 1, len(syncs) - 1)])

    return make


def sync_never_as_configured(ratio: float) -> Make:
    """SYNC that never has the period of 1006h."""

    def make(known: Known, _: float) -> Faulty:
        return Capture(plant(known, sync_times(lambda *_: SYNC_PERIOD * ratio))).faulty(0, SECONDS)

    return make


def sync_missing(count: int, *, pdos: bool) -> Make:
    """So many SYNC frames missing. pdos: what follows them is there, so that they were lost only in the capture."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        first = capture.next(0x080, at) - 0.0001
        until = first + count * SYNC_PERIOD if count else SECONDS + 1
        before = capture.last(0x080, first)
        capture.drop(first, until, 0x080, *(() if pdos else (DRIVE_PDO, SLOW_PDO)))
        return capture.faulty(before, min(until, SECONDS) + 0.001)

    return make


def sync_of_two(phase: float, ratio: float = 1.0) -> Make:
    """A second producer, so much of a period beside the first."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        first = capture.next(0x080, at) + phase * SYNC_PERIOD
        for number in range(int(min(1.0, SECONDS - first) / (SYNC_PERIOD * ratio))):
            capture.add(first + number * SYNC_PERIOD * ratio, 0x080)
        return capture.faulty(first - SYNC_PERIOD, min(first + 1.0, SECONDS))

    return make


# Heartbeat and NMT

OF_IO = (INHIBITED_PDO, EVENT_PDO, 0x700 + IO, 0x580 + IO)


def heartbeat_gap(periods: float, *, burst: bool = False, late_before: bool = False, of: str = "plant") -> Make:
    """So many periods between two heartbeats. burst: of SDO, before it. late_before: the one before is late by half."""

    def make(known: Known, at: float) -> Faulty:
        capture, can_id = Capture(built(of, known)), 0x700 + IO
        before = capture.last(can_id, at)
        missing = int(periods) - 1
        capture.drop(before + 0.001, before + 0.001 + missing * HEARTBEAT, can_id)
        if periods % 1:
            capture.change(before + 0.01, before + HEARTBEAT + 0.02, can_id, later(periods % 1 * HEARTBEAT))
        if late_before:
            capture.change(before - 0.001, before + 0.001, can_id, later(0.5 * HEARTBEAT))
        if burst:
            reads = [f for k in range(400) for f in expedited_upload(Channel(DRIVE), 0x2100, 1, bytes([k % 256]))]
            capture.drop(before - 0.27, before + 0.03, 0x600 + DRIVE, 0x580 + DRIVE)
            capture.place(before - 0.24, reads, 0.0003)
        since = before + 0.5 * HEARTBEAT + 0.0001 if late_before else before
        return capture.faulty(since, before + (periods + 1.1) * HEARTBEAT)

    return make


def node_lost(*, polled: bool, touched: str = "", of: str = "plant") -> Make:
    """A node falls silent for ever. polled: it is still asked. touched: its 1017h was read or written just before."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built(of, known))
        if touched:
            value = struct.pack("<H", round(HEARTBEAT * 1000))
            write = [Channel(IO).client(b"\x2b\x17\x10\x00" + value), Channel(IO).server(b"\x60\x17\x10\x00")]
            read = expedited_upload(Channel(IO), 0x1017, 0, value)
            capture.place(quiet(at), read if touched == "read" else write)
        dies = quiet(at) + (0.003 if touched else 0.06)
        capture.drop(dies, SECONDS + 1, *OF_IO)
        asks = b"\x40\x01\x20" if polled else b"-"
        to_it = [f for f in capture.frames if f.can_id == 0x600 + IO and f.t_us >= us(dies)]
        capture.drop(dies, SECONDS + 1, 0x600 + IO)
        capture.frames += [frame for frame in to_it if frame.data.startswith(asks)]
        return capture.faulty(capture.last(0x700 + IO, dies), SECONDS)

    return make


def reset(command: int, *, boot_up: bool, back: bool = True, of: str = "plant") -> Make:
    """A node is reset. boot_up: it says that it is back; back: it is."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built(of, known))
        capture.drop(at, at + 0.3 if back else SECONDS + 1, *OF_IO, 0x600 + IO)
        capture.add(at, 0x000, bytes([command, IO]))
        capture.drop(at, at + 0.6, INHIBITED_PDO, EVENT_PDO)
        # It obeys a command to all that comes once it is back.
        started = UP + 0.002 if at + 0.3 < UP < at + 0.6 else at + 0.602
        capture.change(at, started, 0x700 + IO, with_data(bytes([PRE_OPERATIONAL])))
        if back:
            capture.add(at + 0.6, 0x000, bytes([START, IO]))
        if boot_up:
            capture.add(at + 0.3, 0x700 + IO, b"\0")
        return capture.faulty(at - 0.0001, at + 0.6 if back else SECONDS)

    return make


def first_heartbeats_missing(count: int) -> Make:
    """The first heartbeats after a commanded reset's boot-up missing."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        capture.frames = reset(RESET_NODE, boot_up=True)(known, at).frames
        boot = capture.next(0x700 + IO, at + 0.29)
        capture.drop(boot + 0.001, SECONDS, 0x700 + IO, most=count)
        return capture.faulty(boot, boot + (count + 2) * HEARTBEAT)

    return make


def two_nodes(period: float, state: int | None = None, *, of: str = "plant") -> Make:
    """Another node with the same node-ID: heartbeats in half phase, of this period; None: of the same state."""

    def make(known: Known, at: float) -> Faulty:
        capture, can_id = Capture(built(of, known)), 0x700 + IO
        own = [frame for frame in capture.frames if frame.can_id == can_id]
        first = capture.last(can_id, at) + HEARTBEAT / 2
        for number in range(int((SECONDS - first) / period)):
            when = first + number * period
            same = [frame.data for frame in own if frame.t_us < us(when)][-1]
            capture.add(when, can_id, same if state is None else bytes([state]))
        return capture.faulty(first - HEARTBEAT, SECONDS)

    return make


def guarding_toggle(known: Known, at: float) -> Faulty:
    """One answer with the toggle bit of the one before."""
    capture = Capture(built("guarded", known))
    when = capture.next(0x700 + GUARDED, at)

    def flipped(frame: CanFrame) -> CanFrame:
        return frame if frame.remote else replace(frame, data=bytes([frame.data[0] ^ 0x80]))

    capture.change(when - 0.0001, when + 0.05, 0x700 + GUARDED, flipped)
    return capture.faulty(when, when + 0.11)


def guarding_unanswered(count: int) -> Make:
    """So many requests without answer, 0: all from there on. A node toggles its bit only as it answers."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("guarded", known))
        when = capture.next(0x700 + GUARDED, at)
        until = when + count * 0.1 - 0.01 if count else SECONDS + 1
        if count % 2:
            capture.frames = [
                replace(f, data=bytes([f.data[0] ^ 0x80]))
                if f.can_id == 0x700 + GUARDED and not f.remote and f.t_us >= us(until)
                else f
                for f in capture.frames
            ]
        capture.frames = [
            f for f in capture.frames if f.can_id != 0x704 or f.remote or not us(when) <= f.t_us < us(until)
        ]
        return capture.faulty(when - 0.001, min(until, SECONDS))

    return make


def life_guarding(lasts: float) -> Make:
    """The master stops asking for longer than the life time."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("guarded", known))
        when = capture.next(0x700 + GUARDED, at) - 0.001
        before = capture.last(0x700 + GUARDED, when) - 0.001
        capture.drop(when, when + lasts, 0x700 + GUARDED)
        return capture.faulty(before, min(when + lasts + 0.1, SECONDS))

    return make
