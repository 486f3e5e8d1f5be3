"""Captures that other people published (ASC, TRC, BLF, MCAP), with their known answers.

The answers are those of the files. What python-can reads of them stands beside the corpus; where it is wrong about a
file, `CORRECTED` has the right frame and says why. Skipped where the corpus is not on the machine.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from capture_frames import Reading, Recorded, from_start, read, run
from captures import SHARED

CORPUS = SHARED / "corpus"
REFERENCE = CORPUS / "transcripts" / "python_can_reference.json"

pytestmark = pytest.mark.skipif(not REFERENCE.is_file(), reason="no corpus of captures on this machine")

_ROW = re.compile(r"([\d.]+) ch=(\d+) (Rx|Tx) ([0-9A-F]+)(x?) ([DRE]) dlc=(\d+) ([0-9A-F]*)")


def reference() -> dict[str, list[str]]:
    if not REFERENCE.is_file():
        return {}
    files = json.loads(REFERENCE.read_text())["files"]
    return {name: row["list"] for name, row in files.items()}


FILES = reference()


def theirs(name: str, row: str) -> Recorded:
    """A frame as python-can read it. It counts the channels of ASC from 0 and those of TRC from 1."""
    match = _ROW.fullmatch(row)
    assert match, row
    seconds, channel, side, can_id, wide, kind, length, data = match.groups()
    return Recorded(
        t_ns=round(float(seconds) * 1e6) * 1000,
        bus=f"can{int(channel) - name.startswith('trc')}",
        can_id=int(can_id, 16),
        data=bytes.fromhex(data),
        kind="remote" if kind == "R" else "error" if kind == "E" else "data",
        extended=bool(wide) and kind != "E",
        asked=int(length) if kind == "R" else 0,
        sent=side == "Tx",
    )


def _fd(frame: Recorded, *, brs: bool = False, esi: bool = False) -> Recorded:
    return replace(frame, kind="fd", brs=brs, esi=esi)


CORRECTED: dict[tuple[str, int], Callable[[Recorded], Recorded]] = {
    # The reference says of neither that they are CAN FD; the lines say CANFD, with BRS and ESI in columns of their own.
    ("asc/logfile.asc", 17): lambda frame: _fd(frame, brs=True),
    ("asc/logfile.asc", 19): _fd,
    ("asc/test_CanFdMessage.asc", 1): lambda frame: _fd(frame, brs=True),
    ("asc/test_CanFdMessage.asc", 2): lambda frame: _fd(frame, esi=True),
    ("asc/test_CanFdMessage.asc", 3): lambda frame: _fd(frame, brs=True, esi=True),
    # "d 40" is a length of 64, and 64 bytes follow, of which python-can keeps eight. Only CAN FD has so many.
    ("asc/single_frame.asc", 1): lambda frame: _fd(replace(frame, data=bytes(range(64)))),
    # "CANFD 3 Tx 50005x 0 0 5 0 ... 200050": its flags have RTR and not FDF: a classic remote frame that python-can
    # takes for one of CAN FD, which has none.
    ("asc/logfile.asc", 18): lambda frame: replace(frame, kind="remote", asked=5),
}

UNTOLD = {"trc/test_CanMessage_V1_0_BUS1.trc"}
"""Files that do not say the side of a frame; python-can says received."""


def opened(name: str, scratch: Path) -> Reading:
    return read(CORPUS / name, output=scratch / "said.jsonl")


def comparable(name: str, frames: list[Recorded]) -> list[Recorded]:
    """Without what the file does not say, or says in its own way: details, identifier and side of error frames."""
    rows = []
    for frame in from_start(frames):
        one = replace(frame, can_id=0, data=b"", extended=False, sent=None) if frame.kind == "error" else frame
        rows.append(replace(one, sent=None) if name in UNTOLD else one)
    return rows


@pytest.mark.parametrize("name", [name for name in FILES if not name.startswith("blf")])
def test_the_frames_are_those_of_the_file(name: str, tmp_path: Path) -> None:
    reading = opened(name, tmp_path)
    wanted = [theirs(name, row) for row in FILES[name]]
    wanted = [CORRECTED.get((name, n), replace)(frame) for n, frame in enumerate(wanted, 1)]
    assert reading.code == 0
    assert comparable(name, reading.frames) == comparable(name, wanted)
    assert reading.complaints == ""


@pytest.mark.parametrize("name", [name for name in FILES if name.startswith("asc")])
def test_stamps_of_asc_are_those_of_the_lines(name: str, tmp_path: Path) -> None:
    reading = opened(name, tmp_path)
    assert [frame.t_ns for frame in reading.frames] == [theirs(name, row).t_ns for row in FILES[name]]


def test_a_raw_dlc_above_eight_stays(tmp_path: Path) -> None:
    """`d D`: DLC 13 of a classic frame, which has eight bytes. python-can makes 32 of it."""
    text = run(["decode", CORPUS / "asc" / "issue_1299.asc"], tmp_path / "frames.txt").out.decode()
    assert "{D}  55 AA 01 02 03 04 05 06" in text


def test_passed_over_lines_of_asc_are_counted(tmp_path: Path) -> None:
    """J1939TP, Statistic and Status lines are no frames: `info` counts them by kind."""
    text = run(["info", CORPUS / "asc" / "logfile.asc"], tmp_path / "logfile.info").out.decode()
    for kind in ("J1939TP", "Statistic", "Status"):
        assert kind in text


@pytest.mark.parametrize("name", [name for name in FILES if name.startswith("blf")])
def test_made_up_blf_objects(name: str, tmp_path: Path) -> None:
    """Each file has two objects whose every field is a pattern: identifiers of 30 bits, lengths of 51 or 102.

    No such frame exists. What is read must not be more than the two, and they are named where they are not read.
    """
    reading = opened(name, tmp_path)
    assert len(reading.frames) <= 2
    assert reading.code == (0 if reading.frames else 2)
    assert len(reading.frames) == 2 or reading.complaints
    for frame in reading.frames:
        assert frame.can_id <= (0x1FFF_FFFF if frame.extended or frame.kind == "error" else 0x7FF)
        assert frame.data.hex() in ("", "5566778899aabbcc", "ccddeeff11223344", bytes(range(64)).hex())


TOPICS = {
    "mcap/cdr_test_0.mcap": {"/test_topic": 3, "/array_topic": 4},
    "mcap/talker.mcap": {"/rosout": 10, "/topic": 10},
    "mcap/topics_and_services.mcap": {"/parameter_events": 7, "/add_two_ints/_service_event": 6},
}
"""What real recordings without CAN hold: topics, and how many messages."""


@pytest.mark.parametrize("name", TOPICS)
def test_a_recording_without_can_has_no_frames_and_says_so(name: str, tmp_path: Path) -> None:
    reading = opened(name, tmp_path)
    assert reading.code == 2
    assert reading.frames == []
    assert len(reading.complaints.splitlines()) == 1, reading.complaints


@pytest.mark.parametrize("name", TOPICS)
def test_info_shows_the_topics(name: str, tmp_path: Path) -> None:
    lines = run(["info", CORPUS / name], tmp_path / "topics.info").out.decode().splitlines()
    for topic, messages in TOPICS[name].items():
        assert any(topic in line and str(messages) in line for line in lines), lines
