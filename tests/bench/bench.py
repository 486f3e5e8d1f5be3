"""Speed, memory and start-up of canalyze beside other programs on the same capture, in one run.

    python tests/bench/bench.py [--frames 1000000] [--repeat 3] [--directory DIR] [--only WHICH]

Makes (once; kept in DIR, by default below the system's temporary directory) a capture in `candump -l` form that is
the same on every machine: eight drives as `eds/drive.eds` presets them, SYNC every 10 ms, 88 % PDO, 7.6 % SDO
(expedited, segmented, block, aborts), heartbeats and some EMCY; a million frames are about 45 MB. Then runs each
program that is installed over it, output to /dev/null, and prints frames per second of CPU time (best of the
repeats), the ratio to tshark's one-line summary, and the peak of memory. Slow programs get the beginning of the
capture only, and the table says how much. A second table has the same capture in every format, each file written by
another program, beside that format's usual reader in Python. A third one has what is made of a capture beside text:
check, expect, diff, columns, the library, beside python-can's reader of the same file; and exports to Parquet beside
decode to JSON lines, with the sizes of the files. A fourth one has the same frames
as a live bus gives them, without the bus: to text, to recordings, to the screen's session, beside decode of the log.
A fifth one has the timeline: `canalyze view --save` beside decode to text with the same descriptions, of that capture
and of one of eight I/O blocks with four analogue inputs in nearly every frame, and the samples of signals a second.
WHICH is one of all, candump, formats, judged, live, timeline.
Only ratios of one run mean anything: machines are shared. Peak memory cannot be measured below what this script
itself takes, which is printed as the floor.

Not a test: nothing here passes or fails.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import zstandard
from bench_captures import MAKERS, capture

ROOT = Path(__file__).resolve().parents[2]
DRIVE = ROOT / "eds" / "drive.eds"
SAMPLE = ROOT / "samples" / "zephyr-sdo.log"


@dataclass(frozen=True, slots=True)
class Contestant:
    """A program and what it does with the capture, whose path goes to the end of its arguments or to stdin."""

    name: str
    command: list[str]
    most_frames: int = sys.maxsize
    on_stdin: bool = False
    suffix: str = "log"
    """The form in which it gets the capture."""
    twice: bool = False
    """Whether it gets a copy of the capture too."""
    of: str = "capture"
    """Whose capture it gets: of drives, or of inputs."""


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


ALONE = "import sys; sys.modules['asammdf'] = None; import can, collections; "
"""python-can without a library of its own formats that takes two seconds to load."""
EXHAUST = "collections.deque({}, maxlen=0)"


def iterating(python: str, start: str = ALONE) -> list[str]:
    """A program that does nothing but take every frame of a file."""
    return [sys.executable, "-c", start + EXHAUST.format(python)]


CANDUMP_TO_TEXT = "canalyze decode, candump"
ASC_TO_TEXT = "canalyze decode, ASC"
MCAP_TO_TEXT = "canalyze decode, MCAP (zstd)"
ASC_ITERATED = "python-can iterating ASC"

FORMATS = [
    Contestant(CANDUMP_TO_TEXT, [*CANALYZE, "decode"]),
    Contestant(ASC_TO_TEXT, [*CANALYZE, "decode"], suffix="asc"),
    Contestant("canalyze decode, ASC.gz", [*CANALYZE, "decode"], suffix="asc.gz"),
    Contestant(MCAP_TO_TEXT, [*CANALYZE, "decode"], suffix="mcap"),
    Contestant("canalyze decode, pcapng", [*CANALYZE, "decode"], suffix="pcapng"),
    Contestant("canalyze decode, BLF", [*CANALYZE, "decode"], suffix="blf"),
    Contestant(ASC_ITERATED, iterating("can.ASCReader(sys.argv[1])"), suffix="asc"),
    Contestant("python-can iterating BLF", iterating("can.BLFReader(sys.argv[1])"), suffix="blf"),
    Contestant(
        "python mcap, raw messages",
        iterating(
            "make_reader(open(sys.argv[1], 'rb')).iter_messages(log_time_order=False)",
            "import sys, collections; from mcap.reader import make_reader; ",
        ),
        suffix="mcap",
    ),
    Contestant("tshark of pcapng, one line each", [*TSHARK, "-r"], suffix="pcapng"),
]
_COLUMNS = """
from canalyze import _core
from canalyze.running.reading import SessionOptions
session = _core.Session(SessionOptions(format="columns", tables=_core.TABLES))
session.begin("capture", True)
with open(sys.argv[1], "rb") as source:
    while data := source.read(1 << 20):
        session.feed(data)
        session.batches()
