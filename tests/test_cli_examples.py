"""`canalyze examples`: the captures that it writes, and what is diagnosed of them.

What it must not do: test how a diagnosis is printed.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from captures import SAMPLES
from conftest import Runner
from diagnoses import diagnosed
from example_captures import EXAMPLES

from canalyze.commands.examples import DEMO, FOLDER, of_pages

TOLD = {
    "node-lost.log": [("node-silent", "open", 9)],
    "node-restarted.log": [("node-silent", "ended", 3)],
    "mapping-refused.log": [("mapping-refused", "ended", 6)],
    "drive-fault.log": [("axis-fault", "ended", 5)],
    "all-well.log": [],
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_tells_one_story(name: str) -> None:
    found = diagnosed(EXAMPLES[name]().encode())
    assert [(one["problem"], one["status"], one["subject"]["node"]) for one in found.roots] == TOLD[name]


def test_the_captures_are_current() -> None:
    files = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.log")}
    assert files == {name: made() for name, made in EXAMPLES.items()}, "python tests/regenerate.py writes them"


def test_what_follows_from_a_loss() -> None:
    found = diagnosed(EXAMPLES["node-lost.log"]().encode())
    (lost, reported) = found.incidents
    assert (reported["problem"], reported["cause"]) == (
        "heartbeat-consumer-error",
        {"id": lost["id"], "link": "L1", "grade": "certain"},
    )


def test_the_files_of_the_pages_are_those_of_the_checkout() -> None:
    copies = [path for path in DEMO.rglob("*") if path.is_file()]
    assert len(copies) > 10
    for path in copies:
        assert path.read_bytes() == (SAMPLES.parent / path.relative_to(DEMO)).read_bytes(), path


def test_the_files_of_the_pages_are_written(canalyze: Runner, tmp_path: Path) -> None:
    done = canalyze("examples", "--pages", "demo", "--lang", "en")
    assert done.code == 0 and f"and {len(of_pages())} files of the pages" in done.out.splitlines()
    written = {
        path.relative_to(tmp_path / "demo").as_posix() for path in (tmp_path / "demo").rglob("*") if path.is_file()
    }
    assert written == {*EXAMPLES, *of_pages()}
    assert {"capture.log", "captures/late.log", "drive.eds", "samples/zephyr-sdo.log", "eds/drive.eds"} < written
    assert canalyze("decode", "--eds", "5=demo/drive.eds", "demo/capture.log").code == 0
    assert canalyze("examples", "--pages", "demo").code == 2
    assert canalyze("examples", "--pages", "demo", "--force").code == 0
