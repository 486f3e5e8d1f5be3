"""Clean networks in captures that are not what their senders did: nothing is said of what the capture alone did.

Every frame twice, as of two adapters on one bus; NMT filtered out; a recording that paused; coarse stamps; a network
switched off and on; a master that looks for nodes or stops its SYNC. What it must not do: contain a fault of a sender.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import product

import pytest
from captures import SAMPLES, Analysis, CanFrame, analyze, console_text, log_text, read_log, spaced
from conftest import NOTES
from diagnoses import diagnosed
from network import OPERATIONAL, PRE_OP, PRE_OPERATIONAL, RESET_COMMUNICATION, START, Follower, Network, echoed_late
from network_sessions import NODE, OTHER, SESSIONS
from sdo_wire import Channel, block_download, block_upload, expedited_upload, segmented_upload

from canalyze import _core
from canalyze.running.reading import SessionOptions

RECORDED = {path.stem: read_log(path.read_bytes()) for path in sorted((SAMPLES / "network").glob("*.log"))}
"""Recorded sessions of whole networks."""
STACKS = {path.stem: read_log(path.read_bytes()) for path in sorted((SAMPLES / "stacks").glob("*.log"))}
PAUSE_US = 60_000_000


def without(frames: Sequence[CanFrame], *can_ids: int) -> list[CanFrame]:
    """A capture from which these identifiers were filtered out."""
    return [frame for frame in frames if frame.can_id not in can_ids]


def paused(frames: Sequence[CanFrame], at: int) -> list[CanFrame]:
    """The capture with a minute without frames before one of them."""
    return [*frames[:at], *(replace(frame, t_us=frame.t_us + PAUSE_US) for frame in frames[at:])]


def quiet(said: Analysis) -> None:
    """Nothing above info."""
    assert not said.above_info(), said.complaint()


def codes(said: Analysis) -> set[str]:
    return {finding["code"] for finding in said.findings}


@pytest.mark.parametrize("name", [*RECORDED, *STACKS])
@pytest.mark.parametrize("apart_us", [10, 900])
def test_no_problem_comes_of_every_frame_twice(name: str, apart_us: int) -> None:
    frames = RECORDED.get(name) or STACKS[name]
    doubled = [copy for frame in frames for copy in (frame, replace(frame, t_us=frame.t_us + apart_us))]
    once, twice = (diagnosed(log_text(sorted(one, key=lambda f: f.t_us))) for one in (frames, doubled))
    assert {one["problem"] for one in twice.roots} <= {one["problem"] for one in once.roots}, twice.said


def test_a_second_master_is_told_from_frames_captured_twice() -> None:
    frames = read_log((SAMPLES / "stories" / "t07-second-master.log").read_bytes())
    assert "two-masters" in {one["problem"] for one in diagnosed(log_text(frames)).roots}


@pytest.mark.parametrize("name", [*RECORDED, *STACKS])
def test_every_frame_twice(name: str) -> None:
    frames = RECORDED.get(name) or STACKS[name]
    doubled = [copy for frame in frames for copy in (frame, replace(frame, t_us=frame.t_us + 1))]
    once, twice = analyze(log_text(frames)), analyze(log_text(doubled))
    quiet(twice)
    assert len(twice.transfers) == len(once.transfers)
    assert [row["data"] for row in twice.transfers] == [row["data"] for row in once.transfers]
    assert not {"SDO015", "SDO020"} & codes(twice)


@pytest.mark.parametrize("name", ["boot-and-states", "remapping", "drive-states"])
def test_every_frame_twice_without_stamps(name: str) -> None:
    quiet(analyze(console_text(copy for frame in RECORDED[name] for copy in (frame, frame))))


def decoded_with_rests(lines: Iterable[str]) -> list[str]:
    """The frames' lines of a pipe that comes to a rest behind each frame."""
    session = _core.Session(SessionOptions("en", format="text"))
    session.begin("-", False)
    out = b""
    for line in lines:
        out += session.feed(f"{line}\n".encode()) + session.rest()
    return [line for line in (out + session.end() + session.finish()).decode().splitlines() if line.startswith("can")]


