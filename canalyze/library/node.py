"""Nodes of a capture in figures, typed: states, heartbeats, SDO, emergencies.

Read from the records of the core's summary and never made here. It must not read a capture, judge or print.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, TypeAlias

from canalyze.library.columns import Tabular
from canalyze.library.rows import Rows
from canalyze.values import Timed

if TYPE_CHECKING:
    import pyarrow
    from canopen import ObjectDictionary

Dictionaries: TypeAlias = "Callable[[str | None, int], ObjectDictionary | None]"

State = Literal["boot-up", "stopped", "operational", "pre-operational"]
"""NMT states; boot-up is the message, after which a node is pre-operational."""


@dataclass(frozen=True, slots=True)
class StateChange(Timed):
    """A node has entered a state."""

    state: State | None
    """The state; None for a number that the standard does not have."""
    text: str | None
    """The state in words."""
    t: str | None
    """Time in seconds, a decimal string with all its digits; None without stamps."""
    frame: int
    """The frame that shows it."""
    commanded: bool
    """Whether the node, which sends no state, was only told to enter it."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Times that were measured, in microseconds."""

    count: int
    """How many."""
    min_us: float
    """The least."""
    mean_us: float
    """The mean."""
    max_us: float
    """The greatest."""
    sigma_us: float
    """The standard deviation."""
    p99_us: float | None
    """99 % of them are not above this, which is at most 3.2 % too high; None where it is not kept."""


@dataclass(frozen=True, slots=True)
class Emcy:
    """An EMCY error code that a node sent."""

    code: int
    """The error code, as 8130h."""
    text: str | None
    """What it means."""
    count: int
    """How often."""
    first_frame: int
    """The first frame with it."""
    last_frame: int
    """The last frame with it."""


@dataclass(frozen=True, slots=True)
class Aborts:
    """SDO transfers that were aborted with one code by one side."""

    code: int
    """The SDO abort code."""
    by: Literal["client", "server"]
    """Who aborted."""
    text: str | None
    """What the code means."""
    count: int
    """How often."""
    first_frame: int
    """The first of these aborts."""
    last_frame: int
    """The last of them."""


@dataclass(frozen=True, slots=True)
class Node:
    """A node that was seen or addressed."""

    bus: str | None
    """The bus, where the capture names it."""
    node: int
    """The node-ID, 1 to 127."""
    name: str | None
    """The device's name, by its description or by 1008h; None where neither is known."""
    frames: int
    """Frames that belong to it."""
    sent: int
    """Frames that it sent."""
    tpdos: int
    """PDOs that it sent."""
    rpdos: int
    """PDOs that it was sent."""
    state: State | None
    """The last NMT state; None where nothing tells."""
    lost: bool
    """Its heartbeats, or answers to node guarding, stopped and did not come back: `state` is that before."""
    states: tuple[StateChange, ...]
    """The states that it entered, in order, the first 64."""
    changes: int
    """How often it entered a state."""
    boot_ups: int
    """Boot-up messages."""
    error_control: Literal["heartbeat", "guarding"] | None
    """How it is watched; None where it is not."""
    heartbeats: int
    """Heartbeats, or answers to node guarding."""
    heartbeat: Spread | None
    """Time from heartbeat to heartbeat; None where nothing was measured."""
    transfers: int
    """SDO transfers with it as the server."""
    ok: int
    """Of these, those that came to their end."""
    aborted: int
    """Of these, those that were aborted."""
    failed: int
    """Of these, those that broke the protocol or had no answer."""
    incomplete: int
    """Of these, those that are cut by an end of the capture, which is no fault."""
    response: Spread | None
    """Time from an SDO request to its response; None where nothing was measured."""
    aborts: tuple[Aborts, ...]
    """SDO aborts by code, at most 32 kinds."""
    emcy_count: int
    """EMCY messages."""
    emcys: tuple[Emcy, ...]
    """EMCYs by error code, at most 32 kinds."""
    _dictionary: "Dictionaries" = field(default=lambda bus, node: None, repr=False, compare=False)

    @property
    def dictionary(self) -> "ObjectDictionary | None":
        """Its description as python-canopen has it, made when it is asked for; None where none was given.

        An `ObjectDictionary` that was given is that one itself; of a file, values that depend on the node-ID are those
        of this node.
        """
        return self._dictionary(self.bus, self.node)

    def __repr__(self) -> str:
        bus = f" on {self.bus}" if self.bus else ""
        name = f" {self.name!r}" if self.name else ""
        return f"<Node {self.node}{bus}{name}: {self.state or 'state unknown'}, {self.frames} frames>"


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
        """Take them in the order of buses and node-IDs. dictionary: gives the description of a node."""
        self._nodes = tuple(replace(one, _dictionary=dictionary) if dictionary else one for one in nodes)

    def arrow(self) -> "pyarrow.Table":
        """Give it as a `pyarrow.Table`; `canalyze.columns` lists the columns. CanalyzeError without pyarrow."""
        return _Listed(self._nodes).arrow()

    def _shown(self) -> tuple[Sequence[str], Iterable[Sequence[object]], int, str]:
        return _Listed(self._nodes)._shown()

    def __getitem__(self, key: int | tuple[str, int]) -> Node:
        """Give the node; KeyError, with the nodes there are, if it is not in the capture or on several buses."""
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


def node(row: Mapping[str, Any]) -> Node:
    """Take one object of the core (`"kind": "summary_node"`)."""
    return Node(
        **{name: row[name] for name in _SIMPLE},
        **{name: row["sdo"][name] for name in _OF_SDO},
        tpdos=row["tpdo"],
        rpdos=row["rpdo"],
        state=row["state_name"],
        states=tuple(
            StateChange(one["name"], one["text"], one["t"], one["frame"], one["commanded"]) for one in row["states"]
        ),
        heartbeat=_spread(row["heartbeat"]),
        response=_spread(row["response"]),
        aborts=tuple(Aborts(by=one["by"], **_coded(one)) for one in row["aborts"]),
        emcy_count=row["emcys"],
        emcys=tuple(Emcy(**_coded(one)) for one in row["emcy"]),
    )


_SIMPLE: Final = ("bus", "node", "name", "frames", "sent", "lost", "changes", "boot_ups", "error_control", "heartbeats")
_OF_SDO: Final = ("transfers", "ok", "aborted", "failed", "incomplete")


def _coded(row: Mapping[str, Any]) -> dict[str, Any]:
    """Give what is known of an error code or an abort code."""
    counted = {name: row[name] for name in ("text", "count", "first_frame", "last_frame")}
    return {"code": int(row["code"], 16), **counted}


def _spread(row: Mapping[str, Any] | None) -> Spread | None:
    return None if row is None else Spread(*map(row.get, Spread.__dataclass_fields__))  # type: ignore[arg-type]
