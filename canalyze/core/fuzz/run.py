"""Runs fuzz targets and keeps a small corpus: `python run.py 3600 sdo network`, then `python run.py --keep`.

Why it exists: the rate decides what fuzzing finds. The crate has no unsafe code, so an address sanitizer finds nothing
in it and costs two thirds of the executions; libFuzzer's entropic schedule searches a list for each of the 20,000
features of an execution; and memory that is handed back to the system after each session is asked for again.

A run begins with the seeds of `seeds.py` and with what `kept/` holds: a line of hexadecimal digits for each input.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

assert sys.platform != "win32"  # libFuzzer's programs, and the times of a process

HERE = Path(__file__).resolve().parent
CORPUS, KEPT, FOUND = HERE / "corpus", HERE / "kept", HERE / "artifacts"
TARGETS = ("network", "sdo", "usdo", "rows", "blf", "trc")
LONGEST = 400
"""Bytes of an input: enough for some thirty frames. `description` and readers of packed files want more."""
MOST_KEPT = 24_000
"""Bytes of all inputs of a target that are kept."""
_FLAGS = (
    f"-max_len={LONGEST}",
    "-entropic=0",
    "-print_funcs=0",
    "-print_final_stats=1",
    "-timeout=20",
    "-rss_limit_mb=1500",
)
_KEEPING = {"MALLOC_TRIM_THRESHOLD_": "268435456", "MALLOC_MMAP_THRESHOLD_": "67108864"}


class Ran(NamedTuple):
    """A run of one target."""

    target: str
    process: subprocess.Popen[bytes]
    log: Path


def build(targets: list[str]) -> Path:
    """Builds the targets and returns the folder of their programs."""
    environment = os.environ | {"RUSTC_BOOTSTRAP": "1"}
    for target in targets:
        subprocess.run(["cargo", "fuzz", "build", "-s", "none", target], cwd=HERE.parent, env=environment, check=True)
    place = Path(os.environ.get("CARGO_TARGET_DIR", HERE / "target"))
    (found,) = place.glob("*/release")
    return found


def unpack(target: str) -> Path:
    """Writes the kept inputs of a target into its corpus, a file each, and returns its folder."""
    place = CORPUS / target
    place.mkdir(parents=True, exist_ok=True)
    kept = KEPT / f"{target}.txt"
    for number, line in enumerate(kept.read_text().split() if kept.exists() else ()):
        (place / f"kept-{number}").write_bytes(bytes.fromhex(line))
    return place


def start(programs: Path, target: str, seconds: int) -> Ran:
    """Starts a target for so long."""
    FOUND.mkdir(exist_ok=True)
    log = FOUND / f"{target}.log"
    command: list[str | Path] = [
        programs / target,
        *_FLAGS,
        f"-max_total_time={seconds}",
        f"-artifact_prefix={FOUND}/{target}-",
        unpack(target),
    ]
    with log.open("wb") as out:
        process = subprocess.Popen(command, stdout=out, stderr=out, env=os.environ | _KEEPING)
    return Ran(target, process, log)


def end(ran: Ran) -> bool:
    """Waits for a run, prints its figures and returns true if it found nothing."""
    _, status, used = os.wait4(ran.process.pid, 0)
    text = ran.log.read_text(errors="replace")
    runs = re.search(r"number_of_executed_units: (\d+)", text)
    coverage = re.findall(r"cov: (\d+) ft: (\d+)", text)
    count, seconds = int(runs[1]) if runs else 0, used.ru_utime + used.ru_stime
    edges, features = coverage[-1] if coverage else ("0", "0")
    failed = "" if status == 0 else f", FAILED: {ran.log}"
    rate = count / seconds if seconds else 0
    print(
        f"{ran.target}: {count} executions, {seconds:.0f} s of CPU, {rate:.0f} a second of CPU, "
        f"{edges} edges, {features} features{failed}",
        flush=True,
    )
    return status == 0


def keep(programs: Path, target: str) -> None:
    """Writes the smallest inputs that reach all edges which the corpus reaches, up to [`MOST_KEPT`] bytes."""
    smallest = CORPUS / f"{target}.smallest"
    smallest.mkdir(exist_ok=True)
    command: list[str | Path] = [
        programs / target,
        "-set_cover_merge=1",
        "-use_counters=0",
        f"-max_len={LONGEST}",
        smallest,
        CORPUS / target,
    ]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    inputs = sorted((path.read_bytes() for path in smallest.iterdir()), key=lambda one: (len(one), one))
    lines, size = [], 0
    for one in inputs:
        size += len(one)
        if size > MOST_KEPT:
            break
        lines.append(one.hex() + "\n")
    KEPT.mkdir(exist_ok=True)
    (KEPT / f"{target}.txt").write_text("".join(lines))
    print(f"{target}: {len(lines)} of {len(inputs)} inputs kept")


def main() -> int:
    """Runs the targets, `--jobs` at a time; returns 1 if one of them failed."""
    said = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    said.add_argument("seconds", type=int, nargs="?", default=60, help="time for each target (default 60)")
    said.add_argument("targets", nargs="*", help=f"default: {' '.join(TARGETS)}")
    said.add_argument("--jobs", type=int, default=2, help="targets that run at once (default 2)")
    said.add_argument("--keep", action="store_true", help="writes kept/ from corpus/ in place of a run")
    given = said.parse_args()
    targets = given.targets or list(TARGETS)
    programs = build(targets)
    if given.keep:
        for target in targets:
            keep(programs, target)
        return 0
    subprocess.run([sys.executable, HERE / "seeds.py", CORPUS], check=True)
    running: list[Ran] = []
    fine = True
    while targets or running:
        while targets and len(running) < given.jobs:
            running.append(start(programs, targets.pop(0), given.seconds))
        ended = [one for one in running if os.waitid(os.P_PID, one.process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)]
        for one in ended:
            fine &= end(one)
            running.remove(one)
        time.sleep(0.5)
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
