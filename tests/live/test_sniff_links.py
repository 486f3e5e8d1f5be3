"""What `canalyze sniff` says and does when an interface is not there, goes, and comes back.

Needs the right to make vcan interfaces (root of a guest); without it the tests are skipped, unless
CANALYZE_LIVE=required. The interface is this file's own.
"""

from __future__ import annotations

import re
import subprocess
import time
from collections.abc import Iterator

import pytest
from captures import sort_rows
from listeners import (
    DEADLINE_S,
    Heartbeats,
    Listener,
    Listeners,
    cansend,
    listeners,
    need,
    unless_the_machine_stalls,
    wait_until,
)
from listeners import bus as bus

LINK = "vcan8"
GONE = 4 * Heartbeats.PERIOD_S + 1
"""Long enough that a node that is judged across the gap would be told lost."""


@pytest.fixture(autouse=True, scope="module")
def socketcan() -> None:
    need("vcan0", right=ip("link", "add", "dev", LINK, "type", "vcan"))
    ip("link", "del", LINK)


def ip(*arguments: str) -> bool:
    """Runs `ip`; whether it could."""
    return subprocess.run(["ip", *arguments], capture_output=True, check=False, timeout=DEADLINE_S).returncode == 0


def up() -> None:
    assert ip("link", "set", LINK, "up")


def down() -> None:
    assert ip("link", "set", LINK, "down")


def add() -> None:
    assert ip("link", "add", "dev", LINK, "type", "vcan")
    up()


def delete() -> None:
    assert ip("link", "del", LINK)


@pytest.fixture
def link() -> Iterator[None]:
    """The interface is there and up."""
    add()
    yield
    ip("link", "del", LINK)


def complaints(listener: Listener) -> list[str]:
    """Lines on standard error about the interface; not those of the summary."""
    return [line for line in listener.err.splitlines() if LINK in line and " frames in " not in line]


def refused(bus: Listeners, *channels: str) -> str:
    """The one line with which it ends at once."""
    ended = bus.sniff(*channels, listens=()).ended()
    assert (ended.code, ended.out) == (2, b"")
    (line,) = ended.err.splitlines()
    assert line.startswith("canalyze: ")
    return line


def test_an_interface_that_is_not_there(bus: Listeners) -> None:
    assert "vcan9" in refused(bus, "vcan9")
    assert "vcan9" in refused(bus, "vcan0", "vcan9")


def test_an_interface_that_is_down(bus: Listeners, link: None) -> None:
    down()
    line = refused(bus, LINK)
    assert LINK in line and f"ip link set {LINK}" in line, "it says what to do"


@pytest.mark.parametrize("go", [down, delete])
def test_it_ends_when_the_interface_goes(go: object, bus: Listeners, link: None) -> None:
    sniff = bus.sniff(LINK, "--format", "jsonl", "--record", "all.log", listens=[LINK])
    cansend(LINK, "60A#4008100000000000", "58A#4108100017000000")
    sniff.wait_for(b'"58A"')
    go()  # type: ignore[operator]
    ended = sniff.ended()
    assert ended.code == 2
    assert len(complaints(sniff)) == 1, ended.err
    said = sort_rows(ended.out)
    assert [row["status"] for row in said.transfers] == ["incomplete"]
    assert not said.above_info(), said.complaint()
    assert (bus.directory / "all.log").read_text().count("\n") == 2


def came_back(sniff: Listener) -> None:
    wait_until(lambda: listeners(LINK) > 0, f"{sniff.name} listens again; it complains: {sniff.err!r}")


@pytest.mark.parametrize(("go", "come"), [(down, up), (delete, add)], ids=["down-up", "del-add"])
def test_it_waits_for_the_interface(go: object, come: object, bus: Listeners, link: None) -> None:
    """What began before goes on after it; who is silent then is told."""

    def judge() -> None:
        ip("link", "del", LINK)
        add()
        waits_for_the_interface(bus, go, come)

    unless_the_machine_stalls(bus, judge)


