"""The MCAP reader: files of other people's writers, read back frame by frame, and every kind of damage.

What it must not do: look at the wording of findings; what they count is computed from the file that was damaged.
"""

from __future__ import annotations

import json
import random
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import mcap_files as files
import pytest
import ros_messages
from captures import SAMPLES, SHARED, Analysis, CanFrame, read_log, sort_rows
from mcap.writer import CompressionType, IndexType
from mcap_files import Message, cdr, classic, header, raw, records

from canalyze import _core
from canalyze.running.reading import SessionOptions

PACKINGS = (CompressionType.NONE, CompressionType.ZSTD, CompressionType.LZ4)


def say(data: bytes, *, size: int = 1 << 20, **settings: Any) -> tuple[Analysis, dict[str, Any]]:
    """What the program says about a file that comes in pieces of this size, and what it knows of it."""
    session = _core.Session(SessionOptions(lang="en", format="jsonl", **settings))
    session.begin("capture.mcap", True, "mcap")
    out = [session.feed(data[at : at + size]) for at in range(0, len(data), size)]
    out += [session.end(), session.finish()]
    contents: dict[str, Any] = json.loads(session.contents())
    return sort_rows(b"".join(out)), contents


def taken(said: Analysis) -> list[CanFrame]:
    """The frames that were read, as they were written."""
    frames = []
    for row in said.frames:
        seconds, fraction = row["t"].split(".")
        t_us = int(seconds) * 10**6 + int(fraction[:6])
        data = bytes.fromhex(row["data"])
        frames.append(CanFrame(row["bus"], int(row["id"], 16), data, t_us, row["ext"], row["rtr"]))
    return frames


def sample(name: str) -> list[CanFrame]:
    return read_log((SAMPLES / f"{name}.log").read_bytes())


def numbered(count: int, *, step_us: int = 125) -> list[CanFrame]:
    """Frames that differ, none of them of CANopen's SDO."""
    return [
        CanFrame(
            "can0",
            0x180 + number % 32,
            struct.pack("<Q", number * 0x9E3779B97F4A7C15 % 2**64),
            10**15 + number * step_us,
        )
        for number in range(count)
    ]


def as_raw(frames: list[CanFrame], **options: Any) -> bytes:
    return raw([(f"/{frame.bus}/from_can_bus", frame.t_us * 1000, cdr(frame)) for frame in frames], **options)


@pytest.mark.parametrize("packing", PACKINGS)
@pytest.mark.parametrize("name", ["lss-fastscan", "two-nodes-interleaved", "sdo-block", "string-100-bytes"])
def test_samples_written_by_mcap_ros2(name: str, packing: CompressionType) -> None:
    frames = sample(name)
    said, contents = say(files.ros2(map(classic, frames), compression=packing))
    assert taken(said) == frames
    assert {row["dir"] for row in said.frames} == {"rx"}
    assert contents["dialect"]["compression"] == {"": "none"}.get(packing.name.lower(), packing.name.lower())
    for topic in contents["topics"]:
        assert topic["schema"] == "can_msgs/msg/Frame" and topic["encoding"] == "ros2msg/cdr"
        assert topic["messages"] == sum(f"/{frame.bus}/from_can_bus" == topic["name"] for frame in frames)
        assert topic["name"] == f"/{topic['bus']}/from_can_bus"
        assert topic["read_as"] == (
            "id=id ext=is_extended rtr=is_rtr err=is_error len=dlc data=data stamp=header.stamp"
        )


def test_every_form_of_container_gives_the_same() -> None:
    frames = numbered(3000)
    whole = taken(say(as_raw(frames))[0])
    assert whole == frames
    variants: tuple[dict[str, Any], ...] = (
        *({"compression": packing} for packing in PACKINGS),
        {"use_chunking": False},
        {"chunk_size": 1},
        {"chunk_size": 1 << 30},
        {"index_types": IndexType.NONE},
        {"enable_crcs": False},
        {"enable_data_crcs": True},
        {"use_statistics": False, "use_summary_offsets": False, "repeat_channels": False, "repeat_schemas": False},
    )
    for options in variants:
        said, _ = say(as_raw(frames, **options))
        assert taken(said) == frames, options
        assert said.findings == [], options


