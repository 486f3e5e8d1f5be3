"""A verdict as JSON and back, for reports that are made after the captures were read, elsewhere.

Must not: judge, or know a report.
"""

from typing import Any, Final

from msgspec import convert, to_builtins
from msgspec.structs import replace

from canalyze.check.verdict import Counted, Verdict

_FINDINGS: Final = ("failures", "others", "consequences")


def row(verdict: Verdict) -> dict[str, Any]:
    """Returns it for `json`. Only the first finding of a kind has the lines around it: others are shown by number."""
    lists: dict[str, Any] = {name: tuple(map(_bare, getattr(verdict, name))) for name in _FINDINGS}
    made: dict[str, Any] = to_builtins(replace(verdict, **lists), str_keys=True)
    return made


def _bare(one: Counted) -> Counted:
    shown = (one.shown[0], *(replace(other, lines=()) for other in one.shown[1:]))
    return replace(one, shown=shown, consequences=tuple(map(_bare, one.consequences)))


def verdict(stored: dict[str, Any]) -> Verdict:
    """Reads one of ours; ValueError for what is none."""
    return convert(stored, Verdict, str_keys=True)
