"""Batches of the tables that a timeline is made of, by hand: for tests of how a timeline is written, without a capture.

What it must not do: stand for what the core says of a capture; tests of that read captures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import pyarrow as pa

from canalyze import _core
from canalyze.running.reading import SessionOptions

WORDS = pa.dictionary(pa.int32(), pa.string())


@cache
def columns(table: str) -> pa.Schema:
    """The columns that the core gives a table."""
    session = _core.Session(SessionOptions(format="columns", tables=(table,), lang="en"))
    session.begin("capture.log", True, "candump")
    session.end()
    session.finish()
    ((_, batch),) = session.batches()
    return pa.schema(batch)


def table(name: str, rows: Sequence[Mapping[str, Any]]) -> tuple[str, Any]:
    """A batch of a table; columns that a row leaves out are null, its cycle 0, its bus can0."""
    given = [{"cycle": 0, "bus": "can0", **row} for row in rows]
    schema = columns(name).with_metadata({"table": name})
    arrays = [pa.array([row.get(field.name) for row in given], field.type) for field in schema]
    return name, pa.RecordBatch.from_arrays(arrays, schema=schema)


def pdo(
    node: int,
    which: str,
    signals: Mapping[str, tuple[pa.DataType, Mapping[str, str], Sequence[Any]]],
    rows: Sequence[Mapping[str, Any]],
    *,
    bus: str = "can0",
    version: int = 1,
) -> tuple[str, Any]:
    """A batch of a PDO: each signal has a type, its column's metadata and its values."""
    name = "/".join(one for one in ("pdo", bus, f"{node}.{which}", str(version)) if one)
    fixed = {
        "t_ns": pa.int64(),
        "frame": pa.uint64(),
        "provenance": WORDS,
        "cycle": pa.uint64(),
        "delay_ns": pa.int64(),
        "running_cycle": pa.uint64(),
    }
    fields = [pa.field(column, of) for column, of in fixed.items()]
    given = [{"running_cycle": row.get("cycle", 0), **row} for row in rows]
    arrays = [pa.array([row.get(column) for row in given], of) for column, of in fixed.items()]
    for signal, (of, meta, values) in signals.items():
        whole = {"object": "6000:00", "factor": "1", "quantity": "true", **meta}
        fields.append(pa.field(signal, of, metadata=whole))
        arrays.append(pa.array(values, of))
    metadata = {"table": name, "bus": bus, "node": str(node), "pdo": which, "version": str(version), "lang": "zh"}
    return name, pa.RecordBatch.from_arrays(arrays, schema=pa.schema(fields, metadata=metadata))
