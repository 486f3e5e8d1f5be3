"""Programs that listen to a bus beside each other: `canalyze sniff` and `candump`, and what they saw.

Why it exists: every live test starts both before the first frame and compares them after the last one. The kernel
says who listens (/proc/net/can), so that no frame has to be sent to find out. What it must not do: judge speed; the
deadlines only keep a broken run from lasting forever.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any, Self

import can
import forked
import pytest
from capture_frames import Recorded
from conftest import environment
from other_readers import candump_log

DEADLINE_S = 120.0
"""For what a user would see at once, or as soon as a viewer has started; a loaded machine may take its time."""
LAST = "7FF#4C415354"
"""Ends a session: no CANopen service of the pre-defined connection set uses this identifier."""
SELECTIVE = ("all", "fil", "inv", "sff", "eff")
"""The kernel's tables of those who take frames; errors apart."""
ATTEMPTS = 5
STANDSTILL_S = 0.008
"""The least lateness of all nodes by the same time that the program tells: eight times its tolerance of 1 ms."""
EVERYTHING = ",0:0,#FFFFFFFF"
"""Behind a channel: candump shows error frames too."""


def lack(*interfaces: str) -> str:
    """What live tests need and do not find here."""
    tools = [tool for tool in ("candump", "cansend", "cangen", "ip") if shutil.which(tool) is None]
    if tools:
        return f"no {' and no '.join(tools)} (can-utils, iproute2)"
    missing = [name for name in interfaces if not Path("/sys/class/net", name).exists()]
    return f"no interface {' and no '.join(missing)}" if missing else ""


def need(*interfaces: str, right: bool = True) -> None:
    """Skips the tests where something is missing, or the right to make interfaces; fails where nothing may be."""
    reason = lack(*interfaces) or ("" if right else "no right to make interfaces")
    if reason and os.environ.get("CANALYZE_LIVE") == "required":
        pytest.fail(reason)
    if reason:
        pytest.skip(reason)


def wait_until(true: Callable[[], object], what: str, *, within_s: float = DEADLINE_S) -> None:
    """Waits for it, and fails with `what` where it does not come."""
    end = time.monotonic() + within_s
    while not true():
        if time.monotonic() > end:
            pytest.fail(f"not within {within_s:g} s: {what}")
        time.sleep(0.02)


class Pulse:
    """A context in which it is seen for how long this machine has stood still."""

    STEP_S = 0.02

    def __enter__(self) -> Self:
        """Begins to look."""
        self.longest = 0.0
        self._over = threading.Event()
        self._looking = threading.Thread(target=self._look, daemon=True)
        self._looking.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Looks no more."""
        self._over.set()
        self._looking.join()

    def _look(self) -> None:
        before = time.monotonic()
        while not self._over.wait(self.STEP_S):
            now = time.monotonic()
            self.longest = max(self.longest, now - before - self.STEP_S)
            before = now


def unless_the_machine_stalls(bus: Listeners, judge: Callable[[], None]) -> None:
    """Does what fails where periods are not kept: again where this machine stood still meanwhile.

    The kernel's timers start the next period late then, for all nodes: in the capture the clock was set forward.
    """
    for attempt in range(ATTEMPTS):
        with Pulse() as pulse:
            try:
                return judge()
            except (AssertionError, pytest.fail.Exception):
                if pulse.longest < STANDSTILL_S or attempt == ATTEMPTS - 1:
                    raise
        bus.close()
        bus.directory = bus.directory / "again"
        bus.directory.mkdir()
    return None


def wait_until_read(reader: subprocess.Popen[bytes]) -> None:
    """Waits until a process that only receives has taken all that came: it sleeps again."""
    stat = Path(f"/proc/{reader.pid}/stat")
    wait_until(lambda: stat.read_text().rpartition(")")[2].split()[0] == "S", "it has read all")


def listeners(interface: str, tables: Sequence[str] = ("all",)) -> int:
    """How many entries the kernel has for those that take every frame of the interface, or part of them."""
    lines = (line for table in tables for line in Path(f"/proc/net/can/rcvlist_{table}").read_text().splitlines())
    return sum(line.split()[:1] == [interface] for line in lines)


def cansend(interface: str, *frames: str) -> None:
    """Sends frames in cansend's notation, one after the other."""
    for frame in frames:
        subprocess.run(["cansend", interface, frame], check=True, timeout=DEADLINE_S)


