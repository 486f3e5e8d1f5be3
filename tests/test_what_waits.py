"""Nodes that are there and do not run, and what a capture lacks: no frame says so.

Each fault has several magnitudes, and stands beside captures that look alike and are well.
"""

from __future__ import annotations

import pytest
from diagnoses import Diagnosed, diagnosed
from test_neighbouring_verdicts import Frames, beats, found, log, node, statuses


def pdos(number: int, until: float, start: float = 0.0, period: float = 0.05) -> Frames:
    """TPDO1 of a node with a counter."""
    count = round((until - start) / period)
    return [(start + place * period + 0.003, f"{0x180 + number:03X}#{place % 251:02X}00") for place in range(count)]


def running(number: int, until: float, start: float = 0.0) -> Frames:
    """A node that is Operational and sends a TPDO."""
    return [*beats(number, 0.1, until, start=start), *pdos(number, until, start)]


def kinds(capture: Diagnosed) -> list[str]:
    return [kind for kind, _ in statuses(capture)]


def started(stays: str, lasts: float, *before: tuple[float, str]) -> Diagnosed:
    """All nodes are started after half a second; node 3 goes on in a state."""
    nodes = [beats(number, 0.1, 0.45, "7F") + running(number, lasts, 0.55) for number in (1, 2)]
    return diagnosed(log(*nodes, list(before), beats(3, 0.1, 0.45, "7F"), beats(3, 0.1, lasts, stays, 0.55)))


@pytest.mark.parametrize("lasts", [6.0, 12.0, 60.0])
def test_a_node_that_does_not_follow_a_start_of_all_is_no_tick(lasts: float) -> None:
    capture = started("7F", lasts, (0.5, "000#0100"))
    assert statuses(capture) == [("not-running", "unknown")], capture.said
    assert node(capture.roots[0]) == 3


@pytest.mark.parametrize("lasts", [1.5, 4.0])
def test_it_may_still_be_about_to_start(lasts: float) -> None:
    assert not started("7F", lasts, (0.5, "000#0100")).roots


@pytest.mark.parametrize("command", ["80", "02"])
@pytest.mark.parametrize("target", ["00", "03"])
def test_a_state_by_command_is_intended(command: str, target: str) -> None:
    state = "7F" if command == "80" else "04"
    then = [(0.6, f"000#{command}{target}")]
    if target == "00":
        then.extend([(0.65, "000#0101"), (0.66, "000#0102")])
    capture = started(state, 12, (0.5, "000#0100"), *then)
    assert "not-running" not in kinds(capture), capture.said


@pytest.mark.parametrize("state", ["04", "7F"])
@pytest.mark.parametrize("others", [1, 3])
def test_an_excerpt_with_a_node_that_does_not_run(state: str, others: int) -> None:
    nodes = [running(number, 8) for number in range(10, 10 + others)]
    capture = diagnosed(log(*nodes, beats(3, 0.1, 8, state)))
    assert statuses(capture) == [("not-running", "unknown")], capture.said
    assert not diagnosed(log(*(beats(number, 0.1, 8, state) for number in (3, 10)))).roots


def test_a_node_that_is_written_to_need_not_run() -> None:
    write = [(1 + place / 2, f"603#2F00200{place % 9}01000000") for place in range(20)]
    answer = [(at + 0.001, f"583#6000200{place % 9}00000000") for place, (at, _) in enumerate(write)]
    capture = diagnosed(log(running(1, 12), running(2, 12), beats(3, 0.1, 12, "7F"), write, answer))
    assert not capture.roots, capture.said


@pytest.mark.parametrize("booted", [1.0, 5.0])
def test_a_node_that_boots_and_is_not_started_beside_others(booted: float) -> None:
    start = [(0.5, "000#0101"), (0.51, "000#0102"), (booted, "703#00")]
    nodes = [beats(number, 0.1, 0.45, "7F") + running(number, booted + 8, 0.55) for number in (1, 2)]
    capture = diagnosed(log(*nodes, start, beats(3, 0.1, booted + 8, "7F", booted + 0.1)))
    assert statuses(capture) == [("not-running", "open")], capture.said
    later = [(booted + 2, "000#0103")]
    beat = beats(3, 0.1, booted + 1.95, "7F", booted + 0.1) + beats(3, 0.1, booted + 8, "05", booted + 2.05)
    assert not diagnosed(log(*nodes, start, later, beat)).roots


