"""Every figure of speed and memory that has a goal, in one command, written as a table to `figures.md`.

    python tests/bench/figures.py [--quick] [--frames N] [--repeat N] [--lens PROGRAM] [-o FILE]

Each program runs once a round, one after the other, so that a change of the machine's load reaches all of them; the
least of the rounds counts. Captures and descriptions are made by this folder's own generator, once, and kept. A peer
that is not installed is a line in the table. Instructions are counted by `perf stat`, where that works. `--quick` has
100,000 frames and two rounds, takes less than a minute, and is too short for the ratios of wall clock; all of it takes
about five minutes, one of them for the captures. Ratios are of one run on one machine; build the core as it is
installed (`pip install .`), and leave the machine alone meanwhile.

It must not be a test: nothing here passes or fails.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path

from bench import CANALYZE, DRIVE, SAMPLE, TSHARK, Measure, run
from bench_captures import capture

TABLE = Path(__file__).with_name("figures.md")
SMALL = 1000
"""Captures of ten frames, to see what a capture of a fleet costs beside its work."""
LARGE = 100
"""Captures of a tenth of the frames, to see what a second worker brings."""
START = 15
"""Runs in a round of what takes milliseconds."""
_WORK = """
import sys
from pathlib import Path
from canalyze.check.examination import Far, Job, examine
from canalyze.configuration.network import Known
job = Job("en", {"threads": 1}, Known(), {}, beside=False)
for path in sorted(Path(sys.argv[1]).iterdir()):
    examine(str(path), job, Far(lambda word: None))
"""
"""The work of a fleet without the fleet."""


@dataclass(frozen=True, slots=True)
class Task:
    """A program with its arguments."""

    name: str
    command: Sequence[str]
    frames: int
    times: int = 1
    """Runs in a round."""


@dataclass(frozen=True, slots=True)
class Taken:
    """The least that a task took."""

    frames: int
    cpu: float
    wall: float
    peak_mib: float
    instructions: int | None = None


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure made from measured tasks, and its goal."""

    title: str
    of: Callable[[Mapping[str, Taken]], float]
    """Raises KeyError for a task that was not measured."""
    goal: float
    unit: str = "x"
    least: bool = False
    """True if the goal is a maximum."""

    @property
    def wanted(self) -> str:
        """The goal, in words."""
        return f"at {'most' if self.least else 'least'} {self.goal:g} {self.unit}"


def cpu_ratio(base: str, name: str) -> Callable[[Mapping[str, Taken]], float]:
    """Returns the function that divides the CPU time of `base` by that of `name`."""
    return lambda taken: taken[base].cpu / taken[name].cpu


def wall_ratio(base: str, name: str) -> Callable[[Mapping[str, Taken]], float]:
    """Returns the function that divides the wall clock of `base` by that of `name`."""
    return lambda taken: taken[base].wall / taken[name].wall


def start_ms(name: str) -> Callable[[Mapping[str, Taken]], float]:
    """Returns the function for the CPU time of `name` beyond that of Python alone, in ms."""
    return lambda taken: (taken[name].cpu - taken["python -c pass"].cpu) * 1000


FIGURES = (
    Figure("text against tshark's one line, one thread", cpu_ratio("tshark", "text"), 25),
    Figure("text, two threads over one, wall clock", wall_ratio("text", "text, two threads"), 1.8),
    Figure("8 described nodes over none", cpu_ratio("text, described", "text"), 1.3, least=True),
    Figure("8 described nodes, synchronous", cpu_ratio("text, synchronous", "text"), 1.3, least=True),
    Figure("8 described nodes, a description that does not fit", cpu_ratio("text, unfit", "text"), 1.3, least=True),
    Figure("signals to CSV", lambda taken: taken["signals"].frames / taken["signals"].cpu / 1e6, 2.5, "M frames/s"),
    Figure("JSON lines", lambda taken: taken["JSON"].cpu / taken["JSON"].frames * 1e6, 0.6, "s/M frames", least=True),
    Figure("summary against canopen-lens", cpu_ratio("canopen-lens", "summary"), 1.5),
    Figure("check against canopen-lens", cpu_ratio("canopen-lens", "check"), 1.5),
    Figure("MCAP (zstd) to text over candump to text, in speed", cpu_ratio("text", "text, MCAP"), 0.9),
    Figure("start of decode over that of Python", start_ms("decode, ten frames"), 50, "ms", least=True),
    Figure("start of check over that of Python", start_ms("check, ten frames"), 60, "ms", least=True),
    Figure("fleet, two workers over one, wall clock", wall_ratio("fleet", "fleet, two workers"), 1.8),
    Figure(
        f"fleet, CPU time of each of {SMALL:,} small captures beyond the work",
        lambda taken: (taken["fleet, small"].cpu - taken["their work"].cpu) / SMALL * 1000,
        5,
        "ms",
        least=True,
    ),
)
"""The figures, in the order of the table."""


