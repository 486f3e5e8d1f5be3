"""SDO transfers in words, and their durations as points, which are visible however short they are.

A lane shows a transfer from its first frame to its last, which is too short to see in a long capture, and two equal
ones look like one. Must not: know the content of a transfer.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from canalyze.timeline.colours import COLOURS
from canalyze.timeline.contents import Contents
from canalyze.timeline.stream import LEVEL, TEXT, Places, Stream, escaped
from canalyze.words import Words

LANES: Final = "sdo/"
"""Prefix of the names of their lanes."""
LIST: Final = "sdo_list/"
"""Prefix of the paths of their lines."""
_LEVELS: Final[dict[str | None, str]] = {"ok": "INFO", "aborted": "ERROR", "failed": "ERROR"}
_MS: Final = 1e6
"""Nanoseconds in a millisecond."""
_SIZE: Final = 3.0
_ENDED: Final[dict[str | None, int]] = {"ok": 0, "aborted": 1, "failed": 1}
"""The series of a transfer among an entity's two, by the class of its state; others have an unknown end."""

Series = npt.NDArray[np.int64]
"""For each row of a lane the series of the transfer that begins there; -1: none."""


class TransferWriter:
    """Writes points to a recording."""

    def __init__(self, stream: Stream, contents: Contents, words: Words) -> None:
        """Writes rows to `stream` and updates `contents`."""
        self._stream = stream
        self._contents = contents
        self._words = words
        self._begun: dict[str, tuple[Places, Series]] = {}
        """The last row of each lane."""

    @staticmethod
    def series(of_class: str | None) -> int:
        """Returns the series of a transfer by the class of its state; -1 for none."""
        return _ENDED.get(of_class, -1)

    def tell(self, lane: str, rows: Places, states: "Sequence[tuple[str, str | None]]", which: Series) -> None:
        """Writes the rows of a lane as lines: `which` is the index in `states` of each; an empty text is none."""
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
        """Appends rows of a lane; each transfer lasts until the next row."""
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
            # Shown at the point under the cursor.
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
