"""Converts the bytes of a form that python-can reads in this process to records for the core.

A reader of that library reads lines from an open file, and an exception ends it. `Lines` takes the place of the file,
so that a bad line costs only itself: it knows the line that a message came from, and after an exception, reading
restarts with the next line. Must not: open a file, or report anything to the user.
"""

import re
import struct
from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final, Protocol, TextIO, cast

from canalyze.sources import packed
from canalyze.sources.library import library
from canalyze.sources.packed import Packer, Unfit

if TYPE_CHECKING:
    from can import Message

    from canalyze.sources.pythoncan import PythonCanCapture


_LONGEST: Final = 64 << 10
"""Maximum length of a line; these formats have no longer ones."""
_CONTROL: Final = re.compile(r"[\0-\x08\x0a-\x1f\x7f]")
"""Control characters that no text line contains, as in a block of zeros."""
DAMAGED: Final = "\0"
"""Replaces a line with such characters; no reader accepts it."""


class Lines:
    """Bytes in, whole lines out; a reader takes this for an open text file."""

    def __init__(self, change: Callable[[str], str | None]) -> None:
        """Creates an empty sequence of lines.

        change: returns the text that replaces a line, or None to leave it out.
        """
        self.number = 0
        """The number of the last line from 1; 0 before the first, and for a line that is not from the file."""
        self.line = ""
        self.answered = True
        """True if the reader made something of the last line."""
        self.endless = 0
        """The number of a last line without line end, which may be cut."""
        self.unanswered: Callable[[], None] = lambda: None
        """Called if another line is wanted and the reader made nothing of the last one."""
        self._change = change
        self._lines: deque[tuple[int, str]] = deque()
        self._before: list[str] = []
        self._rest = ""
        self._taken = 0
        self._long = False

    def feed(self, data: bytes) -> None:
        """Appends bytes."""
        *whole, rest = (self._rest + data.decode("latin-1")).split("\n")
        if self._long and whole:
            whole[0], self._long = "\0", False
        self._add(whole)
        self._rest = rest
        if len(rest) > _LONGEST:
            self._rest, self._long = "", True

    def end(self) -> None:
        """Ends the input; a last line without line end is read as well."""
        if self._rest or self._long:
            self._add(["\0" if self._long else self._rest])
            self.endless = self._taken
            self._rest, self._long = "", False

    def _add(self, lines: list[str]) -> None:
        change, append = self._change, self._lines.append
        if lines and self._taken == 0:
            lines[0] = lines[0].removeprefix("\xef\xbb\xbf")
        for number, line in enumerate(lines, self._taken + 1):
            text = line.strip() if len(line) <= _LONGEST else "\0"
            changed = change(text) if text else None
            if changed is not None:
                append((number, changed))
        self._taken += len(lines)

    def begin(self, *lines: str) -> None:
        """Inserts lines before the waiting ones."""
        self._before = [*lines]

    @property
    def waiting(self) -> bool:
        """True if a line of the file is waiting."""
        return bool(self._lines)

    def __iter__(self) -> Iterator[str]:
        """Yields the waiting lines; the reader sees their end as the end of the file."""
        lines = self._lines
        while True:
            if not self.answered:
                self.settle()
            if self._before:
                self.number, self.line = 0, self._before.pop(0)
            elif lines:
                self.number, self.line = lines.popleft()
                self.answered = False
            else:
                return
            yield self.line

    def __next__(self) -> str:
        """Returns the next line."""
        return next(iter(self))

    def settle(self) -> None:
        """Reports the last line if the reader made nothing of it."""
        if not self.answered:
            self.answered = True
            self.unanswered()

    def close(self) -> None:
        """Does nothing, because a reader closes its file at the end and this one is read further."""


def is_damaged(line: str) -> bool:
    """Returns true if a line contains control characters. Printable lines need no check."""
    return _CONTROL.search(line) is not None


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
