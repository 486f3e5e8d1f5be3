"""What the tests of the command line share: running it as a user does, and small captures."""

import gc
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import forked
import pytest
from captures import SAMPLES

from canalyze.sources.bridge import library

pytest_plugins = ["pytester", "console"]
pytest.register_assert_rewrite("reader_suite", "capture_frames")


def pytest_configure() -> None:
    """Lets what tests start be hung up and interrupted, also where a shell runs them in the background, ignoring both.

    Hides the user's own file.
    """
    os.environ["XDG_CONFIG_HOME"] = os.devnull
    if os.environ.get("CANALYZE_LIVE"):
        library()  # else python-can loads what only MF4 needs, which takes a guest ten seconds
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="module")
def _kept_is_no_garbage() -> None:
    """Spares every collection of garbage the look at the tests themselves, and at the captures that they keep."""
    gc.collect()
    gc.freeze()


NOTES = """\
can1  60A   [8]  40 08 10 00 00 00 00 00
can1  58A   [8]  41 08 10 00 17 00 00 00
can1  58A   [8]  00 5A 65 70 68 79 72 20
can1  60A   [8]  60 00 00 00 00 00 00 00
can1  60A   [8]  70 00 00 00 00 00 00 00
can1  58A   [8]  10 52 54 4F 53 2F 43 41
can1  58A   [8]  00 4E 6F 70 65 6E 4E 6F
can1  60A   [8]  60 00 00 00 00 00 00 00
can1  60A   [8]  70 00 00 00 00 00 00 00
can1  58A   [8]  1B 64 65 00 00 00 00 00
"""
"""A segmented read of 1008h from node 10, as a client's own host sees it."""


@dataclass(frozen=True)
class Done:
    """What a run left behind."""

    code: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        """Lines of standard output."""
        return self.out.splitlines()

    @property
    def complaints(self) -> list[str]:
        """Lines of standard error."""
        return self.err.splitlines()


def environment(**more: str) -> dict[str, str]:
    """Give this environment without what would choose a language, of somebody who reads Chinese, and with `more`."""
    ours = {
        "CANALYZE_LANG",
        "CANALYZE_PAGER",
        "NO_COLOR",
        "LC_ALL",
        "PYTHONIOENCODING",
        "PYTHONUTF8",
        "COLUMNS",
        "TERM",
    }
    return (
        {name: value for name, value in os.environ.items() if name not in ours}
        | {"TERM": "xterm", "LC_MESSAGES": "zh_CN.UTF-8", "PAGER": "cat"}
        | more
    )


def command(*args: str) -> list[str]:
    """Give the command line as a user's shell would start it."""
    return [sys.executable, "-m", "canalyze", *args]


def ran(directory: Path | None, *args: str, **more: Any) -> subprocess.CompletedProcess[bytes]:
    """Runs a command line in a process of its own; more: for `subprocess.run`, instead of the usual."""
    usual: dict[str, Any] = {"cwd": directory, "env": environment(), "capture_output": True, "check": False}
    return subprocess.run(command(*args), **usual | more)


def started(directory: Path | None, *args: str, **more: Any) -> subprocess.Popen[bytes]:
    """Starts a command line; its output goes to pipes. more: for `subprocess.Popen`, instead of the usual."""
    usual: dict[str, Any] = {"cwd": directory, "env": environment()}
    return subprocess.Popen(command(*args), **usual | dict.fromkeys(("stdout", "stderr"), subprocess.PIPE) | more)


Runner = Callable[..., Done]


@pytest.fixture
def canalyze(tmp_path: Path) -> Runner:
    """Run one command line to its end, in an empty directory."""
    return runner(tmp_path)


def runner(folder: Path, *, kept: bool = False) -> Runner:
    """Runs command lines there; `kept`: in one process, for files that have many which only read and write."""

    def run(*args: str, stdin: bytes | None = None, env: dict[str, str] | None = None) -> Done:
        ours = environment(**(env or {}))
        done = forked.run(args, stdin=stdin or b"", cwd=folder, env=ours, timeout_s=120, kept=kept)
        return Done(done.returncode, done.stdout.decode(), done.stderr.decode())

    return run


@pytest.fixture
def notes(tmp_path: Path) -> str:
    """Give the name of a small capture in the directory of the run."""
    (tmp_path / "notes.log").write_text(NOTES)
    return "notes.log"


@pytest.fixture
def set_of_captures(tmp_path: Path) -> Path:
    """Returns a directory of captures: clean.log, toggle.log (SDO001, an error), sync.log (SYN003, a warning)."""
    folder = tmp_path / "captures"
    folder.mkdir()
    for name, source in (("clean", "SDO001.clean"), ("toggle", "SDO001"), ("sync", "SYN003")):
        (folder / f"{name}.log").write_bytes((SAMPLES / "rules" / f"{source}.log").read_bytes())
    return folder


def annotates(lines: Sequence[str], capture: str = NOTES) -> bool:
    """Tell whether every frame of the capture stands in the lines, in order, with something said about it."""
    rest = iter(lines)
    return all(
        any(line.startswith(frame) and len(line) > len(frame) for line in rest) for frame in capture.splitlines()
    )
