"""Adapters through python-can: what is told of them, how their frames and stamps become blocks. No adapter is needed.

Frames come over python-can's virtual bus; what a driver does wrong is made up.
"""

from __future__ import annotations

import ast
import importlib.util
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import can
import pytest
from can.interfaces import BACKENDS
from can.interfaces.virtual import VirtualBus

import canalyze
from canalyze._core import Session
from canalyze.errors import SourceError
from canalyze.running.reading import SessionOptions
from canalyze.sources import live
from canalyze.sources.bridge import bus_name, buses
from canalyze.sources.bridge.buses import PythonCan
from canalyze.words import Words

CHANNEL = "test_buses"
PACKAGE = Path(canalyze.__file__).parent


@pytest.fixture
def sender() -> Iterator[can.BusABC]:
    """Give the other end of the virtual channel; stamps are those of the messages."""
    with can.Bus(interface="virtual", channel=CHANNEL, preserve_timestamps=True) as bus:
        yield bus


@pytest.fixture
def source() -> Iterator[PythonCan]:
    """Give the channel as it is listened to."""
    one = PythonCan("virtual", CHANNEL, first=3)
    yield one
    one.close()


def text_of(interface: str) -> str:
    """The source of an interface's module, which may not be importable here."""
    spec = importlib.util.find_spec(BACKENDS[interface][0].rpartition(".")[0])
    assert spec is not None and spec.submodule_search_locations
    place = Path(spec.submodule_search_locations[0], BACKENDS[interface][0].rpartition(".")[2])
    files = sorted(place.glob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    return "\n".join(file.read_text(encoding="utf-8") for file in files)


def parameters(interface: str) -> set[str]:
    """What the constructors of an interface take, by signature or out of their keywords."""
    text = text_of(interface)
    found = set(re.findall(r"""kwargs(?:\.get\(|\.pop\(|\[)\s*["'](\w+)["']""", text))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef) and node.name == "__init__":
            found |= {argument.arg for argument in node.args.args + node.args.kwonlyargs}
    return found


QUIET = {name: adapter.quiet for name, adapter in buses.ADAPTERS.items() if adapter.quiet}
RATED = {name for name, adapter in buses.ADAPTERS.items() if adapter.rated}


@pytest.mark.parametrize("interface", QUIET)
def test_a_switch_for_listening_is_a_parameter_of_the_interface(interface: str) -> None:
    assert QUIET[interface].keys() <= parameters(interface)
    state = QUIET[interface].get("state")
    assert state is None or state in can.BusState.__members__


def test_interfaces_without_a_switch_have_none() -> None:
    """One that python-can gives a switch later is to be taken up."""
    silent = ("listen", "silent", "passive")
    for interface in sorted(set(BACKENDS) - set(QUIET)):
        assert not {name for name in parameters(interface) if any(word in name for word in silent)}, interface


def test_each_interface_has_a_row() -> None:
    assert set(buses.ADAPTERS) == set(BACKENDS)
    for interface, adapter in buses.ADAPTERS.items():
        assert adapter.data_rate == "data_bitrate" or adapter.data_rate in parameters(interface)


def test_what_an_interface_needs_is_known_of_each() -> None:
    """Of every one but those that need nothing: SocketCAN, the network, the virtual bus."""
    nothing = {name for name, adapter in buses.ADAPTERS.items() if not (adapter.pip or adapter.driver)}
    assert nothing == {"socketcan", "socketcand", "virtual"}


@pytest.mark.parametrize("interface", sorted(set(BACKENDS) - {"virtual", "udp_multicast", "socketcan"}))
def test_what_cannot_be_opened_is_one_line(interface: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SourceError) as caught:
        PythonCan(interface, "0", first=0, bitrate=500_000)
    for lang in ("zh", "en"):
        line = caught.value.in_words(Words(lang))
        assert interface in line and "\n" not in line
        assert re.search(r"pip install '|driver|驱动|--option|adapter|适配器", line)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("interface", sorted(RATED))
