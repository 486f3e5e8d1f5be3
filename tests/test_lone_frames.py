"""SDO frames that stand alone, or behind an abort: what they can be, and when that is decided.

What it must not do: cut sessions at random, which `test_excerpts` does.
"""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from captures import Analysis, CanFrame, analyze, log_text, spaced
from sdo_wire import Channel, block_download, segmented_download

CHANNEL = Channel(5)
REQUEST, RESPONSE = CHANNEL.client, CHANNEL.server
ALONE = {
    "end of a block download": (REQUEST(bytes([0xC1, *bytes(7)])), "end_block_download_request"),
    "end of a block upload": (RESPONSE(bytes([0xC1, *bytes(7)])), "end_block_upload_request"),
    "confirmation by the server": (RESPONSE(bytes([0xA1, *bytes(7)])), "end_block_download_response"),
    "confirmation by the client": (REQUEST(bytes([0xA1, *bytes(7)])), "end_block_upload_response"),
    "start of a block upload": (REQUEST(bytes([0xA3, *bytes(7)])), "start_block_upload"),
}
"""Frames that are a segment of zeros as well."""


def said_of(*frames: CanFrame) -> Analysis:
    return analyze(log_text(spaced(frames)))


def commands(said: Analysis) -> list[str]:
    return [row["sdo"]["command"] for row in said.frames]


@pytest.mark.parametrize("name", ALONE)
def test_a_frame_that_may_be_a_segment_is_undetermined(name: str) -> None:
    frame, _ = ALONE[name]
    said = said_of(frame)
    assert commands(said) == ["undetermined"]
    assert not said.findings and not said.transfers


@pytest.mark.parametrize(
    ("first", "then"),
    [
        ("end of a block download", RESPONSE(bytes([0xA1, *bytes(7)]))),
        ("end of a block upload", REQUEST(bytes([0xA1, *bytes(7)]))),
        ("start of a block upload", RESPONSE(bytes([0x01, *bytes(7)]))),
    ],
)
def test_the_next_frame_decides(first: str, then: CanFrame) -> None:
    frame, command = ALONE[first]
    said = said_of(frame, then)
    assert commands(said)[0] == command
    assert not said.findings, "two frames of SDO are no other protocol"


@pytest.mark.parametrize("heads", [(6, 7), (6, 0x87), (0x86,), (6, 7, 8, 9, 0x8A)], ids=str)
@pytest.mark.parametrize("sent", [1, 5])
def test_segments_under_way_when_the_server_aborted(sent: int, heads: Sequence[int]) -> None:
    """They are segments that go on, whatever command their first byte is."""
    begun = block_download(CHANNEL, 0x1F50, 1, bytes(range(200)))[: 2 + sent]
    abort = RESPONSE(bytes.fromhex("80501F0100000405"))
    shift = sent - 5
    late = [REQUEST(bytes([head + shift, *range(7)])) for head in heads]
    said = said_of(*begun, abort, *late)
    assert commands(said)[2 + sent + 1 :] == ["block_segment"] * len(late)
    assert {row["sdo"]["place"] for row in said.frames[2 + sent + 1 :]} == {"in_flight"}
    assert [row["code"] for row in said.findings] == ["SDO017"]
    assert [row["status"] for row in said.transfers] == ["aborted"]


@pytest.mark.parametrize("head", [0x2F, 0x40, 0x60], ids=hex)
def test_a_request_behind_an_abort_is_a_request(head: int) -> None:
    begun = block_download(CHANNEL, 0x1F50, 1, bytes(range(200)))[:7]
    abort = RESPONSE(bytes.fromhex("80501F0100000405"))
    said = said_of(*begun, abort, REQUEST(bytes([head, 0x00, 0x20, 0, 1, 0, 0, 0])))
    assert commands(said)[-1] != "block_segment"


def test_an_abort_behind_a_lone_frame_does_not_say_what_that_was() -> None:
    segment = segmented_download(CHANNEL, 0x2000, 0, bytes(range(30)))[4]
    for by in (REQUEST, RESPONSE):
        said = said_of(segment, by(bytes.fromhex("8000200000000405")))
        assert commands(said)[0] == "undetermined"
        assert not [row for row in said.transfers if row["data"]]
