"""A damaged chunk of an MCAP file loses its definitions, and every message that is lost by damage is counted.

A file that was written until its writer was killed is said where it is met, and made whole by `convert`, held against
mcap's own reader. Must not: look at the wording of findings; what they count is computed from the file that was
damaged.
"""

from __future__ import annotations

import json
import random
import struct
import time
import zlib
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from captures import CanFrame
from conftest import Runner
from mcap.writer import CompressionType, IndexType
from mcap_files import cdr, raw
from ros_messages import FRAME

from canalyze import _core
from canalyze.errors import OutputError
from canalyze.running.reading import SessionOptions
from canalyze.running.recording import Recording
from canalyze.words import Words

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 1, 2, 3, 4, 5, 6, 15
FRAMES = [
    CanFrame(
        f"can{number % 3 == 0:d}",
        0x180 + number % 32,
        struct.pack("<Q", number * 0x9E3779B97F4A7C15 % 2**64),
        10**15 + number * 125,
    )
    for number in range(260)
]
Damages = list[dict[str, Any]]


def counted(text: bytes) -> bytes:
    return struct.pack("<I", len(text)) + text


def record(op: int, body: bytes) -> bytes:
    return bytes([op]) + struct.pack("<Q", len(body)) + body


def schema(number: int, text: bytes = FRAME.encode(), name: bytes = b"can_msgs/msg/Frame") -> bytes:
    return record(SCHEMA, struct.pack("<H", number) + counted(name) + counted(b"ros2msg") + counted(text))


def channel(number: int, of: int, topic: bytes, encoding: bytes = b"cdr") -> bytes:
    return record(CHANNEL, struct.pack("<HH", number, of) + counted(topic) + counted(encoding) + counted(b""))


def message(number: int, frame: CanFrame) -> bytes:
    log_ns = frame.t_us * 1000
    return record(MESSAGE, struct.pack("<HIQQ", number, 0, log_ns, log_ns) + cdr(frame))


def chunk(content: bytes, frames: list[CanFrame], *, sound: bool = True) -> bytes:
    """A chunk; `sound`: its check sum is right."""
    times = [frame.t_us * 1000 for frame in frames]
    crc = zlib.crc32(content) ^ (not sound)
    head = struct.pack("<QQQI", min(times), max(times), len(content), crc) + counted(b"")
    return record(CHUNK, head + struct.pack("<Q", len(content)) + content)


def whole(*parts: bytes, end: bytes = b"") -> bytes:
    head = MAGIC + record(HEADER, counted(b"ros2") + counted(b"test"))
    return head + b"".join(parts) + record(DATA_END, bytes(4)) + end + record(FOOTER, bytes(20)) + MAGIC


def read(data: bytes, size: int = 1 << 20) -> tuple[Counter[Any], Damages, dict[str, int]]:
    """Read a file: the frames, the damage, and the messages of each topic."""
    rows = []
    for form in ("jsonl", "info"):
        session = _core.Session(SessionOptions(lang="en", format=form))
        session.begin("capture.mcap", True, "mcap")
        out = b"".join(session.feed(data[at : at + size]) for at in range(0, len(data), size))
        rows += [json.loads(line) for line in (out + session.end() + session.finish()).splitlines()]
    info = rows.pop()
    frames = [row for row in rows if row["kind"] == "frame"]
    found = Counter((row["bus"], row["id"], row["data"], row["t"], row["rtr"]) for row in frames)
    assert info["frames"] == len(frames)
    caps = [row for row in rows if row["kind"] == "finding" and row["code"] in ("CAP004", "CAP005")]
    assert len(caps) == info["damages"], "all commands say so alike"
    topics: Counter[str] = Counter()
    for topic in info["contents"]["topics"]:
        topics[topic["name"]] += topic["messages"]
    damages: Damages = info["damage"]
    if info["unreadable"]:
        damages = [*damages, {"kind": "unreadable", "frames": info["unreadable"]["count"]}]
    return found, damages, dict(topics)


def said(damages: Damages) -> list[tuple[str, int | None]]:
    return [(damage["kind"], damage["frames"]) for damage in damages]


def file(**options: Any) -> bytes:
    return raw([(f"/{frame.bus}/from_can_bus", frame.t_us * 1000, cdr(frame)) for frame in FRAMES], **options)


TOPIC = b"/can0/from_can_bus"
PARTS = [[replace(frame, bus="can0") for frame in FRAMES[at : at + 20]] for at in range(0, 100, 20)]
BODIES = [b"".join(message(1, frame) for frame in part) for part in PARTS]
SOUND = [chunk(body, part) for body, part in zip(BODIES[1:], PARTS[1:], strict=True)]
BETTER = schema(1) + channel(1, 1, TOPIC)
TRUE = read(whole(chunk(BETTER, PARTS[0]), *SOUND))[0]


