"""What people paste: rows of a listing without its header, numbered, quoted, shortened, between lines of prose.

Each form is told from its neighbour: the whole listing, of which nothing may be said to be left out. What a listing
leaves out is a gap, in `info`, `summary` and `check`. Must not: decide how a single line is read, which the readers'
own tests do.
"""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import can
import pytest
from conftest import Runner, runner

from canalyze._core import omission, sniff

Frame = tuple[int, int, bytes]
"""Offset in ms, identifier, data."""


@pytest.fixture
def canalyze(tmp_path: Path) -> Runner:
    """One process runs all of them: there are many, and they only read and write."""
    return runner(tmp_path, kept=True)


def session(count: int = 40) -> list[Frame]:
    """Reads of one object again and again, each with its answer."""
    request, answer = bytes.fromhex("4000100000000000"), bytes.fromhex("4300100092010200")
    return [(10 * at + 5, *((0x60A, request) if at % 2 == 0 else (0x58A, answer))) for at in range(count)]


def _row_1_0(number: int, at: int, ident: int, data: bytes) -> str:
    return f"{number:6}) {at:9} {f'{ident:04X}':>9} {len(data):2}  {data.hex(' ').upper()}"


def _row_1_1(number: int, at: int, ident: int, data: bytes) -> str:
    way = "Rx" if ident < 0x600 else "Tx"
    return f"{number:6}) {at:11.1f}  {way} {f'{ident:04X}':>12} {len(data):2}  {data.hex(' ').upper()} "


def _row_1_2(number: int, at: int, ident: int, data: bytes) -> str:
    return f"{number:6}) {at:13.3f} 1  Rx {f'{ident:04X}':>11} {len(data)}    {data.hex(' ').upper()}"


def _row_1_3(number: int, at: int, ident: int, data: bytes) -> str:
    return f"{number:6}) {at:13.3f} 1  Rx {f'{ident:04X}':>11} -  {len(data)}    {data.hex(' ').upper()}"


def _row_2_0(number: int, at: int, ident: int, data: bytes) -> str:
    return f"{number:7} {at:13.3f} DT {f'{ident:04X}':>8} Rx {len(data):<2} {data.hex(' ').upper()}"


def _row_2_1(number: int, at: int, ident: int, data: bytes) -> str:
    return f"{number:7} {at:13.3f} DT 1 {f'{ident:04X}':>9} Rx -  {len(data):<4} {data.hex(' ').upper()}"


def _row_console(number: int, at: int, ident: int, data: bytes) -> str:
    return f"{number:4})  ({at / 1000:010.6f})  slcan0  {ident:03X}   [{len(data)}]  {data.hex(' ').upper()}"


def _row_busmaster(_: int, at: int, ident: int, data: bytes) -> str:
    return f"0:00:{at // 1000:02}:{at % 1000 * 10:04} Rx 1 0x{ident:03X} s {len(data)} {data.hex(' ').upper()} "


def _row_busmaster_decimal(_: int, at: int, ident: int, data: bytes) -> str:
    shown = " ".join(f"{byte:03}" for byte in data)
    return f"0:00:{at // 1000:02}:{at % 1000 * 10:04} Tx 1 {ident} s {len(data)} {shown} "


def _row_canking(_: int, at: int, ident: int, data: bytes) -> str:
    return f" 0    {ident:08X}         {len(data)}  {data.hex(' ').upper()}  {at / 1000:12.6f} R"


def _row_canking_decimal(_: int, at: int, ident: int, data: bytes) -> str:
    return f" 0    {ident:8}         {len(data)}  {' '.join(f'{byte:3}' for byte in data)}  {at / 1000:12.6f} T"


