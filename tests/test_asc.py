"""Vector's ASC: logs by other programs' writers beside what those programs read, and our own beside their readers.

The published logs lie in `../shared/corpus` on some machines. python-can's reading of them is no oracle: where it
differs from the file, the file is right, and `DIFFERENT` says why. What this file must not do: test lines one by one
(the core's own tests do).
"""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
from decimal import Decimal
from pathlib import Path
from typing import Any

import can
import pytest
from captures import SAMPLES, SHARED, Row, session_output, sort_rows

CORPUS = SHARED / "corpus"
PUBLISHED = sorted((CORPUS / "asc").glob("*.asc"))
OWN = sorted(path for path in SAMPLES.glob("*.asc") if path.name != "dialects.asc")
LOGS = sorted(SAMPLES.glob("*.log"))

DIFFERENT: dict[str, dict[int, dict[str, Any]]] = {
    # A raw length code 13 of a classic frame is not the length of an FD frame.
    "issue_1299.asc": {2: {"len": 8}},
    # 64 bytes cannot be a classic frame; python-can keeps eight of them.
    "single_frame.asc": {0: {"data": bytes(range(64)).hex().upper()}},
}
"""By file and number of the frame from 0: what the file has where python-can reads something else."""


def frames(text: bytes, form: str = "asc") -> list[Row]:
    """Our reading."""
    return sort_rows(session_output([text], output_format="jsonl", lang="en", input_format=form)).frames


def identifier(row: Row) -> str:
    """`601`, `18EBFF00x`; an error frame has none."""
    if row["err"]:
        return "error"
    return f"{int(row['id'], 16):X}" + ("x" if row["ext"] else "")


def since_first(rows: list[Row]) -> list[Decimal | None]:
    """The times since the first frame; None of a frame without a stamp, as in the samples that have none."""
    times = [None if row["t"] is None else Decimal(row["t"]) for row in rows]
    start = next((time for time in times if time is not None), None)
    return [None if time is None or start is None else time - start for time in times]


@pytest.mark.parametrize("path", PUBLISHED, ids=lambda path: path.name)
def test_the_published_logs_beside_python_can(path: Path) -> None:
    reference = json.loads((CORPUS / "transcripts" / "python_can_reference.json").read_text())
    theirs = reference["files"][f"asc/{path.name}"]["list"]
    ours = frames(path.read_bytes())
    assert len(ours) == len(theirs) > 0
    for number, (row, line) in enumerate(zip(ours, theirs, strict=True)):
        words = line.split()
        stamp, channel, direction, name, kind, length = words[:6]
        expected = {"len": int(length.removeprefix("dlc=")), "data": (words[6:] or [""])[0]}
        expected |= DIFFERENT.get(path.name, {}).get(number, {})
        assert Decimal(row["t"]) == Decimal(stamp)
        assert row["bus"] == f"can{channel.removeprefix('ch=')}"
        assert bool(row["err"]) == (kind == "E")
        if kind == "E":
            continue
        assert bool(row["rtr"]) == (kind == "R")
        assert (identifier(row), row["dir"]) == (name, direction.lower())
        assert {"len": row["len"], "data": row["data"]} == expected


@pytest.mark.skipif(shutil.which("log2asc") is None, reason="log2asc is not installed")
@pytest.mark.parametrize("options", [[], ["-4"], ["-n"], ["-f"]], ids=lambda options: "".join(options) or "plain")
@pytest.mark.parametrize("path", LOGS, ids=lambda path: path.name)
def test_what_log2asc_writes(path: Path, options: list[str]) -> None:
    lines = [line for line in path.read_bytes().splitlines(keepends=True) if line.startswith(b"(")]
    if not lines or len(lines) != path.read_bytes().count(b"\n("):
        lines = [line for line in lines if re.match(rb"\([\d.]+\) \S+ [0-9A-F]+#", line)]
    text = b"".join(lines)
    expected = frames(text, "candump")
    if not expected:
        pytest.skip("no frames with stamps")
    buses = sorted({row["bus"] for row in expected})
    done = subprocess.run(["log2asc", *options, *buses], input=text, capture_output=True, check=True)
    ours = frames(done.stdout)
    assert len(ours) == len(expected)
    start = Decimal(expected[0]["t"])
    step = Decimal("0.0001") if "-4" in options else Decimal("0.000001")
    for row, other in zip(ours, expected, strict=True):
        assert row["bus"] == f"can{buses.index(other['bus'])}"
        assert abs(Decimal(row["t"]) - (Decimal(other["t"]) - start)) <= step
        if other["err"]:
            # log2asc has no details of an error frame, and with -f writes it as a data frame.
            assert row["err"] or "-f" in options
            continue
        assert identifier(row) == identifier(other)
        assert (row["data"], bool(row["rtr"])) == (other["data"], bool(other["rtr"]))
        assert bool(row["fd"]) == bool(other["fd"])


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.name)
def test_the_own_logs_are_what_the_candump_ones_are(path: Path) -> None:
    ours = frames(path.read_bytes())
    expected = frames(path.with_suffix(".log").read_bytes(), "candump")
    assert len(ours) == len(expected) > 0
    assert since_first(ours) == since_first(expected)
    for row, other in zip(ours, expected, strict=True):
        for key in ("bus", "id", "ext", "rtr", "fd", "err", "dir", "len", "data"):
            assert row[key] == other[key], key


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.name)
def test_python_can_reads_the_own_logs(path: Path) -> None:
    expected = frames(path.read_bytes())
    with can.ASCReader(path) as reader:
        theirs = list(reader)
    assert len(theirs) == len(expected) > 0
    for message, row in zip(theirs, expected, strict=True):
        assert row["t"] is None or math.isclose(message.timestamp, float(row["t"]), abs_tol=1e-6)
        assert message.is_error_frame == bool(row["err"])
        if row["err"]:
            continue
        assert (message.arbitration_id, message.is_extended_id) == (int(row["id"], 16), row["ext"])
        assert (message.is_remote_frame, message.is_fd) == (row["rtr"], bool(row["fd"]))
        assert bytes(message.data).hex().upper() == row["data"]


@pytest.mark.skipif(shutil.which("asc2log") is None, reason="asc2log is not installed")
@pytest.mark.parametrize("path", OWN, ids=lambda path: path.name)
def test_asc2log_reads_the_own_logs(path: Path) -> None:
    done = subprocess.run(["asc2log", "-I", path], capture_output=True, check=True)
    theirs = frames(done.stdout, "candump")
    expected = frames(path.read_bytes())
    assert len(theirs) == len(expected) > 0
    for row, other in zip(theirs, expected, strict=True):
        assert bool(row["err"]) == bool(other["err"])
        if not other["err"]:
            assert (row["id"], row["ext"], row["rtr"], row["data"]) == (
                other["id"],
                other["ext"],
                other["rtr"],
                other["data"],
            )
            assert bool(row["fd"]) == bool(other["fd"])
