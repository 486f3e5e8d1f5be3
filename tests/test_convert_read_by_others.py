"""What `canalyze convert` writes, read back by other people's programs, frame by frame.

A row of `READERS` says which program reads which format, and what that program (not our file) cannot tell of a frame.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import can
import other_readers
import pytest
from capture_frames import Recorded, candump_text, from_start, read, run
from captures import SAMPLES
from other_readers import Read
from other_writers import run_program
from reader_suite import classic, every_kind, frames_of, random_session

CLASSIC = ("data", "remote", "error")
ALL = (*CLASSIC, "fd")


@dataclass(frozen=True, slots=True)
class Reader:
    """Another program that reads one of our formats."""

    suffix: str
    read: Read
    kinds: Sequence[str] = ALL
    """Kinds of frames that the format holds, and that program reads."""
    told: Callable[[Recorded], Recorded] = lambda frame: frame
    """What that program tells of a frame."""
    dated: bool = True
    """It tells stamps since 1970; else they are compared from the first frame on."""
    tolerance_ns: int = 0


def bare(frame: Recorded) -> Recorded:
    """Of an error frame only that there was one; it has no side."""
    if frame.kind != "error":
        return frame
    return replace(frame, can_id=0, data=b"", extended=False, sent=None)


def sideless(frame: Recorded) -> Recorded:
    """An error frame is nobody's: whether it has a side is the format's own affair."""
    return replace(frame, sent=None) if frame.kind == "error" else frame


def unnamed(frame: Recorded) -> Recorded:
    """Neither bus nor side."""
    return bare(replace(frame, bus="can0", sent=False))


def short(frame: Recorded) -> Recorded:
    """python-can's log reader: a remote frame's length is not read."""
    return replace(frame, asked=0)


def emptied(frame: Recorded) -> Recorded:
    """python-can's ASC reader: a frame of CAN FD without data is a remote frame to it."""
    return bare(replace(frame, kind="remote") if frame.kind == "fd" and not frame.data else frame)


def dissected(frame: Recorded) -> Recorded:
    return replace(bare(frame), sent=frame.sent)


READERS = {
    # Of error frames it knows bus errors only, and takes the others for data.
    "log by python-can": Reader(
        "log",
        other_readers.python_can(can.CanutilsLogReader),
        kinds=("data", "remote", "fd"),
        told=short,
        tolerance_ns=1000,
    ),
    "asc by python-can": Reader(
        "asc", other_readers.python_can(can.ASCReader), told=emptied, dated=False, tolerance_ns=1000
    ),
    "asc by asc2log": Reader("asc", other_readers.asc2log, told=bare, dated=False, tolerance_ns=1000),
    "blf by python-can": Reader("blf", other_readers.python_can(can.BLFReader), told=bare, tolerance_ns=1000),
    "trc by python-can": Reader(
        "trc", other_readers.python_can(can.TRCReader, 1), kinds=("data",), dated=False, tolerance_ns=1000
    ),
    "csv by python-can": Reader(
        "csv", other_readers.python_can(can.CSVReader), kinds=CLASSIC, told=unnamed, tolerance_ns=1000
    ),
    "sqlite by python-can": Reader(
        "db", other_readers.python_can(can.SqliteReader), kinds=CLASSIC, told=unnamed, tolerance_ns=1000
    ),
    "mf4 by python-can": Reader(
        "mf4", other_readers.python_can(can.MF4Reader), kinds=("data", "fd"), told=bare, tolerance_ns=1000
    ),
    "mcap by mcap-ros2-support": Reader("mcap", other_readers.mcap),
    "pcapng by tshark": Reader("pcapng", other_readers.tshark, told=dissected),
}


def converted(frames: Sequence[Recorded], suffix: str, scratch: Path) -> Path:
    """What `canalyze convert` makes of a candump log of the frames."""
    source, target = scratch / "source.log", scratch / f"target.{suffix}"
    source.write_bytes(candump_text(frames))
    target.unlink(missing_ok=True)
    ran = run(["convert", source, target])
    assert ran.code == 0, ran.complaints
    return target


def read_nothing(_: Path) -> list[Recorded]:
    """No reader: what was read is compared only."""
    return []


SESSIONS: dict[str, Callable[[], list[Recorded]]] = {
    "every kind": every_kind,
    "random": lambda: random_session(501),
    "one frame": lambda: [classic(0)],
    "equal stamps": lambda: [replace(classic(n, 0x181 + n), t_ns=classic(0).t_ns) for n in range(5)],
    **{log.stem: lambda log=log: frames_of(log) for log in SAMPLES.glob("network/*.log")},  # type: ignore[misc]
}


def same(reader: Reader, got: list[Recorded], frames: Sequence[Recorded]) -> None:
    """Frame by frame, in what that program tells."""
    wanted = [reader.told(frame) for frame in frames if frame.kind in reader.kinds]
    got = [reader.told(frame) for frame in got]
    if not reader.dated:
        got, wanted = list(from_start(got)), list(from_start(wanted))
    assert len(got) == len(wanted)
    for number, (one, other) in enumerate(zip(got, wanted, strict=True), 1):
        near = abs(one.t_ns - other.t_ns) <= reader.tolerance_ns
        assert (replace(one, t_ns=other.t_ns) if near else one) == other, f"frame {number}"


