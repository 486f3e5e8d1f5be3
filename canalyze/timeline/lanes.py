"""States over time: a lane per entity, a row per change, coloured by the class of the state.

A lane of SDO transfers shows each from its first frame to its last, which is too short to see in a long capture, and
two equal ones look like one: they are also lines in words, and points of their durations, which are visible however
short they are. Problems, known at the end of the capture, have a lane per subject, a log of their begins and ends, and
a list in words; one that overlaps an earlier one of its subject has a lane of its own below it. Must not: know the
meaning of a state, judge, or sort again.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr
from msgspec import convert

from canalyze.records.problems import ProblemRow
from canalyze.timeline.charts import COLOURS, FAULTS, PLAIN
from canalyze.timeline.series import problem_list
from canalyze.timeline.stream import LEVEL, STATE, TEXT, Contents, Lane, Places, Stream, escaped, numbers, path, places
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


_EMPTY = '""'
"""A state without text; an empty text would end the lane."""


_PLOTTED: Final = "pdo/"
"""The plot of a PDO, which is no lane; its samples end as the states of a lane do."""
_TOGETHER: Final = 8
"""Number of batches that are joined, because there are many lanes and each gets a piece of a batch."""
_NARROW: Final = 1 << 15
_COLOURED: Final = 64
"""Maximum number of coloured states of a lane; further ones are coloured by the viewer."""


@dataclass(slots=True)
class _Style:
    """The states of a lane that have a class."""

    entity: str
    kind: str
    classes: dict[str, tuple[str, str | None]] = field(default_factory=dict)
    """Text and class, by the key of the state in Rerun; without a class for values of signals."""
    told: int = 0
    """Number of states that have been written."""

    def key(self, text: str, of_class: str | None) -> str:
        """Returns the key of a state in Rerun; a text with two classes has two keys with the same label."""
        text = text or _EMPTY
        if of_class is None and (self.kind != "value" or len(self.classes) >= _COLOURED):
            return text
        known = self.classes.setdefault(text, (text, of_class))
        if known[1] == of_class:
            return text
        other = f"{text} ({of_class})"
        self.classes.setdefault(other, (text, of_class))
        return other


class LaneWriter:
    """Writes lanes to a recording."""

    def __init__(
        self,
        stream: Stream,
        contents: Contents,
        transfers: TransferWriter,
        *,
        ends: "Callable[[str, Places], None]",
        at_once: bool,
    ) -> None:
        """Writes rows to `stream`, also SDO transfers to `transfers`, and updates `contents`.

        ends: called where the samples of a PDO end. at_once: rows are not kept to be joined.
        """
        self._stream = stream
        self._ends = ends
        self._transfers = transfers
        self._contents = contents
        self._most = 1 if at_once else _TOGETHER
        self._held: list[pa.RecordBatch] = []
        self._styles: dict[str, _Style] = {}
        self._plain: dict[str, int] = {}
        """Colours of values by text, so that a value has the same colour in every lane."""

    def take(self, batch: pa.RecordBatch) -> None:
        """Appends changes of any lanes."""
        self._held.append(batch)
        if len(self._held) >= self._most:
            self.flush()

    def flush(self) -> None:
        """Writes everything to the recording."""
        held, self._held = self._held, []
        if len(held) > 1:
            held = pa.Table.from_batches(held).unify_dictionaries().combine_chunks().to_batches()
        for batch in held:
            self._put(batch)

    def _put(self, batch: pa.RecordBatch) -> None:
        lane, state, of_class = (batch.column(name) for name in ("lane", "state", "class"))
        names, texts = lane.dictionary.to_pylist(), state.dictionary.to_pylist()
        classes = [*of_class.dictionary.to_pylist(), None]
        codes = _codes(lane, 0)
        if len(names) < _NARROW:
            codes = codes.astype(np.int16)  # sorted by counting
        order = np.argsort(codes, kind="stable")
        rows = places(batch)[order]
        # A state with its class is one number; 0 means no state.
        stated = _codes(state, -1)
        pairs = np.where(stated < 0, 0, stated * len(classes) + _codes(of_class, len(classes) - 1) + 1)[order]
        places_of = np.zeros(len(texts) * len(classes) + 1, np.int64)
        starts = np.concatenate(([0], np.cumsum(np.bincount(codes, minlength=len(names)))))
        for name, start, end in zip(names, starts, starts[1:], strict=False):
            if start == end:
                continue
            if name.startswith(_PLOTTED):
                self._ends(escaped(name), rows[start:end])
                continue
            style, own = self._style(name), pairs[start:end]
            found = np.flatnonzero(np.bincount(own))
            places_of[found] = np.arange(len(found))
            states = [divmod(int(one) - 1, len(classes)) if one else None for one in found]
            keys = [style.key(texts[one[0]], classes[one[1]]) if one else "" for one in states]
            shown = pa.array(keys, pa.string()).take(pa.array(places_of[own]))
            of_lane = self._contents.lanes[style.entity]
            of_lane.rows += len(own)
            of_lane.fault |= any(one is not None and classes[one[1]] in FAULTS for one in states)
            self._stream.texts(style.entity, rows[start:end], [(STATE, shown)])
            if name.startswith(LANES):
                series = [self._transfers.series(classes[one[1]]) if one else -1 for one in states]
                self._transfers.take(name, rows[start:end], np.array(series)[places_of[own]])
                said = [(texts[one[0]], classes[one[1]]) if one else ("", None) for one in states]
                self._transfers.tell(name, rows[start:end], said, places_of[own])

    def _style(self, name: str) -> _Style:
        style = self._styles.get(name)
        if style is None:
            entity = escaped(name)
            style = self._styles[name] = _Style(entity, name.partition("/")[0])
            self._contents.lanes[entity] = Lane(entity)
        return style

    def colour(self, most: int | None = None) -> None:
        """Writes the colours of new states, for lanes with up to `most` states."""
        for style in self._styles.values():
            if len(style.classes) == style.told or (most is not None and len(style.classes) > most):
                continue
            style.told = len(style.classes)
            palette = COLOURS.get(style.kind, {})
            known = [
                (key, text, self._value(text) if one is None else palette[one])
                for key, (text, one) in style.classes.items()
                if one is None or one in palette
            ]
            if known:
                keys, texts, colours = zip(*known, strict=True)
                self._stream.always(
                    style.entity,
                    rr.StateConfiguration(values=list(keys), labels=list(texts), colors=np.array(colours, np.uint32)),
                )

    def _value(self, text: str) -> int:
        return self._plain.setdefault(text, PLAIN[len(self._plain) % len(PLAIN)])


def _codes(column: pa.Array, null: int) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
    """Returns the dictionary indices of a column."""
    return np.asarray(column.indices.fill_null(null)).astype(np.int64)


PROBLEMS: Final = "problems"
"""The first part of the paths of lanes."""
_STANDING: Final = {"open": "ERROR", "unknown": "WARN", "ended": "WARN", "harmless": "INFO"}


class ProblemWriter:
    """Writes problems to a recording."""

    def __init__(self, stream: Stream, contents: Contents, words: Words) -> None:
        """Writes rows to `stream` and updates `contents`."""
        self._stream = stream
        self._contents = contents
        self._words = words
        self._rows: list[ProblemRow] = []
        self._begins: list[Places] = []
        self._ends: list[Places] = []

    def take(self, batch: pa.RecordBatch) -> None:
        """Appends problems, in the order of reading."""
        self._rows += convert(batch.to_pylist(), list[ProblemRow])
        begins = places(batch)
        stamps = batch.column("end_t_ns")
        stamped = np.asarray(stamps.is_valid())
        frames, cycles = (numbers(batch.column(name)) for name in ("end_frame", "end_cycle"))
        ends = Places(numbers(stamps), stamped, frames, cycles)
        for row in range(len(batch)):
            one = np.array([row])
            self._begins.append(begins[one])
            self._ends.append(ends[one])

    def finish(self) -> str:
        """Writes all problems; returns their list in Markdown, or "" without problems."""
        if not self._rows:
            return ""
        rows = range(len(self._rows))
        for entity, spans in self._lanes(sorted(rows, key=lambda row: self._rows[row].begin_frame)).items():
            self._lane(entity, spans)
        for row in rows:
            self._log(row)
        return problem_list([(one, self._caused(one)) for one in self._rows], self._words)

    def _caused(self, one: ProblemRow) -> str:
        """Returns the cause and the delay after it in words; "" for a root."""
        if one.cause is None:
            return ""
        delay = one.delay_ns
        key = "timeline.caused" if delay is None else "timeline.caused_after"
        return self._words(key, number=one.cause, ms="" if delay is None else f"{delay / _MS:+.1f}")

    def _title(self, one: ProblemRow) -> str:
        caused = self._caused(one)
        return f"#{one.id} {one.message}" + (f" ({caused})" if caused else "")

    def _lanes(self, rows: Sequence[int]) -> dict[str, list[int]]:
        """Returns the problems of each lane, which do not overlap."""
        found: dict[str, list[int]] = {}
        for row in rows:
            one = self._rows[row]
            if not one.begin_frame:  # of the capture as a whole
                continue
            number = 1
            while True:
                below = "" if number == 1 else str(number)
                entity = path(PROBLEMS, one.bus or "", one.subject, below)
                last = found.get(entity)
                if last is None or self._is_free(last[-1], row):
                    break
                number += 1
            found.setdefault(entity, []).append(row)
        return found

    def _is_free(self, before: int, row: int) -> bool:
        end = self._rows[before].end_frame
        return end is not None and end <= self._rows[row].begin_frame

    def _lane(self, entity: str, rows: Sequence[int]) -> None:
        pieces: list[Places] = []
        states: list[str] = []
        for row in rows:
            one = self._rows[row]
            pieces.append(self._begins[row])
            states.append(str(one.id))
            if one.end_frame is not None:
                pieces.append(self._ends[row])
                states.append("")
        palette = COLOURS[PROBLEMS]
        ours = [self._rows[row] for row in rows]
        style = rr.StateConfiguration(
            values=[str(one.id) for one in ours],
            labels=[self._title(one) for one in ours],
            # An array: a list of three or four numbers would be taken for one colour.
            colors=np.array([palette[one.status] for one in ours], np.uint32),
        )
        self._stream.always(entity, style)
        at = pieces[0]
        for piece in pieces[1:]:
            at = at.followed_by(piece)
        self._stream.texts(entity, at, [(STATE, pa.array(states, pa.string()))])
        fault = any(one.status == "open" for one in ours)
        self._contents.lanes[entity] = Lane(entity, len(states), fault)

    def _log(self, row: int) -> None:
        one, words = self._rows[row], self._words
        told = [(self._begins[row], "timeline.begins", _STANDING[one.status])]
        if one.end_frame is not None and one.end_frame > one.begin_frame:
            told.append((self._ends[row], "timeline.ends", "INFO"))
        for place, key, level in told:
            text = words(key, title=self._title(one))
            columns = [(TEXT, pa.array([text], pa.string())), (LEVEL, pa.array([level], pa.string()))]
            self._stream.texts("/log/problems", place, columns)
            self._contents.logged[level] = self._contents.logged.get(level, 0) + 1
