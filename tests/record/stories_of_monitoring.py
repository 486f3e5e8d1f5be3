"""Stories of guarding, heartbeat consumers and the recording itself.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from story_log import Log, answer, emcy, of, on
from story_plant import START, Plant, Story, Tale


def flapping(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "A loose connector: a node goes and comes three times without restarting",
        [
            Story(
                "node 3 was not to be heard three times, for 1.2 s each, and came back each time without a boot-up: "
                "its connection is loose",
                {"node": 3},
                log.last(of(3), gone[0] + 0.01),
                seen[0],
                log.first(of(3), back[2]),
                "ended",
                [
                    *[log.last(of(3), when + 0.01) for when in gone],
                    *[log.first(of(3), when) for when in back],
                ],
                "TPDO1 of node 3 (183h) missing meanwhile; it stays Operational all the time",
                "connector and cable of node 3: no boot-up, so its supply was there; three times, so it will come "
                "again",
            ),
            Story(
                "node 2 reported it each time (EMCY 8130h) and took it back each time",
                {"node": 2},
                seen[0],
                seen[0],
                log.all(emcy(2, 0x0000), began)[-1],
                "ended",
                [*seen, *log.all(emcy(2, 0x0000), began)],
                "none",
                "nothing at node 2",
                caused_by=0,
            ),
        ],
        ["node 3 restarted", "three or six independent problems", "node 2 is defective", "anything stands at the end"],
    )


def consumer_too_short(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "A heartbeat consumer time is shorter than the period of the producer",
        [
            Story(
                "configuration does not fit: node 2 allows node 5 500 ms (1016h:01 = 000501F4h) but node 5 sends its "
                f"heartbeat every 800 ms: EMCY 8130h once in each period, taken back 0.3 s later, {len(seen)} times",
                {"node": 2, "nodes": [2, 5]},
                min(read, seen[0]),
                max(read, seen[0], log.all(emcy(2, 0x8130))[1]),
                None,
                "open",
                [read, *seen[:3], seen[-1], *log.all(emcy(2, 0x0000))[:2]],
                "a false alarm: node 5 is there all the time",
                "1016h:01 of node 2 against 1017h of node 5: at least 1200 ms, or a shorter 1017h",
            )
        ],
        ["node 5 was lost", "node 5's heartbeat is late or irregular", "many independent incidents"],
    )


def guarding_stopped(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "The controller stops guarding a drive; the drive misses it",
        [
            Story(
                "the controller stopped guarding node 4 (no RTR on 704h any more, every 300 ms before); SYNC and "
                "RPDOs go on",
                {"nodes": [127, 4]},
                last,
                seen,
                None,
                "open",
                [log.last(of(4), log.stamp(last) + 0.05)],
                "node 4 is no longer supervised",
                "the controller: why it stopped guarding (program, node taken off its list)",
            ),
            Story(
                "drive 4 noticed it after 900 ms (100Ch x 100Dh; life guarding, EMCY 8130h) and went to fault (6007h "
                "= 1)",
                {"node": 4, "axis": "drive 4"},
                seen,
                seen,
                None,
                "open",
                [log.first(on(0x184, "1F02", "1802"), stopped), log.first(on(0x184, "1802"), stopped)],
                "the axis stands",
                "the controller, not the drive",
                caused_by=0,
            ),
        ],
        ["node 4 does not answer guarding", "node 4 is lost (TPDO1 and EMCY go on)", "the drive is defective"],
    )


def guarding_unanswered(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "A guarded node dies and does not answer any more",
        [
            Story(
                "node 6 went silent (supply switched off): guarding requests (RTR 706h) are not answered any more, "
                "TPDO1 (186h) stopped",
                {"node": 6},
                last,
                asked[1],
                None,
                "open",
                [asked[0], asked[-1]],
                "the controller goes on asking every 300 ms",
                "supply and connector of node 6",
            )
        ],
        ["the controller stopped guarding", "nodes 2 or 4 had trouble"],
    )


def recorder_stall(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "The recorder stands still for 1.6 s on a healthy bus (harmless)",
        [
            Story(
                "hole in the recording: candump was stopped for 1.6 s and its small receive buffer ran over; no frame "
                f"of anybody for {length:.2f} s",
                {"nodes": []},
                edge,
                edge + 1,
                edge + 1,
                "harmless",
                [],
                "frames are missing in the capture; the bus was in order: all go on where they were, no EMCY although "
                "nodes monitor each other with 900 ms",
                "the recording machine",
            )
        ],
        ["heartbeats were lost", "SYNC failed", "TPDOs missed as a fault", "a power failure or cut of the whole bus"],
        natural=[{"line": edge + 1, "kind": f"no frame of any node for {length * 1000:.0f} ms"}],
    )


SCENARIOS = {
    "t03-flapping": flapping,
    "t06-consumer-too-short": consumer_too_short,
    "t20-recorder-stall": recorder_stall,
    "t23-guarding-stopped": guarding_stopped,
    "t24-guarding-unanswered": guarding_unanswered,
}
