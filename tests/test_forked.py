"""That the tests are as fast as they can be: what they run by the thousand is forked, not started, or kept."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

import forked
import pytest
from conftest import NOTES, environment


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")
def test_the_usual_command_lines_are_forked() -> None:
    assert forked.forks(os.environ)
    assert forked.forks(environment())
    assert forked.forks(environment(CANALYZE_LANG="en", NO_COLOR="1"))


@pytest.mark.parametrize("name", ["PYTHONUTF8", "PYTHONIOENCODING", "LC_ALL", "LD_PRELOAD"])
def test_what_has_a_say_in_the_start_is_started(name: str) -> None:
    assert not forked.forks(environment(**{name: "another"}))


LINES = [
    ["--version"],
    ["decode", "-"],
    ["decode", "missing.log"],
    ["check", "--format", "jsonl", "-"],
    ["--no-such"],
    [],
]


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_one_that_is_kept_answers_as_a_fork(lang: str, tmp_path: Path) -> None:
    """Whatever it has answered before: in another language and directory, or refusals."""
    for number, line in enumerate(LINES * 2):
        folder = tmp_path / str(number)
        folder.mkdir()
        env = environment(CANALYZE_LANG=lang)
        fork, kept = (
            forked.run(line, stdin=NOTES.encode(), cwd=folder, env=env, timeout_s=60, kept=kept)
            for kept in (False, True)
        )
        assert (kept.returncode, kept.stdout, kept.stderr) == (fork.returncode, fork.stdout, fork.stderr), line


def test_one_that_is_kept_and_ends_is_no_loss(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    with pytest.raises(subprocess.TimeoutExpired):
        forked.run(["decode", "fifo"], cwd=tmp_path, env=environment(), timeout_s=0.2, kept=True)
    done = forked.run(["--version"], cwd=tmp_path, env=environment(), timeout_s=60, kept=True)
    assert done.returncode == 0 and done.stdout


@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="there is no waiting for a fork of another here")
def test_one_that_is_started_ends_as_a_process(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    with (tmp_path / "out").open("wb") as out, (tmp_path / "err").open("wb") as err:

        def started(*line: str) -> subprocess.Popen[bytes] | forked.Started:
            return forked.start(line, cwd=tmp_path, env=environment(), stdout=out, stderr=err)

        assert started("--version").wait(timeout=60) == 0
        assert started("decode", "missing.log").wait(timeout=60) == 2
        waits, other = started("decode", "fifo"), started("decode", "fifo")
        assert os.getpgid(waits.pid) == waits.pid
        with pytest.raises(subprocess.TimeoutExpired):
            waits.wait(timeout=0.2)
        assert waits.poll() is None
        waits.send_signal(signal.SIGKILL)
        assert (waits.wait(timeout=60), waits.poll()) == (-signal.SIGKILL, -signal.SIGKILL)
        assert other.poll() is None
        other.send_signal(signal.SIGTERM)
        assert other.wait(timeout=60)
    done = forked.run(["--version"], cwd=tmp_path, env=environment(), timeout_s=60)
    assert (done.returncode, (tmp_path / "out").read_bytes()) == (0, done.stdout)
