"""A small SDO server that knows block transfers and nothing else, because python-canopen's own server has none.

Used by the recording of a real session and by the test against python-canopen's client. CiA 301 7.2.4.3.9 to
7.2.4.3.15; uses the checksum when the client does, never loses a segment. What it must not do: grow into a node.
"""

from __future__ import annotations

import binascii
import struct

Payloads = list[bytes]


class BlockServer:
    """Objects that a client reads and writes in blocks: every frame of the client gets the frames that answer it."""

    def __init__(self, objects: dict[tuple[int, int], bytes], *, blksize: int) -> None:
        """Serves these objects and writes into them; asks for sub-blocks of so many segments."""
        self.objects = objects
        self.blksize = blksize
        self._object = (0, 0)
        self._writing = False
        self._value = bytearray()
        self._at = 0
        self._sent = 0
        self._client_blksize = 0
        self._expected = 1
        self._with_crc = False

    def answer(self, request: bytes) -> Payloads:
        """The payloads to send in answer to one payload of the client, in order, each of 8 bytes."""
        return [payload.ljust(8, b"\0") for payload in self._answer(request)]

    def _answer(self, request: bytes) -> Payloads:
        command = request[0]
        if self._writing:
            return self._segment(request)
        if command >> 5 == 6 and not command & 1:
            return self._begin_download(request)
        if command >> 5 == 6:
            return self._end_download(request)
        if command in (0xA0, 0xA4):
            return self._begin_upload(request)
        if command == 0xA3:
            return self._sub_block()
        if command == 0xA2:
            self._at += 7 * request[1]
            self._client_blksize = request[2]
            return self._sub_block() if self._at < len(self._value) else self._end_upload()
        return []

    def _multiplexor(self, request: bytes) -> bytes:
        self._object = (request[1] | request[2] << 8, request[3])
        return request[1:4]

    def _begin_upload(self, request: bytes) -> Payloads:
        multiplexor = self._multiplexor(request)
        if self._object not in self.objects:
            return [b"\x80" + multiplexor + struct.pack("<I", 0x06020000)]
        self._value, self._at = bytearray(self.objects[self._object]), 0
        self._client_blksize, self._with_crc = request[4], bool(request[0] & 4)
        return [bytes([0xC2 | request[0] & 4]) + multiplexor + struct.pack("<I", len(self._value))]

    def _sub_block(self) -> Payloads:
        ahead = self._value[self._at : self._at + 7 * self._client_blksize]
        parts = [bytes(ahead[at : at + 7]) for at in range(0, len(ahead), 7)]
        last = self._at + len(ahead) == len(self._value)
        numbers = range(1, len(parts) + 1)
        return [
            bytes([n | (0x80 if last and n == len(parts) else 0)]) + part
            for n, part in zip(numbers, parts, strict=True)
        ]

    def _end_upload(self) -> Payloads:
        checksum = binascii.crc_hqx(bytes(self._value), 0) if self._with_crc else 0
        return [struct.pack("<BH", 0xC1 | (-len(self._value) % 7) << 2, checksum)]

    def _begin_download(self, request: bytes) -> Payloads:
        multiplexor = self._multiplexor(request)
        if self._object not in self.objects:
            return [b"\x80" + multiplexor + struct.pack("<I", 0x06020000)]
        self._value, self._expected, self._writing = bytearray(), 1, True
        return [bytes([0xA0 | request[0] & 4]) + multiplexor + bytes([self.blksize])]

    def _segment(self, request: bytes) -> Payloads:
        if request[0] == 0x80:
            self._writing = False
            return []
        if request[0] & 0x7F == self._expected:
            self._value += request[1:]
            self._expected += 1
        last = bool(request[0] & 0x80)
        if not last and request[0] & 0x7F < self.blksize:
            return []
        taken, self._expected = self._expected - 1, 1
        self._writing = not last
        return [bytes([0xA2, taken, self.blksize])]

    def _end_download(self, request: bytes) -> Payloads:
        unused = request[0] >> 2 & 7
        self.objects[self._object] = bytes(self._value[: len(self._value) - unused])
        return [b"\xa1"]
