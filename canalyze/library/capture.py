"""A capture as a Python program has it: iterated over, or asked for its transfers, signals, findings, nodes.

It reads by `reading`, with the core's sessions, only when it is asked, and keeps what it was asked for. One pass gives
transfers, findings and nodes together, one the signals, one frames with everything else. It must not write anything,
listen to signals of the system, or know what a frame means.
"""

import difflib
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing
from datetime import UTC, datetime
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeVar, cast, overload
from weakref import WeakSet

from msgspec import Struct

from canalyze.library.columns import Table, html_table, needs, present, renamed
from canalyze.library.plan import Input, Plan, shown_as
from canalyze.library.rows import Events, Findings, Frames, Nodes, Problems, Rows, Transfers, number, one_of
from canalyze.library.stream import Silent
from canalyze.records import SEVERITIES, Severity, Value, records
from canalyze.records.frames import Event, Frame, Signal, events
from canalyze.records.objects import Transfer
from canalyze.records.problems import Finding, Line, Overview, Problem, lines
from canalyze.records.summary import Node
from canalyze.running.reading import Counted, Reading
from canalyze.values import DATES_NS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from canalyze._core import Batch, Session
    from canalyze.library import StrPath


class _Values(Rows[Signal]):
    """Values of signals as a table."""

    _what = "values"
    _table = "signals"
    _row_type = Signal
    _values: ClassVar = {
        "object": lambda one: f"{one.index}:{one.sub:02X}",
        "value": number,
        "integer": lambda one: one.value if isinstance(one.value, int) else None,
        "raw": lambda one: one.raw if isinstance(one.raw, int) else None,
    }
    _first = ("frame", "t_ns", "node", "pdo", "signal", "value", "unit", "text")


class Series(_Values):
    """All values of one signal, in the order of frames."""

    @property
    def name(self) -> str:
        """The name by which it is found: 5.TPDO4.velocity actual value."""
        return "".join(f"{row.node}.{row.pdo}.{row.signal}" for row in self._rows[:1])

    @property
    def unit(self) -> str | None:
        """The unit of the values."""
        return self._rows[0].unit if self._rows else None

    @property
    def values(self) -> list[Value]:
        """The values, with sign, type and factor applied."""
        return [row.value for row in self._rows]

    @property
    def times_ns(self) -> list[int | None]:
        """The times of the values in nanoseconds, as the capture has them; None without stamps."""
        return [row.t_ns for row in self._rows]

    @property
    def times(self) -> list[float | None]:
        """The times of the values in seconds, as the capture has them; None without stamps."""
        return [row.t_s for row in self._rows]

    def plot(self, axes: "Axes | None" = None, **options: Any) -> "Axes":
        """Draws the values as steps over their times with matplotlib; returns the axes (extra `plot`).

        axes: where it is drawn; a new figure otherwise. options: those of `Axes.step`, such as `color`. Times that are
        dates are in UTC; without stamps the numbers of the frames take their place. ValueError where no value is a
        number, CanalyzeError without matplotlib.
        """
        self._numbers()
        if axes is None:
            axes = needs("matplotlib.pyplot", "plot").figure().add_subplot()
        drawn = [row for row in self._rows if isinstance(row.value, int | float)]
        times = [row.t_s for row in drawn]
        at: list[Any]
        if None in times:
            at, label = [row.frame for row in drawn], "frame"
        elif (times[0] or 0) * 1e9 >= DATES_NS:
            at, label = [datetime.fromtimestamp(time or 0, UTC) for time in times], "UTC"
        else:
            at, label = times, "s"
        axes.step(at, [row.value for row in drawn], **{"where": "post", "label": self.name} | options)
        axes.set_xlabel(label)
        axes.set_ylabel(self.unit or "")
        return axes

    @property
    def frames(self) -> list[int]:
        """The frames of the values."""
        return [row.frame for row in self._rows]

    @property
    def min(self) -> float:
        """The least value. ValueError where no value is a number."""
        return min(self._numbers())

    @property
    def max(self) -> float:
        """The greatest value. ValueError where no value is a number."""
        return max(self._numbers())

    @property
    def last(self) -> Value:
        """The last value; None where there is none."""
        return self._rows[-1].value if self._rows else None

    def _numbers(self) -> list[int | float]:
        numbers = [row.value for row in self._rows if isinstance(row.value, int | float)]
        if not numbers:
            raise ValueError(f"{self.name}: no value is a number")
        return numbers

    def __repr__(self) -> str:
        try:
            between = f", {self.min} to {self.max}" + (f" {self.unit}" if self.unit else "")
        except ValueError:
            between = ""
        return f"<Series {self.name}: {len(self)} values{between}>"