def test_an_adapter_that_acknowledges_needs_the_rate(interface: str) -> None:
    """At a wrong one it would disturb the bus."""
    assert interface not in QUIET
    with pytest.raises(SourceError, match="--bitrate"):
        PythonCan(interface, "0", first=0)
    with pytest.raises(SourceError) as caught:  # goes on to what is missing here
        PythonCan(interface, "0", first=0, options={"bitrate": 250_000})
    assert caught.value.key != "bus.needs_rate"


def test_every_other_one_that_acknowledges_keeps_its_rate() -> None:
    """Unless it is told one: what has a rate of its own in python-can has a row."""
    for interface in set(BACKENDS) - set(QUIET) - RATED:
        assert not re.search(r"bitrate(: int)? ?= ?[1-9]", text_of(interface)), interface


def test_only_what_may_come_back_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(**_: Any) -> can.BusABC:
        raise can.CanInitializationError("no such device")

    monkeypatch.setattr(can, "Bus", refuse)
    with pytest.raises(SourceError, match="no such device"):
        PythonCan("kvaser", "0", first=0)
    patient = PythonCan("kvaser", "0", first=0, patient=True)
    with pytest.raises(live.LinkLost) as caught:
        patient.receive(0)
    assert "no such device" in str(caught.value.error)
    assert not patient.reopen()
    monkeypatch.undo()
    with pytest.raises(SourceError):  # what is not installed does not come by waiting
        PythonCan("canalystii", "0", first=0, bitrate=500_000, patient=True)


def test_names_that_may_have_been_meant() -> None:
    assert buses.known("pcan") and not buses.known("pkan")
    assert "pcan" in buses.near("pkan")
    assert "udp_multicast" in buses.near("UDP-Multicast")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("tty_baudrate=115200", ("tty_baudrate", 115200)),
        ("poll-interval=0.5", ("poll_interval", 0.5)),
        ("listen_only=False", ("listen_only", False)),
        ("serial=a=b", ("serial", "a=b")),
        ("empty=", ("empty", "")),
        ("nothing", None),
        ("=1", None),
        ("channel=1", None),
    ],
)
def test_options(text: str, found: object) -> None:
    assert buses.option(text) == found


@pytest.mark.parametrize(
    ("channel", "name"),
    [
        ("0", "can0"),
        ("PCAN_USBBUS1", "PCAN_USBBUS1"),
        ("/dev/ttyACM0", "ttyACM0"),
        ("\\\\.\\COM10", "COM10"),
        ("239.74.163.2", "239.74.163.2"),
        ("ff15:7079:7468:6f6e:6465:6d6f:6d63:6173", "ff15:7079:7468:6f6e:6465:6d6f:6d"),
        ("a b#c,d", "a_b_c_d"),
        ("@x", "can@x"),
    ],
)
def test_the_name_of_a_bus_can_be_read_again(channel: str, name: str) -> None:
    assert bus_name(channel) == name
    session = Session(SessionOptions(lang="en", format="jsonl"))
    session.begin("x", True, "candump")
    out = session.feed(f"(1.000000) {name} 123#00\n".encode()) + session.end() + session.finish()
    assert f'"bus":"{name}"'.encode() in out


def settings(interface: str, **given: Any) -> dict[str, Any]:
    """What python-can would be told."""
    told: dict[str, Any] = {}

    def take(**all_of_it: Any) -> can.BusABC:
        told.update(all_of_it)
        raise can.CanInitializationError("enough")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(can, "Bus", take)
        with pytest.raises(SourceError):
            PythonCan(interface, "0", first=0, **given)
    return told


def test_settings() -> None:
    assert settings("pcan")["state"] == "PASSIVE"
    assert settings("pcan", options={"state": "ACTIVE"})["state"] == "ACTIVE"
    assert settings("kvaser", bitrate=250_000) == {
        "interface": "kvaser",
        "channel": "0",
        "driver_mode": False,
        "bitrate": 250_000,
    }
    fd = {"bitrate": 500_000, "data_bitrate": 2_000_000, "fd": True}
    assert fd.items() <= settings("vector", **fd).items()
    assert settings("nixnet", **fd)["fd_bitrate"] == 2_000_000
    timing = settings("pcan", **fd)["timing"]
    assert (timing.nom_bitrate, timing.data_bitrate) == (500_000, 2_000_000)


