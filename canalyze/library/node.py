"""Nodes of a capture in figures, typed: states, heartbeats, SDO, emergencies.

It must not read a capture, judge or print.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, ClassVar, TypeAlias

from msgspec.structs import replace

from canalyze.library.columns import Tabular
from canalyze.library.rows import Rows
from canalyze.records.summary import Node

if TYPE_CHECKING:
    import pyarrow
    from canopen import ObjectDictionary

Dictionaries: TypeAlias = "Callable[[str | None, int], ObjectDictionary | None]"


def _part(name: str, part: str, one: Node) -> float | None:
    spread = getattr(one, name)
    return None if spread is None else getattr(spread, part)


class _Listed(Rows[Node]):
    """Nodes as a table."""

    _what = "nodes"
    _table = "nodes"
    _row_type = Node
    _values: ClassVar = {
        f"{name}_{part}_us": partial(_part, name, f"{part}_us")
        for name in ("heartbeat", "response")
        for part in ("mean", "max")
    }
    _first = ("bus", "node", "name", "state", "frames", "transfers", "aborted", "emcy_count")


class Nodes(Tabular):
    """The nodes of a capture by bus and node-ID: `nodes[5]`, or `nodes["can1", 5]` where several buses have it."""

    def __init__(self, nodes: Iterable[Node], dictionary: "Dictionaries | None" = None) -> None:
        """Creates a list, in the order of buses and node-IDs. dictionary: returns the description of a node."""
        self._nodes = tuple(replace(one, _dictionary=dictionary) if dictionary else one for one in nodes)

    def arrow(self) -> "pyarrow.Table":
        """Returns it as a `pyarrow.Table`; `canalyze.columns` lists the columns. CanalyzeError without pyarrow."""
        return _Listed(self._nodes).arrow()

    def _shown(self) -> tuple[Sequence[str], Iterable[Sequence[object]], int, str]:
        return _Listed(self._nodes)._shown()

    def __getitem__(self, key: int | tuple[str, int]) -> Node:
        """Returns the node; KeyError, with the nodes of the capture, if it is not there or on several buses."""
        bus, number = key if isinstance(key, tuple) else (None, key)
        found = [one for one in self._nodes if one.node == number and bus in (None, one.bus)]
        if len(found) == 1:
            return found[0]
        if found:
            buses = ", ".join(f'["{one.bus}", {number}]' for one in found)
            raise KeyError(f"node {number} is on several buses: {buses}")
        there = ", ".join(str(one.node) for one in self._nodes) or "none"
        raise KeyError(f"no node {key!r}; nodes: {there}")

    def __contains__(self, key: object) -> bool:
        return any(key in (one.node, (one.bus, one.node)) for one in self._nodes)

    def __iter__(self) -> Iterator[Node]:
        return iter(self._nodes)

    def __len__(self) -> int:
        return len(self._nodes)

    def __repr__(self) -> str:
        shown = ", ".join(f"{one.node} {one.state or '?'}" for one in self._nodes)
        return f"<{len(self)} nodes: {shown}>"
