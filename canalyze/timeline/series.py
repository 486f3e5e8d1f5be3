"""Plots and texts of a recording: quantities of PDOs, periods of SYNC, the load of a bus; lines, and documents.

One entity per PDO and mapping, a row per frame with all its quantities, as physical values. Annotated frames, findings
and emergencies are lines, which are the core's; summary and diagnosis are documents, and the blocks of the summary come
from `reports/summary.py`. Must not: choose the initial view, count or measure.
"""

import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc
import rerun as rr

from canalyze.output import printable
from canalyze.records import records
from canalyze.records.problems import ProblemRow
from canalyze.records.summary import Capture
from canalyze.reports.summary import LEFT, report
from canalyze.timeline.charts import WINDOW
from canalyze.timeline.stream import (
    LEVEL,
    TEXT,
    Contents,
    Places,
    Plot,
    Series,
    Stream,
    mapped,
    path,
    places,
    plain,
    words,
)
from canalyze.timeline.stream import part as part_of
from canalyze.words import Words

_SPECIAL: Final = re.compile(r"([\\`*_{}\[\]<>#|~])")
_FACTS: Final = ("files", "frames", "first_t", "last_t", "seconds", "bit_rate", "dropped", "unreadable")


def markdown(result: bytes, words: Words, *, dated: bool = False) -> str:
    """Returns the JSON lines of one capture as a document. dated: stamps are dates, and formatted as such."""
    sheet = _Markdown()
    report(result, sheet, words, stamp=_date if dated else str)
    return "".join(sheet.parts)


def listed(lines: Sequence[str], words: Words) -> str:
    """Returns a summary in words as a document with an item per line."""
    items = "".join(f"- {_plain(line)}\n" for line in lines)
    return f"# {_plain(words('timeline.summary'))}\n\n{items}"


def facts(result: bytes) -> dict[str, Any]:
    """Returns the properties of a recording; unknown ones are left out."""
    capture = next(records(result, Capture))
    return {key: fact for key in _FACTS if (fact := getattr(capture, key)) is not None}


def problem_list(problems: Sequence[tuple[ProblemRow, str]], words: Words) -> str:
    """Returns the diagnosis as a document: a chapter per status, an item per problem, its consequences below it.

    problems: in the order of reading, each with its cause in words.
    """
    lines = [f"# {_plain(words('timeline.diagnosis'))}\n"]
    heading = ""
    for one, cause in problems:
        if not one.depth and one.status != heading:
            heading = one.status
            lines.append(f"\n## {_plain(words.of('problem_heading', heading))}\n\n")
        indent = "  " * one.depth
        caused = f" ({_plain(cause)})" if cause else ""
        lines.append(f"{indent}- **\\#{one.id}** {_plain(one.message)}{caused}\n")
        if not one.depth and one.checks and one.status != "harmless":
            checks = words("diagnose.between").join(one.checks.split("\n"))
            lines.append(f"{indent}  - {_plain(words('diagnose.check_first', said=checks))}\n")
    return "".join(lines)


def _date(stamp: str) -> str:
    """Returns a stamp as the viewer formats it: date and time of day."""
    seconds, _, fraction = str(stamp).partition(".")
    try:
        day = datetime.fromtimestamp(int(seconds), UTC)
    except (ValueError, OverflowError, OSError):  # no date after all
        return str(stamp)
    return f"{day:%Y-%m-%d %H:%M:%S}" + (f".{fraction}" if fraction else "")


