"""One pass over a capture: sources in, a session between, results out.

The only loop that reads. It hands over every result at once, complaints in their place, and keeps Ctrl-C from losing
what is already known: the first one ends the reading, not the work.
"""

import json
import os
import signal
import sys
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Final, Protocol, Self, TypeVar

from canalyze.errors import SourceError
from canalyze.output import complain
from canalyze.sources.format import Capture, open_capture
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.options import CaptureOptions
    from canalyze.sources.pythoncan import PythonCanCapture

T = TypeVar("T")

_HELD: Final = 100
"""Complaints kept about a file in which no frame was found yet."""
_LISTED: Final = 20
"""Topics of a file without frames that are named."""
_JOINED: Final = 4 << 20
"""Bytes that are fed of all files together at once, where they are joined by time: their frames wait in memory."""
_LEAST: Final = 16 << 10
"""Bytes that are fed of one of them at least."""


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


class _Input:
    """One open file of those that are read together."""

    def __init__(self, capture: "Capture | PythonCanCapture") -> None:
        self.capture = capture
        self.taken = 0
        self.rest = b""
        """What was read and not fed yet."""

    def read(self, most: int | None) -> bytes:
        """Give the next bytes, at most so many; b"" at the end."""
        if not self.rest:
            self.rest = self.capture.read()
        given, self.rest = (self.rest, b"") if most is None else (self.rest[:most], self.rest[most:])
        return given


class Meter(Protocol):
    """What is told how far the reading is: a line on a terminal, or another process."""

    def step(self, size: int, frames: int) -> None:
        """Count `size` bytes more; so many frames were read."""

    def clear(self) -> None:
        """Something else is about to be written."""


