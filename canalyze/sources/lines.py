"""Feeds lines of a text format to python-can's readers one at a time, so that a bad line costs only itself.

A reader of that library reads lines from an open file, and an exception ends it. `Lines` takes the place of the
file and knows the line that a message came from; after an exception, reading restarts with the next line.
Must not: import python-can.
"""

import re
from collections import deque
from collections.abc import Callable, Iterator
from typing import Final

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
