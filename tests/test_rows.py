"""Rows of frames that other programs list: every layout, with every frame exact, and every cell.

Of cells: what each column, time, direction and unit says, and what is refused. Must not: test formats that have a
reader of their own.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
from captures import DATA, session_output
from conftest import Runner

from canalyze import _core

FRAMES = [(0x70A, "00"), (0x60A, "4017100000000000"), (0x58A, "4B171000E8030000"), (0x080, ""), (0x70A, "7F")]
"""A heartbeat, a transfer, a SYNC without data, and another heartbeat."""
SIDES = ("Rx", "Tx", "Rx", "Rx", "Rx")
LAYOUTS: dict[str, str] = json.loads((DATA / "layouts.json").read_text("utf-8"))
"""These frames, as other programs list them."""


def read(text: str | bytes, chunk: int = 0) -> list[dict[str, object]]:
    data = text if isinstance(text, bytes) else text.encode()
    pieces = [data] if not chunk else [data[at : at + chunk] for at in range(0, len(data), chunk)]
    output = session_output(pieces, name="a.txt", input_format="rows", output_format="jsonl", lang="en")
    return [row for row in map(json.loads, output.splitlines()) if row["kind"] == "frame"]


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_frame_is_exact(name: str) -> None:
    rows = read(LAYOUTS[name])
    assert [(int(str(row["id"]), 16), row["data"]) for row in rows] == FRAMES
    assert all(row["line"] for row in rows)


@pytest.mark.parametrize("name", LAYOUTS)
def test_its_format_is_seen(name: str) -> None:
    assert _core.sniff(LAYOUTS[name].encode(), True) == "rows"
    assert _core.sniff(f"Dear all, here is the trace:\n\n{LAYOUTS[name]}".encode(), True) == "rows"


@pytest.mark.parametrize("name", LAYOUTS)
@pytest.mark.parametrize("chunk", [1, 7, 64])
def test_however_it_is_cut(name: str, chunk: int) -> None:
    assert read(LAYOUTS[name], chunk) == read(LAYOUTS[name])


@pytest.mark.parametrize("name", LAYOUTS)
def test_prose_around_it_is_no_frame_and_no_damage(canalyze: Runner, tmp_path: Path, name: str) -> None:
    lines = ["Hello, my node does not answer:", "", *LAYOUTS[name].splitlines(), "Logging stopped.", "Any idea?", ""]
    (tmp_path / "a.txt").write_text("\n".join(lines))
    done = canalyze("decode", "--format", "jsonl", "a.txt")
    assert (done.code, done.err) == (0, "")
    assert sum(line.startswith('{"kind":"frame"') for line in done.lines) == len(FRAMES)


@pytest.mark.parametrize(("name", "times"), json.loads((DATA / "layout_times.json").read_text()).items())
def test_times_are_exact(name: str, times: list[str | None]) -> None:
    assert [row["t"] for row in read(LAYOUTS[name])] == times


@pytest.mark.parametrize("name", ["trace window", "printer", "savvycan", "zlg", "canpro"])
def test_directions(name: str) -> None:
    assert [str(row["dir"]).title() for row in read(LAYOUTS[name])] == list(SIDES)


def test_a_chinese_encoding_is_seen(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_bytes(LAYOUTS["zlg"].encode("gb18030"))
    (tmp_path / "b.txt").write_text(LAYOUTS["zlg"], encoding="utf-8")
    one, other = (canalyze("decode", name).out for name in ("a.txt", "b.txt"))
    assert one == other and len(one.splitlines()) == len(FRAMES)


LISTED = [name for name in LAYOUTS if any(word in LAYOUTS[name] for word in ("LEN", "DLC", "长度", "DL:"))]
LISTED += ["with lengths", "with two digits of length", "with a prefix", "eight digits", "trace window", "slcan"]
"""Layouts that list a length."""


@pytest.mark.parametrize("name", LISTED)
def test_a_row_that_lacks_a_byte_is_no_frame(name: str) -> None:
    """A length that does not fit is damage, not another frame."""
    broken = LAYOUTS[name]
    for whole in ("4B 17 10 00 E8 03 00 00", "4B,17,10,00,E8,03,00,00", "4B171000E8030000"):
        broken = broken.replace(whole, whole[:-3] if " " in whole or "," in whole else whole[:-2])
    assert broken != LAYOUTS[name]
    assert [row["data"] for row in read(broken)] == [data for _, data in FRAMES if not data.startswith("4B")]


@pytest.mark.parametrize(
    "name", ["with lengths", "with two digits of length", "eight digits", "trace window", "savvycan"]
)
def test_a_row_that_lacks_a_byte_is_said(canalyze: Runner, tmp_path: Path, name: str) -> None:
    text = LAYOUTS[name].replace("4B 17 10 00 E8 03 00 00", "4B 17 10").replace("4B,17,10,00,E8,03,00,00", "4B,17,10")
    (tmp_path / "a.txt").write_text(text)
    done = canalyze("--lang", "en", "decode", "--format", "jsonl", "a.txt")
    assert sum(line.startswith('{"kind":"frame"') for line in done.lines) == len(FRAMES) - 1
    assert len(done.complaints) == 1 and "a.txt:" in done.err and "cannot be read" in done.err


@pytest.mark.parametrize("before", [1, 63, 64, 65, 200, 1000])
def test_rows_before_the_first_that_shows_what_they_are_are_kept(before: int) -> None:
    """Data of PDOs alone show nothing; the transfer behind them does."""
    rows = read("181 11 22\n" * before + LAYOUTS["bare"])
    assert len(rows) == before + len(FRAMES)
    assert read("181 11 22\n" * before) == []


@pytest.mark.parametrize(
    "text",
    [
        "CAN 1 FFFFFFFF Rx 1 00\nCAN 1 FFFFFFFF Rx 1 00\n",
        "705 05\n0xFFFFFFFF 00\n0xFFFFFFFF 00\n",
        "0xFFFFFFFF 1 00\n0xFFFFFFFF 1 00\n0.5 705 Rx 1 05\n",
        "Time,ID,DLC,Data\n99999999999999999999,FFFFFFFF,8,0\n-1,705,99999999999,0\n",
    ],
)
def test_numbers_beyond_their_range_are_no_frames(text: str) -> None:
    assert all(int(str(row["id"]), 16) <= 0x1FFF_FFFF for row in read(text))


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("Time,ID,DLC,Data\n0.1,60A,3,40 8 0\n", "400800"),
        ("Time,ID,DLC,Data\n0.1,601,3,40 8 0\n", "400800"),
        ("Time,ID,DLC,Data\n0.1,1546,3,64 8 0\n", "400800"),
        ("Time,ID,DLC,Data\n0.1,705,2,255 8\n", "FF08"),
    ],
)
def test_decimal_bytes_are_told_from_short_ones(text: str, data: str) -> None:
    """A byte of three digits, or one digit beside an identifier of four, is decimal; one digit alone is not."""
    assert [row["data"] for row in read(text)] == [data]


def test_remote_frames_have_no_bytes() -> None:
    rows = read("0.1 705 Rx r 1\n0.2 705 Rx d 1 7F\n")
    assert [(row["rtr"], row["data"]) for row in rows] == [(True, ""), (False, "7F")]


@pytest.mark.parametrize(
    "text",
    [
        "the ID and the data of a node\n",
        "601 is the request of node 1\n",
        "00000000  7f 45 4c 46 02 01 01 00  00 00 00 00 00 00 00 00\n",
        "total 24\ndrwxr-xr-x 2 root root 4096 May 1 10:00 src\n",
        "add\nbad\nface\n",
        "12 34 56 78\n",
        "2024-05-09 10:00:00 INFO started\n",
    ],
)
def test_prose_is_no_row(text: str) -> None:
    assert read(text) == []
    assert _core.sniff(text.encode(), True) == "candump"


@pytest.mark.parametrize("seed", range(200))
def test_any_bytes_do_not_fail(seed: int) -> None:
    """Layouts with bytes changed, removed and doubled, in any pieces: the same result, and no panic."""
    rng = random.Random(seed)
    data = bytearray(rng.choice(list(LAYOUTS.values())).encode())
    for _ in range(rng.randrange(1, 12)):
        place = rng.randrange(len(data))
        match rng.randrange(3):
            case 0:
                data[place] = rng.randrange(256)
            case 1:
                del data[place]
            case _:
                data[place:place] = data[place : place + rng.randrange(1, 40)]
    assert read(bytes(data), rng.randrange(1, 50)) == read(bytes(data))


def test_an_unknown_format_shows_its_first_line(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("\nDear Sir or Madam,\nno frames\n")
    done = canalyze("--lang", "en", "decode", "a.txt")
    assert done.code == 2 and len(done.complaints) == 1
    assert 'first line: "Dear Sir or Madam,"' in done.err and "an identifier and bytes" in done.err


CELLS = [
    json.loads(line) for line in (DATA / "row_cells.jsonl").read_text("utf-8").splitlines() if not line.startswith("#")
]
"""Texts, and the frames in them, or what these keys of theirs say."""


@pytest.mark.parametrize(("text", "wanted"), CELLS)
def test_what_a_row_says(text: str, wanted: str | dict[str, list[object]]) -> None:
    rows = read(text)
    if isinstance(wanted, str):
        assert " ".join(f"{int(str(row['id']), 16):X}#{row['data']}" for row in rows) == wanted
    else:
        assert {key: [row[key] for row in rows] for key in wanted} == wanted


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


def test_marks_of_omitted_rows_are_a_gap(canalyze: Runner, tmp_path: Path) -> None:
    for name in ("names", "objects", "slcan", "zlg"):
        lines = LAYOUTS[name].splitlines()
        (tmp_path / "a.txt").write_text("\n".join([*lines[:4], "(3 frames dropped)", *lines[4:], ""]))
        record = json.loads(canalyze("info", "--format", "jsonl", "a.txt").out)
        assert (record["left_out"], record["frames"]) == ({"places": 1, "uncounted": 0, "rows": 3}, len(FRAMES)), name
