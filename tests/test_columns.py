"""The tables of columns: the same facts as the JSON lines of the same capture, whoever reads them and in what order."""

from __future__ import annotations

import gc
import json
from collections import defaultdict
from collections.abc import Iterable, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import polars
import pyarrow as pa
import pytest
from captures import SAMPLES, Row, described, described_beside, session_output, sort_rows

from canalyze import _core
from canalyze.running.reading import SessionOptions

FIXED = [table for table in _core.TABLES if table not in {"pdo", "wide"}]
PDO = ["t_ns", "frame", "provenance", "cycle", "delay_ns", "running_cycle"]
"""Columns of every table of a PDO, before those of its signals."""
CAPTURES = sorted(
    path for path in SAMPLES.rglob("*") if path.suffix in {".log", ".asc", ".mcap"} and "recorded" not in path.parts
)
DRIVE = described(((5, "drive.eds"),))
BATCH = 65_536
"""Most rows of a batch."""


def batches_of(
    chunks: Iterable[bytes],
    tables: Sequence[str] = tuple(_core.TABLES),
    *,
    name: str = "capture.log",
    network: _core.Network | None = None,
    form: str | None = None,
    **options: Any,
) -> list[tuple[str, _core.Batch]]:
    """All batches of one file that came in these chunks."""
    session = _core.Session(
        SessionOptions(format="columns", tables=tables, network=network, **({"lang": "en"} | options))
    )
    chunks = list(chunks)
    sniffed = _core.sniff(b"".join(chunks), True)
    session.begin(name, True, form or (sniffed if sniffed in _core.FORMATS else "candump"))
    found = []
    for chunk in chunks:
        assert session.feed(chunk) == b""
        found += session.batches()
    assert session.end() + session.finish() == b""
    return found + session.batches()


def tables_of(chunks: Iterable[bytes], tables: Sequence[str] = tuple(_core.TABLES), **options: Any) -> dict[str, Any]:
    """The same, put together by table."""
    parts: dict[str, list[_core.Batch]] = defaultdict(list)
    for name, batch in batches_of(chunks, tables, **options):
        assert name == batch.name == batch.metadata["table"]
        parts[name].append(batch)
    return {name: _core.Table(batches) for name, batches in parts.items()}


def rows_of(table: _core.Table) -> list[Row]:
    """The rows of a table, each by the names of its columns."""
    columns = {name: table.column(name) for name in table.column_names}
    assert {len(values) for values in columns.values()} == {len(table)}
    return [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]


def ns(t: str | None) -> int | None:
    """Seconds as JSON has them."""
    return None if t is None else int(Decimal(t) * 1_000_000_000)


def hexadecimal(text: str | None) -> int | None:
    return None if text is None else int(text, 16)


def exact(row: Row) -> Any:
    """The value of a transfer, as its columns have it."""
    given = (row[column] for column in ("string", "boolean", "integer", "raw", "value"))
    return next((value for value in given if value is not None), None)


def as_number(value: Any) -> Any:
    """JSON has whole numbers beyond 2^53 as strings."""
    return int(value) if isinstance(value, str) and value.lstrip("-").isdigit() else value


def same_frames(said: list[Row], table: _core.Table) -> None:
    for row, frame in zip(rows_of(table), said, strict=True):
        fd = frame["fd"] or {"brs": None, "esi": None}
        kind = "error" if frame["err"] else "remote" if frame["rtr"] else "fd" if frame["fd"] else "data"
        assert row == {
            **{key: frame[key] for key in ("frame", "line", "file", "bus", "dir", "len", "service", "node")},
            "t_ns": ns(frame["t"]),
            "id": int(frame["id"], 16),
            "extended": frame["ext"],
            "kind": kind,
            "brs": fd["brs"],
            "esi": fd["esi"],
            "data": bytes.fromhex(frame["data"]),
        }


