"""GitLab's report of code quality: the findings that a merge request adds or removes, at their lines.

An array of entries, each a kind of finding or a problem in one capture; its fingerprint stays when a capture is
recorded anew. What a baseline allows is left out, as GitLab compares the reports of two branches by itself. A place
is a path from the root of the project, and a line; GitLab wants one, and gets the first of formats without lines.
Must not: judge.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from canalyze.check.verdict import Verdict
from canalyze.output import printable
from canalyze.reports import wording
from canalyze.words import Words

Json = dict[str, Any]

_SEVERITIES: Final = {"error": "major", "warning": "minor", "info": "info"}


def document(verdicts: Sequence[Verdict], words: Words) -> bytes:
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
