"""Kinds of incident about SDO, PDO, SYNC, emergencies and further services: each with a fault and without it.

What it must not do: ask what is told of it.
"""

from __future__ import annotations

import struct

from kind_row import Sample, of_rule
from kinds_of_nodes import NODE, PERIOD, beats, started
from network import PRE_OPERATIONAL, START, Frames, Network

HARDWARE, NO_OBJECT, READ_ONLY, LENGTH, VALUE, NOT_MAPPABLE, NOT_NOW, NOT_STORED = (
    0x0606_0000,
    0x0602_0000,
    0x0601_0002,
    0x0607_0010,
    0x0609_0030,
    0x0604_0041,
    0x0800_0022,
    0x0800_0020,
)
"""SDO abort codes."""


def write(net: Network, index: int, sub: int, value: int, abort: int) -> Network:
    """A write of four bytes that is refused with this code; 0: it is taken."""
    answer = struct.pack("<BHBI", 0x80 if abort else 0x60, index, sub, abort)
    return net.exchange(NODE, struct.pack("<BHBI", 0x23, index, sub, value), answer)


def refused(index: int, abort: int) -> Sample:
    """A write that is refused and not made good; or it is taken."""

    def make(faulty: bool) -> Frames:
        net = Network().boot(NODE).write(NODE, 0x1017, 0, round(PERIOD * 1000), 2)
        write(net, index, 1, 0x6173_6576, abort if faulty else 0)
        return beats(net, {NODE: 4}, ((0, PRE_OPERATIONAL),)).frames()

    return Sample(make, NODE, "open", (0x605, 1))


def half_configured(faulty: bool) -> Frames:
    net = Network().boot(NODE).write(NODE, 0x1017, 0, round(PERIOD * 1000), 2)
    write(net, 0x2000, 1, 1, VALUE if faulty else 0).nmt(START, NODE)
    return beats(net, {NODE: 4}).frames()


def storing(faulty: bool) -> Frames:
    """A node is told to store, and its heartbeats stay away for a second; or come all the same."""
    net = started(NODE)
    for beat in range(1, 21):
        if not (faulty and 5 < beat < 12):
            net.send(0x700 + NODE, b"\x05", after=beat * PERIOD)
    write(net.wait(1.1), 0x1010, 1, 0x6576_6173, 0)
    return net.frames()


def two_clients(faulty: bool) -> Frames:
    """Two clients ask one server at a time, twice; or one after the other."""
    net = Network().boot(NODE)
    for _ in range(2):
        asked = [struct.pack("<BHB", 0x40, index, 0).ljust(8, b"\0") for index in (0x1000, 0x1008)]
        said = [struct.pack("<BHBI", 0x43, index, 0, 0x41) for index in (0x1000, 0x1008)]
        order = [(0x605, asked[0]), (0x605, asked[1]), (0x585, said[0]), (0x585, said[1])]
        for can_id, data in order if faulty else [order[at] for at in (0, 2, 1, 3)]:
            net.send(can_id, data).wait(0.0005)
        net.wait(1)
    return net.read(NODE, 0x1001, 0, 0, 1).frames()


def inhibit_time(faulty: bool) -> Frames:
    """PDOs 3 ms apart, though the inhibit time is 10 ms: three times with right ones between, or twice."""
    net = Network().boot(NODE).set_pdo(NODE, 1, [(0x6000, 1, 8)], inhibit=100).nmt(START, NODE)
    for place in range(100):
        net.wait(0.1).send(0x185, bytes([place]))
        if place % 10 == 1 and place < (30 if faulty else 20):
            net.send(0x185, bytes([place + 100]), after=0.003)
    return net.frames()


def multiplied(faulty: bool) -> Frames:
    """A PDO that comes twice as often after a second start; or as often as before."""
    net = beats(started(NODE), {NODE: 5}).wait(0.05)
    net.cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(20)]).wait(1.95).nmt(START, NODE).wait(0.048)
    period = 0.05 if faulty else 0.1
    return net.cyclic(0x185, period=period, payloads=[bytes([k]) for k in range(20)]).frames()


def not_taken(faulty: bool) -> Frames:
    """RPDOs to a node that is Pre-operational: 60, or 40."""
    net = beats(Network().boot(NODE), {NODE: 3}, ((0, PRE_OPERATIONAL),)).wait(0.5)
    count = 60 if faulty else 40
    return net.cyclic(0x205, period=0.02, payloads=[bytes([k, 0]) for k in range(count)]).frames()