Row = Callable[[int, int, int, bytes], str]
TRC: dict[str, Row] = {
    "1.0": _row_1_0,
    "1.1": _row_1_1,
    "1.2": _row_1_2,
    "1.3": _row_1_3,
    "2.0": _row_2_0,
    "2.1": _row_2_1,
}
ROWS = TRC | {"candump": _row_console}
OTHERS: dict[str, Row] = {
    "BUSMASTER": _row_busmaster,
    "BUSMASTER, decimal": _row_busmaster_decimal,
    "CanKing": _row_canking,
    "CanKing, decimal": _row_canking_decimal,
}
"""Rows without numbers, of programs whose files are recognised by them alone."""
ABOVE = {
    "BUSMASTER": "***BUSMASTER Ver 3.2.2***\n***[START LOGGING SESSION]***\n***HEX***\n***<Time><Tx/Rx><Channel>***",
    "CanKing": "Chn Identifier Flg   DLC  D0...1...2...3...4...5...6..D7       Time     Dir",
}
HEADERS = {
    "1.1": ";$FILEVERSION=1.1\n;$STARTTIME=44548.6028595139\n;\n",
    "1.3": ";$FILEVERSION=1.3\n;$STARTTIME=44548.6028595139\n;\n",
    "2.0": ";$FILEVERSION=2.0\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,I,d,l,D\n;\n",
    "2.1": ";$FILEVERSION=2.1\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n;\n",
}


def listing(row: Row, frames: Sequence[Frame], first: int = 1) -> list[str]:
    return [row(number, *frame) for number, frame in enumerate(frames, first)]


def write(path: Path, lines: Sequence[str]) -> str:
    path.write_text("".join(f"{line}\n" for line in lines))
    return path.name


def info(canalyze: Runner, name: str) -> dict[str, Any]:
    (record,) = map(json.loads, canalyze("info", "--format", "jsonl", name).lines)
    return dict(record)


def frames_of(canalyze: Runner, name: str) -> list[Frame]:
    rows = [json.loads(line) for line in canalyze("decode", "--format", "jsonl", name).lines]
    frames = [row for row in rows if row["kind"] == "frame"]
    return [(round(float(row["t"]) * 1000), int(row["id"], 16), bytes.fromhex(row["data"])) for row in frames]


@pytest.mark.parametrize("form", ROWS)
def test_rows_without_a_header_are_read(canalyze: Runner, tmp_path: Path, form: str) -> None:
    name = write(tmp_path / "a.txt", listing(ROWS[form], session(), first=371))
    record = info(canalyze, name)
    assert record["format"] == ("trc" if form in TRC else "candump")
    assert record["contents"]["dialect"].get("version", form) == form
    assert (record["unreadable"], record["left_out"]) == (None, None)
    assert frames_of(canalyze, name) == session()
    assert canalyze("check", name).code == 0


@pytest.mark.parametrize("form", ROWS | OTHERS)
def test_what_is_pasted_is_read(canalyze: Runner, tmp_path: Path, form: str) -> None:
    rows = listing((ROWS | OTHERS)[form], session())
    name = write(tmp_path / "a.txt", ["This is what I see:", "```", *(f"> {row}" for row in rows), "```"])
    assert frames_of(canalyze, name) == session()
    assert info(canalyze, name)["left_out"] is None


@pytest.mark.parametrize("mark", ["`{}`", "<p>{}</p>", "{}<br>", "> `{}`", "| {} |"])
@pytest.mark.parametrize("form", ROWS | OTHERS)
def test_mark_up_around_rows_is_none_of_them(canalyze: Runner, tmp_path: Path, form: str, mark: str) -> None:
    rows = [mark.format(row) for row in listing((ROWS | OTHERS)[form], session())]
    name = write(tmp_path / "a.txt", rows)
    assert frames_of(canalyze, name) == session()
    assert (info(canalyze, name)["left_out"], info(canalyze, name)["unreadable"]) == (None, None)
    byte = "000 " if form == "BUSMASTER, decimal" else "  0 " if form == "CanKing, decimal" else "00 "
    shorter = write(tmp_path / "b.txt", [*rows[:-1], rows[-1].replace(byte, "", 1)])
    assert len(frames_of(canalyze, shorter)) == len(session()) - 1


@pytest.mark.parametrize("form", OTHERS)
def test_rows_of_other_programs_are_read(canalyze: Runner, tmp_path: Path, form: str) -> None:
    rows = listing(OTHERS[form], session())
    head = ABOVE.get(form)
    name = write(tmp_path / "a.log", ([head] if head else []) + rows)
    record = info(canalyze, name)
    assert (record["format"], record["unreadable"], record["left_out"]) == ("rows", None, None)
    assert record["contents"]["dialect"] == {"program": form.split(",")[0]}
    assert frames_of(canalyze, name) == session()
    assert canalyze("check", name).code == 0
    one = write(tmp_path / "b.log", rows[:1])
    assert frames_of(canalyze, one) == session()[:1]


