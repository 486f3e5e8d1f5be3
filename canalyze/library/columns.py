"""Tables: their columns, in one list, and the way to pyarrow, pandas and polars, which are imported only then.

Columns of the core's tables are those of its schema; lists of the library have those of the table of the same name
that their rows know. Former names of the library are still accepted for a release, and each use warns; those of
classes are in `canalyze/__init__.py`. Must not: read a capture.
"""

import importlib
import json
import warnings
from collections.abc import Collection, Iterable, Sequence
from functools import cache
from html import escape
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from canalyze.errors import CanalyzeError, needed

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

    from canalyze._core import Table as Core

TABLES: Final = {"incidents": "problems"}
"""Former names of tables of columns, each with that of today."""


def renamed(name: str, today: str) -> property:
    """Returns an attribute by its former name, with a warning."""

    def get(self: Any) -> Any:
        warn(name, today)
        return getattr(self, today)

    return property(get, doc=f"Deprecated: the former name of `{today}`.")


def present(name: str) -> str:
    """Returns the present name of a table."""
    if name in TABLES:
        warn(name, TABLES[name])
    return TABLES.get(name, name)


def warn(name: str, today: str) -> None:
    """Warns about the use of a former name."""
    warnings.warn(f"{name} is called {today} now", DeprecationWarning, stacklevel=3)


_OWN: Final = {
    "nodes": "bus:word? node:uint8 name:string? frames:uint64 sent:uint64 tpdos:uint64 rpdos:uint64 state:word?"
    " changes:uint64 boot_ups:uint64 error_control:word? heartbeats:uint64 heartbeat_mean_us:float64?"
    " heartbeat_max_us:float64? transfers:uint64 ok:uint64 aborted:uint64 failed:uint64 incomplete:uint64"
    " response_mean_us:float64? response_max_us:float64? emcy_count:uint64",
    "events": "event:word frame:uint64? t_ns:int64? bus:word? node:uint8? text:string",
}
"""Tables that the core does not build: names and types, `?` behind those that may be null."""
_TEXTS: Final = frozenset({"text", "string", "message", "facts", "checks", "line"})
"""Columns of the core's strings that hold many different values."""
_UNITS: Final = {"len": "bytes", "size": "bytes", "size_indicated": "bytes", "bits": "bits"}
_ENDS: Final = {"_ns": "ns", "_us": "us", "_percent": "%", "_per_s": "1/s"}
"""Units by the end of a name."""
_LISTED: Final = 10
_WIDE: Final = 60


class Column(NamedTuple):
    """A column of a table."""

    name: str
    type: str
    """As Arrow calls it; `word` is a dictionary-encoded string, of which there are few different ones."""
    unit: str
    """ns, us, bytes, bits, % or 1/s; `unit`: as the column of that name says; "" where there is none."""
    nullable: bool
    """True if there may be none."""


def columns(table: str) -> tuple[Column, ...]:
    """Returns the columns of a table, one of `column_tables()`. ValueError for another name.

    All but `nodes` and `events` are those of `Capture.tables`; `pdo` and `wide` stand for the tables of PDOs, in
    which the signals follow. Lists of a capture give the same columns, as far as a row has them.
    """
    name = present(table)
    if name not in (tables := column_tables()):
        raise ValueError(f"table={table!r}: one of {', '.join(tables)}")
    rows = [text.partition(":")[::2] for text in _OWN.get(name, "").split()]
    own = [(name, kind.removesuffix("?"), kind.endswith("?")) for name, kind in rows]
    made = own or _of_the_core(name)
    names = {name for name, _, _ in made}
    return tuple(Column(name, kind, _unit(name, names), nullable) for name, kind, nullable in made)


def column_tables() -> tuple[str, ...]:
    """Returns the names of all tables."""
    from canalyze._core import TABLES

    return (*TABLES, *_OWN)


@cache
def _of_the_core(table: str) -> tuple[tuple[str, str, bool], ...]:
    """Returns name and type of each column of a table, and true if it may be null."""
    from canalyze._core import schema

    record = "pdo" if table == "wide" else table
    rows = next(one["columns"] for one in json.loads(schema()) if one["table"] == record)
    return tuple((row["column"], _type(row["column"], row["arrow"]), row["nullable"]) for row in rows if row["column"])


def _type(name: str, arrow: str) -> str:
    if arrow == "string" and name not in _TEXTS:
        return "word"
    return f"list<{item}>" if (item := arrow.removeprefix("list of ")) != arrow else arrow


def _unit(name: str, names: Collection[str]) -> str:
    if name in ("value", "integer") and "unit" in names:
        return "unit"
    return _UNITS.get(name) or next((unit for end, unit in _ENDS.items() if name.endswith(end)), "")


