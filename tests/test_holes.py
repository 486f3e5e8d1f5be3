"""What is missing of a transfer: in JSON, in words, in Python, and in the files that `--extract` writes.

Sessions are made of values and cut; what is said of their bytes has to agree with the values: no byte stands where it
does not belong, nothing that was seen is left out, and no file looks whole that is not.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from captures import CanFrame, Row, analyze, log_text
from conftest import Runner
from sdo_wire import (
    Channel,
    block_download,
    block_upload,
    expedited_download,
    expedited_upload,
    is_client,
    segmented_download,
    segmented_upload,
)

import canalyze as library

CHANNEL = Channel(10)
DATA = bytes(range(1, 101))
"""100 bytes, each another one: fifteen segments, the last one with two bytes."""
OBJECT = (0x2000, 1)
KINDS: dict[str, Callable[..., list[CanFrame]]] = {
    "segmented upload": segmented_upload,
    "segmented download": segmented_download,
    "block upload": block_upload,
    "block download": block_download,
}


def transfer(kind: str) -> list[CanFrame]:
    """The transfer of the data: blocks of six segments."""
    options = {"blksize": 6} if kind.startswith("block") else {}
    before = expedited_upload(CHANNEL, 0x1000, 0, b"\x92\x01\x02\x00")
    frames = KINDS[kind](CHANNEL, *OBJECT, DATA, **options)
    return [replace(frame, t_us=1000 * place) for place, frame in enumerate([*before, *frames])]


def carries(kind: str, frame: CanFrame) -> bool:
    """Whether a frame has bytes of the data."""
    block = kind.startswith("block")
    first = frame.data[0]
    sender = is_client(frame) == kind.endswith("download")
    return sender and (first & 0x7F in range(1, 7) and frame.data[1] != 0 if block else first >> 5 == 0)


def seen(kind: str, frames: Sequence[CanFrame]) -> set[int]:
    """The bytes of the data that frames have: each occurs once."""
    return {byte for frame in frames if carries(kind, frame) for byte in frame.data[1:]} - {0}


def log(frames: Sequence[CanFrame], lost: int | None = None) -> bytes:
    """A candump log; frames are dropped before this place."""
    if lost is None:
        return log_text(frames)
    return (
        log_text(frames[:lost])
        + b"DROPCOUNT: dropped 2 CAN frames on 'can0' socket (total drops 2)\n"
        + log_text(frames[lost:])
    )


def placed(row: Row) -> set[int]:
    """The bytes that a transfer is said to have; asserts that each whose place is known stands there."""
    data, holes = bytes.fromhex(row["data"]), row.get("holes", [])
    assert len(data) == row["size"]
    gone = {at for hole in holes if hole["length"] for at in range(hole["offset"], hole["offset"] + hole["length"])}
    assert all(data[at] == 0 for at in gone if at < len(data))
    known = min((hole["offset"] for hole in holes if hole["length"] is None), default=len(data))
    for at, byte in enumerate(data):
        if at not in gone and at < known:
            assert byte == DATA[at], row
    return {data[at] for at in range(len(data)) if at not in gone}


def moved(text: bytes) -> list[Row]:
    """The transfers of the data."""
    return [row for row in analyze(text).transfers if row["index"] != "1000"]


def test_what_one_missing_segment_leaves() -> None:
    """Segment 2 of the first sub-block: the acknowledgement shows that it was sent."""
    frames = [frame for frame in transfer("block upload") if frame.data[:2] != b"\x02\x08"]
    (row,) = moved(log(frames))
    assert row["holes"] == [{"offset": 7, "length": 7}]
    assert (row["status"], row["size"], row["size_indicated"]) == ("incomplete", 100, 100)
    assert placed(row) == set(DATA) - set(DATA[7:14])
    assert row["text"].startswith("01 02 03 04 05 06 07 .. .. .. .. .. .. .. 0F ")
    assert row["text"].endswith(" ... [missing: 7 bytes at offset 7]")
    (row,) = [row for row in analyze(log(frames), lang="zh").transfers if row["index"] != "1000"]
    assert row["text"].endswith(" ... [缺失: 偏移7起7字节]")


def test_the_last_segment_is_missing() -> None:
    """The end frame tells how many bytes it had."""
    frames = [frame for frame in transfer("block upload") if frame.data[:2] != b"\x83\x63"]
    (row,) = moved(log(frames))
    assert (row["size"], row["holes"]) == (98, [{"offset": 98, "length": 2}])


def test_a_whole_transfer_has_no_holes() -> None:
    for kind in KINDS:
        (row,) = moved(log(transfer(kind)))
        assert row["status"] == "ok" and "holes" not in row


@pytest.mark.parametrize("kind", list(KINDS))
def test_the_capture_ends(kind: str) -> None:
    """All bytes that were seen stand at their place, and how many are missing is told."""
    frames = transfer(kind)
    for end in range(5, len(frames)):
        (row,) = moved(log(frames[:end]))
        assert row["status"] == "incomplete"
        assert placed(row) == seen(kind, frames[:end]), end
        missing = [{"offset": row["size"], "length": 100 - row["size"]}] if 0 < row["size"] < 100 else []
        assert row.get("holes", []) == missing, end


@pytest.mark.parametrize("kind", list(KINDS))
def test_the_capture_begins(kind: str) -> None:
    """The offset of what comes first is not known, and is not told."""
    frames = transfer(kind)
    first = next(place for place, frame in enumerate(frames) if carries(kind, frame))
    for begin in range(first + 1, len(frames) - 8):
        rows = moved(log(frames[begin:]))
        assert all(row["index"] is None and row["status"] == "incomplete" for row in rows), begin
        for row in rows:
            assert bytes.fromhex(row["data"]) in DATA
            assert not row["size"] or row["holes"][0] == {"offset": 0, "length": None}
        told = set[int]().union(*(placed(row) for row in rows))
        assert told <= seen(kind, frames[begin:])
        assert seen(kind, frames[begin + 3 :]) <= told, begin


@pytest.mark.parametrize("kind", list(KINDS))
def test_frames_were_dropped(kind: str) -> None:
    """Before the loss the places are known, behind it they are not."""
    frames = transfer(kind)
    for place in range(7, len(frames) - 6):
        rows = moved(log([*frames[:place], *frames[place + 2 :]], place))
        before = next(row for row in rows if row["index"] is not None)
        assert before["status"] == "incomplete"
        assert placed(before) == seen(kind, frames[:place]), place
        for row in rows:
            assert bytes.fromhex(row["data"]) in DATA


def test_a_response_is_missing_in_segments() -> None:
    """Its segment is measured by the size, once the last one is seen."""
    frames = transfer("segmented upload")
    (row,) = moved(log([*frames[:7], *frames[8:]]))
    assert row["holes"] == [{"offset": 7, "length": 7}]
    assert placed(row) == set(DATA) - set(DATA[7:14])
    (row,) = moved(log([*frames[:7], *frames[8:20]]))
    assert row["holes"] == [{"offset": 7, "length": None}, {"offset": row["size"], "length": None}]
    assert row["text"].endswith("[missing: unknown number of bytes in between, end]")


def test_files_of_extract(canalyze: Runner, tmp_path: Path) -> None:
    """No file is empty of which bytes were seen, and none looks whole that is not."""
    for number, kind in enumerate(KINDS):
        frames = transfer(kind)
        for name, part in {"end": frames[:15], "begin": frames[9:]}.items():
            (tmp_path / "cut.log").write_bytes(log(part))
            out = tmp_path / f"{number}-{name}"
            canalyze("sdo", "--lang", "en", "cut.log", "--extract", str(out))
            files = {file.name: file.read_bytes() for file in out.iterdir() if "1000h" not in file.name}
            cut = {name: data for name, data in files.items() if name.endswith(".incomplete")}
            assert cut and set(files) == {*cut, *(f"{name}.holes.json" for name in cut)}
            for name, data in cut.items():
                holes = json.loads(files[f"{name}.holes.json"])
                assert data and data in DATA and holes["size"] == len(data)
                assert holes["holes"][-1 if DATA.startswith(data) else 0]["length"] in (None, 100 - len(data))


def test_a_hole_in_a_file(canalyze: Runner, tmp_path: Path) -> None:
    frames = [frame for frame in transfer("block download") if frame.data[:2] != b"\x02\x08"]
    (tmp_path / "hole.log").write_bytes(log(frames))
    said = canalyze("sdo", "--lang", "en", "hole.log", "--extract", "out")
    assert "1 of them with missing bytes, listed in .holes.json beside the file" in said.err
    assert (tmp_path / "out/00002_can0_node10_2000h_01.bin.incomplete").read_bytes() == DATA[:7] + bytes(7) + DATA[14:]
    beside = json.loads((tmp_path / "out/00002_can0_node10_2000h_01.bin.incomplete.holes.json").read_text())
    assert beside["holes"] == [{"offset": 7, "length": 7}]


def test_a_write_that_is_not_confirmed_is_no_empty_file(canalyze: Runner, tmp_path: Path) -> None:
    request, _ = expedited_download(CHANNEL, *OBJECT, b"\x40\x01")
    frames = [*expedited_upload(CHANNEL, 0x1000, 0, b"\x92\x01\x02\x00"), request]
    (tmp_path / "cut.log").write_bytes(log([replace(frame, t_us=1000 * at) for at, frame in enumerate(frames)]))
    canalyze("sdo", "cut.log", "--extract", "out")
    assert (tmp_path / "out/00002_can0_node10_2000h_01.bin.incomplete").read_bytes() == b"\x40\x01"


def test_the_library(tmp_path: Path) -> None:
    frames = [frame for frame in transfer("block upload") if frame.data[:2] != b"\x02\x08"]
    (tmp_path / "hole.log").write_bytes(log(frames))
    with library.open(tmp_path / "hole.log") as capture:
        first, second = capture.transfers
    assert first.holes == ()
    assert second.holes == (library.Hole(7, 7),)
