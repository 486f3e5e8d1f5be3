"""Kinds of incident where one sample and its neighbour do not show all: how they end, and where they must not be told.

What it must not do: ask what is told of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from kinds_of_data import VALUE, emcy_flood, two_clients, write
from kinds_of_drives import (
    ACKNOWLEDGED,
    CYCLIC_POSITION,
    DISABLED,
    ENABLED,
    ERROR,
    FAULT,
    HOMING,
    ON,
    POSITION,
    READY,
    STOPPING,
    cycles,
    drive,
    enabled,
    mode_not_taken,
    reset_in_vain,
)
from kinds_of_nodes import NODE, beats, error_frames, started
from network import OPERATIONAL, PRE_OPERATIONAL, RESET_NODE, START, Frames, Network

GENERAL_ERROR = 0x0800_0000
"""An SDO abort code."""


@dataclass(frozen=True, slots=True)
class Further:
    """A capture, and how incidents of a kind stand in it."""

    kind: str
    make: Callable[[], Frames]
    statuses: tuple[str, ...] = ()
    """In the order in which they are told; empty: none is."""
    end: tuple[int, int] | None = None
    """The frame by which the last of them is over: the n-th on a CAN-ID, from 0 or from the end."""
    unsaid: str = ""
    """What is not true of them, in English."""
    defect: str = ""
    """What is known to be wrong in what is told."""


def within_inhibit_time() -> Frames:
    """Each PDO comes 3 ms after another one, though the inhibit time is 10 ms."""
    net = Network().boot(NODE).set_pdo(NODE, 1, [(0x6000, 1, 8)], inhibit=100).nmt(START, NODE)
    for place in range(40):
        net.wait(0.1).send(0x185, bytes([place])).send(0x185, bytes([place]), after=0.003)
    return net.frames()


def always_late() -> Frames:
    """A PDO with an event timer of 100 ms comes every 200 ms from some time on."""
    net = Network().boot(NODE).set_pdo(NODE, 1, [(0x6000, 1, 8)], event=100).nmt(START, NODE)
    net.cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(20)]).wait(2)
    return net.cyclic(0x185, period=0.2, payloads=[bytes([k]) for k in range(40)]).frames()


def even_stream() -> Frames:
    """One PDO of 8 bytes each millisecond, and heartbeats: half of what 250 kbit/s carry."""
    net = beats(started(3, 4), {3: 4, 4: 4}).wait(1)
    return net.cyclic(0x183, period=0.001, payloads=[bytes(8)] * 2000).frames()


def overload_to_the_end() -> Frames:
    net = beats(started(3, 4), {3: 2, 4: 2}).wait(1)
    after = 0.0
    for place in range(4800):
        size = 8 if place % 2 else 4
        after += 0.00025 if size == 8 else 0.000175
        net.send(0x183 + place % 2, bytes(size), after=after)
    return net.frames()


def flood_that_stops() -> Frames:
    """A PDO floods the bus for 0.5 s and does not come again; the node goes on for two seconds."""
    net = beats(started(NODE), {NODE: 5}).cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(20)]).wait(2)
    return net.cyclic(0x185, period=0.005, payloads=[bytes([k]) for k in range(100)]).frames()


def single_again() -> Frames:
    """A PDO comes twice as often after a second start, and as before after a reset."""
    net = started(NODE).cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(20)])
    net.wait(1.95).nmt(START, NODE).wait(0.048)
    net.cyclic(0x185, period=0.05, payloads=[bytes([k]) for k in range(20)]).wait(1.05)
    net.nmt(RESET_NODE, NODE).wait(0.1).boot(NODE).nmt(START, NODE).wait(0.1)
    return net.cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(60)]).frames()


def one_client_again() -> Frames:
    """Two clients at a time, then one for ten seconds."""
    net = Network()
    for frame in two_clients(True):
        net.send(frame.can_id, frame.data, after=(frame.t_us - 1_700_000_000_000_000) / 1_000_000)
    net.wait(4)
    for _ in range(10):
        net.read(NODE, 0x1000, 0, 0x191, 4).wait(1)
    return net.frames()


def announced_register() -> Frames:
    """The error register is read just before the emergency that tells of it, and the error is taken back later."""
    net = Network().boot(NODE).wait(0.5).read(NODE, 0x1001, 0, 1, 1).wait(0.02).emcy(NODE, 0x2310, 1)
    net.wait(1).emcy(NODE, 0, 0)
    return beats(net, {NODE: 2}, ((0, PRE_OPERATIONAL),)).frames()


def register_read_again() -> Frames:
    net = Network().boot(NODE).wait(0.5).read(NODE, 0x1001, 0, 1, 1).wait(1).read(NODE, 0x1001, 0, 0, 1)
    return beats(net, {NODE: 2}, ((0, PRE_OPERATIONAL),)).frames()


def lag_announced() -> Frames:
    """A following error, by an emergency and by the statusword."""
    net = cycles(enabled(CYCLIC_POSITION), 15, ENABLED, CYCLIC_POSITION, count=5)
    cycles(net, 15, ENABLED | ERROR, CYCLIC_POSITION, count=2).emcy(NODE, 0x8611, 0x21)
    return cycles(net, 15, ENABLED | ERROR, CYCLIC_POSITION, count=15).frames()


def enabled_by_itself() -> Frames:
    """A drive that was ready to switch on is enabled though nothing was commanded."""
    net = cycles(drive(), 6, READY, POSITION, count=20)
    return cycles(net, 6, ENABLED, POSITION, count=20).frames()


def mode_taken_late() -> Frames:
    net = Network()
    for frame in mode_not_taken(True):
        net.send(frame.can_id, frame.data, after=(frame.t_us - 1_700_000_000_000_000) / 1_000_000)
    return cycles(net.wait(6), 15, ENABLED, CYCLIC_POSITION, count=20).frames()


def targets_stop() -> Frames:
    """Targets every 10 ms for a second, and none for three, though the drive stays enabled."""
    net = enabled(CYCLIC_POSITION)
    for place in range(100):
        net.send(0x305, place.to_bytes(4, "little"), after=place * 0.01)
    return cycles(net, 15, ENABLED, CYCLIC_POSITION, count=40).frames()


def targets_while_disabled() -> Frames:
    """No targets while the drive is disabled for a second."""
    net = enabled(CYCLIC_POSITION)
    for _ in range(4):
        for place in range(50):
            net.send(0x305, place.to_bytes(4, "little"), after=place * 0.01)
        cycles(cycles(net, 15, ENABLED, CYCLIC_POSITION, count=5), 0, DISABLED, CYCLIC_POSITION, count=10)
        for controlword, statusword in ((6, READY), (7, ON), (15, ENABLED)):
            cycles(net, controlword, statusword, CYCLIC_POSITION, count=2)
    return net.frames()


def configured_again_and_again() -> Frames:
    """A node boots, is asked for its device type and configured four times, and is never started."""
    net = beats(started(3, 4), {3: 7, 4: 7}).wait(0.1).boot(NODE)
    begin = net.now
    for _ in range(4):
        net.read(NODE, 0x1000, 0, 0x191, 4).write(NODE, 0x1017, 0, 200, 2).wait(0.8)
    net.now = begin
    return beats(net, {NODE: 7}, ((0, PRE_OPERATIONAL),)).frames()


def reset_at_last() -> Frames:
    """Bit 7 is held while the fault stands; then it is taken back, set anew, and the drive leaves the fault."""
    net = cycles(drive(), 0x80, FAULT, POSITION, count=30)
    return cycles(cycles(net, 0, FAULT, POSITION, count=2), 0x80, DISABLED, POSITION, count=5).frames()


def reported(mode: int, bits: int) -> Frames:
    """An enabled drive reports bits of its statusword for half a second."""
    net = cycles(enabled(mode), 15, ENABLED, mode, count=5)
    return cycles(cycles(net, 15, ENABLED | bits, mode, count=5), 15, ENABLED, mode, count=10).frames()


def stopped_and_disabled() -> Frames:
    net = cycles(enabled(POSITION), 15, STOPPING, POSITION, count=10)
    return cycles(net, 0, DISABLED, POSITION, count=5).frames()


def restarted_instead() -> Frames:
    """A write is refused, then the node restarts and is not written to again."""
    net = Network().boot(NODE).write(NODE, 0x1017, 0, 200, 2)
    write(net, 0x2000, 1, 1, VALUE).wait(0.5).boot(NODE)
    return beats(net, {NODE: 3}, ((0, PRE_OPERATIONAL),)).frames()


def made_good_after_start() -> Frames:
    net = Network().boot(NODE).write(NODE, 0x1017, 0, 200, 2)
    write(net, 0x2000, 1, 1, VALUE).nmt(START, NODE).wait(0.5)
    return beats(write(net, 0x2000, 1, 1, 0), {NODE: 3}, ((0, OPERATIONAL),)).frames()


def general_error() -> Frames:
    net = Network().boot(NODE).write(NODE, 0x1017, 0, 200, 2)
    return beats(write(net, 0x2000, 1, 1, GENERAL_ERROR), {NODE: 4}, ((0, PRE_OPERATIONAL),)).frames()


def stepped(*statuswords: int) -> Frames:
    """A drive is told to become enabled by SDO, and asked for its state after each step."""
    net = Network().boot(NODE)
    for controlword, statusword in zip((6, 7, 15), statuswords, strict=False):
        net.write(NODE, 0x6040, 0, controlword, 2).wait(0.01).read(NODE, 0x6041, 0, statusword, 2).wait(0.01)
    return net.frames()


def shown(*statuswords: int, device: int | None = None) -> Frames:
    """A node is asked for its statusword again and again; device: it was asked for its device type before."""
    net = Network().boot(NODE)
    if device is not None:
        net.read(NODE, 0x1000, 0, device, 4)
    for statusword in statuswords:
        net.wait(0.2).read(NODE, 0x6041, 0, statusword, 2)
    return net.frames()


FURTHER: Final[dict[str, Further]] = {
    "in fault from the first look on": Further(
        "axis-fault", lambda: shown(FAULT, FAULT), ("open",), unsaid="in fault since"
    ),
    "in fault, and of type 402": Further("axis-fault", lambda: shown(FAULT, device=0x0002_0192), ("open",)),
    "in fault at first only": Further("axis-fault", lambda: shown(FAULT, DISABLED)),
    "as if in fault, and of type 401": Further("axis-fault", lambda: shown(FAULT, FAULT, device=0x0001_0191)),
    "a drive that takes no step": Further("not-enabled", lambda: stepped(DISABLED, DISABLED, DISABLED), ("open",)),
    "a drive that takes each step": Further("not-enabled", lambda: stepped(READY, ON, ENABLED)),
    "a drive that takes a step late": Further("not-enabled", lambda: stepped(DISABLED, READY, ON)),
    "a drive that is told one step only": Further("not-enabled", lambda: stepped(DISABLED)),
    "each PDO within the inhibit time": Further("inhibit-time", within_inhibit_time, ("open",)),
    "each PDO later than its event timer": Further("pdo-interval", always_late, ("open",)),
    "an even stream is no overload": Further("overload", even_stream, ()),
    "an overload to the end": Further("overload", overload_to_the_end, ("open",)),
    "a flood that stops": Further("node-floods", flood_that_stops, ("ended",)),
    "a PDO that is single again": Further("pdo-multiplied", single_again, ("ended",)),
    "one client again": Further("two-clients", one_client_again, ("ended",)),
    "two clients, all of them answered": Further("request-unanswered", lambda: two_clients(True), ()),
    "a register that an emergency explains": Further("register-without-emcy", announced_register, ()),
    "a register that is 0 again": Further("register-without-emcy", register_read_again, ("ended",)),
    "nothing but error frames are one trouble": Further("bus-errors", lambda: error_frames(12, others=False), ()),
    "a general error is no state": Further("state-refused", general_error, ()),
    "a following error is told once": Further("following-error", lag_announced, ("open",)),
    "a following error that ends": Further(
        "following-error", lambda: reported(CYCLIC_POSITION, ERROR | ACKNOWLEDGED), ("ended",)
    ),
    "a homing that is tried again": Further("homing-failed", lambda: reported(HOMING, ERROR), ("ended",)),
    "a drive that is enabled by itself": Further("state-left", enabled_by_itself, ()),
    "a mode that is taken late": Further("mode-not-taken", mode_taken_late, ("ended",)),
    "a reset with an edge": Further("fault-reset-without-edge", lambda: reset_in_vain(True), ()),
    "targets that stop": Further("targets-late", targets_stop, ("open",)),
    "no targets while disabled": Further("targets-late", targets_while_disabled),
    "configured again and again": Further("not-started", configured_again_and_again, ("open",)),
    "what is configured is not stuck": Further("boot-stuck", configured_again_and_again),
    "error frames to the last": Further(
        "bus-errors", lambda: error_frames(12, others=True), ("ended",), end=(0x20000088, -1)
    ),
    "emergencies to the last": Further("emcy-flood", lambda: emcy_flood(True), ("ended",), end=(0x085, -1)),
    "a reset at last": Further("fault-reset-without-edge", reset_at_last, ("ended",)),
    "a quick stop that ends": Further("quick-stop", stopped_and_disabled, ("ended",)),
    "a refusal and a restart": Further("value-refused", restarted_instead, ("ended",), unsaid="made good"),
    "made good after the start": Further("value-refused", made_good_after_start, ("ended",)),
    "made good after the start is not half configured": Further("half-configured", made_good_after_start),
}
"""By what it shows."""
