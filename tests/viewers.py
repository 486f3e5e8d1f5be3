"""Viewers that canalyze starts, seen from outside: what a tree of processes listens on, and what a viewer was sent.

The kernel says who listens (/proc/net/tcp and the open files of each process), not the program under test. What it must
not do: start canalyze.
"""

from __future__ import annotations

import random
import re
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing, suppress
from ipaddress import ip_address
from pathlib import Path
from typing import TypeVar

import pytest
import rerun_cli  # type: ignore[import-untyped]
from processes import tree

T = TypeVar("T")

DEADLINE_S = 60.0
"""For what a user would see within seconds; a loaded machine may take its time."""
LISTENS = "0A"
"""The state of a socket that listens, as the kernel writes it."""

PROGRAM = Path(rerun_cli.__file__).with_name("rerun")

on_linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the kernel is asked by /proc")


def soon(find: Callable[[], T | None], what: str, *, within_s: float = DEADLINE_S) -> T:
    """Waits until it gives something, and fails with `what` where it does not."""
    end = time.monotonic() + within_s
    while not (found := find()):
        if time.monotonic() > end:
            pytest.fail(f"not within {within_s:g} s: {what}")
        time.sleep(0.05)
    return found


def free_pair() -> int:
    """A port on which nobody listens, nor on the next one; none of those that the system gives by itself."""
    while True:
        page = random.randrange(15_000, 30_000)
        with suppress(OSError), closing(socket.create_server(("127.0.0.1", page))):
            socket.create_server(("127.0.0.1", page + 1)).close()
            return page


def viewer_of(root: int) -> int | None:
    """The viewer among the process's children."""
    for one in tree(root) - {root}:
        try:
            if Path(f"/proc/{one}/cmdline").read_bytes().split(b"\0")[0].endswith(b"/rerun"):
                return one
        except OSError:
            continue
    return None


def listeners(root: int) -> set[tuple[str, int]]:
    """Every address with its port on which any process of the tree listens, of every protocol of the internet."""
    held = set()
    for one in tree(root):
        for entry in Path(f"/proc/{one}/fd").glob("*"):
            try:
                held |= set(re.findall(r"socket:\[(\d+)\]", str(entry.readlink())))
            except OSError:
                continue
    found = set()
    tables = [path for path in map(Path("/proc/net").joinpath, ("tcp", "tcp6", "udp", "udp6")) if path.exists()]
    for table in tables:
        for line in table.read_text().splitlines()[1:]:
            local, _, state, *_rest = line.split()[1:]
            inode = line.split()[9]
            if inode in held and (state == LISTENS or table.name.startswith("udp")):
                address, _, port = local.partition(":")
                words = [bytes.fromhex(address[at : at + 8])[::-1] for at in range(0, len(address), 8)]
                found.add((str(ip_address(b"".join(words))), int(port, 16)))
    return found


def sent_to(connect: str, path: Path, enough: Callable[[Path], bool]) -> None:
    """Writes what a viewer of the web was sent, by Rerun's own program, once there is enough of it."""
    raw = path.with_suffix(".raw.rrd")
    line = [str(PROGRAM), connect, "--save", str(raw), "--bind", "127.0.0.1", "--port", "auto"]
    end = time.monotonic() + DEADLINE_S
    while time.monotonic() < end:
        with subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as saving:
            _settled(raw)
            saving.terminate()
        ordered = subprocess.run(
            [str(PROGRAM), "rrd", "optimize", "-o", str(path), str(raw)], capture_output=True, check=False
        )
        if ordered.returncode == 0 and enough(path):
            return
    pytest.fail("the viewer was not sent what is on the bus")


def _settled(path: Path) -> None:
    """Waits until a file is there and no longer grows, which does not mean that all is in it."""
    seen, end = 0, time.monotonic() + 10
    while time.monotonic() < end:
        time.sleep(0.3)
        size = path.stat().st_size if path.exists() else 0
        if size and size == seen:
            return
        seen = size
