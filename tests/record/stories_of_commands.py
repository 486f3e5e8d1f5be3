"""Stories in which commands play the first part: resets, stops, a second controller, a start without effect.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

import struct
import time

from network_nodes import U16
from story_log import answer, emcy, nmt, of, on
from story_nodes import Habits, Pdo
from story_plant import PRE_OP, RESET_NODE, START, STOP, Plant, Seen, Tale


def second_master(p: Plant) -> Tale:
    """t07: somebody's tool is still on the bus and wants something else than the controller."""
    p.io(2, "heartbeat 300 ms")
    p.io(6, "heartbeat 300 ms")
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.others.append({"bus": "vcan0", "node": None, "role": "a second controller: a service tool with no heartbeat"})
    tool = p.network()
    p.run_up(4)
    began = p.wait(0.0)
    commands = []
    for command in (PRE_OP, PRE_OP, STOP):
        commands.append(time.time())
        tool.send_message(0x000, bytes([command, 6]))
        p.wait(0.35)
        p.nmt(START, 6)  # the controller wants it to run
        p.wait(0.6)
    asked = p.wait(0.0)
    for _ in range(2):
        tool.send_message(0x604, struct.pack("<BHB4x", 0x40, 0x1018, 1))
        p.read(4, 0x6041)
        p.wait(0.5)
    p.wait(2.0)
    log = p.finish()
    first = log.first(nmt(PRE_OP, 6), began)
    against = [log.first(nmt(START, 6), when) for when in commands]
    strange = log.all(on(0x604, "40181001"), asked)
    return Tale(
        log,
        [
            Seen(
                first,
                log.first(nmt(PRE_OP, 6), log.stamp(against[0])),
                log.first(answer(4, 0x1018, 1), log.stamp(strange[-1])),
                [*against, log.first(nmt(STOP, 6), began), *strange, *log.all(answer(4, 0x1018, 1), asked)],
            )
        ],
    )


def producer_stopped(p: Plant) -> Tale:
    """t15: a node is stopped by command; another needs its PDO."""
    p.io(2, "heartbeat 300 ms")
    p.io(3, "heartbeat 300 ms, TPDO1 (183h) type 255 with event timer 200 ms", kind=255, event_ms=200)
    p.io(
        5,
        "heartbeat 300 ms, RPDO2 = 183h with event time 500 ms (written), 1029h:01 = 1",
        rpdos=[Pdo(0x183, 255, (0x6200_0108, 0x6200_0208, 0x6411_0110))],
        behaviour=1,
    )
    p.run_up(configure=lambda: void(p.write(5, 0x1401, 5, 500, U16)))
    stopped = p.nmt(STOP, 3)
    p.wait(3.0)
    started = p.nmt(START, 3)
    p.wait(2.5)
    log = p.finish()
    late = log.first(emcy(5, 0x8250), stopped)
    order = log.first(nmt(STOP, 3), stopped)
    return Tale(
        log,
        [
            Seen(
                order,
                log.first(on(0x703, "04"), stopped),
                log.first(on(0x703, "05"), started),
                [log.first(nmt(START, 3), started)],
            ),
            Seen(late, late, log.first(emcy(5, 0x0000), started), [log.last(on(0x183), log.stamp(order) + 0.01)]),
        ],
    )


def void(_: object) -> None:
    """For a call whose result does not matter."""


def commanded_reset(p: Plant) -> Tale:
    """t18: a node is reset by command and takes 1.5 s; two others report it meanwhile."""
    for node, behaviour in ((2, 1), (3, 1)):
        p.io(
            node,
            "heartbeat 300 ms, monitors 5 with 900 ms (preset), 1029h:01 = 1, 1015h = 50 ms",
            consumers=[(5, 900)],
            behaviour=behaviour,
            emcy_inhibit_100us=500,
            habits=Habits(detail=node == 3),
        )
    p.io(5, "heartbeat 300 ms, takes 1.5 s from reset to boot-up", habits=Habits(boot_s=1.5))
    p.run_up()
    reset = p.nmt(RESET_NODE, 5)
    p.wait(2.2)
    p.nmt(START, 5)
    p.wait(3.0)
    log = p.finish()
    order = log.first(nmt(RESET_NODE, 5), reset)
    seen = [log.first(emcy(node, 0x8130), reset) for node in (2, 3)]
    stories = [
        Seen(
            order,
            order,
            log.first(on(0x705, "05"), log.stamp(order)),
            [log.first(on(0x705, "00"), reset), log.first(nmt(START, 5), reset)],
        )
    ]
    stories.append(Seen(min(seen), max(seen), max(log.first(emcy(node, 0x0000), reset) for node in (2, 3)), seen))
    return Tale(log, stories)


