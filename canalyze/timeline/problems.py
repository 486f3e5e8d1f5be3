"""Problems: a lane per subject with spans, a log of their begins and ends, and a list in words.

A problem that overlaps an earlier one of its subject has a lane of its own below it. Problems are known at the end
of the capture. Must not: judge, or sort again.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
import pyarrow as pa
import rerun as rr
from msgspec import convert

from canalyze.records.problems import ProblemRow
from canalyze.timeline.colours import COLOURS
from canalyze.timeline.contents import Contents, Lane
from canalyze.timeline.logs import problem_list
from canalyze.timeline.stream import LEVEL, STATE, TEXT, Places, Stream, numbers, path, places
from canalyze.words import Words

KIND: Final = "problems"
"""The first part of the paths of lanes."""
_LEVELS: Final = {"open": "ERROR", "unknown": "WARN", "ended": "WARN", "harmless": "INFO"}
_MS: Final = 1e6
"""Nanoseconds in a millisecond."""


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
                entity = path(KIND, one.bus or "", one.subject, below)
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
        palette = COLOURS[KIND]
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
        told = [(self._begins[row], "timeline.begins", _LEVELS[one.status])]
        if one.end_frame is not None and one.end_frame > one.begin_frame:
            told.append((self._ends[row], "timeline.ends", "INFO"))
        for place, key, level in told:
            text = words(key, title=self._title(one))
            columns = [(TEXT, pa.array([text], pa.string())), (LEVEL, pa.array([level], pa.string()))]
            self._stream.texts("/log/problems", place, columns)
            self._contents.logged[level] = self._contents.logged.get(level, 0) + 1
