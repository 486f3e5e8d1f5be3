"""The source `socketcan` on vcan: what is sent arrives, whole and in order, and what goes wrong is said.

Needs vcan0 and vcan1 up and the right to take interfaces down and up (root); else skipped, unless
CANALYZE_LIVE=required. No test judges speed: deadlines only keep a broken run from lasting forever.
"""

from __future__ import annotations

import inspect
import os
import shutil
import signal
import socket
import struct
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from canalyze._core import Session
from canalyze.errors import SourceError
from canalyze.running.reading import SessionOptions
from canalyze.sources import live, netdevices, socketcan
from canalyze.sources.live import LinkLost, Live
from canalyze.sources.socketcan import SocketCan
from canalyze.words import Words

ONE, OTHER = "vcan0", "vcan1"
DEADLINE_S = 60.0
HEADER = struct.calcsize("@PIPNPNi0N") + struct.calcsize("@I0N")
"""Bytes of a struct mmsghdr, with the room behind."""
SLOT = 200
DONTROUTE = 4


def missing() -> str:
    if not all(Path("/sys/class/net", name).exists() for name in (ONE, OTHER)):
        return f"no interfaces {ONE} and {OTHER}"
    if os.geteuid() or not shutil.which("ip"):
        return "no right to take interfaces down"
    return ""


@pytest.fixture(autouse=True, scope="module")
def interfaces() -> None:
    lack = missing()
    if lack and os.environ.get("CANALYZE_LIVE") == "required":
        pytest.fail(lack)
    if lack:
        pytest.skip(lack)


def ip(command: str) -> None:
    subprocess.run(["ip", "link", *command.split()], check=True, timeout=DEADLINE_S)


@pytest.fixture
def restored() -> Iterator[None]:
    yield
    for name in (ONE, OTHER):
        if not Path("/sys/class/net", name).exists():
            ip(f"add dev {name} type vcan")
        ip(f"set {name} mtu 72 up")


@pytest.fixture
def send() -> Iterator[Callable[..., None]]:
    """Sends a frame: identifier with its bits, data, the interface."""
    open_: dict[str, socket.socket] = {}

    def sending(identifier: int, data: bytes = b"", name: str = ONE, fd: int | None = None) -> None:
        if name not in open_:
            one = open_[name] = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
            one.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
            one.bind((name,))
        size = 8 if fd is None else 64
        open_[name].send(struct.pack(f"@IBB2x{size}s", identifier, len(data), fd or 0, data))

    yield sending
    for one in open_.values():
        one.close()


def until(bus: SocketCan, enough: Callable[[bytes], bool]) -> bytes:
    """What comes until it is enough."""
    blocks = b""
    deadline = time.monotonic() + DEADLINE_S
    while not enough(blocks):
        assert time.monotonic() < deadline, "it does not come"
        blocks += bus.receive(0.1)
    return blocks


def count(blocks: bytes) -> int:
    return sum(number for kind, _, number, _, _ in live.heads(blocks) if kind == live.MESSAGES)


def seen(blocks: bytes) -> list[tuple[int, int, int, bytes]]:
    """Bus, message flags, length of the frame and its bytes, of each frame."""
    found = []
    for kind, bus, number, at, end in live.heads(blocks):
        if kind != live.MESSAGES:
            continue
        assert end - at == 16 + number * (HEADER + SLOT)
        for place in range(number):
            header = blocks[at + 16 + place * HEADER :][:HEADER]
            slot = blocks[at + 16 + number * HEADER + place * SLOT :][:SLOT]
            (size,) = struct.unpack_from("@I", header, HEADER - struct.calcsize("@P"))
            (flags,) = struct.unpack_from("@i", header, struct.calcsize("@PIPNPN"))
            found.append((bus, flags, size, slot[:size]))
    return found


def refused(*channels: str, first: int = 0) -> tuple[str, str]:
    with pytest.raises(SourceError) as error:
        SocketCan(channels, first=first)
    return error.value.in_words(Words("zh")), str(error.value)


