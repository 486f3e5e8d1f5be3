"""Incidents of a capture as a list with small finders.

What an incident is stands in `canalyze.incident`. It must not read: what is in a list was read before.
"""

from collections.abc import Iterable
from operator import attrgetter
from typing import ClassVar, Self

from canalyze.incident import STATUSES, Incident, Status
from canalyze.library.rows import Rows, one_of


class Incidents(Rows[Incident]):
    """Incidents of a capture, in the order of their numbers; `roots` are its stories."""

    _what = "incidents"
    _table = "incidents"
    _row_type = Incident
    _values: ClassVar = {
        "incident": attrgetter("kind"),
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
        "checks": None,
        "facts": None,
    }
    _first = ("id", "incident", "status", "node", "begin_frame", "t_ns", "cause", "message")

    def __init__(self, rows: Iterable[Incident], order: Iterable[int] = ()) -> None:
        """Take them. order: the numbers of the roots as they are read, the most important first."""
        super().__init__(rows)
        self._order = tuple(order)

    def _one(self, row: Incident) -> str:
        return f"{row.message} ({row.status}, frame {row.begin.frame})"

    @property
    def roots(self) -> Self:
        """Give those that nothing else has caused, the most important first."""
        place = {number: place for place, number in enumerate(self._order)}
        return type(self)(sorted((one for one in self if one.is_root), key=lambda one: place.get(one.id, one.id)))

    @property
    def standing(self) -> Self:
        """Give those that are not over, roots and what follows from them."""
        return self._only(lambda one: one.status == "stands")

    def of(
        self,
        *,
        node: int | None = None,
        bus: str | None = None,
        kind: str | None = None,
        status: Status | None = None,
    ) -> Self:
        """Give those that concern a node, on a bus, of a kind or status. ValueError for a status that there is none."""
        one_of("status", status, STATUSES)
        return self._only(
            lambda one: (
                (node is None or node in one.nodes)
                and (bus is None or one.bus == bus)
                and (kind is None or one.kind == kind)
                and (status is None or one.status == status)
            )
        )

    def by_id(self, number: int) -> Incident:
        """Give the one of this number; KeyError where there is none."""
        found = next((one for one in self if one.id == number), None)
        if found is None:
            raise KeyError(number)
        return found

    def cause_of(self, one: Incident) -> Incident | None:
        """Give the incident that caused one; None where none is known."""
        return None if one.cause is None else self.by_id(one.cause.id)

    def effects_of(self, one: Incident) -> Self:
        """Give the incidents that one has caused."""
        return self._only(lambda other: other.id in one.effects)
