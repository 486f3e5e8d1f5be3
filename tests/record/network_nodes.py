"""Nodes that behave on a bus as CiA 301 and CiA 402 say, for recording clean sessions.

Why it exists: python-canopen answers SDO requests but leaves out most of what a node does (sending PDOs after SYNC,
inhibit time, event timer, boot-up after a reset, guarding, LSS slaves). Here a node is python-canopen's LocalNode for
the object dictionary and its SDO server, and everything else on top of it. What it must not do: decode captures.

Every frame that carries something worth comparing is entered in an `Account` by the one who sends it.
"""

from __future__ import annotations

import heapq
import itertools
import struct
import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import can
import canopen

EDS = Path(__file__).resolve().parents[2] / "eds"
INTERFACE = "vcan0"
BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F
STATE_OF_COMMAND = {0x01: OPERATIONAL, 0x02: STOPPED, 0x80: PRE_OPERATIONAL}

U8, U16, U32 = 5, 6, 7
SIZE = {U8: 1, U16: 2, U32: 4}

PLAIN_OBJECTS = [
    (0x1000, 0, U32, "ro", 0),
    (0x1001, 0, U8, "ro", 0),
    (0x100C, 0, U16, "rw", 0),
    (0x100D, 0, U8, "rw", 0),
    (0x1017, 0, U16, "rw", 0),
    *[(0x1018, sub, U8 if sub == 0 else U32, "ro", value) for sub, value in enumerate((4, 0, 0x499, 0x10000, 1))],
    *[(0x1201, s, U8 if s in (0, 3) else U32, "rw", v) for s, v in enumerate((3, 0x8000_0000, 0x8000_0000, 0))],
    *[
        (0x1301, sub, kind, "rw", value)
        for sub, kind, value in (
            (0, U8, 6),
            (1, U8, 1),
            (2, U16, 50),
            (3, U8, 20),
            (4, U8, 254),
            (5, U32, 0x107),
            (6, U32, 0x108),
        )
    ],
    *[(0x1381, s, U8 if s == 0 else U32, "rw", v) for s, v in enumerate((2, 0x2000_0110, 0x2000_0210))],
    (0x13FE, 0, U8, "rw", 0xA5),
    *[(0x1401, s, U32 if s == 1 else U8, "rw", v) for s, v in enumerate((2, 0x304, 255))],
    *[(0x1601, s, U8 if s == 0 else U32, "rw", v) for s, v in enumerate((255, 0))],
    *[
        (0x1800 + number - 1, sub, {1: U32, 3: U16, 5: U16}.get(sub, U8), "rw", value)
        for number, cob_id, kind in ((1, 0x184, 253), (5, 0x8000_0000, 255), (6, 0x4000_01E4, 255))
        for sub, value in ((0, 6), (1, cob_id), (2, kind), (3, 0), (5, 0), (6, 0))
    ],
    *[(0x1A00, s, U8 if s == 0 else U32, "rw", v) for s, v in enumerate((2, 0x2000_0110, 0x2000_0210))],
    *[(0x1A04, s, U8 if s == 0 else U32, "rw", 0) for s in range(5)],
    *[(0x1A05, s, U8 if s == 0 else U32, "rw", v) for s, v in enumerate((254, 0))],
    *[(0x2000, s, U8 if s == 0 else U16, "ro", v) for s, v in enumerate((4, 0, 0, 0, 0))],
    (0x2100, 0, U32, "rw", 0),
]
"""Index, sub-index, type, access, value of the objects of the node without an EDS."""


def plain_dictionary() -> Any:
    """The dictionary of the node without an EDS: guarding, second SDO channel, SRDO, RTR, TPDO5 and MPDO."""
    od: Any = canopen.ObjectDictionary()  # type: ignore[no-untyped-call]
    for index, sub, kind, access, value in PLAIN_OBJECTS:
        variable = canopen.objectdictionary.ODVariable(f"{index:04X}:{sub}", index, sub)
        variable.data_type, variable.access_type, variable.default = kind, access, value
        if any(other[0] == index and other[1] for other in PLAIN_OBJECTS):
            if index not in od:
                od.add_object(canopen.objectdictionary.ODRecord(f"{index:04X}", index))
            od[index].add_member(variable)
        else:
            od.add_object(variable)
    return od


