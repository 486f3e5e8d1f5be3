"""One fault is one problem, whatever follows from it.

What it must not do: test the words of a problem, or how a fault ends.
"""

from __future__ import annotations

import struct

import pytest
from captures import log_text
from diagnoses import ABOVE_HARMLESS, diagnosed
from kinds_of_nodes import NODE, PERIOD, beats, started
from network import PRE_OPERATIONAL, START, Frames, Network

OTHERS = (7, 9)
REFUSED = 0x0609_0030


def roots(frames: Frames) -> list[str]:
    """Kind of each root above harmless."""
    said = diagnosed(log_text(frames))
    return [one["problem"] for one in said.incidents if not one["cause"] and one["status"] in ABOVE_HARMLESS]


@pytest.mark.parametrize(("times", "expected"), [(1, "node-restarted"), (2, "node-restarted"), (5, "restart-loop")])
@pytest.mark.parametrize("apart", [1.0, 2.0, 4.0])
def test_restarts_of_a_node_that_starts_itself(times: int, expected: str, apart: float) -> None:
    """Its boot-ups are judged only after some time, when it has long been Operational again."""
    net = Network().live(7, period=PERIOD, seconds=24, states=((0, 5),))
    boots = [4 + apart * number for number in range(times)]
    beat = 0.0
    while beat < 24:
        net.send(0x700 + NODE, b"\x05", after=beat)
        due = [boot for boot in boots if beat < boot <= beat + PERIOD]
        if due:
            net.send(0x700 + NODE, b"\x00", after=due[0])
            beat = due[0]
        beat += PERIOD
    assert roots(net.frames()) == [expected]


def boots(*, refused: bool, running: bool) -> Frames:
    """A master reads each node, writes to one, and starts all or none of them."""
    net = Network()
    for node in (*OTHERS, NODE):
        net.boot(node)
        net.exchange(node, struct.pack("<BHBI", 0x40, 0x1000, 0, 0), struct.pack("<BHBI", 0x43, 0x1000, 0, 0x191))
    written = struct.pack("<BHBI", 0x80 if refused else 0x60, 0x1800, 2, REFUSED if refused else 0)
    net.exchange(NODE, struct.pack("<BHBI", 0x2F, 0x1800, 2, 1), written)
    if running:
        net.nmt(START, 0)
    net.sync(period=0.05, count=240)
    state = 5 if running else PRE_OPERATIONAL
    for node in (*OTHERS, NODE):
        net = beats(net, {node: 12}, ((0, state),))
    return net.frames()


def test_a_master_that_starts_none_waits_for_the_node_that_refused() -> None:
    said = diagnosed(log_text(boots(refused=True, running=False)))
    root, *follow = (one for one in said.incidents if one["status"] in ABOVE_HARMLESS)
    assert (root["problem"], root["cause"]) == ("mapping-refused", None)
    assert {one["problem"] for one in follow} == {"not-started"}
    assert all(one["cause"]["id"] == root["id"] for one in follow)


def test_nodes_that_are_not_started_for_another_reason() -> None:
    assert set(roots(boots(refused=False, running=False))) == {"not-started"}
    assert roots(boots(refused=False, running=True)) == []


@pytest.mark.parametrize("away", [2.0, 5.0])
@pytest.mark.parametrize(("state", "open_"), [(PRE_OPERATIONAL, True), (5, False)])
def test_two_nodes_of_one_segment_that_are_back(away: float, state: int, open_: bool) -> None:
    """They come back without a boot-up, after they left Operational or not, 0.1 s apart."""
    lost = (3, 4)
    net = beats(started(3, 4, 5, 6), dict.fromkeys((5, 6), 16.0) | dict.fromkeys(lost, 4.0))
    for number, node in enumerate(lost):
        net.now += 4 + away + number * 0.1
        net.live(node, period=PERIOD, seconds=12 - away, states=((0, state),))
        net.now -= 4 + away + number * 0.1
    said = diagnosed(log_text(net.frames()))
    (told,) = (one for one in said.incidents if not one["cause"] and one["status"] in ABOVE_HARMLESS)
    assert (told["problem"], told["status"]) == ("segment-lost", "open" if open_ else "ended")
    assert ("then back" if open_ else "all back at") in told["message"]
    assert ("not all Operational" in told["message"]) == open_


