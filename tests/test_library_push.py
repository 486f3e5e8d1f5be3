"""What is pushed or in memory gives what a file gives: messages, bytes, MCAP's reader, a Notifier, a live channel."""

import asyncio
import io
import subprocess
import sys
import threading
from collections.abc import AsyncIterator, Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import can
import canopen
import mcap.reader
import pytest
from captures import SAMPLES
from msgspec.structs import replace

import canalyze
from canalyze.records.problems import ProblemTexts

NETWORK = SAMPLES / "network/sync-and-pdos.log"
OTHERS = [NETWORK, SAMPLES / "sdo-abort.log", SAMPLES / "services.log"]
DRIVE = SAMPLES.parent / "eds/drive.eds"
STORIES = [*sorted((SAMPLES / "stories").glob("*.log"))[::4], *OTHERS]
LIBRARY: Any = canalyze
"""Without types: what a program that has none may do."""


def messages(path: Path) -> list[can.Message]:
    """The frames of a log as python-can reads them, with the channels as they stand there."""
    lines = [line for line in path.read_text().splitlines(keepends=True) if line.startswith("(")]
    found = list(can.CanutilsLogReader(io.StringIO("".join(lines))))
    for message, line in zip(found, lines, strict=True):
        if int(line.split()[2].partition("#")[0], 16) & 0x2000_0000:  # of most classes its reader makes 29-bit frames
            message.is_error_frame, message.is_extended_id = True, False
    return found


def same(event: Any) -> Any:
    """An event without what only a file has: its name, its lines, annotated lines, eight digits of an error frame."""
    if isinstance(event, canalyze.Frame):
        return replace(event, file="", line=None, _id=f"{event.id:X}")
    if isinstance(event, canalyze.Note):
        return replace(event, line=None, about_line=None)
    if isinstance(event, canalyze.Finding):
        return replace(event, file="", line=None, cause_line=None, lines=())
    return event


def of_capture(capture: canalyze.Capture) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
    return (
        list(map(same, capture.events)),
        list(map(same, capture.findings)),
        unnumbered(capture.problems),
        [same_root(one) for one in capture.problems.roots],
    )


def same_root(one: canalyze.Problem) -> tuple[str, Any, Any]:
    return one.kind, one.node, one.begin


def unnumbered(incidents: Iterable[canalyze.Problem]) -> list[Any]:
    """Give them in one order and without numbers: a listener has those of the order in which they were reported."""
    alike = [
        replace(one, id=0, effects=(), cause=one.cause and replace(one.cause, id=0), texts=ProblemTexts())
        for one in incidents
    ]
    return sorted(alike, key=lambda one: (one.begin.frame, one.kind, one.nodes))


def of_listener(given: list[can.Message]) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
    listener = canalyze.Listener()
    for message in given:
        listener(message)
    listener.stop()
    events = [one for one in listener if not isinstance(one, canalyze.ProblemChange)]
    findings = [one for one in events if isinstance(one, canalyze.Finding)]
    roots = [same_root(one) for one in listener.problems.roots]
    return list(map(same, events)), list(map(same, findings)), unnumbered(listener.problems), roots


@pytest.mark.parametrize("path", STORIES, ids=lambda path: path.stem)
def test_every_way_in_gives_the_same(path: Path, tmp_path: Path) -> None:
    """A message says that it was received, so the file has to, too: verdicts heed it."""
    given = messages(path)
    lines = [line.split() for line in path.read_text().splitlines() if line.startswith("(")]
    path = tmp_path / path.name
    path.write_text("".join(f"{' '.join(line[:3])} R\n" for line in lines))
    whole = of_capture(canalyze.open(path))
    assert len(whole[0]) > 10
    assert of_capture(canalyze.open(path.read_bytes())) == whole
    assert of_capture(canalyze.open(given)) == whole
    assert of_capture(canalyze.open(iter(given))) == whole
    events, findings, incidents, roots = of_listener(given)
    assert events == whole[0]
    assert (findings, incidents, roots) == (whole[1], whole[2], whole[3])


