"""What is sound in a Vector BLF file, object by object, so that python-can's reader meets nothing else.

That reader trusts every size in the file: it loops for ever on a size of zero, takes all memory for a large one, and
keeps silent about a file that was cut. Here containers are unpacked and every size is looked at; what is no object is
said as damage, and reading goes on behind it. A container whose check sum does not match is passed over as a whole.

A file is a header, then objects, most of them containers (type 10) of compressed objects. An object has 16 bytes
(`LOBJ`, size of the header, its version, size of the object, type), then flags and a stamp. Objects in containers run
on from one container to the next. Must not: decode frames.
"""

import datetime
import re
import struct
import sys
import zlib
from collections import Counter
from collections.abc import Iterator
from typing import Final

from canalyze.sources import packed

_FILE: Final = struct.Struct("<4sL4B4BQQLL8H8H")
_OBJECT: Final = struct.Struct("<4sHHLL")
_FLAGGED: Final = struct.Struct("<4sHHLLL")
_CONTAINER: Final = struct.Struct("<H6xL4x")
_ERROR_EXT: Final = struct.Struct("<HHLBBBxLLH2x8s")
_SIGN: Final = b"LOBJ"
_HEAD: Final = re.compile(rb"(?s:LOBJ[\x10-\xff]\0[\0-\x03]\0..[\0-\x80]\0[\x01-\xff]\0\0\0)")
"""What reading goes on with behind damage: four letters alone may stand in data."""
_NEXT_CONTAINER: Final = re.compile(rb"(?s:LOBJ\x10\0\x01\0..[\0-\x80][\0-\x04]\x0a\0\0\0[\0\x02]\0)")
_PADDING: Final = 4
"""Most bytes between two objects; writers put as many as the size is above a multiple of four."""

_CONTAINER_TYPE: Final = 10
_LEAST: Final = {1: 16, 86: 16, 73: _ERROR_EXT.size, 100: 84, 101: 40}
"""Bytes behind the header that python-can's reader takes of an object, by the types that it knows."""
_MORE: Final = {1: 8, 86: 16, 73: 8, 100: 8, 101: 96}
"""Bytes that such objects may have beyond these: data, and what later versions of the format put behind them."""
_KINDS: Final = 256
"""Types of objects are below this."""
_ERRORS: Final = {2: "<H", 104: "<B"}
"""Error frames that it does not know (CAN_ERROR, CAN_FD_ERROR_64), and the channel that they begin with."""
_NAMES: Final = {3: "CAN_OVERLOAD", 4: "CAN_STATISTIC", 5: "APP_TRIGGER", 65: "APP_TEXT", 96: "GLOBAL_MARKER"}
_TEN_MICROSECONDS: Final = 1
_MOST: Final = 64 << 20
"""Largest container, packed or unpacked; writers make them of 128 KiB, or a few MiB."""
_PLAIN: Final = 32
"""Bytes of the shortest header of an object that is no container."""
_MOST_INNER: Final = 8 << 20
"""Largest object in a container."""
_CLASSIC: Final = 48
_FD: Final = 116
_FRAMES: Final = (
    rb"(?s:(?:LOBJ\x20\0\x01\0\x30\0\0\0[\x01\x56]\0\0\0%b.{28}"
    rb"|LOBJ\x20\0\x01\0\x74\0\0\0\x64\0\0\0%b.{14}[\0-\x7f].{81}))++"
)
_TENS: Final = re.compile(_FRAMES % (b"\x01\0\0\0", b"\x01\0\0\0"))
"""Data frames one after the other as most files have them, with stamps of 10 µs: they need no looking at each."""
_SOUND: Final = re.compile(_FRAMES % (b".{4}", b".{4}"))
PYTHON_CAN: Final = 5
"""The number of the application that python-can's writer signs with."""


