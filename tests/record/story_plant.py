"""A plant whose story is recorded: wire, nodes, controller, recorder, and the account of what was done to it.

Why it exists: a scenario is then a list of what goes wrong when, and the truth is written from what was done.
What it must not do: know what canalyze makes of it.
"""

from __future__ import annotations

import json
import logging
import signal
import struct
import subprocess
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import can
import canopen
from network_nodes import U8, U16, U32, Account, Timers
from story_drives import StoryDrive, actual, axis_rows, commands
from story_log import Log, MissingFrame
from story_nodes import (
    IO_INPUTS,
    IO_OUTPUTS,
    IO_ROWS,
    Habits,
    IoDevice,
    Mapping,
    Pdo,
    StoryDevice,
    communication_rows,
    dictionary,
    rows_of_pdos,
)
from story_wire import INTERFACE, Socket, Wire

START, STOP, PRE_OP, RESET_NODE, RESET_COMMUNICATION = 0x01, 0x02, 0x80, 0x81, 0x82
CONTROLLER = 127
STACK = (
    "nodes of tests/record/story_nodes.py (python-canopen 2.4.1 for dictionary and SDO server, the rest after CiA "
    "301/402); controller: python-canopen 2.4.1 + python-can 4.6.1; vcan behind an arbiter by identifier at {rate} "
    "kbit/s; recorder: candump -L (can-utils)"
)
LONGEST_STALL_S = 0.12
"""A recording in which the machine stood still longer is thrown away."""
CANDUMP = "candump"


@dataclass
class Seen:
    """The lines of one story, as samples/README.md says; its words are in the truth of the recording."""

    begin: int
    visible: int
    end: int | None = None
    evidence: Iterable[int] = ()
    words: dict[str, str] = field(default_factory=dict)
    """Words with figures, which each recording has its own of."""

    def row(self) -> dict[str, Any]:
        """Returns what is new in an entry of `stories`."""
        lines = {self.begin, self.visible, *self.evidence, *([self.end] if self.end else [])}
        return {
            "begin_line": self.begin,
            "visible_from_line": self.visible,
            "end_line": self.end,
            "evidence_lines": sorted(lines),
            **self.words,
        }


@dataclass
class Tale:
    """The content of a recording, story by story, and where it is not the plant's doing."""

    log: Log
    seen: list[Seen]
    natural: list[dict[str, Any]] = field(default_factory=list)


class Stalls:
    """Notices when the machine itself stood still."""

    def __init__(self) -> None:
        """Starts watching."""
        self.longest = 0.0
        self._running = True
        threading.Thread(target=self._run, daemon=True).start()

    def stop(self) -> None:
        """Ends watching."""
        self._running = False

    def _run(self) -> None:
        while self._running:
            before = time.monotonic()
            time.sleep(0.01)
            self.longest = max(self.longest, time.monotonic() - before - 0.01)


