"""`canalyze monitor` on the command line: what it refuses, and a run on a terminal of its own."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from captures import SAMPLES
from conftest import environment
from monitor_terminal import Terminal, drawn

CAPTURE = SAMPLES / "network" / "sync-and-pdos.log"


def test_textual_that_does_not_work_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "textual").mkdir()
    (tmp_path / "textual" / "__init__.py").write_text("raise ImportError('older than python')")
    program = [sys.executable, "-m", "canalyze", "--lang", "en", "monitor", str(CAPTURE)]
    env = environment() | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(program, capture_output=True, env=env, cwd=tmp_path, check=False)
    assert done.returncode == 2
    assert done.stderr.decode() == "canalyze: monitor needs textual: pip install 'canalyze[tui]'\n"


def test_terminal_that_draws_nothing(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path, str(CAPTURE), TERM="dumb")
    code, said = terminal.end(screen=False)
    assert code == 2 and "TERM=dumb" in said and said.count("\n") == 1


def test_help_comes_without_the_extra(tmp_path: Path) -> None:
    hide = "import sys; sys.modules['textual'] = None; from canalyze.cli import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", hide, "--lang", "en", "monitor", "--help"],
        capture_output=True,
        env=environment(),
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 0 and b"canalyze[tui]" in done.stdout


@pytest.mark.parametrize("key", [b"q", b"\x03"])
def test_run_on_a_terminal(tmp_path: Path, key: bytes) -> None:
    terminal = Terminal(tmp_path, str(CAPTURE), "--speed", "max")
    assert terminal.until(drawn(b"ENDED"))
    terminal.type(key)
    assert terminal.end() == (0, "")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 0), (signal.SIGHUP, 129)])
def test_signal_ends_it_and_the_terminal_is_restored(tmp_path: Path, number: int, code: int) -> None:
    terminal = Terminal(tmp_path, str(CAPTURE), "--speed", "0.1")
    assert terminal.until(drawn(b"REPLAY"))
    terminal.process.send_signal(number)
    assert terminal.end() == (code, "")


def test_no_color_is_kept(tmp_path: Path) -> None:
    colour = re.compile(rb"\x1b\[[0-9;]*\b(?:3[0-7]|4[0-7]|9[0-7]|38|48)[;m]")
    for env, expected in (({}, True), ({"NO_COLOR": "1"}, False)):
        terminal = Terminal(tmp_path, str(CAPTURE), "--speed", "max", **env)
        assert terminal.until(drawn(b"ENDED"))
        terminal.type(b"q")
        terminal.end()
        assert bool(colour.search(terminal.shown)) == expected


def test_what_cannot_be_read_is_said_before_the_screen(tmp_path: Path) -> None:
    (tmp_path / "none.log").write_bytes(b"this is no capture\n" * 20)
    for name in ("none.log", "missing.log"):
        terminal = Terminal(tmp_path, name)
        code, said = terminal.end(screen=False)
        assert code == 2 and said.startswith("canalyze: ") and said.count("\n") == 1


def test_names_of_devices_cannot_drive_the_terminal(tmp_path: Path) -> None:
    # A segmented read of 1008h: a name that would be the title of the terminal's window.
    (tmp_path / "name.log").write_bytes(
        b"(1.000000) can0 605#4008100000000000\n"
        b"(1.000300) can0 585#4108100008000000\n"
        b"(1.000600) can0 605#6000000000000000\n"
        b"(1.000900) can0 585#011B5D303B784207\n"
        b"(1.001000) can0 705#05\n"
    )
    terminal = Terminal(tmp_path, "name.log", "--speed", "max")
    assert terminal.until(drawn(b"ENDED"))
    terminal.type(b"q")
    terminal.end()
    assert b"\x1b]0;xB" not in terminal.shown


def test_it_can_be_stopped_and_goes_on_with_the_whole_screen(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path, str(CAPTURE), "--speed", "max")
    assert terminal.until(drawn(b"ENDED"))
    terminal.type(b"\x1a")
    stopped = os.WSTOPPED | os.WNOWAIT | os.WNOHANG
    assert terminal.until(lambda _: os.waitid(os.P_PID, terminal.process.pid, stopped) is not None)
    assert terminal.is_restored()
    before = len(terminal.shown)
    terminal.process.send_signal(signal.SIGCONT)
    assert terminal.until(lambda shown: b"heartbeat" in shown[before:] and b"annotation" in shown[before:])
    terminal.type(b"q")
    assert terminal.end() == (0, "")


def test_a_terminal_that_is_gone_ends_it(tmp_path: Path) -> None:
    """Without the signal that a session leader gets."""
    terminal = Terminal(tmp_path, str(CAPTURE), "--speed", "0.01")
    assert terminal.until(drawn(b"overview"))
    assert terminal.close() == 129
