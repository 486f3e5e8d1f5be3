"""The subject of the screen, from names and options, and the thread that reads it into the session of the screen.

It is a bus that is listened to, or captures that are replayed. The screen queries the current state; neither waits for
the other. Complaints are kept until the screen, or standard error after it, takes them. Must not: draw, or know the
meaning of a frame.
"""

import threading
from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

from canalyze.configuration.options import accepted, open_session, start_session
from canalyze.errors import CanalyzeError, SourceError
from canalyze.output import complain
from canalyze.records import decoder
from canalyze.records.live import NodeDetails, Snapshot
from canalyze.running.listening import ListeningOptions, channels_of, listening, set_rates
from canalyze.running.reading import Reading
from canalyze.sinks import RECORDS
from canalyze.sources import open_capture
from canalyze.sources.replay import Replay
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.monitor.trace import Line
    from canalyze.sources.live import Live

T = TypeVar("T")

_KEPT: Final = 1000
"""Maximum number of complaints kept; later ones are counted."""
_LONGEST: Final = 5.0
"""Maximum wait for the thread at the end, in seconds."""


class Watch:
    """A source that is read in a thread of its own."""

    def __init__(
        self,
        session: "Session",
        words: Words,
        name: str,
        open_source: "Callable[[Watch], Live | Replay]",
        *,
        replay: bool = False,
        recording: Callable[[], str] | None = None,
    ) -> None:
        """Creates the thread for the source of `open_source`; `name` is its name in messages.

        open_source: gets this object, which handles remarks of a loop over files. replay: the source can be paused and
        change its speed. recording: returns the state of the recording, `records` or `unrecorded`; None without one.
        """
        self.session = session
        self.failure: str | None = None
        """The reason for which reading has ended early, in words."""
        self.crash: BaseException | None = None
        """An unexpected exception: the screen ends and raises it."""
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
        self._source: Live | Replay = source
        self.replay: Replay | None = source if replay else None
        self._reading = Reading(session, words, self, open_input=lambda _: source, given_format=True, frameless=True)
        self._thread = threading.Thread(target=self._run, name="reading", daemon=True)

    def start(self) -> None:
        """Starts reading."""
        self._thread.start()

    def primed(self) -> bool:
        """Reads up to the first frames of a replay; returns true if there are any."""
        assert self.replay is not None
        return self.replay.prime()

    def stop(self) -> None:
        """Ends reading and waits for it; everything received by then is in the session."""
        self._wished.set()
        self._source.stop()
        if self._thread.is_alive():
            self._thread.join(_LONGEST)

    @property
    def over(self) -> bool:
        """True if reading has ended."""
        return self._over.is_set()

    @property
    def badge(self) -> str:
        """The state of the source: live, replay, waiting, over, lost."""
        if self.over:
            return "lost" if self.failure else "over"
        if self.replay is not None:
            return "replay"
        return "waiting" if getattr(self._source, "waiting", False) else "live"

    @property
    def away(self) -> frozenset[str]:
        """The lost buses that are waited for."""
        return getattr(self._source, "away", frozenset())

    @property
    def recording(self) -> str:
        """The state of the recording: `records`, `unrecorded`, or "" without one."""
        return self._recording() if self._recording else ""

    def snapshot(self) -> Snapshot:
        """Returns the current snapshot."""
        found: Snapshot = decoder(Snapshot)(self.session.snapshot())
        return found

    def page(self, bus: str, node: int) -> NodeDetails:
        """Returns the details of a node."""
        found: NodeDetails = decoder(NodeDetails)(self.session.page(bus, node))
        return found

    def trace(self, filter: str, search: str, frame: int | None, rows: int, back: bool) -> "Sequence[Line]":  # noqa: A002
        """Returns lines of the trace, in the order of frames."""
        return self.session.trace(filter, search, frame, rows, back)

    def complaints(self) -> list[str]:
        """Returns the complaints since the last call."""
        with self._lock:
            new = self._complaints[self._taken :]
            self._taken = len(self._complaints)
        return new

    def all_complaints(self) -> list[str]:
        """Returns all complaints, for standard error after the screen is closed."""
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

    # Called by the reading loop.

    @property
    def ended(self) -> bool:
        """True if the end was requested."""
        return self._wished.is_set()

    def during(self, wait: Callable[[], T]) -> T | None:
        """Calls `wait`, unless the end was requested; a request during the call reaches the source."""
        return None if self._wished.is_set() else wait()

    def complain(self, line: str) -> None:
        """Appends a complaint."""
        with self._lock:
            if len(self._complaints) < _KEPT:
                self._complaints.append(line)
            else:
                self._more += 1

    def failed(self, error: SourceError) -> None:
        """Records the failure of the source."""
        self._fail(error)

    def step(self, size: int, frames: int) -> None:
        """Does nothing; the screen queries the progress."""


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
    with accepted():
        frames = start_session(words, given, format="convert", to=RECORDS, stamps=stamps)
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
    with accepted():
        session.trace(expression or "", "", None, 1, True)
