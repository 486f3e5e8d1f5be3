"""What a finding explains: it is said with the finding, in every report, and fails nothing by itself.

What it must not do: know which findings are consequences; the core says that.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET

from msgspec.structs import replace
from report_verdicts import FINDING, one

from canalyze import _core
from canalyze.check.policy import Policy, judge
from canalyze.check.verdict import Examined, Verdict
from canalyze.output import Output
from canalyze.reports import check, hosts, sarif
from canalyze.words import Words

EN = Words("en")
LATE = replace(FINDING, code="SYN008", name="sync-window", severity="info", frame=12, line=13, because_of=7)
OF_A_GAP = replace(LATE, code="PDO004", because_of=2)
SAID = "3 consequences: PDO004, SYN008 (2)"


def judged(policy: Policy | None = None) -> Verdict:
    """An error at frame 8 about frame 7, which explains three findings; a gap at frame 2 explains one more."""
    found = (one(), one(LATE, 2), one(replace(OF_A_GAP, because_of=8)), one(OF_A_GAP))
    return judge(Examined("a.log", found), policy or Policy(), {})


def test_consequences_stand_with_their_cause() -> None:
    verdict = judged()
    assert [cause.finding.code for cause in verdict.failures] == ["SDO001"] and verdict.others == ()
    assert [other.finding.because_of for other in verdict.failures[0].consequences] == [7, 8]
    assert [other.finding.because_of for other in verdict.consequences] == [2]


def test_a_consequence_fails_nothing() -> None:
    alone = judge(Examined("a.log", (one(OF_A_GAP),)), Policy("info"), {})
    assert not alone.failed and len(alone.consequences) == 1


def test_text_folds_them_under_their_cause() -> None:
    written: list[str] = []

    class Lines(Output):
        is_terminal = False

        def text(self, text: str) -> None:
            written.append(text.rstrip("\n"))

    check.show([judged()], Lines.__new__(Lines), EN)
    assert written[0] == "a.log, 0 frames: 1 error, 4 consequences"
    assert written[4] == f"    {SAID}" and "SYN008" not in "".join(written[:4])


def test_json_lines_have_each() -> None:
    *found, end = map(json.loads, check.json_lines([judged()]))
    assert [(row["code"], row["because_of"], row["fails"]) for row in found] == [
        ("SDO001", None, True),
        ("SYN008", 7, False),
        ("PDO004", 8, False),
        ("PDO004", 2, False),
    ]
    assert (end["failures"], end["others"]) == (1, 4)


def test_github_has_them_in_the_annotation_of_their_cause() -> None:
    annotation, of_gap = hosts.github([judged()], EN)
    assert annotation.startswith("::error ") and annotation.endswith(SAID)
    assert of_gap == "a.log: frame 2: 1 consequence: PDO004"


def test_junit_has_them_in_the_text_of_their_cause() -> None:
    root = ET.fromstring(hosts.junit([judged()], EN))
    assert (root.get("tests"), root.get("failures")) == ("1", "1")
    assert (root.findtext(".//failure") or "").strip().splitlines()[-1] == SAID
    assert (root.findtext(".//system-out") or "").strip() == "frame 2: 1 consequence: PDO004"


def test_sarif_has_them_as_properties_of_their_cause() -> None:
    (run,) = json.loads(sarif.document([judged()], _core.rules("en"), EN))["runs"]
    cause, of_gap = run["results"]
    assert len(cause["properties"]["consequences"]) == 2
    assert (of_gap["level"], of_gap["properties"]["becauseOf"]) == ("note", 2)


def test_chinese() -> None:
    (annotation, of_gap) = hosts.github([judged()], Words("zh"))
    assert annotation.endswith("3条后果: PDO004、SYN008 (2)") and of_gap == "a.log: 第2帧: 1条后果: PDO004"
