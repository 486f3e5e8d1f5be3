"""Feeds a timeline in a thread of its own while frames come, so that the receiver never waits for it.

A viewer may be slow, stopped or gone, and a disk full; waiting batches are bounded, beyond that whole batches are
dropped and counted. Must not: know the content of a batch.
"""

import threading
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Protocol

if TYPE_CHECKING:
    from canalyze._core import Batch

MOST_ROWS: Final = 1_000_000
"""Maximum number of waiting rows: some 100 MB."""


class Fed(Protocol):
    """The consumer of the batches: a `Timeline`."""

    def take(self, batches: "Sequence[tuple[str, Batch]]") -> None:
        """Appends batches."""

    def finish(self, summary: bytes = b"", lines: Sequence[str] = ()) -> None:
        """Completes the timeline; lines: a summary in words."""


class Feed:
    """A queue of batches for a timeline."""

    def __init__(self, timeline: Fed, *, most: int = MOST_ROWS) -> None:
        """Starts the thread; the timeline is used only there from here on."""
        self.left_out = 0
        """Number of dropped rows."""
        self.failure: Exception | None = None
        """The error after which batches are ignored, if any."""
        self._timeline = timeline
        self._most = most
        self._queue: deque[Sequence[tuple[str, Batch]]] = deque()
        self._waiting = 0
        self._over = False
        self._lines: Sequence[str] = ()
        self._arrived = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="canalyze-timeline", daemon=True)
        self._thread.start()

    def give(self, batches: "Sequence[tuple[str, Batch]]") -> None:
        """Appends batches; never waits."""
        rows = sum(batch.num_rows for _, batch in batches)
        with self._arrived:
            if self.failure is not None or not rows:
                return
            if self._waiting + rows > self._most:
                self.left_out += rows
                return
            self._queue.append(batches)
            self._waiting += rows
            self._arrived.notify()

    def end(self, lines: Sequence[str] = ()) -> None:
        """Ends the input; waiting batches are still written. Calling it twice is harmless. lines: the summary."""
        with self._arrived:
            self._lines = self._lines or lines
            self._over = True
            self._arrived.notify()

    def ended(self, within_s: float) -> bool:
        """Waits up to `within_s` until the timeline is complete; returns true if it is."""
        self._thread.join(within_s)
        return not self._thread.is_alive()

    def _work(self) -> None:
        try:
            while True:
                with self._arrived:
                    self._arrived.wait_for(lambda: self._queue or self._over)
                    taken = list(self._queue)
                    self._queue.clear()
                if not taken:
                    break
                for batches in taken:
                    self._timeline.take(batches)
                    with self._arrived:
                        self._waiting -= sum(batch.num_rows for _, batch in batches)
            self._timeline.finish(lines=self._lines)
        except Exception as error:
            with self._arrived:
                self.failure = error
                self._queue.clear()
