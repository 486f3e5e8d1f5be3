"""What every capture format must pass: one abstract suite, in the manner of python-can's own.

A format inherits `ReaderSuite` and says three things: how frames become a file by another program's writer (`write`),
which frames that file can hold (`takes`), and what of a frame survives in it (`keep`). Everything else is the same for
all: kinds of frames, stamps, chunking through a pipe, cuts, damage, compression, and that the analysis of the file is
the analysis of the same frames as a candump log. What it must not do: excuse a format for anything that its file does
not lose.
"""

from __future__ import annotations

import bz2
import gzip
import lzma
import os
import random
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any, ClassVar

import pytest
import zstandard
from capture_frames import (
    Reading,
    Recorded,
    annotated,
    candump_text,
    decoded_text,
    from_start,
    read,
    read_candump,
    recorded,
    run,
    transfers,
    without,
)
from captures import SAMPLES, SHARED, Row, sort_rows
from conftest import ran

from canalyze import _core
from canalyze.running.reading import SessionOptions
from canalyze.sources.bridge.reading import from_this_process

START_NS = 1_700_000_000_000_000_000
MS = 1_000_000

BRIDGED = ("blf", "trc", "csv", "sqlite", "mf4")
"""Formats that come through python-can's readers."""


PACKERS: dict[str, Callable[[bytes], bytes]] = {
    "gz": gzip.compress,
    "zst": zstandard.ZstdCompressor().compress,
    "xz": lzma.compress,
    "bz2": bz2.compress,
}

CHANGES_WITH_THE_FORMAT = ("file", "line", "cause_line", "about_line", "t")
"""Keys of rows that name the file, a line of it, or its clock."""
FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


def classic(number: int, can_id: int = 0x181, data: bytes = b"\x01\x02", **more: object) -> Recorded:
    """A frame on can0, a millisecond after the one with the number before."""
    return replace(Recorded(START_NS + number * MS, "can0", can_id, data), **more)  # type: ignore[arg-type]


def every_kind() -> list[Recorded]:
    """Identifiers at their edges, all lengths, remote frames, FD frames with all flags, error frames."""
    source = random.Random(401)
    frames: list[Recorded] = []

    def add(**more: object) -> None:
        frames.append(classic(len(frames), **more))  # type: ignore[arg-type]

    for can_id in (0, 1, 0x7FE, 0x7FF):
        add(can_id=can_id)
    for can_id in (0, 0x7FF, 0x800, 0x1FFF_FFFE, 0x1FFF_FFFF):
        add(can_id=can_id, extended=True)
    for length in range(9):
        add(data=source.randbytes(length))
        add(data=source.randbytes(length), sent=True, can_id=0x601)
        add(kind="remote", data=b"", asked=length)
        add(kind="remote", data=b"", asked=length, can_id=0x1234_5678, extended=True)
    for length in FD_LENGTHS:
        flags = source.randrange(4)
        add(kind="fd", data=source.randbytes(length), brs=bool(flags & 1), esi=bool(flags & 2))
    for flags in range(4):
        add(kind="fd", data=bytes(12), brs=bool(flags & 1), esi=bool(flags & 2), extended=True, sent=True)
    for error, details in (
        (4, "0004000000000000"),
        (8, "00000A1900000000"),
        (0x40, "0" * 16),
        (0x88, "0000800000007F60"),
    ):
        add(kind="error", can_id=error, data=bytes.fromhex(details))
    return frames


def random_session(seed: int, count: int = 300, buses: int = 3) -> list[Recorded]:
    """Frames of all kinds in any order, on several buses, with gaps of 0 to 3 s."""
    source = random.Random(seed)
    kinds = every_kind()
    stamp, frames = START_NS + source.randrange(10**9) // 1000 * 1000, []
    for _ in range(count):
        stamp += source.choice([0, 1000, 117_000, 2 * MS, 3_000 * MS])
        sent = source.random() < 0.3
        frames.append(replace(source.choice(kinds), t_ns=stamp, bus=f"can{source.randrange(buses)}", sent=sent))
    # Numbered channels get their numbers by name: every bus has to be there.
    return [replace(frame, bus=f"can{at}") if at < buses else frame for at, frame in enumerate(frames)]


