"""Batches of the tables that a timeline is made of, by hand: for tests of how a timeline is written, without a capture.

What it must not do: stand for what the core says of a capture; tests of that read captures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow as pa

WORDS = pa.dictionary(pa.int32(), pa.string())
TYPES: dict[str, dict[str, pa.DataType]] = {
    "listing": {
        "frame": pa.uint64(),
        "t_ns": pa.int64(),
        "cycle": pa.uint64(),
        "bus": WORDS,
        "node": pa.uint8(),
        "service": WORDS,
        "severity": WORDS,
        "line": pa.string(),
    },
    "lanes": {
        "lane": WORDS,
        "t_ns": pa.int64(),
        "frame": pa.uint64(),
        "cycle": pa.uint64(),
        "state": WORDS,
        "class": WORDS,
    },
    "log": {
        "t_ns": pa.int64(),
        "frame": pa.uint64(),
        "cycle": pa.uint64(),
        "bus": WORDS,
        "node": pa.uint8(),
        "level": WORDS,
        "source": WORDS,
        "code": WORDS,
        "text": pa.string(),
    },
    "load": {
        "t_ns": pa.int64(),
        "frame": pa.uint64(),
        "cycle": pa.uint64(),
        "bus": WORDS,
        "frames": pa.uint32(),
        "bits": pa.uint64(),
        "frames_per_s": pa.float64(),
        "load_percent": pa.float64(),
    },
    "sync_cycles": {
        "cycle": pa.uint64(),
        "frame": pa.uint64(),
        "t_ns": pa.int64(),
        "bus": WORDS,
        "period_ns": pa.int64(),
        "window_ns": pa.int64(),
    },
}


def table(name: str, rows: Sequence[Mapping[str, Any]]) -> tuple[str, Any]:
    """A batch of a table; columns that a row leaves out are null, its cycle 0, its bus can0."""
    given = [{"cycle": 0, "bus": "can0", **row} for row in rows]
    types = TYPES[name]
    arrays = [pa.array([row.get(column) for row in given], of) for column, of in types.items()]
    return name, pa.RecordBatch.from_arrays(arrays, schema=pa.schema(list(types.items()), metadata={"table": name}))


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
