"""Names and types in the tables of columns: those of strangers' captures and descriptions, and mappings that change."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import polars
import pyarrow as pa
import pytest
from test_columns import DRIVE, log, rows_of, tables_of

from canalyze import _core

HOSTILE = [
    b"a/b",
    b"a%2Fb",
    b"\x1b[31m",
    "\u202eevil".encode(),
    b"x" * 40,
    b"50%",
    "总线".encode(),
    b"c\xffn\xc3",
    b" ",
]


def packed(buses: Sequence[bytes], can_id: int, data: bytes) -> bytes:
    """A frame on each of these buses, whose names may be anything."""
    stream = b""
    for number, bus in enumerate(buses):
        stream += struct.pack("<BBHIqq", 2, number, len(bus), 0, 0, 0) + bus
        stream += struct.pack("<BBBBBBBBIIq", 1, 1, number, len(data), 0, 6, len(data), 0, can_id, 0, 10**9) + data
    return stream


@pytest.mark.parametrize("bus", HOSTILE, ids=ascii)
def test_hostile_names_of_buses(bus: bytes) -> None:
    tables = tables_of([packed([bus], 0x185, b"\x37\x02\x00")], network=DRIVE, form="packed")
    shown = bus[:32].decode(errors="replace")
    assert tables["frames"].column("bus") == [shown]
    assert set(tables["signals"].column("bus")) == {shown}
    (name,) = [name for name in tables if name.startswith("pdo/")]
    assert name.count("/") == 3
    assert name.isprintable()
    assert " " not in name
    assert tables[name].metadata["bus"] == shown
    pa.table(tables[name]).validate(full=True)


def test_buses_whose_names_look_alike() -> None:
    names = [*HOSTILE, b"", b"5.TPDO1", b"c\xfen\xc3"]
    tables = tables_of([packed(names, 0x185, b"\x37\x02")], ["pdo"], network=DRIVE, form="packed")
    assert len(tables) == len(names)
    assert "pdo/5.TPDO1/1" in tables
    assert "pdo/5.TPDO1/5.TPDO1/1" in tables


def test_hostile_names_of_files() -> None:
    tables = tables_of([log(1)], name="\u202e\0.log")
    assert tables["frames"].column("file") == ["\u202e\0.log"]
    assert pa.table(tables["frames"]).column("file").to_pylist() == ["\u202e\0.log"]


def described_as(*rows: tuple[int, str, int, str]) -> _core.Network:
    """TPDO1 of node 5 with these objects: index, name, type, unit."""
    sizes = {1: 1, 5: 8, 6: 16, 7: 32, 8: 32, 0x1B: 64, 9: 8}
    table: list[Any] = [(0x1800, 1, "COB-ID", 7, "rw", 0x180, True, False, False, "", 1.0)]
    table.append((0x1A00, 0, "entries", 5, "rw", len(rows), False, False, False, "", 1.0))
    for number, (index, name, kind, unit) in enumerate(rows, 1):
        entry = index << 16 | sizes[kind]
        table.append((0x1A00, number, "entry", 7, "rw", entry, False, False, False, "", 1.0))
        table.append((index, 0, name, kind, "ro", None, False, False, True, unit, 1.0))
    described_by = _core.Dictionary(file="hostile.eds", form="eds", device="", rows=table)
    return _core.Network(descriptions=[(None, 5, described_by)])


def test_hostile_names_of_signals() -> None:
    names = ["frame", "t_ns", "same", "same", "", "\x1b[2J", "\u202e", "same (2003:00)"]
    network = described_as(*((0x2000 + number, name, 5, "\x00\u202e") for number, name in enumerate(names)))
    tables = tables_of([log(2, "can0", "185", "0102030405060708")], network=network)
    (wide,) = [table for name, table in tables.items() if name.startswith("pdo/")]
    assert len(set(wide.column_names)) == 6 + 8
    assert wide.column_names[6:10] == ["frame (2000:00)", "t_ns (2001:00)", "same", "same (2003:00)"]
    assert [wide.column(name)[0] for name in wide.column_names[6:]] == list(range(1, 9))
    assert set(tables["signals"].column("unit")) == {"\x00\u202e"}
    arrow = pa.table(wide)
    arrow.validate(full=True)
    assert all(name.isprintable() for name in arrow.column_names)
    assert polars.DataFrame(wide).height == 2


def test_types_are_those_of_the_bus() -> None:
    network = described_as((0x2000, "flag", 1, ""), (0x2001, "whole", 6, "V"), (0x2002, "real", 8, ""))
    # A mapping that was written: one that is only assumed is not that of a frame that it does not fit.
    frames = log(1, "can0", "185", "0102") + log(1, "can0", "185", "01000000803F0000")
    tables = tables_of([mapped(0x2000_0001, 0x2001_0010, 0x2002_0020) + frames], network=network)
    wide = pa.table(tables["pdo/can0/5.TPDO1/1"])
    assert [str(field.type) for field in wide.schema][6:] == ["bool", "uint16", "float"]
    assert wide.schema.field("whole").metadata[b"unit"] == b"V"
    assert wide.column("flag").to_pylist() == [True, True]
    assert wide.column("whole").to_pylist()[0] is None
    assert wide.column("real").to_pylist()[0] is None


def mapped(*entries: int) -> bytes:
    """Node 5's TPDO1 is mapped anew, to these objects."""
    lines = []
    written = [(sub, entry) for sub, entry in enumerate(entries, 1)]
    for sub, value in [(0, 0), *written, (0, len(entries))]:
        index = 0x1A00
        size = 4 if sub else 1
        command = 0x43 - 0x20 if size == 4 else 0x2F
        data = bytes([command]) + index.to_bytes(2, "little") + bytes([sub]) + value.to_bytes(4, "little")
        lines.append(f"(1.0) can0 605#{data.hex().upper()}\n(1.0) can0 585#60{data[1:4].hex().upper()}00000000\n")
    return "".join(lines).encode()


def test_mappings_have_versions() -> None:
    first, second = mapped(0x6041_0010), mapped(0x6064_0020)
    pdo = b"(1.0) can0 185#37020000\n"
    text = first + pdo + second + pdo + first + pdo + pdo
    tables = tables_of([text], ["pdo"])
    assert {name: len(table) for name, table in tables.items()} == {"pdo/can0/5.TPDO1/1": 3, "pdo/can0/5.TPDO1/2": 1}
    assert tables["pdo/can0/5.TPDO1/1"].column_names[6:] == ["statusword"]
    assert set(tables["pdo/can0/5.TPDO1/1"].column("provenance")) == {"observed"}


def test_what_a_signal_is_beyond_a_double() -> None:
    network = described_as((0x2000, "great", 0x1B, ""))
    signals = tables_of([log(1, "can0", "185", "FFFFFFFFFFFFFFFF")], ["signals"], network=network)["signals"]
    (row,) = rows_of(signals)
    assert (row["raw"], row["integer"], row["value"]) == (2**64 - 1, None, float(2**64))
