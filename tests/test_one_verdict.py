"""What `check` warns of is a problem of `diagnose`, over samples, recordings and faults, and over their first halves.

A frame that came late counts from the third time on, and what concerns the file alone is said by the reader; both are
listed below. What it must not do: list a rule because the program happens to leave it out.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from captures import SHARED, TESTS, Row, session_output
from diagnoses import diagnosed

LATE = {"HBT001", "SYN003", "SYN004", "SYN009", "SYN010", "PDO004", "PDO005"}
"""Rules of frames that come at another time than due."""
ALONE = {"BUS007"}
"""A single error frame is repeated by its sender."""
FILE = {"CAP001", "CAP003", "EDS002", "EMC011", "SDO014"}
"""Of the file, of a description, and of a client that asks what the device has not: no problem of the bus."""
CAPTURES = sorted([*TESTS.parent.glob("samples/*.log"), *SHARED.glob("cases/*.log"), *SHARED.glob("stories/*.log")])


def warned(text: bytes) -> Iterator[str]:
    """The rules of findings above info that are no consequence."""
    for line in session_output([text], output_format="check", lang="en").decode().splitlines():
        finding: Row = json.loads(line)
        if finding["severity"] != "info" and finding.get("because_of") is None:
            yield finding["code"]


@pytest.mark.parametrize("part", [1, 2])
@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_a_warning_is_a_problem(path: Path, part: int) -> None:
    lines = path.read_bytes().splitlines(keepends=True)
    text = b"".join(lines[: len(lines) // part])
    loose = {one["code"] for one in diagnosed(text).whole["loose"]}
    assert loose <= set(warned(text)), "each is a warning of the check"
    assert loose - LATE - ALONE - FILE == set()
