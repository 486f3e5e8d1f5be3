"""Problems that `canalyze sniff` tells of real SocketCAN: at the end those that `diagnose` says of candump's log.

Needs what `test_sniff_beside_candump.py` needs. Frames come when the stamps of a sample say; where this machine stood
still meanwhile, they are sent again. What it must not do: test what is diagnosed, or judge speed.
"""

from __future__ import annotations

import json
import time
from pathlib import Path

import can
import pytest
from captures import SAMPLES, SHARED, Row, sort_rows
from diagnoses import diagnosed
from listeners import ATTEMPTS, Ended, Listeners, finish, need
from listeners import bus as bus
from other_readers import candump_log
from test_live_incidents import ended_as, final

CAPTURES = [SAMPLES / "problems.log", *sorted((SHARED / "stories").glob("*.log"))]

LATEST_NS = 100_000_000
"""Lateness below which a file and a listener have always told the same."""


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


def latest_ns(path: Path, log: bytes) -> int:
    """The greatest lateness of a frame in a replay, against its first; one that ends it follows in its log."""
    planned, sent = candump_log(path.read_text()), candump_log(log.decode())[:-1]
    off = [now.t_ns - frame.t_ns for now, frame in zip(sent, planned, strict=True)]
    return max(off) - off[0]


def replayed(path: Path, bus: Listeners) -> list[Ended]:
    """Sends a log when it says; what candump, rows, and text in both languages have shown of it.

    Frames that all come late, and then in a row, are a recorder's that stood still. A file may show that by any later
    frame, and a listener waits for those a short time only: there the two may differ.
    """
    for attempt in range(ATTEMPTS):
        rows, zh, en = (
            bus.sniff("vcan0", "--format", "jsonl"),
            bus.sniff("vcan0", lang="zh", name="zh"),
            bus.sniff("vcan0", lang="en", name="en"),
        )
        # With the side of each frame: what the host has sent itself may be listed late, and less is judged of it.
        recorder = bus.candump(options=("-L", "-x"))
        replay(path)
        ended = finish(recorder, rows, zh, en)
        if latest_ns(path, ended[0].out) < LATEST_NS or attempt == ATTEMPTS - 1:
            break
        bus.directory = bus.directory / "again"
        bus.directory.mkdir()
    return ended


def incidents(out: bytes) -> list[Row]:
    return [row for row in map(json.loads, out.splitlines()) if row["kind"] == "problem"]


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_the_last_word_is_that_of_the_recording(path: Path, bus: Listeners) -> None:
    log, live, *texts = replayed(path, bus)
    told = incidents(live.out)
    recorded = diagnosed(log.out).incidents
    assert ended_as(final(told)) == ended_as(recorded)
    assert len(sort_rows(live.out).frames) == log.out.count(b"\n")
    counts = [sum(row["phase"] == phase for row in told) for phase in ("opened", "linked", "ended")]
    for text in texts:
        lines = text.out.decode().splitlines()
        assert [sum(line.startswith(f"# {mark}") for line in lines) for mark in "✖↳✔"] == counts
