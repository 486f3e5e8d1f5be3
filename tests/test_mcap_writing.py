"""MCAP as we write it, read by other people's readers: `mcap` with `mcap-ros2-support`, and `rosbags`.

What decoded topics say is compared with `decode --format jsonl` and `signals --format jsonl` of the same capture.
"""

from __future__ import annotations

import io
import json
import math
import re
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from captures import SAMPLES, placed
from conftest import Runner
from mcap.reader import SeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory

from canalyze._core import Session
from canalyze.running.reading import SessionOptions

EDS = Path(__file__).parents[1] / "eds"
NETWORK = ["--eds", f"5={EDS / 'drive.eds'}", "--eds", f"6={EDS / 'io.eds'}", "--eds", f"7={EDS / 'encoder.eds'}"]
NAMED = ["sync-and-pdos", "boot-and-states", "drive-states", "remapping", "multiplex-and-safety"]
ALL = sorted(SAMPLES.rglob("*.log"))
FD = "(1.000000001) can0 123##3" + "".join(f"{byte:02X}" for byte in range(12)) + " T\n"
MIXED = (
    "(1549455524.265601) can0 60A#4008100000000000 R\n"
    "(1549455524.265602) vcan1 1ABCDEF0#R4 T\n"
    "(1549455524.265600) can0 20000088#0000000400000000 R\n"
    "(1549455525.000000) vcan1 123##3000102030405060708090A0B T\n"
)


class Said(NamedTuple):
    """A message: where, of which frame, when, what."""

    topic: str
    frame: int
    time: int
    message: Any


def session(form: str, capture: bytes, step: int = 0, **more: Any) -> bytes:
    it = Session(SessionOptions(lang="en", format=form, **more))
    it.begin("folder/x.log", True)
    step = step or len(capture) or 1
    out = [it.feed(capture[at : at + step]) for at in range(0, len(capture), step)]
    return b"".join([*out, it.end(), it.finish()])


def mcap(capture: bytes, **more: Any) -> bytes:
    return session("convert", capture, to="mcap", **more)


def opened(data: bytes) -> SeekingReader:
    reader = make_reader(io.BytesIO(data), validate_crcs=True, decoder_factories=[DecoderFactory()])
    assert isinstance(reader, SeekingReader)
    return reader


def said(data: bytes, *, in_order: bool = False) -> list[Said]:
    messages = opened(data).iter_decoded_messages(log_time_order=in_order)
    return [Said(at.topic, one.sequence, one.log_time, decoded) for _, at, one, decoded in messages]


def lines(text: str | bytes, kind: str) -> list[dict[str, Any]]:
    objects = [json.loads(line) for line in text.splitlines()]
    return [one for one in objects if one["kind"] == kind]


def ns(seconds: str | None) -> int:
    return int(Decimal(seconds or 0) * 10**9)


def moment(stamp: Any) -> int:
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def test_frames_come_back() -> None:
    first, remote, error, fd = said(mcap(MIXED.encode()))
    assert (first.topic, first.time) == ("/can0/from_can_bus", 1549455524265601000)
    assert moment(first.message.header.stamp) == first.time
    assert first.message.header.frame_id == "can0"
    assert (first.message.id, first.message.dlc, first.message.data.hex()) == (0x60A, 8, "4008100000000000")
    assert (remote.topic, remote.message.is_rtr, remote.message.dlc) == ("/vcan1/to_can_bus", True, 4)
    assert (remote.message.id, remote.message.is_extended) == (0x1ABCDEF0, True)
    assert (error.message.is_error, error.message.id, error.message.data.hex()) == (True, 0x88, "0000000400000000")
    assert (fd.topic, fd.message.id, fd.message.len) == ("/vcan1/to_can_bus_fd", 0x123, 12)
    assert bytes(fd.message.data) == bytes(range(12))
    times = [one.time for one in said(mcap(MIXED.encode()), in_order=True)]
    assert times == sorted(times)


def test_fd_flags_by_request() -> None:
    (fd,) = said(mcap(FD.encode(), mcap_fd_schema="dataspeed"))
    assert (fd.time, fd.message.fdf, fd.message.brs, fd.message.esi) == (1000000001, True, True, True)
    assert bytes(fd.message.data) == bytes(range(12))


