"""Generated clean sessions of some seconds: long enough for a fault, or a stalled recorder, anywhere in them.

Why it exists: a tolerance shows only where there is time before and after it, beside other traffic, near a change of
state and far from one, and with all that may be known of a network: nothing but its traffic, what the capture shows
being written, or a description. What it must not do: contain a fault. Times are seconds from the first frame.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

from captures import CanFrame
from network import OPERATIONAL, PRE_OP, PRE_OPERATIONAL, RESET_NODE, START, STOPPED, Network, jittered
from sdo_wire import Channel, abort, block_download, block_upload, segmented_download, segmented_upload

from canalyze import _core

Known = Literal["traffic", "written", "described"]
"""What is known of the network: its traffic alone; what is written at the beginning of the capture; a DCF."""
EVERY: tuple[Known, ...] = ("traffic", "written", "described")

DRIVE, IO = 5, 6
"""Node-IDs."""
SYNC_PERIOD, SYNC_WINDOW, HEARTBEAT, INHIBIT, EVENT = 0.025, 0.005, 0.1, 0.05, 0.1
SECONDS = 6.5
BEGIN = 0.1
"""The network is started here; before it is configured, where the capture shows that."""
DOWN, UP = 2.5, 2.8
"""All nodes are Pre-operational between these."""
REACTION = 0.0035
"""From a command to the state that a node's heartbeat shows; the drive's heartbeat is due just before it is over."""

DRIVE_PDO, SLOW_PDO, INHIBITED_PDO, EVENT_PDO = 0x185, 0x285, 0x186, 0x286
"""Type 1 and type 4 of the drive; with an inhibit time and with an event timer, of the other node."""

Row = tuple[int, int, int, int]
"""Index, sub-index, value, bytes of a configured object."""

CONFIGURATION: dict[int, list[Row]] = {
    DRIVE: [
        (0x1006, 0, round(SYNC_PERIOD * 1_000_000), 4),
        (0x1007, 0, round(SYNC_WINDOW * 1_000_000), 4),
        (0x1017, 0, round(HEARTBEAT * 1000), 2),
        *[(0x1800, sub, value, size) for sub, value, size in ((1, 0x4000_0000 | DRIVE_PDO, 4), (2, 1, 1))],
        *[(0x1A00, sub, value, 4 if sub else 1) for sub, value in ((1, 0x6041_0010), (2, 0x6064_0020), (0, 2))],
        *[(0x1801, sub, value, size) for sub, value, size in ((1, 0x4000_0000 | SLOW_PDO, 4), (2, 4, 1))],
        *[(0x1A01, sub, value, 4 if sub else 1) for sub, value in ((1, 0x606C_0020), (0, 1))],
    ],
    IO: [
        (0x1017, 0, round(HEARTBEAT * 1000), 2),
        *[
            (0x1800, sub, value, size)
            for sub, value, size in (
                (1, 0x4000_0000 | INHIBITED_PDO, 4),
                (2, 255, 1),
                (3, round(INHIBIT * 10_000), 2),
                (5, 0, 2),
            )
        ],
        *[(0x1A00, sub, value, 4 if sub else 1) for sub, value in ((1, 0x2001_0010), (0, 1))],
        *[
            (0x1801, sub, value, size)
            for sub, value, size in (
                (1, 0x4000_0000 | EVENT_PDO, 4),
                (2, 255, 1),
                (3, 0, 2),
                (5, round(EVENT * 1000), 2),
            )
        ],
        *[(0x1A01, sub, value, 4 if sub else 1) for sub, value in ((1, 0x2002_0010), (0, 1))],
    ],
}
"""What is written to each node, in this order, mappings' counts last; the order of CiA 301 is made in `_configured`."""

GUARDED = 4
GUARD_TIME, LIFE_FACTOR = 0.1, 3
GUARDING: list[Row] = [(0x100C, 0, round(GUARD_TIME * 1000), 2), (0x100D, 0, LIFE_FACTOR, 1)]


@dataclass(frozen=True, slots=True)
class Session:
    """A clean capture and what is known of it."""

    frames: tuple[CanFrame, ...]
    own: frozenset[int]
    """CAN-IDs that the recording host sends, remote frames apart."""
    network: _core.Network | None = None


MASTERS = frozenset(
    {0x000, 0x080, 0x100, 0x7E5} | {0x100 * group + node for group in (2, 3, 4, 5, 6) for node in range(1, 0x80)}
)
"""CAN-IDs of the master's host: NMT, SYNC, TIME, LSS master, RPDOs, SDO clients."""