@pytest.mark.parametrize("size", [1 << 20, 97])
def test_a_damaged_chunk_loses_its_definitions(size: int) -> None:
    bad = chunk(BETTER + BODIES[0], PARTS[0], sound=False)
    # They may come again in a later chunk.
    found, damages, topics = read(whole(bad, *SOUND[:2], chunk(BETTER + BODIES[3], PARTS[3]), SOUND[3]), size=size)
    assert found == read(whole(chunk(BETTER + BODIES[3], PARTS[3]), SOUND[3]))[0]
    assert said(damages) == [("checksum", None), ("undefined", 40)]
    assert topics == {TOPIC.decode(): 80}
    # At the end they only tell what the messages were.
    for end, name in ((BETTER, [TOPIC.decode()]), (b"", [])):
        found, damages, topics = read(whole(bad, *SOUND, end=end), size=size)
        assert not found and said(damages) == [("checksum", None), ("undefined", 80)]
        assert topics == dict.fromkeys(name, 80)
    other = schema(1, b"uint32 x", b"other_msgs/msg/Counter") + channel(1, 1, b"/counter")
    found, damages, topics = read(whole(bad, *SOUND, end=other), size=size)
    assert not found and said(damages) == [("checksum", None)] and topics == {"/counter": 80}


def test_a_file_that_lost_all_its_frames(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_bytes(whole(chunk(BETTER, PARTS[0], sound=False), *SOUND, end=BETTER))
    done = canalyze("--lang", "en", "decode", "x.mcap")
    assert done.code == 2 and done.complaints[1].startswith("x.mcap: byte ")
    assert "CAP004 80 messages skipped" in done.complaints[1]
    assert done.complaints[2:] == ["canalyze: x.mcap: read as MCAP, no CAN frames; see canalyze info for its content"]


def test_messages_of_a_type_that_is_not_there_are_counted(canalyze: Runner, tmp_path: Path) -> None:
    body = b"".join(message(1, frame) for frame in PARTS[0])
    other = b"".join(message(2, frame) for frame in PARTS[1])
    good = schema(1) + channel(2, 1, b"/can1/from_can_bus")
    for wrong in (
        good + channel(1, 99, TOPIC) + body + other,  # no such type
        body + good + other,  # no such topic
        good + channel(1, 1, TOPIC, b"cdx") + body + other,  # no such encoding
        good + schema(3, b"uint32 ie") + channel(1, 3, TOPIC) + body + other,  # a known name without its fields
    ):
        for data in (whole(wrong), whole(chunk(wrong, PARTS[0] + PARTS[1]))):
            found, damages, topics = read(data)
            assert found.total() == 20
            assert said(damages) == [("undefined", 20)]
            assert topics["/can1/from_can_bus"] == 20 and topics.get(TOPIC.decode(), 20) == 20
            (tmp_path / "x.mcap").write_bytes(data)
            for command in (["decode"], ["summary"], ["check"], ["convert", "--to", "candump"]):
                done = canalyze("--lang", "en", *command, "x.mcap", *(["-"] if command[0] == "convert" else []))
                (line,) = done.complaints
                assert "CAP004 20 messages skipped: the definition of their topic is lost" in line
                assert done.code == (command == ["check"])
            assert "20 frames lost" in canalyze("--lang", "en", "info", "x.mcap").out
    # Other topics are no damage, nor is one without a type.
    other = schema(3, b"uint32 x", b"other_msgs/msg/Counter") + channel(1, 3, TOPIC) + body
    for data in (whole(other, good), whole(channel(1, 0, TOPIC), body, good)):
        found, damages, topics = read(data)
        assert (found.total(), damages, topics[TOPIC.decode()]) == (0, [], 20)


def test_a_definition_that_comes_too_late() -> None:
    for data in (whole(channel(1, 1, TOPIC), *BODIES[1:], schema(1)), whole(*BODIES[1:], end=BETTER)):
        found, damages, _ = read(data)
        assert not found and said(damages) == [("undefined", 80)]


def test_two_definitions_of_one_topic() -> None:
    other = channel(1, 1, b"/can1/from_can_bus")
    # The first holds; without a check sum over it its frames are doubtful.
    found, damages, topics = read(whole(BETTER, BODIES[1], other, BODIES[2]))
    assert (found.total(), said(damages), topics) == (40, [("definition", 40)], {TOPIC.decode(): 40})
    # One that makes frames of unread messages.
    found, damages, topics = read(whole(schema(1), channel(1, 1, TOPIC, b"cdx"), BODIES[1], BETTER, BODIES[2]))
    assert (found.total(), said(damages), topics) == (0, [("definition", 0), ("undefined", 40)], {TOPIC.decode(): 40})
    # The same of their type.
    other = schema(1, FRAME.replace("bool is_rtr\nbool is_extended", "bool is_extended\nbool is_rtr").encode())
    found, damages, _ = read(whole(other, channel(1, 1, TOPIC), BODIES[1], schema(1), BODIES[2]))
    assert (found.total(), said(damages)) == (40, [("definition", 40)])
    other = schema(1, FRAME.replace("uint32 id", "uint32 ie").encode(), b"can_msgs/msg/Fraoe")
    found, damages, _ = read(whole(other, channel(1, 1, TOPIC), BODIES[1], schema(1), BODIES[2]))
    assert (found.total(), said(damages)) == (0, [("definition", 0), ("undefined", 40)])
    # A check sum covers the first.
    found, damages, _ = read(whole(chunk(BETTER + BODIES[1], PARTS[1]), *SOUND[1:], end=other))
    assert (found, said(damages)) == (TRUE, [("definition", 0)])


VARIANTS: dict[str, dict[str, Any]] = {
    "none": {"compression": CompressionType.NONE, "chunk_size": 2000},
    "zstd": {"compression": CompressionType.ZSTD, "chunk_size": 2000},
    "lz4": {"compression": CompressionType.LZ4, "chunk_size": 2000},
    "no index": {"compression": CompressionType.NONE, "chunk_size": 2000, "index_types": IndexType.NONE},
    "no check sum": {"compression": CompressionType.NONE, "chunk_size": 2000, "enable_crcs": False},
    "no chunks": {"use_chunking": False},
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_loss_is_told_with_its_number(variant: str) -> None:
    data = file(**VARIANTS[variant])
    true, damages, _ = read(data)
    assert true.total() == len(FRAMES) and damages == []
    protected = "crcs" not in str(VARIANTS[variant]) and "chunks" not in variant
    choose = random.Random(variant)
    for _ in range(120):
        at, bit = choose.randrange(len(data)), choose.randrange(8)
        changed = bytearray(data)
        changed[at] ^= 1 << bit
        found, damages, _ = read(bytes(changed))
        lost, new = (true - found).total(), (found - true).total()
        where = (at, bit, lost, new, damages)
        doubtful = sum(damage["frames"] or 0 for damage in damages if damage["kind"] == "definition")
        told = sum(damage["frames"] or 0 for damage in damages if damage["kind"] != "definition")
        assert new <= max(doubtful, 0 if protected else 1), where
        if not any(damage["kind"] in ("cut", "rest") for damage in damages):
            assert told == lost - new, where


def test_each_definition_takes_the_same_time() -> None:
    one = CanFrame("can0", 0x181, bytes(8), 10**15)
    many = {
        "redefined": schema(1) + b"".join(channel(1, 1, b"/can%d" % (number % 2)) for number in range(200_000)),
        "topics": schema(1)
        + b"".join(
            channel(number, 1, b"/can%d/%s_can_bus" % (number // 2, (b"from", b"to")[number % 2]))
            + message(number, one)
            for number in range(65_535)
        ),
        "types": b"".join(
            schema(1, FRAME.encode() + b"\nuint8 x%d" % number) + channel(1, 1, b"/can%d" % (number % 2))
            for number in range(20_000)
        ),
        "a long type": schema(1, FRAME.encode() + b"\nuint8 x" * 100_000)
        + b"".join(channel(1, 1, b"/can%d" % (number % 2)) for number in range(50_000)),
        "no type": b"".join(channel(number, 9, b"/can") for number in range(60_000))
        + b"".join(schema(9, b"uint8 x%d" % number) for number in range(20_000)),
        "no type, by turns": b"".join(
            message(1, one) + channel(2, 9, b"/can%d" % (number % 2)) for number in range(50_000)
        ),
    }
    for name, body in many.items():
        session = _core.Session(SessionOptions(lang="en", format="info"))
        session.begin("capture.mcap", True, "mcap")
        began = time.process_time()
        session.feed(whole(body))
        session.end()
        session.finish()
        assert time.process_time() - began < 5, name


def test_the_summary_holds_no_frames() -> None:
    """A record of the summary becomes one of the data by a changed byte: no frame is made of it, and it is reported."""
    parts = (schema(1), channel(1, 1, b"/can"), *(message(1, frame) for frame in FRAMES[:20]))
    stray = message(1, FRAMES[30])
    whole_chunk = chunk(message(1, FRAMES[30]), FRAMES[30:31])
    sound, nothing, topics = read(whole(*parts, end=record(14, bytes(17))))
    assert not nothing and sum(sound.values()) == 20 and topics == {"/can": 20}
    for end in (stray, whole_chunk):
        found, damages, topics = read(whole(*parts, end=end))
        assert found == sound and topics == {"/can": 20}
        assert [damage["kind"] for damage in damages] == ["structure"]
    twice, nothing, _ = read(whole(*parts) + whole(*parts))
    assert sum(twice.values()) == 40 and not nothing, "a file behind another has data again"


@pytest.mark.parametrize("size", [7, 1 << 20])
def test_the_check_sum_over_the_data(size: int) -> None:
    """It is asked where nothing else shows damage; and a record that takes in the end of the data is reported."""
    head = MAGIC + record(HEADER, counted(b"ros2") + counted(b"test"))
    data = head + schema(1) + channel(1, 1, b"/can") + b"".join(message(1, frame) for frame in FRAMES[:20])
    end = record(FOOTER, bytes(20)) + MAGIC
    crc = record(DATA_END, struct.pack("<I", zlib.crc32(data)))
    assert read(data + crc + end, size=size)[1] == []
    for place in range(len(head), len(data)):
        changed = bytearray(data)
        changed[place] ^= 1
        found, damages, _ = read(bytes(changed) + crc + end, size=size)
        assert damages, place
        if [damage["kind"] for damage in damages] == ["unlocated"]:
            assert damages[0]["frames"] == sum(found.values())
    for taken_in, rest in ((data + crc, end), (data + crc + end[: -len(MAGIC)], MAGIC)):
        length = len(taken_in) - len(MAGIC) - 9
        swallowed = MAGIC + bytes([HEADER]) + struct.pack("<Q", length) + taken_in[len(MAGIC) + 9 :]
        found, damages, _ = read(swallowed + rest, size=size)
        assert not found and [damage["kind"] for damage in damages] == ["structure"]


def test_many_damages_are_named_up_to_a_number(canalyze: Runner, tmp_path: Path) -> None:
    chunks = [chunk(message(1, frame), [frame], sound=number % 2 == 0) for number, frame in enumerate(FRAMES[:200])]
    (tmp_path / "many.mcap").write_bytes(whole(schema(1), channel(1, 1, b"/can"), *chunks))
    done = canalyze("--lang", "en", "decode", "many.mcap")
    assert len([line for line in done.complaints if "CAP004" in line]) == 5
    assert done.complaints[-1] == "many.mcap: 100 damaged places in total"
    assert json.loads(canalyze("info", "--format", "jsonl", "many.mcap").out)["damages"] == 100


mcap = pytest.importorskip("mcap.reader")

UNFINISHED = "".join(f"({1700000000 + no / 1000:.6f}) can0 185#{no:04X}\n" for no in range(500))


@pytest.fixture
def unfinished(canalyze: Runner, tmp_path: Path) -> Path:
    """As `sniff --record` leaves it: whole chunks, no footer."""
    (tmp_path / "x.log").write_text(UNFINISHED)
    assert canalyze("convert", "x.log", "whole.mcap").code == 0
    whole = (tmp_path / "whole.mcap").read_bytes()
    (tmp_path / "x.mcap").write_bytes(whole[: len(whole) * 9 // 10])
    return tmp_path / "x.mcap"


def messages(path: Path) -> int:
    with path.open("rb") as file:
        return sum(1 for _ in mcap.make_reader(file).iter_messages())


def test_info_says_how_it_is_made_whole(unfinished: Path, canalyze: Runner, tmp_path: Path) -> None:
    with pytest.raises(Exception):  # noqa: B017 - mcap raises several kinds
        messages(unfinished)
    done = canalyze("--lang", "en", "info", "x.mcap")
    assert "canalyze convert x.mcap NEW.mcap writes a whole one" in done.out
    assert "canalyze convert x.mcap 新文件.mcap" in canalyze("--lang", "zh", "info", "x.mcap").out
    assert "NEW.mcap" not in canalyze("--lang", "en", "info", "whole.mcap").out
    assert canalyze("convert", "x.mcap", "y.mcap").code in (0, 1)
    lines = canalyze("decode", "x.mcap").lines
    there = sum("185" in line for line in lines if not line.startswith("#"))
    assert messages(tmp_path / "y.mcap") == there > 0


def test_a_recording_of_the_same_name_says_it(unfinished: Path, tmp_path: Path) -> None:
    with pytest.raises(OutputError) as error:
        Recording(str(unfinished), Words("en"))
    assert error.value.key == "record.unfinished"
    with pytest.raises(OutputError) as error:
        Recording(str(tmp_path / "whole.mcap"), Words("en"))
    assert error.value.key == "output.exists"