def twins(*, shift: float, reads: int, alone: bool = False) -> Frames:
    """A second device with the same node-ID boots after 4 s, keeps the same period and answers the same requests."""
    net = beats(started(NODE, 7), {7: 16.0, NODE: 16.0})
    begin = net.now
    if not alone:
        net.now = begin + 4
        net.boot(NODE)
        net.now = begin + 4 + shift
        net.live(NODE, period=PERIOD, seconds=12 - shift, states=((0, 5),))
    for number in range(reads):
        net.now = begin + 5.05 + number * 0.7
        request, answer = struct.pack("<BHBI", 0x40, 0x1001, 0, 0), struct.pack("<BHBI", 0x4F, 0x1001, 0, 0)
        net.exchange(NODE, request, answer)
        if not alone:
            net.send(0x580 + NODE, answer, after=0.002)
    return net.frames()


@pytest.mark.parametrize("shift", [0.02, 0.05, 0.08, 0.15])
@pytest.mark.parametrize("reads", [0, 3, 14])
def test_a_second_device_that_boots_later(shift: float, reads: int) -> None:
    assert roots(twins(shift=shift, reads=reads)) == ["duplicate-node-id"]
    assert roots(twins(shift=shift, reads=reads, alone=True)) == []


@pytest.mark.parametrize(("reads", "expected"), [(6, False), (14, True)])
def test_two_equal_responses_to_each_request(reads: int, expected: bool) -> None:
    """Both devices send no heartbeats."""
    net = beats(started(7), {7: 16.0}).boot(NODE)
    answer = struct.pack("<BHBI", 0x4F, 0x1001, 0, 0)
    begin = net.now
    for number in range(reads):
        net.now = begin + 1 + number * 0.7
        net.exchange(NODE, struct.pack("<BHBI", 0x40, 0x1001, 0, 0), answer)
        net.send(0x580 + NODE, answer, after=0.002)
    assert ("duplicate-node-id" in roots(net.frames())) == expected


@pytest.mark.parametrize("apart", [0.0005, 0.005])
def test_two_responses_to_each_guarding_request(apart: float) -> None:
    net = beats(started(7), {7: 16.0}).boot(NODE)
    begin = net.now
    for number in range(60):
        net.now = begin + 0.5 + number * 0.2
        net.send(0x700 + NODE, remote=True)
        net.send(0x700 + NODE, bytes([0x05 | number % 2 << 7]), after=0.0004)
        if number > 20:
            net.send(0x700 + NODE, bytes([0x05 | (number + 1) % 2 << 7]), after=0.0004 + apart)
    assert roots(net.frames()) == ["duplicate-node-id"]


@pytest.mark.parametrize("gap", [0.001, 0.005])
@pytest.mark.parametrize("first", [0.01, 0.1])
def test_a_flood_after_events_between_the_times_of_a_timer(gap: float, first: float) -> None:
    """What comes sooner than the event timer is no usual gap, although it comes first."""
    net = beats(started(NODE, 7), {7: 16.0, NODE: 16.0})
    at, sent = 0.1, 0
    while at < 14:
        net.send(0x180 + NODE, bytes([sent % 7, 0]), after=at)
        sent += 1
        at += gap if at > 8 else first if sent == 1 or sent % 5 == 0 else 0.1
    assert roots(net.frames()) == ["node-floods"]


@pytest.mark.parametrize("later", [3.0, 6.0])
def test_an_error_of_a_consumer_after_a_reset_and_after_a_loss(later: float) -> None:
    """What a consumer reports because of a reset command, and takes back, has nothing to do with a later loss."""
    consumer = 9
    net = beats(started(NODE, 7, consumer), {7: 16.0, consumer: 16.0, NODE: 1.0})
    begin = net.now
    net.now = begin + 1
    net.nmt(0x82, NODE).wait(0.5).emcy(consumer, 0x8130, 0x11)
    net.wait(0.1).boot(NODE).write(NODE, 0x1017, 0, round(PERIOD * 1000), 2).nmt(START, NODE)
    net = beats(net, {NODE: later}).wait(0.1).emcy(consumer, 0, 0)
    net.wait(later + 0.5).emcy(consumer, 0x8130, 0x11)
    said = diagnosed(log_text(net.frames()))
    (root,) = (one for one in said.incidents if not one["cause"] and one["status"] in ABOVE_HARMLESS)
    assert (root["problem"], root["subject"]["node"]) == ("node-silent", NODE)
    assert "heartbeat-consumer-error" in [one["problem"] for one in said.incidents if one["cause"]]