def same_incidents(said: list[Row], table: _core.Table) -> None:
    of_order = ("depth", "subject", "cycle", "end_cycle", "delay_ns", "checks")
    for row, one in zip(sorted(rows_of(table), key=lambda row: row["id"]), said, strict=True):
        subject, cause, end = one["subject"], one["cause"] or {}, one["end"]
        frames = {one["begin"]["frame"], one["noticed"]["frame"], *(step["frame"] for step in one["steps"])}
        assert row == {
            **{key: one[key] for key in ("id", "problem", "status", "impact", "grade", "root", "message")},
            **{key: subject.get(key) for key in ("bus", "node", "axis", "pdo")},
            "nodes": subject.get("nodes", [subject["node"]] if "node" in subject else []),
            "begin_frame": one["begin"]["frame"],
            "t_ns": ns(one["begin"]["t"]),
            "noticed_frame": one["noticed"]["frame"],
            "noticed_t_ns": ns(one["noticed"]["t"]),
            "end_frame": end and end["frame"],
            "end_t_ns": end and ns(end["t"]),
            "count": one["repeats"]["count"],
            "cause": cause.get("id"),
            "cause_link": cause.get("link"),
            "cause_grade": cause.get("grade"),
            "frames": sorted(frames | ({end["frame"]} if end else set())),
            "facts": row["facts"],
            **{key: row[key] for key in of_order},
        }
        assert json.loads(row["facts"]) == one["facts"]


PROBLEMS = [*sorted((SAMPLES / "rules").glob("*.log")), *sorted((SAMPLES / "stacks").glob("*.log"))]


@pytest.mark.parametrize("path", PROBLEMS, ids=lambda path: path.name)
def test_incidents_say_what_json_says(path: Path) -> None:
    text, network = path.read_bytes(), described_beside(path)
    lines = session_output([text], output_format="diagnosis", lang="en", network=network, name=path.name).splitlines()
    said = [row for row in map(json.loads, lines) if row["kind"] == "problem"]
    same_incidents(said, tables_of([text], ["problems"], network=network, name=path.name)["problems"])


def same_transfers(said: list[Row], table: _core.Table) -> None:
    own = {"string", "boolean", "integer", "raw", "value", "first_line", "last_line"}
    for row, transfer in zip(rows_of(table), said, strict=True):
        text = isinstance(transfer["value"], str) and row["string"] is not None
        assert exact(row) == (transfer["value"] if text else as_number(transfer["value"]))
        abort = transfer["abort"] or {"code": None, "by": None, "text": None}
        shared = {key: value for key, value in transfer.items() if key in row and key not in own}
        named = f"{transfer['index']}:{transfer['sub']:02X}" if transfer["index"] else None
        assert {key: value for key, value in row.items() if key not in own} == {
            **shared,
            "index": hexadecimal(transfer["index"]),
            "object": named,
            "data": bytes.fromhex(transfer["data"]),
            "abort_code": hexadecimal(abort["code"]),
            "abort_by": abort["by"],
            "abort_text": abort["text"],
            "t_ns": ns(transfer["t"]),
            "duration_ns": ns(transfer["duration"]),
        }


def same_findings(said: list[Row], table: _core.Table) -> None:
    for row, finding in zip(rows_of(table), said, strict=True):
        expected = {key: value for key, value in finding.items() if key not in {"kind", "t"}}
        facts = json.loads(row["facts"])
        assert row | {"facts": facts} == expected | {"t_ns": ns(finding["t"]), "index": hexadecimal(finding["index"])}


def states(frame: Row) -> Row | None:
    """What a frame says of a state, as a row."""
    said = frame.get(frame["service"], {})
    row: Row = {"node": frame["node"], "command": None}
    if "malformed" in said or said.get("request"):
        return None
    if frame["service"] == "nmt":
        command = int(said["command"], 16)
        state = {1: 5, 2: 4, 128: 127}.get(command)
        return row | {"node": said["target"] or None, "state": state, "source": "command", "command": command}
    if frame["service"] not in {"heartbeat", "guarding"}:
        return None
    state = int(said["state"], 16)
    if said.get("boot_up"):
        return row | {"state": 0, "source": "boot-up"}
    if said["previous"] is not None and not said["changed"]:
        return None
    return row | {"state": state, "source": frame["service"]}


def same_states(frames: list[Row], table: _core.Table) -> None:
    words = {0: "Pre-operational (boot-up)", 4: "Stopped", 5: "Operational", 127: "Pre-operational", None: None}
    expected = [
        {"frame": frame["frame"], "t_ns": ns(frame["t"]), "bus": frame["bus"], "name": words.get(row["state"]), **row}
        for frame in frames
        if (row := states(frame))
    ]
    assert rows_of(table) == expected