def switched_off(silence: float, then: float, starts: bool, command: bool = False, recorded: bool = True) -> Diagnosed:
    """Nodes lose their power together and boot again. recorded: so are NMT commands."""
    parts: list[Frames] = [[(0.5, "000#0100")]]
    back = 3 + silence
    for number in (1, 2, 3):
        parts += [beats(number, 0.1, 0.45, "7F"), running(number, 3, 0.55), [(back + number / 100, f"70{number}#00")]]
        state = "05" if starts else "7F"
        parts += [beats(number, 0.1, back + 0.9, "7F", back + 0.1), beats(number, 0.1, back + then, state, back + 1.1)]
        if starts:
            parts.append(pdos(number, back + then, back + 1.1))
    if starts:
        parts.append([(back + 1, "000#0100")])
    if command:
        parts.append([(back - 0.05, "000#8100")])
    if not recorded:
        parts = [[frame for frame in part if not frame[1].startswith("000#")] for part in parts]
    return diagnosed(log(*parts))


@pytest.mark.parametrize("silence", [0.3, 0.6, 1.0, 3.0])
@pytest.mark.parametrize("then", [7.0, 20.0])
def test_a_bus_that_comes_back_and_is_not_started(silence: float, then: float) -> None:
    capture = switched_off(silence, then, starts=False)
    assert ("not-running", "open") in statuses(capture), capture.said
    assert "not-running" not in kinds(switched_off(silence, then, starts=True))
    assert "not-running" not in kinds(switched_off(silence, then, starts=False, command=True))
    assert "not-running" not in kinds(switched_off(silence, 3.0, starts=False))


@pytest.mark.parametrize("silence", [0.1, 0.3, 1.0, 3.0, 30.0])
def test_a_bus_that_restarts_and_runs_again(silence: float) -> None:
    """All its nodes at once, which no rule blames. A reset by command, or one that is not recorded, differs."""
    assert ("node-restarted", "ended") in statuses(switched_off(silence, 7.0, starts=True))
    assert "node-restarted" not in kinds(switched_off(silence, 7.0, starts=True, command=True))
    assert "node-restarted" not in kinds(switched_off(silence, 7.0, starts=True, recorded=False))


@pytest.mark.parametrize("beat", [0.2, 0.4])
def test_a_silence_of_the_bus_is_no_cause_of_boot_ups(beat: float) -> None:
    """Only the controller goes on, so that the bus seems silent between its heartbeats."""
    controller = beats(1, beat, 12)
    rest = [running(number, 3) for number in (2, 3, 5)]
    boots = [(4.01 + number / 1000, f"70{number}#00") for number in (2, 3, 5)]
    again = [running(number, 12, 4.6) for number in (2, 3, 5)]
    start: Frames = [(0.001, "000#0100"), (4.5, "000#0100")]
    capture = diagnosed(log(controller, *rest, boots, *again, start))
    roots = [one for one in capture.roots if one["problem"] in {"bus-silent", "capture-gap"}]
    assert not roots, capture.said


def poll(number: int, count: int, period: float, lost: set[int], second: float | None = None) -> Frames:
    """Reads of a position that changes. lost: requests that the recording lacks; second: a second server answers."""
    rows: Frames = []
    for place in range(count):
        at, value = 1 + place * period, f"{place * 37 % 65536:04X}"
        if place not in lost:
            rows.append((at, f"{0x600 + number:03X}#4064600000000000"))
        rows.append((at + 0.0008, f"{0x580 + number:03X}#4B646000{value}0000"))
        if second is not None:
            rows.append((at + 0.0008 + second, f"{0x580 + number:03X}#4B646000{(place * 91 + 7) % 65536:04X}0000"))
    return rows


@pytest.mark.parametrize("period", [0.01, 0.024, 0.045])
@pytest.mark.parametrize("lost", [3, 6, 12])
def test_a_response_in_its_turn_is_of_a_lost_request(period: float, lost: int) -> None:
    gone = {20 + 17 * place for place in range(lost)}
    capture = diagnosed(log(beats(3, 0.1, 12), poll(3, 240, period, gone)))
    assert "duplicate-node-id" not in {one["problem"] for one in capture.incidents}, capture.said


@pytest.mark.parametrize("period", [0.01, 0.024, 0.045])
@pytest.mark.parametrize("second", [0.0004, 0.002, 0.005])
def test_two_responses_to_each_request_are_of_two_servers(period: float, second: float) -> None:
    capture = diagnosed(log(beats(3, 0.1, 12), poll(3, 240, period, set(), second)))
    assert "duplicate-node-id" in {one["problem"] for one in capture.incidents}, capture.said


def in_fault(of: int, kind: str) -> Diagnosed:
    """A drive goes into fault; the inputs of a node look like a statusword in fault."""
    types = [(0.2, f"60{number}#4000100000000000") for number in (3, 5)]
    types += [(0.201, "583#4300100091010300"), (0.202, f"585#43001000{kind}")]
    words: Frames = []
    for place in range(200):
        at = 1 + place * 0.02
        words.append((at, f"185#{'1802' if place > 40 else '3702'}"))
        words.append((at + 0.001, f"183#{'B87D0012' if place > 100 else 'B07D0012'}"))
    emcy: Frames = [(1.815, "085#1023010000000000")] if of else []
    return diagnosed(log(beats(3, 0.1, 6), beats(5, 0.1, 6), types, words, emcy))


