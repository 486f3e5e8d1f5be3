"""Tables of columns beside other formats, and those of a timeline against the same capture's lines and figures.

What each lane shows is another file's matter.
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES, Row, described, described_beside, placed, session_output, sort_rows
from mcap.reader import make_reader

from canalyze import _core
from canalyze.running.reading import SessionOptions

CAPTURES = sorted(
    path for path in SAMPLES.rglob("*") if path.suffix in {".log", ".asc", ".mcap"} and "recorded" not in path.parts
)
DRIVE = described(((5, "drive.eds"),))
FORMATS = (
    *("text", "jsonl", "transfers", "signals", "signals-csv", "summary", "observed", "records", "lines", "check"),
    *("convert", "digest", "monitor"),
)
WINDOW = 100_000_000
"""What a row of `load` stands for, in ns."""


def both(text: bytes, form: str, tables: list[str], **options: Any) -> tuple[bytes, dict[str, list[Row]]]:
    """What a session gives as bytes, and the rows of its tables."""
    session = _core.Session(SessionOptions(format=form, tables=tables, **({"lang": "en"} | options)))
    sniffed = _core.sniff(text, True)
    session.begin("capture.log", True, sniffed if sniffed in _core.FORMATS else "candump")
    output = session.feed(text) + session.end() + session.finish()
    rows: dict[str, list[Row]] = defaultdict(list)
    for name, batch in session.batches():
        columns = {column: batch.column(column) for column in batch.column_names}
        rows[name] += [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
    return output, rows


def table(text: bytes, name: str, **options: Any) -> list[Row]:
    """The rows of one table."""
    return both(text, "columns", [name], **options)[1][name]


@pytest.mark.parametrize("form", FORMATS)
def test_neither_changes_the_other(form: str) -> None:
    for name in ("network/sync-and-pdos.log", "services.log", "rules/HBT001.log"):
        text = (SAMPLES / name).read_bytes()
        alone, none = both(text, form, [], network=DRIVE)
        output, rows = both(text, form, _core.TABLES, network=DRIVE)
        assert not none
        assert output == alone
        assert rows == both(text, "columns", _core.TABLES, network=DRIVE)[1]


def test_a_writer_tells_states_of_drives_alike_alone_and_beside_tables() -> None:
    """Alone it gets statuswords that show another state, beside tables all of them."""
    text = (SAMPLES / "network/sync-and-pdos.log").read_bytes()
    alone, _ = both(text, "convert", [], network=DRIVE, to="mcap", decoded=True)
    output, rows = both(text, "convert", _core.TABLES, network=DRIVE, to="mcap", decoded=True)
    assert rows["signals"]
    told = Counter(channel.topic.rsplit("/", 1)[-1] for _, channel, _ in make_reader(BytesIO(alone)).iter_messages())
    assert 0 < told["drive_state"] < told["tpdo3"]
    assert output == alone


def test_info_has_none() -> None:
    output, rows = both((SAMPLES / "services.log").read_bytes(), "info", _core.TABLES)
    assert output
    assert not rows


REPEATED = b"(0.900000) can0 605#4000100000000000\n(0.900500) can0 585#4300100092010000\n" + b"".join(
    f"({1 + n / 10:.6f}) can0 605#40001000000000\n({1 + n / 10:.6f}) can0 585#4300100092010000\n".encode()
    for n in range(32)
)
"""Requests that are a byte short: one finding each."""


def test_repeats_are_folded_in_tables_though_figures_count_them() -> None:
    alone, _ = both(REPEATED, "summary", [])
    output, rows = both(REPEATED, "summary", ["findings", "log", "listing"])
    assert output == alone
    raised = [json.loads(line) for line in output.splitlines() if b'"summary_finding"' in line]
    assert raised[0]["count"] > 20
    told = sort_rows(session_output([REPEATED], output_format="jsonl", lang="en")).findings
    # Ten, and one that counts the others.
    assert [row["code"] for row in told] == [raised[0]["code"]] * 11
    assert [row["message"] for row in rows["findings"]] == [row["message"] for row in told]
    assert [row["text"] for row in rows["log"]] == [row["message"] for row in told]
    assert sum(row["severity"] is not None for row in rows["listing"]) == 10


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: str(path.relative_to(SAMPLES)))
@pytest.mark.parametrize("lang", ["zh", "en"])
def test_the_listing_is_the_lines_of_decode(path: Path, lang: str) -> None:
    text, network = path.read_bytes(), described_beside(path)
    rows = table(text, "listing", network=network, lang=lang)
    said = sort_rows(session_output([text], output_format="jsonl", lang=lang, network=network))
    found = {(finding["frame"], finding["severity"]) for finding in said.findings}
    lines, _ = both(text, "lines", [], network=network, lang=lang, time="n")
    for row, frame, line in zip(rows, said.frames, lines.decode().splitlines(), strict=True):
        shown = json.loads(line)["text"].splitlines()[0]
        assert shown.endswith(row["line"].lstrip())
        assert shown.removesuffix(row["line"].lstrip()).strip() == (frame["bus"] or "")
        assert row["line"].isprintable()
        shared = ("frame", "bus", "node", "service")
        assert {key: row[key] for key in shared} == {key: frame[key] for key in shared}
        assert row["severity"] is None or (row["frame"], row["severity"]) in found
        if not any((row["frame"], level) in found for level in ("error", "warning")):
            assert row["severity"] in {None, "info"}


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: str(path.relative_to(SAMPLES)))
def test_the_log_is_findings_and_emergencies(path: Path) -> None:
    text, network = path.read_bytes(), described_beside(path)
    _, rows = both(text, "columns", ["log", "findings", "emcy", "frames"], network=network)
    found = [row for row in rows["log"] if row["source"] == "finding"]
    last = 0
    for row, finding in zip(found, rows["findings"], strict=True):
        shared = ("code", "bus", "node")
        assert {key: row[key] for key in shared} == {key: finding[key] for key in shared}
        assert (row["level"], row["text"]) == (finding["severity"], placed(finding))
        last = max(last, row["frame"])
        if finding["frame"] is not None:
            assert (row["frame"], row["t_ns"]) == (finding["frame"], finding["t_ns"])
    assert last <= len(rows["frames"])
    errors = [row for row in rows["log"] if row["source"] == "emcy"]
    for row, emcy in zip(errors, rows["emcy"], strict=True):
        place = ("frame", "t_ns", "bus", "node")
        assert {key: row[key] for key in place} == {key: emcy[key] for key in place}
        assert row["code"] == f"{emcy['code']:04X}"
        assert row["level"] == ("info" if emcy["code"] < 0x100 else "error")
        assert row["code"] in row["text"] and (emcy["name"] or "") in row["text"]


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: str(path.relative_to(SAMPLES)))
def test_the_load_is_that_of_the_summary(path: Path) -> None:
    output, rows = both(path.read_bytes(), "summary", ["load", "frames"])
    figures = [json.loads(line) for line in output.splitlines()]
    buses = {row["bus"]: row for row in figures if row["kind"] == "summary_bus"}
    stamps: dict[str | None, list[int]] = defaultdict(list)
    for row in rows["frames"]:
        if row["t_ns"] is not None:
            stamps[row["bus"]].append(row["t_ns"])
    for bus, times in stamps.items():
        own = [row for row in rows["load"] if row["bus"] == bus]
        if times != sorted(times):
            continue
        for row in own:
            within = [time for time in times if row["t_ns"] - WINDOW <= time < row["t_ns"]]
            assert row["frames"] == len(within)
            assert row["frames_per_s"] == 10 * len(within)
            assert row["load_percent"] is None
            assert (row["t_ns"] - times[0]) % WINDOW == 0
        ends = [row["t_ns"] for row in own]
        assert ends == sorted(set(ends))
        end = ends[-1] if ends else times[0]
        counted = [time for time in times if time < end]
        assert sum(row["frames"] for row in own) == len(counted)
        assert sum(row["bits"] for row in own) <= buses[bus]["bits"]
        if len(counted) == len(times) == buses[bus]["frames"]:
            assert sum(row["bits"] for row in own) == buses[bus]["bits"]
    assert {row["bus"] for row in rows["load"]} == set(stamps)


def test_a_silence_is_two_rows() -> None:
    lines = [*((n / 100, "can0") for n in range(30)), (3600.05, "can0"), (3600.2, "can1")]
    text = b"".join(f"({1000 + time:.6f}) {bus} 701#05\n".encode() for time, bus in lines)
    rows = table(text, "load", network=_core.Network(bitrate=100_000))
    shown = [(row["t_ns"] - 1000 * 10**9, row["frames"]) for row in rows if row["bus"] == "can0"]
    tenth = WINDOW
    assert shown == [
        *((tenth, 10), (2 * tenth, 10), (3 * tenth, 10)),
        *((4 * tenth, 0), (36000 * tenth, 0)),
        *((36001 * tenth, 1), (36002 * tenth, 0)),
    ]
    assert rows[0]["load_percent"] == rows[0]["bits"] / 100
    assert [row["frames"] for row in rows if row["bus"] == "can1"] == [1]


def test_a_silent_live_bus_is_told_as_time_goes_on() -> None:
    session = _core.Session(SessionOptions(format="text", tables=["load"]))
    session.begin("-", False)
    session.feed(b"(1000.000000) can0 701#05\n(1000.010000) can0 701#05\n")
    assert session.batches(flush=True) == []


def test_windows_of_sync_are_those_in_force() -> None:
    sync = b"(1.0) can0 080#\n"
    later = [b"(1.1) can0 080#\n", b"(1.2) can0 080#\n"]
    write = b"(1.0) can0 605#23071000E8030000\n(1.0) can0 585#6007100000000000\n"
    rows = table(sync + write + later[0] + later[1], "sync_cycles")
    assert [row["window_ns"] for row in rows] == [None, 1_000_000, 1_000_000]
    rows = table(sync, "sync_cycles", network=_core.Network(sync_window_ns=250_000))
    assert [row["window_ns"] for row in rows] == [250_000]


def test_cycles_run_on() -> None:
    text = (SAMPLES / "network/sync-and-pdos.log").read_bytes()
    _, rows = both(text, "columns", ["listing", "frames", "pdo", "sync_cycles"], network=DRIVE)
    begins = {row["frame"]: row["cycle"] for row in rows["sync_cycles"]}
    running = 0
    cycles = {}
    for row in rows["listing"]:
        running = begins.get(row["frame"], running)
        assert row["cycle"] == running
        cycles[row["frame"]] = running
    assert running > 10
    for name, of_pdo in rows.items():
        if name.startswith("pdo/"):
            assert [row["running_cycle"] for row in of_pdo] == [cycles[row["frame"]] for row in of_pdo]


def test_what_is_plotted() -> None:
    text = (SAMPLES / "network/sync-and-pdos.log").read_bytes()
    pa = pytest.importorskip("pyarrow")
    session = _core.Session(SessionOptions(format="columns", tables=["pdo"], network=DRIVE, lang="en"))
    session.begin("capture.log", True)
    session.feed(text)
    session.end()
    session.finish()
    quantities: dict[str, bytes] = {}
    for _, batch in session.batches():
        for field in pa.schema(batch):
            if field.metadata:
                quantities[field.name] = field.metadata[b"quantity"]
    assert quantities["statusword"] == quantities["modes of operation display"] == b"false"
    assert quantities["velocity actual value"] == b"true"