session.end()
session.finish()
session.batches()
"""
LIBRARY = "import sys, collections, canalyze; "
CHECKED = "canalyze check"
ITERATED = "canalyze.open(), iterated"
JSON = "canalyze decode --format jsonl --eds"
LOG_ITERATED = "python-can iterating candump"

JUDGED = [
    Contestant(CANDUMP_TO_TEXT, [*CANALYZE, "decode"]),
    Contestant(CHECKED, [*CANALYZE, "check"]),
    Contestant("canalyze expect", [*CANALYZE, "expect"]),
    Contestant("canalyze diff, with itself again", [*CANALYZE, "diff"], twice=True),
    Contestant("columns, all tables", [sys.executable, "-c", f"import sys{_COLUMNS}"]),
    Contestant(ITERATED, iterating("canalyze.open(sys.argv[1])", LIBRARY)),
    Contestant("canalyze.open().events", iterating("canalyze.open(sys.argv[1]).events", LIBRARY)),
    Contestant("canalyze.open().transfers", iterating("canalyze.open(sys.argv[1]).transfers", LIBRARY)),
    Contestant("canalyze.open().snapshot()", iterating("canalyze.open(sys.argv[1]).snapshot()", LIBRARY)),
    Contestant(LOG_ITERATED, iterating("can.CanutilsLogReader(sys.argv[1])")),
]
"""What is made of a capture beside text."""
_LIVE = """
import os, sys
from canalyze import _core
from canalyze.running.reading import SessionOptions
session = _core.Session(SessionOptions({settings}))
session.begin("live", False, "live")
with open(sys.argv[1], "rb") as source, open(os.devnull, "wb") as out:
    while data := source.read(1 << 16):
        out.write(session.feed(data))
        {further}
    out.write(session.end() + session.finish())
sys.exit(session.frames == 0)
"""
_RECORDED = """
import sys, tempfile
from canalyze.running.recording import Recording
from canalyze.words import Words
with open(sys.argv[1], "rb") as source, tempfile.TemporaryDirectory() as folder:
    recording = Recording(folder + "/bus{suffix}", Words("en"))
    while data := source.read(1 << 16):
        recording.take(data)
    recording.close()
    sys.exit(recording.written.frames == 0)
