"""Sound captures of every format that are damaged then: the same frames in each.

Why it exists: what is said of damage is compared with what the capture held. What it must not do: use a capture that
somebody else made.
"""

from __future__ import annotations

import bz2
import gzip
import lzma
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import can
import forked
import zstandard
from capture_frames import Recorded, candump_text
from mcap.writer import CompressionType
from other_writers import Write, mcap_ros2, pcap, python_can

ORIGIN_NS = 1_700_000_000_000_000_000
COUNT = 160


@dataclass(frozen=True)
class Form:
    """How a format stands to damage."""

    suffix: str
    make: Callable[[], bytes]
    checksum: bool = False
    """A changed byte is always noticed."""
    open_end: bool = False
    """A file that was cut behind a record is a whole file."""


def frames() -> list[Recorded]:
    """SDO, PDOs, SYNC, and heartbeats of four nodes on two buses; no two frames are alike."""
    found = []
    for number in range(COUNT):
        node, turn = 5 + number % 4, number // 8
        can_id, data = [
            (0x080, b""),
            (0x180 + node, bytes([number, turn, 0x55, 0xAA, node, 0, 1, 2])),
            (0x280 + node, bytes([turn, number, node])),
            (0x600 + node, bytes([0x40, 0x18, 0x10, 1 + turn % 4, 0, 0, 0, 0])),
            (0x580 + node, bytes([0x43, 0x18, 0x10, 1 + turn % 4, number, turn, 0, 0])),
            (0x380 + node, bytes([0xFF, number, 0, turn, 7, 7])),
            (0x700 + node, b"\x05"),
            (0x480 + node, bytes([turn ^ 0x5A, number])),
        ][number % 8]
        found.append(Recorded(ORIGIN_NS + number * 1_237_000, "can0" if number % 3 else "can1", can_id, data))
    return found


def log() -> bytes:
    """The frames as a candump log."""
    return candump_text(frames())


def listed() -> bytes:
    """The frames as rows of a table."""
    rows = [
        f"{one.t_ns / 1e9:.6f};{one.bus};{one.can_id:03X};{len(one.data)};{one.data.hex(' ').upper()}"
        for one in frames()
    ]
    return "\n".join(["Time;Bus;ID;DLC;Data", *rows, ""]).encode()


def converted(suffix: str, *options: str) -> bytes:
    """What `convert` writes."""
    with TemporaryDirectory() as folder:
        Path(folder, "in.log").write_bytes(log())
        line = ["convert", *options, "in.log", f"out.{suffix}"]
        done = forked.run(line, cwd=Path(folder), env=os.environ, timeout_s=60)
        assert done.returncode == 0, done.stderr
        return Path(folder, f"out.{suffix}").read_bytes()


def written(write: Write, suffix: str) -> bytes:
    """What another program's writer writes."""
    with TemporaryDirectory() as folder:
        path = Path(folder, f"out.{suffix}")
        write(frames(), path)
        return path.read_bytes()


def _of_ros2(compression: CompressionType) -> Form:
    return Form("mcap", lambda: written(mcap_ros2(compression, 4096), "mcap"), checksum=True)


def _by_convert(suffix: str, *, checksum: bool = False, open_end: bool = False, options: tuple[str, ...] = ()) -> Form:
    return Form(suffix, lambda: converted(suffix, *options), checksum=checksum, open_end=open_end)


FORMS = {
    "candump": Form("log", log, open_end=True),
    "console": _by_convert("txt", open_end=True, options=("--to", "console")),
    "asc": _by_convert("asc", open_end=True),
    "trc": _by_convert("trc", open_end=True),
    "rows": Form("txt", listed, open_end=True),
    "csv": _by_convert("csv", open_end=True),
    "db": _by_convert("db"),
    "pcap": Form("pcap", lambda: written(pcap(), "pcap"), open_end=True),
    "pcapng": _by_convert("pcapng", open_end=True),
    "blf": _by_convert("blf", checksum=True),
    "blf-plain": Form("blf", lambda: written(python_can(can.BLFWriter, compression_level=0), "blf")),
    "mcap": _by_convert("mcap", checksum=True),
    "mcap-none": _of_ros2(CompressionType.NONE),
    "mcap-lz4": _of_ros2(CompressionType.LZ4),
    "mcap-zstd": _of_ros2(CompressionType.ZSTD),
    "gz": Form("log.gz", lambda: gzip.compress(log()), checksum=True),
    "xz": Form("log.xz", lambda: lzma.compress(log()), checksum=True),
    "bz2": Form("log.bz2", lambda: bz2.compress(log()), checksum=True),
    "zst": Form("log.zst", lambda: zstandard.ZstdCompressor(write_checksum=True).compress(log()), checksum=True),
}


@cache
def sound(form: str) -> bytes:
    """The bytes of the capture in a format."""
    return FORMS[form].make()
