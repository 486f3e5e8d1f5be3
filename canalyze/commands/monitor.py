"""`canalyze monitor`: a bus on the screen, or captures replayed on it.

What is on the screen stands in `monitor/`, which alone needs textual; here it is found out what is read, and everything
that keeps it from being read is said before the screen is taken.
"""

import importlib
import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, Unpack

import click

from canalyze.configuration.options import (
    ANY_PATH,
    CoreUsageError,
    open_session,
    reading_options,
    spelled,
    start_session,
)
from canalyze.errors import CanalyzeError
from canalyze.output import complain, terminal_encoding
from canalyze.output.help import Command
from canalyze.running.listening import (
    ListeningOptions,
    OwnOptions,
    channels_of,
    listening,
    listening_options,
    set_rates,
)
from canalyze.running.reading import Reading
from canalyze.sinks.target import RECORDS
from canalyze.sources.file import STDIN
from canalyze.sources.format import open_capture
from canalyze.sources.replay import Replay
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.monitor.watch import Watch

_FILES: Final = frozenset({"speed", "stamps", "input_format", "merge", "threads", "topic", "time_source", "mcap_map"})
"""Parameters that only files have."""
_CHANNELS: Final = frozenset(OwnOptions.__annotations__)
"""Parameters that only channels have."""


class Shown(NamedTuple):
    """How it is shown."""

    expression: str | None
    """The first filter of the frames."""
    bell: bool
    """Whether the bell rings for new problems."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        names: tuple[str, ...],
        expression: str | None,
        stamps: str,
        speed: float | None,
        bell: bool,
        **given: Unpack[ListeningOptions],
    ) -> int:
        context = click.get_current_context()
        files = _are_files(names, given, words)
        for param in context.command.params:
            if param.name in (_CHANNELS if files else _FILES) and _was_given(context, param.name or ""):
                key = "monitor.only_channels" if files else "monitor.only_files"
                raise click.UsageError(words(key, option=param.opts[-1]), context)
        _refuse(words)
        if files:
            session = open_session(words, given, format="monitor")
            _check(session, expression)
            return _replay(
                session, names, words, given, stamps, 1.0 if speed is None else speed, Shown(expression, bell)
            )
        return _listen(names, words, given, Shown(expression, bell))

    return Command(
        "monitor",
        words,
        run,
        [
            click.Argument(["names"], nargs=-1, type=ANY_PATH, metavar="CHANNEL|FILE"),
            spelled(words, "--speed", _speed, "speed", "X", "monitor.speed"),
            click.Option(["--bell"], is_flag=True, help=words("monitor.bell")),
            *listening_options(words),
            *reading_options(words),
        ],
    )


def _listen(names: tuple[str, ...], words: Words, given: ListeningOptions, how: Shown) -> int:
    """Show what is received until the user has seen enough; give the exit code."""
    from canalyze.monitor.watch import Watch

    named = channels_of(names, given, words)
    masks = [channel.mask for channel in named if channel.filters] or None
    rates = set(set_rates([channel.name for channel in named], given))
    if len(rates) == 1 and (rate := rates.pop()):
        given["bitrate"] = rate
    session = open_session(words, given, format="monitor", masks=masks)
    _check(session, how.expression)
    before: list[str] = []
    with listening(named, given, words, before.append) as opened:
        recordings = opened.recordings
        records = (lambda: "unrecorded" if recordings.failed else "records") if recordings.written else None
        watch = Watch(session, words, opened.live.name, lambda _: opened.live, recording=records)
        for line in before:
            watch.complain(line)
        code = _show(watch, words, how)
        for line in opened.complete(words):
            complain(line)
        for one in recordings.written:
            complain(f"canalyze: {one.in_words(words)}")
        return 2 if recordings.failed else code


def _replay(
    session: "Session",
    names: tuple[str, ...],
    words: Words,
    given: ListeningOptions,
    stamps: str,
    speed: float,
    how: Shown,
) -> int:
    """Show captures as if they came now; give the exit code."""
    from canalyze.monitor.watch import Watch

    try:
        frames = start_session(words, given, format="convert", to=RECORDS, stamps=stamps)
    except ValueError as error:
        raise CoreUsageError(str(error), click.get_current_context()) from error
    form = given.get("input_format")

    def open_source(watch: "Watch") -> Replay:
        reading = Reading(
            frames,
            words,
            watch,
            open_input=partial(open_capture, asked=form),
            merge=given.get("merge", False),
            given_format=form is not None,
        )
        return Replay(names[0], reading.over(names), speed=speed)

    watch = Watch(session, words, names[0], open_source, replay=True)
    if not watch.primed():
        for line in watch.all_complaints():
            complain(line)
        return 2
    return _show(watch, words, how)


def _show(watch: "Watch", words: Words, how: Shown) -> int:
    """Show it until the user has seen enough; give the exit code."""
    from canalyze.monitor.app import Monitor

    app = Monitor(watch, words, expression=how.expression or "", bell=how.bell)
    watch.start()
    try:
        code = app.run()
    finally:
        watch.stop()
    for line in watch.all_complaints():
        complain(line)
    if watch.crash is not None:
        raise watch.crash
    code = app.return_code if code is None else code
    return code or (2 if watch.failure else 0)


def _are_files(names: tuple[str, ...], given: ListeningOptions, words: Words) -> bool:
    """Tell whether files are named, or channels."""
    context = click.get_current_context()
    if not names:
        raise click.UsageError(words("monitor.none"), context)
    if STDIN in names:
        raise click.UsageError(words("monitor.no_stdin"), context)
    if given.get("interface"):
        return False
    files = [name for name in names if _is_there(name) or "/" in name or _named_as_a_file(name)]
    if files and len(files) < len(names):
        channel = next(name for name in names if name not in files)
        raise click.UsageError(words("monitor.mixed", file=files[0], channel=channel), context)
    return bool(files)


def _is_there(name: str) -> bool:
    """Tell whether there is a file of this name; a folder may be called as a channel is."""
    path = Path(name)
    try:
        return path.exists() and not path.is_dir()
    except (OSError, ValueError):
        return False


def _named_as_a_file(name: str) -> bool:
    """Tell a name with a suffix: no interface of SocketCAN has one, but one may be told apart by a number (can0.1)."""
    return bool(Path(name.split(",", 1)[0]).suffix.strip(".0123456789"))


def _was_given(context: click.Context, name: str) -> bool:
    return context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE


def _refuse(words: Words) -> None:
    """Say what is missing on this machine, before anything is opened."""
    try:
        importlib.import_module("canalyze.monitor.app")
    except ImportError as error:
        raise CanalyzeError("monitor.missing") from error
    if terminal_encoding() is None:
        raise click.UsageError(words("monitor.no_terminal"), click.get_current_context())
    if os.environ.get("TERM", "") in ("dumb", "unknown"):
        raise CanalyzeError("monitor.dumb", term=os.environ["TERM"])


def _check(session: "Session", expression: str | None) -> None:
    """Make sure that the first filter can be read."""
    try:
        session.trace(expression or "", "", None, 1, True)
    except ValueError as error:
        raise CoreUsageError(str(error), click.get_current_context()) from error


def _speed(text: str) -> float | None:
    """Read a speed; 0 stands for as fast as can be."""
    if text == "max":
        return 0.0
    try:
        speed = float(text)
    except ValueError:
        return None
    return speed if 0 < speed < 1e6 else None
