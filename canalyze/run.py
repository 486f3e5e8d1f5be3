"""One pass over a capture: sources in, a session between, results out.

The only loop that reads. It hands over every result at once, complaints in their place, and keeps Ctrl-C from losing
what is already known: the first one ends the reading, not the work.
"""

import json
import os
import signal
import sys
from collections.abc import Callable
from functools import partial
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Final, Self, TypeVar

import click

from canalyze.errors import SourceError
from canalyze.output import Progress, complain
from canalyze.sources.format import Capture, open_capture
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.options import CaptureOptions
    from canalyze.sources.pythoncan import PythonCanCapture

T = TypeVar("T")

_LISTED: Final = 20
"""Topics of a file without frames that are named."""
_HELD: Final = 100
"""Complaints kept about a file in which no frame was found yet."""


class Interrupt:
    """Ctrl-C and SIGTERM as a wish that the loop sees; a second one ends everything at once."""

    def __init__(self) -> None:
        """Nothing wished yet."""
        self.signal = 0
        self._waiting = False
        self._before: dict[int, Callable[[int, FrameType | None], object] | int | None] = {}

    def __enter__(self) -> Self:
        """Listen, except to what the caller ignores (as a shell does for a command in the background)."""
        for number in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(number) is not signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._wish)
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Let the signals be what they were."""
        for number, handler in self._before.items():
            if handler is not None:
                signal.signal(number, handler)

    def _wish(self, number: int, _: FrameType | None) -> None:
        again = self.signal != 0
        self.signal = number
        if again:
            raise SystemExit(128 + number)
        if self._waiting:
            raise KeyboardInterrupt

    def during(self, wait: Callable[[], T]) -> T | None:
        """Do what may wait long, unless the end is wished; a wish ends the waiting, and the answer is then None."""
        try:
            self._waiting = True
            return None if self.signal else wait()
        except KeyboardInterrupt:
            return None
        finally:
            self._waiting = False


class Run:
    """One capture of one or several inputs through one session."""

    def __init__(
        self,
        session: "Session",
        words: Words,
        progress: Progress,
        take: Callable[[bytes], None],
        given: "CaptureOptions",
    ) -> None:
        """`take` gets every result of the session, in order, also an empty one; `given` says how inputs are read."""
        self._input_format = given.get("input_format")
        context = click.get_current_context(silent=True)
        self._command = context.command_path if context else "canalyze decode"
        self._session = session
        self._words = words
        self._progress = progress
        self._take = take
        self._name = ""
        self._held: list[str] = []
        self._more = 0

    def over(self, names: tuple[str, ...]) -> int:
        """Read all of them and finish the capture; give the exit code."""
        code = 0
        with Interrupt() as interrupt:
            for name in names:
                try:
                    capture = interrupt.during(partial(open_capture, name, self._command, self._input_format))
                    if capture is None:
                        break
                    with capture:
                        self._read(capture, interrupt)
                except SourceError as error:
                    self.complain(f"canalyze: {error.in_words(self._words)}")
                    code = error.exit_code
            self._hand_over(self._session.finish(), hold=False)
            self._progress.clear()
            return 128 + interrupt.signal if interrupt.signal else code

    def complain(self, line: str) -> None:
        """Write a line to standard error, with the progress out of its way."""
        self._progress.clear()
        complain(line)

    def _read(self, capture: "Capture | PythonCanCapture", interrupt: Interrupt) -> None:
        session = self._session
        session.begin(os.fsencode(capture.name).decode("utf-8", "backslashreplace"), capture.regular, capture.format)
        self._name, self._held, self._more = capture.name, [], 0
        data: bytes | None = b""
        taken = 0
        stopped: SourceError | None = None
        try:
            while data := interrupt.during(capture.read):
                self._hand_over(session.feed(data), hold=capture.regular)
                self._remarks(capture)
                self._progress.step(capture.taken - taken, session.frames)
                taken = capture.taken
        except SourceError as error:  # what came before it is said first
            stopped = error
        self._remarks(capture)
        # A wish that came after the last byte cut nothing short: then data is b"".
        rest = session.end(interrupted=True) if data is None else session.end()
        self._hand_over(rest, hold=capture.regular)
        if stopped:
            raise stopped
        if session.file_frames == 0 and not interrupt.signal:
            self._held, self._more = [], 0  # one line says it all
            raise self._nothing(capture, taken)
        self._release()

    def _remarks(self, capture: "Capture | PythonCanCapture") -> None:
        for remark in capture.remarks():
            self.complain(remark.in_words(self._words))

    def _nothing(self, capture: "Capture | PythonCanCapture", taken: int) -> SourceError:
        """Say why there is no frame: of a file with topics, which ones there are."""
        if taken and capture.format == "mcap":
            topics = json.loads(self._session.contents())["topics"]
            listed = ", ".join(f"{topic['name']} ({topic['schema'] or '?'})" for topic in topics[:_LISTED])
            more = ", ..." if len(topics) > _LISTED else ""
            names = f"{listed}{more}" or self._words("source.topics_empty")
            return SourceError("source.no_topic", name=capture.name, topics=names)
        key = "source.empty" if not taken else "source.nothing" if capture.format == "candump" else "source.frameless"
        return SourceError(key, name=capture.name)

    def _hand_over(self, result: bytes, *, hold: bool) -> None:
        """Pass a result on, then what is to be complained of; of a file without any frame one line will do."""
        self._take(result)
        complaints = self._session.complaints()
        if hold and self._session.file_frames == 0:
            room = _HELD - len(self._held)
            self._held += complaints[:room]
            self._more += len(complaints[room:])
            return
        self._release()
        for line in complaints:
            self.complain(line)

    def _release(self) -> None:
        for line in self._held:
            self.complain(line)
        if self._more:
            self.complain(self._words("source.more_complaints", name=self._name, count=self._more))
        self._held, self._more = [], 0


def piped() -> bool:
    """Tell whether standard input is a pipe or a file, so that it may be read unasked."""
    return sys.stdin is not None and not sys.stdin.isatty()
