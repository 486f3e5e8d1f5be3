"""SDO transfers in words, and how long they took: a point each, seen however short it is beside an hour.

A lane shows a transfer from its first frame to its last: of milliseconds nothing is left in a long capture, and two
that are alike look like one. Must not: know what was transferred.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from canalyze.timeline.clock import Places
from canalyze.timeline.colours import COLOURS
from canalyze.timeline.contents import Contents
from canalyze.timeline.stream import LEVEL, TEXT, Stream, escaped
from canalyze.words import Words

LANES: Final = "sdo/"
"""How the names of their lanes begin."""
LIST: Final = "sdo_list/"
"""How the paths of their lines begin."""
_LEVELS: Final[dict[str | None, str]] = {"ok": "INFO", "aborted": "ERROR", "failed": "ERROR"}
_MS: Final = 1e6
"""Nanoseconds in a millisecond."""
_SIZE: Final = 3.0
_ENDED: Final[dict[str | None, int]] = {"ok": 0, "aborted": 1, "failed": 1}
"""Which of an entity's two series a transfer is in, by the class of its state; of others the end is not known."""

Series = npt.NDArray[np.int64]
"""For each row of a lane: the series of the transfer that begins there; -1: none."""


class TransferWriter:
    """Points on their way into a recording."""

    def __init__(self, stream: Stream, contents: Contents, words: Words) -> None:
        """Rows go to `stream`; `contents` is told what there is."""
        self._stream = stream
        self._contents = contents
        self._words = words
        self._begun: dict[str, tuple[Places, Series]] = {}
        """The last row of each lane."""

    @staticmethod
    def series(of_class: str | None) -> int:
        """Give the series of a transfer by the class of its state; -1 for none."""
        return _ENDED.get(of_class, -1)

    def tell(self, lane: str, rows: Places, states: "Sequence[tuple[str, str | None]]", which: Series) -> None:
        """Take the rows of a lane as lines: `which` of `states`, texts and classes, each is; a text "" is none."""
        texts = np.array([bool(text) for text, _ in states])
        (some,) = np.nonzero(texts[which])
        if not len(some):
            return
        channel = lane.removeprefix(LANES)
        entity = escaped(f"{LIST}{channel}")
        node = next((part for part in channel.split("/") if part.startswith("node")), channel).removeprefix("node")
        whose = self._words("timeline.node", node=node)
        levels = [_LEVELS.get(of_class, "WARN") for _, of_class in states]
        told = self._contents.listed.setdefault(entity, set())
        told.update(level for level, (text, _) in zip(levels, states, strict=True) if text)
        taken = pa.array(which[some])
        lines = pa.array([f"{whose}  {text}" for text, _ in states]).take(taken)
        self._stream.texts(entity, rows[some], [(TEXT, lines), (LEVEL, pa.array(levels).take(taken))])

    def take(self, lane: str, rows: Places, series: Series) -> None:
        """Take rows of a lane: each transfer lasts until the next one."""
        before = self._begun.get(lane)
        if before:
            rows, series = before[0].followed_by(rows), np.concatenate((before[1], series))
        self._begun[lane] = rows[-1:], series[-1:]
        ended = (series[:-1] >= 0) & rows.stamped[:-1] & rows.stamped[1:] & (rows.t_ns[1:] >= rows.t_ns[:-1])
        (some,) = np.nonzero(ended)
        if not len(some):
            return
        took = (rows.t_ns[some + 1] - rows.t_ns[some]).astype(np.float64)
        values = np.full((len(some), 2), np.nan)
        values[np.arange(len(some)), series[some]] = took / _MS
        channel = lane.removeprefix(LANES)
        contents, entity = self._contents, escaped(f"sdo_duration/{channel}")
        if entity not in contents.durations:
            palette = COLOURS["sdo"]
            # Told of a point that is pointed at: whose it is.
            done = self._words("timeline.done_line", channel=channel)
            failed = self._words("timeline.failed_line", channel=channel)
            style = rr.SeriesPoints(
                names=[done, failed],
                colors=np.array([palette["ok"], palette["failed"]], np.uint32),
                markers=["circle", "circle"],
                marker_sizes=[_SIZE, _SIZE],
            )
            self._stream.always(entity, style)
            contents.durations[entity] = None
        contents.transfers += len(some)
        contents.widen(entity, float(took.min()) / _MS, float(took.max()) / _MS)
        contents.transferring_ns += float(took.sum())
        self._stream.scalars(entity, rows[some], values)
