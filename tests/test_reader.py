"""The candump reader beside python-can's: the same files, the same frames.

Where python-can is known to lose something (error frames, the raw DLC) it is not asked.
"""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import can
import pytest
from captures import SAMPLES, analyze

LOGS = sorted(path for path in SAMPLES.rglob("*.log") if b"(" in path.read_bytes()[:1])


Row = tuple[str, str, bool, bool, bool, str]


def theirs(path: Path) -> list[Row]:
    """python-can's frames; an error frame comes as a frame of another kind."""
    rows = []
    with can.CanutilsLogReader(path) as reader:
        for message in reader:
            kind = (message.is_extended_id, message.is_remote_frame, message.is_fd)
            rows.append((str(message.channel), f"{message.arbitration_id:X}", *kind, bytes(message.data).hex().upper()))
    return rows


@pytest.mark.parametrize("path", LOGS, ids=lambda path: str(path.relative_to(SAMPLES)))
def test_the_frames_are_those_of_python_can(path: Path) -> None:
    lines = path.read_text().splitlines()
    if any(line and not line.startswith("(") for line in lines):
        pytest.skip("python-can takes no comments")
    frames = analyze(path.read_bytes()).frames
    other = theirs(path)
    assert len(frames) == len(other) > 0
    for frame, row in zip(frames, other, strict=True):
        identifier = frame["id"].lstrip("0") or "0"
        ours = (frame["bus"], identifier, frame["ext"], frame["rtr"], bool(frame["fd"]), frame["data"])
        assert frame["err"] or ours == row


@pytest.mark.parametrize("path", LOGS, ids=lambda path: str(path.relative_to(SAMPLES)))
def test_every_digit_of_a_stamp_is_kept(path: Path) -> None:
    stamps = [line[1 : line.index(")")] for line in path.read_text().splitlines() if line.startswith("(")]
    ours = [f["t"] for f in analyze(path.read_bytes()).frames]
    assert ours == [str(Decimal(stamp)) for stamp in stamps]
    assert ours
