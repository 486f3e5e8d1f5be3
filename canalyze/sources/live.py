"""Live buses as an input: frames are received at once in threads, and read as those of a capture.

One thread for each source receives blocks (defined in the core's `readers/live/`), passes them to the recording
and appends them to a queue that `Live.read` empties. Receiving therefore never waits for the reader: if the
queue is full, blocks are dropped and counted, and the core is informed. Must not: look into a frame, or send one.
"""

import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from types import TracebackType
from typing import Final, Protocol, Self

from canalyze.errors import CanalyzeError, SourceError, one_line

BUS, MESSAGES, RECORDS, DROPPED, UNTIL, GAP = range(1, 7)
"""Kinds of blocks, as the core numbers them."""
RELEASE_ALL: Final = 2**63 - 1
"""An `until` that releases all held frames without advancing time."""
MOST_BUSES: Final = 256
"""Maximum number of buses."""
TICK_S: Final = 0.1
"""Maximum wait of a source before it reports its time."""
MARGIN_NS: Final = 20_000_000
"""Maximum delay between the stamp of a frame and its arrival from the kernel."""

_HEAD: Final = struct.Struct("<BBBxIq")
_MOST: Final = 64 << 20
"""Maximum number of bytes that wait for the reader."""
_GIVEN: Final = 1 << 20
"""Maximum number of bytes returned at once, so that the reader stays responsive."""
_WAIT_S: Final = 1.5 * TICK_S
"""Maximum wait of `read`, longer than that of a source."""
_REMARKS: Final = 100
"""Maximum number of waiting remarks."""
_JOIN_S: Final = 2.0
"""Maximum wait for a thread at the end."""
_LAST_S: Final = 0.5
"""Maximum time for which waiting frames are received at the end."""
_LAST: Final = 8
"""Minimum number of attempts to receive them, for a machine that stalls just then."""


class LinkLost(Exception):
    """A channel that cannot be listened to any more, or not yet."""

    def __init__(self, channel: str, reason: str | OSError | SourceError) -> None:
        """Keeps the reason; one that is not a SourceError is prefixed with the channel's name."""
        super().__init__(channel, reason)
        self.channel = channel
        self.reason = reason

    @property
    def error(self) -> SourceError:
        """The error to report."""
        if isinstance(self.reason, SourceError):
            return self.reason
        return SourceError("live.lost", channel=self.channel, error=self.reason)


class Ended(Exception):
    """A source has ended without an error."""


class Bus(Protocol):
    """A source of frames with one or several channels.

    Optional methods: `remarks() -> list[CanalyzeError]` returns the remarks since the last call; `ending() -> bytes`
    returns the last blocks after receiving has ended.
    """

    @property
    def names(self) -> Sequence[str]:
        """Its channels, in the order of their indices."""

    @property
    def first(self) -> int:
        """The bus index of the first channel."""

    def receive(self, timeout_s: float) -> bytes:
        """Returns whole blocks, with an `until` at least every TICK_S; b"" if nothing came in this time.

        Raises LinkLost once for each channel that is lost; the other channels are received further. Raises Ended at the
        end, and SourceError if it cannot continue.
        """

    def reopen(self) -> bool:
        """Tries to reopen all lost channels; returns true if all are open."""

    def close(self) -> None:
        """Closes all channels; closing twice is harmless."""


class Recording(Protocol):
    """A recording of all frames, written in the thread that receives them."""

    def take(self, blocks: bytes) -> None:
        """Appends whole blocks; never raises."""

    def remarks(self) -> list[CanalyzeError]:
        """Returns the remarks since the last call."""

    def close(self) -> None:
        """Completes the recording."""


def block(kind: int, bus: int = 0, which: int = 0, number: int = 0, *payload: bytes | memoryview) -> bytes:
    """Returns a block."""
    return b"".join((_HEAD.pack(kind, bus, which, sum(map(len, payload)), number), *payload))


def name_block(bus: int, name: str) -> bytes:
    """Returns the block that names a bus; it precedes all others of that bus."""
    return block(BUS, bus, 0, 0, name.encode("utf-8", "backslashreplace"))


def records_block(bus: int, records: bytes, count: int) -> bytes:
    """Returns a block of `count` frames as records of `packed`."""
    return block(RECORDS, bus, 0, count, records)


def dropped_block(bus: int, count: int, *, which: int = 0) -> bytes:
    """Returns the block for lost frames.

    which: 0 if the kernel or the driver dropped them, 1 if the reader was too slow.
    """
    return block(DROPPED, bus, which, count)


