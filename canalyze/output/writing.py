"""How files come to be: each is written as a part beside its name, which it gets when it is complete.

A part is made anew, in the folder of its file, under a random name that ends in `.part`: a link that somebody has laid
there is not followed, and two runs at once never write into one file. What is written live stands under its name from
the beginning instead (`in_place`), so that a killed process leaves what it has seen. Must not: know what is written, or
word an error; what cannot be is an OSError.
"""

import os
import stat
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from pathlib import Path

AS_IT_IS: Final = getattr(os, "O_BINARY", 0)
"""Where the system would else translate line ends."""
_NO_LINK: Final = getattr(os, "O_NOFOLLOW", 0)
_TRIES: Final = 100
"""Random names that are tried: one is taken once in four thousand million."""
_LONGEST: Final = 200
"""Bytes of a file's name that its part has: names end at 255."""


class Part:
    """A file on its way."""

    def __init__(self, final: "Path", *, replace: bool) -> None:
        """Make the part of `final`. replace: a file of that name gives way, and leaves its mode and its owner."""
        self.final = final
        self.replace = replace
        before = self._before(final)
        # What nobody else may read may not be read meanwhile either.
        mode = 0o666 if before is None else stat.S_IMODE(before.st_mode) & 0o777 | stat.S_IWUSR
        self.path, self.fd = _made(final, mode)

    def _before(self, final: "Path") -> os.stat_result | None:
        """Give what is known of the file that gives way; None where there is none."""
        with suppress(FileNotFoundError):
            before = final.lstat() if self.replace else None
            return before if before and stat.S_ISREG(before.st_mode) else None
        return None

    def append(self, data: bytes) -> None:
        """Write behind what is there, once `fd` is closed."""
        fd = os.open(self.path, os.O_WRONLY | os.O_APPEND | _NO_LINK | AS_IT_IS)
        try:
            write_all(fd, data)
        finally:
            os.close(fd)

    @property
    def empty(self) -> bool:
        """Whether nothing was written."""
        with suppress(OSError):
            return self.path.lstat().st_size == 0
        return True

    def complete(self, final: "Path | None" = None) -> None:
        """Give it its name, or another one; FileExistsError where a file has that, and is not to be replaced."""
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
        """Take it away."""
        self.path.unlink(missing_ok=True)


def _made(final: "Path", mode: int) -> "tuple[Path, int]":
    """Make a file that nobody has, beside another; give its name and its descriptor."""
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
    """Write everything, also to a pipe that another program made non-blocking."""
    view = memoryview(data)
    while view:
        try:
            view = view[os.write(fd, view) :]
        except BlockingIOError:
            import select

            select.select([], [fd], [])


def in_place(name: str, *, force: bool, typed: bool) -> int:
    """Open a file that is written where it stands; give its descriptor. FileExistsError where it may not be replaced.

    force: one that exists is opened, and keeps what it holds until it is cut. typed: the name is the user's own, and
    a link stands for what it points to; one that we have made up is none.
    """
    flags = os.O_WRONLY | os.O_CREAT | AS_IT_IS | (0 if force else os.O_EXCL) | (0 if typed else _NO_LINK)
    return os.open(name, flags, 0o666)
