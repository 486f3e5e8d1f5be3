"""A first version of a file of expectations, from what the core says of a good capture.

How much room a figure gets is decided here, and each figure stands beside what was seen. Must not: measure anything;
that is the core's (`observed`), in the way in which it judges.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final, TypeVar

from msgspec import Struct

from canalyze.output import commandless, hexadecimal, printable
from canalyze.output.layout import wrap
from canalyze.records import records
from canalyze.records.objects import Transfer
from canalyze.records.problems import Problem
from canalyze.records.summary import Bus, Capture, Node, Raised
from canalyze.words import Words

# What the core observes; times in microseconds, as an expectation judges.


class Period(Struct, frozen=True, gc=False):
    """The times from one to the next."""

    count: int
    min_us: float | None
    """The least of those that may be too short."""
    mean_us: float
    max_us: float


class _Train(Struct, frozen=True, gc=False):
    bus: str | None
    silence_us: float | None
    """The time from the last one to the end of the capture; None where something has stopped them."""
    period: Period | None


class Sync(_Train, frozen=True, gc=False, tag_field="kind", tag="observed_sync"):
    """SYNC of a bus."""


class Heartbeat(_Train, frozen=True, gc=False, tag_field="kind", tag="observed_heartbeat"):
    """Heartbeats of a node."""

    node: int


class Pdo(_Train, frozen=True, gc=False, tag_field="kind", tag="observed_pdo"):
    """A PDO."""

    node: int
    pdo: str


class Signal(Struct, frozen=True, gc=False, tag_field="kind", tag="observed_signal"):
    """A signal, and the range of its values."""

    bus: str | None
    node: int
    pdo: str
    signal: str
    select: str
    """Its name in every language."""
    unit: str | None
    min: float | None
    """None where it is no quantity."""
    max: float | None


class NodeState(Struct, frozen=True, gc=False, tag_field="kind", tag="observed_state"):
    """An NMT state of a node."""

    bus: str | None
    node: int
    state: str
    since_boot_up_ns: int | None


class DriveState(NodeState, frozen=True, gc=False, tag_field="kind", tag="observed_drive"):
    """A state of an axis of a drive."""

    axis: int


class Emcy(Struct, frozen=True, gc=False, tag_field="kind", tag="observed_emcy"):
    """An EMCY error code of a node."""

    bus: str | None
    node: int
    code: str
    count: int


R = TypeVar("R", bound=Struct)
_Place = tuple[str | None, int, str, int]
"""Bus, node, index and sub-index."""
KINDS: Final = (
    *(Bus, Capture, DriveState, Emcy, Heartbeat, Node, NodeState),
    *(Pdo, Problem, Raised, Signal, Sync, Transfer),
)
"""The records that a draft is made of."""

MOST_WRITES: Final = 200
"""SDO downloads that are written down; the rest is counted."""
MOST_ALIKE: Final = 8
"""Downloads of one object; what is written more often is no configuration but a setpoint."""
MOST_SIGNALS: Final = 500
"""Signals that get a range; the rest is counted."""
_LONGEST: Final = 32
"""Bytes of a value that is expected as it was; of a longer one only that it was sent."""
_EXACT: Final = 1 << 53
"""The greatest integer that is written as a number."""
_IDENTITY: Final = frozenset({("1000", 0), ("1008", 0), ("1018", 1), ("1018", 2), ("1018", 3)})
"""Objects that say which device it is, but for its serial number: another one of its kind is as good."""
_FEWEST: Final = 5
"""Intervals from which a period is told."""
_LOOSE: Final = 0.5
"""The share of a period that it may be off: another recording on a busier host must pass, a missing frame must not."""
_TIGHT: Final = 0.2
"""That of SYNC, which is a clock."""
_UNTIMED: Final = {
    "heartbeat": "expect.no_heartbeat_period",
    "sync": "expect.no_sync_period",
    "signal": "expect.no_pdo_period",
}
"""The words for rows without a period, by table."""
_COMMENT: Final = 90
"""Characters of a comment behind a value."""


class Draft:
    """The knowledge of a capture, line by line; its size does not grow with the capture."""

    def __init__(self) -> None:
        """Starts empty."""
        self._capture: Capture | None = None
        self._rows: dict[type[Struct], list[Any]] = {}
        self._writes: list[Transfer] = []
        self._alike: dict[_Place, int] = {}
        self._identity: dict[_Place, Transfer | None] = {}
        self._left = {"more": 0, "aborted": 0, "incomplete": 0}

    @property
    def frames(self) -> int:
        """Frames of the capture."""
        return self._capture.frames if self._capture else 0

    @property
    def findings(self) -> list[str]:
        """Codes of the findings above info: a good capture has none."""
        return [one.code for one in self._of(Raised) if one.severity != "info"]

    def take(self, result: bytes) -> None:
        """Adds JSON lines of the core."""
        for one in records(result, *KINDS):
            if isinstance(one, Transfer):
                self._transfer(one)
            elif isinstance(one, Capture):
                self._capture = one
            else:
                self._rows.setdefault(type(one), []).append(one)

    def _of(self, kind: type[R]) -> list[R]:
        return self._rows.get(kind, [])

    def _transfer(self, row: Transfer) -> None:
        if row.status != "ok":
            self._left["aborted" if row.status == "aborted" else "incomplete"] += 1
            return
        if (place := _place(row)) is None:
            return
        if row.direction == "upload":
            if place[2:] in _IDENTITY:
                known = self._identity.setdefault(place, row)
                if known is not None and known.data != row.data:
                    self._identity[place] = None  # it says now this and now that: nothing to expect
            return
        if place in self._alike or len(self._alike) < MOST_WRITES:
            self._alike[place] = self._alike.get(place, 0) + 1
        if len(self._writes) < MOST_WRITES and self._alike.get(place, MOST_WRITES) <= MOST_ALIKE:
            self._writes.append(row)
        else:
            self._left["more"] += 1

    def text(self, words: Words, name: str) -> str:
        """Returns the content of the file; `name` is that of the capture."""
        self._words = words
        seconds = (self._capture and self._capture.seconds) or "?"
        shown = commandless(printable(name).encode()).decode()
        lines = [
            *self._said("expect.head", name=shown, frames=self.frames, seconds=seconds),
            *self._said("expect.head_use"),
        ]
        if self.findings:
            lines += self._said("expect.head_findings", codes=", ".join(self.findings))
        for section in (
            self._writing,
            self._reading,
            self._states,
            self._heartbeats,
            self._syncs,
            self._pdos,
            self._signals,
            self._emcys,
            self._incidents,
            self._latencies,
            self._loads,
        ):
            part = list(section())
            if part:
                lines += ["", *part] if lines[-1] else part
        return "".join(f"{line}\n" for line in lines)

    def _said(self, key: str, **facts: object) -> list[str]:
        return [f"# {line}" for line in wrap(self._words(key, **facts), 110)]

    def _entry(self, table: str, bus: str | None, *pairs: "Pair") -> list[str]:
        """Returns one table, with the bus if there are several."""
        on = [("bus", _text(bus), "")] if bus and self._are_several else []
        lines = [f"[[{table}]]"]
        for key, value, seen in (*pairs[:1], *on, *pairs[1:]):
            lines.append(f"{key} = {value}" + (f"  # {_short(seen)}" if seen else ""))
        return [*lines, ""]

    @property
    def _are_several(self) -> bool:
        """True if the capture has several buses."""
        return self._capture is not None and self._capture.buses > 1

    def _whose(self, row: Transfer) -> str:
        """Returns the name of a node's sequence."""
        return f"{row.bus} node {row.node}" if row.bus and self._are_several else f"node {row.node}"

    def _writing(self) -> Iterator[str]:
        often = {place for place, count in self._alike.items() if count > MOST_ALIKE}
        writes = [row for row in self._writes if _place(row) not in often]
        more = self._left["more"] + len(self._writes) - len(writes)
        if writes:
            yield from self._said("expect.writes", count=len(writes))
        if more:
            yield from self._said("expect.writes_left", count=more, most=MOST_WRITES, alike=MOST_ALIKE)
        for row in writes:
            sequence = ("sequence", _text(self._whose(row)), "")
            yield from self._entry("sdo", row.bus, *_transfer(row), sequence)

    def _reading(self) -> Iterator[str]:
        rows = {place: row for place, row in self._identity.items() if row is not None}
        if rows:
            yield from self._said("expect.reads")
        for place in sorted(rows, key=lambda place: (str(place[0]), *place[1:])):
            yield from self._entry("sdo", place[0], *_transfer(rows[place]))
        if self._left["aborted"] or self._left["incomplete"]:
            yield from self._said("expect.transfers_left", **self._left)
            yield ""

    def _states(self) -> Iterator[str]:
        rows = [*self._of(NodeState), *(row for row in self._of(DriveState) if row.state == "operation-enabled")]
        if rows:
            yield from self._said("expect.states")
        boots = {(node.bus, node.node): node.boot_ups for node in self._of(Node)}
        quickest: dict[tuple[str | None, int], float] = {}
        for row in rows:
            if not isinstance(row, DriveState) and row.state != "boot-up" and row.since_boot_up_ns is not None:
                whose = (row.bus, row.node)
                quickest[whose] = min(quickest.get(whose, math.inf), row.since_boot_up_ns)
        for row in rows:
            pairs = [("node", str(row.node), "")]
            pairs.append(("drive" if isinstance(row, DriveState) else "state", _text(row.state), ""))
            if isinstance(row, DriveState) and row.axis != 1:
                pairs.append(("axis", str(row.axis), ""))
            after, whose = row.since_boot_up_ns, (row.bus, row.node)
            # What belongs to booting: it is due after every boot-up, which a capture with several may not show.
            booting = row.state in ("operational", "operation-enabled") or after == quickest.get(whose)
            if after is not None and booting and boots.get(whose) == 1:
                seen = self._words("expect.after_boot_up", seconds=_number(round(after / 1e9, 3)))
                pairs += [("by_s", _number(round_up(max(3 * after / 1e9, 1))), seen), ("since", '"boot-up"', "")]
            yield from self._entry("state", row.bus, *pairs)

    def _heartbeats(self) -> Iterator[str]:
        yield from self._periods("heartbeat", self._of(Heartbeat), "expect.heartbeats", _LOOSE, 2)

    def _syncs(self) -> Iterator[str]:
        yield from self._periods("sync", self._of(Sync), "expect.syncs", _TIGHT, _FEWEST)

    def _pdos(self) -> Iterator[str]:
        # A PDO is selected by its signals: without a known mapping it has none.
        mapped = {(signal.bus, signal.node, signal.pdo) for signal in self._of(Signal)}
        rows = [row for row in self._of(Pdo) if (row.bus, row.node, row.pdo) in mapped]
        yield from self._periods("signal", rows, "expect.pdos", _LOOSE, _FEWEST)

    def _periods(
        self, table: str, rows: Sequence[Sync | Heartbeat | Pdo], heading: str, share: float, fewest: int
    ) -> Iterator[str]:
        entries: list[str] = []
        timed = [(row, row.period) for row in rows if row.period]
        for row, times in timed:
            period = times.count >= fewest and period_of(times, share)
            if not period or (row.silence_us or 0) > sum(period):  # it stopped: that would be a finding
                continue
            unit, scale = ("ms", 1000) if period[0] >= 1000 else ("us", 1)
            who = [("node", str(row.node), "")] if isinstance(row, Heartbeat) else []
            if isinstance(row, Pdo):
                who = [("select", _text(f"{row.node}.{row.pdo}.*"), "")]
            said = self._seen(times)
            entries += self._entry(
                table,
                row.bus,
                *who,
                (f"period_{unit}", _number(period[0] / scale), said),
                (f"tolerance_{unit}", _number(period[1] / scale), ""),
            )
        if entries:
            yield from self._said(heading)
        yield from entries
        left = len(timed) - sum(line.startswith("[[") for line in entries)
        if left:
            yield from self._said(_UNTIMED[table], count=left)
            yield ""

    def _seen(self, times: Period) -> str:
        """Returns the intervals of a period, not the mean: some may be shorter than the least."""
        most = f"{times.max_us / 1000:.3f}"
        if times.min_us is None:
            return self._words("expect.seen_longest", most=most, count=times.count)
        return self._words("expect.seen_period", least=f"{times.min_us / 1000:.3f}", most=most, count=times.count)

    def _signals(self) -> Iterator[str]:
        rows = [(row, row.min, row.max) for row in self._of(Signal) if row.min is not None and row.max is not None]
        if rows:
            yield from self._said("expect.signals")
        for row, least, most in rows[:MOST_SIGNALS]:
            low, high = range_of(least, most)
            unit = f" {row.unit}" if row.unit else ""
            seen = f"{row.signal}: {_number(least)} .. {_number(most)}{unit}"
            yield from self._entry(
                "signal",
                row.bus,
                ("select", _text(row.select), seen),
                ("min", _number(low), ""),
                ("max", _number(high), ""),
            )
        if len(rows) > MOST_SIGNALS:
            yield from self._said("expect.signals_left", count=len(rows) - MOST_SIGNALS)
            yield ""

    def _emcys(self) -> Iterator[str]:
        yield from self._said("expect.emcys")
        for row in self._of(Emcy):
            seen = self._words("expect.seen_times", count=row.count)
            pairs = [("node", str(row.node), ""), ("code", _text(row.code), seen), ("occurs", '"may"', "")]
            yield from self._entry("emcy", row.bus, *pairs)
        yield from self._entry("emcy", None, ("occurs", '"never"', ""))

    def _incidents(self) -> Iterator[str]:
        yield from self._said("expect.problems")
        seen: dict[tuple[str | None, str, int | None], Problem] = {}
        for row in self._of(Problem):
            if row.is_root and row.status != "harmless":
                seen.setdefault((row.bus, row.kind, row.node), row)
        for (bus, kind, node), row in seen.items():
            said = self._words("expect.seen_at", frame=row.begin.frame, message=row.message)
            whose = [("node", str(node), "")] if node else []
            pairs = [("kind", _text(kind), said), *whose, ("occurs", '"0-"', "")]
            yield from self._entry("problem", bus, *pairs)
        yield from self._entry("problem", None, ("occurs", "0", ""))

    def _latencies(self) -> Iterator[str]:
        slowest: dict[str | None, tuple[float, int]] = {}
        for row in self._of(Node):
            most = row.response.max_us if row.response else 0
            if most > slowest.get(row.bus, (0.0, 0))[0]:
                slowest[row.bus] = most, row.node
        if slowest:
            yield from self._said("expect.latencies")
        for bus, (most, node) in slowest.items():
            milliseconds = most / 1000
            seen = self._words("expect.seen_slowest", milliseconds=f"{milliseconds:.3f}", node=node)
            limit = _number(round_up(max(5 * milliseconds, 50)))
            yield from self._entry("latency", bus, ("of", '"sdo"', ""), ("max_ms", limit, seen))

    def _loads(self) -> Iterator[str]:
        rate = self._capture and self._capture.bit_rate
        rows = [(row.bus, row.load_peak_100ms) for row in self._of(Bus) if rate and row.load_peak_100ms is not None]
        if rows:
            yield from self._said("expect.loads")
        for bus, peak in rows:
            limit = min(5 * math.ceil((1.25 * peak + 2) / 5), 100)
            seen = self._words("expect.seen_load", percent=f"{peak:.1f}")
            yield from self._entry("load", bus, ("max_percent", str(limit), seen), ("bitrate", str(rate), ""))


