"""Joins captures that are parts of one recording: those that follow one another on the same bus.

Must not: read a capture.
"""

from collections.abc import Iterable
from typing import Final, NamedTuple

from canalyze.values import DATES_NS

APART_NS: Final = 5_000_000_000
"""Maximum time from the end of a part to the beginning of the next, in ns; a slow bus may be silent that long."""


class Span(NamedTuple):
    """The time and the buses of one file."""

    name: str
    begin_ns: int | None
    """The first stamp; None without stamps, or if the file could not be read."""
    end_ns: int | None
    buses: frozenset[str | None]

    def follows(self, before: "Span") -> bool:
        """Returns true if this file continues another one. Only stamps of a calendar clock can tell."""
        if self.begin_ns is None or before.end_ns is None or not self.buses & before.buses:
            return False
        return self.begin_ns >= DATES_NS and 0 <= self.begin_ns - before.end_ns <= APART_NS

    def overlaps(self, other: "Span") -> bool:
        """Returns true if both files have frames of the same bus and time, and so are not parts of one recording."""
        if self.begin_ns is None or self.end_ns is None or other.begin_ns is None or other.end_ns is None:
            return False
        return bool(self.buses & other.buses) and self.begin_ns < other.end_ns and other.begin_ns < self.end_ns


def recordings(spans: Iterable[Span]) -> list[tuple[str, ...]]:
    """Returns the file names of each recording, in order of time."""
    every = list(spans)
    timed = sorted((one for one in every if one.begin_ns is not None), key=lambda one: one.begin_ns or 0)
    chains: list[list[Span]] = []
    alone = {one.name for one in timed if any(one.overlaps(other) for other in timed if other is not one)}
    for span in timed:
        chains_before = (one for one in reversed(chains) if span.follows(one[-1]) and one[-1].name not in alone)
        chain = None if span.name in alone else next(chains_before, None)
        if chain is None:
            chains.append([span])
        else:
            chain.append(span)
    place = {span.name: number for number, span in enumerate(every)}
    chains += [[span] for span in every if span.begin_ns is None]
    chains.sort(key=lambda chain: min(place[span.name] for span in chain))
    return [tuple(span.name for span in chain) for chain in chains]
