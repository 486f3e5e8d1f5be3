"""Records clean sessions of whole networks with candump, and writes beside each what happened in it.

    python tests/record/record_network.py [--into DIRECTORY] [--stalled] [NAME]...

Needs Linux with an interface vcan0 that is up, candump of can-utils, and the packages canopen and python-can. The
nodes are those of `network_nodes.py`, built from the dictionaries of eds/ and from the small one here; the master is
python-canopen. DIRECTORY (default: samples/network) gets NAME.log (`candump -l`) and NAME.json, the truth: values as
the senders meant them, not as anybody decoded them. A busy machine stalls; a recording in which a period or a window
was not kept is thrown away and made again.

What it must not do: send anything that a correct node would not send in its state.
"""

from __future__ import annotations

import argparse
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import canopen
from canopen.sdo.server import SdoServer
from network_lss import LssSlave
from network_nodes import (
    CONTROLWORD,
    EDS,
    INTERFACE,
    MODE,
    SIZE,
    TARGET_POSITION,
    U8,
    U16,
    U32,
    Account,
    Device,
    Drive,
    Timers,
    Values,
    named,
    pack,
    plain_dictionary,
)
from network_truth import describe, stalls

TARGET = Path(__file__).resolve().parents[2] / "samples" / "network"
ATTEMPTS = 8
PATIENCE_S = 10.0
"""For an answer to an SDO request; python-canopen's 0.3 s are over where a machine stalls."""
START, STOP, PRE_OP, RESET_NODE, RESET_COMMUNICATION = 0x01, 0x02, 0x80, 0x81, 0x82
DRIVE, IO, ENCODER, PLAIN = 5, 6, 7, 4


@dataclass
class Session:
    """One recording: the nodes, the master, and what must have been kept."""

    account: Account = field(default_factory=Account)
    devices: dict[int, Device] = field(default_factory=dict)
    files: dict[int, str | None] = field(default_factory=dict)
    kept: list[tuple[int, float, float, float]] = field(default_factory=list)
    """CAN-ID, from, to (stamps), longest gap."""
    closing: list[Callable[[], None]] = field(default_factory=list)
    overflow: int = 0
    window_us: int | None = None
    period_us: int | None = None
    sync_producer: str = "master"

    def __post_init__(self) -> None:
        """Connects the master."""
        self.timers = Timers(self.account.lock)
        self.master: Any = canopen.Network()
        self.master.connect(interface="socketcan", channel=INTERFACE)

    def device(self, node: int, eds: str | None, kind: type[Device] = Device) -> Any:
        """A node, connected and silent; the master knows its dictionary too."""
        device = kind(self.account, self.timers, node, eds or plain_dictionary())
        device.connect()
        self.devices[node], self.files[node] = device, eds
        self.remote(node, eds)
        return device

    def remote(self, node: int, eds: str | None) -> Any:
        """The master's view of a node."""
        od = canopen.import_od(str(EDS / eds), node) if eds else plain_dictionary()
        remote = self.master.add_node(canopen.RemoteNode(node, od))
        remote.sdo.RESPONSE_TIMEOUT = PATIENCE_S
        return remote

    def three_nodes(self) -> tuple[Drive, Device, Device]:
        """Drive, I/O and encoder, booted; heartbeats of 100 ms, set by SDO."""
        drive = self.device(DRIVE, "drive.eds", Drive)
        io, encoder = self.device(IO, "io.eds"), self.device(ENCODER, "encoder.eds")
        io.values |= {(0x6000, 1): 0x0F, (0x6000, 2): 0x80} | {(0x6401, sub): -1000 * sub for sub in range(1, 5)}
        encoder.values |= {(0x6004, 0): 8190, (0x6030, 1): -12}
        for device in (drive, io, encoder):
            device.boot()
            time.sleep(0.01)
        return drive, io, encoder

    def heartbeats(self, milliseconds: int, *nodes: int) -> None:
        """Sets 1017h; from here on the period must be kept."""
        for node in nodes:
            self.write(node, 0x1017, 0, milliseconds, U16)
            self.keep(0x700 + node, milliseconds / 1000 * 1.3)

    def keep(self, can_id: int, gap: float) -> None:
        """From now on no gap on this CAN-ID may be longer."""
        self.kept.append((can_id, time.time(), float("inf"), gap))

    def release(self, can_id: int) -> None:
        """Until now."""
        now = time.time()
        self.kept = [(i, since, min(until, now) if i == can_id else until, g) for i, since, until, g in self.kept]

    def nmt(self, command: int, node: int) -> None:
        """Sends an NMT command."""
        with self.account.lock:
            for can_id in [0x700 + n for n in self.devices if node in (0, n)] if command >= 0x81 else []:
                self.release(can_id)
            self.account.enter(0, bytes([command, node]), nmt=command, node=node)
            self.master.send_message(0, [command, node])

    def write(self, node: int, index: int, sub: int, value: int, kind: int) -> None:
        """Writes by SDO."""
        self.master[node].sdo.download(index, sub, value.to_bytes(SIZE[kind], "little"))

    def read(self, node: int, index: int, sub: int = 0) -> int:
        """Reads by SDO."""
        return int.from_bytes(self.master[node].sdo.upload(index, sub), "little")

    def rpdo(self, node: int, number: int, values: Values) -> None:
        """Sends an RPDO of a node; objects that are not given are 0."""
        device = self.devices[node]
        mapped = device.mapping(0x1600, number)
        signals = {thing: values.get(thing, 0) for thing, _ in mapped}
        can_id = device.cob_id(0x1400, number) & 0x7FF
        data = pack([(signals[thing], bits) for thing, bits in mapped])
        with self.account.lock:
            self.account.enter(can_id, data, node=node, pdo=f"RPDO{number}", signals=named(signals))
            self.master.send_message(can_id, data)

    def set_tpdo(self, node: int, number: int, **settings: Any) -> None:
        """Changes a TPDO as reference 5.7 says; `save` of python-canopen does it in that order."""
        tpdo = self.master[node].tpdo[number]
        tpdo.read()
        for name, value in settings.items():
            if name == "mapping":
                tpdo.clear()
                for index, sub in value:
                    tpdo.add_variable(index, sub)
            else:
                setattr(tpdo, name, value)
        tpdo.save()

    def produce_sync(self, seconds: float) -> None:
        """SYNC without a counter, from the master, timed by the kernel."""
        self.master.sync.start(seconds)
        self.keep(0x080, seconds * 1.25)
        self.period_us = round(seconds * 1_000_000)

    def enable_by_sdo(self) -> None:
        """The drive's way up, by SDO."""
        for controlword in (0x0006, 0x0007, 0x000F):
            self.write(DRIVE, *CONTROLWORD, controlword, U16)
            time.sleep(0.03)
            self.read(DRIVE, 0x6041)

    def close(self) -> None:
        """Everything off the bus."""
        for call in self.closing:
            call()
        self.timers.stop()
        for device in self.devices.values():
            device.disconnect()
        self.master.disconnect()


