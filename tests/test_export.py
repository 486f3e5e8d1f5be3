"""`canalyze export`: what is in the files is what JSON lines say, whoever reads them; and no file that is not complete.

The core's tables themselves are tested by `test_columns.py`.
"""

from __future__ import annotations

import csv
import io
import json
import random
import signal
import subprocess
import time
from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import duckdb
import pandas
import polars
import pyarrow as pa
import pyarrow.ipc
import pyarrow.parquet as pq
import pytest
from captures import EDS, SAMPLES, Row, decoded, described, run_canalyze
from conftest import command, environment
from processes import peak_kib
from test_columns_names import mapped

from canalyze import _core
from canalyze.commands.export import name_of
from canalyze.errors import OutputError
from canalyze.exporting import FOLDER, TABLES, Target, form_of
from canalyze.exporting.export import ROWS, SETTINGS, About, Export
from canalyze.exporting.shaping import SIGNALS, Message, identifier, joined
from canalyze.running.reading import SessionOptions

NETWORK = SAMPLES / "network" / "sync-and-pdos.log"
DRIVE = f"5={EDS / 'drive.eds'}"


def export(out: Path, *arguments: str | Path, capture: Path = NETWORK) -> Path:
    run_canalyze(["export", "--lang", "en", *arguments, capture, "-o", out])
    return out


