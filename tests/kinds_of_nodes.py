"""Kinds of incident about the bus, the recording, NMT and error control: each with a fault and without it.

What it must not do: ask what is told of it.
"""

from __future__ import annotations

from collections.abc import Mapping

from captures import CanFrame
from kind_row import Sample, of_rule
from network import OPERATIONAL, PRE_OP, PRE_OPERATIONAL, RESET_NODE, START, STOP, STOPPED, Frames, Network

NODE = 5
PERIOD = 0.2
"""Seconds between heartbeats."""


def started(*nodes: int) -> Network:
    """Nodes that have booted, send heartbeats by 1017h and are started; they have answered, so they serve."""
    net = Network().boot(*nodes)
    for node in nodes:
        net.write(node, 0x1017, 0, round(PERIOD * 1000), 2)
    return net.nmt(START)


def beats(
    net: Network, nodes: Mapping[int, float], states: tuple[tuple[float, int], ...] = ((0, OPERATIONAL),)
) -> Network:
    """Heartbeats of nodes beside everything else, each for so many seconds from now."""
    for number, (node, seconds) in enumerate(nodes.items()):
        net.wait(0.003).live(node, period=PERIOD, seconds=seconds - 0.003 * number, states=states)
    return net


def error_frames(count: int, *, others: bool) -> Frames:
    """Error frames 10 ms apart, of stuff errors; others: a node goes on beside them."""
    begin = 1_700_000_000_000_000
    data = bytes.fromhex("0000040A00000000")
    wrong = [CanFrame("can0", 0x20000088, data, begin + at * 10_000, extended=True) for at in range(count)]
    beat = [CanFrame("can0", 0x705, b"\x05", begin + 5_000 + at * 100_000) for at in range(12)] if others else []
    return sorted([*wrong, *beat], key=lambda frame: frame.t_us)


def segment_lost(faulty: bool) -> Frames:
    return beats(started(3, 4, 5, 6), {3: 8, 4: 8} | dict.fromkeys((5, 6), 4 if faulty else 8)).frames()


def overload(faulty: bool) -> Frames:
    """PDOs one behind the other for a second at 500 kbit/s, or half as many."""
    net = beats(started(3, 4), {3: 4, 4: 4}).wait(1)
    after = 0.0
    for place in range(4800 if faulty else 2400):
        size = 8 if place % 2 else 4
        after += (0.00025 if size == 8 else 0.000175) * (1 if faulty else 2)
        net.send(0x183 + place % 2, bytes(size), after=after)
    return net.frames()


def flood(faulty: bool) -> Frames:
    """A PDO that comes every 100 ms, then every 5 ms: 60 times, or 40 times."""
    net = beats(started(NODE), {NODE: 5}).cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(20)]).wait(2)
    count = 60 if faulty else 40
    net.cyclic(0x185, period=0.005, payloads=[bytes([k]) for k in range(count)]).wait(count * 0.005)
    return net.wait(0.1).cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(20)]).frames()


def bit_timing(faulty: bool) -> Frames:
    net = Network().lss(0x04, 0x01).lss(0x13, 0, 3, answer=[0x13, 0, 0])
    if faulty:
        net.lss(0x15, 100, 0).wait(0.3)
    return net.lss(0x04, 0x00).frames()


def scan(faulty: bool) -> Frames:
    """Twelve nodes are asked for their device type, and one is there; or all are."""
    there = {NODE} if faulty else set(range(1, 13))
    net = Network().boot(*there)
    for node in range(1, 13):
        if node in there:
            net.read(node, 0x1000, 0, 0x191, 4)
        else:
            net.send(0x600 + node, bytes.fromhex("4000100000000000")).wait(0.05)
            net.send(0x600 + node, bytes.fromhex("8000100000000405")).wait(0.005)
    return beats(net, {NODE: 3}, ((0, PRE_OPERATIONAL),)).frames()


def silent(faulty: bool) -> Frames:
    return beats(started(4, NODE), {4: 6, NODE: 3 if faulty else 6}).frames()


def heartbeat_stopped(faulty: bool) -> Frames:
    net = beats(started(4, NODE), {4: 6, NODE: 3 if faulty else 6})
    return net.cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(60)]).frames()