def same_emcys(frames: list[Row], table: _core.Table) -> None:
    said = [frame for frame in frames if frame["service"] == "emcy" and "code" in frame["emcy"]]
    for row, frame in zip(rows_of(table), said, strict=True):
        emcy = frame["emcy"]
        assert row == {
            "t_ns": ns(frame["t"]),
            "frame": frame["frame"],
            "bus": frame["bus"],
            "node": frame["node"],
            "code": int(emcy["code"], 16),
            "name": emcy["name"],
            "register": int(emcy["register"], 16),
            "manufacturer": bytes.fromhex(emcy["manufacturer"]),
            "active": [int(code, 16) for code in emcy["active"]],
            "cleared": [int(code, 16) for code in emcy["cleared"]],
        }


def same_cycles(frames: list[Row], table: _core.Table) -> None:
    delays: dict[tuple[str, int], list[int | None]] = defaultdict(list)
    syncs = {frame["frame"]: frame for frame in frames if frame["service"] == "sync"}
    for frame in frames:
        placed = frame.get("pdo", {}).get("sync")
        if placed:
            delay = placed["delay_us"]
            delays[frame["bus"], placed["cycle"]].append(None if delay is None else round(delay * 1000))
    counts: dict[str, int] = defaultdict(int)
    rows = sorted(rows_of(table), key=lambda row: row["frame"])
    for row in rows:
        counts[row["bus"]] += 1
        assert row["cycle"] == counts[row["bus"]]
        frame = syncs[row["frame"]]
        assert (row["t_ns"], row["bus"]) == (ns(frame["t"]), frame["bus"])
        assert row["counter"] == frame["sync"].get("counter")
        of_cycle = delays.pop((row["bus"], row["cycle"]), [])
        known = [delay for delay in of_cycle if delay is not None]
        assert row["pdos"] == len(of_cycle)
        assert (row["delay_min_ns"], row["delay_max_ns"]) == ((min(known), max(known)) if known else (None, None))
    assert len(rows) <= len(syncs)
    assert not delays


def same_signals(said: list[Row], table: _core.Table) -> None:
    for row, signal in zip(rows_of(table), said, strict=True):
        shared = ("frame", "line", "bus", "node", "pdo", "signal", "unit", "text", "provenance")
        assert {key: row[key] for key in shared} == {key: signal[key] for key in shared}
        assert (row["t_ns"], row["object"]) == (ns(signal["t"]), f"{signal['index']}:{signal['sub']:02X}")
        if row["data"] is not None:
            assert row["data"].hex().upper() == signal["value"]
        elif row["integer"] is not None:
            assert row["integer"] == as_number(signal["value"])
            assert row["value"] == float(row["integer"])
        elif row["value"] is not None and row["value"] == row["value"]:
            assert row["value"] == pytest.approx(float(signal["value"]), rel=1e-7)
        else:
            assert signal["value"] is None
        if row["raw"] is not None:
            assert row["raw"] == as_number(signal["raw"])


def same_pdos(frames: list[Row], said: list[Row], tables: dict[str, _core.Table]) -> None:
    expected: dict[tuple[Any, ...], list[Row]] = defaultdict(list)
    synchronous = {row["frame"]: row["pdo"]["sync"] for row in frames if (row.get("pdo") or {}).get("sync")}
    for signal in said:
        expected[signal["frame"], signal["bus"], signal["node"], signal["pdo"]].append(signal)
    for name, table in tables.items():
        about, schema = table.metadata, pa.schema(table)
        assert name == "/".join(
            filter(None, ("pdo", about["bus"], f"{about['node']}.{about['pdo']}", about["version"]))
        )
        assert schema.names[:6] == PDO
        fields = [field for field in schema if field.metadata]
        for row in rows_of(table):
            sync = synchronous.pop(row["frame"], {"cycle": None, "delay_us": None})
            assert row["cycle"] == sync["cycle"]
            assert row["delay_ns"] == (None if sync["delay_us"] is None else pytest.approx(sync["delay_us"] * 1000))
            if about["version"] == "0":
                assert (len(schema), row["provenance"]) == (len(PDO), "unknown")
                continue
            signals = expected.pop((row["frame"], about["bus"] or None, int(about["node"]), about["pdo"]))
            signals = [signal for signal in signals if (signal["value"], signal["raw"]) != (None, None) or fields]
            assert row["t_ns"] == ns(signals[0]["t"])
            for field, signal in zip(fields, signals, strict=True):
                meta = {key.decode(): value.decode() for key, value in field.metadata.items()}
                assert meta["object"] == f"{signal['index']}:{signal['sub']:02X}"
                assert (meta.get("unit"), row["provenance"]) == (signal["unit"], signal["provenance"])
                value, shown = row[field.name], as_number(signal["value"])
                if isinstance(value, bytes):
                    assert value.hex().upper() == signal["value"]
                elif value is not None and shown is not None:
                    assert value * float(meta["factor"]) == pytest.approx(float(shown), rel=1e-7)
                else:
                    assert value is None or signal["raw"] is not None
    assert not synchronous
    # What is left are multiplex PDOs.
    assert all(len(signals) == 1 for signals in expected.values())


