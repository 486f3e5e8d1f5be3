"""The law of pairing: client frames that a capture shows one late change nothing, and neither does a late beginning.

A capture taken on the client's own host shows some of the client's frames after the server's answer. Any causal
session with any subset of its client frames delayed by one frame of the channel must yield the same transfers and
values and no finding above info; and so must every suffix of a causal capture, for the transfers that begin in it.

The sessions are the worked examples of the samples; what they hold is read by the strict second reading of these
tests.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import pytest
from captures import SAMPLES, CanFrame, Row, analyze, console_text, examples, log_text, read_log, spaced
from sdo_reading import ReadTransfer, comparable_row, read_transfers
from sdo_wire import (
    Channel,
    abort,
    block_download,
    block_upload,
    expedited_download,
    expedited_upload,
    is_client,
    segmented_download,
    segmented_upload,
)

NODE = Channel(10)
NAME = b"Zephyr RTOS/CANopenNode"

SESSIONS: dict[str, list[CanFrame]] = {
    "E1": segmented_upload(NODE, 0x1008, 0, NAME),
    **examples(SAMPLES / "sdo-expedited.log"),
    **examples(SAMPLES / "sdo-segmented.log"),
    **examples(SAMPLES / "sdo-block.log"),
    "long block upload": block_upload(
        NODE, 0x2004, 0, bytes(range(256)) * 4, blksize=20, acknowledged=[20, 3, 0, 20, 19]
    ),
    "long block download": block_download(NODE, 0x2004, 0, bytes(range(256)) * 4, blksize=127, acknowledged=[100]),
    "sub-blocks of one": block_upload(NODE, 0x2004, 0, bytes(range(30)), blksize=1),
    "block download, sub-blocks of one": block_download(NODE, 0x2004, 0, bytes(range(30)), blksize=1, with_crc=False),
    "segments of equal content": segmented_upload(NODE, 0x2004, 0, bytes(70)),
    "the same object again and again": [
        frame for value in range(6) for frame in expedited_upload(NODE, 0x2001, 0, bytes([value, 7]))
    ],
    "written and read in turn": [
        frame
        for value in (b"\1\2", b"\3\4", b"\5\6")
        for frame in expedited_download(NODE, 0x2001, 0, value) + expedited_upload(NODE, 0x2001, 0, value)
    ],
    "empty value": segmented_download(NODE, 0x2004, 0, b""),
}

ABORTED: dict[str, list[CanFrame]] = {
    "E8": examples(SAMPLES / "sdo-abort.log")[
        "E8: write of a read-only object, read of a write-only one, no such object, no such sub-index, too long"
    ],
    "by the server, in segments": [
        *segmented_upload(NODE, 0x1008, 0, NAME)[:5],
        NODE.server(abort(0x1008, 0, 0x08000000)),
    ],
    "by the client, in segments": [
        *segmented_upload(NODE, 0x1008, 0, NAME)[:6],
        NODE.client(abort(0x1008, 0, 0x08000000)),
    ],
    "by the server, in a download": [
        *segmented_download(NODE, 0x2004, 0, NAME)[:3],
        NODE.server(abort(0x2004, 0, 0x06070012)),
    ],
    "by the client, in a block": [*block_upload(NODE, 0x2004, 0, NAME)[:7], NODE.client(abort(0, 0, 0x05040005))],
    "refused, and repeated at once": [
        frame
        for value in (b"\1\2", b"\3\4")
        for frame in (expedited_download(NODE, 0x2001, 0, value)[0], NODE.server(abort(0x2001, 0, 0x08000022)))
    ]
    + expedited_download(NODE, 0x2001, 0, b"\3\4"),
    "refused again and again": [
        frame
        for _ in range(4)
        for frame in (expedited_upload(NODE, 0x2001, 0, b"\1")[0], NODE.server(abort(0x2001, 0, 0x06020000)))
    ],
    "refused, then another of the same object": [
        expedited_upload(NODE, 0x2004, 0, b"\1")[0],
        NODE.server(abort(0x2004, 0, 0x08000022)),
        *segmented_upload(NODE, 0x2004, 0, NAME),
    ],
    "by the server, at the end of a block": [
        *block_download(NODE, 0x2004, 0, NAME)[:-1],
        NODE.server(abort(0x2004, 0, 0x06070012)),
    ],
}

PROLOGUE = expedited_upload(NODE, 0x1000, 0, b"\x91\x01\x0f\x00") + expedited_upload(NODE, 0x1001, 0, b"\x00")
EPILOGUE = expedited_upload(NODE, 0x1018, 1, b"\x01\x03\x00\x00") + expedited_upload(NODE, 0x1001, 0, b"\x00")
"""A channel in use before and after, so that a session is judged by its own frames and not by the capture's edges."""