class Tabular:
    """Rows that can be converted to a table."""

    __slots__ = ()

    def arrow(self) -> "pyarrow.Table":
        """Returns it as a `pyarrow.Table`; `canalyze.columns` lists the columns. CanalyzeError without pyarrow."""
        raise NotImplementedError

    def to_pandas(self) -> "pandas.DataFrame":
        """Returns it as a DataFrame of pandas, integers as integers also where some are missing (extra `pandas`)."""
        pandas = needs("pandas")
        table = self.arrow()
        arrow = needs("pyarrow", "pandas")
        sizes = (8, 16, 32, 64)
        mapped = {getattr(arrow, f"int{size}")(): getattr(pandas, f"Int{size}Dtype")() for size in sizes}
        mapped |= {getattr(arrow, f"uint{size}")(): getattr(pandas, f"UInt{size}Dtype")() for size in sizes}
        mapped[arrow.bool_()] = pandas.BooleanDtype()
        return table.to_pandas(types_mapper=mapped.get)

    def to_polars(self) -> "polars.DataFrame":
        """Returns it as a DataFrame of polars (extra `polars`)."""
        frame: polars.DataFrame = needs("polars").DataFrame(self.arrow())
        return frame

    def _repr_html_(self) -> str:
        """Returns its first rows for a notebook."""
        names, rows, count, what = self._shown()
        return html_table(names, rows, f"{count} {what}")

    def _shown(self) -> tuple[Sequence[str], Iterable[Sequence[object]], int, str]:
        """Returns names of columns, first rows, the number of rows and their kind, for a notebook."""
        raise NotImplementedError


class Table(Tabular):
    """A table of columns of a capture; readers of Arrow take it as it is: `pyarrow.table(table)`."""

    __slots__ = ("_core",)

    def __init__(self, core: "Core") -> None:
        """Wraps a table of the core."""
        self._core = core

    @property
    def name(self) -> str:
        """The name of the table; of those of PDOs `pdo/BUS/NODE.PDO/VERSION`."""
        return self._core.name

    @property
    def num_rows(self) -> int:
        """The number of rows."""
        return self._core.num_rows

    @property
    def column_names(self) -> list[str]:
        """The names of its columns, in order."""
        return self._core.column_names

    @property
    def metadata(self) -> dict[str, str]:
        """The metadata of the schema: `table`, its name; of those of PDOs also bus, node, pdo, version and lang."""
        return self._core.metadata

    def column(self, name: str) -> list[Any]:
        """Returns the values of a column. KeyError: there is none."""
        return self._core.column(name)

    def arrow(self) -> "pyarrow.Table":
        """Returns it as a `pyarrow.Table`, without a copy. CanalyzeError without pyarrow (extra `arrow`)."""
        return needs("pyarrow", "arrow").table(self)

    def __len__(self) -> int:
        return self._core.num_rows

    def __repr__(self) -> str:
        return repr(self._core)

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        return self._core.__arrow_c_stream__(requested_schema)

    def __arrow_c_schema__(self) -> object:
        return self._core.__arrow_c_schema__()

    def _shown(self) -> tuple[Sequence[str], Iterable[Sequence[object]], int, str]:
        names = self.column_names
        firsts = [self.column(name)[:_LISTED] for name in names]
        return names, zip(*firsts, strict=True), len(self), f"rows: {self.name}"


def table_of(table: str, values: dict[str, list[Any]]) -> "pyarrow.Table":
    """Makes a table of columns that are lists, of the types that `columns` has."""
    arrow = needs("pyarrow", "arrow")

    made = {"word": arrow.string, "bool": arrow.bool_}

    def kind(name: str) -> Any:
        if name.startswith("list<"):
            return arrow.list_(kind(name[5:-1]))
        return (made.get(name) or getattr(arrow, name))()

    known = [column for column in columns(table) if column.name in values]
    fields = [arrow.field(column.name, kind(column.type), column.nullable) for column in known]
    return arrow.table({column.name: values[column.name] for column in known}, arrow.schema(fields))


def html_table(names: Sequence[str], rows: Iterable[Sequence[object]], caption: str) -> str:
    """Returns a short table for a notebook; what comes from a capture is escaped."""
    heads = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = [
        "".join(f"<td>{escape(_cell(value))}</td>" for value in row)
        for row, _ in zip(rows, range(_LISTED), strict=False)
    ]
    lines = "".join(f"<tr>{row}</tr>" for row in body)
    return f"<table><caption>{escape(caption)}</caption><thead><tr>{heads}</tr></thead><tbody>{lines}</tbody></table>"


def _cell(value: object) -> str:
    if value is None:
        return ""
    text = value[:_WIDE].hex(" ").upper() if isinstance(value, bytes) else str(value)
    text = "".join(char if char.isprintable() else "\ufffd" for char in text)
    return text if len(text) <= _WIDE else f"{text[: _WIDE - 3]}..."


def needs(module: str, extra: str = "") -> Any:
    """Imports a library that only an extra brings; CanalyzeError that names the extra where it is not there."""
    with needed(CanalyzeError, module, extra or module):
        return importlib.import_module(module)
