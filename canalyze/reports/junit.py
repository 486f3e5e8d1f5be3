"""JUnit XML: what Jenkins, GitLab and the test reporters of GitHub show of a `check`.

A suite is a capture. A test case is a kind of finding (rule, bus, node, object, expectation): it fails, and bears a
name that is the same in the next run; one that the baseline allows is skipped. What it explains is said in its text. A
capture without a failure is one test case that passes, or is skipped where nothing shows it to be CANopen; one that
cannot be read is an error beside what was found until then. There is no stamp of now: but for the time it took, the
same captures give the same file. Must not: judge.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from typing import Final

from canalyze.check.verdict import Counted, Verdict
from canalyze.output import printable
from canalyze.records.problems import Problem
from canalyze.reports import wording
from canalyze.words import Words

_PACKAGED: Final = str.maketrans({"/": ".", "\\": ".", ".": "_"})
"""Readers split the name of a class at its dots: folders become packages, and a suffix stays with its name."""


def document(verdicts: Sequence[Verdict], words: Words) -> bytes:
    """Returns the whole file."""
    root = ET.Element("testsuites", name="canalyze")
    classes = _classes(verdicts)
    for verdict, name in zip(verdicts, classes, strict=True):
        root.append(_suite(verdict, name, words))
    for total in ("tests", "failures", "errors"):
        root.set(total, str(sum(int(suite.get(total, "0")) for suite in root)))
    root.set("time", _seconds(sum(verdict.seconds for verdict in verdicts)))
    ET.indent(root)
    text: str = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def _classes(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """Returns a name for each capture, no two alike: test cases of one name would hide each other."""
    used: set[str] = set()
    for verdict in verdicts:
        name = base = wording.capture_name(verdict.file).translate(_PACKAGED).strip(".") or "_"
        number = 2
        while name in used:
            name = f"{base} ({number})"
            number += 1
        used.add(name)
        yield name


def _suite(verdict: Verdict, classname: str, words: Words) -> ET.Element:
    suite = ET.Element("testsuite", name=wording.capture_name(verdict.file))
    known = [one for one in verdict.others if one.known]
    below = [one for one in verdict.others if not one.known]
    cases = [
        *([_unreadable(verdict.error, words)] if verdict.error is not None else []),
        *(_failing(one, verdict, words) for one in verdict.failures),
        *(_problem(one, verdict, words) for one in verdict.stories),
        *(_skipped(one, words) for one in known),
    ]
    if verdict.error is None and not verdict.failed:
        case = ET.Element("testcase", name=words("reports.clean"))
        if not verdict.judged:
            ET.SubElement(case, "skipped", type=verdict.nature, message=wording.unjudged(verdict, words))
        cases.insert(0, case)
    for number, case in enumerate(cases):
        case.set("classname", classname)
        case.set("time", _seconds(verdict.seconds if number == 0 else 0))
    suite.set("tests", str(len(cases)))
    suite.set("failures", str(len(verdict.failures) + len(verdict.problems)))
    suite.set("errors", str(int(verdict.error is not None)))
    suite.set("skipped", str(sum(case.find("skipped") is not None for case in cases)))
    suite.set("time", _seconds(verdict.seconds))
    properties = ET.SubElement(suite, "properties")
    facts: list[tuple[str, object]] = [("frames", verdict.frames), ("overruled", verdict.overruled)]
    if verdict.expectations is not None:
        facts.append(("expectations", printable(verdict.expectations)))
    for name, value in facts:
        ET.SubElement(properties, "property", name=name, value=str(value))
    suite.extend(cases)
    lines = [words("reports.below") + ":", *(_line(one, words) for one in below)] if below else []
    if lines := [*lines, *wording.of_events(verdict, words)]:
        ET.SubElement(suite, "system-out").text = _block(lines)
    if verdict.complaints:
        ET.SubElement(suite, "system-err").text = _block(map(printable, verdict.complaints))
    return suite


def _unreadable(error: str, words: Words) -> ET.Element:
    case = ET.Element("testcase", name=words("reports.readable"))
    said = ET.SubElement(case, "error", type="unreadable", message=printable(error))
    said.text = printable(error)
    return case


def _failing(one: Counted, verdict: Verdict, words: Words) -> ET.Element:
    finding = one.finding
    case = ET.Element("testcase", name=wording.kind(finding, words))
    said = ET.SubElement(case, "failure", type=finding.severity, message=wording.sentence(one, words))
    severity = words.of("severity", finding.severity)
    lines = [
        f"{wording.place(verdict.file, finding.about_line)}: {severity} {wording.title(finding)}",
        wording.sentence(one, words),
        *wording.annotated(finding),
    ]
    if also := wording.further(one, words):
        lines.append(also)
    if one.consequences:
        lines.append(wording.consequences(one.consequences, words))
    said.text = _block(lines)
    return case


def _problem(one: Problem, verdict: Verdict, words: Words) -> ET.Element:
    """Returns a story: it fails where problems of its status do."""
    where = " ".join(str(part) for part in (one.bus, *one.nodes) if part is not None)
    case = ET.Element("testcase", name=printable(f"{words('check.problem')} {one.kind} {where}".rstrip()))
    if one.id in verdict.problems:
        said = ET.SubElement(case, "failure", type=one.status, message=printable(one.message))
        steps = (f"{words('check.frame', frame=step.frame)}: {printable(step.text)}" for step in one.steps)
        said.text = _block([printable(one.message), *steps, *(printable(check) for check in one.checks)])
    elif one.id in verdict.excused:
        known = words("reports.known", known=verdict.known_problems[one.id])
        ET.SubElement(case, "skipped", type="baseline", message=printable(f"{one.message} ({known})"))
    return case


def _skipped(one: Counted, words: Words) -> ET.Element:
    case = ET.Element("testcase", name=wording.kind(one.finding, words))
    ET.SubElement(case, "skipped", type="baseline", message=wording.sentence(one, words))
    return case


def _line(one: Counted, words: Words) -> str:
    severity = words.of("severity", one.finding.severity)
    said = f"{severity} {wording.kind(one.finding, words)}: {wording.sentence(one, words)}"
    return "; ".join([said, wording.consequences(one.consequences, words)]) if one.consequences else said


def _block(lines: "Iterator[str] | Sequence[str]") -> str:
    return "\n" + "".join(f"{line}\n" for line in lines)


def _seconds(seconds: float) -> str:
    return f"{max(seconds, 0.0):.3f}"
