"""canalyze.toml, CANALYZE_LANG and the global options -> one frozen Config.

The only place that decides the language. It must not print: what is wrong is a ConfigError, worded by who shows it.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from canalyze.errors import ConfigError
from canalyze.words import LANGUAGES

FILE: Final = "canalyze.toml"


@dataclass(frozen=True, slots=True)
class Config:
    """What holds for the whole run."""

    lang: str = "zh"
    """zh or en."""
    chosen: bool = False
    """Whether anybody chose the language: then it stands, whatever the terminal can show."""


KEYS: Final[dict[str, tuple[str, ...]]] = {"lang": LANGUAGES}
"""Keys of canalyze.toml and their values."""


def settle(lang: str | None, file: str | None) -> Config:
    """Decide by option, CANALYZE_LANG and file, in that order; raise ConfigError for what cannot be."""
    given = language(lang)
    if lang is not None and given is None:
        raise ConfigError("config.lang_option", value=lang or '""')
    wanted = os.environ.get("CANALYZE_LANG") or None
    if lang is None and wanted is not None and language(wanted) is None:
        raise ConfigError("config.lang_env", value=wanted)
    filed = read(file).get("lang")  # always: a broken file is said even where another choice wins
    choice = given or language(wanted) or filed
    return Config(lang=choice or "zh", chosen=choice is not None)


def spoken(lang: str | None) -> Config:
    """Give what holds where the file does not count (a ConfigError, help): the first valid choice that needs none."""
    choice = language(lang) or language(os.environ.get("CANALYZE_LANG"))
    return Config(lang=choice or "zh", chosen=choice is not None)


def language(value: str | None) -> str | None:
    """Give the language that is meant by one of LANGUAGES in any case, or by a locale such as zh_CN.UTF-8."""
    import re

    name = re.split("[_.@-]", value or "", maxsplit=1)[0].lower()
    return name if name in LANGUAGES else None


def read(file: str | None) -> dict[str, str]:
    """Read the named file, or canalyze.toml of the current directory if there is one, and check every key."""
    path = Path(FILE if file is None else file)
    try:
        text = path.read_bytes()
    except FileNotFoundError as error:
        if file is None:
            return {}
        raise ConfigError("config.unreadable", file=path, error=error) from error
    except OSError as error:
        raise ConfigError("config.unreadable", file=path, error=error) from error
    values: dict[str, str] = {}
    for key, value in _parsed(path, text).items():
        if key not in KEYS:
            raise ConfigError("config.unknown", file=path, key=key, allowed=", ".join(KEYS))
        if value not in KEYS[key]:
            allowed = ", ".join(f'"{name}"' for name in KEYS[key])
            raise ConfigError("config.value", file=path, key=key, value=_as_toml(value), allowed=allowed)
        values[key] = str(value)
    return values


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
    import re

    problem, _, where = message.partition(" (at ")
    if match := re.match(r"line (\d+), column (\d+)", where):
        return int(match[1]), int(match[2]), problem
    lines = text.decode("utf-8").splitlines() or [""]
    return len(lines), len(lines[-1]) + 1, problem


def _as_toml(value: object) -> str:
    write: Callable[[object], str] = str if not isinstance(value, bool) else lambda value: str(value).lower()
    return f'"{value}"' if isinstance(value, str) else write(value)