def test_any_pieces() -> None:
    frames = numbered(200)
    for options in ({"use_chunking": False}, {"chunk_size": 2000}):
        data = as_raw(frames, **options)
        assert [taken(say(data, size=size)[0]) for size in (1, 7, 1000)] == [frames] * 3


def test_big_endian_and_odd_texts() -> None:
    frames = numbered(8)
    for frame_id in (b"", b"\0", b"a\0", b"can0\0", b"x" * 1000 + b"\0"):
        for big in (False, True):
            messages = [("/can0/from_can_bus", f.t_us * 1000, cdr(f, big=big, frame_id=frame_id)) for f in frames]
            assert taken(say(raw(messages))[0]) == frames


def test_ros1() -> None:
    frames = sample("two-nodes-interleaved")
    said, contents = say(files.ros1(frames))
    assert taken(said) == frames
    assert contents["dialect"]["profile"] == "ros1"


def test_fd_frames() -> None:
    lengths = (0, 1, 8, 12, 16, 20, 24, 32, 48, 64)
    messages = [
        Message(
            "/can0/to_can_bus_fd",
            "ros2_socketcan_msgs/msg/FdFrame",
            ros_messages.FD_FRAME,
            {
                "header": header(10**18 + length),
                "id": 0x100 + length,
                "is_extended": length % 3 == 0,
                "is_error": False,
                "len": length,
                "data": list(range(length)),
            },
            10**18 + length,
        )
        for length in lengths
    ]
    said, contents = say(files.ros2(messages))
    assert [row["len"] for row in said.frames] == list(lengths)
    assert [row["ext"] for row in said.frames] == [length % 3 == 0 for length in lengths]
    assert all(row["fd"] == {"brs": False, "esi": False} for row in said.frames)
    assert {(row["bus"], row["dir"]) for row in said.frames} == {("can0", "tx")}
    assert [bytes.fromhex(row["data"]) for row in said.frames] == [bytes(range(length)) for length in lengths]
    assert "len=len" in contents["topics"][0]["read_as"]


def test_dataspeed() -> None:
    def message(number: int, schema: str, definition: str, **fields: Any) -> Message:
        t_ns = 10**18 + number
        name = f"dataspeed_can_msgs/msg/{schema}"
        return Message("/can_bus_dbw/can_rx", name, definition, {"header": header(t_ns), **fields}, t_ns)

    flags = {"extended": False, "fdf": True, "brs": True, "esi": False, "rtr": False}
    frame = message(0, "Frame", ros_messages.DATASPEED, id=0x181, **flags, data=list(range(12)))
    padded = message(1, "Frame16", ros_messages.DATASPEED_16, id=0x182, **flags, size=12, data=list(range(16)))
    small = message(2, "Frame16", ros_messages.DATASPEED_16, id=0x183, **{**flags, "fdf": False}, size=2, data=[7] * 16)
    nested = {"data": [1, 2, 3, 4, 5, 6, 7, 8], "id": 0x18FF1234, "extended": True, "dlc": 3}
    stamped = message(3, "CanMessageStamped", ros_messages.STAMPED, msg=nested)
    remote = message(4, "Frame", ros_messages.DATASPEED, id=0x701, **{**flags, "fdf": False, "rtr": True}, data=[])
    messages = [frame, padded, small, stamped, remote]
    messages = [replace(one, topic=f"/{number}/can_rx") for number, one in enumerate(messages)]
    said, contents = say(files.ros2(messages))
    fd = {"brs": True, "esi": False}
    assert [(row["bus"], row["id"], row["fd"], row["rtr"], row["len"]) for row in said.frames] == [
        ("0", "181", fd, False, 12),
        ("1", "182", fd, False, 12),
        ("2", "183", False, False, 2),
        ("3", "18FF1234", False, False, 3),
        ("4", "701", False, True, 0),
    ]
    assert contents["topics"][3]["read_as"] == "id=msg.id ext=msg.extended len=msg.dlc data=msg.data stamp=header.stamp"


def test_a_known_name_with_other_fields_is_read_by_its_fields() -> None:
    definition = ros_messages.FRAME.replace("uint8 dlc\nuint8[8] data", "uint8[8] data\nuint8 dlc").replace(
        "uint32 id", "string why\nuint32 id"
    )
    frames = numbered(5)
    messages = [classic(frame) for frame in frames]
    messages = [replace(one, definition=definition, fields={**one.fields, "why": "abc"}) for one in messages]
    said, _ = say(files.ros2(messages))
    assert taken(said) == frames