Writer = Callable[[Iterable[CanFrame]], bytes]


def with_stamps(frames: Iterable[CanFrame]) -> bytes:
    return log_text(spaced(frames))


WRITERS: list[Writer] = [with_stamps, console_text]


def may_be_late(frames: Sequence[CanFrame]) -> list[int]:
    """The client frames that a server frame follows."""
    return [at for at, frame in enumerate(frames[:-1]) if is_client(frame) and not is_client(frames[at + 1])]


def displaced(frames: Sequence[CanFrame], late: Iterable[int]) -> list[CanFrame]:
    """The capture with these client frames one place later."""
    moved = list(frames)
    for at in late:
        moved[at], moved[at + 1] = moved[at + 1], moved[at]
    return moved


PLACES = {"first_frame", "last_frame"}
"""The fields that displacement does change."""


def essence(transfer: ReadTransfer) -> Row:
    """What displacement must not change."""
    return {name: value for name, value in transfer.comparable().items() if name not in PLACES}


def essence_of_row(row: Row) -> Row:
    """The same facts of a line of the program."""
    return {name: value for name, value in comparable_row(row).items() if name not in PLACES}


def judge(capture: bytes, wanted: Sequence[Row], hint: object) -> None:
    """The program must say the same transfers, and nothing above info."""
    said = analyze(capture)
    assert [essence_of_row(row) for row in said.transfers] == list(wanted), hint
    assert not said.above_info(), f"{hint}\n{said.complaint()}"


def judge_displaced(session: list[CanFrame], write: Writer, chosen: Iterable[Sequence[int]]) -> None:
    """The session between its neighbours, with each of these choices of late client frames."""
    whole = [*PROLOGUE, *session, *EPILOGUE]
    wanted = [essence(transfer) for transfer in read_transfers(whole)]
    for late in chosen:
        judge(write(displaced(whole, late)), wanted, f"late: {[at + 1 for at in late]}")


def own_late(session: list[CanFrame]) -> list[int]:
    """The places of the session's own client frames that may be late, in the whole capture."""
    whole = [*PROLOGUE, *session, *EPILOGUE]
    return [at for at in may_be_late(whole) if len(PROLOGUE) <= at < len(PROLOGUE) + len(session)]


def random_subsets(places: list[int], count: int) -> list[list[int]]:
    source = random.Random(58)
    return [[at for at in places if source.random() < 0.5] for _ in range(count)]


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
@pytest.mark.parametrize("name", SESSIONS)
def test_in_causal_order(name: str, write: Writer) -> None:
    judge_displaced(SESSIONS[name], write, [[]])


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
@pytest.mark.parametrize("name", SESSIONS)
def test_each_client_frame_late_in_turn(name: str, write: Writer) -> None:
    judge_displaced(SESSIONS[name], write, [[at] for at in own_late(SESSIONS[name])])


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
@pytest.mark.parametrize("name", SESSIONS)
def test_any_client_frames_late(name: str, write: Writer) -> None:
    places = own_late(SESSIONS[name])
    judge_displaced(SESSIONS[name], write, [places, *random_subsets(places, 25)])


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
def test_any_client_frames_late_in_all_sessions_in_a_row(write: Writer) -> None:
    whole = [frame for session in SESSIONS.values() for frame in session]
    judge_displaced(whole, write, random_subsets(own_late(whole), 10))


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
@pytest.mark.parametrize("name", ABORTED)
def test_aborted_transfers_with_late_client_frames(name: str, write: Writer) -> None:
    """The abort may be seen before the request that it answers."""
    places = own_late(ABORTED[name])
    judge_displaced(ABORTED[name], write, [[], *[[at] for at in places], *random_subsets(places, 10)])


