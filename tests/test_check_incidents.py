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
        ("lost.log", "open", True),
        ("lost.log", "ended", True),
        ("lost.log", "never", False),
        ("back.log", "open", False),
        ("back.log", "ended", True),
        ("well.log", "ended", False),
    ],
)
def test_which_problems_fail(canalyze: Runner, file: str, incidents: str, fails: bool) -> None:
    done = canalyze("check", file, "--problems", incidents, "--fail-on", "never", "--lang", "en")
    assert done.code == fails, done.out
    assert ("problem frame" in done.out) == (file != "well.log")


def test_the_configuration_may_ask(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "canalyze.toml").write_text('[check]\nfail_on = "never"\nincidents = "stands"\n')
    assert canalyze("check", "lost.log").code == 1
    assert canalyze("check", "lost.log", "--problems", "never").code == 0
    (tmp_path / "canalyze.toml").write_text('[check]\nincidents = "always"\n')
    assert canalyze("check", "lost.log").code == 2


def test_without_it_nothing_is_said(canalyze: Runner) -> None:
    assert "problem" not in canalyze("check", "lost.log", "--lang", "en").out


def test_reports(canalyze: Runner, tmp_path: Path) -> None:
    files = ["--junit", "j.xml", "--sarif", "s.json", "--format", "jsonl"]
    done = canalyze("check", "lost.log", "well.log", "--problems", "open", "--fail-on", "never", *files)
    assert done.code == 1
    rows = [json.loads(line) for line in done.out.splitlines()]
    (problem,) = (row for row in rows if row["kind"] == "problem")
    assert (problem["problem"], problem["node"], problem["status"], problem["fails"]) == (
        *("node-silent", 5, "open", True),
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
    said = canalyze("check", "lost.log", "--problems", "open", "--format", "github").out
    assert any(line.startswith("::error ") and "node-silent" in line for line in said.splitlines())


BASE = ("check", "--fail-on", "never", "--problems", "open", "--baseline", "known.json", "--lang", "en")


def test_known_problems_pass_and_new_ones_fail(canalyze: Runner, tmp_path: Path) -> None:
    done = canalyze(*BASE, "--update-baseline", "lost.log")
    assert done.code == 0
    assert json.loads((tmp_path / "known.json").read_text()) == {
        "canalyze_baseline": 1,
        "findings": [],
        "problems": [{"kind": "node-silent", "bus": "can0", "subject": "node 5", "object": None, "count": 1}],
    }
    done = canalyze(*BASE, "lost.log")
    assert (done.code, done.err) == (0, "")
    assert "60 frames: clean, 1 error, 1 in baseline" in done.out
    assert "(baseline allows 1)" in done.out
    (tmp_path / "six.log").write_bytes(lost(20).replace(b" 705#", b" 707#"))
    done = canalyze(*BASE, "lost.log", "six.log")
    assert done.code == 1 and "1 problem" in done.out
    lines = lost(40).splitlines(keepends=True)
    lines.insert(20, b"(1700000000.951000) can0 085#1023030000000000\n")
    (tmp_path / "other.log").write_bytes(b"".join(lines))
    assert canalyze(*BASE, "other.log").code == 1, "another kind of the same node"


def test_each_report_says_what_is_known(canalyze: Runner, tmp_path: Path) -> None:
    canalyze(*BASE, "--update-baseline", "lost.log")
    done = canalyze(*BASE, "lost.log", "--junit", "j.xml", "--sarif", "s.json", "--format", "jsonl")
    (problem,) = (row for row in map(json.loads, done.out.splitlines()) if row["kind"] == "problem")
    assert (problem["known"], problem["fails"]) == (1, False)
    root = ET.parse(tmp_path / "j.xml").getroot()
    skipped = [case for case in root.iter("testcase") if case.find("skipped") is not None]
    assert len(skipped) == 1 and root[0].get("skipped") == "1" and root.get("failures") == "0"
    (run,) = json.loads((tmp_path / "s.json").read_text())["runs"]
    (result,) = (one for one in run["results"] if one["ruleId"] == "node-silent")
    assert result["baselineState"] == "unchanged" and result["suppressions"]
    assert "node-silent" not in canalyze(*BASE, "lost.log", "--format", "github").out


def test_problems_that_are_gone_leave_the_baseline(canalyze: Runner, tmp_path: Path) -> None:
    canalyze(*BASE, "--update-baseline", "lost.log")
    done = canalyze(*BASE, "well.log")
    said = "canalyze: known.json: no longer occurs: node-silent can0, node 5; --update-baseline removes it"
    assert (done.code, done.complaints) == (0, [said])
    assert canalyze("check", "--fail-on", "never", "--baseline", "known.json", "well.log").err == "", "not asked for"


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (
            '{"kind": "Node", "bus": null, "subject": null, "object": null, "count": 1}',
            "invalid kind in a baseline entry",
        ),
        (
            '{"kind": "bus-off", "bus": null, "subject": 5, "object": null, "count": 1}',
            "invalid subject in a baseline entry",
        ),
        (
            '{"kind": "bus-off", "bus": null, "subject": null, "object": "1", "count": 1}',
            "invalid object in a baseline entry",
        ),
        (
            '{"kind": "bus-off", "bus": null, "subject": null, "object": null, "count": 0}',
            "invalid count in a baseline entry",
        ),
        ('{"kind": "bus-off", "node": 5, "count": 1}', "invalid node in a baseline entry"),
        ("5", "invalid {} in a baseline entry"),
    ],
)
@pytest.mark.parametrize("lang", ["zh", "en"])
def test_a_wrong_entry_is_one_line(canalyze: Runner, tmp_path: Path, entry: str, said: str, lang: str) -> None:
    text = f'{{"canalyze_baseline": 1, "findings": [],\n"incidents": [\n{entry}\n]}}\n'
    (tmp_path / "known.json").write_text(text)
    done = canalyze("check", "--problems", "open", "--baseline", "known.json", "lost.log", "--lang", lang)
    assert (done.code, done.out) == (2, "")
    (line,) = done.complaints
    assert line.startswith("canalyze: known.json:3") and (lang == "zh" or said in line)
