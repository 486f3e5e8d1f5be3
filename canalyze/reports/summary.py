"""A capture in figures for people: the capture, its buses, nodes, SYNC, PDOs and findings; and the properties of files.

It lays out the records that the core hands over (`canalyze/core/src/tables/jsonl/summary.rs` documents them) and
computes nothing but units. A block that has nothing to tell is left out. What a block looks like, its sheet says. The
properties of a file are a block, a line a fact; what it does not have is left out.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Final, Protocol

from msgspec import convert
from msgspec.structs import asdict

from canalyze.output import Output, dyed, printable
from canalyze.output.layout import definitions
from canalyze.records import SEVERITIES, records
from canalyze.records.summary import (
    Aborts,
    Burst,
    Bus,
    Capture,
    Identifier,
    Info,
    LeftOut,
    Node,
    Opened,
    Pdo,
    Raised,
    Spread,
    Sync,
    Topic,
)
from canalyze.reports.table import EMPTY, SPARE, Column, write
from canalyze.reports.wording import ranges
from canalyze.words import Words

LEFT: Final = frozenset(
    {"bus", "name", "node_state", "service", "states", "code", "by", "meaning", "pdo", "id", "severity", "buses"}
    | {"nodes", "message"}
)
"""Columns of words; all others hold numbers."""
_FOLDS: Final = frozenset({"name", "states", "meaning", "message", "nodes", "buses"})
_LEAVING: Final = {
    "name": SPARE,
    "synchronous": 1,
    "before_sync": 2,
    "id": 3,
    "errors": 3,
    "rate_100ms": 4,
    "rate_1s": 5,
    "burst": 6,
    "rpdo_rate": 4,
    "tpdo_rate": 5,
    "heartbeat": 6,
    "response": 7,
    "sent": 2,
    "buses": 2,
    "nodes": 3,
    "last": SPARE + 1,
    "first": SPARE + 2,
}
"""In which order columns leave a terminal that is too narrow."""
_STATES: Final = 12
"""Changes of state that are shown of one node; JSON has more."""


class Sheet(Protocol):
    """Takes the blocks; texts are as they are in the capture."""

    def facts(self, heading: str, rows: Sequence[tuple[str, str]]) -> None:
        """Writes terms with what is said of them."""

    def table(self, heading: str, keys: Sequence[str], names: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Writes a table; `keys` say what its columns are, `names` what they are called."""

    def line(self, text: str) -> None:
        """Writes a line behind a block; an empty one separates."""


def show(result: bytes, out: Output, words: Words, *, moments: bool = True) -> None:
    """Writes the JSON lines of one capture as text. moments: see `report`."""
    severities = {words.of("severity", severity): severity for severity in SEVERITIES}
    report(result, _Text(out, severities), words, moments=moments)


def report(
    result: bytes, sheet: Sheet, words: Words, *, moments: bool = True, stamp: Callable[[str], str] = str
) -> None:
    """Writes the records of one capture.

    moments: times are those of the capture; else they are shown as they are. stamp: how its first and its last stamp
    are written.
    """
    for capture in records(result, Capture):
        _Report(sheet, words, capture, moments=moments, stamp=stamp).all(result)


