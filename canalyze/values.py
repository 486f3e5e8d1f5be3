"""Times and objects in records of the core, converted to numbers: seconds, ns, integers.

Must not: read or print anything, or know a record.
"""

from typing import Final, Self

DATES_NS: Final = 631_152_000 * 10**9
"""1990-01-01 in ns: stamps from here on are dates, smaller ones count from some start."""
_SECONDS_MS: Final = 2000


def nanoseconds(t: str | None) -> int | None:
    """Returns a time of the core, a decimal string of seconds, in nanoseconds: exact, unlike a double."""
    if t is None:
        return None
    whole, _, fraction = t.partition(".")
    ns = int(whole or "0") * 1_000_000_000
    part = int(f"{fraction:0<9}"[:9])
    return ns - part if t.startswith("-") else ns + part


def milliseconds(ns: int, *, signed: bool = False) -> str:
    """Returns a time in ms, from 2 s on in s, with a suitable number of digits."""
    ms, sign = ns / 1e6, "+" if signed else ""
    if abs(ms) >= _SECONDS_MS:
        return f"{ms / 1000:{sign}.2f} s"
    return f"{ms:{sign}.{0 if abs(ms) >= 10 or ns % 1_000_000 == 0 else 1}f} ms"


class Timed:
    """A base for records with a time `t`, a decimal string of seconds with all its digits."""

    __slots__ = ()
    t: str | None

    @property
    def t_ns(self) -> int | None:
        """The time in nanoseconds; None without stamps."""
        return nanoseconds(self.t)

    @property
    def t_s(self) -> float | None:
        """The time in seconds, of a date exact to about a microsecond; None without stamps."""
        return None if self.t is None else float(self.t)


class ObjectRef(str):
    """An object as the standard writes it, `1017h:00`: equal to that text, with its numbers as integers.

    It is a string in every respect, also as a key, except for its `index`. `capture.transfers.of(object="1017:00")` and
    similar methods accept all spellings of an object.
    """

    __slots__ = ("index", "sub")
    index: int  # type: ignore[assignment]  # in place of the search for a part of the text
    """The index, 0x1017."""
    sub: int
    """The sub-index."""

    def __new__(cls, index: int, sub: int) -> Self:
        """Creates the text of two integers."""
        made = super().__new__(cls, f"{index:04X}h:{sub:02X}")
        made.index, made.sub = index, sub
        return made

    def __getnewargs__(self) -> tuple[int, int]:  # type: ignore[override]  # what `__new__` takes, not a text
        return self.index, self.sub


def object_ref(index: str | None, sub: int | None) -> ObjectRef | None:
    """Returns the object of a record, whose index is four hexadecimal digits; None if it has none."""
    return None if index is None else ObjectRef(int(index, 16), sub or 0)
