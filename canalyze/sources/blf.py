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
_CONTAINER_SIGN: Final = b"LOBJ\x10\x00\x01\x00"

_CONTAINER_TYPE: Final = 10
_LEAST: Final = {1: 16, 86: 16, 73: _ERROR_EXT.size, 100: 84, 101: 40}
"""Bytes behind the header that python-can's reader takes of an object, by the types that it knows."""
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
_FRAMES: Final = rb"(?s:LOBJ\x20\0\x01\0\x30\0\0\0[\x01\x56]\0\0\0%b.{28})++"
_TENS: Final = re.compile(_FRAMES % rb"\x01\0\0\0")
"""Data frames one after the other as most files have them, with stamps of 10 µs: they need no looking at each."""
_SOUND: Final = re.compile(_FRAMES % b".{4}")
PYTHON_CAN: Final = 5
"""The number of the application that python-can's writer signs with."""


class Damage(Exception):
    """A part that cannot be read, for the core to tell."""

    def __init__(self, kind: int, offset: int, size: int | None = None) -> None:
        """Take what `packed.damage` takes."""
        super().__init__(kind, offset, size)
        self.kind = kind
        self.record = packed.damage(kind, offset, size)


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
        self._tail = b""
        """An object whose end stands in the next container."""
        self._lost = False
        """Something was just lost: that the next object cannot be found at once is no further damage."""
        self._cut = False
        """That the file is cut has been said."""

    @property
    def offset(self) -> int:
        """How much of the file has been looked at."""
        return self._at

    def feed(self, data: bytes) -> Iterator[Piece]:
        """Take the next bytes."""
        self._buffer += data
        yield from self._objects(ended=False)

    def end(self) -> Iterator[Piece]:
        """Take the end of the file."""
        yield from self._objects(ended=True)
        rest = len(self._buffer)
        if self._cut:
            return
        if self.header is None or (rest and bytes(self._buffer).strip(b"\0")):
            yield Damage(packed.CUT, self._at, rest)
        elif self._tail.strip(b"\0") or self._at + rest < self._size:
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
            found = buffer.find(_SIGN, 0, 8)
            if found < 0 or len(buffer) < found + _OBJECT.size:
                if found < 0:
                    damage = self._search(ended)
                    if damage:
                        yield damage
                if len(buffer) < _OBJECT.size or buffer[:4] != _SIGN:
                    return
                continue
            if found:
                self._take(found)
            _, header, _, size, kind = _OBJECT.unpack_from(buffer)
            if not _OBJECT.size <= size <= _MOST:
                yield self._skip(4)
                continue
            if len(buffer) < size and not ended:
                return
            try:
                yield from self._object(header, size, kind)
            except Damage as damage:
                self._tail, self._lost, self._cut = b"", True, damage.kind == packed.CUT
                yield damage

    def _object(self, header: int, size: int, kind: int) -> Iterator[Piece]:
        """Take the object at the buffer's beginning, which may be cut by the end of the file."""
        at, there = self._at, len(self._buffer)
        cut = there < size
        if kind != _CONTAINER_TYPE:
            if cut:
                if self._next_container() > 0:
                    raise self._skip(4)
                raise Damage(packed.CUT, at, len(self._take(there)))
            if header < _PLAIN:  # only a container's is shorter: its type was changed
                raise self._lose(packed.STRUCTURE, size, cut)
            tail, self._tail = self._tail, b""
            yield from self._walk(self._take(size), at)
            self._tail = tail
            return
        behind = _OBJECT.size + _CONTAINER.size
        if there < behind:
            raise Damage(packed.CUT, at, len(self._take(there)))
        method, _ = _CONTAINER.unpack_from(self._buffer, _OBJECT.size)
        held = bytes(self._buffer[behind : min(size, there)])
        if method == 0:
            if cut and self._next_container() > 0:
                raise self._skip(4)
            self._take(size)
            yield from self._walk(held, at)
        elif method == 2:
            unpacker = zlib.decompressobj()
            try:
                data = unpacker.decompress(held, _MOST)
            except (zlib.error, MemoryError):
                raise self._lose(packed.COMPRESSION, size, cut) from None
            if not unpacker.eof and not (cut and self._next_container() < 0):
                raise self._lose(packed.COMPRESSION, size, cut)
            self._take(len(held) + behind - len(unpacker.unused_data) if unpacker.eof else size)
            yield from self._walk(data, at)
        else:
            raise self._lose(packed.STRUCTURE, size, cut)
        if cut:
            raise Damage(packed.CUT if self._next_container() < 0 and not self._buffer else packed.STRUCTURE, at)

    def _lose(self, kind: int, size: int, cut: bool) -> Damage:
        """Pass an object over; one whose size leads beyond the file, only up to the next container."""
        at = self._at
        if cut:
            size = max(self._next_container(), 0) or len(self._buffer)
        return Damage(kind, at, len(self._take(size)))

    def _next_container(self) -> int:
        """Tell how far the next container is; -1 if there is none."""
        return self._buffer.find(_CONTAINER_SIGN, 4)

    def _search(self, ended: bool) -> Damage | None:
        """Pass over what is no object."""
        at = self._at
        found = self._buffer.find(_SIGN)
        keep = 0 if ended else 3
        lost = self._take(found if found >= 0 else len(self._buffer) - keep)
        known, self._lost = self._lost, True
        self._tail = b""
        if found >= 0:
            self._lost = False
        return None if known or not lost.strip(b"\0") else Damage(packed.STRUCTURE, at, len(lost))

    def _skip(self, size: int) -> Damage:
        at = self._at
        self._tail, self._lost = b"", True
        return Damage(packed.STRUCTURE, at, len(self._take(size)))

    def _walk(self, data: bytes, at: int) -> Iterator[Piece]:
        """Look at every object of a container; what python-can would misread is put right."""
        data = self._tail + data
        self._tail = b""
        self._lost = False
        runs: list[bytes] = []
        position, begin, end = 0, 0, len(data)
        unpack, least, passed_over = _FLAGGED.unpack_from, _LEAST, self.passed_over
        while True:
            if run := (_TENS if self.coarse else _SOUND).match(data, position):
                position = run.end()
            found = data.find(_SIGN, position, position + 8)
            if found < 0 and position + 8 <= end:
                found = data.find(_SIGN, position)
                runs.append(data[begin:position])
                yield b"".join(runs)
                runs = []
                lost = (found if found >= 0 else end) - position
                if data[position : position + lost].strip(b"\0"):
                    yield Damage(packed.STRUCTURE, at, lost)
                begin = position = found if found >= 0 else end
                if found < 0:
                    return
            if found < 0 or found + _FLAGGED.size > end:
                self._tail = data[position:]
                break
            _, _, version, size, kind, flags = unpack(data, found)
            header = 32 if version == 1 else 40
            if size < header or size > _MOST_INNER or size < header + least.get(kind, 0):
                runs.append(data[begin:found])
                yield b"".join(runs)
                runs = []
                yield Damage(packed.STRUCTURE, at, size if size < 1024 else None)
                # Behind its sign, so that the next one is looked for.
                following = data.find(_SIGN, found + 4)
                if following < 0:
                    return
                begin = position = following
                continue
            if found + size > end:
                if size > 4096 and kind in least:  # no frame is as long as that
                    yield Damage(packed.STRUCTURE, at)
                    following = data.find(_SIGN, found + 4)
                    runs.append(data[begin:found])
                    if following < 0:
                        begin = position = end
                        break
                    begin = position = following
                    continue
                self._tail = data[found:]
                position = found
                break
            position = found + size
            if kind in least:
                if flags != _TEN_MICROSECONDS:
                    self.coarse = False
                if version not in (1, 2):
                    passed_over[f"object header version {version}"] += 1
                elif kind in (100, 101) and (changed := _repaired(data[found:position], kind, header)):
                    runs += [data[begin:found], changed]
                    begin = position
            elif kind in _ERRORS and version in (1, 2) and size >= header + 4:
                runs += [data[begin:found], _as_error_ext(data[found:position], kind, header)]
                begin = position
            else:
                passed_over[_NAMES.get(kind, f"object type {kind}")] += 1
        runs.append(data[begin:position])
        yield b"".join(runs)


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
