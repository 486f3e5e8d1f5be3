"""A TOML file of the user's: its text parsed, its tables checked key by key, each mistake with its line.

What the configuration and the expectations have in common. Must not: know a key of either, or print: what is wrong is
a ConfigError, worded by who shows it.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple, NoReturn, Self

from canalyze.configuration import network
from canalyze.configuration.bounded import short
from canalyze.errors import ConfigError


class Key(NamedTuple):
    """How a value is read: None says that it cannot be, in the words `config.FORM`."""

    read: Callable[[Any], object]
    form: str
    needed: bool = False
    allowed: str = ""
    """What the words name as allowed, where they leave it open."""


def choice(*values: str, needed: bool = False) -> Key:
    """Give a key that takes one of some words."""
    allowed = ", ".join(f'"{value}"' for value in values)
    return Key(lambda value: value if isinstance(value, str) and value in values else None, "choice", needed, allowed)


def text(value: object) -> str | None:
    """Read a text."""
    return value if isinstance(value, str) and value else None


def node(value: object) -> int | None:
    """Read a node-ID."""
    return value if type(value) is int and value in network.NODES else None


def as_text(read: Callable[[str], object]) -> Callable[[object], object]:
    """Give a reader of strings only: in 181 nobody sees whether it was meant in hexadecimal."""
    return lambda value: read(value) if isinstance(value, str) else None


def bit_rate(value: object) -> int | None:
    """Read a bit rate: a number of bit/s, or a text such as 125k."""
    return network.bit_rate(str(value)) if type(value) in (int, str) else None


_HEADING: Final = re.compile(r"\s*\[{1,2}\s*([\w.-]+)\s*\]{1,2}\s*(?:#.*)?")
_NAMED: Final = re.compile(r"""\s*(?:"([^"]*)"|'([^']*)'|([\w-]+))\s*[=.]""")
_PIECE: Final = re.compile(
    r"""(?P<blank>[ \t]++|\#[^\n]*+)
    |(?P<string>\"{3}(?:[^"\\]++|\\.|"(?!""))*+\"{3,5}|'{3}(?:[^']++|'(?!''))*+'{3,5})
    |(?P<open_string>\"{3}|'{3})
    |(?P<name>[\w+-]++|"(?:[^"\\\n]++|\\[^\n])*+"|'[^'\n]*+')
    |(?P<dot>\.)
    |(?P<bracket>[\[\]{}])
    |(?P<other>.)""",
    re.VERBOSE | re.DOTALL,
)
"""No part of it gives back what it has taken: the time is that of the text's length."""
_DEEPEST: Final = 32
"""Brackets within each other, and parts of a dotted key; a file of ours needs three."""
_LONGEST: Final = 128
"""Characters of a number, or of a key without quotes."""


