"""SDO transfers as frames in causal order, built from values: the clean sessions that the tests displace and break.

Why it exists: the tests need transfers of any size with known values, and must not take them from the program under
test. Layouts: CiA 301 7.2.4.3. What it must not do: build anything that a correct client and server would not send.
"""

from __future__ import annotations

import binascii
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from captures import CanFrame


@dataclass(frozen=True, slots=True)
class Channel:
    """The default SDO channel of a node on a bus."""

    node: int
    bus: str = "can0"

    def client(self, payload: bytes) -> CanFrame:
        """A frame of the client: 600h + node."""
        return CanFrame(self.bus, 0x600 + self.node, payload.ljust(8, b"\0"))

    def server(self, payload: bytes) -> CanFrame:
        """A frame of the server: 580h + node."""
        return CanFrame(self.bus, 0x580 + self.node, payload.ljust(8, b"\0"))


def is_client(frame: CanFrame) -> bool:
    """Whether the frame comes from the client side of a default channel."""
    return 0x601 <= frame.can_id <= 0x67F


def crc(data: bytes) -> int:
    """The checksum of block transfers: CRC-16/XMODEM over the data bytes."""
    return binascii.crc_hqx(data, 0)


def _initiate(command: int, index: int, sub: int, tail: bytes = b"") -> bytes:
    return struct.pack("<BHB", command, index, sub) + tail


def expedited_upload(channel: Channel, index: int, sub: int, value: bytes) -> list[CanFrame]:
    """A read of 1 to 4 bytes."""
    command = 0x43 | (4 - len(value)) << 2
    return [channel.client(_initiate(0x40, index, sub)), channel.server(_initiate(command, index, sub, value))]


def expedited_download(channel: Channel, index: int, sub: int, value: bytes) -> list[CanFrame]:
    """A write of 1 to 4 bytes."""
    command = 0x23 | (4 - len(value)) << 2
    return [channel.client(_initiate(command, index, sub, value)), channel.server(_initiate(0x60, index, sub))]


def _segments(value: bytes) -> Iterator[tuple[int, bytes]]:
    """Command bits t, n, c and the data of each segment; an empty value has one empty segment."""
    parts = [value[at : at + 7] for at in range(0, len(value), 7)] or [b""]
    for number, part in enumerate(parts):
        last = number == len(parts) - 1
        yield (number % 2) << 4 | (7 - len(part)) << 1 | last, part


def segmented_upload(channel: Channel, index: int, sub: int, value: bytes) -> list[CanFrame]:
    """A read in segments, the size announced."""
    frames = [
        channel.client(_initiate(0x40, index, sub)),
        channel.server(_initiate(0x41, index, sub, struct.pack("<I", len(value)))),
    ]
    for command, part in _segments(value):
        frames.append(channel.client(bytes([0x60 | command & 0x10])))
        frames.append(channel.server(bytes([command]) + part))
    return frames


def segmented_download(channel: Channel, index: int, sub: int, value: bytes) -> list[CanFrame]:
    """A write in segments, the size announced."""
    frames = [
        channel.client(_initiate(0x21, index, sub, struct.pack("<I", len(value)))),
        channel.server(_initiate(0x60, index, sub)),
    ]
    for command, part in _segments(value):
        frames.append(channel.client(bytes([command]) + part))
        frames.append(channel.server(bytes([0x20 | command & 0x10])))
    return frames


def _sub_blocks(value: bytes, blksize: int, acknowledged: Iterable[int]) -> Iterator[tuple[list[bytes], int]]:
    """The segments of each sub-block, and how many of them the receiver acknowledges.

    acknowledged: for each sub-block the acknowledgement, as far as it is not everything; after a partial one the sender
    goes on with the first byte that was not acknowledged, numbered from 1 again.
    """
    answers = iter(acknowledged)
    parts = [value[at : at + 7] for at in range(0, len(value), 7)]
    at = 0
    while at < len(parts):
        sent = parts[at : at + blksize]
        last = at + len(sent) == len(parts)
        segments = [
            bytes([number | (0x80 if last and number == len(sent) else 0)]) + part
            for number, part in enumerate(sent, 1)
        ]
        taken = min(next(answers, len(sent)), len(sent))
        yield segments, taken
        at += taken


def _block_end(value: bytes, *, with_crc: bool) -> bytes:
    unused = -len(value) % 7
    return struct.pack("<BH", 0xC1 | unused << 2, crc(value) if with_crc else 0)


def block_upload(
    channel: Channel,
    index: int,
    sub: int,
    value: bytes,
    *,
    blksize: int = 127,
    with_crc: bool = True,
    acknowledged: Iterable[int] = (),
) -> list[CanFrame]:
    """A read in blocks of a value of at least one byte."""
    flag = 4 if with_crc else 0
    frames = [
        channel.client(_initiate(0xA0 | flag, index, sub, bytes([blksize, 0]))),
        channel.server(_initiate(0xC2 | flag, index, sub, struct.pack("<I", len(value)))),
        channel.client(b"\xa3"),
    ]
    for segments, taken in _sub_blocks(value, blksize, acknowledged):
        frames += [channel.server(segment) for segment in segments]
        frames.append(channel.client(bytes([0xA2, taken, blksize])))
    frames.append(channel.server(_block_end(value, with_crc=with_crc)))
    frames.append(channel.client(b"\xa1"))
    return frames


def block_download(
    channel: Channel,
    index: int,
    sub: int,
    value: bytes,
    *,
    blksize: int = 127,
    with_crc: bool = True,
    acknowledged: Iterable[int] = (),
) -> list[CanFrame]:
    """A write in blocks of a value of at least one byte."""
    flag = 4 if with_crc else 0
    frames = [
        channel.client(_initiate(0xC2 | flag, index, sub, struct.pack("<I", len(value)))),
        channel.server(_initiate(0xA0 | flag, index, sub, bytes([blksize]))),
    ]
    for segments, taken in _sub_blocks(value, blksize, acknowledged):
        frames += [channel.client(segment) for segment in segments]
        frames.append(channel.server(bytes([0xA2, taken, blksize])))
    frames.append(channel.client(_block_end(value, with_crc=with_crc)))
    frames.append(channel.server(b"\xa1"))
    return frames


def abort(index: int, sub: int, code: int) -> bytes:
    """The payload of an abort, from either side."""
    return _initiate(0x80, index, sub, struct.pack("<I", code))
