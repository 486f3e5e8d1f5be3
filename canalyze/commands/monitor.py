"""`canalyze monitor`: a bus on the screen, or captures replayed on it.

What is on the screen stands in `monitor/`, which alone needs textual; here it is found out what is read, and everything
that keeps it from being read is said before the screen is taken.
"""

import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, Unpack

import click

from canalyze.errors import CanalyzeError, CoreError
from canalyze.help import Command
from canalyze.options import (
    ANY_PATH,
    CaptureOptions,
    CoreUsageError,
    Spelled,
    open_session,
    reading_options,
    start_session,
)
from canalyze.output import complain, terminal_encoding
from canalyze.sinks.target import RECORDS
from canalyze.sources.file import STDIN
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.listening import ListeningOptions
    from canalyze.monitor.watch import Watch

_ONLY_FILES: Final = ("input_format", "merge", "topic", "time_source", "mcap_map")


class MonitorOptions(CaptureOptions, total=False):
    """Options of captures and of channels."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""
    from canalyze.listening import listening_options

    def run(
        names: tuple[str, ...],
        expression: str | None,
        stamps: str,
        speed: float | None,
        **given: Unpack[MonitorOptions],
    ) -> int:
        context = click.get_current_context()
        _refuse(words)
        files = _files(names, words)
        for option in _misplaced(context, files=files):
            key = "monitor.only_channels" if files else "monitor.only_files"
            raise click.UsageError(words(key, option=option), context)
        open_watch = _replay if files else _listen
        if files:
            session = open_session(words, given, format="monitor")
        else:
            from canalyze.listening import channels_of

            masks = [mask for channel in channels_of(names, words) for mask in channel.masks]
            session = open_session(words, given, format="monitor", masks=masks or None)
        _check_filter(session, expression)
        watch = open_watch(session, names, words, given, stamps, 1.0 if speed is None else speed)
        return _show(watch, words, expression or "")

    return Command(
        "monitor",
        words,
        run,
        [
            click.Argument(["names"], nargs=-1, type=ANY_PATH, metavar="CHANNEL|FILE"),
            click.Option(["--speed"], type=Spelled(_speed, "speed", words), metavar="X", help=words("monitor.speed")),
            *reading_options(words),
            *listening_options(words),
        ],
    )


def _speed(text: str) -> float | None:
    """Read a speed; 0 stands for as fast as can be."""
    if text == "max":
        return 0.0
    try:
        speed = float(text)
    except ValueError:
        return None
    return speed if 0 < speed < 1e6 else None