def test_equal_frames_before_a_rest_prove_nothing() -> None:
    """A bus on which only a heartbeat was sent so far: no frame behind it is taken for one captured twice."""
    shown = decoded_with_rests([*["can1  705   [1]  05"] * 4, *NOTES.splitlines()])
    assert not [line for line in shown if "captured twice" in line]
    assert "Zephyr RTOS/CANopenNode" in shown[-1]


def test_every_frame_twice_before_each_rest() -> None:
    shown = decoded_with_rests(line for line in NOTES.splitlines() for _ in range(2))
    assert ["captured twice" in line for line in shown] == [False, True] * len(NOTES.splitlines())


@pytest.mark.parametrize(
    ("apart_us", "late_us"),
    [
        (20_000, 120),
        pytest.param(
            *(500, 40),
            marks=pytest.mark.xfail(
                strict=True, reason="too few isolated frames before the first block show that frames stand twice"
            ),
        ),
    ],
)
def test_every_frame_twice_with_frames_between(apart_us: int, late_us: int) -> None:
    """The second adapter is late by more than the server takes to answer; heartbeats go before, this far apart."""
    channel = Channel(5)
    session = block_upload(channel, 0x2004, 0, bytes(100), blksize=5) + block_download(channel, 0x2004, 0, bytes(60))
    session += segmented_upload(channel, 0x1008, 0, b"a device with a name")
    beats = [CanFrame("can0", 0x701 + number % 4, b"\x05", number * apart_us) for number in range(16)]
    spread = [replace(frame, t_us=16 * apart_us + 2_000 + 100 * number) for number, frame in enumerate(session)]
    doubled = [copy for frame in beats for copy in (frame, replace(frame, t_us=frame.t_us + late_us))]
    doubled += [copy for frame in spread for copy in (frame, replace(frame, t_us=frame.t_us + 120))]
    said = analyze(log_text(sorted(doubled, key=lambda frame: frame.t_us)))
    quiet(said)
    assert [row["status"] for row in said.transfers] == ["ok"] * 3


def test_heartbeats_without_stamps_are_no_twins() -> None:
    """What stands beside itself there may be a second apart: answers that are alike count all the same."""
    net = Network().boot(NODE).heartbeat(NODE, period=0.1, count=8).wait(0.85)
    for value in (500, 50, 1000):
        net.write(NODE, 0x1017, 0, value, 2).heartbeat(NODE, period=value / 1000, count=6).wait(value * 0.0065)
    said = analyze(console_text(net.read(NODE, 0x1000, 0, 0x192, 4).frames()))
    quiet(said)
    assert [row["status"] for row in said.transfers] == ["ok"] * 4
    assert {row["sdo"]["place"] for row in said.frames if row["service"] == "sdo"} == {"due"}


def test_the_first_two_requests_late_and_a_second_apart() -> None:
    """One object written twice from the capture's beginning on: the stamps tell which answer is whose."""
    net = Network().write(NODE, 0x1017, 0, 100, 2).wait(0.9).write(NODE, 0x1017, 0, 500, 2).wait(0.9)
    request, answer, again, second = net.read(NODE, 0x1000, 0, 0x192, 4).frames()[:4]
    late = [replace(answer, t_us=request.t_us), replace(request, t_us=answer.t_us)]
    late += [replace(second, t_us=again.t_us), replace(again, t_us=second.t_us)]
    said = analyze(log_text([*late, *net.frames()[4:]]))
    quiet(said)
    assert [row["data"] for row in said.transfers] == ["6400", "F401", "92010000"]


def test_polling_cut_in_the_middle_with_every_request_late() -> None:
    """The capture ends with an answer whose request would follow."""
    net = Network().read(NODE, 0x1000, 0, 0x192, 4)
    for value in range(12):
        net.read(NODE, 0x2001, 0, value, 2)
    frames = net.frames()
    late = [frame for at in range(2, len(frames), 2) for frame in (frames[at + 1], frames[at])]
    for end in range(len(late)):
        quiet(analyze(console_text([*frames[:2], *late[:end]])))


