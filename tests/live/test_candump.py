"""`candump can0 | canalyze decode -` on real SocketCAN: lines at once, the same as a log file says, a clean end.

Needs Linux with the interface vcan0 up, and candump and cansend of can-utils; without them the tests are skipped,
unless CANALYZE_LIVE=required. No test judges speed: deadlines only keep a broken run from lasting forever.
"""

from __future__ import annotations

import logging
import os
import re
import select
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import canopen
import pytest
from captures import Analysis, decoded, frame_identity, sort_rows
from conftest import NOTES, environment
from listeners import STANDSTILL_S, Pulse, wait_until_read
from record_session import INTERFACE, run_session

DEADLINE_S = 60.0
"""For one line; a loaded machine may take its time."""
PROBE, LAST = "7FE", "7FF"
"""No CANopen service of the pre-defined connection set uses these identifiers."""

CANALYZE = shlex.join([sys.executable, "-m", "canalyze"])


def missing() -> str:
    """What these tests need and do not find here."""
    tools = [tool for tool in ("candump", "cansend") if shutil.which(tool) is None]
    if tools:
        return f"no {' and no '.join(tools)} (can-utils)"
    return "" if Path("/sys/class/net", INTERFACE).exists() else f"no interface {INTERFACE}"


@pytest.fixture(autouse=True, scope="module")
def socketcan() -> None:
    lack = missing()
    if lack and os.environ.get("CANALYZE_LIVE") == "required":
        pytest.fail(lack)
    if lack:
        pytest.skip(lack)


class Pipeline:
    """A shell's pipeline in a process group of its own, its output read line by line."""

    def __init__(self, command: str, directory: Path) -> None:
        """Starts it; its standard error goes to a file."""
        self.errors = directory / "stderr"
        with self.errors.open("wb") as stderr:
            self.process = subprocess.Popen(
                ["bash", "-c", command],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=stderr,
                cwd=directory,
                env=environment(),
                start_new_session=True,
            )
        assert self.process.stdout is not None
        self.fd = self.process.stdout.fileno()
        self._rest = b""

    def line(self, wanted: Callable[[str], bool], *, within_s: float = DEADLINE_S) -> str:
        """The next line of the kind, those before it passed over; "" if none comes in time."""
        end = time.monotonic() + within_s
        while True:
            head, newline, tail = self._rest.partition(b"\n")
            if newline:
                self._rest = tail
                if wanted(head.decode()):
                    return head.decode()
            elif not select.select([self.fd], [], [], max(0.0, end - time.monotonic()))[0]:
                return ""
            elif piece := os.read(self.fd, 65536):
                self._rest += piece
            else:
                raise AssertionError(f"the output ended early: {self.errors.read_text()}")

    def wait_until_it_listens(self) -> None:
        """Sends probes until one comes out, and a last one that ends them. No two are equal, as if captured twice."""
        for number in range(100):
            cansend(f"{PROBE}#{number:04X}")
            if self.line(is_frame(PROBE), within_s=0.5):
                cansend(f"{LAST}#")
                assert self.line(is_frame(LAST)), "the second probe did not come"
                return
        raise AssertionError(f"no probe came out: {self.errors.read_text()}")

    def interrupt(self) -> tuple[int, bytes]:
        """Ctrl-C: the exit code of the shell, and what was still written."""
        os.killpg(self.process.pid, signal.SIGINT)
        rest, _ = self.process.communicate(timeout=DEADLINE_S)
        return self.process.returncode, self._rest + rest


def is_frame(can_id: str, data: str | None = None) -> Callable[[str], bool]:
    """Tells a frame's line, text or JSON."""
    bare = r"\[\d\]" if data is None else rf"\[\d\]  {data}  .*# *\S"
    text = re.compile(rf"\b{can_id}   {bare}")
    return lambda line: text.search(line) is not None or f'"id":"{can_id}"' in line


def cansend(frame: str) -> None:
    subprocess.run(["cansend", INTERFACE, frame], check=True, timeout=DEADLINE_S)


@pytest.fixture
def pipeline(tmp_path: Path) -> Iterator[Callable[[str], Pipeline]]:
    started: list[Pipeline] = []

    def start(command: str) -> Pipeline:
        started.append(Pipeline(command, tmp_path))
        return started[-1]

    yield start
    for one in started:
        if one.process.poll() is None:
            os.killpg(one.process.pid, signal.SIGKILL)
        one.process.communicate(timeout=DEADLINE_S)


@pytest.mark.parametrize(
    ("options", "form"),
    [
        ([], rf"  {INTERFACE}  60A   "),
        (["-ta", "-x"], rf"\(\d{{10}}\.\d{{6,9}}\)  {INTERFACE}  TX - -  60A   "),
        (["-tz"], rf"\(\d{{3}}\.\d{{6,9}}\)  {INTERFACE}  60A   "),
        (["-L"], rf"\(\d{{10}}\.\d{{6,9}}\)  {INTERFACE}  60A   "),
    ],
    ids=["plain", "-ta -x", "-tz", "-L"],
)
def test_every_line_comes_before_the_next_frame(
    pipeline: Callable[[str], Pipeline], options: Sequence[str], form: str
) -> None:
    live = pipeline(f"candump {' '.join(options)} {INTERFACE} | {CANALYZE} decode -")
    live.wait_until_it_listens()
    lines = []
    for frame in NOTES.splitlines():
        _, can_id, _, data = frame.split(maxsplit=3)
        cansend(f"{can_id}#{data.replace(' ', '')}")
        lines.append(live.line(is_frame(can_id, data)))
        assert lines[-1], f"no annotated line of {frame!r} in time"
    assert re.match(form.lstrip(), lines[0].lstrip()), lines[0]
    assert "1008h" in lines[0]
    assert "Zephyr RTOS/CANopenNode" in lines[-1]


