"""The core's batches in the columns of an export: times as timestamps, plain types, names that SQL takes, units.

| the core has | an export has |
|---|---|
| `t_ns`, `end_t_ns`, ... | `t`, `end_t`, ...: TIMESTAMP in microseconds, UTC; null where no date is known |
| the same, where `t` cannot hold it | `t_ns` besides, on the same clock: without a date, or with digits below 1 µs |
| unsigned numbers | signed ones with more bits, which every reader has; a value of 64 bits stays as it is |
| - | `capture`: which one it is |

Must not: write, or know where a column ends up.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

import pyarrow as pa
import pyarrow.compute as pc

from canalyze.output import printable
from canalyze.values import DATES_NS

_US: Final = 1000
_TIME: Final = pa.timestamp("us", "UTC")
_WORD: Final = pa.dictionary(pa.int32(), pa.string())
_SIGNED: Final = {pa.uint8(): pa.int16(), pa.uint16(): pa.int32(), pa.uint32(): pa.int64(), pa.uint64(): pa.int64()}
_UNSAFE: Final = (
    r"^[=+\-@]|[\x00-\x1f\x7f-\x{a0}\x{ad}\x{61c}\x{180e}"
    r"\x{200b}-\x{200f}\x{2028}-\x{202e}\x{2060}-\x{206f}\x{feff}]"
)
"""Text that CSV must escape: characters that control a terminal or break a line, and the begin of a formula."""
_WHOLE: Final = frozenset({"raw"})
"""Columns of values that need all of 64 bits; others are counters."""
_KEPT: Final = ("t_ns", "frame", "provenance", "cycle", "delay_ns")
"""Columns of a wide table before its signals; `running_cycle` is left out."""
_FIRST: Final = ("t", "t_ns", "capture")
SIGNALS: Final = 2000
"""Maximum number of columns of signals in a wide table: a file of more takes longer to write than the rows."""
RAW: Final = "__raw"
"""Suffix of a number whose words are the column before."""

Made = tuple[pa.Field, pa.Array]


class Of(NamedTuple):
    """The properties common to all rows of a capture."""

    capture: str
    """Its name."""
    date_ns: int = 0
    """The date from which relative stamps count, 0 if unknown."""
    exact: bool = False
    """True if stamps are always exported as numbers, too."""


def fixed(batch: pa.RecordBatch, units: Mapping[str, str], of: Of) -> pa.RecordBatch:
    """Returns the rows of a table with fixed columns."""
    made: list[Made] = []
    for field, values in zip(batch.schema, batch.columns, strict=True):
        made += _column(field, values, units.get(field.name, ""), of)
    return _batch(batch.schema.metadata, [*made, _constant("capture", of.capture, len(batch))])


def wide(batch: pa.RecordBatch, names: Mapping[str, str], of: Of) -> pa.RecordBatch:
    """Returns the rows of a message: `names` contains the column for each signal."""
    about, count = said_of(batch.schema), len(batch)
    made = [
        *_column(batch.schema.field("t_ns"), batch.column("t_ns"), "ns", of),
        _constant("bus", about["bus"] or None, count),
        (pa.field("node", pa.int16(), False), pa.repeat(pa.scalar(int(about["node"]), pa.int16()), count)),
        (pa.field("mapping", pa.int16(), False), pa.repeat(pa.scalar(int(about["version"]), pa.int16()), count)),
    ]
    for name in _KEPT[1:]:
        made += _column(batch.schema.field(name), batch.column(name), "ns" if name.endswith("_ns") else "", of)
    for name, column in names.items():
        field, values = batch.schema.field(name), batch.column(name)
        unit = "" if column.endswith(RAW) else said_of(field).get("unit", "")
        kind = field.type if field.type == pa.uint64() else _SIGNED.get(field.type, field.type)
        made.append((_field(column, kind, field.nullable, unit), values.cast(kind)))
    return _batch(None, [*made, _constant("capture", of.capture, count)])


class Message:
    """The columns of one wide table: those of all PDOs and mappings in it.

    Signals of one name share a column if they have the same unit and kind; a further one of the name, also one that
    differs only in case, has the suffix `_2`. Mappings that would need more than SIGNALS columns are left out.
    """

    def __init__(self) -> None:
        """Starts with the columns that every wide table has."""
        self._columns: dict[str, tuple[str, tuple[str, str]]] = {
            name: (name, ("", "")) for name in (*_FIRST, *_KEPT, "bus", "node", "mapping")
        }
        """Name, unit and kind by the name in lower case."""
        self._most = len(self._columns) + SIGNALS
        self._names: dict[str, dict[str, str] | None] = {}

    def names(self, table: str, schema: pa.Schema) -> dict[str, str] | None:
        """Returns the columns of a table's signals, by their names there; None if it is left out."""
        if table not in self._names:
            used: set[str] = set()
            before = len(self._columns)
            names = {field.name: self._name(field, used) for field in schema if field.metadata}
            fits = len(self._columns) <= self._most
            while not fits and len(self._columns) > before:
                self._columns.popitem()
            self._names[table] = names if fits else None
        return self._names[table]

    def _name(self, field: pa.Field, used: set[str]) -> str:
        about = said_of(field)
        stem = field.name.removesuffix(RAW)
        base = identifier(stem) or identifier(about["object"])
        base += RAW if stem != field.name else ""
        like = (about.get("unit", ""), _kind(field.type))
        number, name = 1, base
        while name.lower() in used or self._columns.get(name.lower(), (name, like))[1] != like:
            number += 1
            name = f"{base}_{number}"
        used.add(name.lower())
        return self._columns.setdefault(name.lower(), (name, like))[0]


