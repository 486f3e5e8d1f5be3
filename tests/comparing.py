"""What `canalyze diff` says of two captures, in process; and captures changed as another adapter would have taken them.

What it must not do: know what differs.
"""

from __future__ import annotations

import json
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace

from captures import CanFrame, Row

from canalyze import _core
from canalyze.running.reading import SessionOptions


@dataclass(frozen=True, slots=True)
class Compared:
    """The answer: the differences in order, those of what went wrong, and the object that closes them."""

    differences: list[Row]
    incidents: list[Row]
    closing: Row
    text: str

    def listed(self) -> str:
        """For a test's message."""
        told = "".join(f"{row['problem']} {row['differs']} {row['a']} {row['b']}\n" for row in self.incidents)
        return told + "\n".join(
            f"{row['what']} node {row['node']} {row['service']} {row['index']}: {row['text']}: "
            + "; ".join(f"{row[s]['frame']} {row[s]['text']}" if row[s] else "none" for s in "ab")
            for row in self.differences
        )


def recorded(data: bytes, network: _core.Network | None = None, form: str | None = None) -> _core.Session:
    """A session that has kept what is to be compared."""
    session = _core.Session(SessionOptions(format="digest", network=network))
    form = form or _core.sniff(data, True)
    session.begin("capture", True, form if form in _core.FORMATS else "candump")
    session.feed(data)
    session.end()
    session.finish()
    return session


def compared(a: bytes, b: bytes, *, network: _core.Network | None = None, tolerance: float = 0.1) -> Compared:
    """Compare two captures."""
    sessions = recorded(a, network), recorded(b, network)
    found = _core.Comparison(*sessions, names=("a", "b"), lang="en", tolerance=tolerance)
    *rows, closing = map(json.loads, found.jsonl().decode().splitlines())
    incidents = [row for row in rows if row["kind"] == "problem_difference"]
    assert rows[: len(incidents)] == incidents, "they come first"
    return Compared(rows[len(incidents) :], incidents, closing, (found.head() + found.body()).decode())


def late_echoes(frames: Sequence[CanFrame], share: float = 0.3) -> list[CanFrame]:
    """A capture on the client's own host: some of what it sends comes one frame late."""
    chance = random.Random(7)
    new = list(frames)
    at = 0
    while at + 1 < len(new):
        one, other = new[at], new[at + 1]
        after = new[at + 2].t_us if at + 2 < len(new) else other.t_us + 1000
        answered = 0x600 <= one.can_id < 0x680 and other.can_id == one.can_id - 0x80
        soon = other.t_us - one.t_us < 4000 and other.t_us + 20 < after
        if answered and soon and chance.random() < share:
            new[at], new[at + 1] = other, replace(one, t_us=other.t_us + 20)
            at += 1
        at += 1
    return new


def jittered(frames: Sequence[CanFrame], most_us: int = 60) -> list[CanFrame]:
    """Stamps of another clock, which are not exact; the order stays."""
    chance = random.Random(11)
    new: list[CanFrame] = []
    for frame in frames:
        t_us = frame.t_us + 3_141_592_653 + chance.randint(0, most_us)
        new.append(replace(frame, t_us=max(t_us, new[-1].t_us if new else t_us)))
    return new


def renamed(frames: Sequence[CanFrame], bus: str) -> list[CanFrame]:
    """The same on a bus of another name."""
    buses = list(dict.fromkeys(frame.bus for frame in frames))
    return [replace(frame, bus=f"{bus}{buses.index(frame.bus)}") for frame in frames]
