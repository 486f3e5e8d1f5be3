"""canalyze.toml, CANALYZE_LANG and the global options -> one frozen Config.

The only place that decides the language and that knows the tables of the file. It must not print: what is wrong is a
ConfigError, worded by who shows it.
"""

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

from canalyze import network
from canalyze.errors import ConfigError
from canalyze.words import LANGUAGES

FILE: Final = "canalyze.toml"
_NOTHING: Final = network.Known()


@dataclass(frozen=True, slots=True)
class Config:
    """What holds for the whole run."""

    lang: str = "zh"
    """zh or en."""
    chosen: bool = False
    """Whether anybody chose the language: then it stands, whatever the terminal can show."""
    known: network.Known = _NOTHING
    """What canalyze.toml says of the network; options may overrule it."""


class Key(NamedTuple):
    """How a value of canalyze.toml is read: None says that it cannot be, in the words `config.FORM`."""

    read: Callable[[Any], object]
    form: str
    needed: bool = False


def _text(value: object) -> str | None:
    return value if isinstance(value, str) and value else None


def _language(value: object) -> str | None:
    return value if isinstance(value, str) and value in LANGUAGES else None


def _node(value: object) -> int | None:
    return value if type(value) is int and value in network.NODES else None


def _nodes(value: object) -> tuple[int, ...] | None:
    if isinstance(value, str):
        return network.nodes(value)
    found = [_node(one) for one in (value if isinstance(value, list) else [value])]
    nodes = tuple(dict.fromkeys(node for node in found if node is not None))
    return nodes if nodes and None not in found else None


def _as_text(read: Callable[[str], object]) -> Callable[[object], object]:
    """Give a reader of strings only: in 181 nobody sees whether it was meant in hexadecimal."""
    return lambda value: read(value) if isinstance(value, str) else None


def _tolerance(value: object) -> int | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return network.nanoseconds(value)


def _bit_rate(value: object) -> int | None:
    return network.bit_rate(str(value)) if type(value) in (int, str) else None


_BUS: Final = Key(_text, "text")
_ID: Final = Key(_as_text(network.can_id), "can_id", needed=True)
ENTRIES: Final[Mapping[str, Mapping[str, Key]]] = {
    "eds": {"file": Key(_text, "text", needed=True), "node": Key(_nodes, "nodes"), "bus": _BUS},
    "cob": {
        "id": _ID,
        "node": Key(_node, "node", needed=True),
        "pdo": Key(_as_text(network.pdo), "pdo", needed=True),
        "bus": _BUS,
    },
    "sdo": {"client": _ID, "server": _ID, "node": Key(_node, "node", needed=True), "bus": _BUS},
}
"""Tables that may come several times, [[eds]], and their keys."""
SYNC: Final[Mapping[str, Key]] = {
    "period_us": Key(lambda value: _tolerance(value) or None, "period"),
    "window_us": Key(lambda value: _tolerance(value) or None, "period"),
}
"""Keys of [sync]."""
KEYS: Final[Mapping[str, Key]] = {
    "lang": Key(_language, "language"),
    "jitter_us": Key(_tolerance, "tolerance"),
    "bitrate": Key(_bit_rate, "bit_rate"),
}
"""Keys of canalyze.toml outside of tables."""


def settle(lang: str | None, file: str | None) -> Config:
    """Decide by option, CANALYZE_LANG and file, in that order; raise ConfigError for what cannot be."""
    given = language(lang)
    if lang is not None and given is None:
        raise ConfigError("config.lang_option", value=lang or '""')
    wanted = os.environ.get("CANALYZE_LANG") or None
    if lang is None and wanted is not None and language(wanted) is None:
        raise ConfigError("config.lang_env", value=wanted)
    filed = read(file)  # always: a broken file is said even where another choice wins
    choice = given or language(wanted) or (filed.lang if filed.chosen else None)
    return Config(lang=choice or "zh", chosen=choice is not None, known=filed.known)


def spoken(lang: str | None) -> Config:
    """Give what holds where the file does not count (a ConfigError, help): the first valid choice that needs none."""
    choice = language(lang) or language(os.environ.get("CANALYZE_LANG"))
    return Config(lang=choice or "zh", chosen=choice is not None)


def language(value: str | None) -> str | None:
    """Give the language that is meant by one of LANGUAGES in any case, or by a locale such as zh_CN.UTF-8."""
    name = re.split("[_.@-]", value or "", maxsplit=1)[0].lower()
    return name if name in LANGUAGES else None