@pytest.mark.parametrize("options", [[], ["--lang", "en"], ["--brief"], ["--format", "jsonl"]], ids=" ".join)
def test_ctrl_c_ends_cleanly(pipeline: Callable[[str], Pipeline], options: Sequence[str]) -> None:
    # The status is canalyze's own: the last command's of the pipeline.
    live = pipeline(f"trap : INT; candump {INTERFACE} | {CANALYZE} decode {' '.join(options)} -")
    live.wait_until_it_listens()
    cansend("60A#4008100000000000")
    assert live.line(is_frame("60A"))
    code, rest = live.interrupt()
    assert code in (0, 130)
    assert live.errors.read_bytes() == b""
    assert rest == b"" or rest.endswith(b"\n")


def test_ctrl_c_on_a_terminal(tmp_path: Path) -> None:
    """As typed: the terminal sends the signal to candump and canalyze alike."""
    if shutil.which("setsid") is None:
        pytest.skip("no setsid (util-linux)")
    ours, theirs = os.openpty()
    shell = f"candump {INTERFACE} | {CANALYZE} --lang en decode -"
    process = subprocess.Popen(
        ["setsid", "--ctty", "--wait", "bash", "-c", shell],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        cwd=tmp_path,
        env=environment(LANG="C.UTF-8"),
    )
    os.close(theirs)
    shown = b""
    end = time.monotonic() + DEADLINE_S
    while b"60A" not in shown and time.monotonic() < end:
        cansend("60A#4008100000000000")
        if select.select([ours], [], [], 0.5)[0]:
            shown += os.read(ours, 65536)
    assert b"60A" in shown, shown
    os.write(ours, b"\x03")
    while select.select([ours], [], [], DEADLINE_S)[0]:
        try:
            piece = os.read(ours, 65536)
        except OSError:  # the other side is closed: how Linux says end of file here
            break
        shown += piece
    os.close(ours)
    assert process.wait(timeout=DEADLINE_S) in (0, 130), shown
    assert b"Traceback" not in shown and b"Error" not in shown, shown


def stop(recorder: subprocess.Popen[bytes]) -> None:
    recorder.terminate()
    recorder.wait(timeout=DEADLINE_S)


def essence(transfer: dict[str, Any]) -> dict[str, Any]:
    """All of a transfer but its frame numbers and times: the pipe saw probes before the first frame."""
    return {key: transfer[key] for key in transfer.keys() - {"t", "duration", "first_frame", "last_frame"}}


def test_a_session_live_and_recorded_are_the_same(pipeline: Callable[[str], Pipeline], tmp_path: Path) -> None:
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    live = pipeline(f"candump -ta {INTERFACE} | {CANALYZE} --lang en decode - --format jsonl | tee live.jsonl")
    live.wait_until_it_listens()
    nodes, master = canopen.Network(), canopen.Network()
    recorder = subprocess.Popen(["candump", "-l", INTERFACE], cwd=tmp_path, stderr=subprocess.DEVNULL)
    try:
        log = wait_for_log(tmp_path)
        cansend(f"{PROBE}#01")
        nodes.connect(interface="socketcan", channel=INTERFACE)
        master.connect(interface="socketcan", channel=INTERFACE)
        with Pulse() as pulse:
            asked = run_session(nodes, master)
        cansend(f"{LAST}#02")
        assert live.line(is_frame(LAST)), "the last frame did not come"
        wait_until_read(recorder)
    finally:
        nodes.disconnect()
        master.disconnect()
        stop(recorder)
    live.interrupt()

    said, recorded = sort_rows((tmp_path / "live.jsonl").read_bytes()), decoded(log)
    assert frames_between(said) == frames_between(recorded)
    assert [essence(row) for row in said.transfers] == [essence(row) for row in recorded.transfers]
    # The nodes send their heartbeats from this process: late where this machine stood still.
    late = {"HBT001"} if pulse.longest >= STANDSTILL_S else set()
    assert {finding["code"] for finding in said.above_info()} <= late, said.complaint()
    assert len(said.transfers) == len(asked)
    for row, wanted in zip(said.transfers, asked, strict=True):
        assert all(row[key] == wanted[key] for key in ("node", "direction", "mode", "index", "sub")), (row, wanted)
        if "abort" in wanted:
            assert (row["status"], row["abort"]["code"]) == ("aborted", wanted["abort"])
        else:
            assert (row["status"], row["data"]) == ("ok", wanted["data"])


def wait_for_log(directory: Path) -> Path:
    """The log file, once candump writes it; candump flushes it late, so that no probe can be waited for."""
    end = time.monotonic() + DEADLINE_S
    while time.monotonic() < end:
        if logs := list(directory.glob("candump-*.log")):
            return logs[0]  # candump opens it when it listens already
        time.sleep(0.05)
    raise AssertionError("candump -l wrote no file")


def frames_between(said: Analysis) -> list[tuple[str, str, bool, bool, int, str]]:
    """The frames from the recording's first to the last."""
    frames = [frame_identity(row) for row in said.frames]
    begin = next(at for at, row in enumerate(said.frames) if (row["id"], row["data"]) == (PROBE, "01"))
    end = next(at for at, row in enumerate(said.frames) if (row["id"], row["data"]) == (LAST, "02"))
    return frames[begin : end + 1]