@pytest.mark.parametrize("name", ["states", "stopped", "guarded"])
def test_commands_filtered_out(name: str) -> None:
    """A node becomes Operational, or Stopped, only by a command: the capture has none at all."""
    quiet(analyze(log_text(without(SESSIONS[name]().frames(), 0x000))))


@pytest.mark.parametrize("name", ["boot-and-states", "guarding", "sync-and-pdos", "sync-counter"])
def test_commands_filtered_out_of_a_recording(name: str) -> None:
    quiet(analyze(log_text(without(RECORDED[name], 0x000))))


def restarted(*, states: bool, boots: bool) -> list[CanFrame]:
    """A node is reset and asked again for four seconds. states: nodes show theirs; boots: this one boots."""
    channel = Channel(5)
    frames = [
        replace(frame, t_us=number * 10_000) for number, frame in enumerate(expedited_upload(channel, 0x1000, 0, b"a"))
    ]
    frames.append(CanFrame("can0", 0, bytes([RESET_COMMUNICATION, 5]), 100_000))
    if states:
        frames += [CanFrame("can0", 0x704, bytes([OPERATIONAL]), at) for at in range(0, 5_000_000, 100_000)]
        frames += [CanFrame("can0", 0x705, b"\0", 600_000)] * boots
    for at in range(1_000_000, 5_000_000, 500_000):
        exchange = expedited_upload(channel, 0x1000, 0, b"a")
        frames += [replace(frame, t_us=at + number * 1000) for number, frame in enumerate(exchange)]
    return sorted(frames, key=lambda frame: frame.t_us)


def test_boot_ups_filtered_out() -> None:
    """Where no node shows its state, none can be missed; where others do, it can."""
    assert not codes(analyze(log_text(restarted(states=False, boots=False)))) & {"NMT006", "NMT002"}
    assert "NMT006" in codes(analyze(log_text(restarted(states=True, boots=False))))
    assert "NMT006" not in codes(analyze(log_text(restarted(states=True, boots=True))))


@pytest.mark.parametrize("gone", [True, False])
def test_what_may_be_the_master_is_missed_after_it_has_reset_all(gone: bool) -> None:
    beats = range(0, 8_000_000, 250_000)
    frames = [CanFrame("can0", 0x77F, bytes([OPERATIONAL]), at) for at in beats if not gone or at < 2_000_000]
    frames += [CanFrame("can0", 0x185, bytes(8), at + 7) for at in range(0, 8_000_000, 50_000)]
    frames.append(CanFrame("can0", 0, bytes([RESET_COMMUNICATION, 0]), 1_900_000))
    found = codes(analyze(log_text(sorted(frames, key=lambda frame: frame.t_us))))
    assert ("NMT006" in found) == gone


@pytest.mark.parametrize("burst", [True, False])
def test_boot_ups_and_emergencies_that_waited_in_the_recorder(burst: bool) -> None:
    """What a recorder lists in a row after it stood still came at any time; the same without that is a fault."""
    beats = [CanFrame("can0", 0x704, bytes([OPERATIONAL]), at * 20_000) for at in range(1, 100)]
    start = 2_000_000 + 3_000_000 * burst
    errors = [CanFrame("can0", 0x085, bytes.fromhex(one), 0) for one in ("1050010000000000", "00" * 8) * 8]
    boots = [CanFrame("can0", 0x705, b"\0"), CanFrame("can0", 0x705, b"\0")]
    late = [CanFrame("can0", 0x704, bytes([OPERATIONAL]))] * 140 * burst
    listed = [*boots, *errors, *late]
    rows = [replace(frame, t_us=start + number * 150) for number, frame in enumerate(listed)]
    after = [CanFrame("can0", 0x704, bytes([OPERATIONAL]), start + 100_000 + at * 20_000) for at in range(40)]
    found = codes(analyze(log_text([*beats, CanFrame("can0", 0x705, b"\0", 1_990_000), *rows, *after])))
    assert ("EMC010" in found) != burst
    assert ("HBT004" in found) != burst


def test_stamps_that_are_all_zero_tell_no_time() -> None:
    frames = read_log((SAMPLES / "rules" / "PDO004.log").read_bytes())
    assert "PDO004" in codes(analyze(log_text(frames)))
    zero = [replace(frame, t_us=0) for frame in frames]
    assert "PDO004" not in codes(analyze(log_text(zero)))


