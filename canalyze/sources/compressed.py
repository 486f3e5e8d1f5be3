"""Compressed files and text of another encoding, as the bytes that are in them.

A layer reads pieces from the one below and returns pieces of bounded size, so that memory does not grow with the
unpacked size. Damage ends the data and is reported, never raised. Bytes are returned before their checksum is read: if
that fails, or if a member cannot be unpacked to its end, all its output may be wrong, and the damage names its
beginning. The modules of the compressions are imported when a file needs them. Must not: know a format of captures.
"""

import codecs
import sys
import zlib
from collections.abc import Callable
from types import ModuleType
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, TypeAlias

HEAD: Final = 8
"""Number of bytes at the beginning of a member that `checked` needs."""
if TYPE_CHECKING:
    import bz2
    import lzma

Compressor: TypeAlias = "bz2.BZ2Compressor | lzma.LZMACompressor | zlib._Compress"
"""One compressed file that is written."""
Decompressor: TypeAlias = "Gzip | bz2.BZ2Decompressor | lzma.LZMADecompressor"
"""One member, stream or frame."""
_ZSTD: Final = b"\x28\xb5\x2f\xfd"
_DICTIONARY: Final = 1 << 28
"""Maximum memory for an xz file, four times the need of its highest preset."""


class Gzip:
    """One member of a gzip file, with the interface of the other decompressors."""

    def __init__(self, other: "Gzip | None" = None) -> None:
        """Begins a member, or copies the state of another decompressor."""
        self._inner: zlib._Decompress = other._inner.copy() if other else zlib.decompressobj(wbits=31)
        self._full: bool = other._full if other else False

    @property
    def eof(self) -> bool:
        """True if the member has ended."""
        return self._inner.eof

    @property
    def needs_input(self) -> bool:
        """True if no more output is available without further input."""
        return not self._inner.unconsumed_tail and not self._full

    @property
    def unused_data(self) -> bytes:
        """The bytes after the end of the member."""
        return self._inner.unused_data

    def decompress(self, data: bytes, max_length: int = -1) -> bytes:
        """Decompresses `data`; returns at most `max_length` bytes."""
        unpacked = self._inner.decompress(self._inner.unconsumed_tail + data, max_length)
        self._full = len(unpacked) == max_length  # there may be more that needs no input
        return unpacked


def _zstd() -> ModuleType:
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    return zstd


def _zstd_decompressor() -> Decompressor:
    made: Decompressor = _zstd().ZstdDecompressor()
    return made


def _zstd_compressor() -> Compressor:
    # Of itself the library writes none, and changed bytes would pass unseen.
    zstd = _zstd()
    made: Compressor = zstd.ZstdCompressor(options={zstd.CompressionParameter.checksum_flag: 1})
    return made


def _always(_: bytes) -> bool:
    return True


def _zstd_checked(head: bytes) -> bool:
    """Returns true if the frame's descriptor announces a checksum; a skippable frame has no content."""
    return not head.startswith(_ZSTD) or len(head) < 5 or bool(head[4] & 4)


def _xz_checked(head: bytes) -> bool:
    """Returns true if the stream's flags announce a check; 0 is none."""
    return len(head) < HEAD or head[7] & 0xF != 0


def _xz_decompressor() -> Decompressor:
    import lzma

    return lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_DICTIONARY)


def _xz_compressor() -> Compressor:
    import lzma

    return lzma.LZMACompressor()


def _bzip2_decompressor() -> Decompressor:
    import bz2

    return bz2.BZ2Decompressor()


def _bzip2_compressor() -> Compressor:
    import bz2

    return bz2.BZ2Compressor()


def errors() -> tuple[type[Exception], ...]:
    """Returns the exceptions that the decompressors raise for bad input."""
    import lzma

    return (OSError, EOFError, ValueError, MemoryError, zlib.error, lzma.LZMAError, _zstd().ZstdError)


class Compression(NamedTuple):
    """A compression of files."""

    suffix: str
    """The suffix of file names."""
    signs: tuple[bytes, ...]
    """The bytes with which members, streams or frames begin."""
    decompressor: Callable[[], Decompressor]
    compressor: Callable[[], Compressor]
    checked: Callable[[bytes], bool]
    """Returns true if a member has a checksum, by its first HEAD bytes."""