def same_values(said: list[Row], tables: dict[str, _core.Table]) -> None:
    """Each signal has the value that its line has, in its unit; what has words has them and the number."""
    expected: dict[tuple[Any, ...], list[Row]] = defaultdict(list)
    for signal in said:
        expected[signal["frame"], signal["bus"], signal["node"], signal["pdo"]].append(signal)
    for name, table in tables.items():
        about = table.metadata
        assert name.startswith("wide/")
        fields = [field for field in pa.schema(table) if field.metadata]
        worded = {field.name.removesuffix("__raw") for field in fields if field.name.endswith("__raw")}
        for row in rows_of(table):
            signals = expected[row["frame"], about["bus"] or None, int(about["node"]), about["pdo"]]
            numbers = [field for field in fields if field.name not in worded]
            for field, signal in zip(numbers, signals, strict=True):
                value, shown = row[field.name], as_number(signal["value"])
                if isinstance(value, bytes):
                    assert value.hex().upper() == signal["value"]
                elif value is not None and shown is not None:
                    assert value == pytest.approx(float(shown), rel=1e-7)
                    if str(field.type) == "double":
                        assert value == float(shown)
                words = row.get(field.name.removesuffix("__raw")) if field.name.endswith("__raw") else None
                if words is not None:
                    assert signal["text"].endswith(words)


def same_objects(said: Any, listed: list[Row], table: _core.Table) -> None:
    rows = rows_of(table)
    by_source: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        by_source[row["source"]].append(row)
    assert set(by_source) <= {"pdo", "sdo", "emcy", "nmt"}
    for row, signal in zip(by_source["pdo"], listed, strict=True):
        shared = ("frame", "bus", "node", "sub", "unit")
        assert {key: row[key] for key in shared} == {key: signal[key] for key in shared}
        assert (row["index"], row["name"]) == (int(signal["index"], 16), signal["signal"])
        if row["value"] is not None and signal["value"] is not None:
            assert row["value"] == pytest.approx(float(signal["value"]), rel=1e-7)
        if row["text"] is not None:
            assert row["text"] in signal["text"] or row["text"] == signal["value"]
    ok = [
        one for one in said.transfers if one["status"] == "ok" and one["index"] and len(one["data"]) == 2 * one["size"]
    ]
    for row, transfer in zip(by_source["sdo"], ok, strict=True):
        assert (row["frame"], row["node"]) == (transfer["last_frame"], transfer["node"])
        assert (row["index"], row["sub"]) == (int(transfer["index"], 16), transfer["sub"])
        if row["integer"] is not None:
            assert row["integer"] == int(as_number(transfer["value"]))
        elif isinstance(transfer["value"], str) and row["value"] is None:
            assert row["text"] in (None, transfer["value"])
    codes = [row for row in by_source["emcy"] if row["index"] is None]
    emcy = [frame for frame in said.frames if frame["service"] == "emcy" and "code" in frame["emcy"]]
    assert [row["integer"] for row in codes] == [int(frame["emcy"]["code"], 16) for frame in emcy]
    seen = [one for frame in said.frames if (one := states(frame)) and one["source"] != "command"]
    assert [(row["node"], row["integer"]) for row in by_source["nmt"]] == [(one["node"], one["state"]) for one in seen]


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: str(path.relative_to(SAMPLES)))
def test_the_same_as_json(path: Path) -> None:
    text, network = path.read_bytes(), described_beside(path)
    said = sort_rows(session_output([text], output_format="jsonl", lang="en", network=network))
    signals = session_output([text], output_format="signals", lang="en", network=network).decode().splitlines()
    listed = [json.loads(line) for line in signals]
    tables = tables_of([text], network=network)
    assert set(FIXED) <= set(tables)
    same_frames(said.frames, tables["frames"])
    same_transfers(said.transfers, tables["transfers"])
    same_findings(said.findings, tables["findings"])
    same_states(said.frames, tables["states"])
    same_emcys(said.frames, tables["emcy"])
    same_cycles(said.frames, tables["sync_cycles"])
    same_signals(listed, tables["signals"])
    same_pdos(said.frames, listed, {name: table for name, table in tables.items() if name.startswith("pdo/")})
    same_values(listed, {name: table for name, table in tables.items() if name.startswith("wide/")})
    same_objects(said, listed, tables["objects"])


