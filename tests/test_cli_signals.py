"""Ctrl-C and SIGTERM at any moment: quiet, with the code of the signal, and what is known is written."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from conftest import NOTES, annotates, command, environment

SIGNALS = pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
SCRIPT = Path(sys.executable).with_name("canalyze")


@contextmanager
def started(directory: Path, line: list[str], **env: str) -> Iterator[subprocess.Popen[bytes]]:
    """Start a command line whose three streams are pipes."""
    with subprocess.Popen(
        line,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=directory,
        env=environment(**env),
        # Whoever started the tests may ignore Ctrl-C (a shell does for what runs in its background).
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def ended(process: subprocess.Popen[bytes], number: int, first: bytes = b"") -> tuple[int, str, str]:
    """Send the signal while standard input stays open; give the code and the two outputs."""
    assert process.stdout and process.stderr
    process.send_signal(number)
    code = process.wait(timeout=60)
    return code, (first + process.stdout.read()).decode(), process.stderr.read().decode()


@SIGNALS
@pytest.mark.parametrize("line", [command("decode", "-"), [str(SCRIPT), "decode", "-"]], ids=["module", "script"])
def test_while_it_is_still_being_imported(tmp_path: Path, line: list[str], number: int, code: int) -> None:
    (tmp_path / "click.py").write_text("import os, time\nos.write(1, b'importing')\ntime.sleep(60)\n")
    with started(tmp_path, line, PYTHONPATH=str(tmp_path)) as process:
        assert process.stdout
        assert process.stdout.read(9) == b"importing"
        assert ended(process, number) == (code, "", "")


@SIGNALS
def test_while_explain_waits(tmp_path: Path, number: int, code: int) -> None:
    with started(tmp_path, command("explain", "-")) as process:
        assert process.stdin and process.stdout
        process.stdin.write(NOTES.splitlines(keepends=True)[0].encode())
        process.stdin.flush()
        first = process.stdout.readline()
        assert first.startswith(b"can1")
        assert ended(process, number)[::2] == (code, "")


@SIGNALS
def test_what_is_known_is_written(tmp_path: Path, number: int, code: int) -> None:
    with started(tmp_path, command("decode", "-")) as process:
        assert process.stdin and process.stdout
        process.stdin.write(NOTES.encode())
        process.stdin.flush()
        said, out, err = ended(process, number, process.stdout.readline())
    assert (said, err) == (code, "")
    assert annotates(out.splitlines())


@SIGNALS
def test_line_that_we_did_not_wait_for_is_no_fault_of_the_file(tmp_path: Path, number: int, code: int) -> None:
    with started(tmp_path, command("decode", "-")) as process:
        assert process.stdin and process.stdout
        process.stdin.write(NOTES.encode() + b"can1  60A   [8]  40 08 1")
        process.stdin.flush()
        said, out, err = ended(process, number, process.stdout.readline())
    assert (said, err) == (code, "")
    assert annotates(out.splitlines())
    assert len([line for line in out.splitlines() if line.startswith("can1")]) == len(NOTES.splitlines())


def test_signal_that_the_caller_ignores_stays_ignored(tmp_path: Path) -> None:
    code = "import signal, os; signal.signal(2, signal.SIG_IGN); import canalyze.__main__; os.kill(os.getpid(), 2)"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment(), check=False)
    assert done.returncode == 0
