"""Rows on their way into a recording: Arrow's columns become columns of Rerun's components, without an object a row.

Must not: know what the rows are, or what else is in the recording.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from canalyze.timeline.clock import Clock, Places

if TYPE_CHECKING:
    from rerun import ComponentDescriptor

SCALARS: "Final[ComponentDescriptor]" = rr.Scalars.descriptor_scalars()
STATE: "Final[ComponentDescriptor]" = rr.StateChange.descriptor_state()
TEXT: "Final[ComponentDescriptor]" = rr.TextLog.descriptor_text()
LEVEL: "Final[ComponentDescriptor]" = rr.TextLog.descriptor_level()

_NO_PART: Final = frozenset("/%")


class _Values(rr.ComponentBatchLike):
    """A column as it is."""

    def __init__(self, array: pa.Array) -> None:
        self._array = array

    def as_arrow_array(self) -> pa.Array:
        return self._array


class Stream:
    """A recording, as those see it who put rows into it."""

    def __init__(self, recording: rr.RecordingStream, clock: Clock) -> None:
        """Rows go into `recording`, to where `clock` says that they stand."""
        self._recording = recording
        self._clock = clock

    @property
    def start_ns(self) -> int:
        """The stamp that time is counted from."""
        return self._clock.start_ns

    def scalars(self, entity: str, rows: Places, values: npt.NDArray[np.float64]) -> None:
        """Put rows of numbers; `values` has a column for each line of the entity's plot, NaN where there is none."""
        for some, indexes in self._clock.pieces(rows):
            block = values if some is None else values[some]
            column = rr.ComponentColumn(
                SCALARS, _Values(pa.array(block.reshape(-1))), lengths=np.full(len(block), block.shape[1], np.int32)
            )
            rr.send_columns(entity, indexes, [column], recording=self._recording)

    def texts(self, entity: str, rows: Places, columns: "Sequence[tuple[ComponentDescriptor, pa.Array]]") -> None:
        """Put rows of texts, one of each column."""
        for some, indexes in self._clock.pieces(rows):
            taken = [(what, texts if some is None else texts.take(pa.array(some))) for what, texts in columns]
            sent = [rr.ComponentColumn(what, _Values(texts)) for what, texts in taken]
            rr.send_columns(entity, indexes, sent, recording=self._recording)

    def always(self, entity: str, what: Any) -> None:
        """Put what holds for the entity at any time; the last one counts."""
        self._recording.log(entity, what, static=True)


def path(*parts: str) -> str:
    """Give the path of an entity as Rerun takes it; parts that are empty are left out."""
    return rr.new_entity_path([part(one) for one in parts if one])


def part(name: str) -> str:
    """Give a name as a part of a path, as the core writes those of lanes: no blanks, and what is unsafe as %2F."""
    return "".join("_" if c == " " else c if c.isprintable() and c not in _NO_PART else _percent(c) for c in name)


def _percent(char: str) -> str:
    return "".join(f"%{byte:02X}" for byte in char.encode("utf-8", "surrogateescape"))


def escaped(lane: str) -> str:
    """Give the path of an entity for one whose parts are made already, as those of lanes."""
    return rr.new_entity_path(lane.split("/"))


def plain(column: pa.Array) -> pa.Array:
    """Give the texts of a column of words."""
    return column.dictionary_decode() if pa.types.is_dictionary(column.type) else column


def words(column: pa.Array) -> set[str]:
    """Give the words of a column."""
    return {word for word in column.unique().to_pylist() if word is not None}


def mapped(column: pa.Array, table: dict[str | None, str]) -> pa.Array:
    """Give another word for each word of a column, that of None for null."""
    column = column if pa.types.is_dictionary(column.type) else column.dictionary_encode()
    others = pa.array([*(table[word] for word in column.dictionary.to_pylist()), table[None]], pa.string())
    return others.take(column.indices.fill_null(len(others) - 1))
