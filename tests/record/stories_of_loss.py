"""Stories of nodes, cables and controllers that go away.

What it must not do: take a truth from anything but what was done to the plant and the frames that followed.
"""

from __future__ import annotations

from story_log import Log, controller, emcy, nmt, of, on
from story_nodes import Habits
from story_plant import START, Plant, Story, Tale

SUPPLY = "supply, connector and LEDs of node {}: it said nothing before it stopped, and no frame explains it"


def node_dead(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "A drive dies and stays dead; the node that monitors it reports it and falls back",
        [
            Story(
                "node 5 went silent (supply switched off; nothing on the bus caused it) and did not come back",
                {"node": 5},
                last,
                seen,
                None,
                "open",
                [],
                "no heartbeat and no TPDO1 (185h) of drive 5; its RPDO1 (205h) goes on and reaches nobody",
                SUPPLY.format(5),
            ),
            Story(
                "node 3 noticed it (heartbeat consumer, EMCY 8130h) and left Operational by itself (1029h:01 = 0)",
                {"node": 3},
                seen,
                seen,
                None,
                "open",
                [fell],
                "TPDO1 of node 3 (183h) stopped; nobody starts it again",
                "nothing wrong in node 3: node 5; then NMT start of node 3",
                caused_by=0,
            ),
        ],
        ["node 3 restarted or went silent", "EMCY 8130h is a defect of node 3", "nodes 2 or 127 had trouble"],
    )


def cable_off(p: Plant) -> tuple[Log, Tale]:
    """t02: the cable of a drive is off for 2.6 s; the drive goes on and misses the controller."""
    p.io(2, "heartbeat 300 ms")
    p.drive(
        4,
        "heartbeat 300 ms, monitors 127 with 900 ms (preset, not on the bus), 6007h = 1, 1029h:01 = 0",
        consumers=[(127, 900)],
    )
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.cycle()
    p.nmt(START)
    p.wait(0.5)
    p.enable(4)
    p.wait(1.2)
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
    return log, Tale(
        "The cable of one drive is off for 2.6 s: no restart, but the drive missed its controller",
        [
            Story(
                "node 4 was not to be heard for 2.6 s and came back without a boot-up: it had kept its supply, only "
                "the connection was broken",
                {"node": 4},
                last,
                told,
                log.first(of(4), back),
                "ended",
                [lost],
                "no heartbeat, no statusword; controlwords sent meanwhile did not arrive",
                "connector and cable of node 4 (no boot-up on return: supply was there)",
            ),
            Story(
                "behind the broken connection node 4 missed the heartbeat of 127: EMCY 8130h (sent when the cable was "
                "back), fault by 6007h, Pre-operational by 1029h; over after NMT start, fault reset and enabling",
                {"node": 4},
                lost,
                lost,
                enabled,
                "ended",
                [
                    log.first(emcy(4, 0x0000), back),
                    log.first(on(0x704, "7F"), back),
                    log.first(nmt(START, 4), back),
                    log.first(on(0x184, "1802"), back),
                    log.first(on(0x204, "8000"), back),
                ],
                "the axis stood from then on",
                "the connection of node 4, not the controller: its heartbeat (77F) never paused",
                caused_by=0,
            ),
        ],
        [
            "node 4 restarted or lost power",
            "the controller (127) failed or paused",
            "the fault of the drive is one of motor or power stage",
            "anything stands at the end",
        ],
        "While the cable is off frames of node 4 are lost, but EMCYs wait in its controller until they are sent.",
    )


def segment_off(p: Plant) -> tuple[Log, Tale]:
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
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.cycle()
    p.nmt(START)
    p.wait(0.5)
    p.enable(5)
    p.wait(1.0)
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
    return log, Tale(
        "Three nodes lose their common supply at once and come back",
        [
            Story(
                "nodes 3, 4 and 5 went silent within one heartbeat period and came back 2.5 s later, each with a "
                "boot-up: their common supply was interrupted",
                {"nodes": [3, 4, 5]},
                min(log.last(of(node), off + 0.02) for node in (3, 4, 5)),
                seen,
                log.first(on(0x185, "3702"), back),
                "ended",
                [*boots, *(log.last(of(node), off + 0.02) for node in (3, 4, 5)), log.first(nmt(START, 0), back)],
                "no frames of the three; drive 5 had to be enabled again",
                "what the three have in common: fuse, supply, distributor. All came back with a boot-up, so power was "
                "gone",
            ),
            Story(
                "node 2, which monitors 3 and 4, reported both (EMCY 8130h twice) and took it back when both were "
                "there again",
                {"node": 2},
                seen,
                seen,
                log.all(emcy(2, 0x0000), off)[-1],
                "ended",
                log.all(emcy(2, 0x8130), off),
                "none: node 2 stays Operational (1029h:01 = 1)",
                "nothing at node 2",
                caused_by=0,
            ),
        ],
        [
            "three independent failures",
            "node 2 restarted, went silent or is defective",
            "a reset command caused it",
            "anything stands at the end",
        ],
    )


