"""Single faults of SDO, PDO, EMCY, drives and of the recording itself, each put into a clean session at a time.

What it must not do: name codes or magnitudes; `fault_table.py` does.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import replace

from captures import CanFrame
from faulty_captures import Capture, Faulty, Make, later, quiet, us, with_data
from network import PRE_OP, PRE_OPERATIONAL, START
from plants import (
    DOWN,
    DRIVE,
    DRIVE_PDO,
    EVENT,
    EVENT_PDO,
    FAULT_REACTION,
    FAULTY,
    INHIBIT,
    INHIBITED_PDO,
    IO,
    SECONDS,
    SLOW_PDO,
    SWITCH_ON_DISABLED,
    SYNC_PERIOD,
    SYNC_WINDOW,
    UP,
    Known,
    built,
    drive,
)
from sdo_wire import Channel, abort, block_download, block_upload, expedited_upload, segmented_upload

# SDO


def sdo(
    frames: Callable[[Channel], list[CanFrame]], *, pause: float = 1.0, node: int = DRIVE, step: float = 0.0004
) -> Make:
    """Frames of a client and a server; for a time after them the client asks nothing."""

    def make(known: Known, at: float) -> Faulty:
        capture, since = Capture(built("plant", known)), quiet(at)
        capture.drop(since, since + pause, 0x600 + node, 0x580 + node)
        last = capture.place(since, frames(Channel(node)), step)
        return capture.faulty(since, last)

    return make


def answered_after(delay: float) -> Make:
    """A response that comes late."""

    def make(known: Known, at: float) -> Faulty:
        capture, since = Capture(built("plant", known)), quiet(at)
        capture.drop(since, since + delay + 0.1, 0x600 + DRIVE, 0x580 + DRIVE)
        capture.place(since, expedited_upload(Channel(DRIVE), 0x2001, 0, b"\x05"), delay)
        return capture.faulty(since, since + delay)

    return make


def refused(channel: Channel) -> list[CanFrame]:
    """A write that the server refuses."""
    return [channel.client(b"\x2f\x00\x60\x00\x01"), channel.server(abort(0x6000, 0, 0x0609_0030))]


def made_good(channel: Channel) -> list[CanFrame]:
    """The same, and then a value that is taken."""
    return [*refused(channel), channel.client(b"\x2f\x00\x60\x00\x02"), channel.server(b"\x60\x00\x60")]


def interleaved(channel: Channel) -> list[CanFrame]:
    """Two clients that read in segments at once on one channel."""
    one = segmented_upload(channel, 0x1008, 0, b"a drive with a very long name")
    two = segmented_upload(channel, 0x1009, 0, b"the version of its hardware")
    pairs = zip(zip(one[::2], one[1::2], strict=True), zip(two[::2], two[1::2], strict=True), strict=False)
    return [frame for both in pairs for pair in both for frame in pair]


def block_left(channel: Channel) -> list[CanFrame]:
    """A block download whose segments nobody acknowledges, and then a read in blocks without an abort between."""
    return [
        *block_download(channel, 0x2011, 0, bytes(200), blksize=20)[:22],
        *block_upload(channel, 0x2010, 0, bytes(range(200))),
    ]


def repeated(answers: int) -> Callable[[Channel], list[CanFrame]]:
    """A request that the client sends twice."""

    def frames(channel: Channel) -> list[CanFrame]:
        request, answer = expedited_upload(channel, 0x2001, 0, b"\x07\0")
        return [request, request, *[answer] * answers]

    return frames


def until_client(frames: list[CanFrame], count: int) -> list[CanFrame]:
    """The beginning of a transfer, to the n-th frame of the client."""
    ends = [at for at, frame in enumerate(frames, 1) if 0x601 <= frame.can_id <= 0x67F]
    return frames[: ends[count - 1]]


# PDO


def pdo_late(factor: float) -> Make:
    """One synchronous PDO so many windows after its SYNC."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        sync = capture.next(0x080, at)
        moved = us(sync + factor * SYNC_WINDOW)
        capture.change(sync, sync + 0.01, DRIVE_PDO, lambda frame: replace(frame, t_us=moved))
        return capture.faulty(sync, sync + SYNC_PERIOD)

    return make


