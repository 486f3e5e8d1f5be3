"""`check --sarif`: valid by the schema of SARIF 2.1.0, within what code scanning takes, and stable from run to run."""

from __future__ import annotations

import json
import re
from typing import Any
from urllib.parse import unquote_to_bytes, urlsplit

import pytest
from msgspec.structs import replace
from report_schemas import sarif_faults
from report_verdicts import BLOCKS, FINDING, hostile, many, one

from canalyze import __version__, _core
from canalyze.check.verdict import Verdict
from canalyze.reports import sarif
from canalyze.reports.sarif import file_uri
from canalyze.words import LANGUAGES, Words


def log(verdicts: list[Verdict], lang: str = "en") -> Any:
    return json.loads(sarif.document(verdicts, _core.rules(lang), Words(lang)))


def run(*verdicts: Verdict, lang: str = "en") -> Any:
    (only,) = log(list(verdicts), lang)["runs"]
    return only


def result(*verdicts: Verdict) -> Any:
    (only,) = run(*verdicts)["results"]
    return only


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize("seeds", BLOCKS)
def test_any_document_is_valid(seeds: range, lang: str) -> None:
    for seed in seeds:
        valid(hostile(seed), lang)


def valid(verdicts: list[Verdict], lang: str) -> None:
    written = log(verdicts, lang)
    assert sarif_faults(written) == []
    (only,) = written["runs"]
    rules = only["tool"]["driver"]["rules"]
    assert len(only["results"]) == sum(len(verdict.failures) + len(verdict.others) for verdict in verdicts)
    assert [rule["id"] for rule in rules] == sorted({found["ruleId"] for found in only["results"]})
    for rule in rules:
        assert rule["shortDescription"]["text"] and rule["help"]["text"] and rule["help"]["markdown"]
    artifacts = only["artifacts"]
    for found in only["results"]:
        assert rules[found["ruleIndex"]]["id"] == found["ruleId"]
        (location,) = found["locations"]
        at = location["physicalLocation"]["artifactLocation"]
        assert artifacts[at["index"]]["location"]["uri"] == at["uri"] != ""
        assert found["message"]["text"]
        links = re.findall(r"\]\(([^)]*)\)", found["message"]["text"])
        assert links == [str(related["id"]) for related in found.get("relatedLocations", [])]
        assert found["partialFingerprints"]["primaryLocationLineHash"]
    successful = all(verdict.error is None for verdict in verdicts)
    assert only["invocations"][0]["executionSuccessful"] is successful
    assert all(text.isprintable() for text in strings(written))


def strings(value: Any) -> list[str]:
    """Every string but those of rules, whose help has paragraphs."""
    if isinstance(value, dict):
        return [text for key, part in value.items() if key != "rules" for text in strings(part)]
    if isinstance(value, list):
        return [text for part in value for text in strings(part)]
    return [value] if isinstance(value, str) else []


