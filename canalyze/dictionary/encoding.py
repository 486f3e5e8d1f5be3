"""Bytes of a description -> text. EDS names no encoding, so anything but UTF-8 has to be told by its letters.

GB18030, the ANSI code page 1252 and the DOS code pages 850 and 437 accept nearly any bytes: what decides is which of
them makes words. A byte 94h between two small letters is an ö of code page 850, and a closing quotation mark of 1252
does not stand there.
"""

import codecs
import re
import unicodedata
from typing import Final

_MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_SINGLE: Final = ("cp1252", "cp850", "cp437")
"""In the order in which a tie is decided."""
_JUDGED: Final = 1 << 16
"""Bytes of lines beyond ASCII that are enough to tell by."""
_LETTERS: Final = frozenset("äöüßéèêëàâáåæøœçñíìîïóòôõúùûãčšžýÿ")
_SIGNS: Final = frozenset("®©™\N{EN DASH}—“”‘’„…²³±·«»€§")


def decode(data: bytes) -> tuple[str, str, bool]:
    """Give the text, the name of its encoding, and whether there was a byte order mark. Never fails."""
    for mark, name in _MARKS:
        if data.startswith(mark):
            return data[len(mark) :].decode(name, "replace"), name, True
    try:
        return data.decode("utf-8"), "utf-8", False
    except UnicodeDecodeError:
        pass
    if _chinese(data):
        return data.decode("gb18030"), "gb18030", False
    telling = b"\n".join(line for line in data.splitlines() if not line.isascii())[:_JUDGED]
    best = max(_SINGLE, key=lambda name: (_sense(telling.decode(name, "replace")), -_SINGLE.index(name)))
    return data.decode(best, "replace"), best, False


def _chinese(data: bytes) -> bool:
    """Tell whether the bytes above 7Fh come in pairs that are common Chinese characters."""
    try:
        data.decode("gb18030")
    except UnicodeDecodeError:
        return False
    pairs = strangers = 0
    for run in re.finditer(rb"[\x80-\xff]+", data):
        found = run.group()
        before, after = data[run.start() - 1 : run.start()], data[run.end() : run.end() + 1]
        # The first level of GB 2312, by far the most of any text, and its signs; two letters of Latin, as in "ção",
        # make such a pair too, but they stand inside a word.
        common = len(re.findall(rb"(?s)[\xa1\xa3\xb0-\xd7][\xa1-\xfe]", found)) if len(found) % 2 == 0 else 0
        if len(found) % 2 or (len(found) == 2 and (before.isalpha() or after.isalpha())):
            strangers += 1
        else:
            pairs += common
    return pairs > strangers


def _sense(text: str) -> int:
    """Judge how much the letters beyond ASCII look like words of a European language."""
    return sum(
        _letter(text, place) if char.isalpha() and char not in "ªºµƒ" else _sign(text, place)
        for place, char in enumerate(text)
        if not char.isascii()
    )


def _letter(text: str, place: int) -> int:
    char = text[place]
    before, after = text[place - 1 : place], text[place + 1 : place + 2]
    if unicodedata.name(char, "").startswith("GREEK"):  # units, such as 10 kΩ
        return 2 if not after.isalpha() and before in "kM 0123456789" else -2
    if before.isdigit() or not (before.isalpha() or after.isalpha()):
        return -2
    if (char.isupper() and before.islower()) or (char.islower() and after.isupper()):
        return -2
    return 3 if char.lower() in _LETTERS else 1


def _sign(text: str, place: int) -> int:
    char = text[place]
    before, after = text[place - 1 : place], text[place + 1 : place + 2]
    if char == "\N{DEGREE SIGN}":
        return 3 if not before.isalpha() else -1
    if char == "\N{MICRO SIGN}":
        return 3 if not before.isalpha() and after in tuple("smAVFHg") else 1
    if char in _SIGNS:
        return 1 if not (before.isalpha() and after.isalpha()) or char in "’·" else -2
    return -2