def test_who_acknowledges() -> None:
    def acknowledges(interface: str, **options: Any) -> bool:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(can, "Bus", lambda **_: None)
            return PythonCan(interface, "0", first=0, bitrate=500_000, options=options).acknowledges

    assert acknowledges("gs_usb") and acknowledges("ixxat")
    assert not acknowledges("slcan") and not acknowledges("virtual")
    assert not acknowledges("slcan", listen_only=False)  # the user knows


def taken(source: PythonCan, wait_s: float = 0.05) -> list[tuple[int, int, int, bytes]]:
    """Blocks of one call: kind, bus, number, payload."""
    blocks = source.receive(wait_s)
    return [(kind, bus, number, blocks[at + 16 : end]) for kind, bus, number, at, end in live.heads(blocks)]


def decoded(blocks: bytes) -> list[str]:
    session = Session(SessionOptions(lang="en", format="convert", to="candump"))
    session.begin("live", False, "live")
    out = session.feed(blocks) + session.end() + session.finish()
    return out.decode().splitlines()


def test_frames_of_every_kind(source: PythonCan, sender: can.BusABC) -> None:
    now = 1_700_000_000.25
    sender.send(can.Message(timestamp=now, arbitration_id=0x60A, data=b"\x40\x08", is_extended_id=False))
    sender.send(can.Message(timestamp=now, arbitration_id=0x60A, data=b"", is_extended_id=True))
    sender.send(can.Message(timestamp=now, arbitration_id=1, dlc=3, is_remote_frame=True, is_extended_id=False))
    sender.send(
        can.Message(
            timestamp=now, arbitration_id=2, data=bytes(12), is_fd=True, bitrate_switch=True, is_extended_id=False
        )
    )
    assert decoded(received(source, 4)) == [
        f"(1700000000.250000) {CHANNEL} 60A#4008 R",
        f"(1700000000.250000) {CHANNEL} 0000060A# R",
        f"(1700000000.250000) {CHANNEL} 001#R3 R",
        f"(1700000000.250000) {CHANNEL} 002##1000000000000000000000000 R",
    ]


def test_blocks_have_the_bus_and_a_time(source: PythonCan, sender: can.BusABC) -> None:
    kinds = [(kind, bus) for kind, bus, _, _ in taken(source, 0)]
    assert kinds == [(live.BUS, 3), (live.UNTIL, 0)]
    before = time.time_ns()
    sender.send(can.Message(timestamp=time.time(), arbitration_id=1))
    found = taken(source, 0.5)
    assert [(kind, bus) for kind, bus, _, _ in found] == [(live.RECORDS, 3), (live.UNTIL, 0)]
    assert found[0][2] == 1
    assert before - 2_000_000_000 < found[1][2] <= time.time_ns()


def received(source: PythonCan, count: int) -> bytes:
    """Blocks with so many frames: a machine that stalls gets them by several calls."""
    blocks, deadline = b"", time.monotonic() + 20
    while sum(number for kind, _, number, *_ in live.heads(blocks) if kind == live.RECORDS) < count:
        assert time.monotonic() < deadline, blocks
        blocks += source.receive(0.5)
    return blocks


def stamps(blocks: bytes) -> list[float]:
    return [float(line[1 : line.index(")")]) for line in decoded(blocks)]


def test_stamps_that_are_no_dates_get_one_offset(source: PythonCan, sender: can.BusABC) -> None:
    for stamp in (17.5, 17.75, 18.0):
        sender.send(can.Message(timestamp=stamp, arbitration_id=1))
    first, second, third = stamps(received(source, 3))
    assert abs(first - time.time()) < 60
    assert (round(second - first, 5), round(third - first, 5)) == (0.25, 0.5)


def test_without_stamps_the_time_of_receipt_counts(source: PythonCan, sender: can.BusABC) -> None:
    for stamp in (0.0, float("nan")):
        sender.send(can.Message(timestamp=stamp, arbitration_id=1))
    assert all(abs(stamp - time.time()) < 60 for stamp in stamps(received(source, 2)))


