"""Captures as a live source: their frames come when their stamps say, at some speed, so that a screen can follow.

Whatever the format, a session of the core makes records of the frames (`packed`), and these become blocks of the live
stream (`sources/live.py`), each with the time up to which everything was handed over. No more is read than what is due:
memory does not grow with the capture. A capture without stamps comes at a fixed rate, and its frames stay without.
Must not: decode, or change a frame or its stamp.
"""

import threading
import time
from collections.abc import Generator
from types import TracebackType
from typing import Final, Self

from canalyze.errors import CanalyzeError
from canalyze.sources.live import RELEASE_ALL, dropped_block, name_block, records_block, until_block
from canalyze.sources.packed import BUS, DROPPED, FRAME, FRAME_HEAD, OTHER_HEAD, STAMP

RATE: Final = 1000.0
"""Frames a second of a capture without stamps, at speed 1."""
SLOWEST, FASTEST = 1 / 1024, 1024.0
"""Between these the speed can be changed while it runs."""
_WAIT_S: Final = 0.1
"""Longest time that read() waits."""
_SILENCE_NS: Final = 60_000_000_000
"""Longest silence of a capture that is waited for; a longer one is passed over."""
_STOPPED_S: Final = 1.0
"""No two reckonings lie this far apart, unless the program was stopped (Ctrl-Z): then the replay was, too."""
_MOST: Final = 1 << 16
"""Bytes of records handed over at once, where they come as fast as can be."""


class Replay:
    """What the reading loop takes for a capture: `read()` waits until frames are due."""

    def __init__(self, name: str, results: Generator[bytes, None, None], *, speed: float = 1.0) -> None:
        """Replay what `results` give: records, from the reading loop over a session of format `convert`, to `packed`.

        speed: seconds of the capture in one second; 0: as fast as can be.
        """
        self.name = name
        self.format = self.kind = "live"
        self.regular = False
        self.compression: str | None = None
        self.damage = None
        self.begins = False
        self.checked: bool | None = None
        self.taken = 0
        self.stamped: bool | None = None
        """Whether its frames have stamps; None before the first one."""
        self._speed = speed
        self._paused = False
        self._wake = threading.Event()
        self._stopped = False
        self._results = results
        self._over = False
        self._records = b""
        self._at = 0
        """Where in the records the next one is that is not handed over."""
        self._newest: int | None = None
        """The newest stamp handed over."""
        self._origin = 0
        """The stamp from which the replay's clock counts."""
        self._due = 0.0
        """How far the replay is, on its own clock: ns of the capture, or frames where it has no stamps."""
        self._before: float | None = None
        """When that was reckoned, on the clock of this machine."""

    # What the screen does to it.

    @property
    def speed(self) -> float:
        """Seconds of the capture in a second; 0: as fast as can be."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._speed = speed
        self._wake.set()

    def faster(self, faster: bool) -> None:
        """Double the speed, or halve it; one that is as fast as can be comes down to the fastest other one."""
        speed = self._speed * 2 if faster else self._speed / 2
        if not self._speed:
            speed = 0.0 if faster else FASTEST
        elif speed > FASTEST:
            speed = 0.0
        self.speed = max(speed, SLOWEST) if speed else 0.0

    @property
    def paused(self) -> bool:
        """Whether its time stands still."""
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self._paused = paused
        self._wake.set()

    @property
    def fixed_rate(self) -> float | None:
        """Frames in a second of a capture without stamps, at speed 1; None where stamps tell."""
        return RATE if self.stamped is False else None

    def prime(self) -> bool:
        """Read up to the first frames, so that what is wrong with the files is known before; tell whether there are."""
        return self._fetch()

    def stop(self) -> None:
        """End: read() gives b""."""
        self._stopped = True
        self._wake.set()

    # What the reading loop takes.

    def rests(self) -> bool:
        """Tell whether nothing more comes at the moment: a replay says the time itself."""
        return False

    def read(self) -> bytes:
        """Give the blocks that are due, or the time alone after a while; b"" at the end; SourceError as a capture."""
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

    def remarks(self) -> list[CanalyzeError]:
        """Give nothing: what is to be told of the files was told."""
        return []

    def __enter__(self) -> Self:
        """Give the replay itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Close the files."""
        self.stop()
        self._results.close()

    def _fetch(self) -> bool:
        """See to it that there are records; False: there are no more."""
        while self._at >= len(self._records) and not self._over:
            found = next(self._results, None)
            if found is None:
                self._over = True
            else:
                self._records, self._at = found, 0
        return self._at < len(self._records)

    def _take(self) -> bytes:
        """Take the records that are due by now, as blocks."""
        self._reckon()
        blocks: list[bytes] = []
        records, at, end = self._records, self._at, len(self._records)
        most = end if self._speed else min(end, at + _MOST)
        begin, count, bus = at, 0, -1

        def close() -> None:
            if count:
                blocks.append(records_block(bus, records[begin:at], count))

        while at < most:
            kind, flags, index, _, _, _, size, _, _, stamp = FRAME_HEAD.unpack_from(records, at)
            if kind != FRAME:
                close()
                _, index, size, _, number, _ = OTHER_HEAD.unpack_from(records, at)
                at += FRAME_HEAD.size + size
                if kind == BUS:
                    blocks.append(name_block(index, records[at - size : at].decode("utf-8", "replace")))
                elif kind == DROPPED:
                    blocks.append(dropped_block(index, number))
                begin, count = at, 0
                continue
            if not self._is_due(bool(flags & STAMP), stamp):
                break
            if index != bus:
                close()
                begin, count, bus = at, 0, index
            at += FRAME_HEAD.size + size
            count += 1
        close()
        self._at = at
        if blocks:
            blocks.append(self._tick())
        return b"".join(blocks)

    def _reckon(self) -> None:
        """Let the replay's own clock go on."""
        now = time.monotonic()
        if self._before is not None:
            passed = min(now - self._before, _STOPPED_S)
            self._due += passed * self._speed * (RATE if self.stamped is False else 1e9)
        self._before = now

    def _is_due(self, stamped: bool, stamp: int) -> bool:
        """Tell whether a frame has its turn; if so, it is handed over."""
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
        """Say up to when everything was handed over; where there are no stamps, that nothing is held back."""
        if self._newest is None:
            return until_block(RELEASE_ALL)
        until = max(self._newest, self._origin + int(self._due))
        if self._at < len(self._records):
            kind, flags, *_, stamp = FRAME_HEAD.unpack_from(self._records, self._at)
            if kind == FRAME and flags & STAMP:
                until = min(until, stamp - 1)
        return until_block(max(until, 0))
