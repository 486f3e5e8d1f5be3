"""A TOML file of the user's: its text parsed, its tables checked key by key, each mistake with its line.

What the configuration and the expectations have in common. Must not: know a key of either, or print: what is wrong is
a ConfigError, worded by who shows it.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple, NoReturn, Self

from canalyze import network
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


class File:
    """A file whose TOML is in order: reads its tables, and finds the lines that tomllib does not tell."""

    def __init__(self, path: Path, lines: list[str]) -> None:
        """Take the lines of its text."""
        self._path = path
        self._lines = lines
        headings = ((number, _HEADING.fullmatch(line)) for number, line in enumerate(lines, 1))
        self._headings = [(number, match[1]) for number, match in headings if match]

    @classmethod
    def parsed(cls, path: Path, content: bytes) -> tuple[Self, dict[str, Any]]:
        """Give a file of this content, and its values; ConfigError if it is no TOML."""
        values = parsed(path, content)
        return cls(path, content.decode("utf-8").splitlines()), values

    def line(self, table: str, place: int, key: str = "") -> int | None:
        """Give the line of a key, or of its table, of which it is number `place`; None if neither is seen."""
        starts = [0] if table == "" else [number for number, name in self._headings if name == table]
        if place >= len(starts):  # not under a heading of its own: sync.period_us = 1, eds = [{...}]
            return self.line("", 0, table)
        start = starts[place]
        end = next((number for number, _ in self._headings if number > start), len(self._lines) + 1)
        pattern = re.compile(rf"""\s*["']?{re.escape(key)}["']?\s*[=.]""")
        seen = (number for number in range(start + 1, end) if key and pattern.match(self._lines[number - 1]))
        opened = (number for number, name in self._headings if not table and name == key)
        return next(seen, None) or next(opened, start) or None

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

        near = get_close_matches(name.lower(), allowed, n=1, cutoff=0.7)
        shown = f"{table}.{name}" if table else name
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
    """Give the values of a file of this text; ConfigError if it is no TOML."""
    import tomllib

    try:
        return tomllib.loads(text.decode("utf-8"))
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise ConfigError("config.not_utf8", file=path, line=line) from error
    except tomllib.TOMLDecodeError as error:
        line, column, problem = _place(str(error), text)
        raise ConfigError("config.broken", file=path, line=line, column=column, problem=problem) from error


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
    return f'"{value}"' if isinstance(value, str) else write(value)
