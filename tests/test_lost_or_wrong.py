"""Frames that the recording lost, and frames that are wrong: what looks alike within a transfer, over all places.

A jump of the toggle bit or of the sequence number is the same frame by frame. The end of the transfer tells: where both
sides took it as done and bytes lack, the recording lost frames, and nobody is accused. Where all bytes are there, the
frame was wrong.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest
from captures import Analysis, CanFrame, analyze, log_text, spaced
from sdo_wire import Channel, block_download, block_upload, expedited_upload, segmented_download, segmented_upload

NODE = Channel(10)
DATA = bytes(range(1, 141))
"""140 bytes: twenty segments."""
EXCHANGE = expedited_upload(NODE, 0x1018, 4, bytes(range(4)))
SEGMENTED = {"upload": segmented_upload, "download": segmented_download}
BLOCK = {"upload": block_upload, "download": block_download}


def said(transfer: list[CanFrame]) -> Analysis:
    """The output for a transfer between others."""
    return analyze(log_text(spaced(2 * EXCHANGE + transfer + 2 * EXCHANGE)))


def changed(frame: CanFrame, bits: int) -> CanFrame:
    """The frame with these bits of its first byte inverted."""
    return replace(frame, data=bytes([frame.data[0] ^ bits]) + frame.data[1:])


def accused(result: Analysis) -> set[str]:
    """The codes above info that blame somebody."""
    return {finding["code"] for finding in result.above_info()} - {"SDO024"}


def lost_exchanges() -> Iterator[tuple[str, int, int]]:
    """The direction, the first segment that is not recorded, and how many."""
    for way in SEGMENTED:
        for count in (1, 3, 5, 9):
            yield from ((way, first, count) for first in range(19 - count))


@pytest.mark.parametrize(("way", "first", "count"), list(lost_exchanges()))
def test_lost_segments_of_a_segmented_transfer_accuse_nobody(way: str, first: int, count: int) -> None:
    """An odd number of them: an even one leaves the toggle bits as they were."""
    whole = SEGMENTED[way](NODE, 0x2000, 1, DATA)
    result = said(whole[: 2 + 2 * first] + whole[2 + 2 * (first + count) :])
    assert not accused(result), result.complaint()
    assert [f["facts"].get("missing") for f in result.above_info()] == [count], result.complaint()
    assert result.transfers[2]["status"] == "incomplete"


@pytest.mark.parametrize("side", [0, 1], ids=["client", "server"])
@pytest.mark.parametrize("segment", range(1, 19))
@pytest.mark.parametrize("way", SEGMENTED)
def test_a_wrong_toggle_bit_is_an_error(way: str, segment: int, side: int) -> None:
    whole = SEGMENTED[way](NODE, 0x2000, 1, DATA)
    at = 2 + 2 * segment + side
    whole[at] = changed(whole[at], 0x10)
    result = said(whole)
    assert "SDO001" in accused(result), result.complaint()
    assert not [f for f in result.findings if f["code"] == "SDO024"]


def segments(frames: list[CanFrame], way: str) -> list[int]:
    """Where the segments of a block transfer stand."""
    sender = 0x58A if way == "upload" else 0x60A
    inner = range(3 if way == "upload" else 2, len(frames) - 2)
    return [at for at in inner if frames[at].can_id == sender]


def lost_segments() -> Iterator[tuple[str, int, int]]:
    """The direction, the first segment that is not recorded, and how many; none across a sub-block of ten."""
    for way in BLOCK:
        for count in (1, 2, 4, 8):
            yield from ((way, first, count) for first in range(20) if first % 10 + count < 10)


@pytest.mark.parametrize(("way", "first", "count"), list(lost_segments()))
def test_lost_segments_of_a_block_transfer_accuse_nobody(way: str, first: int, count: int) -> None:
    whole = BLOCK[way](NODE, 0x2000, 1, DATA, blksize=10)
    gone = set(segments(whole, way)[first : first + count])
    result = said([frame for at, frame in enumerate(whole) if at not in gone])
    assert not accused(result), result.complaint()
    assert [f["facts"].get("missing") for f in result.above_info()] == [count], result.complaint()
    (transfer,) = [row for row in result.transfers if row["index"] == "2000"]
    assert transfer["status"] == "incomplete"
    assert transfer["holes"] == [{"offset": 7 * first, "length": 7 * count}]


@pytest.mark.parametrize("bits", [0x01, 0x02, 0x04, 0x08, 0x10])
@pytest.mark.parametrize("segment", range(20))
@pytest.mark.parametrize("way", BLOCK)
def test_a_wrong_sequence_number_is_an_error(way: str, segment: int, bits: int) -> None:
    whole = BLOCK[way](NODE, 0x2000, 1, DATA, blksize=10)
    at = segments(whole, way)[segment]
    whole[at] = changed(whole[at], bits)
    result = said(whole)
    assert accused(result), result.complaint()


@pytest.mark.parametrize("count", [2, 4, 8])
@pytest.mark.parametrize("first", range(1, 11))
@pytest.mark.parametrize("way", SEGMENTED)
def test_an_even_number_of_lost_segments_leaves_its_time(way: str, first: int, count: int) -> None:
    """The toggle bits stay as they were; without the time it is a wrong size."""
    whole = SEGMENTED[way](NODE, 0x2000, 1, DATA)
    frames = 2 * EXCHANGE + whole + 2 * EXCHANGE
    gone = range(4 + 2 + 2 * first, 4 + 2 + 2 * (first + count))
    result = analyze(log_text(frame for at, frame in enumerate(spaced(frames)) if at not in gone))
    assert not accused(result), result.complaint()
    assert [f["facts"].get("missing") for f in result.above_info()] == [count], result.complaint()
    assert result.transfers[2]["status"] == "incomplete"
    assert result.transfers[2]["holes"] == [{"offset": 7 * first, "length": 7 * count}]
    at_once = analyze(log_text(spaced(frame for at, frame in enumerate(frames) if at not in gone)))
    assert accused(at_once) == {"SDO006"}, at_once.complaint()


@pytest.mark.parametrize("more", [7, 14, 28, 70])
@pytest.mark.parametrize("longest", [1.0, 1.4, 1.9])
@pytest.mark.parametrize("way", SEGMENTED)
def test_a_wrong_size_is_an_error_at_any_pace(way: str, longest: float, more: int) -> None:
    """One exchange takes longer than the others, as on any host."""
    whole = SEGMENTED[way](NODE, 0x2000, 1, DATA)
    at = 1 if way == "upload" else 0
    whole[at] = replace(whole[at], data=whole[at].data[:4] + (len(DATA) + more).to_bytes(4, "little"))
    frames = spaced(2 * EXCHANGE + whole + 2 * EXCHANGE)
    late = [
        replace(frame, t_us=frame.t_us + int((longest - 1) * 800) * (place > 20)) for place, frame in enumerate(frames)
    ]
    result = analyze(log_text(late))
    assert "SDO006" in accused(result), result.complaint()
