"""Findings at their files and lines, as hosts of code show them: GitHub and GitLab. Must not: judge.

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
"""

import hashlib
import json
import os
from collections import Counter
from collections.abc import Iterator, Sequence
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
            yield _problem(verdict, problem, words)
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
    explained = [wording.consequences(one.consequences, words)] if one.consequences else []
    properties = _file(file)
    if properties and finding.about_line is not None:
        properties["line"] = str(finding.about_line)
    brief = "; ".join([wording.brief(one, words), *explained])
    command = _command(_COMMANDS[finding.severity], properties | {"title": title}, brief)
    said = "; ".join([wording.sentence(one, words), *explained])
    place = wording.place(file, finding.about_line)
    return finding.severity, command, f"{words.of('severity', finding.severity)} {title} {place}: {said}"


def _problem(verdict: Verdict, one: Problem, words: Words) -> tuple[Severity, str, str]:
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
        try:
            shown = os.path.relpath(file, root)
        except (ValueError, OSError):  # another drive; no current folder
            shown = file
        if Path(shown).parts[:1] == (os.pardir,):
            shown = file
    return wording.capture_name(shown.replace(os.sep, "/")) or "-"
