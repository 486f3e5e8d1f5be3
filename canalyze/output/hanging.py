"""Breaks lines of a listing that are wider than the terminal between words, with a hanging indent.

Continuation lines of an annotation begin below its first word; those of a comment are comments. Colours continue.
Must not: know the content.
"""

import re
from typing import Final

from canalyze.output.layout import folded, width

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
    """Return whole lines so that none is wider than `columns`."""
    if columns <= _NARROW:
        return lines
    text = lines.decode("utf-8", "backslashreplace")
    return "\n".join(_broken(line, columns) for line in text.split("\n")).encode("utf-8", "backslashreplace")


def _broken(line: str, columns: int) -> str:
    """Return a line without its end, or those that it is broken into."""
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
    """Return the texts into which a line is broken, with its colours."""
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
