"""Stories of drives that fault, and of resets that do not help.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from story_log import Log, controller, emcy, on
from story_nodes import Habits
from story_plant import START, Plant, Story, Tale


def reset_in_vain(p: Plant) -> tuple[Log, Tale]:
    """t11: a drive is too hot; two resets do not help, the third does."""
    p.io(2, "heartbeat 300 ms")
    drive = p.drive(
        4,
        "heartbeat 300 ms, monitors 127 with 900 ms (written), TPDO1 type 255 with event timer 300 ms",
        pdo=False,
        kind=255,
        event_ms=300,
    )
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.configure_drive(4, kind=255)
    p.cycle()
    p.nmt(START)
    p.wait(0.5)
    p.enable(4)
    p.wait(1.0)
    struck = p.wait(0.0)
    axis = drive.axes[0]
    axis.fault(0x4310, 0x08, cause="hot")
    p.wait(0.6)
    tries = [p.reset_fault(4), p.reset_fault(4)]
    axis.causes.clear()
    p.wait(0.3)
    tries.append(p.reset_fault(4))
    p.enable(4)
    p.wait(1.5)
    log = p.finish()
    raised = log.first(emcy(4, 0x4310), struck)
    return log, Tale(
        "A drive is too hot; two fault resets come too early, the third helps",
        [
            Story(
                "drive 4 reported EMCY 4310h (temperature of the drive) and went to fault; two fault resets (edges of "
                "bit 7) had no effect because the cause stood; the third took it back (EMCY 0000h), enabled again "
                "after",
                {"node": 4, "axis": "drive 4"},
                raised,
                raised,
                log.first(on(0x184, "3702"), tries[2]),
                "ended",
                [
                    log.first(on(0x184, "1F02"), struck),
                    log.first(on(0x184, "1802"), struck),
                    *[log.first(on(0x204, "8000"), when) for when in tries],
                    log.first(emcy(4, 0x0000), tries[2]),
                    log.first(on(0x184, "5002"), tries[2]),
                ],
                "the axis stood from the fault to operation enabled",
                "cooling and load of drive 4; resets before it has cooled down cannot help",
            )
        ],
        ["the resets had no edge", "communication is the cause", "anything stands at the end", "three faults"],
    )


def reset_without_edge(p: Plant) -> tuple[Log, Tale]:
    """t12: the controller holds bit 7 of the controlword, so there is no edge when a reset is wanted."""
    p.io(2, "heartbeat 300 ms")
    drive = p.drive(
        4,
        "heartbeat 300 ms, monitors 127 with 900 ms (written), TPDO1 type 1; EMCY after the statusword",
        pdo=False,
        habits=Habits(emcy_first=False),
    )
    p.run_up(configure=lambda: p.configure_drive(4))
    for controlword in (0x0086, 0x0087, 0x008F):
        p.command(4, controlword, 60_000 if controlword == 0x008F else 0)
        p.wait(0.25)
    p.wait(1.0)
    struck = p.wait(0.0)
    drive.axes[0].fault(0x2310, 0x02)
    p.wait(0.6)
    tried = p.wait(0.0)
    for controlword in (0x0080, 0x0086, 0x0087, 0x008F, 0x0080):
        p.command(4, controlword)
        p.wait(0.5)
    p.wait(1.5)
    log = p.finish()
    raised = log.first(emcy(4, 0x2310), struck)
    shown = log.first(on(0x184, "1F02", "1802"), struck)
    return log, Tale(
        "A drive faults, and its reset has no edge: the controller holds bit 7 all the time",
        [
            Story(
                "drive 4 went to fault (EMCY 2310h, current at the output) and stays there: bit 7 of the controlword "
                "is 1 in every RPDO (also before the fault), so there is no rising edge, and no reset",
                {"node": 4, "axis": "drive 4"},
                min(raised, shown),
                max(raised, shown),
                None,
                "open",
                [
                    log.first(on(0x204, "8000"), tried),
                    log.all(on(0x204, "8000"), tried)[-1],
                    log.all(on(0x184), tried)[-1],
                ],
                "the axis stands; the steps 06h, 07h, 0Fh have no effect",
                "the controller's sequence: controlword 0, then 80h; then the motor and its cable (2310h)",
            )
        ],
        ["the cause of the fault still stands (it was over at once; nothing shows it)", "communication is the cause"],
    )


def both_axes(p: Plant) -> tuple[Log, Tale]:
    """t13: safe torque off stops both axes of a device, without an EMCY; later everything is put right."""
    p.io(2, "heartbeat 300 ms")
    drive = p.drive(
        5,
        "heartbeat 300 ms, monitors 127 with 900 ms (preset), TPDO1/2 type 1 (mapping read by the controller)",
        axes=2,
        consumers=[(127, 900)],
    )

    def look() -> None:
        for number in (0, 1):
            for index, subs in ((0x1400, (1, 2)), (0x1600, (0, 1, 2)), (0x1800, (1, 2)), (0x1A00, (0, 1, 2))):
                for sub in subs:
                    p.read(5, index + number, sub)

    p.run_up(5, configure=look)
    p.command(5, 0x000F, -60_000, axis=1)
    p.wait(1.0)
    struck = p.wait(0.0)
    drive.safe_torque_off(True, fault=True)
    p.wait(0.4)
    p.command(5, 0x0000)
    p.wait(1.6)
    released = p.wait(0.0)
    drive.safe_torque_off(False, fault=False)
    p.wait(0.5)
    tried = p.reset_fault(5)
    p.enable(5)
    p.wait(1.5)
    log = p.finish()
    first = min(log.first(on(can_id, "0F02", "0802"), struck) for can_id in (0x185, 0x285))
    second = max(log.first(on(can_id, "0F02", "0802"), struck) for can_id in (0x185, 0x285))
    return log, Tale(
        "Both axes of a device fault at the same moment, without an EMCY (safe torque off)",
        [
            Story(
                "both axes of node 5 fell from operation enabled to fault in the same cycle, without an EMCY and with "
                "bit 4 (voltage enabled) gone: the safety circuit opened; 2 s later it was closed, both were reset "
                "and enabled again",
                {"node": 5, "axis": "both axes of node 5"},
                first,
                second,
                log.first(on(0x285, "3702"), tried),
                "ended",
                [
                    log.first(on(0x205, "8000"), tried),
                    log.first(on(0x305, "8000"), tried),
                    log.first(on(0x185, "1802"), released),
                    log.first(on(0x185, "3702"), tried),
                ],
                "both axes stood from then on",
                "what both have in common: emergency stop, safe torque off, supply of the power stage",
            )
        ],
        ["two independent faults", "communication is the cause", "anything stands at the end"],
    )


def enable_without_effect(p: Plant) -> tuple[Log, Tale]:
    """t26: a drive is told to enable while safe torque off is on."""
    p.io(2, "heartbeat 300 ms")
    drive = p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (written), TPDO1 type 1", pdo=False)
    drive.torque_off = True

    p.run_up(configure=lambda: p.configure_drive(4))
    told = p.wait(0.0)
    p.enable(4)
    p.wait(1.0)
    again = p.wait(0.0)
    p.enable(4)
    p.wait(2.5)
    log = p.finish()
    shutdown = log.first(on(0x204, "0600"), told)
    enable = log.first(on(0x204, "0F00"), told)
    return log, Tale(
        "A drive does not enable: safe torque off is on",
        [
            Story(
                "drive 4 does not follow 06h, 07h, 0Fh: it stays in switch on disabled, with bit 4 (voltage enabled) "
                "0; a second attempt has no effect either",
                {"node": 4, "axis": "drive 4"},
                shutdown,
                log.first(on(0x184, "4002"), log.stamp(enable)),
                None,
                "open",
                [enable, log.first(on(0x204, "0600"), again), log.all(on(0x184, "4002"))[-1]],
                "the axis does not move; no EMCY, no fault",
                "safe torque off, mains and intermediate circuit of drive 4 (bit 4 of the statusword is 0)",
            )
        ],
        ["drive 4 faulted", "the commands did not arrive (node 4 is Operational, RPDO1 is valid)"],
    )


def controller_paused(p: Plant) -> tuple[Log, Tale]:
    """t27: the controller's program stands still for 1.8 s: quick stop, then put right."""
    p.io(2, "heartbeat 300 ms")
    p.drive(
        5,
        "heartbeat 300 ms, monitors 127 with 900 ms (written), 6007h = 3 (quick stop), 1029h:01 = 1, TPDO1 type 255 "
        "with event timer 300 ms",
        pdo=False,
        kind=255,
        event_ms=300,
        reaction=3,
        behaviour=1,
        habits=Habits(reaction_s=0.05, detail=True),
    )
    p.run_up(5, configure=lambda: p.configure_drive(5, kind=255))
    p.stop("heartbeat", "cycle")
    stalled = p.wait(0.0)
    p.wait(1.8)
    back = p.wait(0.0)
    p.heartbeat()
    p.cycle()
    p.command(5, 0x0000)
    p.wait(1.0)
    p.enable(5)
    p.wait(1.5)
    log = p.finish()
    seen = log.first(emcy(5, 0x8130), stalled)
    return log, Tale(
        "The controller stands still for 1.8 s; a drive does a quick stop and is enabled again",
        [
            Story(
                "the controller (127) stood still for 1.8 s: no heartbeat, no SYNC, no RPDOs; then it went on",
                {"node": 127},
                log.last(lambda line: controller(line) or on(0x080)(line), stalled + 0.02),
                seen,
                log.first(lambda line: controller(line) or on(0x080)(line), back),
                "ended",
                [log.last(on(0x77F), stalled + 0.02), log.last(on(0x080), stalled + 0.02)],
                "no set-points for 1.8 s",
                "load and program of the controller; its CAN adapter",
            ),
            Story(
                "drive 5 missed it (EMCY 8130h), did a quick stop (6007h = 3), took the error back when the heartbeat "
                "came again, and was enabled again",
                {"node": 5, "axis": "drive 5"},
                seen,
                seen,
                log.first(on(0x185, "3702"), back),
                "ended",
                [
                    log.first(on(0x185, "1702"), stalled),
                    log.first(on(0x185, "5002"), stalled),
                    log.first(emcy(5, 0x0000), back),
                ],
                "the axis stopped",
                "the controller, not the drive",
                caused_by=0,
            ),
        ],
        ["drive 5 is defective", "the drive stopped by itself for no reason", "anything stands at the end"],
    )


SCENARIOS = {
    "t11-reset-in-vain": reset_in_vain,
    "t12-reset-without-edge": reset_without_edge,
    "t13-both-axes": both_axes,
    "t26-enable-without-effect": enable_without_effect,
    "t27-controller-paused": controller_paused,
}