def identifier(name: str) -> str:
    """Returns a name of letters, digits and `_` that does not begin with a digit; "" if nothing is left."""
    found = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")
    return f"_{found}" if found[:1].isdigit() else found


def said_of(what: "pa.Schema | pa.Field") -> dict[str, str]:
    """Returns the metadata of a schema or a field as text."""
    return {key.decode(): value.decode() for key, value in (what.metadata or {}).items()}


def kind_of(data_type: pa.DataType) -> str:
    """Returns the name of a type for the catalog."""
    if pa.types.is_dictionary(data_type):
        return kind_of(data_type.value_type)
    if pa.types.is_list(data_type):
        return f"list<{kind_of(data_type.value_type)}>"
    return str(data_type)


def joined(batches: Sequence[pa.RecordBatch], schema: pa.Schema) -> pa.Table:
    """Returns the rows of batches in the columns of a wider schema; missing columns are null.

    Each column is joined from the batches that have it: many mappings of a few rows each cost no more than their cells.
    """
    if all(batch.schema.equals(schema) for batch in batches):
        return pa.Table.from_batches(batches, schema)
    chunks: dict[str, list[pa.Array]] = {name: [] for name in schema.names}
    filled = dict.fromkeys(chunks, 0)
    count = 0
    for batch in batches:
        for name, values in zip(batch.schema.names, batch.columns, strict=True):
            kind = schema.field(name).type
            if gap := count - filled[name]:
                chunks[name].append(pa.nulls(gap, kind))
            chunks[name].append(values.cast(kind, safe=False))
            filled[name] = count + len(batch)
        count += len(batch)
    for name, kind in zip(schema.names, schema.types, strict=True):
        if gap := count - filled[name]:
            chunks[name].append(pa.nulls(gap, kind))
    return pa.table(
        [pa.chunked_array(chunks[name], kind) for name, kind in zip(schema.names, schema.types, strict=True)],
        schema=schema,
    )


def plain(batch: pa.RecordBatch) -> pa.RecordBatch:
    """Returns rows without dictionaries, which an Arrow file may have only once."""
    arrays = [one.dictionary_decode() if pa.types.is_dictionary(one.type) else one for one in batch.columns]
    return _replaced(batch, arrays)


def texts(batch: pa.RecordBatch) -> pa.RecordBatch:
    """Returns rows for CSV: bytes in hexadecimal, lists separated by blanks, text without formulas."""
    return _replaced(plain(batch), [_text(one) for one in plain(batch).columns])


