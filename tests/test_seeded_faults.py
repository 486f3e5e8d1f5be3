"""One fault in clean traffic: the program must say so, at that frame, and of that node only.

A table of faults in hand-made sessions, and sweeps that put the same fault into every fitting frame of recorded
ones. A finding is at the right place when its frame, or the frame it names as the cause, is the faulty frame, the
channel's next frame, or a place the row of the table adds (a wrong size can only be seen at the end). A dropped
frame's place is that of its neighbours.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from captures import SAMPLES, Analysis, CanFrame, Row, analyze, log_text, read_log
from faults_of_sdo import (
    AFTER,
    BLOCK_DOWNLOAD,
    BLOCK_UPLOAD,
    DOWNLOAD,
    END,
    FAULTS,
    NODE,
    PROLOGUE,
    READ,
    UPLOAD,
    WRITE,
    Change,
    Fault,
    flip,
    in_company,
    sdo_places,
    shorten,
)

SEVERITIES = ("info", "warning", "error")


def judge(said: Analysis, codes: set[str], severity: str, places: set[int], node: int) -> None:
    """At least one right finding at a right place, and none of another node."""
    others = [finding for finding in said.findings if finding["node"] != node]
    assert not others, others
    right = [finding for finding in said.findings if finding["code"] in codes and at_least(finding, severity)]
    assert right, f"no finding of {sorted(codes)}, but: {listed(said.findings)}"
    assert any({finding["frame"], finding["cause_frame"]} & places for finding in right), (
        f"not at {sorted(places)}: {listed(right)}"
    )


def at_least(finding: Row, severity: str) -> bool:
    return SEVERITIES.index(finding["severity"]) >= SEVERITIES.index(severity)


def listed(findings: list[Row]) -> str:
    return ", ".join(f"{f['code']} {f['severity']} at {f['frame']} of {f['cause_frame']}" for f in findings) or "none"


def test_without_a_fault_there_is_nothing_to_say() -> None:
    for session in (UPLOAD, DOWNLOAD, READ, WRITE, BLOCK_UPLOAD, BLOCK_DOWNLOAD):
        said = analyze(log_text(in_company(session)[0]))
        assert not said.findings, listed(said.findings)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_fault_is_found_where_it_is(fault: Fault) -> None:
    session = list(fault.session)
    fault.change(session, fault.at)
    assert session != fault.session
    capture, numbers = in_company(session)
    missing = len(session) < len(fault.session)
    places = {numbers[at] for at in range(fault.at - missing, fault.at + 2) if at >= 0}
    if fault.at == 0 and missing:
        places.add(len(PROLOGUE))
    for at in fault.also:
        places.add(numbers[len(session)] if at == AFTER else numbers[len(session) - 1] if at == END else numbers[at])
    said = analyze(log_text(capture))
    assert len(said.frames) == len(capture)
    judge(said, {f"SDO{code}" for code in fault.codes.split()}, fault.severity, places, NODE.node)
    first_fault = numbers[max(fault.at - missing, 0)]
    early = [finding for finding in said.findings if finding["frame"] < min(first_fault, min(places))]
    assert not early, listed(early)
    if fault.severity == "info" and fault.name.startswith(("reserved", "padding", "abort by", "the same request")):
        assert not said.above_info(), said.complaint()


# Sweeps: the same fault in every fitting frame of a recorded session.


def recorded_frames(name: str) -> list[CanFrame]:
    """The plain data frames of a recording; remote and error frames are left out."""
    lines = (SAMPLES / name).read_bytes().splitlines(keepends=True)
    return [frame for line in lines if b"#R" not in line and b" 2000" not in line for frame in read_log(line)]


SESSIONS = ["recorded/session.log", "stacks/b6-sdo-block-retransmission.log", "stacks/c3-pdo-remap-master-sync.log"]


def in_segments(frames: list[CanFrame]) -> set[int]:
    """The places of the frames of segmented transfers that carry a toggle bit, found by walking their channels."""
    toggled: set[int] = set()
    running: dict[int, str] = {}
    for at, frame in enumerate(frames):
        node, client = frame.can_id & 0x7F, 0x601 <= frame.can_id <= 0x67F
        if frame.extended or not (client or 0x581 <= frame.can_id <= 0x5FF):
            continue
        kind = frame.data[0] >> 5
        if running.get(node) == "segments" and kind in ((0, 3) if client else (0, 1)):
            toggled.add(at)
            if kind == 0 and frame.data[0] & 1:
                running[node] = "last" if client else ""
        elif running.get(node) == "last":
            toggled.add(at)
            running[node] = ""
        elif client and frame.data[0] in (0x20, 0x21, 0x40):
            running[node] = "initiate"
        elif not client and running.get(node) == "initiate" and frame.data[0] in (0x60, 0x40, 0x41):
            running[node] = "segments"
        else:
            running[node] = ""
    return toggled


def swept(
    name: str, change: Change, wanted: Callable[[list[CanFrame], int], bool], codes: set[str], count: int
) -> None:
    """The change at up to so many fitting places of the recording, one at a time."""
    frames = recorded_frames(name)
    before = {(f["code"], f["frame"]) for f in analyze(log_text(frames)).findings}
    fitting = [entry for entry in sdo_places(frames) if wanted(frames, entry[0])]
    assert fitting or count == 0, "nothing to change"
    for at, node, neighbours in fitting[:: max(1, len(fitting) // count)]:
        changed = list(frames)
        change(changed, at)
        said = analyze(log_text(changed))
        new = [finding for finding in said.findings if (finding["code"], finding["frame"]) not in before]
        places = {place + 1 for place in neighbours}
        right = [
            finding
            for finding in new
            if finding["code"] in codes
            and at_least(finding, "warning")
            and {finding["frame"], finding["cause_frame"]} & places
        ]
        hint = f"{name} frame {at + 1}: {frames[at].can_id:03X} {frames[at].data.hex(' ')}: {listed(new)}"
        assert right, hint
        assert all(finding["node"] == node for finding in new if at_least(finding, "warning")), hint


@pytest.mark.parametrize("name", SESSIONS[:2])
def test_the_toggle_of_any_segment(name: str) -> None:
    toggled = in_segments(recorded_frames(name))
    swept(name, flip(0, 0x10), lambda _, at: at in toggled, {"SDO001", "SDO002"}, 40)


@pytest.mark.parametrize("name", SESSIONS)
def test_any_frame_one_byte_short(name: str) -> None:
    swept(name, shorten(7), lambda _, at: True, {"SDO010"}, 40)


@pytest.mark.parametrize("name", SESSIONS)
def test_the_object_of_any_expedited_answer(name: str) -> None:
    def is_answer(frames: list[CanFrame], at: int) -> bool:
        return frames[at].can_id < 0x600 and frames[at].data[0] in (0x43, 0x47, 0x4B, 0x4F)

    count = 20 if name == SESSIONS[0] else 0
    if count:
        swept(name, flip(1, 0x80), is_answer, {"SDO002", "SDO003"}, count)
