"""What workers of a fleet do in its tests: they leave a trace, and some end their own process.

Why it exists: other processes find their work by its module. Must not: need pytest.
"""

from __future__ import annotations

import os
import signal
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from canalyze.fleet import task
from canalyze.fleet.task import Manifest, Piece, Work
from canalyze.running.pool import Ended, Tell


@dataclass(frozen=True)
class Traced:
    """The work on a capture, between two lines of a trace; `poison` in its name kills the process, each time."""

    work: Work
    trace: str
    seconds: float = 0.0

    def __call__(self, piece: Piece, tell: Tell) -> Manifest:
        name = Path(piece.capture.name).name
        self._write("begun", name)
        if "poison" in name:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.seconds)
        done = task.do(self.work, piece, tell)
        self._write("ended", name)
        return done

    def _write(self, what: str, name: str) -> None:
        with Path(self.trace).open("a") as file:
            file.write(f"{what} {name} {os.getpid()} {os.getppid()}\n")


class Here:
    """An executor that does the pieces in this process, one after the other, in the order in which they came."""

    width = 1

    def __init__(self, work: Any, *_: Any, **__: Any) -> None:
        """Begins without pieces."""
        self._work = work
        self._pieces: list[Any] = []

    def submit(self, piece: Any) -> None:
        """Submits a piece."""
        self._pieces.append(piece)

    def completed(self) -> Iterator[Ended]:
        """Yields the pieces as they end."""
        while self._pieces:
            piece = self._pieces.pop(0)
            yield Ended(piece, self._work(piece, lambda word: None))

    def close(self) -> None:
        """Does nothing."""


def trace(path: Path) -> list[list[str]]:
    """The lines of a trace: what, name, process, its parent."""
    return [line.split() for line in path.read_text().splitlines()] if path.exists() else []


def counts(path: Path, what: str) -> Counter[str]:
    """How often each capture is in a trace."""
    return Counter(name for kind, name, *_ in trace(path) if kind == what)


def simple(piece: str, tell: Tell) -> Any:
    """Work that does what its piece says."""
    kind, _, value = piece.partition(" ")
    if kind == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    elif kind == "sleep":
        time.sleep(float(value))
    elif kind == "take":
        return len(bytearray(int(value) << 20))
    elif kind == "raise":
        raise ValueError(value)
    elif kind == "tell":
        tell(value)
    return f"{kind} {os.getpid()}"
