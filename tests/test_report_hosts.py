"""Reports for hosts of code: JUnit, GitLab's code quality and GitHub's annotations.

`check --junit` is valid by Jenkins' schema, and read as a reader of JUnit XML does. `check --code-quality` has GitLab's
form, and fingerprints that stay. `check --format github` has workflow commands, read as GitHub's runner does, and
nothing else to be read. That reader follows the runner's documentation of commands: `::name key=value,key=value::data`
at the begin of a line, after blanks; the older `##[name key=value]data` anywhere in a line; four or six characters
escaped.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from captures import DATA
from junitparser import Error, Failure, Skipped
from junitparser.xunit2 import JUnitXml
from msgspec.structs import replace
from report_schemas import junit_faults
from report_verdicts import BLOCKS, FINDING, hostile, many, one

from canalyze.check.verdict import Verdict
from canalyze.reports import hosts
from canalyze.words import LANGUAGES, Words

EN = Words("en")


def read(document: bytes) -> list[Any]:
    """The suites, as the reader of other people has them."""
    suites: Any = JUnitXml.fromstring(document)
    return list(suites)


def cases(document: bytes) -> list[Any]:
    return [case for suite in read(document) for case in suite]


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize("seeds", BLOCKS)
def test_any_document_is_valid(seeds: range, lang: str) -> None:
    for seed in seeds:
        valid(hostile(seed), lang)


def valid(verdicts: list[Verdict], lang: str) -> None:
    document = hosts.junit(verdicts, Words(lang))
    assert junit_faults(document) == []
    assert document.endswith(b"</testsuites>\n") or not verdicts
    suites = read(document)
    assert len(suites) == len(verdicts)
    for suite, verdict in zip(suites, verdicts, strict=True):
        kinds = Counter(type(result) for case in suite for result in case.result)
        assert suite.tests == len(list(suite)) and abs(suite.time - verdict.seconds) < 0.001
        assert suite.failures == kinds[Failure] == len(verdict.failures)
        assert suite.errors == kinds[Error] == (verdict.error is not None)
        assert suite.skipped == kinds[Skipped] == sum(bool(other.known) for other in verdict.others)
        assert suite.tests > 0, "a capture that nobody sees"
    names = [(case.classname, case.name) for suite in suites for case in suite]
    assert len(names) == len(set(names)), "readers drop all but the first of a name"
    root = ET.fromstring(document)
    assert int(root.attrib["tests"]) == len(names)
    assert root.attrib["failures"] == str(sum(len(verdict.failures) for verdict in verdicts))


def test_the_schema_would_notice() -> None:
    assert junit_faults(b"<testsuites><testsuite name='a'/></testsuites>")


def test_a_capture_of_which_nothing_was_judged_is_skipped() -> None:
    alien = Verdict("a.log", frames=9, nature="foreign")
    (suite,) = read(hosts.junit([alien], EN))
    (case,) = suite
    assert case.is_skipped and (suite.tests, suite.skipped, suite.failures) == (1, 1, 0)
    assert (case.name, case.result[0].message) == ("no failing findings", "not CANopen, not judged")
    (held,) = cases(hosts.junit([replace(alien, expectations="a.expect.toml")], EN))
    (failed,) = cases(hosts.junit([replace(alien, failures=(one(),))], EN))
    assert held.is_passed and not failed.is_skipped and not failed.is_passed


def test_captures_of_like_names_stay_apart() -> None:
    verdicts = [Verdict(name) for name in ("a.b", "a_b", "a/b.log", "a.b", "../a.b", "/a.b", "-", "")]
    names = [case.classname for case in cases(hosts.junit(verdicts, EN))]
    assert len(set(names)) == len(verdicts)
    assert names[:4] == ["a_b", "a_b (2)", "a.b_log", "a_b (3)"]
    assert names[-2:] == ["stdin", "_"]


def test_an_empty_set_is_a_document() -> None:
    document = hosts.junit([], EN)
    assert junit_faults(document) == [] and read(document) == []


def test_characters_that_xml_cannot_hold_are_escaped() -> None:
    bad = replace(FINDING, message="\x00\x1b \ufffe \ud800 ]]>")
    (case,) = cases(hosts.junit([Verdict("a\x07.log", (one(bad),))], EN))
    assert case.result[0].message.startswith("\\x00\\x1b \\ufffe \\ud800 ]]> (")
    assert case.classname == "a\\x07_log".replace("\\", ".")


def test_the_same_verdicts_give_the_same_bytes() -> None:
    verdicts = [many(30), *hostile(3)]
    assert hosts.junit(verdicts, EN) == hosts.junit(verdicts, EN)
    assert b"timestamp" not in hosts.junit([many(2)], EN)


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


@dataclass
class Command:
    """A command, its escapes undone."""

    name: str
    properties: dict[str, str]
    data: str


def unescaped(text: str, *tokens: str) -> str:
    for token in (*tokens, "\r", "\n", "%"):
        text = text.replace(f"%{ord(token):02X}", token)
    return text


def parsed(line: str) -> Command | None:
    assert line == line.strip("\r\n") and len(line.splitlines()) == 1
    text = line.lstrip()
    if text.startswith("::") and "::" in text[2:]:
        head, data = text[2:].split("::", 1)
        name, _, listed = head.partition(" ")
        pairs = [pair.split("=", 1) for pair in listed.split(",") if pair]
        assert all(len(pair) == 2 for pair in pairs)
        return Command(name, {key: unescaped(value, ":", ",") for key, value in pairs}, unescaped(data))
    assert "##[" not in line, "an older command"
    return None


def commands(*verdicts: Verdict, lang: str = "en") -> list[Command]:
    return [found for line in hosts.github(verdicts, Words(lang)) if (found := parsed(line))]


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize("seeds", BLOCKS)
def test_any_line_is_what_it_is_meant_to_be(seeds: range, lang: str) -> None:
    for seed in seeds:
        as_meant(hostile(seed), lang)


def as_meant(verdicts: list[Verdict], lang: str) -> None:
    lines = list(hosts.github(verdicts, Words(lang)))
    found = [parsed(line) for line in lines]
    counts = Counter(command.name for command in found if command)
    assert set(counts) <= {"error", "warning", "notice"} and all(count <= 10 for count in counts.values())
    told = sum(verdict.error is not None for verdict in verdicts)
    told += sum(len(verdict.failures) + sum(not other.known for other in verdict.others) for verdict in verdicts)
    assert len(lines) == told + (None in found)
    for command in found:
        if command:
            assert set(command.properties) <= {"file", "line", "title"}
            assert command.data.isprintable(), "one line"


def test_the_line_as_it_is_written() -> None:
    bare = replace(FINDING, lines=(), cause_frame=None, message="100% late, a::b", t=None)
    (line,) = hosts.github([Verdict("a,b: 5%.log", (one(bare),))], EN)
    assert line == ("::error file=a%2Cb%3A 5%25.log,line=9,title=SDO001 toggle-bit::100%25 late, a::b (frame 8)")


def test_a_capture_of_which_nothing_was_judged_is_a_notice() -> None:
    alien = Verdict("a.log", frames=9, nature="silent")
    assert commands(alien) == [Command("notice", {"file": "a.log"}, "no data frames, not judged")]
    assert [found.name for found in commands(replace(alien, failures=(one(),)))] == ["error"]
    assert not commands(replace(alien, expectations="a.expect.toml")) and not commands(Verdict("a.log", frames=9))
    found = commands(*[replace(alien, file=f"{number}.log") for number in range(20)])
    assert len(found) == 10 and "11" in found[-1].data


def test_standard_input_is_no_file() -> None:
    found, broken = commands(Verdict("-", (one(),))), commands(Verdict("-", error="stdin: nothing in it"))
    assert found[0].properties == {"title": "SDO001 toggle-bit"}
    assert broken == [Command("error", {}, "stdin: nothing in it")]


@pytest.mark.parametrize("severity", ["error", "warning", "info"])
def test_what_github_would_drop_is_in_the_log(severity: Any) -> None:
    lines = list(hosts.github([many(25, severity)], EN))
    shown = [command for line in lines if (command := parsed(line))]
    plain = [line for line in lines if not parsed(line)]
    name = {"info": "notice"}.get(severity, severity)
    most = 9 if severity == "info" else 10
    assert [command.name for command in shown] == [name] * most + ["notice"]
    assert len(plain) == 25 - most and plain[0].startswith(f"{severity} SDO001 toggle-bit a.log:8: node 10")
    assert shown[-1].data.endswith(f"in the log: {severity} {25 - most}")


def test_ten_of_a_kind_need_no_closing_line() -> None:
    assert len(list(hosts.github([many(10), many(10, "warning"), many(9, "info")], EN))) == 29


def test_a_name_cannot_become_a_command() -> None:
    evil = "\n::stop-commands::x ##[add-mask]y"
    verdicts = [replace(many(12, file=evil), error=evil), *(Verdict(evil, error=evil) for _ in range(12))]
    lines = list(hosts.github(verdicts, EN))
    assert {command.name for line in lines if (command := parsed(line))} == {"error", "notice"}


def test_nothing_found_is_nothing_said() -> None:
    assert list(hosts.github([], EN)) == list(hosts.github([Verdict("a.log")], EN)) == []