def cangen(interface: str, *options: str) -> None:
    """Runs cangen to its end."""
    subprocess.run(["cangen", interface, *options], check=True, timeout=4 * DEADLINE_S, capture_output=True)


def send_all(interface: str, frames: Iterable[tuple[int, bytes]]) -> None:
    """Sends 11-bit data frames from this process: far quicker than cansend."""
    with can.Bus(interface="socketcan", channel=interface, receive_own_messages=False) as bus:
        for can_id, data in frames:
            bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False), timeout=DEADLINE_S)


class Heartbeats:
    """Heartbeats sent by the kernel, so that this machine's load does not show in them."""

    PERIOD_S = 0.25
    SHOW_THE_PERIOD = 20
    """Heartbeats that show it though a loaded machine delays some: what is told of a node without one is nothing."""

    def __init__(self, interface: str = "vcan0") -> None:
        """Nothing is sent yet."""
        self._bus: Any = can.Bus(interface="socketcan", channel=interface)
        self._tasks: dict[int, Any] = {}

    def start(self, *nodes: int) -> None:
        """Boot-up, then a heartbeat every PERIOD_S."""
        for node in nodes:
            self._bus.send(can.Message(arbitration_id=0x700 + node, data=[0x00], is_extended_id=False))
        self.resume(*nodes)

    def resume(self, *nodes: int) -> None:
        """A heartbeat every PERIOD_S, of a node that has been up."""
        for node in nodes:
            beat = can.Message(arbitration_id=0x700 + node, data=[0x7F], is_extended_id=False)
            self._tasks[node] = self._bus.send_periodic(beat, self.PERIOD_S)

    def stop(self, *nodes: int) -> None:
        """They fall silent."""
        for node in nodes or list(self._tasks):
            with suppress(can.CanError):  # the interface went away before
                self._tasks.pop(node).stop()

    def close(self) -> None:
        """Ends all."""
        self.stop()
        self._bus.shutdown()


@dataclass(frozen=True)
class Ended:
    """What a listener left behind."""

    code: int
    out: bytes
    err: str


Begin = Callable[[Path, IO[bytes], IO[bytes]], "subprocess.Popen[bytes] | forked.Started"]
"""Starts a program in a directory, with these for what it writes and what it complains of."""


def begin_sniff(*arguments: str) -> Begin:
    """`canalyze sniff`, which takes a guest two seconds to load: it is forked."""
    return lambda directory, out, err: forked.start(arguments, cwd=directory, env=environment(), stdout=out, stderr=err)


def begin_program(*line: str) -> Begin:
    """A program that is not ours."""
    return lambda directory, out, err: subprocess.Popen(
        line,
        stdin=subprocess.DEVNULL,
        stdout=out,
        stderr=err,
        cwd=directory,
        env=environment(),
        start_new_session=True,
    )


