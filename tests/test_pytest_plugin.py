"""The pytest plugin as its user has it: fixtures, what a failed assertion shows, and that it stays away."""

import subprocess
import sys
from pathlib import Path

import pytest
from captures import DATA, SAMPLES
from diagnoses import diagnosed
from test_diagnosis import lost

DRIVE = SAMPLES.parent / "eds/drive.eds"
NETWORK = SAMPLES / "network/sync-and-pdos.log"


@pytest.fixture
def tests(pytester: pytest.Pytester) -> pytest.Pytester:
    """Give an empty project with a folder of captures beside its tests."""
    folder = pytester.mkdir("tests")
    (folder / "caps").mkdir()
    for path in (NETWORK, DRIVE, SAMPLES / "sdo-abort.log"):
        (folder / "caps" / path.name).write_bytes(path.read_bytes())
    (folder / "caps/lost.log").write_bytes(lost(20))
    return pytester


def run(tests: pytest.Pytester, source: str, *args: str) -> pytest.RunResult:
    """Run a test file of this source."""
    (tests.path / "tests/test_it.py").write_text(source, encoding="utf-8")
    return tests.runpytest_subprocess("-p", "no:cacheprovider", "-vv", *args)


def test_captures_are_opened_beside_the_test(tests: pytest.Pytester) -> None:
    done = run(
        tests,
        """
        def test_clean(canalyze_open):
            capture = canalyze_open("caps/sync-and-pdos.log", eds={5: "caps/drive.eds"})
            assert not capture.findings.at_least("warning")
            assert capture.nodes[5].state == "pre-operational"
            assert capture.signals["5.TPDO4.velocity actual value"].max == 900
            same = canalyze_open("caps/sync-and-pdos.log", eds=["5=caps/drive.eds"], filter="node=5")
            assert {frame.node for frame in same.frames} == {5}
        """.replace("\n        ", "\n"),
    )
    done.assert_outcomes(passed=1)


FAILING = (DATA / "plugin_failing.txt").read_text()


def test_failures_show_annotated_lines(tests: pytest.Pytester) -> None:
    done = run(tests, FAILING)
    done.assert_outcomes(failed=11)
    text = done.stdout.str()
    parts = {}
    for part in text.split("\n____")[1:]:
        name, _, rest = part.lstrip("_ ").partition(" ")
        parts[name] = rest.partition("=== short test")[0]
    aborted = "# abort transfer from the server: 1008h:00 05030000h toggle bit not alternated"
    assert "canalyze: findings" in parts["test_findings"] and aborted in parts["test_findings"]
    assert "SDO001 error, frame 13: node 10 1008h:00: client sent toggle=1" in parts["test_findings"]
    assert "SDO017 info, frame" not in parts["test_findings"]
    assert "canalyze: SDO transfers" in parts["test_generator"] and "... 9 more" in parts["test_generator"]
    assert "2B 17 10 00 64 00 00 00  # SDO request sent by the client: write 1017h:00" in parts["test_value"]
    assert "node: 5, expected 6" in parts["test_two"] and parts["test_two"].count("<Transfer") >= 4
    assert "3 found, 0 expected" in parts["test_none"]
    assert "velocity actual value=900 rpm" in parts["test_signal"] and "=-900 rpm" in parts["test_signal"]
    assert "use .values of the series" in parts["test_series"]
    assert "canalyze: findings" in parts["test_without_fixture"]
    assert "canalyze" not in parts["test_other"].replace("test_canalyze", "")
    assert "item 0:" in parts["test_long"]


TROUBLE = (DATA / "plugin_trouble.txt").read_text()


def test_failures_tell_the_story(tests: pytest.Pytester) -> None:
    done = run(tests, TROUBLE)
    done.assert_outcomes(failed=5)
    parts = {}
    for part in done.stdout.str().split("\n____")[1:]:
        name, _, rest = part.lstrip("_ ").partition(" ")
        parts[name] = rest.partition("=== short test")[0]
    title = diagnosed(lost(20)).roots[0]["message"]
    assert "canalyze: open problems in tests/caps/lost.log" in parts["test_other_part"]
    for name in ("test_standing", "test_one", "test_list"):
        assert "canalyze: problems" in parts[name], name
    for name in ("test_other_part", "test_standing", "test_one", "test_list"):
        assert parts[name].count(f"1  {title}") == 1 and "check first: " in parts[name], name
    assert "1 found, 0 expected" in parts["test_list"]
    assert f"  node-silent open, frame 39: {title}" in parts["test_list"]
    assert "canalyze:" not in parts["test_well"]
    tests.makeini("[pytest]\ncanalyze_lang = zh\n")
    said = run(tests, TROUBLE, "-k", "other_part").stdout.str()
    assert "canalyze：tests/caps/lost.log 中未解决的问题" in said and "先查" in said


