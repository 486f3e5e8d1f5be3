"""Kinds of incident about what a controller sends, and who answers it: each with a fault and without it.

What it must not do: know what the program says of it.
"""

from __future__ import annotations

import struct

from kind_row import Sample
from kinds_of_nodes import NODE, PERIOD, beats, started
from network import OPERATIONAL, RESET_NODE, START, Follower, Frames, Network

NO_OBJECT = 0x0602_0000
"""An SDO abort code."""


def reads(times: int, *, succeeds: bool = False) -> Frames:
    """An object is read every second and refused; then perhaps not."""
    net = started(NODE)
    beats(net, {NODE: times + 2})
    for number in range(times):
        refused = struct.pack("<BHBI", 0x80, 0x2100, 0, NO_OBJECT)
        value = struct.pack("<BHBI", 0x43, 0x2100, 0, 7)
        last = succeeds and number == times - 1
        net.wait(1).exchange(NODE, struct.pack("<BHB", 0x40, 0x2100, 0), value if last else refused)
    return net.frames()


def resets(times: int, pause: float = 2) -> Frames:
    """A node is reset, boots and is read, again and again; at last it stays Pre-operational."""
    net = Network().boot(NODE)
    for _ in range(times):
        net.wait(pause).nmt(RESET_NODE, NODE).wait(0.2).boot(NODE).wait(0.1).read(NODE, 0x1000, 0, 0x192, 4)
    return net.frames()


def mute(faulty: bool) -> Frames:
    """A node is reset and boots; then its heartbeats come again, or nothing does."""
    net = beats(started(4, NODE), {4: 12, NODE: 3}).wait(3.05).nmt(RESET_NODE, NODE).wait(0.1).boot(NODE)
    return (net if faulty else beats(net.wait(0.1).nmt(START, NODE), {NODE: 9})).frames()


def another_device(faulty: bool) -> Frames:
    """A node boots twice, and its identity is read each time: the serial number is another one, or the same."""
    net = Network()
    for serial in (0x11, 0x22 if faulty else 0x11):
        net.boot(NODE).read(NODE, 0x1018, 1, 0x99, 4).read(NODE, 0x1018, 4, serial, 4)
        net.write(NODE, 0x1017, 0, round(PERIOD * 1000), 2).nmt(START)
        beats(net, {NODE: 3}).wait(3)
        net.nmt(RESET_NODE, NODE).wait(0.1)
    net.boot(NODE).write(NODE, 0x1017, 0, round(PERIOD * 1000), 2).nmt(START)
    return beats(net, {NODE: 2}).frames()


def switched_off(faulty: bool) -> Frames:
    """1017h is set to 0, or to a longer time."""
    net = beats(started(4, NODE), {4: 8, NODE: 2}).wait(2.05)
    net.write(NODE, 0x1017, 0, 0 if faulty else 500, 2)
    if not faulty:
        net.live(NODE, period=0.5, seconds=6, states=((0, OPERATIONAL),))
    return net.frames()


def elsewhere(faulty: bool) -> Frames:
    """A server answers with the CAN-ID of the request, or with its own."""
    net = started(NODE)
    beats(net, {NODE: 8})
    for _ in range(3):
        request, answer = struct.pack("<BHB", 0x40, 0x1000, 0), struct.pack("<BHBI", 0x43, 0x1000, 0, 0x192)
        net.wait(1).send(0x600 + NODE, request.ljust(8, b"\0"))
        net.send(0x600 + NODE if faulty else 0x580 + NODE, answer, after=0.002)
        if faulty:
            net.send(0x600 + NODE, struct.pack("<BHBI", 0x80, 0x1000, 0, 0x0504_0000), after=0.8)
    return net.frames()


def rpdo(
    cycles: int, *, of: int = 100, second: int | None = None, transmit: bool = False, changes: bool = False
) -> Frames:
    """SYNC with a PDO in each of the first cycles; `second`: another sender of it from this cycle on.

    `transmit`: it is a TPDO; `changes`: its data are others each time.
    """
    can_id = 0x285 if transmit else 0x205
    net = started(NODE)
    beats(net, {NODE: of / 100})
    net.send(0x000, bytes([0x80, NODE]), after=of / 100 + 0.005)
    for cycle in range(cycles):
        net.send(can_id, bytes([0x0F, cycle % 256 if changes else 0]), after=cycle / 100 + 0.001)
        if second is not None and cycle >= second:
            net.send(0x205, b"\x06\0", after=cycle / 100 + 0.006)
    return net.sync(period=0.01, count=of, followers=[Follower(0x185, lambda _: b"\x37\x02", 0.002)]).frames()


def not_taken(faulty: bool) -> Frames:
    """RPDO1 has another COB-ID; frames come with the former one, or with its own."""
    net = Network().boot(NODE).write(NODE, 0x1400, 1, 0x8000_0205, 4).write(NODE, 0x1400, 1, 0x305, 4)
    net.write(NODE, 0x1017, 0, round(PERIOD * 1000), 2).nmt(START)
    beats(net, {NODE: 4})
    return net.wait(0.5).cyclic(0x205 if faulty else 0x305, period=0.1, payloads=[b"\x0f\0"] * 30).frames()


SAMPLES = {
    "read-in-vain": Sample(lambda faulty: reads(5 if faulty else 4), NODE, "open", (0x605, 1)),
    "reset-again-and-again": Sample(lambda faulty: resets(3 if faulty else 2), NODE, "open", (0x000, 0)),
    "mute-after-boot-up": Sample(mute, NODE, "open", (0x705, -1)),
    "another-device": Sample(another_device, NODE, "open", (0x585, 4)),
    "heartbeat-switched-off": Sample(switched_off, NODE, "harmless", (0x605, 1)),
    "answer-on-another-id": Sample(elsewhere, NODE, "open", (0x605, 1)),
    "rpdo-stopped": Sample(lambda faulty: rpdo(60 if faulty else 100), NODE, "open", (0x205, -1)),
    "frames-not-taken": Sample(not_taken, NODE, "open", (0x205, 0)),
}
