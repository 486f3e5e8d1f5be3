"""`check --code-quality`: GitLab's form, and fingerprints that stay."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from captures import DATA
from msgspec.structs import replace
from report_verdicts import BLOCKS, FINDING, hostile, one

from canalyze.check.verdict import Verdict
from canalyze.reports import hosts
from canalyze.words import LANGUAGES, Words

SCHEMA = json.loads((DATA / "code_quality.schema.json").read_text())
"""As GitLab's documentation has it, "Code Quality report format"."""


def report(*verdicts: Verdict, lang: str = "en") -> list[Any]:
    found: list[Any] = json.loads(hosts.code_quality(verdicts, Words(lang)))
    jsonschema.validate(found, SCHEMA)
    return found


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize("seeds", BLOCKS)
def test_any_report_is_valid(seeds: range, lang: str) -> None:
    for seed in seeds:
        verdicts = hostile(seed)
        found = report(*verdicts, lang=lang)
        assert len({entry["fingerprint"] for entry in found}) == len(found), "GitLab shows one of a fingerprint"
        expected = sum(verdict.error is not None for verdict in verdicts)
        expected += sum(
            len(verdict.failures) + sum(not other.known for other in verdict.others) for verdict in verdicts
        )
        assert len(found) == expected
        assert all(entry["description"].isprintable() for entry in found)


def test_the_fingerprint_stays_when_the_frame_moves_or_the_language_is_another() -> None:
    def fingerprint(file: str = "a.log", lang: str = "en", **changes: Any) -> str:
        (entry,) = report(Verdict(file, (one(replace(FINDING, **changes)),)), lang=lang)
        return str(entry["fingerprint"])

    first = fingerprint()
    assert first == fingerprint(frame=99, line=100, cause_frame=None, message="other", lang="zh")
    others = [fingerprint(file="b.log"), fingerprint(node=11), fingerprint(index="1009"), fingerprint(code="SDO002")]
    assert len({first, *others}) == 5


def test_paths_are_those_in_the_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CI_PROJECT_DIR", raising=False)
    (tmp_path / "sub").mkdir()
    names = ["./a.log", str(tmp_path / "sub/b.log"), "/elsewhere/c.log", "../d.log", "-"]

    def paths() -> list[str]:
        return [entry["location"]["path"] for entry in report(*(Verdict(name, (one(),)) for name in names))]

    assert paths() == ["a.log", "sub/b.log", "/elsewhere/c.log", "../d.log", "stdin"]
    monkeypatch.chdir(tmp_path / "sub")
    monkeypatch.setenv("CI_PROJECT_DIR", str(tmp_path))
    assert paths() == ["sub/a.log", "sub/b.log", "/elsewhere/c.log", "d.log", "stdin"]
