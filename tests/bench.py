"""Speed, memory and start-up of canalyze beside other programs on the same capture, in one run.

    python tests/bench.py [--frames 1000000] [--repeat 3] [--directory DIR]

Makes (once; kept in DIR, by default below the system's temporary directory) a capture in `candump -l` form that is
the same on every machine: eight drives as `eds/drive.eds` presets them, SYNC every 10 ms, 88 % PDO, 7.6 % SDO
(expedited, segmented, block, aborts), heartbeats and some EMCY; a million frames are about 45 MB. Then runs each
program that is installed over it, output to /dev/null, and prints frames per second of CPU time (best of the
repeats), the ratio to tshark's one-line summary, and the peak of memory. Slow programs get the beginning of the
capture only, and the table says how much.
Only ratios of one run mean anything: machines are shared. Peak memory cannot be measured below what this script
itself takes, which is printed as the floor.

Not a test: nothing here passes or fails.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

TESTS = Path(__file__).resolve().parent
DRIVE = TESTS.parent / "eds" / "drive.eds"
SAMPLE = TESTS.parent / "samples" / "zephyr-sdo.log"
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
        index, sub = source.choice([0x1008, 0x1018, 0x2000, 0x2001, 0x6040, 0x6064]), source.randrange(4)
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


def capture_lines(count: int) -> Iterator[str]:
    """So many lines of a capture."""
    source = random.Random(301)
    start, written = 1_700_000_000_000_000, 0
    stamp = start
    for frame in traffic(source):
        if not frame:
            start += CYCLE_US
            stamp = start + source.randrange(30)
            continue
        yield f"({stamp // 1_000_000}.{stamp % 1_000_000:06d}) {BUS} {frame}\n"
        stamp += 120 + source.randrange(200)
        written += 1
        if written == count:
            return


def write_capture(path: Path, count: int) -> None:
    """The capture, in place only when it is whole."""
    unfinished = path.with_suffix(".unfinished")
    with unfinished.open("w") as out:
        out.writelines(capture_lines(count))
    unfinished.replace(path)


def capture(directory: Path, count: int) -> Path:
    """The capture of so many frames; made by another process where it is missing, so that this one stays small."""
    path = directory / f"capture-{count}.log"
    if not path.exists():
        print(f"making {path} ...", flush=True)
        subprocess.run([sys.executable, __file__, "--make", str(path), "--frames", str(count)], check=True)
    return path


@dataclass(frozen=True, slots=True)
class Contestant:
    """A program and what it does with the capture, whose path goes to the end of its arguments or to stdin."""

    name: str
    command: list[str]
    most_frames: int = sys.maxsize
    on_stdin: bool = False


CANALYZE = [sys.executable, "-m", "canalyze"]
TSHARK = ["tshark", "-n", "-d", "can.subdissector,canopen"]

CONTESTANTS = [
    Contestant("canalyze decode", [*CANALYZE, "decode"]),
    Contestant("canalyze decode --eds, 8 nodes", [*CANALYZE, "decode", "--eds", f"1-8={DRIVE}"]),
    Contestant("canalyze signals --eds, 8 nodes", [*CANALYZE, "signals", "--eds", f"1-8={DRIVE}"]),
    Contestant("canalyze decode --lang en", [*CANALYZE, "decode", "--lang", "en"]),
    Contestant("canalyze decode --format jsonl", [*CANALYZE, "decode", "--format", "jsonl"]),
    Contestant("canalyze sdo --format jsonl", [*CANALYZE, "sdo", "--format", "jsonl"]),
    Contestant("canalyze summary --bitrate 500k", [*CANALYZE, "summary", "--bitrate", "500k"]),
    Contestant("tshark (one line a frame)", [*TSHARK, "-r"], 1_000_000),
    Contestant("tshark -T json", [*TSHARK, "-T", "json", "-r"], 100_000),
    Contestant("log2long", ["log2long"], on_stdin=True),
    Contestant("wc -l", ["wc", "-l"]),
]


@dataclass(frozen=True, slots=True)
class Measure:
    """What one run took."""

    cpu: float
    wall: float
    peak_kib: int
    status: int


def run(command: list[str], stdin: Path | None = None) -> Measure:
    """One run, its output thrown away."""
    with Path(os.devnull).open("wb") as nowhere, (stdin or Path(os.devnull)).open("rb") as source:
        begin = time.perf_counter()
        process = subprocess.Popen(command, stdin=source, stdout=nowhere, stderr=nowhere)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
    return Measure(usage.ru_utime + usage.ru_stime, wall, usage.ru_maxrss, process.returncode)


def available(contestant: Contestant) -> str | None:
    """Why a program cannot run here; None when it can."""
    if contestant.command[0] != sys.executable:
        return None if shutil.which(contestant.command[0]) else "not installed"
    return None if run([*CANALYZE, "--help"]).status == 0 else "does not start"


def best_of(contestant: Contestant, path: Path, repeat: int) -> Measure:
    """The run with the least CPU time."""
    command = contestant.command if contestant.on_stdin else [*contestant.command, str(path)]
    runs = [run(command, path if contestant.on_stdin else None) for _ in range(repeat)]
    return min(runs, key=lambda measure: measure.cpu)


def measure_speed(directory: Path, frames: int, repeat: int) -> None:
    """The table of all programs."""
    rates: dict[str, tuple[float, Measure, int]] = {}
    for contestant in CONTESTANTS:
        reason = available(contestant)
        if reason:
            print(f"{contestant.name}: {reason}")
            continue
        count = min(frames, contestant.most_frames)
        measure = best_of(contestant, capture(directory, count), 1 if count < frames else repeat)
        if measure.status:
            print(f"{contestant.name}: ended with {measure.status}")
            continue
        rates[contestant.name] = (count / max(measure.cpu, 1e-3), measure, count)
    base = rates.get("tshark (one line a frame)")
    print(f"\n{'program':32} {'frames':>10} {'CPU s':>8} {'frames/s':>12} {'x tshark':>9} {'peak MiB':>9}")
    for name, (rate, measure, count) in rates.items():
        ratio = f"{rate / base[0]:.1f}" if base else "-"
        shown = f"{count}{'' if count == frames else ' *'}"
        print(f"{name:32} {shown:>10} {measure.cpu:8.2f} {rate:12,.0f} {ratio:>9} {measure.peak_kib / 1024:9.1f}")
    floor = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"* the beginning of the capture only.  Memory below {floor:.1f} MiB (this script) cannot be seen.")


def measure_start(repeat: int) -> None:
    """Start-up: the sample of ten frames, beside the least a command line program in Python can take."""
    commands = {
        "python -c pass": [sys.executable, "-c", "pass"],
        'python -c "import click"': [sys.executable, "-c", "import click"],
        f"canalyze decode {SAMPLE.name}": [*CANALYZE, "decode", str(SAMPLE)],
        "canalyze --help": [*CANALYZE, "--help"],
    }
    print(f"\nstart-up, wall clock, median of {repeat}")
    for name, command in commands.items():
        runs = [run(command) for _ in range(repeat)]
        if any(measure.status for measure in runs):
            print(f"{name:32} does not run")
        else:
            print(f"{name:32} {statistics.median(measure.wall for measure in runs) * 1000:8.1f} ms")


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=1_000_000, help="frames in the capture (default: 1000000)")
    parser.add_argument("--repeat", type=int, default=3, help="runs of each program; the best counts (default: 3)")
    parser.add_argument("--directory", type=Path, default=Path(tempfile.gettempdir()) / "canalyze-bench")
    parser.add_argument("--make", type=Path, help="only write a capture to this file")
    options = parser.parse_args()
    if options.make:
        write_capture(options.make, options.frames)
        return
    options.directory.mkdir(parents=True, exist_ok=True)
    path = capture(options.directory, options.frames)
    print(f"{path.name}: {options.frames} frames, {path.stat().st_size / 1e6:.1f} MB")
    measure_speed(options.directory, options.frames, options.repeat)
    measure_start(15)


if __name__ == "__main__":
    main()
