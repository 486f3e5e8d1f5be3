"""Nodes that notice what goes wrong around them, and say so, as CiA 301 and CiA 402 have it.

Why it exists: the nodes of `network_nodes.py` live in a world in which nothing fails. Here they watch heartbeats
(1016h), guarding, RPDOs (1400h:05) and SYNC (1006h), report by EMCY and error register, leave Operational (1029h),
refuse or ignore SDO requests, restart, and lose supply or cable. What makes nodes of different makers differ is a
field of `Habits`. What it must not do: read what canalyze says, or do what no real node would.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import can
import canopen
from network_nodes import (
    OPERATIONAL,
    PRE_OPERATIONAL,
    STATE_OF_COMMAND,
    STOPPED,
    U8,
    U16,
    U32,
    Account,
    Device,
    Object,
    Timers,
)
from story_wire import Socket, Wire

HEARTBEAT_LOST, RPDO_LATE, PDO_TOO_SHORT, SYNC_LOST = 0x8130, 0x8250, 0x8210, 0x8700
COMMUNICATION_BIT, GENERIC_BIT = 0x10, 0x01
NO_OBJECT, READ_ONLY, NOT_MAPPABLE, OUT_OF_RANGE, NOT_IN_THIS_STATE, NO_SUB = (
    0x06020000,
    0x06010002,
    0x06040041,
    0x06090030,
    0x08000022,
    0x06090011,
)
NO_ACCESS = 0x06010000
SAVE = 0x65766173

Rows = list[tuple[int, int, int, str, int]]
"""Index, sub-index, type, access, value."""
Mapping = tuple[int, ...]
"""Entries as 1600h and 1A00h hold them: index, sub-index, bits."""


@dataclass(frozen=True)
class Pdo:
    """A PDO as the node has it after power-up: COB-ID (0: of the node, invalid bit set), type, event time in ms."""

    cob_id: int
    kind: int
    mapping: Mapping
    event_ms: int = 0
    inhibit_100us: int = 0


@dataclass
class Habits:
    """In what nodes of different makers differ."""

    boot_s: float = 0.3
    """From power-up or reset command to the boot-up message."""
    reaction_s: float = 0.0
    """From noticing an error to reacting to it."""
    self_starting: bool = False
    """Enters Operational after the boot-up without a command (1F80h)."""
    refuses_start: bool = False
    """Stays Pre-operational while the error register is not 0."""
    sync_code: int = SYNC_LOST
    emcy_first: bool = True
    """The EMCY of a drive's fault goes out before the statusword; no: after it."""
    detail: bool = False
    """Puts which of the watched nodes it was into the EMCY, as some stacks do."""


def rows_of_pdos(base: int, pdos: Iterable[Pdo]) -> Rows:
    """Communication and mapping records from 1400h or 1800h."""
    rows: Rows = []
    for number, pdo in enumerate(pdos):
        record, mapping = base + number, base + 0x200 + number
        rows += [(record, 0, U8, "ro", 6 if base == 0x1800 else 5), (record, 1, U32, "rw", pdo.cob_id)]
        rows += [(record, 2, U8, "rw", pdo.kind), (record, 3, U16, "rw", pdo.inhibit_100us)]
        rows += [(record, 5, U16, "rw", pdo.event_ms)]
        if base == 0x1800:
            rows.append((record, 6, U8, "rw", 0))
        entries = [*pdo.mapping, *[0] * (8 - len(pdo.mapping))]
        rows.append((mapping, 0, U8, "rw", len(pdo.mapping)))
        rows += [(mapping, sub, U32, "rw", entry) for sub, entry in enumerate(entries, 1)]
    return rows


