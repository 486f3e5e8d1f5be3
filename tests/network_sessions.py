"""Generated clean sessions: small networks in which everything is right, one for each service that is judged.

Why it exists: the same sessions must raise nothing as they are and exactly one thing with one fault in them. What it
must not do: contain a fault. Times in the comments are seconds from the first frame.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from network import OPERATIONAL, PRE_OP, PRE_OPERATIONAL, RESET_NODE, START, STOP, STOPPED, Follower, Network

NODE, OTHER = 5, 6
POSITION = [(0x6041, 0, 16), (0x6064, 0, 32)]
SPEED = [(0x6041, 0, 16), (0x606C, 0, 32), (0x6077, 0, 16)]
BITS = [(0x2000, 1, 32), (0x2001, 0, 16), (0x2002, 0, 3), (0x2003, 0, 13)]
IDENTITY = (0x0000_0001, 0x0000_0002, 0x8000_0000, 0x0000_0003)


def states() -> Network:
    """Boot-up, heartbeats of 100 ms, start at 0.55, a reset at 1.25 with its boot-up at 1.45, until 2.4."""
    net = Network().boot(NODE, OTHER)
    for node in (NODE, OTHER):
        net.write(node, 0x1017, 0, 100, 2)
    net.write(OTHER, 0x1016, 1, NODE << 16 | 500, 4)
    net.now = 0.05
    net.live(OTHER, period=0.1, seconds=2.35, states=[(0, PRE_OPERATIONAL)])
    net.now = 0.01
    net.live(NODE, period=0.1, seconds=1.2, states=[(0, PRE_OPERATIONAL), (0.54, OPERATIONAL)])
    net.now = 0.55
    net.nmt(START, NODE)
    net.now = 1.25
    net.nmt(RESET_NODE, NODE)
    net.now = 1.45
    net.boot(NODE).write(NODE, 0x1017, 0, 100, 2)
    return net.live(NODE, period=0.1, seconds=0.9, states=[(0, PRE_OPERATIONAL)])


def stopped() -> Network:
    """Start at 0.35, stop at 1.05, pre-operational again at 2.05, heartbeats of 100 ms until 2.4."""
    net = Network().boot(NODE, OTHER).write(NODE, 0x1017, 0, 100, 2).write(OTHER, 0x1017, 0, 100, 2)
    changes = [(0, PRE_OPERATIONAL), (0.34, OPERATIONAL), (1.04, STOPPED), (2.04, PRE_OPERATIONAL)]
    net.now = 0.01
    net.live(NODE, period=0.1, seconds=2.4, states=changes)
    net.now = 0.03
    net.live(OTHER, period=0.1, seconds=2.4, states=[(0, PRE_OPERATIONAL)])
    for at, command in ((0.35, START), (1.05, STOP), (2.05, PRE_OP)):
        net.now = at
        net.nmt(command, NODE)
    return net


def in_flight() -> Network:
    """A stop reaches a node that has a TPDO and an EMCY in its transmit queue: they come 1 and 2 ms after it."""
    net = Network().boot(NODE).write(NODE, 0x1017, 0, 100, 2)
    net.set_pdo(NODE, 1, [(0x2001, 0, 16)])
    net.now = 0.05
    net.live(NODE, period=0.1, seconds=1.0, states=[(0, PRE_OPERATIONAL), (0.05, OPERATIONAL), (0.55, STOPPED)])
    net.nmt(START, NODE).wait(0.01)
    net.cyclic(0x185, period=0.05, payloads=[struct.pack("<H", k) for k in range(11)])
    net.now = 0.561
    return net.send(0x000, bytes([STOP, NODE])).send(0x085, b"\x10\x32\x05\0\0\0\0\0", after=0.002)


def guarded() -> Network:
    """Guarding of 100 ms, start at 0.55."""
    net = Network().boot(NODE).write(NODE, 0x100C, 0, 100, 2).write(NODE, 0x100D, 0, 3, 1)
    net.now = 0.05
    net.guarding(NODE, period=0.1, count=5)
    net.now = 0.53
    net.nmt(START, NODE)
    net.now = 0.55
    return net.guarding(NODE, period=0.1, count=12, state=OPERATIONAL, toggle=1)


def emergencies() -> Network:
    """Errors and resets 50 ms apart with an inhibit time of 20 ms; heartbeats as a clock."""
    net = Network().boot(NODE).write(NODE, 0x1015, 0, 200, 2).write(NODE, 0x1017, 0, 100, 2)
    net.heartbeat(NODE, period=0.1, count=10)
    for code, register in ((0x3210, 0x05), (0x4210, 0x0D), (0x0000, 0x05), (0x0000, 0x00), (0x8110, 0x11), (0, 0)):
        net.wait(0.05 - 0.001).emcy(NODE, code, register)
    return net


def times() -> Network:
    """TIME every second, heartbeats between."""
    net = Network().boot(NODE).write(NODE, 0x1017, 0, 500, 2)
    return net.heartbeat(NODE, period=0.5, count=11).wait(0.02).time(period=1.0, count=6)


def lss_configured() -> Network:
    """A slave gets node-ID 17 and comes up with it; then a silent bus but for node 6's heartbeats."""
    net = Network().boot(OTHER).write(OTHER, 0x1017, 0, 100, 2).heartbeat(OTHER, period=0.1, count=40).wait(0.02)
    net.lss_select(*IDENTITY).lss(0x5E, answer=[0x5E, 0xFF]).lss(0x11, 17, answer=[0x11, 0])
    return net.lss(0x17, answer=[0x17, 0]).lss(0x04, 0).wait(0.03).boot(17)


