"""Stories of configurations that are refused, stay unanswered, or do not fit.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from network_nodes import U8
from story_log import answer, download, emcy, nmt, on
from story_nodes import IO_INPUTS, NOT_MAPPABLE, Pdo
from story_plant import START, Plant, Seen, Tale


def refused_and_started(p: Plant) -> Tale:
    """t09: part of a mapping is refused; the controller does not care and starts."""
    p.io(2, "heartbeat 300 ms")
    p.io(6, "heartbeat 300 ms, PDOs to be configured; has no object 6402h", pdo=False)
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.heartbeat()
    p.power_up()
    p.wait(0.6)
    device = p.devices[6]
    p.write_pdo(6, 0x1400, 1, 0x206, 255, (0x6200_0108, 0x6411_0110))
    p.write(6, 0x1800, 1, 0xC000_0186)
    p.write(6, 0x1800, 2, 1, U8)
    p.write(6, 0x1A00, 0, 0, U8)
    p.write(6, 0x1A00, 1, 0x6000_0108)
    wrong = p.wait(0.0)
    p.write(6, 0x1A00, 2, 0x6402_0110)
    device.refusals[0x1A00, 0] = NOT_MAPPABLE  # an entry of the count is none
    p.write(6, 0x1A00, 0, 2, U8)
    p.write(6, 0x1800, 1, 0x4000_0186)
    p.cycle()
    p.wait(0.3)
    started = p.nmt(START)
    p.wait(0.5)
    p.enable(4)
    p.wait(4.0)
    log = p.finish()
    asked = log.first(download(6, 0x1A00, 2), wrong)
    refused = log.first(answer(6, 0x1A00, 2, "80"), wrong)
    return Tale(
        log,
        [
            Seen(
                asked,
                refused,
                None,
                [
                    log.first(download(6, 0x1A00, 0), log.stamp(refused)),
                    log.first(answer(6, 0x1A00, 0, "80"), wrong),
                    log.first(nmt(START, 0), started),
                ],
            )
        ],
    )


def mute_object(p: Plant) -> Tale:
    """t10: one object is not answered; the client gives up, goes on, and later repeats the write."""
    p.io(2, "heartbeat 300 ms")
    p.io(6, "heartbeat 300 ms, PDOs to be configured", pdo=False)
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.heartbeat()
    p.power_up()
    p.wait(0.6)
    device = p.devices[6]
    p.write_pdo(6, 0x1400, 1, 0x206, 255, (0x6200_0108, 0x6411_0110))
    device.mute.add((0x1016, 1))
    asked_at = p.wait(0.0)
    p.write(6, 0x1016, 1, 127 << 16 | 900)
    given_up = p.wait(0.0)
    p.write_pdo(6, 0x1800, 1, 0x4000_0186, 1, (0x6000_0108, 0x6401_0110))
    device.mute.clear()
    p.wait(1.0)
    again_at = p.wait(0.0)
    p.write(6, 0x1016, 1, 127 << 16 | 900)
    p.cycle()
    p.wait(0.3)
    p.nmt(START)
    p.wait(0.5)
    p.enable(4)
    p.wait(3.0)
    log = p.finish()
    asked = log.first(download(6, 0x1016, 1), asked_at)
    gave_up = log.first(on(0x606, "80000000"), asked_at, given_up + 0.05)
    good = log.first(answer(6, 0x1016, 1, "60"), again_at)
    return Tale(log, [Seen(asked, gave_up, good, [log.first(download(6, 0x1016, 1), again_at)])])


def absent(p: Plant) -> Tale:
    """t21: a node is not there from the beginning; the controller asks again and again and never starts."""
    p.io(2, "heartbeat 300 ms")
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.know(p.master, 7, 0.5)
    p.heartbeat()
    p.power_up()
    p.wait(0.4)
    began = p.wait(0.0)
    for node in (2, 4):
        p.read(node, 0x1000)
        p.read(node, 0x1018, 1)
    for _ in range(7):
        p.read(7, 0x1000)
        p.wait(0.6)
    log = p.finish()
    asked = log.all(on(0x607, "40001000"), began)
    gave_up = log.all(on(0x607, "80"), began)
    return Tale(
        log,
        [
            Seen(
                asked[0],
                gave_up[0],
                None,
                [asked[-1], gave_up[-1]],
                words={
                    "kind": f"node 7 is absent: {len(asked)} requests for 1000h, each given up after 0.5 s "
                    "(05040000h); nothing was ever heard of it"
                },
            )
        ],
    )


def wrong_order(p: Plant) -> Tale:
    """t22: a mapping is written in the wrong order and never made good; a consumer gets too few bytes."""
    p.io(2, "heartbeat 300 ms")
    p.io(
        3,
        "heartbeat 300 ms, RPDO2 = 186h to be configured with 6 bytes, 1029h:01 = 1",
        rpdos=[Pdo(0x8000_0186, 255, ())],
        behaviour=1,
    )
    p.io(6, "heartbeat 300 ms, TPDO1 of 4 bytes, type 255 with event timer 200 ms (preset)", kind=255, event_ms=200)
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.write_pdo(3, 0x1400, 2, 0x186, 255, (0x6200_0108, 0x6200_0208, 0x6411_0110, 0x6411_0110))
    wrong = p.wait(0.0)
    p.write(6, 0x1A00, 0, 0, U8)
    for sub, entry in enumerate((*IO_INPUTS, 0x6401_0210), 1):
        p.write(6, 0x1A00, sub, entry)
    p.write(6, 0x1A00, 0, 4, U8)
    p.write(6, 0x1800, 1, 0x4000_0186)
    p.cycle()
    p.wait(0.3)
    started = p.nmt(START)
    p.wait(4.5)
    log = p.finish()
    refused = log.all(on(0x586, "80"), wrong)
    short = log.first(emcy(3, 0x8210), started)
    return Tale(
        log,
        [
            Seen(
                log.first(download(6, 0x1A00, 0), wrong),
                refused[0],
                None,
                [refused[-1], log.first(on(0x186), started)],
                words={
                    "kind": f"all {len(refused)} writes of 1A00h of node 6 were refused (06010000h) because TPDO1 was "
                    "still valid; the controller went on and started: TPDO1 keeps its 4 bytes, 6 were wanted"
                },
            ),
            Seen(short, short, None, [log.first(on(0x186), started)]),
        ],
    )


def scan(p: Plant) -> Tale:
    """c03: a configuration tool asks all node-IDs up to 32, then the plant is configured and runs."""
    p.io(2, "heartbeat 300 ms")
    p.io(6, "heartbeat 300 ms, PDOs written", pdo=False)
    p.drive(4, "heartbeat 300 ms, PDOs and consumer of 127 written", pdo=False)
    for node in range(1, 33):
        if node not in p.devices:
            p.know(p.master, node, 0.05)
    p.heartbeat()
    p.power_up()
    p.wait(0.4)
    began = p.wait(0.0)
    for node in range(1, 33):
        p.read(node, 0x1000)
    p.wait(0.3)
    p.configure_io(6)
    p.configure_drive(4)
    p.cycle()
    p.wait(0.3)
    p.nmt(START)
    p.wait(0.5)
    p.enable(4)
    p.wait(2.0)
    log = p.finish()
    asked = [log.first(on(0x600 + node, "40001000"), began) for node in range(1, 33)]
    return Tale(log, [Seen(asked[0], asked[8], asked[-1])])


SCENARIOS = {
    "t09-refused-and-started": refused_and_started,
    "t10-mute-object": mute_object,
    "t21-absent": absent,
    "t22-wrong-order": wrong_order,
    "c03-scan": scan,
}