def test_flags_in_the_identifier_and_lengths_above_eight() -> None:
    def message(number: int, **fields: Any) -> Message:
        one = classic(CanFrame("can0", 0x123, bytes(8), 10**15 + number))
        return replace(one, fields={**one.fields, **fields})

    said, _ = say(
        files.ros2(
            [
                message(0, id=0x80000123),
                message(1, id=0x40000123, dlc=4),
                message(2, id=0x20000004),
                message(3, dlc=12),
                message(4, dlc=200),
                message(5, is_error=True, id=0x40),
            ]
        )
    )
    shown = [(row["id"], row["ext"], row["rtr"], row["err"], row["len"]) for row in said.frames]
    assert shown == [
        ("00000123", True, False, False, 8),
        ("123", False, True, False, 4),
        ("00000004", False, False, True, 8),
        ("123", False, False, False, 8),
        ("00000040", False, False, True, 8),
    ]
    assert [row["code"] for row in said.findings] == ["CAP001", "BUS001", "BUS007"]


def test_unsorted_messages_and_overlapping_chunks_come_in_order() -> None:
    frames = numbered(4000)
    shuffled = list(frames)
    for number in range(0, len(shuffled) - 40, 40):
        part = shuffled[number : number + 40]
        random.Random(number).shuffle(part)
        shuffled[number : number + 40] = part
    for options in ({}, {"use_chunking": False}):
        assert taken(say(as_raw(shuffled, **options))[0]) == frames


def test_buses_of_one_file() -> None:
    frames = numbered(400)
    messages = []
    for number, frame in enumerate(frames):
        topic = ("/can0/from_can_bus", "/can0/to_can_bus", "/ns/can1/from_can_bus", "/plain")[number % 4]
        messages.append((topic, frame.t_us * 1000, cdr(frame)))
    said, contents = say(raw(messages))
    expected = [("can0", "rx"), ("can0", "tx"), ("ns/can1", "rx"), ("plain", None)] * 100
    assert [(row["bus"], row["dir"]) for row in said.frames] == expected
    assert [topic["messages"] for topic in contents["topics"]] == [100] * 4
    chosen, contents = say(raw(messages), topics=["/can0/*"])
    assert len(chosen.frames) == 200
    assert [bool(topic["read_as"]) for topic in contents["topics"]] == [True, True, False, False]
    assert len(say(raw(messages), topics=["/pl*", "/ns/*"])[0].frames) == 200


def recorded(frames: list[CanFrame], *, echoes: bool) -> bytes:
    """As rosbag2 records a master on `ros2_socketcan`: its frames as they were asked for, and perhaps as heard."""
    messages = []
    for frame in frames:
        t_ns = frame.t_us * 1000
        own = frame.can_id in (0, 0x80) or 0x600 <= frame.can_id < 0x680
        if own:
            asked = cdr(replace(frame, t_us=frame.t_us - 300))
            messages.append(("/can0/to_can_bus", t_ns - 200_000, asked))
        if echoes or not own:
            messages.append(("/can0/from_can_bus", t_ns + 50_000, cdr(frame)))
    return raw(messages, chunk_size=1 << 14)


@pytest.mark.parametrize("name", ["sdo-block", "string-100-bytes", "two-nodes-interleaved"])
def test_echoes_of_a_master(name: str) -> None:
    frames = [replace(frame, bus="can0") for frame in sample(name)]
    alone, _ = say(as_raw(frames))
    for size in (1 << 20, 700):
        heard, contents = say(recorded(frames, echoes=True), size=size)
        own = [row for row in heard.frames if row["dir"] == "tx"]
        assert taken(heard) == frames
        assert contents["passed_over"] == [{"kind": "Echo", "count": len(own)}]
        assert [row["code"] for row in heard.findings] == [row["code"] for row in alone.findings]
        # Nothing is missing of a driver that does not hear itself, and nothing is passed over.
        deaf, contents = say(recorded(frames, echoes=False), size=size)
        assert len(deaf.frames) == len(frames)
        assert contents["passed_over"] == []