@pytest.mark.parametrize("capture", ALL, ids=lambda path: path.stem)
def test_every_sample(capture: Path) -> None:
    content = capture.read_bytes()
    truth = lines(session("jsonl", content), "frame")
    data = mcap(content)
    assert len(opened(data).get_summary().statistics.channel_message_counts) > 0  # type: ignore[union-attr]
    written = [one for one in said(data) if re.search("/(from|to)_can_bus(_fd)?$", one.topic)]
    assert len(written) == len(truth)
    for one, frame in zip(written, truth, strict=True):
        message = one.message
        assert (message.id, message.is_extended) == (int(frame["id"], 16), frame["ext"])
        length = message.len if "fd" in one.topic.split("_") else message.dlc
        assert (length, message.is_error) == (frame["len"], frame["err"])
        assert bytes(message.data)[: len(frame["data"]) // 2].hex().upper() == frame["data"]
        if frame["t"] is not None:
            assert one.time == moment(message.header.stamp) == ns(frame["t"])


def test_summary() -> None:
    frames = "".join(
        f"({no // 1000}.{no % 1000:03}000) can{no % 2} {no % 0x7FF:03X}#{no:016X}\n" for no in range(20_000)
    )
    data = mcap(frames.encode())
    summary = opened(data).get_summary()
    assert summary is not None and summary.statistics is not None
    assert summary.statistics.message_count == 20_000
    assert summary.statistics.channel_message_counts == {0: 10_000, 1: 10_000}
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (0, 19_999_000_000)
    assert summary.statistics.chunk_count == len(summary.chunk_indexes) == 2
    assert all(chunk.compression == "zstd" for chunk in summary.chunk_indexes)
    assert all(sorted(chunk.message_index_offsets) == [0, 1] for chunk in summary.chunk_indexes)
    header = opened(data).get_header()
    assert header.profile == "ros2" and header.library.startswith("canalyze/")
    (source,) = opened(data).iter_metadata()
    assert source.name == "canalyze.source"
    assert source.metadata == {"file": "x.log", "format": "candump", "buses": "can0\ncan1"}
    part = opened(data).iter_messages(topics=["/can1/from_can_bus"], start_time=15 * 10**9, end_time=16 * 10**9)
    with pytest.warns(DeprecationWarning):
        assert len(list(part)) == 500
    archive = mcap(frames.encode(), mcap_archive=True)
    assert len(archive) < 0.8 * len(data)
    assert [one[:3] for one in said(archive)] == [one[:3] for one in said(data)]


def test_chunking_changes_nothing() -> None:
    content = (SAMPLES / "network" / "boot-and-states.log").read_bytes()
    assert mcap(content, decoded=True) == mcap(content, step=97, decoded=True)


def test_without_stamps() -> None:
    assert [one.time for one in said(mcap(b"can0  001   [0]\ncan0  002   [0]\n"))] == [0, 1_000_000]


def test_rosbags(tmp_path: Path) -> None:
    rosbags = pytest.importorskip("rosbags.highlevel")
    path = tmp_path / "x.mcap"
    path.write_bytes(mcap((SAMPLES / "network" / "boot-and-states.log").read_bytes(), decoded=True))
    with rosbags.AnyReader([path]) as reader:
        read = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.msgtype == "can_msgs/msg/Frame"
        ]
    assert len(read) == len(
        lines(session("jsonl", (SAMPLES / "network" / "boot-and-states.log").read_bytes()), "frame")
    )


@pytest.fixture(params=NAMED)
def decoded(request: pytest.FixtureRequest, canalyze: Runner, tmp_path: Path) -> tuple[Path, bytes]:
    """Give a capture and its decoded MCAP."""
    capture = SAMPLES / "network" / f"{request.param}.log"
    done = canalyze("--lang", "en", "convert", "--decoded", *NETWORK, str(capture), "out.mcap")
    assert done.code == 0, done.err
    return capture, (tmp_path / "out.mcap").read_bytes()


def definitions(data: bytes) -> dict[str, dict[str, str]]:
    """Give for each topic the field of each object, `6041:00`."""
    summary = opened(data).get_summary()
    assert summary is not None
    found = {}
    for channel in summary.channels.values():
        text = summary.schemas[channel.schema_id].data.decode()
        rows = re.findall(r"^# (?:.*, )?([0-9A-F]{4})h:([0-9A-F]{2})(?:, .*)?\n\S+ (\S+)$", text, re.M)
        found[channel.topic] = {f"{index}:{sub}": field for index, sub, field in rows}
    return found


def test_signals(decoded: tuple[Path, bytes], canalyze: Runner) -> None:
    capture, data = decoded
    done = canalyze("--lang", "en", "signals", "--format", "jsonl", *NETWORK, str(capture))
    fields = definitions(data)
    written = {}
    for one in said(data):
        if (place := re.match(r"/(.*)/node(\d+)/([tr]pdo\d+)", one.topic)) is not None:
            bus, node, pdo = place.groups()
            for address, field in fields[one.topic].items():
                written[one.frame, bus, int(node), pdo.upper(), address] = getattr(one.message, field)
    truth = lines(done.out, "signal")
    assert truth
    for row in truth:
        key = (row["frame"], row["bus"], row["node"], row["pdo"], f"{row['index']}:{row['sub']:02X}")
        value = written.pop(key)
        if isinstance(value, bytes):
            assert value.hex().upper() == row["value"]
        else:
            assert value == pytest.approx(float(row["value"]), rel=1e-6)
    assert not written


def test_words_of_states(decoded: tuple[Path, bytes]) -> None:
    _, data = decoded
    states: dict[str, str] = {}
    for one in said(data):
        if one.topic.endswith("/drive_state"):
            assert states.get(one.topic) != one.message.state
            states[one.topic] = one.message.state
        elif hasattr(one.message, "statusword_text") and one.topic.count("/") == 3:
            # The text may say more: a warning.
            assert one.message.statusword_text