def until_block(ns: int) -> bytes:
    """Returns the block that says that all frames stamped up to `ns` have been delivered."""
    return block(UNTIL, number=ns)


def gap_block(bus: int, *, away: bool = False) -> bytes:
    """Returns the block that says that frames may be missing until the next one; away: the bus itself is gone."""
    return block(GAP, bus, away)


def heads(blocks: bytes) -> Iterator[tuple[int, int, int, int, int]]:
    """Yields kind, bus, number, begin and end of each block."""
    at = 0
    while at < len(blocks):
        kind, bus, _, size, number = _HEAD.unpack_from(blocks, at)
        end = at + _HEAD.size + size
        yield kind, bus, number, at, end
        at = end


class Blocks:
    """An input of blocks with the interface of `format.Capture`; a context manager."""

    format: Final = "live"
    kind: Final = "live"
    regular: Final = False
    damage: Final = None
    begins: Final = False
    checked: Final = None
    compression: Final = None

    def __init__(self, name: str) -> None:
        """Sets the name that is used in messages."""
        self.name = name
        self.taken = 0
        """Number of bytes read."""

    def rests(self) -> bool:
        """Returns false; blocks say the time themselves."""
        return False

    def remarks(self) -> list[CanalyzeError]:
        """Returns the remarks since the last call, for standard error."""
        return []

    def __enter__(self) -> Self:
        """Returns the input."""
        return self