def communication_rows(
    node: int,
    *,
    heartbeat_ms: int = 300,
    consumers: Iterable[tuple[int, int]] = (),
    behaviour: int = 0,
    sync_us: int = 0,
    sync_producer: bool = False,
    guarding: tuple[int, int] = (0, 0),
    emcy_inhibit_100us: int = 0,
    device_type: int = 0x00030191,
    product: int = 1,
    serial: int | None = None,
) -> Rows:
    """What CiA 301 has in every node; consumers are pairs of node and ms, guarding is 100Ch in ms and 100Dh."""
    entries = [watched << 16 | ms for watched, ms in consumers]
    entries += [0] * (4 - len(entries))
    return [
        (0x1000, 0, U32, "ro", device_type),
        (0x1001, 0, U8, "ro", 0),
        (0x1003, 0, U8, "rw", 0),
        (0x1003, 1, U32, "ro", 0),
        (0x1005, 0, U32, "rw", 0x4000_0080 if sync_producer else 0x80),
        (0x1006, 0, U32, "rw", sync_us),
        (0x100C, 0, U16, "rw", guarding[0]),
        (0x100D, 0, U8, "rw", guarding[1]),
        (0x1010, 0, U8, "ro", 1),
        (0x1010, 1, U32, "rw", 1),
        (0x1014, 0, U32, "rw", 0x80 + node),
        (0x1015, 0, U16, "rw", emcy_inhibit_100us),
        (0x1016, 0, U8, "ro", 4),
        *[(0x1016, sub, U32, "rw", entry) for sub, entry in enumerate(entries, 1)],
        (0x1017, 0, U16, "rw", heartbeat_ms),
        (0x1018, 0, U8, "ro", 4),
        (0x1018, 1, U32, "ro", 0x03A5),
        (0x1018, 2, U32, "ro", product),
        (0x1018, 3, U32, "ro", 0x0001_0004),
        (0x1018, 4, U32, "ro", 4000 + node if serial is None else serial),
        (0x1029, 0, U8, "ro", 1),
        (0x1029, 1, U8, "rw", behaviour),
        (0x1F50, 0, U8, "ro", 1),
        (0x1F50, 1, U32, "wo", 0),
        (0x1F51, 0, U8, "ro", 1),
        (0x1F51, 1, U8, "rw", 1),
    ]


IO_ROWS: Rows = [
    (0x6000, 0, U8, "ro", 2),
    (0x6000, 1, U8, "ro", 0),
    (0x6000, 2, U8, "ro", 0),
    (0x6200, 0, U8, "ro", 2),
    (0x6200, 1, U8, "rw", 0),
    (0x6200, 2, U8, "rw", 0),
    (0x6401, 0, U8, "ro", 2),
    (0x6401, 1, U16, "ro", 0),
    (0x6401, 2, U16, "ro", 0),
    (0x6411, 0, U8, "ro", 1),
    (0x6411, 1, U16, "rw", 0),
]
IO_INPUTS: Mapping = (0x6000_0108, 0x6000_0208, 0x6401_0110)
IO_OUTPUTS: Mapping = (0x6200_0108, 0x6411_0110)


def dictionary(rows: Rows) -> Any:
    """The object dictionary of these rows."""
    od: Any = canopen.ObjectDictionary()  # type: ignore[no-untyped-call]
    records = {index for index, sub, *_ in rows if sub}
    for index, sub, kind, access, value in rows:
        variable = canopen.objectdictionary.ODVariable(f"{index:04X}:{sub}", index, sub)
        variable.data_type, variable.access_type, variable.default = kind, access, value
        if index not in records:
            od.add_object(variable)
            continue
        if index not in od:
            od.add_object(canopen.objectdictionary.ODRecord(f"{index:04X}", index))
        od[index].add_member(variable)
    return od


class Deadline:
    """Something that must come again and again; calls when it did not come in time."""

    def __init__(self, timers: Timers, call: Callable[[], None]) -> None:
        """Not running."""
        self._timers, self._call = timers, call
        self._generation = 0

    def put_off(self, seconds: float) -> None:
        """It came: so long from now on it may stay away."""
        self._generation += 1
        mine = self._generation
        self._timers.after(seconds, lambda: self._over(mine))

    def stop(self) -> None:
        """It need not come any more."""
        self._generation += 1

    def _over(self, generation: int) -> None:
        if generation == self._generation:
            self._call()