@pytest.mark.parametrize("inline", [False, True])
def test_messages_that_ros_prints_are_read(canalyze: Runner, tmp_path: Path, inline: bool) -> None:
    text = "$ ros2 topic echo /from_can_bus\n"
    for at, ident, data in session():
        padded = [*data, *[0] * (8 - len(data))]
        listed = f" {padded}\n" if inline else "\n" + "".join(f"- {byte}\n" for byte in padded)
        text += (
            f"header:\n  stamp:\n    sec: 1700000000\n    nanosec: {at * 1_000_000}\n  frame_id: can1\nid: {ident}\n"
            f"is_rtr: false\nis_extended: false\nis_error: false\ndlc: {len(data)}\ndata:{listed}---\n"
        )
    (tmp_path / "echo.yaml").write_text(text)
    result = canalyze("decode", "--lang", "en", "echo.yaml")
    assert (result.code, result.err) == (0, "")
    first = result.lines[0]
    assert first.startswith("(1700000000.005000000)  can1  60A   [8]  40 00 10 00 00 00 00 00  # SDO request"), first
    assert len([line for line in result.lines if line.startswith("(")]) == len(session())


def test_a_damaged_file_is_not_called_whole(canalyze: Runner, tmp_path: Path) -> None:
    packet = bytes.fromhex("0000060108000000") + bytes(8)
    record = struct.pack("<IIII", 1, 0, 16, 16) + packet
    whole = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 227) + 3 * record
    for data, damages in ((whole, 0), (whole[:-3], 1)):
        (tmp_path / "a.pcap").write_bytes(data)
        assert ("no dropped or out-of-order frames" in canalyze("summary", "--lang", "en", "a.pcap").out) is (
            damages == 0
        )
        assert json.loads(canalyze("summary", "--format", "jsonl", "a.pcap").lines[0])["damages"] == damages


@pytest.mark.parametrize("form", HEADERS)
def test_a_header_says_the_same(canalyze: Runner, tmp_path: Path, form: str) -> None:
    rows = listing(TRC[form], session())
    whole = write(tmp_path / "a.trc", [HEADERS[form].rstrip("\n"), *rows])
    assert frames_of(canalyze, whole) == session()
    assert info(canalyze, whole)["left_out"] is None
    cut = write(tmp_path / "b.trc", [HEADERS[form].rstrip("\n"), *rows[:10], *rows[17:]])
    assert info(canalyze, cut)["left_out"] == {"places": 1, "uncounted": 0, "rows": 7}


@pytest.mark.parametrize(
    "row",
    [
        "{at:.6f} {ident:03X}#{compact}",
        "{at:.3f}  can0  {ident:03X}   [{count}]  {spaced}",
        "can0  0x{ident:03X}   [{count}]  {spaced}",
        "RX 0x{ident:03X} [{count}] {spaced}",
        "can0 {ident:03X} [{count}] {dotted}",
        "can0 {ident:03X} [{count}] {colons}",
    ],
)
def test_how_people_write_a_row(canalyze: Runner, tmp_path: Path, row: str) -> None:
    """Stamps without parentheses are times and no interfaces; identifiers have 0x, bytes other marks between them."""

    def written(at: int, ident: int, data: bytes) -> str:
        forms = {"compact": data.hex(), "spaced": data.hex(" "), "dotted": data.hex("."), "colons": data.hex(":")}
        return row.format(at=at / 1000, ident=ident, count=len(data), **forms)

    name = write(tmp_path / "a.txt", [written(*frame) for frame in session()])
    rows = [json.loads(line) for line in canalyze("decode", "--format", "jsonl", name).lines]
    frames = [one for one in rows if one["kind"] == "frame"]
    assert [(int(one["id"], 16), bytes.fromhex(one["data"])) for one in frames] == [frame[1:] for frame in session()]
    assert len({one["bus"] for one in frames}) == 1
    times = [None if one["t"] is None else round(float(one["t"]) * 1000) for one in frames]
    assert times == [frame[0] if "{at" in row else None for frame in session()]
    assert not [one for one in rows if one["kind"] == "finding"]