def described(rows: dict[int, list[Row]]) -> _core.Network:
    """A DCF of each node, with these values configured."""
    types = {1: 5, 2: 6, 4: 7}
    dictionaries = [
        (
            None,
            node,
            _core.Dictionary(
                file=f"node-{node}.dcf",
                form="dcf",
                device="",
                rows=[
                    (index, sub, f"{index:04X}:{sub:02X}", types[size], "rw", value, False, True, False, "", 1.0)
                    for (index, sub), (value, size) in sorted(
                        {(0x1000, 0): (0x191, 4), **{(row[0], row[1]): (row[2], row[3]) for row in objects}}.items()
                    )
                ],
            ),
        )
        for node, objects in rows.items()
    ]
    return _core.Network(descriptions=dictionaries)


def _configured(net: Network, node: int, *, with_pdos: bool) -> None:
    """Writes in the order of CiA 301: a PDO is invalid while it is changed, and so is its mapping."""
    rows = CONFIGURATION[node]
    for row in rows:
        if row[0] < 0x1400 and (with_pdos or row[0] == 0x1017):
            net.write(node, *row)
    if not with_pdos:
        return
    for communication in sorted({row[0] for row in rows if 0x1800 <= row[0] < 0x1A00}):
        parameters = {row[1]: row for row in rows if row[0] == communication}
        mapping = [row for row in rows if row[0] == communication + 0x200]
        index, sub, cob_id, size = parameters.pop(1)
        net.write(node, index, sub, cob_id | 0x8000_0000, size)
        for row in parameters.values():
            net.write(node, *row)
        net.write(node, communication + 0x200, 0, 0, 1)
        for row in mapping:
            net.write(node, *row)
        net.write(node, index, sub, cob_id, size)


def in_operation(at: float) -> bool:
    """Whether the plant's nodes are Operational at a time, with room for a PDO's delay."""
    return BEGIN + 0.005 <= at < DOWN - 0.003 or at >= UP + 0.005


def sync_times(gap_of: Callable[[int, float], float] | None = None) -> list[float]:
    """When SYNC is sent. gap_of: the gap after the n-th one, sent at that time."""
    found = [BEGIN + 0.011]
    while found[-1] < SECONDS:
        found.append(found[-1] + (gap_of(len(found) - 1, found[-1]) if gap_of else SYNC_PERIOD))
    return found[:-1]


def plant(known: Known = "written", syncs: Sequence[float] | None = None) -> Session:
    """SYNC with two synchronous PDOs, two event-driven ones, heartbeats, and SDO reads beside them.

    syncs: when SYNC is sent; none: the nodes send heartbeats and answer SDO requests, and nothing else.
    """
    net = Network()
    if known == "written":
        net.boot(DRIVE, IO)
        for node in CONFIGURATION:
            _configured(net, node, with_pdos=syncs is None or bool(syncs))
        net.now = BEGIN
        net.nmt(START)
    states = [(0.0, PRE_OPERATIONAL if known == "written" else OPERATIONAL), (BEGIN + REACTION, OPERATIONAL)]
    states += [(DOWN + REACTION, PRE_OPERATIONAL), (UP + REACTION, OPERATIONAL)]
    for node, first in ((DRIVE, 0.0031), (IO, 0.0572)):
        net.now = 0.0
        for beat in range(1, int((SECONDS - first) / HEARTBEAT) + 1):
            at = first + beat * HEARTBEAT
            net.send(0x700 + node, bytes([[state for since, state in states if since <= at][-1]]), after=at)
    cycle = 0
    for number, at in enumerate(sync_times() if syncs is None else syncs):
        net.now = at
        net.send(0x080)
        if not in_operation(at):
            cycle = 0
            continue
        cycle += 1
        net.send(DRIVE_PDO, struct.pack("<Hi", 0x0237, 100 + number), after=0.0016)
        if cycle % 4 == 0:
            net.send(SLOW_PDO, struct.pack("<i", 1000 - number), after=0.0021)
    if syncs is None or syncs:
        _event_driven(net)
    for at, command in ((DOWN, PRE_OP), (UP, START)):
        net.now = at
        net.nmt(command)
    _polls(net)
    return Session(
        tuple(jittered(net.frames(), most_us=120)), MASTERS, described(CONFIGURATION) if known == "described" else None
    )


def _event_driven(net: Network) -> None:
    """TPDO1 and TPDO2 of the other node, the one at its inhibit time, the other at its event timer."""
    for can_id, period, first in ((INHIBITED_PDO, INHIBIT, BEGIN + 0.0163), (EVENT_PDO, EVENT, BEGIN + 0.0338)):
        for since, until in ((first, DOWN), (UP + first - BEGIN, SECONDS)):
            for number in range(int((until - since) / period) + 1):
                net.now = since + number * period
                net.send(can_id, struct.pack("<H", number))


