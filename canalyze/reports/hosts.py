"""Findings as hosts of code show them: annotations of GitHub, GitLab's code quality, and JUnit XML. Must not: judge.

GitHub Actions: workflow commands, which the runner reads from a step's output. What cannot be read comes first, then
what fails the check, then what is below the threshold, then a notice for each capture that was not judged at all; what
the baseline allows is not shown. An annotation is one short line: place and rule are beside it, and the lines of the
capture are in other reports. GitHub shows ten annotations of each kind in a step and drops the others silently:
these are plain lines of the log here, and a closing annotation counts them. Nothing of a capture or of its name can
become a command: a command begins a line, and in the older form stands anywhere behind `##[`.

GitLab's report of code quality: an array of entries, each a kind of finding or a problem in one capture; its
fingerprint stays when a capture is recorded again. What a baseline allows is left out, as GitLab compares the reports
of two branches itself. A place is a path from the root of the project, and a line; GitLab wants one, and gets the first
of formats without lines.

JUnit XML: what Jenkins, GitLab and the test reporters of GitHub show. A suite is a capture. A test case is a kind of
finding (rule, bus, node, object, expectation): it fails, and bears a name that is the same in the next run; one that
the baseline allows is skipped. What it explains is said in its text. A capture without a failure is one test case that
passes, or is skipped where nothing shows it to be CANopen; one that cannot be read is an error beside what was found
until then. There is no stamp of now: but for the time it took, the same captures give the same file.
"""

import hashlib
import json
import os
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from canalyze.check.verdict import Counted, Verdict
from canalyze.output import printable
from canalyze.records import SEVERITIES, Severity
from canalyze.records.problems import Problem
from canalyze.reports import wording
from canalyze.sources import STDIN
from canalyze.words import Words

_COMMANDS: Final = {"error": "error", "warning": "warning", "info": "notice"}
_MOST: Final = {"error": 10, "warning": 10, "info": 9}
"""Of each kind in a step; the tenth notice counts the others."""
_DATA: Final = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
_PROPERTY: Final = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A", ":": "%3A", ",": "%2C"})


def github(verdicts: Sequence[Verdict], words: Words) -> Iterator[str]:
    """Returns the lines of the report, without line ends."""
    given = Counter[str]()
    for severity, command, line in _annotations(verdicts, words):
        given[severity] += 1
        yield command if given[severity] <= _MOST[severity] else _plain(line)
    for verdict in verdicts:
        for said in wording.of_events(verdict, words):
            yield _plain(f"{wording.capture_name(verdict.file)}: {said}")
    left = {severity: given[severity] - _MOST[severity] for severity in reversed(SEVERITIES)}
    if any(count > 0 for count in left.values()):
        counts = words("reports.then").join(
            words("reports.count_of", severity=words.of("severity", severity), count=count)
            for severity, count in left.items()
            if count > 0
        )
        yield _command("notice", {}, words("reports.annotations", counts=counts))


def _annotations(verdicts: Sequence[Verdict], words: Words) -> Iterator[tuple[Severity, str, str]]:
    """Returns severity, command and line of each annotation, in their order."""
    for verdict in verdicts:
        if verdict.error is not None:
            error = printable(verdict.error)
            yield "error", _command("error", _file(verdict.file), error), f"{words.of('severity', 'error')} {error}"
    for verdict in verdicts:
        for problem in (one for one in verdict.stories if one.id not in verdict.excused):
            yield _stated(verdict, problem, words)
    for failing in (True, False):
        for verdict in verdicts:
            for one in verdict.failures if failing else verdict.others:
                if failing or not one.known:
                    yield _finding(verdict.file, one, words)
    for verdict in verdicts:
        if not verdict.judged and verdict.error is None:
            said = wording.unjudged(verdict, words)
            yield "info", _command("notice", _file(verdict.file), said), f"{wording.capture_name(verdict.file)}: {said}"


def _finding(file: str, one: Counted, words: Words) -> tuple[Severity, str, str]:
    finding, title = one.finding, wording.title(one.finding)
    explained = _explained(one, words)
    properties = _file(file)
    if properties and finding.about_line is not None:
        properties["line"] = str(finding.about_line)
    brief = "; ".join([wording.brief(one, words), *explained])
    command = _command(_COMMANDS[finding.severity], properties | {"title": title}, brief)
    said = "; ".join([wording.sentence(one, words), *explained])
    place = wording.place(file, finding.about_line)
    return finding.severity, command, f"{words.of('severity', finding.severity)} {title} {place}: {said}"


def _explained(one: Counted, words: Words) -> list[str]:
    """Returns a sentence about the consequences, if there are any."""
    return [wording.consequences(one.consequences, words)] if one.consequences else []


