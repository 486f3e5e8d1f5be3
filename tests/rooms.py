"""Which tests belong to which part of the source, by the table in README.md.

    python tests/rooms.py PATH...

prints the files of tests for these paths, one a line, without those that take long.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

TESTS = Path(__file__).resolve().parent
TABLE = TESTS / "README.md"
_NAME = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, slots=True)
class Row:
    """A row of the table; paths begin at the checkout."""

    rooms: tuple[str, ...]
    tests: tuple[str, ...]
    long: tuple[str, ...]


def rows() -> Iterator[Row]:
    """Yields the rows of the table."""
    _, _, rest = TABLE.read_text(encoding="utf-8").partition("| rooms | tests | long ones |\n")
    table, _, _ = rest.partition("\n\n")
    for line in table.splitlines()[1:]:
        rooms, tests, long = ([*_NAME.findall(cell)] for cell in line.strip("|").split("|"))
        yield Row(tuple(rooms), *(tuple(f"tests/{name}" for name in names) for names in (tests, long)))


def tests_of(paths: Iterable[str]) -> list[str]:
    """Returns the tests of these paths, without long ones: those of the nearest room, and of every room below."""
    found: set[str] = set()
    table = [(f"{room}/", row) for row in rows() for room in row.rooms]
    for path in paths:
        if re.fullmatch(r"tests/(.*/)?(test_\w+\.py|console/.+\.txt)", path):
            found.add(path)
            continue
        here = f"{path.rstrip('/')}/"
        nearest = max((len(room) for room, _ in table if here.startswith(room)), default=0)
        for room, row in table:
            if room.startswith(here) or (here.startswith(room) and len(room) == nearest):
                found.update(row.tests)
    return sorted(found)


if __name__ == "__main__":
    print("\n".join(tests_of(sys.argv[1:])))