def read(file: str | None) -> Config:
    """Read the named file, or canalyze.toml of the current directory if there is one, and check every key."""
    path = Path(FILE if file is None else file)
    try:
        text = path.read_bytes()
    except FileNotFoundError as error:
        if file is None:
            return Config()
        raise ConfigError("config.unreadable", file=path, error=error) from error
    except OSError as error:
        raise ConfigError("config.unreadable", file=path, error=error) from error
    values = _parsed(path, text)
    filed = _File(path, text.decode("utf-8").splitlines())
    for key in values:
        if key not in (*KEYS, *ENTRIES, "sync"):
            allowed = ", ".join([*KEYS, "[sync]", *(f"[[{name}]]" for name in ENTRIES)])
            raise ConfigError("config.unknown", file=filed.at("", 0, key), key=key, allowed=allowed)
    top = filed.read("", 0, {key: value for key, value in values.items() if key in KEYS}, KEYS)
    given = values.get("sync", {})
    if not isinstance(given, dict):
        raise ConfigError("config.table", file=filed.at("", 0, "sync"), key="sync", table="[sync]")
    sync = filed.read("sync", 0, given, SYNC)
    known = network.Known(
        tuple(
            network.Description(entry.get("bus"), entry.get("node") or (), str(path.parent / entry["file"]))
            for entry in filed.entries("eds", values)
        ),
        tuple(
            network.Cob(entry.get("bus"), entry["id"], entry["node"], *entry["pdo"])
            for entry in filed.entries("cob", values)
        ),
        tuple(
            network.SdoChannel(entry.get("bus"), entry["client"], entry["server"], entry["node"])
            for entry in filed.entries("sdo", values)
        ),
        sync.get("period_us"),
        sync.get("window_us"),
        top.get("jitter_us"),
        top.get("bitrate"),
    )
    lang = top.get("lang")
    return Config(lang=lang or "zh", chosen=lang is not None, known=known)


class _File:
    """A file whose TOML is in order: reads its tables, and finds the lines that tomllib does not tell."""

    def __init__(self, path: Path, lines: list[str]) -> None:
        """Take the lines of its text."""
        self._path = path
        self._lines = lines
        headings = ((number, _HEADING.fullmatch(line)) for number, line in enumerate(lines, 1))
        self._headings = [(number, match[1]) for number, match in headings if match]

    def at(self, table: str, place: int, key: str = "") -> str:
        """Give FILE:LINE of a key, or of its table, of which it is number `place`; FILE if neither is seen."""
        starts = [0] if table == "" else [number for number, name in self._headings if name == table]
        if place >= len(starts):  # not under a heading of its own: sync.period_us = 1, eds = [{...}]
            return self.at("", 0, table)
        start = starts[place]
        end = next((number for number, _ in self._headings if number > start), len(self._lines) + 1)
        pattern = re.compile(rf"""\s*["']?{re.escape(key)}["']?\s*[=.]""")
        seen = (number for number in range(start + 1, end) if pattern.match(self._lines[number - 1]))
        opened = (number for number, name in self._headings if not table and name == key)
        line = next(seen, None) or next(opened, start)
        return f"{self._path}:{line}" if line else str(self._path)

    def read(self, table: str, place: int, values: Mapping[str, object], keys: Mapping[str, Key]) -> dict[str, Any]:
        """Read the values of one table; ConfigError for what cannot be."""
        found = {}
        for name, value in values.items():
            shown = f"{table}.{name}" if table else name
            if name not in keys:
                file = self.at(table, place, name)
                raise ConfigError("config.unknown", file=file, key=shown, allowed=", ".join(keys))
            found[name] = keys[name].read(value)
            if found[name] is None:
                file = self.at(table, place, name)
                raise ConfigError(f"config.{keys[name].form}", file=file, key=shown, value=_as_toml(value))
        for name, key in keys.items():
            if key.needed and name not in found:
                raise ConfigError("config.lacks", file=self.at(table, place), key=f"{table}.{name}")
        return found

    def entries(self, table: str, values: Mapping[str, object]) -> list[dict[str, Any]]:
        """Read all tables of one name."""
        given = values.get(table, [])
        if not isinstance(given, list) or not all(isinstance(entry, dict) for entry in given):
            raise ConfigError("config.table", file=self.at(table, 0), key=table, table=f"[[{table}]]")
        found = []
        for place, entry in enumerate(given):
            found.append(self.read(table, place, entry, ENTRIES[table]))
            if table == "sdo" and found[-1]["client"] == found[-1]["server"]:
                file = self.at(table, place, "server")
                raise ConfigError("config.one_id", file=file, key="sdo.server", value=_as_toml(entry["server"]))
        return found


_HEADING: Final = re.compile(r"\s*\[{1,2}\s*([\w.-]+)\s*\]{1,2}\s*(?:#.*)?")


def _parsed(path: Path, text: bytes) -> dict[str, object]:
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


def _as_toml(value: object) -> str:
    write: Callable[[object], str] = str if not isinstance(value, bool) else lambda value: str(value).lower()
    return f'"{value}"' if isinstance(value, str) else write(value)
