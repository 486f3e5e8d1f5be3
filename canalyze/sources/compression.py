"""What files are compressed with: one row a compression, for those that are read and those that are written.

The modules behind it are imported when a file needs them. Must not: know what is in a file.
"""

import sys
import zlib
from collections.abc import Callable
from types import ModuleType
from typing import Final, NamedTuple, Protocol

HEAD: Final = 8
"""Bytes at the beginning of a member that say all of it that is asked here."""
_ZSTD: Final = b"\x28\xb5\x2f\xfd"
_DICTIONARY: Final = 1 << 28
"""Most memory that an xz file may ask for, four times what its highest preset needs."""


class Compressor(Protocol):
    """One file on its way out, as the standard library has it."""

    def compress(self, data: bytes, /) -> bytes:
        """Take more; give what is ready of the file."""
        ...

    def flush(self) -> bytes:
        """Give the rest."""
        ...


class Decompressor(Protocol):
    """One member, stream or frame, as the standard library has it for bz2 and xz."""

    @property
    def eof(self) -> bool:
        """Whether the member is over."""
        ...

    @property
    def needs_input(self) -> bool:
        """Whether there is nothing more to give of what it has got."""
        ...

    @property
    def unused_data(self) -> bytes:
        """What came behind its end."""
        ...

    def decompress(self, data: bytes, max_length: int = -1) -> bytes:
        """Take more; give at most so many bytes."""
        ...


class Gzip:
    """One member of a gzip file, with the ways of the others."""

    def __init__(self, other: "Gzip | None" = None) -> None:
        """At the beginning of a member, or where another one stands."""
        self._inner: zlib._Decompress = other._inner.copy() if other else zlib.decompressobj(wbits=31)
        self._full: bool = other._full if other else False

    @property
    def eof(self) -> bool:
        """Whether the member is over."""
        return self._inner.eof

    @property
    def needs_input(self) -> bool:
        """Whether there is nothing more to give of what it has got."""
        return not self._inner.unconsumed_tail and not self._full

    @property
    def unused_data(self) -> bytes:
        """What came behind its end."""
        return self._inner.unused_data

    def decompress(self, data: bytes, max_length: int = -1) -> bytes:
        """Take more; give at most so many bytes."""
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
    """Tell it by the frame's descriptor; a skippable frame holds nothing that could be wrong."""
    return not head.startswith(_ZSTD) or len(head) < 5 or bool(head[4] & 4)


def _xz_checked(head: bytes) -> bool:
    """Tell it by the stream's flags: 0 is no check."""
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
    """Give what the decompressors raise about what they read."""
    import lzma

    return (OSError, EOFError, ValueError, MemoryError, zlib.error, lzma.LZMAError, _zstd().ZstdError)


class Compression(NamedTuple):
    """One way to compress a file."""

    suffix: str
    """How the names of such files end."""
    signs: tuple[bytes, ...]
    """How its members, streams or frames begin."""
    decompressor: Callable[[], Decompressor]
    compressor: Callable[[], Compressor]
    checked: Callable[[bytes], bool]
    """By its first HEAD bytes: whether a member has a check sum."""


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
"""By the name that the core's `sniff` has for it."""
