"""Every capture format that is read, each through the whole suite of `reader_suite.py`.

A class says who wrote the file and what that file loses; the reader may lose nothing more. What it must not do: hold
tests of a single format's own (they stand beside its reader).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import can
import other_writers
import pytest
import reader_suite
from capture_frames import Recorded
from captures import run_canalyze
from mcap.writer import CompressionType
from other_writers import Write
from reader_suite import ReaderSuite, line_ends, read_here

from canalyze import _core
from canalyze.sources.bridge import reading

CLASSIC = ("data", "remote", "error")


def numbered(bus: str) -> str:
    """The name that a format with channel numbers gives back: can0 for the first."""
    digits = re.search(r"\d+$", bus)
    return f"can{int(digits[0]) if digits else 0}"


def bare_error(frame: Recorded) -> Recorded:
    """Of an error frame only that there was one."""
    return replace(frame, can_id=0, data=b"") if frame.kind == "error" else frame


class Text(ReaderSuite):
    """Formats of lines."""

    frame_line = rb"^ *[\d.]+ "

    def whole_before(self, file: bytes, cut: int) -> int:
        ends = line_ends(file, lambda line: re.match(self.frame_line, line) is not None)
        return sum(end <= cut for end in ends)

    def prefix(self, got: Sequence[Recorded], whole: Sequence[Recorded], where: str) -> None:
        # A line that is cut between two bytes of its data may look whole.
        assert list(got[:-1]) == list(whole[: max(len(got) - 1, 0)]), where


class TestCandumpOfPythonCan(Text):
    form = "candump"
    suffix = "log"
    frame_line = rb"^\("
    backwards = False
    tolerance_ns = 1000

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.python_can(can.CanutilsLogWriter)(frames, path)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind != "error"  # written as a bus error, whatever it was, and without details

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, asked=0)

    def test_no_frame(self, tmp_path: Path) -> None:
        path = self.file([], tmp_path)
        assert "".join(map(str, run_canalyze(["decode", path], expected_exit=2).splitlines())) == ""


class TestAscOfLog2asc(Text):
    form = "asc"
    suffix = "asc"
    absolute = False
    tolerance_ns = 1000
    zero_ns = 1_000_000_000  # log2asc takes 0 for "no start yet"
    options: tuple[str, ...] = ()
    frame_line = rb"^ +\d+\.\d+ +(CANFD )?"

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.log2asc(*self.options)(frames, path)

    def keep(self, frame: Recorded) -> Recorded:
        return bare_error(replace(frame, bus=numbered(frame.bus)))


class TestAscOfLog2ascInCanFdForm(TestAscOfLog2asc):
    """`-f`: every frame in a CANFD line; whether a frame is one of CAN FD stands in the flags of its end."""

    options = ("-f",)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind != "error"


class TestAscOfLog2ascInCrLf(TestAscOfLog2asc):
    """`-n -r`: lines end as on Windows, and remote frames have no length."""

    options = ("-n", "-r")

    def keep(self, frame: Recorded) -> Recorded:
        return super().keep(replace(frame, asked=0))


class TestAscOfPythonCan(Text):
    form = "asc"
    suffix = "asc"
    absolute = False
    tolerance_ns = 1000
    frame_line = rb"^ +\d+\.\d+ (?!Start of measurement)"

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.python_can(can.ASCWriter)(frames, path)

    def keep(self, frame: Recorded) -> Recorded:
        return bare_error(replace(frame, bus=numbered(frame.bus)))


class TestRowsOfPythonCan(Text):
    """What `can.Printer` prints, as it stands in logs and posts."""

    form = "rows"
    suffix = "txt"
    frame_line = rb"^Timestamp: "
    tolerance_ns = 1000
    backwards = False

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.python_can(can.Printer)(frames, path)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind != "error"

    def keep(self, frame: Recorded) -> Recorded:
        return frame


class Mcap(ReaderSuite):
    """Topics as ros2_socketcan has them."""

    form = "mcap"
    suffix = "mcap"
    sorts = True
    writer: Write

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        type(self).writer(frames, path)

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, brs=False, esi=False)


class TestMcapZstd(Mcap):
    writer = staticmethod(other_writers.mcap_ros2(CompressionType.ZSTD))


class TestMcapSmallChunks(Mcap):
    writer = staticmethod(other_writers.mcap_ros2(CompressionType.ZSTD, chunk_size=700))


class TestMcapLz4(Mcap):
    writer = staticmethod(other_writers.mcap_ros2(CompressionType.LZ4))


class TestMcapUncompressed(Mcap):
    writer = staticmethod(other_writers.mcap_ros2(CompressionType.NONE))


class TestMcapBare(Mcap):
    writer = staticmethod(other_writers.mcap_bare)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind != "fd"

    def whole_before(self, file: bytes, cut: int) -> int:
        at, whole = 8, 0
        while at + 9 <= cut:
            kind, end = file[at], at + 9 + int.from_bytes(file[at + 1 : at + 9], "little")
            whole += kind == 5 and end <= cut
            at = end
        return whole


class TestMcapDataspeed(Mcap):
    writer = staticmethod(other_writers.mcap_dataspeed)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind != "error"

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, asked=0)


class Packets(ReaderSuite):
    """pcap: no names of interfaces, no side of a frame."""

    form = "pcap"
    suffix = "pcap"
    writer: Write
    order = "little"
    tolerance_ns = 1000

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        type(self).writer(frames, path)

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, bus="can0", sent=None)


def pcap_whole(file: bytes, cut: int, order: str) -> int:
    """Records of a pcap file that end before the cut."""
    at, whole = 24, 0
    while at + 16 <= cut:
        at += 16 + int.from_bytes(file[at + 8 : at + 12], "little" if order == "little" else "big")
        whole += at <= cut
    return whole


class TestPcap(Packets):
    writer = staticmethod(other_writers.pcap())

    def whole_before(self, file: bytes, cut: int) -> int:
        return pcap_whole(file, cut, "little")


class TestPcapBigEndianNanoseconds(Packets):
    writer = staticmethod(other_writers.pcap(order=">", nanoseconds=True))
    tolerance_ns = 0

    def whole_before(self, file: bytes, cut: int) -> int:
        return pcap_whole(file, cut, "big")


class Cooked(Packets):
    """The cooked link types say the side of a frame."""

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, bus="can0")


class TestPcapCooked(Cooked):
    writer = staticmethod(other_writers.pcap(other_writers.SLL))


class TestPcapCooked2(Cooked):
    writer = staticmethod(other_writers.pcap(other_writers.SLL2))

    def keep(self, frame: Recorded) -> Recorded:
        # A cooked header of the second kind has the host's number of the interface, and no name.
        return replace(frame, bus=f"if{int(numbered(frame.bus).removeprefix('can')) + 1}")


class TestPcapngOfEditcap(Packets):
    form = "pcapng"
    suffix = "pcapng"
    writer = staticmethod(other_writers.editcap("pcapng", other_writers.pcap()))


class TestPcapngOfEditcapCooked(Cooked):
    form = "pcapng"
    suffix = "pcapng"
    tolerance_ns = 0
    writer = staticmethod(other_writers.editcap("pcapng", other_writers.pcap(other_writers.SLL, nanoseconds=True)))


class TestPcapngNamed(ReaderSuite):
    """Interfaces with their names, stamps in ns, the side in the flags."""

    form = "pcapng"
    suffix = "pcapng"
    order = "<"

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.pcapng_named(self.order)(frames, path)

    def whole_before(self, file: bytes, cut: int) -> int:
        at, whole, order = 0, 0, "little" if self.order == "<" else "big"
        while at + 12 <= cut:
            kind = int.from_bytes(file[at : at + 4], order)  # type: ignore[arg-type]
            at += int.from_bytes(file[at + 4 : at + 8], order)  # type: ignore[arg-type]
            whole += kind == 6 and at <= cut
        return whole


class TestPcapngNamedBigEndian(TestPcapngNamed):
    order = ">"


class TestBlf(ReaderSuite):
    form = "blf"
    suffix = "blf"
    absolute = False
    tolerance_ns = 1000
    long = 3000

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.python_can(can.BLFWriter)(frames, path)

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, bus=numbered(frame.bus))


class TestTrc(Text):
    form = "trc"
    suffix = "trc"
    absolute = False
    tolerance_ns = 1000
    frame_line = rb"^ *\d+ "
    long = 3000

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.python_can(can.TRCWriter)(frames, path)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind == "data"

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, bus=numbered(frame.bus))


class TestCsv(Text):
    """python-can's own: neither bus nor side."""

    form = "csv"
    suffix = "csv"
    tolerance_ns = 1000
    frame_line = rb"^\d"
    long = 3000

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.python_can(can.CSVWriter)(frames, path)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind in CLASSIC

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, bus="can0", sent=None)


