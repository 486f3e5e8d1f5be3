"""The benchmark's capture, and the same capture in every format.

Why it exists: what is measured must be the same on every machine and for every program, and making it takes longer and
more memory than measuring it. Run by `bench.py` as a process of its own. What it must not do: measure.
"""

from __future__ import annotations

import argparse
import gzip
import random
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from capture_frames import Recorded

sys.path.append(str(Path(__file__).resolve().parents[1]))

NODES = range(1, 9)
BUS = "can0"
CYCLE_US = 10_000
HEARTBEAT_CYCLES = 50


def sdo_lines(source: random.Random) -> Iterator[str]:
    """An endless row of valid transfers, one after the other, as `ID#DATA`: in causal order on every channel."""
    import sdo_wire  # the generating process only: the measuring one stays small

    makers = [
        (sdo_wire.expedited_upload, 1, 4, 40),
        (sdo_wire.expedited_download, 1, 4, 25),
        (sdo_wire.segmented_upload, 5, 60, 15),
        (sdo_wire.segmented_download, 5, 60, 10),
        (sdo_wire.block_upload, 30, 400, 2),
        (sdo_wire.block_download, 30, 400, 2),
    ]
    weights = [weight for *_, weight in makers]
    refusals = [0x06020000, 0x06090011, 0x06010002, 0x08000022]
    while True:
        channel = sdo_wire.Channel(source.choice(NODES), BUS)
        index, sub = source.choice([0x1008, 0x2018, 0x2000, 0x2001, 0x6040, 0x6064]), source.randrange(4)
        if source.random() < 0.06:
            request = sdo_wire.expedited_upload(channel, index, sub, b"\0")[0]
            frames = [request, channel.server(sdo_wire.abort(index, sub, source.choice(refusals)))]
        else:
            make, least, most, _ = source.choices(makers, weights)[0]
            frames = make(channel, index, sub, source.randbytes(source.randint(least, most)))
        for frame in frames:
            yield f"{frame.can_id:03X}#{frame.data.hex().upper()}"


def traffic(source: random.Random) -> Iterator[str]:
    """Endless traffic as `ID#DATA`, an empty string at the end of each cycle of 10 ms."""
    for node in NODES:
        yield f"{0x700 + node:03X}#00"
    yield "000#0100"
    yield ""
    sdo = sdo_lines(source)
    errors: list[str] = []
    cycle = 0
    while True:
        yield "080#"
        for node in NODES:
            position = (cycle * 37 * node) & 0xFFFFFFFF
            yield f"{0x380 + node:03X}#3706{position.to_bytes(4, 'little').hex().upper()}"
            yield f"{0x480 + node:03X}#3706{source.getrandbits(48):012X}"
            yield f"{0x400 + node:03X}#0F00{(position + 37 & 0xFFFFFFFF).to_bytes(4, 'little').hex().upper()}"
        yield next(sdo)
        yield next(sdo)
        if cycle % 12 == 0:
            yield next(sdo)
        if cycle % HEARTBEAT_CYCLES < len(NODES):
            yield f"{0x701 + cycle % HEARTBEAT_CYCLES:03X}#05"
        if source.random() < 0.01:
            node = source.choice(NODES)
            errors.append(f"{0x80 + node:03X}#0000000000000000")
            yield f"{0x80 + node:03X}#1042090000000000"
        elif errors and source.random() < 0.1:
            yield errors.pop()
        yield ""
        cycle += 1


def inputs(source: random.Random) -> Iterator[str]:
    """Frames of eight I/O blocks as `eds/io.eds` presets them, nearly all four analogue inputs; "" ends a cycle."""
    for node in NODES:
        yield f"{0x700 + node:03X}#00"
    yield "000#0100"
    yield ""
    levels = {node: [source.randrange(1 << 16) for _ in range(4)] for node in NODES}
    cycle = 0
    while True:
        yield "080#"
        for node in NODES:
            levels[node] = [(level + source.randrange(-40, 41)) & 0xFFFF for level in levels[node]]
            yield f"{0x280 + node:03X}#{b''.join(level.to_bytes(2, 'little') for level in levels[node]).hex().upper()}"
        if cycle % 5 == 0:
            for node in NODES:
                yield f"{0x180 + node:03X}#{cycle >> 3 & 0xFF:02X}"
        if cycle % HEARTBEAT_CYCLES < len(NODES):
            yield f"{0x701 + cycle % HEARTBEAT_CYCLES:03X}#05"
        yield ""
        cycle += 1


TRAFFIC: dict[str, Callable[[random.Random], Iterator[str]]] = {"capture": traffic, "inputs": inputs}
"""What is captured, by the first part of a file's name."""