COMPRESSIONS: Final[dict[str, Compression]] = {
    "gzip": Compression(".gz", (b"\x1f\x8b",), Gzip, lambda: zlib.compressobj(wbits=31), _always),
    "zstd": Compression(
        ".zst",
        (_ZSTD, *(bytes([0x50 + n]) + b"\x2a\x4d\x18" for n in range(16))),
        _zstd_decompressor,
        _zstd_compressor,
        _zstd_checked,
    ),
    "xz": Compression(".xz", (b"\xfd7zXZ\0",), _xz_decompressor, _xz_compressor, _xz_checked),
    "bzip2": Compression(".bz2", (b"BZh",), _bzip2_decompressor, _bzip2_compressor, _always),
}
"""The compressions, by the core's names for them."""


PIECE: Final = 1 << 20
"""Maximum number of bytes returned by one `read`."""
_TAKEN: Final = 1 << 12
"""Number of bytes passed to a decompressor at once; damage among them costs all of their output."""
_KEPT: Final = 1 << 16
"""Bytes of a member that are kept, so that the sound part of a small damaged member is not lost."""


class Damage(NamedTuple):
    """The point from which a file cannot be unpacked."""

    kind: str
    """One of the core's kinds of damage."""
    offset: int
    """The offset in the compressed file, in bytes."""
    lost: int | None
    """Bytes of the file from there on; None if it ends there."""
    since: int | None = None
    """The begin of the member whose output may be wrong; None if all output is sound."""


class Layer(Protocol):
    """A source of bytes."""

    @property
    def damage(self) -> Damage | None:
        """The damage of the file that ended the data, if any."""
        ...

    @property
    def begins(self) -> bool:
        """True if the bytes returned last are the first that a new checksum covers."""
        ...

    def read(self) -> bytes:
        """Returns the next bytes, b"" at the end."""
        ...


