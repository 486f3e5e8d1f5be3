"""Numbers and values as files write them -> what they are, and bytes of transfers -> values as files write them.

Numbers are decimal, hexadecimal (0x) or octal (leading 0); signed ones may be written as the two's complement of their
width; `$NODEID` may be a summand (CiA 306 4.6 and 4.7). Whatever has to be changed is noted as a defect, and what
cannot be understood has no value.
"""

import math
import re
import struct
from functools import lru_cache
from typing import Final, NamedTuple

from canalyze._core import DATA_TYPES
from canalyze.dictionary.ini import Ini, Key
from canalyze.dictionary.model import NodeOffset, Value

UNSIGNED8, UNSIGNED16, UNSIGNED32, OPAQUE = 0x05, 0x06, 0x07, 0x0F
NAMES: Final = {kind: name for kind, (name, _) in DATA_TYPES.items()}
_WIDTHS: Final = {kind: bits for kind, (_, bits) in DATA_TYPES.items() if bits}
CODES: Final = {name: kind for kind, name in NAMES.items()}
BY_WIDTH: Final = {
    bits: kind for kind, (name, bits) in DATA_TYPES.items() if bits and name.startswith(("UNSIGNED", "BOOLEAN"))
}
"""Data types without a sign by their bits."""
SIGNED: Final = {kind: bits for kind, bits in _WIDTHS.items() if NAMES[kind].startswith("INTEGER")}
REAL: Final = {kind: bits for kind, bits in _WIDTHS.items() if NAMES[kind].startswith("REAL")}
_REALS: Final = {32: "<f", 64: "<d"}
_UNICODE: Final = 0x0B
STRINGS: Final = frozenset({0x09, _UNICODE})
BYTES: Final = frozenset({0x0A, OPAQUE})

_NUMBER: Final = re.compile(r"([+-]?)(?:0x([0-9a-f]+)|([0-9]+))", re.IGNORECASE)
_COMMENT: Final = re.compile(r";|#|//")
_NO_BYTES: Final = frozenset({"0", "0x0"})
"""What exporters write as the default of bytes or of a domain that has none."""
_NODE: Final = re.compile(r"\$?NODEID", re.IGNORECASE)
_MOST_SUMMANDS: Final = 16


class Whole(NamedTuple):
    """An integer as a file has it."""

    value: int
    odd: str = ""
    """The defect of its spelling, if there is one."""
    decimal: bool = True
    relative: bool = False
    """The node-ID is to be added."""


def spelled(data: bytes, kind: int) -> str | None:
    """Give a value that was transferred as a file has it; None where it cannot: its length, text of several lines."""
    match decoded(data, kind):
        case float(real):
            return repr(real) if math.isfinite(real) else None
        case int(number):
            return str(number) if kind in SIGNED else f"{number:#x}"
        case str(text):
            return text if text == text.strip() and text.isprintable() and text else None
        case bytes(octets):
            return octets.hex(" ").upper() or None
    return None