def pdo_missing(count: int, written: bool = False) -> Make:
    """A synchronous PDO missing for so many cycles. written: a write to its parameters was refused just before."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        if written:
            channel = Channel(DRIVE)
            write = [channel.client(b"\x2f\x00\x18\x02\xf3"), channel.server(abort(0x1800, 2, 0x0609_0030))]
            capture.place(quiet(at) - 0.01, write)
        sync = capture.next(0x080, quiet(at) if written else at)
        capture.drop(sync, sync + count * SYNC_PERIOD - 0.001, DRIVE_PDO)
        return capture.faulty(sync - SYNC_PERIOD, sync + (count + 0.4) * SYNC_PERIOD)

    return make


def pdo_twice(known: Known, at: float) -> Faulty:
    """A synchronous PDO twice in a cycle, with another value."""
    capture = Capture(built("plant", known))
    sync = capture.next(0x080, at)
    capture.add(sync + 0.0037, DRIVE_PDO, struct.pack("<Hi", 0x0237, -1))
    return capture.faulty(sync, sync + SYNC_PERIOD)


def pdo_wrong_cycle(known: Known, at: float) -> Faulty:
    """A PDO of every fourth cycle, one cycle late."""
    capture = Capture(built("plant", known))
    when = capture.next(SLOW_PDO, at)
    capture.change(when - 0.0001, when + 0.0001, SLOW_PDO, later(SYNC_PERIOD))
    return capture.faulty(when - 0.003, when + 2 * SYNC_PERIOD)


def pdo_length(by: int, *, lasting: bool) -> Make:
    """A PDO that is longer or shorter than its mapping: one, or all from there on."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        when = capture.next(DRIVE_PDO, at)
        until = SECONDS + 1 if lasting else when + 0.01

        def changed(frame: CanFrame) -> CanFrame:
            return replace(frame, data=(frame.data + bytes(8))[: len(frame.data) + by])

        capture.change(when - 0.0001, until, DRIVE_PDO, changed)
        return capture.faulty(when - 0.0001, min(until, SECONDS))

    return make


def pdo_in_pre_operational(milliseconds: float) -> Make:
    """An event-driven PDO so long after the node was taken out of Operational."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        capture.drop(at, at + 0.4, INHIBITED_PDO, EVENT_PDO)
        capture.change(at + 0.002, at + 0.402, 0x700 + IO, with_data(bytes([PRE_OPERATIONAL])))
        capture.add(at, 0x000, bytes([PRE_OP, IO]))
        capture.add(at + 0.4, 0x000, bytes([START, IO]))
        if milliseconds:
            capture.add(at + milliseconds / 1000, INHIBITED_PDO, b"\x01\x02")
        return capture.faulty(at, at + max(milliseconds, 0.1) / 1000)

    return make


def inhibit_violated(part: float, *, written: bool = False) -> Make:
    """A PDO before its inhibit time is over, by so much of it. written: another PDO was written before."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        if written:
            other_pdo(capture, at)
        when = capture.next(INHIBITED_PDO, quiet(at) + 0.03)
        capture.change(when - 0.0001, when + 0.0001, INHIBITED_PDO, later(-part * INHIBIT))
        return capture.faulty(when - INHIBIT - 0.001, when)

    return make


