"""A flood on vcan0 with candump and sniff beside each other: what each of them saw, and at what cost.

    PYTHONPATH=tests python tests/live/flood.py [--seconds S] [--gap MS] [--senders N] [--format F] [--record FORM]...

Prints one JSON object: the rate, frames that the bus carried, that candump logged, and that sniff recorded and showed,
and the CPU seconds of both. `test_flood.py` runs it for a short while; the rate that candump holds is found by hand.
What it must not do: judge.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from listeners import LAST, Listener, Listeners, cansend, wait_until

PATIENCE_S = 120.0


def carried() -> int:
    """Frames that vcan0 has carried."""
    return int(Path("/sys/class/net/vcan0/statistics/tx_packets").read_text())


def lines(path: Path, *, without: bytes = b"\0") -> int:
    """Lines of a file that is too long for memory, but for those with this word."""
    with path.open("rb") as file:
        return sum(without not in line for line in file)


def flood(
    directory: Path, *, seconds: float, gap: str, senders: int, form: str, records: Sequence[str]
) -> dict[str, Any]:
    """Runs it; what was seen, in numbers. The files stay in the directory."""
    bus = Listeners(directory)
    options = [option for suffix in records for option in ("--record", f"flood.{suffix}")]
    stamps = ["-t", "a"] if form == "text" else []
    try:
        sniff = bus.sniff("vcan0", "--format", form, *stamps, *options, name="sniff")
        candump = bus.candump("vcan0", options=("-l", "-d"), name="candump")
        before, cpu = carried(), (sniff.cpu_s(), candump.cpu_s())
        began = time.monotonic()
        running = [
            subprocess.Popen(["cangen", "vcan0", "-g", gap, "-I", "123", "-L", "8"], stdout=subprocess.DEVNULL)
            for _ in range(senders)
        ]
        time.sleep(seconds)
        for sender in running:
            sender.kill()
            sender.wait()
        took = time.monotonic() - began
        cansend("vcan0", LAST)
        frames = carried() - before
        caught_up = behind(sniff, directory)
        spent = (sniff.cpu_s() - cpu[0], candump.cpu_s() - cpu[1])
        ended = sniff.stop()
        candump.stop()
    finally:
        bus.close()
    (log,) = directory.glob("candump-*.log")
    return {
        "seconds": round(took, 1),
        "rate": round(frames / took),
        "carried": frames,
        "candump": lines(log, without=b"DROPCOUNT"),
        "shown": lines(sniff.out_path, without=b"DROPCOUNT"),
        "cpu_s": {"sniff": round(spent[0], 2), "candump": round(spent[1], 2)},
        "caught_up_s": round(caught_up, 2),
        "exit": ended.code,
        "log": str(log),
        "complaints": ended.err.splitlines(),
    }


def behind(sniff: Listener, directory: Path) -> float:
    """Waits until the last frame is shown; how long that took."""
    began = time.monotonic()

    def last_is_shown() -> bool:
        with sniff.out_path.open("rb") as file:
            file.seek(max(0, file.seek(0, 2) - 4096))
            end = file.read()
        return b"4C 41 53 54" in end or b"4C415354" in end

    wait_until(last_is_shown, "the last frame", within_s=PATIENCE_S)
    return time.monotonic() - began


def main() -> None:
    """One measurement by the command line."""
    parser = argparse.ArgumentParser(description="A flood, with candump and sniff beside each other.")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--gap", default="0.02")
    parser.add_argument("--senders", type=int, default=1)
    parser.add_argument("--format", default="text", choices=["text", "jsonl"])
    parser.add_argument("--record", action="append", default=[])
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        told = flood(
            Path(scratch),
            seconds=given.seconds,
            gap=given.gap,
            senders=given.senders,
            form=given.format,
            records=given.record,
        )
        told["recorded"] = {form: lines(Path(scratch, f"flood.{form}")) for form in given.record if form == "log"}
    print(json.dumps(told, indent=1))


if __name__ == "__main__":
    main()
