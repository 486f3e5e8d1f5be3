"""Capture files as other people's programs write them: log2asc, python-can, mcap, Wireshark.

Why it exists: a reader that is only shown what its own author wrote agrees with its author. What it must not do: use
anything of canalyze, or decide what a format may lose (the suite's classes do). pcap frames are packed here by hand, by
the layout that libpcap documents (LINKTYPE_CAN_SOCKETCAN, LINKTYPE_LINUX_SLL, LINKTYPE_LINUX_SLL2), and turned into
pcapng by Wireshark's editcap.
"""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import can
import pytest
from capture_frames import Recorded, candump_text
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as Ros2Writer
from ros_messages import DATASPEED, FD_FRAME, FRAME

Write = Callable[[Iterable[Recorded], Path], None]


def program(name: str) -> str:
    """The program of that name; the test is skipped where it is missing, unless nothing may be missing."""
    found = shutil.which(name)
    if found is None:
        if os.environ.get("CANALYZE_TOOLS") == "required":
            pytest.fail(f"{name} is missing, and CANALYZE_TOOLS=required")
        pytest.skip(f"{name} is not installed")
    return found


def run_program(name: str, *arguments: str | Path, stdin: bytes | None = None) -> bytes:
    """Standard output of another program."""
    command = [program(name), *map(str, arguments)]
    done = subprocess.run(command, input=stdin, capture_output=True, check=False, env=os.environ | {"TZ": "UTC"})
    if done.returncode:
        raise AssertionError(f"{command} ended with {done.returncode}: {done.stderr.decode(errors='replace')}")
    return done.stdout


@contextmanager
def in_utc() -> Iterator[None]:
    """Local time is UTC meanwhile: formats that write civil time then name the moment itself."""
    before = os.environ.get("TZ")
    os.environ["TZ"] = "UTC"
    time.tzset()
    try:
        yield
    finally:
        if before is None:
            del os.environ["TZ"]
        else:
            os.environ["TZ"] = before
        time.tzset()


def message(frame: Recorded) -> can.Message:
    """The frame as python-can has it."""
    remote = frame.kind == "remote"
    return can.Message(
        timestamp=frame.t_ns / 1e9,
        arbitration_id=frame.can_id,
        is_extended_id=frame.extended,
        is_remote_frame=remote,
        is_error_frame=frame.kind == "error",
        is_fd=frame.kind == "fd",
        bitrate_switch=frame.brs,
        error_state_indicator=frame.esi,
        is_rx=not frame.sent,
        channel=frame.bus,
        dlc=frame.asked if remote else len(frame.data),
        data=None if remote else frame.data,
    )


def python_can(writer: Callable[..., Any], **options: Any) -> Write:
    """A writer of python-can."""

    def write(frames: Iterable[Recorded], path: Path) -> None:
        with in_utc():
            out = writer(path, **options)
            try:
                for frame in frames:
                    out.on_message_received(message(frame))
            finally:
                out.stop()

    return write


def sqlite(frames: Iterable[Recorded], path: Path) -> None:
    """python-can's database. Its writer drops what it has not written when it is told to stop: it is waited for."""
    out = can.SqliteWriter(path)
    for frame in frames:
        out.on_message_received(message(frame))
    while not out.buffer.empty():
        time.sleep(0.01)
    out.stop()