def event_timer(factor: float, *, written: bool = False) -> Make:
    """A PDO that is not sent when its event timer is over; its timer goes on from there."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        if written:
            other_pdo(capture, at)
        when = capture.next(EVENT_PDO, quiet(at) + 0.03)
        capture.drop(when - 0.001, when - 0.001 + (int(factor) - 1) * EVENT, EVENT_PDO)
        until = DOWN if when < DOWN else SECONDS + 1
        capture.change(when - 0.001, until, EVENT_PDO, later(factor % 1 * EVENT))
        if when < DOWN:
            capture.drop(DOWN, UP, EVENT_PDO)
        return capture.faulty(when - EVENT - 0.001, when + factor * EVENT)

    return make


def other_pdo(capture: Capture, at: float) -> None:
    """A write to the parameters of another PDO of the node."""
    channel = Channel(IO)
    capture.place(quiet(at), [channel.client(b"\x2f\x05\x18\x02\xff"), channel.server(b"\x60\x05\x18\x02")])


def second_sender(known: Known, at: float) -> Faulty:
    """Another node sends on a PDO's identifier."""
    capture = Capture(built("plant", known))
    for number in range(14):
        capture.add(at + number * 0.07, INHIBITED_PDO, bytes([number, 0x55]))
    return capture.faulty(at - INHIBIT - 0.001, at + 1.0)


# Error frames, EMCY, drives, the recording itself


def error_frames(class_bits: int, data: bytes, count: int = 1, restarted: bool = False) -> Make:
    """What the recording host's controller reports. restarted: it is back 0.1 s later."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        for number in range(count):
            capture.add(at + number * 0.001, 0x2000_0000 | class_bits, data.ljust(8, b"\0"))
        if restarted:
            capture.add(at + 0.1, 0x2000_0100, bytes(8))
        return capture.faulty(at, at + count * 0.001 + 0.1 * restarted)

    return make


def emergencies(*messages: tuple[float, int, int]) -> Make:
    """Emergencies of a node: seconds after the first, error code, error register."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        for after, code, register in messages:
            capture.add(at + after, 0x080 + IO, struct.pack("<HB5x", code, register))
        return capture.faulty(at, at + messages[-1][0])

    return make


def drive_fault(
    *, emergency: bool, reset_after: float = 0, effect: bool = True, device_type: int = 0x0002_0192
) -> Make:
    """A drive goes into Fault. reset_after: the fault is reset then, with or without effect."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(drive(known, device_type))
        when = capture.next(DRIVE_PDO, at)
        words = [(when - 0.001, FAULT_REACTION), (when + 0.02, FAULTY)]
        if reset_after and effect:
            words.append((when + reset_after, SWITCH_ON_DISABLED))
        for since, word in words:
            capture.change(since, SECONDS + 1, DRIVE_PDO, with_data(struct.pack("<H", word)))
        if emergency:
            capture.add(when - 0.0015, 0x080 + DRIVE, struct.pack("<HB5x", 0x2310, 0x03))
        if reset_after:
            capture.add(when + reset_after - 0.02, 0x205, struct.pack("<H", 0x0080))
        if reset_after and not effect:
            return capture.faulty(when + reset_after - 0.021, SECONDS)
        return capture.faulty(when - 0.002, when + 0.06)

    return make


def stamps_jump(by: float) -> Make:
    """The clock of the recording is put on or back."""

    def make(known: Known, at: float) -> Faulty:
        frames = list(built("plant", known).frames)
        first = next(number for number, frame in enumerate(frames) if frame.t_us >= us(at))
        moved = [later(by)(frame) for frame in frames[first:]]
        return Faulty([*frames[:first], *moved], first, first + 4)

    return make


def frames_lost(count: int) -> Make:
    """So many frames missing, one after the other, and nothing says so."""

    def make(known: Known, at: float) -> Faulty:
        frames = list(built("plant", known).frames)
        first = next(number for number, frame in enumerate(frames) if frame.t_us >= us(at))
        return Faulty([*frames[:first], *frames[first + count :]], first, first + 30)

    return make


def bus_load(lasts: float) -> Make:
    """A bus that is full of one node's frames."""

    def make(known: Known, at: float) -> Faulty:
        capture = Capture(built("plant", known))
        for number in range(int(lasts / 0.00092)):
            capture.add(at + number * 0.00092, 0x6F0, struct.pack("<Q", number * 0x0123_4567_89AB))
        return capture.faulty(at - 0.001, at + lasts + 0.001)

    return make
