"""Numbers in few columns: times, rates, sizes, bars. Must not: know their meaning."""

from typing import Final

BLANK: Final = "-"
"""Shown for an unknown value."""
_NS: Final = 1_000_000_000
_PARTS: Final = " ▏▎▍▌▋▊▉"


def period(ns: int | None) -> str:
    """Returns a time of up to some minutes with its unit, in at most seven columns."""
    if ns is None:
        return BLANK
    if ns <= 0:
        return "0"
    for limit, step, unit in ((1_000, 1, "ns"), (1_000_000, 1_000, "µs"), (_NS, 1_000_000, "ms")):
        if ns < limit:
            return f"{_three(ns / step)}{unit}"
    return f"{_three(ns / _NS)}s" if ns < 1000 * _NS else clock(ns)


def _three(value: float) -> str:
    """Returns about three digits, so that a value that hardly changes does not flicker."""
    return f"{value:.2f}" if value < 9.995 else f"{value:.1f}" if value < 99.95 else f"{value:.0f}"


def seconds(ns: int | None, digits: int = 1) -> str:
    """Returns a time in seconds without its unit."""
    return BLANK if ns is None else f"{ns / _NS:.{digits}f}"


def clock(ns: int | None) -> str:
    """Returns a time of any length as 1:02:03."""
    if ns is None:
        return BLANK
    whole = max(0, ns) // _NS
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"


def rate(value: float | None) -> str:
    """Returns a rate, with one decimal if it is small."""
    if value is None:
        return BLANK
    return f"{value:.1f}" if 0 < value < 99.95 else f"{value:.0f}"


def size(octets: int | None) -> str:
    """Returns a number of bytes."""
    if octets is None:
        return BLANK
    if octets < 10_000:
        return str(octets)
    for step, unit in ((1 << 10, "Ki"), (1 << 20, "Mi"), (1 << 30, "Gi")):
        if octets < step * 1000 or unit == "Gi":
            return f"{_three(octets / step)}{unit}"
    return str(octets)


def bar(part: float, columns: int) -> str:
    """Returns a bar for a ratio of 0 to 1, in eighths of a column."""
    eighths = round(max(0.0, min(part, 1.0)) * columns * 8)
    full, rest = divmod(eighths, 8)
    return ("█" * full + (_PARTS[rest] if rest else "")).ljust(columns, "░")
