"""Problems of a capture as a list with small finders.

A problem itself is in `canalyze.records`. It must not read: what is in a list was read before.
"""

from collections.abc import Iterable
from operator import attrgetter
from typing import ClassVar, Literal, Self

from canalyze.library.former import renamed
from canalyze.library.rows import Rows, one_of
from canalyze.records.problems import FORMER_STATUSES, STATUSES, Problem, Status


class Problems(Rows[Problem]):
    """Problems of a capture, in the order of their numbers; `roots` have no known cause."""

    _what = "problems"
    _table = "problems"
    _row_type = Problem
    _values: ClassVar = {
        "problem": attrgetter("kind"),
        "begin_frame": lambda one: one.begin.frame,
        "t_ns": lambda one: one.begin.t_ns,
        "noticed_frame": lambda one: one.noticed.frame,
        "noticed_t_ns": lambda one: one.noticed.t_ns,
        "end_frame": lambda one: one.end and one.end.frame,
        "end_t_ns": lambda one: one.end and one.end.t_ns,
        "root": attrgetter("is_root"),
        "cause": lambda one: one.cause and one.cause.id,
        "cause_link": lambda one: one.cause and one.cause.link,
        "cause_grade": lambda one: one.cause and one.cause.grade,
        "subject": None,
        "checks": None,
        "facts": None,
    }
    _first = ("id", "problem", "status", "node", "begin_frame", "t_ns", "cause", "message")

    def __init__(self, rows: Iterable[Problem], order: Iterable[int] = ()) -> None:
        """Creates a list. order: the numbers of the roots as they are read, the most important first."""
        super().__init__(rows)
        self._order = tuple(order)

    def _one(self, row: Problem) -> str:
        return f"{row.message} ({row.status}, frame {row.begin.frame})"

    @property
    def roots(self) -> Self:
        """The problems that nothing else has caused, the most important first."""
        place = {number: place for place, number in enumerate(self._order)}
        return type(self)(sorted((one for one in self if one.is_root), key=lambda one: place.get(one.id, one.id)))

    @property
    def open(self) -> Self:
        """The problems that have not ended, roots and their consequences."""
        return self._only(lambda one: one.status == "open")

    standing = renamed("standing", "open")

    def of(
        self,
        *,
        node: int | None = None,
        bus: str | None = None,
        kind: str | None = None,
        status: Status | Literal["stands", "over"] | None = None,
    ) -> Self:
        """Returns those of a node, bus, kind or status. ValueError for an unknown status.

        The former names of statuses, stands and over, are accepted for a release.
        """
        status = FORMER_STATUSES.get(status or "", status)
        one_of("status", status, STATUSES)
        return self._only(
            lambda one: (
                (node is None or node in one.nodes)
                and (bus is None or one.bus == bus)
                and (kind is None or one.kind == kind)
                and (status is None or one.status == status)
            )
        )

    def by_id(self, number: int) -> Problem:
        """Returns the problem of this number; KeyError if there is none."""
        found = next((one for one in self if one.id == number), None)
        if found is None:
            raise KeyError(number)
        return found

    def cause_of(self, one: Problem) -> Problem | None:
        """Returns the problem that caused one; None if none is known."""
        return None if one.cause is None else self.by_id(one.cause.id)

    def effects_of(self, one: Problem) -> Self:
        """Returns the problems that one has caused."""
        return self._only(lambda other: other.id in one.effects)
