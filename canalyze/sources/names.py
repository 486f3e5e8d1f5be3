"""Names of captures: patterns and directories are expanded to files, globs match names; and parts of one recording.

Captures are parts of one recording that follow one another on the same bus. Must not: open a file.
"""

import glob
import os
import re
import shlex
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Final, NamedTuple

from canalyze.errors import SourceError
from canalyze.sources import STDIN
from canalyze.sources.compressed import COMPRESSIONS
from canalyze.values import DATES_NS

CAPTURES: Final = frozenset(
    {
        *(".asc", ".blf", ".candump", ".cap", ".csv", ".db", ".log", ".mcap", ".mf4", ".pcap", ".pcapng"),
        *(".sqlite", ".sqlite3", ".trc", ".txt"),
    }
)
"""Suffixes of capture files."""


def unpacked(name: str) -> Path:
    """Returns the name of a capture without the suffix of its compression."""
    path = Path(name)
    return path.with_suffix("") if path.suffix.lower() in {one.suffix for one in COMPRESSIONS.values()} else path


def named_as_capture(name: str) -> bool:
    """Returns true if a file in a directory is a capture by its name."""
    return not Path(name).name.startswith(".") and unpacked(name).suffix.lower() in CAPTURES


def below(folder: str) -> Iterator[str]:
    """Yields the files below a folder that are captures by their names."""
    for inside, folders, files in os.walk(folder):
        folders[:] = sorted(one for one in folders if not one.startswith("."))
        yield from (os.path.join(inside, one) for one in sorted(files) if named_as_capture(one))  # noqa: PTH118


class Named(NamedTuple):
    """A capture to read."""

    name: str
    error: SourceError | None = None
    """The reason if there is no such file."""


def expanded(names: Iterable[str]) -> Iterator[Named]:
    """Yields every file once, in the given order; those of a pattern or a directory sorted. `**` enters directories."""
    seen: set[str] = set()
    for name in names:
        if name == STDIN or not glob.has_magic(name) or os.path.lexists(name):
            found = [name]
        else:
            # Not pathlib's, whose names differ from a shell's: without ./ and, before 3.13, with hidden files.
            found = sorted(one for one in glob.glob(name, recursive=True) if not Path(one).is_dir())  # noqa: PTH207
            if not found:
                yield Named(name, SourceError("source.no_match", name=name))
        if found == [name] and Path(name).is_dir():
            found = list(below(name))
            if not found:
                pattern = shlex.quote(str(Path(name, "**", "*.log")))
                yield Named(name, SourceError("source.directory", name=name, pattern=pattern))
        for one in found:
            if one not in seen:
                seen.add(one)
                yield Named(one)


_GLOB: Final = re.compile(r"((?:(?:^|(?<=/))\*\*/)+|\*\*|\*|\?|\[!?\]?[^\]]*\])")
_WILDCARDS: Final = {"*": "[^/]*?", "**": ".*?", "**/": "(?:.*?/)??"}


@cache
def matching(glob: str) -> re.Pattern[str]:
    """Returns the regular expression of a glob, for `fullmatch`.

    `*` and `?` stay within a directory, `**` does not, `**/` in place of a directory matches any number of them,
    `[a-z]` and `[!a-z]` are one character. An invalid set is literal. The first match of the text between two wildcards
    is final (an atomic group), which finds every match and keeps the time short for any glob.
    """
    parts = [("", "")]
    for place, piece in enumerate(_GLOB.split(glob)):
        wildcard, fixed = parts[-1]
        if place % 2 and piece[0] == "*":
            parts.append((piece[:3], ""))
        else:
            parts[-1] = wildcard, fixed + (_character(piece) if place % 2 else re.escape(piece))
    found = group = ""
    for number, (wildcard, fixed) in enumerate(parts, 1):
        piece = _WILDCARDS.get(wildcard, "") + fixed
        if wildcard != "*":
            found, group = f"{found}(?>{group})", piece
        else:
            group += piece if number == len(parts) else f"(?>{piece})"
    try:
        return re.compile(found + group, re.DOTALL)
    except re.error:  # [z-a]
        return re.compile(re.escape(glob))


def _character(piece: str) -> str:
    """Returns the regular expression of `?` or a set."""
    if piece == "?":
        return "[^/]"
    members = re.sub(r"([\\\[\]^&~|])", r"\\\1", piece[1:-1].removeprefix("!"))
    return f"(?!/)[{'^' if piece[1] == '!' else ''}{members}]"


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