def test_bytes_may_be_compressed_or_a_file() -> None:
    with (SAMPLES / "sdo-block.mcap").open("rb") as file:
        opened = canalyze.open(file)
        assert opened.paths == () and opened.name.endswith("sdo-block.mcap")
        assert not file.closed
    assert list(map(same, opened.events)) == list(map(same, canalyze.open(SAMPLES / "sdo-block.mcap").events))
    import gzip

    packed = canalyze.open(gzip.compress(NETWORK.read_bytes()))
    assert list(packed.transfers) == list(canalyze.open(NETWORK).transfers) == list(packed.transfers)
    assert canalyze.open(io.BytesIO(NETWORK.read_bytes())).nodes[5].state == "pre-operational"


@pytest.mark.parametrize("make", [mcap.reader.make_reader, lambda file: mcap.reader.make_reader(file).iter_messages()])
def test_mcap_by_its_own_reader(make: Callable[[Any], Any]) -> None:
    whole = canalyze.open(SAMPLES / "services.mcap")
    with (SAMPLES / "services.mcap").open("rb") as file:
        read = canalyze.open(make(file))
    assert list(map(same, read.events)) == list(map(same, whole.events))
    assert whole.transfers == read.transfers != []


def test_what_python_can_knows_of_a_frame_is_kept() -> None:
    given = [
        can.Message(
            timestamp=1.0, arbitration_id=0x705, is_remote_frame=True, dlc=1, is_extended_id=False, channel="a"
        ),
        can.Message(timestamp=1.1, arbitration_id=0x12345678, data=b"\1", is_rx=False, channel="b"),
        can.Message(
            timestamp=1.2, arbitration_id=0x185, data=bytes(12), is_fd=True, bitrate_switch=True, is_extended_id=False
        ),
        can.Message(timestamp=1.3, arbitration_id=0x4, is_error_frame=True, data=bytes(8), channel="a"),
    ]
    listener = canalyze.Listener(names={"a": "first"})
    for message in given:
        listener.on_message_received(message)
    listener.stop()
    frames = [one for one in listener.take() if isinstance(one, canalyze.Frame)]
    expected = [
        ("first", True, False, False, False, "rx"),
        ("b", False, True, False, False, "tx"),
        (None, False, False, True, False, "rx"),
        ("first", False, False, False, True, "rx"),
    ]
    facts = [(one.bus, one.remote, one.extended, one.fd, one.error, one.direction) for one in frames]
    assert facts == expected
    assert [one.brs for one in frames] == [False, False, True, False]
    assert [one.t_ns for one in frames] == [1_000_000_000, 1_100_000_000, 1_200_000_000, 1_300_000_000]
    assert [one.t_s for one in frames] == [1.0, 1.1, 1.2, 1.3]
    assert [one.direction for one in canalyze.open(given).frames] == ["rx", "tx", "rx", "rx"]


def test_stamps_that_nobody_set_are_none() -> None:
    bare = [can.Message(arbitration_id=0x705, data=b"\5", is_extended_id=False) for _ in range(3)]
    assert [one.t for one in canalyze.open(bare).frames] == [None, None, None]
    assert [one.timestamp for one in bare] == [0.0, 0.0, 0.0]
    bare[2].timestamp = 0.5
    assert [one.t_ns for one in canalyze.open(bare).frames] == [0, 0, 500_000_000]


@pytest.fixture
def bus(request: pytest.FixtureRequest) -> Iterator[tuple[can.BusABC, can.BusABC]]:
    """Two ends of a bus within the process."""
    with (
        can.Bus(interface="virtual", channel=request.node.name) as one,
        can.Bus(interface="virtual", channel=request.node.name) as other,
    ):
        yield one, other


