"""What a capture is asked for, as lists that do not change: SDO transfers and findings, with small finders.

A finder gives a list of the same kind. It must not read: what is in a list was read before.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, Literal, Self, TypeVar, overload

from canalyze import network
from canalyze.finding import SEVERITIES, Finding, Severity
from canalyze.library.event import Transfer

T = TypeVar("T")

_SHOWN: Final = 3


class Rows(Sequence[T]):
    """A list that does not change; equal to any list or tuple of the same things."""

    _what = "rows"

    def __init__(self, rows: Iterable[T]) -> None:
        """Take the rows, in their order."""
        self._rows = tuple(rows)

    @overload
    def __getitem__(self, place: int) -> T: ...
    @overload
    def __getitem__(self, place: slice) -> Self: ...
    def __getitem__(self, place: int | slice) -> T | Self:
        """Give one, or a list of the same kind."""
        return type(self)(self._rows[place]) if isinstance(place, slice) else self._rows[place]

    def __len__(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[T]:
        return iter(self._rows)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, str | bytes) or not isinstance(other, Sequence):
            return NotImplemented
        return self._rows == tuple(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        more = [*map(self._one, self._rows[:_SHOWN]), *["..."] * (len(self) > _SHOWN)]
        return f"<{len(self)} {self._what}{': ' if more else ''}{', '.join(more)}>"

    def _one(self, row: T) -> str:
        return repr(row)

    def _only(self, fits: Callable[[T], bool]) -> Self:
        return type(self)(row for row in self._rows if fits(row))


class Transfers(Rows[Transfer]):
    """SDO transfers, in the order in which they end."""

    _what = "transfers"

    def _one(self, row: Transfer) -> str:
        return f"node {row.node} {row.direction} {row.object or '?'} {row.status}"

    def of(
        self,
        *,
        node: int | None = None,
        object: str | None = None,  # noqa: A002  the standard's word
        direction: Literal["upload", "download"] | None = None,
        bus: str | None = None,
        status: Literal["ok", "aborted", "incomplete", "failed"] | None = None,
    ) -> Self:
        """Give those of a node, an object ("1018:01", "1018h:01", or "1018" with all sub-indexes), a direction ...

        ValueError for what is no object, and for words that no transfer has.
        """
        one_of("direction", direction, ("upload", "download"))
        one_of("status", status, ("ok", "aborted", "incomplete", "failed"))
        wanted = None if object is None else network.address(object.strip())
        if object is not None and wanted is None:
            raise ValueError(f"object={object!r}: an object is written 1018:01, or 1018 with all of its sub-indexes")
        index, sub = (None, None) if wanted is None else (f"{wanted[0]:04X}", wanted[1])

        def fits(one: Transfer) -> bool:
            return (
                (node is None or one.node == node)
                and (index is None or one.index == index)
                and (sub is None or one.sub == sub)
                and (direction is None or one.direction == direction)
                and (bus is None or one.bus == bus)
                and (status is None or one.status == status)
            )

        return self._only(fits)


class Findings(Rows[Finding]):
    """Findings, in the order of frames; of one kind on one object ten, then one that counts the rest."""

    _what = "findings"

    def _one(self, row: Finding) -> str:
        return f"{row.severity} {row.code} at frame {row.frame}"

    def at_least(self, severity: Severity) -> Self:
        """Give those of this severity or worse: info, warning, error. ValueError for another word."""
        one_of("severity", severity, SEVERITIES)
        bad = SEVERITIES[SEVERITIES.index(severity) :]
        return self._only(lambda finding: finding.severity in bad)

    def of(self, code: str) -> Self:
        """Give those of a rule (SDO005), or of all that begin so (SDO). ValueError where there is no such rule."""
        from canalyze._core import rules

        if not any(rule.code.startswith(code.upper()) for rule in rules("en")):
            raise ValueError(f"code={code!r}: no rule begins so; `canalyze rules` lists them")
        return self._only(lambda finding: finding.code.startswith(code.upper()))


def one_of(name: str, value: str | None, choices: Sequence[str]) -> None:
    """Raise ValueError for a word that is none of those: what it is compared with would just never be the same."""
    if value is not None and value not in choices:
        raise ValueError(f"{name}={value!r}: one of {', '.join(choices)}")
