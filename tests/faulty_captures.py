"""Captures with a fault in them: what a fault is, where it is put, and how a clean session is changed.

Why it exists: a fault that is found at one magnitude, in one place, with everything known says little about the next
one. What it must not do: hold what the program says today; `detection.json` does. Times are seconds from the
capture's first frame.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

from captures import CanFrame
from plants import EVERY, SECONDS, UP, Known, Session, built

from canalyze import _core

START_US = 1_700_000_000_000_000
"""The stamp of time 0 of every plant."""
POSITIONS = {
    "start": 0.45,
    "middle": 1.5,
    "at a change of state": UP + 0.02,
    "after one": UP + 0.15,
    "far from one": 4.3,
}
"""Beside these "end", which leaves room for the fault."""
MARGIN = 0.25
"""Seconds that a capture goes on after a fault."""


@dataclass(frozen=True, slots=True)
class Faulty:
    """A capture with a fault, and the numbers of the frames that it is about."""

    frames: list[CanFrame]
    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Case:
    """A capture with a fault and all that is known of it."""

    where: str
    faulty: Faulty
    network: _core.Network | None = None
    own: tuple[tuple[str, int | None], ...] = ()
    """Code and node of what the session without the fault says of itself."""


Make = Callable[[Known, float], Faulty]


@dataclass(frozen=True, slots=True)
class Fault:
    """A class of faults at one magnitude."""

    name: str
    magnitude: str
    codes: str
    """Beginnings of codes, any of which is right: rules that do not exist yet have none."""
    make: Make
    lasts: float = 0.1
    """Seconds that the fault needs."""
    known: tuple[Known, ...] = EVERY
    positions: tuple[str, ...] = (*POSITIONS, "end")
    beside: str = ""
    """Beginnings of codes that are true of the capture as well."""
    plant: str = "plant"
    """The session that it is put into."""
    bit_rate: int | None = None
    """Where the load of the bus is expected to stay below 90 %."""

    @property
    def row(self) -> str:
        return f"{self.name}: {self.magnitude}"

    def cases(self) -> Iterator[Case]:
        """Each place, with all that may be known."""
        for known in self.known:
            network = built(self.plant, known).network
            for where, at in self.times():
                yield Case(f"{where}, {known}", self.make(known, at), network)

    def times(self) -> list[tuple[str, float]]:
        """Where the fault is put: each position that leaves it room, before the nodes are stopped or after."""
        found = {**POSITIONS, "end": SECONDS - MARGIN - self.lasts}
        return [
            (where, found[where]) for where in self.positions if found[where] + self.lasts + MARGIN <= SECONDS + 0.001
        ]


class Capture:
    """The frames of a session while a fault is put into them."""

    def __init__(self, session: Session) -> None:
        """A copy of a clean session."""
        self.frames = list(session.frames)

    def drop(self, since: float, until: float, *can_ids: int, most: int = 1_000_000) -> None:
        """Frames of these identifiers (none: all) missing from a time to another, so many at most."""
        first, last = us(since), us(until)
        left = most
        kept = []
        for frame in self.frames:
            missing = left > 0 and first <= frame.t_us < last and (frame.can_id in can_ids or not can_ids)
            left -= missing
            if not missing:
                kept.append(frame)
        self.frames = kept

    def add(self, at: float, can_id: int, data: bytes = b"", *, remote: bool = False) -> None:
        """One more frame."""
        self.frames.append(CanFrame("can0", can_id, data, us(at), extended=can_id > 0x7FF, remote=remote))

    def place(self, at: float, frames: Iterable[CanFrame], step: float = 0.0004) -> float:
        """More frames in even steps; the time of the last one."""
        last = at
        for number, frame in enumerate(frames):
            last = at + number * step
            self.frames.append(replace(frame, t_us=us(last)))
        return last

    def next(self, can_id: int, since: float) -> float:
        """When the next frame of an identifier is due from a time on."""
        return seconds(next(frame.t_us for frame in self.frames if frame.can_id == can_id and frame.t_us >= us(since)))

    def last(self, can_id: int, until: float) -> float:
        """When the last frame of an identifier before a time was."""
        return seconds(max(frame.t_us for frame in self.frames if frame.can_id == can_id and frame.t_us < us(until)))

    def change(self, since: float, until: float, can_id: int, new: Callable[[CanFrame], CanFrame]) -> None:
        """Other frames for those of an identifier from a time to another."""
        within = range(us(since), us(until))
        self.frames = [new(f) if f.can_id == can_id and f.t_us in within else f for f in self.frames]

    def faulty(self, first: float, last: float) -> Faulty:
        """The capture in the order of its stamps; the fault is about the frames from a time to another."""
        frames = sorted(self.frames, key=lambda frame: frame.t_us)
        numbers = [number for number, frame in enumerate(frames, 1) if us(first) <= frame.t_us <= us(last)]
        return Faulty(frames, numbers[0], numbers[-1])


def us(at: float) -> int:
    return START_US + round(at * 1_000_000)


def seconds(t_us: int) -> float:
    return (t_us - START_US) / 1_000_000


def later(by: float) -> Callable[[CanFrame], CanFrame]:
    """A frame so many seconds later."""
    return lambda frame: replace(frame, t_us=frame.t_us + round(by * 1_000_000))


def with_data(data: bytes) -> Callable[[CanFrame], CanFrame]:
    """A frame with other data."""
    return lambda frame: replace(frame, data=data)


def quiet(at: float) -> float:
    """A moment without SDO traffic near a time."""
    return int(at / 0.2 + 1e-6) * 0.2 + 0.05
