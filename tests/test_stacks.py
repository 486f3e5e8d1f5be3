"""Sessions of real stacks: the program must report the transfers that happened, and no fault that did not.

`samples/stacks/NAME.json` says what happened in NAME.log; each capture is also read in candump's console form with
`-t a -x`, made from the log here. Third-party transcripts, and the table of what is said of captures that other people
published, are compared where they are at hand.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES, Row, decoded, sdo_rows
from compare_transcripts import DEFAULT_DIRECTORY, compare
from corpus_table import CORPUS, TABLE, captures, row, table

CAPTURES = sorted((SAMPLES / "stacks").glob("*.log"))
FORMS = ("log", "console")


def console_form(log: str) -> str:
    """The same capture as `candump -t a -x` prints it."""
    lines = []
    for line in log.splitlines():
        stamp, bus, frame = line.split()
        can_id, data = frame.split("#")
        if data.startswith("R"):
            shown = f"[{data[1:] or 0}]  remote request"
        elif not data:
            shown = "[0] "
        else:
            shown = f"[{len(data) // 2}]  " + " ".join(data[at : at + 2] for at in range(0, len(data), 2))
        lines.append(f" {stamp}  {bus}  TX - -  {can_id}   {shown}\n")
    return "".join(lines)


def capture_file(log: Path, form: str, scratch: Path) -> Path:
    if form == "log":
        return log
    path = scratch / f"{log.stem}.candump"
    path.write_text(console_form(log.read_text()))
    return path


def wanted_row(truth: Row) -> Row:
    """A transfer of the truth file in the program's words."""
    done = truth["result"] == "ok"
    wanted = {
        "bus": truth["bus"],
        "node": truth["node"],
        "direction": truth["dir"],
        "mode": truth["mode"],
        "index": truth["index"],
        "sub": truth["sub"],
        "status": "ok" if done else "aborted",
        "abort": None if done else (truth["abort_code"], truth["abort_by"]),
        "first_frame": truth["first_line"],
        "last_frame": truth["last_line"],
        "size_indicated": truth["size_announced"],
    }
    if done:
        wanted |= {"size": truth["length"], "data": truth["data"].upper()}
    for name in ("crc_negotiated", "retransmissions"):
        if name in truth:
            wanted[name] = truth[name]
    return wanted


def given_row(row: Row, wanted: Row) -> Row:
    """The same fields of a line of the program."""
    given = {name: row[name] for name in wanted}
    if row["abort"] is not None:
        given["abort"] = (row["abort"]["code"], row["abort"]["by"])
    if "data" in given:
        given["data"] = given["data"].upper()
    return given


def test_the_captures_hold_transfers() -> None:
    truths = [json.loads(path.with_suffix(".json").read_text()) for path in CAPTURES]
    compared = sum(len(truth["sdo"]) for truth in truths)
    print(f"{compared} transfers in {len(truths)} captures are compared, in {len(FORMS)} forms each")
    assert compared > 0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("log", CAPTURES, ids=lambda path: path.stem)
def test_the_transfers_are_those_that_happened(log: Path, form: str, tmp_path: Path) -> None:
    truth: list[Row] = json.loads(log.with_suffix(".json").read_text())["sdo"]
    rows = sdo_rows(capture_file(log, form, tmp_path))
    wanted = [wanted_row(one) for one in truth]
    assert len(rows) == len(wanted)
    for found, want in zip(rows, wanted, strict=True):
        assert given_row(found, want) == want
    print(f"{log.stem}, {form}: {len(rows)} transfers compared")


def is_natural(finding: Row, natural: list[dict[str, Any]]) -> bool:
    """Whether the truth lists this finding's frame (or the one it names as its cause)."""
    lines = {event["line"] for event in natural}
    return finding["frame"] in lines or finding["cause_frame"] in lines


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("log", CAPTURES, ids=lambda path: path.stem)
def test_nothing_above_info_but_what_happened(log: Path, form: str, tmp_path: Path) -> None:
    truth = json.loads(log.with_suffix(".json").read_text())
    said = decoded(capture_file(log, form, tmp_path))
    assert len(said.frames) == truth["frames"]
    alarms = [finding for finding in said.above_info() if not is_natural(finding, truth["natural"])]
    assert not alarms, said.complaint()


@pytest.mark.skipif(not DEFAULT_DIRECTORY.is_dir(), reason="the third-party transcripts are not beside this checkout")
def test_the_transcripts_say_what_their_authors_say() -> None:
    result = compare(DEFAULT_DIRECTORY)
    print(result.summary)
    assert result.answers > 0
    assert not result.wrong, result.summary


@pytest.mark.skipif(not CORPUS.is_dir(), reason="no corpus of captures on this machine")
def test_the_table_is_that_of_the_program(tmp_path: Path) -> None:
    assert TABLE.read_text(encoding="utf-8") == table(tmp_path), "python tests/corpus_table.py"


@pytest.mark.skipif(not CORPUS.is_dir(), reason="no corpus of captures on this machine")
def test_every_capture_is_in_it(tmp_path: Path) -> None:
    files = captures()
    assert len(files) >= 30
    assert next(row(files[0], tmp_path)).count("/") == 1


def test_the_table_names_files_only() -> None:
    rows = [line for line in TABLE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")][1:]
    assert rows
    for line in rows:
        name, *rest = line.strip("| ").split(" | ")
        assert name.count("/") == 1 and not any("/" in cell or "#" in cell for cell in rest), line