class Run:
    """One capture of one or several inputs through one session."""

    def __init__(
        self,
        session: "Session",
        words: Words,
        progress: Meter,
        take: Callable[[bytes], None],
        given: "CaptureOptions",
        *,
        frameless: bool = False,
        tell: Callable[[str], None] = complain,
    ) -> None:
        """`take` gets every result of the session, in order, also an empty one; `given` says how inputs are read.

        frameless: a file without any frame is fine, if it has the sign of its format. tell: gets what is to be
        complained of, line by line.
        """
        self._tell = tell
        self._input_format = given.get("input_format")
        self._merge = given.get("merge", False)
        self._frameless = frameless
        self._session = session
        self._words = words
        self._progress = progress
        self._take = take
        self._name = ""
        self._held: list[str] = []
        self._more = 0
        self.last: Capture | PythonCanCapture | None = None
        """The input that was read last, closed: what is known of it."""
        self.understood = False
        """Something could be read of it."""
        self.failure: str | None = None
        """Why an input, or its rest, could not be read: the first such reason, in words."""

    def over(self, names: tuple[str, ...]) -> int:
        """Read all of them, one after the other or joined by time, and finish the capture; give the exit code."""
        self._code = 0
        with Interrupt() as interrupt:
            for group in [names] if self._merge else [(name,) for name in names]:
                if interrupt.signal:
                    break
                try:
                    self._read(group, interrupt)
                except SourceError as error:
                    self._failed(error)
            self._hand_over(self._session.finish(), hold=False)
            self._progress.clear()
            return 128 + interrupt.signal if interrupt.signal else self._code

    def complain(self, line: str) -> None:
        """Write a line to standard error, with the progress out of its way."""
        self._progress.clear()
        self._tell(line)

    def _failed(self, error: SourceError) -> None:
        reason = error.in_words(self._words)
        self.failure = self.failure or reason
        self.complain(f"canalyze: {reason}")
        self._code = error.exit_code

    def _read(self, names: tuple[str, ...], interrupt: Interrupt) -> None:
        """Read files together: each goes on when the session needs it."""
        with ExitStack() as stack:
            inputs: list[_Input] = []
            for name in names:
                capture: Capture | PythonCanCapture | None
                try:
                    capture = interrupt.during(partial(open_capture, name, self._input_format))
                except SourceError as error:
                    self._failed(error)
                    continue
                if capture is None:
                    break
                stack.callback(capture.__exit__, None, None, None)
                inputs.append(_Input(capture))
            self._through(inputs, interrupt)

    def _through(self, inputs: list[_Input], interrupt: Interrupt) -> None:
        session = self._session
        for place, one in enumerate(inputs):
            capture = self.last = one.capture
            session.begin(_utf8(capture.name), capture.regular, capture.format, place)
            self._name, self._held, self._more = capture.name, [], 0
        joined = len(inputs) > 1
        most = max(_LEAST, _JOINED // len(inputs)) if joined else None
        open_ = dict(enumerate(inputs))
        while open_ and (number := session.wants()) is not None:
            one = open_[number]
            stopped: SourceError | None = None
            try:
                data = interrupt.during(partial(one.read, most))
            except SourceError as error:  # what came before it is said first
                data, stopped = b"", error
            self._remarks(one.capture)
            if data is None:
                break
            hold = one.capture.regular and not joined
            if data:
                self._hand_over(session.feed(data, number), hold=hold)
                self._remarks(one.capture)
                self._progress.step(one.capture.taken - one.taken, session.frames)
                one.taken = one.capture.taken
                continue
            self._remarks(one.capture)
            del open_[number]
            self._ended(number, one.capture, stopped, hold=hold)
        refusal = session.refusal()
        if refusal:
            reason, numbers = refusal
            names = [inputs[number].capture.name for number in numbers]
            raise SourceError(f"merge.{reason}", name=names[0], other=names[-1])
        for place, one in open_.items():  # broken off
            self._hand_over(session.end(interrupted=True, input=place), hold=one.capture.regular and not joined)
        self._release()

    def _ended(
        self, number: int, capture: "Capture | PythonCanCapture", stopped: SourceError | None, *, hold: bool
    ) -> None:
        session = self._session
        self.understood = stopped is None or session.file_frames > 0
        if capture.damage:
            session.damaged(capture.damage.kind, capture.damage.offset, capture.damage.lost, number)
        self._hand_over(session.end(input=number), hold=hold)
        if session.file_frames == 0:
            if stopped is None:
                stopped = self._nothing(capture)
                if stopped and capture.format == "candump" and not capture.damage:
                    self._held, self._more = [], 0  # it is none: one line says it all
            self.understood = stopped is None
        self._release()
        if stopped:
            self._failed(stopped)

    def _remarks(self, capture: "Capture | PythonCanCapture") -> None:
        for remark in capture.remarks():
            self.complain(remark.in_words(self._words))

    def _nothing(self, capture: "Capture | PythonCanCapture") -> SourceError | None:
        """Say why there is no frame, unless that is no fault: of a file with topics, which ones there are."""
        if not capture.taken:
            return SourceError("source.empty", name=capture.name)
        if self._frameless and capture.format != "candump":
            return None
        if capture.format == "mcap":
            topics = json.loads(self._session.contents())["topics"]
            topics.sort(key=lambda topic: topic["messages"] == 0)  # what holds nothing is listed last
            listed = ", ".join(f"{topic['name']} ({topic['schema'] or '?'})" for topic in topics[:_LISTED])
            more = ", ..." if len(topics) > _LISTED else ""
            if topics:
                return SourceError("source.no_topic", name=capture.name, topics=f"{listed}{more}")
        # Of what could not be unpacked, or is said to be something, there is nothing to guess.
        if capture.format == "candump" and not self._input_format and not capture.damage:
            return SourceError("source.nothing", name=capture.name)
        form = self._words.of("info.title", capture.kind)
        return SourceError("source.frameless", name=capture.name, form=form)

    def _hand_over(self, result: bytes, *, hold: bool) -> None:
        """Pass a result on, then what is to be complained of; of a file that is no capture one line will do."""
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


def _utf8(name: str) -> str:
    return os.fsencode(name).decode("utf-8", "backslashreplace")


def piped() -> bool:
    """Tell whether standard input is a pipe or a file, so that it may be read unasked."""
    return sys.stdin is not None and not sys.stdin.isatty()