Object = tuple[int, int]
"""Index and sub-index."""
Values = dict[Object, int]


class Account:
    """What was sent with which meaning, by CAN-ID and in order: one sender for each CAN-ID."""

    def __init__(self) -> None:
        """Empty."""
        self.sent: dict[int, deque[tuple[bytes, dict[str, Any]]]] = defaultdict(deque)
        self.lock = threading.RLock()

    def enter(self, can_id: int, data: bytes, **meaning: Any) -> None:
        """Notes one frame."""
        self.sent[can_id].append((data, meaning))


class Timers:
    """Calls functions later, on one thread and under the account's lock."""

    def __init__(self, lock: threading.RLock) -> None:
        """Starts the thread."""
        self._lock = lock
        self._wake = threading.Condition()
        self._due: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()
        self._running = True
        threading.Thread(target=self._run, daemon=True).start()

    def at(self, when: float, call: Callable[[], None]) -> None:
        """Calls at this reading of the monotonic clock."""
        with self._wake:
            heapq.heappush(self._due, (when, next(self._order), call))
            self._wake.notify()

    def after(self, seconds: float, call: Callable[[], None]) -> None:
        """Calls so many seconds from now."""
        self.at(time.monotonic() + seconds, call)

    def every(self, seconds: float, call: Callable[[], None]) -> Callable[[], None]:
        """Calls in even steps, the first time after one of them, until the function returned is called."""
        running = [True]
        start = time.monotonic()

        def again(step: int) -> None:
            if running[0]:
                call()
                self.at(start + (step + 1) * seconds, lambda: again(step + 1))

        self.at(start + seconds, lambda: again(1))
        return lambda: running.__setitem__(0, False)

    def stop(self) -> None:
        """Ends the thread; what is still due is not called."""
        with self._wake:
            self._running = False
            self._wake.notify()

    def _run(self) -> None:
        while True:
            with self._wake:
                while self._running and (not self._due or self._due[0][0] > time.monotonic()):
                    self._wake.wait(self._due[0][0] - time.monotonic() if self._due else None)
                if not self._running:
                    return
                call = heapq.heappop(self._due)[2]
            with self._lock:
                call()


class _Dictionary(canopen.LocalNode):
    """A LocalNode that remembers which objects the present request wrote."""

    def __init__(self, node: int, od: Any) -> None:
        super().__init__(node, od)
        self.written: list[Object] = []

    def set_data(self, index: int, subindex: int, data: bytes, check_writable: bool = False) -> None:
        """As LocalNode does it."""
        super().set_data(index, subindex, data, check_writable)
        self.written.append((index, subindex))