def test_words_are_in_the_language_of_the_project(tests: pytest.Pytester) -> None:
    tests.makeini("[pytest]\ncanalyze_lang = zh\n")
    done = run(tests, FAILING, "-k", "findings")
    assert "canalyze：检查结果" in done.stdout.str() and "从站发送的中止" in done.stdout.str()
    tests.makeini("[pytest]\ncanalyze_lang = de\n")
    assert run(tests, FAILING).ret == pytest.ExitCode.USAGE_ERROR


SNAPSHOT = """
def test_it(canalyze_open, snapshot):
    capture = canalyze_open("caps/sync-and-pdos.log")
    assert [(one.direction, one.object, one.value) for one in capture.transfers.of(node=5)] == snapshot
    assert [(one.code, one.node, one.object) for one in capture.findings.at_least("warning")] == snapshot
"""


@pytest.mark.parametrize("workers", [(), ("-n", "2")], ids=["here", "xdist"])
def test_a_capture_is_compared_by_syrupy(tests: pytest.Pytester, workers: tuple[str, ...]) -> None:
    run(tests, SNAPSHOT, *workers).assert_outcomes(failed=1)
    run(tests, SNAPSHOT, "--snapshot-update", *workers).assert_outcomes(passed=1)
    kept = (tests.path / "tests/__snapshots__/test_it.ambr").read_text(encoding="utf-8")
    assert "'1017h:00'" in kept and "download" in kept
    moved = NETWORK.read_text().replace("(1795232", "(1795233").replace("vcan0", "can3")
    (tests.path / "tests/caps" / NETWORK.name).write_text(moved)
    run(tests, SNAPSHOT, *workers).assert_outcomes(passed=1)
    written = "605#2B17100064000000"
    assert written in moved
    (tests.path / "tests/caps" / NETWORK.name).write_text(moved.replace(written, "605#2B17100065000000"))
    run(tests, SNAPSHOT, *workers).assert_outcomes(failed=1)


def test_a_missing_capture_is_shown_where_it_is_opened(tests: pytest.Pytester) -> None:
    """Not in the program that opens it."""
    done = run(tests, 'def test_it(canalyze_open):\n    canalyze_open("caps/nosuch.log")\n')
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*SourceError: tests?caps?nosuch.log: cannot open: no such file or directory"])
    assert "_fd" not in done.stdout.str()


def test_the_plugin_is_light(tests: pytest.Pytester) -> None:
    source = """
import sys

def test_it():
    heavy = {"canalyze._core", "canalyze.library.capture", "click", "can", "canopen"} & set(sys.modules)
    assert not heavy
"""
    (tests.path / "tests/test_it.py").write_text(source)
    tests.runpytest_subprocess().assert_outcomes(passed=1)


def test_the_plugin_can_be_turned_off(tests: pytest.Pytester) -> None:
    (tests.path / "tests/test_it.py").write_text(
        "def test_it(canalyze_open):\n    pass\n\ndef test_other():\n    pass\n"
    )
    done = tests.runpytest_subprocess("-p", "no:canalyze")
    done.assert_outcomes(errors=1, passed=1)
    done.stdout.fnmatch_lines(["*fixture 'canalyze_open' not found*"])


TYPED = (DATA / "plugin_typed.txt").read_text()


def test_types_hold_for_the_user(tmp_path: Path) -> None:
    good, bad = tmp_path / "test_good.py", tmp_path / "test_bad.py"
    good.write_text(TYPED)
    bad.write_text(
        "import canalyze\n"
        "capture = canalyze.open('x.log', colour=1)\n"
        "capture.transfers.of(direction='up')\n"
        "capture.findings.at_least('bad')\n"
        "capture.nodes['x']\n"
        "capture.transfers[0].values\n"
    )
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), str(good), str(bad)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    errors = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert [line.split(":")[0:2] for line in errors] == [["test_bad.py", str(line)] for line in range(2, 7)], (
        done.stdout
    )