def test_the_schema_would_notice() -> None:
    written = log([Verdict("a.log", (one(),))])
    (found,) = written["runs"][0]["results"]
    found["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] = "a b\\c"
    found["level"] = "info"
    assert len(sarif_faults(written)) == 2


@pytest.mark.parametrize("lang", LANGUAGES)
def test_every_rule_of_the_catalogue_is_described(lang: str) -> None:
    rules = _core.rules(lang)
    findings = [replace(FINDING, code=rule.code, name=rule.name, severity=rule.severity) for rule in rules]
    only = run(Verdict("a.log", tuple(map(one, findings))), lang=lang)
    assert sarif_faults(log([Verdict("a.log", tuple(map(one, findings)))], lang)) == []
    driver = only["tool"]["driver"]
    assert (driver["name"], driver["version"]) == ("canalyze", __version__)
    assert only["language"] == driver["language"] == {"zh": "zh-CN", "en": "en-US"}[lang]
    for rule, written in zip(sorted(rules, key=lambda rule: rule.code), driver["rules"], strict=True):
        assert written["id"] == rule.code and written["shortDescription"]["text"] == rule.message
        assert re.fullmatch(r"[A-Z][A-Za-z0-9]*", written["name"])
        assert written["fullDescription"]["text"] == rule.meaning
        assert rule.cause in written["help"]["text"] and rule.cause in written["help"]["markdown"]
        level = {"error": "error", "warning": "warning", "info": "note"}[rule.severity]
        assert written["defaultConfiguration"]["level"] == level
        assert len(written["properties"]["tags"]) <= 10


def test_a_rule_that_no_catalogue_has_is_described_by_its_finding() -> None:
    only = run(Verdict("a.log", (one(replace(FINDING, code="ZZZ001", name="new-thing", severity="warning")),)))
    (rule,) = only["tool"]["driver"]["rules"]
    assert (rule["id"], rule["name"], rule["help"]["text"]) == ("ZZZ001", "NewThing", "ZZZ001 new-thing")
    assert rule["defaultConfiguration"]["level"] == "warning"


def test_a_fingerprint_is_of_the_kind_and_not_of_the_place() -> None:
    def fingerprint(**changes: Any) -> str:
        found = result(Verdict("a.log", (one(replace(FINDING, **changes)),)))
        return str(found["partialFingerprints"]["primaryLocationLineHash"])

    same = fingerprint()
    assert re.fullmatch(r"[0-9a-f]{16}:1", same)
    assert fingerprint(frame=100, line=None, t=None, message="other", severity="info", lines=()) == same
    others: list[dict[str, Any]] = [
        {"code": "SDO002"},
        {"bus": None},
        {"bus": "can1"},
        {"node": 1},
        {"index": None},
        {"sub": 1},
    ]
    assert len({same, *(fingerprint(**other) for other in others)}) == 1 + len(others)
    assert same == "f907f523af0bb533:1", "alerts of all users would be closed and opened anew"


def test_a_capture_of_which_nothing_was_judged_is_named() -> None:
    alien = Verdict("a.log", frames=9, nature="unproven")
    (invocation,) = log([alien])["runs"][0]["invocations"]
    (said,) = invocation["toolExecutionNotifications"]
    assert (said["level"], said["message"]["text"]) == ("warning", "may not be CANopen, not judged")
    assert invocation["executionSuccessful"] and sarif_faults(log([alien])) == []
    for judged in (replace(alien, nature="canopen"), replace(alien, failures=(one(),))):
        assert "toolExecutionNotifications" not in log([judged])["runs"][0]["invocations"][0]


def test_an_empty_set_is_a_document() -> None:
    assert sarif_faults(log([])) == []
    assert run()["results"] == [] and run()["tool"]["driver"]["rules"] == []


def test_code_scanning_gets_no_more_than_it_takes_and_the_worst_of_it() -> None:
    only = run(many(24_990, "warning"), many(20, "error", "b.log"))
    levels = [found["level"] for found in only["results"]]
    assert len(levels) == 25_000 and levels.count("error") == 20 and levels[-1] == "error"
    (said,) = only["invocations"][0]["toolExecutionNotifications"]
    assert said["message"]["text"].startswith("10 more findings") and said["level"] == "warning"


@pytest.mark.parametrize(
    ("name", "windows", "uri"),
    [
        ("samples/a b.log", False, "samples/a%20b.log"),
        ("./a.log", False, "a.log"),
        ("../a.log", False, "../a.log"),
        ("a:b.log", False, "a%3Ab.log"),
        ("100%#?.log", False, "100%25%23%3F.log"),
        ("节点.log", False, "%E8%8A%82%E7%82%B9.log"),
        ("\udcff.log", False, "%FF.log"),
        ("back\\slash.log", False, "back%5Cslash.log"),
        ("/home/ci/run/caps/a.log", False, "caps/a.log"),
        ("/home/ci/runs/a.log", False, "file:///home/ci/runs/a.log"),
        ("//double/a.log", False, "file:///double/a.log"),
        ("caps\\a b.log", True, "caps/a%20b.log"),
        ("C:\\ci\\run\\caps\\a.log", True, "caps/a.log"),
        ("c:\\CI\\run\\a.log", True, "a.log"),
        ("D:\\x\\a#.log", True, "file:///D:/x/a%23.log"),
        ("\\\\server\\share\\a b.log", True, "file://server/share/a%20b.log"),
        ("half\ud800.log", True, "half%ED%A0%80.log"),
    ],
)
def test_a_name_becomes_a_uri(name: str, windows: bool, uri: str) -> None:
    here = "C:\\ci\\run" if windows else "/home/ci/run"
    assert file_uri(name, windows=windows, here=here) == uri
    parts = urlsplit(uri)
    assert parts.scheme in ("", "file") and not parts.query and not parts.fragment
    if not windows and not parts.scheme and "run" not in name:
        assert unquote_to_bytes(parts.path) == name.removeprefix("./").encode("utf-8", "surrogateescape")
