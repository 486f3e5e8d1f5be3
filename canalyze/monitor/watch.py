"""The thread that reads: the one reading loop over a live source or a replay, into the session that the screen shows.

The screen asks for what is known by now; neither waits for the other. What is to be complained of is kept until the
screen, or standard error after it, takes it. Must not: draw, or know what a frame means.
"""

import json
import threading
from collections.abc import Callable, Sequence
from contextlib import closing
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar

from canalyze.errors import CanalyzeError, SourceError
from canalyze.running.reading import Reading
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.monitor.trace import Line

T = TypeVar("T")

_KEPT: Final = 1000
"""Complaints that are kept; later ones are counted."""
_LONGEST: Final = 5.0
"""Seconds that the end waits for the thread."""


class Input(Protocol):
    """What is read: `sources.live.Live`, or `sources.replay.Replay`; beyond what the loop needs, how it is stopped."""

    def stop(self) -> None:
        """End soon: read() gives b"" when what came is given."""


class Playing(Protocol):
    """A replay: its time can stand still, or run faster."""

    speed: float
    """Seconds of the capture in a second; 0: as fast as can be."""
    paused: bool

    def prime(self) -> bool:
        """Read up to the first frames; tell whether there are any."""

    def faster(self, faster: bool) -> None:
        """Double the speed, or halve it."""

    @property
    def fixed_rate(self) -> float | None:
        """Frames in a second of a capture without stamps; None where stamps tell."""


class Watch:
    """A source being read in a thread of its own."""

    def __init__(
        self,
        session: "Session",
        words: Words,
        name: str,
        open_source: "Callable[[Watch], Input]",
        *,
        replay: bool = False,
        recording: Callable[[], str] | None = None,
    ) -> None:
        """Read what `open_source` gives, which looks to the loop like a capture; `name` is what it is called.

        open_source: is given this, which takes what a loop over files tells. replay: it can stand still and run
        faster. recording: how the recording stands, `records` or `unrecorded`; None: there is none.
        """
        self.session = session
        self.failure: str | None = None
        """Why it can be read no further, in words."""
        self.crash: BaseException | None = None
        """What should never come: the screen ends and it is raised."""
        self._words = words
        self._name = name
        self._recording = recording
        self._wished = threading.Event()
        self._over = threading.Event()
        self._complaints: list[str] = []
        self._taken = 0
        self._more = 0
        self._lock = threading.Lock()
        source: Any = open_source(self)
        self._source: Input = source
        self.replay: Playing | None = source if replay else None
        self._reading = Reading(session, words, self, open_input=lambda _: source, given_format=True, frameless=True)
        self._thread = threading.Thread(target=self._run, name="reading", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def primed(self) -> bool:
        """Read up to the first frames of a replay; tell whether there are any."""
        assert self.replay is not None
        return self.replay.prime()

    def stop(self) -> None:
        """End, and wait for it; what was received by then is in the session."""
        self._wished.set()
        self._source.stop()
        if self._thread.is_alive():
            self._thread.join(_LONGEST)

    @property
    def over(self) -> bool:
        """Whether nothing comes any more."""
        return self._over.is_set()

    @property
    def badge(self) -> str:
        """How it stands: live, replay, waiting, over, lost."""
        if self.over:
            return "lost" if self.failure else "over"
        if self.replay is not None:
            return "replay"
        return "waiting" if getattr(self._source, "waiting", False) else "live"

    @property
    def away(self) -> frozenset[str]:
        """The buses that are lost and waited for."""
        return getattr(self._source, "away", frozenset())

    @property
    def recording(self) -> str:
        """How the recording stands: `records`, `unrecorded`; "" where nothing is recorded."""
        return self._recording() if self._recording else ""

    def snapshot(self) -> dict[str, Any]:
        """Give what is known by now."""
        found: dict[str, Any] = json.loads(self.session.snapshot())
        return found

    def page(self, bus: str, node: int) -> dict[str, Any]:
        """Give what is known of a node beyond its row."""
        found: dict[str, Any] = json.loads(self.session.page(bus, node))
        return found

    def trace(self, filter: str, search: str, frame: int | None, rows: int, back: bool) -> "Sequence[Line]":  # noqa: A002
        """Give lines that are kept, in the order of frames."""
        return self.session.trace(filter, search, frame, rows, back)

    def complaints(self) -> list[str]:
        """Give those that came since the last call."""
        with self._lock:
            new = self._complaints[self._taken :]
            self._taken = len(self._complaints)
        return new

    def all_complaints(self) -> list[str]:
        """Give all that were kept, for standard error when the screen is gone."""
        with self._lock:
            more = [self._words("source.more_complaints", name=self._name, count=self._more)] if self._more else []
            return [*self._complaints, *more]

    def _run(self) -> None:
        try:
            with closing(self._reading.over([self._name])) as results:
                for _ in results:  # nothing comes out of it: the screen asks
                    pass
        except CanalyzeError as error:
            self._fail(error)
        except BaseException as error:
            self.crash = error
        finally:
            self._over.set()

    def _fail(self, error: CanalyzeError) -> None:
        line = error.in_words(self._words)
        self.failure = self.failure or line
        self.complain(f"canalyze: {line}")

    # What the loop tells and asks.

    @property
    def ended(self) -> bool:
        """Whether the end is wished."""
        return self._wished.is_set()

    def during(self, wait: Callable[[], T]) -> T | None:
        """Do what waits; it is the source that is told of a wish for the end."""
        return None if self._wished.is_set() else wait()

    def complain(self, line: str) -> None:
        """Keep a line."""
        with self._lock:
            if len(self._complaints) < _KEPT:
                self._complaints.append(line)
            else:
                self._more += 1

    def failed(self, error: SourceError) -> None:
        """Take it that there is no more."""
        self._fail(error)

    def step(self, size: int, frames: int) -> None:
        """Nothing: the screen asks how far it is."""