def test_a_node_that_leaves_operational_stops_its_pdos() -> None:
    """A consumer that has lost its controller leaves Operational. Its TPDO has an event timer that nobody names."""
    controller = 9
    net = beats(started(NODE, 7), {7: 16.0}).boot(controller)
    net = beats(net, {controller: 5.0})
    begin = net.now
    beats(net, {NODE: 16.0}, ((0.0, 5), (5.7, PRE_OPERATIONAL)))
    net.now = begin
    net.cyclic(0x180 + NODE, period=0.1, payloads=[bytes([number // 4, 0]) for number in range(56)])
    net.now = begin + 5.6
    net.emcy(NODE, 0x8130, 0x11)
    assert roots(net.frames()) == ["node-silent"]


@pytest.mark.parametrize("spread", [0.0, 0.003, 0.3])
def test_nodes_that_restart_at_the_same_time(spread: float) -> None:
    """A supply that breaks down for a moment: all boot again by themselves, while others of another supply go on."""
    nodes = (3, 4, 5)
    net = beats(started(*nodes, 7, 8), dict.fromkeys(nodes, 4.0) | {7: 16.0, 8: 16.0})
    begin = net.now
    for number, node in enumerate(nodes):
        net.now = begin + 4.1 + number * spread
        net.boot(node).write(node, 0x1017, 0, round(PERIOD * 1000), 2).nmt(START, node)
        beats(net, {node: 11.8 - number * spread})
    said = diagnosed(log_text(net.frames()))
    (told,) = (one for one in said.incidents if not one["cause"] and one["status"] in ABOVE_HARMLESS)
    assert (told["problem"], told["status"]) == ("node-restarted", "ended")
    assert set(told["subject"]["nodes"]) == set(nodes)


@pytest.mark.parametrize("names", [NODE, 0])
def test_a_report_that_names_the_lost_node(names: int) -> None:
    """A consumer of which another entry of 1016h is known reports the loss of a node, perhaps by its number."""
    consumer = 9
    net = started(NODE, 7, consumer).write(consumer, 0x1016, 1, 7 << 16 | 500, 4)
    net = beats(net, {7: 12.0, consumer: 12.0, NODE: 4.0})
    net.wait(4.4).emcy(consumer, 0x8130, 0x11, bytes([0, names, 0, 0, 0]))
    told = roots(net.frames())
    assert told == (["node-silent"] if names else ["node-silent", "heartbeat-consumer-error"])


def test_the_last_report_of_a_node_is_no_consequence_of_its_silence() -> None:
    net = beats(started(NODE, 7, 8), {7: 12.0, 8: 3.0, NODE: 4.0})
    net.wait(4.05).emcy(NODE, 0x8130, 0x11, bytes([0, 8, 0, 0, 0]))
    said = diagnosed(log_text(net.frames()))
    causes = {one["id"]: one["subject"].get("node") for one in said.incidents}
    (report,) = (one for one in said.incidents if one["problem"] == "heartbeat-consumer-error")
    assert causes[report["cause"]["id"]] == 8


def test_a_violation_and_the_abort_it_gets() -> None:
    net = beats(started(NODE, 7), {7: 8.0, NODE: 8.0}).wait(2)
    net.exchange(NODE, struct.pack("<BHBI", 0x21, 0x2100, 1, 21), struct.pack("<BHBI", 0x60, 0x2100, 1, 0))
    net.exchange(NODE, b"\x00" + bytes(7), b"\x20")
    net.exchange(NODE, b"\x00" + bytes(7), struct.pack("<BHBI", 0x80, 0x2100, 1, 0x0503_0000))
    assert roots(net.frames()) == ["damaged-transfer"]


def test_a_pdo_that_is_too_short_and_the_report_of_its_receiver() -> None:
    net = Network().boot(NODE).write(NODE, 0x1017, 0, round(PERIOD * 1000), 2)
    net.set_pdo(NODE, 1, [(0x6200, 1, 8), (0x6200, 2, 8)], transmit=False).nmt(START, NODE)
    net = beats(net, {NODE: 6.0})
    net.wait(1).cyclic(0x200 + NODE, period=0.1, payloads=[b"\x01"] * 20)
    net.emcy(NODE, 0x8210, 0x11)
    assert roots(net.frames()) == ["pdo-length"]


@pytest.mark.parametrize("kind", ["node-restarted", "left-operational"])
def test_rpdos_that_stop_with_their_node_are_no_problem(kind: str) -> None:
    """The controller of a network with SYNC sends none to a node that is not Operational."""
    net = beats(started(NODE, 7), {7: 12.0})
    begin = net.now
    if kind == "node-restarted":
        beats(net, {NODE: 4.0}).wait(4.05).boot(NODE)
    net.now = begin
    beats(net, {NODE: 12.0}, ((0, 5), (4.1, PRE_OPERATIONAL)))
    net.now = begin
    net.sync(period=0.01, count=1190)
    for number in range(410):
        net.send(0x200 + NODE, bytes([number % 200, 1]), after=number * 0.01 + 0.001)
    assert roots(net.frames()) == [kind]


def guarded(lost: tuple[int, ...], *, since: float, until: float) -> Frames:
    """A master guards three nodes every 0.4 s; some do not answer for a time."""
    net = Network().boot(3, 4, 5).nmt(START, 0)
    begin = net.now
    for cycle in range(40):
        for number, node in enumerate((3, 4, 5)):
            net.now = begin + cycle * 0.4 + number * 0.13
            out = node in lost and since <= net.now - begin < until
            net.send(0x700 + node, remote=True)
            if not out:
                net.send(0x700 + node, bytes([5 | cycle % 2 << 7]), after=0.001)
    return net.frames()


@pytest.mark.parametrize("lost", [(3,), (3, 4), (4, 5), (3, 4, 5)])
@pytest.mark.parametrize("until", [8.0, 99.0])
def test_guarded_nodes_of_one_segment_are_one_problem(lost: tuple[int, ...], until: float) -> None:
    assert roots(guarded(lost, since=4.0, until=until)) == ["guarding-unanswered"]


def test_guarded_nodes_that_are_lost_at_different_times_are_two() -> None:
    first, second = (guarded((node,), since=since, until=99) for node, since in ((3, 4.0), (5, 9.0)))
    assert roots([one for one in first if one in second]) == ["guarding-unanswered"] * 2


@pytest.mark.parametrize("out", [0.5, 1.0])
@pytest.mark.parametrize("pdo", [0.02, 0.1])
def test_a_node_that_sends_nothing_for_a_moment(out: float, pdo: float) -> None:
    """Its heartbeats and its PDOs of an event timer are missing in the same time."""
    net = started(NODE, OTHERS[0]).write(NODE, 0x1800, 5, round(pdo * 1000), 2)
    begin, gone = net.now, range(round(6.05 * 1000), round((6.05 + out) * 1000))
    for at in range(0, 12_000, round(pdo * 1000)):
        if at not in gone:
            net.send(0x180 + NODE, bytes([at // 100 % 250, 1]), after=at / 1000)
    for node in (NODE, OTHERS[0]):
        for at in range(0, 12_000, round(PERIOD * 1000)):
            if node != NODE or at not in gone:
                net.now = begin
                net.send(0x700 + node, b"\x05", after=at / 1000 + 0.0005 * node)
    assert len(roots(net.frames())) == 1


def test_a_node_that_restarts_and_is_silent_in_turn() -> None:
    """Each time it is back with a boot-up: one problem, whichever was seen first."""
    net = Network().live(7, period=PERIOD, seconds=24, states=((0, 5),)).nmt(START, 0)
    beat = 0.0
    for off in (0.1, 0.1, 1.5, 1.5):
        for _ in range(20):
            net.send(0x700 + NODE, b"\x05", after=beat)
            beat += PERIOD
        beat += off
        net.send(0x700 + NODE, b"\x00", after=beat)
        beat += PERIOD
    for _ in range(20):
        net.send(0x700 + NODE, b"\x05", after=beat)
        beat += PERIOD
    (one,) = diagnosed(log_text(net.frames())).incidents
    assert (one["problem"], one["repeats"]["count"]) == ("restart-loop", 4)


def test_a_late_heartbeat_behind_a_restart_belongs_to_it() -> None:
    net = Network().live(7, period=PERIOD, seconds=12, states=((0, 5),))
    beats_at = [at * PERIOD for at in range(20)] + [4 + 1.9 * PERIOD + at * PERIOD for at in range(38)]
    for at in beats_at:
        net.send(0x700 + NODE, b"\x05", after=at)
    net.send(0x700 + NODE, b"\x00", after=4.0)
    assert roots(net.frames()) == ["node-restarted"]


@pytest.mark.parametrize(("identifier", "expected"), [(0x010, ["node-floods"]), (0x7E0, [])])
def test_an_identifier_that_was_never_seen_fills_the_bus(identifier: int, expected: list[str]) -> None:
    """All other nodes are silent meanwhile and are back; or they go on beside one of lower priority."""
    net = beats(started(NODE, *OTHERS), dict.fromkeys((NODE, *OTHERS), 6.0)).wait(6)
    for _ in range(3000):
        net.send(identifier, bytes(8)).wait(0.001)
    if not expected:
        net.now -= 3
    net = beats(net, dict.fromkeys((NODE, *OTHERS), 6.0))
    assert roots(net.frames()) == expected