def session(blocks: bytes) -> tuple[int, list[str]]:
    """How many frames the core finds in blocks, and its complaints."""
    one = Session(SessionOptions(lang="en", format="text", depth="brief"))
    one.begin("live", False, "live")
    one.feed(blocks)
    one.end()
    one.finish()
    return one.frames, one.complaints()


def test_frames_of_every_kind_arrive_as_they_are(send: Callable[..., None]) -> None:
    bus = SocketCan([ONE])
    send(0x123, b"abc")
    send(0x8000_0456, b"")
    send(0x4000_0701)
    send(0x124, bytes(range(48)), fd=1)
    send(0x2000_0004, bytes(8))
    blocks = until(bus, lambda blocks: count(blocks) >= 5)
    bus.close()
    frames = seen(blocks)
    assert [(size, struct.unpack_from("@IB", data)) for _, _, size, data in frames] == [
        (16, (0x123, 3)),
        (16, (0x8000_0456, 0)),
        (16, (0x4000_0701, 0)),
        (72, (0x124, 48)),
        (16, (0x2000_0004, 8)),
    ]
    assert all(flags & DONTROUTE for _, flags, _, _ in frames), "each was sent by this host"
    assert session(blocks) == (5, [])


def test_order_and_number_under_a_burst(send: Callable[..., None]) -> None:
    bus = SocketCan([ONE])
    most = 5000
    for number in range(most):
        send(number % 0x800, struct.pack("<I", number))
    frames = seen(until(bus, lambda blocks: count(blocks) >= most))
    bus.close()
    assert [struct.unpack_from("<I", data, 8)[0] for _, _, _, data in frames] == list(range(most))


def test_two_channels_are_one_source(send: Callable[..., None]) -> None:
    bus = SocketCan([OTHER, ONE], first=3)
    for number in range(50):
        send(number, name=ONE if number % 2 else OTHER)
    blocks = until(bus, lambda blocks: count(blocks) >= 50)
    bus.close()
    names = {index: blocks[at + 16 : end].decode() for kind, index, _, at, end in live.heads(blocks) if kind == 1}
    assert names == {3: OTHER, 4: ONE}
    for index, numbers in ((3, range(0, 50, 2)), (4, range(1, 50, 2))):
        assert [struct.unpack_from("@I", data)[0] for at, _, _, data in seen(blocks) if at == index] == list(numbers)


def test_what_waits_for_other_channels_does_not_wait_for_the_next_frame(send: Callable[..., None]) -> None:
    """Else a line of a slow bus would come when somebody else speaks, or with the next tick."""
    bus = SocketCan([ONE, OTHER])
    send(1)
    until(bus, lambda blocks: count(blocks) >= 1)
    begun = time.time_ns()
    (said,) = [number for kind, _, number, _, _ in live.heads(bus.receive(5.0)) if kind == live.UNTIL]
    bus.close()
    assert time.time_ns() - begun < 4_500_000_000
    assert said >= begun - 5_000_000


def test_any_is_what_is_up(restored: None) -> None:
    ip(f"set {OTHER} down")
    bus = SocketCan(["any"])
    assert list(bus.names) == [ONE]
    assert [str(remark) for remark in bus.remarks()] == [f"any: listening to {ONE}"]
    bus.close()
    ip(f"set {ONE} down")
    assert refused("any")[1] == f"any: no CAN interface is up; bring one up: sudo ip link set {ONE} up"


def test_time_goes_on_when_nothing_comes() -> None:
    bus = SocketCan([ONE])
    before = time.time_ns()
    begun = time.monotonic()
    times = [number for _ in range(5) for kind, _, number, _, _ in live.heads(bus.receive(0.1)) if kind == live.UNTIL]
    bus.close()
    assert len(times) == 5 and times == sorted(times)
    assert before < times[-1] < time.time_ns()
    assert time.monotonic() - begun > 0.4


