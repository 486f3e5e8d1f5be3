"""The verdicts of `check` as JSON lines: one object a kind of finding, and one at the end of each capture.

Keys are only ever added, never renamed, but for those of problems (CHANGELOG). `finding` has those of the core's
(`canalyze/core/src/tables/jsonl`), of the first of its kind, and

| key | is |
|---|---|
| `lines` | the annotated lines of its context, oldest first, `{"frame","text"}` each |
| `count` | how many of the kind there are |
| `frames` | where the first ten stand |
| `known` | how many of them the baseline allows |
| `fails` | whether the check fails by it |

`problem`, with --problems, has `id problem bus node nodes status impact grade begin end message frames known fails`
(`known`: how many of its kind the baseline allows), and `incident`, which is deprecated, the former name of `problem`;
only roots are listed, and harmless ones are not.

`check` has `file`, `frames` (how many were read), `failed`, `failures` and `others` (how many findings fail, and how
many do not), `nature` (what the capture has shown of its buses: `canopen` where one is; `unproven`, `foreign`, or
`silent` without data frames), `judged` (false where nothing fails because none of it is CANopen, and no expectations
were held against it), `overruled` (how many were taken away), `reasons` (`{"reason","count"}` of each override
that changed some), `expectations` (the file of them that it was held against, or null) and `error` (why the file could
not be read, or null).
"""

import os
from collections.abc import Iterator, Sequence
from typing import Any

from msgspec import to_builtins

from canalyze.check.verdict import Counted, Verdict
from canalyze.output import jsonl
from canalyze.records.problems import Problem


def lines(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """Returns the lines, without their ends."""
    for verdict in verdicts:
        passing = (*verdict.others, *verdict.every_consequence)
        both = [(one, True) for one in verdict.failures] + [(one, False) for one in passing]
        for one, fails in sorted(both, key=lambda row: row[0].finding.frame or 0):
            yield _line(_finding(one, fails))
        for problem in verdict.stories:
            known = verdict.known_problems.get(problem.id, 0)
            yield _line(_incident(problem, known, fails=problem.id in verdict.problems))
        yield _line(
            {
                "kind": "check",
                "file": os.fsencode(verdict.file).decode("utf-8", "backslashreplace"),
                "frames": verdict.frames,
                "failed": verdict.failed,
                "failures": sum(one.count for one in verdict.failures),
                "others": sum(one.count for one in passing),
                "nature": verdict.nature,
                "judged": verdict.judged,
                "overruled": verdict.overruled,
                "reasons": [{"reason": reason, "count": count} for reason, count in verdict.reasons],
                "expectations": verdict.expectations,
                "error": verdict.error,
            }
        )


def _finding(one: Counted, fails: bool) -> dict[str, Any]:
    return {
        **to_builtins(one.finding),
        "about_frame": one.finding.about_frame,
        "count": one.count,
        "frames": [other.frame for other in one.shown if other.frame is not None],
        "known": one.known,
        "fails": fails,
    }


def _incident(one: Problem, known: int, *, fails: bool) -> dict[str, Any]:
    return {
        "kind": "problem",
        "id": one.id,
        "problem": one.kind,
        "incident": one.kind,
        "bus": one.bus,
        "node": one.node,
        "nodes": list(one.nodes),
        "status": one.status,
        "impact": one.impact,
        "grade": one.grade,
        "begin": to_builtins(one.begin),
        "end": to_builtins(one.end),
        "message": one.message,
        "frames": list(one.frames),
        "known": known,
        "fails": fails,
    }


def _line(row: dict[str, Any]) -> str:
    return jsonl.text(row, compact=True)
