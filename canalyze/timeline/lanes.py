"""States over time: a lane per entity, a row per change, coloured by the class of the state.

Must not: know the meaning of a state, or make a text.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import pyarrow as pa
import rerun as rr

from canalyze.timeline.colours import COLOURS, FAULTS, PLAIN
from canalyze.timeline.contents import Contents, Lane
from canalyze.timeline.stream import STATE, Places, Stream, escaped, places
from canalyze.timeline.transfers import LANES, TransferWriter

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