def test_a_node_that_falls_back_where_nobody_commands() -> None:
    """What a node does by itself is told, at the end at the latest, and where a command comes."""
    net = Network().boot(NODE, OTHER).write(NODE, 0x1017, 0, 100, 2)
    for node in (NODE, OTHER):
        net.live(node, period=0.1, seconds=2.0, states=[(0, OPERATIONAL)] + [(1.0, PRE_OPERATIONAL)] * (node == NODE))
    (finding,) = analyze(log_text(net.frames())).above_info()
    assert (finding["code"], finding["node"]) == ("NMT004", NODE)
    net.now = 1.55
    (finding,) = analyze(log_text(net.nmt(START, OTHER).frames())).above_info()
    assert (finding["code"], finding["node"]) == ("NMT004", NODE)


@pytest.mark.parametrize("seconds", [1.0, 30.0])
def test_a_node_that_boots_again_where_nobody_commands(seconds: float) -> None:
    """A network that starts itself: told at the boot-up's frame, whenever it is told."""
    net = Network()
    for node in (3, 4, 5):
        net.boot(node).send(0x700 + node, bytes([OPERATIONAL]), after=0.02)
        net.live(node, period=0.1, seconds=0.5 + seconds, states=[(0, OPERATIONAL)])
    frames = net.frames()
    at = next(place for place, frame in enumerate(frames) if frame.t_us > (net.start + 0.51) * 1_000_000)
    again = CanFrame("can0", 0x704, b"\0", frames[at].t_us - 1)
    (finding,) = analyze(log_text([*frames[:at], again, *frames[at:]])).above_info()
    assert (finding["code"], finding["node"], finding["frame"]) == ("NMT003", 4, at + 1)


def test_a_boot_up_that_is_told_late_stands_at_its_frame() -> None:
    """Whether the other node comes back as well shows only then."""
    net = Network().boot(NODE, OTHER).write(NODE, 0x1017, 0, 100, 2).write(OTHER, 0x1017, 0, 100, 2).nmt(START)
    net.live(OTHER, period=0.1, seconds=2.0, states=[(0, OPERATIONAL)]).wait(0.33)
    place = len([frame for frame in net.frames() if frame.t_us <= (net.start + net.now) * 1_000_000]) + 1
    (finding,) = analyze(log_text(net.boot(NODE).read(NODE, 0x1000, 0, 0x192, 4).frames())).above_info()
    assert (finding["code"], finding["node"], finding["frame"]) == ("NMT003", NODE, place)


def network_of(count: int, *, boot_ups: Sequence[float]) -> Network:
    """Nodes with heartbeats under a master that keeps its power; they boot again at these times, 3 s and later."""
    net = Network()
    nodes = range(1, count + 1)
    net.live(0x7F, period=0.1, seconds=6.0, states=[(0, OPERATIONAL)])
    net.boot(*nodes)
    for node in nodes:
        net.write(node, 0x1017, 0, 100, 2)
    net.nmt(START)
    start = net.now
    for node, again in zip(nodes, boot_ups, strict=True):
        net.now = start
        net.live(node, period=0.1, seconds=1.0, states=[(0, OPERATIONAL)])
        net.now = again
        net.boot(node).write(node, 0x1017, 0, 100, 2)
        net.live(node, period=0.1, seconds=2.0, states=[(0, PRE_OPERATIONAL)])
    return net


def test_a_network_switched_off_and_on() -> None:
    """All nodes boot again, one after the other, while the master is alive."""
    said = analyze(log_text(network_of(3, boot_ups=[3.0, 3.2, 3.9]).frames()))
    assert "NMT003" not in codes(said), said.complaint()


def test_one_node_of_a_network_boots_again() -> None:
    net = network_of(2, boot_ups=[3.0, 3.2])
    kept = [f for f in net.frames() if (f.can_id, f.data) != (0x702, b"\0") or f.t_us < (net.start + 3) * 1_000_000]
    assert "NMT003" in codes(analyze(log_text(kept)))