Pair = tuple[str, str, str]
"""A key, its value as TOML, and what was seen."""


def _place(row: Transfer) -> _Place | None:
    return None if row.index is None or row.sub is None else (row.bus, row.node, row.index, row.sub)


def _transfer(row: Transfer) -> list[Pair]:
    """Returns the expectation of a transfer: its object, its direction, and its value if it is short."""
    pairs = [
        ("node", str(row.node), ""),
        ("object", _text(f"{row.index}:{row.sub:02X}"), row.name or ""),
        ("direction", _text(row.direction), ""),
    ]
    value = _value(row)
    if value:
        pairs.append((*value, row.text))
    return pairs


def _value(row: Transfer) -> tuple[str, str] | None:
    """Returns the key and the value of a transfer's data: typed if its type is known, else its bytes."""
    value, kind, data = row.value, row.type, row.data
    if isinstance(value, bool):
        return "value", str(value).lower()
    if isinstance(value, int) and kind and abs(value) <= _EXACT:
        return "value", hexadecimal(value, row.text) or str(value)
    if isinstance(value, float):
        return "value", repr(value)
    if not data or len(data) != row.size or row.size > _LONGEST:
        return None
    if isinstance(value, str) and kind == "VISIBLE_STRING" and value.isascii() and value.isprintable() and value:
        return "value", _text(value)
    return "data", _text(data.hex(" ").upper())