class Signals(_Values):
    """Every value of every signal, in the order of frames; `signals["5.TPDO4.velocity actual value"]` is a series."""

    @cached_property
    def _groups(self) -> dict[tuple[str | None, int, str, str, int, str], list[Signal]]:
        found: dict[tuple[str | None, int, str, str, int, str], list[Signal]] = {}
        for row in self._rows:
            found.setdefault((row.bus, row.node, row.pdo, row.index, row.sub, row.signal), []).append(row)
        return found

    def _one(self, row: Signal) -> str:
        return f"{row.node}.{row.pdo}.{row.signal}"

    @property
    def names(self) -> list[str]:
        """The names of all signals, with the bus before them (can1:5.TPDO1.statusword) where there are several."""
        return [self._name(key) for key in self._groups]

    def _name(self, key: tuple[str | None, int, str, str, int, str]) -> str:
        bus, node, pdo, _, _, signal = key
        several = len({key[0] for key in self._groups}) > 1
        return (f"{bus}:" if several else "") + f"{node}.{pdo}.{signal}"

    @overload
    def __getitem__(self, place: int) -> Signal: ...
    @overload
    def __getitem__(self, place: slice) -> "Signals": ...
    @overload
    def __getitem__(self, place: str) -> Series: ...
    def __getitem__(self, place: int | slice | str) -> "Signal | Signals | Series":
        """Returns one value, some, or the series of a signal.

        A signal is named as for --select: by its name or its object (6041:00), alone, behind the node (`5.`) or behind
        node and PDO (`5.TPDO4.`), with the bus before it where needed (`can1:`); case does not matter. KeyError if no
        signal is called so, or several.
        """
        if isinstance(place, int):
            return self._rows[place]
        if isinstance(place, slice):
            return Signals(self._rows[place])
        if not isinstance(place, str):
            raise TypeError(f"signals[{place!r}]: a name or a number is needed, not {type(place).__name__}")
        wanted = place.lower()
        found = [key for key in self._groups if wanted in _names(key)]
        if len(found) == 1:
            return Series(self._groups[found[0]])
        if found:
            several = ", ".join(map(self._name, found))
            raise KeyError(f"{place!r} is the name of several signals: {several}")
        near = difflib.get_close_matches(place, self.names, 3, 0.4) or self.names[:3]
        hint = f"; there are {', '.join(near)}" if near else ""
        raise KeyError(f"no signal {place!r}{hint}")


def _names(key: tuple[str | None, int, str, str, int, str]) -> set[str]:
    bus, node, pdo, index, sub, signal = key
    own = [signal, index, f"{index}:{sub:02X}", f"{index}h:{sub:02X}"]
    names = [prefix + name for name in own for prefix in ("", f"{node}.", f"{node}.{pdo}.")]
    return {name.lower() for name in [*names, *(f"{bus}:{name}" for name in names)]}


T = TypeVar("T")
S = TypeVar("S", bound=Struct)


