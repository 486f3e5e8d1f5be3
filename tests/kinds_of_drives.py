"""Kinds of incident about drives (CiA 402): each with a fault and without it.

What it must not do: ask what is told of it.
"""

from __future__ import annotations

import struct

from kind_row import Sample, of_rule
from kinds_of_nodes import NODE
from network import START, Frames, Network

POSITION, HOMING, CYCLIC_POSITION = 1, 6, 8
DISABLED, READY, ON, ENABLED, FAULT, STOPPING = 0x0250, 0x0231, 0x0233, 0x0237, 0x0218, 0x0217
"""Statuswords: remote, voltage enabled, and the state."""
ACKNOWLEDGED, ERROR, LIMIT, REACHED = 0x1000, 0x2000, 0x0800, 0x0400
"""Further bits of it."""


def drive() -> Network:
    """A drive with the controlword and the mode in RPDO1, the target in RPDO2, the statusword and the mode in TPDO1."""
    net = Network().boot(NODE).read(NODE, 0x1000, 0, 0x0002_0192, 4)
    net.set_pdo(NODE, 1, [(0x6041, 0, 16), (0x6061, 0, 8)])
    net.set_pdo(NODE, 1, [(0x6040, 0, 16), (0x6060, 0, 8)], transmit=False)
    return net.set_pdo(NODE, 2, [(0x607A, 0, 32)], transmit=False).nmt(START, NODE)


def cycles(net: Network, controlword: int, statusword: int, mode: int, *, count: int = 1) -> Network:
    """What is commanded and reported, ten times a second."""
    for _ in range(count):
        net.send(0x205, struct.pack("<Hb", controlword, mode))
        net.send(0x185, struct.pack("<Hb", statusword, mode), after=0.005).wait(0.1)
    return net


def enabled(mode: int) -> Network:
    """A drive that was enabled step by step."""
    net = drive()
    for controlword, statusword in ((0, DISABLED), (6, READY), (7, ON), (15, ENABLED)):
        cycles(net, controlword, statusword, mode, count=2)
    return net


def reset_in_vain(faulty: bool) -> Frames:
    """A drive that is in fault already is reset, and stays in fault; or leaves it."""
    net = cycles(drive(), 0, FAULT, POSITION, count=3)
    return cycles(net, 0x80, FAULT if faulty else DISABLED, POSITION, count=40).frames()


def held_reset(faulty: bool) -> Frames:
    """Bit 7 of the controlword is set all the time while the drive is in fault; or it is set anew, and that helps."""
    net = cycles(drive(), 0x80 if faulty else 0, FAULT, POSITION, count=3)
    return cycles(net, 0x80, FAULT if faulty else DISABLED, POSITION, count=30).frames()


def left(faulty: bool) -> Frames:
    """An enabled drive is disabled though nothing was commanded; or after disable voltage."""
    net = cycles(enabled(POSITION), 15, ENABLED, POSITION, count=20)
    return cycles(net, 15 if faulty else 0, DISABLED, POSITION, count=20).frames()


def mode_not_taken(faulty: bool) -> Frames:
    """Another mode is asked for and the old one displayed for 4 s; or for 0.3 s."""
    net = enabled(POSITION)
    for place in range(40):
        displayed = POSITION if faulty or place < 3 else CYCLIC_POSITION
        net.send(0x205, struct.pack("<Hb", 15, CYCLIC_POSITION))
        net.send(0x185, struct.pack("<Hb", ENABLED, displayed), after=0.005).wait(0.1)
    return net.frames()


def quick_stop(faulty: bool) -> Frames:
    """A drive stops by itself; or because bit 2 of the controlword is taken back."""
    return cycles(enabled(POSITION), 15 if faulty else 11, STOPPING, POSITION, count=20).frames()


def reports(mode: int, wrong: int, right: int, *, count: int = 20, clean_count: int | None = None) -> Sample:
    """An enabled drive reports a bit of its statusword, in tenths of a second; or other bits, or not for so long."""

    def make(faulty: bool) -> Frames:
        net = cycles(enabled(mode), 15, ENABLED, mode, count=5)
        if faulty or clean_count is not None:
            cycles(net, 15, ENABLED | wrong, mode, count=count if faulty else clean_count or 0)
        if not faulty:
            cycles(net, 15, ENABLED | right, mode, count=20)
        return net.frames()

    return Sample(make, NODE, "open", (0x185, 13))


def set_point(faulty: bool) -> Frames:
    """A new set-point is not acknowledged; or it is after 0.4 s."""
    net = cycles(enabled(POSITION), 15, ENABLED, POSITION, count=5)
    cycles(net, 0x1F, ENABLED, POSITION, count=4)
    return cycles(net, 0x1F, ENABLED | (0 if faulty else ACKNOWLEDGED), POSITION, count=10).frames()


def targets(faulty: bool) -> Frames:
    """Targets every 10 ms, of which one is missing for 50 ms: three times, or twice."""
    net = enabled(CYCLIC_POSITION)
    begin, late = net.now, 0.0
    for place in range(200):
        late += 0.04 if place % 50 == 40 and place < (150 if faulty else 100) else 0
        net.send(0x305, struct.pack("<i", place), after=place * 0.01 + late)
    net.now = begin
    return cycles(net, 15, ENABLED, CYCLIC_POSITION, count=20).frames()


SAMPLES = {
    "axis-fault": of_rule("DRV005", NODE, "open"),
    "fault-reset-without-effect": Sample(reset_in_vain, NODE, "open", (0x205, 3)),
    "not-enabled": of_rule("DRV002", NODE, "open"),
    "quick-stop": Sample(quick_stop, NODE, "open", (0x185, 8)),
    "state-left": Sample(left, NODE, "open"),
    "illegal-transition": of_rule("DRV001", NODE, "ended"),
    "mode-not-taken": Sample(mode_not_taken, NODE, "open", (0x205, 8)),
    "fault-reset-without-edge": Sample(held_reset, NODE, "open"),
    "following-error": reports(CYCLIC_POSITION, ERROR | ACKNOWLEDGED, ACKNOWLEDGED),
    "internal-limit": reports(POSITION, LIMIT, 0, clean_count=9),
    "set-point-not-acknowledged": Sample(set_point, NODE, "open", (0x205, 13)),
    "homing-failed": reports(HOMING, ERROR, ACKNOWLEDGED | REACHED),
    "targets-late": Sample(targets, NODE, "ended", (0x305, 39)),
}