class Plant:
    """Everything of one recording."""

    def __init__(self, path: Path, bit_rate: int = 250_000, buffer_bytes: int = 8_000_000) -> None:
        """Begins to record to this log; buffer_bytes is the recorder's receive buffer."""
        logging.getLogger("canopen").setLevel(logging.CRITICAL)
        self.path = path
        self.account = Account()
        self.timers = Timers(self.account.lock)
        self.wire = Wire(bit_rate)
        self.devices: dict[int, StoryDevice] = {}
        self.outputs: dict[int, dict[int, tuple[int, int]]] = {}
        """For each drive and axis: controlword and target that the controller sends."""
        self.cycles = 0
        self.controller_role = "controller (python-canopen)"
        self.others: list[dict[str, Any]] = []
        self.stop_calls: dict[str, Callable[[], None]] = {}
        self.networks: list[Any] = []
        self.master: Any = self.network()
        self._output = path.open("wb")
        self._recorder = subprocess.Popen([CANDUMP, "-L", "-r", str(buffer_bytes), INTERFACE], stdout=self._output)
        time.sleep(0.4)
        self.stalls = Stalls()

    # -- nodes

    def network(self) -> Any:
        """A further participant of python-canopen on the wire."""
        network: Any = canopen.Network()
        network.bus = Socket(self.wire)
        network.connect()
        self.networks.append(network)
        return network

    def add(self, device: StoryDevice, role: str) -> None:
        """A node, on the wire and without supply."""
        device.connect()
        device.role = role
        self.devices[device.id] = device
        if device.id not in self.master.nodes:
            self.know(self.master, device.id)

    def know(self, network: Any, node: int, patience_s: float = 1.0) -> None:
        """Makes a controller an SDO client of a node."""
        remote = network.add_node(canopen.RemoteNode(node, dictionary([])))
        remote.sdo.RESPONSE_TIMEOUT = patience_s

    def io(
        self, node: int, role: str, *, kind: int = 1, event_ms: int = 0, rpdo_event_ms: int = 0,
        rpdos: Iterable[Pdo] = (), pdo: bool = True, habits: Habits | None = None, **settings: Any,
    ) -> IoDevice:  # fmt: skip
        """An I/O node: RPDO1 sets outputs, TPDO1 shows inputs; without `pdo` both are still to be configured."""
        invalid = 0 if pdo else 0x8000_0000
        tpdo = Pdo(0x4000_0180 + node | invalid, kind, IO_INPUTS if pdo else (), event_ms)
        rpdo = Pdo(0x200 + node | invalid, 255, IO_OUTPUTS if pdo else (), rpdo_event_ms)
        rows = communication_rows(node, **settings) + IO_ROWS
        rows += rows_of_pdos(0x1400, [rpdo, *rpdos]) + rows_of_pdos(0x1800, [tpdo])
        device = IoDevice(self.wire, self.account, self.timers, node, rows, habits)
        self.add(device, f"I/O device, {role}")
        return device

    def drive(
        self, node: int, role: str, *, axes: int = 1, kind: int = 1, event_ms: int = 0, rpdo_event_ms: int = 0,
        reaction: int = 1, pdo: bool = True, habits: Habits | None = None, **settings: Any,
    ) -> StoryDrive:  # fmt: skip
        """A drive: RPDOn carries controlword and target of axis n, TPDOn statusword and position."""
        invalid = 0 if pdo else 0x8000_0000
        steps = range(axes)
        tpdos = [Pdo(0x4000_0180 + 0x100 * n + node | invalid, kind, actual(n) if pdo else (), event_ms) for n in steps]
        rpdos = [
            Pdo(0x200 + 0x100 * n + node | invalid, kind, commands(n) if pdo else (), rpdo_event_ms) for n in steps
        ]
        rows = communication_rows(node, device_type=0x0002_0192, product=2, **settings)
        for n in steps:
            rows += axis_rows(n, reaction=reaction)
        rows += rows_of_pdos(0x1400, rpdos) + rows_of_pdos(0x1800, tpdos)
        device = StoryDrive(self.wire, self.account, self.timers, node, rows, habits)
        self.add(device, f"CiA 402 drive{f' of {axes} axes' if axes > 1 else ''}, {role}")
        self.outputs[node] = dict.fromkeys(steps, (0, 0))
        return device

    def run_up(self, *drives: int, configure: Callable[[], None] | None = None, heartbeat: bool = True) -> None:
        """Power-up, configuration, cycle, NMT start; the drives are enabled."""
        if heartbeat:
            self.heartbeat()
        self.power_up()
        self.wait(0.5)
        if configure is not None:
            configure()
        self.cycle()
        self.wait(0.3)
        self.nmt(START)
        self.wait(0.5)
        self.enable(*drives)
        self.wait(1.0)

    def power_up(self, *nodes: int, apart_s: float = 0.07) -> None:
        """Supply for these, or for all; they boot one after the other."""
        for step, node in enumerate(nodes or self.devices):
            self.devices[node].power_up(0.1 + step * apart_s)
        self.wait(0.3 + len(nodes or self.devices) * apart_s)

    # -- the controller

    def heartbeat(self, milliseconds: int = 250) -> None:
        """The controller's own heartbeat, Operational."""
        self.controller_role += f", heartbeat 77F every {milliseconds} ms"
        self.stop_calls["heartbeat"] = self.timers.every(
            milliseconds / 1000, lambda: self.master.send_message(0x700 + CONTROLLER, b"\x05")
        )

    def cycle(self, milliseconds: int = 100, *, sync: bool = True) -> None:
        """SYNC, then the RPDOs of the drives; those of the I/O nodes each fifth time."""
        self.controller_role += f", {'SYNC and ' if sync else ''}RPDOs of the drives every {milliseconds} ms"
        self.stop_calls["cycle"] = self.timers.every(milliseconds / 1000, lambda: self._cycle(sync))

    def _cycle(self, sync: bool) -> None:
        self.cycles += 1
        if sync:
            self.master.send_message(0x080, b"")
        for node, axes in self.outputs.items():
            for axis, (controlword, target) in axes.items():
                self.master.send_message(0x200 + 0x100 * axis + node, struct.pack("<Hi", controlword, target))
        if self.cycles % 5 == 0:
            for node, device in self.devices.items():
                if isinstance(device, IoDevice):
                    self.master.send_message(0x200 + node, struct.pack("<BH", self.cycles // 5 & 0xFF, 10))

    def stop(self, *what: str) -> None:
        """Ends `heartbeat` or `cycle` of the controller."""
        for name in what:
            self.stop_calls.pop(name)()

    def nmt(self, command: int, node: int = 0) -> float:
        """Sends an NMT command; the time just before it."""
        before = time.time()
        self.master.send_message(0x000, bytes([command, node]))
        return before

    def guard(self, node: int, milliseconds: int) -> None:
        """Guards a node by RTR."""
        self.controller_role += f", guards {node} every {milliseconds} ms"
        request = can.Message(arbitration_id=0x700 + node, is_remote_frame=True, dlc=1, is_extended_id=False)
        self.stop_calls["guarding"] = self.timers.every(milliseconds / 1000, lambda: self.master.bus.send(request))

    def stall_recorder(self, seconds: float) -> None:
        """The recorder stands still; what does not fit into its receive buffer is lost."""
        self._recorder.send_signal(signal.SIGSTOP)
        self.wait(seconds)
        self._recorder.send_signal(signal.SIGCONT)

    def write(self, node: int, index: int, sub: int, value: int, kind: int = U32) -> bool:
        """Writes by SDO; whether it was taken."""
        size = {U8: 1, U16: 2, U32: 4}[kind]
        try:
            self.master.nodes[node].sdo.download(index, sub, value.to_bytes(size, "little"))
        except (canopen.SdoAbortedError, canopen.SdoCommunicationError):
            return False
        return True

    def load(self, node: int, index: int, sub: int, data: bytes) -> bool:
        """Writes many bytes in segments; whether they were taken."""
        try:
            self.master.nodes[node].sdo.download(index, sub, data, force_segment=True)
        except (canopen.SdoAbortedError, canopen.SdoCommunicationError):
            return False
        return True

    def read(self, node: int, index: int, sub: int = 0) -> int | None:
        """Reads by SDO; None where it was refused or not answered."""
        try:
            return int.from_bytes(self.master.nodes[node].sdo.upload(index, sub), "little")
        except (canopen.SdoAbortedError, canopen.SdoCommunicationError):
            return None

    def write_pdo(self, node: int, base: int, number: int, cob_id: int, kind: int, mapping: Mapping) -> None:
        """Configures a PDO in the order that CiA 301 wants; base 1400h or 1800h."""
        record = base + number - 1
        self.write(node, record, 1, cob_id | 0x8000_0000)
        self.write(node, record, 2, kind, U8)
        self.write(node, record + 0x200, 0, 0, U8)
        for sub, entry in enumerate(mapping, 1):
            self.write(node, record + 0x200, sub, entry)
        self.write(node, record + 0x200, 0, len(mapping), U8)
        self.write(node, record, 1, cob_id)

    def configure_drive(self, node: int, *, consumer_ms: int = 900, kind: int = 1) -> None:
        """Heartbeat consumer of the controller, RPDO1 and TPDO1."""
        self.write(node, 0x1016, 1, CONTROLLER << 16 | consumer_ms)
        self.write_pdo(node, 0x1400, 1, 0x200 + node, kind, commands())
        self.write_pdo(node, 0x1800, 1, 0x4000_0180 + node, kind, actual())

    def configure_io(self, node: int, kind: int = 1) -> None:
        """RPDO1 and TPDO1."""
        self.write_pdo(node, 0x1400, 1, 0x200 + node, 255, IO_OUTPUTS)
        self.write_pdo(node, 0x1800, 1, 0x4000_0180 + node, kind, IO_INPUTS)

    def command(self, node: int, controlword: int, target: int = 0, axis: int | None = None) -> None:
        """What the controller sends from the next cycle on, to one axis or all."""
        for number in self.outputs[node] if axis is None else (axis,):
            self.outputs[node][number] = controlword, target

    def enable(self, *nodes: int, target: int = 60_000) -> None:
        """Takes drives to operation enabled by RPDO."""
        for controlword in (0x0000, 0x0006, 0x0007, 0x000F):
            for node in nodes:
                self.command(node, controlword, target if controlword == 0x000F else 0)
            self.wait(0.25)

    def reset_fault(self, node: int, hold_s: float = 0.3) -> float:
        """An edge of bit 7 from 0, held for a while; the time before it."""
        self.command(node, 0x0000)
        self.wait(0.25)
        before = time.time()
        self.command(node, 0x0080)
        self.wait(hold_s)
        self.command(node, 0x0000)
        self.wait(0.2)
        return before

    # -- time and the end

    def wait(self, seconds: float) -> float:
        """Lets time pass; the time after it."""
        time.sleep(seconds)
        return time.time()

    def finish(self) -> Log:
        """Everything off the bus; the log."""
        longest = self.stalls.longest
        self.stalls.stop()
        for name in list(self.stop_calls):
            self.stop(name)
        self._recorder.terminate()
        self._recorder.wait()
        self._output.close()
        self.timers.stop()
        self.wire.stop()
        for device in self.devices.values():
            device.disconnect()
        for network in self.networks:
            network.disconnect()
        if longest > LONGEST_STALL_S:
            raise MissingFrame(f"the machine stood still for {longest:.3f} s")
        return Log(self.path)

    def write_truth(self, tale: Tale, told: dict[str, Any]) -> None:
        """Writes the truth beside the log: the words of the recording before it, and the lines of this one."""
        nodes = [{"bus": INTERFACE, "node": CONTROLLER, "role": self.controller_role}, *self.others]
        nodes += [{"bus": INTERFACE, "node": device.id, "role": device.role} for device in self.devices.values()]
        whole = told | {
            "capture": self.path.name,
            "stack": STACK.format(rate=self.wire.bit_rate // 1000),
            "seconds": tale.log.seconds,
            "frames": len(tale.log.lines),
            "nodes": nodes,
            "stories": [words | seen.row() for words, seen in zip(told["stories"], tale.seen, strict=True)],
            "natural": [*tale.natural, *tale.log.late_syncs()],
        }
        self.path.with_suffix(".json").write_text(json.dumps(whole, indent=1, ensure_ascii=False) + "\n")
