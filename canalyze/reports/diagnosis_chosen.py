"""The problems that are asked for: by node, bus and time; and those that fail the command.

Must not: read a capture.
"""

from collections.abc import Iterable
from typing import Final

from canalyze.errors import SourceError
from canalyze.records.problems import Overview, Problem
from canalyze.reports import wording
from canalyze.reports.diagnosis_text import Chosen, root
from canalyze.words import Words

FAIL_ON: Final = {"open": ("open",), "unknown": ("open", "unknown"), "ended": ("open", "unknown", "ended")}
"""Statuses of problems that make the command fail, by --fail-on."""


def fails(shown: Iterable[Problem], fail_on: str | None) -> bool:
    """Returns true if a problem is there that --fail-on is about."""
    failing = FAIL_ON.get(fail_on or "", ())
    return any(one.status in failing and one.is_root for one in shown)


def check_places(chosen: Chosen, incidents: list[Problem], whole: Overview, words: Words) -> None:
    """Raises where the bus or the node that is asked for is not in the capture."""
    places = {(one.bus, one.node) for one in whole.nodes}
    places |= {(one.bus, number) for one in incidents for number in _concerned(one)}
    buses = sorted({bus for bus in (*whole.buses, *(one.bus for one in incidents)) if bus})
    if chosen.bus is not None and chosen.bus not in buses:
        key = "diagnose.no_bus" if buses else "diagnose.no_buses"
        raise SourceError(key, bus=chosen.bus or '""', buses=words("reports.list").join(buses))
    nodes = {node for bus, node in places if chosen.bus in (None, bus)}
    if chosen.node is not None and chosen.node not in nodes:
        if not nodes:
            raise SourceError("diagnose.no_nodes", node=chosen.node)
        key = "diagnose.no_node" if chosen.bus is None else "diagnose.no_node_on"
        raise SourceError(key, node=chosen.node, bus=chosen.bus, nodes=wording.ranges(nodes, ", "))


def _concerned(one: Problem) -> tuple[int, ...]:
    """Returns the nodes of a problem."""
    return one.nodes if one.node is None else (one.node, *one.nodes)


def select(incidents: list[Problem], whole: Overview | None, chosen: Chosen) -> list[Problem]:
    """Returns the problems that are asked for, each with its causes and consequences."""
    node, bus, since = chosen
    begin = float((whole and whole.begin) or 0)
    by_id = {one.id: one for one in incidents}

    def fits(one: Problem) -> bool:
        late = since is None or one.end is None or one.end.t is None or float(one.end.t) - begin >= since
        about = node is None or node in _concerned(one)
        return late and about and (bus is None or one.bus == bus)

    roots = {root(one, by_id).id for one in incidents if fits(one)}
    return [one for one in incidents if root(one, by_id).id in roots]