def log2asc(*options: str) -> Write:
    """can-utils' converter from candump's log form."""

    def write(frames: Iterable[Recorded], path: Path) -> None:
        # It takes what stands behind the point for µs, however many digits there are.
        frames = [replace(frame, t_ns=frame.t_ns // 1000 * 1000) for frame in frames]
        buses = sorted({frame.bus for frame in frames}) or ["can0"]
        out = run_program("log2asc", *options, *buses, stdin=candump_text(frames))
        path.write_bytes(out)

    return write


def _header(frame: Recorded) -> dict[str, Any]:
    seconds, rest = divmod(frame.t_ns, 1_000_000_000)
    return {"stamp": {"sec": seconds, "nanosec": rest}, "frame_id": "can"}


def mcap_ros2(compression: CompressionType, chunk_size: int = 1 << 20) -> Write:
    """What ros2_socketcan's topics become in a recording: can_msgs/Frame and FdFrame, by mcap-ros2-support."""

    def write(frames: Iterable[Recorded], path: Path) -> None:
        with path.open("wb") as file, Ros2Writer(file, chunk_size=chunk_size, compression=compression) as out:
            classic = out.register_msgdef("can_msgs/msg/Frame", FRAME)
            fd = out.register_msgdef("ros2_socketcan_msgs/msg/FdFrame", FD_FRAME)
            for number, frame in enumerate(frames):
                head = {"header": _header(frame), "id": frame.can_id, "is_extended": frame.extended}
                topic = f"/{frame.bus}/{'to' if frame.sent else 'from'}_can_bus"
                if frame.kind == "fd":
                    body = {"is_error": False, "len": len(frame.data), "data": list(frame.data)}
                    out.write_message(f"{topic}_fd", fd, head | body, frame.t_ns, frame.t_ns, number)
                    continue
                body = {
                    "is_rtr": frame.kind == "remote",
                    "is_error": frame.kind == "error",
                    "dlc": frame.asked if frame.kind == "remote" else len(frame.data),
                    "data": list(frame.data.ljust(8, b"\0")),
                }
                out.write_message(topic, classic, head | body, frame.t_ns, frame.t_ns, number)

    return write


def mcap_dataspeed(frames: Iterable[Recorded], path: Path) -> None:
    """A Dataspeed recording, whose frames keep the flags of CAN FD."""
    with path.open("wb") as file, Ros2Writer(file) as out:
        schema = out.register_msgdef("dataspeed_can_msgs/msg/Frame", DATASPEED)
        for number, frame in enumerate(frames):
            body = {
                "header": _header(frame),
                "id": frame.can_id,
                "extended": frame.extended,
                "fdf": frame.kind == "fd",
                "brs": frame.brs,
                "esi": frame.esi,
                "rtr": frame.kind == "remote",
                "data": list(frame.data),
            }
            topic = f"/{frame.bus}/can_{'tx' if frame.sent else 'rx'}"
            out.write_message(topic, schema, body, frame.t_ns, frame.t_ns, number)


def mcap_bare(frames: Iterable[Recorded], path: Path) -> None:
    """The same frames without chunks, check sums and an index, as a small logger may write them, packed by hand."""
    with path.open("wb") as file:
        out = McapWriter(file, use_chunking=False, enable_crcs=False, use_statistics=False)
        out.start(profile="ros2", library="tests")
        schema = out.register_schema("can_msgs/msg/Frame", "ros2msg", FRAME.encode())
        channels: dict[str, int] = {}
        for frame in frames:
            topic = f"/{frame.bus}/{'to' if frame.sent else 'from'}_can_bus"
            if topic not in channels:
                channels[topic] = out.register_channel(topic, "cdr", schema)
            seconds, rest = divmod(frame.t_ns, 1_000_000_000)
            flags = (frame.kind == "remote", frame.extended, frame.kind == "error")
            length = frame.asked if frame.kind == "remote" else len(frame.data)
            data = struct.pack(
                "<4siII4xI3?B8s", b"\0\1\0\0", seconds, rest, 1, frame.can_id, *flags, length, frame.data
            )
            out.add_message(channels[topic], frame.t_ns, data, frame.t_ns)
        out.finish()  # type: ignore[no-untyped-call]


SOCKETCAN = 227
SLL = 113
SLL2 = 276


def socketcan(frame: Recorded, order: str = ">") -> bytes:
    """A frame as LINKTYPE_CAN_SOCKETCAN has it: the identifier in network order.

    Behind a cooked header it stands in the order of the host, which is that of the file.
    """
    flags = {"remote": 0x4000_0000, "error": 0x2000_0000}.get(frame.kind, 0) | (0x8000_0000 if frame.extended else 0)
    length = frame.asked if frame.kind == "remote" else len(frame.data)
    if frame.kind == "fd":
        fd_flags = frame.brs | frame.esi << 1 | 4
        return struct.pack(f"{order}IBBxx64s", frame.can_id | flags, length, fd_flags, frame.data)
    return struct.pack(f"{order}IBxxx8s", frame.can_id | flags, length, frame.data)


def _cooked(frame: Recorded, order: str) -> bytes:
    protocol = 0x000D if frame.kind == "fd" else 0x000C
    return struct.pack(">HHH8sH", 4 if frame.sent else 0, 280, 0, b"", protocol) + socketcan(frame, order)


def _cooked2(frame: Recorded, order: str) -> bytes:
    interface = int(frame.bus.removeprefix("can") if frame.bus.startswith("can") else 0) + 1
    protocol = 0x000D if frame.kind == "fd" else 0x000C
    return struct.pack(">HHIHBB8s", protocol, 0, interface, 280, 4 if frame.sent else 0, 0, b"") + socketcan(
        frame, order
    )


_PACKERS: dict[int, Callable[[Recorded, str], bytes]] = {
    SOCKETCAN: lambda frame, _: socketcan(frame),
    SLL: _cooked,
    SLL2: _cooked2,
}


def pcap(link: int = SOCKETCAN, *, order: str = "<", nanoseconds: bool = False) -> Write:
    """The old format, in one byte order, with stamps in µs or ns."""

    def write(frames: Iterable[Recorded], path: Path) -> None:
        magic = 0xA1B2_3C4D if nanoseconds else 0xA1B2_C3D4
        parts = [struct.pack(f"{order}IHHiIII", magic, 2, 4, 0, 0, 262_144, link)]
        for frame in frames:
            packet = _PACKERS[link](frame, order)
            seconds, rest = divmod(frame.t_ns, 1_000_000_000)
            fraction = rest if nanoseconds else rest // 1000
            parts += [struct.pack(f"{order}IIII", seconds, fraction, len(packet), len(packet)), packet]
        path.write_bytes(b"".join(parts))

    return write


def editcap(form: str, source: Write) -> Write:
    """What editcap of Wireshark makes of such a file."""

    def write(frames: Iterable[Recorded], path: Path) -> None:
        raw = path.with_name("before-editcap.pcap")
        source(frames, raw)
        run_program("editcap", "-F", form, raw, path)
        raw.unlink()

    return write


def _block(order: str, kind: int, body: bytes) -> bytes:
    body += bytes(-len(body) % 4)
    return struct.pack(f"{order}II", kind, len(body) + 12) + body + struct.pack(f"{order}I", len(body) + 12)


def _option(order: str, code: int, value: bytes) -> bytes:
    return struct.pack(f"{order}HH", code, len(value)) + value + bytes(-len(value) % 4)


def pcapng_named(order: str = "<") -> Write:
    """An interface a bus, with its name and stamps in ns; the side of a frame in its flags: as dumpcap writes it."""

    def write(frames: Iterable[Recorded], path: Path) -> None:
        frames = list(frames)
        parts = [_block(order, 0x0A0D_0D0A, struct.pack(f"{order}IHHq", 0x1A2B_3C4D, 1, 0, -1))]
        interfaces: dict[str, int] = {}
        for bus in dict.fromkeys(frame.bus for frame in frames):
            interfaces[bus] = len(interfaces)
            named = _option(order, 2, bus.encode()) + _option(order, 9, b"\x09") + _option(order, 0, b"")
            parts.append(_block(order, 1, struct.pack(f"{order}HHI", SOCKETCAN, 0, 0) + named))
        for frame in frames:
            packet = socketcan(frame)
            fixed = struct.pack(
                f"{order}IIIII",
                interfaces[frame.bus],
                frame.t_ns >> 32,
                frame.t_ns & 0xFFFF_FFFF,
                len(packet),
                len(packet),
            )
            side = _option(order, 2, struct.pack(f"{order}I", 2 if frame.sent else 1)) + _option(order, 0, b"")
            parts.append(_block(order, 6, fixed + packet + bytes(-len(packet) % 4) + side))
        path.write_bytes(b"".join(parts))

    return write