class Damage:
    """A part that cannot be read, for the core to tell."""

    def __init__(self, kind: int, offset: int, size: int | None = None) -> None:
        """Take what `packed.damage` takes."""
        self.kind, self.offset, self.size = kind, offset, size
        self.record = packed.damage(kind, offset, size)

    def joined(self, after: "Damage") -> "Damage | None":
        """Give the damage that this one and the next are together; None if something may stand between them."""
        if self.size is None or after.size is None or packed.CUT in (self.kind, after.kind):
            return None
        # Parts of a packed container all have its offset.
        if after.offset not in (self.offset, self.offset + self.size) or after.kind not in (
            packed.STRUCTURE,
            self.kind,
        ):
            return None
        return Damage(self.kind, self.offset, self.size + after.size)


Piece = bytes | Damage
"""Whole objects, one after the other, or what stood in their place and cannot be read."""


class Objects:
    """Takes the bytes of a file in any chunking and gives what is sound of them."""

    def __init__(self) -> None:
        """At the beginning of a file."""
        self.date_ns: int | None = None
        """When the measurement started, as civil time counted as if it were UTC, to the ms; None if it is not said."""
        self.application = 0
        self.header: bytes | None = None
        """The file's header, for python-can: without its date, so that stamps keep their ns."""
        self.coarse = True
        """All stamps so far are of 10 µs."""
        self.passed_over: Counter[str] = Counter()
        self._size = 0
        self._buffer = bytearray()
        self._at = 0
        """Offset in the file of the buffer's beginning."""
        self._before = 0
        """Size of the object before the buffer, which its padding follows."""
        self._tail = b""
        """An object whose end stands in the next container."""
        self._tail_at = 0
        """Where it begins, or the container that it begins in."""
        self._inner_before = 0
        """Size of the object before it."""
        self._lost: list[Damage] = []
        """What is lost and has not been told yet: it may go on."""
        self._pending: Damage | None = None
        """The last damage, which the next one may join."""
        self._cut = False
        """That the file is cut has been said."""

    @property
    def offset(self) -> int:
        """How much of the file has been looked at."""
        return self._at

    def feed(self, data: bytes) -> Iterator[Piece]:
        """Take the next bytes."""
        self._buffer += data
        yield from self._joined(self._objects(ended=False))

    def end(self) -> Iterator[Piece]:
        """Take the end of the file."""
        yield from self._joined(self._last())
        if self._pending:
            yield self._pending

    def _joined(self, pieces: Iterator[Piece]) -> Iterator[Piece]:
        """Make one damage of those with nothing sound between them: the first wrong size may lead to many more."""
        for piece in pieces:
            before = self._pending
            if not isinstance(piece, Damage):
                if piece:
                    if before:
                        yield before
                    self._pending = None
                    yield piece
            elif before and (joined := before.joined(piece)):
                self._pending = joined
            else:
                if before:
                    yield before
                self._pending = piece

    def _last(self) -> Iterator[Piece]:
        yield from self._objects(ended=True)
        rest = len(self._buffer)
        yield from self._told()
        if self._cut:
            return
        if self.header is None or (rest and bytes(self._buffer).strip(b"\0")):
            at = self._tail_at if self._tail else self._at
            yield Damage(packed.CUT, at, len(self._tail) + rest)
        elif self._tail.strip(b"\0"):
            yield Damage(packed.CUT, self._tail_at, len(self._tail))
        elif rest > _PADDING:
            yield Damage(packed.STRUCTURE, self._at, rest)
        elif self._at + rest < self._size:
            yield Damage(packed.CUT, self._at + rest)

    def _take(self, size: int) -> bytes:
        taken = bytes(self._buffer[:size])
        del self._buffer[:size]
        self._at += len(taken)
        return taken

    def _head(self) -> bool:
        if len(self._buffer) < _FILE.size:
            return False
        fields = _FILE.unpack_from(self._buffer)
        size = fields[1] if _FILE.size <= fields[1] <= 4096 else 144
        if len(self._buffer) < size:
            return False
        self._take(size)
        self.application, self._size = fields[2], fields[10]
        year, month, _, day, hour, minute, second, millisecond = fields[14:22]
        try:
            date = datetime.datetime(year, month, day, hour, minute, second, tzinfo=datetime.UTC)
            self.date_ns = int(date.timestamp()) * 1_000_000_000 + min(millisecond, 999) * 1_000_000
        except (ValueError, OverflowError):
            self.date_ns = None
        self.header = _FILE.pack(b"LOGG", _FILE.size, *fields[2:14], *[0] * 16)
        return True

    def _objects(self, *, ended: bool) -> Iterator[Piece]:
        if self.header is None and not self._head():
            return
        buffer = self._buffer
        while len(buffer) >= _OBJECT.size:
            found = buffer.find(_SIGN, 0, _PADDING + len(_SIGN))
            if found < 0 or not _is_padding(buffer[:found], self._before):
                following = _next_head(buffer, 0)
                # The beginning of a head may stand at the end.
                self._lose(following if following >= 0 else len(buffer) - (0 if ended else _OBJECT.size - 1))
                if following < 0:
                    return
                continue
            self._take(found)
            if len(buffer) < _OBJECT.size:
                return
            _, header, _, size, kind = _OBJECT.unpack_from(buffer)
            least = _OBJECT.size + _CONTAINER.size if kind == _CONTAINER_TYPE else _PLAIN
            if not least <= size <= _MOST or (kind != _CONTAINER_TYPE and header < _PLAIN):
                self._lose(len(_SIGN))
                continue
            if len(buffer) < size + _OBJECT.size + _CONTAINER.size and not ended:
                return
            self._before = size
            yield from self._object(size, kind)

    def _object(self, size: int, kind: int) -> Iterator[Piece]:
        """Take the object at the buffer's beginning, which may be cut by the end of the file."""
        at, there = self._at, len(self._buffer)
        cut = there < size
        following = _next_head(self._buffer, len(_SIGN)) if cut else -1
        behind = _OBJECT.size + _CONTAINER.size
        if kind != _CONTAINER_TYPE or there < behind:
            inner = -1 if cut or self._followed(size) else _next_head(self._buffer, len(_SIGN), size + _OBJECT.size)
            if 0 < inner < size:  # the next one begins in it: its size is wrong, or bytes of it are gone
                self._lose(inner)
            elif not cut:
                yield from self._told()
                tail, self._tail = self._tail, b""
                whole = self._take(size)
                yield from self._walk(whole, at, plain=True, followed=self._followed())
                if self._tail:
                    yield Damage(packed.STRUCTURE, self._tail_at, len(self._tail))
                self._tail = tail
            elif following < 0:
                self._end_here(there)
            else:
                self._lose(len(_SIGN))
            return
        method, _ = _CONTAINER.unpack_from(self._buffer, _OBJECT.size)
        held = bytes(self._buffer[behind : min(size, there)])
        short = False
        if method == 0:
            further = _NEXT_CONTAINER.search(self._buffer, behind, size + behind)
            short = further is not None and further.start() < size
            if further and short:  # its size leads beyond its end
                held = held[: further.start() - behind]
            self._take(behind + len(held))
            yield from self._told()
            yield from self._walk(held, at + behind, plain=True, followed=self._followed())
        elif method == 2:
            unpacker = zlib.decompressobj()
            try:
                data = unpacker.decompress(held, _MOST)
            except (zlib.error, MemoryError):
                self._lose(max(following, 0) or size, packed.COMPRESSION)
                return
            if not unpacker.eof and not (cut and following < 0):
                self._lose(max(following, 0) or size, packed.COMPRESSION)
                return
            self._take(len(held) + behind - len(unpacker.unused_data) if unpacker.eof else size)
            yield from self._told()
            yield from self._walk(data, at, plain=False, followed=True)
        else:
            self._lose(max(following, 0) or size)
            return
        if cut and not short and not self._buffer:
            self._tail, self._cut = b"", True
            yield Damage(packed.CUT, at)
        elif cut or short:  # all of it is read, but its size is not what it says
            yield Damage(packed.STRUCTURE, at, 0)

    def _told(self) -> list[Damage]:
        """Give what was lost before the next object."""
        lost, self._lost = self._lost, []
        return lost

    def _lose(self, size: int, kind: int = packed.STRUCTURE) -> None:
        """Pass bytes over, and with them what was to go on there."""
        if self._tail:
            self._lost.append(Damage(packed.STRUCTURE, self._tail_at, len(self._tail)))
            self._tail = b""
        at = self._at
        if taken := len(self._take(size)):
            self._lost.append(Damage(kind, at, taken))

    def _end_here(self, there: int) -> None:
        """Pass over the object that the end of the file cuts."""
        at = self._tail_at if self._tail else self._at
        self._lost.append(Damage(packed.CUT, at, len(self._tail) + len(self._take(there))))
        self._tail, self._cut = b"", True

    def _followed(self, at: int = 0) -> bool:
        """Tell whether an object begins in the buffer there, or it ends: what came before it ended where it should."""
        end = at + _PADDING + len(_SIGN)
        found = self._buffer.find(_SIGN, at, end)
        if found >= 0:
            return _is_padding(self._buffer[at:found], self._before)
        rest = bytes(self._buffer[at:end])
        return len(rest) < _PADDING + len(_SIGN) and _SIGN.startswith(rest.lstrip(b"\0"))

    def _walk(self, data: bytes, at: int, *, plain: bool, followed: bool) -> Iterator[Piece]:
        """Look at every object of a container; what python-can would misread is put right.

        at: where the data begin in the file, or the container that they were packed in. plain: they were not packed.
        followed: what comes behind the data is what should come there.
        An object is believed if the next one stands where it ends: damage may begin in the one before it.
        """
        seam, tail_at = len(self._tail), self._tail_at
        data = self._tail + data
        self._tail = b""
        runs: list[bytes] = []
        begin, end = 0, len(data)
        position, last = 0, 0
        """Behind the last object, and its beginning."""
        before = self._inner_before
        unpack, least, more, passed_over = _FLAGGED.unpack_from, _LEAST, _MORE, self.passed_over

        def offset(position: int) -> int:
            if position < seam:
                return tail_at
            return at + position - seam if plain else at

        def lost(since: int, until: int) -> Iterator[Piece]:
            nonlocal begin, runs, position, last, before
            if since < begin:  # what was put right is lost as well
                runs.pop()
            else:
                runs.append(data[begin:since])
            yield b"".join(runs)
            yield Damage(packed.STRUCTURE, offset(since), until - since)
            runs, before = [], 0
            begin = position = last = until

        while True:
            if run := (_TENS if self.coarse else _SOUND).match(data, position):
                position = run.end()
                before = _CLASSIC if data.startswith(_SIGN, position - _CLASSIC) else _FD
                last = position - before
            found = data.find(_SIGN, position, position + _PADDING + len(_SIGN))
            if found < 0 and position + _PADDING + len(_SIGN) > end:
                break
            if found != position and (found < 0 or not _is_padding(data[position:found], before)):
                following = _next_head(data, position)
                yield from lost(last, following if following >= 0 else _partial_head(data, position))
                continue
            if found + _FLAGGED.size > end:
                break
            _, _, version, size, kind, flags = unpack(data, found)
            header = 32 if version == 1 else 40
            stop = found + size
            if found < seam < stop and data.startswith(_SIGN, seam):  # its end is not in the container behind it
                yield from lost(found, seam)
                continue
            bare = header + least.get(kind, 0)
            usual = bare + more.get(kind, 0)
            if size < bare or size > _MOST_INNER or not 0 < kind < _KINDS or (kind in least and version not in (1, 2)):
                following = _next_head(data, found + len(_SIGN))
                yield from lost(found, following if following >= 0 else _partial_head(data, found + len(_SIGN)))
                continue
            if size > usual:  # the head of another object in it: its size is wrong
                inner = max(found + usual, seam - _OBJECT.size if found < seam else 0)
                following = _next_head(data, inner, min(stop, end))
                if following >= 0:
                    yield from lost(found, following)
                    continue
            if stop > end:
                if size > 4096 and kind in least:  # no frame is as long as that
                    following = _next_head(data, found + len(_SIGN))
                    yield from lost(found, following if following >= 0 else _partial_head(data, found + len(_SIGN)))
                    continue
                break
            if kind in least:
                if size > usual and stop + _PADDING + len(_SIGN) <= end:
                    following = data.find(_SIGN, stop, stop + _PADDING + len(_SIGN))
                    if following < 0 and (following := _next_head(data, found + len(_SIGN))) >= 0:
                        yield from lost(found, following)
                        continue
                if flags != _TEN_MICROSECONDS:
                    self.coarse = False
                if kind in (100, 101) and (changed := _repaired(data[found:stop], kind, header)):
                    runs += [data[begin:found], changed]
                    begin = stop
            elif kind in _ERRORS and version in (1, 2) and size >= header + 4:
                runs += [data[begin:found], _as_error_ext(data[found:stop], kind, header)]
                begin = stop
            else:
                passed_over[_NAMES.get(kind, f"object type {kind}")] += 1
            position, last, before = stop, found, size
        self._inner_before = before
        if not followed and last < end and _SIGN not in data[position : position + _PADDING + len(_SIGN)]:
            yield from lost(last, end)
        elif data[position:].strip(b"\0") or end - position > _PADDING:
            self._tail = data[position:]
            self._tail_at = offset(position)
        runs.append(data[begin:position])
        yield b"".join(runs)


