"""Stories of nodes, cables and controllers that go away.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from story_log import controller, emcy, nmt, of, on
from story_nodes import Habits
from story_plant import START, Plant, Seen, Tale


def node_dead(p: Plant) -> Tale:
    """t01: a drive dies; an I/O node watches it."""
    p.io(2, "heartbeat 300 ms")
    p.io(3, "heartbeat 300 ms, monitors 5 with 700 ms and 127 with 900 ms (written), 1029h:01 = 0")
    p.drive(5, "heartbeat 300 ms, monitors 127 with 900 ms (written), SYNC type 1", pdo=False)
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.write(3, 0x1016, 1, 5 << 16 | 700)
    p.write(3, 0x1016, 2, 127 << 16 | 900)
    p.configure_drive(5)
    p.cycle()
    p.wait(0.4)
    p.nmt(START)
    p.wait(0.4)
    p.enable(5)
    p.wait(1.0)
    p.devices[5].power_off()
    died = p.wait(0.0)
    p.wait(4.5)
    log = p.finish()
    last = log.last(of(5), died + 0.05)
    seen = log.first(emcy(3, 0x8130), died)
    fell = log.first(on(0x703, "7F"), died)
    return Tale(log, [Seen(last, seen), Seen(seen, seen, None, [fell])])


def cable_off(p: Plant) -> Tale:
    """t02: the cable of a drive is off for 2.6 s; the drive goes on and misses the controller."""
    p.io(2, "heartbeat 300 ms")
    p.drive(
        4,
        "heartbeat 300 ms, monitors 127 with 900 ms (preset, not on the bus), 6007h = 1, 1029h:01 = 0",
        consumers=[(127, 900)],
    )
    p.run_up(4)
    p.wait(0.2)
    p.devices[4].pull_cable()
    off = p.wait(0.0)
    p.wait(2.6)
    back = p.wait(0.0)
    p.devices[4].plug_cable()
    p.wait(1.5)
    p.command(4, 0)
    started = p.nmt(START, 4)
    p.wait(0.5)
    p.reset_fault(4)
    p.enable(4)
    p.wait(1.2)
    log = p.finish()
    last = log.last(of(4), off + 0.02)
    told = log.silence_told(4, last, 2, 0.3)
    lost = log.first(emcy(4, 0x8130), back)
    enabled = log.first(on(0x184, "3702"), started)
    return Tale(
        log,
        [
            Seen(last, told, log.first(of(4), back), [lost]),
            Seen(
                lost,
                lost,
                enabled,
                [
                    log.first(emcy(4, 0x0000), back),
                    log.first(on(0x704, "7F"), back),
                    log.first(nmt(START, 4), back),
                    log.first(on(0x184, "1802"), back),
                    log.first(on(0x204, "8000"), back),
                ],
            ),
        ],
    )


def segment_off(p: Plant) -> Tale:
    """t04: three nodes lose their common supply and get it back."""
    p.io(
        2,
        "heartbeat 300 ms, monitors 3 with 900 ms and 4 with 800 ms (preset), 1029h:01 = 1",
        consumers=[(3, 900), (4, 800)],
        behaviour=1,
    )
    p.io(3, "heartbeat 300 ms, behind the same supply as 4 and 5")
    p.io(4, "heartbeat 300 ms, behind the same supply")
    p.drive(5, "heartbeat 300 ms, monitors 127 with 900 ms (preset), behind the same supply", consumers=[(127, 900)])
    p.run_up(5)
    for node in (3, 4, 5):
        p.devices[node].power_off()
    off = p.wait(0.0)
    p.wait(0.3)
    p.command(5, 0)
    p.wait(2.2)
    back = p.wait(0.0)
    p.power_up(3, 4, 5)
    p.wait(0.8)
    p.nmt(START)
    p.wait(0.5)
    p.enable(5)
    p.wait(1.2)
    log = p.finish()
    seen = log.first(emcy(2, 0x8130), off)
    boots = [log.first(on(0x700 + node, "00"), back) for node in (3, 4, 5)]
    return Tale(
        log,
        [
            Seen(
                min(log.last(of(node), off + 0.02) for node in (3, 4, 5)),
                seen,
                log.first(on(0x185, "3702"), back),
                [*boots, *(log.last(of(node), off + 0.02) for node in (3, 4, 5)), log.first(nmt(START, 0), back)],
            ),
            Seen(seen, seen, log.all(emcy(2, 0x0000), off)[-1], log.all(emcy(2, 0x8130), off)),
        ],
    )


def restart_loop(p: Plant) -> Tale:
    """t05: a watchdog restarts a node every 1.2 s, for ever."""
    p.io(2, "heartbeat 300 ms")
    p.io(6, "heartbeat 200 ms; its watchdog restarts it every 1.2 s", heartbeat_ms=200)
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.run_up(4)
    began = p.wait(0.0)
    for _ in range(6):
        p.devices[6].restart()
        p.wait(1.2)
    log = p.finish()
    boots = log.all(on(0x706, "00"), began)
    return Tale(
        log,
        [
            Seen(
                log.last(of(6), log.stamp(boots[0])),
                boots[0],
                None,
                boots,
                words={
                    "kind": f"node 6, Operational until then, restarts by itself again and again, {len(boots)} times, "
                    "every 1.2 s (watchdog); nobody commands it and nobody starts it again"
                },
            )
        ],
    )


def controller_dead(p: Plant) -> Tale:
    """t14: the controller dies; everybody who watched it reacts as its maker meant it to."""
    p.io(
        2,
        "heartbeat 300 ms, TPDO1 by event timer 400 ms, 1400h:05 = 1200 ms (preset), 1029h:01 = 1",
        kind=255,
        event_ms=400,
        rpdo_event_ms=1200,
        behaviour=1,
    )
    p.drive(
        4,
        "heartbeat 300 ms, monitors 127 with 900 ms (written), 6007h = 1 (fault), 1029h:01 = 1, TPDO1 type 255",
        pdo=False,
        kind=255,
        event_ms=300,
        behaviour=1,
        habits=Habits(reaction_s=0.02),
    )
    p.drive(
        5,
        "heartbeat 300 ms, monitors 127 with 1000 ms (written), 6007h = 3 (quick stop), 1029h:01 = 1, TPDO1 type 255",
        pdo=False,
        kind=255,
        event_ms=300,
        reaction=3,
        behaviour=1,
        habits=Habits(reaction_s=0.15),
    )
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.configure_drive(4, kind=255)
    p.configure_drive(5, consumer_ms=1000, kind=255)
    p.cycle()
    p.wait(0.3)
    p.nmt(START)
    p.wait(0.5)
    p.enable(4, 5)
    p.wait(1.5)
    p.stop("heartbeat", "cycle")
    died = p.wait(0.0)
    p.wait(5.0)
    log = p.finish()
    seen4, seen5 = log.first(emcy(4, 0x8130), died), log.first(emcy(5, 0x8130), died)
    late = log.first(emcy(2, 0x8250), died)
    return Tale(
        log,
        [
            Seen(
                log.last(controller, died + 0.02),
                min(seen4, seen5, late),
                None,
                [log.last(on(0x77F), died + 0.02), log.last(on(0x080), died + 0.02)],
            ),
            Seen(seen4, seen4, None, [log.first(on(0x184, "1F02"), died), log.first(on(0x184, "1802"), died)]),
            Seen(seen5, seen5, None, [log.first(on(0x185, "1702"), died), log.first(on(0x185, "5002"), died)]),
            Seen(late, late, None, [log.last(on(0x202), died + 0.02)]),
        ],
    )


def sync_producer_dead(p: Plant) -> Tale:
    """t16: the device that produces SYNC dies; the drives' actual values come by event timer."""
    p.io(
        2,
        "heartbeat 300 ms, SYNC producer 100 ms (1005h/1006h preset, not on the bus)",
        sync_us=100_000,
        sync_producer=True,
        kind=255,
        event_ms=500,
    )
    for node, code in ((3, 0x8700), (4, 0x8100)):
        p.drive(
            node,
            f"heartbeat 300 ms, monitors 127 with 900 ms and SYNC (1006h = 100 ms, 250 ms allowed, EMCY {code:04X}h), "
            "RPDO1 type 1, TPDO1 type 255 with event timer 300 ms, 1029h:01 = 1, 6007h = 1",
            consumers=[(127, 900)],
            sync_us=100_000,
            behaviour=1,
            event_ms=300,
            habits=Habits(sync_code=code, reaction_s=0.0 if node == 3 else 0.1),
        )
        p.devices[node].local.set_data(0x1800, 2, b"\xff")
        p.devices[node].stored = {0x1800: {2: b"\xff"}}
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.cycle(sync=False)
    p.wait(0.3)
    p.nmt(START)
    p.wait(0.5)
    p.enable(3, 4)
    p.wait(1.5)
    p.devices[2].power_off()
    died = p.wait(0.0)
    p.wait(5.0)
    log = p.finish()
    seen = [log.first(emcy(3, 0x8700), died), log.first(emcy(4, 0x8100), died)]
    last = log.last(of(2), died + 0.02)
    last_sync = log.last(on(0x080), died + 0.02)
    stories = [Seen(max(last, last_sync), min(seen), None, [last, last_sync]), Seen(last_sync, min(seen))]
    stories.append(
        Seen(
            min(seen),
            max(seen),
            None,
            [*seen, *[log.first(on(0x180 + node, word), died) for node in (3, 4) for word in ("1F02", "1802")]],
        )
    )
    return Tale(log, stories)


def forgotten(p: Plant) -> Tale:
    """t17: a node restarts by itself and nobody starts it again."""
    p.io(2, "heartbeat 300 ms")
    p.io(4, "heartbeat 300 ms, TPDO1 type 1")
    p.drive(5, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.run_up(5)
    p.wait(0.5)
    p.devices[4].restart()
    dipped = p.wait(0.0)
    p.wait(6.0)
    log = p.finish()
    boot = log.first(on(0x704, "00"), dipped)
    return Tale(
        log,
        [
            Seen(
                log.last(of(4), log.stamp(boot)),
                boot,
                None,
                [log.first(on(0x704, "7F"), dipped), log.all(on(0x704, "7F"), dipped)[-1]],
            )
        ],
    )


SCENARIOS = {
    "t01-node-dead": node_dead,
    "t02-cable-off": cable_off,
    "t04-segment-off": segment_off,
    "t05-restart-loop": restart_loop,
    "t14-controller-dead": controller_dead,
    "t16-sync-producer-dead": sync_producer_dead,
    "t17-forgotten": forgotten,
}