def plant_stopped(p: Plant) -> Tale:
    """t19: the whole plant is stopped and started by NMT."""
    p.io(2, "heartbeat 300 ms")
    p.io(5, "heartbeat 300 ms")
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.run_up(4)
    p.command(4, 0x0006)
    p.wait(0.3)
    p.command(4, 0x0000)
    p.wait(0.3)
    p.stop("cycle")
    stopped = p.nmt(STOP)
    p.wait(2.0)
    p.nmt(PRE_OP)
    p.wait(0.7)
    p.cycle()
    p.wait(0.2)
    started = p.nmt(START)
    p.wait(0.5)
    p.enable(4)
    p.wait(1.5)
    log = p.finish()
    order = log.first(nmt(STOP, 0), stopped)
    return Tale(log, [Seen(order, order, log.first(nmt(START, 0), started), [log.first(nmt(PRE_OP, 0), stopped)])])


def start_without_effect(p: Plant) -> Tale:
    """t25: a node refuses to start while its error register is not 0."""
    p.io(2, "heartbeat 300 ms")
    device = p.io(
        6, "heartbeat 300 ms; refuses NMT start while its error register is not 0", habits=Habits(refuses_start=True)
    )
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.heartbeat()
    p.power_up()
    struck = p.wait(0.3)
    device.raise_error("supply of the outputs", 0x3130, 0x04, b"\x02")
    p.wait(0.4)
    p.cycle()
    p.wait(0.3)
    started = p.nmt(START)
    p.wait(0.6)
    p.enable(4)
    again = [p.nmt(START, 6)]
    p.wait(1.0)
    p.read(6, 0x1001)
    again.append(p.nmt(START, 6))
    p.wait(2.5)
    log = p.finish()
    raised = log.first(emcy(6, 0x3130), struck)
    order = log.first(nmt(START, 0), started)
    return Tale(
        log,
        [
            Seen(raised, raised, None, [log.first(answer(6, 0x1001, 0), struck)]),
            Seen(
                order,
                log.first(on(0x706, "7F"), started),
                None,
                [*[log.first(nmt(START, 6), when) for when in again], log.all(on(0x706, "7F"), started)[-1]],
            ),
        ],
    )


def restart_of_all(p: Plant) -> Tale:
    """c02: the plant is reset by command, configured and started again."""
    p.io(2, "heartbeat 300 ms, monitors 5 with 900 ms (preset)", consumers=[(5, 900)])
    p.io(5, "heartbeat 300 ms", pdo=False)
    p.drive(4, "heartbeat 300 ms, PDOs and consumer of 127 written", pdo=False)

    def configure() -> None:
        p.configure_io(5)
        p.configure_drive(4)

    p.run_up(4, configure=configure)
    p.command(4, 0x0006)
    p.wait(0.3)
    p.command(4, 0x0000)
    p.wait(0.3)
    p.stop("cycle")
    p.wait(0.1)
    reset = p.nmt(RESET_NODE)
    p.wait(1.0)
    configure()
    p.cycle()
    p.wait(0.3)
    started = p.nmt(START)
    p.wait(0.5)
    p.enable(4)
    p.wait(1.2)
    log = p.finish()
    order = log.first(nmt(RESET_NODE, 0), reset)
    return Tale(
        log,
        [
            Seen(
                order,
                order,
                log.first(nmt(START, 0), started),
                [log.first(on(0x700 + node, "00"), reset) for node in (2, 4, 5)],
            )
        ],
    )


def boot_and_run(p: Plant) -> Tale:
    """c01: nothing happens."""
    p.io(2, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.io(6, "heartbeat 300 ms, PDOs written", pdo=False)
    p.drive(4, "heartbeat 300 ms, PDOs and consumer of 127 written", pdo=False)

    def configure() -> None:
        p.configure_io(6)
        p.configure_drive(4)

    p.run_up(4, configure=configure)
    p.read(4, 0x6041)
    p.read(6, 0x1018, 1)
    p.wait(4.0)
    log = p.finish()
    log.first(of(4))
    return Tale(log, [])


SCENARIOS = {
    "t07-second-master": second_master,
    "t15-producer-stopped": producer_stopped,
    "t18-commanded-reset": commanded_reset,
    "t19-plant-stopped": plant_stopped,
    "t25-start-without-effect": start_without_effect,
    "c01-boot-and-run": boot_and_run,
    "c02-plant-restart": restart_of_all,
}