def _text(text: str) -> str:
    """Returns a text as a TOML string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("##[", "##\\u005b")
    return '"' + "".join(c if c.isprintable() else _escaped(c) for c in escaped) + '"'


def _escaped(char: str) -> str:
    code = ord(char)
    if 0xD800 <= code <= 0xDFFF:  # no character, which TOML cannot hold
        return "?"
    return f"\\u{code:04X}" if code < 0x10000 else f"\\U{code:08X}"


def _short(seen: str) -> str:
    """Returns a comment in one line of bounded length."""
    text = printable(seen)
    return text if len(text) <= _COMMENT else text[: _COMMENT - 3] + "..."


def _number(value: float) -> str:
    """Writes a number without an exponent where it has none to need."""
    if value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return repr(float(f"{value:.12g}"))


def round_up(value: float) -> float:
    """Returns the least of 1, 2, 5, 10, 20, ... (and 0.5, 0.2, ...) that is not below a value above 0."""
    power = 10.0 ** math.floor(math.log10(value))
    steps = (step * power for step in (1, 2, 5, 10))
    return float(f"{next((step for step in steps if value <= step * (1 + 1e-9)), 10 * power):.6g}")


def period_of(times: Period, share: float) -> tuple[float, float] | None:
    """Returns the period of times in µs, and a tolerance of at least that share of it; None if there is none."""
    mean, min_us = times.mean_us, times.min_us
    if min_us is not None and mean < min_us:  # the mean has also those that may be too short
        mean = (min_us + times.max_us) / 2
    if mean <= 0:
        return None
    period = next(
        near for digits in (1, 2, 3, 17) if abs((near := float(f"{mean:.{digits - 1}e}")) - mean) <= mean / 100
    )
    least = mean if min_us is None else min_us
    off = max(times.max_us - period, period - least)
    # Below the period itself: that a frame is missing must show.
    tolerance = max(share * period, min(round_up(1.5 * off) if off else 0.0, 0.75 * period))
    return (period, tolerance) if off <= period / 2 else None


def range_of(least: float, most: float) -> tuple[float, float]:
    """Returns a range with room on both sides, in round numbers; one that was never negative stays so."""
    room = max((most - least) / 4, max(abs(least), abs(most)) / 10) or 1.0
    step = 10.0 ** math.floor(math.log10(room))
    low, high = math.floor((least - room) / step) * step, math.ceil((most + room) / step) * step
    low = max(low, 0.0) if least >= 0 else low
    high = min(high, 0.0) if most <= 0 and least < 0 else high
    return float(f"{low:.12g}"), float(f"{high:.12g}")