def with_defaults(text: str, values: Mapping[str, str]) -> str:
    """Returns a description with other default values, by the names of sections."""
    for section, value in values.items():
        text, count = re.subn(rf"(?s)(\[{section}\][^\[]*?DefaultValue=)[^\r\n]*", rf"\g<1>{value}", text)
        assert count == 1, section
    return text


def descriptions(directory: Path) -> dict[str, Path]:
    """Writes the description of the drives as it is (synchronous), with events, and with too short a mapping."""
    text = DRIVE.read_text(encoding="utf-8")
    made = {
        "synchronous": text,
        "described": with_defaults(text, dict.fromkeys(("1402sub2", "1802sub2", "1803sub2"), "255")),
        "unfit": with_defaults(text, dict.fromkeys(("1602sub0", "1A02sub0", "1A03sub0"), "1")),
    }
    paths = {name: directory / f"{name}.eds" for name in made}
    for name, path in paths.items():
        path.write_text(made[name], encoding="utf-8")
    return paths


def folder(log: Path, name: str, count: int, frames: int) -> Path:
    """Returns a folder of captures, each the beginning of a capture, and a file of its own by name."""
    path = log.with_name(f"{name}-{count}-{frames}")
    if not path.is_dir():
        unfinished = Path(tempfile.mkdtemp(dir=path.parent))
        first = unfinished / "0.log"
        with log.open() as lines, first.open("w") as out:
            out.writelines(islice(lines, frames))
        for number in range(1, count):
            os.link(first, unfinished / f"{number}.log")
        unfinished.rename(path)
    return path


