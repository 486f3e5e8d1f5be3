"""Contents of a capture as lists that do not change, with small finders: SDO transfers, findings, problems, nodes.

A finder gives a list of the same kind. It must not read: what is in a list was read before.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Self, TypeAlias, TypeVar, overload

from msgspec.structs import replace

from canalyze.configuration import network
from canalyze.library.columns import Tabular, columns, renamed, table_of
from canalyze.records import SEVERITIES, Severity
from canalyze.records.frames import Event, Frame
from canalyze.records.objects import Transfer
from canalyze.records.problems import FORMER_STATUSES, STATUSES, Finding, Problem, Status
from canalyze.records.summary import Node

if TYPE_CHECKING:
    import pyarrow
    from canopen import ObjectDictionary

T = TypeVar("T")
ObjectLike: TypeAlias = str | int | tuple[int, int]
"""An object of a device: `"1018:01"`, `(0x1018, 1)`, or `0x1018` with all of its sub-indexes."""

_SHOWN: Final = 3
_LEAST: Final = 0x1000
"""The least index of an object; a lower one is rather a decimal number by mistake."""


class Rows(Tabular, Sequence[T]):
    """A list that does not change; equal to any list or tuple of the same things."""

    _what = "rows"
    _table: ClassVar[str] = ""
    """The table whose columns it has."""
    _values: ClassVar[Mapping[str, Callable[[Any], object] | None]] = {}
    """Columns that are no attributes of that name; None: which it has not."""
    _row_type: ClassVar[type] = object
    _first: ClassVar[tuple[str, ...]] = ()
    """Columns that a notebook shows."""

    def __init__(self, rows: Iterable[T]) -> None:
        """Creates a list of the rows, in their order."""
        self._rows = tuple(rows)

    @overload
    def __getitem__(self, place: int) -> T: ...
    @overload
    def __getitem__(self, place: slice) -> Self: ...
    def __getitem__(self, place: int | slice) -> T | Self:
        """Returns one, or a list of the same kind."""
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
        what = self._what.removesuffix("s") if len(self) == 1 else self._what
        return f"<{len(self)} {what}{': ' if more else ''}{', '.join(more)}>"

    def _one(self, row: T) -> str:
        return repr(row)

    def _getters(self) -> dict[str, Callable[[Any], object]]:
        """Returns the functions that make the values of the columns."""
        if not self._table:
            raise TypeError(f"{self._what}: no table has such rows")
        names = [one.name for one in columns(self._table)]
        made = {name: self._values.get(name, attrgetter(name)) for name in names if hasattr(self._row_type, name)}
        made |= {name: own for name, own in self._values.items() if name in names}
        return {name: get for name in names if (get := made.get(name))}

    def arrow(self) -> "pyarrow.Table":
        """Returns it as a `pyarrow.Table`; `canalyze.columns` lists the columns. CanalyzeError without pyarrow."""
        getters = self._getters()
        return table_of(self._table, {name: [get(row) for row in self] for name, get in getters.items()})

    def _shown(self) -> tuple[Sequence[str], Iterable[Sequence[object]], int, str]:
        if not self._table:
            return ("",), ((self._one(row),) for row in self._rows), len(self), self._what
        getters = self._getters()
        return self._first, ([getters[name](row) for name in self._first] for row in self), len(self), self._what

    def _only(self, fits: Callable[[T], bool]) -> Self:
        return type(self)(row for row in self._rows if fits(row))

    def _having(self, **wanted: object) -> Self:
        """Returns those with attributes of these values; None stands for any."""
        asked = {name: value for name, value in wanted.items() if value is not None}
        return self._only(lambda row: all(getattr(row, name) == value for name, value in asked.items()))


def _short(one: Any) -> str | None:
    """Returns an object as tables have it: 1017:00."""
    return None if one.object is None else f"{one.object.index:04X}:{one.object.sub:02X}"


def _index(one: Any) -> int | None:
    return None if one.object is None else one.object.index


def _whole(one: Any) -> int | None:
    """Returns a value that is an integer of 64 bits with sign, else None."""
    value = one.value
    return value if isinstance(value, int) and not isinstance(value, bool) and -(1 << 63) <= value < 1 << 63 else None


def number(one: Any) -> float | None:
    """Returns a value that is a number, else None."""
    return float(one.value) if isinstance(one.value, int | float) and not isinstance(one.value, bool) else None


class Events(Rows[Event]):
    """All that there is, in order: frames, notes, findings, transfers."""

    _what = "events"
    _table = "events"
    _row_type = Frame
    _values: ClassVar = {
        "event": lambda one: type(one).__name__.lower(),
        "frame": lambda one: one.last_frame if isinstance(one, Transfer) else one.frame,
        "t_ns": lambda one: getattr(one, "t_ns", None),
        "text": lambda one: one.message if isinstance(one, Finding) else one.text,
    }
    _first = ("frame", "t_ns", "event", "node", "text")


class Frames(Rows[Frame]):
    """Frames, in order."""

    _what = "frames"
    _table = "frames"
    _row_type = Frame
    _values: ClassVar = {
        "kind": lambda one: "error" if one.error else "remote" if one.remote else "fd" if one.fd else "data",
        "brs": lambda one: one.brs if one.fd else None,
        "esi": lambda one: one.esi if one.fd else None,
        "dir": attrgetter("direction"),
        "len": attrgetter("length"),
    }
    _first = ("frame", "t_ns", "bus", "id", "data", "service", "node", "text")

    def _getters(self) -> dict[str, Callable[[Any], object]]:
        return {**super()._getters(), "text": attrgetter("text")}


class Transfers(Rows[Transfer]):
    """SDO transfers, in the order in which they end."""

    _what = "transfers"
    _table = "transfers"
    _row_type = Transfer
    _values: ClassVar = {
        "transfer": attrgetter("number"),
        "index": _index,
        "object": _short,
        "string": lambda one: one.value if isinstance(one.value, str) else None,
        "boolean": lambda one: one.value if isinstance(one.value, bool) else None,
        "integer": _whole,
        "value": number,
        "abort_code": lambda one: one.abort and one.abort.code,
        "abort_by": lambda one: one.abort and one.abort.by,
        "abort_text": lambda one: one.abort and one.abort.text,
    }
    _first = ("node", "direction", "object", "name", "text", "status", "first_frame", "last_frame")

    def _one(self, row: Transfer) -> str:
        return f"node {row.node} {row.direction} {row.object or '?'} {row.status}"

    def of(
        self,
        *,
        node: int | None = None,
        object: ObjectLike | None = None,  # noqa: A002  the standard's word
        direction: Literal["upload", "download"] | None = None,
        bus: str | None = None,
        status: Literal["ok", "aborted", "incomplete", "failed"] | None = None,
    ) -> Self:
        """Returns those of a node, an object, a direction ...

        object: "1018:01", "1018h:01", (0x1018, 1), or 0x1018 and "1018" with all sub-indexes. ValueError for what is no
        object, and for words that no transfer has.
        """
        one_of("direction", direction, ("upload", "download"))
        one_of("status", status, ("ok", "aborted", "incomplete", "failed"))
        index, sub = (None, None) if object is None else address(object)
        return self._having(node=node, index=index, sub=sub, direction=direction, bus=bus, status=status)


class Findings(Rows[Finding]):
    """Findings, in the order of frames; of one kind on one object ten, then one that counts the rest."""

    _what = "findings"
    _table = "findings"
    _row_type = Finding
    _values: ClassVar = {
        "index": lambda one: None if one.index is None else int(one.index, 16),
        "facts": lambda one: json.dumps(dict(one.facts), ensure_ascii=False, separators=(",", ":")),
    }
    _first = ("severity", "code", "frame", "t_ns", "node", "message")

    def _one(self, row: Finding) -> str:
        return f"{row.severity} {row.code} at frame {row.frame}"

    def at_least(self, severity: Severity) -> Self:
        """Returns those of this severity or worse: info, warning, error. ValueError for another word."""
        one_of("severity", severity, SEVERITIES)
        bad = SEVERITIES[SEVERITIES.index(severity) :]
        return self._only(lambda finding: finding.severity in bad)

    def of(self, code: str) -> Self:
        """Returns those of a rule (SDO005), or of all that begin so (SDO). ValueError if there is no such rule."""
        from canalyze._core import rules

        if not isinstance(code, str):
            raise TypeError(f"code={code!r}: a text is needed, not {type(code).__name__}")
        if not any(rule.code.startswith(code.upper()) for rule in rules("en")):
            raise ValueError(f"code={code!r}: no rule begins so; `canalyze rules` lists them")
        return self._only(lambda finding: finding.code.startswith(code.upper()))


def address(given: ObjectLike) -> tuple[str, int | None]:
    """Returns the index of an object, four hexadecimal digits, and its sub-index; None: all of them.

    TypeError for what is neither text nor integers, ValueError for what is no object.
    """
    index, sub = given if isinstance(given, tuple) and len(given) == 2 else (given, None)
    if isinstance(given, str):
        found = network.address(given.strip())
    elif type(index) is int and (sub is None or type(sub) is int):
        is_object = _LEAST <= index < 1 << 16 and 0 <= (sub or 0) < 1 << 8
        found = (index, sub) if is_object else None
    else:
        wanted = "1018:01, 0x1018 or (0x1018, 1)"
        raise TypeError(f"object={given!r}: a text or integers are needed, as {wanted}, not {type(given).__name__}")
    if found is None:
        raise ValueError(f"object={given!r}: an object is written 1018:01, or 1018 with all of its sub-indexes")
    return f"{found[0]:04X}", found[1]


def one_of(name: str, value: str | None, choices: Sequence[str]) -> None:
    """Raises ValueError for a word that is none of the choices."""
    if value is not None and value not in choices:
        raise ValueError(f"{name}={value!r}: one of {', '.join(choices)}")


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
        there = self if node is None else self._only(lambda one: node in one.nodes)
        return there._having(bus=bus, kind=kind, status=status)

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