def boot_and_states(s: Session) -> None:
    """Boot-up, every NMT command, heartbeats and a consumer of them, EMCY with inhibit time, TIME."""
    drive, _io, encoder = s.three_nodes()
    s.master.time.transmit()
    s.heartbeats(100, DRIVE, IO, ENCODER)
    s.write(DRIVE, 0x1016, 1, IO << 16 | 300, U32)
    s.write(DRIVE, 0x1015, 0, 200, U16)
    time.sleep(0.25)
    s.nmt(START, 0)
    time.sleep(0.35)
    drive.emcy(0x3210, 0x05, b"\x01\x02")
    time.sleep(0.06)
    drive.emcy(0x4210, 0x0D)
    time.sleep(0.06)
    drive.emcy(0x0000, 0x05)
    time.sleep(0.06)
    drive.emcy(0x0000, 0x00)
    s.nmt(STOP, IO)
    time.sleep(0.25)
    s.nmt(START, IO)
    time.sleep(0.15)
    s.nmt(PRE_OP, ENCODER)
    time.sleep(0.25)
    s.write(DRIVE, 0x1016, 1, 0, U32)
    s.nmt(RESET_COMMUNICATION, IO)
    time.sleep(0.1)
    s.heartbeats(100, IO)
    encoder.emcy(0x8110, 0x11)
    time.sleep(0.02)
    encoder.emcy(0x0000, 0x00)
    s.nmt(RESET_NODE, ENCODER)
    time.sleep(0.1)
    s.write(ENCODER, 0x1017, 0, 150, U16)
    s.keep(0x707, 0.195)
    time.sleep(0.2)
    s.master.time.transmit()
    s.nmt(START, 0)
    time.sleep(0.35)