def test_our_own_files_have_no_echoes() -> None:
    frames = [CanFrame("can0", 0x601, b"\x40\x08\x10" + bytes(5), 10**9 + number * 500) for number in range(200)]
    log = "".join(
        f"({frame.t_us // 10**6}.{frame.t_us % 10**6:06}) can0 601#{frame.data.hex()} {'TR'[number % 2]}\n"
        for number, frame in enumerate(frames)
    )
    session = _core.Session(SessionOptions(format="convert", to="mcap"))
    session.begin("x.log", True, "candump")
    made = session.feed(log.encode()) + session.end() + session.finish()
    assert taken(say(made)[0]) == frames


def test_clocks() -> None:
    base = 1_700_000_000 * 10**9

    def read(stamps: list[int], source: str | None) -> list[int]:
        messages = []
        for number, stamp in enumerate(stamps):
            one = classic(CanFrame("can0", 0x181, b"\1", 0))
            log = base + number * 10**9
            messages.append(
                replace(one, fields={**one.fields, "header": header(stamp)}, log_ns=log + 2, publish_ns=log + 1)
            )
        said, _ = say(files.ros2(messages), time_source=source)
        return [int(row["t"].replace(".", "")) - base for row in said.frames]

    second = 10**9
    stamps = [base, base + second, 0, base + 3 * second]
    assert read(stamps, None) == [0, second, 2 * second + 1, 3 * second + 1]
    assert read(stamps, "stamp") == [0, second, 2 * second + 1, 3 * second]
    assert read(stamps, "publish") == [1, second + 1, 2 * second + 1, 3 * second + 1]
    assert read(stamps, "log") == [2, second + 2, 2 * second + 2, 3 * second + 2]
    since_boot = [5 * second, 6 * second]
    assert read(since_boot, None) == [1, second + 1]


OWN = """uint64 timestamp
uint16 can_id
string<=8 note
uint8[] payload
"""


def own_message(number: int) -> tuple[str, int, bytes]:
    data = bytes(range(number % 9))
    body = struct.pack("<QH", 0, 0x180 + number) + bytes(2) + struct.pack("<I", 3) + b"no\0"
    body += bytes(-len(body) % 4) + struct.pack("<I", len(data)) + data
    return ("/x", 10**18 + number, b"\0\1\0\0" + body)


def test_fields_by_the_users_word() -> None:
    messages = [own_message(number) for number in range(20)]
    file = raw(messages, schema="my_msgs/msg/Thing", definition=OWN)
    said, contents = say(file)
    assert said.frames == [] and contents["topics"][0]["read_as"] == ""
    said, contents = say(file, mcap_maps=["topic=/x,id=can_id,data=payload"])
    assert [(row["id"], row["len"]) for row in said.frames] == [(f"{0x180 + n:03X}", n % 9) for n in range(20)]
    assert contents["topics"][0]["read_as"] == "id=can_id data=payload"
    for fields in (
        "topic=/y,id=can_id,data=payload",
        "id=can_id",
        "id=payload,data=payload",
        "id=can_id,data=payload,len=no",
    ):
        assert say(file, mcap_maps=[fields])[0].frames == [], fields


