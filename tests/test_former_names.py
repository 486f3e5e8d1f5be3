"""Former names of problems, which are accepted for a release: each gives what the name of today gives."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Runner
from test_diagnosis import lost

import canalyze
from canalyze import _core
from canalyze.check.baseline import ProblemKind, read


@pytest.fixture
def capture(tmp_path: Path) -> canalyze.Capture:
    (tmp_path / "lost.log").write_bytes(lost(20))
    return canalyze.open(tmp_path / "lost.log")


def test_names_of_the_library(capture: canalyze.Capture) -> None:
    for former, today in (("Incident", "Problem"), ("IncidentChange", "ProblemChange"), ("Incidents", "Problems")):
        with pytest.warns(DeprecationWarning, match=f"{former} is called {today}"):
            assert getattr(canalyze, former) is getattr(canalyze, today)
        assert former not in dir(canalyze)
    with pytest.warns(DeprecationWarning, match="incidents is called problems") as warned:
        assert capture.incidents is capture.problems
    assert warned[0].filename == __file__
    with pytest.warns(DeprecationWarning, match="standing is called open"):
        assert list(capture.problems.standing) == list(capture.problems.open) != []
    with pytest.warns(DeprecationWarning, match="stories is called diagnosis"):
        assert capture.stories() == capture.diagnosis() != []
    with pytest.warns(DeprecationWarning, match="incidents is called problems"):
        assert canalyze.Listener().incidents == []


def test_statuses_of_the_library(capture: canalyze.Capture) -> None:
    assert capture.problems.of(status="stands") == capture.problems.of(status="open") != []
    assert capture.problems.of(status="over") == capture.problems.of(status="ended") == []


def test_the_table_of_the_library(capture: canalyze.Capture) -> None:
    with pytest.warns(DeprecationWarning, match="incidents is called problems"):
        found = capture.tables("incidents")
    assert found.keys() == {"incidents"}
    assert found["incidents"].column("problem") == ["node-silent"]
    with pytest.warns(DeprecationWarning, match="incidents is called problems"):
        assert canalyze.columns("incidents") == canalyze.columns("problems")
    assert "incidents" not in canalyze.column_tables()


def test_the_table_of_expectations() -> None:
    entry = 'kind = "node-silent"\noccurs = 1\n'
    former, today = (_core.Expectations(f"[[{name}]]\n{entry}".encode(), "x") for name in ("incident", "problem"))
    assert former.normal == today.normal
    both = _core.Expectations(f"[[incident]]\n{entry}[[problem]]\n{entry}[[incident]]\n{entry}".encode(), "x")
    assert len(json.loads(both.normal)["problem"]) == 3
    with pytest.raises(_core.SettingsError) as wrong:
        _core.Expectations(b"[[incident]]\nkinds = 1\n", "x")
    assert wrong.value.args[1]["key"] == "incident.kinds"
    with pytest.raises(_core.SettingsError) as wrong:
        _core.Expectations(b"[[stories]]\n", "x")
    assert "[[problem]]" in wrong.value.args[1]["allowed"] and "incident" not in wrong.value.args[1]["allowed"]


def test_the_list_of_a_baseline(tmp_path: Path) -> None:
    entry = '{"kind": "node-silent", "bus": null, "subject": "node 5", "object": null, "count": 2}'
    (tmp_path / "known.json").write_text(f'{{"canalyze_baseline": 1, "findings": [], "incidents": [{entry}]}}')
    assert read(str(tmp_path / "known.json")) == {ProblemKind("node-silent", None, "node 5", None): 2}


def test_keys_of_json_lines(canalyze: Runner, tmp_path: Path) -> None:
    """`incident` is beside `problem`, and `incidents` beside `problems` of `diff`, for a release."""
    (tmp_path / "lost.log").write_bytes(lost(20))
    (tmp_path / "well.log").write_bytes(lost(40))
    for command in (("diagnose",), ("decode", "--problems"), ("check", "--problems", "open")):
        rows = map(json.loads, canalyze(*command, "--format", "jsonl", "lost.log").lines)
        problems = [row for row in rows if row["kind"] == "problem"]
        assert problems and all(row["incident"] == row["problem"] == "node-silent" for row in problems)
    *_, closing = map(json.loads, canalyze("diff", "--format", "jsonl", "lost.log", "well.log").lines)
    assert closing["incidents"] == closing["problems"] > 0
