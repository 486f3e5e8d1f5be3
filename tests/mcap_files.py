"""MCAP files of CAN frames, written by other people's packages (`mcap`, `mcap-ros2-support`).

Why it exists: our reader must read what others write, and damage must be made where it is wanted. What it must not do:
use the program's own writer.

    python tests/mcap_files.py

writes the captures of the rules about damaged files anew.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from captures import SAMPLES, CanFrame, spaced
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as Ros2Writer
from ros_messages import FRAME, FRAME_ROS1


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a topic. Times in ns."""

    topic: str
    schema: str
    definition: str
    fields: dict[str, Any]
    log_ns: int
    publish_ns: int | None = None


def header(t_ns: int) -> dict[str, Any]:
    """A header with this stamp."""
    return {"stamp": {"sec": t_ns // 10**9, "nanosec": t_ns % 10**9}, "frame_id": "can"}


def classic(frame: CanFrame, topic: str | None = None, *, lag_ns: int = 0) -> Message:
    """A frame as ros2_socketcan publishes it."""
    t_ns = frame.t_us * 1000
    fields = {
        "header": header(t_ns),
        "id": frame.can_id,
        "is_rtr": frame.remote,
        "is_extended": frame.extended,
        "is_error": False,
        "dlc": len(frame.data),
        "data": list(frame.data.ljust(8, b"\0")),
    }
    return Message(topic or f"/{frame.bus}/from_can_bus", "can_msgs/msg/Frame", FRAME, fields, t_ns + lag_ns)


def ros2(messages: Iterable[Message], **options: Any) -> bytes:
    """A file of these messages as mcap-ros2-support writes it."""
    stream = io.BytesIO()
    options.setdefault("chunk_size", 1 << 16)
    writer = Ros2Writer(stream, **options)
    schemas: dict[str, Any] = {}
    for message in messages:
        if message.schema not in schemas:
            schemas[message.schema] = writer.register_msgdef(message.schema, message.definition)
        publish = message.log_ns if message.publish_ns is None else message.publish_ns
        writer.write_message(message.topic, schemas[message.schema], message.fields, message.log_ns, publish)
    writer.finish()  # type: ignore[no-untyped-call]
    return stream.getvalue()


def raw(
    messages: Sequence[tuple[str, int, bytes]],
    *,
    schema: str = "can_msgs/msg/Frame",
    definition: str = FRAME,
    languages: tuple[str, str] = ("ros2msg", "cdr"),
    compression: CompressionType = CompressionType.ZSTD,
    chunk_size: int = 1 << 14,
    **options: Any,
) -> bytes:
    """A file of messages (topic, time, bytes) as `mcap` writes it."""
    stream = io.BytesIO()
    writer = McapWriter(stream, compression=compression, chunk_size=chunk_size, **options)
    writer.start("ros2", "test")
    schema_id = writer.register_schema(schema, languages[0], definition.encode())
    channels: dict[str, int] = {}
    for topic, log_ns, data in messages:
        if topic not in channels:
            channels[topic] = writer.register_channel(topic, languages[1], schema_id)
        writer.add_message(channels[topic], log_ns, data, log_ns)
    writer.finish()  # type: ignore[no-untyped-call]
    return stream.getvalue()


def cdr(frame: CanFrame, *, big: bool = False, frame_id: bytes = b"can0\0") -> bytes:
    """A `can_msgs/msg/Frame`, serialised by hand after the rules of CDR."""
    order = ">" if big else "<"
    t_ns = frame.t_us * 1000
    body = struct.pack(f"{order}iII", t_ns // 10**9, t_ns % 10**9, len(frame_id)) + frame_id
    body += bytes(-len(body) % 4)
    flags = bytes([frame.remote, frame.extended, False, len(frame.data)])
    body += struct.pack(f"{order}I", frame.can_id) + flags + frame.data.ljust(8, b"\0")
    return bytes([0, 0 if big else 1, 0, 0]) + body


def ros1(frames: Iterable[CanFrame]) -> bytes:
    """A file of ROS 1 messages, serialised by hand: packed, without padding."""
    stream = io.BytesIO()
    writer = McapWriter(stream, chunk_size=1 << 14)
    writer.start("ros1", "test")
    schema = writer.register_schema("can_msgs/Frame", "ros1msg", FRAME_ROS1.encode())
    channels: dict[str, int] = {}
    for number, frame in enumerate(frames):
        topic = f"/{frame.bus}/received_messages"
        if topic not in channels:
            channels[topic] = writer.register_channel(topic, "ros1", schema)
        t_ns = frame.t_us * 1000
        data = struct.pack("<IIII", number, t_ns // 10**9, t_ns % 10**9, 4) + b"can0" + struct.pack("<I", frame.can_id)
        data += bytes([frame.remote, frame.extended, False, len(frame.data)]) + frame.data.ljust(8, b"\0")
        writer.add_message(channels[topic], t_ns, data, t_ns)
    writer.finish()  # type: ignore[no-untyped-call]
    return stream.getvalue()


def records(file: bytes) -> list[tuple[int, int, int]]:
    """The records of a whole file: offset, type, length with head."""
    found = []
    at = 8
    while file[at : at + 8] != b"\x89MCAP0\r\n":
        op, size = struct.unpack_from("<BQ", file, at)
        found.append((at, op, size + 9))
        at += size + 9
    return found


_TRANSFERS = [
    ("4008100000000000", "43081000436F7265"),
    ("4000100000000000", "4300100092010200"),
    ("2B171000E8030000", "6017100000000000"),
]


def rules() -> dict[str, bytes]:
    """The captures of CAP004 and CAP005 and their clean neighbours: SDO transfers, each in a chunk of its own."""
    frames = [CanFrame("can0", 0x705, b"\5")]
    for request, response in _TRANSFERS:
        frames += [CanFrame("can0", 0x605, bytes.fromhex(request)), CanFrame("can0", 0x585, bytes.fromhex(response))]
    frames = spaced(frames)
    messages = [("/can0/from_can_bus", frame.t_us * 1000, cdr(frame)) for frame in frames]
    whole = raw(messages, compression=CompressionType.NONE, chunk_size=100)
    chunks = [(at, size) for at, op, size in records(whole) if op == 0x06]
    at, size = chunks[2]
    flipped = bytearray(whole)
    flipped[at + size - 3] ^= 0x10
    at, size = chunks[-1]
    return {
        "CAP004.mcap": bytes(flipped),
        "CAP004.clean.mcap": whole,
        "CAP005.mcap": whole[: at + size // 2],
        "CAP005.clean.mcap": whole,
    }


if __name__ == "__main__":
    for name, data in rules().items():
        (SAMPLES / "rules" / name).write_bytes(data)
