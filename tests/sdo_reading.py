"""A strict second reading of SDO: clean traffic in causal order becomes transfers, anything else is an error.

Why it exists: recordings, samples and generated captures need a truth that does not come from the program under
test, and the benchmark's traffic must be shown to be valid. It is deliberately small and intolerant: no reordering,
no quirks, no recovery. What it must not do: share code with the program.
"""

from __future__ import annotations

import binascii
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from captures import CanFrame


class UncleanTrafficError(Exception):
    """A frame that a correct client or server would not have sent here."""


@dataclass(slots=True)
class ReadTransfer:
    """One SDO transfer; the names are those of the program's JSON output."""

    bus: str
    node: int
    direction: str
    mode: str
    index: str
    sub: int
    first_frame: int
    last_frame: int = 0
    status: str = "incomplete"
    data: bytearray = field(default_factory=bytearray)
    size_indicated: int | None = None
    abort_code: str | None = None
    abort_by: str | None = None
    crc_negotiated: bool | None = None
    retransmissions: int = 0

    def comparable(self) -> dict[str, Any]:
        """The fields every reader of the same capture must agree on; an unfinished transfer's mode is not one."""
        facts: dict[str, Any] = {
            "bus": self.bus,
            "node": self.node,
            "direction": self.direction,
            "index": self.index,
            "sub": self.sub,
            "status": self.status,
            "abort_code": self.abort_code,
            "abort_by": self.abort_by,
            "first_frame": self.first_frame,
            "last_frame": self.last_frame,
        }
        if self.status == "ok":
            facts |= {"mode": self.mode, "data": self.data.hex().upper()}
            facts |= {"size": len(self.data), "size_indicated": self.size_indicated}
        return facts


def comparable_row(row: dict[str, Any]) -> dict[str, Any]:
    """The same fields out of a transfer line of the program."""
    facts = {name: row[name] for name in ("bus", "node", "direction", "index", "sub", "status")}
    abort = row["abort"] or {"code": None, "by": None}
    facts |= {"abort_code": abort["code"], "abort_by": abort["by"]}
    facts |= {"first_frame": row["first_frame"], "last_frame": row["last_frame"]}
    if row["status"] == "ok":
        facts |= {"mode": row["mode"], "data": row["data"].upper()}
        facts |= {"size": row["size"], "size_indicated": row["size_indicated"]}
    return facts


def read_transfers(frames: Iterable[CanFrame], *, cut_short: bool = False) -> list[ReadTransfer]:
    """Every transfer on the default channels, in the order they began; frames count from 1 over the whole capture.

    cut_short: the capture may end within transfers.
    """
    servers: dict[tuple[str, int], _Channel] = {}
    begun: list[ReadTransfer] = []
    for number, frame in enumerate(frames, 1):
        if frame.extended or not (0x581 <= frame.can_id <= 0x5FF or 0x601 <= frame.can_id <= 0x67F):
            continue
        node, by = frame.can_id & 0x7F, "client" if frame.can_id >= 0x600 else "server"
        channel = servers.setdefault((frame.bus, node), _Channel(frame.bus, node, begun))
        channel.take(number, by, frame.data)
    for transfer in begun:
        if transfer.status == "incomplete" and not cut_short:
            raise UncleanTrafficError(f"never ended: {transfer}")
    return begun


