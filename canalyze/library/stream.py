"""A bus while it is listened to: frames are pushed by whoever has them, typed events come out.

    python-can's Notifier --(its thread)--> Listener --lock--> the core's session --> callback, or queue --> iterating
    sources.live (its threads) --> Bus, read where it is iterated over --> the same

Nothing is ever sent, printed or recorded, and signals of the system are let alone.
"""

import asyncio
import sys
import threading
import time
from collections import deque
from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterator, Mapping
from copy import copy
from typing import TYPE_CHECKING, Any, Final, Self, TypeVar, Unpack

from canalyze.configuration import network
from canalyze.errors import SourceError, one_line
from canalyze.library import Known
from canalyze.library.columns import renamed
from canalyze.library.plan import Plan, plan
from canalyze.library.rows import Problems
from canalyze.records.frames import Event, events
from canalyze.records.problems import Overview, Problem
from canalyze.running.reading import Reading
from canalyze.sources import live as blocks
from canalyze.sources.bridge import Packer, Unfit, bus_name, is_message, nanoseconds

if TYPE_CHECKING:
    from can import Message

    from canalyze.sources import Capture

T = TypeVar("T")

_TICK_S: Final = 0.1
"""The time that iterating waits before it lets the time of the frames go on."""
_MOST: Final = 1 << 20
"""Events that wait at most."""
_REMARKS: Final = 1000


class Silent:
    """Reads without a word: complaints are kept, and what cannot be read is raised."""

    ended: Final = False

    def __init__(self) -> None:
        """Starts without complaints."""
        self.complaints: list[str] = []

    def during(self, wait: Callable[[], T]) -> T | None:
        """Calls a function that may wait long: nothing ends it."""
        return wait()

    def complain(self, line: str) -> None:
        """Keeps a line."""
        self.complaints.append(line)

    def failed(self, error: SourceError) -> None:
        """Raises the error."""
        raise error

    def step(self, size: int, frames: int) -> None:
        """Does nothing: progress is not shown."""


class Stream:
    """Events as they come: iterate over it (`for`, `async for`), or ask with `take` and `get`; a context manager.

    `Frame`, `Note`, `Finding`, `Transfer` and `ProblemChange`. It ends when it is stopped; then `problems` are
    complete.
    """

    def __init__(self, made: Plan) -> None:
        """Starts a session of the core."""
        self._plan = made
        self._session = made.session("events", incidents=True)
        self._reader = Silent()
        self._events: deque[Event] = deque()
        self._final: list[Problem] = []
        self._order: tuple[int, ...] = ()
        self._over = False

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {'stopped' if self._over else 'listening'}, {self.frames} frames>"

    @property
    def problems(self) -> Problems:
        """The problems with their status and causes: complete once it was stopped, empty before."""
        return Problems(self._final, self._order)

    incidents = renamed("incidents", "problems")

    @property
    def complaints(self) -> tuple[str, ...]:
        """Remarks in words: repaired descriptions, frames that were lost, messages of adapters."""
        return self._plan.said + tuple(self._reader.complaints)

    @property
    def frames(self) -> int:
        """Frames so far."""
        return self._session.frames

    def stop(self) -> None:
        """Ends it; events that are known only at the end follow then. From any thread; twice is harmless."""
        raise NotImplementedError

    def take(self) -> list[Event]:
        """Returns the events that wait, without waiting for more."""
        return self._wait(0)

    def get(self, timeout: float | None = None) -> Event | None:
        """Wait for the next event, at most so many seconds; None where none came, or none ever will."""
        end = None if timeout is None else time.monotonic() + timeout
        while not self._events:
            left = _TICK_S if end is None else min(_TICK_S, end - time.monotonic())
            got = self._wait(max(0.0, left))
            self._events.extend(got)
            if not got and (self._over or (end is not None and time.monotonic() >= end)):
                return None
        return self._events.popleft()

    def __iter__(self) -> Iterator[Event]:
        """Yields events until it is stopped."""
        while got := self._wait(_TICK_S) or not self._over:
            if isinstance(got, list):
                yield from got

    async def __aiter__(self) -> AsyncIterator[Event]:
        """Yields events until it is stopped; waiting is done in another thread."""
        while got := await asyncio.to_thread(self._wait, _TICK_S) or not self._over:
            if isinstance(got, list):
                for event in got:
                    yield event

    def __enter__(self) -> Self:
        """Returns it."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stops it."""
        self.stop()

    def _wait(self, timeout_s: float) -> list[Event]:
        """Returns the events that wait, or those of this time. None, once `_over`: no more come."""
        raise NotImplementedError

    def _typed(self, result: bytes) -> list[Event]:
        """Returns the events in a result of the core."""
        found: list[Event] = []
        for one in events(result):
            if isinstance(one, Problem):
                self._final.append(one)
            elif isinstance(one, Overview):
                self._order = one.order
            else:
                found.append(one)
        return found


