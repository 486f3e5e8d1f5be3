"""Opens an input by name: unpacks it, detects its format, and yields bytes that the core reads.

The reading loop gets a `Capture`: its name, its format for the core, and `read`, which returns b"" at the end. Only
formats are known here, not their content.
"""

from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources.compressed import COMPRESSIONS, Damage, Layer, Transcoded, Unpacked
from canalyze.sources.file import Memory, Source

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from canalyze.sources.bridge.reading import Bridged

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