@pytest.fixture(scope="module")
def lake(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The network of three nodes, one of them described."""
    return export(tmp_path_factory.mktemp("export") / "lake", "--eds", DRIVE, "--device", "truck 1/a")


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def rows(folder: Path, table: str) -> list[Row]:
    """The rows of a table, as DuckDB reads them."""
    found = duckdb.sql(f"SELECT * FROM read_parquet('{folder}/{table}/**/*.parquet', union_by_name = true)")
    assert found is not None
    return [dict(zip(found.columns, row, strict=True)) for row in found.fetchall()]


def stamp(t: str) -> int:
    return int(Decimal(t) * 1_000_000)


def micros(t: Any) -> int:
    exact: int = round(t.timestamp() * 1_000_000)
    return exact


def test_frames_are_those_of_json(lake: Path) -> None:
    said = decoded(NETWORK).frames
    found = rows(lake, "frames")
    assert len(found) == len(said) == 329
    for row, frame in zip(found, said, strict=True):
        assert {key: row[key] for key in ("frame", "line", "file", "bus", "dir", "len", "service", "node")} == {
            key: frame[key] for key in ("frame", "line", "file", "bus", "dir", "len", "service", "node")
        }
        assert (micros(row["t"]), row["id"]) == (stamp(frame["t"]), int(frame["id"], 16))
        assert bytes(row["data"]) == bytes.fromhex(frame["data"])
        assert (str(row["date"]), row["device"], row["capture"]) == ("2026-11-21", "truck 1/a", "sync-and-pdos")


def test_everybody_reads_the_same(lake: Path) -> None:
    for path in map(Path, files(lake)):
        (by_duckdb,) = duckdb.execute(f"SELECT count(*) FROM '{lake / path}'").fetchall()
        arrow = pq.ParquetFile(lake / path).read()
        by_polars, by_pandas = polars.read_parquet(lake / path), pandas.read_parquet(lake / path)
        assert by_duckdb[0] == arrow.num_rows == by_polars.height == len(by_pandas), path
        assert list(by_pandas.columns) == arrow.column_names == by_polars.columns
        assert by_polars.get_column("capture").to_list() == arrow.column("capture").to_pylist()
        for name in arrow.column_names:
            if name == "t" and path.parts[0] != "captures":
                assert str(by_pandas["t"].dtype) == "datetime64[us, UTC]"
                assert by_polars["t"].to_list() == arrow.column("t").to_pylist()
    frames = next((lake / "frames").rglob("*.parquet"))
    assert pandas.read_parquet(frames)["id"].tolist() == polars.read_parquet(frames)["id"].to_list()
    whole = polars.read_parquet(lake / "states/**/*.parquet", hive_partitioning=True)
    assert set(whole["device"]) == {"truck 1/a"}


def test_signals_are_those_of_the_command(lake: Path) -> None:
    lines = run_canalyze(["signals", "--lang", "en", "--eds", DRIVE, "--format", "jsonl", NETWORK]).splitlines()
    said = {(row["frame"], row["node"], row["pdo"], row["signal"]): row for row in map(json.loads, lines)}
    catalog = [row for row in rows(lake, "catalog") if row["index"] is not None]
    tables = {row["message"]: rows(lake, f"signals/message={row['message']}") for row in catalog}
    assert set(tables) == {"RPDO3_drive", "TPDO1", "TPDO2", *(f"TPDO{number}_drive" for number in (1, 2, 3, 4))}
    seen = set()
    for one in catalog:
        for row in tables[one["message"]]:
            if (row["node"], row["mapping"]) != (one["node"], one["mapping"]):
                continue
            key = row["frame"], row["node"], one["pdo"], one["name"]
            signal_, value = said[key], row[one["column_name"]]
            assert micros(row["t"]) == stamp(signal_["t"])
            assert f"{one['index']:04X}" == signal_["index"]
            assert row["provenance"] == signal_["provenance"]
            if isinstance(value, str):
                assert signal_["text"].endswith(value)
                assert value.islower()
                continue
            seen.add(key)
            assert value == signal_["value"]
            assert one["unit"] == (None if one["column_name"].endswith("__raw") else signal_["unit"])
    assert seen == set(said)
    torque = {row["torque_actual_value"] for row in tables["TPDO4_drive"]}
    assert -0.1 in torque
    assert 2.9 in torque


def test_units_are_in_the_schema_and_in_the_catalog(lake: Path) -> None:
    message = pq.read_schema(next((lake / "signals/message=TPDO4_drive").rglob("*.parquet")))
    assert message.field("velocity_actual_value").metadata[b"unit"] == b"rpm"
    assert message.field("torque_actual_value").metadata[b"unit"] == b"%"
    transfers = pq.read_schema(next((lake / "transfers").rglob("*.parquet")))
    assert transfers.field("duration_ns").metadata[b"unit"] == b"ns"
    listed = {(row["table_name"], row["message"], row["column_name"]): row for row in rows(lake, "catalog")}
    assert listed["transfers", None, "duration_ns"]["unit"] == "ns"
    velocity = listed["signals", "TPDO4_drive", "velocity_actual_value"]
    assert (velocity["unit"], velocity["node"], velocity["data_type"], velocity["type"], velocity["factor"]) == (
        *("rpm", 5, "INTEGER32", "int32", 1.0),
    )
    for path in map(Path, files(lake)):
        table = path.parts[0]
        named = path.parts[1].removeprefix("message=") if table == "signals" else None
        there = {column for name, message_, column in listed if (name, message_) == (table, named)}
        assert table == "catalog" or set(pq.read_schema(lake / path).names) == there


def test_other_tables_are_those_of_json(tmp_path: Path) -> None:
    for name in ("problems.log", "sdo-abort.log", "network/drive-states.log"):
        out = export(tmp_path / Path(name).stem, capture=SAMPLES / name)
        said = decoded(SAMPLES / name)
        transfers = rows(out, "transfers")
        assert [row["transfer"] for row in transfers] == [row["transfer"] for row in said.transfers]
        assert [row["status"] for row in transfers] == [row["status"] for row in said.transfers]
        found = [(row["code"], row["frame"], row["message"]) for row in rows(out, "findings")]
        assert found == [(row["code"], row["frame"], row["message"]) for row in said.findings]
        (capture,) = rows(out, "captures")
        assert capture["frames"] == len(said.frames)
        counts = [sum(row["severity"] == one for row in said.findings) for one in ("error", "warning", "info")]
        assert [capture["errors"], capture["warnings"], capture["infos"]] == counts
        assert micros(capture["t"]) == stamp(said.frames[0]["t"])
        lines = run_canalyze(["diagnose", "--lang", "en", "--format", "jsonl", SAMPLES / name]).splitlines()
        incidents = [row for row in map(json.loads, lines) if row["kind"] == "problem"]
        assert {row["id"] for row in rows(out, "problems")} == {row["id"] for row in incidents}


def test_spark_takes_it(lake: Path, tmp_path: Path) -> None:
    """Neither nanoseconds nor INT96 as timestamps; and no unsigned numbers, which not every reader has."""
    nanos = export(tmp_path / "nanos", capture=capture_of(tmp_path, ["1700000000.123456789"]))
    for folder in (lake, nanos):
        for path in folder.rglob("*.parquet"):
            file = pq.ParquetFile(path)
            for place in range(len(file.schema)):
                column = file.schema.column(place)
                logical = json.loads(column.logical_type.to_json())
                assert column.physical_type != "INT96"
                if logical["Type"] == "Timestamp":
                    assert (logical["timeUnit"], logical["isAdjustedToUTC"]) == ("microseconds", True)
                assert logical["Type"] != "Int" or logical["isSigned"] or column.name == "raw", column
            for group in range(file.metadata.num_row_groups):
                assert file.metadata.row_group(group).column(0).compression == "ZSTD"


def capture_of(folder: Path, stamps: Sequence[str], name: str = "made.log", frame: str = "701#05") -> Path:
    path = folder / name
    path.write_text("".join(f"({one}) can0 {frame}\n" for one in stamps))
    return path


def test_stamps_below_a_microsecond_are_kept(tmp_path: Path) -> None:
    out = export(tmp_path / "out", capture=capture_of(tmp_path, ["1700000000.123456789", "1700000001.000000000"]))
    assert [(micros(row["t"]), row["t_ns"]) for row in rows(out, "frames")] == [
        (1_700_000_000_123_456, 1_700_000_000_123_456_789),
        (1_700_000_001_000_000, 1_700_000_001_000_000_000),
    ]


def test_stamps_below_a_microsecond_may_come_late(tmp_path: Path) -> None:
    """The column is there for all rows then, of a folder and of a single file."""
    count = 2 * ROWS
    stamps = [f"{1_700_000_000 + turn // 1000}.{turn % 1000:03d}000" for turn in range(count)]
    capture = capture_of(tmp_path, [*stamps, "1700001000.000000001"])
    run_canalyze(["export", "--table", "frames", capture, "-o", tmp_path / "out"])
    run_canalyze(["export", capture, "-o", tmp_path / "out.parquet"])
    (path,) = (tmp_path / "out/frames").rglob("*.parquet")
    for one in (path, tmp_path / "out.parquet"):
        file = pq.ParquetFile(one)
        table = file.read()
        assert table.column("frame").to_pylist() == list(range(1, count + 2))
        assert table.column("t_ns").null_count == count
        assert table.column("t_ns").to_pylist()[-1] == 1_700_001_000_000_000_001
        assert file.metadata.num_row_groups > 2
        assert max(file.metadata.row_group(at).num_rows for at in range(file.metadata.num_row_groups)) < 2 * ROWS
    assert not list(tmp_path.rglob("*.part"))


def test_ordinary_stamps_need_no_second_column(lake: Path) -> None:
    assert "t_ns" not in pq.read_schema(next((lake / "frames").rglob("*.parquet"))).names


def test_stamps_without_a_date_are_no_dates(tmp_path: Path) -> None:
    out = export(tmp_path / "zero", capture=SAMPLES / "recorded/session.tz.candump")
    found = rows(out, "frames")
    said = decoded(SAMPLES / "recorded/session.tz.candump").frames
    assert [row["t_ns"] for row in found] == [int(Decimal(frame["t"]) * 10**9) for frame in said]
    assert {row["t"] for row in found} == {None}
    assert {row["date"] for row in found} == {None}
    (capture,) = rows(out, "captures")
    assert (capture["t"], capture["frames"]) == (None, len(said))
    assert capture["seconds"] > 0


def test_a_date_beside_the_stamps_counts(tmp_path: Path) -> None:
    """ASC has it in its head; as everywhere it is taken as UTC."""
    out = export(tmp_path / "asc", capture=SAMPLES / "services.asc")
    dated = export(tmp_path / "log", capture=SAMPLES / "services.log")
    times, exact = ([row["t"] for row in rows(folder, "frames")] for folder in (out, dated))
    assert times == exact
    assert files(out) == [path.replace("services.log", "services.asc") for path in files(dated)]
    assert "t_ns" not in rows(out, "frames")[0]
    (of_asc,), (of_log,) = rows(out, "captures"), rows(dated, "captures")
    assert (of_asc["t"], of_asc["end_t"]) == (of_log["t"], of_log["end_t"])


def test_a_capture_without_stamps(tmp_path: Path) -> None:
    out = export(tmp_path / "none", capture=SAMPLES / "recorded/session.plain.candump")
    found = rows(out, "frames")
    assert found
    assert {row["t"] for row in found} == {None}
    assert "t_ns" not in found[0]
    (capture,) = rows(out, "captures")
    assert (capture["t"], capture["seconds"]) == (None, None)


def test_a_clock_that_is_set(tmp_path: Path) -> None:
    out = export(tmp_path / "set", capture=capture_of(tmp_path, ["12.000000", "1700000000.500000"]))
    assert [(row["t"] is None, row["t_ns"]) for row in rows(out, "frames")] == [
        (True, 12 * 10**9),
        (False, 1_700_000_000_500_000_000),
    ]


def test_two_buses_are_told_apart(tmp_path: Path) -> None:
    out = export(tmp_path / "two", "--eds", DRIVE, capture=SAMPLES / "two-nodes-interleaved.log")
    path = tmp_path / "buses.log"
    path.write_text("(1700000000.0) can0 185#3702\n(1700000000.1) can1 185#4002\n")
    out = export(tmp_path / "out", "--eds", DRIVE, capture=path)
    assert [(row["bus"], row["statusword__raw"]) for row in rows(out, "signals/message=TPDO1_drive")] == [
        ("can0", 0x237),
        ("can1", 0x240),
    ]
    (capture,) = rows(out, "captures")
    assert capture["buses"] == ["can0", "can1"]


def test_a_bus_has_a_description_of_its_own(tmp_path: Path) -> None:
    path = tmp_path / "buses.log"
    path.write_text("(1700000000.0) can0 185#3702\n(1700000000.1) can1 185#4002\n")
    out = export(tmp_path / "out", "--eds", f"can1:5={EDS / 'drive.eds'}", capture=path)
    assert {row["message"] for row in rows(out, "signals")} == {"TPDO1_drive"}
    assert {row["bus"] for row in rows(out, "signals")} == {"can1"}


def test_a_mapping_that_changes(tmp_path: Path) -> None:
    path = tmp_path / "mapped.log"
    pdo = b"(1.0) can0 185#37020000\n"
    path.write_bytes(mapped(0x6041_0010) + pdo + mapped(0x6064_0020) + pdo + mapped(0x6041_0010) + pdo)
    out = export(tmp_path / "out", capture=path)
    found = rows(out, "signals/message=TPDO1")
    assert [row["mapping"] for row in sorted(found, key=lambda row: row["frame"])] == [1, 2, 1]
    assert [(row["statusword__raw"], row["position_actual_value"]) for row in found if row["mapping"] == 2] == [
        (None, 0x237)
    ]
    listed = [(row["column_name"], row["mapping"]) for row in rows(out, "catalog") if row["index"] is not None]
    assert set(listed) == {("statusword", 1), ("statusword__raw", 1), ("position_actual_value", 2)}


def field(name: str, kind: pa.DataType, unit: str = "") -> pa.Field:
    return pa.field(name, kind, metadata={"object": "2000:00", **({"unit": unit} if unit else {})})


def columns(message: Message, table: str, schema: pa.Schema) -> list[str]:
    names = message.names(table, schema)
    assert names is not None
    return list(names.values())


def test_names_of_signals() -> None:
    message = Message()
    first = pa.schema(
        [
            *(
                field("Speed", pa.int16(), "rpm"),
                field("speed", pa.int16(), "rpm"),
                field("Motor speed [1]", pa.int8()),
            ),
            *(field("frame", pa.int8()), field("状态", pa.int8()), field("2000h:01", pa.int8())),
            *(field("mode", pa.string()), field("mode__raw", pa.int8())),
        ]
    )
    assert columns(message, "wide/1", first) == [
        *("Speed", "speed_2", "Motor_speed_1", "frame_2", "_2000_00", "_2000h_01", "mode", "mode__raw")
    ]
    second = pa.schema(
        [field("SPEED", pa.float64(), "rpm"), field("Speed", pa.int16(), "1/s"), field("mode", pa.bool_())]
    )
    names = columns(message, "wide/2", second)
    assert names[0] == "Speed", "the same signal, of another width"
    assert names[1] not in ("Speed", "speed_2"), "in another unit"
    assert names[2] == "mode_2"
    lowered = [name.lower() for name in {*names, *columns(message, "wide/1", first)}]
    assert len(lowered) == len(set(lowered))


def test_mappings_beyond_the_columns_of_a_message_are_named(tmp_path: Path) -> None:
    """Each of 2,100 mappings has another object; those that have a column are complete, the others are counted."""
    count = SIGNALS + 100
    path = tmp_path / "mapped.log"
    pdo = b"(1.0) can0 185#37020000\n"
    path.write_bytes(b"".join(mapped((0x2000 + number) << 16 | 0x20) + pdo for number in range(count)))
    line = command("--lang", "en", "export", str(path), "-o", str(tmp_path / "out"))
    told = subprocess.run(line, capture_output=True, text=True, check=True, env=environment())
    said = f"TPDO1: at most {SIGNALS} columns of signals; 100 PDOs of further mappings left out"
    assert told.stderr == f"canalyze: {said}, their values are in table objects\n"
    (file,) = (tmp_path / "out" / "signals").rglob("*.parquet")
    table = pq.read_table(file)
    signals = [name for name in table.schema.names if name.startswith("_")]
    assert (len(table), len(signals)) == (SIGNALS, SIGNALS)
    assert all(table[name].null_count == SIGNALS - 1 for name in signals)
    assert len({row["index"] for row in rows(tmp_path / "out", "objects") if row["source"] == "pdo"}) == count


def test_a_mapping_that_needs_no_further_column_fits() -> None:
    message = Message()
    full = pa.schema([field(f"s{number}", pa.int8()) for number in range(SIGNALS)])
    assert len(columns(message, "wide/1", full)) == SIGNALS
    assert message.names("wide/2", pa.schema([field("s0", pa.int8()), field("other", pa.int8())])) is None
    assert columns(message, "wide/3", pa.schema([field("s1", pa.int8()), field("s0", pa.int8())])) == ["s1", "s0"]
    assert message.names("wide/4", pa.schema([field("other", pa.int8())])) is None


@pytest.mark.parametrize(
    ("name", "made"), [("a-b c", "a_b_c"), ("1x", "_1x"), ("状态", ""), ("a__b", "a_b"), ("_x_", "x")]
)
def test_identifiers(name: str, made: str) -> None:
    assert identifier(name) == made


@pytest.mark.parametrize("group", [1, ROWS], ids=["written in pieces", "in one"])
def test_a_column_gets_wider(group: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An object that is mapped with 8 bits and then with 32 is one column all the same; 64 bits are another."""
    monkeypatch.setattr("canalyze.exporting.export.ROWS", group)
    path = tmp_path / "mapped.log"
    pdo = b"(1.0) can0 185#FFFFFFFF00000080\n"
    path.write_bytes(b"".join(mapped(0x2000_0000 + bits) + pdo for bits in (8, 32, 64)))
    out = export(tmp_path / "out", capture=path)
    (made,) = (out / "signals/message=TPDO1").rglob("*.parquet")
    table = pq.read_table(made)
    assert [str(table.schema.field(name).type) for name in ("_2000h_00", "_2000h_00_2")] == ["int64", "uint64"]
    assert sorted(table.select(["_2000h_00", "_2000h_00_2"]).to_pydict().values(), key=str) == [
        [0xFF, 0xFFFF_FFFF, None],
        [None, None, 0x8000_0000_FFFF_FFFF],
    ]
    types = {(row["column_name"], row["mapping"], row["type"]) for row in rows(out, "catalog") if row["index"]}
    assert types == {("_2000h_00", 1, "int64"), ("_2000h_00", 2, "int64"), ("_2000h_00_2", 3, "uint64")}


def test_languages_do_not_change_what_queries_compare(lake: Path, tmp_path: Path) -> None:
    out = tmp_path / "zh"
    run_canalyze(["export", "--lang", "zh", "--eds", DRIVE, "--device", "truck 1/a", NETWORK, "-o", out])
    assert files(out) == files(lake)
    for path in files(out):
        zh, en = pq.read_table(out / path), pq.read_table(lake / path)
        assert zh.schema.equals(en.schema, check_metadata=False)
        people = {"name", "text", "message", "abort_text", "checks"}
        people -= {"name", "text"} if path.startswith(("objects", "catalog")) else set()
        for column in set(zh.column_names) - people:
            assert zh.column(column).to_pylist() == en.column(column).to_pylist(), (path, column)


@pytest.mark.parametrize("table", sorted(set(TABLES) - {"signals"}))
def test_one_file_of_each_kind(table: str, lake: Path, tmp_path: Path) -> None:
    whole = pq.read_table(next((lake / table).rglob("*.parquet")))
    for suffix in ("parquet", "arrow", "csv"):
        export(tmp_path / f"x.{suffix}", "--eds", DRIVE, "--table", table)
    assert pq.read_table(tmp_path / "x.parquet").equals(whole)
    arrow = pyarrow.ipc.open_file(tmp_path / "x.arrow").read_all()
    for name in whole.column_names:
        assert arrow.column(name).to_pylist() == whole.column(name).to_pylist()
    lines = list(csv.DictReader(io.StringIO((tmp_path / "x.csv").read_text())))
    assert list(lines[0] if lines else arrow.column_names) == arrow.column_names
    for line, row in zip(lines, arrow.to_pylist(), strict=True):
        for name, value in row.items():
            shown = line[name]
            if value is None:
                assert shown == ""
            elif isinstance(value, bytes):
                assert shown == value.hex().upper()
            elif isinstance(value, list):
                assert shown == " ".join(map(str, value))
            elif isinstance(value, bool):
                assert shown == str(value).lower()
            elif isinstance(value, int | float):
                assert float(shown) == float(value)
            elif isinstance(value, str):
                assert shown == value


def test_few_files_are_open_at_once(lake: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was written in pieces is put together: one file each, with the same rows."""
    monkeypatch.setattr("canalyze.exporting.export._OPEN", 1)
    monkeypatch.setattr("canalyze.exporting.export.ROWS", 1)
    out = export(tmp_path / "lake", "--eds", DRIVE, "--device", "truck 1/a")
    assert files(out) == files(lake)
    for path in files(out):
        assert pq.read_table(out / path).equals(pq.read_table(lake / path)), path


def test_names() -> None:
    assert name_of("a/b c.log.zst") == "b_c"
    assert name_of("-") == "stdin"
    assert name_of("..log") == "capture"
    assert name_of("记录.asc") == "记录"
    assert [form_of(name) for name in ("x.PARQUET", "x.arrow", "lake", "x.d/", "x.json")] == [
        *("parquet", "arrow", FOLDER, FOLDER, None)
    ]


def running(folder: Path, out: str, *source: str) -> subprocess.Popen[bytes]:
    line = command("--lang", "en", "export", *source, "-o", out)
    pipe = subprocess.PIPE
    return subprocess.Popen(line, stdin=pipe, stdout=pipe, stderr=pipe, cwd=folder, env=environment())


def heartbeats(count: int) -> Iterator[bytes]:
    for turn in range(count):
        yield f"({1_700_000_000 + turn // 1000}.{turn % 1000:03d}000) can0 701#05\n".encode()


@pytest.mark.parametrize("out", ["lake", "x.parquet"])
def test_a_killed_run_leaves_nothing_visible(out: str, tmp_path: Path) -> None:
    with running(tmp_path, out, "-") as process:
        assert process.stdin
        process.stdin.write(b"".join(heartbeats(2 * ROWS)))
        process.stdin.flush()
        for _ in range(600):
            if any(path.stat().st_size for path in tmp_path.rglob("*.part")):
                break
            time.sleep(0.1)
        assert list(tmp_path.rglob("*.part")), "it has begun to write"
        process.kill()
    assert not list(tmp_path.rglob("*.parquet"))


@pytest.mark.parametrize("out", ["lake", "x.parquet"])
def test_an_interrupted_run_leaves_nothing(out: str, tmp_path: Path) -> None:
    (tmp_path / "long.log").write_bytes(b"".join(heartbeats(4 * ROWS)))
    with running(tmp_path, out, "long.log") as process:
        for _ in range(600):
            if list(tmp_path.rglob("*.part")):
                break
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (130, f"canalyze: {out}: interrupted; nothing written\n".encode())
    assert [path.name for path in tmp_path.iterdir()] == ["long.log"]


def test_an_interrupted_pipe_is_complete(tmp_path: Path) -> None:
    with running(tmp_path, "x.parquet", "-") as process:
        assert process.stdin
        process.stdin.write(b"".join(heartbeats(ROWS + 10)))
        process.stdin.flush()
        for _ in range(600):
            if any(path.stat().st_size for path in tmp_path.rglob("*.part")):
                break
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    count = pq.read_metadata(tmp_path / "x.parquet").num_rows
    assert 0 < count <= ROWS + 10
    assert err.decode() == f"canalyze: x.parquet: interrupted; holds the {count} frames read so far\n"


def test_a_program_of_its_own_may_export(tmp_path: Path) -> None:
    """As a fleet does: batches of any session, and nothing is left where it fails half-way."""
    target = Target(tmp_path / "lake", FOLDER, ("frames", "signals"))
    options = SessionOptions("en", SETTINGS["format"], tables=target.core, network=described(((5, "drive.eds"),)))
    data = NETWORK.read_bytes()

    def read(made: Export) -> None:
        session = _core.Session(options)
        session.begin("n.log", True)
        results = [session.feed(data), session.end(), session.finish()]
        made.take(session, b"".join(results))

    about = About("night-17", "truck", ("n.log",), {(None, 5): "drive.eds"})
    with Export(target, about) as made:
        read(made)
        written = made.complete()
    assert written.rows["frames"] == 329
    assert {str(path.relative_to(tmp_path / "lake")) for path in written.files} == set(files(tmp_path / "lake"))
    assert written.size == sum(path.stat().st_size for path in written.files)
    assert written.files[-1].parts[-4] == "captures"
    with pytest.raises(OutputError, match=r"night-17\.parquet: file exists"):
        Export(target, about)
    with Export(target._replace(path=tmp_path / "half"), about) as made:
        read(made)
    assert [path.name for path in tmp_path.iterdir()] == ["lake"]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="Linux tells the peak of a process")
def test_memory_does_not_grow_with_the_capture(tmp_path: Path) -> None:
    peaks = []
    for count in (3 * ROWS, 9 * ROWS):
        path = tmp_path / f"{count}.log"
        with path.open("wb") as out:
            out.writelines(heartbeats(count))
        peaks.append(peak_kib(tmp_path, "export", str(path), "-o", f"{count}.parquet"))
    assert peaks[1] - peaks[0] < 24 * 1024, peaks  # in KiB; the frames that are more take 70 MB in memory


@pytest.mark.parametrize("seed", range(20))
def test_rows_of_other_columns_are_put_together(seed: int) -> None:
    """As pyarrow does it, a batch at a time."""
    chance = random.Random(seed)
    kinds = {"a": pa.int16(), "b": pa.string(), "c": pa.float64(), "d": pa.bool_(), "e": pa.int64()}
    batches = []
    for _ in range(chance.randrange(1, 12)):
        names = [name for name in kinds if chance.random() < 0.6] or ["a"]
        count = chance.randrange(4)
        columns = {
            name: pa.array([chance.choice([None, 0, 1]) for _ in range(count)], pa.int64()).cast(kinds[name])
            for name in names
        }
        batches.append(pa.record_batch(columns))
    schema = pa.schema(kinds)
    each = [pa.table(batch) if len(batch.schema) else pa.table({}) for batch in batches]
    whole = pa.concat_tables([*each, schema.empty_table()], promote_options="default").select(schema.names)
    assert joined(batches, schema).equals(whole)
