"""Mappings and COB-IDs that only unanswered SDO writes show: PDOs are decoded by them, and nobody is judged.

The answering direction is not recorded, or one response was lost. What frames or a later answer decide is confirmed or
dropped. What it must not do: look at the wording, but for the word that marks a value.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from captures import Analysis, CanFrame, Row, analyze, log_text, spaced
from clean_sessions import sessions

NODE = 5
PREDEFINED = 0x185
MOVED = 0x1A5
MAPPING = "60410010 60640020"
POSITION = bytes.fromhex("370200100000")


def request(index: int, sub: int, value: int, size: int = 4) -> CanFrame:
    data = bytes([0x23 | (4 - size) << 2]) + index.to_bytes(2, "little") + bytes([sub]) + value.to_bytes(4, "little")
    return CanFrame("can0", 0x600 + NODE, data)


def response(to: CanFrame) -> CanFrame:
    return CanFrame("can0", 0x580 + NODE, b"\x60" + to.data[1:4] + bytes(4))


def refusal(to: CanFrame) -> CanFrame:
    return CanFrame("can0", 0x580 + NODE, b"\x80" + to.data[1:4] + bytes.fromhex("41000406"))


def tpdo(data: bytes = POSITION, can_id: int = MOVED) -> CanFrame:
    return CanFrame("can0", can_id, data)


START = CanFrame("can0", 0x000, bytes([0x01, NODE]))
OFF = request(0x1A00, 0, 0, 1)
FIRST = request(0x1A00, 1, 0x60410010)
SECOND = request(0x1A00, 2, 0x60640020)
COUNT = request(0x1A00, 0, 2, 1)
COB = request(0x1800, 1, MOVED)
WRITES = [OFF, FIRST, SECOND, COUNT, COB]
ANSWERED = [frame for write in WRITES for frame in (write, response(write))]


def said(*frames: CanFrame, step_us: int = 2_000) -> Analysis:
    return analyze(log_text(spaced(frames, step_us=step_us)))


def pdos(found: Analysis) -> list[Row]:
    return [row for row in found.frames if row["service"] == "pdo" and not row["pdo"]["remote"]]


def read(row: Row) -> tuple[int, str, str | None, str]:
    """Whose PDO a frame is, and what it is decoded by."""
    pdo = row["pdo"]
    mapped = " ".join(f"{one['index']}{one['sub']:02X}{one['bits']:02X}" for one in pdo["signals"])
    return row["node"], pdo["pdo"], pdo["provenance"], mapped


def without_answers(frames: list[CanFrame]) -> list[CanFrame]:
    return [frame for frame in frames if not 0x581 <= frame.can_id <= 0x5FF]


def test_requests_alone_decode_as_unconfirmed() -> None:
    found = said(*WRITES, START, tpdo(), tpdo())
    assert [read(row) for row in pdos(found)] == [(NODE, "TPDO1", "unconfirmed", MAPPING)] * 2
    assert not found.above_info(), found.complaint()
    assert {one["provenance"] for row in pdos(found) for one in row["pdo"]["signals"]} == {"unconfirmed"}
    assert all("unconfirmed" in row["text"] for row in pdos(found))


def test_answered_writes_decode_as_observed() -> None:
    found = said(*ANSWERED, START, tpdo(), tpdo())
    assert [read(row) for row in pdos(found)] == [(NODE, "TPDO1", "observed", MAPPING)] * 2
    assert not any("unconfirmed" in row["text"] for row in pdos(found))


@pytest.mark.parametrize("lost", range(len(WRITES)))
def test_one_lost_response(lost: int) -> None:
    """The client goes on, as it can only do when it has got the response."""
    frames = [frame for frame in ANSWERED if frame is not ANSWERED[2 * lost + 1]]
    # The last write is taken for unanswered when a second has passed.
    found = said(*frames, START, *[tpdo()] * 40, step_us=50_000)
    assert read(pdos(found)[-1])[:2] == (NODE, "TPDO1")
    assert read(pdos(found)[-1])[2:] == ("observed" if lost == 0 else "unconfirmed", MAPPING)
    assert not [row for row in found.findings if row["code"].startswith("PDO")], found.findings


@pytest.mark.parametrize("refused", [FIRST, SECOND, COUNT])
def test_a_refused_write_decodes_nothing(refused: CanFrame) -> None:
    frames = [frame for write in WRITES for frame in ((write, refusal(write)) if write is refused else (write,))]
    for row in pdos(said(*frames, response(COB), START, tpdo(), tpdo())):
        assert read(row) == (NODE, "TPDO1", None, "")
        assert row["pdo"]["unmapped"] == "unknown"


def test_a_refused_identifier_is_not_used() -> None:
    found = said(*WRITES, refusal(COB), START, tpdo(can_id=PREDEFINED), tpdo())
    assert [read(row)[:2] for row in pdos(found)] == [(NODE, "TPDO1"), (MOVED - 0x180, "TPDO1")]


@pytest.mark.parametrize("length", [0, 2, 4, 5, 7, 8])
def test_a_mapping_of_another_length_is_not_used(length: int) -> None:
    found = said(*WRITES, START, tpdo(bytes(length)), tpdo())
    assert [read(row) for row in pdos(found)] == [(NODE, "TPDO1", "unconfirmed", "")] * 2
    assert not found.above_info(), found.complaint()


def test_an_identifier_that_was_not_left_is_kept() -> None:
    found = said(*WRITES, START, tpdo(can_id=PREDEFINED), tpdo())
    assert [read(row) for row in pdos(found)] == [
        (NODE, "TPDO1", "unconfirmed", MAPPING),
        (MOVED - 0x180, "TPDO1", None, ""),
    ]


def test_a_later_answer_confirms() -> None:
    found = said(*WRITES, START, tpdo(), *ANSWERED, tpdo())
    assert [read(row)[2] for row in pdos(found)] == ["unconfirmed", "observed"]


def test_a_reset_ends_it() -> None:
    reset = CanFrame("can0", 0x000, bytes([0x81, NODE]))
    found = said(*WRITES, START, tpdo(), reset, tpdo())
    assert read(pdos(found)[-1]) == (MOVED - 0x180, "TPDO1", None, "")


def test_a_mapping_in_the_making_is_not_used() -> None:
    """Behind the first mapping a second one is begun: what stands there is neither."""
    longer = [OFF, request(0x1A00, 1, 0x60640020), request(0x1A00, 2, 0x60410010)]
    found = said(*WRITES, START, tpdo(), *longer, tpdo())
    assert [read(row)[3] for row in pdos(found)] == [MAPPING, ""]


def test_nobody_is_judged_by_it() -> None:
    """In the wrong state, too long, and while another node has the identifier by default."""
    halted = [CanFrame("can0", 0x700 + node, b"\x7f") for node in (NODE, MOVED - 0x180)]
    found = said(*WRITES, *halted, *[tpdo()] * 50, *halted, *[tpdo(bytes(8))] * 50)
    assert not [row for row in found.findings if row["code"].startswith("PDO")], found.findings


@pytest.mark.parametrize("name", list(sessions()))
def test_clean_sessions_without_answers(name: str) -> None:
    """Each PDO means what it means in the whole session, or it is not said what it means."""
    frames = list(sessions()[name].frames)
    numbers = [number for number, frame in enumerate(frames, 1) if not 0x581 <= frame.can_id <= 0x5FF]
    whole = {row["frame"]: row for row in pdos(analyze(log_text(frames)))}
    found = analyze(log_text(without_answers(frames)))
    for row in pdos(found):
        true = whole.get(numbers[row["frame"] - 1])
        if true is None or row["pdo"]["provenance"] is None:
            continue
        assert read(replace_provenance(row)) == read(replace_provenance(true)), row["text"]
    assert not [row for row in found.above_info() if row["code"].startswith(("PDO", "MPD"))], found.complaint()


def replace_provenance(row: Row) -> Row:
    return {**row, "pdo": {**row["pdo"], "provenance": "any"}}


def test_a_write_in_flight_is_none() -> None:
    """A PDO between a request and its response is decoded as before: an answer may still come."""
    on = [*ANSWERED, START, tpdo()]
    again = [OFF, response(OFF), FIRST, response(FIRST), SECOND, response(SECOND), COUNT]
    found = said(*on, *again, replace(tpdo()), response(COUNT), tpdo())
    assert "unconfirmed" not in [read(row)[2] for row in pdos(found)]