class File:
    """A file whose TOML is in order: reads its tables, and finds the lines that tomllib does not tell."""

    def __init__(self, path: Path, lines: list[str]) -> None:
        """Take the lines of its text."""
        self._path = path
        self._tables: dict[str, list[int]] = {"": [0]}
        """Where the headings of each table stand; what stands before the first one is under none."""
        self._keys: dict[tuple[int, str], int] = {}
        """Where each key stands first, by the heading that it is under."""
        start = 0
        for number, line in enumerate(lines, 1):
            if match := _HEADING.fullmatch(line):
                start = number
                self._tables.setdefault(match[1], []).append(number)
            elif match := _NAMED.match(line):
                self._keys.setdefault((start, match[1] or match[2] or match[3] or ""), number)

    @classmethod
    def parsed(cls, path: Path, content: bytes) -> tuple[Self, dict[str, Any]]:
        """Give a file of this content, and its values; ConfigError if it is no TOML."""
        values = parsed(path, content)
        return cls(path, [line.rstrip("\r") for line in content.decode("utf-8").split("\n")]), values

    def line(self, table: str, place: int, key: str = "") -> int | None:
        """Give the line of a key, or of its table, of which it is number `place`; None if neither is seen."""
        starts = self._tables.get(table, [])
        if place >= len(starts):  # not under a heading of its own: sync.period_us = 1, eds = [{...}]
            return self.line("", 0, table)
        start = starts[place]
        opened = self._tables.get(key, [0])[0] if not table and key else 0
        return self._keys.get((start, key)) or opened or start or None

    def at(self, table: str, place: int, key: str = "") -> str:
        """Give FILE:LINE as `line` does; FILE if no line is seen."""
        line = self.line(table, place, key)
        return f"{self._path}:{line}" if line else str(self._path)

    def allow(
        self, values: Mapping[str, object], keys: Iterable[str], *, tables: Iterable[str], lists: Iterable[str]
    ) -> None:
        """Check the names at the top: keys, tables [NAME], and tables that may come several times, [[NAME]]."""
        allowed = {key: key for key in keys} | {name: f"[{name}]" for name in tables}
        allowed |= {name: f"[[{name}]]" for name in lists}
        for name in values:
            if name not in allowed:
                self._unknown("", 0, name, allowed)

    def _unknown(self, table: str, place: int, name: str, allowed: Mapping[str, str]) -> NoReturn:
        """Say that there is no such key, and which one may be meant."""
        from difflib import get_close_matches

        near = get_close_matches(name[:_LONGEST].lower(), allowed, n=1, cutoff=0.7)
        shown = short(f"{table}.{name}" if table else name)
        file, listed = self.at(table, place, name), ", ".join(allowed.values())
        if near:
            raise ConfigError("config.unknown_near", file=file, key=shown, near=allowed[near[0]], allowed=listed)
        raise ConfigError("config.unknown", file=file, key=shown, allowed=listed)

    def read(self, table: str, place: int, values: Mapping[str, object], keys: Mapping[str, Key]) -> dict[str, Any]:
        """Read the values of one table; ConfigError for what cannot be."""
        found = {}
        for name, value in values.items():
            shown = f"{table}.{name}" if table else name
            if name not in keys:
                self._unknown(table, place, name, {key: key for key in keys})
            found[name] = keys[name].read(value)
            if found[name] is None:
                file = self.at(table, place, name)
                allowed = keys[name].allowed
                raise ConfigError(
                    f"config.{keys[name].form}", file=file, key=shown, value=as_toml(value), allowed=allowed
                )
        for name, key in keys.items():
            if key.needed and name not in found:
                raise ConfigError("config.lacks", file=self.at(table, place), key=f"{table}.{name}")
        return found

    def entries(self, table: str, values: Mapping[str, object], keys: Mapping[str, Key]) -> list[dict[str, Any]]:
        """Read all tables of one name."""
        given = values.get(table, [])
        if not isinstance(given, list) or not all(isinstance(entry, dict) for entry in given):
            raise ConfigError("config.table", file=self.at(table, 0), key=table, table=f"[[{table}]]")
        return [self.read(table, place, entry, keys) for place, entry in enumerate(given)]


def parsed(path: Path, text: bytes) -> dict[str, object]:
    """Give the values of a file of this text; ConfigError if it is no TOML, or nested beyond what has a meaning."""
    import tomllib

    try:
        decoded = text.decode("utf-8")
        _limit(path, decoded)
        return tomllib.loads(decoded)
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise ConfigError("config.not_utf8", file=path, line=line) from error
    except tomllib.TOMLDecodeError as error:
        line, column, problem = _place(str(error), text)
        raise ConfigError("config.broken", file=path, line=line, column=column, problem=short(problem)) from error


def _limit(path: Path, text: str) -> None:
    """Refuse what tomllib would take without end: it recurses by brackets, copies by the parts of a dotted key.

    Brackets, keys and numbers are counted as the text has them, outside of its strings and comments.
    """
    depth = parts = 0
    dotted = False
    for match in _PIECE.finditer(text):
        kind = match.lastgroup
        if kind == "blank":
            continue
        if kind == "open_string":  # tomllib gets no further either
            return
        if kind == "name":
            parts = parts + 1 if dotted else 1
        elif kind == "bracket":
            depth = max(0, depth + (1 if match[0] in "[{" else -1))
        dotted = kind == "dot"
        long = kind == "name" and match[0][0] not in "\"'" and len(match[0]) > _LONGEST
        if depth > _DEEPEST or parts > _DEEPEST or long:
            key = "config.long" if long else "config.deep"
            line = text.count("\n", 0, match.start()) + 1
            raise ConfigError(key, file=path, line=line, most=_LONGEST if long else _DEEPEST)


def _place(message: str, text: bytes) -> tuple[int, int, str]:
    """Take line and column out of tomllib's "... (at line 3, column 7)" or "... (at end of document)"."""
    problem, _, where = message.partition(" (at ")
    if match := re.match(r"line (\d+), column (\d+)", where):
        return int(match[1]), int(match[2]), problem
    lines = text.decode("utf-8").splitlines() or [""]
    return len(lines), len(lines[-1]) + 1, problem


def as_toml(value: object) -> str:
    """Give a value as the file has it."""
    write: Callable[[object], str] = str if not isinstance(value, bool) else lambda value: str(value).lower()
    return f'"{short(value)}"' if isinstance(value, str) else short(write(value))