class Device:
    """One node: NMT slave, heartbeat or guarding, SDO server, PDOs, EMCY."""

    def __init__(self, account: Account, timers: Timers, node: int, od: str | Any) -> None:
        """Not yet on the bus: `boot` brings it up. od: a file of eds/, or an object dictionary."""
        self.account, self.timers, self.id = account, timers, node
        self.network = canopen.Network()
        self._od = od
        self._load()
        self.values: Values = {}
        """Process data: what TPDOs carry and RPDOs set; signed numbers for signed objects."""
        self.state: int | None = None
        self.stored: dict[int, dict[int, bytes]] = {}
        self.syncs = 0
        self.toggle = 0
        self.new_id: int | None = None
        """A node-ID given by LSS, taken at the next reset."""
        self._cancel: list[Callable[[], None]] = []
        self._sync_count: dict[int, int] = {}
        self._last_sent: dict[int, float] = {}
        self._event_generation: dict[int, int] = defaultdict(int)
        self._held: list[tuple[int, bytes]] = []
        self.second_channel: Any = None

    def _load(self) -> None:
        """The dictionary with the COB-IDs of the present node-ID."""
        od = canopen.import_od(str(EDS / self._od), self.id) if isinstance(self._od, str) else self._od
        self.local = _Dictionary(self.id, od)
        self.local._write_callbacks.clear()  # LocalNode's own heartbeat
        self.local.add_read_callback(self._process_value)  # type: ignore[no-untyped-call]
        self.local.sdo.network = self.network

    # -- the bus

    def connect(self) -> None:
        """Opens a socket of its own, so that nodes see each other's frames."""
        self.network.listeners = [self._on_frame]  # type: ignore[list-item]
        self.network.connect(interface="socketcan", channel=INTERFACE)

    def disconnect(self) -> None:
        """Leaves the bus."""
        self._quiet()
        self.network.disconnect()

    def send(self, can_id: int, data: bytes, **meaning: Any) -> None:
        """Sends one frame, and says what it means if that is worth comparing."""
        if meaning:
            self.account.enter(can_id, data, **meaning)
        self.network.send_message(can_id, data)

    def _on_frame(self, message: can.Message) -> None:
        with self.account.lock:
            can_id, data = message.arbitration_id, bytes(message.data)
            if message.is_error_frame or message.is_extended_id or self.state is None:
                return
            if message.is_remote_frame:
                self._on_remote(can_id)
            elif can_id == 0x000 and data[1] in (0, self.id):
                self._on_nmt(data[0])
            elif can_id == 0x080:
                self._on_sync(data[0] if data else None)
            elif can_id == 0x600 + self.id:
                self._on_sdo(self.local.sdo, data)
            elif self.second_channel is not None and can_id == self.second_channel.rx_cobid:
                self._on_sdo(self.second_channel, data)
            else:
                self._on_rpdo(can_id, data)

    # -- NMT, heartbeat, guarding

    def boot(self) -> None:
        """Initialisation is over: boot-up, then Pre-operational."""
        with self.account.lock:
            self.local.data_store = {index: dict(subs) for index, subs in self.stored.items()}
            self.toggle = 0
            self.state = PRE_OPERATIONAL
            self.send(0x700 + self.id, b"\0", boot_up=True)
            self._heartbeats()
            self.entered()

    def entered(self) -> None:
        """For drives: what happens when the node has come up."""

    def _on_nmt(self, command: int) -> None:
        if command in STATE_OF_COMMAND:
            before, self.state = self.state, STATE_OF_COMMAND[command]
            if before != self.state:
                self._sync_count.clear()
                self._held.clear()
                if self.number(0x1017):
                    self._beat()
                    self._heartbeats()
                if self.state == OPERATIONAL:
                    for tpdo in self.tpdos():
                        if self._is_event_driven(tpdo):
                            self.transmit(tpdo)
        elif command in (0x81, 0x82):
            self._quiet()
            self.state = None
            if self.new_id:
                self.id, self.new_id = self.new_id, None
                self._load()
            self.timers.after(0.03, self.boot)

    def _quiet(self) -> None:
        for cancel in self._cancel:
            cancel()
        self._cancel.clear()
        for number in self._event_generation:
            self._event_generation[number] += 1
        self._last_sent.clear()

    def _heartbeats(self) -> None:
        for cancel in self._cancel:
            cancel()
        self._cancel.clear()
        if period := self.number(0x1017):
            self._cancel.append(self.timers.every(period / 1000, self._beat))

    def _beat(self) -> None:
        if self.state is not None:
            self.send(0x700 + self.id, bytes([self.state]))

    def _on_remote(self, can_id: int) -> None:
        if can_id == 0x700 + self.id and not self.number(0x1017) and self.state is not None:
            self.send(can_id, bytes([self.toggle | self.state]))
            self.toggle ^= 0x80
        for tpdo in self.tpdos():
            cob_id = self.cob_id(0x1800, tpdo)
            allowed = not cob_id & 0xC000_0000
            if allowed and cob_id & 0x7FF == can_id and self.state == OPERATIONAL:
                self.transmit(tpdo)

    # -- SDO

    def _on_sdo(self, server: Any, data: bytes) -> None:
        if self.state not in (PRE_OPERATIONAL, OPERATIONAL):
            return
        server.on_request(0, data, 0.0)
        written, self.local.written = self.local.written, []
        for index, sub in written:
            self.after_write(index, sub)

    def after_write(self, index: int, sub: int) -> None:
        """What a write leads to once it is acknowledged."""
        if index == 0x1017:
            self._heartbeats()
        elif index == 0x1010 and self.number(index, sub) == 0x65766173:
            self.stored = {i: dict(subs) for i, subs in self.local.data_store.items() if i not in (0x1010, 0x1011)}
        elif 0x1800 <= index <= 0x19FF and sub == 1 and self.state == OPERATIONAL:
            self._sync_count.pop(index - 0x17FF, None)
            if self._is_event_driven(index - 0x17FF):
                self.transmit(index - 0x17FF)
        elif (index, sub) in self.values:
            self.values[index, sub] = self.number(index, sub)
            self.on_output({(index, sub)})

    def number(self, index: int, sub: int = 0) -> int:
        """The object's value as an unsigned number; 0 where there is none."""
        try:
            return int.from_bytes(self.local.get_data(index, sub), "little")
        except canopen.SdoAbortedError:
            return 0

    def _process_value(self, index: int, subindex: int, od: Any) -> int | None:
        return self.values.get((index, subindex)) if od.access_type == "ro" else None

    # -- PDO

    def tpdos(self) -> list[int]:
        """Numbers of the TPDOs of the dictionary."""
        return [index - 0x17FF for index in self.local.object_dictionary if 0x1800 <= index <= 0x19FF]

    def rpdos(self) -> list[int]:
        """Numbers of the RPDOs of the dictionary."""
        return [index - 0x13FF for index in self.local.object_dictionary if 0x1400 <= index <= 0x15FF]

    def cob_id(self, base: int, number: int) -> int:
        """Sub-index 1 of the communication parameter."""
        return self.number(base + number - 1, 1)

    def mapping(self, base: int, number: int) -> list[tuple[Object, int]]:
        """Objects and bit lengths, in order."""
        count = self.number(base + number - 1, 0)
        entries = [self.number(base + number - 1, sub) for sub in range(1, count + 1)] if count <= 64 else []
        return [((entry >> 16, entry >> 8 & 0xFF), entry & 0xFF) for entry in entries]

    def _type(self, tpdo: int) -> int:
        return self.number(0x1800 + tpdo - 1, 2)

    def _is_event_driven(self, tpdo: int) -> bool:
        valid = not self.cob_id(0x1800, tpdo) & 0x8000_0000
        return valid and self._type(tpdo) >= 254 and bool(self.mapping(0x1A00, tpdo))

    def transmit(self, tpdo: int, *, sync: bool = False) -> None:
        """Sends a TPDO now, or as soon as its inhibit time is over."""
        cob_id = self.cob_id(0x1800, tpdo)
        mapped = self.mapping(0x1A00, tpdo)
        if self.state != OPERATIONAL or cob_id & 0x8000_0000 or not mapped:
            return
        inhibit = self.number(0x1800 + tpdo - 1, 3) / 10_000 if self._type(tpdo) >= 254 else 0
        now = time.monotonic()
        last = self._last_sent.get(tpdo)
        # a margin, since the stamps are the kernel's and not this clock's
        if last is not None and inhibit and now < last + inhibit * 1.1 + 0.0005:
            self._event_generation[tpdo] += 1
            generation = self._event_generation[tpdo]
            self.timers.at(last + inhibit * 1.1 + 0.001, lambda: self._late_event(tpdo, generation))
            return
        signals = {thing: self.values.get(thing, self.number(*thing)) for thing, _ in mapped}
        data = pack([(signals[thing], bits) for thing, bits in mapped])
        meaning: dict[str, Any] = {"node": self.id, "pdo": f"TPDO{tpdo}", "signals": named(signals)}
        if sync:
            meaning["cycle"] = self.syncs
        self._last_sent[tpdo] = now
        self.send(cob_id & 0x7FF, data, **meaning)
        self._event_generation[tpdo] += 1
        event = self.number(0x1800 + tpdo - 1, 5)
        if event and self._type(tpdo) >= 254:
            generation = self._event_generation[tpdo]
            self.timers.at(now + event / 1000, lambda: self._late_event(tpdo, generation))

    def _late_event(self, tpdo: int, generation: int) -> None:
        if generation == self._event_generation[tpdo]:
            self.transmit(tpdo)

    def show(self, values: Values) -> None:
        """New process data; event-driven TPDOs that carry any of them go out."""
        with self.account.lock:
            changed = {thing for thing, value in values.items() if self.values.get(thing) != value}
            self.values |= values
            for tpdo in self.tpdos():
                if self._is_event_driven(tpdo) and any(t in changed for t, _ in self.mapping(0x1A00, tpdo)):
                    self.transmit(tpdo)

    def on_sync_sampled(self) -> None:
        """For drives: new process data before the TPDOs of a cycle are sampled; must not send."""

    def _on_sync(self, counter: int | None) -> None:
        self.syncs += 1
        if self.state != OPERATIONAL:
            return
        for number, data in self._held:
            self._take(number, data)
        self._held.clear()
        self.on_sync_sampled()
        for tpdo in self.tpdos():
            kind = self._type(tpdo)
            if not 1 <= kind <= 240 or self.cob_id(0x1800, tpdo) & 0x8000_0000:
                continue
            start = self.number(0x1800 + tpdo - 1, 6)
            waiting = self._sync_count.get(tpdo)
            if waiting is None and start and counter is not None:
                if counter != start:
                    continue
                waiting = 1
            waiting = (kind if waiting is None else waiting) - 1
            if waiting == 0:
                self.transmit(tpdo, sync=True)
            self._sync_count[tpdo] = waiting or kind

    def _on_rpdo(self, can_id: int, data: bytes) -> None:
        for number in self.rpdos():
            cob_id = self.cob_id(0x1400, number)
            if cob_id & 0x8000_07FF == can_id and self.state == OPERATIONAL:
                if self.number(0x1400 + number - 1, 2) <= 240:
                    self._held = [(held, old) for held, old in self._held if held != number] + [(number, data)]
                else:
                    self._take(number, data)

    def _take(self, number: int, data: bytes) -> None:
        whole, offset, set_now = int.from_bytes(data, "little"), 0, set()
        for thing, bits in self.mapping(0x1600, number):
            self.values[thing] = whole >> offset & ((1 << bits) - 1)
            set_now.add(thing)
            offset += bits
        self.on_output(set_now)

    def on_output(self, things: set[Object]) -> None:
        """For drives: these were set by an RPDO or an acknowledged SDO write."""

    # -- EMCY

    def emcy(self, code: int, register: int, manufacturer: bytes = b"") -> None:
        """An error, or with code 0 the end of one."""
        with self.account.lock:
            self.values[0x1001, 0] = register
            data = struct.pack("<HB5s", code, register, manufacturer)
            self.send(0x080 + self.id, data, emcy=True, code=code, register=register)


