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
