"""Stories of configurations that are refused, stay unanswered, or do not fit.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from network_nodes import U8
from story_log import Log, answer, download, nmt, on
from story_nodes import NOT_MAPPABLE
from story_plant import START, Plant, Story, Tale


def refused_and_started(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "Part of a PDO mapping is refused, and the node is started all the same",
        [
            Story(
                "two writes of the mapping of TPDO1 of node 6 were refused: 1A00h:02 = 64020110h (06040041h, no such "
                "object to map) and 1A00h:00 = 2 (06040041h); not repeated; the node was started all the same",
                {"node": 6, "pdo": "TPDO1 of node 6 / 186h"},
                asked,
                refused,
                None,
                "stands",
                [
                    log.first(download(6, 0x1A00, 0), log.stamp(refused)),
                    log.first(answer(6, 0x1A00, 0, "80"), wrong),
                    log.first(nmt(START, 0), started),
                ],
                "TPDO1 of node 6 is valid but maps nothing: 186h never comes",
                "the mapping against the EDS of this device: object 6402h does not exist in it",
            )
        ],
        ["node 6 is lost or silent", "node 6 failed to start (its heartbeat says 05)", "other nodes had trouble"],
    )


def mute_object(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "One write of a configuration stays unanswered and is repeated later",
        [
            Story(
                "the write of 1016h:01 of node 6 was not answered for 1 s (all others were); the client gave up "
                "(05040000h), went on, and repeated it 1 s later with success",
                {"node": 6},
                asked,
                gave_up,
                good,
                "over",
                [log.first(download(6, 0x1016, 1), again_at)],
                "none in the end: before NMT start the heartbeat consumer is configured",
                "nothing stands; the firmware of node 6 does not answer while it is busy with 1016h",
            )
        ],
        ["node 6 is lost or silent (it answers every other request and its heartbeat goes on)", "anything stands"],
    )


SCENARIOS = {
    "t09-refused-and-started": refused_and_started,
    "t10-mute-object": mute_object,
}
