"""Problems that `canalyze sniff` tells of real SocketCAN: at the end those that `diagnose` says of candump's log.

Needs what `test_sniff_beside_candump.py` needs. Frames come when the stamps of a sample say. What it must not do: test
what is diagnosed, or judge speed.
"""

from __future__ import annotations

import json
import time
from pathlib import Path

import can
import pytest
from captures import SAMPLES, SHARED, Row, sort_rows
from diagnoses import diagnosed
from listeners import Listeners, finish, need
from listeners import bus as bus
from other_readers import candump_log
from test_live_incidents import ended_as, final

CAPTURES = [SAMPLES / "problems.log", *sorted((SHARED / "stories").glob("*.log"))]


@pytest.fixture(autouse=True, scope="module")
def socketcan() -> None:
    need("vcan0")


def replay(path: Path, interface: str = "vcan0") -> None:
    """Sends the frames of a log, as far apart as they were."""
    frames = candump_log(path.read_text())
    began, first = time.monotonic_ns(), frames[0].t_ns
    with can.Bus(interface="socketcan", channel=interface) as sender:
        for frame in frames:
            time.sleep(max(0, began + frame.t_ns - first - time.monotonic_ns()) / 1e9)
            sender.send(can.Message(arbitration_id=frame.can_id, data=frame.data, is_extended_id=False))


def incidents(out: bytes) -> list[Row]:
    return [row for row in map(json.loads, out.splitlines()) if row["kind"] == "problem"]


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_the_last_word_is_that_of_the_recording(path: Path, bus: Listeners) -> None:
    rows, zh, en = (
        bus.sniff("vcan0", "--format", "jsonl"),
        bus.sniff("vcan0", lang="zh", name="zh"),
        bus.sniff("vcan0", lang="en", name="en"),
    )
    # With the side of each frame: those that the host has sent itself may be listed late, and less is judged of them.
    recorder = bus.candump(options=("-L", "-x"))
    replay(path)
    log, live, *texts = finish(recorder, rows, zh, en)
    told = incidents(live.out)
    recorded = diagnosed(log.out).incidents
    assert ended_as(final(told)) == ended_as(recorded)
    assert len(sort_rows(live.out).frames) == log.out.count(b"\n")
    counts = [sum(row["phase"] == phase for row in told) for phase in ("opened", "linked", "ended")]
    for text in texts:
        lines = text.out.decode().splitlines()
        assert [sum(line.startswith(f"# {mark}") for line in lines) for mark in "✖↳✔"] == counts
