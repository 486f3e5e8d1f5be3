"""One session, twenty dialects of candump: all of them must decode to the same frames and the same transfers.

The recordings and `session.json` come from record_session.py; session.json says what the client asked and got.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES, Analysis, Row, analyze, decoded, frame_identity, log_text, read_log, session_output

RECORDED = SAMPLES / "recorded"
DIALECTS = sorted(path.name for path in RECORDED.glob("session.*") if path.suffix in {".log", ".candump"})
WITH_ABSOLUTE_TIME = {"session.log", "session.L-x.log", "session.ta.candump", "session.ta-x-a.candump"}


@pytest.fixture(scope="module")
def asked() -> list[Row]:
    rows: list[Row] = json.loads((RECORDED / "session.json").read_text())["sdo"]
    return rows


@pytest.fixture(scope="module")
def reference() -> Analysis:
    return decoded(RECORDED / "session.log")


def essence(transfer: Row) -> Row:
    """What must be the same in every dialect: all but the file's own line numbers and times."""
    return {key: value for key, value in transfer.items() if key not in {"t", "duration", "file"}}


def test_there_are_dialects() -> None:
    assert len(DIALECTS) >= 20


def test_the_log_has_every_frame_of_the_file(reference: Analysis) -> None:
    lines = (RECORDED / "session.log").read_text().splitlines()
    written = [line.split()[2].split("#") for line in lines]
    assert len(reference.frames) == len(lines)
    for row, (can_id, data) in zip(reference.frames, written, strict=True):
        if can_id == "20000004":
            assert row["err"]
        else:
            assert row["id"] == can_id
        assert row["rtr"] == data.startswith("R")
        if row["rtr"]:
            assert row["len"] == int(data[1:])
        else:
            assert row["data"].upper() == data


def test_the_transfers_are_what_the_client_asked(reference: Analysis, asked: list[Row]) -> None:
    assert len(reference.transfers) == len(asked)
    for row, wanted in zip(reference.transfers, asked, strict=True):
        for key in ("node", "direction", "index", "sub"):
            assert row[key] == wanted[key], (row, wanted)
        if "abort" in wanted:
            assert row["status"] == "aborted", (row, wanted)
            assert (row["abort"]["code"], row["abort"]["by"]) == (wanted["abort"], "server")
        else:
            assert (row["status"], row["mode"]) == ("ok", wanted["mode"]), (row, wanted)
            assert row["data"].upper() == wanted["data"]
        assert row["reordered"] in (False, 0)


@pytest.mark.parametrize("name", DIALECTS)
def test_a_dialect_says_the_same(name: str, reference: Analysis) -> None:
    said = decoded(RECORDED / name)
    assert [frame_identity(row) for row in said.frames] == [frame_identity(row) for row in reference.frames]
    assert [essence(row) for row in said.transfers] == [essence(row) for row in reference.transfers]
    assert not said.above_info(), said.complaint()
    if name in WITH_ABSOLUTE_TIME:
        assert [row["t"] for row in said.frames] == [row["t"] for row in reference.frames]


@pytest.mark.parametrize("name", DIALECTS)
def test_the_text_of_a_dialect_can_be_read_again(name: str) -> None:
    once = session_output([(RECORDED / name).read_bytes()], name=name)
    assert session_output([once], name=name) == once


NEWER_CANDUMP: dict[str, tuple[str, str, str]] = {
    "-N in the log form": ("session.log", r"\.(\d{6})\)", r".\g<1>000)"),
    "-N with -t a": ("session.ta.candump", r"\.(\d{6})\)", r".\g<1>000)"),
    "-N with -t d": ("session.td.candump", r"\.(\d{6})\)", r".\g<1>000)"),
    "-N with -t A": ("session.tA.candump", r"\.(\d{6})\)", r".\g<1>000)"),
    "-8": ("session.plain.candump", r"\[(\d)\]", r"{\g<1>}"),
}
"""Options of a newer candump than the one that recorded: their form is made from a recording."""


@pytest.mark.parametrize("option", NEWER_CANDUMP)
def test_a_newer_candump_says_the_same(option: str, reference: Analysis) -> None:
    name, pattern, replacement = NEWER_CANDUMP[option]
    text = re.sub(pattern, replacement, (RECORDED / name).read_text())
    said = analyze(text.encode(), name=name)
    assert [frame_identity(row) for row in said.frames] == [frame_identity(row) for row in reference.frames]
    assert [essence(row) for row in said.transfers] == [essence(row) for row in reference.transfers]
    assert not said.above_info(), said.complaint()


def test_a_dropcount_line_is_a_gap_and_no_frame(tmp_path: Path, reference: Analysis) -> None:
    lines = (RECORDED / "session.plain.candump").read_text().splitlines(keepends=True)
    lines.insert(20, "DROPCOUNT: dropped 3 CAN frames on 'vcan0' socket (total drops 3)\n")
    capture = tmp_path / "drops.candump"
    capture.write_text("".join(lines))
    said = decoded(capture)
    assert [frame_identity(row) for row in said.frames] == [frame_identity(row) for row in reference.frames]
    errors: list[Any] = [finding for finding in said.findings if finding["severity"] == "error"]
    assert not errors, errors


def test_the_reader_of_the_tests_writes_what_it_read() -> None:
    text = (SAMPLES / "two-nodes-interleaved.log").read_bytes()
    plain = b"".join(line for line in text.splitlines(keepends=True) if not line.startswith(b"#"))
    assert log_text(read_log(text)) == plain