def capture_lines(count: int, of: str = "capture") -> Iterator[str]:
    """So many lines of a capture."""
    source = random.Random(301)
    start, written = 1_700_000_000_000_000, 0
    stamp = start
    for frame in TRAFFIC[of](source):
        if not frame:
            start += CYCLE_US
            stamp = start + source.randrange(30)
            continue
        yield f"({stamp // 1_000_000}.{stamp % 1_000_000:06d}) {BUS} {frame}\n"
        stamp += 120 + source.randrange(200)
        written += 1
        if written == count:
            return


def recorded(log: Path) -> Iterator[Recorded]:
    """The frames of that capture, which are all of the plainest kind."""
    from capture_frames import Recorded

    with log.open() as lines:
        for line in lines:
            stamp, bus, frame = line.split()
            seconds, _, micros = stamp[1:-1].partition(".")
            can_id, _, data = frame.partition("#")
            yield Recorded(int(seconds) * 10**9 + int(micros) * 1000, bus, int(can_id, 16), bytes.fromhex(data))


def _asc(log: Path, path: Path) -> None:
    with log.open("rb") as source, path.open("wb") as out:
        subprocess.run(["log2asc", BUS], stdin=source, stdout=out, check=True)


def _asc_gz(log: Path, path: Path) -> None:
    with log.with_suffix(".asc").open("rb") as source, gzip.open(path, "wb", compresslevel=6) as out:
        shutil.copyfileobj(source, out)


def _mcap(log: Path, path: Path) -> None:
    import other_writers
    from mcap.writer import CompressionType

    other_writers.mcap_ros2(CompressionType.ZSTD)(recorded(log), path)


def _pcapng(log: Path, path: Path) -> None:
    import other_writers

    other_writers.editcap("pcapng", other_writers.pcap())(recorded(log), path)


def _blf(log: Path, path: Path) -> None:
    import can
    import other_writers

    other_writers.python_can(can.BLFWriter)(recorded(log), path)


def _live(log: Path, path: Path) -> None:
    """As the kernel would hand them over, in batches, each with the time after it: blocks of the live stream."""
    from canalyze.sources import live

    frame, control = struct.Struct("@IB3x8s56x"), struct.Struct("@Niiqq")
    header = struct.Struct("@PIPNPNi0PI0P")
    with path.open("wb") as out:
        out.write(live.name_block(0, BUS))
        for batch in batched(recorded(log), BATCH):
            headers = header.pack(0, 0, 0, 1, 0, control.size, 0, 16) * len(batch)
            slots = (
                frame.pack(one.can_id, len(one.data), one.data)
                + control.pack(control.size, 1, 35, *divmod(one.t_ns, 10**9)).ljust(128, b"\0")
                for one in batch
            )
            out.write(live.block(live.MESSAGES, 0, 0, len(batch), headers + b"".join(slots)))
            out.write(live.until_block(batch[-1].t_ns))


def batched(frames: Iterator[Recorded], size: int) -> Iterator[list[Recorded]]:
    """So many at a time."""
    while batch := list(islice(frames, size)):
        yield batch


MAKERS: dict[str, tuple[str, Callable[[Path, Path], None]]] = {
    "asc": ("log2asc", _asc),
    "asc.gz": ("log2asc and gzip", _asc_gz),
    "mcap": ("mcap-ros2-support, zstd", _mcap),
    "pcapng": ("editcap, of a pcap packed here", _pcapng),
    "blf": ("python-can", _blf),
}
"""The other formats of the capture, who makes them, and how: none of them is written by canalyze."""
BATCH = 100
"""Frames that come at once from a live bus."""


def make(path: Path, count: int) -> None:
    """The capture in the format of the name, in place only when it is whole."""
    name, _, suffix = path.name.partition(".")
    unfinished = path.with_name(f"unfinished.{suffix}")
    if suffix == "log":
        with unfinished.open("w") as out:
            out.writelines(capture_lines(count, name.partition("-")[0]))
    else:
        maker = _live if suffix == "live" else MAKERS[suffix][1]
        maker(path.with_name(f"{name}.log"), unfinished)
    unfinished.replace(path)


def capture(directory: Path, count: int, suffix: str = "log", of: str = "capture") -> Path | None:
    """The capture of so many frames; made by another process where it is missing, so that this one stays small.

    of: a row of TRAFFIC. None where a program is missing that makes it.
    """
    path = directory / f"{of}-{count}.{suffix}"
    if not path.exists():
        for base in ("log", "asc") if suffix == "asc.gz" else ("log",):
            if suffix != base and capture(directory, count, base, of) is None:
                return None
        print(f"making {path} ...", flush=True)
        made = subprocess.run([sys.executable, __file__, str(path), str(count)], check=False)
        if made.returncode:
            return None
    return path


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Writes the benchmark's capture in the format of the name.")
    parser.add_argument("path", type=Path)
    parser.add_argument("frames", type=int)
    options = parser.parse_args()
    make(options.path, options.frames)
