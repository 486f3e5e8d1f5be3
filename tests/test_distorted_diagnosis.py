"""Clean sessions, distorted by their recording: the diagnosis names no problem that the session itself does not have.

    python tests/test_distorted_diagnosis.py [--write]

Why it exists: a problem may follow from frames where no check has found anything (`test_distortions.py`), so that a
node is blamed for what the recording did. A problem that the session has by itself, or that a node reports, may stand.
Cells that fail today stand in `distorted_diagnosis.json` and are strict xfails.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache

import pytest
from captures import TESTS, Row, log_text, session_output
from clean_sessions import sessions
from distortions import DISTORTIONS, Distortion

FAILING = TESTS / "distorted_diagnosis.json"
"""Cells that fail today: for each distortion the sessions."""

REPORTED = ("EMC007", "DRV005", "CAP")
"""Findings that a node has reported an error, or that tell of the recording."""


def problems(text: bytes, form: str = "log") -> list[Row]:
    """Returns the problems of a capture that are not harmless."""
    output = session_output([text], name=f"capture.{form}", output_format="diagnosis", lang="en")
    rows: list[Row] = [json.loads(line) for line in output.decode().splitlines()]
    return [row for row in rows if row["kind"] == "problem" and row["status"] != "harmless"]


def key(problem: Row) -> tuple[str, object]:
    return problem["problem"], problem["subject"].get("node")


@cache
def own_problems(name: str) -> frozenset[tuple[str, object]]:
    return frozenset(map(key, problems(log_text(sessions()[name].frames))))


def alarms(name: str, distortion: Distortion) -> Iterator[str]:
    """Problems that only the distortion raises."""
    raised = {frame.can_id - 0x80 for frame in sessions()[name].frames if 0x81 <= frame.can_id <= 0xFF}
    for where, text in distortion.apply(sessions()[name]):
        for problem in problems(text, distortion.form):
            codes = [cited["code"] for cited in problem["findings"]]
            reported = bool(codes) and all(code.startswith(REPORTED + (distortion.allowed or ())) for code in codes)
            node = problem["subject"].get("node")
            if key(problem) not in own_problems(name) and not reported and not (node in raised and "EMC007" in codes):
                yield f"{where}: {problem['problem']} {problem['status']}: {problem['message']}"


def failing() -> dict[str, list[str]]:
    found: dict[str, list[str]] = json.loads(FAILING.read_text()) if FAILING.exists() else {}
    return found


def marked() -> Iterator[object]:
    known = failing()
    for distortion in DISTORTIONS:
        for name in sessions():
            fails = name in known.get(distortion.name, [])
            marks = [pytest.mark.xfail(strict=True, reason=FAILING.name)] if fails else []
            yield pytest.param(name, distortion, id=f"{distortion.name}-{name}", marks=marks)


@pytest.mark.parametrize(("name", "distortion"), list(marked()))
def test_a_distortion_is_no_problem(name: str, distortion: Distortion) -> None:
    found = list(alarms(name, distortion))
    assert not found, "\n".join(found[:8])


def main(arguments: list[str]) -> None:
    """Try every cell; count or write those that fail."""
    found: dict[str, list[str]] = {}
    kinds: Counter[str] = Counter()
    for distortion in DISTORTIONS:
        for name in sessions():
            told = list(alarms(name, distortion))
            if told:
                found.setdefault(distortion.name, []).append(name)
                kinds.update(f"{distortion.kind}: {one.split(': ')[1].split()[0]}" for one in told)
    for row, count in kinds.most_common():
        print(row, count)
    print(sum(map(len, found.values())), "of", len(DISTORTIONS) * len(sessions()), "cells fail")
    if "--write" in arguments:
        rows = ",\n".join(f" {json.dumps(row)}: {json.dumps(sorted(names))}" for row, names in found.items())
        FAILING.write_text(f"{{\n{rows}\n}}\n" if rows else "{}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