def test_no_frame_is_behind_its_time(send: Callable[..., None]) -> None:
    """An `until` says that every frame up to there was given."""
    bus = SocketCan([ONE, OTHER])
    said = 0
    for number in range(300):
        send(number % 0x7FF, name=ONE if number % 3 else OTHER)
        for channel in bus._channels:
            channel.stamp = None
        blocks = bus.receive(0.02)
        assert all(channel.stamp > said for channel in bus._channels if channel.stamp)
        said = max(number for kind, _, number, _, _ in live.heads(blocks) if kind == live.UNTIL)
    bus.close()


@pytest.mark.parametrize(
    ("channels", "said"),
    [
        (("can77",), f"can77: no such CAN interface; available: {ONE}, {OTHER}"),
        (("an-interface-of-a-long-name",), "an-interface-of-a-long-name: no such CAN interface; available: "),
        (("",), ": no such CAN interface; available: "),
        (("lo",), f"lo: not a CAN interface; CAN interfaces: {ONE}, {OTHER}"),
        ((ONE, ONE), f"{ONE}: given twice"),
        ((ONE, "any"), f"{ONE}: given twice"),
    ],
)
def test_what_cannot_be_listened_to(channels: tuple[str, ...], said: str) -> None:
    chinese, english = refused(*channels)
    assert english.startswith(said)
    assert chinese != english


def test_an_interface_that_is_down(restored: None) -> None:
    ip(f"set {ONE} down")
    assert refused(ONE)[1] == f"{ONE}: the interface is down; bring it up: sudo ip link set {ONE} up"


def test_no_index_left() -> None:
    assert refused(ONE, OTHER, first=255)[1] == "too many channels, at most 256"


def test_patience_waits_from_the_beginning(restored: None, send: Callable[..., None]) -> None:
    ip(f"set {ONE} down")
    bus = SocketCan([ONE], patient=True)
    with pytest.raises(LinkLost) as lost:
        bus.receive(0.1)
    assert "is down" in str(lost.value.error)
    assert not bus.reopen()
    ip(f"set {ONE} up")
    assert bus.reopen()
    send(0x11)
    until(bus, lambda blocks: count(blocks) == 1)
    bus.close()
    with pytest.raises(SourceError):
        SocketCan(["lo"], patient=True)


@pytest.mark.parametrize(
    ("goes", "comes", "said"),
    [
        (f"set {ONE} down", (f"set {ONE} up",), "went down; bring it up"),
        (f"del {ONE}", (f"add dev {ONE} type vcan", f"set {ONE} up"), "is gone; check"),
    ],
)
def test_a_channel_goes_and_comes(
    goes: str, comes: tuple[str, ...], said: str, restored: None, send: Callable[..., None]
) -> None:
    with Live([SocketCan([ONE, OTHER])], reconnect=True) as one:
        blocks = b""
        told: list[str] = []

        def reads(enough: Callable[[], bool]) -> None:
            nonlocal blocks
            deadline = time.monotonic() + DEADLINE_S
            while not enough():
                assert time.monotonic() < deadline, told
                blocks += one.read()
                told.extend(str(remark) for remark in one.remarks())

        send(0x100, name=OTHER)
        reads(lambda: count(blocks) == 1)
        ip(goes)
        reads(lambda: len(told) == 1)
        assert said in told[0] and told[0].endswith(f"; waiting for {ONE}")
        send(0x101, name=OTHER)
        reads(lambda: count(blocks) == 2)
        for command in comes:
            ip(command)
        reads(lambda: len(told) == 2)
        assert told[1] == f"{ONE}: receiving again"
        send(0x102, name=ONE)
        reads(lambda: count(blocks) == 3)
    assert [bus for kind, bus, _, _, _ in live.heads(blocks) if kind == live.GAP] == [0]
    assert session(blocks) == (3, [])


def test_without_patience_it_ends(restored: None, send: Callable[..., None]) -> None:
    with Live([SocketCan([ONE])]) as one:
        send(0x100)
        blocks = one.read()
        send(0x101)
        ip(f"set {ONE} down")
        with pytest.raises(SourceError, match=f"{ONE}: the interface went down; .*--reconnect"):
            while data := one.read():
                blocks += data
        assert one.read() == b""
    assert count(blocks) == 2, "what came before it is not lost"


