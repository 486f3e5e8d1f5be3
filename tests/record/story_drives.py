"""Drives of one or more axes that fault, stop and refuse to go as CiA 402 has it, for recorded stories.

Why it exists: what goes wrong with a machine is seen first at its drives. An axis n has its objects n times 800h
higher. What it must not do: take a fault reset without an edge of bit 7, or while the cause of the fault stands.
"""

from __future__ import annotations

from typing import Any

from network_nodes import OPERATIONAL, STATUSWORDS, TRANSITIONS, U8, U16, U32, Object, command_of
from story_nodes import Mapping, Rows, StoryDevice

AXIS_STEP = 0x800
CONTROLWORD, STATUSWORD, REACTION, ERROR_CODE = 0x6040, 0x6041, 0x6007, 0x603F
MODE, MODE_SHOWN, POSITION, TARGET = 0x6060, 0x6061, 0x6064, 0x607A
VOLTAGE_BIT, RESET_BIT = 0x10, 0x80
NO_ACTION, FAULT, DISABLE_VOLTAGE, QUICK_STOP = 0, 1, 2, 3
"""What 6007h asks for when the connection is lost."""
COUNTS_PER_CYCLE = 900
I16, I32, I8 = 3, 4, 2


def axis_rows(axis: int, *, reaction: int = FAULT) -> Rows:
    """The objects of an axis, counted from 0."""
    at = axis * AXIS_STEP
    return [
        (REACTION + at, 0, I16, "rw", reaction),
        (ERROR_CODE + at, 0, U16, "ro", 0),
        (CONTROLWORD + at, 0, U16, "rw", 0),
        (STATUSWORD + at, 0, U16, "ro", 0),
        (MODE + at, 0, I8, "rw", 8),
        (MODE_SHOWN + at, 0, I8, "ro", 8),
        (POSITION + at, 0, I32, "ro", 0),
        (TARGET + at, 0, I32, "rw", 0),
        (0x6081 + at, 0, U32, "rw", 10_000),
        (0x6502 + at, 0, U32, "ro", 0xA5),
        (0x605A + at, 0, I16, "rw", 2),
        (0x6098 + at, 0, U8, "rw", 0),
    ]


def commands(axis: int = 0) -> Mapping:
    """What the RPDO of an axis carries: controlword and target position."""
    at = axis * AXIS_STEP << 16
    return (0x6040_0010 + at, 0x607A_0020 + at)


def actual(axis: int = 0) -> Mapping:
    """What the TPDO of an axis carries: statusword and actual position."""
    at = axis * AXIS_STEP << 16
    return (0x6041_0010 + at, 0x6064_0020 + at)


