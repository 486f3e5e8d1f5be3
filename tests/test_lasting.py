"""Lasting faults are open until a frame shows their end, over all magnitudes.

What it must not do: test the words of a problem.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Callable
from dataclasses import replace

import pytest
from captures import log_text, session_output
from diagnoses import ABOVE_HARMLESS, diagnosed
from kinds_of_drives import CYCLIC_POSITION, DISABLED, ENABLED, ON, POSITION, READY, cycles, drive, enabled
from kinds_of_nodes import NODE, PERIOD, beats, started
from network import PRE_OPERATIONAL, START, Follower, Frames, Network

Problem = tuple[str, str]
OTHER = 6
LONG = 12.0


def problems(frames: Frames) -> list[Problem]:
    """Kind and status of each root above harmless."""
    said = diagnosed(log_text(frames))
    roots = [one for one in said.incidents if not one["cause"] and one["status"] in ABOVE_HARMLESS]
    return [(one["problem"], one["status"]) for one in roots]


def two_nodes(seconds: float = LONG) -> Network:
    return beats(started(NODE, OTHER), {OTHER: seconds})


def slower(factor: float, until: float = 30, since: float = 4) -> Frames:
    """Heartbeats that come more slowly from a time on, 4 s, and as before from `until` on."""
    net = two_nodes(20)
    at = 0.0
    while at < 20:
        net.send(0x700 + NODE, b"\x05", after=at)
        at += PERIOD * (factor if since <= at < until else 1)
    return net.frames()


@pytest.mark.parametrize("factor", [1.5, 2, 3, 4, 6, 8])
def test_slower_heartbeats_are_open(factor: float) -> None:
    assert problems(slower(factor)) == [("heartbeat-irregular", "open")]


@pytest.mark.parametrize("since", [6, 12, 16, 17])
def test_slower_heartbeats_are_open_wherever_they_begin(since: float) -> None:
    assert problems(slower(3, since=since)) == [("heartbeat-irregular", "open")]


@pytest.mark.parametrize("period", [0.1, 0.5, 1.0, 1.5])
def test_a_heartbeat_that_stops_is_open_though_other_frames_come(period: float) -> None:
    net = beats(two_nodes(), {NODE: 5})
    count = round(LONG / period)
    net.cyclic(0x180 + NODE, period=period, payloads=[bytes([at % 256, 0]) for at in range(count)])
    assert problems(net.frames()) == [("heartbeat-stopped", "open")]


@pytest.mark.parametrize("shift", [0.06, 0.14])
def test_a_second_heartbeat_stream_is_another_device(shift: float) -> None:
    net = beats(two_nodes(), {NODE: LONG})
    net.wait(shift).live(NODE, period=PERIOD, seconds=LONG - shift, states=((0, 5),))
    assert problems(net.frames()) == [("duplicate-node-id", "open")]


@pytest.mark.parametrize("uneven", [0.005, 0.02])
def test_an_uneven_task_is_no_other_device(uneven: float) -> None:
    """Gaps that alternate, of a node whose period is not configured."""
    net = beats(started(OTHER), {OTHER: LONG}).boot(NODE)
    for beat in range(115):
        net.send(0x700 + NODE, b"\x05", after=0.5 + beat * 0.1 + (uneven if beat % 2 else 0))
    assert problems(net.frames()) == []


def sync(factor: float, until: float = 30) -> Frames:
    """SYNC with another period from 4 s on, and as before from `until` on."""
    net = beats(two_nodes(), {NODE: LONG})
    at = 0.0
    while at < LONG:
        net.send(0x080, after=at)
        at += 0.01 * (factor if 4 <= at < until else 1)
    return net.frames()


@pytest.mark.parametrize("factor", [1.5, 2, 3])
@pytest.mark.parametrize(("until", "status"), [(30, "open"), (7, "ended")])
def test_a_period_of_sync_that_stays_changed_is_open(factor: float, until: float, status: str) -> None:
    assert problems(sync(factor, until)) == [("sync-irregular", status)]


@pytest.mark.parametrize("lasts", [0.3, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("back", [True, False])
def test_a_gap_of_a_synchronous_pdo_is_a_problem(lasts: float, *, back: bool) -> None:
    net = beats(two_nodes(), {NODE: LONG})
    first = 500 if back else 1200 - round(lasts / 0.01)
    missing = range(first, first + round(lasts / 0.01))
    for cycle in range(1200):
        net.send(0x080, after=cycle * 0.01)
        if cycle not in missing:
            net.send(0x180 + NODE, b"\x37\x02", after=cycle * 0.01 + 0.0005)
    assert problems(net.frames()) == [("pdo-missing", "ended" if back else "open")]


def answers(first: bytes, second: bytes, asked: int = 0x600 + NODE) -> Frames:
    """Reads of the serial number, each answered twice."""
    net = Network().boot(NODE)
    for _ in range(3):
        net.wait(0.5).send(asked, struct.pack("<BHBI", 0x40, 0x1018, 4, 0))
        net.send(0x580 + NODE, struct.pack("<BHB", 0x43, 0x1018, 4) + first, after=0.001)
        net.send(0x580 + NODE, struct.pack("<BHB", 0x43, 0x1018, 4) + second, after=0.0013)
    return beats(net, {NODE: 2}, ((0, PRE_OPERATIONAL),)).frames()


def test_two_identities_are_two_devices() -> None:
    assert problems(answers(b"\1\2\3\4", b"\1\2\3\5")) == [("duplicate-node-id", "open")]


@pytest.mark.parametrize("times", [1, 2, 3])
def test_responses_of_another_server_are_told_from_the_second_one_on(times: int) -> None:
    net = beats(Network().boot(NODE), {NODE: 8}, ((0, PRE_OPERATIONAL),))
    for _ in range(times):
        net.wait(1).send(0x600 + NODE, struct.pack("<BHBI", 0x40, 0x1018, 1, 0))
        net.send(0x583, struct.pack("<BHBI", 0x43, 0x1018, 1, 0x5A), after=0.001)
    kinds = [kind for kind, _ in problems(net.frames())]
    assert ("answer-on-another-id" in kinds) == (times > 1)
    assert times == 1 or kinds == ["answer-on-another-id"]


def guarded(answered: int) -> Frames:
    """Guarding requests each 200 ms, the first ones answered, and a PDO each second."""
    net = Network().boot(NODE)
    for at in range(40):
        net.wait(0.2).send(0x700 + NODE, remote=True)
        if at < answered:
            net.send(0x700 + NODE, bytes([0x05 | at % 2 * 0x80]), after=0.001)
        if at % 5 == 0:
            net.send(0x180 + NODE, bytes([at, 0]), after=0.05)
    return net.frames()


def test_a_pdo_is_no_answer_to_guarding() -> None:
    assert problems(guarded(20)) == [("guarding-unanswered", "open")]
    assert problems(guarded(40)) == []


@pytest.mark.parametrize(("count", "expected"), [(40, []), (120, [("commands-not-taken", "unknown")])])
def test_commands_to_a_node_that_is_never_started(count: int, expected: list[Problem]) -> None:
    net = beats(Network().boot(NODE), {NODE: 4}, ((0, PRE_OPERATIONAL),)).wait(0.5)
    net.cyclic(0x200 + NODE, period=0.5 if count > 100 else 0.02, payloads=[b"\x0f\0"] * (count // 20))
    assert problems(net.frames()) == expected


@pytest.mark.parametrize("lasting", [5.0, 1.0, 0.2])
def test_a_steady_pdo_that_is_not_sent_any_more(lasting: float) -> None:
    net = beats(two_nodes(), {NODE: LONG})
    count = round((LONG - 0.5 - lasting) / 0.05)
    net.cyclic(0x180 + NODE, period=0.05, payloads=[bytes([at // 4 % 256, 0]) for at in range(count)])
    assert problems(net.frames()) == ([("pdo-missing", "open")] if lasting > 0.5 else [])


def test_a_frame_has_its_own_line_first_behind_a_step_of_the_clock() -> None:
    """What became due before the step stands below the frame that shows it."""
    stamps = [10.476893, 10.578493, 10.682093, 10.789493, 10.891193, 10.942193, 10.997293]
    lines = [f"({2305843000 + at:.6f}) can0 080#" for at in stamps] + ["(2.220000) can0 104#02"]
    data = "\n".join(lines).encode() + b"\n"
    text = session_output([data], name="a.log", output_format="text", lang="en").decode()
    assert sum(not line.startswith("#") for line in text.splitlines()) == len(lines)


ENDS: list[Callable[[], Frames]] = [lambda: slower(3, until=12), lambda: sync(2, until=7)]


@pytest.mark.parametrize("make", ENDS)
def test_what_has_ended_is_not_open(make: Callable[[], Frames]) -> None:
    assert [status for _, status in problems(make())] == ["ended"]


def test_the_followers_are_known() -> None:
    """A neighbour without any fault: the same network with a synchronous PDO in each cycle."""
    net = beats(two_nodes(), {NODE: LONG})
    net.sync(period=0.01, count=1200, followers=[Follower(0x180 + NODE, lambda cycle: bytes([cycle % 256, 0]))])
    assert problems(net.frames()) == []


@pytest.mark.parametrize("odd", [1, 100])
def test_a_length_that_returns_has_ended(odd: int) -> None:
    net = beats(two_nodes(), {NODE: LONG})
    for at in range(230):
        net.send(0x180 + NODE, bytes(6 if at < 100 or at >= 100 + odd else 4), after=at * 0.05)
    assert problems(net.frames()) in ([("pdo-length", "ended")], [])


@pytest.mark.parametrize("index", [0x1800, 0x1A00])
def test_a_pdo_may_stop_after_its_configuration_changed(index: int) -> None:
    net = beats(two_nodes(), {NODE: LONG})
    net.cyclic(0x180 + NODE, period=0.05, payloads=[bytes([at // 4 % 256, 0]) for at in range(120)]).wait(6)
    net.write(NODE, index, *((1, 0x8000_0185, 4) if index == 0x1800 else (0, 0, 1)))
    assert problems(net.frames()) == []


@pytest.mark.parametrize("factor", [2, 6, 10])
def test_faster_heartbeats_are_no_second_device(factor: int) -> None:
    net = beats(started(OTHER), {OTHER: 20}).boot(NODE)
    at = 0.5
    while at < 20:
        net.send(0x700 + NODE, b"\x05", after=at)
        at += 1.0 if at < 10 else 1.0 / factor
    assert "duplicate-node-id" not in [kind for kind, _ in problems(net.frames())]


@pytest.mark.parametrize("jitter", [0.001, 0.002])
@pytest.mark.parametrize("seed", range(4))
def test_jitter_is_no_change_of_the_period_of_sync(jitter: float, seed: int) -> None:
    chance = random.Random(seed)
    net = beats(two_nodes(), {NODE: LONG})
    for cycle in range(round(LONG / 0.02)):
        net.send(0x080, after=cycle * 0.02 + chance.uniform(0, jitter))
    assert problems(net.frames()) == []


@pytest.mark.parametrize("again", ["", "read", "other", "same"])
def test_a_download_that_failed_is_open_until_its_object_is_written(again: str) -> None:
    """A segmented download stops without a response and is aborted by its client."""
    net = beats(two_nodes(), {NODE: LONG}).wait(2)
    net.exchange(NODE, struct.pack("<BHBI", 0x21, 0x2100, 1, 10), struct.pack("<BHBI", 0x60, 0x2100, 1, 0))
    net.wait(0.01).send(0x600 + NODE, b"\x00" + bytes(range(7)))
    net.wait(1.0).send(0x600 + NODE, struct.pack("<BHBI", 0x80, 0x2100, 1, 0x0504_0000)).wait(1)
    if again == "read":
        net.read(NODE, 0x1018, 1, 0x5A, 4)
    elif again:
        net.write(NODE, 0x2100, 1 if again == "same" else 2, 7, 4)
    (problem,) = problems(net.frames())
    assert problem == ("request-unanswered", "ended" if again == "same" else "open")


@pytest.mark.parametrize("then", [0x0F, 0x06, 0x00])
@pytest.mark.parametrize("back", [False, True])
def test_a_drive_that_dropped_out_is_out_until_it_is_enabled_again(then: int, back: bool) -> None:
    """The controller holds its command, or takes it back once it sees that."""
    net = cycles(enabled(POSITION), 15, ENABLED, POSITION, count=20)
    cycles(net, 15, DISABLED, POSITION, count=3)
    cycles(net, then, DISABLED, POSITION, count=20)
    if back:
        for controlword, statusword in ((6, READY), (7, ON), (15, ENABLED)):
            cycles(net, controlword, statusword, POSITION, count=4)
    assert problems(net.frames()) == [("state-left", "ended" if back else "open")]


@pytest.mark.parametrize(("seconds", "expected"), [(3, []), (8, [("not-enabled", "open")])])
def test_a_drive_that_is_told_enable_operation_at_once(seconds: int, expected: list[Problem]) -> None:
    """With voltage, but without the steps before: it stays disabled."""
    assert problems(cycles(drive(), 15, DISABLED, POSITION, count=seconds * 10).frames()) == expected


@pytest.mark.parametrize("late", [0.03, 0.05, 0.2, 0.9])
def test_targets_that_the_recorder_held_back(late: float) -> None:
    """All frames of a time come at once behind it: no target is late, then or later."""
    net = enabled(CYCLIC_POSITION)
    begin = net.now
    for place in range(600):
        net.send(0x305, struct.pack("<i", place), after=place * 0.004)
    cycles(net, 15, ENABLED, CYCLIC_POSITION, count=24)
    stalled = round((1_700_000_000 + begin + 1.0) * 1_000_000)
    ends = stalled + round(late * 1_000_000)
    frames = [
        replace(frame, t_us=ends + (frame.t_us - stalled) // 100) if stalled <= frame.t_us < ends else frame
        for frame in net.frames()
    ]
    assert problems(frames) == []


@pytest.mark.parametrize(("timer", "expected"), [(None, ["pdo-missing"]), (50, ["pdo-missing"]), (0, [])])
@pytest.mark.parametrize("kind", [254, 255])
def test_an_event_timer_that_is_not_named_beside_a_transmission_type_that_is(
    kind: int, timer: int | None, expected: list[str]
) -> None:
    """A TPDO that is known to be event-driven stops; an event timer of 0 says that nothing but changes send it."""
    net = Network().boot(NODE, OTHER).write(NODE, 0x1017, 0, round(PERIOD * 1000), 2)
    net.write(OTHER, 0x1017, 0, round(PERIOD * 1000), 2).write(NODE, 0x1800, 2, kind, 1)
    if timer is not None:
        net.write(NODE, 0x1800, 5, timer, 2)
    net = beats(net.nmt(START), {NODE: LONG, OTHER: LONG})
    net.cyclic(0x180 + NODE, period=0.05, payloads=[bytes([at // 4 % 256, 0]) for at in range(120)])
    assert [found for found, _ in problems(net.frames())] == expected


@pytest.mark.parametrize(
    ("late", "expected"), [(0, []), (0.5, []), (1, ["heartbeat-irregular"]), (2, ["heartbeat-irregular"])]
)
def test_a_heartbeat_that_never_came_is_a_problem_and_a_late_one_is_none(late: float, expected: list[str]) -> None:
    """One gap that is longer by a part of the period, or by one or two whole ones."""
    net = two_nodes()
    at = 0.0
    for beat in range(58):
        net.send(0x700 + NODE, b"\x05", after=at)
        at += PERIOD * (1 + late if beat == 20 else 1)
    assert problems(net.frames()) == [(kind, "ended") for kind in expected]


@pytest.mark.parametrize(("missing", "expected"), [(0, []), (1, ["sync-irregular"]), (3, ["sync-irregular"])])
def test_a_sync_that_never_came_is_a_problem(missing: int, expected: list[str]) -> None:
    net = beats(two_nodes(), {NODE: LONG})
    for cycle in range(600):
        if not 300 <= cycle < 300 + missing:
            net.send(0x080, b"", after=cycle * 0.02)
            net.send(0x186, b"\x01\x00", after=cycle * 0.02 + 0.001)
    assert problems(net.frames()) == [(kind, "ended") for kind in expected]


@pytest.mark.parametrize(("until", "expected"), [(12.0, "open"), (8.0, "ended")])
def test_an_undefined_state_lasts_until_a_defined_one(until: float, expected: str) -> None:
    net = beats(two_nodes(), {NODE: 5})
    for beat in range(35):
        at = 5 + beat * PERIOD
        net.send(0x700 + NODE, b"\x03" if at < until else b"\x05", after=at)
    assert [status for kind, status in problems(net.frames()) if kind == "wire-error"] == [expected]


@pytest.mark.parametrize(("until", "expected"), [(12.0, "open"), (8.0, "ended")])
def test_sync_without_its_counter_lasts_until_it_is_back(until: float, expected: str) -> None:
    net = beats(two_nodes().write(OTHER, 0x1019, 0, 10, 1), {NODE: LONG})
    for cycle in range(220):
        at = cycle * 0.05
        net.send(0x080, b"" if 5 <= at < until else bytes([cycle % 10 + 1]), after=at)
    assert [status for kind, status in problems(net.frames()) if kind == "sync-length"] == [expected]


@pytest.mark.parametrize(("register", "expected"), [(0x00, "ended"), (0x01, "ended"), (0x09, "open"), (0x0D, "open")])
def test_an_error_lasts_until_the_error_register_does_not_show_it(register: int, expected: str) -> None:
    """EMCY 4210h with bits 0 and 3; then 1001h is read."""
    net = beats(two_nodes(3), {NODE: 3}).wait(3).send(0x080 + NODE, bytes.fromhex("1042090000000000")).wait(0.5)
    net.read(NODE, 0x1001, 0, register, 1)
    net = beats(net, {NODE: 6, OTHER: 6})
    assert problems(net.frames()) == [("temperature", expected)]


def test_a_device_with_the_generic_bit_alone_keeps_its_error() -> None:
    net = beats(two_nodes(3), {NODE: 3}).wait(3).send(0x080 + NODE, bytes.fromhex("1042010000000000")).wait(0.5)
    net.read(NODE, 0x1001, 0, 0x01, 1)
    assert problems(beats(net, {NODE: 6, OTHER: 6}).frames()) == [("temperature", "open")]


@pytest.mark.parametrize("register", [0x01, 0x11, 0x81])
def test_an_error_register_that_contradicts_the_end_of_an_error(register: int) -> None:
    def read(value: int) -> Frames:
        net = beats(two_nodes(3), {NODE: 3}).wait(3).send(0x080 + NODE, bytes.fromhex("1042090000000000")).wait(0.1)
        net.send(0x080 + NODE, bytes(8)).wait(0.1).read(NODE, 0x1001, 0, value, 1)
        return beats(net, {NODE: 6, OTHER: 6}).frames()

    assert problems(read(0)) == [("temperature", "ended")]
    assert problems(read(register)) == [("register-without-emcy", "open"), ("temperature", "ended")]


@pytest.mark.parametrize(("count", "valid", "expected"), [(60, None, "open"), (60, 30, "ended"), (5, None, None)])
def test_frames_to_a_disabled_rpdo(count: int, valid: int | None, expected: str | None) -> None:
    """The COB-ID of RPDO1 keeps bit 31 while its controller sends; it is mended behind a number of frames, or not."""
    net = beats(started(NODE, OTHER).write(NODE, 0x1400, 1, 0x8000_0205, 4), {NODE: 8, OTHER: 8})
    for frame in range(count):
        if frame == valid:
            net.write(NODE, 0x1400, 1, 0x205, 4)
        net.send(0x205, bytes([frame, 0])).wait(0.05)
    assert [status for kind, status in problems(net.frames()) if kind == "frames-not-taken"] == (
        [expected] if expected else []
    )


@pytest.mark.parametrize("used", [True, False])
def test_a_tpdo_that_is_moved_onto_the_identifier_of_another_node(used: bool) -> None:
    """The other sends on its identifier of the pre-defined connection set, or it does not."""
    net = started(NODE, OTHER).write(NODE, 0x1800, 1, 0x185, 4)
    for frame in range(80):
        if frame == 40:
            net.write(NODE, 0x1800, 1, 0x8000_0185, 4).write(NODE, 0x1800, 1, 0x186, 4)
        net.send(0x185 if frame < 40 else 0x186, bytes([frame, 0])).wait(0.05)
        if used:
            net.send(0x186, bytes([frame // 8, 7])).wait(0.05)
    net = beats(net, {NODE: 2, OTHER: 2})
    assert ("shared-cob-id" in [kind for kind, _ in problems(net.frames())]) == used


def test_a_tpdo_that_is_moved_to_and_fro_shares_no_identifier() -> None:
    """The other identifier is free each time, although it is that of a node by the pre-defined connection set."""
    net = started(NODE, OTHER).write(NODE, 0x1800, 1, 0x185, 4)
    for frame in range(160):
        identifier = 0x185 if frame // 40 % 2 == 0 else 0x186
        if frame % 40 == 0:
            net.write(NODE, 0x1800, 1, 0x8000_0000 | identifier, 4).write(NODE, 0x1800, 1, identifier, 4)
        net.send(identifier, bytes([frame, 0])).wait(0.05)
    assert "shared-cob-id" not in [kind for kind, _ in problems(beats(net, {NODE: 2, OTHER: 2}).frames())]


@pytest.mark.parametrize("factor", [1.5, 3, 6])
def test_heartbeats_that_stay_slower_do_not_follow_from_an_error(factor: float) -> None:
    """An error is reported in the first gap that is longer."""
    net = Network(start=1_700_000_000.0)
    emergency = net.wait(4.6).send(0x080 + NODE, bytes.fromhex("0010010000000000")).frames()
    frames = sorted([*slower(factor), *emergency], key=lambda frame: frame.t_us)
    assert ("heartbeat-irregular", "open") in problems(frames)


def asked(answers: list[bool], *, late: bool = False) -> Frames:
    """Reads of 2200h:01 each second, answered or not, or after the client gave up; others are answered between them."""
    net = beats(two_nodes(3 + len(answers) + 6), {NODE: 3 + len(answers) + 6}).wait(3)
    for answered in answers:
        begin = net.now
        if answered:
            net.read(NODE, 0x2200, 1, 7, 4)
        else:
            net.send(0x600 + NODE, bytes.fromhex("4000220100000000"))
            net.send(0x600 + NODE, bytes.fromhex("8000220100000405"), after=0.1)
            if late:
                net.send(0x580 + NODE, bytes.fromhex("4300220107000000"), after=0.15)
        net.wait(0.5).read(NODE, 0x1000, 0, 0x000F_0191, 4)
        net.now = begin + 1
    return net.wait(5).frames()


@pytest.mark.parametrize("late", [True, False])
def test_requests_in_vain_go_on_until_one_is_served(*, late: bool) -> None:
    def statuses(answers: list[bool]) -> set[str]:
        return {status for _, status in problems(asked(answers, late=late))}

    for times in (3, 4, 8):
        assert statuses([False] * times) == {"open"}
        assert statuses([*[False] * times, True]) == {"ended"}
    assert statuses([False]) == {"ended"}
    assert statuses([True] * 4) == set()