def test_what_the_kernel_dropped_is_counted_once(send: Callable[..., None]) -> None:
    bus = SocketCan([ONE])
    listening = bus._channels[0].socket
    assert listening is not None
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 20_000)
    bus._channels[0].small = True
    for _ in range(3000):
        send(0x123, bytes(8))
    blocks = until(bus, lambda blocks: count(blocks) > 0)
    send(0x124, bytes(8))  # tells of the drops before it
    blocks += bus.receive(0.2)
    for _ in range(1000):
        send(0x125, bytes(8))
    blocks += bus.receive(0.2)
    time.sleep(0.11)
    bus.receive(0)
    remarks = [str(remark) for remark in bus.remarks()]
    blocks += bus.ending()
    assert bus.ending() == b""
    bus.close()
    received = count(blocks)
    lost = [number for kind, _, number, _, _ in live.heads(blocks) if kind == live.DROPPED]
    assert len(lost) == 1, "those behind the last frame"
    assert len(remarks) == 1 and "net.core.rmem_max" in remarks[0]
    frames, complaints = session(blocks)
    assert frames == received
    assert len(complaints) == 2 and f"(total {4001 - received})" in complaints[-1]


def test_time_does_not_pass_frames_that_are_missing(send: Callable[..., None]) -> None:
    bus = SocketCan([ONE])
    listening = bus._channels[0].socket
    assert listening is not None
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 20_000)
    for _ in range(1000):
        send(0x123, bytes(8))
    blocks = until(bus, lambda blocks: count(blocks) > 0)
    kinds = [kind for kind, *_ in live.heads(blocks)]
    assert live.GAP in kinds[kinds.index(live.MESSAGES) : -1] and kinds[-1] == live.UNTIL
    assert live.GAP not in [kind for kind, *_ in live.heads(bus.receive(0.2))], "once is enough"
    send(0x124, bytes(8))  # tells of the drops before it
    assert live.GAP not in [kind for kind, *_ in live.heads(until(bus, lambda blocks: count(blocks) > 0))]
    bus.close()


def test_bus_off_is_said_once(send: Callable[..., None]) -> None:
    bus = SocketCan([ONE])
    for _ in range(3):
        send(0x2000_0040, bytes(8))
        until(bus, lambda blocks: count(blocks) == 1)
        time.sleep(0.11)
        bus.receive(0)
    told = [str(remark) for remark in bus.remarks()]
    bus.close()
    assert len(told) == 1 and f"sudo ip link set {ONE} type can restart-ms 100" in told[0]


def test_bus_off_is_told_with_its_frame(send: Callable[..., None]) -> None:
    bus = SocketCan([ONE])
    for _ in range(20):
        bus.receive(0)  # what is looked at now and then was looked at just before
    send(0x2000_0040, bytes(8))
    until(bus, lambda blocks: count(blocks) == 1)
    told = [str(remark) for remark in bus.remarks()]
    bus.close()
    assert len(told) == 1 and "bus-off" in told[0]


def test_bus_off_is_told_at_the_end(send: Callable[..., None]) -> None:
    bus = SocketCan([ONE])
    bus.receive(0)
    send(0x2000_0040, bytes(8))
    assert bus.ending() == b""
    told = [str(remark) for remark in bus.remarks()]
    bus.close()
    assert len(told) == 1 and "bus-off" in told[0]


def test_hardware_stamps_fall_back(send: Callable[..., None]) -> None:
    bus = SocketCan([ONE], hardware_stamps=True)
    for _ in range(60):
        send(0x123)
        until(bus, lambda blocks: count(blocks) == 1)
    told = [str(remark) for remark in bus.remarks()]
    blocks = until(bus, lambda blocks: bool(blocks))
    bus.close()
    assert told == [f"{ONE}: the adapter has no hardware timestamps, using kernel timestamps"]
    assert all(abs(n - time.time_ns()) < 60e9 for kind, _, n, _, _ in live.heads(blocks) if kind == live.UNTIL)