def _polls(net: Network) -> None:
    """Reads of both nodes, and now and then a longer transfer."""
    for number in range(int((SECONDS - 0.2) / 0.2)):
        net.now = 0.2 + 0.2 * number + 0.0071
        for node in (DRIVE, IO):
            net.read(node, 0x2001, 0, number, 2)
    for at, transfer in (
        (0.731, segmented_upload(Channel(DRIVE), 0x1008, 0, b"a drive with a name")),
        (1.931, block_upload(Channel(IO), 0x2010, 0, bytes(range(100)), blksize=8)),
        (3.331, block_download(Channel(DRIVE), 0x2011, 0, bytes(range(70)), blksize=5)),
        (4.731, segmented_download(Channel(IO), 0x2012, 0, bytes(range(30)))),
    ):
        place(net, at, transfer)


def place(net: Network, at: float, transfer: Iterable[CanFrame], step: float = 0.0004) -> None:
    """Frames of a transfer in even steps."""
    for number, frame in enumerate(transfer):
        net.now = at + number * step
        net.send(frame.can_id, frame.data)


def counted() -> Session:
    """SYNC with the counter of its producer, to 10; a consumer's own 1019h is another one, which concerns nobody."""
    net = Network().boot(DRIVE, IO).write(DRIVE, 0x1019, 0, 10, 1).write(DRIVE, 0x1006, 0, 10_000, 4)
    net.write(DRIVE, 0x1005, 0, 0x4000_0080, 4).read(IO, 0x1005, 0, 0x80, 4).read(IO, 0x1019, 0, 6, 1).nmt(START)
    net.now = 0.05
    net.sync(period=0.01, count=150, overflow=10)
    for node in (DRIVE, IO):
        net.live(node, period=0.1, seconds=1.5, states=[(0, OPERATIONAL)])
    return Session(tuple(net.frames()), MASTERS - {0x080})


def guarded(known: Known = "written") -> Session:
    """Guarding of one node beside the heartbeats of another, SDO between; stop and start in the middle."""
    net = Network()
    if known == "written":
        net.boot(GUARDED)
        for row in GUARDING:
            net.write(GUARDED, *row)
    toggle = 0
    for number in range(int((SECONDS - 0.05) / GUARD_TIME)):
        net.now = 0.05 + number * GUARD_TIME
        state = STOPPED if DOWN < net.now < UP else OPERATIONAL if net.now > 1.2 else PRE_OPERATIONAL
        net.send(0x700 + GUARDED, remote=True)
        net.send(0x700 + GUARDED, bytes([state | toggle]), after=0.0006)
        toggle ^= 0x80
    for at, command in ((1.18, START), (DOWN - 0.02, 0x02), (UP - 0.02, START)):
        net.now = at
        net.nmt(command, GUARDED)
    net.now = 0.0
    net.heartbeat(IO, period=0.25, count=int(SECONDS / 0.25) - 1, state=OPERATIONAL)
    for number in range(int((SECONDS - 0.4) / 0.3)):
        net.now = 0.3131 + 0.3 * number
        net.read(IO, 0x2001, 0, number, 2)
    known_rows = described({GUARDED: GUARDING}) if known == "described" else None
    return Session(tuple(jittered(net.frames(), most_us=120)), MASTERS, known_rows)


FAULTY, FAULT_REACTION, ENABLED, SWITCH_ON_DISABLED = 0x0218, 0x021F, 0x0237, 0x0250


def drive(known: Known = "written", device_type: int = 0x0002_0192) -> Session:
    """A drive that shows its statusword every 50 ms, enabled from 0.6 s on; its PDOs are read by SDO or described."""
    net = Network()
    if known == "written":
        net.boot(DRIVE).read(DRIVE, 0x1000, 0, device_type, 4)
        net.read_pdo(DRIVE, 1, [(0x6041, 0, 16)], can_id=DRIVE_PDO, kind=255)
        net.read_pdo(DRIVE, 1, [(0x6040, 0, 16)], can_id=0x205, kind=255, transmit=False)
    net.now = 0.05
    net.nmt(START, DRIVE)
    words = [(0.0, SWITCH_ON_DISABLED), (0.3, 0x0231), (0.4, 0x0233), (0.5, ENABLED)]
    for at, controlword in ((0.291, 0x06), (0.391, 0x07), (0.491, 0x0F)):
        net.now = at
        net.send(0x205, struct.pack("<H", controlword))
    for number in range(int((SECONDS - 0.1) / 0.05)):
        net.now = 0.06 + 0.05 * number
        net.send(DRIVE_PDO, struct.pack("<H", [word for since, word in words if since <= net.now][-1]))
    net.now = 0.0
    net.heartbeat(DRIVE, period=0.5, count=int(SECONDS / 0.5) - 1, state=OPERATIONAL)
    rows: list[Row] = [
        (0x1000, 0, device_type, 4),
        (0x1017, 0, 500, 2),
        (0x1400, 1, 0x205, 4),
        (0x1400, 2, 255, 1),
        (0x1600, 0, 1, 1),
        (0x1600, 1, 0x6040_0010, 4),
        (0x1800, 1, 0x4000_0185, 4),
        (0x1800, 2, 255, 1),
        (0x1A00, 0, 1, 1),
        (0x1A00, 1, 0x6041_0010, 4),
        (0x6040, 0, 0, 2),
        (0x6041, 0, 0, 2),
    ]
    return Session(tuple(net.frames()), MASTERS, described({DRIVE: rows}) if known == "described" else None)


