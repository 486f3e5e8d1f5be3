"""Files written atomically: each as a part with a temporary name, renamed when complete; and the user's, read whole.

A part is created in the folder of its file, under a random name that ends in `.part`: an existing link is not
followed, and two runs never write to the same file. Live recordings are written under their final name instead
(`in_place`), so that a killed process leaves its data. Failures of writing are OSErrors.

Configuration, expectations and baselines are read whole, never more of one than its bound: a file that somebody hands
over must cost no more than it is worth, whatever it holds, a device without end, too. Must not: know the content.
"""

import os
import stat
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Final, TypeVar

from canalyze.errors import ConfigError, as_error

if TYPE_CHECKING:
    from pathlib import Path

T = TypeVar("T")
MOST: Final = 2 << 20
"""Bytes of such a file; a hundred times those of a large one."""
_SHOWN: Final = 200
AS_IT_IS: Final = getattr(os, "O_BINARY", 0)
"""The flag against translation of line ends, where the system has it."""
_NO_LINK: Final = getattr(os, "O_NOFOLLOW", 0)
_TRIES: Final = 100
"""Maximum number of random names; one collides once in four thousand million."""
_LONGEST: Final = 200
"""Maximum bytes of a file's name in that of its part; names end at 255."""


class Part:
    """A file that is being written."""

    def __init__(self, final: "Path", *, replace: bool) -> None:
        """Creates the part of `final`. replace: an existing file is replaced, keeping its mode and owner."""
        self.final = final
        self.replace = replace
        before = self._before(final)
        # The part is as private as the file that it replaces.
        mode = 0o666 if before is None else stat.S_IMODE(before.st_mode) & 0o777 | stat.S_IWUSR
        self.path, self.fd = _made(final, mode)

    def _before(self, final: "Path") -> os.stat_result | None:
        """Returns the status of the file that is replaced, or None."""
        with suppress(FileNotFoundError):
            before = final.lstat() if self.replace else None
            return before if before and stat.S_ISREG(before.st_mode) else None
        return None

    def append(self, data: bytes) -> None:
        """Appends data after `fd` was closed."""
        fd = os.open(self.path, os.O_WRONLY | os.O_APPEND | _NO_LINK | AS_IT_IS)
        try:
            write_all(fd, data)
        finally:
            os.close(fd)

    @property
    def empty(self) -> bool:
        """True if nothing was written."""
        with suppress(OSError):
            return self.path.lstat().st_size == 0
        return True

    def complete(self, final: "Path | None" = None) -> None:
        """Renames the part to its file or to `final`. Raises FileExistsError if that exists, unless it is replaced."""
        final = final or self.final
        if before := self._before(final):
            if sys.platform != "win32":
                with suppress(OSError):  # the owner is kept by who may
                    os.chown(self.path, before.st_uid, before.st_gid)
            self.path.chmod(stat.S_IMODE(before.st_mode))
        if self.replace:
            self.path.replace(final)
            return
        try:
            os.link(self.path, final)
        except FileExistsError:
            raise
        except (OSError, AttributeError) as error:  # not every file system can
            if os.path.lexists(final):
                raise FileExistsError(str(final)) from error
            self.path.rename(final)
        else:
            self.path.unlink()

    def discard(self) -> None:
        """Removes the part."""
        self.path.unlink(missing_ok=True)


def _made(final: "Path", mode: int) -> "tuple[Path, int]":
    """Creates a new file beside another; returns its path and descriptor."""
    begin = os.fsdecode(os.fsencode(final.name)[:_LONGEST])
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | _NO_LINK | AS_IT_IS
    for left in reversed(range(_TRIES)):
        path = final.with_name(f"{begin}.{os.urandom(4).hex()}.part")
        try:
            return path, os.open(path, flags, mode)
        except FileExistsError:
            if not left:
                raise
    raise FileExistsError(str(final))


def write_all(fd: int, data: bytes) -> None:
    """Writes everything, also to a pipe that another program made non-blocking."""
    view = memoryview(data)
    while view:
        try:
            view = view[os.write(fd, view) :]
        except BlockingIOError:
            import select

            select.select([], [fd], [])


def in_place(name: str, *, force: bool, typed: bool) -> int:
    """Opens a file that is written under its final name; returns its descriptor.

    Raises FileExistsError if it may not be replaced. force: an existing file is opened, and keeps its content until it
    is truncated. typed: the name was given by the user, and links are followed; otherwise they are not.
    """
    flags = os.O_WRONLY | os.O_CREAT | AS_IT_IS | (0 if force else os.O_EXCL) | (0 if typed else _NO_LINK)
    return os.open(name, flags, 0o666)


def content(path: "Path") -> bytes:
    """Reads a file; OSError as the system has it, ConfigError where it is too large."""
    with path.open("rb") as file:
        read = file.read(MOST + 1)
    if len(read) > MOST:
        raise ConfigError("config.large", file=path, most=MOST >> 20)
    return read


def checked(path: "Path", read: Callable[[bytes, str], T], unreadable: str) -> T:
    """Returns a file as the core reads it; ConfigError for an error in it, `unreadable` if it cannot be opened."""
    from canalyze._core import SettingsError

    with as_error(ConfigError, unreadable, file=path):
        found = content(path)
    try:
        return read(found, str(path).encode("utf-8", "backslashreplace").decode())
    except SettingsError as error:
        key, facts = error.args
        raise ConfigError(key, **facts) from error


def short(text: str) -> str:
    """Returns a text as one line can show it."""
    return text if len(text) <= _SHOWN else text[: _SHOWN - 1] + "…"