def lss_bit_timing() -> Network:
    """500 kbit/s set and activated with a switch delay of 200 ms (at 0.1); node 6 is silent for twice that."""
    net = Network().boot(OTHER).write(OTHER, 0x1017, 0, 50, 2)
    net.heartbeat(OTHER, period=0.05, count=1).wait(0.06)
    net.lss(0x04, 1).lss(0x13, 0, 2, answer=[0x13, 0]).lss(0x15, 200, 0).wait(0.4)
    return net.heartbeat(OTHER, period=0.05, count=20).lss(0x04, 0)


def lss_fastscan() -> Network:
    """A slave without node-ID is found and gets node-ID 17."""
    net = Network().boot(OTHER).wait(0.02).lss_fastscan(IDENTITY).lss(0x11, 17, answer=[0x11, 0])
    return net.lss(0x17, answer=[0x17, 0]).lss(0x04, 0).wait(0.03).boot(17).read(17, 0x1018, 4, 3, 4)


def sync_alone() -> Network:
    """SYNC of 10 ms without counter; cycle and window known, no PDO."""
    net = Network().boot(NODE).write(NODE, 0x1006, 0, 10_000, 4).write(NODE, 0x1007, 0, 2000, 4)
    return net.nmt(START).wait(0.01).sync(period=0.01, count=60)


def position(cycle: int) -> bytes:
    """A statusword and a position that rises."""
    return struct.pack("<Hi", 0x0237, -20 + cycle)


def speed(cycle: int) -> bytes:
    """A statusword, a speed and a torque."""
    return struct.pack("<Hih", 0x0237, 1000 * cycle, -cycle)


def _synchronous(overflow: int) -> Network:
    net = Network().boot(NODE)
    if overflow:
        net.write(NODE, 0x1019, 0, overflow, 1)
    net.write(NODE, 0x1006, 0, 10_000, 4).write(NODE, 0x1007, 0, 2000, 4)
    net.set_pdo(NODE, 3, POSITION, kind=1).set_pdo(NODE, 4, SPEED, kind=4).nmt(START).wait(0.05)
    followers = [Follower(0x385, position, 0.0004), Follower(0x485, speed, 0.0007, every=4)]
    return net.sync(period=0.01, count=60, overflow=overflow, followers=followers)


