"""Clean sessions, distorted by their recording in every way and magnitude: nothing but what really happened is said.

    python tests/test_distortions.py [--write] [--show WORD]

A cell is a session under a distortion of one magnitude, at several places. It fails on a finding above info, or on a
problem that is not harmless, that the session itself does not have: a problem may follow from frames where no check has
found anything, so that a node is blamed for what the recording did. Cells that fail today are in `distortions.json` and
`distorted_diagnosis.json`; a cell that passes has to leave its list, which `--write` does. `--show` prints what is said
in the cells whose name has the word.
What it must not do: hold an exception for what the program happens to say.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache, lru_cache
from itertools import product
from pathlib import Path

import pytest
from captures import TESTS, Row, log_text, session_output
from clean_sessions import beside, sessions
from distortions import DISTORTIONS, Distortion

from canalyze import _core

HAPPENED = {"EMC": "EMC007", "DRV": "DRV005"}
"""From these codes on a finding says that a node has raised an error, not that it reported it in a wrong way."""

REPORTED = ("EMC007", "DRV005", "CAP")
"""Findings that a node has reported an error, or that tell of the recording."""

REFUSED = "SDO018"
"""A node has refused a write, and nothing made it good: the session `transfers` has one for each node."""


def happened(finding: Row) -> bool:
    """Whether a finding tells of an error that a node has really raised."""
    code: str = finding["code"]
    return code >= HAPPENED.get(code[:3], "~")


def findings(text: bytes, network: _core.Network | None, form: str = "log") -> list[Row]:
    """The findings above info that are no consequence of another."""
    output = session_output([text], name=f"capture.{form}", output_format="check", lang="en", network=network)
    rows: list[Row] = [json.loads(line) for line in output.decode().splitlines()]
    return [row for row in rows if row["severity"] != "info" and row.get("because_of") is None]


def problems(text: bytes, form: str = "log") -> list[Row]:
    """Returns the problems of a capture that are not harmless."""
    output = session_output([text], name=f"capture.{form}", output_format="diagnosis", lang="en")
    rows: list[Row] = [json.loads(line) for line in output.decode().splitlines()]
    return [row for row in rows if row["kind"] == "problem" and row["status"] != "harmless"]


def key(finding: Row) -> tuple[str, int | None]:
    return finding["code"], finding["node"]


@cache
def own_findings(name: str) -> tuple[list[Row], ...]:
    """What an undistorted session says of itself, by itself and with descriptions."""
    text = log_text(sessions()[name].frames)
    return tuple(findings(text, network) for network in beside(name))


def problem_key(problem: Row) -> tuple[str, object]:
    return problem["problem"], problem["subject"].get("node")


@cache
def own_problems(name: str) -> frozenset[tuple[str, object]]:
    return frozenset(map(problem_key, problems(log_text(sessions()[name].frames))))


@lru_cache(maxsize=64)
def distorted(name: str, distortion: Distortion) -> list[tuple[str, bytes]]:
    """The captures of a cell: where it is distorted, and its text. Both judges look at them, one after the other."""
    return list(distortion.apply(sessions()[name]))


@cache
def raising(name: str) -> set[int]:
    """The nodes that send emergencies in a session."""
    return {frame.can_id - 0x80 for frame in sessions()[name].frames if 0x81 <= frame.can_id <= 0xFF}


def false_findings(name: str, distortion: Distortion) -> Iterator[tuple[str, str, str]]:
    """Yields findings that only the distortion raises: where it was, the code, and all that is said."""
    for where, text in distorted(name, distortion):
        for network, own in zip(beside(name), own_findings(name), strict=True):
            left = Counter(map(key, own))
            for finding in findings(text, network, distortion.form):
                told = happened(finding) and finding["node"] in raising(name)
                if told or finding["code"].startswith(distortion.allowed or "-"):
                    continue
                left[key(finding)] -= 1
                if left[key(finding)] < 0:
                    yield where, finding["code"], described(finding)


def false_problems(name: str, distortion: Distortion) -> Iterator[tuple[str, str, str]]:
    """Yields problems that only the distortion raises."""
    for where, text in distorted(name, distortion):
        for problem in problems(text, distortion.form):
            codes = [cited["code"] for cited in problem["findings"]]
            reported = bool(codes) and all(code.startswith(REPORTED + (distortion.allowed or ())) for code in codes)
            node = problem["subject"].get("node")
            sent = node in raising(name) and "EMC007" in codes
            if problem_key(problem) not in own_problems(name) and not reported and not sent:
                yield where, problem["problem"], f"{problem['status']}: {problem['message']}"


def described(finding: Row) -> str:
    return f"frame {finding['frame']} cause {finding['cause_frame']}: {finding['message']}"


JUDGES: dict[str, tuple[Path, Callable[[str, Distortion], Iterator[tuple[str, str, str]]]]] = {
    "check": (TESTS / "distortions.json", false_findings),
    "diagnose": (TESTS / "distorted_diagnosis.json", false_problems),
}
"""What may be false, with the list of cells that fail today: for each distortion the sessions."""


def failing(judge: str) -> dict[str, list[str]]:
    """The cells that are known to fail."""
    found: dict[str, list[str]] = json.loads(JUDGES[judge][0].read_text())
    return found


def listed(found: Iterable[tuple[str, str, str]], most: int = 12) -> str:
    rows = list(found)
    return "\n".join([f"{len(rows)} in all", *(": ".join(row) for row in rows[:most])])


@pytest.mark.parametrize("judge", JUDGES)
@pytest.mark.parametrize("distortion", DISTORTIONS, ids=lambda distortion: distortion.name)
def test_a_distortion_raises_nothing(judge: str, distortion: Distortion) -> None:
    """The cells that fail are those of the list, neither more nor fewer."""
    file, alarms = JUDGES[judge]
    known = {*failing(judge).get(distortion.name, [])} & sessions().keys()
    found = {name: list(alarms(name, distortion)) for name in sessions()}
    false = {name: rows for name, rows in found.items() if rows}
    further = "\n".join(f"{name}: {listed(rows)}" for name, rows in false.items() if name not in known)
    assert not further, further
    assert known == false.keys(), f"cells that pass have to leave {file.name}"


@pytest.mark.parametrize("name", list(sessions()))
def test_a_session_is_clean(name: str) -> None:
    """Its own findings are none but what a node has really reported."""
    own = [finding for findings in own_findings(name) for finding in findings]
    wrong = [("as it is", it["code"], described(it)) for it in own if not happened(it) and it["code"] != REFUSED]
    assert not wrong, listed(wrong)


@pytest.mark.parametrize("judge", JUDGES)
def test_the_list_names_cells(judge: str) -> None:
    """A name that is no cell's would excuse nothing, and nobody would see it."""
    known = {distortion.name for distortion in DISTORTIONS}
    for row, names in failing(judge).items():
        assert row in known and {*names} <= sessions().keys(), row


def main(arguments: list[str]) -> None:
    """Try every cell; count, show or write those that fail."""
    word = arguments[arguments.index("--show") + 1] if "--show" in arguments else ""
    cells = [(d, name) for d, name in product(DISTORTIONS, sessions()) if word in f"{d.name}-{name}"]
    for judge, (file, alarms) in JUDGES.items():
        found: dict[str, list[str]] = {}
        codes: dict[str, Counter[str]] = {}
        for distortion, name in cells:
            if raised := list(alarms(name, distortion)):
                found.setdefault(distortion.name, []).append(name)
                codes.setdefault(distortion.name, Counter()).update(code for _, code, _ in raised)
                if word:
                    print(f"{distortion.name}, {name}: {listed(raised)}")
        for row, names in found.items():
            said = ", ".join(f"{code} {count}" for code, count in codes[row].most_common(8))
            print(f"{judge}: {row}: {len(names)} sessions; {said}")
        print(f"{judge}: {sum(map(len, found.values()))} of {len(cells)} cells fail")
        if "--write" in arguments and not word:
            rows = ",\n".join(f" {json.dumps(row)}: {json.dumps(sorted(names))}" for row, names in found.items())
            file.write_text(f"{{\n{rows}\n}}\n" if rows else "{}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
