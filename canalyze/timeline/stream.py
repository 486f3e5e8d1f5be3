"""Writes Arrow columns as columns of Rerun's components at the positions of their rows, without an object per row.

`capture_time` exists if stamps are dates, `time_since_start` counts from the first stamp, `frame` always exists,
`sync_cycle` after the first SYNC. A row without a stamp is on the last two only; one whose stamp is no date is not
on the first. If the clock is set during a capture, from 1970 to now or back, there is no gap: the next frame gets
the position of the one before.

`Contents` is what is in the recording so far: plain data, updated by the writers, from which the layout is made. Must
not: know the meaning of the rows or of a state.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from canalyze.values import DATES_NS

if TYPE_CHECKING:
    from rerun import ComponentDescriptor

_SEEN: Final = 4000
"""A transfer that takes more than this fraction of the capture is visible in its lane."""
_INFORMED: Final = 10
"""Maximum number of informational rows of a log that leave room for others."""


@dataclass(slots=True)
class Series:
    """One line of a plot: a signal of a PDO that is a quantity."""

    name: str
    """The name of the line with its unit: 速度实际值 [rpm]."""
    unit: str
    """Its unit; "" if unknown."""
    described: bool
    """True if it has a name, from the standard or a description, and not just an index."""
    least: float = float("inf")
    """The least value so far, ignoring NaN."""
    greatest: float = float("-inf")
    """The greatest value so far."""
    kind: str = ""
    """The core's kind of quantity; "" if unknown."""

    @property
    def varies(self) -> bool:
        """True if it has had more than one value."""
        return self.least < self.greatest


@dataclass(slots=True)
class Plot:
    """The quantities of one PDO by one mapping: one entity with a row per frame."""

    entity: str
    """Path of the entity: /pdo/can0/node5/TPDO1."""
    bus: str
    """The bus's name; "" if the capture has no names."""
    node: int
    """Node-ID."""
    pdo: str
    """TPDO1."""
    series: list[Series]
    """Its lines, in their order in the entity's rows."""
    rows: int = 0
    """Rows so far."""


@dataclass(slots=True)
class Lane:
    """A lane of states."""

    entity: str
    """Path of the entity: /nmt/can0/node5; its first part is the kind of lane."""
    rows: int = 0
    """Changes so far."""
    fault: bool = False
    """True if it has had a fault: a lost heartbeat, a drive in fault, an emergency."""

    @property
    def kind(self) -> str:
        """nmt, sdo, drive, emcy, problems or value."""
        return self.entity.split("/")[1]


@dataclass(slots=True)
class Contents:
    """The contents, in the order in which they came."""

    plots: dict[str, Plot] = field(default_factory=dict)
    """By entity."""
    lanes: dict[str, Lane] = field(default_factory=dict)
    """By entity."""
    sync: set[str] = field(default_factory=set)
    """Buses with SYNC periods at /sync/can0/period, and the window at /sync/can0/window."""
    delays: dict[str, None] = field(default_factory=dict)
    """Entities of the delays of synchronous PDOs: /sync/can0/delay/node5/TPDO1."""
    durations: dict[str, None] = field(default_factory=dict)
    """Entities of the durations of SDO transfers: /sdo_duration/can0/node5."""
    transfers: int = 0
    """Number of transfers in them."""
    transferring_ns: float = 0.0
    """Their total duration."""
    load: dict[str, bool] = field(default_factory=dict)
    """Buses with a load at /load/can0: true in percent, false in frames per second."""
    peaks: dict[str, float] = field(default_factory=dict)
    """The maximum load of each bus so far, in percent."""
    windows: set[str] = field(default_factory=set)
    """Buses with a known synchronous window."""
    frames: int = 0
    """Rows of annotated frames, at /frames."""
    logged: dict[str, int] = field(default_factory=dict)
    """Rows of findings and emergencies, at /log/..., by level: ERROR, WARN, INFO."""
    findings: int = 0
    """Rows of findings, at /log/findings/..."""
    told: dict[tuple[str, int], dict[str, None]] = field(default_factory=dict)
    """Entities with findings and emergencies of a node, by the bus as in paths and the node."""
    listed: dict[str, set[str]] = field(default_factory=dict)
    """Entities with SDO transfers in words, and their levels: /sdo_list/can0/node5."""
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    """The least and the greatest value of entities of no PDO."""
    timed: bool = False
    """True if there is a stamp, and so a timeline `time_since_start`; otherwise there is only `frame`."""
    dated: bool = False
    """True if stamps are dates, and so there is a timeline `capture_time`."""
    cycles: bool = False
    """True if there are SYNC cycles, and so a timeline `sync_cycle`."""
    first_ns: int = 0
    """Elapsed time of the first row, in ns."""
    last_ns: int = 0
    """Elapsed time of the last row, in ns."""
    first_frame: int = 0
    last_frame: int = 0
    summary: bool = False
    """True if there is a summary, at /summary."""
    diagnosis: bool = False
    """True if there is a diagnosis in words, at /diagnosis."""

    def widen(self, entity: str, least: float, greatest: float) -> None:
        """Extends the range of an entity by the least and the greatest of some values."""
        if least <= greatest:
            before = self.ranges.get(entity, (least, greatest))
            self.ranges[entity] = min(before[0], least), max(before[1], greatest)

    @property
    def brief(self) -> bool:
        """True if SDO transfers are too short to be visible in their lanes."""
        return self.transferring_ns * _SEEN < self.transfers * (self.last_ns - self.first_ns)

    @property
    def crowded(self) -> bool:
        """True if errors may be out of sight in a log, below informational rows."""
        return self.logged.get("INFO", 0) > _INFORMED and len(self.logged) > 1


