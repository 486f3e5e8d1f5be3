"""The time axis that the pictures of the page of a diagnosis share, and text in them in both languages.

The axis shows the part of the capture in which the incidents are. Must not: judge, or know what is drawn on it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any, Final

from canalyze.output import printable
from canalyze.values import nanoseconds

Record = Mapping[str, Any]
Texts = Mapping[str, str]
"""The same in each language."""

WIDTH: Final = 1000
"""Units of a picture that are as wide as the page."""
LEFT: Final = 132
"""Where time begins: the names of rows stand before it."""
RIGHT: Final = 16
_TICKS: Final = 9
_LEAST_NS: Final = 1_000_000_000
"""What is shown before and behind the incidents at least."""
_WIDE: Final = "ᄀ"
"""From here on a character is about as wide as high."""


@dataclass(frozen=True)
class Axis:
    """A span of time, in ns, across the width of a picture."""

    origin_ns: int
    """The begin of the capture: times are told from there."""
    begin_ns: int
    end_ns: int

    def x(self, t_ns: int) -> float:
        """Give where a time stands; what is outside stands at the edge."""
        held = min(max(t_ns, self.begin_ns), self.end_ns)
        return LEFT + (held - self.begin_ns) / (self.end_ns - self.begin_ns) * (WIDTH - LEFT - RIGHT)

    def ticks(self) -> Iterator[tuple[float, str]]:
        """Give where round times stand, and what they are called."""
        span = self.end_ns - self.begin_ns
        step = next(
            step for step in (digit * 10**power for power in range(20) for digit in (1, 2, 5)) if span / step <= _TICKS
        )
        decimals = max(0, 9 - (len(str(step)) - 1))
        first = -((self.origin_ns - self.begin_ns) // step)
        for number in range(first, first + _TICKS + 2):
            t_ns = self.origin_ns + number * step
            if self.begin_ns <= t_ns <= self.end_ns:
                yield self.x(t_ns), f"{number * step / 1e9:.{decimals}f} s"


def axis_of(incidents: Sequence[Record], whole: Record) -> Axis | None:
    """Give the axis on which all incidents are; None without stamps, incidents or time."""
    begin, end = nanoseconds(whole["begin"]), nanoseconds(whole["end"])
    moments = [t_ns for one in incidents for t_ns in moments_of(one)]
    if begin is None or end is None or end <= begin or not moments:
        return None
    first, last = min(moments), max(moments)
    around = max((last - first) // 6, _LEAST_NS)
    stays = any(one["end"] is None and one["status"] == "open" for one in incidents)
    last = min(last + (2 if stays else 1) * around, end)
    first = max(first - around, begin)
    # An axis that leaves little of the capture out rather shows all of it.
    if last - first >= (end - begin) / 2:
        first, last = begin, end
    return Axis(begin, first, last) if last > first else None


def moments_of(one: Record) -> Iterator[int]:
    """Give the times in ns at which something of an incident is known."""
    places = (one["begin"], one["noticed"], one["end"], *one["steps"])
    found = (nanoseconds(place["t"]) for place in places if place is not None)
    return (t_ns for t_ns in found if t_ns is not None)


def head(height: float) -> str:
    """Open a picture of a height."""
    return f'<svg viewBox="0 0 {WIDTH} {height:.0f}" role="img" xmlns="http://www.w3.org/2000/svg">'


def grid(axis: Axis, top: float, bottom: float, *, named: bool) -> str:
    """Give a line for each round time, with its name below where it is asked for."""
    parts = []
    for x, name in axis.ticks():
        parts.append(f'<path class="tick" d="M{x:.1f} {top:.0f}V{bottom:.0f}"/>')
        if named:
            parts.append(f'<text class="soft" text-anchor="middle" x="{x:.1f}" y="{bottom + 14:.0f}">{name}</text>')
    return "".join(parts)


def text(texts: Texts, x: float, y: float, kind: str = "") -> str:
    """Give a line in each language, of a class; once where both say the same."""
    of_class = f' class="{kind}"' if kind else ""
    said = {lang: escape(printable(one), quote=False) for lang, one in texts.items()}
    if len(set(said.values())) == 1:
        return f'<text{of_class} x="{x:.1f}" y="{y:.1f}">{next(iter(said.values()))}</text>'
    lines = (f'<text{of_class} lang="{lang}" x="{x:.1f}" y="{y:.1f}">{one}</text>' for lang, one in said.items())
    return "".join(lines)


def title(texts: Texts) -> str:
    """Give what is shown under the pointer, in each language."""
    lines = dict.fromkeys(escape(printable(one), quote=False) for one in texts.values())
    return f"<title>{chr(10).join(lines)}</title>"


def extent(said: str, size: float = 11) -> float:
    """Give about how wide a line is, in units, in letters so high."""
    return sum(size if char >= _WIDE else size * 0.56 for char in said)


def shortened(said: str, room: float, size: float = 11) -> str:
    """Give a line that fits into the room, cut with a dot at its end where it must be; nothing where little remains."""
    if extent(said, size) <= room:
        return said
    kept = said
    while kept and extent(kept + "…", size) > room:
        kept = kept[:-1]
    return kept.rstrip() + "…" if len(kept) > 1 else ""
