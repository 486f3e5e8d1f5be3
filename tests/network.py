"""Exact sequences of whole CANopen networks, with exact stamps, and single faults to put into them.

    session = Network().boot(5).heartbeat(5, period=0.1, count=20).wait(0.25).nmt(START, 5)
    log_text(session.frames())

Why it exists: a verdict on time, order or state can only be tested on a capture in which one thing is wrong and
everything else exactly right. Every call puts frames at the present time (`now`); those that are short (an SDO
exchange, a command) move the time on, those that go on beside everything else (heartbeats, SYNC, guarding) do not.
What it must not do: draw random numbers without a seed, or send what a correct node would not send.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from captures import CanFrame

START, STOP, PRE_OP, RESET_NODE, RESET_COMMUNICATION = 0x01, 0x02, 0x80, 0x81, 0x82
BOOTING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F
ANSWER = 0.0003
"""Seconds from a request to its answer."""
STEP = 0.001
"""Seconds from a short exchange to the next."""
DAYS_TO_1984 = 5113

Entry = tuple[int, int, int]
"""Index, sub-index, bits of a mapped object."""


@dataclass(frozen=True, slots=True)
class Follower:
    """A synchronous PDO: sent so many seconds after every n-th SYNC."""

    can_id: int
    data: Callable[[int], bytes]
    """The payload, from the number of the cycle, which counts from 1."""
    delay: float = 0.0005
    every: int = 1
    first: int | None = None
    """Number of the first cycle it is sent in; None: the n-th."""


class Network:
    """A capture being made. Every method gives the network back."""

    def __init__(self, bus: str = "can0", start: float = 1_700_000_000.0) -> None:
        """Empty; start is the stamp of time 0, in seconds since 1970."""
        self.bus, self.start, self.now = bus, start, 0.0
        self._placed: list[tuple[int, int, CanFrame]] = []

    # -- time and single frames

    def wait(self, seconds: float) -> Network:
        """Lets time pass."""
        self.now += seconds
        return self

    def send(self, can_id: int, data: bytes = b"", *, after: float = 0.0, remote: bool = False) -> Network:
        """One frame, so many seconds from now; the time does not move on."""
        t_us = round((self.start + self.now + after) * 1_000_000)
        self._placed.append((t_us, len(self._placed), CanFrame(self.bus, can_id, data, t_us, remote=remote)))
        return self

    def frames(self) -> list[CanFrame]:
        """Everything sent, in the order of the stamps."""
        return [frame for _, _, frame in sorted(self._placed, key=lambda placed: placed[:2])]

    # -- NMT and error control

    def boot(self, *nodes: int) -> Network:
        """Boot-ups, 2 ms apart."""
        for node in nodes:
            self.send(0x700 + node, b"\0").wait(0.002)
        return self

    def nmt(self, command: int, node: int = 0) -> Network:
        """A command; 2 ms later it is in effect."""
        return self.send(0x000, bytes([command, node])).wait(0.002)

    def heartbeat(self, node: int, *, period: float, count: int, state: int = PRE_OPERATIONAL) -> Network:
        """Heartbeats beside everything else, the first after one period."""
        for beat in range(1, count + 1):
            self.send(0x700 + node, bytes([state]), after=beat * period)
        return self

    def live(self, node: int, *, period: float, seconds: float, states: Sequence[tuple[float, int]]) -> Network:
        """Heartbeats beside everything else, in states that change at given times from now: (seconds, state)."""
        for beat in range(1, round(seconds / period) + 1):
            state = [state for since, state in states if since <= beat * period][-1]
            self.send(0x700 + node, bytes([state]), after=beat * period)
        return self

    def guarding(
        self, node: int, *, period: float, count: int, state: int = PRE_OPERATIONAL, toggle: int = 0
    ) -> Network:
        """Requests of the master and answers of the node, beside everything else, the first at once."""
        for number in range(count):
            self.send(0x700 + node, after=number * period, remote=True)
            answer = state | ((number + toggle) % 2) << 7
            self.send(0x700 + node, bytes([answer]), after=number * period + ANSWER)
        return self

    # -- SDO

    def exchange(self, node: int, request: bytes, answer: bytes) -> Network:
        """A request on the default channel and its answer."""
        self.send(0x600 + node, request.ljust(8, b"\0"))
        return self.send(0x580 + node, answer.ljust(8, b"\0"), after=ANSWER).wait(STEP)

    def write(self, node: int, index: int, sub: int, value: int, size: int) -> Network:
        """An expedited write, acknowledged."""
        data = value.to_bytes(size, "little", signed=value < 0)
        request = struct.pack("<BHB", 0x23 | (4 - size) << 2, index, sub) + data
        return self.exchange(node, request, struct.pack("<BHB", 0x60, index, sub))

    def read(self, node: int, index: int, sub: int, value: int, size: int) -> Network:
        """An expedited read, answered."""
        data = value.to_bytes(size, "little", signed=value < 0)
        answer = struct.pack("<BHB", 0x43 | (4 - size) << 2, index, sub) + data
        return self.exchange(node, struct.pack("<BHB", 0x40, index, sub), answer)

    # -- PDO

    def set_pdo(
        self,
        node: int,
        number: int,
        mapping: Iterable[Entry],
        *,
        can_id: int | None = None,
        kind: int = 255,
        inhibit: int | None = None,
        event: int | None = None,
        start_value: int | None = None,
        transmit: bool = True,
    ) -> Network:
        """A PDO configured by SDO in the order of CiA 301: invalid, parameters, mapping, valid.

        inhibit: in 100 us; event: in ms. Bit 30 of a TPDO is set: no RTR.
        """
        base = (0x180 if transmit else 0x200) + 0x100 * (number - 1) + node
        cob_id = (can_id or base) | (0x4000_0000 if transmit else 0)
        communication = (0x1800 if transmit else 0x1400) + number - 1
        table = communication + 0x200
        entries = [index << 16 | sub << 8 | bits for index, sub, bits in mapping]
        self.write(node, communication, 1, cob_id | 0x8000_0000, 4).write(node, communication, 2, kind, 1)
        for sub, value, size in ((3, inhibit, 2), (5, event, 2), (6, start_value, 1)):
            if value is not None:
                self.write(node, communication, sub, value, size)
        self.write(node, table, 0, 0, 1)
        for sub, entry in enumerate(entries, 1):
            self.write(node, table, sub, entry, 4)
        return self.write(node, table, 0, len(entries), 1).write(node, communication, 1, cob_id, 4)

    def read_pdo(
        self, node: int, number: int, mapping: Iterable[Entry], *, can_id: int, kind: int, transmit: bool = True
    ) -> Network:
        """A PDO's parameters read by SDO: how a capture shows them when nobody writes them."""
        communication = (0x1800 if transmit else 0x1400) + number - 1
        entries = [index << 16 | sub << 8 | bits for index, sub, bits in mapping]
        self.read(node, communication, 1, can_id | (0x4000_0000 if transmit else 0), 4)
        self.read(node, communication, 2, kind, 1).read(node, communication + 0x200, 0, len(entries), 1)
        for sub, entry in enumerate(entries, 1):
            self.read(node, communication + 0x200, sub, entry, 4)
        return self

    def cyclic(self, can_id: int, *, period: float, payloads: Iterable[bytes]) -> Network:
        """Frames in even steps beside everything else, the first at once."""
        for number, data in enumerate(payloads):
            self.send(can_id, data, after=number * period)
        return self

    # -- SYNC, TIME, EMCY

    def sync(self, *, period: float, count: int, overflow: int = 0, followers: Iterable[Follower] = ()) -> Network:
        """SYNC beside everything else, the first at once, with the PDOs that follow it."""
        followers = list(followers)
        for cycle in range(1, count + 1):
            after = (cycle - 1) * period
            self.send(0x080, bytes([(cycle - 1) % overflow + 1]) if overflow else b"", after=after)
            for pdo in followers:
                since = cycle - (pdo.first or pdo.every)
                if since >= 0 and since % pdo.every == 0:
                    self.send(pdo.can_id, pdo.data(cycle), after=after + pdo.delay)
        return self

    def time(self, *, period: float, count: int) -> Network:
        """TIME beside everything else, the first at once, as the stamps say."""
        for number in range(count):
            after = number * period
            days, seconds = divmod(self.start + self.now + after, 86_400)
            self.send(0x100, struct.pack("<IH", int(seconds * 1000), int(days) - DAYS_TO_1984), after=after)
        return self

    def emcy(self, node: int, code: int, register: int, manufacturer: bytes = b"") -> Network:
        """An emergency; code 0000 resets."""
        return self.send(0x080 + node, struct.pack("<HB5s", code, register, manufacturer)).wait(STEP)

    # -- LSS

    def lss(self, *request: int, answer: Sequence[int] | None = None) -> Network:
        """A request of the LSS master, and the slave's answer if there is one."""
        self.send(0x7E5, bytes(request).ljust(8, b"\0"))
        if answer is not None:
            self.send(0x7E4, bytes(answer).ljust(8, b"\0"), after=ANSWER)
        return self.wait(0.02)

    def lss_select(self, vendor: int, product: int, revision: int, serial: int) -> Network:
        """Switch state selective; the slave answers."""
        for cs, value in zip((0x40, 0x41, 0x42), (vendor, product, revision), strict=True):
            self.lss(cs, *struct.pack("<I", value))
        return self.lss(0x43, *struct.pack("<I", serial), answer=[0x44])

    def lss_fastscan(self, identity: Sequence[int]) -> Network:
        """Fastscan of one slave without node-ID; it ends in configuration state."""
        self.lss(0x51, 0, 0, 0, 0, 0x80, 0, 0, answer=[0x4F])
        for part, own in enumerate(identity):
            known = 0
            for bit in range(31, -1, -1):
                matches = (known ^ own) >> bit == 0
                self.lss(0x51, *struct.pack("<I", known), bit, part, part, answer=[0x4F] if matches else None)
                known |= 0 if matches else 1 << bit
            self.lss(0x51, *struct.pack("<I", known), 0, part, (part + 1) & 3, answer=[0x4F])
        return self

    # -- SRDO and CiA 402

    def srdo(self, can_id: int, *, period: float, payloads: Iterable[bytes], delay: float = 0.0005) -> Network:
        """Pairs beside everything else, the first at once: data on the odd CAN-ID, inverted data on the next."""
        for number, data in enumerate(payloads):
            self.send(can_id, data, after=number * period)
            self.send(can_id + 1, bytes(byte ^ 0xFF for byte in data), after=number * period + delay)
        return self

    def drive(self, node: int, steps: Iterable[tuple[int, int]], *, pause: float = 0.1) -> Network:
        """Controlwords by RPDO1 and the statuswords that TPDO1 answers with 5 ms later."""
        for controlword, statusword in steps:
            self.send(0x200 + node, struct.pack("<H", controlword))
            self.send(0x180 + node, struct.pack("<H", statusword), after=0.005).wait(pause)
        return self


