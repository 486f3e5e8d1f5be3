"""One wrong frame is one finding above info, and it stands at that frame: nothing that only follows from it is said.

Sweeps over hand-made sessions, alone in their capture and in the midst of others: a frame missing, doubled, with an
undefined command, of another object, too short. Beside them a table of single faults of other services. What it must
not do: repeat what `test_seeded_faults.py` and `test_network_faults.py` show, that a fault is found at all.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest
from captures import Analysis, CanFrame, analyze, console_text, log_text, session_output, spaced
from network import OPERATIONAL, PRE_OP, PRE_OPERATIONAL, START, Frames, Network, find
from network_sessions import SESSIONS
from sdo_wire import (
    Channel,
    block_download,
    block_upload,
    expedited_download,
    expedited_upload,
    segmented_download,
    segmented_upload,
)

NODE = Channel(10)
VALUE = bytes(range(1, 65))
TRANSFERS = {
    "expedited upload": expedited_upload(NODE, 0x2001, 0, b"\xef\xbe"),
    "expedited download": expedited_download(NODE, 0x2000, 0, b"\x0a\0\0\0"),
    "segmented upload": segmented_upload(NODE, 0x1008, 0, b"Zephyr RTOS/CANopenNode"),
    "segmented download": segmented_download(NODE, 0x2004, 0, bytes(range(20))),
    "block upload": block_upload(NODE, 0x2004, 0, VALUE, blksize=4),
    "block download": block_download(NODE, 0x2004, 0, VALUE, blksize=4),
}
BEFORE = expedited_upload(NODE, 0x1001, 0, b"\0")
AFTER = expedited_upload(NODE, 0x1000, 0, b"\x91\x01\x0f\0")


def amid(transfer: Frames) -> Frames:
    """The transfer between two others, every 0.7 ms a frame."""
    return spaced([*BEFORE, *transfer, *AFTER], step_us=700)


def flipped(frames: Frames, at: int, byte: int, bits: int) -> Frames:
    data = bytearray(frames[at].data)
    data[byte] ^= bits
    return with_data(frames, at, bytes(data))


def with_data(frames: Frames, at: int, data: bytes) -> Frames:
    return [*frames[:at], replace(frames[at], data=data), *frames[at + 1 :]]


def without(frames: Frames, at: int) -> Frames:
    return [*frames[:at], *frames[at + 1 :]]


def swapped(frames: Frames, at: int) -> Frames:
    """A frame behind the next one; stamps in order."""
    here, following = frames[at], frames[at + 1]
    changed = [replace(following, t_us=here.t_us), replace(here, t_us=following.t_us)]
    return [*frames[:at], *changed, *frames[at + 2 :]]


def twice(frames: Frames, at: int) -> Frames:
    return [*frames[: at + 1], replace(frames[at], t_us=frames[at].t_us + 150), *frames[at + 1 :]]


def only(said: Analysis, codes: str, *, frame: int | None = None) -> bool:
    """Whether one finding above info was raised, of one of these codes, at this frame or about it."""
    loud = said.above_info()
    return (
        len(loud) == 1
        and loud[0]["code"] in codes.split()
        and (frame is None or frame in (loud[0]["frame"], loud[0]["cause_frame"]))
    )


def of_transfers(change: Callable[[Frames, int], Frames]) -> Iterator[tuple[str, int, Analysis]]:
    """Each frame of each transfer changed, with what is said of the capture, with and without stamps."""
    for name, transfer in TRANSFERS.items():
        frames = amid(transfer)
        for at in range(len(BEFORE), len(frames) - len(AFTER)):
            changed = change(frames, at)
            for text, form in ((log_text(changed), "log"), (console_text(changed), "candump")):
                yield name, at, analyze(text, name=f"capture.{form}")


def is_segment(name: str, frames: Frames, at: int) -> bool:
    """Whether a frame is data of a block transfer: 6 bytes that are no command."""
    sender = 0x58A if "upload" in name else 0x60A
    return name.startswith("block") and frames[at].can_id == sender and frames[at].data[0] & 0x7F < 5


def test_a_missing_frame_is_said_once() -> None:
    for name, at, said in of_transfers(without):
        codes = "SDO002 SDO012 SDO024"
        assert only(said, codes), f"{name} without frame {at + 1}: {said.complaint()}"


def test_a_doubled_frame_is_said_once() -> None:
    for name, at, said in of_transfers(twice):
        again = amid(TRANSFERS[name])[at].can_id == 0x60A and not said.above_info()
        assert again or only(said, "SDO002 SDO007 SDO012", frame=at + 2), f"{name} frame {at + 1}: {said.complaint()}"


def test_an_undefined_command_is_said_once() -> None:
    for name, transfer in TRANSFERS.items():
        frames = amid(transfer)
        for at in range(len(BEFORE), len(frames) - len(AFTER)):
            if is_segment(name, frames, at):
                continue
            said = analyze(log_text(with_data(frames, at, b"\xff" + frames[at].data[1:])))
            if not name.startswith("block"):
                assert only(said, "SDO023", frame=at + 1), f"{name} frame {at + 1}: {said.complaint()}"


@pytest.mark.parametrize("name", TRANSFERS)
def test_a_frame_that_is_too_short_is_said_once(name: str) -> None:
    """Whatever it lacks, and whatever cannot be judged for want of it."""
    frames = amid(TRANSFERS[name])
    for at in range(len(BEFORE), len(frames) - len(AFTER)):
        for length in range(8):
            said = analyze(log_text(with_data(frames, at, frames[at].data[:length])))
            assert only(said, "SDO010", frame=at + 1), f"frame {at + 1}, {length} bytes: {said.complaint()}"
            assert said.transfers[-1]["data"] == "91010F00"


@pytest.mark.parametrize("name", ["segmented upload", "segmented download", "block upload", "block download"])
def test_data_that_a_short_segment_lacks(name: str) -> None:
    """It was taken as it came: the value has a hole. Where the sender only leaves out what is no data, it has none."""
    frames = amid(TRANSFERS[name])
    whole = analyze(log_text(frames)).transfers[1]
    parts = (VALUE[7:14], VALUE[14:21], bytes(range(7, 14)), b"RTOS/CA")
    full = [at for at, frame in enumerate(frames) if frame.data[1:] in parts]
    assert full
    for at in full:
        row = analyze(log_text(with_data(frames, at, frames[at].data[:5]))).transfers[1]
        assert (row["status"], row["size"]) == ("incomplete", whole["size"])
        assert [hole["length"] for hole in row["holes"]] == [3]
    last = max(at for at, frame in enumerate(frames) if is_segment(name, frames, at) or frame.data[0] & 0xE1 == 1)
    row = analyze(log_text(with_data(frames, last, frames[last].data.rstrip(b"\0")))).transfers[1]
    assert (row["status"], row["data"]) == ("ok", whole["data"])


def test_an_acknowledgement_that_is_too_short() -> None:
    """What it leaves to be sent again shows only by what comes, and not always."""
    for block in (block_upload, block_download):
        for acknowledged in ([], [2], [4, 1]):
            frames = amid(block(NODE, 0x2004, 0, VALUE, blksize=4, acknowledged=acknowledged))
            for at, frame in enumerate(frames):
                if frame.data[0] == 0xA2:
                    for length in range(8):
                        said = analyze(log_text(with_data(frames, at, frame.data[:length])))
                        assert only(said, "SDO010", frame=at + 1), f"frame {at + 1}: {said.complaint()}"
                        row = said.transfers[1]
                        assert row["status"] == "incomplete" or row["data"] == VALUE.hex().upper()


def test_something_else_than_the_end_of_a_block_transfer() -> None:
    for name in ("block upload", "block download"):
        frames = amid(TRANSFERS[name])
        end = next(at for at, frame in enumerate(frames) if frame.data[0] == 0xD9)
        for bits in (0x01, 0x80):
            said = analyze(log_text(flipped(frames, end, 0, bits)))
            assert only(said, "SDO012", frame=end + 1), f"{name}: {said.complaint()}"


@pytest.mark.parametrize("length", [0, 5])
def test_a_short_segment_that_is_sent_again(length: int) -> None:
    """Its receiver did not take it."""
    for block in (block_upload, block_download):
        frames = amid(block(NODE, 0x2004, 0, VALUE, blksize=4, acknowledged=[1]))
        sender = 0x58A if block is block_upload else 0x60A
        at = next(at for at, frame in enumerate(frames) if frame.can_id == sender and frame.data[0] == 2)
        said = analyze(log_text(with_data(frames, at, frames[at].data[:length])))
        assert only(said, "SDO010", frame=at + 1), said.complaint()
        assert (said.transfers[1]["status"], said.transfers[1]["data"]) == ("ok", VALUE.hex().upper())


def test_the_last_segment_of_a_block_transfer() -> None:
    """Its number, or its mark: the receiver takes it for what was due."""
    for name in ("block upload", "block download"):
        frames = amid(TRANSFERS[name])
        last = max(at for at, frame in enumerate(frames) if is_segment(name, frames, at) and frame.data[0] & 0x80)
        for bits in (0x01, 0x10, 0x80):
            said = analyze(log_text(flipped(frames, last, 0, bits)))
            assert only(said, "SDO012", frame=last + 1), f"{name}: {said.complaint()}"


def test_a_response_with_another_command() -> None:
    """It is no response to what was asked for: what it would say as another is not judged."""
    frames = amid(TRANSFERS["segmented download"])
    for at in range(5, len(frames) - len(AFTER), 2):
        for command in (0xA0, 0xB0, 0xA4):
            said = analyze(log_text(with_data(frames, at, bytes([command, *frames[at].data[1:]]))))
            assert only(said, "SDO002", frame=at + 1), f"frame {at + 1}: {said.complaint()}"


@pytest.mark.parametrize("name", TRANSFERS)
@pytest.mark.parametrize("booted", [False, True])
def test_the_only_transfer_of_a_capture(name: str, booted: bool) -> None:
    """Nothing before it shows that this is SDO; the first exchange is judged all the same."""
    start = [CanFrame("can0", 0x70A, b"\0")] * booted
    frames = spaced([*start, *TRANSFERS[name]], step_us=700)
    first, answer = len(start), len(start) + 1
    assert not analyze(log_text(frames)).findings
    for byte, bits in ((1, 0x01), (2, 0x10), (3, 0x01)):
        said = analyze(log_text(flipped(frames, answer, byte, bits)))
        assert only(said, "SDO003", frame=answer + 1), said.complaint()
    for length in (7, 4) if name == "expedited download" else (7,):
        said = analyze(log_text(with_data(frames, answer, frames[answer].data[:length])))
        assert only(said, "SDO010", frame=answer + 1), said.complaint()
    if name == "block download":
        said = analyze(log_text(with_data(frames, answer, frames[answer].data[:4] + bytes(4))))
        assert only(said, "SDO012", frame=answer + 1), said.complaint()
    said = analyze(log_text(without(frames, first)))
    assert not said.above_info(), said.complaint()


@pytest.mark.parametrize("booted", [False, True])
def test_a_channel_that_begins_late_in_the_capture_has_no_edge(booted: bool) -> None:
    """It ran for two seconds without it, or its server has just booted."""
    net = Network().boot(5) if booted else Network().live(5, period=0.1, seconds=4, states=[(0, PRE_OPERATIONAL)])
    net.now = 0.05 if booted else 2.05
    frames = net.read(5, 0x1000, 0, 0x191, 4).wait(1).read(5, 0x1018, 1, 5, 4).frames()
    answer = find(frames, 0x585, 0)
    assert only(analyze(log_text(without(frames, answer))), "SDO002", frame=answer)
    assert only(analyze(log_text(without(frames, answer - 1))), "SDO002", frame=answer)
    assert only(analyze(log_text(flipped(frames, answer, 1, 1))), "SDO003", frame=answer + 1)
    for kept in (0x605, 0x585):
        one_side = analyze(log_text(frame for frame in frames if frame.can_id in (0x705, kept))).above_info()
        assert [row["code"] for row in one_side] == ["SDO031"] * (kept == 0x605)
    said = analyze(log_text(swapped(frames, answer - 1)))
    assert not said.findings, said.complaint()


@pytest.mark.parametrize("number", [1, 3])
def test_segments_that_were_not_acknowledged_and_not_sent_again(number: int) -> None:
    for name in ("block upload", "block download"):
        frames = amid(TRANSFERS[name])
        at = next(at for at, frame in enumerate(frames) if frame.data[:3] == b"\xa2\x04\x04")
        said = analyze(log_text(with_data(frames, at, bytes([0xA2, number, 4]).ljust(8, b"\0"))))
        assert only(said, "SDO012", frame=at + 1), said.complaint()
        last = next(at for at, frame in enumerate(frames) if frame.data[:3] == b"\xa2\x02\x04")
        said = analyze(log_text(with_data(frames, last, bytes([0xA2, 1, 4]).ljust(8, b"\0"))))
        assert only(said, "SDO012"), said.complaint()


def test_a_segment_marked_as_last_that_is_not() -> None:
    for name in ("block upload", "block download"):
        frames = amid(TRANSFERS[name])
        for at, frame in enumerate(frames):
            if is_segment(name, frames, at) and frame.data[0] in (1, 2, 3, 4) and at < len(frames) - 8:
                said = analyze(log_text(flipped(frames, at, 0, 0x80)))
                assert only(said, "SDO012", frame=at + 1), f"{name} frame {at + 1}: {said.complaint()}"


def session(name: str) -> Frames:
    return SESSIONS[name]().frames()


def test_error_control_of_a_wrong_length_is_no_silence_and_no_loss() -> None:
    for name in ("states", "stopped", "guarded"):
        frames = session(name)
        for at, frame in enumerate(frames):
            if frame.can_id == 0x705 and not frame.remote:
                for data in (b"", frame.data + b"\0", frame.data.ljust(8, b"\0")):
                    said = analyze(log_text(with_data(frames, at, data)))
                    reset = not data and frame.data == b"\0"
                    right = [f for f in said.above_info() if (f["code"], f["frame"]) == ("HBT006", at + 1)]
                    assert right, f"{name} frame {at + 1}: {said.complaint()}"
                    assert reset or only(said, "HBT006"), f"{name} frame {at + 1}: {said.complaint()}"


@pytest.mark.parametrize("bits", [0x80, 0xFF])
def test_bit_7_of_one_heartbeat(bits: int) -> None:
    for name in ("states", "stopped", "event_driven"):
        frames = session(name)
        beats = [at for at, frame in enumerate(frames) if frame.can_id == 0x705]
        for at in beats[:-5]:
            said = analyze(log_text(with_data(frames, at, bytes([frames[at].data[0] | bits]))))
            codes = "HBT003 NMT002" if frames[at].data == b"\0" else "HBT003"
            loud = said.above_info()
            assert {f["code"] for f in loud} <= set(codes.split()), f"{name} frame {at + 1}: {said.complaint()}"
            assert any((f["code"], f["frame"]) == ("HBT003", at + 1) for f in loud), f"{name} frame {at + 1}"


def test_toggle_of_guarding_where_the_requests_were_not_recorded() -> None:
    net = Network().boot(5)
    net.now = 0.05
    frames = [frame for frame in net.guarding(5, period=0.1, count=12).frames() if not frame.remote]
    assert not analyze(log_text(frames)).findings
    for at in range(4, len(frames) - 1):
        assert only(analyze(log_text(flipped(frames, at, 0, 0x80))), "GRD001", frame=at + 1), at


@pytest.mark.parametrize("command", [b"\x01\x05\x00", b"\x01\x05".ljust(8, b"\0"), b"\x33\x05", b"\x01\x85"])
def test_what_follows_from_a_broken_command(command: bytes) -> None:
    frames = session("states")
    at = find(frames, 0x000, 0)
    assert only(analyze(log_text(with_data(frames, at, command))), "NMT001", frame=at + 1)
    at = find(frames, 0x000, 1)
    assert only(analyze(log_text(with_data(frames, at, command))), "NMT001", frame=at + 1)


def test_one_heartbeat_with_another_state_while_pdos_go_on() -> None:
    net = Network().boot(5).write(5, 0x1017, 0, 100, 2).nmt(START, 5)
    net.live(5, period=0.1, seconds=1.0, states=[(0, OPERATIONAL)])
    frames = net.cyclic(0x185, period=0.01, payloads=[bytes([k]) for k in range(95)]).frames()
    for number in range(3, 8):
        at = find(frames, 0x705, number)
        assert only(analyze(log_text(with_data(frames, at, b"\x7f"))), "NMT004", frame=at + 1)


def test_one_time_that_is_wrong() -> None:
    frames = session("times")
    for number in range(1, 6):
        at = find(frames, 0x100, number)
        assert only(analyze(log_text(flipped(frames, at, 4, 1))), "TIM002", frame=at + 1)


def test_lengths_and_counters_of_sync() -> None:
    for name, data in (("sync_alone", b"\0"), ("synchronous", b"\x05"), ("synchronous_counted", b"")):
        frames = session(name)
        at = find(frames, 0x080, 30)
        assert only(analyze(log_text(with_data(frames, at, data))), "SYN001", frame=at + 1)
    frames = session("synchronous_counted")
    at = find(frames, 0x080, 30)
    said = analyze(log_text([frame for i, frame in enumerate(frames) if not at <= i < at + 2]))
    assert only(said, "SYN002"), said.complaint()
    net = Network().boot(5).write(5, 0x1019, 0, 10, 1).nmt(PRE_OP).wait(0.01)
    frames = net.sync(period=0.01, count=60).frames()
    assert only(analyze(log_text(frames)), "SYN001", frame=find(frames, 0x080, 0) + 1)


def test_lss_answers_that_never_come_or_cannot_be_read() -> None:
    frames = session("lss_configured")
    for number in range(4):
        at = find(frames, 0x7E4, number)
        assert only(analyze(log_text(without(frames, at))), "LSS009", frame=at), number
        said = analyze(log_text(with_data(frames, at, b"\x99".ljust(8, b"\0"))))
        assert only(said, "LSS001", frame=at + 1), said.complaint()
    for at, frame in enumerate(frames):
        if frame.can_id == 0x7E5:
            said = analyze(log_text(with_data(frames, at, b"\x99".ljust(8, b"\0"))))
            assert only(said, "LSS001", frame=at + 1), said.complaint()
    frames = session("lss_bit_timing")
    at = find(frames, 0x7E5, 1)
    assert only(analyze(log_text(with_data(frames, at, frames[at].data[:7]))), "LSS001", frame=at + 1)


def test_lengths_of_what_every_device_has() -> None:
    """CiA 301 gives 1017h two bytes; no description is needed to say so."""
    wrong = Network().boot(5).write(5, 0x2000, 0, 1, 1).write(5, 0x1017, 0, 100, 4).read(5, 0x1000, 0, 0x191, 4)
    assert only(analyze(log_text(wrong.frames())), "SDO013", frame=4)
    wrong = Network().boot(5).read(5, 0x1001, 0, 0, 1).read(5, 0x1017, 0, 100, 4).read(5, 0x1000, 0, 0x191, 4)
    assert only(analyze(log_text(wrong.frames())), "SDO013", frame=5)
    wrong = Network().boot(5).read(5, 0x1000, 0, 0x191, 3)
    assert only(analyze(log_text(wrong.frames())), "SDO013", frame=3)
    net = Network().boot(5).write(5, 0x1017, 0, 100, 2).read(5, 0x1000, 0, 0x191, 4).read(5, 0x2017, 0, 1, 4)
    assert not analyze(log_text(net.frames())).findings
    # Who always sends four bytes does it with all of them, and means no harm.
    net = Network().boot(5).write(5, 0x1017, 0, 100, 4).read(5, 0x1017, 0, 100, 4).read(5, 0x1001, 0, 0, 4)
    assert not analyze(log_text(net.frames())).findings


def test_heartbeats_slower_than_1017h() -> None:
    net = Network().boot(5).write(5, 0x1017, 0, 100, 2)
    net.live(5, period=0.2, seconds=2.0, states=[(0, PRE_OPERATIONAL)])
    assert only(analyze(log_text(net.frames())), "HBT001")


@pytest.mark.parametrize(
    ("count", "before_ms", "said"), [(1, 40, ["PDO002"]), (5, 40, ["PDO002"]), (6, 40, []), (30, 40, []), (1, 5, [])]
)
def test_tpdos_between_a_boot_up_and_the_start(count: int, before_ms: int, said: list[str]) -> None:
    """A few are a fault; a node that sends many has started itself, and the command may be listed late."""
    start = (count * 20 + before_ms) * 1000
    frames = [CanFrame("can0", 0x705, b"\0", 0), CanFrame("can0", 0x000, b"\x01\x00", start)]
    frames += [CanFrame("can0", 0x185, b"\x07", (place + 1) * 20_000) for place in range(count)]
    frames += [CanFrame("can0", 0x185, b"\x07", start + (place + 1) * 20_000) for place in range(5)]
    output = session_output([log_text(sorted(frames, key=lambda frame: frame.t_us))], output_format="check")
    rows = [json.loads(line) for line in output.decode().splitlines()]
    assert [row["code"] for row in rows if row["kind"] == "finding" and row["severity"] != "info"] == said