class Live(Blocks):
    """Live buses."""

    def __init__(
        self,
        buses: Sequence[Bus],
        *,
        recording: Recording | None = None,
        reconnect: bool = False,
        duration_s: float | None = None,
        most: int = _MOST,
    ) -> None:
        """Takes ownership of the buses, not of the recording.

        A lost channel is waited for while there are others; reconnect: also if it was the last one. duration_s: the
        time after which it ends. most: maximum number of bytes that wait for the reader.
        """
        self.names = [name for bus in buses for name in bus.names]
        super().__init__(", ".join(self.names))
        self.unshown = 0
        """Number of frames dropped because the reader was too slow."""
        self.failure: SourceError | None = None
        """The error that ended it early."""
        self._buses = list(buses)
        self._recording = recording
        self._reconnect = reconnect
        self._duration_s = duration_s
        self._most = most
        self._again = most // 2  # blocks are taken again when so few wait: one gap, and not one every few frames
        self._deadline: float | None = None
        self._threads: list[threading.Thread] = []
        self._stopped = self._at_once = self._closed = False  # plain flags: a signal's handler sets them
        self._feeding = threading.Lock()
        """Held while blocks are passed on, so that the recording and the queue get them in the same order."""
        self._arrived = threading.Condition()
        self._queue: deque[bytes] = deque()
        self._waiting = 0
        self._left_out: dict[int, int] | None = None
        """Number of dropped frames since the queue was full, by bus; None while it is not full."""
        self._running: set[int] = set()
        self._listening: set[int] = set()
        """Sources that are not lost."""
        self._away: dict[int, dict[str, SourceError]] = {}
        """The lost channels of each source, with the reason."""
        self._until: dict[int, int] = {}
        """The time up to which each connected source has delivered its frames."""
        self._merged: int | None = None
        self._last = b""
        """The blocks passed on last."""
        self._behind: int | None = None
        """The delay of the frames' clock against the host's when a channel was lost; None before the first time."""
        self._remarks: list[CanalyzeError] = []
        self._told = False

    @property
    def away(self) -> frozenset[str]:
        """The lost channels that are waited for."""
        with self._arrived:
            return frozenset(name for lost in self._away.values() for name in lost)

    @property
    def waiting(self) -> bool:
        """True if all channels are lost and waited for."""
        with self._arrived:
            there = sum(len(self._buses[place].names) for place in self._running)
            return bool(self._away) and len(self.away) == there

    def start(self) -> None:
        """Starts to receive; `read` starts it otherwise."""
        if self._threads or self._closed:
            return
        if self._duration_s is not None:
            self._deadline = time.monotonic() + self._duration_s
        self._running = set(range(len(self._buses)))
        self._listening = set(self._running)
        for place, bus in enumerate(self._buses):
            thread = threading.Thread(target=self._work, args=(place, bus), name=f"canalyze-live-{place}", daemon=True)
            self._threads.append(thread)
        if len(self._buses) > 1:  # before any frame: what joins them has to know that there are several
            names = (name_block(bus.first + at, name) for bus in self._buses for at, name in enumerate(bus.names))
            self._hand_over(b"".join(names))
        for thread in self._threads:
            thread.start()

    def read(self) -> bytes:
        """Returns new blocks, or after a short wait a block without news; b"" at the end.

        Raises SourceError once if a source has failed.
        """
        self.start()
        with self._arrived:
            self._arrived.wait_for(lambda: self._queue or not self._running or self._at_once, _WAIT_S)
            if self._at_once or (not self._queue and not self._running):
                return self._end()
            given = []
            size = 0
            while self._queue and size < _GIVEN:
                piece = self._queue.popleft()
                given.append(piece)
                size += len(piece)
            self._waiting -= size
        blocks = b"".join(given) or self._nothing_new()
        self.taken += len(blocks)
        return blocks

    def remarks(self) -> list[CanalyzeError]:
        """Returns the remarks since the last call, for standard error."""
        with self._arrived:
            remarks, self._remarks = self._remarks, []
        for one in (*self._buses, self._recording):
            told = getattr(one, "remarks", None)
            if told:
                remarks += told()
        return remarks

    def stop(self, *, now: bool = False) -> None:
        """Ends receiving; with `now` waiting blocks are discarded. Safe to call in a signal handler."""
        self._stopped = True
        if now:
            self._at_once = True

    def close(self) -> None:
        """Ends receiving, in bounded time even if a source blocks."""
        self._stopped = self._closed = True
        deadline = time.monotonic() + _JOIN_S
        for thread in self._threads:
            thread.join(max(0.0, deadline - time.monotonic()))
        if not self._threads:
            for bus in self._buses:
                bus.close()

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Ends receiving."""
        self.close()

    def _end(self) -> bytes:
        if self.failure and not self._told:
            self._told = True
            raise self.failure
        return b""

    def _nothing_new(self) -> bytes:
        """Returns a block without news, so that the reader can do other work."""
        return until_block(RELEASE_ALL if self._merged is None else self._merged)

    # What follows runs in the threads.

    @property
    def _over(self) -> bool:
        return self._stopped or (self._deadline is not None and time.monotonic() >= self._deadline)

    def _work(self, place: int, bus: Bus) -> None:
        try:
            self._drain(place, bus)
        except SourceError as error:
            self._fail(error)
        except BaseException as error:  # a thread that has died in silence would be a bus on which nothing happens
            self._fail(SourceError("live.broken", channel=", ".join(bus.names), problem=one_line(error)))
        finally:
            with suppress(Exception):
                bus.close()
            self._leave(place)

    def _drain(self, place: int, bus: Bus) -> None:
        with suppress(Ended):
            while not self._over:
                try:
                    self._deliver(place, bus.receive(self._patience()))
                except LinkLost as lost:
                    self._lost(place, bus, lost)
                    self._wait_for(place, bus)
            self._take_the_rest(place, bus)
        ending: Callable[[], bytes] | None = getattr(bus, "ending", None)
        if ending:
            self._deliver(place, ending())

    def _take_the_rest(self, place: int, bus: Bus) -> None:
        """Receives the frames that have arrived by the end, for a bounded time."""
        enough = time.monotonic() + _LAST_S
        lost = calls = 0
        while not self._at_once and (calls < _LAST or time.monotonic() < enough):
            calls += 1
            try:
                blocks = bus.receive(0)
            except LinkLost:  # of other channels there may be more
                lost += 1
                if lost > len(bus.names):
                    return
                continue
            self._deliver(place, blocks)
            if not any(kind in (MESSAGES, RECORDS) for kind, *_ in heads(blocks)):
                return

    def _patience(self) -> float:
        if self._deadline is None:
            return TICK_S
        return max(0.0, min(TICK_S, self._deadline - time.monotonic()))

    def _lost(self, place: int, bus: Bus, lost: LinkLost) -> None:
        """Reports a lost channel. Raises SourceError if none is left and none is waited for."""
        names = list(bus.names)
        index = bus.first + names.index(lost.channel) if lost.channel in names else bus.first
        with self._feeding:
            times = [number for kind, _, number, *_ in heads(self._last) if kind == UNTIL and number != RELEASE_ALL]
            if times:
                self._behind = time.time_ns() - times[-1]
        self._deliver(place, name_block(index, lost.channel) + gap_block(index, away=True))
        with self._arrived:
            self._away.setdefault(place, {})[lost.channel] = lost.error
        self._need_one(lost.error)
        self._remark(SourceError("live.waiting", reason=lost.error, channel=lost.channel))

    def _need_one(self, error: SourceError) -> None:
        """Raises the error that ends it, if no channel is left and none is waited for."""
        if self.waiting and not self._reconnect and not self._over:
            raise SourceError("live.gone", reason=error)

    def _wait_for(self, place: int, bus: Bus) -> None:
        """Waits until all lost channels are back, and receives from the others meanwhile."""
        pause = 0.2
        others = len(bus.names) > 1
        if not others:
            with self._arrived:
                self._forget(place)
        while not self._over:
            again = time.monotonic() + pause
            while (left := again - time.monotonic()) > 0 and not self._over:
                try:
                    if others:
                        self._deliver(place, bus.receive(min(left, TICK_S)))
                    else:
                        time.sleep(min(left, TICK_S))
                        self._pass_time()
                except LinkLost as further:
                    self._lost(place, bus, further)
            for error in list(self._away[place].values())[-1:]:  # others may have ended meanwhile
                self._need_one(error)
            if not self._over and bus.reopen():
                with self._arrived:
                    self._listening.add(place)
                    lost = self._away.pop(place, {})
                self._remark(SourceError("live.back", channel=", ".join(lost)))
                return
            pause = min(pause * 1.25, 1.0)

    def _pass_time(self) -> None:
        """Advances the frames' time by the host's clock if no source is connected."""
        with self._feeding:
            if not self._listening and self._behind is not None:
                self._hand_over(until_block(time.time_ns() - self._behind))

    def _deliver(self, place: int, blocks: bytes) -> None:
        if not blocks:
            return
        with self._feeding:
            self._hand_over(blocks if len(self._buses) == 1 else self._one_time(place, blocks))

    def _one_time(self, place: int, blocks: bytes) -> bytes:
        """Merges the times of several sources to that of the source that is furthest behind."""
        kept = []
        until = None
        for kind, _, number, at, end in heads(blocks):
            if kind == UNTIL:
                until = number
            else:
                kept.append(blocks[at:end])
        with self._arrived:
            if until is not None and place in self._listening:
                self._until[place] = until
            if self._until and self._listening <= self._until.keys():
                least = min(self._until.values())
                if self._merged is None or least > self._merged:
                    self._merged = least
                    kept.append(until_block(least))
        return b"".join(kept)

    def _hand_over(self, blocks: bytes) -> None:
        self._last = blocks
        if self._recording:
            self._recording.take(blocks)
        with self._arrived:
            if self._left_out is not None and self._waiting <= self._again:
                blocks = self._dropped() + blocks
            elif self._left_out is None and self._waiting + len(blocks) > self._most:
                self._left_out = {}
            if self._left_out is not None:
                blocks = self._short(blocks, self._left_out)
            if blocks:
                self._queue.append(blocks)
                self._waiting += len(blocks)
                self._arrived.notify()

    def _dropped(self) -> bytes:
        """Returns blocks for the frames dropped so far."""
        left_out, self._left_out = self._left_out or {}, None
        return b"".join(dropped_block(bus, count, which=1) for bus, count in sorted(left_out.items()) if count)

    def _short(self, blocks: bytes, left_out: dict[int, int]) -> bytes:
        """Returns the blocks that are kept if the queue is full: those about the buses, without frames."""
        kept = []
        for kind, bus, number, at, end in heads(blocks):
            if kind in (MESSAGES, RECORDS):
                left_out[bus] = left_out.get(bus, 0) + number
                self.unshown += number
            elif kind != UNTIL or number == RELEASE_ALL:
                kept.append(blocks[at:end])
        return b"".join(kept)

    def _leave(self, place: int) -> None:
        with self._arrived:
            self._running.discard(place)
            self._away.pop(place, None)
            self._forget(place)
            if not self._running and self._left_out:
                blocks = self._dropped()
                self._queue.append(blocks)
                self._waiting += len(blocks)
            self._arrived.notify_all()

    def _forget(self, place: int) -> None:
        """Stops waiting for the time of a source."""
        self._listening.discard(place)
        self._until.pop(place, None)

    def _fail(self, error: SourceError) -> None:
        """Ends everything; `read` raises the error after the waiting blocks."""
        with self._arrived:
            self.failure = self.failure or error
        self._stopped = True

    def _remark(self, remark: CanalyzeError) -> None:
        with self._arrived:
            if len(self._remarks) < _REMARKS:
                self._remarks.append(remark)