class Unpacked:
    """The content of a compressed file, with all its members joined."""

    def __init__(self, below: Layer, form: str) -> None:
        """Creates the layer; `form` is one of COMPRESSIONS."""
        self.damage: Damage | None = None
        self.begins = False
        self.checked = True
        """True if every member so far has a checksum."""
        self._below = below
        compression = COMPRESSIONS[form]
        self._new, self._signs = compression.decompressor, compression.signs
        self._has_sum = compression.checked
        self._member: Decompressor | None = None
        self._kept = b""
        """The input of the current member, while it is small."""
        self._given = 0
        """Number of bytes that the member has produced."""
        self._head = b""
        """Its first bytes."""
        self._start = 0
        """Its offset in the file."""
        self._held = b""
        """Output of the member that is returned by the next `read`, after that of the members before it."""
        self._first = True
        self._raw = b""
        self._at = 0
        """The position in `_raw`."""
        self._offset = 0
        """Bytes of the file before `_raw`."""
        self._over = False

    def read(self) -> bytes:
        """Returns up to PIECE bytes of the content; b"" at the end, or where damage ends it.

        They are all of finished members, or all of the current one, so that `Damage.since` can name what may be wrong.
        """
        self.begins = bool(self._held) or self._member is None or not self._given
        over: list[bytes] = []
        pieces, self._held = [self._held] if self._held else [], b""
        room = PIECE - sum(map(len, pieces))
        while room and not self.damage:
            member = self._member
            # Waits for input only without output, so that lines of a pipe are answered when they come.
            if (member is None or member.needs_input) and self._at == len(self._raw) and not self._over:
                if over or pieces:
                    break
                self._offset += len(self._raw)
                self._raw, self._at = self._below.read(), 0
                self._over = not self._raw
            if member is None and not self._begin():
                if self._over:
                    break
                continue
            piece = self._step(room)
            if piece:
                pieces.append(piece)
                room -= len(piece)
            if self._member is None and not self.damage:
                over += pieces
                pieces = []
                self.begins = self.begins or not over
        if over:
            self._held, pieces = b"".join(pieces), over
        return b"".join(pieces)

    def _begin(self) -> bool:
        """Begins the next member, skipping zero padding; returns false if there is none, or not yet."""
        if not self._first:
            rest = self._raw[self._at :].lstrip(b"\0")
            self._at = len(self._raw) - len(rest)
        longest = max(map(len, self._signs))
        while len(self._raw) - self._at < longest and self._at < len(self._raw) and not self._over:
            more = self._below.read()
            self._over = not more
            self._raw += more
        head = self._raw[self._at : self._at + longest]
        if not head:
            return False
        if not head.startswith(self._signs):
            begun = len(head) < longest and any(sign.startswith(head) for sign in self._signs)
            self._damaged("cut" if begun else "rest", self._at)
            return False
        self._first = False
        self._member, self._kept, self._given = self._new(), b"", 0
        self._head, self._start = b"", self._offset + self._at
        return True

    def _step(self, room: int) -> bytes:
        member = self._member
        assert member is not None
        data = self._raw[self._at : self._at + _TAKEN] if member.needs_input else b""
        if not data and member.needs_input:
            if self._over:
                self._damaged("cut", self._at)
            return b""
        self._at += len(data)
        self._look(data)
        again, behind = self._again(member, data)
        try:
            piece = member.decompress(data, room)
        except errors():
            piece, used = _bytewise(*again)
            self._given += len(piece)
            self._damaged("compression", self._at - behind + used, self._start if self._given else None)
            return piece
        self._given += len(piece)
        if member.eof:
            self._at -= len(member.unused_data)
            self._member = None
        return piece

    def _look(self, data: bytes) -> None:
        """Reads from the first bytes of a member if it has a checksum."""
        if len(self._head) < HEAD:
            self._head += data[: HEAD - len(self._head)]
            self.checked = self.checked and self._has_sum(self._head)

    def _again(self, member: Decompressor, data: bytes) -> "tuple[tuple[Decompressor | None, bytes, int], int]":
        """Returns the state from which `data` can be unpacked again if it is damaged, and how far back it begins."""
        if isinstance(member, Gzip):
            return (Gzip(member), data, 0), len(data)
        if len(self._kept) > _KEPT:
            return (None, b"", 0), len(data)
        self._kept += data
        return (self._new(), self._kept, self._given), len(self._kept)

    def _damaged(self, kind: str, at: int, since: int | None = None) -> None:
        """Records the damage and counts the bytes that are left."""
        lost = len(self._raw) - at
        while kind != "cut" and (more := self._below.read()):
            lost += len(more)
        self.damage = Damage(kind, self._offset + at, None if kind == "cut" else lost, since)


def _bytewise(member: "Decompressor | None", data: bytes, skipped: int) -> tuple[bytes, int]:
    """Unpacks damaged bytes one by one; returns the output after `skipped` bytes, and the number of sound bytes."""
    pieces, used = b"", 0
    try:
        while member and len(pieces) < PIECE and not member.eof and (used < len(data) or not member.needs_input):
            byte = data[used : used + 1] if member.needs_input else b""
            piece = member.decompress(byte, PIECE)
            used += len(byte)
            pieces += piece[skipped:]
            skipped = max(0, skipped - len(piece))
    except errors():
        pass
    return pieces, used


class Transcoded:
    """Text of another encoding as UTF-8; undecodable bytes become U+FFFD."""

    def __init__(self, below: Layer, encoding: str) -> None:
        """Creates the layer; `encoding` is a name that Python knows."""
        self._below = below
        self._decoder = codecs.getincrementaldecoder(encoding)("replace")
        self._over = False

    @property
    def damage(self) -> Damage | None:
        """The damage of the layer below."""
        return self._below.damage

    @property
    def begins(self) -> bool:
        """The state of the layer below; a character that a member boundary splits belongs to the next member."""
        return self._below.begins

    def read(self) -> bytes:
        """Returns the next bytes, b"" at the end."""
        text = ""
        while not text and not self._over:
            raw = self._below.read()
            self._over = not raw
            text = self._decoder.decode(raw, final=self._over)
        return text.encode("utf-8")