def sync_and_pdos(s: Session) -> None:
    """SYNC of 10 ms; TPDOs of type 1 and 4, and event-driven with inhibit time and event timer; RPDOs of both kinds."""
    _drive, io, encoder = s.three_nodes()
    s.window_us = 6000
    s.heartbeats(100, DRIVE, IO, ENCODER)
    for node in (DRIVE, ENCODER):
        s.write(node, 0x1006, 0, 10_000, U32)
        s.write(node, 0x1007, 0, s.window_us, U32)
    s.set_tpdo(ENCODER, 2, trans_type=4)
    s.set_tpdo(ENCODER, 1, event_timer=50)
    s.set_tpdo(IO, 2, inhibit_time=100, event_timer=40)
    s.nmt(START, 0)
    s.keep(0x187, 0.065)
    s.keep(0x286, 0.052)
    s.enable_by_sdo()
    cycle, running = 0, True

    def on_sync(can_id: int, data: bytearray, timestamp: float) -> None:
        nonlocal cycle
        cycle += 1
        position = -70_000 if cycle > 20 else 50_000
        encoder.values |= {(0x6004, 0): 8190 + 3 * cycle, (0x6030, 1): -12 + cycle}
        if cycle % 2 and running:
            s.rpdo(DRIVE, 3, {CONTROLWORD: 0x000F, TARGET_POSITION: position})

    s.master.subscribe(0x080, on_sync)
    s.produce_sync(0.01)
    for step in range(8):
        time.sleep(0.04)
        s.rpdo(IO, 1, {(0x6200, 1): 1 << step, (0x6200, 2): 0xFF >> step})
        io.show({(0x6000, 1): 0xF0 | step})
        if step % 3 == 0:
            s.rpdo(IO, 2, {(0x6411, 1): -step, (0x6411, 2): 1000 * step})
            io.show({(0x6401, 1): -step, (0x6401, 4): 32_000 + step})
    running = False
    time.sleep(0.01)
    s.nmt(PRE_OP, 0)
    s.release(0x187)
    s.release(0x286)
    time.sleep(0.03)
    s.release(0x080)
    s.master.sync.stop()


def sync_counter(s: Session) -> None:
    """The drive produces SYNC with a counter to 8; types 1, 2 and 4, the last with a SYNC start value of 3."""
    drive, _io, encoder = s.three_nodes()
    s.window_us, s.overflow, s.period_us, s.sync_producer = 7000, 8, 10_000, "node 5"
    s.heartbeats(200, DRIVE, IO, ENCODER)
    for node in (ENCODER, DRIVE):
        s.write(node, 0x1019, 0, s.overflow, U8)
        s.write(node, 0x1007, 0, s.window_us, U32)
    s.set_tpdo(DRIVE, 3, trans_type=2)
    s.write(ENCODER, 0x1801, 1, 0xC000_0287, U32)
    s.write(ENCODER, 0x1801, 2, 4, U8)
    s.write(ENCODER, 0x1801, 6, 3, U8)
    s.write(ENCODER, 0x1801, 1, 0x4000_0287, U32)
    s.nmt(START, 0)
    s.enable_by_sdo()
    s.write(DRIVE, 0x1006, 0, s.period_us, U32)
    s.write(DRIVE, 0x1005, 0, 0x4000_0080, U32)
    counter = 0

    def produce() -> None:
        nonlocal counter
        counter = counter % s.overflow + 1
        encoder.values |= {(0x6004, 0): 70_000 + counter, (0x6030, 1): -counter}
        drive.send(0x080, bytes([counter]))
        drive._on_sync(counter)

    stop = s.timers.every(0.01, produce)
    time.sleep(0.005)
    s.keep(0x080, 0.0125)
    for step in range(6):
        time.sleep(0.07)
        s.rpdo(DRIVE, 3, {CONTROLWORD: 0x000F, TARGET_POSITION: 4000 * (step - 3)})
    s.nmt(PRE_OP, 0)
    time.sleep(0.02)
    s.release(0x080)
    stop()


