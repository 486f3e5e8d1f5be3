"""`check --incidents`: which problems fail, and how each report has them.

What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from conftest import Runner
from test_diagnosis import lost


@pytest.fixture(autouse=True)
def captures(tmp_path: Path) -> None:
    """One in which node 5 is lost, one in which it comes back, one in which all is well."""
    (tmp_path / "lost.log").write_bytes(lost(20))
    both = lost(20, until=30) + lost(60, until=60).replace(b"(170000000", b"(170000001")
    (tmp_path / "back.log").write_bytes(both)
    (tmp_path / "well.log").write_bytes(lost(40))


@pytest.mark.parametrize(
    ("file", "incidents", "fails"),
    [
        ("lost.log", "stands", True),
        ("lost.log", "over", True),
        ("lost.log", "never", False),
        ("back.log", "stands", False),
        ("back.log", "over", True),
        ("well.log", "over", False),
    ],
)
def test_which_problems_fail(canalyze: Runner, file: str, incidents: str, fails: bool) -> None:
    done = canalyze("check", file, "--incidents", incidents, "--fail-on", "never", "--lang", "en")
    assert done.code == fails, done.out
    assert ("problem frame" in done.out) == (file != "well.log")


def test_the_configuration_may_ask(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "canalyze.toml").write_text('[check]\nfail_on = "never"\nincidents = "stands"\n')
    assert canalyze("check", "lost.log").code == 1
    assert canalyze("check", "lost.log", "--incidents", "never").code == 0
    (tmp_path / "canalyze.toml").write_text('[check]\nincidents = "always"\n')
    assert canalyze("check", "lost.log").code == 2


def test_without_it_nothing_is_said(canalyze: Runner) -> None:
    assert "problem" not in canalyze("check", "lost.log", "--lang", "en").out


def test_reports(canalyze: Runner, tmp_path: Path) -> None:
    files = ["--junit", "j.xml", "--sarif", "s.json", "--format", "jsonl"]
    done = canalyze("check", "lost.log", "well.log", "--incidents", "stands", "--fail-on", "never", *files)
    assert done.code == 1
    rows = [json.loads(line) for line in done.out.splitlines()]
    (problem,) = (row for row in rows if row["kind"] == "incident")
    assert (problem["incident"], problem["node"], problem["status"], problem["fails"]) == (
        *("node-silent", 5, "stands", True),
    )
    root = ET.parse(tmp_path / "j.xml").getroot()
    failing = [case.get("name") or "" for case in root.iter("testcase") if case.find("failure") is not None]
    assert len(failing) == 1 and "node-silent can0 5" in failing[0]
    assert root.get("failures") == "1"
    (run,) = json.loads((tmp_path / "s.json").read_text())["runs"]
    (result,) = (one for one in run["results"] if one["ruleId"] == "node-silent")
    assert run["tool"]["driver"]["rules"][result["ruleIndex"]]["id"] == "node-silent"
    assert result["level"] == "error"
    assert result["codeFlows"][0]["threadFlows"][0]["locations"]
    said = canalyze("check", "lost.log", "--incidents", "stands", "--format", "github").out
    assert any(line.startswith("::error ") and "node-silent" in line for line in said.splitlines())