class _Report:
    """The blocks of one capture, on their way to a sheet."""

    def __init__(
        self, sheet: Sheet, words: Words, capture: Capture, *, moments: bool, stamp: Callable[[str], str]
    ) -> None:
        self._sheet = sheet
        self._moments = moments
        self._stamp = stamp
        self._words = words
        self._capture = capture

    def all(self, result: bytes) -> None:
        """Writes every block."""
        buses, every = list(records(result, Bus)), list(records(result, Node))
        nodes, silent = [one for one in every if one.sent], [one for one in every if not one.sent]
        self._facts()
        self._buses(buses)
        self._services(buses)
        self._nodes(nodes, silent)
        self._states([*nodes, *silent])
        self._codes("aborts", [*nodes, *silent])
        self._codes("emcy", nodes)
        self._sync(records(result, Sync))
        self._pdos(records(result, Pdo))
        self._identifiers(records(result, Identifier))
        self._findings(list(records(result, Raised)))

    def _facts(self) -> None:
        capture, words = self._capture, self._words
        frames = words("summary.frames", frames=capture.frames, files=capture.files)
        rows = [(words("summary.row_frames"), frames)]
        if capture.seconds is not None:
            ends = {"first_t": capture.first_t, "last_t": capture.last_t}
            facts = {key: time and self._stamp(time) for key, time in ends.items()}
            key = "summary.time" if capture.first_t is not None else "summary.duration"
            rows.append((words("summary.row_time"), words(key, **facts, seconds=capture.seconds)))
        quality = words("summary.row_quality")
        for line in self._quality():
            rows.append((quality, line))
            quality = ""
        self._sheet.facts(words("summary.capture"), rows)

    def _quality(self) -> list[str]:
        """Returns the remarks that readers of the figures need."""
        capture, words = self._capture, self._words
        lines = []
        if capture.unstamped == capture.frames:
            lines.append(words("summary.no_stamps"))
        elif capture.unstamped:
            lines.append(words("summary.unstamped", count=capture.unstamped))
        if capture.gaps:
            lines.append(words("summary.gaps", count=capture.gaps, frames=capture.dropped))
        left_out = capture.left_out
        if left_out:
            lines.append(words(f"summary.{left_out_key(left_out)}", **asdict(left_out)))
        if capture.unreadable:
            lines.append(words("summary.unreadable", count=capture.unreadable))
        if capture.damages:
            lines.append(words("summary.damages", count=capture.damages))
        if capture.backward:
            most = f"{_ms(capture.backward_most_us or 0)} ms"
            lines.append(words("summary.backward", count=capture.backward, most=most))
        if capture.reordered:
            lines.append(words("summary.reordered", count=capture.reordered))
        if not lines:
            lines.append(words("summary.good"))
        if capture.pause_us:
            lines.append(words("summary.pause", ms=_ms(capture.pause_us), frame=capture.pause_frame))
        return lines

    def _buses(self, buses: Sequence[Bus]) -> None:
        keys = ["bus", "frames", "rate", "rate_1s", "rate_100ms", "load", "load_1s", "load_100ms", "burst", "errors"]
        rows = [
            [
                _text(bus.bus),
                str(bus.frames),
                *map(_rate, (bus.rate, bus.peak_rate_1s, bus.peak_rate_100ms)),
                *map(_percent, (bus.load, bus.load_peak_1s, bus.load_peak_100ms)),
                self._burst(bus.burst),
                str(bus.errors),
            ]
            for bus in buses
        ]
        self._table("summary.buses", keys, rows)
        bit_rate = self._capture.bit_rate
        if bit_rate is None:
            self._line(self._words("summary.no_bit_rate"))
        elif self._capture.seconds is not None:
            self._line(self._words("summary.load", rate=f"{bit_rate / 1000:g}"))
        switched = sum(bus.fd_switched for bus in buses)
        if switched and bit_rate is not None:
            self._line(self._words("summary.fd", count=switched))

    def _burst(self, burst: Burst | None) -> str:
        if burst is None:
            return EMPTY
        return self._words("summary.burst", frames=burst.frames, ms=_ms(burst.length_us))

    def _services(self, buses: Sequence[Bus]) -> None:
        rows = [
            [_text(bus.bus), service, str(count), f"{count / (bus.frames or 1):.1%}"]
            for bus in buses
            for service, count in bus.services.items()
        ]
        self._table("summary.services", ["bus", "service", "frames", "share"], rows)

    def _nodes(self, nodes: Sequence[Node], silent: Sequence[Node]) -> None:
        keys = ["bus", "node", "name", "node_state", "sent", "boot_ups", "heartbeat", "transfers", "response", "aborts"]
        rows = [
            [
                _text(node.bus),
                str(node.node),
                _text(node.name),
                self._state(node),
                str(node.sent),
                _count(node.boot_ups),
                _times(node.heartbeat, "min_us", "mean_us", "max_us"),
                _count(node.transfers),
                _times(node.response, "min_us", "mean_us", "p99_us", "max_us"),
                _count(node.aborted),
                _count(node.emcy_count),
                _rate(node.tpdo_rate if node.tpdos else None),
                _rate(node.rpdo_rate if node.rpdos else None),
            ]
            for node in nodes
        ]
        self._table("summary.nodes", [*keys, "emcys", "tpdo_rate", "rpdo_rate"], rows)
        for bus in dict.fromkeys(node.bus for node in silent):
            ids = [node.node for node in silent if node.bus == bus]
            on_bus = f"{bus}: " if bus is not None else ""
            if not rows:
                self._line("")
            self._line(self._words("summary.silent", bus=on_bus, nodes=ranges(ids)))

    def _state(self, node: Node) -> str:
        if node.state_number is None:
            return EMPTY
        state = _word(node.state_number, node.state_text)
        if node.lost:
            return self._words("summary.lost", state=state)
        if node.states and node.states[-1].commanded:
            state = self._words("summary.commanded", state=state)
        return state

    def _states(self, nodes: Sequence[Node]) -> None:
        """Shows the states of the nodes that have had more than one."""
        rows = [[_text(node.bus), str(node.node), self._changes(node)] for node in nodes if len(node.states) > 1]
        self._table("summary.states" if self._moments else "summary.states_at", ["bus", "node", "states"], rows)

    def _changes(self, node: Node) -> str:
        from decimal import Decimal

        start = self._capture.first_t
        said: list[str] = []
        for change in node.states[:_STATES]:
            state = _word(change.number, change.text)
            if change.t is None or start is None:
                said.append(self._words("summary.at_frame", state=state, frame=change.frame))
            elif not self._moments:
                said.append(self._words("summary.at_moment", state=state, moment=change.t))
            else:
                after = Decimal(change.t) - Decimal(start)
                said.append(self._words("summary.at", state=state, seconds=f"{after:.3f}"))
        if node.changes > len(said):
            said.append(self._words("summary.more_changes", count=node.changes))
        return self._words("summary.then").join(said)

    def _codes(self, kind: str, nodes: Sequence[Node]) -> None:
        by = ["by"] if kind == "aborts" else []
        rows = [
            [
                _text(node.bus),
                str(node.node),
                f"{one.digits if isinstance(one, Aborts) else f'{one.code:04X}'}h",
                *(self._words.of("by", getattr(one, key)) for key in by),
                _text(one.text),
                str(one.count),
                str(one.first_frame),
                str(one.last_frame),
            ]
            for node in nodes
            for one in (node.aborts if by else node.emcys)
        ]
        self._table(f"summary.{kind}", ["bus", "node", "code", *by, "meaning", "count", "first", "last"], rows)

    def _sync(self, syncs: Iterable[Sync]) -> None:
        rows = []
        for sync in syncs:
            counter = EMPTY if sync.counter_min is None else f"{sync.counter_min}..{sync.counter_max}"
            rows.append(
                [
                    _text(sync.bus),
                    str(sync.frames),
                    _times(sync.period, "min_us", "mean_us", "p99_us", "max_us"),
                    _times(sync.period, "sigma_us"),
                    counter,
                    _text(sync.counter_jumps),
                ]
            )
        self._table("summary.sync", ["bus", "frames", "period", "sigma", "counter", "jumps"], rows)

    def _pdos(self, pdos: Iterable[Pdo]) -> None:
        keys = ["bus", "node", "pdo", "id", "frames", "rate", "interval", "synchronous", "delay", "before_sync"]
        rows = [
            [
                _text(pdo.bus),
                str(pdo.node),
                pdo.pdo,
                pdo.id,
                str(pdo.frames),
                _rate(pdo.rate),
                _times(pdo.interval, "min_us", "mean_us", "max_us"),
                _count(pdo.synchronous),
                _times(pdo.delay, "min_us", "mean_us", "p99_us", "max_us"),
                _count(pdo.before_sync),
            ]
            for pdo in pdos
        ]
        self._table("summary.pdos", keys, rows)

    def _identifiers(self, identifiers: Iterable[Identifier]) -> None:
        rows = [
            [
                _text(one.bus),
                one.id,
                str(one.frames),
                _rate(one.rate),
                _times(one.interval, "min_us", "mean_us", "max_us"),
                _span(one.length_min, one.length_max),
            ]
            for one in identifiers
        ]
        self._table("summary.identifiers", ["bus", "id", "frames", "rate", "interval", "length"], rows)

    def _findings(self, findings: Sequence[Raised]) -> None:
        if not findings:
            self._line("")
            self._line(self._words("summary.no_findings"))
            return
        keys = ["code", "severity", "count", "first", "last", "buses", "nodes", "message"]
        rows = [
            [
                one.code,
                self._words.of("severity", one.severity),
                str(one.count),
                self._place(one.first_frame, one.first_line),
                self._place(one.last_frame, one.last_line),
                " ".join(one.buses) or EMPTY,
                ranges(one.nodes) or EMPTY,
                one.message,
            ]
            for one in findings
        ]
        self._table("summary.findings", keys, rows)

    def _place(self, frame: int | None, line: int | None) -> str:
        """Returns the frame; a finding about the capture itself has only a line."""
        if frame is not None:
            return str(frame)
        return EMPTY if line is None else self._words("summary.line", line=line)

    def _table(self, heading: str, keys: Sequence[str], rows: list[list[str]]) -> None:
        """Writes a block; a column with nothing in it is left out."""
        if not rows:
            return
        shown = [place for place in range(len(keys)) if any(row[place] != EMPTY for row in rows)]
        names = [self._words(f"col.{keys[place]}") for place in shown]
        cells = [[row[place] for place in shown] for row in rows]
        self._sheet.table(self._words(heading), [keys[place] for place in shown], names, cells)

    def _line(self, text: str) -> None:
        self._sheet.line(text)


