"""`canalyze monitor` on vcan: what is sent is on the screen and in the recording, a bus that goes is said.

Needs vcan0 up and the right to take it down and up (root); else skipped, unless CANALYZE_LIVE=required.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import pytest
from captures import CanFrame, read_log
from monitor_terminal import Terminal, drawn

BUS = "vcan0"
BEATS = [CanFrame(BUS, 0x705, b"\x05"), CanFrame(BUS, 0x185, bytes(range(8)))]


@pytest.fixture(autouse=True)
def interface() -> Iterator[None]:
    lack = "" if Path("/sys/class/net", BUS).exists() else f"no interface {BUS}"
    lack = lack or ("no right to take interfaces down" if os.geteuid() or not shutil.which("ip") else "")
    if lack and os.environ.get("CANALYZE_LIVE") == "required":
        pytest.fail(lack)
    if lack:
        pytest.skip(lack)
    link("up")
    yield
    link("up")


def link(state: str) -> None:
    subprocess.run(["ip", "link", "set", BUS, state], check=True)


def send(count: int) -> None:
    """Sends the frames so many times, a few ms apart."""
    with can.Bus(interface="socketcan", channel=BUS) as bus:
        for _ in range(count):
            for frame in BEATS:
                bus.send(can.Message(arbitration_id=frame.can_id, data=frame.data, is_extended_id=False))
            time.sleep(0.002)


def sent_until(terminal: Terminal, holds: Callable[[bytes], bool]) -> bool:
    """Sends frames again and again, since the first ones may come before an interface that is back is listened to."""
    for _ in range(20):
        send(3)
        if terminal.until(holds, seconds=3):
            return True
    return False


def test_bus_on_the_screen_and_in_the_recording(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path, BUS, "--record", "seen.log")
    assert terminal.until(drawn(b"LIVE"))
    send(100)
    assert terminal.until(drawn(b"heartbeat of node 5")) and terminal.until(drawn(b"5 TPDO1"))
    assert terminal.until(drawn(b"200")), "the frames are counted"
    terminal.type(b"q")
    code, said = terminal.end()
    assert code == 0 and "seen.log" in said
    seen = [
        (frame.can_id, frame.data) for frame in read_log((tmp_path / "seen.log").read_bytes().replace(b" T\n", b"\n"))
    ]
    assert seen == [(frame.can_id, frame.data) for _ in range(100) for frame in BEATS]


def test_bus_that_goes_is_said_and_the_screen_stays(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path, BUS)
    assert terminal.until(drawn(b"LIVE"))
    link("down")
    assert terminal.until(drawn(b"LOST"))
    assert terminal.process.poll() is None
    terminal.type(b"q")
    code, said = terminal.end()
    assert code == 2 and said.count("\n") == 1 and BUS in said


def test_states_are_unknown_until_they_are_heard_again(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path, BUS, "--reconnect")
    assert terminal.until(drawn(b"LIVE"))
    send(20)
    assert terminal.until(drawn(b"Operational"))
    link("down")
    assert terminal.until(drawn(b"unknown")) and terminal.until(drawn(b"down"))
    # Without it the LIVE of before would be taken for that of the interface that is back, and frames sent too early.
    assert terminal.until(drawn(b"WAITING"))
    link("up")
    assert terminal.until(lambda shown: b"LIVE" in shown.rpartition(b"WAITING")[2])
    assert sent_until(terminal, lambda shown: b"Operational" in shown.rpartition(b"unknown")[2])
    terminal.type(b"\x03")
    assert terminal.end()[0] == 0


def test_bus_that_comes_back_is_listened_to_again(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path, BUS, "--reconnect")
    assert terminal.until(drawn(b"LIVE"))
    link("down")
    assert terminal.until(drawn(b"WAITING"))
    link("up")
    assert terminal.until(lambda shown: b"LIVE" in shown.rpartition(b"WAITING")[2])
    assert sent_until(terminal, drawn(b"heartbeat of node 5"))
    terminal.type(b"\x03")
    assert terminal.end()[0] == 0