# Single faults. Each takes frames in order and gives the changed ones, with the places of the fault among them.

Frames = list[CanFrame]
Changed = tuple[Frames, list[int]]
"""The frames, and indices at which a finding about the fault may stand (as its frame or as its cause)."""
Fault = Callable[[Frames], Changed]


def find(frames: Sequence[CanFrame], can_id: int, number: int) -> int:
    """The index of the n-th frame on a CAN-ID; from the end if negative."""
    return [at for at, frame in enumerate(frames) if frame.can_id == can_id][number]


def drop(can_id: int, number: int, count: int = 1) -> Fault:
    """Frames missing: so many on this CAN-ID, from the n-th on. Place: from the one before to the one after on it."""

    def fault(frames: Frames) -> Changed:
        first = find(frames, can_id, number)
        missing = [at for at, frame in enumerate(frames) if at >= first and frame.can_id == can_id][:count]
        left = [frame for at, frame in enumerate(frames) if at not in missing]
        after = [at for at in range(missing[-1] - len(missing) + 1, len(left)) if left[at].can_id == can_id]
        return left, list(range(_before(left, first, can_id), after[0] + 1 if after else len(left)))

    return fault


def drop_answers(can_id: int, number: int) -> Fault:
    """The answers to two guarding requests in a row missing, from the n-th frame on this CAN-ID on."""

    def fault(frames: Frames) -> Changed:
        once, _ = drop(can_id, number)(frames)
        return drop(can_id, number + 1)(once)

    return fault


