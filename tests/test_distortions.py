"""Clean sessions, distorted by their recording in every way and magnitude: nothing above info but what really happened.

    python tests/test_distortions.py [--write] [--show WORD]

A cell is a session under a distortion of one magnitude, at several places. It fails on a finding above info that the
session itself does not raise. Cells that fail today stand in `distortions.json` and are strict xfails: once one
passes it has to leave the list, which `--write` does. `--show` lists what is said in the cells whose name has the word.
What it must not do: hold an exception for what the program happens to say.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from itertools import product

import pytest
from captures import TESTS, Row, log_text, session_output
from clean_sessions import beside, sessions
from distortions import DISTORTIONS, Distortion

from canalyze import _core

FAILING = TESTS / "distortions.json"
"""Cells that fail today: for each distortion the sessions."""

HAPPENED = {"EMC": "EMC007", "DRV": "DRV005"}
"""From these codes on a finding says that a node has raised an error, not that it reported it in a wrong way."""

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


def key(finding: Row) -> tuple[str, int | None]:
    return finding["code"], finding["node"]


@cache
def own_findings(name: str) -> tuple[list[Row], ...]:
    """What an undistorted session says of itself, by itself and with descriptions."""
    text = log_text(sessions()[name].frames)
    return tuple(findings(text, network) for network in beside(name))


def alarms(name: str, distortion: Distortion) -> Iterator[tuple[str, Row]]:
    """Findings that only the distortion raises, and where it was."""
    raised = {frame.can_id - 0x80 for frame in sessions()[name].frames if 0x81 <= frame.can_id <= 0xFF}
    for where, text in distortion.apply(sessions()[name]):
        for network, own in zip(beside(name), own_findings(name), strict=True):
            left = Counter(map(key, own))
            for finding in findings(text, network, distortion.form):
                told = happened(finding) and finding["node"] in raised
                if told or finding["code"].startswith(distortion.allowed or "-"):
                    continue
                left[key(finding)] -= 1
                if left[key(finding)] < 0:
                    yield where, finding


def listed(found: Iterator[tuple[str, Row]], most: int = 12) -> str:
    rows = list(found)
    lines = [f"{where}: {f['code']} frame {f['frame']} cause {f['cause_frame']}: {f['message']}" for where, f in rows]
    return "\n".join([f"{len(rows)} findings", *lines[:most]])


def failing() -> dict[str, list[str]]:
    """The cells that are known to fail."""
    found: dict[str, list[str]] = json.loads(FAILING.read_text()) if FAILING.exists() else {}
    return found


def cells() -> Iterator[tuple[str, Distortion]]:
    """Every session with every distortion."""
    return ((name, distortion) for distortion, name in product(DISTORTIONS, sessions()))


def marked() -> Iterator[object]:
    known = failing()
    for name, distortion in cells():
        fails = name in known.get(distortion.name, [])
        marks = [pytest.mark.xfail(strict=True, reason="distortions.json")] if fails else []
        yield pytest.param(name, distortion, id=f"{distortion.name}-{name}", marks=marks)


@pytest.mark.parametrize(("name", "distortion"), list(marked()))
def test_a_distortion_raises_nothing(name: str, distortion: Distortion) -> None:
    found = list(alarms(name, distortion))
    assert not found, listed(iter(found))


@pytest.mark.parametrize("name", list(sessions()))
def test_a_session_is_clean(name: str) -> None:
    """Its own findings are none but what a node has really reported."""
    own = [finding for findings in own_findings(name) for finding in findings]
    wrong = [("as it is", it) for it in own if not happened(it) and it["code"] != REFUSED]
    assert not wrong, listed(iter(wrong))


def test_the_list_names_cells() -> None:
    """A name that is no cell's would excuse nothing, and nobody would see it."""
    known = {(name, distortion.name) for name, distortion in cells()}
    assert {(name, row) for row, names in failing().items() for name in names} <= known


def main(arguments: list[str]) -> None:
    """Try every cell; count, show or write those that fail."""
    word = arguments[arguments.index("--show") + 1] if "--show" in arguments else None
    found: dict[str, list[str]] = {}
    codes: dict[str, Counter[str]] = {}
    total = Counter(distortion.kind for _, distortion in cells())
    for name, distortion in cells():
        if word is not None and word not in f"{distortion.name}-{name}":
            continue
        raised = list(alarms(name, distortion))
        if raised:
            found.setdefault(distortion.name, []).append(name)
            codes.setdefault(distortion.name, Counter()).update(finding["code"] for _, finding in raised)
        if raised and word is not None:
            print(f"{distortion.name}, {name}: {listed(iter(raised))}")
    for row, names in found.items():
        said = ", ".join(f"{code} {count}" for code, count in codes[row].most_common(8))
        print(f"{row}: {len(names)} sessions; {said}")
    fails = Counter(d.kind for d in DISTORTIONS for name in found.get(d.name, []))
    print("; ".join(f"{kind} {fails[kind]} of {count} cells fail" for kind, count in total.items()))
    if "--write" in arguments:
        rows = ",\n".join(f" {json.dumps(row)}: {json.dumps(sorted(names))}" for row, names in found.items())
        FAILING.write_text(f"{{\n{rows}\n}}\n" if rows else "{}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
