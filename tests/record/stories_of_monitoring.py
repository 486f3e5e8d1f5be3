"""Stories of guarding, heartbeat consumers and the recording itself.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from story_log import answer, emcy, of, on
from story_plant import START, Plant, Seen, Tale


def flapping(p: Plant) -> Tale:
    """t03: a loose contact: a node goes and comes three times, without restarting."""
    p.io(
        2,
        "heartbeat 300 ms, monitors 3 with 700 ms (preset), 1029h:01 = 1, 1015h = 20 ms",
        consumers=[(3, 700)],
        behaviour=1,
        emcy_inhibit_100us=200,
    )
    device = p.io(3, "heartbeat 300 ms; its connector is loose")
    p.run_up()
    began = p.wait(0.0)
    gone, back = [], []
    for _ in range(3):
        device.pull_cable()
        gone.append(p.wait(0.0))
        back.append(p.wait(1.2))
        device.plug_cable()
        p.wait(1.0)
    p.wait(2.5)
    log = p.finish()
    seen = log.all(emcy(2, 0x8130), began)
    return Tale(
        log,
        [
            Seen(
                log.last(of(3), gone[0] + 0.01),
                seen[0],
                log.first(of(3), back[2]),
                [*[log.last(of(3), when + 0.01) for when in gone], *[log.first(of(3), when) for when in back]],
            ),
            Seen(seen[0], seen[0], log.all(emcy(2, 0x0000), began)[-1], [*seen, *log.all(emcy(2, 0x0000), began)]),
        ],
    )


def consumer_too_short(p: Plant) -> Tale:
    """t06: 1016h is shorter than the period that is kept; both are preset, one is read."""
    p.io(
        2,
        "heartbeat 300 ms, monitors 5 with 500 ms and 127 with 900 ms (preset, read once by the controller), 1029h:01 "
        "= 1",
        consumers=[(5, 500), (127, 900)],
        behaviour=1,
    )
    p.io(5, "heartbeat 800 ms (preset)", heartbeat_ms=800)
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.heartbeat()
    p.power_up()
    p.wait(0.2)
    read_at = p.wait(0.0)
    p.read(2, 0x1016, 1)
    p.read(2, 0x1016, 2)
    p.wait(0.2)
    p.cycle()
    p.wait(0.2)
    p.nmt(START)
    p.wait(0.4)
    p.enable(4)
    p.wait(5.5)
    log = p.finish()
    seen = log.all(emcy(2, 0x8130))
    read = log.first(answer(2, 0x1016, 1, "4"), read_at)
    return Tale(
        log,
        [
            Seen(
                min(read, seen[0]),
                max(read, seen[0], log.all(emcy(2, 0x8130))[1]),
                None,
                [read, *seen[:3], seen[-1], *log.all(emcy(2, 0x0000))[:2]],
                words={
                    "kind": "configuration does not fit: node 2 allows node 5 500 ms (1016h:01 = 000501F4h) but node 5 "
                    f"sends its heartbeat every 800 ms: EMCY 8130h once in each period, taken back 0.3 s later, "
                    f"{len(seen)} times"
                },
            )
        ],
    )


def guarding_stopped(p: Plant) -> Tale:
    """t23: the master stops guarding a drive."""
    p.io(2, "heartbeat 300 ms")
    p.drive(
        4,
        "no heartbeat; node guarding: 100Ch = 300 ms, 100Dh = 3 (written), 6007h = 1, 1029h:01 = 1, TPDO1 type 1",
        pdo=False,
        heartbeat_ms=0,
        behaviour=1,
    )

    def configure() -> None:
        p.write(4, 0x100C, 0, 300, 6)
        p.write(4, 0x100D, 0, 3, 5)
        p.write_pdo(4, 0x1400, 1, 0x204, 1, (0x6040_0010, 0x607A_0020))
        p.write_pdo(4, 0x1800, 1, 0x4000_0184, 1, (0x6041_0010, 0x6064_0020))
        p.guard(4, 300)

    p.run_up(4, configure=configure, heartbeat=False)
    p.stop("guarding")
    stopped = p.wait(0.0)
    p.wait(4.0)
    log = p.finish()
    last = log.last(on(0x704, "R"), stopped + 0.02)
    seen = log.first(emcy(4, 0x8130), stopped)
    return Tale(
        log,
        [
            Seen(last, seen, None, [log.last(of(4), log.stamp(last) + 0.05)]),
            Seen(
                seen, seen, None, [log.first(on(0x184, "1F02", "1802"), stopped), log.first(on(0x184, "1802"), stopped)]
            ),
        ],
    )


def guarding_unanswered(p: Plant) -> Tale:
    """t24: a guarded node dies; the master goes on asking."""
    p.io(2, "heartbeat 300 ms")
    p.io(6, "no heartbeat; node guarding: 100Ch = 300 ms, 100Dh = 3 (preset)", heartbeat_ms=0, guarding=(300, 3))
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.run_up(4, configure=lambda: p.guard(6, 300))
    p.wait(0.5)
    p.devices[6].power_off()
    died = p.wait(0.0)
    p.wait(4.5)
    log = p.finish()
    last = log.last(of(6), died + 0.02)
    asked = log.all(on(0x706, "R"), died)
    return Tale(log, [Seen(last, asked[1], None, [asked[0], asked[-1]])])


def recorder_stall(p: Plant) -> Tale:
    """t20: the recorder stands still; the bus is healthy."""
    p.io(2, "heartbeat 300 ms, monitors 3 with 900 ms (preset)", consumers=[(3, 900)])
    p.io(3, "heartbeat 300 ms, monitors 2 and 127 with 900 ms (preset)", consumers=[(2, 900), (127, 900)])
    p.io(6, "heartbeat 300 ms")
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.run_up(4)
    p.wait(1.0)
    before = p.wait(0.0)
    p.stall_recorder(1.6)
    p.wait(3.5)
    log = p.finish()
    gaps = [
        (later.stamp - line.stamp, line.number)
        for line, later in zip(log.lines, log.lines[1:], strict=False)
        if line.stamp > before - 0.1
    ]
    length, edge = max(gaps)
    return Tale(
        log,
        [
            Seen(
                edge,
                edge + 1,
                edge + 1,
                words={
                    "kind": "hole in the recording: candump was stopped for 1.6 s and its small receive buffer ran "
                    f"over; no frame of anybody for {length:.2f} s"
                },
            )
        ],
        [{"line": edge + 1, "kind": f"no frame of any node for {length * 1000:.0f} ms"}],
    )


SCENARIOS = {
    "t03-flapping": flapping,
    "t06-consumer-too-short": consumer_too_short,
    "t20-recorder-stall": recorder_stall,
    "t23-guarding-stopped": guarding_stopped,
    "t24-guarding-unanswered": guarding_unanswered,
}