def test_a_clock_that_was_set_is_a_gap(send: Callable[..., None], monkeypatch: pytest.MonkeyPatch) -> None:
    bus = SocketCan([ONE])
    send(0x123)
    until(bus, lambda blocks: count(blocks) == 1)
    really = time.time_ns
    monkeypatch.setattr(time, "time_ns", lambda: really() + 3_600_000_000_000)
    kinds = [kind for kind, *_ in live.heads(bus.receive(0.01))]
    assert kinds == [live.GAP, live.UNTIL]
    assert [kind for kind, *_ in live.heads(bus.receive(0.01))] == [live.UNTIL]
    bus.close()


def test_a_stopped_process_loses_nothing(send: Callable[..., None]) -> None:
    listens, says = os.pipe()
    child = os.fork()
    if child == 0:  # receives until a frame says that it is the last
        total = 0
        bus = SocketCan([ONE])
        os.write(says, b"!")
        done = False
        while not done:
            blocks = bus.receive(0.1)
            total += count(blocks)
            done = any(struct.unpack_from("@I", data)[0] == 0x7FF for _, _, _, data in seen(blocks))
        os._exit(0 if total == 2001 else 1)
    os.read(listens, 1)
    os.close(listens)
    os.close(says)
    os.kill(child, signal.SIGSTOP)
    for _ in range(2000):
        send(0x123, bytes(8))
    time.sleep(1.5)
    os.kill(child, signal.SIGCONT)
    send(0x7FF)
    deadline = time.monotonic() + DEADLINE_S
    while (ended := os.waitpid(child, os.WNOHANG))[0] == 0:
        if time.monotonic() > deadline:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.05)
    assert ended[1] == 0


def beside(bus: SocketCan, monkeypatch: pytest.MonkeyPatch, ahead_ns: int) -> None:
    """Put a hardware stamp, of a clock that is so far ahead, beside each last frame."""
    really = bus._batch.last

    def last() -> tuple[int | None, int | None, int | None]:
        kernel, _, drops = really()
        return kernel, None if kernel is None else kernel + ahead_ns, drops

    monkeypatch.setattr(bus._batch, "last", last)


def test_time_is_that_of_hardware_stamps(send: Callable[..., None], monkeypatch: pytest.MonkeyPatch) -> None:
    bus = SocketCan([ONE], hardware_stamps=True)
    beside(bus, monkeypatch, -1_000_000_000_000)
    send(0x123)
    blocks = until(bus, lambda blocks: count(blocks) == 1) + bus.receive(0.1)
    now = time.time_ns()
    bus.close()
    for kind, _, number, at, _ in live.heads(blocks):
        assert kind != live.MESSAGES or blocks[at + 2] == 1
        if kind == live.UNTIL:
            last = number
    assert 990e9 < now - last < 1010e9
    assert bus.remarks() == []


def test_several_hardware_clocks_are_put_in_no_order(
    send: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    bus = SocketCan([ONE, OTHER], hardware_stamps=True)
    beside(bus, monkeypatch, -1_000_000_000_000)
    send(0x123)
    blocks = until(bus, lambda blocks: count(blocks) == 1)
    bus.close()
    assert [str(remark) for remark in bus.remarks()] == [
        f"{ONE}: hardware timestamps use another clock and cannot be ordered with other channels, "
        "using kernel timestamps"
    ]
    assert [blocks[at + 2] for kind, _, _, at, _ in live.heads(blocks) if kind == live.MESSAGES] == [0]


def test_it_never_sends() -> None:
    """Nothing in the source writes to a socket but the question for the bit rate, which goes to the kernel."""
    for text in (inspect.getsource(socketcan), inspect.getsource(netdevices).replace("kernel.send(asked)", "")):
        assert not any(word in text for word in (".send", ".write(", "sendmsg", "sendmmsg"))
