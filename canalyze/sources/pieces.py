"""Converts the bytes of a form that python-can reads in this process to records for the core.

A reader of that library reads lines from an open file, and an exception ends it. `Lines` takes the place of the file,
so that a bad line costs only itself: it knows the line that a message came from, and after an exception, reading
restarts with the next line. Must not: open a file, or report anything to the user.
"""

import re
import struct
from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final, TextIO, cast

from canalyze.sources import packed
from canalyze.sources.library import library
from canalyze.sources.packed import Packer, Unfit

if TYPE_CHECKING:
    pass


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
                self.number, line = 0, self._before.pop(0)
            elif lines:
                self.number, line = lines.popleft()
                self.answered = False
            else:
                return
            yield line

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


class CsvText:
    """python-can's own table: lines for its reader."""

    def __init__(self) -> None:
        """Creates the converter."""
        self._lines = Lines(self._change)
        self._frame = Packer(6, directed=False, bus=lambda _: "can0").frame
        self._out: list[bytes] = []
        """Records that have not been yielded yet."""
        self._lines.unanswered = lambda: self._out.append(self._unreadable(packed.NO_FRAME))
        self._reader = library().CSVReader(cast("TextIO", self._lines))

    @staticmethod
    def _change(line: str) -> str | None:
        if not line.isprintable() and is_damaged(line):
            return DAMAGED
        return None if line.startswith("timestamp,") and line.count(",") <= _COMMAS else line

    def feed(self, data: bytes) -> bytes:
        """Appends bytes; returns records."""
        self._lines.feed(data)
        return self._drained()

    def end(self, *, broken: bool) -> bytes:
        """Ends the input; returns the remaining records. broken: the file could not be unpacked further."""
        if not broken:
            self._lines.end()
        return self._drained()

    def _drained(self) -> bytes:
        """Reads the waiting lines; one that the library cannot read costs only itself."""
        lines, out = self._lines, self._out
        while lines.waiting:
            try:
                lines.begin("headings")
                for message in iter(self._reader):
                    lines.answered = True
                    try:
                        out.append(self._frame(message, lines.number))
                    except (Unfit, TypeError, struct.error) as error:
                        out.append(self._unreadable(error.reason if isinstance(error, Unfit) else packed.DATA))
            except Exception:  # of the line: its message says nothing that the line does not
                lines.answered = True
                out.append(self._unreadable(packed.NO_FRAME))
            lines.settle()
        records = b"".join(out)
        out.clear()
        return records

    def _unreadable(self, reason: int) -> bytes:
        """Returns the record for the last line, which cannot be read; one without line end was cut."""
        number = self._lines.number
        return packed.unreadable(packed.CUT_LINE if number == self._lines.endless else reason, number)