def transfers() -> Session:
    """SDO transfers of every kind one after the other, to two nodes, beside heartbeats."""
    net = Network().boot(DRIVE, IO)
    for round_ in range(4):
        for number, node in enumerate((DRIVE, IO)):
            channel, since = Channel(node), 0.1 + 0.5 * round_ + 0.21 * number
            place(net, since, segmented_upload(channel, 0x1008, 0, b"what is in it"))
            place(net, since + 0.02, block_upload(channel, 0x2004, 0, bytes(90), blksize=4, acknowledged=[2]))
            place(net, since + 0.05, block_download(channel, 0x2004, 0, bytes(range(90)), blksize=6))
            place(net, since + 0.08, segmented_download(channel, 0x2005, 0, bytes(40)))
            refused = [
                Channel(node).client(b"\x2f\x00\x60\x00\x01"),
                Channel(node).server(abort(0x6000, 0, 0x0601_0002)),
            ]
            place(net, since + 0.11, refused)
    net.now = 0.0
    for node in (DRIVE, IO):
        net.live(node, period=0.1, seconds=2.2, states=[(0, PRE_OPERATIONAL)])
    return Session(tuple(net.frames()), MASTERS)


def slow() -> Session:
    """Two minutes of a quiet network: heartbeats of 1 s, a PDO with an event timer of 0.5 s, a read now and then."""
    net = Network().boot(DRIVE, IO).write(DRIVE, 0x1017, 0, 1000, 2).write(IO, 0x1017, 0, 1000, 2)
    net.set_pdo(IO, 1, [(0x2001, 0, 16)], event=500, inhibit=1000).nmt(START)
    for node, first in ((DRIVE, 0.21), (IO, 0.43)):
        net.now = first
        net.live(node, period=1.0, seconds=119.0, states=[(0, OPERATIONAL)])
    net.now = 0.3
    net.cyclic(INHIBITED_PDO, period=0.5, payloads=[struct.pack("<H", k) for k in range(239)])
    for number in range(11):
        net.now = 5.037 + number * 10
        net.read(DRIVE, 0x2001, 0, number, 2)
    return Session(tuple(jittered(net.frames(), most_us=200)), MASTERS)


def reset() -> Session:
    """A node is reset by a command, boots, is configured and started again; the other goes on."""
    net = Network().boot(DRIVE, IO)
    for node in (DRIVE, IO):
        net.write(node, 0x1017, 0, 100, 2)
    net.now = 0.05
    net.live(DRIVE, period=0.1, seconds=4.0, states=[(0, PRE_OPERATIONAL)])
    net.live(IO, period=0.1, seconds=1.4, states=[(0, PRE_OPERATIONAL)])
    net.now = 1.5
    net.nmt(RESET_NODE, IO).wait(0.4).boot(IO).write(IO, 0x1017, 0, 100, 2)
    net.live(IO, period=0.1, seconds=2.0, states=[(0, PRE_OPERATIONAL), (0.5, OPERATIONAL)]).wait(0.45)
    net.nmt(START, IO)
    return Session(tuple(net.frames()), MASTERS)


@cache
def built(name: str, known: Known) -> Session:
    """A plant of this name, made once."""
    return PLANTS[name](known)


def calm(known: Known = "written") -> Session:
    """The same network with its SYNC and its PDOs switched off: the bus is silent for most of the time."""
    return plant(known, [])


PLANTS: dict[str, Callable[[Known], Session]] = {"plant": plant, "calm": calm, "guarded": guarded, "drive": drive}
"""Those that the faults are put into, by what is known of them."""


def as_made(frames: Iterable[CanFrame], own: Iterable[int] = MASTERS) -> Session:
    """Frames of another generator or of a recording."""
    return Session(tuple(replace(frame) for frame in frames), frozenset(own))
