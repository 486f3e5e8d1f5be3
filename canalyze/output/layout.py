"""Text on a terminal: its width, padding, line breaks, and lists of definitions.

A Chinese character takes two columns, and a line does not begin with its punctuation. `hanging` breaks lines of a
listing with a hanging indent: continuation lines of an annotation begin below its first word, those of a comment are
comments, and colours continue. Must not: know the content.
"""

import re
import unicodedata
from collections.abc import Iterable, Sequence
from typing import Final

_COLOUR: Final = re.compile("\x1b\\[([0-9;]*)m")
_PLAIN: Final = "\x1b[0m"
_MARK: Final = "  # "
_LEAST: Final = 30
"""Minimum columns for an annotation beside its frame; with less it continues below."""
_INDENT: Final = 4
"""Additional indent below any other line."""
_NARROW: Final = 20
"""Maximum columns of a terminal for which lines are not broken."""
_COMMENT: Final = "#     "


def hanging(lines: bytes, columns: int) -> bytes:
    """Returns the lines so that none is wider than `columns`."""
    if columns <= _NARROW:
        return lines
    text = lines.decode("utf-8", "backslashreplace")
    return "\n".join(_broken(line, columns) for line in text.split("\n")).encode("utf-8", "backslashreplace")


def _broken(line: str, columns: int) -> str:
    """Returns a line without its line end, broken if it is too wide."""
    if len(line) <= columns and line.isascii():
        return line
    plain = _COLOUR.sub("", line)
    if width(plain) <= columns:
        return line
    head, mark, said = plain.partition(_MARK)
    if plain.startswith("#"):
        begin, rest, indent = "", plain, _COMMENT
    elif mark and columns - width(head + mark) >= _LEAST:
        begin, rest, indent = head + mark, said, " " * width(head + mark)
    else:
        begin, rest = "", plain
        indent = " " * min(len(plain) - len(plain.lstrip()) + _INDENT, columns // 2)
    first, *others = folded(rest, columns - len(indent))
    return _coloured(line, [begin + first, *others], indent)


def _coloured(line: str, texts: list[str], indent: str) -> str:
    """Returns the texts into which a line is broken, with its colours."""
    made = []
    place, colour = 0, ""
    for number, text in enumerate(texts):
        if number:
            made.append(f"{_PLAIN if colour else ''}\n{indent}{colour}")
        rest = text
        while rest:
            if found := _COLOUR.match(line, place):
                colour = "" if found[1] in ("", "0") else found[0]
                made.append(found[0])
                place = found.end()
                continue
            if line[place] == rest[0]:  # else it is a blank at which the line was broken
                made.append(rest[0])
                rest = rest[1:]
            place += 1
    return "".join([*made, *(found[0] for found in _COLOUR.finditer(line, place))])


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
