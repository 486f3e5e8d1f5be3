"""SocketCAN as a live source: batches of frames from the kernel, with its stamps and drop counters.

One CAN_RAW socket per channel, one `recvmmsg` for up to 1024 frames into memory allocated once; a batch is passed to
the core as the kernel wrote it, without an object per frame. At this rate python-can's socket reports neither
drops nor the sender of a frame. Must not: send anything, or look into a frame.

Linux only, but importing it is fine anywhere.
"""

import ctypes
import os
import select
import socket
import struct
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources.live import (
    MARGIN_NS,
    MESSAGES,
    MOST_BUSES,
    LinkLost,
    block,
    dropped_block,
    gap_block,
    name_block,
    until_block,
)
from canalyze.sources.netdevices import (
    BUFFER,
    HOPELESS,
    RXQ_OVFL,
    TIMESTAMPING,
    TIMESTAMPNS,
    bring_up,
    can_socket,
    interfaces,
    missing,
    opened,
    watching,
    went,
)

ANY: Final = "any"
"""The channel name for all CAN interfaces that are up."""

_MEMINFO: Final = 55
_DROPS: Final = 8
"""The index of the drops in SO_MEMINFO."""
_FRAMES: Final = 1024
"""Maximum number of frames in a batch."""
_BATCHES: Final = 4
"""Maximum number of batches of a channel before the others get their turn."""
_FRAME: Final = 72
_CONTROL: Final = 128
_SLOT: Final = _FRAME + _CONTROL
_GATHER_S: Final = 0.01
"""Time for which frames are gathered if each would be a batch of its own."""
_BUSY_S: Final = 0.02
"""Maximum interval of batches for that."""
_LOOK_S: Final = 0.1
"""Interval at which the counters are read."""
_JOIN_NS: Final = 5_000_000
"""Time for which frames of several channels are held to be sorted."""
_STEP_NS: Final = 50_000_000
"""A larger step between the clocks means that one was set, or that the host has slept."""
_SURE_NS: Final = 10_000_000
"""Maximum time for reading both clocks to compare them."""
_DATE_NS: Final = 1_000_000_000
"""A hardware stamp further than this from the host's clock is of another clock."""
_WINDOW_NS: Final = 10_000_000_000
"""Time for which the distance of hardware stamps from the host's clock is remembered."""
_PATIENCE: Final = 50
"""Number of batches without a hardware stamp before their absence is reported."""

_NO_WAIT: Final[int] = getattr(socket, "MSG_DONTWAIT", 0)
_READABLE: Final[int] = getattr(select, "POLLIN", 0)
_CMSG: Final = struct.Struct("@Nii")
_WORD: Final = struct.calcsize("@l")
_SPEC: Final = struct.Struct("@ll")
_COUNT: Final = struct.Struct("@I")


class _Iovec(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("len", ctypes.c_size_t))


class _Msghdr(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_void_p),
        ("namelen", ctypes.c_uint),
        ("iov", ctypes.c_void_p),
        ("iovlen", ctypes.c_size_t),
        ("control", ctypes.c_void_p),
        ("controllen", ctypes.c_size_t),
        ("flags", ctypes.c_int),
    )


class _Mmsghdr(ctypes.Structure):
    _fields_ = (("hdr", _Msghdr), ("len", ctypes.c_uint))


