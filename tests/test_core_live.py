"""What live buses need of the core, from Python: blocks in, candump's filters, a number of frames, a tally.

The blocks themselves are tested with their reader; here is what a caller sees.
"""

from __future__ import annotations

import json
import struct

import pytest

from canalyze._core import Session
from canalyze.running.reading import SessionOptions

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
    session = Session(SessionOptions(lang="en"))
    session.begin("can0", False, "live")
    out = session.feed(block(1, 0, body=b"can0") + heartbeats(10))
    assert out.count(b"  # heartbeat of node 5") == 10
    assert out.startswith(b"(1700000000.000000)  can0  RX - -  705   [1]  05")
    assert session.feed(block(5, 0, START_NS + 1_100_000_000)) == b""
    ticks = b"".join(block(5, 0, START_NS + no * 100_000_000) for no in range(11, 90))
    assert (
        session.feed(ticks) == b"#   HBT002 error: frame 10 node 5: no heartbeat for 400 ms since then "
        b"(limit 330 ms: 3 periods plus tolerance)\n"
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
    session = Session(SessionOptions(lang="en", format="jsonl", limit=3, masks=["can1,705~7FF"]))
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
        Session(SessionOptions(lang="en", masks=[f"can0,{part}"]))
    assert f"filter '{part}' of 'can0,{part}' is unknown" in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(ValueError) as caught:
        Session(SessionOptions(lang="zh", masks=[f"can0,{part}"]))
    assert f"“can0,{part}”中的过滤条件“{part}”无法识别" in str(caught.value)


def test_frames_that_are_lost_are_named_by_bus() -> None:
    session = Session(SessionOptions(lang="zh"))
    session.begin("can0,can1", False, "live")
    lost = block(1, 0, body=b"can0") + block(1, 1, body=b"can1") + block(4, 1, 7)
    assert session.feed(lost + block(6, 0) + block(5, 0, START_NS)).startswith(
        b"DROPCOUNT: dropped 7 CAN frames on 'can1'"
    )
    assert session.complaints() == ["can1: CAP002 丢失7帧 (累计7帧)"]


def test_a_stream_that_is_none_is_one_damage() -> None:
    session = Session(SessionOptions(lang="en"))
    session.begin("can0", False, "live")
    session.feed(b"\xff" * 40)
    session.feed(heartbeats(3))
    assert len(session.complaints()) == 1 and session.frames == 0


REQUEST, ANSWER = (0x605, "4018100100000000"), (0x585, "4318100191010F00")
BEFORE = [(0.2, 0x605, "4000100000000000"), (0.21, 0x585, "4300100091010F00")]


def frame(at_s: float, cob: int, data: str) -> bytes:
    """A frame that comes at this time."""
    octets = bytes.fromhex(data)
    at = START_NS + round(at_s * 1e9)
    record = RECORD.pack(1, 1 | 16, 0, len(octets), 0, 6, len(octets), 0, cob, 0, at) + octets
    return block(3, 0, body=record) + block(5, 0, at)


def told(session: Session, frames: list[tuple[float, int, str]], seconds: float) -> list[tuple[float, str]]:
    """The lines of findings and problems while frames come and the time passes, each with when it came."""
    found = []
    waiting = sorted(frames)
    for step in range(round(seconds * 10)):
        now = step / 10
        blocks = b""
        while waiting and waiting[0][0] <= now:
            blocks += frame(*waiting.pop(0))
        out = session.feed(blocks + block(5, 0, START_NS + step * 100_000_000))
        found += [(now, line) for line in out.decode().splitlines() if line.startswith("#")]
    return found


def silent(frames: list[tuple[float, int, str]], seconds: float = 6) -> tuple[list[tuple[float, str]], str]:
    """What is told of a bus with these frames while it runs, and at its end."""
    session = Session(SessionOptions(lang="en", incidents=True))
    session.begin("can0", False, "live")
    session.feed(block(1, 0, body=b"can0"))
    return told(session, frames, seconds), (session.end() + session.finish()).decode()


@pytest.mark.parametrize("alive", [True, False])
def test_a_silent_server_is_named_while_the_bus_runs(alive: bool) -> None:
    others = [(0.3 + step / 2, 0x706, "05") for step in range(12 if alive else 0)]
    live, end = silent([*BEFORE, (1.0, *REQUEST), *others])
    lines = [line for _, line in live]
    assert [at for at, line in live if "SDO002" in line and "request without response" in line] == [2.6]
    assert any("problem 1: node 5: request for 1018h:01 at 800 ms not answered" in line for line in lines)
    assert "SDO002" not in end and "not answered" not in end, "and not again"


def test_a_server_that_never_answers_is_named_while_the_bus_runs() -> None:
    others = [(0.3 + step / 2, 0x706, "05") for step in range(12)]
    live, end = silent([(1.0, *REQUEST), *others])
    assert [round(at, 1) for at, line in live if "SDO031" in line] == [2.6]
    assert any("never heard" in line for _, line in live) and "SDO031" not in end


@pytest.mark.parametrize("after_s", [0.02, 1.2])
def test_a_server_that_answers_in_time_is_not_named(after_s: float) -> None:
    live, end = silent([*BEFORE, (1.0, *REQUEST), (1.0 + after_s, *ANSWER)])
    assert not [line for _, line in live if "SDO002" in line or "not answered" in line] and "SDO002" not in end


def test_a_server_that_answers_after_all_is_named_once() -> None:
    live, end = silent([*BEFORE, (1.0, *REQUEST), (4.0, *ANSWER)])
    assert [at for at, line in live if "SDO002" in line] == [2.6]
    assert "was not answered" not in end
    assert "incomplete" not in end


def test_a_scan_names_no_one() -> None:
    scan = [(1.0 + node / 50, 0x600 + node, "4000100000000000") for node in range(1, 100)]
    live, end = silent([*BEFORE, *scan], 8)
    assert not [line for _, line in live if "SDO031" in line] and "SDO031" not in end


def test_a_bus_that_was_away_leaves_states_unknown() -> None:
    session = Session(SessionOptions(lang="en", format="monitor"))
    session.begin("can0", False, "live")
    session.feed(block(1, 0, body=b"can0") + heartbeats(10))

    def node() -> dict[str, object]:
        one: dict[str, object] = json.loads(session.snapshot())["nodes"][0]
        return one

    session.feed(block(6, 0) + block(5, 0, START_NS + 1_000_000_000))
    assert (node()["unknown"], node()["state"]) == (False, "05"), "a few frames are missing, no more"
    ticks = b"".join(block(5, 0, START_NS + no * 100_000_000) for no in range(10, 60))
    session.feed(block(6, 0, which=1) + ticks)
    assert (node()["unknown"], node()["silent"], node()["findings"]) == (True, None, {"error": 0, "warning": 0})
    session.feed(frame(7.0, 0x706, "05"))
    assert node()["unknown"] is True, "another node says nothing of this one"
    session.feed(frame(7.1, 0x705, "7F") + block(5, 0, START_NS + 7_500_000_000))
    assert (node()["unknown"], node()["state"]) == (False, "7F")


def test_a_lost_heartbeat_does_not_come_back_by_an_interface_that_goes() -> None:
    session = Session(SessionOptions(lang="en", format="monitor"))
    session.begin("can0", False, "live")
    others = b"".join(frame(1.0 + step / 10, 0x706, "05") for step in range(20))
    session.feed(block(1, 0, body=b"can0") + heartbeats(10) + others)

    def shown() -> tuple[object, object, list[object]]:
        snapshot = json.loads(session.snapshot())
        node = snapshot["nodes"][0]
        return node["silent"], node["unknown"], [(one["kind"], one["status"]) for one in snapshot["problems"]]

    assert shown()[:2] == ("heartbeat", False)
    before = shown()[2]
    assert ("node-silent", "open") in before
    ticks = b"".join(block(5, 0, START_NS + no * 100_000_000) for no in range(30, 80))
    session.feed(block(6, 0, which=1) + ticks)
    assert shown() == (None, True, before), "nobody knows, and nothing is over"
    session.feed(b"".join(frame(8.0 + step / 10, 0x706, "05") for step in range(20)))
    assert shown() == (None, True, before)
    session.feed(frame(10.0, 0x705, "05") + block(5, 0, START_NS + 10_200_000_000))
    assert shown()[:2] == (None, False) and ("node-silent", "open") not in shown()[2]


def test_nodes_in_figures() -> None:
    session = Session(SessionOptions(lang="en"))
    session.begin("can0", False, "live")
    others = b"".join(frame(1.0 + step / 10, 0x706, "7F") for step in range(20))
    session.feed(block(1, 0, body=b"can0") + heartbeats(10) + others)
    assert json.loads(session.nodes()) == [
        {
            "bus": "can0",
            "node": 5,
            "state_text": "Operational",
            "silent": "heartbeat",
            "frames": 10,
            "errors": 1,
            "warnings": 0,
        },
        {
            "bus": "can0",
            "node": 6,
            "state_text": "Pre-operational",
            "silent": "",
            "frames": 20,
            "errors": 0,
            "warnings": 0,
        },
    ]


def test_a_page_of_a_node() -> None:
    session = Session(SessionOptions(lang="en", format="monitor"))
    session.begin("can0", False, "live")
    write = [(0.3, 0x605, "2300180185010000"), (0.31, 0x585, "6000180100000000")]
    session.feed(block(1, 0, body=b"can0") + b"".join(frame(*one) for one in [*BEFORE, *write]))
    page = json.loads(session.page("can0", 5))
    assert [(one["index"], one["sub"]) for one in page["identity"]] == [("1000", 0)]
    assert "000F0191h" in page["identity"][0]["text"] and page["identity"][0]["name"] == "device type"
    assert [(one["pdo"], one["id"], one["valid"]) for one in page["pdos"]] == [("TPDO1", "185", True)]
    assert json.loads(session.page("can0", 6)) == {"identity": [], "pdos": []}
    assert session.page("can9", 5) == ""
