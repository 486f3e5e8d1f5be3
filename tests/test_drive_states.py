"""The states of drives in lanes against the statuswords that PDOs and uploads carry."""

from __future__ import annotations

import json
from bisect import bisect_right
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from captures import SAMPLES

from canalyze import _core
from canalyze.running.reading import SessionOptions

CODINGS = [
    (0x4F, 0x00, "not-ready-to-switch-on"),
    (0x4F, 0x40, "switch-on-disabled"),
    (0x6F, 0x21, "ready-to-switch-on"),
    (0x6F, 0x23, "switched-on"),
    (0x6F, 0x27, "operation-enabled"),
    (0x6F, 0x07, "quick-stop-active"),
    (0x4F, 0x0F, "fault-reaction-active"),
    (0x4F, 0x08, "fault"),
]
"""Mask, value and state of a statusword (CiA 402)."""

STATUSWORDS = {0x6041 + 0x800 * axis: axis for axis in range(8)}
CAPTURES = sorted([*SAMPLES.glob("network/*.log"), *SAMPLES.glob("stories/*.log"), *SAMPLES.glob("rules/DRV*.log")])


def rows_of(path: Path, table: str) -> list[dict[str, Any]]:
    session = _core.Session(SessionOptions(format="columns", tables=[table], lang="en"))
    session.begin(path.name, True, "candump")
    assert session.feed(path.read_bytes()) + session.end() + session.finish() == b""
    return [row for _, batch in session.batches() for row in pa.record_batch(batch).to_pylist()]


def state_of(statusword: int) -> str | None:
    return next((name for mask, value, name in CODINGS if statusword & mask == value), None)


def test_all_states_are_covered() -> None:
    seen = {row["class"] for path in CAPTURES for row in rows_of(path, "lanes") if row["lane"].startswith("drive/")}
    assert {name for _, _, name in CODINGS} - {"not-ready-to-switch-on"} <= seen


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_a_lane_shows_the_last_statusword(path: Path) -> None:
    """A row has the state of the statusword in its frame; between rows, statuswords show no other one."""
    lanes: dict[tuple[str, int, int], list[dict[str, Any]]] = {}
    for row in rows_of(path, "lanes"):
        kind, bus, node, *axis = row["lane"].split("/")
        if kind == "drive":
            key = (bus, int(node[4:]), int(axis[0][4:]) - 1 if axis else 0)
            lanes.setdefault(key, []).append(row)
    words: dict[tuple[str, int, int], dict[int, str | None]] = {}
    for row in rows_of(path, "objects"):
        if row["index"] in STATUSWORDS and row["sub"] == 0:
            key = (row["bus"], row["node"], STATUSWORDS[row["index"]])
            words.setdefault(key, {})[row["frame"]] = state_of(row["integer"])
    for key, rows in lanes.items():
        frames = [row["frame"] for row in rows]
        for row in rows:
            assert row["class"] is None or row["class"] == words[key][row["frame"]], row
        for frame, state in words[key].items():
            place = bisect_right(frames, frame) - 1
            assert (rows[place]["class"] if place >= 0 else None) == state, (key, frame)
    assert all(key in lanes for key, shown in words.items() if any(shown.values()))


def exchange(t_ms: int, request: str, answer: str) -> str:
    return f"(1.{t_ms:03}0) can0 605#{request}\n(1.{t_ms:03}5) can0 585#{answer}\n"


@pytest.mark.parametrize("profile, states", [(402, ["ready-to-switch-on", "operation-enabled"]), (406, [])])
def test_only_a_drive_has_states_of_one(profile: int, states: list[str]) -> None:
    """6041h of an encoder is no statusword, whatever its PDOs carry."""
    capture = exchange(0, "4000100000000000", f"43001000{profile.to_bytes(4, 'little').hex()}")
    capture += exchange(1, "2F001A0000000000", "60001A0000000000")
    capture += exchange(2, "23001A0110004160", "60001A0100000000")
    capture += exchange(3, "2F001A0001000000", "60001A0000000000")
    capture += "(1.1000) can0 185#3102\n(1.1100) can0 185#3702\n"
    session = _core.Session(SessionOptions(format="observed", lang="en"))
    session.begin("x.log", True, "candump")
    said = session.feed(capture.encode()) + session.end() + session.finish()
    rows = [json.loads(line) for line in said.splitlines()]
    assert [row["state"] for row in rows if row["kind"] == "observed_drive"] == states
