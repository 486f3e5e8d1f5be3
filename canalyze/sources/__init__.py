"""Sources of captures: an input is opened by name, unpacked, its format detected, its bytes yielded to the core.

compressed.py  the content of compressed bytes, and text of another encoding; the compressions
names.py       names of captures, and captures that are parts of one recording
bridge/        formats and adapters of python-can, and its messages
live.py        live buses as an input: socketcan.py (with netdevices.py), bridge/buses.py, replay.py of captures

`Source` and `Memory` are files, pipes, standard input and captures in memory as bytes. `read` returns the result of one
read(2), at most 1 MiB, so that a line of a pipe is answered when it comes. The reading loop gets a `Capture`: its name,
its format for the core, and `read`, which returns b"" at the end. Only formats are known here, not their content: no
source knows the meaning of a frame.
"""

import errno
import os
import re
import stat
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources.compressed import COMPRESSIONS, Damage, Layer, Transcoded, Unpacked

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from canalyze.sources.bridge.reading import Bridged

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


BRIDGED: Final = {"mf4": "mf4", "csv": "csv", "db": "sqlite"}
"""Formats that python-can reads: the names of --input-format, and the core's names for them."""

_SIGN: Final = 6
"""Number of bytes that suffices to recognize any compression."""


def input_formats() -> tuple[str, ...]:
    """Returns the names of the formats that can be read."""
    from canalyze._core import FORMATS

    return (*FORMATS, *BRIDGED)


class _PutBack:
    """A layer that returns its first bytes again."""

    def __init__(self, head: bytes, below: Layer) -> None:
        self._head = head
        self._below = below

    @property
    def damage(self) -> Damage | None:
        return self._below.damage

    @property
    def begins(self) -> bool:
        return self._below.begins

    def read(self) -> bytes:
        head, self._head = self._head, b""
        return head or self._below.read()


class Capture:
    """An open input; a context manager."""

    def __init__(self, source: Source | Memory, form: str = "") -> None:
        """Takes ownership of the source and reads its first bytes; `form` is the format, if it is known."""
        self.name = source.name
        self.format = form
        """One of the core's FORMATS, or "packed"."""
        self.regular = source.regular
        """True for a regular file, false for a pipe, a terminal or a device."""
        self.compression: str | None = None
        """gzip, xz, bzip2 or zstd; None if it is not compressed."""
        self._source = source
        self._layer: Layer = source
        self._unpacked: Unpacked | None = None
        self._bridged: Bridged | None = None
        self._kind = ""
        self.head = source.read()
        """The first bytes, unpacked and decoded."""
        self._begun = self._behind_head = False

    @property
    def kind(self) -> str:
        """The name of its format."""
        return self._kind or self.format

    @property
    def taken(self) -> int:
        """Number of bytes of the file that have been read, for the progress display."""
        return self._source.taken

    @property
    def damage(self) -> Damage | None:
        """The damage that ended the data, if any; known at the end."""
        return self._layer.damage

    @property
    def begins(self) -> bool:
        """True if the bytes returned last are the first that a new checksum covers."""
        return self.compression is not None and (self._layer.begins or not self._behind_head)

    @property
    def checked(self) -> bool | None:
        """True if everything unpacked so far has a checksum; None if the file is not compressed."""
        return self._unpacked.checked if self._unpacked else None

    @property
    def path(self) -> "Path | None":
        """The file itself, for a reader that opens by name; None for a pipe, and for unpacked or transcoded data."""
        return self._source.path if self._layer is self._source else None

    def read(self) -> bytes:
        """Returns the next bytes, the head first, b"" at the end. Raises SourceError if the system refuses."""
        self._behind_head = self._begun or not self.head
        self._begun = True
        return self._layer.read() if self._behind_head else self.head

    def rests(self) -> bool:
        """Returns true if nothing arrives at the moment, though the data has not ended."""
        return not self._bridged and (self._begun or not self.head) and self._source.rests()

    def remarks(self) -> list[CanalyzeError]:
        """Returns the remarks of python-can since the last call; there are none on plain bytes."""
        return self._bridged.remarks() if self._bridged else []

    def close(self) -> None:
        """Closes the source."""
        if self._bridged:
            self._bridged.close()
        self._source.close()

    def __enter__(self) -> Self:
        """Returns the capture."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Closes the capture."""
        self.close()

    def unpack(self, form: str) -> None:
        """Unpacks the data, by the name of its compression, before any was read."""
        self.compression = form
        self._unpacked = Unpacked(_PutBack(self.head, self._layer), form)
        self._under(self._unpacked)

    def transcode(self, encoding: str) -> None:
        """Decodes the data to UTF-8, before any was read."""
        self._under(Transcoded(_PutBack(self.head, self._layer), encoding))

    def bridge(self, form: str, formats: "Sequence[str]" = ()) -> None:
        """Reads the data through python-can, before any was read; `form` is one of BRIDGED.

        formats: those to choose from, if the user has given the form. Raises SourceError if a package is not installed.
        """
        from canalyze.sources.bridge.reading import Bridged

        below = _PutBack(self.head, self._layer)
        self._layer = self._bridged = Bridged(below, self.name, form, self.path, formats=formats)
        self.format, self._kind, self.head = "packed", form, b""

    def _under(self, layer: Layer) -> None:
        self._layer = layer
        self.head = layer.read()

    def told(self, asked: str | None) -> str:
        """Returns the detected format; if `asked` is given, only compression and encoding are detected."""
        from canalyze._core import sniff

        while True:
            form = sniff(self.head, False)
            if form is None and asked and len(self.head) >= _SIGN:
                return asked
            if form is not None:
                return form
            if self.head.endswith(b"\n") and self._source.rests() and sniff(self.head, True) == "rows":
                return "rows"  # a pipe has come to a rest, and what waits for lines of another format is to be shown
            more = self._layer.read()
            if not more:
                return sniff(self.head, True) or "candump"
            self.head += more


def open_capture(name: str, asked: str | None = None, shown: str | None = None) -> Capture:
    """Opens the input of that name ('-' is standard input) and detects its format.

    asked: the format given by the user, also that of compressed data. shown: the name in messages. Raises SourceError
    if it cannot be opened or read.
    """
    return identified(Source(name, shown), asked)


def identified(source: Source | Memory, asked: str | None = None) -> Capture:
    """Detects the format of a source, also if it is compressed or of another encoding.

    Closes the source and raises SourceError if it cannot be read.
    """
    from canalyze._core import FORMATS

    try:
        capture = Capture(source)
        form = capture.told(asked)
        if form in COMPRESSIONS:
            capture.unpack(form)
            inner = capture.told(asked)
            if inner in COMPRESSIONS:
                raise SourceError("source.nested", name=source.name, outer=form, inner=inner)
            form = inner
        if form.startswith("utf-16") or form == "gbk":
            capture.transcode(form)
            form = capture.told(asked)
        form = asked or form
        form = BRIDGED.get(form, form)
        if form in BRIDGED.values():
            capture.bridge(form, input_formats() if asked else ())
        elif form in FORMATS:
            capture.format = form
        else:
            raise SourceError("source.other", name=source.name, kind=form)
        return capture
    except BaseException:
        source.close()
        raise