def emergency(code: int, register: int = 0x01) -> Sample:
    """A node reports an error and does not take it back; or reports that there is none."""

    def make(faulty: bool) -> Frames:
        net = beats(started(4, NODE), {4: 4, NODE: 4}).wait(2.05)
        return net.emcy(NODE, code if faulty else 0, register if faulty else 0).frames()

    return Sample(make, NODE, "open", (0x085, 0))


def register_set(faulty: bool) -> Frames:
    net = Network().boot(NODE).wait(0.5).read(NODE, 0x1001, 0, 1 if faulty else 0, 1)
    return beats(net, {NODE: 2}, ((0, PRE_OPERATIONAL),)).frames()


def emcy_flood(faulty: bool) -> Frames:
    """Twelve emergencies within half a second that all say that no error is left; or eight."""
    net = beats(started(NODE), {NODE: 4}).wait(1)
    for _ in range(12 if faulty else 8):
        net.emcy(NODE, 0, 0).wait(0.03)
    return net.frames()


SAMPLES = {
    "request-unanswered": of_rule("SDO002", 10, "ended"),
    "late-answer": of_rule("SDO020", 10, "ended"),
    "object-refused": refused(0x2000, NO_OBJECT),
    "access-refused": refused(0x2000, READ_ONLY),
    "length-refused": refused(0x2000, LENGTH),
    "value-refused": refused(0x2000, VALUE),
    "state-refused": refused(0x2000, NOT_NOW),
    "mapping-refused": refused(0x1A00, NOT_MAPPABLE),
    "write-refused": refused(0x2000, HARDWARE),
    "half-configured": Sample(half_configured, NODE, "open", (0x605, 1)),
    "store-failed": refused(0x1010, NOT_STORED),
    "program-download-failed": refused(0x1F50, HARDWARE),
    "storing": Sample(storing, NODE, "harmless", (0x605, 1)),
    "damaged-transfer": of_rule("SDO003", 10, "open"),
    "two-clients": Sample(two_clients, NODE, "open", (0x605, 0)),
    "identity-mismatch": of_rule("EDS004", NODE, "open", described=True),
    "pdo-length": of_rule("PDO001", NODE, "open"),
    "pdo-missing": of_rule("SYN008", NODE, "open"),
    "pdo-never-sent": of_rule("PDO022", NODE, "open"),
    "pdo-interval": of_rule("PDO023", NODE, "open"),
    "rpdo-timeout": emergency(0x8250, 0x11),
    "shared-cob-id": of_rule("PDO020", 6, "open"),
    "pdo-not-allowed": of_rule("PDO002", NODE, "open"),
    "pdo-configuration": of_rule("PDO008", NODE, "open"),
    "inhibit-time": Sample(inhibit_time, NODE, "ended"),
    "pdo-multiplied": Sample(multiplied, NODE, "open", (0x185, 20)),
    "commands-not-taken": Sample(not_taken, NODE, "open", (0x205, 0)),
    "sync-stopped": of_rule("SYN013", None, "open"),
    "sync-never": of_rule("SYN014", None, "open"),
    "sync-irregular": of_rule("SYN002", None, "ended"),
    "two-sync-producers": of_rule("SYN006", 6, "open"),
    "sync-length": of_rule("SYN001", NODE, "ended"),
    "communication-error": emergency(0x8100, 0x11),
    "overrun": emergency(0x8110, 0x11),
    "bus-trouble": emergency(0x8140, 0x11),
    "device-error": emergency(0x2310, 0x03),
    "supply-voltage": emergency(0x3210, 0x05),
    "temperature": emergency(0x4210, 0x09),
    "module-failed": emergency(0x7000),
    "register-without-emcy": Sample(register_set, NODE, "open", (0x585, 0)),
    "emcy-flood": Sample(emcy_flood, NODE, "ended", (0x085, 0)),
    "lss-unanswered": of_rule("LSS009", None, "open"),
    "lss-refused": of_rule("LSS003", None, "ended"),
    "time-jump": of_rule("TIM002", None, "ended"),
    "srdo-invalid": of_rule("SRD001", NODE, "ended"),
    "wire-error": of_rule("HBT003", NODE, "ended"),
}