def tasks(directory: Path, frames: int, lens: str | None) -> tuple[list[Task], dict[str, str]]:
    """Returns the tasks, and why others cannot be measured here."""
    log, mcap = capture(directory, frames), capture(directory, frames, "mcap")
    if log is None:
        sys.exit("the capture could not be made")
    text = [*CANALYZE, "decode", "--threads", "1"]
    made = [
        Task("text", [*text, str(log)], frames),
        Task("text, two threads", [*CANALYZE, "decode", "--threads", "2", str(log)], frames),
        *(
            Task(f"text, {name}", [*text, "--eds", f"1-8={path}", str(log)], frames)
            for name, path in descriptions(directory).items()
        ),
    ]
    eds = str(directory / "described.eds")
    for name, command in {
        "signals": ["signals", "--format", "csv", "--eds", f"1-8={eds}"],
        "JSON": ["decode", "--format", "jsonl"],
        "summary": ["summary"],
        "check": ["check"],
    }.items():
        made.append(Task(name, [*CANALYZE, *command, "--threads", "1", str(log)], frames))
    absent = {}
    if mcap is None:
        absent["text, MCAP"] = "the capture could not be made"
    else:
        made.append(Task("text, MCAP", [*text, str(mcap)], frames))
    peers = {"tshark": [*TSHARK, "-r"], lens or "canopen-lens": ["--lang", "en", "--no-color"]}
    for name, arguments in peers.items():
        program = shutil.which(name) or shutil.which(name, path=str(Path(sys.executable).parent))
        kind = "tshark" if name == "tshark" else "canopen-lens"
        if program is None:
            absent[kind] = "not installed"
        else:
            rest = arguments[1:] if kind == "tshark" else arguments
            made.append(Task(kind, [program, *rest, str(log)], frames))
    made += [
        Task("python -c pass", [sys.executable, "-c", "pass"], 0, START),
        Task("decode, ten frames", [*CANALYZE, "decode", str(SAMPLE)], 10, START),
        Task("check, ten frames", [*CANALYZE, "check", str(SAMPLE)], 10, START),
    ]
    small, large = folder(log, "small", SMALL, 10), folder(log, "large", LARGE, frames // 10)
    fleet = [*CANALYZE, "fleet", "check", "--force", "-o", str(directory / "fleet-out")]
    made += [
        Task("fleet", [*fleet, "--workers", "1", str(large)], LARGE * (frames // 10)),
        Task("fleet, two workers", [*fleet, "--workers", "2", str(large)], LARGE * (frames // 10)),
        Task("fleet, small", [*fleet, "--workers", "2", str(small)], SMALL * 10),
        Task("their work", [sys.executable, "-c", _WORK, str(small)], SMALL * 10),
    ]
    return made, absent


def measured(every: Sequence[Task], rounds: int) -> tuple[dict[str, Taken], dict[str, str]]:
    """Returns what each task took, and why others have no figures."""
    runs: dict[str, list[Measure]] = {task.name: [] for task in every}
    for number in range(rounds):
        for task in every:
            print(f"round {number + 1} of {rounds}: {task.name}", file=sys.stderr, flush=True)
            runs[task.name] += [run(list(task.command)) for _ in range(task.times)]
    taken, failed = {}, {}
    for task in every:
        status = max((one.status for one in runs[task.name]), key=abs)
        if status not in (0, 1):  # 1: something was found
            failed[task.name] = f"ended with {status}"
            continue
        cpu, wall = min(one.cpu for one in runs[task.name]), min(one.wall for one in runs[task.name])
        peak = max(one.peak_kib for one in runs[task.name]) / 1024
        taken[task.name] = Taken(task.frames, cpu, wall, peak, instructions(task.command))
    return taken, failed


def instructions(command: Sequence[str]) -> int | None:
    """Returns the number of instructions of a run, without those of the system; None if they cannot be counted."""
    if shutil.which("perf") is None:
        return None
    with tempfile.NamedTemporaryFile() as file:
        line = ["perf", "stat", "-x,", "-e", "instructions:u", "-o", file.name, "--", *command]
        subprocess.run(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        found = re.search(r"(?m)^(\d+),", Path(file.name).read_text())
    return int(found[1]) if found else None


def document(taken: Mapping[str, Taken], absent: Mapping[str, str], about: Sequence[str]) -> str:
    """Returns the tables. absent: reasons, by the names of tasks that were not measured."""
    counted = any(one.instructions for one in taken.values())
    lines = ["# Figures", "", "Written by `python tests/bench/figures.py`, which says how each is measured.", ""]
    lines += [f"- {line}" for line in about]
    if not counted:
        lines.append("- instructions: left out, `perf stat` counts none on this machine")
    lines += ["", "| figure | measured | goal | |", "|---|---|---|---|"]
    for figure in FIGURES:
        try:
            value = figure.of(taken)
        except KeyError as missing:
            name = str(missing.args[0])
            lines.append(f"| {figure.title} | {name}: {absent.get(name, 'not measured')} | {figure.wanted} | |")
            continue
        met = value <= figure.goal if figure.least else value >= figure.goal
        shown = f"{value:.{max(0, 2 - int(math.log10(max(abs(value), 1))))}f} {figure.unit}"
        lines.append(f"| {figure.title} | {shown} | {figure.wanted} | {'met' if met else 'not met'} |")
    heads = ["program", "frames", "CPU s", "wall s", "frames/s of CPU", "peak MiB"]
    heads += ["instructions/frame"] if counted else []
    lines += ["", f"| {' | '.join(heads)} |", f"|---{'|--:' * (len(heads) - 1)}|"]
    for name, one in taken.items():
        rate = f"{one.frames / one.cpu:,.0f}" if one.frames > 10 else "-"
        cells = [name, f"{one.frames:,}", f"{one.cpu:.3f}", f"{one.wall:.3f}", rate, f"{one.peak_mib:.0f}"]
        if counted:
            cells.append(f"{one.instructions / max(one.frames, 1):,.0f}" if one.instructions else "-")
        lines.append(f"| {' | '.join(cells)} |")
    lines += [f"| {name} | {reason} |{' |' * (len(heads) - 2)}" for name, reason in absent.items()]
    return "\n".join(lines) + "\n"


def processor() -> str:
    """Returns the model of the processor."""
    info = Path("/proc/cpuinfo")
    found = re.search(r"(?m)^model name\s*:\s*(.+)$", info.read_text()) if info.exists() else None
    return found[1].strip() if found else platform.processor() or platform.machine()


def main() -> None:
    """The command line."""
    from canalyze import __version__

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="100,000 frames and two rounds")
    parser.add_argument("--frames", type=int, help="frames in the capture (default: 1000000)")
    parser.add_argument("--repeat", type=int, help="rounds; the least counts (default: 5)")
    parser.add_argument("--lens", help="canopen-lens, if it is installed elsewhere")
    parser.add_argument("--directory", type=Path, default=Path(tempfile.gettempdir()) / "canalyze-bench")
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    options = parser.parse_args()
    frames = options.frames or (100_000 if options.quick else 1_000_000)
    rounds = options.repeat or (2 if options.quick else 5)
    options.directory.mkdir(parents=True, exist_ok=True)
    every, absent = tasks(options.directory, frames, options.lens)
    before = os.getloadavg()[0]
    taken, failed = measured(every, rounds)
    about = (
        f"canalyze {__version__}, {datetime.now(UTC):%Y-%m-%d}",
        f"{processor()}, {os.cpu_count()} processors, load {before:.1f} before and {os.getloadavg()[0]:.1f} after",
        f"{frames:,} frames, the least of {rounds} rounds",
    )
    text = document(taken, absent | failed, about)
    options.output.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
