"""Lanes of a timeline: the states that nodes were in, as their recorders know, and what holds of any capture."""

from __future__ import annotations

import json
from collections import defaultdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from captures import SAMPLES

from canalyze import _core
from canalyze.running.reading import SessionOptions

CAPTURES = sorted(
    path for path in SAMPLES.rglob("*") if path.suffix in {".log", ".asc", ".mcap"} and "recorded" not in path.parts
)
TOLD = sorted(path for path in [*SAMPLES.glob("network/*.json"), *SAMPLES.glob("stacks/*.json")])
CLASSES = {"boot-up": "pre-operational"}
"""Classes of states that are not named as the state."""


def lanes_of(path: Path, lang: str = "en") -> dict[str, list[dict[str, Any]]]:
    """The rows of a capture by lane, in their order."""
    session = _core.Session(SessionOptions(format="columns", tables=["lanes"], lang=lang))
    data = path.read_bytes()
    sniffed = _core.sniff(data, True)
    session.begin(path.name, True, sniffed if sniffed in _core.FORMATS else "candump")
    assert session.feed(data) + session.end() + session.finish() == b""
    found = defaultdict(list)
    for _, batch in session.batches():
        for row in pa.record_batch(batch).to_pylist():
            found[row["lane"]].append(row)
    return found


@pytest.mark.parametrize("path", TOLD, ids=lambda path: path.stem)
def test_states_are_those_that_nodes_were_in(path: Path) -> None:
    """From the frame on that shows a state its lane shows it."""
    lanes = lanes_of(path.with_suffix(".log"))
    for change in json.loads(path.read_text()).get("state_changes", []):
        rows = lanes[f"nmt/{change['bus']}/node{change['node']}"]
        state = [row["class"] for row in rows if row["frame"] <= change["line"]][-1]
        assert state == CLASSES.get(change["state"], change["state"]), change


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.name)
def test_a_row_is_a_change(path: Path) -> None:
    """Lanes begin with a state, and their rows are changes in the order of frames and times, in both languages."""
    lanes = lanes_of(path)
    for lane, rows in lanes.items():
        if lane.startswith("pdo/"):  # not a lane, but where samples of a plot end
            assert not any(row["state"] or row["class"] for row in rows)
            continue
        assert rows[0]["state"] is not None
        for before, row in pairwise(rows):
            assert before["frame"] <= row["frame"]
            assert None in (before["t_ns"], row["t_ns"]) or before["t_ns"] <= row["t_ns"]
            assert (before["state"], before["class"]) != (row["state"], row["class"]) or row["lane"].startswith("sdo/")
    plain = [lane for lane in lanes if not lane.startswith("value/")]
    for lane, rows in lanes_of(path, "zh").items():
        if not lane.startswith("value/"):
            assert [row["class"] for row in rows] == [row["class"] for row in lanes[lane]]
            plain.remove(lane)
    assert not plain
