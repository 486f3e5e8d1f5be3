"""Captures as a live source: frames come at the times of their stamps, at a chosen speed.

A session of the core makes records of the frames (`packed`) from any format; these become blocks of the live
stream (`sources/live.py`), each with the time up to which everything has been delivered. Only frames that are due
are read, so that memory does not grow with the capture. The frames of a capture without stamps come at a fixed
rate and stay without. Must not: decode, or change a frame or its stamp.
"""

import threading
import time
from collections.abc import Generator
from types import TracebackType
from typing import Final

from canalyze.sources.bridge import BUS, DROPPED, FRAME, records
from canalyze.sources.live import RELEASE_ALL, Blocks, dropped_block, name_block, records_block, until_block

RATE: Final = 1000.0
"""Frames per second of a capture without stamps, at speed 1."""
SLOWEST, FASTEST = 1 / 1024, 1024.0
"""Limits of the speed."""
_WAIT_S: Final = 0.1
"""Maximum wait of `read`."""
_SILENCE_NS: Final = 60_000_000_000
"""Maximum silence of a capture that is replayed; a longer one is skipped."""
_STOPPED_S: Final = 1.0
"""A longer time between two calls means that the program was stopped (Ctrl-Z), and the replay with it."""
_MOST: Final = 1 << 16
"""Maximum number of bytes delivered at once without a speed limit."""


class Replay(Blocks):
    """A capture for the reading loop whose `read()` waits until frames are due."""

    def __init__(self, name: str, results: Generator[bytes, None, None], *, speed: float = 1.0) -> None:
        """Replays records from the reading loop over a session of format `convert` to `packed`.

        speed: seconds of the capture per second; 0: without limit.
        """
        super().__init__(name)
        self.stamped: bool | None = None
        """True if its frames have stamps; None before the first one."""
        self._speed = speed
        self._paused = False
        self._wake = threading.Event()
        self._stopped = False
        self._results = results
        self._over = False
        self._records = b""
        self._at = 0
        """The position in the records of the next one to deliver."""
        self._newest: int | None = None
        """The newest stamp delivered."""
        self._origin = 0
        """The stamp from which the replay's clock counts."""
        self._due = 0.0
        """The replay's own clock: ns of the capture, or frames if it has no stamps."""
        self._before: float | None = None
        """The time of this machine at which `_due` was calculated."""

    # What the screen does to it.

    @property
    def speed(self) -> float:
        """Seconds of the capture per second; 0: without limit."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._speed = speed
        self._wake.set()

    def faster(self, faster: bool) -> None:
        """Doubles or halves the speed; halving an unlimited speed gives the fastest limited one."""
        speed = self._speed * 2 if faster else self._speed / 2
        if not self._speed:
            speed = 0.0 if faster else FASTEST
        elif speed > FASTEST:
            speed = 0.0
        self.speed = max(speed, SLOWEST) if speed else 0.0

    @property
    def paused(self) -> bool:
        """True if its time is stopped."""
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self._paused = paused
        self._wake.set()

    @property
    def fixed_rate(self) -> float | None:
        """Frames per second of a capture without stamps, at speed 1; None if it has stamps."""
        return RATE if self.stamped is False else None

    def prime(self) -> bool:
        """Reads up to the first frames, so that errors of the files show early; returns true if there are any."""
        return self._fetch()

    def stop(self) -> None:
        """Ends the replay; `read` returns b""."""
        self._stopped = True
        self._wake.set()

    # What the reading loop takes.

    def read(self) -> bytes:
        """Returns the blocks that are due, or the time alone after a while; b"" at the end.

        Raises SourceError as a capture does.
        """
        deadline = time.monotonic() + _WAIT_S
        while not self._stopped:
            if not self._fetch():
                return b""
            if self._paused:
                self._before = None
            elif found := self._take():
                self.taken += len(found)
                return found
            left = deadline - time.monotonic()
            if left <= 0:
                return self._tick()
            self._wake.wait(min(left, 0.02))
            self._wake.clear()
        return b""

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Closes the files."""
        self.stop()
        self._results.close()

    def _fetch(self) -> bool:
        """Reads further records if none are left; returns false at the end."""
        while self._at >= len(self._records) and not self._over:
            found = next(self._results, None)
            if found is None:
                self._over = True
            else:
                self._records, self._at = found, 0
        return self._at < len(self._records)

    def _take(self) -> bytes:
        """Returns the records that are due by now, as blocks."""
        self._reckon()
        blocks: list[bytes] = []
        data, at = self._records, self._at
        most = len(data) if self._speed else at + _MOST
        begin, count, bus = at, 0, -1

        def close() -> None:
            if count:
                blocks.append(records_block(bus, data[begin:at], count))

        for record in records(data, at):
            if record.kind != FRAME:
                close()
                if record.kind == BUS:
                    blocks.append(name_block(record.bus, data[record.begin : record.end].decode("utf-8", "replace")))
                elif record.kind == DROPPED:
                    blocks.append(dropped_block(record.bus, record.number))
                begin, count = record.end, 0
            elif at >= most or not self._is_due(record.is_stamped, record.number):
                break
            else:
                if record.bus != bus:
                    close()
                    begin, count, bus = at, 0, record.bus
                count += 1
            at = record.end
        close()
        self._at = at
        if blocks:
            blocks.append(self._tick())
        return b"".join(blocks)

    def _reckon(self) -> None:
        """Advances the replay's own clock."""
        now = time.monotonic()
        if self._before is not None:
            passed = min(now - self._before, _STOPPED_S)
            self._due += passed * self._speed * (RATE if self.stamped is False else 1e9)
        self._before = now

    def _is_due(self, stamped: bool, stamp: int) -> bool:
        """Returns true if a frame is due, and counts it as delivered."""
        if self.stamped is None:
            self.stamped = stamped
            self._origin = stamp
            self._due = 0.0
        if not stamped:
            if self.stamped is False and self._speed:
                if self._due < 1.0:
                    return False
                self._due -= 1.0
            return True
        if self._newest is None:
            self._origin, self._due = stamp, 0.0
        ahead = stamp - self._origin - self._due
        if ahead > 0 and self._speed and ahead <= _SILENCE_NS:
            return False
        if ahead > 0:
            self._due = float(stamp - self._origin)
        self._newest = stamp if self._newest is None else max(self._newest, stamp)
        return True

    def _tick(self) -> bytes:
        """Returns the block with the time up to which everything was delivered, or one that releases held frames."""
        if self._newest is None:
            return until_block(RELEASE_ALL)
        until = max(self._newest, self._origin + int(self._due))
        following = next(records(self._records, self._at), None)
        if following and following.is_stamped:
            until = min(until, following.number - 1)
        return until_block(max(until, 0))
