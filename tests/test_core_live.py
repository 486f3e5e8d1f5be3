"""What live buses need of the core, from Python: blocks in, candump's filters, a number of frames, a tally.

The blocks themselves are tested with their reader; here is what a caller sees.
"""

from __future__ import annotations

import json
import struct

import pytest

from canalyze._core import Session

START_NS = 1_700_000_000_000_000_000
RECORD = struct.Struct("<BBBBBBBBIIq")


def block(kind: int, bus: int, number: int = 0, body: bytes = b"", which: int = 0) -> bytes:
    """A block of the stream `live`."""
    return struct.pack("<BBBBIq", kind, bus, which, 0, len(body), number) + body


def heartbeats(count: int, bus: int = 0) -> bytes:
    """So many heartbeats of node 5, every 100 ms, as python-can's receivers hand them over."""
    records = [
        RECORD.pack(1, 1 | 16, bus, 1, 0, 6, 1, 0, 0x705, 0, START_NS + no * 100_000_000) + b"\x05"
        for no in range(count)
    ]
    return block(3, bus, body=b"".join(records))


def test_blocks_become_lines_and_time_tells_what_is_missing() -> None:
    session = Session(lang="en")
    session.begin("can0", False, "live")
    out = session.feed(block(1, 0, body=b"can0") + heartbeats(10))
    assert out.count(b"  # heartbeat of node 5") == 10
    assert out.startswith(b"(1700000000.000000)  can0  RX - -  705   [1]  05")
    assert session.feed(block(5, 0, START_NS + 1_100_000_000)) == b""
    ticks = b"".join(block(5, 0, START_NS + no * 100_000_000) for no in range(11, 90))
    assert (
        session.feed(ticks)
        == b"#   HBT002 error: frame 10 node 5: no heartbeat for 400ms after it, the limit is 330ms\n"
    )
    session.end(interrupted=True)
    session.finish()
    tally = json.loads(session.tally())
    assert tally == {
        "frames": 10,
        "shown": 10,
        "findings": {"error": 1, "warning": 0, "info": 0},
        "transfers": {"ok": 0, "aborted": 0, "incomplete": 0, "failed": 0},
        "expectations": None,
        "buses": [{"name": "can0", "frames": 10, "error_frames": 0, "dropped": 0}],
    }


def test_as_many_frames_as_asked_for() -> None:
    session = Session(lang="en", format="jsonl", count=3, masks=["can1,705~7FF"])
    session.begin("can0,can1", False, "live")
    assert not session.done
    names = block(1, 0, body=b"can0") + block(1, 1, body=b"can1")
    out = session.feed(names + heartbeats(2, 1) + heartbeats(9) + block(5, 0, START_NS + 10**10))
    assert session.done and session.wants() is None
    assert [json.loads(line)["bus"] for line in out.splitlines()] == ["can0"] * 3
    assert session.feed(heartbeats(5) + block(5, 0, START_NS + 10**11)) == b""
    session.end(interrupted=True)
    assert session.finish() == b""
    tally = json.loads(session.tally())
    assert tally["shown"] == 3 and [bus["name"] for bus in tally["buses"]] == ["can0", "can1"]


@pytest.mark.parametrize("part", ["123", "12G:7FF", "#", "x", ""])
def test_what_is_no_filter_of_candump_is_said(part: str) -> None:
    with pytest.raises(ValueError) as caught:
        Session(lang="en", masks=[f"can0,{part}"])
    assert f"filter '{part}' of 'can0,{part}' is unknown" in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(ValueError) as caught:
        Session(lang="zh", masks=[f"can0,{part}"])
    assert f"“can0,{part}”中的过滤条件“{part}”无法识别" in str(caught.value)


def test_frames_that_are_lost_are_named_by_bus() -> None:
    session = Session(lang="zh")
    session.begin("can0,can1", False, "live")
    lost = block(1, 0, body=b"can0") + block(1, 1, body=b"can1") + block(4, 1, 7)
    assert session.feed(lost + block(6, 0) + block(5, 0, START_NS)).startswith(
        b"DROPCOUNT: dropped 7 CAN frames on 'can1'"
    )
    assert session.complaints() == ["can1: CAP002 丢失7帧 (累计7帧)"]


def test_a_stream_that_is_none_is_one_damage() -> None:
    session = Session(lang="en")
    session.begin("can0", False, "live")
    session.feed(b"\xff" * 40)
    session.feed(heartbeats(3))
    assert len(session.complaints()) == 1 and session.frames == 0
