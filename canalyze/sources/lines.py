"""Lines of a text format for python-can's readers, one line at a time, so that one bad line costs only itself.

A reader of that library reads lines from an open file, and an exception in one ends it. Here it gets the lines through
`Lines`, which knows which line a message came from; behind one that raised, reading begins anew with the next. Must
not: import python-can.
"""

import re
from collections import deque
from collections.abc import Callable, Iterator
from typing import Final

_LONGEST: Final = 64 << 10
"""Longest line that is read; a longer one is none of these formats'."""
_CONTROL: Final = re.compile(r"[\0-\x08\x0a-\x1f\x7f]")
"""Bytes that no line of text has within it: a block of zeros, a newline that became something else."""
DAMAGED: Final = "\0"
"""What is handed out in place of a line with such bytes: no reader takes it for one of its lines."""


class Lines:
    """Bytes in, whole lines out, to a reader that takes this for an open text file."""

    def __init__(self, change: Callable[[str], str | None]) -> None:
        """Change: what a line becomes before it is handed out; None leaves it out."""
        self.number = 0
        """Of the line that was handed out last, from 1; 0 before the first and for what no line of the file is."""
        self.line = ""
        self.answered = True
        """Something came of the last line."""
        self.endless = 0
        """The number of a last line that lacks its end, and may be cut."""
        self.unanswered: Callable[[], None] = lambda: None
        """Called when a further line is wanted, and nothing came of the last one."""
        self._change = change
        self._lines: deque[tuple[int, str]] = deque()
        self._before: list[str] = []
        self._rest = ""
        self._taken = 0
        self._long = False

    def feed(self, data: bytes) -> None:
        """Take the next bytes."""
        *whole, rest = (self._rest + data.decode("latin-1")).split("\n")
        if self._long and whole:
            whole[0], self._long = "\0", False
        self._add(whole)
        self._rest = rest
        if len(rest) > _LONGEST:
            self._rest, self._long = "", True

    def end(self) -> None:
        """Take the end: a last line may lack its end."""
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
        """Have these handed out before what is there."""
        self._before = [*lines]

    @property
    def waiting(self) -> bool:
        """Whether a line of the file is there."""
        return bool(self._lines)

    def __iter__(self) -> Iterator[str]:
        """Give what is there; its end is the end of the file to whoever reads."""
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
        """Give the next line alone."""
        return next(iter(self))

    def settle(self) -> None:
        """Say of the last line that nothing came of it, if so."""
        if not self.answered:
            self.answered = True
            self.unanswered()

    def close(self) -> None:
        """Do nothing: the reader closes what it has read to the end, and this is read on."""


def is_damaged(line: str) -> bool:
    """Tell whether a line has bytes that no text has. Of a line that is printable it need not be asked."""
    return _CONTROL.search(line) is not None