class Listener(Stream):
    """A listener for python-can's `Notifier`, with the messages of one bus or several.

        with canalyze.Listener(eds={5: "drive.eds"}) as listener:
            notifier = can.Notifier(bus, [listener])
            for event in listener:
                print(event)

    Identifier, RTR, FD with BRS and ESI, error frames (with a class where the interface gives SocketCAN's), direction,
    channel and stamp are kept; a message without a stamp gets the time of its receipt. It needs no Notifier: whoever
    has messages calls it with each, `listener(message)`.

    What the program itself sends on this bus is only received if the bus was opened with `receive_own_messages=True`:
    without it the listener has the responses to requests that it never saw, and says so. A second bus on the same
    channel, or another program, needs no such option.

    Where the next frames tell what one means, its events wait for them, or for `advance`: at most 0.2 s. Iterating
    advances by itself; with `on_event` call `advance()` from time to time, which finds silence, too.

    Threads: messages, `advance`, `on_error` and `stop` may come from any threads at once: one lock puts them into an
    order. `on_event` is called in the thread that brings the message, one event at a time and in order, while others
    wait: it should be quick, and may call the listener itself. What it raises goes to whoever brought the message.
    Without it events wait in a queue for one thread or task that iterates, or calls `take` or `get`.
    """

    def __init__(
        self,
        on_event: Callable[[Event], object] | None = None,
        *,
        names: Mapping[Any, str] | None = None,
        name: str = "bus",
        most: int = _MOST,
        **options: Unpack[Known],
    ) -> None:
        """Creates a listener.

        on_event: is called with each event; without it they wait to be asked for. names: what a bus is called in
        events, by the channel of its messages; as the channel otherwise. name: what stands for the file in events.
        most: so many events wait at most, then the oldest are thrown away (`lost`). options: those of `open` about
        the network, the language and the filter.
        """
        if on_event is not None and not callable(on_event):
            raise TypeError(f"on_event={on_event!r}: what can be called is needed, not {type(on_event).__name__}")
        if not isinstance(most, int) or most < 1:
            raise ValueError(f"most={most!r}: 1 or more")
        super().__init__(plan("Listener", options))
        self.lost = 0
        """Events that were thrown away, since nobody asked for them."""
        self._on_event = on_event
        self._names = dict(names or {})
        self._most = most
        self._lock = threading.RLock()
        self._arrived = threading.Condition(self._lock)
        self._calling = False
        self._channels: dict[object, tuple[int, Packer]] = {}
        self._now_ns: int | None = None
        """The time of the frames by now."""
        self._heard = time.monotonic_ns()
        """When it was so, on this host's clock."""
        self._session.begin(str(name), False, "live")

    def __call__(self, message: "Message") -> None:
        """Adds a message, as `on_message_received`."""
        if not is_message(message):
            raise TypeError(f"message: a can.Message is needed, not {type(message).__name__}")
        if not message.timestamp > 0:  # also what is no number
            message = copy(message)
            message.timestamp = time.time()
        with self._lock:
            if self._over:
                return
            before, index, packer = self._channel(message.channel)
            try:
                record = packer.frame(message)
                self._now_ns = max(nanoseconds(message.timestamp), self._now_ns or 0)
                block = blocks.records_block(index, record, 1)
            except (Unfit, ValueError, OverflowError):
                block = blocks.dropped_block(index, 1)
            self._heard = time.monotonic_ns()
            # Of several channels nothing waits for another: what comes first is first.
            several = blocks.until_block(blocks.RELEASE_ALL) if len(self._channels) > 1 else b""
            self._feed(before + block + several)

    def on_message_received(self, msg: "Message") -> None:
        """Adds a message."""
        self(msg)

    def on_error(self, exc: Exception) -> None:
        """Notes that a bus cannot be received from: frames may be missing until the next one."""
        with self._lock:
            self._complain(one_line(exc))
            if not self._over:
                self._feed(b"".join(blocks.gap_block(index) for index, _ in self._channels.values()))

    def advance(self, seconds: float | None = None, *, ns: int | None = None, to_ns: int | None = None) -> None:
        """Advances the time without a frame, so that a missing heartbeat is noticed.

        seconds, ns: by how much, from the last frame or call on. to_ns: up to this time, on the clock of the stamps.
        Nothing given: as much as has passed on this host since the last frame, less 0.1 s for frames on their way.
        Iterating over it does the last while it waits. Time never goes back.
        """
        amounts = {"seconds": seconds, "ns": ns, "to_ns": to_ns}
        given = {name: value for name, value in amounts.items() if value is not None}
        for key, value in given.items():
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 1 << 62:
                raise ValueError(f"{key}={value!r}: a number, 0 or more")
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)}: only one of them")
        with self._lock:
            if self._over:
                return
            now = time.time_ns() if self._now_ns is None else self._now_ns
            if to_ns is not None:
                until = round(to_ns)
            elif given:
                until = now + (round(ns) if ns is not None else round((seconds or 0) * 1e9))
            else:
                passed = time.monotonic_ns() - self._heard
                until = now + max(0, passed - round(_TICK_S * 1e9)) if self._now_ns is not None else now
            if self._now_ns is not None and until > self._now_ns:
                self._heard = time.monotonic_ns() - (0 if given else round(_TICK_S * 1e9))
                self._now_ns = until
                self._feed(blocks.until_block(until))

    def stop(self) -> None:
        """Ends it, as the Notifier does; later messages are passed over."""
        with self._lock:
            if self._over:
                return
            self._over = True
            self._dispatch(self._session.end() + self._session.finish())
            self._arrived.notify_all()

    async def over(self, messages: "AsyncIterable[Message]") -> AsyncIterator[Event]:
        """Yields the events of messages that come asynchronously, as of `can.AsyncBufferedReader`; then stops."""
        try:
            async for message in messages:
                self(message)
                for event in self.take():
                    yield event
        finally:
            self.stop()
        for event in self.take():
            yield event

    def _channel(self, channel: object) -> tuple[bytes, int, Packer]:
        known = self._channels.get(channel)
        if known is not None:
            return b"", *known
        index = len(self._channels)
        if index >= blocks.MOST_BUSES:
            raise ValueError(f"channel {channel!r}: more than {blocks.MOST_BUSES} channels")
        name = self._names.get(channel) or bus_name(channel)
        packer = Packer(6, directed=True, bus=lambda _: name)
        self._channels[channel] = index, packer
        return blocks.name_block(index, name), index, packer

    def _feed(self, data: bytes) -> None:
        self._dispatch(self._session.feed(data))

    def _dispatch(self, result: bytes) -> None:
        """Dispatches events with the lock held: in order also if a callback brings further ones."""
        for line in self._session.complaints():
            self._complain(line)
        self._events.extend(self._typed(result))
        if self._on_event is None:
            while len(self._events) > self._most:
                self._events.popleft()
                self.lost += 1
            self._arrived.notify_all()
            return
        if self._calling:
            return
        self._calling = True
        try:
            while self._events:
                self._on_event(self._events.popleft())
        finally:
            self._calling = False

    def _complain(self, line: str) -> None:
        if len(self._reader.complaints) < _REMARKS:
            self._reader.complain(line)

    def _wait(self, timeout_s: float) -> list[Event]:
        with self._arrived:
            if not self._events and not self._over and timeout_s > 0:
                self._arrived.wait(timeout_s)
                if not self._events:
                    self.advance()
            got = list(self._events)
            self._events.clear()
            return got