CAPTURE_TIME: Final = "capture_time"
ELAPSED: Final = "time_since_start"
FRAME: Final = "frame"
SYNC_CYCLE: Final = "sync_cycle"

_LEAST: Final = -(2**63) + 1
"""The least valid time in ns; viewers treat the next smaller one as no time."""
_MOST: Final = 2**63 - 1

Whole = npt.NDArray[np.int64]
"""Whole numbers of rows."""


@dataclass(frozen=True, slots=True)
class Places:
    """The positions of rows."""

    t_ns: Whole
    """Stamps; undefined for rows without one."""
    stamped: npt.NDArray[np.bool_]
    """True for rows with a stamp."""
    frame: Whole
    """Frames, from 1."""
    cycle: Whole
    """SYNC cycles of the row's bus; 0 before the first."""

    def __len__(self) -> int:
        return len(self.frame)

    def __getitem__(self, rows: "slice | npt.NDArray[Any]") -> "Places":
        """Returns the positions of some rows."""
        return Places(self.t_ns[rows], self.stamped[rows], self.frame[rows], self.cycle[rows])

    def followed_by(self, rows: "Places") -> "Places":
        """Returns these positions followed by others."""
        return Places(
            np.concatenate((self.t_ns, rows.t_ns)),
            np.concatenate((self.stamped, rows.stamped)),
            np.concatenate((self.frame, rows.frame)),
            np.concatenate((self.cycle, rows.cycle)),
        )


def places(batch: pa.RecordBatch) -> Places:
    """Returns the positions in a batch of any table."""
    stamps = batch.column("t_ns")
    # Of a PDO, `cycle` is the one that it belongs to: asynchronous ones belong to none.
    named = "running_cycle" if "running_cycle" in batch.schema.names else "cycle"
    frame = "begin_frame" if "begin_frame" in batch.schema.names else "frame"
    return Places(
        numbers(stamps),
        np.ones(len(stamps), np.bool_) if not stamps.null_count else np.asarray(stamps.is_valid()),
        numbers(batch.column(frame)),
        numbers(batch.column(named)),
    )


def numbers(column: pa.Array) -> Whole:
    """Returns a column of whole numbers, with 0 for null."""
    if column.null_count:
        column = column.fill_null(0)
    return np.asarray(column).astype(np.int64, copy=False)