def waits_for_the_interface(bus: Listeners, go: object, come: object) -> None:
    sniff = bus.sniff(LINK, "--reconnect", "--format", "jsonl", "--record", "all.log", listens=[LINK])
    before = Heartbeats(LINK)
    before.start(5, 6)
    shown = Heartbeats.SHOW_THE_PERIOD
    wait_until(lambda: sniff.out.count(b'"id":"705"') > shown, "heartbeats before")
    # The request waits when the interface goes: on a bus that runs on, its server would be called silent.
    cansend(LINK, "60A#4008100000000000", "58A#4108100017000000", "60A#6000000000000000")
    wait_until(lambda: sniff.out.count(b'"id":"60A"') == 2, "the request that waits")
    go()  # type: ignore[operator]
    sniff.wait_for_complaint(LINK)
    before.close()
    time.sleep(GONE)
    assert len(complaints(sniff)) == 1, sniff.err
    count = sniff.out.count(b'"id":"705"')
    come()  # type: ignore[operator]
    came_back(sniff)
    after = Heartbeats(LINK)
    try:
        after.resume(5, 6)
        wait_until(lambda: sniff.out.count(b'"id":"705"') > count + shown, "heartbeats after")
        cansend(LINK, "60A#4000100000000000", "58A#4300100091010F00")
        wait_until(lambda: b"91010F00" in sniff.out, "the transfer after")
        time.sleep(2 * Heartbeats.PERIOD_S)
        said = sort_rows(whole_lines(sniff))
        assert not said.above_info(), said.complaint()
        assert len(complaints(sniff)) == 2, sniff.err
        after.stop(6)
        wait_until(lambda: b"HBT002" in sniff.out, "the node that fell silent afterwards")
    finally:
        after.close()
    ended = sniff.stop()
    assert ended.code == 0, ended.err
    said = sort_rows(ended.out)
    assert [(row["code"], row["node"]) for row in said.above_info()][:1] == [("HBT002", 6)], said.complaint()
    assert [row["status"] for row in said.transfers if row["index"] == "1000"] == ["ok"]
    assert (bus.directory / "all.log").read_text().count("\n") == len(said.frames)


def whole_lines(listener: Listener) -> bytes:
    out = listener.out
    return out[: out.rfind(b"\n") + 1]


def test_an_interface_that_comes_later(bus: Listeners) -> None:
    ip("link", "del", LINK)
    sniff = bus.sniff(LINK, "--reconnect", "-t", "n", listens=())
    try:
        sniff.wait_for_complaint(LINK)
        time.sleep(1)
        assert sniff.process.poll() is None
        add()
        came_back(sniff)
        cansend(LINK, "705#05")
        sniff.wait_for(b"705")
    finally:
        ip("link", "del", LINK)
    assert re.search(rf"{LINK}", sniff.err)
    assert sniff.stop().code == 0


@pytest.mark.parametrize("options", [["--reconnect"], []], ids=["reconnect", "plain"])
@pytest.mark.parametrize(("go", "come"), [(down, up), (delete, add)], ids=["down-up", "del-add"])
def test_one_of_two_channels_goes(go: object, come: object, options: list[str], bus: Listeners, link: None) -> None:
    sniff = bus.sniff("vcan0", LINK, *options, "-t", "n", listens=["vcan0", LINK])
    cansend(LINK, "705#05")
    sniff.wait_for(b"vcan8  TX - -  705")
    go()  # type: ignore[operator]
    sniff.wait_for_complaint(LINK)
    cansend("vcan0", "706#05")
    sniff.wait_for(b"vcan0  TX - -  706")
    (line,) = complaints(sniff)
    assert line.endswith(f"; waiting for {LINK}"), "it is said once, and that it is waited for"
    come()  # type: ignore[operator]
    came_back(sniff)
    cansend(LINK, "707#05")
    sniff.wait_for(b"vcan8  TX - -  707")
    cansend("vcan0", "708#05")
    sniff.wait_for(b"vcan0  TX - -  708")
    assert sniff.stop().code == 0


def test_it_ends_when_the_last_of_two_channels_goes(bus: Listeners, link: None) -> None:
    assert ip("link", "add", "dev", "vcan7", "type", "vcan") and ip("link", "set", "vcan7", "up")
    try:
        sniff = bus.sniff("vcan7", LINK, "-t", "n", listens=["vcan7", LINK])
        down()
        sniff.wait_for_complaint(LINK)
        cansend("vcan7", "706#05")
        sniff.wait_for(b"vcan7  TX - -  706")
    finally:
        ip("link", "del", "vcan7")
    ended = sniff.ended()
    assert ended.code == 2
    assert "vcan7: the interface is gone" in ended.err and "--reconnect" in ended.err