@pytest.mark.parametrize("row", ["601 [8] 40.00.10.00.00.00.00", "601 [8] 40.00 10.00 00.00 00.00", "0x 601 [8] 40"])
def test_what_is_no_whole_row_is_no_frame(canalyze: Runner, tmp_path: Path, row: str) -> None:
    name = write(tmp_path / "a.txt", ["can0  701   [1]  05", f"can0 {row}"])
    rows = [json.loads(line) for line in canalyze("decode", "--format", "jsonl", name).lines]
    assert [one["id"] for one in rows if one["kind"] == "frame"] == ["701"]


@pytest.mark.parametrize("form", ROWS)
@pytest.mark.parametrize("missing", [1, 2, 19])
def test_a_jump_of_the_numbers_is_a_gap(canalyze: Runner, tmp_path: Path, form: str, missing: int) -> None:
    rows = listing(ROWS[form], session())
    name = write(tmp_path / "a.txt", [*rows[:12], *rows[12 + missing :]])
    assert info(canalyze, name)["left_out"] == {"places": 1, "uncounted": 0, "rows": missing}
    for lang, good in (("en", "no dropped or out-of-order frames"), ("zh", "未见丢帧")):
        report = canalyze("summary", "--lang", lang, name)
        assert good not in report.out
        assert f"CAP008 row 12 is followed by row {13 + missing}" in report.err or lang == "zh"
    found = [json.loads(line) for line in canalyze("check", "--format", "jsonl", name).lines]
    codes = [row["code"] for row in found if row["kind"] == "finding" and row["severity"] != "info"]
    assert codes == ["CAP008"]


@pytest.mark.parametrize("form", ROWS)
def test_a_mark_is_a_gap_and_the_numbers_tell_how_many(canalyze: Runner, tmp_path: Path, form: str) -> None:
    rows = listing(ROWS[form], session())
    for marks, left_out in (
        (["..."], {"places": 1, "uncounted": 0, "rows": 6}),
        (["[...]", "(3 frames dropped)"], {"places": 1, "uncounted": 0, "rows": 6}),
    ):
        name = write(tmp_path / "a.txt", [*rows[:12], *marks, *rows[18:]])
        assert info(canalyze, name)["left_out"] == left_out
    for mark, left_out in (
        ("\u2026", {"places": 1, "uncounted": 1, "rows": 0}),
        ("-- snip --", {"places": 1, "uncounted": 1, "rows": 0}),
        ("(3 frames dropped)", {"places": 1, "uncounted": 0, "rows": 3}),
        ("12 frames omitted", {"places": 1, "uncounted": 0, "rows": 12}),
        ("\uff08\u4e2d\u95f4\u7701\u756525\u5e27\uff09", {"places": 1, "uncounted": 0, "rows": 25}),
    ):
        name = write(tmp_path / "a.txt", [*rows[:12], mark, *listing(ROWS[form], session()[18:])])
        record = info(canalyze, name)
        assert (record["left_out"], record["unreadable"]) == (left_out, None), mark
        assert "no dropped or out-of-order frames" not in canalyze("summary", "--lang", "en", name).out
        whole = write(tmp_path / "b.txt", rows)
        assert "no dropped or out-of-order frames" in canalyze("summary", "--lang", "en", whole).out


