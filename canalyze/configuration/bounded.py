"""Files of the user's that are read whole: configuration, expectations, baselines; never more of one than its bound.

A file that somebody hands over must cost no more than it is worth, whatever it holds: a device without end, too. Must
not: know what is in it.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeVar

from canalyze.errors import ConfigError, as_error

T = TypeVar("T")
MOST: Final = 2 << 20
"""Bytes of such a file; a hundred times those of a large one."""
_SHOWN: Final = 200


def content(path: Path) -> bytes:
    """Reads a file; OSError as the system has it, ConfigError where it is too large."""
    with path.open("rb") as file:
        read = file.read(MOST + 1)
    if len(read) > MOST:
        raise ConfigError("config.large", file=path, most=MOST >> 20)
    return read


def checked(path: Path, read: Callable[[bytes, str], T], unreadable: str) -> T:
    """Returns a file as the core reads it; ConfigError for an error in it, `unreadable` if it cannot be opened."""
    from canalyze._core import SettingsError

    with as_error(ConfigError, unreadable, file=path):
        found = content(path)
    try:
        return read(found, str(path).encode("utf-8", "backslashreplace").decode())
    except SettingsError as error:
        key, facts = error.args
        raise ConfigError(key, **facts) from error


def short(text: str) -> str:
    """Returns a text as one line can show it."""
    return text if len(text) <= _SHOWN else text[: _SHOWN - 1] + "…"
