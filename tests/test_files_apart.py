"""Files that are one capture, with nothing recorded between them for any time.

No node is blamed for that time, and what is wrong within a file is found. What it must not do: test files of one
recording that goes on (`test_cli_check.py`), or damaged ones.
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace

import pytest
from captures import CanFrame, Row, log_text
from clean_sessions import beside, sessions
from distortions import shown
from faulty_captures import Capture
from plants import IO, built
from test_distortions import happened, key

from canalyze import _core
from canalyze.running.reading import SessionOptions

APART_US = (
    *(1_000_000, 10_000_000, 60_000_000, 3_540_000_000, 3_660_000_000, 86_400_000_000),
    *(-1_000_000, -60_000_000, -3_540_000_000, -3_660_000_000, -86_400_000_000),
)
"""Below and above an hour, and the later file named first.

Physical limit: a silence that is no longer than those before it may as well be a node's that is late.
"""


def judged(files: list[list[CanFrame]], network: _core.Network | None = None) -> list[Row]:
    """The findings above info that are no consequence of another, but for findings about the capture."""
    session = _core.Session(SessionOptions(lang="en", format="check", depth="default", network=network))
    output = b""
    for number, frames in enumerate(files):
        session.begin(f"part{number}.log", True, "candump")
        output += session.feed(log_text(frames)) + session.end()
    rows: list[Row] = [json.loads(line) for line in (output + session.finish()).decode().splitlines()]
    above = [row for row in rows if row["severity"] != "info" and row.get("because_of") is None]
    return [row for row in above if not row["code"].startswith("CAP")]


def apart(frames: list[CanFrame], at: int, by_us: int) -> list[list[CanFrame]]:
    """Two files, the second one so much later."""
    return [frames[:at], [replace(frame, t_us=frame.t_us + by_us) for frame in frames[at:]]]


@pytest.mark.parametrize("by_us", APART_US, ids=shown)
def test_nobody_is_blamed_for_what_is_not_recorded(by_us: int) -> None:
    wrong = []
    for name, session in sessions().items():
        frames = list(session.frames)
        raised = {frame.can_id - 0x80 for frame in frames if 0x81 <= frame.can_id <= 0xFF}
        for network in beside(name):
            own = Counter(key(row) for row in judged([frames], network))
            for part in (0.2, 0.5, 0.8):
                at = min(max(round(len(frames) * part), 1), len(frames) - 1)
                found = judged(apart(frames, at, by_us), network)
                found = [row for row in found if not (happened(row) and row["node"] in raised)]
                more = Counter(map(key, found)) - own
                wrong += [(name, part, row["code"], row["message"]) for row in found if key(row) in more]
    assert not wrong


@pytest.mark.parametrize("by_us", [0, *APART_US], ids=shown)
def test_a_fault_within_a_file_is_found(by_us: int) -> None:
    """A node is silent for a second, in the second file as in the first one."""
    for since in (1.2, 4.3):
        capture = Capture(built("plant", "written"))
        capture.drop(since, since + 1.0, 0x700 + IO, 0x186, 0x286, 0x586, 0x606)
        at = next(n for n, frame in enumerate(capture.frames) if frame.t_us > capture.frames[0].t_us + 3_200_000)
        found = [row["code"] for row in judged(apart(capture.frames, at, by_us))]
        assert "HBT002" in found, (since, found)


@pytest.mark.parametrize("by_us", [0, 2000], ids=shown)
def test_a_fault_across_files_that_follow_each_other_is_found(by_us: int) -> None:
    """A recording is cut into files anywhere: the node is silent from before the cut on."""
    capture = Capture(built("plant", "written"))
    capture.drop(3.0, 4.5, 0x700 + IO, 0x186, 0x286, 0x586, 0x606)
    for cut_us in (3_050_000, 3_200_000, 4_000_000):
        at = next(n for n, frame in enumerate(capture.frames) if frame.t_us > capture.frames[0].t_us + cut_us)
        found = [row["code"] for row in judged(apart(capture.frames, at, by_us))]
        assert "HBT002" in found, (cut_us, found)