class _Batch:
    """Memory for the frames of one recvmmsg, reused."""

    def __init__(self) -> None:
        self._recvmmsg = ctypes.CDLL(None, use_errno=True).recvmmsg
        self._recvmmsg.argtypes = (ctypes.c_int, ctypes.c_void_p, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p)
        self._recvmmsg.restype = ctypes.c_int
        self._size = ctypes.sizeof(_Mmsghdr)
        self._slots = ctypes.create_string_buffer(_FRAMES * _SLOT)
        self._headers = (_Mmsghdr * _FRAMES)()
        self._vectors = (_Iovec * _FRAMES)()
        begin = ctypes.addressof(self._slots)
        for place in range(_FRAMES):
            at = begin + place * _SLOT
            self._vectors[place] = _Iovec(at, _FRAME)
            vector = ctypes.addressof(self._vectors) + place * ctypes.sizeof(_Iovec)
            self._headers[place].hdr = _Msghdr(None, 0, vector, 1, at + _FRAME, _CONTROL, 0)
        self._fresh = ctypes.string_at(self._headers, ctypes.sizeof(self._headers))
        self._at_headers, self._at_slots = memoryview(self._headers).cast("B"), memoryview(self._slots).cast("B")
        self._address = ctypes.addressof(self._headers)
        self._used = 0

    def fill(self, descriptor: int) -> int:
        """Receives the waiting frames without blocking. Raises OSError, or BlockingIOError if there are none."""
        # The kernel writes over the lengths that say how much room there is.
        ctypes.memmove(self._address, self._fresh, self._used * self._size)
        self._used = 0
        count: int = self._recvmmsg(descriptor, self._address, _FRAMES, _NO_WAIT, None)
        if count < 0:
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number))
        self._used = count
        return count

    def block(self, bus: int, which: int) -> bytes:
        """Returns the received frames as a block."""
        count = self._used
        parts = self._at_headers[: count * self._size], self._at_slots[: count * _SLOT]
        return block(MESSAGES, bus, which, count, *parts)

    def last(self) -> tuple[int | None, int | None, int | None]:
        """Returns the kernel's stamp, the hardware's stamp and the drop counter of the last frame."""
        place = self._used - 1
        room = self._headers[place].hdr.controllen
        begin = place * _SLOT + _FRAME
        kernel = hardware = drops = None
        at = begin
        while at + _CMSG.size <= begin + room:
            size, level, kind = _CMSG.unpack_from(self._at_slots, at)
            data = at + _CMSG.size
            if size < _CMSG.size or at + size > begin + room:
                break
            if level == socket.SOL_SOCKET and kind == TIMESTAMPNS:
                kernel = _ns(*_SPEC.unpack_from(self._at_slots, data))
            elif level == socket.SOL_SOCKET and kind == TIMESTAMPING:
                hardware = _ns(*_SPEC.unpack_from(self._at_slots, data + 2 * _SPEC.size)) or None
            elif level == socket.SOL_SOCKET and kind == RXQ_OVFL:
                drops = _COUNT.unpack_from(self._at_slots, data)[0]
            at += -(-size // _WORD) * _WORD
        return kernel, hardware, drops


def _ns(seconds: int, ns: int) -> int:
    return seconds * 1_000_000_000 + ns


class _Channel:
    """One interface, with its counters and clock."""

    def __init__(self, name: str, bus: int) -> None:
        self.name = name
        self.bus = bus
        self.socket: socket.socket | None = None
        self.watch: socket.socket | None = None
        """A socket that receives a frame only if the controller goes bus-off."""
        self.named = False
        self.hardware = False
        self.reported = 0
        """The drop counter of the last frame passed on."""
        self._doubted = 0
        """The number of drops for which a gap was passed on last."""
        self.stamp: int | None = None
        """The stamp of the last frame."""
        self.small = False
        """True if the kernel granted a smaller buffer than requested."""
        self.without = 0
        """Number of batches without a hardware stamp; negative after the first stamp."""
        self._ahead: list[tuple[int, int]] = []
        """Maximum lead of hardware stamps over the host's clock, by time window."""

    @property
    def offset(self) -> int:
        """The difference to add to the host's clock to get the clock of the stamps."""
        return max((ahead for _, ahead in self._ahead), default=0)

    def compare(self, stamp: int, now: int) -> None:
        """Updates the offset by the stamp of a frame that has just arrived."""
        window = now // _WINDOW_NS
        if not self._ahead or self._ahead[-1][0] != window:
            self._ahead = [*self._ahead[-1:], (window, stamp - now)]
        else:
            self._ahead[-1] = (window, max(self._ahead[-1][1], stamp - now))

    def drops(self) -> int:
        """Returns the number of dropped frames that no later frame has reported."""
        if self.socket is None:
            return 0
        try:
            values = self.socket.getsockopt(socket.SOL_SOCKET, _MEMINFO, 4 * (_DROPS + 1))
        except OSError:
            return 0  # a kernel before 4.12
        if len(values) < 4 * (_DROPS + 1):
            return 0
        (total,) = _COUNT.unpack_from(values, 4 * _DROPS)
        missing: int = (total - self.reported) & 0xFFFF_FFFF
        return missing if missing < 1 << 31 else 0

    def lacks(self) -> bool:
        """Returns true once for each new number of dropped frames that no frame has reported."""
        unsaid = self.drops()
        before, self._doubted = self._doubted, self.reported + unsaid
        return unsaid > 0 and before != self._doubted

    def close(self) -> None:
        """Closes its sockets; new ones count from 0."""
        for one in (self.socket, self.watch):
            if one is not None:
                one.close()
        self.socket = self.watch = None
        self.named = False
        self.reported = self._doubted = 0
        self.stamp = None


class SocketCan:
    """Several CAN interfaces as one source, a `live.Bus`."""

    def __init__(
        self, channels: Sequence[str], *, first: int = 0, hardware_stamps: bool = False, patient: bool = False
    ) -> None:
        """Opens the interfaces; `any` means all that are up, `first` is the bus index of the first of them.

        hardware_stamps: use the adapter's stamps if it has any. patient: an interface that cannot be opened is lost at
        the beginning. Raises SourceError with the remedy otherwise.
        """
        can_socket(next(iter(channels), ANY)).close()  # raises if the system has no CAN at all
        self._poll = select.poll()  # type: ignore[attr-defined, unused-ignore]  # Windows has none
        self.first = first
        self._hardware = hardware_stamps
        self._remarks: deque[CanalyzeError] = deque()
        self.names: Sequence[str] = self._named(channels)
        self._channels = [_Channel(name, first + place) for place, name in enumerate(self.names)]
        self._lost: list[LinkLost] = []
        """Losses that have not been reported yet."""
        self._batch = _Batch()
        self._clocks: int | None = None
        self._busy_until = self._look_at = 0.0
        self._held = False
        """True if frames were delivered that wait to be sorted with those of other channels."""
        try:
            for channel in self._channels:
                try:
                    self._open(channel)
                except SourceError as error:
                    if not patient or error.key in HOPELESS:
                        raise
                    self._lost.append(LinkLost(channel.name, error))
        except BaseException:
            self.close()
            raise

    def receive(self, timeout_s: float) -> bytes:
        """Returns new frames of all channels, each in its order, and the time up to which they are complete."""
        if self._lost:
            raise self._lost.pop(0)
        if self._held:  # others of that time have come by then, or will not
            timeout_s = min(timeout_s, 2 * _JOIN_NS / 1e9)
        ready = self._poll.poll(max(0, round(timeout_s * 1000)))
        self._held = bool(ready) and len(self._channels) > 1
        if ready and time.monotonic() < self._busy_until and timeout_s > _GATHER_S:
            time.sleep(_GATHER_S)
        blocks: list[bytes] = []
        for channel in self._channels:
            if channel.socket is not None and not channel.named:  # each new socket counts its drops from 0
                channel.named = True
                blocks.append(name_block(channel.bus, channel.name))
        now = self._now(blocks)
        ends: list[int] = []
        for channel in self._channels:
            if channel.socket is not None:
                dry = self._take(channel, channel.socket.fileno(), blocks, now)
                if dry and channel.lacks():  # time passes them before a frame reports them
                    blocks.append(gap_block(channel.bus))
                ends.append(now + channel.offset if dry or channel.stamp is None else channel.stamp)
        moment = time.monotonic()
        if ready:
            self._busy_until = moment + _BUSY_S
        self._heed()
        if moment >= self._look_at:
            self._look_at = moment + _LOOK_S
            self._look()
        margin = MARGIN_NS if len(self._channels) == 1 else _JOIN_NS
        blocks.append(until_block(min(ends, default=now) - margin))
        return b"".join(blocks)

    def reopen(self) -> bool:
        """Tries to reopen the lost channels."""
        for channel in self._channels:
            if channel.socket is None:
                with suppress(SourceError):
                    self._open(channel)
        return all(channel.socket is not None for channel in self._channels)

    def ending(self) -> bytes:
        """Returns the drops that no frame has reported, and checks the counters a last time."""
        self._heed()
        self._look()
        return b"".join(self._missing(channel) for channel in self._channels)

    def remarks(self) -> list[CanalyzeError]:
        """Returns the remarks since the last call."""
        return [self._remarks.popleft() for _ in range(len(self._remarks))]  # another thread adds to them

    def close(self) -> None:
        """Closes all sockets."""
        for channel in self._channels:
            channel.close()

    def _named(self, channels: Sequence[str]) -> list[str]:
        names: list[str] = []
        for name in channels:
            if name == ANY:
                up, down = interfaces()
                if not up:
                    raise SourceError("live.none_up", command=bring_up(down[0])) if down else missing(ANY)
                self._remarks.append(SourceError("live.any", channels=", ".join(up)))
                names += up
            else:
                names.append(name)
        for place, name in enumerate(names):
            if name in names[:place]:
                raise SourceError("live.twice", channel=name)
        if self.first + len(names) > MOST_BUSES:
            raise SourceError("live.too_many", most=MOST_BUSES)
        return names

    def _open(self, channel: _Channel) -> None:
        channel.close()
        listening, channel.small = opened(channel.name, hardware_stamps=self._hardware)
        channel.socket = listening
        channel.hardware = self._hardware
        self._poll.register(listening, _READABLE)
        channel.watch = watching(channel.name)
        if channel.watch:
            self._poll.register(channel.watch, _READABLE)

    def _take(self, channel: _Channel, descriptor: int, blocks: list[bytes], now: int) -> bool:
        """Appends the waiting frames of a channel; returns true if those were all."""
        broken: OSError | None = None
        rounds = 0
        while rounds < _BATCHES or broken:
            try:
                count = self._batch.fill(descriptor)
            except BlockingIOError:
                break
            except InterruptedError:
                continue
            except OSError as error:  # what came before it can still be received
                if broken:
                    break
                broken = error
                continue
            rounds += 1
            self._learn(channel, now, fresh=count < _FRAMES)
            blocks.append(self._batch.block(channel.bus, 1 if channel.hardware else 0))
            if count < _FRAMES and not broken:
                return True
        else:
            return False
        if broken:
            blocks.append(self._missing(channel))
            self._forget(channel)
            self._lost.append(LinkLost(channel.name, went(channel.name, broken)))
        return True

    def _learn(self, channel: _Channel, now: int, *, fresh: bool) -> None:
        """Reads the control messages of the last frame of a batch."""
        kernel, hardware, drops = self._batch.last()
        channel.reported = channel.reported if drops is None else drops
        channel.stamp = None if kernel is None else kernel + channel.offset
        if not channel.hardware:
            return
        if hardware is None:
            channel.without += channel.without >= 0
            if channel.without == _PATIENCE:
                self._remark(SourceError("live.no_hardware_stamps", channel=channel.name))
            return
        channel.without = -1
        if abs(hardware - now) > _DATE_NS and len(self._channels) > 1:  # no order can be made of several clocks
            channel.hardware = False
            self._remark(SourceError("live.other_clock", channel=channel.name))
            return
        channel.stamp = hardware
        if fresh:
            channel.compare(hardware, now)

    def _now(self, blocks: list[bytes]) -> int:
        """Returns the host's clock; reports gaps if it was set or the host has slept."""
        before = time.monotonic_ns()
        now = time.time_ns()
        if time.monotonic_ns() - before < _SURE_NS:
            apart = now - before
            if self._clocks is not None and abs(apart - self._clocks) > _STEP_NS:
                blocks += (gap_block(channel.bus) for channel in self._channels if channel.named)
            self._clocks = apart
        return now

    def _look(self) -> None:
        """Reports small buffers that have lost frames."""
        for channel in self._channels:
            if channel.small and channel.reported + channel.drops():
                channel.small = False
                self._remark(SourceError("live.small_buffer", channel=channel.name, bytes=BUFFER))

    def _heed(self) -> None:
        """Reports bus-off as soon as the kernel does, so that it is seen even if the user stops then."""
        for channel in self._channels:
            watch = channel.watch
            if watch is None:
                continue
            try:
                told = watch.recv(_FRAME, _NO_WAIT)
            except BlockingIOError:
                continue
            except OSError:  # the interface is gone, which the other socket reports
                told = b""
            self._poll.unregister(watch)  # once is enough
            channel.watch = None
            watch.close()
            if told:
                self._remark(SourceError("live.bus_off", channel=channel.name))

    def _missing(self, channel: _Channel) -> bytes:
        drops = channel.drops()
        channel.reported += drops
        return dropped_block(channel.bus, drops) if drops else b""

    def _forget(self, channel: _Channel) -> None:
        for one in (channel.socket, channel.watch):
            if one is not None:
                with suppress(KeyError):
                    self._poll.unregister(one)
        channel.close()

    def _remark(self, remark: CanalyzeError) -> None:
        self._remarks.append(remark)