class Listener:
    """One program in a process group of its own, its output in files."""

    def __init__(self, name: str, begin: Begin, directory: Path) -> None:
        """Starts it in the directory; NAME.out and NAME.err get what it writes."""
        self.name = name
        self.out_path, self.err_path = directory / f"{name}.out", directory / f"{name}.err"
        with self.out_path.open("wb") as out, self.err_path.open("wb") as err:
            self.process = begin(directory, out, err)

    @property
    def out(self) -> bytes:
        """What it wrote so far."""
        return self.out_path.read_bytes()

    @property
    def err(self) -> str:
        """What it complained of so far."""
        return self.err_path.read_text()

    def wait_for(self, wanted: bytes, *, times: int = 1) -> None:
        """Waits until it has written this so many times."""
        self._wait(lambda: self.out.count(wanted) >= times, repr(wanted))

    def wait_for_any(self, *wanted: bytes) -> None:
        """Waits until it has written one of these."""
        self._wait(lambda: any(one in self.out for one in wanted), f"any of {wanted}")

    def _wait(self, written: Callable[[], bool], what: str) -> None:
        wait_until(lambda: written() or self.process.poll() is not None, f"{what} of {self.name}")
        if not written():
            pytest.fail(f"{self.name} ended with {self.process.returncode} before {what}: {self.err}")

    def wait_for_complaint(self, wanted: str) -> None:
        """Waits until it has written this to standard error."""
        wait_until(lambda: wanted in self.err, f"{wanted!r} on standard error of {self.name}, which is {self.err!r}")

    def send(self, number: int) -> None:
        """Sends it a signal."""
        self.process.send_signal(number)

    def ended(self) -> Ended:
        """Waits for its end."""
        try:
            code = self.process.wait(timeout=DEADLINE_S)
        except subprocess.TimeoutExpired:
            pytest.fail(f"{self.name} does not end; it complains: {self.err}")
        return Ended(code, self.out, self.err)

    def stop(self, number: int = signal.SIGINT) -> Ended:
        """Ends it as Ctrl-C does."""
        self.send(number)
        return self.ended()

    def kill(self) -> None:
        """Ends it whatever it does; for the end of a test."""
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait(timeout=DEADLINE_S)

    def cpu_s(self) -> float:
        """CPU time that it took so far, of user and system."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Listeners:
    """Starts listeners and waits until the kernel knows them; `close` ends what is left."""

    def __init__(self, directory: Path) -> None:
        """Their files go to the directory."""
        self.directory = directory
        self._started: list[Listener] = []

    def sniff(self, *arguments: str, listens: Sequence[str] = ("vcan0",), name: str = "", lang: str = "en") -> Listener:
        """Starts `canalyze sniff`; `listens` are the interfaces that it opens."""
        name = name or f"sniff{len(self._started)}"
        return self._start(name, begin_sniff("--lang", lang, "sniff", *arguments), listens)

    def candump(self, *channels: str, options: Sequence[str] = ("-L",), name: str = "") -> Listener:
        """Starts a candump that loses nothing; its output is the log."""
        channels = channels or (f"vcan0{EVERYTHING}",)
        name = name or f"candump{len(self._started)}"
        listens = [channel.split(",")[0] for channel in channels]
        begin = begin_program("candump", *options, "-r", "8000000", *channels)
        return self._start(name, begin, listens, SELECTIVE)

    def _start(self, name: str, begin: Begin, listens: Sequence[str], tables: Sequence[str] = ("all",)) -> Listener:
        before = {interface: listeners(interface, tables) for interface in listens}
        started = Listener(name, begin, self.directory)
        self._started.append(started)
        wait_until(
            lambda: (
                started.process.poll() is not None
                or all(listeners(interface, tables) > count for interface, count in before.items())
            ),
            f"{name} listens on {' and '.join(listens)}",
        )
        assert not listens or started.process.poll() is None, f"{name} ended at once: {started.err}"
        return started

    def close(self) -> None:
        """Ends all of them."""
        for one in self._started:
            one.kill()


@pytest.fixture
def bus(tmp_path: Path) -> Iterator[Listeners]:
    """Listeners in the test's directory."""
    started = Listeners(tmp_path)
    yield started
    started.close()


def logged(recorder: Listener) -> list[Recorded]:
    """The frames of candump's log, without the side: it is not what is compared."""
    return sideless(candump_log(recorder.out.decode()))


def sideless(frames: Iterable[Recorded]) -> list[Recorded]:
    """The frames without who sent them."""
    return [replace(frame, sent=None) for frame in frames]


def lines_of_frames(out: bytes) -> list[str]:
    """The lines of frames in text, without what is said about them."""
    frame = re.compile(r"\b\w*can\d+  .*\[\d+\]")
    lines = out.decode().splitlines()
    return [line.partition("  #")[0].rstrip() for line in lines if frame.search(line.partition("#")[0])]


def finish(recorder: Listener, *sniffs: Listener, interface: str = "vcan0", frame: str = LAST) -> list[Ended]:
    """Sends the last frame, waits until every listener has shown it, and ends them; what they left, candump's first.

    The sniffers show frames as `candump` does on a terminal or as JSON lines.
    """
    cansend(interface, frame)
    recorder.wait_for(f" {interface} {frame}".encode())
    for one in sniffs:
        one.wait_for_any(*as_shown(frame))
    return [one.stop() for one in (recorder, *sniffs)]


def as_shown(frame: str) -> tuple[bytes, bytes]:
    """How a frame stands in text and in JSON lines."""
    can_id, _, data = frame.partition("#")
    spaced = " ".join(data[at : at + 2] for at in range(0, len(data), 2))
    return f"  {can_id}   [{len(data) // 2}]  {spaced}".encode(), f'"data":"{data}"'.encode()