def test_inputs_of_another_node_are_no_statusword() -> None:
    capture = in_fault(5, "92010200")
    assert {one["subject"].get("node") for one in capture.incidents if one["status"] != "harmless"} <= {5}, capture.said


@pytest.mark.parametrize("at", [0.45, 0.9, 1.4])
def test_an_early_report_of_a_loss_makes_no_silence(at: float) -> None:
    """The heartbeats of node 1 come every 500 ms, and a consumer misses them."""
    report: Frames = [(at, "082#3081110001000000")]
    capture = diagnosed(log(beats(1, 0.5, 10, start=0.02), running(2, 10), running(3, 10), report))
    assert {one["subject"].get("node") for one in capture.incidents} == {2}, capture.said


@pytest.mark.parametrize("lasts", [1.5, 4.0])
def test_a_loss_that_is_reported_is_one(lasts: float) -> None:
    gone = beats(1, 0.5, 4, start=0.02) + beats(1, 0.5, 14, start=4.02 + lasts)
    capture = diagnosed(log(gone, running(2, 14), running(3, 14), [(5.3, "082#3081110001000000")]))
    assert any(one["subject"].get("node") == 1 for one in capture.incidents), capture.said


SYNC_PRODUCER: Frames = [
    (0.15, "601#2306100010270000"),
    (0.1515, "581#6006100000000000"),
    (0.16, "601#2305100080000040"),
    (0.1615, "581#6005100000000000"),
    (0.3, "000#0100"),
]


@pytest.mark.parametrize("lasts", [6.0, 10.0, 40.0])
def test_a_configured_producer_that_sends_no_sync(lasts: float) -> None:
    others = log(SYNC_PRODUCER, running(1, lasts, 0.4), running(2, lasts, 0.4))
    assert [row["code"] for row in found(others)] == ["SYN014"]
    assert statuses(diagnosed(others)) == [("sync-never", "open")]


@pytest.mark.parametrize("lasts", [1.0, 4.5])
def test_it_may_still_be_about_to_send(lasts: float) -> None:
    assert not found(log(SYNC_PRODUCER, running(1, lasts, 0.4)))


@pytest.mark.parametrize("change", ["601#2305100080000000", "601#2306100000000000"])
def test_a_producer_that_is_switched_off_owes_none(change: str) -> None:
    off: Frames = [(0.2, change), (0.2015, f"581#60{change[6:12]}00000000")]
    assert not found(log(SYNC_PRODUCER, off, running(1, 10, 0.4)))


def test_a_producer_that_sends_owes_none() -> None:
    sync = [(0.4 + place / 100, "080#") for place in range(960)]
    assert not found(log(SYNC_PRODUCER, running(1, 10, 0.4), sync))


@pytest.mark.parametrize("read", [False, True])
def test_a_tick_is_not_for_states_that_nobody_has_read(read: bool) -> None:
    kind: Frames = [(0.2, "605#4000100000000000"), (0.201, "585#4300100092010200")]
    if read:
        kind += [(0.3, "605#4041600000000000"), (0.301, "585#4B41600037020000")]
    capture = diagnosed(log(beats(5, 0.1, 6), kind, [(1 + place / 50, "185#3702") for place in range(251)]))
    assert not capture.roots, capture.said
    assert ("drive states not judged: node 5" in capture.whole["looked"]) != read, capture.whole["looked"]


def lossy(lasts: float, part: int) -> list[tuple[float, str]]:
    """Nodes with heartbeats and SYNC, some of them missing in the recording; node 3 is gone after `lasts` seconds."""
    sync = [(place / 50, "080#") for place in range(1000)]
    whole = [*sync, *running(1, 20), *running(2, 20), *running(3, lasts), *running(4, 20)]
    return [frame for place, frame in enumerate(sorted(whole)) if (place * 7919 + 13) % part]


@pytest.mark.parametrize("part", [53, 101, 211])
def test_what_single_lost_frames_explain_is_not_open(part: int) -> None:
    capture = diagnosed(log(lossy(20, part)))
    assert "frames-missing" in {one["problem"] for one in capture.incidents}, capture.incidents
    assert not capture.roots, capture.said


@pytest.mark.parametrize("part", [53, 101, 211])
@pytest.mark.parametrize("lasts", [8.0, 12.0, 18.0])
def test_lost_frames_hide_no_node_that_is_gone(part: int, lasts: float) -> None:
    capture = diagnosed(log(lossy(lasts, part)))
    assert [(one["problem"], one["subject"].get("node")) for one in capture.roots] == [("node-silent", 3)], capture.said