def drop_exchange(node: int, number: int) -> Fault:
    """The n-th request of the client on the default channel and the answer to it missing."""

    def fault(frames: Frames) -> Changed:
        at = find(frames, 0x600 + node, number)
        answer = next(i for i in range(at, len(frames)) if frames[i].can_id == 0x580 + node)
        left = [frame for i, frame in enumerate(frames) if i not in (at, answer)]
        return left, list(range(at, len(left)))

    return fault


def _before(frames: Frames, at: int, can_id: int) -> int:
    """The last frame on this CAN-ID before an index, or the index."""
    earlier = [i for i in range(min(at, len(frames))) if frames[i].can_id == can_id]
    return earlier[-1] if earlier else max(at - 1, 0)


def shift(can_id: int, number: int, milliseconds: float) -> Fault:
    """One frame later (or earlier). Place: the frame itself and the next two on its CAN-ID."""

    def fault(frames: Frames) -> Changed:
        at = find(frames, can_id, number)
        moved = replace(frames[at], t_us=frames[at].t_us + round(milliseconds * 1000))
        new = sorted([*frames[:at], *frames[at + 1 :], moved], key=lambda frame: frame.t_us)
        here = new.index(moved)
        later = [i for i in range(here + 1, len(new)) if new[i].can_id == can_id][:2]
        return new, [here, *later]

    return fault


