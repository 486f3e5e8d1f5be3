"""`canalyze sniff --rerun` and `--save` on real SocketCAN: every frame in the file, whatever becomes of the viewer.

What it must not do: need a display (the viewer is a page), or judge what stands on a timeline.
"""

from __future__ import annotations

import os
import signal
import urllib.request
from pathlib import Path

import pytest
from listeners import Listeners, cansend, lines_of_frames, need, wait_until
from listeners import bus as bus
from recordings import recording, verified
from viewers import listeners, viewer_of

LAST = "7FF#4C415354"


@pytest.fixture(autouse=True, scope="module")
def socketcan() -> None:
    need("vcan0", "vcan1")


def rows(path: Path) -> int:
    """Annotated frames in a recording."""
    return len(recording(path).rows("/frames", "TextLog:text"))


def test_two_buses_in_a_file_without_a_listener(bus: Listeners, tmp_path: Path) -> None:
    sniff = bus.sniff("vcan0", "vcan1", "--save", "out.rrd", listens=("vcan0", "vcan1"))
    cansend("vcan0", "705#00", "705#05", "185#1122")
    wait_until(lambda: (tmp_path / "out.rrd").stat().st_size, "rows in the file while it runs")
    assert listeners(sniff.process.pid) == set()
    cansend("vcan1", "706#00", LAST)
    sniff.wait_for(b"4C 41 53 54")
    done = sniff.stop()
    assert done.code == 0 and "out.rrd: timeline, " in done.err
    verified(tmp_path / "out.rrd")
    assert rows(tmp_path / "out.rrd") == len(lines_of_frames(done.out)) == 5


@pytest.mark.parametrize("what", [signal.SIGSTOP, signal.SIGKILL])
def test_the_viewer_is_for_this_machine_and_may_go(bus: Listeners, tmp_path: Path, what: signal.Signals) -> None:
    sniff = bus.sniff("vcan0", "--rerun", "--web", "--save", "out.rrd", "--record", "bus.log")
    cansend("vcan0", "705#00", "705#05")
    sniff.wait_for_complaint("open in a browser: ")
    url = sniff.err.partition("open in a browser: ")[2].split()[0]
    with urllib.request.urlopen(url) as answer:
        assert answer.status == 200
    found = listeners(sniff.process.pid)
    assert {address for address, _ in found} == {"127.0.0.1"} and len(found) == 2
    viewer = viewer_of(sniff.process.pid)
    assert viewer
    os.kill(viewer, what)
    for number in range(50):
        cansend("vcan0", f"185#{number:08X}")
    cansend("vcan0", LAST)
    sniff.wait_for(b"4C 41 53 54")
    sniff.send(signal.SIGINT)
    if what == signal.SIGSTOP:
        sniff.wait_for_complaint(" stays available; ")
        sniff.send(signal.SIGINT)
    done = sniff.ended()
    assert done.code == 0
    assert ("listening continues" in done.err) == (what == signal.SIGKILL)
    verified(tmp_path / "out.rrd")
    recorded = len((tmp_path / "bus.log").read_text().splitlines())
    assert rows(tmp_path / "out.rrd") == len(lines_of_frames(done.out)) == recorded == 53