@pytest.mark.parametrize("form", ROWS)
def test_numbers_that_begin_anew_or_run_back_are_no_gap(canalyze: Runner, tmp_path: Path, form: str) -> None:
    row, frames = ROWS[form], session()
    for numbers in (
        [*range(1, 21), *range(1, 21)],
        [*range(7, 47)],
        [*range(40, 0, -1)],
        [1] * 40,
        [number // 2 for number in range(2, 42)],
    ):
        rows = [row(number, *frame) for number, frame in zip(numbers, frames, strict=True)]
        assert info(canalyze, write(tmp_path / "a.txt", rows))["left_out"] is None, numbers


@pytest.mark.parametrize("form", ["1.1", "1.3", "2.1"])
def test_rows_that_are_no_frames_are_rows(canalyze: Runner, tmp_path: Path, form: str) -> None:
    rows = listing(TRC[form], session())
    kinds = {
        "1.1": [
            "     5)        40.3  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY ",
            "     6)        50.3  Error      0008  4  00 00 00 00",
        ],
        "1.3": [
            "     5)        40.300 1  Warng FFFFFFFF -  4    00 00 00 08 BUSHEAVY",
            "     6)        50.300 1  Error     0008 -  0",
        ],
        "2.1": [
            "      5        40.300 ST 1          Rx -  4    00 00 00 08",
            "      6        50.300 ER 1          Rx -  5    04 00 02 00 00",
        ],
    }[form]
    for other in (kinds[1], rows[5][:-3] + "ZZ"):
        name = write(tmp_path / "a.trc", [*rows[:4], kinds[0], other, *rows[6:]])
        assert info(canalyze, name)["left_out"] is None, other


def test_what_python_can_writes_leaves_nothing_out(canalyze: Runner, tmp_path: Path) -> None:
    source = random.Random(16)
    for version in can.io.trc.TRCFileVersion.V1_0, can.io.trc.TRCFileVersion.V2_1:
        with can.TRCWriter(tmp_path / "a.trc") as writer:
            writer.file_version = version
            for at in range(500):
                kind = source.choice(({}, {"is_remote_frame": True}, {"is_error_frame": True}, {"is_fd": True}))
                data = b"" if "is_remote_frame" in kind else bytes(4)
                writer(can.Message(at / 100, 0x181, False, data=data, channel=source.randrange(2), **kind))
        record = info(canalyze, "a.trc")
        assert record["frames"] > 50
        assert record["left_out"] is None
        lines = [line for line in (tmp_path / "a.trc").read_text().splitlines() if not line.startswith(";")]
        assert info(canalyze, write(tmp_path / "b.trc", lines))["frames"] == record["frames"]


@pytest.mark.parametrize("piece", [1, 7, 4096])
def test_no_chunking_changes_what_is_found(piece: int) -> None:
    for form, row in ROWS.items():
        text = "\n".join(["A trace:", "...", *listing(row, session())]).encode()
        told = [sniff(text[:end], False) for end in range(0, 200, piece)]
        assert set(told) <= {None, sniff(text, True)}, form


@pytest.mark.parametrize("form", TRC)
def test_prose_is_no_kind_of_row(canalyze: Runner, tmp_path: Path, form: str) -> None:
    prose = ["So here I have it:", "Look at what I see in it"]
    name = write(tmp_path / "a.txt", [prose[0], *listing(TRC[form], session()), prose[1]])
    record = info(canalyze, name)
    assert (record["unreadable"]["count"], record["contents"]["passed_over"]) == (2, [])
    assert record["frames"] == len(session())


def test_only_marks_are_marks() -> None:
    assert (omission(b"..."), omission(b"[7 lines skipped]"), omission("\u4ee5\u4e0b\u7565".encode())) == (-1, 7, -1)
    assert [omission(line) for line in (b"", b"# remark", b"nothing was lost", b"\xff\xfe", b"-----")] == [None] * 5


@pytest.mark.parametrize("digits", ["02x", "03x", "03X", "08x"])
def test_an_identifier_that_is_listed_twice_counts_in_hexadecimal(
    canalyze: Runner, tmp_path: Path, digits: str
) -> None:
    """As Wireshark's list does: 133 and 389 are hexadecimal numbers, too."""
    sent: list[Frame] = [(10 * at, (0x80, 0x85, 0x185, 0x605, 0x705)[at % 5], b"\x05") for at in range(1, 11)]
    rows = [f"{at / 1000:.6f}  CAN  ID: {it} (0x{it:{digits}}), Length: 1  {data.hex()}" for at, it, data in sent]
    assert frames_of(canalyze, write(tmp_path / "a.txt", rows)) == sent
    assert frames_of(canalyze, write(tmp_path / "b.txt", [rows[1]])) == sent[1:2]
