"""A file whose bytes are compressed on their way out. What they hold is not known here.

The same bytes give the same file: no name and no date stands in it.
"""

import sys
from collections.abc import Callable
from types import TracebackType
from typing import Final, Protocol

from canalyze.output import FileOutput


class _Compressor(Protocol):
    """What the standard library's compressors have in common."""

    def compress(self, data: bytes, /) -> bytes: ...
    def flush(self) -> bytes: ...


def _gzip() -> _Compressor:
    import zlib

    return zlib.compressobj(wbits=31)


def _zstd() -> _Compressor:
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    return zstd.ZstdCompressor()


def _xz() -> _Compressor:
    import lzma

    return lzma.LZMACompressor()


def _bzip2() -> _Compressor:
    import bz2

    return bz2.BZ2Compressor()


COMPRESSIONS: Final[dict[str, Callable[[], _Compressor]]] = {
    ".gz": _gzip,
    ".zst": _zstd,
    ".xz": _xz,
    ".bz2": _bzip2,
}
"""By the end of a file's name."""


class CompressedOutput(FileOutput):
    """A compressed file; complete when its block ends without an error."""

    def __init__(self, name: str, compression: str, *, force: bool) -> None:
        """Open the file beside `name`; `compression` is one of COMPRESSIONS."""
        self._compressor = COMPRESSIONS[compression]()
        super().__init__(name, force=force)

    def write(self, data: bytes) -> None:
        """Compress and write."""
        super().write(self._compressor.compress(data))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Write what the compressor still holds, then do as every file."""
        if kind is None:
            try:
                super().write(self._compressor.flush())
            except BaseException as failure:
                super().__exit__(type(failure), failure, failure.__traceback__)
                raise
        super().__exit__(kind, error, at)
