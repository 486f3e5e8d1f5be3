"""Text of a description -> sections with keys and their lines, whatever its shape. Knows no key of CiA 306.

Sections and keys are found without regard to case; of two that are alike the later one counts. A comment is a line
that begins with `;` or `#`; what follows a value on its line is left to who knows whether it is a number.
"""

from collections import Counter
from collections.abc import Iterator
from typing import Final, NamedTuple

from canalyze.dictionary.model import Defect

_MOST_DEFECTS: Final = 1000
"""Defects of one code that are kept; the rest is counted."""


class Key(NamedTuple):
    """One `name=value`."""

    name: str
    value: str
    line: int


class Section:
    """One `[name]` with its keys, by small-letter name."""

    __slots__ = ("keys", "line", "name")

    def __init__(self, name: str, line: int, keys: dict[str, Key] | None = None) -> None:
        """Begin on a line; without keys it has none yet."""
        self.name = name
        self.line = line
        self.keys: dict[str, Key] = {} if keys is None else keys

    def get(self, name: str) -> Key | None:
        """Give a key that is there and not empty."""
        key = self.keys.get(name.lower())
        return key if key and key.value else None

    def text(self, name: str) -> str | None:
        """Give the text of a key, None if it is missing."""
        key = self.keys.get(name.lower())
        return key.value if key else None


class Ini:
    """The sections by small-letter name, and what was wrong with the text."""

    def __init__(self) -> None:
        """No section yet."""
        self.sections: dict[str, Section] = {}
        self._defects: list[Defect] = []
        self._counts: Counter[str] = Counter()

    @property
    def defects(self) -> tuple[Defect, ...]:
        """What was wrong, by line."""
        more = {code: count - _MOST_DEFECTS for code, count in self._counts.items() if count > _MOST_DEFECTS}
        rest = [Defect(0, "more", {"code": code, "count": count}) for code, count in more.items()]
        return tuple(sorted([*rest, *self._defects], key=lambda defect: defect.line))

    def section(self, name: str) -> Section | None:
        """Give a section."""
        return self.sections.get(name.lower())

    def complain(self, line: int, code: str, **facts: object) -> None:
        """Note a defect."""
        self._counts[code] += 1
        if self._counts[code] <= _MOST_DEFECTS:
            self._defects.append(Defect(line, code, facts))


def parse(text: str) -> Ini:
    """Read all lines."""
    ini = Ini()
    current: Section | None = None
    for number, line in _lines(text):
        if line.startswith("["):
            current = _open(ini, line, number)
            continue
        name, equals, value = line.partition("=")
        name = name.strip()
        if not equals or not name:
            ini.complain(number, "no-equals", text=_short(line))
        elif current is None:
            ini.complain(number, "no-section", text=_short(line))
        else:
            _put(ini, current, Key(name, value.strip(), number))
    return ini


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Give number and text of each line that says something; a DOS end-of-file mark and NULs say nothing."""
    for number, raw in enumerate(_ended(text), 1):
        line = raw.strip(" \t\v\f\0\x1a\N{ZERO WIDTH NO-BREAK SPACE}\N{NO-BREAK SPACE}\N{IDEOGRAPHIC SPACE}")
        if line and line[0] not in ";#":
            yield number, line


def _ended(text: str) -> Iterator[str]:
    """Give the lines as any system ends them: a line feed with what carriage returns stand before it, or one return."""
    plain = text.replace("\r\n", "\n")
    if "\r" not in plain:
        yield from plain.split("\n")
        return
    pieces = text.split("\n")
    for piece in pieces[:-1]:
        yield from piece.rstrip("\r").split("\r")
    yield from pieces[-1].split("\r")


def _open(ini: Ini, line: str, number: int) -> Section:
    inside, bracket, _ = line[1:].partition("]")
    name = inside.strip()
    if not bracket:
        ini.complain(number, "section-bracket", text=_short(line), read=f"[{_short(name)}]")
    found = ini.sections.get(name.lower())
    if found is None:
        found = ini.sections[name.lower()] = Section(name, number)
    else:
        ini.complain(number, "duplicate-section", section=_short(name), first=found.line)
    return found


def _put(ini: Ini, section: Section, key: Key) -> None:
    small = key.name.lower()
    other = section.keys.get(small)
    if other is not None:
        facts = {"section": _short(section.name), "key": _short(key.name), "first": other.line}
        ini.complain(key.line, "duplicate-key", **facts, used=_short(key.value), other=_short(other.value))
    section.keys[small] = key


def _short(text: str) -> str:
    return text if len(text) <= 60 else text[:59] + "…"
