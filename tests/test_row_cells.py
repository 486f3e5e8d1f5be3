"""Rows of frames that other programs list: what each column, time, direction and unit says, and what is refused."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from captures import DATA
from conftest import Runner
from test_rows import FRAMES, LAYOUTS, read

CELLS = [
    json.loads(line) for line in (DATA / "row_cells.jsonl").read_text("utf-8").splitlines() if not line.startswith("#")
]
"""Texts, and the frames in them."""


@pytest.mark.parametrize(("text", "frames"), CELLS)
def test_what_a_row_says(text: str, frames: str) -> None:
    assert " ".join(f"{int(str(row['id']), 16):X}#{row['data']}" for row in read(text)) == frames


@pytest.mark.parametrize(
    ("cell", "t"),
    [
        ("15:23:01.123", "55381.123"),
        ("15:23:01:123", "55381.123"),
        ("3:23:01 PM", "55381"),
        ("12:00:01 AM", "00001"),
        ("2024-03-12 15:23:01.123", "1710256981.123"),
        ("1710238272123456", "1710238272.123456"),
        ("1710238272123", "1710238272.123"),
        ("0.5", "0.5"),
        ("when", None),
        ("", None),
    ],
)
def test_times_of_cells(cell: str, t: str | None) -> None:
    """A time that cannot be read is none; the frame is there."""
    (row,) = read(f"Timestamp,ID,DLC,Data\n{cell},705,1,05\n")
    assert (row["id"], row["data"]) == ("705", "05")
    assert row["t"] == t or (t is not None and float(str(row["t"])) == float(t))


@pytest.mark.parametrize(("ext", "extended"), [("1", True), ("0", False), ("true", True), ("False", False)])
def test_a_column_says_that_an_identifier_is_long(ext: str, extended: bool) -> None:
    (row,) = read(f"Time,ID,Ext,Data\n0.1,705,{ext},05\n")
    assert row["id"] == ("00000705" if extended else "705")


def test_a_length_that_does_not_fit_is_said(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("Time,ID,DLC,Data\n0.1,60A,8,40 17\n0.2,705,1,05\n")
    done = canalyze("--lang", "en", "decode", "a.csv")
    assert len(done.lines) == 1 and done.complaints == ["a.csv:2: cannot be read: data bytes do not match the length"]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("ID|CS|Index|Sub|Data\n60A|40|1017|00|00 00 00 00\n", "spread over columns or rows"),
        ("kind,start,data,identifier\nid,0.1,,0x60A\nbyte,0.2,0x40,\nbyte,0.3,0x17,\n", "spread over columns or rows"),
        ("ID DLC Data\n385 4 55 2 8 7\n", "hexadecimal (385h) or decimal (181h); name their column ID (hex)"),
        ("time,id,data\n0.1,1234,10\n", "hexadecimal (1234h) or decimal (4D2h)"),
        ("ID;Len;Data\n60G;1;05\n", "cell 1 is not an identifier"),
        ('"t","t_ns","capture","bus","id","extended","dir","len","data"\n1,2,"a","can0",1797,false,,1,"05"\n',
         "a table that canalyze exported"),
        ('{"kind":"frame","t":"1.0","dir":"rx","id":"705","len":1,"data":"05","service":"heartbeat"}\n',
         "a table that canalyze exported"),
    ],
)  # fmt: skip
def test_rows_that_are_refused_say_why(canalyze: Runner, tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "a.txt").write_text(text)
    done = canalyze("--lang", "en", "decode", "a.txt")
    assert done.out == "" and why in done.err
    assert read(text) == []


def test_its_own_export_is_refused(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "e.log").write_text("(1.0) can0 705#05\n(1.1) can0 182#0102\n")
    assert canalyze("export", "e.log", "-o", "frames.csv").code == 0
    done = canalyze("--lang", "en", "decode", "frames.csv")
    assert done.out == "" and "frames.csv:2: cannot be read: a table that canalyze exported" in done.err


def test_a_row_without_an_identifier_among_others_is_said(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "| ID | Len | Data |\n|---|---|---|\n| 705 | 1 | 05 |\n| x | 1 | 05 |\n| sum | 1 | |\n"
    )
    done = canalyze("--lang", "en", "decode", "a.csv")
    assert len(done.lines) == 1 and done.complaints == ["a.csv:4: cannot be read: cell 1 is not an identifier"]


@pytest.mark.parametrize(
    ("text", "t"),
    [
        ("#,Time (ms),ID,Data\n1,12.3,705,05\n", "0.0123"),
        ("| # | Time (ms) | ID | Data |\n|---|---|---|---|\n| 1 | 12.3 | `705` | `05` |\n", "0.0123"),
        ("# Time (ms), ID, Data\n12.3,705,05\n", "0.0123"),
        ("Time [ms]  ID  Len  Data\n12.3  705  1  05\n", "0.0123"),
        ("Time / ms;ID;Data\n12,3;705;05\n", "0.0123"),
        ("1,012  Rx  705  1  05\n", "1.012"),
        ("Time (ms)  Event Kind  ID  Dir  Len  Data\n12.3  CAN  705  Rx  1  05\n", None),
        ("Time (ms)  Event Kind  ID  Dir  Len  Data\n10:00:01.5  CAN  705  Rx  1  05\n", "36001.5"),
        ("m:s.ms.us,Len,ID,Data\n1:02.003.004,1 B,0x705,05\n", "62.003004"),
        ("t7051050064\n", "0.100"),
        ("t70510500000064\n", "0.000100"),
        ("2024年03月12日 10:00:00.5 发送帧：ID=705 长度=1 数据=05\n", "1710237600.5"),
    ],
)
def test_units_of_times(text: str, t: str | None) -> None:
    """Without a fitting heading the unit is unknown, and so is the time."""
    assert [row["t"] for row in read(text)] == [t]


@pytest.mark.parametrize(
    ("stamps", "times"),
    [
        (["EA5F", "0001", "00C8", "0001"], ["59.999", "60.001", "60.200", "120.001"]),
        (["FFFF", "0000"], ["65.535", "65.536"]),
        (["D693A3FF", "00000000"], ["3599.999999", "3600.000000"]),
    ],
)
def test_the_clock_of_an_adapter_begins_again(stamps: list[str], times: list[str]) -> None:
    assert [row["t"] for row in read("".join(f"t705105{stamp}\n" for stamp in stamps))] == times


@pytest.mark.parametrize(
    ("head", "remote", "data"),
    [
        ("RTR", "1", "0"),
        ("Remote", "true", "false"),
        ("RTR", "yes", "no"),
        ("远程帧", "远程帧", "数据帧"),
        ("格式", "远程帧", "数据帧"),
    ],
)
def test_a_column_says_that_a_frame_is_remote(head: str, remote: str, data: str) -> None:
    rows = read(f"Time,ID,{head},DLC,Data\n0.1,705,{remote},1,\n0.2,705,{data},1,05\n")
    assert [(row["rtr"], row["len"], row["data"]) for row in rows] == [(True, 1, ""), (False, 1, "05")]


def test_a_remote_frame_has_the_code_of_its_length() -> None:
    rows = read("ID;DLC;DataLength;RTR;Data\n705;1;0;1;\n60A;8;8;0;4017100000000000\n")
    assert [(row["rtr"], row["len"]) for row in rows] == [(True, 1), (False, 8)]


@pytest.mark.parametrize(
    ("rx", "tx"),
    [("Rx", "Tx"), ("empfangen", "gesendet"), ("Empfangen", "Senden"), ("E", "S"), ("R", "S"), ("in", "out")],
)  # fmt: skip
def test_words_for_a_direction(rx: str, tx: str) -> None:
    rows = read(f"Zeit;Richtung;ID;Data\n0,1;{rx};705;05\n0,2;{tx};60A;4017100000000000\n")
    assert [row["dir"] for row in rows] == ["rx", "tx"]


def test_numbers_are_directions_only_of_programs_that_are_known(canalyze: Runner, tmp_path: Path) -> None:
    text = "TimestampEpoch;Dir;ID;DataBytes\n0.1;0;705;05\n0.2;1;60A;4017100000000000\n"
    assert [row["dir"] for row in read(text)] == ["rx", "tx"]
    other = text.replace("TimestampEpoch", "Time")
    assert [row["dir"] for row in read(other)] == [None, None]
    (tmp_path / "a.csv").write_text(other)
    assert "direction" not in canalyze("--lang", "en", "info", "a.csv").out


def test_decimal_rows_of_canking(canalyze: Runner, tmp_path: Path) -> None:
    """A channel is no row number: identifier 0 and two bytes are no identifier 2."""
    (tmp_path / "a.txt").write_text(
        " 0           0         2    1   0                    12.012300 T\n"
        " 0        1546         8   64  23  16   0   0   0   0   0   12.1 T\n"
        " 0         128         0                              12.2 R\n"
    )
    rows = [json.loads(line) for line in canalyze("decode", "--format", "jsonl", "a.txt").lines if '"frame"' in line]
    rows = [row for row in rows if row["kind"] == "frame"]
    assert [(row["id"], row["data"]) for row in rows] == [("000", "0100"), ("60A", "4017100000000000"), ("080", "")]


def test_time_bus_and_direction_may_be_before_an_object() -> None:
    text = LAYOUTS["objects"].replace('"time"', '"count"')
    text = "".join(f"10:00:0{n}.5 INFO can1 RX {row}\n" for n, row in enumerate(text.splitlines()))
    shown = [(row["t"], row["bus"], row["dir"]) for row in read(text)]
    assert shown == [(f"3600{n}.5", "can1", "rx") for n in range(5)]


def test_a_row_of_another_form_than_most_is_said(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("0.1 Rx 705 8 40 17 10\n" + "0.1 Rx 705 1 05\n" * 3)
    done = canalyze("--lang", "en", "decode", "a.txt")
    assert len(done.lines) == 3 and len(done.complaints) == 1
    assert done.complaints[0].startswith("a.txt:1: cannot be read")


@pytest.mark.parametrize(
    "end", ["0.3;705", "0.3;705;", "0.3;705;2;05 0", "0.", "0.3;7\x005;2;05 06\n", "0.3;705\xb22;05 06\n"]
)
def test_a_row_of_a_table_that_is_cut_or_damaged_is_said(canalyze: Runner, tmp_path: Path, end: str) -> None:
    (tmp_path / "a.txt").write_text(f"Time;ID;Len;Data\n0.1;705;2;05 06\n0.2;705;2;05 07\n{end}", encoding="latin-1")
    done = canalyze("--lang", "en", "decode", "a.txt")
    assert len(done.lines) == 2 and len(done.complaints) == 1
    assert done.complaints[0].startswith("a.txt:4: cannot be read")


def test_an_object_that_is_cut_is_said(canalyze: Runner, tmp_path: Path) -> None:
    whole = json.dumps([{"can_id": 0x705, "data": [5]}] * 2, indent=1)
    (tmp_path / "a.json").write_text(whole[: whole.rindex("5") + 1])
    done = canalyze("--lang", "en", "decode", "a.json")
    assert len(done.lines) == 1 and len(done.complaints) == 1 and "line is truncated" in done.err


@pytest.mark.parametrize("head", ["", "Time  ID  Len  Data\n"])
@pytest.mark.parametrize("rows", [1, 3, 40])
def test_a_pipe_shows_its_rows_when_it_rests(head: str, rows: int) -> None:
    """`tail -f log | canalyze decode -`: what was written is shown before anything further is."""
    text = head + "".join(f"0.{n:03}  60A  8  40 17 10 00 00 00 00 {n:02X}\n" for n in range(rows))
    command = [sys.executable, "-m", "canalyze", "--lang", "en", "decode", "--format", "jsonl", "-"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=os.environ.copy()) as process:
        assert process.stdin and process.stdout
        process.stdin.write(text.encode())
        process.stdin.flush()
        shown = [json.loads(process.stdout.readline()) for _ in range(rows)]
        process.stdin.close()
        assert [row["data"][-2:] for row in shown] == [f"{n:02X}" for n in range(rows)]


BUSMASTER = """***BUSMASTER Ver 3.2.2***
***START DATE AND TIME 1:9:2023 10:11:12:123***
***HEX***
***{mode} MODE***
***<Time><Tx/Rx><Channel><CAN ID><Type><DLC><DataBytes>***
00:00:00:5000 Tx 1 0x60A s 8 40 17 10 00 00 00 00 00
00:00:00:0020 Rx 1 0x58A s 8 4B 17 10 00 E8 03 00 00
...
00:00:01:0000 Rx 1 0x70A s 2 05
"""


@pytest.mark.parametrize(("mode", "times"), [("SYSTEM", ["0.5000", "0.0020"]), ("RELATIVE", ["0.5000", "0.5020"])])
def test_relative_times_of_busmaster(canalyze: Runner, tmp_path: Path, mode: str, times: list[str]) -> None:
    (tmp_path / "a.log").write_text(BUSMASTER.format(mode=mode))
    done = canalyze("--lang", "en", "decode", "--format", "jsonl", "a.log")
    assert [json.loads(line)["t"] for line in done.lines if '"frame"' in line[:20]] == times
    assert "a.log:9: cannot be read: data bytes do not match the length" in done.err
    assert json.loads(canalyze("info", "--format", "jsonl", "a.log").out)["left_out"]["places"] == 1


@pytest.mark.parametrize("text", ["0.1  705  1  05\n0.2  705  1  7F\n", "Time,ID,Data\n0.1,705,05\n0.2,705,7F\n"])
def test_times_may_be_differences(canalyze: Runner, tmp_path: Path, text: str) -> None:
    (tmp_path / "a.txt").write_text(text + "0.2 Rx 705 1 05\n" * 0)
    for stamps, times in (("auto", ["0.1", "0.2"]), ("delta", ["0.1", "0.3"])):
        done = canalyze("decode", "--format", "jsonl", "--stamps", stamps, "a.txt", "--input-format", "rows")
        assert [json.loads(line)["t"] for line in done.lines if '"frame"' in line[:20]] == times


@pytest.mark.parametrize(
    "row",
    [
        "t60A84017",
        "< frame 60A 1.5 40 1G >",
        "Timestamp: 1.5  ID: 060a  S Rx  DL: 8  40 17",
        "0  0000060A  8  40 17 10  1.5 R",
        "10:00:00:0000 Rx 1 0x60A s 8 40",
    ],
)
def test_a_damaged_row_that_says_what_it_is_is_said(canalyze: Runner, tmp_path: Path, row: str) -> None:
    (tmp_path / "a.txt").write_text(f"t705105\n{row}\nt70517F\nTCP connection lost\n")
    done = canalyze("--lang", "en", "decode", "a.txt")
    assert len(done.lines) == 2 and done.complaints == ["a.txt:2: cannot be read: data bytes do not match the length"]


def test_marks_of_omitted_rows_are_a_gap(canalyze: Runner, tmp_path: Path) -> None:
    for name in ("names", "objects", "slcan", "zlg"):
        lines = LAYOUTS[name].splitlines()
        (tmp_path / "a.txt").write_text("\n".join([*lines[:4], "(3 frames dropped)", *lines[4:], ""]))
        record = json.loads(canalyze("info", "--format", "jsonl", "a.txt").out)
        assert (record["left_out"], record["frames"]) == ({"places": 1, "uncounted": 0, "rows": 3}, len(FRAMES)), name