class _Markdown:
    """Blocks as chapters."""

    def __init__(self) -> None:
        self.parts: list[str] = []

    def facts(self, heading: str, rows: Sequence[tuple[str, str]]) -> None:
        lines = "".join(f"- {_plain(term)}: {_plain(text)}\n" if term else f"- {_plain(text)}\n" for term, text in rows)
        self.parts.append(f"# {_plain(heading)}\n\n{lines}")

    def table(self, heading: str, keys: Sequence[str], names: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        sides = [":--" if key in LEFT else "--:" for key in keys]
        lines = "".join(f"| {' | '.join(cells)} |\n" for cells in (map(_plain, row) for row in rows))
        head = f"| {' | '.join(map(_plain, names))} |\n|{'|'.join(sides)}|\n"
        self.parts.append(f"\n## {_plain(heading)}\n\n{head}{lines}")

    def line(self, text: str) -> None:
        if text:
            self.parts.append(f"\n{_plain(text)}\n")


def _plain(text: str) -> str:
    """Returns a text with Markdown's special characters escaped."""
    return _SPECIAL.sub(r"\\\1", printable(text))


_LEVELS: Final[dict[str | None, str]] = {"error": "ERROR", "warning": "WARN", "info": "INFO", None: "TRACE"}
_SOURCES: Final = {"finding": "findings", "emcy": "emcy"}
"""The second part of their paths, by the core's names; the third is the bus, then comes the node."""


class LogWriter:
    """Writes lines to a recording."""

    def __init__(self, stream: Stream, contents: Contents) -> None:
        """Writes rows to `stream` and updates `contents`."""
        self._stream = stream
        self._contents = contents
        self._buses: set[str] = set()

    def frames(self, batch: pa.RecordBatch) -> None:
        """Appends annotated frames, prefixed with the bus if there are several."""
        if not len(batch):
            return
        lines, buses = batch.column("line"), batch.column("bus")
        self._buses |= words(buses)
        if len(self._buses) > 1:
            lines = pc.binary_join_element_wise(plain(buses).fill_null("-"), lines, "  ")
        self._contents.frames += len(batch)
        levels = mapped(batch.column("severity"), _LEVELS)
        self._stream.texts("/frames", places(batch), [(TEXT, lines), (LEVEL, levels)])

    def log(self, batch: pa.RecordBatch) -> None:
        """Appends findings and emergencies."""
        rows, sources = places(batch), np.asarray(plain(batch.column("source")), object)
        coded = pc.binary_join_element_wise(plain(batch.column("code")), batch.column("text"), "  ")
        levels = mapped(batch.column("level"), _LEVELS)
        buses = np.asarray(plain(batch.column("bus")).fill_null(""), object)
        nodes = np.asarray(batch.column("node").fill_null(0))
        for source, kind in _SOURCES.items():
            (every,) = np.nonzero(sources == source)
            for bus, node in dict.fromkeys(zip(buses[every].tolist(), nodes[every].tolist(), strict=True)):
                some = every[(buses[every] == bus) & (nodes[every] == node)]
                entity = path("log", kind, bus, *([f"node{node}"] if node else []))
                if node:
                    self._contents.told.setdefault((part_of(bus), node), {})[entity] = None
                taken = pa.array(some)
                told = levels.take(taken)
                for one in told.value_counts().to_pylist():
                    self._contents.logged[one["values"]] = self._contents.logged.get(one["values"], 0) + one["counts"]
                self._contents.findings += len(some) if source == "finding" else 0
                # The text of an emergency has its code.
                texts = batch.column("text") if source == "emcy" else coded
                self._stream.texts(entity, rows[some], [(TEXT, texts.take(taken)), (LEVEL, told)])


_ENDS: Final = 4096
"""Maximum number of waiting ends of a PDO's samples."""
_LONGEST: Final = 64
"""Maximum length of a signal's name in that of its line."""
_US: Final = 1000.0
"""Nanoseconds in a microsecond."""
_WINDOW_NS: Final = 100_000_000
"""Duration of a row of the load."""

Numbers = npt.NDArray[np.float64]
"""Numbers of rows, NaN for none."""


class SeriesWriter:
    """Writes plots to a recording."""

    def __init__(self, stream: Stream, contents: Contents, words: Words) -> None:
        """Writes rows to `stream` and updates `contents`."""
        self._stream = stream
        self._contents = contents
        self._words = words
        self._pdos: dict[bytes, _Pdo] = {}
        self._windows: dict[str, float] = {}
        """The last synchronous window, by bus, in µs."""
        self._ended: dict[str, list[Places]] = {}
        """Positions where samples end, by the entity of the PDO's first mapping."""

    def pdo(self, batch: pa.RecordBatch) -> None:
        """Appends rows of a PDO by one mapping."""
        table = batch.schema.metadata[b"table"]
        pdo = self._pdos.get(table)
        if pdo is None:
            pdo = self._pdos[table] = _Pdo(batch.schema)
        rows = places(batch)
        if pdo.columns:
            plot = pdo.plot
            if not plot.rows:
                self._contents.plots[plot.entity] = plot
                # A sample holds until the next one.
                self._named(plot.entity, [one.name for one in plot.series], rr.components.InterpolationMode.StepAfter)
            values = np.empty((len(rows), len(pdo.columns)), np.float64)
            for line, (place, factor) in enumerate(pdo.columns):
                np.multiply(_numbers(batch.column(place)), factor, out=values[:, line])
                _extend(plot.series[line], values[:, line])
            plot.rows += len(rows)
            self._stream.scalars(plot.entity, rows, values)
        delays = batch.column("delay_ns")
        if delays.null_count < len(delays):
            self._delays(pdo, rows, delays)

    def ends(self, entity: str, rows: Places) -> None:
        """Appends positions where the samples of a PDO, of any mapping, end."""
        waiting = self._ended.setdefault(entity, [])
        waiting.append(rows)
        if sum(map(len, waiting)) > _ENDS:
            self._end(entity)

    def flush(self) -> None:
        """Writes the waiting ends, after a sample of the same frame, which they end."""
        for entity in list(self._ended):
            self._end(entity)

    def _end(self, entity: str) -> None:
        waiting = self._ended.pop(entity)
        plots = [plot for one, plot in self._contents.plots.items() if one == entity or one.startswith(f"{entity}/v")]
        for plot in plots:
            for rows in waiting:
                self._stream.scalars(plot.entity, rows, np.full((len(rows), len(plot.series)), np.nan))

    def _delays(self, pdo: "_Pdo", rows: Places, delays: pa.Array) -> None:
        """Writes the delays after SYNC of the rows that have one."""
        if pdo.delay not in self._contents.delays:
            self._contents.delays[pdo.delay] = None
            self._named(pdo.delay, [f"{pdo.plot.node}.{pdo.plot.pdo} [µs]"])
        (some,) = np.nonzero(np.asarray(delays.is_valid()))
        self._put(pdo.delay, rows[some], _numbers(delays)[some] / _US)

    def sync(self, batch: pa.RecordBatch) -> None:
        """Appends SYNC cycles."""
        for bus, rows, some in _by_bus(batch):
            entity = path("sync", bus, "period")
            if bus not in self._contents.sync:
                self._contents.sync.add(bus)
                self._named(entity, [self._words("timeline.period")])
            self._put(entity, rows, _numbers(batch.column("period_ns"))[some] / _US)
            self._window(bus, rows, _numbers(batch.column("window_ns"))[some] / _US)

    def _window(self, bus: str, rows: Places, windows: Numbers) -> None:
        """Writes the synchronous window where it changes, and at the end, so that it is drawn up to there."""
        known = np.where(np.isnan(windows), -1.0, windows)
        before = np.concatenate(([self._windows.get(bus, -1.0)], known[:-1]))
        if (known < 0).all() and before[0] < 0:
            return
        self._windows[bus] = float(known[-1])
        change = known != before
        change[-1] = True
        entity = path("sync", bus, "window")
        if bus not in self._contents.windows:
            self._contents.windows.add(bus)
            self._named(
                entity, [self._words("timeline.window_line")], rr.components.InterpolationMode.StepAfter, WINDOW
            )
        self._put(entity, rows[change], windows[change])

    def load(self, batch: pa.RecordBatch) -> None:
        """Appends the load of buses, in percent if the bit rate is known, or else in frames per second."""
        for bus, rows, some in _by_bus(batch):
            entity = path("load", bus)
            percent = self._contents.load.get(bus)
            if first := percent is None:
                percent = bool(np.asarray(batch.column("load_percent").is_valid())[some].any())
                self._contents.load[bus] = percent
                name = self._words("timeline.load_line" if percent else "timeline.rate_line", bus=bus).strip()
                self._named(entity, [name], rr.components.InterpolationMode.StepBefore)
            column = batch.column("load_percent" if percent else "frames_per_s")
            values = _numbers(column)[some]
            if percent:
                peak = float(np.fmax.reduce(values, initial=self._contents.peaks.get(bus, 0.0)))
                self._contents.peaks[bus] = peak
            if first:
                # Drawn from the window's begin, not only at its end.
                rows = _from(rows, max(int(rows.t_ns[0]) - _WINDOW_NS, self._stream.start_ns))
                values = np.concatenate((values[:1], values))
            self._put(entity, rows, values)

    def _put(self, entity: str, rows: Places, values: Numbers) -> None:
        """Writes an entity's only line and updates its range."""
        finite = values[np.isfinite(values)]
        if len(finite):
            self._contents.widen(entity, float(finite.min()), float(finite.max()))
        self._stream.scalars(entity, rows, values[:, np.newaxis])

    def _named(self, entity: str, names: list[str], mode: Any = None, colour: int | None = None) -> None:
        lines = rr.SeriesLines(
            names=names,
            colors=None if colour is None else np.array([colour], np.uint32),
            interpolation_mode=mode,
            aggregation_policy=rr.components.AggregationPolicy.MinMax,
        )
        self._stream.always(entity, lines)


class _Pdo:
    """The plot and the columns of a table of a PDO's rows."""

    def __init__(self, schema: pa.Schema) -> None:
        meta = _text(schema.metadata)
        whose = (meta["bus"], f"node{meta['node']}", meta["pdo"])
        version = f"v{meta['version']}" if meta["version"] != "1" else ""
        shown = [(place, one) for place, one in enumerate(map(_meta, schema)) if one.get("quantity") == "true"]
        series = [_series(schema.field(place).name, one) for place, one in shown]
        self.columns = [(place, float(one["factor"])) for place, one in shown]
        """Column of the table and factor of each line."""
        self.plot = Plot(path("pdo", *whose, version), meta["bus"], int(meta["node"]), meta["pdo"], series)
        self.delay = path("sync", meta["bus"], "delay", *whose[1:])


def _series(name: str, meta: dict[str, str]) -> Series:
    unit = meta.get("unit", "")
    if len(name) > _LONGEST:
        # Cut, it may be another one's: the object is not.
        name = f"{name[:_LONGEST]}… ({meta['object']})"
    # An unnamed signal has the name of its object: 2000h:01.
    described = not name.startswith(f"{meta['object'][:4]}h")
    return Series(f"{name} [{unit}]" if unit else name, unit, described, kind=meta.get("kind", ""))


def _extend(series: Series, values: Numbers) -> None:
    finite = values[np.isfinite(values)]
    if len(finite):
        series.least = min(series.least, float(finite.min()))
        series.greatest = max(series.greatest, float(finite.max()))


def _meta(field: pa.Field) -> dict[str, str]:
    return _text(field.metadata or {})


def _text(metadata: Mapping[bytes, bytes]) -> dict[str, str]:
    return {key.decode(): value.decode() for key, value in metadata.items()}


def _numbers(column: pa.Array) -> Numbers:
    """Returns a column of any numbers, with NaN for null."""
    return np.asarray(column.to_numpy(zero_copy_only=False), np.float64)


def _by_bus(batch: pa.RecordBatch) -> "list[tuple[str, Places, npt.NDArray[np.bool_]]]":
    """Returns the rows of each bus, "" if the capture has no names."""
    rows = places(batch)
    buses = batch.column("bus").dictionary_decode()
    if buses.null_count == len(buses) or (buses.null_count == 0 and len(words(buses)) == 1):
        everything = np.ones(len(rows), np.bool_)
        return [(buses[0].as_py() or "", rows, everything)] if len(rows) else []
    named = np.asarray(buses.fill_null(""), object)
    return [(bus, rows[named == bus], named == bus) for bus in dict.fromkeys(named.tolist())]


def _from(rows: Places, start_ns: int) -> Places:
    """Returns the rows preceded by one at `start_ns`."""
    t_ns = np.concatenate(([start_ns], rows.t_ns))
    again = np.concatenate(([0], np.arange(len(rows))))
    return Places(t_ns, rows.stamped[again], rows.frame[again], rows.cycle[again])