def remapping(s: Session) -> None:
    """TPDOs remapped and moved by SDO, a TPDO5 set up, one stored and one forgotten at a reset."""
    _drive, io, encoder = s.three_nodes()
    plain = s.device(PLAIN, None)
    plain.values |= {(0x2000, sub): 0x1000 * sub + 5 for sub in range(1, 5)}
    plain.boot()
    s.heartbeats(100, IO, ENCODER)
    s.nmt(START, 0)
    time.sleep(0.02)
    io.show({(0x6000, 1): 1})
    time.sleep(0.05)
    # from inputs to analogue values, in the running network
    s.set_tpdo(IO, 1, mapping=[(0x6401, 1), (0x6000, 2), (0x6401, 3)])
    for step in range(5):
        time.sleep(0.02)
        io.show({(0x6401, 1): -30_000 + step, (0x6000, 2): step, (0x6401, 3): 500 * step})
    # the same moved to another CAN-ID, and back to one object
    s.set_tpdo(IO, 1, cob_id=0x1C6)
    for step in range(5):
        time.sleep(0.02)
        io.show({(0x6401, 3): -500 * step - 1})
    s.set_tpdo(IO, 1, cob_id=0x1C6, mapping=[(0x6000, 2)])
    for step in range(3):
        time.sleep(0.02)
        io.show({(0x6000, 2): 0x80 + step})
    # TPDO5 of the node without EDS: nothing is known of it but what is written
    s.write(PLAIN, 0x1804, 2, 255, U8)
    s.write(PLAIN, 0x1804, 3, 20, U16)
    s.write(PLAIN, 0x1A04, 0, 0, U8)
    for sub, entry in enumerate((0x2000_0410, 0x2000_0110, 0x2000_0310), 1):
        s.write(PLAIN, 0x1A04, sub, entry, U32)
    s.write(PLAIN, 0x1A04, 0, 3, U8)
    s.write(PLAIN, 0x1804, 1, 0x4000_01C4, U32)
    for step in range(5):
        time.sleep(0.02)
        plain.show({(0x2000, 4): 0xBEE0 + step, (0x2000, 1): step, (0x2000, 3): 0x8000 + step})
    # kept over a reset
    s.set_tpdo(ENCODER, 1, mapping=[(0x6030, 1), (0x6004, 0)], event_timer=30)
    s.keep(0x187, 0.039)
    s.write(ENCODER, 0x1010, 1, 0x65766173, U32)
    time.sleep(0.1)
    s.release(0x187)
    for node in (ENCODER, IO):
        s.nmt(RESET_COMMUNICATION, node)
    time.sleep(0.08)
    s.nmt(START, 0)
    s.keep(0x187, 0.039)
    for step in range(5):
        time.sleep(0.03)
        encoder.values[0x6004, 0] = 100_000 * step
        encoder.values[0x6030, 1] = -step
        io.show({(0x6000, 2): 0x10 + step})
    s.nmt(PRE_OP, 0)
    s.release(0x187)
    # back to the device's own values
    s.write(IO, 0x1011, 1, 0x64616F6C, U32)
    s.nmt(RESET_NODE, IO)
    time.sleep(0.06)


def drive_states(s: Session) -> None:
    """A drive through all states of CiA 402: by RPDO and TPDO, then by SDO; with a fault and its reset."""
    drive = s.device(DRIVE, "drive.eds", Drive)
    drive.boot()
    s.heartbeats(200, DRIVE)
    s.nmt(START, DRIVE)
    time.sleep(0.05)

    def command(*controlwords: int) -> None:
        for controlword in controlwords:
            s.rpdo(DRIVE, 1, {CONTROLWORD: controlword})
            time.sleep(0.04)

    command(0x0006, 0x0007)
    s.rpdo(DRIVE, 2, {CONTROLWORD: 0x0007, MODE: 3})
    time.sleep(0.04)
    command(0x000F)
    command(0x0007, 0x000F, 0x0002, 0x000F, 0x0006, 0x0000)
    command(0x0006, 0x0007, 0x000F)
    drive.fault(0x2310, 0x03)
    time.sleep(0.1)
    command(0x0000)
    command(0x0080)
    drive.emcy(0x0000, 0x00)
    time.sleep(0.04)
    command(0x0006, 0x0000)
    s.write(DRIVE, *MODE, 1, U8)
    time.sleep(0.02)
    s.read(DRIVE, 0x6061)
    s.enable_by_sdo()
    s.write(DRIVE, *TARGET_POSITION, (-4096) & 0xFFFF_FFFF, U32)
    for controlword in (0x001F, 0x000F, 0x0007, 0x0006, 0x0000):
        s.write(DRIVE, *CONTROLWORD, controlword, U16)
        time.sleep(0.03)
        s.read(DRIVE, 0x6041)
    s.nmt(STOP, DRIVE)
    time.sleep(0.25)


