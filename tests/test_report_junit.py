"""`check --junit`: valid by Jenkins' schema, and what a reader of JUnit XML makes of it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from typing import Any

import pytest
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