class TestSqlite(ReaderSuite):
    form = "sqlite"
    suffix = "db"
    tolerance_ns = 1000
    long = 3000
    piped = False
    tries = 10

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        other_writers.sqlite(frames, path)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind in CLASSIC

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, bus="can0", sent=None)


class TestMf4(ReaderSuite):
    """ASAM MDF: data, error and remote frames in groups of their own, merged by their stamps."""

    form = "mf4"
    suffix = "mf4"
    tolerance_ns = 1000
    long = 300
    piped = False
    tries = 10

    @pytest.fixture(autouse=True)
    def _in_this_process(self, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
        """Files that are sound are read here, which saves seconds for each; damaged ones as ever."""
        name = request.node.originalname
        if name not in ("test_every_kind", "test_cut_anywhere", "test_flipped_bytes") and "noise" not in name:
            monkeypatch.setattr(reading, "from_process", read_here)

    def write(self, frames: Sequence[Recorded], path: Path) -> None:
        pytest.importorskip("asammdf")
        other_writers.python_can(can.MF4Writer)(frames, path)

    def takes(self, frame: Recorded) -> bool:
        return frame.kind in ("data", "fd")

    def keep(self, frame: Recorded) -> Recorded:
        return replace(frame, bus=numbered(frame.bus))


SUITES = [suite for suite in globals().values() if isinstance(suite, type) and issubclass(suite, ReaderSuite)]


def test_every_format_has_its_suite() -> None:
    """A format that the core lists, and every one that the bridge brings, is proven here."""
    proven = {suite.form for suite in SUITES if hasattr(suite, "form")}
    assert proven >= {*_core.FORMATS, *reader_suite.BRIDGED}