def logs() -> list[Path]:
    """Captures of the samples and of real stacks, in candump's log form."""
    named = [*SAMPLES.glob("*.log"), *SAMPLES.glob("network/*.log"), *(SHARED / "stacks").glob("*.log")]
    return sorted(path for path in named if path.read_bytes()[:1] in (b"(", b"#"))


LOGS = logs()


def frames_of(log: Path) -> list[Recorded]:
    """The frames of a candump log, as the program itself reads it: the candump reader has tests of its own."""
    frames = _FRAMES_OF.get(log)
    if frames is None:
        session = _core.Session(SessionOptions(lang="en", format="jsonl"))
        session.begin(str(log), True, "candump")
        rows = sort_rows(session.feed(log.read_bytes()) + session.end() + session.finish()).frames
        frames = _FRAMES_OF[log] = [replace(recorded(row), sent=False) for row in rows if row["t"] is not None]
    return frames


_FRAMES_OF: dict[Path, list[Recorded]] = {}


class ReaderSuite(ABC):
    """Everything that holds for every format."""

    form: ClassVar[str]
    """What the format is called in `--input-format`."""
    suffix: ClassVar[str]
    tolerance_ns: ClassVar[int] = 0
    """By how much a stamp may differ: what the writer (or the format) rounds."""
    absolute: ClassVar[bool] = True
    """Stamps count from 1970; else from the capture's start."""
    backwards: ClassVar[bool] = True
    """Stamps that go backwards survive; else the writer changes them."""
    sorts: ClassVar[bool] = False
    """Frames come in the order of their stamps: the format promises no order of its own."""
    zero_ns: ClassVar[int] = 0
    """The first stamp of a capture from zero, where the writer does not take 0 itself."""
    long: ClassVar[int] = 5_000
    """Frames of a long capture; fewer where the writer is slow."""
    piped: ClassVar[bool] = True
    """It can be read from a pipe as it comes (a database cannot: it is read when it is whole)."""

    tries: ClassVar[int] = 60
    """Damaged files; fewer where each takes a process of its own."""

    @abstractmethod
    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        """Make a file of them, by another program."""

    def takes(self, frame: Recorded) -> bool:
        """Whether the file can hold such a frame."""
        return True

    def keep(self, frame: Recorded) -> Recorded:
        """What of the frame survives in the file."""
        return frame

    def whole_before(self, file: bytes, cut: int) -> int:
        """How many frames at least are whole in the first `cut` bytes; 0 where that cannot be told."""
        return 0

    # What the tests share.

    def expected(self, frames: Sequence[Recorded]) -> list[Recorded]:
        return [self.keep(frame) for frame in frames if self.takes(frame)]

    def file(self, frames: Sequence[Recorded], scratch: Path, name: str = "capture") -> Path:
        path = scratch / f"{name}.{self.suffix}"
        path.unlink(missing_ok=True)
        self.write([frame for frame in frames if self.takes(frame)], path)
        return path

    def same(self, got: Sequence[Recorded], wanted: Sequence[Recorded]) -> None:
        """Frame by frame, stamps within what the format rounds."""
        assert len(got) == len(wanted)
        if not self.absolute:
            got, wanted = list(from_start(got)), list(from_start(wanted))
        for number, (one, other) in enumerate(zip(got, wanted, strict=True)):
            near = abs(one.t_ns - other.t_ns) <= self.tolerance_ns
            if one.kind == "error":  # nobody's frame: whether it has a side is the format's own affair
                one, other = replace(one, sent=None), replace(other, sent=None)
            assert (one if not near else replace(one, t_ns=other.t_ns)) == other, f"frame {number + 1}"

    def check(self, frames: Sequence[Recorded], scratch: Path) -> Reading:
        """Write, read, compare: frames and exit code."""
        reading = read(self.file(frames, scratch))
        wanted = self.expected(frames)
        assert not reading.complaints or not wanted, reading.complaints
        assert reading.code == (0 if wanted else 2)
        self.same(reading.frames, wanted)
        return reading

    def reference(self, reading: Reading, scratch: Path) -> Reading:
        """The frames that were read, with the stamps that were read, as a candump log."""
        start = 0 if self.absolute else START_NS
        frames = [replace(frame, t_ns=frame.t_ns + start) for frame in reading.frames]
        return read_candump(candump_text(frames), scratch)

    # Frames.

    def test_one_frame(self, tmp_path: Path) -> None:
        self.check([classic(0, 0x60A, bytes.fromhex("4008100000000000"))], tmp_path)

    def test_no_frame(self, tmp_path: Path) -> None:
        reading = self.check([], tmp_path)
        assert len(reading.complaints.splitlines()) <= 1, reading.complaints

    def test_every_kind(self, tmp_path: Path) -> None:
        self.check(every_kind(), tmp_path)

    @pytest.mark.parametrize("buses", [2, 9])
    def test_buses(self, buses: int, tmp_path: Path) -> None:
        self.check([classic(n, 0x700 + n % 9, bus=f"can{n % buses}") for n in range(3 * buses)], tmp_path)

    def test_a_long_capture(self, tmp_path: Path) -> None:
        source = random.Random(402)
        frames = [classic(n, source.randrange(0x800), source.randbytes(n % 9)) for n in range(self.long)]
        reading = read(self.file(frames, tmp_path))
        assert reading.code == 0
        self.same(reading.frames, self.expected(frames))

    @pytest.mark.parametrize("seed", range(5))
    def test_random_sessions(self, seed: int, tmp_path: Path) -> None:
        self.check(random_session(seed), tmp_path)

    # Stamps.

    def test_stamps_from_zero(self, tmp_path: Path) -> None:
        self.check([replace(classic(n), t_ns=self.zero_ns + n * 250_000_000) for n in range(8)], tmp_path)

    def test_equal_stamps(self, tmp_path: Path) -> None:
        self.check([replace(classic(n, 0x181 + n), t_ns=START_NS) for n in range(8)], tmp_path)

    def test_stamps_that_go_backwards(self, tmp_path: Path) -> None:
        steps = (0, 5, 3, 9, 8, 8, 20)
        frames = [replace(classic(n, 0x181 + n), t_ns=START_NS + step * MS) for n, step in enumerate(steps)]
        if self.backwards:
            reading = read(self.file(frames, tmp_path))
            assert reading.code == 0
            wanted = self.expected(frames)
            self.same(reading.frames, sorted(wanted, key=lambda frame: frame.t_ns) if self.sorts else wanted)
        else:
            assert len(read(self.file(frames, tmp_path)).frames) == len(frames)

    def test_digits_below_a_microsecond(self, tmp_path: Path) -> None:
        frames = [replace(classic(n), t_ns=START_NS + n * MS + 123_456 + n) for n in range(8)]
        got = read(self.file(frames, tmp_path)).frames
        if self.tolerance_ns == 0 and self.absolute and got[1].t_ns % 1000:
            self.same(got, self.expected(frames))
        else:
            wanted = self.expected(frames)
            start = 0 if self.absolute else wanted[0].t_ns - got[0].t_ns
            assert all(abs(a.t_ns + start - b.t_ns) <= 2000 for a, b in zip(got, wanted, strict=True))

    def test_far_stamps(self, tmp_path: Path) -> None:
        self.check([replace(classic(n), t_ns=2_100_000_000_000_000_000 + n * MS) for n in range(3)], tmp_path)

    # What is said of them.

    @pytest.mark.parametrize("log", LOGS, ids=lambda path: f"{path.parent.name}-{path.stem}")
    def test_the_analysis_is_that_of_the_candump_log(self, log: Path, tmp_path: Path) -> None:
        frames = frames_of(log)
        if not frames:
            pytest.skip("no stamps in it")
        reading = read(self.file(frames, tmp_path))
        self.same(reading.frames, self.expected(frames))
        reference = self.reference(reading, tmp_path)
        assert reading.meanings == reference.meanings
        for ours, theirs in (
            (reading.said.findings, reference.said.findings),
            (reading.said.transfers, reference.said.transfers),
            (reading.said.notes, reference.said.notes),
        ):
            assert comparable(ours) == comparable(theirs)

    def test_the_text_is_that_of_the_candump_log(self, tmp_path: Path) -> None:
        frames = frames_of(SAMPLES / "network" / "sync-and-pdos.log")
        path = self.file(frames, tmp_path)
        self.reference(read(path), tmp_path)
        reference = tmp_path / "reference.log"
        assert annotated(decoded_text(path)) == annotated(decoded_text(reference))
        rows = [comparable(transfers(file)) for file in (path, reference)]
        assert rows[0] == rows[1]
        assert rows[0]

    def test_decoded_text_is_a_capture_again(self, tmp_path: Path) -> None:
        frames = frames_of(SAMPLES / "network" / "remapping.log")
        later = frames[-1].t_ns + MS - START_NS
        frames = [*frames, *(replace(frame, t_ns=frame.t_ns + later) for frame in every_kind())]
        text = decoded_text(self.file(frames, tmp_path))
        again = tmp_path / "again.txt"
        again.write_bytes(text)
        assert decoded_text(again) == text

    # How the bytes come.

    @pytest.mark.parametrize("piece", [1, 7, 65_536])
    def test_any_chunking_through_a_pipe(self, piece: int, tmp_path: Path) -> None:
        frames = random_session(77, count=40 if piece == 1 else 300)
        path = self.file(frames, tmp_path)
        whole = read(path)
        pipe = tmp_path / f"pipe.{self.suffix}"
        os.mkfifo(pipe)
        with Feeding(pipe, path.read_bytes(), piece):
            reading = read(pipe)
        assert reading.code == 0
        assert (reading.frames, reading.meanings) == (whole.frames, whole.meanings)
        assert without(reading.said.findings, "file") == without(whole.said.findings, "file")

    @pytest.mark.parametrize("piece", [1, 7, 4096])
    def test_any_chunking_of_the_core(self, piece: int, tmp_path: Path) -> None:
        if self.form not in _core.FORMATS:
            pytest.skip("its bytes are not the core's")
        file = self.file(random_session(78, count=60), tmp_path).read_bytes()
        assert core_output(self.form, file, piece) == core_output(self.form, file, len(file))

    @pytest.mark.parametrize("packed", ["", *PACKERS])
    def test_standard_input(self, packed: str, tmp_path: Path) -> None:
        if packed not in ("", "zst"):  # the others differ in the unpacking only, which files have below
            pytest.skip("as a file")
        path = self.file(random_session(79, count=50), tmp_path)
        data = path.read_bytes()
        done = ran(
            None,
            "decode",
            "-",
            "--format",
            "jsonl",
            "--lang",
            "en",
            input=PACKERS[packed](data) if packed else data,
            timeout=60,
        )
        assert (done.returncode, done.stderr.decode()) == (0, "")
        assert [recorded(row) for row in sort_rows(done.stdout).frames] == read(path).frames

    @pytest.mark.parametrize("packed", PACKERS)
    def test_compressed(self, packed: str, tmp_path: Path) -> None:
        path = self.file(random_session(80), tmp_path)
        squeezed = tmp_path / f"squeezed.{self.suffix}.{packed}"
        squeezed.write_bytes(PACKERS[packed](path.read_bytes()))
        plain, reading = read(path), read(squeezed)
        assert (reading.code, reading.complaints) == (0, "")
        assert (reading.frames, reading.meanings) == (plain.frames, plain.meanings)

    def test_its_format_is_told_by_its_content(self, tmp_path: Path) -> None:
        path = self.file(random_session(81, count=20), tmp_path)
        assert _core.sniff(path.read_bytes(), True) == self.form
        plain = path.with_name("nameless")
        path.rename(plain)
        assert read(plain).code == 0

    # Damage.

    def test_cut_anywhere(self, tmp_path: Path) -> None:
        frames = random_session(82, count=60)
        path = self.file(frames, tmp_path)
        file, whole = path.read_bytes(), read(path).frames
        source = random.Random(403)
        cuts = {
            *range(0, 64, 420 // self.tries),
            *(source.randrange(len(file)) for _ in range(self.tries * 2 // 3)),
            *range(len(file) - 40, len(file), 180 // self.tries),
        }
        cut_file = tmp_path / f"cut.{self.suffix}"
        for cut in sorted(cuts):
            cut_file.write_bytes(file[:cut])
            reading = read(cut_file)
            got = reading.frames
            assert reading.code == (0 if got else 2), f"cut at {cut}: {reading.complaints}"
            assert len(got) >= self.whole_before(file, cut), f"cut at {cut}: {len(got)} frames"
            self.prefix(got, whole, f"cut at {cut}")

    def prefix(self, got: Sequence[Recorded], whole: Sequence[Recorded], where: str) -> None:
        """What is read of a cut file are the first frames of the whole one."""
        assert list(got) == list(whole[: len(got)]), where

    def test_flipped_bytes(self, tmp_path: Path) -> None:
        frames = random_session(83, count=60)
        path = self.file(frames, tmp_path)
        file = path.read_bytes()
        source = random.Random(404)
        flipped_file = tmp_path / f"flipped.{self.suffix}"
        for _ in range(self.tries):
            flipped = bytearray(file)
            places = [source.randrange(len(file)) for _ in range(source.choice([1, 1, 1, 4]))]
            for place in places:
                flipped[place] ^= 1 << source.randrange(8)
            flipped_file.write_bytes(flipped)
            reading = read(flipped_file)
            assert reading.code == (0 if reading.frames else 2), (places, reading.complaints)
            assert len(reading.frames) <= len(frames) + 2 * len(places), places

    def test_nothing_but_the_beginning_and_noise(self, tmp_path: Path) -> None:
        file = self.file(random_session(84, count=20), tmp_path).read_bytes()
        source = random.Random(405)
        noisy = tmp_path / f"noisy.{self.suffix}"
        for kept in (16, 40, 200, len(file) // 2)[: self.tries // 5]:
            for noise in (source.randbytes(4096), bytes(4096), b"\xff" * 4096, file * 2):
                noisy.write_bytes(file[:kept] + noise)
                reading = read(noisy)
                assert reading.code == (0 if reading.frames else 2), (kept, noise[:8], reading.complaints)

    # The other commands.

    def test_info(self, tmp_path: Path) -> None:
        ran = run(["info", self.file(random_session(85, count=50), tmp_path)], tmp_path / "info.txt")
        assert ran.code == 0, ran.complaints


def comparable(rows: Sequence[Row]) -> list[Row]:
    """Rows without what names the file, a line of it or its clock; durations as numbers, whatever their digits."""
    kept = without(rows, *CHANGES_WITH_THE_FORMAT)
    return [row | {"duration": Decimal(row["duration"])} if row.get("duration") else row for row in kept]


def core_output(form: str, file: bytes, piece: int) -> bytes:
    """What a session of the core says on a file that comes in pieces."""
    session = _core.Session(SessionOptions(lang="en", format="jsonl"))
    session.begin("capture", True, form)
    output = [session.feed(file[at : at + piece]) for at in range(0, len(file), max(piece, 1))]
    return b"".join([*output, session.end(), session.finish()])


class Feeding:
    """A thread that writes bytes to a FIFO in pieces, each in a write of its own."""

    def __init__(self, pipe: Path, data: bytes, piece: int) -> None:
        """Ready to write these bytes in pieces of this size."""
        self._thread = threading.Thread(target=self._feed, args=(pipe, data, piece), daemon=True)

    @staticmethod
    def _feed(pipe: Path, data: bytes, piece: int) -> None:
        with pipe.open("wb", buffering=0) as out:
            for at in range(0, len(data), piece):
                try:
                    out.write(data[at : at + piece])
                except BrokenPipeError:
                    return

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._thread.join(60)


def line_ends(file: bytes, is_frame: Callable[[bytes], bool]) -> Iterator[int]:
    """Offsets after each line that is a frame."""
    at = 0
    for line in file.splitlines(keepends=True):
        at += len(line)
        if is_frame(line):
            yield at


def read_here(path: Path, _: Path) -> Iterator[tuple[str, Any]]:
    """Reads an MF4 file in this process, in place of `reading.from_process`: no process is started."""
    return iter([*from_this_process(path)])  # at once: meanwhile what is logged and printed goes elsewhere