class _Channel:
    """One channel: the transfer that is open and what has to come next."""

    def __init__(self, bus: str, node: int, begun: list[ReadTransfer]) -> None:
        self.bus = bus
        self.node = node
        self.begun = begun
        self.open: ReadTransfer | None = None
        self.wanted = ""
        self.toggle = 0
        self.blksize = 0
        self.segments: list[bytes] = []
        self.sent_last = False

    def take(self, number: int, by: str, data: bytes) -> None:
        if len(data) != 8:
            raise UncleanTrafficError(f"frame {number}: {len(data)} bytes")
        if data[0] == 0x80:
            self._abort(number, by, data)
        elif self.open is None:
            self._begin(number, by, data)
        else:
            if (by, self.open.direction, self.wanted) == ("server", "upload", "block answer") and data[0] >> 5 == 2:
                self.wanted = "answer"
            step = getattr(self, f"_{self.open.direction}_{self.wanted.replace(' ', '_')}_{by}", None)
            if step is None:
                raise UncleanTrafficError(f"frame {number}: {data.hex()} by the {by} where {self.wanted!r} has to come")
            self.open.last_frame = number
            step(self.open, data)

    def _need(self, holds: bool, what: str) -> None:
        if not holds:
            raise UncleanTrafficError(f"{self.open}: {what}")

    def _abort(self, number: int, by: str, data: bytes) -> None:
        transfer = self.open
        if transfer is None:
            raise UncleanTrafficError(f"frame {number}: abort of nothing")
        transfer.status, transfer.last_frame = "aborted", number
        transfer.abort_code, transfer.abort_by = f"{int.from_bytes(data[4:], 'little'):08X}", by
        self.open = None

    def _end(self, transfer: ReadTransfer) -> None:
        announced = transfer.size_indicated
        self._need(announced is None or announced == len(transfer.data), "size")
        transfer.status = "ok"
        self.open = None

    def _begin(self, number: int, by: str, data: bytes) -> None:
        if by != "client":
            raise UncleanTrafficError(f"frame {number}: answer to nothing")
        index, sub = f"{data[1] | data[2] << 8:04X}", data[3]
        command, self.toggle, self.segments, self.sent_last = data[0], 0, [], False

        def begin(direction: str, mode: str, wanted: str) -> ReadTransfer:
            transfer = ReadTransfer(self.bus, self.node, direction, mode, index, sub, number, number)
            self.open, self.wanted = transfer, wanted
            self.begun.append(transfer)
            return transfer

        if command == 0x40:
            begin("upload", "expedited", "answer")
            self._need(data[4:] == bytes(4), "reserved bytes")
        elif command in (0x23, 0x27, 0x2B, 0x2F):
            transfer = begin("download", "expedited", "answer")
            transfer.data += data[4 : 8 - (command >> 2 & 3)]
            transfer.size_indicated = len(transfer.data)
        elif command in (0x20, 0x21):
            transfer = begin("download", "segmented", "answer")
            transfer.size_indicated = int.from_bytes(data[4:], "little") if command & 1 else None
        elif command in (0xC0, 0xC2, 0xC4, 0xC6):
            transfer = begin("download", "block", "block answer")
            transfer.size_indicated = int.from_bytes(data[4:], "little") if command & 2 else None
            transfer.crc_negotiated = bool(command & 4)
        elif command in (0xA0, 0xA4):
            transfer = begin("upload", "block", "block answer")
            transfer.crc_negotiated = bool(command & 4)
            self.blksize = data[4]
            self._need(1 <= self.blksize <= 127, "block size")
        else:
            raise UncleanTrafficError(f"frame {number}: {data.hex()} begins nothing")

    def _same_object(self, transfer: ReadTransfer, data: bytes) -> None:
        self._need(f"{data[1] | data[2] << 8:04X}" == transfer.index and data[3] == transfer.sub, "another object")

    def _segment(self, transfer: ReadTransfer, data: bytes) -> bool:
        self._need(data[0] >> 5 == 0 and data[0] >> 4 & 1 == self.toggle, "segment command")
        transfer.data += data[1 : 8 - (data[0] >> 1 & 7)]
        return bool(data[0] & 1)

    def _upload_answer_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._same_object(transfer, data)
        if data[0] in (0x43, 0x47, 0x4B, 0x4F):
            transfer.mode, transfer.crc_negotiated = "expedited", None
            transfer.data += data[4 : 8 - (data[0] >> 2 & 3)]
            transfer.size_indicated = len(transfer.data)
            self._end(transfer)
        else:
            self._need(data[0] in (0x40, 0x41), "upload answer")
            transfer.mode, transfer.crc_negotiated = "segmented", None
            transfer.size_indicated = int.from_bytes(data[4:], "little") if data[0] & 1 else None
            self.wanted = "request"

    def _upload_request_client(self, transfer: ReadTransfer, data: bytes) -> None:
        self._need(data == bytes([0x60 | self.toggle << 4]) + bytes(7), "segment request")
        self.wanted = "segment"

    def _upload_segment_server(self, transfer: ReadTransfer, data: bytes) -> None:
        if self._segment(transfer, data):
            self._end(transfer)
        self.toggle ^= 1
        self.wanted = "request"

    def _download_answer_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._same_object(transfer, data)
        self._need(data[0] == 0x60 and data[4:] == bytes(4), "download answer")
        if transfer.mode == "expedited":
            self._end(transfer)
        self.wanted = "segment"

    def _download_segment_client(self, transfer: ReadTransfer, data: bytes) -> None:
        self.sent_last = self._segment(transfer, data)
        self.wanted = "confirmation"

    def _download_confirmation_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._need(data == bytes([0x20 | self.toggle << 4]) + bytes(7), "segment answer")
        self.toggle ^= 1
        self.wanted = "segment"
        if self.sent_last:
            self._end(transfer)

    def _download_block_answer_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._same_object(transfer, data)
        self._need(data[0] in (0xA0, 0xA4), "block answer")
        transfer.crc_negotiated = transfer.crc_negotiated and bool(data[0] & 4)
        self.blksize = data[4]
        self._need(1 <= self.blksize <= 127, "block size")
        self.wanted = "sub block"

    def _upload_block_answer_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._same_object(transfer, data)
        self._need(data[0] in (0xC0, 0xC2, 0xC4, 0xC6), "block answer")
        transfer.size_indicated = int.from_bytes(data[4:], "little") if data[0] & 2 else None
        transfer.crc_negotiated = transfer.crc_negotiated and bool(data[0] & 4)
        self.wanted = "start"

    def _upload_start_client(self, transfer: ReadTransfer, data: bytes) -> None:
        self._need(data == b"\xa3" + bytes(7), "start")
        self.wanted = "sub block"

    def _block_segment(self, data: bytes) -> None:
        number, last = data[0] & 0x7F, bool(data[0] & 0x80)
        if number != len(self.segments) + 1:
            self._need(number > len(self.segments), "sequence number repeated")
            self.segments += [b""] * (number - 1 - len(self.segments))
        self._need(number <= self.blksize and not self.sent_last, "segment after the end of the sub-block")
        self.segments.append(data[1:])
        self.sent_last = last

    def _block_acknowledged(self, transfer: ReadTransfer, data: bytes) -> None:
        self._need(data[0] == 0xA2 and data[3:] == bytes(5), "acknowledgement")
        taken, self.blksize = data[1], data[2]
        self._need(taken <= len(self.segments) and 1 <= self.blksize <= 127, "acknowledgement")
        self._need(all(self.segments[:taken]), "a segment that was not there is acknowledged")
        transfer.data += b"".join(self.segments[:taken])
        if taken < len(self.segments):
            transfer.retransmissions += 1
            self.sent_last = False
        self.segments = []
        if self.sent_last:
            self.wanted = "block end"

    def _download_sub_block_client(self, transfer: ReadTransfer, data: bytes) -> None:
        self._block_segment(data)

    def _download_sub_block_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._block_acknowledged(transfer, data)

    def _upload_sub_block_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._block_segment(data)

    def _upload_sub_block_client(self, transfer: ReadTransfer, data: bytes) -> None:
        self._block_acknowledged(transfer, data)

    def _block_end(self, transfer: ReadTransfer, data: bytes) -> None:
        self._need(data[0] & 0xE3 == 0xC1, "block end")
        unused = data[0] >> 2 & 7
        del transfer.data[len(transfer.data) - unused :]
        checksum = data[1] | data[2] << 8
        if transfer.crc_negotiated:
            self._need(checksum == binascii.crc_hqx(bytes(transfer.data), 0), "checksum")
        self.wanted = "block close"

    def _download_block_end_client(self, transfer: ReadTransfer, data: bytes) -> None:
        self._block_end(transfer, data)

    def _upload_block_end_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._block_end(transfer, data)

    def _block_close(self, transfer: ReadTransfer, data: bytes) -> None:
        self._need(data == b"\xa1" + bytes(7), "close")
        self._end(transfer)

    def _download_block_close_server(self, transfer: ReadTransfer, data: bytes) -> None:
        self._block_close(transfer, data)

    def _upload_block_close_client(self, transfer: ReadTransfer, data: bytes) -> None:
        self._block_close(transfer, data)
