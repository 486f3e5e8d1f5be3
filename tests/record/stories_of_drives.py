"""Stories of drives that fault, and of resets that do not help.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from story_log import controller, emcy, on
from story_nodes import Habits
from story_plant import START, Plant, Seen, Tale


def reset_in_vain(p: Plant) -> Tale:
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
    return Tale(
        log,
        [
            Seen(
                raised,
                raised,
                log.first(on(0x184, "3702"), tries[2]),
                [
                    log.first(on(0x184, "1F02"), struck),
                    log.first(on(0x184, "1802"), struck),
                    *[log.first(on(0x204, "8000"), when) for when in tries],
                    log.first(emcy(4, 0x0000), tries[2]),
                    log.first(on(0x184, "5002"), tries[2]),
                ],
            )
        ],
    )


def reset_without_edge(p: Plant) -> Tale:
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
    return Tale(
        log,
        [
            Seen(
                min(raised, shown),
                max(raised, shown),
                None,
                [
                    log.first(on(0x204, "8000"), tried),
                    log.all(on(0x204, "8000"), tried)[-1],
                    log.all(on(0x184), tried)[-1],
                ],
            )
        ],
    )


def both_axes(p: Plant) -> Tale:
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
    return Tale(
        log,
        [
            Seen(
                first,
                second,
                log.first(on(0x285, "3702"), tried),
                [
                    log.first(on(0x205, "8000"), tried),
                    log.first(on(0x305, "8000"), tried),
                    log.first(on(0x185, "1802"), released),
                    log.first(on(0x185, "3702"), tried),
                ],
            )
        ],
    )


def enable_without_effect(p: Plant) -> Tale:
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
    return Tale(
        log,
        [
            Seen(
                shutdown,
                log.first(on(0x184, "4002"), log.stamp(enable)),
                None,
                [enable, log.first(on(0x204, "0600"), again), log.all(on(0x184, "4002"))[-1]],
            )
        ],
    )


def controller_paused(p: Plant) -> Tale:
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
    return Tale(
        log,
        [
            Seen(
                log.last(lambda line: controller(line) or on(0x080)(line), stalled + 0.02),
                seen,
                log.first(lambda line: controller(line) or on(0x080)(line), back),
                [log.last(on(0x77F), stalled + 0.02), log.last(on(0x080), stalled + 0.02)],
            ),
            Seen(
                seen,
                seen,
                log.first(on(0x185, "3702"), back),
                [
                    log.first(on(0x185, "1702"), stalled),
                    log.first(on(0x185, "5002"), stalled),
                    log.first(emcy(5, 0x0000), back),
                ],
            ),
        ],
    )


SCENARIOS = {
    "t11-reset-in-vain": reset_in_vain,
    "t12-reset-without-edge": reset_without_edge,
    "t13-both-axes": both_axes,
    "t26-enable-without-effect": enable_without_effect,
    "t27-controller-paused": controller_paused,
}
