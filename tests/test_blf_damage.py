"""Damaged BLF files: every frame that is lost is reported, none is invented, and reading goes on behind the damage."""

import random
import re
import struct
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from test_pythoncan import blf_object, given, session, stored, written

Frames = list[dict[str, Any]]
PLAIN, PACKED = 0, 6


def recording(tmp_path: Path, level: int) -> tuple[bytes, Frames]:
    """A BLF of many containers, packed or not, and its frames."""
    messages = [message for _ in range(4) for message in session()]
    for number, message in enumerate(messages):
        message.timestamp = 1_700_000_000 + number * 0.001_003
    path = written("blf", tmp_path / "whole.blf", messages, max_container_size=1200, compression_level=level)
    data = path.read_bytes()
    frames, complaints = given(data, "blf")
    assert (len(frames), complaints) == (len(messages), [])
    return data, frames


def same(frame: dict[str, Any]) -> tuple[Any, ...]:
    """What tells a frame from others."""
    return tuple(map(str, frame.values()))


def compared(data: bytes, frames: Frames, step: int = 1 << 20) -> tuple[int, int, list[str]]:
    """Read a damaged file: frames that are gone, frames that the whole file has not, and what was said."""
    read, complaints = given(data, "blf", step)
    before, after = Counter(map(same, frames)), Counter(map(same, read))
    return (before - after).total(), (after - before).total(), complaints


@pytest.mark.parametrize("level", [PLAIN, PACKED])
@pytest.mark.parametrize("kind", ["zeros", "garbage", "removed"])
def test_blocks_that_are_lost(tmp_path: Path, level: int, kind: str) -> None:
    data, frames = recording(tmp_path, level)
    rng = random.Random(17)
    for _ in range(150):
        at = rng.randrange(144, len(data) - 1)
        size = rng.choice((1, 2, 3, 4, 5, 8, 17, 48, 100, 512, 2000))
        if kind == "garbage":
            changed = data[:at] + rng.randbytes(size) + data[at:]
        else:
            changed = data[:at] + bytes(size if kind == "zeros" else 0) + data[at + size :]
        gone, invented, complaints = compared(changed, frames, rng.choice((100, 1 << 20)))
        where = (at, size, gone, invented, complaints)
        assert gone == invented or complaints, where
        # A few bytes within a frame may be no more than other data: only the format's check sums would show them.
        within = size <= (4 if kind == "garbage" else 48) and level == PLAIN
        assert invented == 0 or (within and invented == 1), where
        assert gone <= (size // 48 + 4 if level == PLAIN else size // 100 * 14 + 45), where


@pytest.mark.parametrize("level", [PLAIN, PACKED])
def test_bytes_that_are_flipped(tmp_path: Path, level: int) -> None:
    data, frames = recording(tmp_path, level)
    passed_over = 0
    rng = random.Random(3)
    for _ in range(400):
        at = rng.randrange(144, len(data))
        gone, invented, complaints = compared(
            data[:at] + bytes([data[at] ^ rng.randrange(1, 256)]) + data[at + 1 :], frames
        )
        assert invented <= (1 if level == PLAIN else 0), (at, complaints)
        # A type that exists is that of another object, which is counted as passed over.
        if gone > invented and not complaints:
            assert (level, data.rfind(b"LOBJ", 0, at)) == (PLAIN, at - 12), at
            passed_over += 1
    assert passed_over <= 5


@pytest.mark.parametrize("zeros", [5, 16, 512, 5000])
def test_zeros_at_the_end_are_no_padding(tmp_path: Path, zeros: int) -> None:
    data, frames = recording(tmp_path, PACKED)
    gone, invented, complaints = compared(data.rstrip(b"\0") + bytes(zeros + 4), frames)
    assert (gone, invented, len(complaints)) == (0, 0, 1)
    assert f"{zeros}" in complaints[0] or f"{zeros + 4}" in complaints[0]
    assert compared(data + bytes(3 - len(data) % 4), frames) == (0, 0, [])


def test_the_place_and_the_bytes_are_told(tmp_path: Path) -> None:
    data, frames = recording(tmp_path, PLAIN)
    heads = [found.start() for found in re.finditer(rb"LOBJ\x20\0", data)]
    begin, end = heads[60], heads[64]
    gone, invented, complaints = compared(data[:begin] + bytes(end - begin) + data[end:], frames)
    assert (gone, invented, len(complaints)) == (5, 0, 1)  # the damage may begin in the one before
    (place, size) = map(int, re.findall(r"byte (\d+):.* (\d+) bytes", complaints[0])[0])
    assert place == heads[59]
    assert place + size == end


def test_stray_bytes_between_two_recordings(tmp_path: Path) -> None:
    data, frames = recording(tmp_path, PACKED)
    stray = struct.pack("<4sHHLLH6xL4x", b"LOBJ", 16, 1, 36, 10, 0, 4) + b"\1\2\3\4"
    gone, invented, complaints = compared(data + bytes(-len(data) % 4) + stray + data[144:], frames)
    assert (gone, invented) == (0, len(frames))
    assert len(complaints) == 1
    assert " 4 bytes" in complaints[0]


@pytest.mark.parametrize("kind", [0, 65, 255, 256, 1 << 30])
def test_an_object_whose_size_leads_far_swallows_nothing(kind: int) -> None:
    good = blf_object(1, bytes.fromhex("0100 00 01 01070000 0500000000000000"))
    whole = stored(good * 20)
    containers = whole[144:] * 10
    bad = stored(good, blf_object(kind, bytes(20), size=1_000_000))
    read, complaints = given(bad + containers, "blf")
    assert len(read) == 201
    assert len(complaints) == 1
    assert f" {32 + 20} bytes" in complaints[0]


def test_a_large_object_of_another_type_runs_on_over_containers() -> None:
    good = blf_object(1, bytes.fromhex("0100 00 01 01070000 0500000000000000"))
    large = blf_object(65, random.Random(1).randbytes(100_000))
    inner = good + large + good
    data = stored()[:144]
    for at in range(0, len(inner), 7001):
        data += stored(inner[at : at + 7001])[144:] + bytes(-(32 + len(inner[at : at + 7001])) % 4)
    read, complaints = given(data, "blf", 1000)
    assert (len(read), complaints) == (2, [])