class Clock:
    """The timelines and their extent."""

    def __init__(self, contents: Contents) -> None:
        """Creates the timelines without rows; `contents` is updated."""
        self._contents = contents
        self._first: int | None = None
        self._zeros: dict[bool, int] = {}
        """The stamp at 0 s of `time_since_start`, for stamps that are dates and for others."""
        self._dates: tuple[int, int] | None = None
        """The first and the last date."""
        self._last_cycle = 0

    @property
    def start_ns(self) -> int:
        """The stamp from which time counts."""
        return self._first or 0

    def start(self, batches: Iterable[Places]) -> None:
        """Sets the start to the earliest stamped frame in the first rows of all tables."""
        seen = [rows[rows.stamped] for rows in batches if self._cycles(rows)]
        self._learn([rows for rows in seen if len(rows)])

    def _cycles(self, rows: Places) -> bool:
        """Notes if there are SYNC cycles; returns true if there are rows."""
        self._contents.cycles |= bool(len(rows) and rows.cycle.max() > 0)
        return bool(len(rows))

    def _learn(self, seen: list[Places]) -> None:
        """Learns the first stamp of either kind.

        A clock that is set during a capture jumps by decades, for an unknown time: the first stamp after it gets the
        position of the last one before it.
        """
        first: dict[bool, tuple[int, int]] = {}
        for rows in seen:
            for dated in (False, True):
                (some,) = np.nonzero((rows.t_ns >= DATES_NS) == dated)
                if len(some):
                    place = some[rows.frame[some].argmin()]
                    one = (int(rows.frame[place]), int(rows.t_ns[place]))
                    first[dated] = min(first.get(dated, one), one)
        contents = self._contents
        for dated, (frame, t_ns) in sorted(first.items(), key=lambda one: one[1]):
            if dated in self._zeros:
                continue
            before = contents.last_ns
            if not self._zeros:
                self._first, before, contents.timed, contents.first_ns = t_ns, 0, True, 0
            else:
                ends = [
                    int(rows.t_ns[which].max()) - self._zeros[not dated]
                    for rows in seen
                    if (which := ((rows.t_ns >= DATES_NS) != dated) & (rows.frame < frame)).any()
                ]
                before = min(max(ends, default=before), _MOST)
            self._zeros[dated] = max(_LEAST - 1, min(t_ns - before, _MOST))
            contents.dated |= dated

    def pieces(self, rows: Places) -> "Iterator[tuple[npt.NDArray[np.int64] | None, list[rr.TimeColumn]]]":
        """Yields indices of rows on the same timelines, None for all of them, with their positions.

        A timeline that begins with these rows is included.
        """
        if not self._cycles(rows):
            return
        dates = rows.stamped & (rows.t_ns >= DATES_NS)
        others = rows.stamped ^ dates
        if (True not in self._zeros and dates.any()) or (False not in self._zeros and others.any()):
            self._learn([rows[rows.stamped]])
        kinds: list[tuple[npt.NDArray[np.bool_], bool | None]] = [(dates, True), (others, False)]
        for which, dated in kinds:
            if which.all():
                yield None, self._columns(rows, dated=dated)
                return
        kinds.append((~rows.stamped, None))
        # Of two rows at one time, the one that is sent last counts.
        found = ((np.nonzero(which)[0], dated) for which, dated in kinds)
        for some, dated in sorted((one for one in found if len(one[0])), key=lambda one: int(one[0][0])):
            yield some, self._columns(rows[some], dated=dated)

    def span(self) -> list[rr.TimeColumn]:
        """Returns the first and the last position on every timeline."""
        contents = self._contents
        columns = [rr.TimeColumn(FRAME, sequence=np.array([contents.first_frame, contents.last_frame], np.int64))]
        if contents.cycles:
            columns.append(rr.TimeColumn(SYNC_CYCLE, sequence=np.array([0, self._last_cycle], np.int64)))
        if contents.timed:
            elapsed = np.array([contents.first_ns, contents.last_ns], np.int64)
            columns.append(rr.TimeColumn(ELAPSED, duration=elapsed.view("timedelta64[ns]")))
        if self._dates:
            dates = np.array(self._dates, np.int64)
            columns.append(rr.TimeColumn(CAPTURE_TIME, timestamp=dates.view("datetime64[ns]")))
        return columns

    def _columns(self, rows: Places, *, dated: bool | None) -> list[rr.TimeColumn]:
        """Returns the positions of rows whose stamps are dates, are none, or are missing (None)."""
        contents = self._contents
        columns = [rr.TimeColumn(FRAME, sequence=rows.frame)]
        if contents.first_frame == 0:
            contents.first_frame = int(rows.frame.min())
        contents.first_frame = min(contents.first_frame, int(rows.frame.min()))
        contents.last_frame = max(contents.last_frame, int(rows.frame.max()))
        if contents.cycles:
            columns.append(rr.TimeColumn(SYNC_CYCLE, sequence=rows.cycle))
            self._last_cycle = max(self._last_cycle, int(rows.cycle.max()))
        if dated is not None:
            zero = self._zeros[dated]
            elapsed = np.clip(rows.t_ns, _LEAST + max(zero, 0), _MOST + min(zero, 0)) - zero
            columns.append(rr.TimeColumn(ELAPSED, duration=elapsed.view("timedelta64[ns]")))
            contents.first_ns = min(contents.first_ns, int(elapsed.min()))
            contents.last_ns = max(contents.last_ns, int(elapsed.max()))
        if dated:
            first, last = int(rows.t_ns.min()), int(rows.t_ns.max())
            known = self._dates or (first, last)
            self._dates = min(first, known[0]), max(last, known[1])
            columns.append(rr.TimeColumn(CAPTURE_TIME, timestamp=rows.t_ns.view("datetime64[ns]")))
        return columns