@pytest.mark.parametrize("name", ["sync-and-pdos", "multiplex-and-safety", "boot-and-states"])
def test_a_recording_that_paused(name: str) -> None:
    frames = RECORDED[name]
    for at in range(len(frames) // 6, len(frames) - 1, max(1, len(frames) // 12)):
        said = analyze(log_text(paused(frames, at)))
        told = codes(said) & {"PDO005", "SRD003", "TIM002"}
        assert not told, f"before frame {at + 1}: {said.complaint()}"


def test_stamps_of_ten_milliseconds() -> None:
    for name in ("sync-counter", "sync-and-pdos"):
        coarse = [replace(frame, t_us=frame.t_us // 10_000 * 10_000) for frame in RECORDED[name]]
        quiet(analyze(log_text(coarse)))


def test_a_master_stops_its_sync_to_configure() -> None:
    """All nodes to Pre-operational, a few writes, and the SYNC goes on."""
    net = Network().boot(NODE).write(NODE, 0x1800, 2, 1, 1).nmt(START).wait(0.05)
    follower = Follower(0x185, lambda cycle: struct.pack("<H", cycle))
    net.sync(period=0.02, count=30, followers=[follower])
    net.wait(0.602).nmt(PRE_OP).write(NODE, 0x1006, 0, 20_000, 4).wait(0.08).nmt(START).wait(0.005)
    quiet(analyze(log_text(net.sync(period=0.02, count=30, followers=[follower]).frames())))


def test_who_scans_the_bus_expects_no_answers() -> None:
    """126 requests, two answers: one line for each silent node would say nothing."""
    net = Network()
    for node in range(1, 127):
        net.send(0x600 + node, b"\x40\x00\x10\x00\0\0\0\0").wait(0.001)
        if node in (5, 9):
            net.send(0x580 + node, b"\x43\x00\x10\x00\x92\x01\0\0")
    said = analyze(log_text(net.frames()))
    assert not codes(said), said.findings
    net.wait(2).send(0x705, b"\x05")
    silent = [frame for frame in net.frames() if frame.can_id in (0x601, 0x602, 0x605, 0x585, 0x705)]
    assert codes(analyze(log_text(silent))) == {"SDO031"}


def test_a_heartbeat_time_of_which_only_the_confirmation_is_there() -> None:
    net = Network().boot(NODE).heartbeat(NODE, period=0.02, count=20).wait(0.405).write(NODE, 0x1017, 0, 200, 2)
    net.heartbeat(NODE, period=0.2, count=8)
    quiet(analyze(log_text(without(net.frames(), 0x605))))


def test_a_reset_without_boot_up_listed_late() -> None:
    """Some nodes show Pre-operational at once."""
    net = Network().boot(NODE).write(NODE, 0x1017, 0, 100, 2).nmt(START, NODE)
    net.live(NODE, period=0.1, seconds=0.5, states=[(0, OPERATIONAL)]).wait(0.55)
    net.send(0, bytes([RESET_COMMUNICATION, NODE])).send(0x705, b"\x7f", after=0.0003).wait(0.01)
    net.heartbeat(NODE, period=0.1, count=5)
    for seed in range(4):
        assert "NMT004" not in codes(analyze(log_text(echoed_late(net.frames(), {0x000}, seed=seed))))


@pytest.mark.parametrize("step_us", [100, 130, 200, 250])
@pytest.mark.parametrize("blksize", [8, 16, 24, 33, 40, 63, 100, 127])
def test_sub_blocks_of_equal_data_are_not_copies(blksize: int, step_us: int) -> None:
    """A file of zeros: each sub-block is the one before once more, within the time in which a copy may come."""
    exchange = expedited_upload(Channel(5), 0x1000, 0, bytes(4))
    for block in (block_upload, block_download):
        for count, before in product((2, 3, 5, 8), ([], exchange)):
            frames = before + block(Channel(5), 0x1F50, 1, bytes(7 * blksize * count), blksize=blksize)
            said = analyze(log_text(spaced(frames, step_us=step_us)))
            quiet(said)
            assert {row["status"] for row in said.transfers} == {"ok"}
            assert not any(row["sdo"]["place"] == "duplicate" for row in said.frames)
