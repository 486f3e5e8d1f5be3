"""Orderly ends, and ends by a fault: a SYNC, a node-ID, a bus, the heartbeats of a controller.

Each fault stands beside the orderly end that looks like it.
"""

from __future__ import annotations

import pytest
from diagnoses import diagnosed
from test_neighbouring_verdicts import Frames, beats, log, statuses
from test_what_waits import kinds, running

PERIOD = 0.02


def syncs(until: float, start: float = 0.0) -> Frames:
    return [(start + PERIOD * place, "080#") for place in range(round((until - start) / PERIOD))]


@pytest.mark.parametrize("after", [0.0, 0.03, 0.2, 1.0])
@pytest.mark.parametrize("again", [False, True])
@pytest.mark.parametrize("command", ["80", "02"])
def test_a_sync_that_ends_behind_a_stop_of_all_nodes(after: float, again: bool, command: str) -> None:
    """The controller reports Operational all the while, since it does not obey itself."""
    state = "7F" if command == "80" else "04"
    nodes = [running(number, 2) + beats(number, 0.1, 6, state, 2.01) for number in (5, 6)]
    parts: list[Frames] = [[(0.001, "000#0100"), (2.0, f"000#{command}00")], syncs(2 + after), beats(1, 0.1, 8)]
    if again:
        parts += [syncs(8, 4), [(6, "000#0100")], *(running(number, 8, 6.02) for number in (5, 6))]
    capture = diagnosed(log(*parts, *nodes))
    assert not {"sync-stopped", "sync-irregular"} & {*kinds(capture)}, capture.said


@pytest.mark.parametrize("lasts", [1.0, 4.0])
def test_a_sync_that_ends_while_nodes_run(lasts: float) -> None:
    start: Frames = [(0.001, "000#8000"), (0.1, "000#0100")]
    capture = diagnosed(
        log(start, syncs(2), *(running(number, 2 + lasts, 0.12) for number in (5, 6)), beats(1, 0.1, 6))
    )
    assert ("sync-stopped", "open") in statuses(capture), capture.said


SELECT = [("40", "E5020000"), ("41", "34120000"), ("42", "03000100"), ("43", "CD2C0100")]


def moved(command: str, then: int, reset: int = 5) -> Frames:
    """Node 5 gets node-ID 12 by LSS, behind a command; a node is reset, and one boots."""
    select = [(3.0 + place / 100, f"7E5#{step}{value}000000") for place, (step, value) in enumerate(SELECT)]
    assign = [(3.05, "7E4#4400000000000000"), (3.06, "7E5#110C000000000000"), (3.061, "7E4#1100000000000000")]
    store = [(3.07, "7E5#1700000000000000"), (3.071, "7E4#1700000000000000"), (3.08, "7E5#0400000000000000")]
    booted = [(3.1, f"000#82{reset:02X}"), (3.2, f"7{then:02X}#00"), (3.4, f"000#01{then:02X}")]
    return [(2.9, f"000#{command}05"), *select, *assign, *store, *booted, *beats(then, 0.1, 8, start=3.41)]


@pytest.mark.parametrize("command", ["80", "02"])
def test_a_node_that_gets_another_node_id_is_not_missed(command: str) -> None:
    before = [running(5, 2.9), running(6, 8), [(0.001, "000#0100")]]
    capture = diagnosed(log(*before, moved(command, 12)))
    assert not [one for one in statuses(capture) if one[1] == "open"], capture.said
    # Another node was reset: who has the new node-ID is unknown, and node 5 does not come back.
    capture = diagnosed(log(*before, moved(command, 12, reset=7)))
    assert ("commanded-stop", "open") in statuses(capture), capture.said


@pytest.mark.parametrize("silence", [0.4, 1.0, 5.0])
def test_a_silence_that_begins_with_error_frames_is_no_pause_of_the_recording(silence: float) -> None:
    """All go on in phase: their clocks know nothing of the bus."""
    back = 3 + silence
    nodes = [running(number, 3) + running(number, back + 4, back) for number in (5, 6, 7)]
    errors: Frames = [(3.0 + place / 1000, "20000088#0000080000000000") for place in range(40)]
    told = [{one["problem"] for one in diagnosed(log(*nodes, more)).incidents} for more in (errors, [])]
    assert [("capture-gap" in kinds) for kinds in told] == [False, True]


@pytest.mark.parametrize("goes_on", [False, True])
def test_what_controls_goes_on_without_the_heartbeat_of_a_node(goes_on: bool) -> None:
    """It is not said to be the controller then."""
    rpdos = [(0.005 + place * PERIOD, f"205#{place % 251:02X}00") for place in range(400 if goes_on else 149)]
    parts = [[(0.001, "000#0100")], beats(1, 0.1, 3), running(5, 8), running(6, 8), syncs(8 if goes_on else 3), rpdos]
    capture = diagnosed(log(*parts))
    (silent,) = [one for one in capture.roots if one["problem"] == "node-silent"]
    assert ("host" in silent["checks"]) == (not goes_on), capture.said