@pytest.mark.parametrize(
    "path", [path for path in CAPTURES if path.parent.name == "network"], ids=lambda path: path.name
)
def test_others_read_the_same(path: Path) -> None:
    for table in tables_of([path.read_bytes()], network=described_beside(path), lang="zh").values():
        own = {name: table.column(name) for name in table.column_names}
        arrow = pa.table(table)
        arrow.validate(full=True)
        assert arrow.to_pydict() == own
        assert arrow.schema.metadata == {key.encode(): value.encode() for key, value in table.metadata.items()}
        assert polars.DataFrame(table).to_dict(as_series=False) == own
        for batch in table.batches():
            one = pa.record_batch(batch)
            one.validate(full=True)
            assert one.schema.equals(pa.schema(batch), check_metadata=True)
        assert pa.schema(table).equals(arrow.schema, check_metadata=True)


SHORT = {"findings": {"message"}, "states": {"name"}}
"""Tables in which what is called so elsewhere is no word for people."""


def test_languages_differ_in_words_only() -> None:
    text = (SAMPLES / "network/sync-and-pdos.log").read_bytes()
    words = {"name", "text", "message", "signal", "abort_text", "line", "state", "lane", "checks"}
    zh, en = (tables_of([text], FIXED, network=DRIVE, lang=lang) for lang in ("zh", "en"))
    for name, table in en.items():
        for column in set(table.column_names) - SHORT.get(name, words):
            assert table.column(column) == zh[name].column(column), (name, column)
    assert "状态字" in zh["signals"].column("signal")
    # Of a lane's name, only the signal's.
    places = [
        [lane.split("/")[: 4 if lane.startswith("value/") else None] for lane in lanes]
        for lanes in (zh["lanes"].column("lane"), en["lanes"].column("lane"))
    ]
    assert places[0] == places[1]


@pytest.mark.parametrize(
    "path", [SAMPLES / "network/sync-and-pdos.log", SAMPLES / "sdo-block.mcap"], ids=lambda p: p.name
)
def test_chunks_do_not_matter(path: Path) -> None:
    text, network = path.read_bytes(), described_beside(path)
    whole = {name: rows_of(table) for name, table in tables_of([text], network=network).items()}
    pieces = tables_of([text[start : start + 997] for start in range(0, len(text), 997)], network=network)
    assert {name: rows_of(table) for name, table in pieces.items()} == whole


def test_nothing_but_what_is_asked_for() -> None:
    text = (SAMPLES / "network/sync-and-pdos.log").read_bytes()
    for table in _core.TABLES:
        names = {name.split("/")[0] for name, _ in batches_of([text], [table], network=DRIVE)}
        assert names == {table}
    assert batches_of([text], []) == []
    selected = tables_of([text], ["signals", "pdo"], network=DRIVE, select="5.TPDO4.*")
    assert set(selected["signals"].column("pdo")) == {"TPDO4"}
    assert {name.split("/")[2] for name in selected if name != "signals"} == {"5.TPDO4"}
    shown = tables_of([text], FIXED, network=DRIVE, filter="service=sync")
    assert set(shown["frames"].column("service")) == {"sync"}
    assert not len(shown["signals"])
    assert max(shown["sync_cycles"].column("pdos")) > 0


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match='tables="frame": frames transfers'):
        _core.Session(SessionOptions(format="columns", tables=["frame"]))
    with pytest.raises(ValueError):
        _core.Table([])
    one, two = (batches_of([b""], [table])[0][1] for table in ("frames", "emcy"))
    with pytest.raises(ValueError):
        _core.Table([one, two])
    with pytest.raises(KeyError):
        one.column("nothing")
    with pytest.raises(KeyError):
        _core.Table([one]).column("nothing")


