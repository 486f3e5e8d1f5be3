"""Tables: their columns, in one list, and the way to pyarrow, pandas and polars, which are imported only then.

Columns of the core's tables are as `render/columns/mod.rs` of the core has them; lists of the library have those of
the table of the same name that their rows know. Must not: read a capture.
"""

import importlib
from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from canalyze.errors import CanalyzeError
from canalyze.library import former

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

    from canalyze._core import Table as Core

_COLUMNS: Final[dict[str, str]] = {
    "frames": "frame:uint64 line:uint64? file:word t_ns:int64? bus:word? id:uint32 extended:bool kind:word brs:bool?"
    " esi:bool? dir:word? len:uint8=bytes data:binary service:word node:uint8?",
    "transfers": "transfer:uint64 bus:word? node:uint8 client:uint8? session:uint8?"
    " direction:word mode:word index:uint16? sub:uint8? object:word?"
    " name:word? type:word? size_indicated:uint32?=bytes size:uint64=bytes data:binary string:string? boolean:bool?"
    " integer:int64? raw:uint64? value:float64? text:string status:word abort_code:uint32? abort_by:word?"
    " abort_text:word? first_frame:uint64 last_frame:uint64 first_line:uint64? last_line:uint64? t_ns:int64?"
    " duration_ns:int64? reordered:bool retransmissions:uint32 crc_negotiated:bool? findings:list<string>",
    "states": "t_ns:int64? frame:uint64 bus:word? node:uint8? state:uint8? name:word? source:word command:uint8?",
    "emcy": "t_ns:int64? frame:uint64 bus:word? node:uint8 code:uint16 name:word? register:uint8 manufacturer:binary"
    " active:list<uint16> cleared:list<uint16>",
    "findings": "code:word name:word severity:word file:word frame:uint64? line:uint64? t_ns:int64?"
    " cause_frame:uint64? cause_line:uint64? about_frame:uint64? because_of:uint64? bus:word? node:uint8?"
    " index:uint16? sub:uint8? message:string facts:string",
    "sync_cycles": "cycle:uint64 frame:uint64 t_ns:int64? bus:word? period_ns:int64? counter:uint8? pdos:uint32"
    " delay_min_ns:int64? delay_max_ns:int64? window_ns:int64?",
    "signals": "t_ns:int64? frame:uint64 line:uint64? bus:word? node:uint8 pdo:word signal:word object:word"
    " value:float64?=unit integer:int64?=unit raw:uint64? data:binary? unit:word? text:string? provenance:word",
    "pdo": "t_ns:int64? frame:uint64 provenance:word cycle:uint64? delay_ns:int64? running_cycle:uint64",
    "wide": "t_ns:int64? frame:uint64 provenance:word cycle:uint64? delay_ns:int64? running_cycle:uint64",
    "objects": "t_ns:int64? frame:uint64 bus:word? node:uint8 index:uint16? sub:uint8? source:word name:word?"
    " value:float64?=unit integer:int64?=unit text:string? unit:word?",
    "od": "bus:word? node:uint8 index:uint16 sub:uint8 name:word? type:word? type_from:word? bits:uint64?=bits"
    " access:word? readable:bool? writable:bool? exists:bool? value:float64? integer:int64? text:string? data:binary?"
    " source:word? t_ns:int64? frame:uint64? values:uint64 read:uint64 written:uint64 tpdo:uint64 rpdo:uint64"
    " emcy:uint64 refused:uint64 unconfirmed:uint64 abort_codes:list<uint32> in_force:uint64? in_force_from:word?"
    " first_frame:uint64 last_frame:uint64",
    "listing": "frame:uint64 t_ns:int64? cycle:uint64 bus:word? node:uint8? service:word severity:word? line:string",
    "lanes": "lane:word t_ns:int64? frame:uint64 cycle:uint64 state:word? class:word?",
    "log": "t_ns:int64? frame:uint64 cycle:uint64 bus:word? node:uint8? level:word source:word code:word text:string",
    "load": "t_ns:int64 frame:uint64 cycle:uint64 bus:word? frames:uint32 bits:uint64=bits frames_per_s:float64=1/s"
    " load_percent:float64?=%",
    "problems": "id:uint32 problem:word status:word impact:word grade:word depth:uint64 bus:word? node:uint8?"
    " nodes:list<uint8> axis:uint8? pdo:word? subject:word begin_frame:uint64 t_ns:int64? cycle:uint64"
    " noticed_frame:uint64 noticed_t_ns:int64? end_frame:uint64? end_t_ns:int64? end_cycle:uint64? count:uint64"
    " root:bool cause:uint32? cause_link:word? cause_grade:word? delay_ns:int64? frames:list<uint64> message:string"
    " checks:string facts:string",
    "nodes": "bus:word? node:uint8 name:string? frames:uint64 sent:uint64 tpdos:uint64 rpdos:uint64 state:word?"
    " changes:uint64 boot_ups:uint64 error_control:word? heartbeats:uint64 heartbeat_mean_us:float64?=us"
    " heartbeat_max_us:float64?=us transfers:uint64 ok:uint64 aborted:uint64 failed:uint64 incomplete:uint64"
    " response_mean_us:float64?=us response_max_us:float64?=us emcy_count:uint64",
    "events": "event:word frame:uint64? t_ns:int64? bus:word? node:uint8? text:string",
}
"""Name, type (`?`: may be null), and behind `=` a unit that the name does not end with."""
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
    name = former.table(table)
    if name not in _COLUMNS:
        raise ValueError(f"table={table!r}: one of {', '.join(_COLUMNS)}")
    return tuple(map(_column, _COLUMNS[name].split()))


def column_tables() -> tuple[str, ...]:
    """Returns the names of all tables."""
    return tuple(_COLUMNS)


def _column(text: str) -> Column:
    said, _, unit = text.partition("=")
    name, _, kind = said.partition(":")
    return Column(name, kind.removesuffix("?"), unit or ("ns" if name.endswith("_ns") else ""), kind.endswith("?"))


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
    """Import a library that only an extra brings; CanalyzeError that names the extra where it is not there."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        line = f"pip install 'canalyze[{extra or module}]'"
        raise CanalyzeError("library.extra", name=module, line=line) from error
