"""Files, pipes, standard input and captures in memory as bytes.

`read` returns the result of one read(2), at most 1 MiB, so that a line of a pipe is answered when it comes.
A source knows neither formats nor frames.
"""

import errno
import os
import re
import stat
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from canalyze.errors import SourceError

if TYPE_CHECKING:
    from pathlib import Path

CHUNK: Final = 1 << 20
_AS_IT_IS: Final = getattr(os, "O_BINARY", 0)
"""The flag against translation of line ends, where the system has it."""
STDIN: Final = "-"
_REST_S: Final = 0.1


def _is_channel(name: str) -> bool:
    """Returns true if a name looks like a CAN interface."""
    return re.fullmatch("(v|vx|sl)?can[0-9]+(,.*)?", name) is not None


class Source:
    """An open file; a context manager."""

    def __init__(self, name: str, shown: str | None = None) -> None:
        """Opens `name` ('-' is standard input, called stdin).

        shown: the name in messages. Raises SourceError if it cannot be opened.
        """
        self.name = shown or ("stdin" if name == STDIN else name)
        self._name = name
        self.taken = 0
        """Number of bytes read so far."""
        self._fd = -1
        self._own = name != STDIN
        try:
            self._fd = os.open(name, os.O_RDONLY | _AS_IT_IS) if self._own else 0
            self._status = os.fstat(self._fd)
            if stat.S_ISDIR(self._status.st_mode):
                raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
        except (OSError, ValueError) as error:
            self.close()
            if isinstance(error, ValueError):  # a NUL in the name
                error = OSError(errno.ENOENT, str(error))
            key = "source.channel" if error.errno == errno.ENOENT and _is_channel(self.name) else "source.open"
            raise SourceError(key, name=self.name, error=error) from error

    @property
    def regular(self) -> bool:
        """True for a regular file, false for a pipe, a terminal or a device."""
        return stat.S_ISREG(self._status.st_mode)

    @property
    def damage(self) -> None:
        """Always None; only compressed files can be damaged."""

    @property
    def begins(self) -> bool:
        """Always false, because plain bytes have no checksum."""
        return False

    @property
    def path(self) -> "Path | None":
        """The file itself, for a reader that opens by name; None for a pipe and for standard input."""
        if not (self._own and self.regular):
            return None
        from pathlib import Path

        return Path(self._name)

    def read(self) -> bytes:
        """Returns the next bytes, b"" at the end. Raises SourceError if the system refuses."""
        try:
            data = os.read(self._fd, CHUNK)
            self.taken += len(data)
            return data
        except OSError as error:
            raise SourceError("source.read", name=self.name, error=error) from error

    def rests(self) -> bool:
        """Returns true if a pipe, a terminal or a device delivers nothing for a tenth of a second."""
        if self.regular:
            return False
        import select

        try:
            return not select.select([self._fd], [], [], _REST_S)[0]
        except (OSError, ValueError):  # not supported by every system
            return True

    def close(self) -> None:
        """Closes the file; standard input stays open."""
        if self._own and self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def __enter__(self) -> Self:
        """Returns the source."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Closes the source."""
        self.close()


class Memory:
    """Bytes with a name, with the interface of `Source`."""

    regular: Final = True
    damage: Final = None
    begins: Final = False
    path: Final = None

    def __init__(self, name: str, data: bytes) -> None:
        """Wraps `data`; `name` is used in messages."""
        self.name = name
        self.taken = 0
        self._data = memoryview(data)

    def read(self) -> bytes:
        """Returns the next bytes, b"" at the end."""
        given = bytes(self._data[self.taken : self.taken + CHUNK])
        self.taken += len(given)
        return given

    def rests(self) -> bool:
        """Returns false; everything is there."""
        return False

    def close(self) -> None:
        """Does nothing."""


def total_size(names: tuple[str, ...]) -> int | None:
    """Returns the total size of all files in bytes, or None if one is not a regular file."""
    total = 0
    for name in names:
        try:
            status = os.fstat(0) if name == STDIN else os.stat(name)  # noqa: PTH116 - pathlib is a tenth of the start
        except (OSError, ValueError):
            continue
        if not stat.S_ISREG(status.st_mode):
            return None
        total += status.st_size
    return total
