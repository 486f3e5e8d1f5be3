"""The first version of a file of expectations: valid, in order, with room around what was seen, and bounded."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from filled_records import filled
from msgspec import convert
from msgspec.json import encode

from canalyze.expectations import read
from canalyze.expectations.draft import KINDS, MOST_ALIKE, MOST_WRITES, Draft, period_of, range_of, round_up
from canalyze.records.observed import Period
from canalyze.words import LANGUAGES, Words

Row = dict[str, Any]
TAGGED = {str(kind.__struct_config__.tag): kind for kind in KINDS}

CAPTURE: Row = {"kind": "summary_capture", "frames": 329, "buses": 1, "seconds": "0.534875", "bit_rate": None}


def write(index: str, sub: int, value: object, **more: Any) -> Row:
    row: Row = {
        "kind": "transfer",
        "bus": "vcan0",
        "node": 5,
        "direction": "download",
        "index": index,
        "sub": sub,
        "name": "an object",
        "type": "UNSIGNED16",
        "size": 2,
        "data": "E803",
        "value": value,
        "text": "",
        "status": "ok",
    }
    return row | more


def spread(least: float, mean: float, most: float, count: int = 100) -> Row:
    return {"count": count, "min_us": least, "mean_us": mean, "max_us": most}


def lines(*rows: Row) -> bytes:
    """Rows as the core writes them, with what they do not say."""
    return b"".join(encode(filled(TAGGED[row["kind"]], row)) + b"\n" for row in rows)


def drafted(tmp_path: Path, *rows: Row, lang: str = "en") -> tuple[str, dict[str, Any]]:
    """The text, and what the core gets of it."""
    draft = Draft()
    draft.take(lines(*rows))
    text = draft.text(Words(lang), "boot.log")
    path = tmp_path / "boot.expect.toml"
    path.write_text(text, encoding="utf-8")
    return text, json.loads(read(path).normal)


@pytest.mark.parametrize("lang", LANGUAGES)
def test_an_empty_one_is_valid(tmp_path: Path, lang: str) -> None:
    text, found = drafted(tmp_path, CAPTURE, lang=lang)
    assert "boot.log" in text and "329" in text
    assert [entry["occurs"] for entry in found["emcy"]] == ["never"]


def test_writes_stand_in_their_order_at_each_node(tmp_path: Path) -> None:
    text, found = drafted(
        tmp_path,
        CAPTURE,
        write("1017", 0, 1000, text="1000 (03E8h)", name="producer heartbeat time"),
        write("1800", 1, 0xC0000185, node=6, text="C0000185h (185h, invalid)", type="UNSIGNED32"),
        write("1017", 0, 500),
        write("2000", 0, None, type=None, size=3, data="010203"),
        write("2001", 0, "abc", type="VISIBLE_STRING", size=3, data="616263"),
        write("2002", 0, 'a"\\\u007f', type="VISIBLE_STRING", size=4, data="61225C7F"),
        write("2003", 0, 1.5, type="REAL32", size=4, data="0000C03F"),
        write("2004", 0, True, type="BOOLEAN", size=1, data="01"),
        write("2005", 0, None, type="DOMAIN", size=100, data="00" * 100),
        write("2006", 0, "18446744073709551615", type="UNSIGNED64", size=8, data="FF" * 8),
    )
    assert [(e["node"], f"{e['index']:X}", e["value"], e["sequence"]) for e in found["sdo"]] == [
        (5, "1017", {"number": 1000}, "node 5"),
        (6, "1800", {"number": 0xC0000185}, "node 6"),
        (5, "1017", {"number": 500}, "node 5"),
        (5, "2000", {"data": "010203"}, "node 5"),
        (5, "2001", {"text": "abc"}, "node 5"),
        (5, "2002", {"data": "61225C7F"}, "node 5"),
        (5, "2003", {"number": 1.5}, "node 5"),
        (5, "2004", {"bool": True}, "node 5"),
        (5, "2005", None, "node 5"),
        (5, "2006", {"data": "FF" * 8}, "node 5"),
    ]
    assert all(entry["direction"] == "download" and entry["outcome"] == "ok" for entry in found["sdo"])
    assert "value = 1000  # 1000 (03E8h)" in text and "value = 0xC0000185" in text
    assert "# producer heartbeat time" in text


def test_setpoints_and_floods_are_counted_only(tmp_path: Path) -> None:
    setpoints = [write("607A", 0, number) for number in range(MOST_ALIKE + 1)]
    text, found = drafted(tmp_path, CAPTURE, write("1017", 0, 1000), *setpoints)
    assert [entry["index"] for entry in found["sdo"]] == [0x1017]
    assert f"{MOST_ALIKE + 1} more writes" in text
    many = [write(f"{0x2000 + number:04X}", 0, 1) for number in range(MOST_WRITES + 50)]
    text, found = drafted(tmp_path, CAPTURE, *many)
    assert len(found["sdo"]) == MOST_WRITES
    assert "50 more writes" in text


def test_the_identity_is_read_once_and_without_serial_number(tmp_path: Path) -> None:
    _, found = drafted(
        tmp_path,
        CAPTURE,
        *(write("1018", sub, sub, direction="upload") for sub in (4, 3, 2, 1, 0, 1)),
        write("1008", 0, "now this", direction="upload", data="00", type="VISIBLE_STRING"),
        write("1008", 0, "now that", direction="upload", data="01", type="VISIBLE_STRING"),
        write("6041", 0, 1, direction="upload"),
    )
    assert [(e["index"], e["sub"], e["direction"], e["sequence"]) for e in found["sdo"]] == [
        (0x1018, sub, "upload", None) for sub in (1, 2, 3)
    ]


def test_aborted_transfers_are_counted_only(tmp_path: Path) -> None:
    text, found = drafted(
        tmp_path, CAPTURE, write("1017", 0, 1, status="aborted"), write("1017", 0, 1, status="incomplete")
    )
    assert not found["sdo"]
    assert "1 aborted, 1 incomplete" in text


def test_states_of_booting_have_time(tmp_path: Path) -> None:
    state: Row = {"kind": "observed_state", "bus": "vcan0", "node": 5, "left": False, "first_frame": 1}
    other = state | {"node": 6}
    _, found = drafted(
        tmp_path,
        CAPTURE,
        {"kind": "summary_node", "bus": "vcan0", "node": 5, "boot_ups": 1, "response": None},
        {"kind": "summary_node", "bus": "vcan0", "node": 6, "boot_ups": 2, "response": None},
        state | {"state": "boot-up", "since_boot_up_ns": 0},
        state | {"state": "pre-operational", "since_boot_up_ns": 100_000_000},
        state | {"state": "operational", "since_boot_up_ns": 1_300_000_000},
        state | {"state": "stopped", "since_boot_up_ns": 9_000_000_000},
        other | {"state": "operational", "since_boot_up_ns": 1_300_000_000},
        other | {"node": 7, "state": "operational", "since_boot_up_ns": None},
        {**state, "kind": "observed_drive", "axis": 2, "state": "operation-enabled", "since_boot_up_ns": 10_000_000},
        {**state, "kind": "observed_drive", "axis": 1, "state": "switched-on", "since_boot_up_ns": 10_000_000},
    )
    assert [
        (e["node"], e["state"] or e["drive"], e["by_ns"], e["since"], e["axis"], e["stays"]) for e in found["state"]
    ] == [
        (5, "boot-up", None, "start", None, False),
        (5, "pre-operational", 1_000_000_000, "boot-up", None, False),
        (5, "operational", 5_000_000_000, "boot-up", None, False),
        (5, "stopped", None, "start", None, False),
        (6, "operational", None, "start", None, False),
        (7, "operational", None, "start", None, False),
        (5, "operation-enabled", 1_000_000_000, "boot-up", 2, False),
    ]


def test_periods(tmp_path: Path) -> None:
    whose: Row = {"bus": "vcan0", "node": 5, "silence_us": 500.0}
    signal = {"kind": "observed_signal", **whose, "select": "", "min": None, "max": None}
    text, found = drafted(
        tmp_path,
        CAPTURE,
        {"kind": "observed_heartbeat", **whose, "count": 101, "period": spread(999_100, 1_000_200, 1_001_300)},
        {"kind": "observed_heartbeat", **whose, "node": 6, "count": 101, "period": spread(20_000, 90_000, 200_000)},
        {
            "kind": "observed_sync",
            "bus": "vcan0",
            "count": 101,
            "period": spread(10_017, 10_025.9, 10_068),
            "silence_us": None,
        },
        {"kind": "observed_pdo", **whose, "pdo": "TPDO3", "count": 101, "period": spread(400, 500, 600)},
        {"kind": "observed_pdo", **whose, "pdo": "TPDO4", "count": 3, "period": spread(400, 500, 600, 2)},
        {"kind": "observed_pdo", **whose, "pdo": "TPDO5", "count": 1, "period": None},
        {
            "kind": "observed_pdo",
            **whose,
            "pdo": "TPDO6",
            "count": 9,
            "period": spread(400, 500, 600),
            "silence_us": 801.0,
        },
        {"kind": "observed_pdo", **whose, "pdo": "TPDO7", "count": 101, "period": spread(400, 500, 600)},
        *(signal | {"pdo": f"TPDO{number}"} for number in range(3, 7)),
    )
    assert [(e["node"], e["period_ns"], e["tolerance_ns"]) for e in found["heartbeat"]] == [
        (5, 1_000_000_000, 500_000_000)
    ]
    assert [(e["period_ns"], e["tolerance_ns"]) for e in found["sync"]] == [(10_000_000, 2_000_000)]
    assert [(e["select"], e["period_ns"], e["tolerance_ns"]) for e in found["signal"]] == [
        ("5.TPDO3.*", 500_000, 250_000)
    ]
    assert "seen 999.100 .. 1001.300 ms (100 intervals)" in text
    assert "# Nodes without a heartbeat period here: 1 (" in text and "# PDOs without a period here: 2 (" in text


def test_signals_have_room(tmp_path: Path) -> None:
    signal: Row = {
        "kind": "observed_signal",
        "bus": "vcan0",
        "node": 5,
        "pdo": "TPDO4",
        "signal": "转速\n",
        "unit": "rpm",
    }
    text, found = drafted(
        tmp_path,
        CAPTURE,
        signal | {"select": "5.TPDO4.606C:00", "min": -3.5, "max": 900.0},
        signal | {"select": "5.TPDO4.6041:00", "min": None, "max": None},
        signal | {"select": 'a"\\b\x1b', "min": 0, "max": 0},
    )
    assert [(e["select"], e["min"], e["max"]) for e in found["signal"]] == [
        ("5.TPDO4.606C:00", -300, 1200),
        ('a"\\b\x1b', 0, 1),
    ]
    assert "# 转速\\x0a: -3.5 .. 900 rpm" in text


def test_emcys_latency_and_load(tmp_path: Path) -> None:
    _, found = drafted(
        tmp_path,
        CAPTURE | {"bit_rate": 500_000},
        {"kind": "observed_emcy", "bus": "vcan0", "node": 5, "code": "8130", "count": 2},
        {"kind": "summary_node", "bus": "vcan0", "node": 5, "boot_ups": 1, "response": {"max_us": 1182}},
        {"kind": "summary_node", "bus": "vcan0", "node": 6, "boot_ups": 1, "response": {"max_us": 9182}},
        {"kind": "summary_node", "bus": "vcan0", "node": 7, "boot_ups": 1, "response": None},
        {"kind": "summary_bus", "bus": "vcan0", "load_peak_100ms": 31.4},
    )
    assert [(e["node"], e["code"], e["occurs"]) for e in found["emcy"]] == [
        (5, [0x8130, 0xFFFF], "may"),
        (None, None, "never"),
    ]
    assert [(e["of"], e["node"], e["max_ns"]) for e in found["latency"]] == [("sdo", None, 50_000_000)]
    assert [(e["max_percent"], e["bit_rate"]) for e in found["load"]] == [(45, 500_000)]


def test_buses_stand_where_there_are_several(tmp_path: Path) -> None:
    _, found = drafted(
        tmp_path,
        CAPTURE | {"buses": 2, "bit_rate": 500_000},
        write("1017", 0, 1000, bus="can0"),
        write("1017", 0, 1000, bus="can1"),
        {
            "kind": "observed_sync",
            "bus": "can1",
            "count": 101,
            "period": spread(10_017, 10_025.9, 10_068),
            "silence_us": None,
        },
        {"kind": "summary_node", "bus": "can1", "node": 5, "boot_ups": 1, "response": {"max_us": 1182}},
        {"kind": "summary_bus", "bus": "can1", "load_peak_100ms": 31.4},
    )
    assert [(e["bus"], e["sequence"]) for e in found["sdo"]] == [("can0", "can0 node 5"), ("can1", "can1 node 5")]
    assert [e["bus"] for table in ("sync", "latency", "load") for e in found[table]] == ["can1"] * 3


def test_problems_that_were_seen_may_occur_and_no_others(tmp_path: Path) -> None:
    row: Row = {
        "kind": "problem",
        "problem": "node-silent",
        "subject": {"bus": "vcan0", "node": 5},
        "status": "ended",
        "root": True,
        "begin": {"frame": 39, "t": None},
        "message": "node 5: silent",
    }
    harmless, effect = row | {"status": "harmless", "problem": "capture-gap"}, row | {"root": False, "subject": {}}
    bus = row | {"problem": "bus-off", "subject": {"bus": "vcan0", "nodes": []}}
    text, found = drafted(tmp_path, CAPTURE, row, row, harmless, effect, bus)
    assert [(e["kind"], e["node"], e["occurs"]) for e in found["problem"]] == [
        ("node-silent", 5, [0, None]),
        ("bus-off", None, [0, None]),
        (None, None, [0, 0]),
    ]
    assert "# seen at frame 39: node 5: silent" in text


def test_findings_of_the_capture_are_said(tmp_path: Path) -> None:
    row: Row = {"kind": "summary_finding", "code": "HBT003", "severity": "error"}
    text, _ = drafted(tmp_path, CAPTURE, row, row | {"code": "SDO017", "severity": "info"})
    assert "HBT003" in text and "SDO017" not in text


def test_what_a_capture_names_cannot_leave_its_comment(tmp_path: Path) -> None:
    draft = Draft()
    draft.take(
        lines(CAPTURE, write("1017", 0, 1000, name="x\n[[load]]\nmax_percent = 1", text="\r\n[[load]]" + "y" * 200))
    )
    text = draft.text(Words("en"), "a\nb\u2028.log")
    assert set(tomllib.loads(text)) == {"sdo", "emcy", "problem"}
    assert max(map(len, text.splitlines())) < 120


@pytest.mark.parametrize(
    ("value", "up"),
    [(1, 1), (1.01, 2), (2, 2), (2.1, 5), (5.1, 10), (0.5, 0.5), (0.51, 1), (0.011, 0.02), (999, 1000), (1e9, 1e9)],
)
def test_limits_are_round(value: float, up: float) -> None:
    assert round_up(value) == up


@pytest.mark.parametrize(
    ("least", "mean", "most", "period"),
    [
        (99, 100.2, 101, (100, 10)),
        (10_017, 10_025.9, 10_068, (10_000, 1000)),
        (8_000, 10_000, 12_000, (10_000, 5_000)),
        (31_000, 31_250, 31_500, (31_000, 3_100)),
        (6_500, 10_000, 13_500, (10_000, 7_500)),
        (99_900, 87_000, 100_300, (100_000, 10_000)),
        (4_000, 10_000, 16_000, None),
        (0, 0, 0, None),
    ],
)
def test_periods_are_round(least: float, mean: float, most: float, period: tuple[float, float] | None) -> None:
    assert period_of(convert(spread(least, mean, most), Period), 0.1) == period


@pytest.mark.parametrize(
    ("least", "most", "wanted"),
    [
        (0, 0, (0, 1)),
        (0, 1, (0, 1.3)),
        (5, 5, (4.5, 5.5)),
        (-10, 10, (-15, 15)),
        (100, 900, (0, 1100)),
        (-900, -100, (-1100, 0)),
        (64000, 65000, (57000, 72000)),
        (0.001, 0.002, (0.0007, 0.0023)),
    ],
)
def test_ranges_are_round(least: float, most: float, wanted: tuple[float, float]) -> None:
    low, high = range_of(least, most)
    assert (low, high) == wanted
    assert low <= least <= most <= high