def restart_loop(p: Plant) -> tuple[Log, Tale]:
    """t05: a watchdog restarts a node every 1.2 s, for ever."""
    p.io(2, "heartbeat 300 ms")
    p.io(6, "heartbeat 200 ms; its watchdog restarts it every 1.2 s", heartbeat_ms=200)
    p.drive(4, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.cycle()
    p.nmt(START)
    p.wait(0.5)
    p.enable(4)
    p.wait(1.0)
    began = p.wait(0.0)
    for _ in range(6):
        p.devices[6].restart()
        p.wait(1.2)
    log = p.finish()
    boots = log.all(on(0x706, "00"), began)
    return log, Tale(
        "A node restarts every 1.2 s by itself and never gets further than Pre-operational",
        [
            Story(
                f"node 6, Operational until then, restarts by itself again and again, {len(boots)} times, every 1.2 s "
                "(watchdog); nobody commands it and nobody starts it again",
                {"node": 6},
                log.last(of(6), log.stamp(boots[0])),
                boots[0],
                None,
                "open",
                boots,
                "TPDO1 of node 6 (186h) is missing; it only ever reaches Pre-operational",
                "watchdog, supply and firmware of node 6: the even distance of 1.2 s speaks for a watchdog",
            )
        ],
        ["six independent incidents", "node 6 was reset by a command", "other nodes had trouble"],
    )


def controller_dead(p: Plant) -> tuple[Log, Tale]:
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
    return log, Tale(
        "The controller dies: both drives stop, each in its own way, and an RPDO times out",
        [
            Story(
                "the controller (127) died: its heartbeat, SYNC and all its RPDOs stop together and do not come back",
                {"node": 127},
                log.last(controller, died + 0.02),
                min(seen4, seen5, late),
                None,
                "open",
                [log.last(on(0x77F), died + 0.02), log.last(on(0x080), died + 0.02)],
                "no SYNC, no set-points, no commands",
                "the controller: program, computer, its CAN adapter and cable; everything else follows",
            ),
            Story(
                "drive 4 misses the controller (EMCY 8130h) and goes to fault (6007h = 1)",
                {"node": 4, "axis": "drive 4"},
                seen4,
                seen4,
                None,
                "open",
                [log.first(on(0x184, "1F02"), died), log.first(on(0x184, "1802"), died)],
                "the axis is without torque and must be reset",
                "the controller, not the drive",
                caused_by=0,
            ),
            Story(
                "drive 5 misses the controller (EMCY 8130h), does a quick stop (6007h = 3) and ends in switch on "
                "disabled",
                {"node": 5, "axis": "drive 5"},
                seen5,
                seen5,
                None,
                "open",
                [log.first(on(0x185, "1702"), died), log.first(on(0x185, "5002"), died)],
                "the axis must be enabled again",
                "the controller, not the drive",
                caused_by=0,
            ),
            Story(
                "node 2 gets no RPDO1 any more: EMCY 8250h",
                {"node": 2, "pdo": "RPDO1 of node 2 / 202h"},
                late,
                late,
                None,
                "open",
                [log.last(on(0x202), died + 0.02)],
                "outputs keep their last values; node 2 stays Operational (1029h:01 = 1)",
                "the controller, who sends 202h",
                caused_by=0,
            ),
        ],
        ["drives 4 and 5 are defective", "node 2 is the cause", "four independent problems", "nodes 2, 4, 5 are lost"],
    )


def sync_producer_dead(p: Plant) -> tuple[Log, Tale]:
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
    stories = [
        Story(
            "node 2, which produces SYNC, died: heartbeat, TPDO1 and SYNC stop together and do not come back",
            {"node": 2},
            max(last, last_sync),
            min(seen),
            None,
            "open",
            [last, last_sync],
            "no SYNC and no inputs (182h) from there on",
            SUPPLY.format(2) + "; everything else follows from it",
        ),
        Story(
            "no SYNC any more, every 100 ms before",
            {"nodes": []},
            last_sync,
            min(seen),
            None,
            "open",
            [],
            "RPDO1 of the drives (type 1) are no longer taken over",
            "node 2, who produced it",
            caused_by=0,
        ),
    ]
    stories.append(
        Story(
            "drives 3 and 4 miss SYNC: EMCY 8700h and 8100h, and fault",
            {"nodes": [3, 4], "axis": "drives 3 and 4"},
            min(seen),
            max(seen),
            None,
            "open",
            [*seen, *[log.first(on(0x180 + node, word), died) for node in (3, 4) for word in ("1F02", "1802")]],
            "the axes stand",
            "the SYNC producer (node 2), not the drives",
            caused_by=1,
        )
    )
    return log, Tale(
        "The device that produces SYNC dies; both drives fault",
        stories,
        ["drives 3 or 4 are defective or went silent", "the controller failed", "three independent roots"],
    )


def forgotten(p: Plant) -> tuple[Log, Tale]:
    """t17: a node restarts by itself and nobody starts it again."""
    p.io(2, "heartbeat 300 ms")
    p.io(4, "heartbeat 300 ms, TPDO1 type 1")
    p.drive(5, "heartbeat 300 ms, monitors 127 with 900 ms (preset)", consumers=[(127, 900)])
    p.heartbeat()
    p.power_up()
    p.wait(0.5)
    p.cycle()
    p.nmt(START)
    p.wait(0.5)
    p.enable(5)
    p.wait(1.5)
    p.devices[4].restart()
    dipped = p.wait(0.0)
    p.wait(6.0)
    log = p.finish()
    boot = log.first(on(0x704, "00"), dipped)
    return log, Tale(
        "An I/O node restarts by itself in operation, and the controller forgets to start it",
        [
            Story(
                "node 4, Operational until then, restarted by itself (boot-up without a command) and stays "
                "Pre-operational: the controller never starts it again",
                {"node": 4},
                log.last(of(4), log.stamp(boot)),
                boot,
                None,
                "open",
                [log.first(on(0x704, "7F"), dipped), log.all(on(0x704, "7F"), dipped)[-1]],
                "TPDO1 of node 4 (184h) is missing from there on; RPDO1 (204h) is sent to it without effect",
                "first the controller's reaction to a boot-up (NMT start), then the supply or watchdog of node 4",
            )
        ],
        ["node 4 was reset by a command", "node 4 is silent at the end", "nodes 2 or 5 had trouble"],
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