def frame(number: int) -> can.Message:
    return can.Message(arbitration_id=0x185, data=number.to_bytes(4, "little"), is_extended_id=False)


def test_a_notifier_calls_it(bus: tuple[can.BusABC, can.BusABC]) -> None:
    sender, received = bus
    events: list[canalyze.Event] = []
    threads: set[str] = set()
    enough = threading.Event()

    def take(event: canalyze.Event) -> None:
        events.append(event)
        threads.add(threading.current_thread().name)
        if isinstance(event, canalyze.Frame) and event.frame == 100:
            enough.set()

    notifier = can.Notifier(received, [canalyze.Listener(take, name="test")])
    for number in range(100):
        sender.send(frame(number))
    assert enough.wait(30)
    notifier.stop()
    frames = [one for one in events if isinstance(one, canalyze.Frame)]
    assert [int.from_bytes(one.data, "little") for one in frames] == list(range(100))
    assert {one.file for one in frames} == {"test"}
    assert threading.current_thread().name not in {name for name in threads if "Notifier" in name or "can" in name}


def test_beside_the_network_of_python_canopen(request: pytest.FixtureRequest) -> None:
    """What its client reads and writes is in the transfers, by its own description."""
    with canopen.Network() as network, canopen.Network() as machine:
        network.connect(interface="virtual", channel=request.node.name, receive_own_messages=True)
        machine.connect(interface="virtual", channel=request.node.name)
        machine.create_node(5, str(DRIVE)).nmt.state = "PRE-OPERATIONAL"
        node = network.add_node(5, str(DRIVE))
        with canalyze.Listener(eds={5: node.object_dictionary}) as listener:
            network.notifier.add_listener(listener)
            node.sdo[0x1017].raw = 500
            vendor = node.sdo[0x1018][1].raw
            transfers = (event for event in listener if isinstance(event, canalyze.Transfer))
            written, read = next(transfers), next(transfers)
            assert network.notifier is not None
            network.notifier.remove_listener(listener)
    assert (written.node, written.object, written.value, written.status) == (5, "1017h:00", 500, "ok")
    assert (read.name, read.value, read.status) == ("vendor-ID", vendor, "ok")


def test_iterating_ends_when_the_notifier_stops(bus: tuple[can.BusABC, can.BusABC]) -> None:
    sender, received = bus
    with canalyze.Listener() as listener:
        notifier = can.Notifier(received, [listener])
        for number in range(20):
            sender.send(frame(number))
        found = []
        for event in listener:
            if isinstance(event, canalyze.Frame):
                found.append(event.frame)
                if event.frame == 20:
                    notifier.stop()
    assert found == list(range(1, 21))
    assert listener.frames == 20 and listener.take() == [] and listener.get(0) is None
    listener(frame(1))  # too late, and no error
    assert listener.frames == 20


def test_many_threads_may_push() -> None:
    listener = canalyze.Listener()
    channels = ["a", "b", "c", "d"]

    def push(channel: str) -> None:
        for number in range(200):
            message = frame(number)
            message.channel, message.timestamp = channel, 1.0 + number / 1000
            listener(message)
            listener.advance()

    threads = [threading.Thread(target=push, args=(channel,)) for channel in channels]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    listener.stop()
    frames = [one for one in listener.take() if isinstance(one, canalyze.Frame)]
    assert [one.frame for one in frames] == list(range(1, 801))
    for channel in channels:
        own = [
            int.from_bytes(one.data, "little") for one in frames if one.bus is not None and one.bus.endswith(channel)
        ]
        assert own == list(range(200))