def test_fields_inside_of_fields_by_the_users_word() -> None:
    frame = CanFrame("x", 0x123, bytes(range(8)), 10**15)
    one = classic(frame, "/x")
    definition = "Inner inner\nstd_msgs/Header top\n" + "=" * 80 + "\nMSG: my_msgs/Inner\n" + ros_messages.FRAME
    nested = replace(
        one, schema="my_msgs/msg/Outer", definition=definition, fields={"inner": one.fields, "top": header(2 * 10**18)}
    )
    fields = "id=inner.id,data=inner.data,len=inner.dlc,stamp="
    for stamp, t_ns in (("inner.header.stamp", 10**18), ("top.stamp", 2 * 10**18)):
        said, _ = say(files.ros2([nested]), mcap_maps=[fields + stamp], time_source="stamp")
        assert taken(said) == [replace(frame, t_us=t_ns // 1000)]
    # A single field replaces that of a known type.
    definition = ros_messages.FRAME.replace("dlc", "size")
    one = replace(one, definition=definition, fields={**one.fields, "size": 3})
    assert say(files.ros2([one]))[0].frames == []
    (row,) = say(files.ros2([one]), mcap_maps=["len=size"])[0].frames
    assert row["len"] == 3


def test_a_type_that_is_not_known_is_not_read() -> None:
    for definition in ("uint32 id\nuint8[] data\n", ros_messages.FRAME, "", "junk"):
        said, contents = say(raw([("/x", 1, bytes(40))], schema="a_msgs/msg/B", definition=definition))
        assert said.frames == said.findings == [] and contents["topics"][0]["read_as"] == "", definition
    for languages in (("protobuf", "protobuf"), ("jsonschema", "json"), ("flatbuffer", "flatbuffer")):
        said, contents = say(raw([("/x", 1, bytes(40))], schema="CanFrame", definition="", languages=languages))
        assert said.frames == said.findings == [] and contents["topics"][0]["read_as"] == ""


# Damage. The file has chunks of about 250 frames; every expectation is computed from it.

FRAMES = numbered(2000)
ZSTD = as_raw(FRAMES)
PLAIN = as_raw(FRAMES, compression=CompressionType.NONE)
LZ4 = as_raw(FRAMES, compression=CompressionType.LZ4)
CHUNK, INDEX, DATA_END = 0x06, 0x07, 0x0F


def chunks(file: bytes) -> list[tuple[int, int, int]]:
    """Offset, length and number of frames of every chunk."""
    found = records(file)
    sizes = [struct.unpack_from("<I", file, at + 11)[0] // 16 for at, op, _ in found if op == INDEX]
    places = [(at, size) for at, op, size in found if op == CHUNK]
    return [(at, size, count) for (at, size), count in zip(places, sizes, strict=True)]


def flip(file: bytes, at: int, bit: int = 0) -> bytes:
    return file[:at] + bytes([file[at] ^ 1 << bit]) + file[at + 1 :]


def without(frames: list[CanFrame], first: int, count: int) -> list[CanFrame]:
    return frames[:first] + frames[first + count :]


def damages(said: Analysis) -> list[tuple[str, dict[str, Any]]]:
    return [(row["code"], row["facts"]) for row in said.findings if row["code"].startswith("CAP")]


def middle(file: bytes) -> tuple[int, int, int, int]:
    """Offset, length, frames of a chunk, and the frames before it."""
    all_chunks = chunks(file)
    number = len(all_chunks) // 2
    return (*all_chunks[number], sum(count for _, _, count in all_chunks[:number]))


@pytest.mark.parametrize("file", [ZSTD, PLAIN, LZ4], ids=["zstd", "none", "lz4"])
def test_cut_in_the_middle_of_a_chunk(file: bytes) -> None:
    at, size, count, before = middle(file)
    for part in (0.1, 0.5, 0.97):
        end = at + int(size * part)
        said, _ = say(file[:end])
        assert taken(said) == FRAMES[: len(said.frames)]
        assert before <= len(said.frames) < before + count
        assert damages(said) == [("CAP005", {"offset": at, "bytes": end - at})]
    if file is PLAIN:  # the others give whole blocks only, and these chunks are of one
        assert len(said.frames) > before + count * 0.8


def test_the_beginning_of_a_cut_chunk_is_read_as_far_as_it_goes() -> None:
    noise = random.Random(1)
    frames = [replace(frame, data=noise.randbytes(8)) for frame in numbered(20000)]
    for packing in PACKINGS:
        file = as_raw(frames, compression=packing, chunk_size=1 << 24)
        ((at, size, count),) = chunks(file)
        assert count == 20000
        said, _ = say(file[: at + size * 6 // 10])
        assert taken(said) == frames[: len(said.frames)]
        assert len(said.frames) > 10000, packing


@pytest.mark.parametrize("file", [ZSTD, PLAIN, LZ4], ids=["zstd", "none", "lz4"])
def test_zeros_where_the_rest_of_the_file_should_be(file: bytes) -> None:
    at, size, count, before = middle(file)
    end = at + size // 2
    for zeros in (100, 4096):
        said, _ = say(file[:end] + bytes(zeros))
        assert taken(said) == FRAMES[: len(said.frames)]
        assert before <= len(said.frames) < before + count
        assert {code for code, _ in damages(said)} <= {"CAP004", "CAP005"} and damages(said)


def test_the_end_is_missing() -> None:
    (end,) = (at for at, op, _ in records(ZSTD) if op == DATA_END)
    for cut in (end, end + 13, len(ZSTD) - 8):
        said, _ = say(ZSTD[:cut])
        assert taken(said) == FRAMES
        assert [code for code, _ in damages(said)] == ["CAP005"]
    said, _ = say(ZSTD[: len(ZSTD) - 3])
    assert taken(said) == FRAMES and [code for code, _ in damages(said)] == ["CAP005"]


def test_zeros_after_the_end_are_no_damage() -> None:
    for zeros in (1, 7, 4096, 100_000):
        said, _ = say(ZSTD + bytes(zeros))
        assert taken(said) == FRAMES and said.findings == []
    said, _ = say(ZSTD + b"rubbish at the end of the file")
    assert taken(said) == FRAMES
    assert [code for code, _ in damages(said)] == ["CAP004"]


@pytest.mark.parametrize("file", [ZSTD, PLAIN, LZ4], ids=["zstd", "none", "lz4"])
def test_a_flipped_bit_in_a_chunk_costs_that_chunk_alone(file: bytes) -> None:
    at, size, count, before = middle(file)
    for part in (0.2, 0.4, 0.6, 0.8, 0.99):
        said, _ = say(flip(file, at + int(size * part), 3))
        assert taken(said) == without(FRAMES, before, count)
        assert damages(said) == [("CAP004", {"offset": at, "bytes": size, "frames": count})]


def test_a_flipped_bit_in_the_first_chunk_loses_its_definitions() -> None:
    for options in ({}, {"repeat_channels": False, "repeat_schemas": False}):
        file = as_raw(FRAMES, **options)
        at, size, count = chunks(file)[0]
        said, _ = say(flip(file, at + size - 20, 3))
        assert taken(said) == [] and damages(said)[0][1]["offset"] == at
        assert [facts.get("frames") for _, facts in damages(said)] == [None, len(FRAMES) - count, count]


def test_frames_of_a_lost_chunk_are_counted_at_the_end_without_its_index() -> None:
    file = as_raw(FRAMES, index_types=IndexType.NONE)
    at, size = [(at, size) for at, op, size in records(file) if op == CHUNK][3]
    said, _ = say(flip(file, at + size // 2, 3))
    lost = len(FRAMES) - len(said.frames)
    assert damages(said) == [("CAP004", {"offset": at, "bytes": size}), ("CAP004", {"offset": 0, "frames": lost})]
    assert lost > 0


def test_a_flipped_bit_in_a_length_inside_of_a_chunk() -> None:
    at, size, count, before = middle(PLAIN)
    inside = at + 9 + 8 + 8 + 8 + 4 + 4 + 8
    for byte in range(1, 9):
        said, _ = say(flip(PLAIN, inside + byte, 4))
        assert taken(said) == without(FRAMES, before, count)
        assert damages(said) == [("CAP004", {"offset": at, "bytes": size, "frames": count})]


@pytest.mark.parametrize("file", [ZSTD, PLAIN, LZ4], ids=["zstd", "none", "lz4"])
def test_a_flipped_bit_in_the_length_of_a_chunk_costs_nothing(file: bytes) -> None:
    at, _, _, _ = middle(file)
    for byte in range(1, 9):
        for bit in (0, 3, 7):
            said, _ = say(flip(file, at + byte, bit))
            assert taken(said) == FRAMES, (byte, bit)
            assert damages(said) == [("CAP004", {"offset": at, "bytes": 8, "frames": 0})]


def test_a_flipped_bit_in_the_head_of_a_chunk() -> None:
    at, _, count, before = middle(ZSTD)
    for byte in range(9, 9 + 44):
        said, _ = say(flip(ZSTD, at + byte, 5))
        frames = taken(said)
        # Times of the head are not covered by the check sum, and only used for sorting.
        assert frames in (FRAMES, without(FRAMES, before, count)), byte
        assert (frames == FRAMES) == (byte < 25) or byte >= 45, byte


def test_a_flipped_bit_in_the_length_of_an_index_costs_no_frame() -> None:
    found = [at for at, op, _ in records(ZSTD) if op == INDEX]
    for byte in (1, 2, 3, 5, 8, 11, 12, 13, 14):
        said, _ = say(flip(ZSTD, found[4] + byte, 2))
        assert taken(said) == FRAMES
        assert [code for code, _ in damages(said)] == ["CAP004"]


def test_a_flipped_bit_in_a_length_outside_of_chunks() -> None:
    file = as_raw(FRAMES, use_chunking=False)
    at = [at for at, op, _ in records(file) if op == 0x05][1000]
    for byte in range(1, 9):
        said, _ = say(flip(file, at + byte, 6))
        frames = taken(said)
        assert frames[:1000] == FRAMES[:1000] and frames[-1] == FRAMES[-1]
        lost = len(FRAMES) - len(frames)
        assert lost <= 400 if byte == 2 else lost == 1, (byte, lost)
        assert "CAP004" in {code for code, _ in damages(said)}


def test_any_flipped_bit_and_any_cut_leaves_frames_that_were_there() -> None:
    chance = random.Random(5)
    frames = numbered(300)
    known = set(frames)
    for options in ({"chunk_size": 3000}, {"chunk_size": 3000, "compression": CompressionType.LZ4}):
        file = as_raw(frames, **options)
        first = chunks(file)[1][0]
        for _ in range(400):
            damaged = flip(file, chance.randrange(first, len(file)), chance.randrange(8))
            damaged = damaged[: chance.randrange(first, len(file))] if chance.random() < 0.3 else damaged
            assert set(taken(say(damaged)[0])) <= known


def test_two_files_one_after_the_other() -> None:
    frames = numbered(600)
    said, _ = say(as_raw(frames[:300]) + as_raw(frames[300:]))
    assert taken(said) == frames and said.findings == []


def test_a_chunk_that_unpacks_to_more_than_it_may() -> None:
    """A bomb: the memory it claims is not taken, and the rest of the file is read."""
    import zstandard

    packed = zstandard.ZstdCompressor().compress(bytes(300 << 20))
    body = struct.pack("<QQQII", 0, 1, 300 << 20, 0, 4) + b"zstd" + struct.pack("<Q", len(packed)) + packed
    bomb = struct.pack("<BQ", CHUNK, len(body)) + body
    at, _, _, _ = middle(ZSTD)
    said, _ = say(ZSTD[:at] + bomb + ZSTD[at:])
    assert taken(said) == FRAMES
    assert [code for code, _ in damages(said)] == ["CAP004"]


# The command line.


def canalyze(*arguments: str | Path, data: bytes | None = None) -> subprocess.CompletedProcess[bytes]:
    command = [sys.executable, "-m", "canalyze", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, check=False, input=data)


def test_from_standard_input(tmp_path: Path) -> None:
    frames = sample("two-nodes-interleaved")
    file = tmp_path / "x.mcap"
    file.write_bytes(files.ros2(map(classic, frames)))
    one = canalyze("decode", file)
    other = canalyze("decode", "-", data=file.read_bytes())
    assert one.returncode == other.returncode == 0
    assert one.stdout == other.stdout and one.stdout.count(b"\n") >= len(frames)
    assert canalyze("decode", "-", data=one.stdout).stdout == one.stdout, "text output is input again"


CORPUS = SHARED / "corpus" / "mcap"
KNOWN = {
    "cdr_test_0.mcap": {"/test_topic": 3, "/array_topic": 4},
    "talker.mcap": {"/rosout": 10, "/topic": 10},
    "topics_and_services.mcap": {"/parameter_events": 7, "/add_two_ints/_service_event": 6},
}


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus lies elsewhere")
@pytest.mark.parametrize("name", KNOWN)
def test_recordings_without_can(name: str) -> None:
    said, contents = say((CORPUS / name).read_bytes())
    assert said.frames == said.findings == []
    assert {topic["name"]: topic["messages"] for topic in contents["topics"] if topic["messages"]} == KNOWN[name]
    assert not any(topic["read_as"] for topic in contents["topics"])
    for lang in ("zh", "en"):
        done = canalyze("decode", CORPUS / name, "--lang", lang)
        lines = done.stderr.decode().splitlines()
        assert done.returncode == 2 and done.stdout == b"" and len(lines) == 1
        assert all(topic in lines[0] for topic in KNOWN[name]) and "--mcap-map" in lines[0] and "--topic" in lines[0]


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_mistakes_in_options(lang: str) -> None:
    for option, value in (("--mcap-map", "ident=x"), ("--mcap-map", ""), ("--time-source", "wall")):
        done = canalyze("decode", option, value, "--lang", lang, data=b"")
        assert done.returncode == 2 and option in done.stderr.decode(), done.stderr
        assert len(done.stderr.splitlines()) == 1
