"""Masters and slaves: a master does not obey its own commands to all, and its slaves do.

Over the ways in which a capture shows a node. Must not: test the words of a problem.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from captures import log_text
from diagnoses import ABOVE_HARMLESS, diagnosed
from kinds_of_nodes import PERIOD, beats
from network import START, Frames, Network

MASTER, SLAVE = 1, 5
STOP, PRE, RESET, RESET_COMMUNICATION = 0x02, 0x80, 0x81, 0x82
STATES = {STOP: 4, PRE: 0x7F, RESET: 0x7F, RESET_COMMUNICATION: 0x7F}


def problems(frames: Frames) -> list[tuple[str, int | None]]:
    """Kind and node of each root above harmless."""
    said = diagnosed(log_text(frames))
    roots = [one for one in said.incidents if not one["cause"] and one["status"] in ABOVE_HARMLESS]
    return [(one["problem"], one["subject"].get("node")) for one in roots]


def commanded(command: int, *, asked: str, of: int = MASTER, deaf: bool = False) -> Frames:
    """A command to all after 4 s, which nodes 6 and 7 obey; node `of` was asked by SDO before.

    Node 1 is Operational all the time; the slave 5 too where it is `deaf`, else it obeys.
    """
    net = Network()
    if asked == "write":
        net.write(of, 0x1017, 0, round(PERIOD * 1000), 2)
    elif asked == "manager":
        net.write(of, 0x1F80, 0, 0x0D, 4)
    elif asked == "read":
        net.read(of, 0x1000, 0, 0x00000195, 4)
    start = net.now
    beats(net, {MASTER: 10.0, 6: 4.0, 7: 4.0})
    if of == SLAVE:
        beats(net, {SLAVE: 10.0 if deaf else 4.0})
    net.now = start + 4.05
    net.nmt(command)
    obeying = [6, 7] if of != SLAVE or deaf else [SLAVE, 6, 7]
    if command in (RESET, RESET_COMMUNICATION):
        net.wait(0.05).boot(*obeying)
    for node in obeying:
        net.now = start + 4.2 + node * 0.001
        net.live(node, period=PERIOD, seconds=2.8, states=((0, STATES[command]),))
    net.now = start + 7.05
    net.nmt(START)
    for node in obeying:
        net.now = start + 7.1 + node * 0.001
        net.live(node, period=PERIOD, seconds=2.8, states=((0, 5),))
    return net.frames()


@pytest.mark.parametrize("asked", ["not", "read", "manager"])
@pytest.mark.parametrize("command", STATES)
def test_a_master_does_not_obey_itself(command: int, asked: str) -> None:
    assert problems(commanded(command, asked=asked)) == []


@pytest.mark.parametrize("command", STATES)
def test_a_slave_that_was_configured_obeys(command: int) -> None:
    assert problems(commanded(command, asked="write", of=SLAVE)) == []
    ((_, node), *others) = problems(commanded(command, asked="write", of=SLAVE, deaf=True))
    assert node == SLAVE and not others


def running(seconds: float) -> Network:
    """Nodes 6 and 7, which are Operational for a time from now on."""
    net = Network().boot(6, 7)
    for node in (6, 7):
        net.write(node, 0x1017, 0, round(PERIOD * 1000), 2).nmt(START, node)
    return beats(net, {6: seconds, 7: seconds})


def waiting(
    *, heartbeat: bool, reads: bool, runs: bool, boots: int = 1, started: bool = True, pdos: int = 80
) -> Frames:
    """Node 5 boots beside nodes 6 and 7, which run; it is read, and started or starts itself, or neither."""
    net = running(14.0)
    begin = net.now
    for number in range(boots):
        net.now = begin + 0.5 + number * 1.5
        net.boot(SLAVE)
        if reads:
            net.wait(0.1).read(SLAVE, 0x1000, 0, 0x000F_0191, 4).read(SLAVE, 0x1018, 1, 0x31, 4)
    if runs and started:
        net.nmt(START, SLAVE)
    if heartbeat:
        net.live(SLAVE, period=PERIOD, seconds=14 - (net.now - begin), states=((0, 5 if runs else 0x7F),))
    elif runs:
        net.cyclic(
            0x180 + SLAVE, period=(14 - (net.now - begin)) / pdos, payloads=[bytes([at % 251]) for at in range(pdos)]
        )
    return net.frames()


@pytest.mark.parametrize("pdos", [2, 8, 80])
def test_a_node_that_starts_itself(pdos: int) -> None:
    for heartbeat in (True, False):
        assert problems(waiting(heartbeat=heartbeat, reads=True, runs=True, started=False, pdos=pdos)) == []


@pytest.mark.parametrize("heartbeat", [True, False])
def test_a_node_that_is_read_and_never_started(*, heartbeat: bool) -> None:
    assert problems(waiting(heartbeat=heartbeat, reads=True, runs=False)) == [("not-started", SLAVE)]
    assert problems(waiting(heartbeat=heartbeat, reads=True, runs=True)) == []


def test_a_node_that_restarts_and_does_not_run_again() -> None:
    said = diagnosed(log_text(waiting(heartbeat=False, reads=False, runs=False, boots=2)))
    assert [(one["problem"], one["status"]) for one in said.incidents] == [("node-restarted", "unknown")]
    assert problems(waiting(heartbeat=False, reads=True, runs=False, boots=7)) == [("restart-loop", SLAVE)]


def alone(boots: int, *, period: float, heartbeats: bool = False, ordered: bool = False) -> Frames:
    """Boot-ups of the only node in a capture, perhaps commanded."""
    net = Network()
    for _ in range(boots):
        if ordered:
            net.nmt(RESET, SLAVE)
        begin = net.wait(0.05).boot(SLAVE).now
        if heartbeats:
            net.live(SLAVE, period=PERIOD, seconds=period - 0.2, states=((0, 0x7F),))
        net.now = begin + period
    return net.frames()


@pytest.mark.parametrize("period", [0.7, 1.5, 5.0, 9.0])
@pytest.mark.parametrize("heartbeats", [True, False])
def test_a_node_that_is_alone_and_boots_again_and_again(period: float, *, heartbeats: bool) -> None:
    for boots in (3, 7, 20):
        assert problems(alone(boots, period=period, heartbeats=heartbeats)) == [("restart-loop", SLAVE)]
    assert problems(alone(1, period=period, heartbeats=heartbeats)) == []
    assert ("restart-loop", SLAVE) not in problems(alone(3, period=period, ordered=True))


@pytest.mark.parametrize("boots", [3, 6])
def test_a_node_that_is_alone_and_switched_by_hand(boots: int) -> None:
    for period in (15.0, 60.0):
        assert problems(alone(boots, period=period)) == []


@pytest.mark.parametrize(("seconds", "status"), [(5, "open"), (15, "ended"), (60, "ended")])
def test_a_node_that_is_alone_and_stays_up(seconds: int, status: str) -> None:
    frames = alone(4, period=1.0)
    beat = frames[-1].t_us
    frames += [replace(frames[-1], data=b"\x7f", t_us=beat + number * 200_000) for number in range(1, seconds * 5)]
    said = diagnosed(log_text(frames))
    assert [(one["problem"], one["status"]) for one in said.incidents] == [("restart-loop", status)]


@pytest.mark.parametrize("boots", [2, 3, 5])
def test_a_node_that_restarts_and_is_not_heard_any_more(boots: int) -> None:
    net = running(18.0)
    begin = net.now
    for number in range(boots):
        net.now = begin + 0.5 + number * 1.5
        net.boot(SLAVE).live(SLAVE, period=PERIOD, seconds=1.4, states=((0, 0x7F),))
    said = diagnosed(log_text(net.frames()))
    assert [one["subject"]["node"] for one in said.incidents if one["status"] == "open"] == [SLAVE]


def switched_on(*, heartbeats: bool, configures: bool, deaf: int | None = None, command: int = RESET) -> Frames:
    """All are switched on together, the master not first; then it resets all, configures and starts them.

    deaf: a slave that does not obey, as the master does not.
    """
    net = Network().boot(6, MASTER, 7, 8)
    start = net.now
    beats(net, dict.fromkeys((6, 7, 8), 1.0) | ({MASTER: 12.0} if heartbeats else {}))
    net.now = start + 1.05
    net.nmt(command)
    obeying = [node for node in (6, 7, 8) if node != deaf]
    net.wait(0.3).boot(*obeying)
    for node in obeying if configures else ():
        net.write(node, 0x1017, 0, round(PERIOD * 1000), 2)
    net.wait(0.1).nmt(START)
    again = net.now + 0.01
    for node in obeying:
        net.now = again + node * 0.001
        net.live(node, period=PERIOD, seconds=12.0 - (again - start), states=((0, 5),))
    if deaf is not None:
        net.now = start + 1.1
        net.live(deaf, period=PERIOD, seconds=10.9, states=((0, 5),))
    return net.frames()


@pytest.mark.parametrize("command", [RESET, RESET_COMMUNICATION])
@pytest.mark.parametrize("configures", [True, False])
def test_a_master_that_is_switched_on_with_its_slaves(command: int, *, configures: bool) -> None:
    assert not problems(switched_on(heartbeats=True, configures=configures, command=command))


@pytest.mark.parametrize("command", [RESET, RESET_COMMUNICATION])
def test_a_node_that_only_boots_beside_configured_ones_is_a_master_or_gone(command: int) -> None:
    said = diagnosed(log_text(switched_on(heartbeats=False, configures=True, command=command)))
    roots = [(one["problem"], one["status"]) for one in said.incidents if one["status"] in ABOVE_HARMLESS]
    assert roots == [("no-boot-up", "unknown")]


def test_of_two_that_do_not_obey_one_is_no_master() -> None:
    assert ("no-boot-up", 7) in problems(switched_on(heartbeats=True, configures=False, deaf=7))


def test_a_node_that_is_gone_behind_a_reset() -> None:
    """No node is configured, so nothing shows that it is the master."""
    assert problems(switched_on(heartbeats=False, configures=False)) == [("no-boot-up", MASTER)]