def guarding(s: Session) -> None:
    """Node guarding with its toggle bit through the NMT states and a reset; TPDO1 only on remote request."""
    plain = s.device(PLAIN, None)
    plain.values |= {(0x2000, 1): 1, (0x2000, 2): 2}
    plain.boot()
    s.write(PLAIN, 0x100C, 0, 100, U16)
    s.write(PLAIN, 0x100D, 0, 3, U8)
    for index, sub in ((0x1800, 1), (0x1800, 2), (0x1A00, 0), (0x1A00, 1), (0x1A00, 2)):
        s.read(PLAIN, index, sub)
    guard = s.master[PLAIN].nmt
    guard.start_node_guarding(0.1)
    time.sleep(0.35)
    s.nmt(START, PLAIN)
    for step in range(8):
        time.sleep(0.05)
        plain.show({(0x2000, 1): 40 * step, (0x2000, 2): 0xFFFF - step})
        s.master.send_message(0x184, b"", remote=True)
    time.sleep(0.02)
    s.nmt(STOP, PLAIN)
    time.sleep(0.3)
    s.nmt(PRE_OP, PLAIN)
    time.sleep(0.25)
    guard.stop_node_guarding()
    time.sleep(0.05)
    s.nmt(RESET_NODE, PLAIN)
    time.sleep(0.1)
    s.master.time.transmit()
    guard.start_node_guarding(0.1)
    time.sleep(0.35)
    guard.stop_node_guarding()
    time.sleep(0.05)


def multiplex_and_safety(s: Session) -> None:
    """MPDOs of both modes, an SRDO, and an SDO channel beside the default one."""
    plain = s.device(PLAIN, None)
    plain.boot()
    for sub in (1, 2, 3, 5, 6):
        s.read(PLAIN, 0x1301, sub)
    for index, sub in ((0x1805, 1), (0x1805, 2), (0x1A05, 0), (0x1401, 1), (0x1401, 2), (0x1601, 0)):
        s.read(PLAIN, index, sub)
    second: Any = SdoServer(0x684, 0x6C4, plain.local)  # type: ignore[no-untyped-call]
    second.network = plain.network
    s.write(PLAIN, 0x1201, 3, 1, U8)
    s.write(PLAIN, 0x1201, 2, 0x6C4, U32)
    s.write(PLAIN, 0x1201, 1, 0x684, U32)
    plain.second_channel = second
    client = s.master[PLAIN].add_sdo(0x684, 0x6C4)
    client.network, client.RESPONSE_TIMEOUT = s.master, PATIENCE_S
    s.heartbeats(100, PLAIN)
    s.nmt(START, PLAIN)

    def safety() -> None:
        value = plain.values.get((0x2000, 1), 0)
        data = struct.pack("<H", value)
        plain.send(0x107, data)
        plain.send(0x108, bytes(byte ^ 0xFF for byte in data))

    time.sleep(0.01)
    stop = s.timers.every(0.04, safety)
    time.sleep(0.045)
    s.keep(0x107, 0.049)
    s.keep(0x108, 0.049)
    for step in range(10):
        time.sleep(0.035)
        plain.values[0x2000, 1] = 0x0100 * step + 7
        client.download(0x2100, 0, struct.pack("<I", 0x1000_0000 + step))
        client.upload(0x2100, 0)
        with s.account.lock:
            sam = struct.pack("<BHBI", PLAIN, 0x2000, 1 + step % 4, 100 + step)
            plain.send(0x1E4, sam, mpdo="sam", node=PLAIN, index="2000", sub=1 + step % 4, value=100 + step)
            dam = struct.pack("<BHBI", 0x80 | PLAIN, 0x2100, 0, 42 + step)
            s.account.enter(0x304, dam, mpdo="dam", node=PLAIN, index="2100", sub=0, value=42 + step)
            s.master.send_message(0x304, dam)
        s.read(PLAIN, 0x1001)
    stop()
    time.sleep(0.005)
    s.release(0x107)
    s.release(0x108)
    s.nmt(PRE_OP, PLAIN)
    time.sleep(0.05)


def lss_slave(s: Session, device: Device, serial: int, *, configured: bool) -> LssSlave:
    """The LSS side of a device; its identity is that of its dictionary, with a serial number."""
    identity = device.number(0x1018, 1), device.number(0x1018, 2), device.number(0x1018, 3), serial
    device.values[0x1018, 4] = serial
    slave = LssSlave(device, identity, configured=configured)
    slave.connect()
    s.closing.append(slave.network.disconnect)
    return slave