def test_an_empty_capture_has_columns() -> None:
    full = tables_of([(SAMPLES / "services.log").read_bytes()], FIXED)
    for text in ([], [b""], [b"nothing of a capture\n"]):
        tables = tables_of(text)
        assert list(tables) == FIXED
        for name, table in tables.items():
            assert len(table) == 0
            assert pa.table(table).schema.equals(pa.table(full[name]).schema, check_metadata=True)
            assert polars.DataFrame(table).height == 0


def log(count: int, bus: str = "can0", can_id: str = "701", data: str = "05") -> bytes:
    return b"".join(f"({1000 + number / 1000:.6f}) {bus} {can_id}#{data}\n".encode() for number in range(count))


def test_batches_end() -> None:
    batches = batches_of([log(2 * BATCH + 5)], ["frames", "states"])
    assert [(name, len(batch)) for name, batch in batches] == [
        *(("frames", BATCH), ("frames", BATCH), ("frames", 5), ("states", 1))
    ]
    table = _core.Table([batch for name, batch in batches if name == "frames"])
    assert len(table) == pa.table(table).num_rows == 2 * BATCH + 5
    assert table.column("frame") == list(range(1, 2 * BATCH + 6))
    assert len(pa.table(table).to_batches()) == 3


def test_a_live_source_ends_them_itself() -> None:
    session = _core.Session(SessionOptions(format="columns", tables=["frames", "signals"], network=DRIVE))
    session.begin("-", False)
    session.feed(log(3))
    session.rest()  # equal frames wait until it is known whether the capture shows them twice
    assert session.batches() == []
    assert [(name, len(batch)) for name, batch in session.batches(flush=True)] == [("frames", 3)]
    assert session.batches(flush=True) == []
    session.feed(log(2))
    session.end()
    session.finish()
    assert [(name, len(batch)) for name, batch in session.batches()] == [("frames", 2), ("signals", 0)]
    assert session.batches(flush=True) == []


def drive_batches() -> list[_core.Batch]:
    text = (SAMPLES / "network/sync-and-pdos.log").read_bytes()
    return [batch for name, batch in batches_of([text], ["signals"], network=DRIVE) if name == "signals"]


def test_columns_outlive_what_they_came_from() -> None:
    batch = drive_batches()[0]
    values = batch.column("value")
    table = _core.Table([batch])
    array = pa.record_batch(batch)
    whole = pa.table(table)
    frame = polars.DataFrame(table)
    del batch, table
    gc.collect()
    assert array.column("value").to_pylist() == whole.column("value").to_pylist() == values
    del array
    gc.collect()
    assert whole.column("value").to_pylist() == values
    del whole
    gc.collect()
    assert frame["value"].to_list() == values


def test_capsules_that_nobody_takes() -> None:
    batch = drive_batches()[0]
    table = _core.Table([batch])
    for _ in range(1000):
        batch.__arrow_c_array__()
        batch.__arrow_c_schema__()
        table.__arrow_c_stream__()
    kept = table.__arrow_c_stream__(), batch.__arrow_c_array__(None)
    values = batch.column("value")
    del batch, table
    gc.collect()
    del kept
    gc.collect()
    assert values


class Once:
    """Hands the same capsule out again and again."""

    def __init__(self, capsule: object) -> None:
        """Keep it."""
        self.capsule = capsule

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        return self.capsule


def test_a_capsule_is_taken_once() -> None:
    table = _core.Table(drive_batches())
    once = Once(table.__arrow_c_stream__())
    first = pa.table(once)
    with pytest.raises((ValueError, pa.ArrowInvalid)):
        pa.table(once)
    assert first.equals(pa.table(table))
    half = pa.RecordBatchReader.from_stream(table)
    half.read_next_batch()
    del half, once
    gc.collect()
    assert first.num_rows == len(table)


def test_nothing_is_kept() -> None:
    batch = drive_batches()[0]
    before = pa.total_allocated_bytes()
    resident = []
    for round_ in range(3):
        for _ in range(2000):
            pa.record_batch(batch)
            pa.table(_core.Table([batch]))
        gc.collect()
        resident.append(memory())
        assert pa.total_allocated_bytes() == before, round_
    assert resident[-1] - resident[0] < 4 << 20


def memory() -> int:
    """What this process takes now, in bytes."""
    pages = Path("/proc/self/statm")
    return int(pages.read_text().split()[1]) * 4096 if pages.exists() else 0
