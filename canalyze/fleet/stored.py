"""A verdict as JSON and back, for reports that are made later or elsewhere.

Must not: judge, or know a report.
"""

from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass, replace
from functools import cache
from types import NoneType, UnionType
from typing import Any, Final, Union, get_args, get_origin, get_type_hints

from canalyze.check.verdict import Counted, Verdict
from canalyze.problem import status

_FINDINGS: Final = ("failures", "others", "consequences")


def row(verdict: Verdict) -> dict[str, Any]:
    """Returns a verdict for `json`. Only the first finding of each kind keeps its context lines."""
    lists: dict[str, Any] = {name: tuple(map(_bare, getattr(verdict, name))) for name in _FINDINGS}
    return asdict(replace(verdict, **lists))


def _bare(one: Counted) -> Counted:
    shown = (one.shown[0], *(replace(other, lines=()) for other in one.shown[1:]))
    return replace(one, shown=shown, consequences=tuple(map(_bare, one.consequences)))


def verdict(stored: Any) -> Verdict:
    """Restores a verdict. Raises LookupError, TypeError or ValueError for other data."""
    made: Verdict = _value(Verdict, stored)
    return replace(made, incidents=tuple(replace(one, status=status(one.status)) for one in made.incidents))


def _value(kind: Any, value: Any) -> Any:
    origin, inner = get_origin(kind), get_args(kind)
    if isinstance(kind, type) and is_dataclass(kind):
        return kind(**{name: _value(of, value[name]) for name, of in _fields(kind)})
    if origin is tuple:
        of_each = inner[:1] * len(value) if inner[-1] is Ellipsis else inner
        return tuple(_value(of, one) for of, one in zip(of_each, value, strict=True))
    if origin in (Union, UnionType):
        return None if value is None else _value(next(one for one in inner if one is not NoneType), value)
    if origin is Mapping and inner[0] is int:  # JSON has only texts for keys
        return {int(key): one for key, one in value.items()}
    return value


@cache
def _fields(kind: Any) -> list[tuple[str, Any]]:
    hints = get_type_hints(kind)
    return [(field.name, hints[field.name]) for field in fields(kind)]