def pack(fields: Iterable[tuple[int, int]]) -> bytes:
    """Values and bit lengths, from bit 0 upward."""
    whole = offset = 0
    for value, bits in fields:
        whole |= (value & ((1 << bits) - 1)) << offset
        offset += bits
    return whole.to_bytes((offset + 7) // 8, "little")


def named(signals: Values) -> dict[str, int]:
    """Signals under the names they have in the truth files."""
    return {f"{index:04X}:{sub:02X}": value for (index, sub), value in signals.items()}


CONTROLWORD, STATUSWORD, MODE, MODE_DISPLAY = (0x6040, 0), (0x6041, 0), (0x6060, 0), (0x6061, 0)
POSITION, VELOCITY, TORQUE = (0x6064, 0), (0x606C, 0), (0x6077, 0)
TARGET_POSITION, TARGET_VELOCITY = (0x607A, 0), (0x60FF, 0)

STATUSWORDS = {
    "switch on disabled": 0x0250,
    "ready to switch on": 0x0231,
    "switched on": 0x0233,
    "operation enabled": 0x0237,
    "quick stop active": 0x0217,
    "fault reaction active": 0x021F,
    "fault": 0x0218,
}

TRANSITIONS: dict[tuple[str, str], str] = {
    ("switch on disabled", "shutdown"): "ready to switch on",
    ("ready to switch on", "switch on"): "switched on",
    ("ready to switch on", "disable voltage"): "switch on disabled",
    ("ready to switch on", "quick stop"): "switch on disabled",
    ("switched on", "enable operation"): "operation enabled",
    ("switched on", "shutdown"): "ready to switch on",
    ("switched on", "disable voltage"): "switch on disabled",
    ("switched on", "quick stop"): "switch on disabled",
    ("operation enabled", "switch on"): "switched on",
    ("operation enabled", "shutdown"): "ready to switch on",
    ("operation enabled", "disable voltage"): "switch on disabled",
    ("operation enabled", "quick stop"): "quick stop active",
    ("quick stop active", "disable voltage"): "switch on disabled",
    ("quick stop active", "enable operation"): "operation enabled",
}
"""CiA 402: state and command to state. The automatic transitions and the fault reset are the drive's."""


def command_of(controlword: int) -> str:
    """The command that bits 0 to 3 ask for."""
    if not controlword & 0x02:
        return "disable voltage"
    if not controlword & 0x04:
        return "quick stop"
    if not controlword & 0x01:
        return "shutdown"
    return "enable operation" if controlword & 0x08 else "switch on"


class Drive(Device):
    """A CiA 402 drive: state machine, modes, a motor that follows its targets at once."""

    drive_state = "switch on disabled"
    last_controlword = 0

    def entered(self) -> None:
        self.drive_state = "switch on disabled"
        self.last_controlword = 0
        self.values |= {STATUSWORD: STATUSWORDS[self.drive_state], CONTROLWORD: 0, MODE: 0, MODE_DISPLAY: 0}
        self.values |= dict.fromkeys((POSITION, VELOCITY, TORQUE, TARGET_POSITION, TARGET_VELOCITY), 0)

    def on_output(self, things: set[Object]) -> None:
        if MODE in things:
            self.timers.after(0.002, lambda: self.show({MODE_DISPLAY: self.values[MODE]}))
        if CONTROLWORD not in things:
            return
        controlword, before = self.values[CONTROLWORD], self.last_controlword
        self.last_controlword = controlword
        target = TRANSITIONS.get((self.drive_state, command_of(controlword)))
        if self.drive_state == "fault":
            target = "switch on disabled" if controlword & ~before & 0x80 else None
        if target is not None:
            self.timers.after(0.002, lambda: self.go(target))

    def go(self, state: str) -> None:
        """Takes the state and shows it."""
        with self.account.lock:
            self.drive_state = state
            self.show({STATUSWORD: STATUSWORDS[state]})

    def fault(self, code: int, register: int) -> None:
        """An error: EMCY, fault reaction, fault."""
        with self.account.lock:
            self.emcy(code, register)
            self.go("fault reaction active")
            self.timers.after(0.03, lambda: self.go("fault"))

    def on_sync_sampled(self) -> None:
        if self.drive_state == "operation enabled":
            target = self.values[TARGET_POSITION]
            target -= (target & 0x8000_0000) << 1
            step = max(-900, min(900, target - self.values[POSITION]))
            self.values |= {POSITION: self.values[POSITION] + step, VELOCITY: step, TORQUE: step // 30 - 1}
