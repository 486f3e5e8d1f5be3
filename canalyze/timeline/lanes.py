"""States over time: a lane an entity, a row a change, the class of a state as its colour.

Must not: know what a state means, or make a text.
"""

from dataclasses import dataclass, field

import numpy as np
import pyarrow as pa
import rerun as rr

from canalyze.timeline.clock import places
from canalyze.timeline.colours import COLOURS
from canalyze.timeline.contents import Contents, Lane
from canalyze.timeline.stream import STATE, Stream, escaped

_EMPTY = '""'
"""A state without text: an empty one would end the lane."""


@dataclass(slots=True)
class _Style:
    """The states of a lane that have a class."""

    entity: str
    kind: str
    classes: dict[str, tuple[str, str]] = field(default_factory=dict)
    """Text and class, by the state as Rerun has it."""
    told: int = 0
    """How many the recording knows."""

    def key(self, text: str, of_class: str | None) -> str:
        """Give a state as Rerun has it; one text of two classes is two states that are called the same."""
        text = text or _EMPTY
        if of_class is None:
            return text
        known = self.classes.setdefault(text, (text, of_class))
        if known[1] == of_class:
            return text
        other = f"{text} ({of_class})"
        self.classes.setdefault(other, (text, of_class))
        return other


class LaneWriter:
    """Lanes on their way into a recording."""

    def __init__(self, stream: Stream, contents: Contents) -> None:
        """Rows go to `stream`; `contents` is told what there is."""
        self._stream = stream
        self._contents = contents
        self._styles: dict[str, _Style] = {}

    def take(self, batch: pa.RecordBatch) -> None:
        """Take changes of any lanes."""
        rows = places(batch)
        lane, state, of_class = (batch.column(name) for name in ("lane", "state", "class"))
        texts, classes = state.dictionary.to_pylist(), [*of_class.dictionary.to_pylist(), None]
        # A state with its class is one number; -1 is none.
        pair = _codes(state, -1) * len(classes) + _codes(of_class, len(classes) - 1)
        pair[_codes(state, -1) < 0] = -1
        codes = _codes(lane, 0)
        order = np.argsort(codes, kind="stable")
        starts = np.searchsorted(codes[order], np.arange(len(lane.dictionary) + 1))
        for code, name in enumerate(lane.dictionary.to_pylist()):
            some = order[starts[code] : starts[code + 1]]
            if not len(some):
                continue
            style = self._style(name)
            found, which = np.unique(pair[some], return_inverse=True)
            keys = [
                "" if one < 0 else style.key(texts[one // len(classes)], classes[one % len(classes)]) for one in found
            ]
            self._contents.lanes[style.entity].rows += len(some)
            self._stream.texts(style.entity, rows[some], [(STATE, pa.array(keys, pa.string()).take(pa.array(which)))])

    def _style(self, name: str) -> _Style:
        style = self._styles.get(name)
        if style is None:
            entity = escaped(name)
            style = self._styles[name] = _Style(entity, name.partition("/")[0])
            self._contents.lanes[entity] = Lane(entity)
        return style

    def colour(self) -> None:
        """Tell the colours of the states that are new."""
        for style in self._styles.values():
            if len(style.classes) == style.told:
                continue
            style.told = len(style.classes)
            palette = COLOURS.get(style.kind, {})
            known = [(key, text, palette[one]) for key, (text, one) in style.classes.items() if one in palette]
            if known:
                keys, texts, colours = zip(*known, strict=True)
                self._stream.always(
                    style.entity,
                    rr.StateConfiguration(values=list(keys), labels=list(texts), colors=np.array(colours, np.uint32)),
                )


def _codes(column: pa.Array, null: int) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
    """Give the numbers of a column's words."""
    return np.asarray(column.indices.fill_null(null)).astype(np.int64)
