"""Frames of a server that no request asks for: single ones, floods, late answers and duplicates.

A flood is one finding with its count, and its bytes are never data of the transfer that runs. Beside it what looks
alike and is none: responses whose requests are not in the capture, and segments under way when a transfer was aborted.
"""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable
from dataclasses import replace

import pytest
from captures import Analysis, CanFrame, Row, analyze, console_text, log_text, session_output, spaced
from network import Network
from sdo_wire import Channel, abort, expedited_upload, segmented_download, segmented_upload

NODE = Channel(5)
EXCHANGE = expedited_upload(NODE, 0x1018, 4, bytes(range(4)))
DOWNLOAD = segmented_download(NODE, 0x2000, 1, bytes(range(64)))

ODD = {
    "same segment": lambda number: bytes([0x00, 0x20, 0, 0, 0, 0, 0, 0]),
    "segments": lambda number: bytes([0x10 * (number % 2), 0, 0, 0x20, 0, 0, 0x30, 0]),
    "same response": lambda number: struct.pack("<BHBI", 0x43, 0x1018, 2, 7),
    "confirmations": lambda number: b"\x60\x00\x20\x01",
    "bytes without order": lambda number: random.Random(number).randbytes(3).rjust(8, b"\0"),
}


def flood(payload: Callable[[int], bytes], frames: int) -> list[CanFrame]:
    """Frames of the server in a row."""
    return [NODE.server(payload(number)) for number in range(frames)]


def floods(said: Analysis) -> list[tuple[int, int]]:
    """Of each flood its first frame and its count."""
    return [(f["frame"], f["facts"]["frames"]) for f in said.findings if f["facts"].get("flood")]


@pytest.mark.parametrize("frames", [4, 6, 33, 100, 500])
@pytest.mark.parametrize("kind", ODD)
@pytest.mark.parametrize("stamps", [True, False])
def test_a_flood_between_transfers_is_one_finding(kind: str, frames: int, stamps: bool) -> None:
    capture = 3 * EXCHANGE + flood(ODD[kind], frames) + 3 * EXCHANGE
    said = analyze(log_text(spaced(capture)) if stamps else console_text(capture))
    assert floods(said) == [(7, frames)], said.complaint()
    assert len(said.above_info()) == 1, said.complaint()
    assert len(said.transfers) == 6


@pytest.mark.parametrize("frames", [4, 10, 40])
@pytest.mark.parametrize("kind", ["same segment", "bytes without order"])
@pytest.mark.parametrize("at", [4, 6, 8])
def test_a_flood_is_no_data_of_a_download(kind: str, frames: int, at: int) -> None:
    """The value is what the client sent, and no line shows a segment of the server."""
    capture = 2 * EXCHANGE + DOWNLOAD[:at] + flood(ODD[kind], frames) + DOWNLOAD[at:]
    said = analyze(log_text(spaced(capture)))
    assert floods(said) == [(4 + at + 1, frames)], said.complaint()
    assert [f["code"] for f in said.above_info()] == ["SDO002"], said.complaint()
    assert said.transfers[2]["data"] == bytes(range(64)).hex().upper()
    words = [row["sdo"]["command"] for row in said.frames[4 + at : 4 + at + frames]]
    assert set(words) == {"undetermined"}, words


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_a_few_are_no_flood(frames: int) -> None:
    said = analyze(log_text(spaced(3 * EXCHANGE + flood(ODD["confirmations"], frames) + EXCHANGE)))
    assert not floods(said)
    assert [(f["code"], f["frame"]) for f in said.above_info()] == [("SDO002", 7)], said.complaint()


@pytest.mark.parametrize("apart_ms", [100, 1000])
def test_frames_far_apart_are_no_flood(apart_ms: int) -> None:
    before = spaced(3 * EXCHANGE)
    behind = spaced(flood(ODD["same response"], 20), start_us=1_700_000_001_000_000, step_us=1000 * apart_ms)
    said = analyze(log_text(before + behind))
    assert not floods(said)
    assert said.above_info(), "a response without a request is a finding all the same"


def told_at(capture: list[CanFrame], frame: int) -> list[Row]:
    """What was reported before the line of a frame is written."""
    rows = [json.loads(line) for line in session_output([log_text(capture)], output_format="jsonl").splitlines()]
    behind = next(at for at, row in enumerate(rows) if row["kind"] == "frame" and row["frame"] > frame)
    return [row for row in rows[:behind] if row["kind"] == "finding"]


BEATS = [replace(NODE.server(b"\x05"), can_id=0x706)] * 140


@pytest.mark.parametrize("frames", [1, 3, 4, 20, 64])
def test_what_nobody_asked_for_is_reported_though_the_client_is_silent(frames: int) -> None:
    """Other frames of the bus tell that time passes: a request is answered sooner than they come."""
    before = spaced(4 * EXCHANGE + flood(ODD["confirmations"], frames))
    assert before[-1].t_us is not None
    capture = before + spaced(BEATS, start_us=before[-1].t_us + 10_000, step_us=10_000)
    said = told_at(capture, 8 + frames + 102)
    assert [(f["code"], f["facts"].get("frames")) for f in said if f["severity"] != "info"] == [
        ("SDO002", frames if frames >= 4 else None)
    ], said
    assert len(analyze(log_text(capture)).above_info()) == 1