def test_a_callback_may_call_it_and_may_fail() -> None:
    seen: list[int] = []

    def take(event: canalyze.Event) -> None:
        if isinstance(event, canalyze.Frame):
            seen.append(event.frame)
            if 7 <= event.frame < 9:
                listener(stamped(1 + event.frame / 10))
                assert seen[-1] == event.frame, "one event at a time"
            if event.frame == 9:
                raise LookupError("of the user's")

    listener = canalyze.Listener(take)
    for number in range(6):
        listener(stamped(1 + number / 10))
    assert seen == [1, 2, 3, 4, 5, 6]
    with pytest.raises(LookupError, match="of the user's"):
        listener(stamped(1.6))
    assert seen == [1, 2, 3, 4, 5, 6, 7, 8, 9]
    listener(stamped(1.9))
    assert seen == [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]


def stamped(seconds: float) -> can.Message:
    return can.Message(timestamp=seconds, arbitration_id=0x705, data=b"\5", is_extended_id=False)


def test_silence_is_found_without_a_frame() -> None:
    """Nobody is heard any more, and no frame is there to tell."""
    listener = canalyze.Listener()
    for number in range(20):
        listener(stamped(10 + number / 10))
    assert not [one for one in listener.take() if isinstance(one, canalyze.Finding)]
    listener.advance(0.05)
    assert not listener.take()
    listener.advance(ns=2_000_000_000)
    found = [one for one in listener.take() if isinstance(one, canalyze.Finding)]
    assert [one.code for one in found] == ["HBT005"]  # nobody was heard: the bus, and no node, is silent
    listener.advance(to_ns=0)  # time never goes back
    assert not listener.take()


def test_an_error_of_the_bus_is_a_gap_and_no_lost_heartbeat() -> None:
    listener = canalyze.Listener()
    for number in range(20):
        listener(stamped(10 + number / 10))
    listener.on_error(OSError("unplugged"))
    listener.advance(5)
    listener.stop()
    assert not [one for one in listener.take() if isinstance(one, canalyze.Finding)]
    assert listener.complaints == ("OSError: unplugged",)


def test_what_nobody_takes_is_bounded() -> None:
    listener = canalyze.Listener(most=10)
    for number in range(25):
        listener(stamped(1 + number / 10))
    assert [one.frame for one in listener.take() if isinstance(one, canalyze.Frame)] == list(range(16, 26))
    assert listener.lost == 15


def test_asyncio(bus: tuple[can.BusABC, can.BusABC]) -> None:
    sender, received = bus

    async def by_iterating() -> list[int]:
        listener = canalyze.Listener()
        notifier = can.Notifier(received, [listener], loop=asyncio.get_running_loop())
        for number in range(10):
            sender.send(frame(number))
        found = []
        async for event in listener:
            if isinstance(event, canalyze.Frame):
                found.append(event.frame)
                if event.frame == 10:
                    notifier.stop()
        return found

    async def by_reader() -> list[int]:
        async def some() -> AsyncIterator[can.Message]:
            reader = can.AsyncBufferedReader()
            for number in range(5):
                reader.on_message_received(stamped(1.0 + number))
            for _ in range(5):
                yield await reader.get_message()

        listener = canalyze.Listener()
        return [event.frame async for event in listener.over(some()) if isinstance(event, canalyze.Frame)]

    assert asyncio.run(by_iterating()) == list(range(1, 11))
    assert asyncio.run(by_reader()) == list(range(1, 6))


def test_a_live_channel(request: pytest.FixtureRequest) -> None:
    channel = request.node.name
    found: list[canalyze.Event] = []
    with (
        canalyze.live(channel, interface="virtual") as listening,
        can.Bus(interface="virtual", channel=channel) as sender,
    ):
        for number in range(50):
            sender.send(frame(number))
        for event in listening:
            found.append(event)
            if isinstance(event, canalyze.Frame) and event.frame == 50:
                listening.stop()
    assert [one.frame for one in found if isinstance(one, canalyze.Frame)] == list(range(1, 51))
    assert listening.get(0) is None
    with pytest.raises(canalyze.SourceError):
        canalyze.live("nowhere0")
    with pytest.raises(ValueError, match="interface='nothing'"):
        canalyze.live("nowhere0", interface="nothing")
    for wrong in ([], ["a", "a"], [5]):
        with pytest.raises(ValueError, match="channels"):
            LIBRARY.live(*wrong)


