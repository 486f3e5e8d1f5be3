"""What can be seen in a clean session: periods, boot-ups, commands, transfers; the capture that a change of it makes.

Why it exists: a class of faults that is found in the session that it was written for is not found elsewhere. A change
is drawn for any clean session that has what it needs, at any magnitude and place that leave it visible; what a session
has is seen here, for all changes alike. What it must not do: know a change; the files `changes_of_*.py` do.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from random import Random
from statistics import median

from captures import CanFrame
from faulty_captures import Faulty
from network import OPERATIONAL, PRE_OP, PRE_OPERATIONAL, RESET_COMMUNICATION, RESET_NODE, START, STOP, STOPPED
from plants import Session

RESETS = (RESET_NODE, RESET_COMMUNICATION)
STATES = {START: OPERATIONAL, STOP: STOPPED, PRE_OP: PRE_OPERATIONAL}
MS = 1000
"""Microseconds of a millisecond."""
EVEN_PART = 8
"""Gaps that differ from their median by at most this part of it are even."""

Frames = list[CanFrame]
Draw = Callable[["Traffic", Random, float], Faulty | None]
"""A change of a session, of one magnitude; none where the session has no place for it."""


@dataclass(frozen=True)
class Traffic:
    """A clean session, and what can be seen in it."""

    session: Session

    @cached_property
    def frames(self) -> Frames:
        return list(self.session.frames)

    @cached_property
    def start_us(self) -> int:
        return self.frames[0].t_us

    @cached_property
    def end_us(self) -> int:
        return self.frames[-1].t_us

    @cached_property
    def times(self) -> dict[int, list[int]]:
        """The stamps of data frames by CAN-ID."""
        found: dict[int, list[int]] = defaultdict(list)
        for frame in self.frames:
            if not frame.extended and not frame.remote:
                found[frame.can_id].append(frame.t_us)
        return found

    @cached_property
    def guarded(self) -> set[int]:
        return {frame.can_id & 0x7F for frame in self.frames if frame.remote and 0x700 < frame.can_id < 0x780}

    @cached_property
    def boots(self) -> list[tuple[int, int]]:
        """Stamps and nodes of boot-ups."""
        return [(f.t_us, f.can_id & 0x7F) for f in self.frames if 0x700 < f.can_id < 0x780 and f.data == b"\0"]

    @cached_property
    def commands(self) -> list[tuple[int, int, int]]:
        """Stamp, specifier and node of NMT commands."""
        return [(f.t_us, f.data[0], f.data[1]) for f in self.frames if f.can_id == 0 and len(f.data) == 2]

    @cached_property
    def exchanges(self) -> list[tuple[int, int, int]]:
        """Places of a request and its answer, and the node: expedited transfers on default channels."""
        found: list[tuple[int, int, int]] = []
        asked: dict[int, int] = {}
        for place, frame in enumerate(self.frames):
            node, group = frame.can_id & 0x7F, frame.can_id & ~0x7F
            if frame.extended or not node or len(frame.data) != 8:
                continue
            if group == 0x600:
                asked[node] = place
            elif group == 0x580 and node in asked:
                request = self.frames[asked.pop(node)]
                read = request.data[0] == 0x40 and frame.data[0] & 0xF3 == 0x43
                wrote = request.data[0] & 0xF3 == 0x23 and frame.data[0] == 0x60
                if (read or wrote) and request.data[1:4] == frame.data[1:4]:
                    found.append((self.frames.index(request), place, node))
        return found

    @cached_property
    def in_transfers(self) -> dict[int, list[tuple[int, int]]]:
        """Times by node in which its default channel is busy with something else than an expedited transfer."""
        short = {place for request, answer, _ in self.exchanges for place in (request, answer)}
        found: dict[int, list[tuple[int, int]]] = defaultdict(list)
        for place, frame in enumerate(self.frames):
            if 0x580 < frame.can_id < 0x680 and frame.can_id != 0x600 and place not in short:
                found[frame.can_id & 0x7F].append((frame.t_us - 20 * MS, frame.t_us + 20 * MS))
        return found

    def heartbeats(self, node: int) -> list[int]:
        """Stamps of a node's heartbeats, boot-ups left out."""
        can_id = 0x700 + node
        return [f.t_us for f in self.frames if f.can_id == can_id and not f.remote and f.data not in (b"", b"\0")]

    @cached_property
    def producers(self) -> dict[int, int]:
        """Nodes with even heartbeats, and the period in us."""
        found = {}
        for can_id in sorted(self.times):
            node = can_id - 0x700
            if not 0 < node < 0x80 or node in self.guarded:
                continue
            gaps = [later - before for before, later in self.even_gaps(node)]
            if len(gaps) >= 5:
                found[node] = round(median(gaps))
        return found

    def even_gaps(self, node: int) -> list[tuple[int, int]]:
        """The ends of a node's gaps between heartbeats that are about as long as most."""
        beats = self.heartbeats(node)
        gaps = list(pairwise(beats))
        if not gaps:
            return []
        usual = median(later - before for before, later in gaps)
        return [(b, e) for b, e in gaps if abs(e - b - usual) <= usual / EVEN_PART]

    @cached_property
    def nodes(self) -> list[int]:
        """Nodes that send error control frames."""
        return sorted(can_id - 0x700 for can_id in self.times if 0x700 < can_id < 0x780)

    def tpdos(self, node: int) -> list[int]:
        """CAN-IDs of a node's TPDOs, as far as they are those of the pre-defined connection set."""
        return [can_id for can_id in (0x180 + node, 0x280 + node, 0x380 + node, 0x480 + node) if can_id in self.times]

    def of_node(self, node: int) -> set[int]:
        """CAN-IDs of the frames that a node sends."""
        return {0x080 + node, 0x700 + node, 0x580 + node, *self.tpdos(node)}

    def commanded(self, node: int, since: int, until: int) -> bool:
        """True if a command to a node, or to all, is within a time, or its boot-up."""
        return any(since <= at <= until and to in (0, node) for at, _, to in self.commands) or any(
            since <= at <= until and of == node for at, of in self.boots
        )

    def heard(self, since: int, until: int, node: int) -> bool:
        """True if other nodes are heard all the time, so that the recorder did not stand still."""
        others = [f.t_us for f in self.frames if f.can_id & 0x7F != node and since < f.t_us < until]
        times = [since, *others, until]
        return max(after - before for before, after in pairwise(times)) < (until - since) / 2

    def quiet_of(self, node: int, at: int) -> bool:
        """True if a node's default SDO channel is idle for some time around a stamp."""
        near = [place for can_id in (0x600 + node, 0x580 + node) for place in self.times.get(can_id, [])]
        return all(abs(place - at) > 15 * MS for place in near)

    # -- changed sessions

    def without(self, gone: Callable[[CanFrame], bool]) -> Frames:
        return [frame for frame in self.frames if not gone(frame)]

    def faulty(self, frames: Iterable[CanFrame], first_us: int, last_us: int) -> Faulty:
        """The changed capture in the order of its stamps; the fault is about the frames from a time to another."""
        ordered = sorted(frames, key=lambda frame: frame.t_us)
        times = [frame.t_us for frame in ordered]
        first, last = bisect_left(times, first_us) + 1, bisect_right(times, last_us)
        return Faulty(ordered, first, max(first, min(last, len(ordered))))

    def bus(self) -> str:
        return self.frames[0].bus

    def frame(self, can_id: int, data: bytes, t_us: int) -> CanFrame:
        return CanFrame(self.bus(), can_id, data, t_us)


def chosen(rng: Random, found: Iterable[tuple[int, ...]]) -> tuple[int, ...] | None:
    rows = sorted(found)
    return rng.choice(rows) if rows else None