@pytest.mark.parametrize("session", SESSIONS)
@pytest.mark.parametrize("name", READERS)
def test_others_read_what_we_write(name: str, session: str, tmp_path: Path) -> None:
    reader = READERS[name]
    frames = [frame for frame in SESSIONS[session]() if frame.kind in reader.kinds]
    buses = ["can0", "can1", "can2"]
    frames = [frame if frame.bus in buses else replace(frame, bus="can0") for frame in frames]
    if reader.suffix == "mf4":
        frames = frames[:60]  # asammdf takes milliseconds a frame
    target = converted(frames, reader.suffix, tmp_path)
    wanted = [replace(frame, brs=False, esi=False) for frame in frames] if reader.suffix == "mcap" else frames
    got = reader.read(target)
    if reader.suffix == "mcap":
        got = [replace(frame, brs=False, esi=False) for frame in got]
    same(reader, got, wanted)


def test_a_whole_second_of_asc2log_is_read_as_one(tmp_path: Path) -> None:
    """Whatever time of day it begins with: among stamps 1 µs apart one is at the whole second."""
    rows = "".join(f"0.{number:06} 1 123 Rx d 1 00\n" for number in range(1_000_000))
    path = tmp_path / "each.asc"
    path.write_text(f"date Sun Nov 29 02:37:43 pm 2026\nbase hex  timestamps absolute\n{rows}")
    text = other_readers.carried(run_program("asc2log", stdin=path.read_bytes()).decode())
    stamps = re.findall(r"^\((\d+)\.(\d{6})\) ", text, flags=re.MULTILINE)
    assert [int(seconds + fraction) - int("".join(stamps[0])) for seconds, fraction in stamps] == list(range(1_000_000))


SUFFIXES = sorted({reader.suffix for reader in READERS.values()})


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_we_read_what_we_write(suffix: str, tmp_path: Path) -> None:
    frames = [frame for frame in random_session(502, count=60) if suffix not in ("trc", "mf4") or frame.kind == "data"]
    if suffix in ("csv", "db"):
        frames = [frame for frame in frames if frame.kind in CLASSIC]
    target = converted(frames, suffix, tmp_path)
    reading = read(target)
    assert reading.code == 0, reading.complaints
    loose = suffix in ("csv", "db")
    got, wanted = list(from_start(reading.frames)), list(from_start(frames))
    if suffix == "mcap":
        wanted = [replace(frame, brs=False, esi=False) for frame in wanted]
        got = [replace(frame, brs=False, esi=False) for frame in got]
    if suffix == "asc":
        got, wanted = [bare(frame) for frame in got], [bare(frame) for frame in wanted]
    if loose:
        got, wanted = [unnamed(frame) for frame in got], [unnamed(frame) for frame in wanted]
    same(Reader(suffix, read_nothing, told=sideless, dated=False, tolerance_ns=1000), got, wanted)


@pytest.mark.parametrize("suffix", ["asc", "mcap", "pcapng"])
def test_digits_below_a_microsecond_survive_where_the_format_has_them(suffix: str, tmp_path: Path) -> None:
    frames = [replace(classic(n), t_ns=classic(n).t_ns + 123_456 + n) for n in range(5)]
    got = list(from_start(read(converted(frames, suffix, tmp_path)).frames))
    assert [frame.t_ns for frame in got] == [frame.t_ns for frame in from_start(frames)]


@pytest.mark.parametrize("suffix", ["asc", "mcap", "pcapng"])
def test_names_of_buses_survive(suffix: str, tmp_path: Path) -> None:
    names = ("vcan0", "drive", "can7", "slcan0")
    frames = [classic(n, bus=names[n % len(names)]) for n in range(8)]
    got = read(converted(frames, suffix, tmp_path)).frames
    assert [frame.bus for frame in got] == [frame.bus for frame in frames]


def test_pcapng_has_as_many_packets_for_capinfos(tmp_path: Path) -> None:
    target = converted(random_session(503, count=120), "pcapng", tmp_path)
    lines = run_program("capinfos", "-M", target).decode().splitlines()
    told = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)}
    assert told["Number of packets"] == "120"
    assert told["Number of interfaces in file"] == "3"
    assert told["File encapsulation"].lower() == "socketcan"  # as -M has it, or not, by version


def test_back_to_candump_is_the_same_text(tmp_path: Path) -> None:
    """Candump's log, through the formats that lose nothing of it, and back."""
    frames = [frame for frame in random_session(504) if frame.kind != "fd"]
    source = candump_text(frames).decode()
    for suffix in ("mcap", "pcapng"):
        there = converted(frames, suffix, tmp_path)
        back = tmp_path / "back.log"
        ran = run(["convert", there, back, "--force"])
        assert ran.code == 0, ran.complaints
        assert digits_of_microseconds(back.read_text()) == source


def digits_of_microseconds(text: str) -> str:
    """The log with six digits behind the point, where the rest is zeros."""
    return re.sub(r"^\((\d+\.\d{6})000\)", r"(\1)", text, flags=re.MULTILINE)
