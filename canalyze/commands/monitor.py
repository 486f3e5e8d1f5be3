"""`canalyze monitor`: a bus on the screen, or captures replayed on it.

What is on the screen, and what it shows, is in `monitor/`, which alone needs textual; everything that keeps it from
being shown is reported before the screen is taken.
"""

import importlib
import os
from pathlib import Path
from typing import Final

from canalyze.configuration.options import ANY_PATH, READING, argument, option, typed, usage
from canalyze.errors import CanalyzeError, as_error
from canalyze.output import terminal_encoding
from canalyze.running.listening import LISTENING, OwnOptions
from canalyze.running.passes import Pass, pass_command
from canalyze.sources import STDIN
from canalyze.words import Words

_FILES: Final = frozenset({"speed", "stamps", "input_format", "merge", "threads", "topic", "time_source", "mcap_map"})
"""Parameters that only files have."""
_CHANNELS: Final = frozenset(OwnOptions.__annotations__)
"""Parameters that only channels have."""


def run(one: Pass) -> int:
    """Shows what is named."""
    names, words = one.given.pop("names"), one.words
    files = _are_files(names, one.interface, words)
    for param in typed():
        if param.name in (_CHANNELS if files else _FILES):
            raise usage(words, "monitor.only_channels" if files else "monitor.only_files", option=param.opts[-1])
    _refuse(words)
    from canalyze.monitor.opening import Shown, listen, replay

    how = Shown(one.expression, one.bell)
    if not files:
        return listen(names, words, one.given, how)
    return replay(names, words, one.given, one.stamps, 1.0 if one.speed is None else one.speed, how)


def _are_files(names: tuple[str, ...], interface: str | None, words: Words) -> bool:
    """Returns true if files are named, false for channels."""
    if not names:
        raise usage(words, "monitor.none")
    if STDIN in names:
        raise usage(words, "monitor.no_stdin")
    if interface:
        return False
    files = [name for name in names if _is_there(name) or "/" in name or _named_as_a_file(name)]
    if files and len(files) < len(names):
        channel = next(name for name in names if name not in files)
        raise usage(words, "monitor.mixed", file=files[0], channel=channel)
    return bool(files)


def _is_there(name: str) -> bool:
    """Returns true if there is a file of this name; a folder may be called as a channel is."""
    path = Path(name)
    try:
        return path.exists() and not path.is_dir()
    except (OSError, ValueError):
        return False


def _named_as_a_file(name: str) -> bool:
    """Returns true for a name with a suffix; an interface of SocketCAN has none but a number (can0.1)."""
    return bool(Path(name.split(",", 1)[0]).suffix.strip(".0123456789"))


def _refuse(words: Words) -> None:
    """Raises for what is missing on this machine, before anything is opened."""
    with as_error(CanalyzeError, "monitor.missing", ImportError):
        importlib.import_module("canalyze.monitor.app")
    if terminal_encoding() is None:
        raise usage(words, "monitor.no_terminal")
    if os.environ.get("TERM", "") in ("dumb", "unknown"):
        raise CanalyzeError("monitor.dumb", term=os.environ["TERM"])


def _speed(text: str) -> float | None:
    """Reads a speed; 0 is as fast as possible."""
    if text == "max":
        return 0.0
    try:
        speed = float(text)
    except ValueError:
        return None
    return speed if 0 < speed < 1e6 else None


command = pass_command(
    "monitor",
    run,
    argument("names", "CHANNEL|FILE", nargs=-1, type=ANY_PATH),
    *LISTENING,
    option("--speed", "X", _speed, "speed", usual=0),
    option("--bell"),
    *READING,
)
