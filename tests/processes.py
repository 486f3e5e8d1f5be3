"""Processes as the kernel sees them: all that came from one, and whether they have done what there is to do.

Why it exists: a test that has to wait until a program has taken what it was given would else wait for a time, which is
too long on one machine and too short on another. What it must not do: know what the processes do.
"""

from __future__ import annotations

import fcntl
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

DEADLINE_S = 60.0
_STILL_S = 0.1


_PEAK = """
import sys
from canalyze.cli import main
main(sys.argv[1:])
sys.stderr.write(next(line for line in open("/proc/self/status") if line.startswith("VmHWM")).split()[1])
"""


def peak_kib(folder: Path, *args: str) -> int:
    """The most memory that a command line has taken, in KiB; the command must not say anything else."""
    line = [sys.executable, "-c", _PEAK, *args]
    return int(subprocess.run(line, capture_output=True, check=True, cwd=folder).stderr)


def tree(root: int) -> set[int]:
    """The process and all that came from it and are still there."""
    parents: dict[int, int] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(path.parent.name)] = int(path.read_text().rpartition(")")[2].split()[1])
        except (OSError, ValueError):
            continue
    found = {root}
    while more := {child for child, parent in parents.items() if parent in found} - found:
        found |= more
    return found


def wait_until_idle(root: int, *, unread: int | None = None) -> None:
    """Waits until nothing is left in a pipe (its descriptor) and every thread of the tree has slept for a moment."""
    end = time.monotonic() + DEADLINE_S
    before = None
    while (now := _threads(root)) != before or (unread is not None and _bytes_in(unread)):
        assert time.monotonic() < end, "it goes on and on"
        before = now
        time.sleep(_STILL_S)


def _threads(root: int) -> object:
    """How often each thread was given a processor by now; something that equals nothing while one wants it."""
    found = {}
    for process in tree(root):
        for path in Path(f"/proc/{process}/task").glob("*/status"):
            try:
                status = dict(line.split(":", 1) for line in path.read_text().splitlines() if ":" in line)
            except OSError:
                return object()
            if status["State"].split()[0] not in "SZ":
                return object()
            found[path] = status["voluntary_ctxt_switches"], status["nonvoluntary_ctxt_switches"]
    return found


def _bytes_in(pipe: int) -> int:
    (size,) = struct.unpack("@i", fcntl.ioctl(pipe, termios.FIONREAD, b"\0" * 4))
    return int(size)
