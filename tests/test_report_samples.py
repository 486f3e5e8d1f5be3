"""The reports of `check` over every sample, as a CI job writes them: valid, and of one mind.

JUnit XML, SARIF and the JSON lines are written in one run from one verdict; what one of them says, all say.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES
from conftest import ran
from junitparser import Failure
from junitparser.xunit2 import JUnitXml
from report_schemas import junit_faults, sarif_faults
from test_report_hosts import parsed

from canalyze.words import LANGUAGES

CAPTURES = [
    path.relative_to(SAMPLES).as_posix()
    for path in sorted(SAMPLES.rglob("*"))
    if path.suffix in (".log", ".asc", ".mcap", ".gz", ".zst", ".pcapng", ".blf", ".trc")
]
BINARY = (".mcap", ".pcapng", ".blf")


def check(folder: Path, lang: str, form: str) -> list[str]:
    (folder / "empty.log").touch()
    names = [*CAPTURES, str(folder / "gone.log"), str(folder / "empty.log")]
    reports = ["--junit", str(folder / "junit.xml"), "--sarif", str(folder / "sarif.json")]
    reports += ["--code-quality", str(folder / "quality.json"), "--markdown", str(folder / "summary.md")]
    done = ran(SAMPLES, "check", "--lang", lang, "--format", form, "--force", *reports, *names, timeout=120)
    assert done.returncode == 2, done.stderr
    return done.stdout.decode().splitlines()


@pytest.mark.parametrize("lang", LANGUAGES)
def test_reports_of_all_samples_agree(tmp_path: Path, lang: str) -> None:
    rows = [json.loads(line) for line in check(tmp_path, lang, "jsonl")]
    document = (tmp_path / "junit.xml").read_bytes()
    log = json.loads((tmp_path / "sarif.json").read_bytes())
    assert junit_faults(document) == [] and sarif_faults(log) == []

    suites: Any = JUnitXml.fromstring(document)
    (run,) = log["runs"]
    assert len(CAPTURES) > 300 and len(list(suites)) == len(run["artifacts"]) == len(CAPTURES) + 2
    unread = run["invocations"][0]["toolExecutionNotifications"]
    assert [said["level"] for said in unread].count("error") == sum(suite.errors for suite in suites) >= 2
    assert run["invocations"][0]["executionSuccessful"] is False

    failing = {(row["file"], row["code"]) for row in rows if row["kind"] == "finding" and row["fails"]}
    in_junit = {
        (suite.name, case.name.split()[0])
        for suite in suites
        for case in suite
        if any(isinstance(result, Failure) for result in case.result)
    }
    assert in_junit == failing
    quality = json.loads((tmp_path / "quality.json").read_bytes())
    in_quality = {(entry["location"]["path"], entry["check_name"]) for entry in quality}
    assert (
        failing
        <= in_quality
        <= {(row["file"], row["code"]) for row in rows if row["kind"] == "finding"}
        | {(entry["location"]["path"], entry["check_name"]) for entry in quality if entry["check_name"][:1].islower()}
    )
    assert sum(entry["severity"] == "blocker" for entry in quality) == sum(suite.errors for suite in suites)
    summary = (tmp_path / "summary.md").read_text(encoding="utf-8")
    assert len(summary) <= 65_536 and summary.count("| `") > 100
    in_sarif = {
        (found["locations"][0]["physicalLocation"]["artifactLocation"]["uri"], found["ruleId"])
        for found in run["results"]
    }
    # A consequence is told with its cause.
    findings = [row for row in rows if row["kind"] == "finding"]
    judged = [row for row in findings if row["because_of"] is None]
    causes = {(row["file"], frame) for row in judged for frame in (row["frame"], row["cause_frame"])}
    # A row stands for its repetitions too, but says of the first alone where its cause is: the others' lie as far away.
    causes |= {
        (row["file"], frame + row["cause_frame"] - row["frame"])
        for row in judged
        if row["cause_frame"] is not None
        for frame in row["frames"]
    }
    told = {
        (row["file"], row["code"])
        for row in rows
        if row["kind"] == "finding" and (row["because_of"] is None or (row["file"], row["because_of"]) not in causes)
    }
    assert in_sarif == told > failing
    for found in run["results"]:
        place = found["locations"][0]["physicalLocation"]
        assert "region" not in place or Path(place["artifactLocation"]["uri"]).suffix not in BINARY
        assert str(found["properties"].get("frame", "")) in found["message"]["text"]


def test_annotations_of_all_samples(tmp_path: Path) -> None:
    lines = check(tmp_path, "en", "github")
    commands = [command for line in lines if (command := parsed(line))]
    assert {command.name for command in commands} == {"error", "warning", "notice"}
    assert len(commands) <= 30 < len(lines)
    for command in commands:
        if Path(command.properties.get("file", "")).suffix in BINARY:
            assert "line" not in command.properties
