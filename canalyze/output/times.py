"""Times of the core, which are decimal strings of seconds, as numbers and in words. Must not: know of what they are."""

from typing import Final

_SECONDS_MS: Final = 2000


def nanoseconds(t: str | None) -> int | None:
    """Give a time of the core, a decimal string of seconds, in nanoseconds: exact, as a double is not."""
    if t is None:
        return None
    whole, _, fraction = t.partition(".")
    ns = int(whole or "0") * 1_000_000_000
    part = int(f"{fraction:0<9}"[:9])
    return ns - part if t.startswith("-") else ns + part


def milliseconds(ns: int, *, signed: bool = False) -> str:
    """Give a time in ms, from 2 s on in s, with as many digits as are read."""
    ms, sign = ns / 1e6, "+" if signed else ""
    if abs(ms) >= _SECONDS_MS:
        return f"{ms / 1000:{sign}.2f} s"
    return f"{ms:{sign}.{0 if abs(ms) >= 10 or ns % 1_000_000 == 0 else 1}f} ms"
