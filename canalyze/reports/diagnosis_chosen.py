"""The problems that are asked for: by node, bus and time; and those that fail the command.

Must not: read a capture.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Final

from canalyze.errors import SourceError
from canalyze.reports import wording
from canalyze.reports.diagnosis_text import Chosen, root
from canalyze.words import Words

FAIL_ON: Final = {"open": ("open",), "unknown": ("open", "unknown"), "ended": ("open", "unknown", "ended")}
"""Statuses of problems that make the command fail, by --fail-on."""


def fails(shown: Iterable[Mapping[str, Any]], fail_on: str | None) -> bool:
    """Returns true if a problem is there that --fail-on is about."""
    failing = FAIL_ON.get(fail_on or "", ())
    return any(one["status"] in failing and one["root"] for one in shown)


def check_places(chosen: Chosen, incidents: list[dict[str, Any]], whole: dict[str, Any], words: Words) -> None:
    """Raises where the bus or the node that is asked for is not in the capture."""
    places = {(one["bus"], one["node"]) for one in whole["nodes"]}
    for one in incidents:
        subject = one["subject"]
        own = () if subject.get("node") is None else (subject["node"],)
        places |= {(subject["bus"], number) for number in (*own, *subject.get("nodes", ()))}
    buses = sorted({*whole["buses"], *(one["subject"]["bus"] for one in incidents)} - {"", None})
    if chosen.bus is not None and chosen.bus not in buses:
        key = "diagnose.no_bus" if buses else "diagnose.no_buses"
        raise SourceError(key, bus=chosen.bus or '""', buses=words("reports.list").join(buses))
    nodes = {node for bus, node in places if chosen.bus in (None, bus)}
    if chosen.node is not None and chosen.node not in nodes:
        if not nodes:
            raise SourceError("diagnose.no_nodes", node=chosen.node)
        key = "diagnose.no_node" if chosen.bus is None else "diagnose.no_node_on"
        raise SourceError(key, node=chosen.node, bus=chosen.bus, nodes=wording.ranges(nodes, ", "))


def select(
    incidents: list[dict[str, Any]],
    whole: dict[str, Any] | None,
    chosen: Chosen,
) -> list[dict[str, Any]]:
    """Returns the problems that are asked for, each with its causes and consequences."""
    node, bus, since = chosen
    begin = float((whole or {}).get("begin") or 0)
    by_id = {one["id"]: one for one in incidents}

    def fits(one: dict[str, Any]) -> bool:
        subject, end = one["subject"], one["end"]
        late = since is None or end is None or end["t"] is None or float(end["t"]) - begin >= since
        about = node is None or node in (subject.get("node"), *subject.get("nodes", ()))
        return late and about and (bus is None or subject["bus"] == bus)

    roots = {root(one, by_id)["id"] for one in incidents if fits(one)}
    return [one for one in incidents if root(one, by_id)["id"] in roots]