class Bus(Stream):
    """Channels that canalyze listens to itself, by `canalyze.live`; nothing is ever sent.

    Threads: it receives in threads of its own from the start, and is read where it is iterated over, in one thread or
    task; `stop` may be called from any.
    """

    def __init__(self, made: Plan, receiving: "blocks.Live") -> None:
        """Creates a bus of a receiver."""
        super().__init__(made)
        self._receiving = receiving

        def opened(_: str) -> "Capture | blocks.Live":
            return receiving

        reading = Reading(self._session, made.words, self._reader, open_input=opened)
        self._results = reading.over((receiving.name,))
        receiving.start()

    def stop(self) -> None:
        """Ends the receiving; events that were received still follow."""
        self._receiving.stop()

    def __exit__(self, *_: object) -> None:
        """Stops it and closes the channels."""
        self._receiving.close()
        self._results.close()

    def _wait(self, timeout_s: float) -> list[Event]:
        end = time.monotonic() + timeout_s
        while True:
            result = next(self._results, None)
            if result is None:
                self._over = True
                return []
            found = self._typed(result)
            if found or time.monotonic() >= end:
                return found


def live(
    *channels: str,
    interface: str | None = None,
    data_bitrate: int | None = None,
    fd: bool = False,
    adapter: Mapping[str, Any] | None = None,
    reconnect: bool = False,
    duration: float | None = None,
    **options: Unpack[Known],
) -> Bus:
    """Listens to channels: `with canalyze.live("can0") as bus: for event in bus: ...`, or `async for`.

    interface: SocketCAN on Linux, or one of python-can's: then bitrate, data_bitrate, fd and adapter (what else
    python-can is told, by the names of its parameters) count. reconnect: a channel that is lost is waited for.
    duration: in seconds; without it until `stop`. options: those of `open` about the network, the language, the filter.

    SourceError for what cannot be opened, at once, or received from any more, then.
    """
    from canalyze.sources.bridge import buses

    if not channels or not all(isinstance(one, str) and one for one in channels) or len(set(channels)) < len(channels):
        raise ValueError(f"channels={channels!r}: names of channels, each once")
    if interface is None and not sys.platform.startswith("linux"):
        raise ValueError("interface: one of python-can's is needed on this system")
    if duration is not None and not (isinstance(duration, int | float) and duration > 0):
        raise ValueError(f"duration={duration!r}: seconds, above 0")
    made = plan("live", options)
    rate = None if (asked := options.get("bitrate")) is None else network.bit_rate(str(asked))
    if interface not in (None, buses.OWN) and not buses.known(str(interface)):
        raise ValueError(f"interface={interface!r}: python-can has no such interface")
    opened = buses.opened(
        interface or buses.OWN,
        dict.fromkeys(channels),
        bitrate=rate,
        data_bitrate=data_bitrate,
        fd=fd,
        options=adapter,
        patient=reconnect,
    )
    try:
        return Bus(made, blocks.Live(opened, reconnect=reconnect, duration_s=duration))
    except BaseException:
        for one in opened:
            one.close()
        raise


__all__ = ["Bus", "Listener", "Silent", "Stream", "live"]
