"""Writes Arrow columns as columns of Rerun's components, without an object per row.

Must not: know the meaning of the rows, or the rest of the recording.
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
