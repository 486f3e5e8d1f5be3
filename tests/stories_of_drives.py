"""Stories of drives that fault, and of resets that do not help.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from story_log import Log, emcy, on
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
                "bit 7) had no effect because the cause stood; the third took it back (EMCY 0000h), enabled again after",
                {"node": 4, "axis": "drive 4"},
                raised,
                raised,
                log.first(on(0x184, "3702"), tries[2]),
                "over",
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


SCENARIOS = {
    "t11-reset-in-vain": reset_in_vain,
}