def synchronous() -> Network:
    """SYNC of 10 ms; TPDO3 of type 1 and TPDO4 of type 4, both configured by SDO; a window of 2 ms."""
    return _synchronous(0)


def synchronous_counted() -> Network:
    """The same with a counter to 10."""
    return _synchronous(10)


def event_driven() -> Network:
    """TPDO1 with an inhibit time of 20 ms, TPDO2 with an event timer of 50 ms, both at 20 Hz; RPDO1; start at 0.05."""
    net = Network().boot(NODE).write(NODE, 0x1017, 0, 100, 2)
    changes = [(0, PRE_OPERATIONAL), (0.06, OPERATIONAL), (1.06, PRE_OPERATIONAL)]
    net.live(NODE, period=0.1, seconds=2.0, states=changes)
    net.set_pdo(NODE, 1, [(0x2001, 0, 16)], inhibit=200).set_pdo(NODE, 2, BITS, event=50)
    net.set_pdo(NODE, 1, [(0x6040, 0, 16), (0x6060, 0, 8)], transmit=False)
    net.now = 0.05
    net.nmt(START, NODE).wait(0.01)
    net.cyclic(0x185, period=0.05, payloads=[struct.pack("<H", 1000 + k) for k in range(20)]).wait(0.007)
    net.cyclic(0x285, period=0.05, payloads=[struct.pack("<iHH", -k, 3 * k, 0xF815 + 8 * k) for k in range(20)])
    net.wait(0.006).cyclic(0x205, period=0.1, payloads=[struct.pack("<Hb", 6, k - 2) for k in range(10)])
    net.now = 1.066
    return net.nmt(PRE_OP, NODE)


def configuring() -> Network:
    """TPDO1 set up, used, moved to 1F5 with another mapping, used again."""
    net = Network().boot(NODE).nmt(START, NODE)
    net.set_pdo(NODE, 1, [(0x2001, 0, 16)]).wait(0.02)
    net.cyclic(0x185, period=0.02, payloads=[struct.pack("<H", k) for k in range(5)]).wait(0.12)
    net.set_pdo(NODE, 1, [(0x2001, 0, 16), (0x2004, 0, 8)], can_id=0x1F5).wait(0.02)
    return net.cyclic(0x1F5, period=0.02, payloads=[struct.pack("<Hb", k, -k) for k in range(5)])


def moved() -> Network:
    """TPDO1 moved to 1F5 with nothing else written: invalid, then valid at the new place."""
    net = Network().boot(NODE).nmt(START, NODE)
    net.read_pdo(NODE, 1, [(0x2001, 0, 16)], can_id=0x185, kind=255).wait(0.02)
    net.cyclic(0x185, period=0.02, payloads=[struct.pack("<H", k) for k in range(5)]).wait(0.12)
    net.write(NODE, 0x1800, 1, 0xC000_0185, 4).write(NODE, 0x1800, 1, 0x4000_01F5, 4).wait(0.02)
    return net.cyclic(0x1F5, period=0.02, payloads=[struct.pack("<H", k) for k in range(5)])


def remapped() -> Network:
    """The mapping of TPDO1 changed, its CAN-ID not."""
    net = Network().boot(NODE).nmt(START, NODE)
    net.read_pdo(NODE, 1, [(0x2001, 0, 16)], can_id=0x185, kind=255).wait(0.02)
    net.cyclic(0x185, period=0.02, payloads=[struct.pack("<H", k) for k in range(5)]).wait(0.12)
    net.write(NODE, 0x1800, 1, 0xC000_0185, 4).write(NODE, 0x1A00, 0, 0, 1).write(NODE, 0x1A00, 1, 0x2004_0008, 4)
    net.write(NODE, 0x1A00, 0, 1, 1).write(NODE, 0x1800, 1, 0x4000_0185, 4).wait(0.02)
    return net.cyclic(0x185, period=0.02, payloads=[bytes([k]) for k in range(5)])


UP = [(0x0006, 0x0231), (0x0007, 0x0233), (0x000F, 0x0237)]
DOWN = [(0x0007, 0x0233), (0x0006, 0x0231), (0x0000, 0x0250)]