def test_an_adapter_that_begins_anew_gets_another_offset(source: PythonCan, sender: can.BusABC) -> None:
    for stamp in (500.0, 0.5):
        sender.send(can.Message(timestamp=stamp, arbitration_id=1))
    first, second = stamps(received(source, 2))
    assert 0 <= second - first < 60


def test_time_waits_for_an_adapter_that_is_late(source: PythonCan, sender: can.BusABC) -> None:
    """What is said to be over lies before every frame that comes with the same delay."""
    for _ in range(3):
        sender.send(can.Message(timestamp=time.time() - 0.5, arbitration_id=1))
        until = taken(source, 0.5)[-1][2]
        assert until < (time.time() - 0.5) * 1e9


class Failing:
    """A driver that raises so often, then gives a frame."""

    def __init__(self, times: int, error: Exception) -> None:
        """`times` errors come first."""
        self.times = times
        self.error = error

    def recv(self, _: float) -> can.Message | None:
        self.times -= 1
        if self.times >= 0:
            raise self.error
        return can.Message(timestamp=time.time(), arbitration_id=1) if self.times == -1 else None

    def shutdown(self) -> None:
        raise self.error


@pytest.mark.parametrize("error", [can.CanOperationError("unplugged"), OSError(5, "unplugged"), KeyError("unplugged")])
def test_an_unplugged_adapter(source: PythonCan, error: Exception) -> None:
    source._bus = Failing(1, error)  # type: ignore[assignment]
    assert [kind for kind, *_ in taken(source)][1:] == [live.RECORDS, live.DROPPED, live.UNTIL]
    source._bus = Failing(10, error)  # type: ignore[assignment]
    with pytest.raises(live.LinkLost) as caught:
        source.receive(0)
    for lang in ("zh", "en"):
        assert "unplugged" in caught.value.error.in_words(Words(lang))
    assert source.reopen()
    assert taken(source)[-1][0] == live.UNTIL


class Unplugged(Failing):
    """A driver that gives so many frames, then raises for ever."""

    def recv(self, _: float) -> can.Message | None:
        self.times -= 1
        if self.times >= 0:
            return can.Message(timestamp=time.time(), arbitration_id=1)
        raise self.error


def test_frames_just_before_an_adapter_is_unplugged_are_not_lost(source: PythonCan) -> None:
    source._bus = Unplugged(3, can.CanOperationError("unplugged"))  # type: ignore[assignment]
    received(source, 3)
    for _ in range(2):
        with pytest.raises(live.LinkLost) as caught:
            source.receive(0)
        assert "unplugged" in str(caught.value.error)


def test_what_python_can_logs_is_a_remark(source: PythonCan, capfd: pytest.CaptureFixture[str]) -> None:
    import logging

    for _ in range(3):
        logging.getLogger("can.some").warning("something is %s", "odd")
    assert [str(remark) for remark in source.remarks()] == [f"{CHANNEL}: python-can: something is odd"]
    assert capfd.readouterr().err == ""


def test_nothing_is_ever_sent(monkeypatch: pytest.MonkeyPatch, sender: can.BusABC) -> None:
    sent = []
    monkeypatch.setattr(VirtualBus, "send", lambda *args: sent.append(args))
    monkeypatch.setattr(can.BusABC, "send_periodic", lambda *args: sent.append(args))
    source = PythonCan("virtual", CHANNEL, first=0)
    source.receive(0)
    source.reopen()
    source.receive(0)
    source.close()
    assert not sent


LISTENING = (
    "sources/bridge/buses.py",
    "sources/live.py",
    "sources/socketcan.py",
    "commands/sniff.py",
    "running/listening.py",
    "running/recording.py",
)


@pytest.mark.parametrize("name", LISTENING)
def test_no_source_names_a_call_that_sends(name: str) -> None:
    """Neither a method that sends, nor a write to what is listened to."""
    called = set()
    for node in ast.walk(ast.parse((PACKAGE / name).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Attribute):
            called.add(node.attr)
    assert not called & {
        "send",
        "sendmsg",
        "sendto",
        "sendall",
        "sendmmsg",
        "send_periodic",
        "Notifier",
        "flush_tx_buffer",
    }