class Axis:
    """One axis: its state and what keeps it from going."""

    def __init__(self, drive: StoryDrive, number: int) -> None:
        """As after power-up."""
        self.drive, self.at = drive, number * AXIS_STEP
        self.number = number
        self.reset()

    def reset(self) -> None:
        """As after power-up."""
        self.state, self.last_controlword = "switch on disabled", 0
        self.causes: set[Any] = set()
        """Why a fault cannot be reset yet."""
        self.key: Any = None
        self.drive.values |= {
            (STATUSWORD + self.at, 0): self.statusword(),
            (CONTROLWORD + self.at, 0): 0,
            (ERROR_CODE + self.at, 0): 0,
            (POSITION + self.at, 0): 0,
            (TARGET + self.at, 0): 0,
        }

    def statusword(self) -> int:
        """Of the state; without bit 4 where the safe torque off is on."""
        return STATUSWORDS[self.state] & ~(VOLTAGE_BIT if self.drive.torque_off else 0)

    def go(self, state: str) -> None:
        """Takes the state and shows it."""
        self.state = state
        self.drive.show({(STATUSWORD + self.at, 0): self.statusword()})

    def command(self, controlword: int) -> None:
        """What a controlword leads to."""
        before, self.last_controlword = self.last_controlword, controlword
        if self.state == "fault":
            if controlword & ~before & RESET_BIT and not self.standing():
                self.drive.timers.after(0.002, self._recovered)
            return
        target = TRANSITIONS.get((self.state, command_of(controlword)))
        if target is not None and not (self.drive.torque_off and target != "switch on disabled"):
            self.drive.timers.after(0.002, lambda: self._reached(self.state, target))

    def standing(self) -> bool:
        """Whether what led to the fault is still there."""
        return bool(self.causes) or (self.key in self.drive.errors and self.key != ("axis", self.number))

    def _recovered(self) -> None:
        if self.state == "fault":
            self.drive.values[ERROR_CODE + self.at, 0] = 0
            self.drive.take_back(("axis", self.number))
            self.go("switch on disabled")

    def _reached(self, _before: str, target: str) -> None:
        if self.state not in ("fault", "fault reaction active") and self.state != target:
            self.go(target)

    def fault(self, code: int, bits: int = 0, cause: Any = None, *, emcy: bool = True) -> None:
        """An error of the axis itself: EMCY and states in the order the maker chose; code 0: none is told."""
        if cause is not None:
            self.causes.add(cause)
        self.key = ("axis", self.number)
        detail = bytes([self.number + 1]) if len(self.drive.axes) > 1 else b""
        if emcy and self.drive.habits.emcy_first:
            self.drive.raise_error(self.key, code, bits, detail)
        self._fall(code)
        if emcy and not self.drive.habits.emcy_first:
            self.drive.timers.after(0.006, lambda: self.drive.raise_error(("axis", self.number), code, bits, detail))

    def _fall(self, code: int) -> None:
        self.drive.values[ERROR_CODE + self.at, 0] = code
        self.go("fault reaction active")
        self.drive.timers.after(0.03, lambda: self.go("fault"))

    def connection_lost(self, key: Any, code: int, reaction: int) -> None:
        """What 6007h asks for, where the axis is moving or could."""
        if self.state not in ("operation enabled", "switched on", "quick stop active"):
            return
        if reaction == FAULT:
            self.key = key
            self._fall(code)
        elif reaction == DISABLE_VOLTAGE:
            self.go("switch on disabled")
        elif reaction == QUICK_STOP and self.state == "operation enabled":
            self.go("quick stop active")
            self.drive.timers.after(0.2, lambda: self._reached(self.state, "switch on disabled"))

    def step(self) -> None:
        """Moves towards the target, before TPDOs are sampled."""
        if self.state == "operation enabled":
            target = self.drive.values[TARGET + self.at, 0]
            target -= (target & 0x8000_0000) << 1
            position = self.drive.values[POSITION + self.at, 0]
            self.drive.values[POSITION + self.at, 0] = position + max(
                -COUNTS_PER_CYCLE, min(COUNTS_PER_CYCLE, target - position)
            )


class StoryDrive(StoryDevice):
    """A device with one axis, or as many as its dictionary has."""

    axes: tuple[Axis, ...] = ()
    torque_off = False
    """Safe torque off: no axis leaves "switch on disabled"."""

    def entered(self) -> None:
        super().entered()
        if not self.axes:
            self.axes = tuple(Axis(self, number) for number in range(8) if self._has(0x6041 + number * AXIS_STEP, 0))
        for axis in self.axes:
            axis.reset()

    def on_output(self, things: set[Object]) -> None:
        for axis in self.axes:
            if (CONTROLWORD + axis.at, 0) in things:
                axis.command(self.values[CONTROLWORD + axis.at, 0])

    def on_sync_sampled(self) -> None:
        for axis in self.axes:
            axis.step()

    def on_communication_error(self) -> None:
        for key, (code, bits) in list(self.errors.items()):
            if bits & 0x10:
                for axis in self.axes:
                    axis.connection_lost(key, code, self.number(REACTION + axis.at))
        super().on_communication_error()

    def safe_torque_off(self, on: bool, *, fault: bool) -> None:
        """The safety circuit opens or closes: the axes that were enabled fault without an EMCY, or fall back."""
        with self.account.lock:
            self.torque_off = on
            for axis in self.axes:
                if on and fault and axis.state == "operation enabled":
                    axis.causes.add("torque off")
                    axis.fault(0, emcy=False)
                elif on and axis.state not in ("fault", "fault reaction active"):
                    axis.go("switch on disabled")
                elif not on:
                    axis.causes.discard("torque off")
                    self.show({(STATUSWORD + axis.at, 0): axis.statusword()})

    @property
    def running(self) -> bool:
        """All axes are enabled in Operational."""
        return self.state == OPERATIONAL and all(axis.state == "operation enabled" for axis in self.axes)
