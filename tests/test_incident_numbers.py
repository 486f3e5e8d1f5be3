"""The numbers of problems that a reader sees, and the frames that findings are cited with.

Numbers count from 1 without gaps in the order of reading, the same in every output of a whole capture; a finding stands
at one frame, wherever it is named. What it must not do: test what is found.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from captures import SAMPLES, SHARED, Row, described_beside, session_output
from conftest import Runner
from diagnoses import diagnosed

CAPTURES = [
    SAMPLES / "problems.log",
    *sorted((SAMPLES / "stories").glob("*.log")),
    *sorted((SHARED / "stories").glob("*.log")),
    *(path for path in sorted((SAMPLES / "rules").glob("*.log")) if ".clean." not in path.name),
]
FEW = [SAMPLES / "problems.log", *sorted((SAMPLES / "stories").glob("t0*.log"))]


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_numbers_count_in_the_order_of_reading(path: Path) -> None:
    found = diagnosed(path.read_bytes(), described_beside(path))
    assert [one["id"] for one in found.incidents] == [*range(1, len(found.incidents) + 1)]
    assert found.whole["order"] == sorted(found.whole["order"])
    by_id = {one["id"]: one for one in found.incidents}
    for one in found.incidents:
        assert one["effects"] == sorted(one["effects"])
        assert all(by_id[effect]["cause"]["id"] == one["id"] < effect for effect in one["effects"])
        assert one["cause"] is None or one["id"] in by_id[one["cause"]["id"]]["effects"]
        assert "parts" not in one, "nobody was told of those"
    assert {node["problem"] for node in found.whole["nodes"]} <= {None, *by_id}


@pytest.mark.parametrize("path", FEW, ids=lambda path: path.stem)
def test_a_report_names_all_numbers_once_in_order(canalyze: Runner, path: Path) -> None:
    count = len(diagnosed(path.read_bytes()).incidents)
    done = canalyze("diagnose", "--lang", "en", "--all", str(path))
    told, _, _ = done.out.partition("\nNODES\n")
    heads = [int(one) for one in re.findall(r"^ +(?:→ )?(\d+)  \S", told, re.MULTILINE)]
    assert heads == [*range(1, count + 1)]
    story = canalyze("diagnose", "--lang", "en", "-n", "1", str(path))
    heads = [int(one) for one in re.findall(r"^ *(?:→ )?(\d+)  \S", story.out, re.MULTILINE)]
    assert heads == [*range(1, len(heads) + 1)] and heads, "a story is a row of numbers"


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_a_finding_stands_at_one_frame(path: Path) -> None:
    described = described_beside(path)

    def rows(form: str) -> list[Row]:
        output = session_output([path.read_bytes()], output_format=form, lang="en", network=described)
        return [json.loads(line) for line in output.decode().splitlines()]

    checked = {(one["code"], one["frame"], one["about_frame"]) for one in rows("check") if one["kind"] == "finding"}
    cited = {
        (entry["code"], entry["frame"], entry["about_frame"])
        for one in rows("diagnosis")
        if one["kind"] == "problem"
        for entry in one["findings"]
    }
    # Of many of one kind `check` shows the first, and counts the others.
    shown = {code for code, *_ in checked}
    assert {one for one in cited if one[0] in shown} - checked <= {one for one in cited if one[0] in counted(checked)}


def counted(checked: set[tuple[str, int, int]]) -> set[str]:
    """The rules of which there were several."""
    codes = [code for code, *_ in checked]
    return {code for code in codes if codes.count(code) > 1}


def test_what_is_missing_is_cited_where_it_came_last(canalyze: Runner) -> None:
    path = str(SAMPLES / "stories" / "t01-node-dead.log")
    (checked,) = (line for line in canalyze("check", "--lang", "en", path).lines if line.startswith("  error HBT002"))
    (told,) = (
        line
        for line in canalyze("diagnose", "--lang", "en", "-n", "1", path).lines
        if line.lstrip().startswith("HBT002")
    )
    (frame,) = re.findall(r"frame (\d+)", checked)
    assert f"HBT002 #{frame} " in told
