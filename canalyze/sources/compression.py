"""The compressions of files that are read and written, one row each.

Their modules are imported when a file needs them. Must not: know the content of a file.
"""

import sys
import zlib
from collections.abc import Callable
from types import ModuleType
from typing import Final, NamedTuple, Protocol

HEAD: Final = 8
"""Number of bytes at the beginning of a member that `checked` needs."""
_ZSTD: Final = b"\x28\xb5\x2f\xfd"
_DICTIONARY: Final = 1 << 28
"""Maximum memory for an xz file, four times the need of its highest preset."""


class Compressor(Protocol):
    """One compressed file that is written, with the standard library's interface."""

    def compress(self, data: bytes, /) -> bytes:
        """Compresses `data`; returns the output that is ready."""
        ...

    def flush(self) -> bytes:
        """Returns the remaining output."""
        ...


class Decompressor(Protocol):
    """One member, stream or frame, with the standard library's interface of bz2 and xz."""

    @property
    def eof(self) -> bool:
        """True if the member has ended."""
        ...

    @property
    def needs_input(self) -> bool:
        """True if no more output is available without further input."""
        ...

    @property
    def unused_data(self) -> bytes:
        """The bytes after the end of the member."""
        ...

    def decompress(self, data: bytes, max_length: int = -1) -> bytes:
        """Decompresses `data`; returns at most `max_length` bytes."""
        ...


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
