"""Stories of services that keep a node busy or leave it unusable, of LSS, of load, and of a node-ID given twice.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

import struct
from typing import Any

from network_lss import LssSlave
from network_nodes import PRE_OPERATIONAL, U8
from story_log import answer, download, emcy, nmt, of, on
from story_nodes import (
    IO_INPUTS,
    IO_OUTPUTS,
    IO_ROWS,
    NOT_IN_THIS_STATE,
    SAVE,
    Habits,
    IoDevice,
    Pdo,
    communication_rows,
    rows_of_pdos,
)
from story_plant import START, Plant, Seen, Tale
from story_wire import Socket

FLASH_FAILED = 0x0606_0000
BLOCK_BYTES = 180
SEGMENTS_TAKEN = 14


class FlashedDevice(IoDevice):
    """A node with a bootloader whose flash memory fails in the midst of a program download."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        """In its application."""
        super().__init__(*arguments, **settings)
        self.in_bootloader = False
        self._segments = 0

    def after_write(self, index: int, sub: int) -> None:
        super().after_write(index, sub)
        if (index, sub) == (0x1F51, 1) and self.number(0x1F51, 1) == 0:
            self.in_bootloader = True
            self.timers.after(0.05, self.restart)

    def entered(self) -> None:
        super().entered()
        if self.in_bootloader:
            self.local.data_store[0x1000] = {0: bytes(4)}
            self.local.data_store[0x1800] = {1: struct.pack("<I", 0x8000_0186)}

    def _on_nmt(self, command: int) -> None:
        if not (self.in_bootloader and command == 0x01):
            super()._on_nmt(command)

    def _on_sdo(self, server: Any, data: bytes) -> None:
        if data[0] & 0xE0 == 0x00 and self.state == PRE_OPERATIONAL:
            self._segments += 1
            if self._segments > SEGMENTS_TAKEN:
                self.network.send_message(0x580 + self.id, struct.pack("<BHBI", 0x80, 0x1F50, 1, FLASH_FAILED))
                return
        super()._on_sdo(server, data)


def io_rows(node: int, **settings: Any) -> Any:
    """The dictionary of an I/O node, for devices that `Plant.io` does not make."""
    tpdo, rpdo = Pdo(0x4000_0180 + node, 1, IO_INPUTS), Pdo(0x200 + node, 255, IO_OUTPUTS)
    rows = communication_rows(node, **settings) + IO_ROWS
    return rows + rows_of_pdos(0x1400, [rpdo]) + rows_of_pdos(0x1800, [tpdo])


def node_id_twice(p: Plant) -> Tale:
    """t08: a spare device is plugged in with a node-ID that is taken."""
    p.io(2, "heartbeat 300 ms")
    p.io(6, "heartbeat 300 ms, TPDO1 type 1")
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.run_up(4)
    spare = IoDevice(
        p.wire, p.account, p.timers, 6, io_rows(6, heartbeat_ms=450, serial=9117), Habits(boot_s=0.1)
    )  # fmt: skip
    spare.connect()
    spare.role = "I/O device, a second one with node-ID 6, heartbeat 450 ms, never started"
    plugged = p.wait(0.0)
    spare.power_up()
    p.wait(1.0)
    p.read(6, 0x1018, 4)
    p.wait(1.0)
    p.read(6, 0x1000)
    p.wait(3.0)
    p.networks.append(spare.network)
    log = p.finish()
    p.devices[-6] = spare
    boot = log.first(on(0x706, "00"), plugged)
    running = log.first(on(0x706, "05"), log.stamp(boot))
    answers = log.all(answer(6, 0x1018, 4), plugged)
    return Tale(
        log,
        [
            Seen(
                boot,
                running,
                None,
                [*answers, *log.all(answer(6, 0x1000, 0), plugged), log.first(on(0x706, "7F"), plugged)],
            )
        ],
    )


def overload(p: Plant) -> Tale:
    """t28: one node floods its TPDO on a slow bus; what has a higher identifier waits."""
    p.io(2, "heartbeat 500 ms", heartbeat_ms=500)
    p.io(5, "heartbeat 500 ms", heartbeat_ms=500)
    device = p.io(3, "heartbeat 500 ms, TPDO1 type 255 without inhibit time", kind=255, heartbeat_ms=500)
    p.heartbeat(500)
    p.power_up()
    p.wait(0.8)
    p.cycle(200)
    p.nmt(START)
    p.wait(3.0)
    began = p.wait(0.0)
    level = 0

    def bounce() -> None:
        nonlocal level
        level += 1
        if len(device.socket.waiting) < 3:
            device.show({(0x6401, 1): 700 + level % 50})

    stop = p.timers.every(0.0054, bounce)
    p.wait(2.5)
    stop()
    ended = p.wait(0.0)
    p.wait(4.0)
    log = p.finish()
    flood = log.all(on(0x183), began, ended + 0.3)
    late = max(
        (log.stamp(later) - log.stamp(line), later)
        for can_id in (0x702, 0x705, 0x77F)
        for line, later in zip(log.all(on(can_id), began - 1), log.all(on(can_id), began - 1)[1:], strict=False)
    )
    return Tale(
        log,
        [
            Seen(
                flood[0],
                flood[20],
                flood[-1],
                [late[1]],
                words={
                    "kind": f"node 3 sent its TPDO1 (183h) {len(flood)} times in 2.5 s (about 4 times a second "
                    "before): an analogue input bounces and there is no inhibit time; the bus (20 kbit/s) was "
                    "loaded to nine tenths",
                    "consequences": "what has a higher identifier came late: a heartbeat up to "
                    f"{late[0]:.2f} s after the one before (0.5 s)",
                },
            )
        ],
    )


def stored(p: Plant) -> Tale:
    """t29: storing parameters keeps a node busy for 1.5 s; who monitors it reports it."""
    p.io(2, "heartbeat 300 ms, monitors 6 with 900 ms (preset), 1029h:01 = 1", consumers=[(6, 900)], behaviour=1)
    device = p.io(6, "heartbeat 300 ms; storing parameters (1010h) takes 1.5 s in which it does nothing else")
    device.save_s = 1.5
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.run_up(4)
    saved = p.wait(0.0)
    p.write(6, 0x1010, 1, SAVE)
    p.wait(5.0)
    log = p.finish()
    order = log.first(download(6, 0x1010, 1), saved)
    done = log.first(answer(6, 0x1010, 1), saved)
    back = log.first(of(6), log.stamp(done))
    seen = log.first(emcy(2, 0x8130), saved)
    return Tale(log, [Seen(order, seen, back, [done]), Seen(seen, seen, log.first(emcy(2, 0x0000), saved))])


def lss(p: Plant) -> Tale:
    """t30: LSS: first nobody answers, then the node refuses its new node-ID."""
    p.io(2, "heartbeat 300 ms")
    device = p.io(6, "heartbeat 300 ms, LSS slave")
    slave = LssSlave(device, (0x03A5, 1, 0x0001_0004, 4006), configured=True)
    slave.network.bus = Socket(p.wire)
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    slave.connect()
    p.networks.append(slave.network)
    p.heartbeat()
    p.power_up()
    p.wait(0.4)

    def ask(*data: int) -> None:
        p.master.send_message(0x7E5, bytes(data).ljust(8, b"\0"))
        p.wait(0.03)

    began = p.wait(0.0)
    for _ in range(2):
        for command, value in zip(range(0x40, 0x44), (0x03A5, 1, 0x0001_0004, 4711), strict=True):
            ask(command, *struct.pack("<I", value))
        p.wait(1.0)
    refused_at = p.wait(0.0)
    for command, value in zip(range(0x40, 0x44), (0x03A5, 1, 0x0001_0004, 4006), strict=True):
        ask(command, *struct.pack("<I", value))
    p.wait(0.1)
    ask(0x11, 200)
    p.wait(0.2)
    ask(0x04, 0)
    p.wait(0.5)
    p.cycle()
    p.wait(0.2)
    p.nmt(START)
    p.wait(0.4)
    p.enable(4)
    p.wait(2.0)
    log = p.finish()
    first = log.first(on(0x7E5, "40"), began)
    fourth = log.first(on(0x7E5, "43"), began)
    second = log.all(on(0x7E5, "40"), began)[1]
    order = log.first(on(0x7E5, "11"), refused_at)
    refusal = log.first(on(0x7E4, "11"), refused_at)
    return Tale(
        log,
        [
            Seen(first, second, None, [fourth, log.all(on(0x7E5, "43"), began)[1]]),
            Seen(order, refusal, None, [log.first(on(0x7E4, "44"), refused_at)]),
        ],
    )


def bootloader(p: Plant) -> Tale:
    """t31: a program download is aborted and the node stays in its bootloader."""
    p.io(2, "heartbeat 300 ms")
    device = FlashedDevice(p.wire, p.account, p.timers, 6, io_rows(6))
    p.add(device, "I/O device with bootloader, heartbeat 300 ms; its flash memory fails")
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.run_up(4)
    program: Any = device.local.object_dictionary[0x1F50]
    program[1].data_type = 0x000F  # DOMAIN
    began = p.wait(0.0)
    p.write(6, 0x1F51, 1, 0, U8)
    p.wait(0.8)
    p.read(6, 0x1000)
    p.load(6, 0x1F50, 1, bytes(range(BLOCK_BYTES)))
    p.wait(0.3)
    device.refusals[0x1F51, 1] = NOT_IN_THIS_STATE
    p.write(6, 0x1F51, 1, 1, U8)
    p.wait(0.5)
    p.nmt(START, 6)
    p.wait(3.0)
    log = p.finish()
    asked = log.first(download(6, 0x1F50, 1), began)
    abort = log.first(answer(6, 0x1F50, 1, "80"), began)
    start = log.first(nmt(START, 6), log.stamp(abort))
    return Tale(
        log,
        [
            Seen(
                asked,
                abort,
                None,
                [
                    log.first(download(6, 0x1F51, 1), began),
                    log.first(on(0x706, "00"), began),
                    log.first(answer(6, 0x1000, 0), began),
                    log.first(answer(6, 0x1F51, 1, "80"), log.stamp(abort)),
                    log.all(on(0x706, "7F"), log.stamp(abort))[-1],
                ],
            ),
            Seen(start, log.first(on(0x706, "7F"), log.stamp(start))),
        ],
    )


SCENARIOS = {
    "t08-node-id-twice": node_id_twice,
    "t28-overload": overload,
    "t29-stored": stored,
    "t30-lss": lss,
    "t31-bootloader": bootloader,
}
