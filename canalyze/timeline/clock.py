"""The timelines of a recording, and where a row of the core's tables stands on them.

`capture_time` is there where stamps are dates, `time_since_start` counts from the first stamp, `frame` is always there,
`sync_cycle` once there is a SYNC. A row without a stamp stands on the last two only, one whose stamp is no date among
dates not on the first. Must not: touch what a row says.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from canalyze.timeline.contents import Contents

CAPTURE_TIME: Final = "capture_time"
ELAPSED: Final = "time_since_start"
FRAME: Final = "frame"
SYNC_CYCLE: Final = "sync_cycle"

_DATES: Final = 631_152_000 * 10**9
"""1990-01-01 in ns: stamps from here on are dates, earlier ones count from some start."""

_LEAST: Final = -(2**63) + 1
"""The least time in ns: one less is no time to those who draw it."""
_MOST: Final = 2**63 - 1

Whole = npt.NDArray[np.int64]
"""Whole numbers of rows."""


@dataclass(frozen=True, slots=True)
class Places:
    """Where rows stand."""

    t_ns: Whole
    """Stamps; anything where there is none."""
    stamped: npt.NDArray[np.bool_]
    """Which rows have a stamp."""
    frame: Whole
    """Frames, from 1."""
    cycle: Whole
    """SYNC cycles of the row's bus; 0 before the first."""

    def __len__(self) -> int:
        return len(self.frame)

    def __getitem__(self, rows: "slice | npt.NDArray[Any]") -> "Places":
        """Give those of some rows."""
        return Places(self.t_ns[rows], self.stamped[rows], self.frame[rows], self.cycle[rows])


def places(batch: pa.RecordBatch) -> Places:
    """Read them off a batch of any table."""
    stamps = batch.column("t_ns")
    # Of a PDO, `cycle` is the one that it belongs to: asynchronous ones belong to none.
    named = "running_cycle" if "running_cycle" in batch.schema.names else "cycle"
    return Places(
        numbers(stamps),
        np.ones(len(stamps), np.bool_) if not stamps.null_count else np.asarray(stamps.is_valid()),
        numbers(batch.column("frame")),
        numbers(batch.column(named)),
    )


def numbers(column: pa.Array) -> Whole:
    """Give a column of whole numbers; 0 for null."""
    if column.null_count:
        column = column.fill_null(0)
    return np.asarray(column).astype(np.int64, copy=False)


class Clock:
    """The timelines, and what is known of their extent."""

    def __init__(self, contents: Contents) -> None:
        """Nothing seen yet; `contents` is told what there is."""
        self._contents = contents
        self._origin_ns = 0
        self._last_cycle = 0

    @property
    def start_ns(self) -> int:
        """The stamp that time is counted from."""
        return self._origin_ns

    def start(self, batches: Iterable[Places]) -> None:
        """Take the first rows of all tables: the earliest frame with a stamp among them is the start."""
        first: tuple[int, int] | None = None
        for rows in batches:
            self._contents.cycles |= bool(len(rows) and rows.cycle.max() > 0)
            frames = rows.frame[rows.stamped]
            if len(frames):
                place = int(frames.argmin())
                one = (int(frames[place]), int(rows.t_ns[rows.stamped][place]))
                first = one if first is None else min(first, one)
        if first:
            self._begin(first[1])

    def _begin(self, t_ns: int) -> None:
        contents = self._contents
        self._origin_ns, contents.timed, contents.dated = t_ns, True, t_ns >= _DATES
        contents.first_ns = contents.last_ns = 0

    def pieces(self, rows: Places) -> "Iterator[tuple[npt.NDArray[np.int64] | None, list[rr.TimeColumn]]]":
        """Give which rows stand on the same timelines, None for all of them, and where.

        A timeline that begins with these rows is one of theirs already.
        """
        if not len(rows):
            return
        contents = self._contents
        if not contents.timed and rows.stamped.any():
            self._begin(int(rows.t_ns[rows.stamped][0]))
        contents.cycles |= bool(rows.cycle.max() > 0)
        # Among dates there may be stamps of a clock that was not set yet.
        dates = rows.stamped & (rows.t_ns >= _DATES) if contents.dated else rows.stamped
        if dates.all():
            yield None, self._columns(rows, stamped=True)
            return
        for which, stamped in ((dates, True), (rows.stamped & ~dates, True), (~rows.stamped, False)):
            (some,) = np.nonzero(which)
            if len(some):
                yield some, self._columns(rows[some], stamped=stamped)

    def span(self) -> list[rr.TimeColumn]:
        """Give the first and the last place on every timeline."""
        contents = self._contents
        ends = Places(
            np.array([contents.first_ns, contents.last_ns], np.int64) + self._origin_ns,
            np.ones(2, np.bool_),
            np.array([contents.first_frame, contents.last_frame], np.int64),
            np.array([0, self._last_cycle], np.int64),
        )
        return self._columns(ends, stamped=contents.timed)

    def _columns(self, rows: Places, *, stamped: bool) -> list[rr.TimeColumn]:
        contents = self._contents
        columns = [rr.TimeColumn(FRAME, sequence=rows.frame)]
        if contents.first_frame == 0:
            contents.first_frame = int(rows.frame.min())
        contents.first_frame = min(contents.first_frame, int(rows.frame.min()))
        contents.last_frame = max(contents.last_frame, int(rows.frame.max()))
        if contents.cycles:
            columns.append(rr.TimeColumn(SYNC_CYCLE, sequence=rows.cycle))
            self._last_cycle = max(self._last_cycle, int(rows.cycle.max()))
        if stamped:
            least, most = _LEAST + max(self._origin_ns, 0), _MOST + min(self._origin_ns, 0)
            elapsed = np.clip(rows.t_ns, least, most) - self._origin_ns
            columns.append(rr.TimeColumn(ELAPSED, duration=elapsed.view("timedelta64[ns]")))
            contents.first_ns = min(contents.first_ns, int(elapsed.min()))
            contents.last_ns = max(contents.last_ns, int(elapsed.max()))
            if contents.dated and rows.t_ns.min() >= _DATES:
                columns.append(rr.TimeColumn(CAPTURE_TIME, timestamp=rows.t_ns.view("datetime64[ns]")))
        return columns
