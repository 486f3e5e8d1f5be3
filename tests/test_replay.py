"""Captures replayed as live sources: everything comes through, at its time, and no more is read than is due."""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import pytest
from captures import SAMPLES, CanFrame, log_text, run_canalyze, spaced

from canalyze import _core
from canalyze.errors import SourceError
from canalyze.running.reading import Reading, SessionOptions
from canalyze.sources import open_capture
from canalyze.sources.live import RECORDS, RELEASE_ALL, UNTIL, heads
from canalyze.sources.replay import FASTEST, RATE, SLOWEST, Replay
from canalyze.words import Words

T = TypeVar("T")
WORDS = Words("en")


class Listener:
    """What the reading loops tell."""

    def __init__(self) -> None:
        """Nothing told yet."""
        self.ended = False
        self.said: list[str] = []
        self.errors: list[SourceError] = []

    def during(self, wait: Callable[[], T]) -> T | None:
        return wait()

    def complain(self, line: str) -> None:
        self.said.append(line)

    def failed(self, error: SourceError) -> None:
        self.errors.append(error)

    def step(self, size: int, frames: int) -> None:
        pass


def replay(*files: Path, speed: float = 0.0, listener: Listener | None = None) -> Replay:
    frames = _core.Session(SessionOptions(format="convert", to="packed"))
    names = [str(file) for file in files]
    results = Reading(frames, WORDS, listener or Listener(), open_input=open_capture).over(names)
    return Replay(names[0], results, speed=speed)


def through(source: Replay, form: str = "jsonl") -> bytes:
    session = _core.Session(SessionOptions(lang="en", format=form))
    taken: Any = source
    loop = Reading(session, WORDS, Listener(), open_input=lambda _: taken, given_format=True, frameless=True)
    return b"".join(loop.over(["replay"]))


def meaning(text: str) -> list[str]:
    """The bus, the frame and what it means of each line, without stamps and directions."""
    lines = []
    for line in text.splitlines():
        words = [word for word in line.split() if not word.startswith("(")]
        lines.append(" ".join(word for word in words if word not in ("RX", "TX", "-", "B", "E")))
    return lines


CAPTURES = [
    *sorted(SAMPLES.glob("*.log")),
    *sorted((SAMPLES / "network").glob("*.log")),
    *(SAMPLES / "rules" / f"{code}.log" for code in ("CAP002", "HBT001", "SDO005", "SYN001", "EMC001")),
    SAMPLES / "services.mcap",
    SAMPLES / "services.asc",
]


@pytest.mark.parametrize("capture", CAPTURES, ids=lambda path: path.name)
def test_everything_comes_through(capture: Path) -> None:
    expected = run_canalyze(["--lang", "en", "decode", "-t", "n", capture]).decode()
    assert meaning(through(replay(capture), "text").decode()) == meaning(expected)


def frames(count: int, step_us: int) -> bytes:
    return log_text(spaced([CanFrame("can0", 0x705, b"\x05")] * count, step_us=step_us))


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    """Two seconds of heartbeats, one every 100 ms."""
    path = tmp_path / "beats.log"
    path.write_bytes(frames(21, 100_000))
    return path


class Clock:
    """Time that goes on only where it is waited for, whatever the machine does meanwhile."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """It begins at 0 and replaces this machine's."""
        self.now = 0.0
        monkeypatch.setattr(time, "monotonic", lambda: self.now)
        monkeypatch.setattr(threading.Event, "wait", lambda _, timeout: self.pass_(timeout))

    def pass_(self, seconds: float) -> None:
        self.now += seconds


def test_stamps_pace_it(capture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = replay(capture, speed=8.0)
    clock = Clock(monkeypatch)
    assert through(source).count(b'"kind":"frame"') == 21
    assert 0.25 <= clock.now < 0.3


def test_time_goes_on_between_frames(capture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = replay(capture, speed=0.5)
    untils = []
    clock = Clock(monkeypatch)
    while clock.now < 0.5:
        untils += [number for kind, _, number, _, _ in heads(source.read()) if kind == UNTIL]
    assert untils == sorted(untils)
    assert 200_000_000 < untils[-1] - untils[0] < 300_000_000


def test_pause_and_speed(capture: Path) -> None:
    source = replay(capture, speed=1.0)
    source.read()
    source.paused = True
    before = {number for kind, _, number, _, _ in heads(source.read()) if kind == UNTIL}
    time.sleep(0.2)
    assert {number for kind, _, number, _, _ in heads(source.read()) if kind == UNTIL} == before
    source.paused = False
    source.speed = 0.0
    assert b"".join(iter(source.read, b"")).count(bytes.fromhex("05 07 00 00")) >= 19


def test_steps_of_speed(capture: Path) -> None:
    source = replay(capture, speed=1.0)
    for _ in range(12):
        source.faster(True)
    assert source.speed == 0.0
    source.faster(False)
    assert source.speed == FASTEST
    for _ in range(30):
        source.faster(False)
    assert source.speed == SLOWEST


def test_long_silence_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "two-days.log"
    path.write_bytes(frames(2, 86_400_000_000))
    clock = Clock(monkeypatch)
    assert through(replay(path, speed=1.0)).count(b'"kind":"frame"') == 2
    assert clock.now < 5


def test_no_stamps_come_at_a_fixed_rate_and_stay_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "console.log"
    path.write_bytes(b"  can0  705   [1]  05\n" * 300)
    source = replay(path, speed=1.0)
    clock = Clock(monkeypatch)
    blocks = b"".join(iter(source.read, b""))
    assert 0.25 < clock.now < 0.35
    assert source.fixed_rate == RATE
    assert {number for kind, _, number, _, _ in heads(blocks) if kind == UNTIL} == {RELEASE_ALL}


def test_memory_is_bounded(tmp_path: Path) -> None:
    path = tmp_path / "long.log"
    path.write_bytes(frames(100_000, 1000))
    source = replay(path, speed=1.0)
    for _ in range(5):
        source.read()
    assert len(source._records) < 4 << 20
    source.stop()
    assert source.read() == b""


def test_several_files_are_one_capture(capture: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.log"
    other.write_bytes(frames(3, 1000))
    assert through(replay(capture, other)).count(b'"kind":"frame"') == 24


def test_file_that_cannot_be_read_is_told_before(tmp_path: Path) -> None:
    listener = Listener()
    source = replay(tmp_path / "missing.log", listener=listener)
    assert not source.prime()
    assert [error.key for error in listener.errors] and source.read() == b""


def test_time_for_which_the_program_was_stopped_is_not_caught_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    capture = tmp_path / "capture.log"
    capture.write_bytes(log_text(CanFrame("can0", 0x185, b"\1", second * 1_000_000) for second in range(50)))
    source = replay(capture, speed=1.0)
    now = time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now)

    def frames() -> int:
        return sum(number for kind, _, number, *_ in heads(source.read()) if kind == RECORDS)

    assert frames() == 1
    now += 1000.0
    assert frames() == 1