"""


def listened(settings: str, further: str = "") -> list[str]:
    """A session of these settings that is fed what a live bus gives."""
    return [sys.executable, "-c", _LIVE.format(settings=settings, further=further)]


LIVE = [
    Contestant(CANDUMP_TO_TEXT, [*CANALYZE, "decode"]),
    Contestant("live to text", listened(""), suffix="live"),
    Contestant("live to JSON lines", listened('format="jsonl"'), suffix="live"),
    Contestant("live to the screen's session", listened('format="monitor"'), suffix="live"),
    Contestant("the same, snapshot each 64 KiB", listened('format="monitor"', "session.snapshot()"), suffix="live"),
    *(
        Contestant(
            f"live to a recording, {suffix}", [sys.executable, "-c", _RECORDED.format(suffix=suffix)], suffix="live"
        )
        for suffix in (".log", ".asc", ".mcap", ".pcapng")
    ),
]
"""What a live bus gives, without the bus."""
GOALS = [
    ("ASC to text / python-can iterating ASC", ASC_TO_TEXT, ASC_ITERATED, 10.0),
    ("MCAP to text / candump to text", MCAP_TO_TEXT, CANDUMP_TO_TEXT, 0.8),
]
"""What is divided by what, and what it should be at least."""


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
    if contestant.twice:  # the same file under another name
        again = path.with_name(f"again-{path.name}")
        if not again.exists():
            again.symlink_to(path.name)
        command.append(str(again))
    runs = [run(command, path if contestant.on_stdin else None) for _ in range(repeat)]
    return min(runs, key=lambda measure: measure.cpu)


ONLY = ("all", "candump", "formats", "judged", "live", "timeline")
"""Which tables there are."""
Rates = dict[str, tuple[float, Measure, int]]
"""By the name of a contestant: frames per second of CPU time, what was measured, and of how many frames."""


def compete(contestants: list[Contestant], directory: Path, frames: int, repeat: int) -> Rates:
    """All of them, one after the other; who cannot run is named."""
    rates: Rates = {}
    for contestant in contestants:
        count = min(frames, contestant.most_frames)
        path = (
            None if (reason := available(contestant)) else capture(directory, count, contestant.suffix, contestant.of)
        )
        if path is None:
            print(f"{contestant.name}: {reason or f'no {contestant.suffix} capture'}")
            continue
        measure = best_of(contestant, path, 1 if count < frames else repeat)
        if measure.status:
            print(f"{contestant.name}: ended with {measure.status}")
            continue
        rates[contestant.name] = (count / max(measure.cpu, 1e-3), measure, count)
    return rates


def show(rates: Rates, frames: int, base_name: str, base_title: str) -> None:
    """The table, with the ratio to one of them."""
    base = rates.get(base_name)
    print(f"\n{'program':32} {'frames':>10} {'CPU s':>8} {'frames/s':>12} {base_title:>9} {'peak MiB':>9}")
    for name, (rate, measure, count) in rates.items():
        ratio = f"{rate / base[0]:.2f}" if base else "-"
        shown = f"{count}{'' if count == frames else ' *'}"
        print(f"{name:32} {shown:>10} {measure.cpu:8.2f} {rate:12,.0f} {ratio:>9} {measure.peak_kib / 1024:9.1f}")


def measure_speed(directory: Path, frames: int, repeat: int) -> None:
    """The table of all programs."""
    show(compete(CONTESTANTS, directory, frames, repeat), frames, "tshark (one line a frame)", "x tshark")
    floor = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"* the beginning of the capture only.  Memory below {floor:.1f} MiB (this script) cannot be seen.")


def measure_formats(directory: Path, frames: int, repeat: int) -> None:
    """The table of formats, and what the ratios should be."""
    for suffix, (maker, _) in MAKERS.items():
        path = capture(directory, frames, suffix)
        size = f"{path.stat().st_size / 1e6:8.1f} MB" if path else "  missing"
        print(f"{suffix:8} {size}, written by {maker}")
    rates = compete(FORMATS, directory, frames, repeat)
    show(rates, frames, CANDUMP_TO_TEXT, "x candump")
    for title, ours, base, goal in GOALS:
        if ours in rates and base in rates:
            print(f"{title}: {rates[ours][0] / rates[base][0]:.2f} (goal: at least {goal:g})")
        else:
            print(f"{title}: not measured (goal: at least {goal:g})")


def measure_judging(directory: Path, frames: int, repeat: int) -> None:
    """The table of what is made of a capture beside text, and that of what is exported."""
    rates = compete(JUDGED, directory, frames, repeat)
    show(rates, frames, CANDUMP_TO_TEXT, "x decode")
    if ITERATED in rates and LOG_ITERATED in rates:
        print(f"{ITERATED} / {LOG_ITERATED}: {rates[ITERATED][0] / rates[LOG_ITERATED][0]:.2f}")
    described, lines = ["--eds", f"1-8={DRIVE}", "--force", "-o"], str(directory / "decoded.jsonl")
    some, whole = directory / "lake", directory / "lake-of-all"
    tables = ["--table", "frames", "--table", "signals"]
    exports = [
        Contestant(JSON, [*CANALYZE, "decode", "--format", "jsonl", *described, lines]),
        Contestant("canalyze export, frames and signals", [*CANALYZE, "export", *tables, *described, str(some)]),
        Contestant("canalyze export, all tables", [*CANALYZE, "export", *described, str(whole)]),
    ]
    show(compete(exports, directory, frames, repeat), frames, JSON, "x JSON")
    log = directory / f"capture-{frames}.log"
    with log.open("rb") as source, Path(os.devnull).open("wb") as nowhere:
        _, packed = zstandard.ZstdCompressor(3).copy_stream(source, nowhere)
    print(f"{log.name}: {log.stat().st_size / 1e6:.1f} MB, {packed / 1e6:.1f} MB by zstd")
    for folder in (some, whole):
        size = sum(path.stat().st_size for path in folder.rglob("*.parquet"))
        print(f"{folder.name}: {size / 1e6:.1f} MB, {size / packed:.2f} x that")


IO = DRIVE.with_name("io.eds")


def measure_timeline(directory: Path, frames: int, repeat: int) -> None:
    """The table of the timeline, and how many samples of signals go into it a second."""
    for of, eds in (("capture", DRIVE), ("inputs", IO)):
        described = ["--eds", f"1-8={eds}"]
        made = directory / "timeline.rrd"
        text, whole = f"canalyze decode --eds, {eds.stem}s", f"canalyze view --save, {eds.stem}s"
        summary = f"canalyze summary --eds, {eds.stem}s"
        view = ["view", *described, "--force", "--save", str(made)]
        contestants = [
            Contestant(text, [*CANALYZE, "decode", *described], of=of),
            Contestant(summary, [*CANALYZE, "summary", *described], of=of),
            Contestant(whole, [*CANALYZE, *view], of=of),
        ]
        rates = compete(contestants, directory, frames, repeat)
        show(rates, frames, text, "x decode")
        if whole not in rates or summary not in rates:
            return
        count, taken, waited = samples(made), rates[whole][1].cpu, rates[whole][1].wall
        small = ["--force", "--save", str(made.with_name("small.rrd")), str(SAMPLE)]
        start = run([*CANALYZE, "view", *small]).cpu - run([*CANALYZE, "summary", str(SAMPLE)]).cpu
        # Rerun's threads work while frames are read: only all of the CPU time tells what they cost.
        added = taken - rates[summary][1].cpu - start
        print(f"{made.name}: {made.stat().st_size / 1e6:.1f} MB, {count:,} samples of signals; a second:")
        print(f"{'by all of the command, as one waits for it':56} {count / waited:12,.0f}")
        print(f"{'by all of the command, of CPU time':56} {count / taken:12,.0f}")
        print(f"{'by what it adds to summary and to start (goal: 1,000,000)':56} {count / max(added, 1e-3):12,.0f}")


def samples(recording: Path) -> int:
    """How many values of signals stand in a recording; none is no value."""
    import pyarrow.compute as pc
    from rerun.chunk import RrdReader

    reader = RrdReader(str(recording))
    count = 0
    for chunk in reader.stream(store=reader.recordings()[0]).filter(content="/pdo/**", is_static=False):
        batch = chunk.to_record_batch()
        if "Scalars:scalars" in batch.schema.names:
            values = batch.column("Scalars:scalars").flatten()
            count += len(values) - pc.sum(pc.is_nan(values)).as_py()
    return count


def measure_start(repeat: int) -> None:
    """Start-up: the sample of ten frames, beside the least a command line program in Python can take."""
    commands = {
        "python -c pass": [sys.executable, "-c", "pass"],
        'python -c "import click"': [sys.executable, "-c", "import click"],
        f"canalyze decode {SAMPLE.name}": [*CANALYZE, "decode", str(SAMPLE)],
        f"canalyze {SAMPLE.name}": [*CANALYZE, str(SAMPLE)],
        f"canalyze check {SAMPLE.name}": [*CANALYZE, "check", str(SAMPLE)],
        "canalyze --help": [*CANALYZE, "--help"],
    }
    print(f"\nstart-up, CPU time and wall clock, median of {repeat} (goal of decode: 60 ms more than Python alone)")
    for name, command in commands.items():
        runs = [run(command) for _ in range(repeat)]
        if any(measure.status for measure in runs):
            print(f"{name:32} does not run")
        else:
            cpu, wall = (statistics.median(getattr(one, of) for one in runs) * 1000 for of in ("cpu", "wall"))
            print(f"{name:32} {cpu:8.1f} ms {wall:8.1f} ms")


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=1_000_000, help="frames in the capture (default: 1000000)")
    parser.add_argument("--repeat", type=int, default=3, help="runs of each program; the best counts (default: 3)")
    parser.add_argument("--directory", type=Path, default=Path(tempfile.gettempdir()) / "canalyze-bench")
    parser.add_argument("--only", choices=ONLY, default="all", help="which tables")
    options = parser.parse_args()
    options.directory.mkdir(parents=True, exist_ok=True)
    path = capture(options.directory, options.frames)
    if path is None:
        sys.exit("the capture could not be made")
    print(f"{path.name}: {options.frames} frames, {path.stat().st_size / 1e6:.1f} MB")
    wanted = ONLY if options.only == "all" else (options.only,)
    if "candump" in wanted:
        measure_speed(options.directory, options.frames, options.repeat)
    if "formats" in wanted:
        measure_formats(options.directory, options.frames, options.repeat)
    if "judged" in wanted:
        measure_judging(options.directory, options.frames, options.repeat)
    if "live" in wanted:
        show(
            compete(LIVE, options.directory, options.frames, options.repeat),
            options.frames,
            CANDUMP_TO_TEXT,
            "x decode",
        )
    if "timeline" in wanted:
        measure_timeline(options.directory, options.frames, options.repeat)
    if options.only == "all":
        measure_start(15)


if __name__ == "__main__":
    main()