@pytest.mark.parametrize("name", SESSIONS)
def test_the_very_first_request_late(name: str) -> None:
    """The capture begins with an answer: its request may follow or was never captured, but it is no fault."""
    session = SESSIONS[name]
    said = analyze(with_stamps(displaced(session, may_be_late(session)[:1])))
    assert not said.above_info(), said.complaint()


def answered_slowly(frames: Iterable[CanFrame]) -> bytes:
    """Stamps by a client that is quicker than its server."""
    stamps = 1_700_000_000_000_000
    spread = []
    for frame in frames:
        stamps += 60 if is_client(frame) else 700
        spread.append(replace(frame, t_us=stamps))
    return log_text(spread)


@pytest.mark.parametrize("name", ["the same object again and again", "written and read in turn"])
def test_late_requests_of_a_quick_client(name: str) -> None:
    """A response, and its request listed later than the next answer takes."""
    whole = [*PROLOGUE, *SESSIONS[name], *EPILOGUE]
    wanted = [essence(transfer) for transfer in read_transfers(whole)]
    for late in [own_late(SESSIONS[name]), *random_subsets(own_late(SESSIONS[name]), 10)]:
        stamps = [frame.t_us for frame in read_log(answered_slowly(whole))]
        moved = [replace(frame, t_us=t_us) for frame, t_us in zip(displaced(whole, late), stamps, strict=True)]
        judge(log_text(moved), wanted, f"late: {[at + 1 for at in late]}")


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
@pytest.mark.parametrize("name", [*SESSIONS, *ABORTED])
def test_all_requests_late_from_the_very_first_on(name: str, write: Writer) -> None:
    """Whose the first answers are cannot be known where they are of one object: nothing is said of them."""
    session = (SESSIONS | ABORTED)[name]
    whole = [*session, *EPILOGUE]
    said = analyze(write(displaced(whole, may_be_late(whole))))
    assert not said.above_info(), said.complaint()


def judge_suffixes(whole: list[CanFrame], write: Writer) -> None:
    begun = read_transfers(whole)
    for cut in range(1, len(whole)):
        wanted = [essence(transfer) for transfer in begun if transfer.first_frame > cut]
        said = analyze(write(whole[cut:]))
        hint = f"from frame {cut + 1}: {whole[cut].can_id:03X} {whole[cut].data.hex(' ')}"
        assert not said.above_info(), f"{hint}\n{said.complaint()}"
        rows = said.transfers
        assert len(wanted) <= len(rows) <= len(wanted) + 1, hint
        beginning_not_captured, whole_ones = rows[: len(rows) - len(wanted)], rows[len(rows) - len(wanted) :]
        assert [essence_of_row(row) for row in whole_ones] == wanted, hint
        assert all(row["status"] != "ok" for row in beginning_not_captured), hint


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
@pytest.mark.parametrize("name", [*SESSIONS, *ABORTED])
def test_every_suffix_of_one_session(name: str, write: Writer) -> None:
    session = (SESSIONS | ABORTED)[name]
    judge_suffixes([*session, *EPILOGUE, *segmented_upload(NODE, 0x1008, 0, NAME)], write)


def test_every_prefix_is_no_fault() -> None:
    """A capture that ends in a transfer has an incomplete one, never a violation."""
    for name, session in (SESSIONS | ABORTED).items():
        for end in range(1, len(session)):
            said = analyze(with_stamps([*PROLOGUE, *session[:end]]))
            assert not said.above_info(), f"{name} up to frame {end}\n{said.complaint()}"