def _stated(verdict: Verdict, one: Problem, words: Words) -> tuple[Severity, str, str]:
    """Returns a root at its begin; captures of text have a line a frame only where they say so, so none is named."""
    severity: Severity = "error" if one.id in verdict.problems else "info"
    title = f"{words('check.problem')} {one.kind}, {words('check.frame', frame=one.begin.frame)}"
    message = printable(one.message)
    command = _command(_COMMANDS[severity], _file(verdict.file) | {"title": title}, message)
    return severity, command, f"{words.of('severity', severity)} {title}: {message}"


def _file(file: str) -> dict[str, str]:
    """Returns the property that names the file; standard input is none."""
    return {} if file == STDIN else {"file": wording.capture_name(file)}


def _command(name: str, properties: dict[str, str], message: str) -> str:
    listed = ",".join(f"{key}={value.translate(_PROPERTY)}" for key, value in properties.items())
    return f"::{name}{' ' if listed else ''}{listed}::{message.translate(_DATA)}"


def _plain(text: str) -> str:
    """Returns a line of the log that is no command."""
    return text.replace("##[", "##\\x5b").replace("##vso[", "##vso\\x5b")


Json = dict[str, Any]

_SEVERITIES: Final = {"error": "major", "warning": "minor", "info": "info"}


def code_quality(verdicts: Sequence[Verdict], words: Words) -> bytes:
    """Returns the whole file."""
    root = _root()
    entries: list[Json] = []
    used: set[str] = set()
    for verdict in verdicts:
        path = _path(verdict.file, root)
        for name, severity, text, line, kind in _entries(verdict, words):
            number = 0
            while (fingerprint := _fingerprint(path, name, *kind, number)) in used:
                number += 1
            used.add(fingerprint)
            entries.append(
                {
                    "description": text,
                    "check_name": name,
                    "fingerprint": fingerprint,
                    "severity": severity,
                    "location": {"path": path, "lines": {"begin": line or 1}},
                }
            )
    return f"{json.dumps(entries, ensure_ascii=False, indent=2)}\n".encode()


def _entries(verdict: Verdict, words: Words) -> Iterator[tuple[str, str, str, int | None, tuple[object, ...]]]:
    """Returns name, severity, sentence, line and what else its kind is, of each entry."""
    if verdict.error is not None:
        yield "unreadable", "blocker", printable(verdict.error) or "-", None, ()
    elif not verdict.judged:
        yield "not-judged", "info", wording.unjudged(verdict, words), None, ()
    for problem in verdict.stories:
        if problem.id not in verdict.excused:
            severity = "critical" if problem.id in verdict.problems else "info"
            subject = (problem.bus, problem.nodes, problem.pdo, problem.axis)
            yield problem.kind, severity, printable(problem.message), None, subject
    for one in (*verdict.failures, *(one for one in verdict.others if not one.known)):
        finding = one.finding
        line = finding.about_line
        kind = (finding.bus, finding.node, finding.object, wording.expectation(finding))
        yield printable(finding.code), _SEVERITIES[finding.severity], wording.brief(one, words), line, kind


def _fingerprint(*parts: object) -> str:
    return hashlib.sha256(repr([str(part) for part in parts]).encode("utf-8", "backslashreplace")).hexdigest()


def _root() -> str | None:
    """Returns the folder that paths are shown from: that of the project in a job, or else the current one."""
    try:
        return os.environ.get("CI_PROJECT_DIR") or str(Path.cwd())
    except OSError:  # it is gone
        return None


def _path(file: str, root: str | None) -> str:
    """Returns the path of a capture in the project, or as it was given where it is not in it."""
    shown = file
    if root is not None and file not in ("-", ""):
        with suppress(ValueError, OSError):  # another drive; no current folder
            shown = os.path.relpath(file, root)
        if Path(shown).parts[:1] == (os.pardir,):
            shown = file
    return wording.capture_name(shown.replace(os.sep, "/")) or "-"


_PACKAGED: Final = str.maketrans({"/": ".", "\\": ".", ".": "_"})
"""Readers split the name of a class at its dots: folders become packages, and a suffix stays with its name."""


def junit(verdicts: Sequence[Verdict], words: Words) -> bytes:
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
    also = wording.further(one, words)
    said.text = _block([*lines, *([also] if also else []), *_explained(one, words)])
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
    return "; ".join([said, *_explained(one, words)])


def _block(lines: "Iterator[str] | Sequence[str]") -> str:
    return "\n" + "".join(f"{line}\n" for line in lines)


def _seconds(seconds: float) -> str:
    return f"{max(seconds, 0.0):.3f}"
