"""The table of tests in README.md is complete, and leads from a path to its tests."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
import rooms

ROOT = rooms.TESTS.parent
ROWS = [*rooms.rows()]


def test_each_file_of_tests_is_in_one_row() -> None:
    named = Counter(name for row in ROWS for name in (*row.tests, *row.long))
    files = [*rooms.TESTS.rglob("test_*.py"), *(rooms.TESTS / "console").iterdir()]
    there = Counter(path.relative_to(ROOT).as_posix() for path in files)
    assert named == there, "tests/README.md: each file of tests belongs into one row of the table"


def test_each_room_exists() -> None:
    assert not [room for row in ROWS for room in row.rooms if not (ROOT / room).exists()]


@pytest.mark.parametrize("house", ["canalyze", "canalyze/core/src"])
def test_each_part_of_the_source_has_a_row(house: str) -> None:
    named = {room for row in ROWS for room in row.rooms}
    folders = [path for path in (ROOT / house).iterdir() if path.is_dir() and path.name != "__pycache__"]
    assert len(folders) > 9
    for folder in folders:
        path = folder.relative_to(ROOT).as_posix()
        assert any(f"{room}/".startswith(f"{path}/") for room in named), path


@pytest.mark.parametrize(
    ("path", "tests"),
    [
        ("canalyze/reports/sarif.py", ["tests/test_report_sarif.py"]),
        (
            "canalyze/core/src/views/diff",
            ["tests/console/diff.txt", "tests/test_diff.py"],
        ),
        ("canalyze/core/src/checks/sync/mod.rs", ["tests/test_sync_faults.py"]),
        ("tests/live/test_flood.py", ["tests/live/test_flood.py"]),
        ("CHANGELOG.md", []),
    ],
)
def test_a_path_leads_to_its_tests(path: str, tests: list[str]) -> None:
    assert rooms.tests_of([path]) == tests


def test_a_folder_leads_to_the_tests_below_it() -> None:
    below = rooms.tests_of(["canalyze/reports/"])
    assert {"tests/test_report_samples.py", "tests/test_report_hosts.py"} < {*below}
    assert "tests/test_cli_view.py" not in rooms.tests_of(["canalyze/commands/view.py"])


def test_every_test_that_is_found_is_a_file() -> None:
    found = rooms.tests_of(room for row in ROWS for room in row.rooms)
    assert len(found) > 100
    assert all(Path(ROOT, name).is_file() for name in found)