class Capture:
    """A capture of one file or several, by `canalyze.open`; a context manager.

    Iterating gives every `Event` in order and keeps none of them: memory does not grow. What is asked for as a list is
    read once and kept.
    """

    def __init__(self, plan: Plan, inputs: tuple[Input, ...]) -> None:
        """Creates a capture that is read by a plan; nothing is read yet."""
        self._plan = plan
        self._inputs = inputs
        self._complaints: tuple[str, ...] | None = None
        self._records: dict[type[Struct], list[Any]] | None = None
        self._lists: dict[str, Any] = {}
        self._checked: list[Finding] = []
        self._running: WeakSet[Generator[Event, None, None]] = WeakSet()

    @property
    def paths(self) -> tuple[Path, ...]:
        """Its files, as absolute paths; none of what is in memory."""
        return tuple(one.path for one in self._inputs if one.path is not None)

    @property
    def name(self) -> str:
        """Its files for people: relative to the directory where it was opened, joined by commas."""
        return ", ".join(one.name for one in self._inputs)

    def __repr__(self) -> str:
        return f"<Capture {self.name}>"

    def _repr_html_(self) -> str:
        """Returns its name, and the number of rows that were read, for a notebook."""
        rows = [(name, len(rows)) for name, rows in {**self._lists, **self._read}.items()]
        return html_table(("read", "rows"), rows, self.name)

    def __enter__(self) -> Self:
        """Returns the capture itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Closes it."""
        self.close()

    def close(self) -> None:
        """Ends all iterations, so that no file stays open; lists that were read stay."""
        for one in list(self._running):
            one.close()

    def __iter__(self) -> Iterator[Event]:
        """Yields frames, notes, findings and transfers in order, from the file unless `events` were read.

        SourceError where a file cannot be read, or no further, or holds no frame.
        """
        if "events" in self._read:
            return iter(self.events)
        stream = self._stream()
        self._running.add(stream)
        return stream

    @cached_property
    def events(self) -> Events:
        """All of them, in order: frames, notes, findings, transfers. About 0.8 KiB of memory a frame."""
        with closing(self._stream()) as stream:
            return Events(stream)

    @cached_property
    def frames(self) -> Frames:
        """All frames, out of `events`."""
        return Frames(one for one in self.events if isinstance(one, Frame))

    @property
    def transfers(self) -> Transfers:
        """SDO transfers, in the order in which they end."""
        return self._list(Transfer, Transfers)

    @property
    def findings(self) -> Findings:
        """Findings, in the order of frames; of one kind on one object ten, then one that counts the rest."""
        return self._list(Finding, Findings)

    @cached_property
    def problems(self) -> Problems:
        """The problems with their status and causes: `capture.problems.roots`, `.open`, `.of(node=5)`."""
        found, whole = self.diagnosed
        return Problems(found, whole.order)

    @cached_property
    def diagnosed(self) -> tuple[list[Problem], Overview]:
        """The problems, and the overview of the whole capture."""
        result = self.through("diagnosis")[1]
        return list(records(result, Problem)), next(records(result, Overview))

    incidents = renamed("incidents", "problems")

    def diagnosis(self, problems: Iterable[Problem] | None = None) -> list[str]:
        """Returns the lines of `canalyze diagnose` about some of `problems`, with their consequences and checks.

        None: the open roots, the most important first.
        """
        from canalyze.reports.diagnosis import stories

        asked = self.problems.roots.open if problems is None else problems
        found, _ = self.diagnosed
        by_id = {one.id: one for one in found}
        return stories([by_id[one.id] for one in asked if one.id in by_id], found, self._plan.words)

    stories = renamed("stories", "diagnosis")

    @property
    def nodes(self) -> Nodes:
        """Nodes with their states, heartbeats, SDO figures and EMCYs, and their descriptions."""
        return self._list(Node, partial(Nodes, dictionary=self._plan.dictionary))

    @cached_property
    def signals(self) -> Signals:
        """Signals of PDOs, one row a value; `signals["5.TPDO4.velocity actual value"]` is a series."""
        with closing(self._typed("signals", Signal)) as rows:
            return Signals(rows)

    @property
    def complaints(self) -> tuple[str, ...]:
        """Remarks on the files, in words: damage, lines that cannot be read, repaired descriptions."""
        if self._complaints is None:
            self._read_records()
        return self._plan.said + (self._complaints or ())

    def lines(self, first: int, last: int | None = None) -> list[Line]:
        """Returns the annotated lines of the frames from `first` to `last`, both included, as `decode` writes them."""
        return self.annotated([(first, first if last is None else last)])

    def annotated(self, ranges: Iterable[tuple[int, int]]) -> list[Line]:
        """Returns the annotated lines of several ranges of frames, in order of frames, in one pass."""
        ranges = list(ranges)
        if not all(type(number) is int for pair in ranges for number in pair):
            raise TypeError(f"ranges={ranges!r}: pairs of frame numbers are needed")
        wanted = [(max(first, 1), last) for first, last in ranges if last >= max(first, 1)]
        if not wanted:
            return []
        session = self._plan.session("lines", "frame=" + ",".join(f"{first}-{last}" for first, last in wanted))
        end = max(last for _, last in wanted)
        found: list[Line] = []
        with closing(self._results(session)) as results:
            for result in results:
                found += (Line(one.frame, text) for one in lines(result) for text in one.text.split("\n"))
                if session.frames >= end:
                    break
        return found

    def tables(self, *names: str, select: str | None = None) -> dict[str, Table]:
        """Returns tables of columns, all in one pass: `capture.tables("transfers")["transfers"].to_polars()`.

        Arrow's readers take one as it is: `pyarrow.table(table)`.
        names: frames, transfers, states, emcy, findings, sync_cycles, signals, pdo (one table for each PDO and mapping,
        `pdo/can1/5.TPDO4/1`; 0: a synchronous PDO of which no mapping is known), wide (the same in units and words),
        objects (each value of an object, whatever carried it), od (each object of a node), listing (annotated lines),
        lanes (what each lane of a timeline shows), log (findings and emergencies), load (each 100 ms of a bus),
        problems (what went wrong); none: all of them. `canalyze.columns` lists their columns.
        select: which signals, as --select. Times are `t_ns`, in nanoseconds. Nothing is kept but what is given.
        ValueError for another name.
        """
        from canalyze._core import TABLES
        from canalyze._core import Table as Core

        asked = {present(name): name for name in names}
        for name in asked:
            one_of("table", name, TABLES)
        session = self._plan.session("columns", tables=tuple(asked) or TABLES, select=select)
        batches: dict[str, list[Batch]] = {}
        with closing(self._results(session)) as results:
            for _ in results:
                for name, batch in session.batches():
                    batches.setdefault(name, []).append(batch)
        for name, batch in session.batches():
            batches.setdefault(name, []).append(batch)
        return {asked.get(name, name): Table(Core(parts)) for name, parts in batches.items()}

    def check(self, expect: "StrPath | None" = None, *, at_least: Severity = "warning") -> Findings:
        """Returns the findings of `canalyze check`, as severe as that or worse; of expectations too, if they are given.

        expect: a file of expectations (boot.expect.toml), relative to the folder of `open`; none is looked for.
        ConfigError for a mistake in it. Each call reads the capture.
        """
        more: dict[str, Any] = {}
        one_of("at_least", at_least, SEVERITIES)
        if expect is not None:
            from canalyze.expectations import read

            more["expectations"] = read(Path(shown_as(self._plan.folder / expect)))
        with closing(self._typed("check", Finding, **more)) as rows:
            found = list(rows)
        self._checked += found
        return Findings(found).at_least(at_least)

    def html(self, *, frames: Literal["near", "all"] = "all") -> str:
        """Returns the page that `canalyze diagnose --html` writes, with the capture and its descriptions inside.

        frames: without effect, the page has all. OutputError where this installation has no page, SourceError where a
        file cannot be read or holds no frame.
        """
        from canalyze import html

        one_of("frames", frames, ("near", "all"))
        plan = self._plan
        return html.page(plan.words.lang, plan.page_options, [self._opened()], merge=plan.merge).decode("utf-8")

    @property
    def lang(self) -> Literal["en", "zh"]:
        """The language of its words."""
        return "zh" if self._plan.words.lang == "zh" else "en"

    @property
    def folder(self) -> Path:
        """Where relative names are looked for."""
        return self._plan.folder

    def through(self, form: str, take: Callable[[bytes], object] | None = None, **more: Any) -> "tuple[Session, bytes]":
        """Reads all of it in a format of the core; returns session and result. take: gets the result piece by piece."""
        session = self._plan.session(form, **more)
        out = bytearray()
        with closing(self._results(session)) as results:
            for result in results:
                (take or out.extend)(result)
        return session, bytes(out)

    def gave(self, row: object) -> bool:
        """Returns true if this finding, transfer, signal or problem is in one of the lists that were read."""
        lists = [*(self._records or {}).values(), self._checked, *self._read.values()]
        return any(row is one for rows in lists for one in rows)

    @property
    def _read(self) -> dict[str, Rows[Any]]:
        """The lists beside those of `_read_records` that were read."""
        return {name: vars(self)[name] for name in ("signals", "problems", "events") if name in vars(self)}

    def _list(self, kind: type[Struct], form: Callable[[Iterable[Any]], T]) -> T:
        name = kind.__name__.lower() + "s"
        if name not in self._lists:
            self._lists[name] = form(self._read_records()[kind])
        found: T = self._lists[name]
        return found

    def _read_records(self) -> dict[type[Struct], list[Any]]:
        if self._records is None:
            found: dict[type[Struct], list[Any]] = {Transfer: [], Finding: [], Node: []}
            with closing(self._typed("records", *found)) as rows:
                for row in rows:
                    found[type(row)].append(row)
            self._records = found
        return self._records

    def _stream(self) -> Generator[Event, None, None]:
        with closing(self._results(self._plan.session("jsonl"))) as results:
            for result in results:
                yield from cast(Iterator[Event], events(result))

    def _typed(self, form: str, *kinds: type[S], **more: Any) -> Generator[S, None, None]:
        """Yields the records of these kinds in a format of the core."""
        with closing(self._results(self._plan.session(form, **more))) as results:
            for result in results:
                yield from records(result, *kinds)

    def _opened(self) -> Iterator[Counted]:
        """Opens the inputs one after the other, each until the next is wanted."""
        plan = self._plan
        for one in self._inputs:
            with one.open() as opened:
                yield Counted(opened, plan.session("info"), plan.words, given_format=plan.input_format is not None)

    def _results(self, session: "Session") -> Generator[bytes, None, None]:
        """Reads all inputs through a session; at its end the complaints are known."""
        plan = self._plan
        reader = Silent()
        reading = Reading(
            session,
            plan.words,
            reader,
            open_input=lambda place: self._inputs[int(place)].open(),
            merge=plan.merge,
            given_format=plan.input_format is not None,
        )
        yield from reading.over(list(map(str, range(len(self._inputs)))))
        if self._complaints is None:
            self._complaints = tuple(reader.complaints)