def _text(values: pa.Array) -> pa.Array:
    if pa.types.is_list(values.type):
        return pc.binary_join(values.cast(pa.list_(pa.string())), " ")
    if pa.types.is_string(values.type) or pa.types.is_large_string(values.type):
        return _harmless(values)
    if not pa.types.is_binary(values.type):
        return values
    _, offsets, data = values.buffers()
    ends = pa.Array.from_buffers(pa.int32(), len(values) + 1, [None, offsets], offset=values.offset)
    digits = pa.py_buffer((data.to_pybytes() if data else b"").hex().upper().encode())
    doubled = pc.multiply(ends, pa.scalar(2, pa.int32()))
    text = pa.StringArray.from_buffers(len(values), doubled.buffers()[1], digits)
    return text if not values.null_count else pc.if_else(values.is_valid(), text, None)


def _harmless(values: pa.Array) -> pa.Array:
    """Returns text without control characters or formulas, escaped as in the core's CSV."""
    if not pc.any(pc.match_substring_regex(values, _UNSAFE)).as_py():
        return values
    return pa.array([None if text is None else _cell(text) for text in values.to_pylist()], values.type)


def _cell(text: str) -> str:
    escaped = printable(text)
    return f"'{escaped}" if escaped.startswith(("=", "+", "-", "@")) else escaped


def _replaced(batch: pa.RecordBatch, arrays: list[pa.Array]) -> pa.RecordBatch:
    fields = [field.with_type(one.type) for field, one in zip(batch.schema, arrays, strict=True)]
    return pa.record_batch(arrays, schema=pa.schema(fields, batch.schema.metadata))


def _column(field: pa.Field, values: pa.Array, unit: str, of: Of) -> Iterator[Made]:
    """Yields the exported columns of a column; a time may become two."""
    name, kind = field.name, field.type
    if name == "t_ns" or name.endswith("_t_ns"):
        values, times, whole = _times(values, of.date_ns)
        yield pa.field(name.removesuffix("_ns"), _TIME, True), times
        if of.exact or not whole:
            yield _field(name, kind, True, "ns"), values
        return
    if pa.types.is_list(kind) and kind.value_type in _SIGNED:
        kind = pa.list_(_SIGNED[kind.value_type])
    elif name not in _WHOLE:
        kind = _SIGNED.get(kind, kind)
    yield _field(name, kind, field.nullable, "" if unit == "unit" else unit), values.cast(kind)


def _times(values: pa.Array, date_ns: int) -> tuple[pa.Array, pa.Array, bool]:
    """Returns stamps with the known date added, the same as timestamps, and true if timestamps hold them all."""
    least = pc.min(values).as_py()
    if least is not None and least < DATES_NS and date_ns:
        values = pc.if_else(pc.less(values, DATES_NS), pc.add(values, date_ns), values)
        least = pc.min(values).as_py()
    micros = pc.divide(values, _US)
    if least is not None and least < DATES_NS:
        return values, pc.if_else(pc.greater_equal(values, DATES_NS), micros, None).cast(_TIME), False
    return values, micros.cast(_TIME), pc.all(pc.equal(pc.multiply(micros, _US), values)).as_py() is not False


def _kind(data_type: pa.DataType) -> str:
    """Returns the kind of a type for shared columns: numbers of any width are one kind, except 64 unsigned bits."""
    if pa.types.is_floating(data_type) or (pa.types.is_integer(data_type) and data_type != pa.uint64()):
        return "number"
    return kind_of(data_type)


def _constant(name: str, word: str | None, count: int) -> Made:
    places = pa.nulls(count, pa.int32()) if word is None else pa.repeat(pa.scalar(0, pa.int32()), count)
    return pa.field(name, _WORD, word is None or name == "bus"), pa.DictionaryArray.from_arrays(places, [word or ""])


def _field(name: str, kind: pa.DataType, nullable: bool, unit: str) -> pa.Field:
    return pa.field(name, kind, nullable, {"unit": unit} if unit else None)


def _batch(metadata: Any, made: list[Made]) -> pa.RecordBatch:
    """Joins columns to a batch: times first, then the columns that every table has."""
    first = {name: place for place, name in enumerate(_FIRST)}
    made = sorted(made, key=lambda one: first.get(one[0].name, len(first)))
    schema = pa.schema([field for field, _ in made], metadata)
    return pa.record_batch([values for _, values in made], schema=schema)