def packed(value: Value, kind: int, node: int) -> bytes:
    """Give a value that a file has as it is transferred."""
    if isinstance(value, NodeOffset):
        value = value.at(node)
    if isinstance(value, str):
        return value.encode("utf-16-le" if kind == _UNICODE else "utf-8")
    if isinstance(value, bytes):
        return value
    if kind in REAL:
        return struct.pack(_REALS[REAL[kind]], value)
    bits = _WIDTHS.get(kind, 64)
    return (int(value) & (1 << bits) - 1).to_bytes(-(-bits // 8), "little")


@lru_cache(maxsize=1024)  # a file has few different ones
def integer(text: str) -> Whole | None:
    """Read an integer without `$NODEID`; None if it is none."""
    bare = without_comment(text)
    match = _NUMBER.fullmatch(bare)
    if match is None or len(bare) > 40:
        return None
    sign, hexadecimal, digits = match.groups()
    value, odd = int(hexadecimal or digits, 16 if hexadecimal else 10), ""
    if digits and len(digits) > 1 and digits[0] == "0" and value > 7:
        odd = "octal"
        if not set(digits) & {"8", "9"}:
            value = int(digits, 8)
    if bare != text:
        odd = "trailing-comment"
    return Whole(-value if sign == "-" else value, odd, decimal=not hexadecimal)


def with_node(text: str) -> Whole | None:
    """Read an integer that may have `$NODEID` among its summands, in any order and case."""
    if "NODEID" not in text.upper():
        return integer(text)
    bare = without_comment(text)
    odd = "trailing-comment" if bare != text else ""
    joined = re.sub(r"\s", "", bare)
    summands = re.findall(r"[+-]?[^+-]+", joined)
    if len(summands) > _MOST_SUMMANDS:
        return None
    nodes, offset = 0, 0
    for summand in summands:
        if _NODE.fullmatch(summand.removeprefix("+")):
            nodes += 1
        elif (number := integer(summand)) is not None:
            offset += number.value
            odd = odd or number.odd
        else:
            return None
    if nodes != 1 or "".join(summands) != joined:
        return None
    if len(summands) > 2 or "$" not in joined or "-" in joined:
        odd = odd or "nodeid-form"
    return Whole(offset, odd, relative=True)


def decoded(data: bytes, kind: int) -> int | float | str | bytes | None:
    """Give the value that SDO transfers as these bytes; None where they are none of that type."""
    if kind in STRINGS:
        return data.decode("utf-16-le" if kind == _UNICODE else "utf-8", "replace").rstrip("\0")
    if kind in BYTES:
        return data
    if kind in REAL:
        return float(struct.unpack(_REALS[REAL[kind]], data)[0]) if len(data) * 8 == REAL[kind] else None
    number, bits = int.from_bytes(data, "little", signed=kind in SIGNED), _WIDTHS.get(kind, 0)
    least, beyond = (-1 << bits - 1, 1 << bits - 1) if kind in SIGNED else (0, 1 << bits)
    return number if 0 < len(data) <= 8 and bits and least <= number < beyond else None


def without_comment(text: str) -> str:
    """Give what stands before a comment behind a value."""
    match = _COMMENT.search(text)
    return text[: match.start()].rstrip() if match else text


class Values:
    """Reads the values of keys and notes what is wrong with them."""

    def __init__(self, ini: Ini) -> None:
        """Defects go to `ini`."""
        self._ini = ini

    def whole(self, key: Key | None) -> int | None:
        """Read a count, a code, a flag: an integer of no particular type. None if there is none."""
        if key is None or not key.value:
            return None
        number = integer(key.value)
        if number is None:
            self._odd(key, "not-a-number")
            return None
        if number.odd:
            self._odd(key, number.odd, read=number.value)
        return number.value

    def value(self, key: Key | None, kind: int) -> Value | None:
        """Read a value of a type; None if it is empty or cannot be used."""
        if key is None or not key.value:
            return None
        if kind in STRINGS:
            return key.value
        if kind in BYTES:
            return self._bytes(key)
        if kind in REAL:
            return self._real(key, REAL[kind])
        number = self._number(key, kind)
        if number is None:
            return None
        return NodeOffset(number.value) if number.relative else number.value

    def real(self, key: Key | None) -> float | None:
        """Read a number of no particular type that may be broken."""
        return self._real(key, 64) if key and key.value else None

    def limit(self, key: Key | None, kind: int) -> int | float | None:
        """Read a LowLimit or HighLimit, which may not depend on the node-ID."""
        if key is None or not key.value or kind in STRINGS or kind in BYTES:
            return None
        if kind in REAL:
            return self._real(key, REAL[kind])
        number = self._number(key, kind)
        return None if number is None or number.relative else number.value

    def _odd(self, key: Key, code: str, **facts: object) -> None:
        if not key.line:  # a copy: it was said of the original
            return
        shown = key.value if len(key.value) <= 60 else key.value[:59] + "…"
        self._ini.complain(key.line, code, key=key.name, value=shown, **facts)

    def _number(self, key: Key, kind: int) -> Whole | None:
        number = with_node(key.value)
        if number is None:
            self._odd(key, "not-a-number")
            return None
        fitted = _fitted(number, kind)
        if fitted is None:
            self._odd(key, "out-of-range", bits=_WIDTHS[kind])
        elif fitted.odd:
            shown = f"$NODEID+{fitted.value:X}h" if fitted.relative else str(fitted.value)
            self._odd(key, fitted.odd, read=shown)
        return fitted

    def _real(self, key: Key, bits: int) -> float | None:
        bare = without_comment(key.value)
        code = "trailing-comment" if bare != key.value else ""
        try:
            value = float(bare)
        except ValueError:
            number = integer(bare)
            if number is None or not 0 <= number.value < 1 << bits:
                self._odd(key, "not-a-number")
                return None
            code = code if number.value == 0 else "real-as-hex"
            value = struct.unpack(_REALS[bits], number.value.to_bytes(bits // 8, "little"))[0]
        if not math.isfinite(value) or "_" in bare:
            self._odd(key, "not-a-number")
            return None
        if code:
            self._odd(key, code, read=value)
        return value

    def _bytes(self, key: Key) -> bytes | None:
        bare = without_comment(key.value)
        if bare in _NO_BYTES:
            return None
        try:
            data = bytes.fromhex(bare)
        except ValueError:
            self._odd(key, "not-bytes")
            return None
        if bare != key.value:
            self._odd(key, "trailing-comment", read=data.hex(" ").upper())
        return data


def _fitted(number: Whole, kind: int) -> Whole | None:
    """Give the number as its type has it, None if it does not fit into its bits."""
    value, odd = number.value, number.odd
    if kind in SIGNED:
        bits = SIGNED[kind]
        if 1 << (bits - 1) <= value < 1 << bits:  # two's complement: the usual spelling if it is hexadecimal
            value -= 1 << bits
            odd = odd or ("wrapped" if number.decimal else "")
        fits = -1 << (bits - 1) <= value < 1 << (bits - 1)
    else:
        bits = _WIDTHS[kind]
        if -1 << (bits - 1) <= value < 0 and bits > 1 and not number.relative:
            value += 1 << bits
            odd = odd or "wrapped"
        fits = 0 <= value < 1 << bits or (number.relative and abs(value) < 1 << bits)
    return Whole(value, odd, number.decimal, number.relative) if fits else None
