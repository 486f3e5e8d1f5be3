"""One pass over a capture on the command line: results to where they belong, complaints to standard error.

It reads by `reading` and adds what only a command may do: it keeps Ctrl-C from losing what is already known (the first
one ends the reading, not the work), shows progress, and has an exit code.
"""

import signal
import sys
from collections.abc import Callable
from contextlib import closing
from functools import partial
from types import FrameType
from typing import TYPE_CHECKING, Protocol, Self, TypeVar

from canalyze.errors import ReaderGone, SourceError
from canalyze.output import complain
from canalyze.running.reading import Reading
from canalyze.sources import Capture, open_capture
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.configuration.options import CaptureOptions
    from canalyze.sources.live import Live

T = TypeVar("T")


class Interrupt:
    """Ctrl-C, SIGTERM and SIGHUP as a wish that the loop sees; a second one ends everything at once."""

    def __init__(self, wished: Callable[[], None] | None = None) -> None:
        """Nothing wished yet. wished: is called by the first wish, which then does not end what waits."""
        self.signal = 0
        self._wished = wished
        self._waiting = False
        self._before: dict[int, Callable[[int, FrameType | None], object] | int | None] = {}

    def __enter__(self) -> Self:
        """Handles signals, except those that the caller ignores (as a shell does for a command in the background)."""
        for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", None)):
            if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._wish)
        return self

    def __exit__(self, *_: object) -> None:
        """Restores the handlers of the signals."""
        for number, handler in self._before.items():
            if handler is not None:
                signal.signal(number, handler)

    def _wish(self, number: int, _: FrameType | None) -> None:
        again = self.signal != 0
        self.signal = number
        if again:
            raise SystemExit(128 + number)
        if self._wished:
            self._wished()
        elif self._waiting:
            raise KeyboardInterrupt

    @property
    def ended(self) -> bool:
        """True if what is under way has to end where it is."""
        return self.signal != 0 and self._wished is None

    def during(self, wait: Callable[[], T]) -> T | None:
        """Calls what may wait long, unless the end is wished; a wish ends the waiting, and the answer is then None."""
        try:
            self._waiting = True
            return None if self.ended else wait()
        except KeyboardInterrupt:
            return None
        finally:
            self._waiting = False


class Meter(Protocol):
    """Shows how far the reading is: a line on a terminal, or a message to another process."""

    def step(self, size: int, frames: int) -> None:
        """Counts `size` bytes more; so many frames were read."""

    def clear(self) -> None:
        """Hides it: something else is about to be written."""


class NoProgress:
    """A meter that shows nothing: of a reading beside the one that counts."""

    def step(self, size: int, frames: int) -> None:
        """Shows nothing."""

    def clear(self) -> None:
        """Shows nothing."""


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
        live: "Live | None" = None,
        shown: str | None = None,
    ) -> None:
        """`take` gets every result of the session, in order, also an empty one; `given` says how inputs are read.

        frameless: a file without any frame is fine, if it has the sign of its format. tell: gets what is to be
        complained of, line by line. live: what is read, whatever the name; the first signal stops it, so that what it
        has received is still read, and Ctrl-C is its usual end. shown: the name of what is read, for people.
        """
        form = given.get("input_format")
        # Made when it reads, so that the two do not hold each other, and with them the session, when that is over.
        self._reading = partial(
            Reading,
            session,
            words,
            open_input=partial(open_capture, asked=form, shown=shown) if live is None else lambda _: live,
            merge=given.get("merge", False),
            given_format=form is not None,
            frameless=frameless,
        )
        self.failure: str | None = None
        """Why an input, or its rest, could not be read: the first such reason, in words."""
        self.last: Capture | Live | None = None
        """The input that was read last, closed: what is known of it."""
        self.understood = False
        """Something could be read of it."""
        self._live = live is not None
        self._tell = tell
        self._words = words
        self._progress = progress
        self._take = take
        self._interrupt = Interrupt(None if live is None else live.stop)

    @property
    def signal(self) -> int:
        """The signal that has ended the reading; 0 if none has."""
        return self._interrupt.signal

    def over(self, names: tuple[str, ...]) -> int:
        """Reads all of them, one after the other or joined by time, and finishes the capture; returns the exit code."""
        self._code = 0
        reading = self._reading(self)
        try:
            with self._interrupt, closing(reading.over(names)) as results:
                for result in results:
                    self._take(result)
                self._progress.clear()
        except ReaderGone as gone:  # what could not be read before stays unread
            gone.exit_code = self._code
            raise
        finally:
            self.last, self.understood = reading.last, reading.understood
        ended_by = 0 if self._live and self.signal == signal.SIGINT else self.signal
        return 128 + ended_by if ended_by else self._code

    @property
    def ended(self) -> bool:
        """True if a signal came."""
        return self._interrupt.ended

    def during(self, wait: Callable[[], T]) -> T | None:
        """Calls what may wait long; a signal ends the waiting, and the answer is then None."""
        return self._interrupt.during(wait)

    def complain(self, line: str) -> None:
        """Writes a line to standard error, with the progress out of its way."""
        self._progress.clear()
        self._tell(line)

    def failed(self, error: SourceError) -> None:
        """Reports that an input cannot be read: the others are read all the same, and the exit code shows it."""
        reason = error.in_words(self._words)
        self.failure = self.failure or reason
        self.complain(f"canalyze: {reason}")
        self._code = error.exit_code

    def step(self, size: int, frames: int) -> None:
        """Shows progress."""
        self._progress.step(size, frames)


def piped() -> bool:
    """Returns true if standard input is a pipe or a file, so that it may be read unasked."""
    return sys.stdin is not None and not sys.stdin.isatty()
