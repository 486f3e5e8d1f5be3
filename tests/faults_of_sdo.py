"""Single faults of SDO transfers: sessions made by hand, what is changed in them, and the codes that are right.

What it must not do: know in which capture a session is put.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from captures import CanFrame, spaced
from sdo_wire import (
    Channel,
    abort,
    block_download,
    block_upload,
    expedited_download,
    expedited_upload,
    segmented_download,
    segmented_upload,
)

NODE, BYSTANDER = Channel(10), Channel(5)

UPLOAD = segmented_upload(
    NODE, 0x1008, 0, b"Zephyr RTOS/CANopenNode"
)  # 0 40, 1 41, 2 60, 3 00, 4 70, 5 10, .. 8 70, 9 1B
DOWNLOAD = segmented_download(NODE, 0x2004, 0, bytes(range(20)))  # 0 21, 1 60, 2 00, 3 20, 4 10, 5 30, 6 03, 7 20
READ = expedited_upload(NODE, 0x2001, 0, b"\xef\xbe")  # 0 40, 1 4B
WRITE = expedited_download(NODE, 0x2000, 0, b"\x0a\0\0\0")  # 0 23, 1 60
BLOCK_UPLOAD = block_upload(
    NODE, 0x2004, 0, bytes(range(64)), blksize=4
)  # 0 A4, 1 C6, 2 A3, 3-6, 7 A2, .. 15 A2, 16 D9, 17 A1
BLOCK_DOWNLOAD = block_download(
    NODE, 0x2004, 0, bytes(range(64)), blksize=4
)  # 0 C6, 1 A4, 2-5, 6 A2, .. 14 A2, 15 D9, 16 A1

Change = Callable[[list[CanFrame], int], None]


def flip(byte: int, bits: int) -> Change:
    """These bits of that byte, the other way round."""

    def change(frames: list[CanFrame], at: int) -> None:
        data = bytearray(frames[at].data)
        data[byte] ^= bits
        frames[at] = replace(frames[at], data=bytes(data))

    return change


def put(byte: int, value: int) -> Change:
    """That byte replaced."""

    def change(frames: list[CanFrame], at: int) -> None:
        flip(byte, frames[at].data[byte] ^ value)(frames, at)

    return change


def shorten(length: int) -> Change:
    """The frame with fewer bytes."""

    def change(frames: list[CanFrame], at: int) -> None:
        frames[at] = replace(frames[at], data=frames[at].data[:length])

    return change


def drop(count: int) -> Change:
    """So many frames missing from there on."""

    def change(frames: list[CanFrame], at: int) -> None:
        del frames[at : at + count]

    return change


def insert(*new: CanFrame) -> Change:
    """Other frames before that one."""

    def change(frames: list[CanFrame], at: int) -> None:
        frames[at:at] = new

    return change


def break_off(*new: CanFrame) -> Change:
    """The session ends there with other frames."""

    def change(frames: list[CanFrame], at: int) -> None:
        frames[at:] = new

    return change


@dataclass(frozen=True)
class Fault:
    """A row of the table."""

    name: str
    session: list[CanFrame]
    at: int
    change: Change
    codes: str
    """Any of these is right, without their SDO."""
    severity: str = "warning"
    """What the finding must at least be."""
    also: tuple[int, ...] = ()
    """Further right places in the changed session; -1 is its last frame, -2 the first frame after it."""


END, AFTER = -1, -2

FAULTS = [
    Fault("toggle of a segment request, upload", UPLOAD, 4, flip(0, 0x10), "001 002"),
    Fault("toggle of the first segment request, upload", UPLOAD, 2, flip(0, 0x10), "001 002"),
    Fault("toggle of a segment response, upload", UPLOAD, 5, flip(0, 0x10), "001 002"),
    Fault("toggle of the last segment, upload", UPLOAD, 9, flip(0, 0x10), "001 002"),
    Fault("toggle of a segment, download", DOWNLOAD, 4, flip(0, 0x10), "001 002"),
    Fault("toggle of a segment response, download", DOWNLOAD, 5, flip(0, 0x10), "001 002"),
    Fault("toggle of the last response, download", DOWNLOAD, 7, flip(0, 0x10), "001 002"),
    Fault("index in a response, segmented upload", UPLOAD, 1, flip(1, 0x01), "002 003"),
    Fault("index in a response, segmented download", DOWNLOAD, 1, flip(2, 0x01), "002 003"),
    Fault("index in a response, expedited upload", READ, 1, flip(1, 0x01), "002 003"),
    Fault("sub-index in a response, expedited download", WRITE, 1, flip(3, 0x01), "002 003"),
    Fault("index in a response, block upload", BLOCK_UPLOAD, 1, flip(1, 0x01), "002 003"),
    Fault("index in a response, block download", BLOCK_DOWNLOAD, 1, flip(1, 0x01), "002 003"),
    Fault("index in a request, expedited upload", READ, 0, flip(1, 0x01), "002 003"),
    Fault("n of the last segment, upload", UPLOAD, 9, flip(0, 0x02), "006"),
    Fault("n of the last segment, download", DOWNLOAD, 6, flip(0, 0x04), "006", also=(END,)),
    Fault("n in the middle, upload", UPLOAD, 5, flip(0, 0x02), "006", also=(END,)),
    Fault("n in the middle is said by itself", UPLOAD, 5, flip(0, 0x02), "005", severity="info"),
    Fault("n without e, upload initiate", UPLOAD, 1, flip(0, 0x04), "004"),
    Fault("n without e, download initiate", DOWNLOAD, 0, flip(0, 0x04), "004"),
    Fault("n without s, expedited upload", READ, 1, flip(0, 0x01), "004"),
    Fault("n of the end, block upload", BLOCK_UPLOAD, 16, flip(0, 0x04), "006 012 019"),
    Fault("n of the end, block download", BLOCK_DOWNLOAD, 15, flip(0, 0x04), "006 012 019"),
    Fault("announced size, upload", UPLOAD, 1, flip(4, 0x0F), "006", also=(END,)),
    Fault("announced size, download", DOWNLOAD, 0, flip(4, 0x02), "006", also=(6, END)),
    Fault("announced size, block upload", BLOCK_UPLOAD, 1, flip(4, 0x02), "006 012", also=(16, 17)),
    Fault("announced size, block download", BLOCK_DOWNLOAD, 0, flip(4, 0x02), "006 012", also=(15, 16)),
    Fault("last flag cleared, upload", UPLOAD, 9, flip(0, 0x01), "007 008"),
    Fault("last flag cleared, download", DOWNLOAD, 6, flip(0, 0x01), "007 008", also=(AFTER,)),
    Fault("last flag early, upload", UPLOAD, 5, flip(0, 0x01), "006 007"),
    Fault("last flag early, download", DOWNLOAD, 4, flip(0, 0x01), "006 007"),
    Fault("last flag cleared, block upload", BLOCK_UPLOAD, 14, flip(0, 0x80), "007 012", also=(16,)),
    Fault("last flag early, block download", BLOCK_DOWNLOAD, 4, flip(0, 0x80), "006 007 012", also=(6, 7)),
    Fault("segment dropped, upload", UPLOAD, 4, drop(2), "001 006 024", also=(END,)),
    Fault("segment dropped, download", DOWNLOAD, 4, drop(2), "001 006 024", also=(END,)),
    Fault("two segments dropped, upload", UPLOAD, 4, drop(4), "006", also=(END,)),
    Fault("segment dropped but acknowledged, block upload", BLOCK_UPLOAD, 4, drop(1), "024", also=(6,)),
    Fault("segment dropped but acknowledged, block download", BLOCK_DOWNLOAD, 4, drop(1), "024", also=(5,)),
    Fault("response dropped, upload", UPLOAD, 5, drop(1), "001 024"),
    Fault("response dropped, download", DOWNLOAD, 3, drop(1), "001 024"),
    Fault("initiate response dropped, upload", UPLOAD, 1, drop(1), "024"),
    Fault("initiate response dropped, expedited", READ, 1, drop(1), "002 008"),
    Fault("acknowledgement dropped, block download", BLOCK_DOWNLOAD, 6, drop(1), "012 024", also=(7, 9, 10)),
    Fault("end response dropped, block download", BLOCK_DOWNLOAD, 16, drop(1), "002 007 008 012"),
    Fault("request dropped, upload", UPLOAD, 4, drop(1), "001 002"),
    Fault("request dropped, download", DOWNLOAD, 4, drop(1), "001 002 006", also=(END,)),
    Fault("initiate request dropped, expedited", READ, 0, drop(1), "002"),
    Fault("acknowledgement dropped, block upload", BLOCK_UPLOAD, 7, drop(1), "012 024", also=(8, 10, 11)),
    Fault("seqno doubled, block upload", BLOCK_UPLOAD, 5, put(0, 2), "012", also=(6, 7)),
    Fault("seqno doubled, block download", BLOCK_DOWNLOAD, 4, put(0, 2), "012", also=(5, 6)),
    Fault("seqno beyond the sub-block, block upload", BLOCK_UPLOAD, 5, put(0, 9), "012", also=(6, 7)),
    Fault("seqno beyond the sub-block, block download", BLOCK_DOWNLOAD, 4, put(0, 9), "012", also=(5, 6)),
    Fault("seqno 0, block upload", BLOCK_UPLOAD, 5, put(0, 0), "012", also=(6, 7)),
    Fault("ackseq too high, block upload", BLOCK_UPLOAD, 7, put(1, 5), "012"),
    Fault("ackseq too high, block download", BLOCK_DOWNLOAD, 6, put(1, 127), "012"),
    Fault("blksize 0 in the request, block upload", BLOCK_UPLOAD, 0, put(4, 0), "012"),
    Fault("blksize 128 in the request, block upload", BLOCK_UPLOAD, 0, put(4, 128), "012"),
    Fault("blksize 0 in the response, block download", BLOCK_DOWNLOAD, 1, put(4, 0), "012"),
    Fault("blksize 0 in an acknowledgement, block upload", BLOCK_UPLOAD, 7, put(2, 0), "012"),
    Fault("blksize 0 in an acknowledgement, block download", BLOCK_DOWNLOAD, 6, put(2, 0), "012"),
    Fault("checksum, block upload", BLOCK_UPLOAD, 16, flip(1, 0x20), "019"),
    Fault("checksum, block download", BLOCK_DOWNLOAD, 15, flip(2, 0x01), "019"),
    Fault("one bit of the data, block upload", BLOCK_UPLOAD, 4, flip(5, 0x40), "019", also=(16, 17)),
    Fault("one bit of the data, block download", BLOCK_DOWNLOAD, 4, flip(5, 0x40), "019", also=(15, 16)),
    Fault("4 bytes, upload request", UPLOAD, 0, shorten(4), "010"),
    Fault("6 bytes, expedited response", READ, 1, shorten(6), "010"),
    Fault("1 byte, segment request", UPLOAD, 4, shorten(1), "010"),
    Fault("3 bytes, last segment", UPLOAD, 9, shorten(3), "010"),
    Fault("4 bytes, download response", WRITE, 1, shorten(4), "010"),
    Fault("5 bytes, block segment", BLOCK_UPLOAD, 4, shorten(5), "010"),
    Fault("no bytes at all", UPLOAD, 4, shorten(0), "010"),
    Fault("reserved bit of the upload request", READ, 0, flip(0, 0x10), "009", severity="info"),
    Fault("reserved bytes of the upload request", READ, 0, flip(6, 0x55), "009", severity="info"),
    Fault("reserved bytes of the download response", WRITE, 1, flip(7, 0x55), "009", severity="info"),
    Fault("reserved bit of a segment request", UPLOAD, 4, flip(0, 0x01), "009", severity="info"),
    Fault("padding of the last segment", UPLOAD, 9, flip(7, 0x55), "009", severity="info"),
    Fault(
        "abort by the server", UPLOAD, 5, break_off(NODE.server(abort(0x1008, 0, 0x08000000))), "017", severity="info"
    ),
    Fault(
        "abort by the client", UPLOAD, 4, break_off(NODE.client(abort(0x1008, 0, 0x05040000))), "017", severity="info"
    ),
    Fault(
        "abort by the client, block",
        BLOCK_UPLOAD,
        7,
        break_off(NODE.client(abort(0, 0, 0x05040005))),
        "017",
        severity="info",
    ),
    Fault(
        "abort from nowhere, the transfer goes on",
        UPLOAD,
        5,
        insert(NODE.server(abort(0x1008, 0, 0x08000000))),
        "017",
        severity="info",
    ),
    Fault("new initiate in an open transfer", UPLOAD, 4, insert(*READ), "008"),
    Fault("new initiate in an open block transfer", BLOCK_DOWNLOAD, 15, break_off(*READ), "008 007 012"),
    Fault("a second answer", READ, 1, insert(READ[1]), "002 020", severity="info"),
]

PROLOGUE = expedited_upload(NODE, 0x1000, 0, b"\x91\x01\x0f\x00") + expedited_upload(NODE, 0x1001, 0, b"\x00")
EPILOGUE = expedited_upload(NODE, 0x1018, 1, b"\x01\x03\x00\x00") + expedited_upload(NODE, 0x1017, 0, b"\x00\x00")


def in_company(session: list[CanFrame]) -> tuple[list[CanFrame], list[int]]:
    """The session between its neighbours, with another node's exchanges among its frames.

    The numbers are those in the capture: of the session's frames, and after them of the epilogue's.
    """
    capture: list[CanFrame] = [*PROLOGUE]
    numbers = []
    for at, frame in enumerate([*session, *EPILOGUE]):
        if at % 3 == 0:
            capture += expedited_upload(BYSTANDER, 0x2001, 0, bytes([at, 1]))
        capture.append(frame)
        numbers.append(len(capture))
    return spaced(capture), numbers


def sdo_places(frames: list[CanFrame]) -> Iterator[tuple[int, int, list[int]]]:
    """Each SDO frame: its place, its node, and the places of the channel's neighbours (one before, two after)."""
    channels: dict[int, list[int]] = {}
    for at, frame in enumerate(frames):
        if not frame.extended and (0x581 <= frame.can_id <= 0x5FF or 0x601 <= frame.can_id <= 0x67F):
            channels.setdefault(frame.can_id & 0x7F, []).append(at)
    for node, places in channels.items():
        for nth, at in enumerate(places):
            yield at, node, places[max(nth - 1, 0) : nth + 3]