def change(can_id: int, number: int, byte: int, value: int) -> Fault:
    """One byte of one frame. Place: the frame and the next on its CAN-ID."""

    def fault(frames: Frames) -> Changed:
        at = find(frames, can_id, number)
        data = bytearray(frames[at].data)
        data[byte] = value
        return _put(frames, at, bytes(data))

    return fault


def payload(can_id: int, number: int, data: bytes) -> Fault:
    """The whole payload of one frame. Place: the frame and the next on its CAN-ID."""
    return lambda frames: _put(frames, find(frames, can_id, number), data)


def _put(frames: Frames, at: int, data: bytes) -> Changed:
    new = [*frames[:at], replace(frames[at], data=data), *frames[at + 1 :]]
    later = [i for i in range(at + 1, len(new)) if new[i].can_id == new[at].can_id][:1]
    return new, [at, *later]


def from_there_on(can_id: int, number: int, data: bytes) -> Fault:
    """The payload of that frame and of all later ones on its CAN-ID. Place: that frame and everything after."""

    def fault(frames: Frames) -> Changed:
        at = find(frames, can_id, number)
        new = [replace(f, data=data) if i >= at and f.can_id == can_id else f for i, f in enumerate(frames)]
        return new, list(range(at, len(new)))

    return fault


def duplicate(can_id: int, number: int, milliseconds: float) -> Fault:
    """One frame a second time, so much later. Place: the copy and the original."""

    def fault(frames: Frames) -> Changed:
        at = find(frames, can_id, number)
        copy = replace(frames[at], t_us=frames[at].t_us + round(milliseconds * 1000))
        new = sorted([*frames, copy], key=lambda frame: frame.t_us)
        return new, [i for i, frame in enumerate(new) if frame in (copy, frames[at])]

    return fault


def add(*sent: tuple[float, int, bytes | None], later: bool = False) -> Fault:
    """More frames: seconds from the first, CAN-ID, data (None: remote). Place: they; later: and all after them."""

    def fault(frames: Frames) -> Changed:
        more = [
            CanFrame(frames[0].bus, can_id, data or b"", frames[0].t_us + round(at * 1_000_000), remote=data is None)
            for at, can_id, data in sent
        ]
        new = sorted([*frames, *more], key=lambda frame: frame.t_us)
        places = [i for i, frame in enumerate(new) if frame in more]
        return new, list(range(places[0], len(new))) if later else places

    return fault


# Ways in which a clean capture may look and still be clean.


def jittered(frames: Frames, *, most_us: int = 300, seed: int = 1) -> Frames:
    """Stamps late by up to so much, as system time stamps are; the order stays."""
    chance = random.Random(seed)
    last, new = 0, []
    for frame in frames:
        last = max(last, frame.t_us + chance.randrange(most_us + 1))
        new.append(replace(frame, t_us=last))
    return new


def echoed_late(frames: Frames, can_ids: Iterable[int], *, within_us: int = 700, seed: int = 1) -> Frames:
    """Frames that the capturing host sent, and all requests of remote frames, one late; stamps in order.

    Only where the next frame is another's and follows soon, and there by chance.
    """
    chance, late = random.Random(seed), set(can_ids)
    new, at = list(frames), 0
    while at + 1 < len(new):
        here, following = new[at], new[at + 1]
        soon = following.t_us - here.t_us <= within_us and following.can_id not in late
        if (here.can_id in late or here.remote) and soon and chance.random() < 0.4:
            new[at], new[at + 1] = replace(following, t_us=here.t_us), replace(here, t_us=following.t_us)
            at += 1
        at += 1
    return new


def cuts(length: int, count: int = 20) -> list[tuple[int, int]]:
    """Starts and ends (first index, index after the last) of pieces of a capture: suffixes, prefixes, both."""
    steps = [length * k // (count + 1) for k in range(1, count + 1)]
    return [(step, length) for step in steps] + [(0, step) for step in steps] + [(s // 2, s) for s in steps[::4]]