class StoryDevice(Device):
    """A node that watches, reports and reacts."""

    def __init__(
        self, wire: Wire, account: Account, timers: Timers, node: int, rows: Rows, habits: Habits | None = None
    ) -> None:
        """Without supply: `power_up` brings it to the bus."""
        self.wire, self.habits = wire, habits or Habits()
        super().__init__(account, timers, node, dictionary(rows))
        self.errors: dict[Any, tuple[int, int]] = {}
        """What is wrong now: EMCY code and bits of the error register."""
        self.refusals: dict[Object, int] = {}
        """Objects whose writing is refused, with the abort code."""
        self.mute: set[Object] = set()
        """Objects for which requests get no answer."""
        self.save_s = 0.0
        """How long storing parameters (1010h) keeps it from everything else."""
        self.deaf = False
        """The SDO server answers nothing."""
        self.stays_away = False
        """Does not boot."""
        self._watches: dict[Any, Deadline] = {}
        self._produces: Callable[[], None] | None = None
        self._emcy_free_at = 0.0
        self.role = ""

    # -- supply and cable

    @property
    def socket(self) -> Socket:
        """Its place on the wire."""
        assert isinstance(self.network.bus, Socket)
        return self.network.bus

    def connect(self) -> None:
        """As Device, but on the wire."""
        self.network.listeners = [self._on_frame]  # type: ignore[list-item]
        self.network.bus = Socket(self.wire)
        self.network.connect()

    def power_up(self, after: float | None = None) -> None:
        """Supply is there: the boot-up follows."""
        if not self.stays_away:
            self.timers.after(self.habits.boot_s if after is None else after, self.boot)

    def power_off(self) -> None:
        """Supply is gone: at once, without a word."""
        with self.account.lock:
            self.wire.empty(self.socket)
            self._quiet()
            self.state = None

    def stand_still(self, seconds: float) -> None:
        """Its processor is busy with something else: nothing is sent, nothing taken, then it goes on."""
        with self.account.lock:
            state, self.state = self.state, None

            def goes_on() -> None:
                self.state = state

            self.timers.after(seconds, goes_on)

    def restart(self) -> None:
        """The watchdog bites, or the supply dips: off and on again."""
        self.power_off()
        self.power_up()

    def pull_cable(self) -> None:
        """It goes on, but alone."""
        self.wire.plug(self.socket, False)

    def plug_cable(self) -> None:
        """It is there again."""
        self.wire.plug(self.socket, True)

    def entered(self) -> None:
        self.errors.clear()
        self.values[0x1001, 0] = 0
        if self.number(0x1005) & 0x4000_0000:
            self._produce_sync()
        if self.habits.self_starting:
            self.timers.after(0.02, lambda: self._on_nmt(0x01))

    def _quiet(self) -> None:
        super()._quiet()
        for watch in self._watches.values():
            watch.stop()
        if self._produces is not None:
            self._produces()
            self._produces = None

    # -- errors

    def emcy(self, code: int, register: int, manufacturer: bytes = b"") -> None:
        """As Device, but not sooner than the inhibit time (1015h, in 100 us) after the one before."""
        with self.account.lock:
            now = time.monotonic()
            due = max(now, self._emcy_free_at)
            self._emcy_free_at = due + self.number(0x1015) / 10_000
            if due == now:
                super().emcy(code, register, manufacturer)
            else:
                self.timers.at(due, lambda: super(StoryDevice, self).emcy(code, register, manufacturer))

    def raise_error(self, key: Any, code: int, bits: int, detail: bytes = b"") -> None:
        """An error has come: EMCY and error register, then what the node does about it."""
        with self.account.lock:
            if key in self.errors or self.state is None:
                return
            self.errors[key] = code, bits | GENERIC_BIT
            self.emcy(code, self._register(), detail)
            if bits & COMMUNICATION_BIT:
                self.timers.after(self.habits.reaction_s, self.on_communication_error)

    def take_back(self, key: Any) -> None:
        """An error has gone: EMCY 0000h with what is left in the error register."""
        with self.account.lock:
            if self.errors.pop(key, None) is not None:
                self.emcy(0x0000, self._register())

    def _register(self) -> int:
        whole = 0
        for _, bits in self.errors.values():
            whole |= bits
        return whole

    def on_communication_error(self) -> None:
        """Error behaviour 1029h:01: 0 Pre-operational, 1 as it was, 2 Stopped."""
        target = {0: PRE_OPERATIONAL, 2: STOPPED}.get(self.number(0x1029, 1))
        if target is not None and self.state == OPERATIONAL:
            self._on_nmt(next(command for command, state in STATE_OF_COMMAND.items() if state == target))

    # -- what it receives

    def _on_frame(self, message: can.Message) -> None:
        with self.account.lock:
            if self.state is None or message.is_error_frame or message.is_extended_id:
                return
            watched = message.arbitration_id - 0x700
            if 1 <= watched <= 127 and watched != self.id and not message.is_remote_frame and message.data:
                self._on_heartbeat(watched)
            if message.is_remote_frame and message.arbitration_id == 0x700 + self.id:
                self._on_guarding()
        super()._on_frame(message)

    def _on_heartbeat(self, watched: int) -> None:
        for sub in range(1, 5):
            entry = self.number(0x1016, sub)
            if entry >> 16 == watched and entry & 0xFFFF:
                self._watch(("heartbeat", watched), lambda sub=sub: self.heartbeat_lost(watched, sub)).put_off(  # type: ignore[misc]
                    (entry & 0xFFFF) / 1000
                )
                self.take_back(("heartbeat", watched))

    def heartbeat_lost(self, watched: int, sub: int) -> None:
        """The heartbeat of a watched node stayed away."""
        detail = bytes([0, 0x1B, sub - 1]) if self.habits.detail else b""
        self.raise_error(("heartbeat", watched), HEARTBEAT_LOST, COMMUNICATION_BIT, detail)

    def _on_guarding(self) -> None:
        life = self.number(0x100C) * self.number(0x100D) / 1000
        if life:
            self._watch("guarding", lambda: self.raise_error("guarding", HEARTBEAT_LOST, COMMUNICATION_BIT)).put_off(
                life
            )
            self.take_back("guarding")

    def _on_rpdo(self, can_id: int, data: bytes) -> None:
        for number in self.rpdos():
            if self.cob_id(0x1400, number) & 0x8000_07FF != can_id or self.state != OPERATIONAL:
                continue
            wanted = sum(bits for _, bits in self.mapping(0x1600, number)) // 8
            if len(data) < wanted:
                self.raise_error(("length", number), PDO_TOO_SHORT, COMMUNICATION_BIT)
                return
            self.take_back(("length", number))
            if event := self.number(0x1400 + number - 1, 5):
                key = ("rpdo", number)
                self._watch(key, lambda key=key: self._rpdo_late(key)).put_off(event / 1000)  # type: ignore[misc]
                self.take_back(key)
        super()._on_rpdo(can_id, data)

    def _rpdo_late(self, key: Any) -> None:
        if self.state == OPERATIONAL:
            self.raise_error(key, RPDO_LATE, COMMUNICATION_BIT)

    def _on_sync(self, counter: int | None) -> None:
        period = self.number(0x1006)
        if period and not self.number(0x1005) & 0x4000_0000:
            self._watch("sync", self.sync_lost).put_off(period * 2.5e-6)
            self.take_back("sync")
        super()._on_sync(counter)

    def sync_lost(self) -> None:
        """SYNC stayed away for two and a half periods; matters in Operational only."""
        if self.state == OPERATIONAL:
            self.raise_error("sync", self.habits.sync_code, COMMUNICATION_BIT)

    def _watch(self, key: Any, call: Callable[[], None]) -> Deadline:
        return self._watches.setdefault(key, Deadline(self.timers, call))

    def _produce_sync(self) -> None:
        if self._produces is None and (period := self.number(0x1006)):

            def produce() -> None:
                self.send(0x080, b"")
                super(StoryDevice, self)._on_sync(None)

            self._produces = self.timers.every(period / 1_000_000, produce)

    # -- NMT

    def _on_nmt(self, command: int) -> None:
        if command == 0x01 and self.habits.refuses_start and self.errors:
            return
        if command in (0x81, 0x82):
            self._quiet()
            self.state = None
            self.power_up()
            return
        super()._on_nmt(command)

    def leave_operational(self) -> None:
        """By itself, without a command or an error."""
        with self.account.lock:
            self._on_nmt(0x80)

    # -- SDO

    def _on_sdo(self, server: Any, data: bytes) -> None:
        index, sub = struct.unpack_from("<HB", data, 1)
        if self.deaf or (index, sub) in self.mute:
            return
        code = self._refused(index, sub, data)
        if code is not None and self.state in (PRE_OPERATIONAL, OPERATIONAL):
            self.network.send_message(0x580 + self.id, struct.pack("<BHBI", 0x80, index, sub, code))
            return
        super()._on_sdo(server, data)

    def _refused(self, index: int, sub: int, data: bytes) -> int | None:
        """The abort code of a write that is not taken: by the table, or by the rules of PDO mapping."""
        if data[0] & 0xE0 != 0x20:
            return None
        if (index, sub) in self.refusals:
            return self.refusals[index, sub]
        if not (0x1600 <= index <= 0x17FF or 0x1A00 <= index <= 0x1BFF):
            return None
        try:
            self.local.get_data(index, sub)
        except canopen.SdoAbortedError:
            return None
        valid = not self.number(index - 0x200, 1) & 0x8000_0000
        if valid:
            return NOT_IN_THIS_STATE if self.state == OPERATIONAL else NO_ACCESS
        if sub and self.number(index, 0):
            return NO_ACCESS
        entry = int.from_bytes(data[4:8], "little")
        return NOT_MAPPABLE if sub and entry and not self._has(entry >> 16, entry >> 8 & 0xFF) else None

    def _has(self, index: int, sub: int) -> bool:
        try:
            self.local.get_data(index, sub)
        except canopen.SdoAbortedError:
            return False
        return True

    def after_write(self, index: int, sub: int) -> None:
        if index == 0x1016:
            watched = self.number(index, sub) >> 16
            for key in [key for key in self._watches if key == ("heartbeat", watched)]:
                self._watches.pop(key).stop()
        if index == 0x1010 and self.save_s and self.number(0x1010, sub) == SAVE:
            self.timers.after(0.001, lambda: self.stand_still(self.save_s))
        if index == 0x1005 and self.number(0x1005) & 0x4000_0000:
            self._produce_sync()
        super().after_write(index, sub)


class IoDevice(StoryDevice):
    """Inputs that move a little, so that its TPDOs look alive."""

    _stop_inputs: Callable[[], None] | None = None

    def entered(self) -> None:
        super().entered()
        self.values |= {(0x6000, 1): 0x11, (0x6000, 2): 0x80, (0x6401, 1): 900}
        self.values |= {(0x6200, 1): 0, (0x6200, 2): 0, (0x6411, 1): 0}
        self._ticks = 0
        self._stop_inputs = self.timers.every(0.25, self._move)

    def _quiet(self) -> None:
        super()._quiet()
        if self._stop_inputs is not None:
            self._stop_inputs()

    def _move(self) -> None:
        self._ticks += 1
        level = 900 + 17 * abs(16 - self._ticks % 32)
        self.show({(0x6401, 1): level, (0x6000, 1): 0x11 + (self._ticks // 8) % 4})