SCALARS: "Final[ComponentDescriptor]" = rr.Scalars.descriptor_scalars()
STATE: "Final[ComponentDescriptor]" = rr.StateChange.descriptor_state()
TEXT: "Final[ComponentDescriptor]" = rr.TextLog.descriptor_text()
LEVEL: "Final[ComponentDescriptor]" = rr.TextLog.descriptor_level()

_NO_PART: Final = frozenset("/%")


class _Values(rr.ComponentBatchLike):
    """A column without conversion."""

    def __init__(self, array: pa.Array) -> None:
        self._array = array

    def as_arrow_array(self) -> pa.Array:
        return self._array


class Stream:
    """A recording as seen by its writers."""

    def __init__(self, recording: rr.RecordingStream, clock: Clock) -> None:
        """Writes rows to `recording`, at their positions by `clock`."""
        self._recording = recording
        self._clock = clock

    @property
    def start_ns(self) -> int:
        """The stamp from which time counts."""
        return self._clock.start_ns

    def scalars(self, entity: str, rows: Places, values: npt.NDArray[np.float64]) -> None:
        """Writes rows of numbers; `values` has a column for each line of the entity's plot, NaN for none."""
        for some, indexes in self._clock.pieces(rows):
            block = values if some is None else values[some]
            column = rr.ComponentColumn(
                SCALARS, _Values(pa.array(block.reshape(-1))), lengths=np.full(len(block), block.shape[1], np.int32)
            )
            rr.send_columns(entity, indexes, [column], recording=self._recording)

    def texts(self, entity: str, rows: Places, columns: "Sequence[tuple[ComponentDescriptor, pa.Array]]") -> None:
        """Writes rows of texts, one of each column."""
        for some, indexes in self._clock.pieces(rows):
            taken = [(what, texts if some is None else texts.take(pa.array(some))) for what, texts in columns]
            sent = [rr.ComponentColumn(what, _Values(texts)) for what, texts in taken]
            rr.send_columns(entity, indexes, sent, recording=self._recording)

    def always(self, entity: str, what: Any) -> None:
        """Writes a static component of the entity; the last one counts."""
        self._recording.log(entity, what, static=True)


def path(*parts: str) -> str:
    """Returns the path of an entity; empty parts are left out."""
    return rr.new_entity_path([part(one) for one in parts if one])


def part(name: str) -> str:
    """Returns a name as a part of a path, escaped as in the core's lanes: no blanks, unsafe characters as %2F."""
    return "".join("_" if c == " " else c if c.isprintable() and c not in _NO_PART else _percent(c) for c in name)


def _percent(char: str) -> str:
    return "".join(f"%{byte:02X}" for byte in char.encode("utf-8", "surrogateescape"))


def escaped(lane: str) -> str:
    """Returns the path of an entity whose parts are escaped already, as those of lanes."""
    return rr.new_entity_path(lane.split("/"))


def plain(column: pa.Array) -> pa.Array:
    """Returns the texts of a column of words."""
    return column.dictionary_decode() if pa.types.is_dictionary(column.type) else column


def words(column: pa.Array) -> set[str]:
    """Returns the distinct words of a column."""
    return {word for word in column.unique().to_pylist() if word is not None}


def mapped(column: pa.Array, table: dict[str | None, str]) -> pa.Array:
    """Replaces each word of a column by that in `table`, null by that of None."""
    column = column if pa.types.is_dictionary(column.type) else column.dictionary_encode()
    others = pa.array([*(table[word] for word in column.dictionary.to_pylist()), table[None]], pa.string())
    return others.take(column.indices.fill_null(len(others) - 1))