def restarts(count: int, faulty: bool) -> Frames:
    """A node that boots again and is started again each time; its reset is commanded, or is not."""
    net = beats(started(4, NODE), {4: 1.9 + count})
    for _ in range(count):
        beats(net, {NODE: 0.8}).wait(0.9)
        if not faulty:
            net.nmt(RESET_NODE, NODE).wait(0.01)
        net.boot(NODE).write(NODE, 0x1017, 0, round(PERIOD * 1000), 2).nmt(START, NODE)
    return beats(net, {NODE: 2}).frames()


def restart_loop(faulty: bool) -> Frames:
    """Four boot-ups, one a second, that nobody notices; or as many by command, and it is started each time."""
    net = beats(started(4, NODE), {4: 7})
    beats(net, {NODE: 1}).wait(1.1)
    for _ in range(4):
        if not faulty:
            net.nmt(RESET_NODE, NODE).wait(0.01)
        net.boot(NODE)
        if not faulty:
            beats(net.nmt(START, NODE), {NODE: 0.95})
        net.wait(0.98)
    if not faulty:
        beats(net, {NODE: 1.5})
    return net.frames()


def waits_for_start(faulty: bool, reads: int) -> Frames:
    """A node boots, its device type is read so often, 0.6 s apart, and it is not started within 6 s; or it is."""
    net = beats(started(3, 4), {3: 7, 4: 7}).wait(0.1).boot(NODE)
    begin = net.now
    for _ in range(reads if faulty else 1):
        net.read(NODE, 0x1000, 0, 0x191, 4).wait(0.6)
    if not faulty:
        net.wait(4).nmt(START, NODE)
    started_at, net.now = net.now - begin, begin
    states = ((0.0, PRE_OPERATIONAL), *(() if faulty else ((started_at, OPERATIONAL),)))
    return beats(net, {NODE: 6.5}, states).frames()


def not_running(faulty: bool) -> Frames:
    """A node boots beside others that run, and is not started within 7 s; or it is after one."""
    net = beats(started(3, 4), {3: 8.5, 4: 8.5}).wait(0.1).boot(NODE)
    begin = net.now
    if not faulty:
        net.wait(1).nmt(START, NODE)
    started_at, net.now = net.now - begin, begin
    states = ((0.0, PRE_OPERATIONAL), *(() if faulty else ((started_at, OPERATIONAL),)))
    return beats(net, {NODE: 8.2}, states).frames()


def two_masters(faulty: bool) -> Frames:
    """A node is stopped and started again half a second later: twice, or once."""
    net = beats(started(3, NODE), {3: 9})
    begin = net.now
    states = [(0.0, OPERATIONAL)]
    for _ in range(2 if faulty else 1):
        states += [(net.wait(1).now - begin, STOPPED)]
        net.nmt(STOP, NODE).wait(0.498)
        states += [(net.now - begin, OPERATIONAL)]
        net.nmt(START, NODE)
    net.now = begin
    return beats(net, {NODE: 9}, tuple(states)).frames()


def commanded(command: int, faulty: bool) -> Frames:
    """All nodes are told to reset or to be Pre-operational, and are started again; or nothing is told."""
    net = beats(started(NODE), {NODE: 1 if faulty else 3}).wait(1.1)
    if not faulty:
        return net.frames()
    net.nmt(command).wait(0.05)
    if command == RESET_NODE:
        net.boot(NODE).write(NODE, 0x1017, 0, round(PERIOD * 1000), 2)
    return beats(net.wait(0.1).nmt(START), {NODE: 2}).frames()


def consumer_error(faulty: bool) -> Frames:
    """A consumer reports a loss, and no node is lost; or that no error is left."""
    net = beats(started(4, NODE), {4: 4, NODE: 4}).wait(2.05)
    return net.emcy(NODE, 0x8130 if faulty else 0, 0x11 if faulty else 0).frames()


def irregular(faulty: bool) -> Frames:
    """Heartbeats of which three come too late; or two do."""
    net = started(NODE)
    for beat in range(1, 61):
        late = beat % 10 == 5 and beat < (30 if faulty else 20)
        net.send(0x705, b"\x05", after=beat * PERIOD + (0.12 if late else 0))
    return net.frames()


