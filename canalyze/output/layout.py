"""Text on a terminal: its width, padding, line breaks, and lists of definitions.

A Chinese character takes two columns, and a line does not begin with its punctuation. Must not: know the content.
"""

import unicodedata
from collections.abc import Iterable, Sequence
from typing import Final

_OPENING: Final = "（“‘《"
_CLOSING: Final = "，。；：、？！）”’》,.;:?!)"


def width(text: str) -> int:
    """Returns the columns that a text takes on a terminal."""
    if text.isascii():
        return len(text)
    return sum(0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def pad(text: str, columns: int, *, right: bool = False) -> str:
    """Pads a text to `columns`, on its right side or, for numbers, on its left."""
    blanks = " " * (columns - width(text))
    return blanks + text if right else text + blanks


def wrap(text: str, columns: int) -> list[str]:
    """Breaks a text into lines between words or Chinese characters, but not before their punctuation."""
    lines = [""]
    for piece in _pieces(text):
        if lines[-1] and width(lines[-1]) + width(piece.rstrip()) > columns:
            lines[-1] = lines[-1].rstrip()
            lines.append("")
        lines[-1] += piece
    lines[-1] = lines[-1].rstrip()
    return lines


def folded(text: str, columns: int) -> list[str]:
    """Breaks a text into lines as `wrap` does, and also within long words."""
    lines = []
    for line in wrap(text, columns):
        piece = ""
        room = columns
        for char in line:
            if width(char) > room:
                lines.append(piece)
                piece, room = "", columns
            piece += char
            room -= width(char)
        lines.append(piece)
    return lines


def definitions(
    rows: Sequence[tuple[str, str]], *, left: int | None = None, columns: int | None = None, margin: int = 2
) -> list[str]:
    """Lays out terms with their texts beside them; a term wider than `left` gets a line of its own.

    columns: the width at which lines are broken; None: nowhere.
    """
    if left is None:
        left = max((width(term) for term, _ in rows), default=0)
    indent = " " * (margin + left + 2)
    lines = []
    for term, text in rows:
        first, *rest = [text] if columns is None else wrap(text, columns - len(indent))
        if width(term) > left:
            lines += [" " * margin + term, indent + first]
        else:
            lines.append((" " * margin + pad(term, left) + "  " + first).rstrip())
        lines += [indent + line for line in rest]
    return lines


def _pieces(text: str) -> Iterable[str]:
    """Yields the pieces of a text between which a line may end."""
    piece = ""
    for char in text:
        if piece and _may_part(piece[-1], char):
            yield piece
            piece = ""
        piece += char
    if piece:
        yield piece


def _may_part(before: str, after: str) -> bool:
    if after in _CLOSING or after == " " or before in _OPENING:
        return False
    return before == " " or width(before) == 2 or width(after) == 2