class _Text:
    """Blocks as lines of text, tables as wide as the terminal."""

    def __init__(self, out: Output, severities: Mapping[str, str]) -> None:
        self._out = out
        self._severities = severities

    def facts(self, heading: str, rows: Sequence[tuple[str, str]]) -> None:
        self._heading(heading)
        for line in definitions(rows):
            self.line(line)

    def table(self, heading: str, keys: Sequence[str], names: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        columns = [
            Column(
                name,
                right=key not in LEFT,
                folds=key in _FOLDS,
                leaves=_LEAVING.get(key, 0),
                colour=self._colour if key == "severity" else None,
            )
            for key, name in zip(keys, names, strict=True)
        ]
        self.line("")
        self._heading(heading)
        write(columns, rows, self._out)

    def _colour(self, cell: str) -> str:
        return self._severities.get(cell, "")

    def _heading(self, text: str) -> None:
        self._out.text(dyed(text, "own", out=self._out) + "\n")

    def line(self, text: str) -> None:
        self._out.text(printable(text).rstrip() + "\n")


def _text(value: object) -> str:
    return EMPTY if value is None else str(value)


def _word(state: int, text: str | None) -> str:
    """Returns the word for a state; its number where it has none."""
    return text or f"{state:02X}h"


def _count(number: int) -> str:
    return str(number) if number else EMPTY


def _rate(rate: float | None) -> str:
    return EMPTY if rate is None else f"{rate:.1f}"


def _percent(load: float | None) -> str:
    return EMPTY if load is None else f"{load:.1f}%"


def _ms(us: float) -> str:
    """Returns microseconds as milliseconds, with the digits that count."""
    ms = us / 1000
    digits = 3 if ms < 9.9995 else 2 if ms < 99.995 else 1
    return f"{ms:.{digits}f}"


def _times(spread: Spread | None, *keys: str) -> str:
    return EMPTY if spread is None else "/".join(_ms(getattr(spread, key)) for key in keys)


def _span(least: int, most: int) -> str:
    return str(least) if least == most else f"{least}-{most}"


def left_out_key(left_out: LeftOut) -> str:
    """Returns the key of the sentence about rows that are left out, by how many places tell their number."""
    if left_out.uncounted == left_out.places:
        return "left_out_unknown"
    return "left_out_partly" if left_out.uncounted else "left_out"


_DOUBTFUL: Final = ("doubtful", "definition", "unlocated")
"""Kinds of damage whose frames are there, and may be wrong."""
_LISTED: Final = 20
"""Topics, buses, damages and the like that are shown of each; JSON has more."""


def show_file(row: Mapping[str, Any], out: Output, words: Words, *, first: bool) -> None:
    """Writes the block of one file, a blank line before it if it is not the first one."""
    record, opened = convert(row, Info), convert(row, Opened)
    rows: list[tuple[str, str]] = []
    before = ""
    for term, fact in _rows(record, opened, words):
        rows.append(("" if term == before else term, printable(fact)))
        before = term
    lines = [*([] if first else [""]), printable(record.file), *definitions(rows)]
    out.text("".join(f"{line}\n" for line in lines))


def _rows(record: Info, opened: Opened, words: Words) -> Iterator[tuple[str, str]]:
    """Returns term and fact; a term that comes again is written once."""
    contents = record.contents

    def row(key: str, fact: str) -> tuple[str, str]:
        return words(f"info.{key}"), fact

    key = "info.packed" if opened.compression else "info.plain"
    title = words.of("info.title", opened.format)
    fact = words(key, format=title, compression=opened.compression, size=f"{opened.size:,}")
    unchecked = [words("info.unchecked")] if opened.checked is False else []
    yield row("format_row", words("info.then").join([fact, *unchecked]))
    for name, value in contents.dialect.items():
        yield row("dialect", f"{name}: {value}")
    yield row("frames", _frames(record, words))
    for fact in _moments(record, words):
        yield row("time", fact)
    for bus in record.buses[:_LISTED]:
        yield row("buses", words("info.bus", bus=bus.bus or words("info.nameless"), frames=bus.frames))
    yield from (row("buses", more) for more in _more(record.buses, len(record.buses), words))
    for topic in contents.topics[:_LISTED]:
        yield row("topics", _topic(topic, words))
    yield from (row("topics", more) for more in _more(contents.topics, len(contents.topics), words))
    if any(topic.messages and not topic.read_as for topic in contents.topics):
        yield row("topics", words("info.map"))
    for kind in contents.passed_over[:_LISTED]:
        yield row("passed_over", f"{kind.kind}: {kind.count}")
    yield from (row("passed_over", more) for more in _more(contents.passed_over, len(contents.passed_over), words))
    for fact in _losses(record, opened, words):
        yield row("quality", fact)


def _more(items: Sequence[object], count: int, words: Words) -> Iterator[str]:
    shown = min(len(items), _LISTED)
    if count > shown:
        yield words("info.more", count=count - shown)


def _frames(record: Info, words: Words) -> str:
    parts = [str(record.frames)]
    kinds = record.kinds
    parts += [words(f"info.{kind}", count=count) for kind, count in kinds.items() if count]
    parts += [words(f"info.{way}", count=count) for way, count in record.directions.items() if count]
    return words("info.then").join(parts)


def _moments(record: Info, words: Words) -> Iterator[str]:
    if record.first_t is None:
        if record.frames:
            yield words("info.no_stamps")
        return
    if record.zone:
        zone = words(f"info.{record.zone}")
        yield words("info.dates", first=record.first_date, last=record.last_date, zone=zone)
    else:
        yield words("info.stamps", first=record.first_t, last=record.last_t)
    fewest, most = record.decimals or (0, 0)
    digits = str(most) if fewest == most else f"{fewest}-{most}"
    yield words("info.span", seconds=record.seconds, digits=digits)
    if record.unstamped:
        yield words("info.unstamped", count=record.unstamped)
    if record.backward:
        yield words("info.backward", count=record.backward, most=f"{record.backward_most_us / 1000:g}")


def _topic(topic: Topic, words: Words) -> str:
    kind = " ".join(part for part in (topic.schema, f"({topic.encoding})" if topic.encoding else "") if part)
    read = words("info.read_as", fields=topic.read_as) if topic.read_as else words("info.not_read")
    parts = [topic.name, kind, words("info.messages", count=topic.messages), read, topic.bus]
    return words("info.then").join(part for part in parts if part)


def _losses(record: Info, opened: Opened, words: Words) -> Iterator[str]:
    """Returns lines about losses."""
    unreadable = record.unreadable
    if unreadable:
        line, offset = unreadable.first_line, unreadable.first_offset
        if line is None and offset is None:
            yield words("info.unreadable_somewhere", count=unreadable.count)
        else:
            yield words("info.unreadable", count=unreadable.count, place=_place(line, offset, words))
        if unreadable.further_buses:
            yield words("info.further_buses", count=unreadable.further_buses)
    if record.clamped_stamps:
        yield words("info.clamped_stamps", count=record.clamped_stamps)
    if record.gaps:
        yield words("info.gaps", count=record.gaps, frames=record.dropped)
    left_out = record.left_out
    if left_out:
        yield words(f"info.{left_out_key(left_out)}", **asdict(left_out))
    if record.error_markers:
        yield words("info.error_markers", count=record.error_markers)
    for damage in record.damage[:_LISTED]:
        of_frames = "doubtful" if damage.kind in _DOUBTFUL else "lost"
        counted = {"bytes": "info.lost_bytes", "frames": f"info.{of_frames}_frames"}
        lost = [words(said, count=count) for key, said in counted.items() if (count := getattr(damage, key))]
        fact = words(
            "info.damage", place=_place(damage.line, damage.offset, words), kind=words.of("damage", damage.kind)
        )
        yield words("info.then").join([fact, *lost])
    yield from _more(record.damage, record.damages, words)
    if opened.format == "mcap" and any(damage.kind == "cut" for damage in record.damage):
        yield words("info.unfinished", name=record.file)
    wrong = ("unreadable", "clamped_stamps", "gaps", "left_out", "error_markers", "damages")
    if not any(getattr(record, key) for key in wrong):
        yield words("info.whole")


def _place(line: int | None, offset: int | None, words: Words) -> str:
    return words("info.line", line=line) if line is not None else words("info.offset", offset=offset)
