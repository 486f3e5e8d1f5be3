"""From a name to bytes that the core reads: opened, unpacked, and the format told by the first bytes.

What a loop sees is a `Capture`: its name, its format for the core, and `read` until nothing comes. Only formats are
known here; what is in them is not.
"""

from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources.compressed import Damage, Layer, Transcoded, Unpacked
from canalyze.sources.compression import COMPRESSIONS
from canalyze.sources.file import Source

if TYPE_CHECKING:
    from pathlib import Path

    from canalyze.sources.memory import Memory
    from canalyze.sources.pythoncan import PythonCanCapture

BRIDGED: Final = {"mf4": "mf4", "csv": "csv", "db": "sqlite"}
"""What python-can reads: the names of --input-format, and what the core's sniff calls them."""

_SIGN: Final = 6
"""Bytes that tell a compression, whatever they are."""


def input_formats() -> tuple[str, ...]:
    """Give the names of the formats that can be read."""
    from canalyze._core import FORMATS

    return (*FORMATS, *BRIDGED)


class _PutBack:
    """A layer with the bytes that were looked at before it again."""

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


class Opened:
    """A source, what is in it where it is compressed or of another encoding, and its first bytes."""

    def __init__(self, source: "Source | Memory") -> None:
        """Take over the source and read its first bytes."""
        self.name = source.name
        self.regular = source.regular
        """Whether it is a file of known end, not a pipe, a terminal or a device."""
        self.compression: str | None = None
        """gzip, xz, bzip2 or zstd, if it is compressed."""
        self._source = source
        self._layer: Layer = source
        self._unpacked: Unpacked | None = None
        self.head = source.read()
        """What was read already."""

    @property
    def taken(self) -> int:
        """Bytes of the file that have been read."""
        return self._source.taken

    @property
    def damage(self) -> Damage | None:
        """Why the file could be unpacked no further; known when nothing comes any more."""
        return self._layer.damage

    @property
    def begins(self) -> bool:
        """Whether the bytes given last are the first that a new check sum covers."""
        return self._layer.begins

    @property
    def checked(self) -> bool | None:
        """Whether all that was unpacked so far has a check sum; None: nothing is."""
        return self._unpacked.checked if self._unpacked else None

    @property
    def path(self) -> "Path | None":
        """The file itself, for a reader that opens by name; None where it is a pipe, or something in it is read."""
        return self._source.path if self._layer is self._source else None

    def read(self) -> bytes:
        """Give what comes after the head, b"" at the end; SourceError if the system refuses."""
        return self._layer.read()

    def rests(self) -> bool:
        """Tell whether nothing more comes at the moment, though it is not over."""
        return self._source.rests()

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def unpack(self, form: str) -> None:
        """Read what is in it, by the name of its compression."""
        self.compression = form
        self._unpacked = Unpacked(_PutBack(self.head, self._layer), form)
        self._under(self._unpacked)

    def transcode(self, encoding: str) -> None:
        """Read it as UTF-8."""
        self._under(Transcoded(_PutBack(self.head, self._layer), encoding))

    def _under(self, layer: Layer) -> None:
        self._layer = layer
        self.head = layer.read()

    def told(self, asked: str | None) -> str:
        """Give the name of what the bytes are; where the format is given, no more than their wrapping is looked for."""
        from canalyze._core import sniff

        while True:
            form = sniff(self.head, False)
            if form is None and asked and len(self.head) >= _SIGN:
                return asked
            if form is not None:
                return form
            if self.head.endswith(b"\n") and self.rests() and sniff(self.head, True) == "rows":
                return "rows"  # a pipe has come to a rest, and what waits for lines of another format is to be shown
            more = self._layer.read()
            if not more:
                return sniff(self.head, True) or "candump"
            self.head += more


class Capture:
    """An open input whose format is known; a context manager."""

    def __init__(self, source: Opened, form: str) -> None:
        """Take over what was opened."""
        self.name = source.name
        self.format = form
        """One of the core's FORMATS."""
        self.kind = form
        """The name of its format."""
        self.compression = source.compression
        """gzip, xz, bzip2 or zstd, if it is compressed."""
        self.regular = source.regular
        """Whether it is a file of known end, not a pipe, a terminal or a device."""
        self._source = source
        self.head = source.head
        """The first bytes."""
        self._head = source.head
        self._behind_head = False

    @property
    def taken(self) -> int:
        """Bytes of the file behind it that have been read: what progress counts."""
        return self._source.taken

    @property
    def damage(self) -> Damage | None:
        """Why the file could be unpacked no further; known when nothing comes any more."""
        return self._source.damage

    @property
    def begins(self) -> bool:
        """Whether the bytes given last are the first that a new check sum covers."""
        return self._source.begins if self._behind_head else self.compression is not None

    @property
    def checked(self) -> bool | None:
        """Whether all that was unpacked so far has a check sum; None: nothing is."""
        return self._source.checked

    def read(self) -> bytes:
        """Give the next bytes, b"" at the end; SourceError if the system refuses."""
        head, self._head = self._head, b""
        self._behind_head = not head
        return head or self._source.read()

    def rests(self) -> bool:
        """Tell whether nothing more comes at the moment, though it is not over."""
        return not self._head and self._source.rests()

    def remarks(self) -> list[CanalyzeError]:
        """Give what is to be told of the file since the last call: of bytes there is nothing."""
        return []

    def __enter__(self) -> Self:
        """Give the capture itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Close it."""
        self._source.close()


def open_capture(name: str, asked: str | None = None, shown: str | None = None) -> "Capture | PythonCanCapture":
    """Open the input of that name ('-' is standard input) and find out what it is; SourceError if that cannot be.

    asked: the format that the user says it has, or that what is compressed in it has. shown: its name for people.
    """
    return identified(Source(name, shown), asked)


def identified(source: "Source | Memory", asked: str | None = None) -> "Capture | PythonCanCapture":
    """Find out what a source is, by whatever wrapping; it is closed where that cannot be, which is a SourceError."""
    from canalyze._core import FORMATS

    try:
        opened = Opened(source)
        form = opened.told(asked)
        if form in COMPRESSIONS:
            opened.unpack(form)
            inner = opened.told(asked)
            if inner in COMPRESSIONS:
                raise SourceError("source.nested", name=source.name, outer=form, inner=inner)
            form = inner
        if form.startswith("utf-16") or form == "gbk":
            opened.transcode(form)
            form = opened.told(asked)
        form = asked or form
        form = BRIDGED.get(form, form)
        if form in BRIDGED.values():
            from canalyze.sources.pythoncan import PythonCanCapture

            return PythonCanCapture(opened, opened.head, form, asked=asked is not None)
        if form not in FORMATS:
            raise SourceError("source.other", name=source.name, kind=form)
        return Capture(opened, form)
    except BaseException:
        source.close()
        raise