def lss_selective(s: Session) -> None:
    """A configured slave gets another node-ID, stores it and takes it at a reset; it is identified and asked."""
    encoder = s.device(ENCODER, "encoder.eds")
    io = s.device(IO, "io.eds")
    lss_slave(s, encoder, 0x1122_3344, configured=True)
    lss_slave(s, io, 0x0000_0042, configured=True)
    encoder.boot()
    io.boot()
    lss = s.master.lss
    lss.send_switch_state_selective(0, 0x406, 0x10000, 0x1122_3344)
    lss.inquire_node_id()
    for cs in (0x5A, 0x5B, 0x5C, 0x5D):
        lss.inquire_lss_address(cs)
    lss.configure_node_id(17)
    lss.store_configuration()
    lss.send_switch_state_global(0)
    s.devices[17], s.files[17] = s.devices.pop(ENCODER), s.files[ENCODER]
    s.remote(17, "encoder.eds")
    s.nmt(RESET_COMMUNICATION, ENCODER)
    time.sleep(0.1)
    s.read(17, 0x1018, 4)
    lss.send_identify_remote_slave(0, 0x401, 0x10000, 0x1FFFF, 0x10, 0xFF)
    time.sleep(0.02)
    lss.send_identify_non_configured_remote_slave()
    time.sleep(0.05)
    s.read(IO, 0x1018, 4)


def lss_fastscan(s: Session) -> None:
    """Two slaves without node-ID are found by Fastscan, one after the other, and get theirs."""
    first, second = s.device(20, "io.eds"), s.device(21, "io.eds")
    lss_slave(s, first, 0x7FFE_FFF3, configured=False)
    lss_slave(s, second, 0x7FFE_FFF7, configured=False)
    lss = s.master.lss
    lss.RESPONSE_TIMEOUT = 0.08
    lss.send_identify_non_configured_remote_slave()
    time.sleep(0.05)
    for node in (20, 21):
        found, identity = lss.fast_scan()
        if not found:
            raise canopen.lss.LssError(f"Fastscan found nobody: {identity}")
        lss.inquire_node_id()
        lss.configure_node_id(node)
        lss.store_configuration()
        lss.send_switch_state_global(0)
        time.sleep(0.06)
        s.read(node, 0x1018, 4)


SESSIONS: dict[str, Callable[[Session], None]] = {
    "boot-and-states": boot_and_states,
    "sync-and-pdos": sync_and_pdos,
    "sync-counter": sync_counter,
    "remapping": remapping,
    "drive-states": drive_states,
    "guarding": guarding,
    "multiplex-and-safety": multiplex_and_safety,
    "lss-selective": lss_selective,
    "lss-fastscan": lss_fastscan,
}


def record(run: Callable[[Session], None], scratch: Path) -> tuple[str, Session]:
    """The text of one recording, and its session."""
    candump = subprocess.Popen(
        ["candump", "-l", INTERFACE], cwd=scratch, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    time.sleep(0.5)
    session = Session()
    try:
        run(session)
    finally:
        session.close()
        time.sleep(0.2)
        candump.terminate()
        candump.wait()
    (log,) = scratch.iterdir()
    return log.read_text(), session


def main() -> None:
    """Records the sessions that the command line names, or all."""
    parser = argparse.ArgumentParser(description="Records clean sessions of whole networks.")
    parser.add_argument("--into", type=Path, default=TARGET)
    parser.add_argument("--stalled", action="store_true", help="one attempt each; kept where the machine stalled, too")
    parser.add_argument("names", nargs="*", default=list(SESSIONS))
    options = parser.parse_args()
    options.into.mkdir(parents=True, exist_ok=True)
    for name in options.names:
        for attempt in range(1, 2 if options.stalled else ATTEMPTS + 1):
            with tempfile.TemporaryDirectory() as scratch:
                try:
                    text, session = record(SESSIONS[name], Path(scratch))
                except (canopen.SdoCommunicationError, canopen.lss.LssError) as stall:
                    print(f"{name}, attempt {attempt}: {stall!r}", flush=True)
                    continue
            truth, missed = describe(name, text, session.account.sent, session)
            if missed := missed + stalls(text, session):
                print(f"{name}, attempt {attempt}: {len(missed)}: {'; '.join(missed[:4])}", flush=True)
            if not missed or options.stalled:
                break
        else:
            raise SystemExit(f"{name}: the machine is too busy")
        (options.into / f"{name}.log").write_text(text)
        (options.into / f"{name}.json").write_text(truth)
        print(f"{name}: {len(text.splitlines())} frames, {len(text)} bytes", flush=True)


if __name__ == "__main__":
    main()
