"""The subject of the screen, from names and options: a bus that is listened to, or captures that are replayed.

Must not: draw.
"""

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import click

from canalyze.configuration.options import CoreUsageError, open_session, start_session
from canalyze.monitor.watch import Watch
from canalyze.output import complain
from canalyze.running.listening import ListeningOptions, channels_of, listening, set_rates
from canalyze.running.reading import Reading
from canalyze.sinks import RECORDS
from canalyze.sources.format import open_capture
from canalyze.sources.replay import Replay
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session


class Shown(NamedTuple):
    """Options of the screen."""

    expression: str | None
    """The first filter of the frames."""
    bell: bool
    """True if the bell rings for new problems."""


def listen(names: tuple[str, ...], words: Words, given: ListeningOptions, how: Shown) -> int:
    """Shows what is received until the user has seen enough; returns the exit code."""
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
        complain(*opened.complete(words))
        for one in recordings.written:
            complain(f"canalyze: {one.in_words(words)}")
        return 2 if recordings.failed else code


def replay(names: tuple[str, ...], words: Words, given: ListeningOptions, stamps: str, speed: float, how: Shown) -> int:
    """Shows captures as if they came now; returns the exit code."""
    session = open_session(words, given, format="monitor")
    _check(session, how.expression)
    try:
        frames = start_session(words, given, format="convert", to=RECORDS, stamps=stamps)
    except ValueError as error:
        raise CoreUsageError(str(error), click.get_current_context()) from error
    form = given.get("input_format")

    def open_source(watch: Watch) -> Replay:
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
        complain(*watch.all_complaints())
        return 2
    return _show(watch, words, how)


def _show(watch: Watch, words: Words, how: Shown) -> int:
    """Shows it until the user has seen enough; returns the exit code."""
    from canalyze.monitor.app import Monitor

    app = Monitor(watch, words, expression=how.expression or "", bell=how.bell)
    watch.start()
    try:
        code = app.run()
    finally:
        watch.stop()
    complain(*watch.all_complaints())
    if watch.crash is not None:
        raise watch.crash
    code = app.return_code if code is None else code
    return code or (2 if watch.failure else 0)


def _check(session: "Session", expression: str | None) -> None:
    """Raises a usage error for a first filter that cannot be read."""
    try:
        session.trace(expression or "", "", None, 1, True)
    except ValueError as error:
        raise CoreUsageError(str(error), click.get_current_context()) from error