def too_short(faulty: bool) -> Frames:
    """A node waits 100 ms for heartbeats that come every 200 ms, and reports a loss; or it waits 300 ms."""
    net = Network().boot(4, NODE)
    net.write(NODE, 0x1016, 1, 0x0004_0000 | (100 if faulty else 300), 4)
    for node in (4, NODE):
        net.write(node, 0x1017, 0, round(PERIOD * 1000), 2)
    beats(net.nmt(START), {4: 4, NODE: 4})
    if faulty:
        net.wait(0.31).emcy(NODE, 0x8130, 0x11)
    return net.frames()


def watched_absent(faulty: bool) -> Frames:
    """A node watches another one, reports a loss, and that one was never there; or it is there."""
    nodes = (NODE,) if faulty else (NODE, 9)
    net = Network().boot(*nodes).write(NODE, 0x1016, 1, 0x0009_01F4, 4)
    for node in nodes:
        net.write(node, 0x1017, 0, round(PERIOD * 1000), 2)
    beats(net.nmt(START), dict.fromkeys(nodes, 4.0))
    if faulty:
        net.wait(0.55).emcy(NODE, 0x8130, 0x11)
    return net.frames()


SAMPLES = {
    "bus-off": of_rule("BUS001", None, "open"),
    "error-passive": of_rule("BUS002", None, "unknown"),
    "not-acknowledged": of_rule("BUS004", None, "ended"),
    "bus-errors": Sample(lambda faulty: error_frames(3 if faulty else 2, others=True), None, "ended", (0x20000088, 0)),
    "transceiver-fault": of_rule("BUS008", None, "open"),
    "wrong-bit-rate": Sample(
        lambda faulty: error_frames(12 if faulty else 2, others=False), None, "open", (0x20000088, 0)
    ),
    "segment-lost": Sample(segment_lost, (5, 6), "open", (0x705, -1)),
    "bus-silent": of_rule("HBT005", None, "harmless"),
    "not-canopen": of_rule("BUS009", None, "harmless"),
    "capture-gap": of_rule("CAP002", None, "harmless"),
    "frames-missing": of_rule("CAP009", None, "harmless"),
    "overload": Sample(overload, None, "ended"),
    "node-floods": Sample(flood, NODE, "ended", (0x185, 21)),
    "bit-timing-activated": Sample(bit_timing, None, "harmless", (0x7E5, 2)),
    "node-absent": of_rule("SDO031", 10, "open"),
    "scan": Sample(scan, tuple(n for n in range(1, 13) if n != NODE), "harmless", (0x601, 0)),
    "node-silent": Sample(silent, NODE, "open", (0x705, -1)),
    "heartbeat-stopped": Sample(heartbeat_stopped, NODE, "open", (0x705, -1)),
    "node-restarted": Sample(lambda faulty: restarts(1, faulty), NODE, "ended"),
    "restart-loop": Sample(restart_loop, NODE, "open", (0x705, 6)),
    "no-boot-up": of_rule("NMT006", NODE, "open"),
    "not-started": Sample(lambda faulty: waits_for_start(faulty, 1), NODE, "open", (0x705, 0)),
    "boot-stuck": Sample(lambda faulty: waits_for_start(faulty, 3), NODE, "open", (0x605, 0)),
    "not-running": Sample(not_running, NODE, "open", (0x705, 0)),
    "two-masters": Sample(two_masters, (NODE,), "ended", (0x000, 1)),
    "left-operational": of_rule("NMT004", NODE, "open"),
    "start-without-effect": of_rule("NMT002", NODE, "open"),
    "commanded-reset": Sample(lambda faulty: commanded(RESET_NODE, faulty), (NODE,), "harmless", (0x000, 1)),
    "commanded-stop": Sample(lambda faulty: commanded(PRE_OP, faulty), (NODE,), "harmless", (0x000, 1)),
    "heartbeat-consumer-error": Sample(consumer_error, NODE, "open", (0x085, 0)),
    "guarding-unanswered": of_rule("GRD002", NODE, "ended"),
    "guarding-stopped": of_rule("GRD005", NODE, "ended"),
    "guarding-and-heartbeat": of_rule("GRD003", NODE, "open"),
    "duplicate-node-id": of_rule("HBT004", NODE, "open"),
    "heartbeat-irregular": Sample(irregular, NODE, "ended"),
    "consumer-time-too-short": Sample(too_short, NODE, "open", (0x085, 0)),
    "watched-node-absent": Sample(watched_absent, NODE, "open", (0x085, 0)),
}
