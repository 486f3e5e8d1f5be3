"""Where a file says at its end what it holds, and what it says there: read before the rest, as nobody can who is fed.

Only of a file that can be opened by name, once more. Must not: know what a summary means, nor fail.
"""

import os
import struct
from pathlib import Path
from typing import Final

_MAGIC: Final = b"\x89MCAP0\r\n"
_FOOTER: Final = struct.Struct("<BQQQI8s")
"""A record's type and length; where the summary begins, where its offsets do, its check sum; the sign of the format."""
_FOOTER_TYPE: Final = 2
_MOST: Final = 16 << 20
"""The longest summary that is read."""


def summary_of(path: Path) -> bytes:
    """Give the end of an MCAP file from its summary on; b"" where it has none."""
    try:
        with path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            if size < _FOOTER.size:
                return b""
            file.seek(size - _FOOTER.size)
            kind, _, start, _, _, sign = _FOOTER.unpack(file.read(_FOOTER.size))
            if kind != _FOOTER_TYPE or sign != _MAGIC or not size - _MOST <= start < size or not start:
                return b""
            file.seek(start)
            return file.read(size - start)
    except (OSError, struct.error):
        return b""