def test_states_that_uploads_show() -> None:
    """A message for each other state, also where no PDO shows it."""
    words = [0x0231, 0x0631, 0x0237, 0x0022, 0x0231]
    capture = "".join(
        f"({number}.0) can0 605#4041600000000000\n({number}.1) can0 585#4B416000{word & 0xFF:02X}{word >> 8:02X}0000\n"
        for number, word in enumerate(words, 1)
    )
    shown = [one for one in said(mcap(capture.encode(), decoded=True)) if one.topic == "/can0/node5/drive_state"]
    assert [(one.frame, one.message.statusword) for one in shown] == [
        (2, 0x0231),
        (6, 0x0237),
        (8, 0x0022),
        (10, 0x0231),
    ]
    assert [one.message.state for one in shown] == ["ready to switch on", "operation enabled", "", "ready to switch on"]


def test_events(decoded: tuple[Path, bytes], canalyze: Runner) -> None:
    capture, data = decoded
    text = canalyze("--lang", "en", "decode", "--format", "jsonl", *NETWORK, str(capture)).out
    messages = said(data)
    frames = lines(text, "frame")

    states = [
        (one.frame, int(one.topic.split("/")[2][4:]), one.message.state)
        for one in messages
        if one.topic.endswith("nmt_state")
    ]
    beats = [one for one in frames if one["service"] in ("heartbeat", "guarding") and not one["rtr"]]
    shown = [(one["frame"], one["node"], int(one[one["service"]]["state"], 16)) for one in beats]
    assert states == shown

    emergencies = [one for one in messages if one.topic.endswith("/emcy")]
    truth = [one for one in frames if one["service"] == "emcy"]
    assert len(emergencies) == len(truth)
    for one, frame in zip(emergencies, truth, strict=True):
        message = one.message
        assert f"{message.code:04X}" == frame["emcy"]["code"]
        assert f"{message.error_register:02X}" == frame["emcy"]["register"]
        assert bytes(message.manufacturer).hex().upper() == frame["emcy"]["manufacturer"]
        assert (one.frame, message.text) == (frame["frame"], frame["text"])

    transfers = [one.message for one in messages if one.topic.endswith("/sdo")]
    for one, row in zip(transfers, lines(text, "transfer"), strict=True):
        assert (one.direction, one.mode, one.status) == (row["direction"], row["mode"], row["status"])
        assert (f"{one.index:04X}", one.sub, one.name) == (row["index"], row["sub"], row["name"] or "")
        assert (one.value, one.size) == (row["text"], row["size"])
        assert one.text.startswith(f"{row['index']}h:{row['sub']:02X} ") and one.value in one.text
        assert bytes(one.data).hex().upper() == row["data"][:2048]
        assert (one.first_frame, one.last_frame) == (row["first_frame"], row["last_frame"])
        assert moment(one.start) == ns(row["t"])
        assert math.isclose(one.duration, float(row["duration"]), abs_tol=1e-9)
        assert one.abort_code == (int(row["abort"]["code"], 16) if row["abort"] else 0)
        assert one.abort_text == (row["abort"]["text"] or "" if row["abort"] else "")

    found(messages, lines(text, "finding"))


def found(messages: list[Said], truth: list[dict[str, Any]]) -> None:
    findings = [one.message for one in messages if one.topic == "/findings"]
    for one, row in zip(findings, truth, strict=True):
        assert (one.code, one.name, one.severity) == (row["code"], row["name"], row["severity"])
        assert (one.message, one.node) == (row["message"], row["node"] or 0)
        assert (f"{one.index:04X}", one.sub) == (row["index"] or "0000", row["sub"] or 0)
        assert (one.frame, one.cause_frame) == (row["frame"] or 0, row["cause_frame"] or 0)
        assert (one.about_frame, one.because_of) == (row["about_frame"] or 0, row["because_of"] or 0)
    level = {"info": 20, "warning": 30, "error": 40}
    log = [(one.message.level, one.message.msg) for one in messages if one.topic == "/log"]
    for row in truth:
        assert (level[row["severity"]], f"{row['code']} {placed(row)}") in log


@pytest.mark.parametrize("capture", sorted((SAMPLES / "rules").glob("*[0-9].log")), ids=lambda path: path.stem)
def test_findings_of_every_rule(capture: Path) -> None:
    content = capture.read_bytes()
    found(said(mcap(content, decoded=True)), lines(session("jsonl", content), "finding"))


def test_words_in_the_chosen_language() -> None:
    it = Session(SessionOptions(lang="zh", format="convert", to="mcap", decoded=True))
    it.begin("x.log", True)
    (_, state) = said(it.feed(b"(1.0) can0 705#05 R\n") + it.end() + it.finish())
    assert (state.topic, state.message.state, state.message.name) == ("/can0/node5/nmt_state", 5, "操作状态")