def _is_padding(gap: bytes | bytearray, before: int) -> bool:
    """Tell whether bytes between two objects are padding: as many as the size before them asks for, or few zeros."""
    size = len(gap)
    return size == 0 or (size <= _PADDING and (size in (before % 4, -before % 4) or not gap.strip(b"\0")))


def _next_head(data: bytes | bytearray, start: int, end: int = sys.maxsize) -> int:
    """Tell where the next head of an object is; -1 if there is none."""
    head = _HEAD.search(data, start, end)
    return head.start() if head else -1


def _partial_head(data: bytes, start: int) -> int:
    """Tell where at the end of data a head may begin that goes on behind them; their end if none does."""
    for at in range(max(start, len(data) - _OBJECT.size + 1), len(data)):
        if data[at : at + len(_SIGN)] == _SIGN[: len(data) - at]:
            return at
    return len(data)


def _repaired(whole: bytes, kind: int, header: int) -> bytes | None:
    """Take the remote flag from an FD frame, which has none: with it python-can drops the data."""
    at, remote, fd = (header + 2, 0x80, 0x01) if kind == 100 else (header + 12, 0x10, 0x10)
    if not (whole[at] & remote and whole[header + 13] & fd):
        return None
    changed = bytearray(whole)
    changed[at] &= ~remote & 0xFF
    return bytes(changed)


def _as_error_ext(whole: bytes, kind: int, header: int) -> bytes:
    """Give the error frame as the type that python-can knows, without details."""
    (channel,) = struct.unpack_from(_ERRORS[kind], whole, header)
    _, size, version, _, _ = _OBJECT.unpack_from(whole)
    body = _ERROR_EXT.pack(channel, 0, 0, 0, 0, 0, 0, 0, 0, b"")
    return _OBJECT.pack(_SIGN, size, version, header + len(body), 73) + whole[_OBJECT.size : header] + body
