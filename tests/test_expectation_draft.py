"""The first version of a file of expectations: valid, in order, with room around what was seen, and bounded."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from captures import DATA
from filled_records import filled
from msgspec import convert
from msgspec.json import encode

from canalyze.expectations import read
from canalyze.expectations.draft import KINDS, MOST_ALIKE, MOST_WRITES, Draft, Period, period_of, range_of, round_up
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


@pytest.mark.parametrize("rows", sorted((DATA / "drafts").glob("*.jsonl")), ids=lambda path: path.stem)
def test_rows_and_their_draft(tmp_path: Path, rows: Path) -> None:
    """The whole text, which the core takes."""
    text, _ = drafted(tmp_path, *map(json.loads, rows.read_text(encoding="utf-8").splitlines()))
    assert text == rows.with_suffix(".expect.toml").read_text(encoding="utf-8")


def test_setpoints_and_floods_are_counted_only(tmp_path: Path) -> None:
    setpoints = [write("607A", 0, number) for number in range(MOST_ALIKE + 1)]
    text, found = drafted(tmp_path, CAPTURE, write("1017", 0, 1000), *setpoints)
    assert [entry["index"] for entry in found["sdo"]] == [0x1017]
    assert f"{MOST_ALIKE + 1} more writes" in text
    many = [write(f"{0x2000 + number:04X}", 0, 1) for number in range(MOST_WRITES + 50)]
    text, found = drafted(tmp_path, CAPTURE, *many)
    assert len(found["sdo"]) == MOST_WRITES
    assert "50 more writes" in text


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
