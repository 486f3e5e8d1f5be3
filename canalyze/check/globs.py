"""Globs of file names, matched in one pass over the name: whatever a glob says, there is no way back and no way twice.

`*` and `?` stay within a directory, `**` does not, `**/` goes through any number of directories, `[a-z]` and `[!a-z]`
are one character. Must not: open a file, or know which names there are.
"""

import re
from functools import cache
from typing import Final

_PIECE: Final = re.compile(r"((?:\*\*/)+|\*\*|\*|\?|\[!?\]?[^\]]*\])")


class Glob:
    """A glob as the states that a name leads through: of each state a bit says how it goes on."""

    def __init__(self, glob: str) -> None:
        """Read it; what looks like a set of characters and is none stands for itself."""
        self._literals: dict[str, int] = {}
        """States that take one character, and lead to the next state."""
        self._sets: list[tuple[re.Pattern[str], int]] = []
        self._any = self._inside = 0
        """States that take any character, and any but a slash."""
        self._stays = self._skips = self._opens = self._closes = 0
        """States that stay as they are by what they take; that need take nothing; from which directories may be left
        out; that lead on by a slash."""
        self._end = 1
        try:
            for place, piece in enumerate(_PIECE.split(glob)):
                self._read(piece) if place % 2 else self._plain(piece)
        except re.error:  # [z-a]
            self._literals, self._sets, self._end = {}, [], 1
            self._any = self._inside = self._stays = self._skips = self._opens = self._closes = 0
            self._plain(glob)

    def _plain(self, text: str) -> None:
        for char in text:
            self._literals[char] = self._literals.get(char, 0) | self._end
            self._end <<= 1

    def _read(self, piece: str) -> None:
        state, self._end = self._end, self._end << 1
        if piece.startswith("["):
            inner = piece[1:-1]
            members = re.sub(r"([\\\[\]^&~|])", r"\\\1", inner.removeprefix("!"))
            self._sets.append((re.compile(f"[^{members}]" if inner.startswith("!") else f"[{members}]"), state))
        elif piece == "?":
            self._inside |= state
        elif piece.endswith("/"):
            inner_state, self._end = self._end, self._end << 1
            self._skips |= state
            self._opens |= state
            self._any |= inner_state
            self._stays |= inner_state
            self._closes |= inner_state
        else:
            self._skips |= state
            self._stays |= state
            if piece == "**":
                self._any |= state
            else:
                self._inside |= state

    def _taking(self, char: str) -> int:
        """Give the states that take a character."""
        found = self._literals.get(char, 0) | self._any | (0 if char == "/" else self._inside)
        for members, state in self._sets:
            if members.match(char):
                found |= state
        return found

    def _reached(self, states: int) -> int:
        """Give the states, and those that they lead to without a character."""
        while (more := states | (states & self._skips) << 1 | (states & self._opens) << 2) != states:
            states = more
        return states

    def names(self, name: str) -> bool:
        """Tell whether it is about all of a name."""
        states = self._reached(1)
        for char in name:
            taking = states & self._taking(char)
            states = taking & self._stays | (taking & ~self._stays) << 1
            if char == "/":
                states |= (taking & self._closes) << 1
            if not states:
                return False
            states = self._reached(states)
        return bool(states & self._end)


@cache
def glob(text: str) -> Glob:
    """Give a glob, read once."""
    return Glob(text)