def rpdos(period: float, until: float, start: float = 0.2, uneven: float = 0.0) -> Frames:
    count = round((until - start) / period)
    return [(start + period * (place + uneven * (place % 3)), f"205#{place % 251:02X}00") for place in range(count)]


@pytest.mark.parametrize("period", [0.005, 0.02, 0.05])
@pytest.mark.parametrize("reports", [False, True])
@pytest.mark.parametrize("back", [0.0, 5.5])
def test_rpdos_that_came_evenly_and_stop(period: float, reports: bool, back: float) -> None:
    """On a bus without SYNC nobody knows whether they should go on, unless a node reports that it misses them."""
    start: Frames = [(0.001, "000#0100")]
    parts = [start, beats(1, 0.1, 8), running(5, 8), running(6, 8), rpdos(period, 4)]
    if reports:
        parts.append([(4.1, "085#5082110000000000")])
    if back:
        parts += [rpdos(period, 8, back), [(back + 0.1, "085#0000000000000000")]]
    capture = diagnosed(log(*parts))
    status = "ended" if back else "open" if reports else "unknown"
    stopped = [one for one in capture.roots if one["problem"] == "rpdo-stopped"]
    assert [one["status"] for one in stopped] == [status], capture.said
    assert len(stopped[0]["effects"]) == reports, capture.said


@pytest.mark.parametrize("period", [0.02, 0.05])
def test_rpdos_that_need_not_go_on(period: float) -> None:
    start: Frames = [(0.001, "000#0100")]
    nodes = [beats(1, 0.1, 8), running(6, 8)]
    # Sent at changes, until the end, or to a node that is stopped.
    for parts in (
        [running(5, 8), rpdos(period, 4, uneven=0.6)],
        [running(5, 8), rpdos(period, 8)],
        [running(5, 4), [(4, "000#8005")], beats(5, 0.1, 8, "7F", 4.05), rpdos(period, 4)],
        [running(5, 4.2), rpdos(period, 4)],
    ):
        assert "rpdo-stopped" not in kinds(diagnosed(log(start, *nodes, *parts)))


@pytest.mark.parametrize(
    ("abort", "told"),
    [
        ("605#8000100000000405", ["request-unanswered"]),  # by the client, after a time-out
        ("585#80501F0104000405", ["program-download-failed"]),
        ("585#8001200010000706", ["length-refused"]),
        ("585#8001200000000206", []),  # no such object, the usual answer to a read
        ("605#8001200000000005", []),
    ],
)
def test_an_excerpt_that_begins_within_a_transfer_and_shows_its_abort(abort: str, told: list[str]) -> None:
    """Nobody knows if it was tried before, or again."""
    nodes = [running(5, 1), running(6, 1)]
    assert statuses(diagnosed(log(*nodes, [(0.5, abort)]))) == [(kind, "unknown") for kind in told]
    # Behind a transfer that the capture has.
    whole: Frames = [(0.1, "605#4000100000000000"), (0.101, "585#4300100092010000")]
    assert not [one for one in statuses(diagnosed(log(*nodes, whole, [(0.5, abort)]))) if one[1] == "unknown"]


@pytest.mark.parametrize("command", ["80", "02"])
@pytest.mark.parametrize("seconds", [0.5, 3.0])
def test_a_controller_does_not_obey_its_own_command(command: str, seconds: float) -> None:
    state, back = ("7F" if command == "80" else "04"), 2 + seconds
    nodes = [running(number, 2.03) + beats(number, 0.1, back, state, 2.08) for number in (5, 6)]
    again = [running(number, back + 3, back + 0.05) for number in (5, 6)]
    start: Frames = [(0.001, "000#0100"), (2.0, f"000#{command}00"), (back, "000#0100")]
    capture = diagnosed(log(start, *nodes, *again, beats(1, 0.1, back + 3)))
    (stopped,) = [one for one in capture.incidents if one["problem"] == "commanded-stop"]
    assert (stopped["status"], stopped["subject"]["nodes"]) == ("harmless", [5, 6]), capture.said


@pytest.mark.parametrize("boots", [False, True])
def test_a_node_that_runs_again_behind_a_boot_up_shows_nothing_of_commands(boots: bool) -> None:
    """Without one only a command brings it back, so that commands are not recorded; behind one it starts itself."""
    left = [running(5, 2), beats(5, 0.1, 3 if boots else 3.55, "7F", 2.05), running(5, 8, 3.6)]
    again: Frames = [(3.1, "705#00"), *beats(5, 0.1, 3.55, "7F", 3.2)] if boots else []
    capture = diagnosed(log(*left, again, running(6, 8)))
    assert ("left-operational" in kinds(capture)) == boots, capture.said
