"""`canalyze diagnose`, and files without a command: what is printed, and the exit codes.

What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import json
import re
import signal
import subprocess
from pathlib import Path

import pytest
from captures import SAMPLES, run_canalyze
from conftest import Runner, ran, started
from network_sessions import SESSIONS
from processes import wait_until_idle
from test_diagnosis import frames_of, lost

from canalyze.output.layout import width
from canalyze.reports.diagnosis import _fitted

LINES = 30
CHINESE = re.compile("[\u4e00-\u9fff]")


@pytest.fixture(autouse=True)
def lost_log(tmp_path: Path) -> None:
    """A capture in which node 5 is lost."""
    (tmp_path / "lost.log").write_bytes(lost(20))


def test_from_a_file_as_standard_input(tmp_path: Path) -> None:
    for args in ([], ["-n", "1"]):
        with (tmp_path / "lost.log").open("rb") as stdin:
            done = ran(None, *args, "--lang", "en", stdin=stdin)
        assert (done.returncode, done.stderr) == (0, b"") and b"node 5" in done.stdout


def test_a_signal_ends_the_reading_of_a_pipe_not_the_report(tmp_path: Path) -> None:
    with started(None, "-n", "1", "--lang", "en", stdin=subprocess.PIPE, stderr=None) as process:
        assert process.stdin is not None and process.stdout is not None
        process.stdin.write(lost(20))
        process.stdin.flush()
        wait_until_idle(process.pid)
        process.send_signal(signal.SIGINT)
        assert b"node 5" in process.stdout.read()
        assert process.wait(30) == 130


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("name", SESSIONS)
def test_a_report_is_short(canalyze: Runner, tmp_path: Path, name: str, lang: str) -> None:
    (tmp_path / "a.log").write_bytes(frames_of(name))
    done = canalyze("a.log", "--lang", lang)
    assert done.code == 0
    assert 1 <= len(done.out.splitlines()) <= LINES
    if lang == "en":
        assert not CHINESE.search(done.out)


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("name", ["node-lost", "node-restarted", "mapping-refused", "drive-fault"])
def test_a_story_has_all_of_it(canalyze: Runner, name: str, lang: str) -> None:
    assert canalyze("examples", ".").code == 0
    incidents = [json.loads(line) for line in canalyze(f"{name}.log", "--format", "jsonl", "--lang", lang).lines]
    for one in incidents:
        told = canalyze(f"{name}.log", "-n", str(one["id"]), "--lang", lang)
        assert told.code == 0 and "\\x" not in told.out
        assert one["message"] in told.lines[0]
        assert all(step["text"] in told.out and f"#{step['frame']} " in told.out for step in one["steps"])
        assert all(entry["code"] in told.out for entry in one["findings"])
        assert f"canalyze explain {one['problem']}" in told.lines[-1]
        if one["cause"] is not None:
            assert f"-n {one['cause']['id']}" in told.lines[-1]
        if lang == "en":
            assert not CHINESE.search(told.out)


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("columns", [40, 60, 80, 100])
def test_lines_fit_a_narrow_terminal(lang: str, columns: int) -> None:
    report = run_canalyze(["diagnose", SAMPLES / "problems.log", "--lang", lang]).decode().splitlines()
    for line in report:
        fitted = _fitted(line, columns)
        assert "".join("".join(fitted).replace(" · ", "").split()) == "".join(line.replace(" · ", "").split())
        if "canalyze" not in line:
            assert max(map(width, fitted)) <= columns, fitted
        if match := re.search(r"  (#[0-9]+)$", line):
            assert fitted[-1].endswith(match[1])
