"""A recorded log read back by line, to say in a truth file which lines show what was done.

Why it exists: what was done is known by its time; people and tests count lines. What it must not do: interpret more
than identifiers and bytes, or ask canalyze anything.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any


@dataclass(frozen=True)
class Line:
    """One frame: its line counted from 1, stamp in seconds, identifier, data (remote: "R") as hexadecimal digits."""

    number: int
    stamp: float
    can_id: int
    data: str

    @property
    def node(self) -> int | None:
        """Who sends on this identifier in the predefined connection set; None for what anybody may send."""
        base, node = self.can_id & 0x780, self.can_id & 0x7F
        sent_by_node = base in (0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700)
        return node if sent_by_node and node and not self.data.startswith("R") else None


Test = Callable[[Line], bool]


def on(can_id: int, *starts: str) -> Test:
    """Frames of an identifier whose data begin with one of these digits (all, if none are given)."""
    return lambda line: line.can_id == can_id and (not starts or line.data.startswith(starts))


def of(node: int) -> Test:
    """Frames that a node sent."""
    return lambda line: line.node == node


def emcy(node: int, code: int) -> Test:
    """An error report with this code."""
    return on(0x080 + node, f"{code & 0xFF:02X}{code >> 8:02X}")


def controller(line: Line) -> bool:
    """What only the controller of these stories sends: its heartbeat, NMT, SDO requests, and the RPDOs."""
    return line.can_id in (0x000, 0x77F) or line.can_id & 0x780 in (0x200, 0x300, 0x600)


def nmt(command: int, node: int) -> Test:
    """An NMT command."""
    return on(0x000, f"{command:02X}{node:02X}")


def download(node: int, index: int, sub: int) -> Test:
    """A request to write an object."""
    thing = f"{index & 0xFF:02X}{index >> 8:02X}{sub:02X}"
    return lambda line: line.can_id == 0x600 + node and line.data[0] == "2" and line.data[2:8] == thing


def answer(node: int, index: int, sub: int, first: str = "") -> Test:
    """A response for an object; first: its first two digits, e.g. "80" for an abort."""
    thing = f"{index & 0xFF:02X}{index >> 8:02X}{sub:02X}"
    return lambda line: line.can_id == 0x580 + node and line.data[2:8] == thing and line.data.startswith(first)


class Log:
    """A log as `candump -L` writes it."""

    def __init__(self, path: Path) -> None:
        """Reads it."""
        self.lines: list[Line] = []
        for number, text in enumerate(path.read_text().splitlines(), 1):
            stamp, _, frame = text.split()
            can_id, data = frame.split("#")
            self.lines.append(Line(number, float(stamp[1:-1]), int(can_id, 16), data))

    @property
    def seconds(self) -> float:
        """From the first frame to the last."""
        return round(self.lines[-1].stamp - self.lines[0].stamp, 3)

    def all(self, test: Test, after: float = 0.0, before: float = float("inf")) -> list[int]:
        """The lines of all such frames between two times."""
        return [line.number for line in self.lines if after < line.stamp < before and test(line)]

    def first(self, test: Test, after: float = 0.0, before: float = float("inf")) -> int:
        """The first of them; that there is none is an error of the recording."""
        found = self.all(test, after, before)
        if not found:
            raise MissingFrame(f"no such frame between {after} and {before}")
        return found[0]

    def last(self, test: Test, before: float, after: float = 0.0) -> int:
        """The last of them."""
        found = self.all(test, after, before)
        if not found:
            raise MissingFrame(f"no such frame between {after} and {before}")
        return found[-1]

    def stamp(self, line: int) -> float:
        """When a line was received."""
        return self.lines[line - 1].stamp

    def late_syncs(self) -> list[dict[str, Any]]:
        """Where SYNC came late but not missing: the machine that recorded stood still, as the truth calls `natural`."""
        stamps = [(line.stamp, line.number) for line in self.lines if on(0x080)(line)]
        gaps = [(after[0] - before[0], after[1]) for before, after in pairwise(stamps)]
        period = median(gap for gap, _ in gaps) if gaps else 0.0
        return [
            {"line": line, "kind": f"SYNC {(gap - period) * 1000:.0f} ms late"}
            for gap, line in gaps
            if 1.25 * period < gap < 2.5 * period
        ]

    def silence_told(self, node: int, since: int, periods: float, period_s: float) -> int:
        """The first line from which it can be told that a node is silent whose heartbeat has this period."""
        due = self.stamp(since) + periods * period_s
        return self.first(lambda line: True, due)


class MissingFrame(Exception):
    """A frame that a story needs is not in its recording: it must be made again."""