@pytest.mark.parametrize(
    ("source", "kind", "said"),
    [
        (5, TypeError, "source: .* not int"),
        ([5], TypeError, "source: .* not int"),
        (None, TypeError, "source: .* not NoneType"),
        ([], ValueError, "source: no file"),
        (io.StringIO("text"), TypeError, "open for text"),
        ([stamped(1.0), "x.log"], TypeError, "source: item 2 is no can.Message but str"),
        (["x.log", stamped(1.0)], (TypeError, canalyze.SourceError), "x.log"),
    ],
)
def test_what_is_no_source_is_said(source: object, kind: type[Exception], said: str) -> None:
    with pytest.raises(kind, match=said):
        LIBRARY.open(source)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: LIBRARY.Listener(5), "on_event=5"),
        (lambda: LIBRARY.Listener(colour="red"), "no option colour"),
        (lambda: LIBRARY.Listener(filter=5), "filter=5: str is needed, not int"),
        (lambda: LIBRARY.Listener(eds=5), "eds=5"),
        (lambda: LIBRARY.Listener(eds={5: 6}), r"eds\[5\]: .* not int"),
        (lambda: LIBRARY.Listener()("frame"), "message: a can.Message is needed, not str"),
        (lambda: LIBRARY.Listener(most=0), "most=0"),
        (lambda: LIBRARY.Listener().advance(-1), "seconds=-1"),
        (lambda: LIBRARY.Listener().advance(1, ns=5), "seconds and ns"),
        (lambda: LIBRARY.open(NETWORK, merge=3), "merge=3"),
        (lambda: LIBRARY.open(NETWORK, bitrate=1.5), "bitrate=1.5"),
        (lambda: LIBRARY.open(NETWORK).transfers.of(object=5), "object=5"),
        (lambda: LIBRARY.open(NETWORK).findings.of(5), "code=5"),
        (lambda: LIBRARY.open(NETWORK).signals[1.5], r"signals\[1.5\]"),
        (lambda: LIBRARY.open(NETWORK).lines("a"), "ranges"),
        (lambda: LIBRARY.open(NETWORK).tables("nothing"), "table='nothing'"),
        (lambda: LIBRARY.open(NETWORK).check(at_least="bad"), "at_least='bad'"),
    ],
)
def test_what_cannot_be_is_said_with_its_name(call: Callable[[], object], said: str) -> None:
    with pytest.raises((TypeError, ValueError), match=said) as raised:
        call()
    assert "canalyze" in str(raised.traceback[-1].path)


def test_a_program_of_a_user_is_typed(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(
        "import can\nimport canalyze\n\n"
        "def show(event: canalyze.Event) -> None:\n"
        "    if isinstance(event, canalyze.Transfer) and event.object is not None:\n"
        "        print(event.object.index + event.object.sub, event.t_s, event.t_ns)\n\n"
        "with can.Bus(interface='virtual', channel='x') as bus:\n"
        "    listener = canalyze.Listener(show, eds={5: 'drive.eds'}, lang='zh')\n"
        "    notifier = can.Notifier(bus, [listener])\n"
        "    listener.advance(0.5)\n"
        "    notifier.stop()\n"
        "capture = canalyze.open([can.Message()], filter='node=5')\n"
        "frame = capture.transfers.to_polars()\n"
        "print(frame.height, capture.nodes[5].dictionary, canalyze.diff('a.log', capture).differences)\n"
        "for event in canalyze.live('can0', bitrate='500k'):\n"
        "    show(event)\n"
    )
    command = [sys.executable, "-m", "mypy", "--strict", "--no-incremental", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=SAMPLES.parent)
    assert done.returncode == 0, done.stdout
