"""Converts the bytes of a form that python-can reads in this process to records for the core.

Text is passed to its reader line by line (`lines`). Must not: open a file, or report anything to the user.
"""

import struct
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, Protocol, TextIO, cast

from canalyze.sources import packed
from canalyze.sources.library import library
from canalyze.sources.lines import DAMAGED, Lines, is_damaged
from canalyze.sources.packed import Packer, Unfit

if TYPE_CHECKING:
    from can import Message

    from canalyze.sources.pythoncan import PythonCanCapture

_COMMAS: Final = 6
"""Number of commas in a row of python-can's table."""


class Pieces(Protocol):
    """A converter for the bytes of one form."""

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Appends bytes; yields records."""

    def end(self, *, broken: bool) -> Iterator[bytes]:
        """Ends the input; yields the remaining records. broken: the file could not be unpacked further."""


def as_numbered(channel: object) -> str:
    """Returns the bus name of a numbered channel."""
    return f"can{channel}" if isinstance(channel, int) else "can0"


def only(_: object) -> str:
    """Returns the bus name of a form without channels."""
    return "can0"


class Text:
    """Lines for one of python-can's readers of text."""

    def __init__(self, capture: "PythonCanCapture", lines: Lines, packer: Packer) -> None:
        """Creates the converter for a capture; `lines` prepares its lines for the library."""
        self.lines = lines
        self.packer = packer
        self.capture = capture
        self.out: list[bytes] = []
        """Records that have not been yielded yet."""
        lines.unanswered = self._unanswered

    def reader(self) -> "Iterator[Message]":
        """Returns a reader that continues with the next line."""
        raise NotImplementedError

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Appends bytes; yields records."""
        self.lines.feed(data)
        yield from self.drain()

    def end(self, *, broken: bool) -> Iterator[bytes]:
        """Ends the input; yields the remaining records."""
        if not broken:
            self.lines.end()
        yield from self.drain()

    def drain(self) -> Iterator[bytes]:
        """Reads the waiting lines; one that the library cannot read costs only itself."""
        lines, frame = self.lines, self.packer.frame
        out = self.out
        append = out.append
        while lines.waiting:
            try:
                for message in self.reader():
                    lines.answered = True
                    try:
                        append(frame(message, lines.number))
                    except (Unfit, TypeError, struct.error) as error:
                        reason = error.reason if isinstance(error, Unfit) else packed.DATA
                        out.append(self._unreadable(reason))
            except Exception:  # of the line: its message says nothing that the line does not
                lines.answered = True
                out.append(self._unreadable(packed.NO_FRAME))
            lines.settle()
        yield b"".join(out)
        out.clear()

    def _unanswered(self) -> None:
        self.out.append(self.nothing())

    def nothing(self) -> bytes:
        """Returns the record of a line without a message."""
        return self._unreadable(packed.NO_FRAME)

    def _unreadable(self, reason: int) -> bytes:
        """Returns the record for the last line, which cannot be read; one without line end was cut."""
        number = self.lines.number
        return packed.unreadable(packed.CUT_LINE if number == self.lines.endless else reason, number)


class CsvText(Text):
    """python-can's own table."""

    def __init__(self, capture: "PythonCanCapture") -> None:
        """Creates the converter for a capture."""
        super().__init__(capture, Lines(self._change), Packer(6, directed=False, bus=only))
        self._reader = library().CSVReader(cast("TextIO", self.lines))

    @staticmethod
    def _change(line: str) -> str | None:
        if not line.isprintable() and is_damaged(line):
            return DAMAGED
        return None if line.startswith("timestamp,") and line.count(",") <= _COMMAS else line

    def reader(self) -> "Iterator[Message]":
        """Returns a reader that continues with the next line."""
        self.lines.begin("headings")
        return iter(self._reader)
