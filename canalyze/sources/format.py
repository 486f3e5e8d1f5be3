"""From a name to bytes that the core reads: opened, and the format told by its first bytes.

What a loop sees is a `Capture`: its name, its format for the core, and `read` until nothing comes. Only formats are
known here; what is in them is not.
"""

import shlex
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources.file import Source

if TYPE_CHECKING:
    from canalyze.sources.pythoncan import PythonCanCapture

BRIDGED: Final = {"blf": "blf", "trc": "trc", "mf4": "mf4", "csv": "csv", "db": "sqlite"}
"""What python-can reads: the names of --input-format, and what the core's sniff calls them."""

_PROGRAMS: Final = {"gzip": "zcat", "xz": "xzcat", "zstd": "zstdcat", "bzip2": "bzcat"}
"""What undoes a compression."""
_TITLES: Final = {"asc": "Vector ASC", "blf": "Vector BLF", "mcap": "MCAP"}
"""How a format is called in a sentence, where it is not called by its name."""


class Capture:
    """An open input whose format is known; a context manager."""

    def __init__(self, source: Source, head: bytes, form: str) -> None:
        """Take over the source; `head` is what was read of it already."""
        self.name = source.name
        self.format = form
        """One of the core's FORMATS."""
        self.regular = source.regular
        """Whether it is a file of known end, not a pipe, a terminal or a device."""
        self._source = source
        self._head: bytes | None = head

    @property
    def taken(self) -> int:
        """Bytes of the file behind it that have been read: what progress counts."""
        return self._source.taken

    def read(self) -> bytes:
        """Give the next bytes, b"" at the end; SourceError if the system refuses."""
        if self._head is not None:
            head, self._head = self._head, None
            return head
        return self._source.read()

    def remarks(self) -> list[CanalyzeError]:
        """Give what is to be told of the file since the last call: of bytes there is nothing."""
        return []

    def __enter__(self) -> Self:
        """Give the capture itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Close it."""
        self._source.close()


def open_capture(name: str, command: str, asked: str | None = None) -> "Capture | PythonCanCapture":
    """Open the input of that name ('-' is standard input) and find out what it is; SourceError if that cannot be.

    command: what was typed, such as `canalyze decode`, for advice. asked: the format that the user says it has.
    """
    from canalyze._core import FORMATS, sniff

    source = Source(name)
    try:
        head, form = source.read(), asked
        while form is None:
            form = sniff(head, False)
            if form is None:
                more = source.read()
                form = None if more else sniff(head, True)
                head += more
        form = BRIDGED.get(form, form)
        if form in BRIDGED.values():
            from canalyze.sources.pythoncan import PythonCanCapture

            return PythonCanCapture(source, head, form)
        if form not in FORMATS:
            raise _refused(source.name, form, command)
        return Capture(source, head, form)
    except BaseException:
        source.close()
        raise


def _refused(name: str, form: str, command: str) -> SourceError:
    file = "" if name == "stdin" else f" {shlex.quote(name)}"
    if form in _PROGRAMS:
        return SourceError("source.packed", name=name, kind=form, line=f"{_PROGRAMS[form]}{file} | {command} -")
    if form.startswith("utf-16"):
        line = f"iconv -f {form.upper()} -t UTF-8{file} | {command} -"
        return SourceError("source.encoded", name=name, kind=form.upper(), line=line)
    return SourceError("source.other", name=name, kind=_TITLES.get(form, form))
