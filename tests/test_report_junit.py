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
from report_verdicts import BINARY, BLOCKS, FINDING, hostile, many, one

from canalyze.check.verdict import Verdict
from canalyze.reports import junit
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
    document = junit.document(verdicts, Words(lang))
    assert junit_faults(document) == []
    assert document.endswith(b"</testsuites>\n") or not verdicts
    suites = read(document)
    assert len(suites) == len(verdicts)
    for suite, verdict in zip(suites, verdicts, strict=True):
        kinds = Counter(type(result) for case in suite for result in case.result)
        assert suite.tests == len(list(suite))
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


def test_a_failing_kind_is_a_test_case() -> None:
    document = junit.document([Verdict("samples/boot.log", (one(count=12),), frames=20, seconds=0.25)], EN)
    (suite,) = read(document)
    assert suite.name == "samples/boot.log" and suite.time == 0.25
    (case,) = suite
    assert case.classname == "samples.boot_log"
    assert case.name == "SDO001 toggle-bit can0 node 10 1008h:00"
    (failure,) = case.result
    said = (
        "node 10 1008h:00: toggle=0 from the server, 1 was due "
        "(frame 7, line 8, shown by frame 8, 1700000000.003200 s, 12 times)"
    )
    assert failure.type == "error" and failure.message == said
    assert failure.text.strip().splitlines() == [
        "samples/boot.log:8: error SDO001 toggle-bit",
        said,
        f"> {FINDING.lines[0].text}",
        f"  {FINDING.lines[1].text}",
        "also frames 8, 9, 10, 11, 12, 13, 14, 15, 16 and more",
    ]


def test_a_clean_capture_passes_under_the_same_name_every_time() -> None:
    below = one(replace(FINDING, severity="info"))
    clean, noted = cases(junit.document([Verdict("a.log"), Verdict("b.log", others=(below,))], EN))
    assert clean.is_passed and noted.is_passed
    assert (clean.classname, clean.name) == ("a_log", "no failing findings")
    assert (noted.classname, noted.name) == ("b_log", "no failing findings")


def test_a_capture_of_which_nothing_was_judged_is_skipped() -> None:
    alien = Verdict("a.log", frames=9, nature="foreign")
    (suite,) = read(junit.document([alien], EN))
    (case,) = suite
    assert case.is_skipped and (suite.tests, suite.skipped, suite.failures) == (1, 1, 0)
    assert (case.name, case.result[0].message) == ("no failing findings", "not CANopen, not judged")
    (held,) = cases(junit.document([replace(alien, expectations="a.expect.toml")], EN))
    (failed,) = cases(junit.document([replace(alien, failures=(one(),))], EN))
    assert held.is_passed and not failed.is_skipped and not failed.is_passed


def test_what_does_not_count_is_told_beside() -> None:
    verdict = Verdict("a.log", others=(one(replace(FINDING, severity="info")),), complaints=("a.log:3: not a frame",))
    (suite,) = read(junit.document([verdict], EN))
    heading, line = suite.system_out.strip().splitlines()
    assert heading == "below the threshold:"
    assert line.startswith("info SDO001 toggle-bit can0 node 10 1008h:00: node 10")
    assert suite.system_err.strip() == "a.log:3: not a frame"


def test_what_the_baseline_allows_is_skipped() -> None:
    (clean, skipped) = cases(junit.document([Verdict("a.log", others=(one(count=2, known=3),))], EN))
    assert clean.is_passed and skipped.is_skipped
    assert skipped.name == "SDO001 toggle-bit can0 node 10 1008h:00"
    assert skipped.result[0].message.endswith("2 times, baseline allows 3)")


def test_an_unreadable_capture_is_an_error_and_hides_nothing() -> None:
    verdicts = [Verdict("gone.log", error="gone.log: no such file"), Verdict("b.log", (one(BINARY),), error="cut off")]
    gone, cut, found = cases(junit.document(verdicts, EN))
    assert [type(case.result[0]) for case in (gone, cut, found)] == [Error, Error, Failure]
    assert gone.name == cut.name == "readable"
    assert gone.result[0].message == "gone.log: no such file"
    assert found.result[0].text.strip().startswith("b.log: error SDO001")


def test_captures_of_like_names_stay_apart() -> None:
    verdicts = [Verdict(name) for name in ("a.b", "a_b", "a/b.log", "a.b", "../a.b", "/a.b", "-", "")]
    names = [case.classname for case in cases(junit.document(verdicts, EN))]
    assert len(set(names)) == len(verdicts)
    assert names[:4] == ["a_b", "a_b (2)", "a.b_log", "a_b (3)"]
    assert names[-2:] == ["stdin", "_"]


def test_an_empty_set_is_a_document() -> None:
    document = junit.document([], EN)
    assert junit_faults(document) == [] and read(document) == []


def test_characters_that_xml_cannot_hold_are_escaped() -> None:
    bad = replace(FINDING, message="\x00\x1b \ufffe \ud800 ]]>")
    (case,) = cases(junit.document([Verdict("a\x07.log", (one(bad),))], EN))
    assert case.result[0].message.startswith("\\x00\\x1b \\ufffe \\ud800 ]]> (")
    assert case.classname == "a\\x07_log".replace("\\", ".")


def test_the_same_verdicts_give_the_same_bytes() -> None:
    verdicts = [many(30), *hostile(3)]
    assert junit.document(verdicts, EN) == junit.document(verdicts, EN)
    assert b"timestamp" not in junit.document([many(2)], EN)


def test_chinese_stays_chinese() -> None:
    (case,) = cases(junit.document([Verdict("a.log", (one(),))], Words("zh")))
    assert case.name == "SDO001 toggle-bit can0 节点10 1008h:00"
    assert "(第7帧, 第8行, 依据第8帧, 1700000000.003200 s)" in case.result[0].message