def drive_with_one_tpdo() -> Network:
    """The drive of drive.eds, booted, with its heartbeats of 1000 ms, and its TPDO2 of 500 ms switched off."""
    net = Network().boot(NODE).heartbeat(NODE, period=1.0, count=2, state=OPERATIONAL)
    return net.write(NODE, 0x1801, 1, 0xC000_0285, 4)


def drive() -> Network:
    """A drive (drive.eds) up, into quick stop, out of it and up and down again; its PDOs read by SDO first."""
    net = drive_with_one_tpdo()
    net.read_pdo(NODE, 1, [(0x6041, 0, 16)], can_id=0x185, kind=255)
    net.read_pdo(NODE, 1, [(0x6040, 0, 16)], can_id=0x205, kind=255, transmit=False)
    net.nmt(START, NODE).send(0x185, b"\x50\x02").wait(0.1)
    return net.drive(NODE, [*UP, (0x0002, 0x0217), (0x0000, 0x0250), *UP, *DOWN])


def drive_described() -> Network:
    """The same drive up and down; only its EDS says what its PDOs carry."""
    net = drive_with_one_tpdo().nmt(START, NODE).send(0x185, b"\x50\x02").wait(0.1)
    return net.drive(NODE, [*UP, *DOWN])


def drive_cyclic() -> Network:
    """A drive that shows its statusword every 50 ms; controlword 6 at 0.3, 7 at 0.6, then 2 s as it is."""
    net = drive_with_one_tpdo()
    net.set_pdo(NODE, 1, [(0x6041, 0, 16)], event=50)
    net.read_pdo(NODE, 1, [(0x6040, 0, 16)], can_id=0x205, kind=255, transmit=False)
    net.now = 0.1
    net.nmt(START, NODE)
    net.now = 0.11
    words = [0x0250] * 4 + [0x0231] * 6 + [0x0233] * 40
    net.cyclic(0x185, period=0.05, payloads=[struct.pack("<H", word) for word in words])
    net.now = 0.3
    net.send(0x205, b"\x06\x00")
    net.now = 0.6
    return net.send(0x205, b"\x07\x00")


def drive_by_sdo() -> Network:
    """The same drive asked and told by SDO only."""
    net = Network().boot(NODE).read(NODE, 0x6041, 0, 0x0250, 2)
    for controlword, statusword in UP:
        net.write(NODE, 0x6040, 0, controlword, 2).wait(0.02).read(NODE, 0x6041, 0, statusword, 2)
    return net.write(NODE, 0x60FF, 0, -1500, 4).write(NODE, 0x6060, 0, 3, 1).read(NODE, 0x6061, 0, 3, 1)


def safety() -> Network:
    """An SRDO every 50 ms; SCT 55 ms and SRVT 20 ms are read by SDO; Operational from the start."""
    net = Network().boot(NODE)
    for sub, value, size in ((1, 1, 1), (2, 55, 2), (3, 20, 1), (5, 0x109, 4), (6, 0x10A, 4)):
        net.read(NODE, 0x1301, sub, value, size)
    net.nmt(START, NODE).wait(0.02)
    return net.srdo(0x109, period=0.05, payloads=[struct.pack("<H", 0x1234 + k) for k in range(20)])


SESSIONS: dict[str, Callable[[], Network]] = {
    session.__name__: session
    for session in (
        states,
        stopped,
        in_flight,
        guarded,
        emergencies,
        times,
        lss_configured,
        lss_bit_timing,
        lss_fastscan,
        sync_alone,
        synchronous,
        synchronous_counted,
        event_driven,
        configuring,
        moved,
        remapped,
        drive,
        drive_described,
        drive_cyclic,
        drive_by_sdo,
        safety,
    )
}

DESCRIBED = {name: {NODE: "drive.eds"} for name in ("drive", "drive_described", "drive_cyclic", "drive_by_sdo")}
"""Sessions whose nodes are those of a dictionary in eds/."""