@pytest.mark.parametrize("step_ms", [1, 10, 40])
def test_a_flood_that_lasts_is_reported_while_it_runs(step_ms: int) -> None:
    frames = 3000 // step_ms
    before = spaced(4 * EXCHANGE)
    assert before[-1].t_us is not None
    odd = spaced(flood(ODD["same segment"], frames), start_us=before[-1].t_us + 5000, step_us=1000 * step_ms)
    first = [f for f in told_at(before + odd, 8 + 1200 // step_ms) if f["severity"] != "info"]
    assert [f["frame"] for f in first] == [9] and first[0]["facts"]["flood"], first
    said = analyze(log_text(before + odd))
    assert [f["code"] for f in said.above_info()] == ["SDO002"], said.complaint()
    whole = [f for f in said.findings if f["facts"].get("flood") and f["severity"] == "info"]
    assert [(f["facts"]["frames"], f["because_of"]) for f in whole] == [(frames, 9)], whole


@pytest.mark.parametrize("lost", [4, 20, 200])
def test_responses_whose_requests_are_not_recorded_are_no_flood(lost: int) -> None:
    """The recording lost the client's frames: each response is about another object, or is the next segment."""
    objects = [frame for number in range(lost) for frame in expedited_upload(NODE, 0x2000 + number, 0, b"\x01\x02")]
    upload = segmented_upload(NODE, 0x1008, 0, bytes(7 * lost))
    for whole, kept in ((objects, 0), (upload, 4)):
        responses = whole[:kept] + [frame for frame in whole[kept:] if frame.can_id == 0x585]
        said = analyze(log_text(spaced(3 * EXCHANGE + responses + 3 * EXCHANGE)))
        assert not floods(said), said.complaint()


def booted() -> Network:
    return Network().boot(5).read(5, 0x1000, 0, 0x191, 4).read(5, 0x1018, 4, 7, 4).wait(0.1)


def told(net: Network) -> list[tuple[str, str | None]]:
    """What is found, but that the node booted on its own."""
    said = analyze(log_text(net.read(5, 0x1018, 1, 5, 4).frames()))
    return [
        (f["code"], f["facts"].get("reason") or f["facts"].get("missing"))
        for f in said.above_info()
        if f["code"] != "NMT003"
    ]


READ = struct.pack("<BHB4x", 0x40, 0x1000, 0)
ANSWER = struct.pack("<BHBI", 0x43, 0x1000, 0, 0x191)


@pytest.mark.parametrize("wait", [0.001, 0.1, 0.9])
def test_an_answer_behind_the_boot_up_is_late(wait: float) -> None:
    net = booted().send(0x605, READ).wait(wait).boot(5).wait(0.001).send(0x585, ANSWER).wait(0.1)
    assert told(net) == [("SDO020", "boot_up")]


def test_an_answer_to_a_request_behind_the_boot_up_is_none() -> None:
    net = booted().send(0x605, READ).wait(0.1).boot(5).wait(0.3)
    assert told(net.send(0x605, READ).wait(0.001).send(0x585, ANSWER).wait(0.1)) == []


def test_a_duplicate_behind_the_boot_up() -> None:
    net = booted().boot(5).wait(0.01).send(0x585, struct.pack("<BHBI", 0x43, 0x1018, 4, 7)).wait(0.1)
    assert told(net) == [("SDO002", "request")]


@pytest.mark.parametrize("wait", [0.02, 0.5, 5.0])
def test_the_same_abort_again(wait: float) -> None:
    """Without a frame of the client in between; with one it is the answer to that."""
    refused = abort(0x1000, 0, 0x06020000)
    net = booted().send(0x605, READ).wait(0.001).send(0x585, refused).wait(wait)
    assert told(net.send(0x585, refused).wait(0.1)) == [("SDO002", "request")]
    net = booted().send(0x605, READ).wait(0.001).send(0x585, refused).wait(wait)
    assert told(net.send(0x605, READ).wait(0.001).send(0x585, refused).wait(0.1)) == []


def test_two_requests_that_are_refused_are_no_duplicate() -> None:
    """The client asked twice before the server refused both."""
    refused = abort(0x1000, 0, 0x06020000)
    net = booted().send(0x605, READ).wait(0.002).send(0x605, READ).wait(0.001)
    net.send(0x585, refused).wait(0.002).send(0x585, refused).wait(0.1)
    assert "SDO002" not in {code for code, _ in told(net)}


@pytest.mark.parametrize("wait", [0.002, 0.1, 0.9])
def test_a_request_is_not_answered_by_the_response_before_the_refusal(wait: float) -> None:
    """The capture begins with the response to an earlier request for the object."""
    net = Network().send(0x585, ANSWER).wait(wait).send(0x605, READ).wait(0.001)
    said = analyze(log_text(net.send(0x585, abort(0x1000, 0, 0x06020000)).wait(0.1).read(5, 0x1018, 1, 5, 4).frames()))
    assert [row["status"] for row in said.transfers if row["first_frame"] == 2] == ["aborted"], said.transfers
