"""What `Live` makes of sources: order, time, a full queue, lost channels, the end. No CAN is needed.

The sources are made up: each says what it gives, and when.
"""

from __future__ import annotations

import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence

import pytest

from canalyze.errors import CanalyzeError, OutputError, SourceError
from canalyze.sources import live
from canalyze.sources.live import Live

DEADLINE_S = 10.0

Step = bytes | Exception | Callable[[], bytes]


class Made:
    """A source that gives one step after the other; then nothing, or its end."""

    def __init__(self, *steps: Step, names: Sequence[str] = ("can0",), first: int = 0, endless: bool = False) -> None:
        """Each step is what `receive` gives, raises or does."""
        self.names = names
        self.first = first
        self.steps = list(steps)
        self.endless = endless
        self.closed = 0
        self.back = True
        self.reopened = 0

    def receive(self, timeout_s: float) -> bytes:
        if self.steps:
            step = self.steps.pop(0)
            if isinstance(step, Exception):
                raise step
            return step() if callable(step) else step
        if not self.endless:
            raise live.Ended
        time.sleep(timeout_s)
        return b""

    def reopen(self) -> bool:
        self.reopened += 1
        return self.back

    def close(self) -> None:
        self.closed += 1


class Kept:
    """A recording in memory."""

    def __init__(self) -> None:
        """Empty."""
        self.blocks = b""
        self.told: list[CanalyzeError] = []

    def take(self, blocks: bytes) -> None:
        self.blocks += blocks

    def remarks(self) -> list[CanalyzeError]:
        told, self.told = self.told, []
        return told

    def close(self) -> None:
        pass


def frames(bus: int, count: int, size: int = 32) -> bytes:
    return live.records_block(bus, bytes(size * count), count)


def read_out(one: Live) -> bytes:
    """Everything until the end; fails rather than hangs."""
    until = time.monotonic() + DEADLINE_S
    out = b""
    while data := one.read():
        out += data
        assert time.monotonic() < until, "it does not end"
    return out


def read_until(one: Live, enough: Callable[[list[tuple[int, int, int]]], bool]) -> list[tuple[int, int, int]]:
    """What comes until it is enough."""
    until = time.monotonic() + DEADLINE_S
    out: list[tuple[int, int, int]] = []
    while not enough(out):
        out += kinds(one.read())
        assert time.monotonic() < until, out
    return out


def times(out: list[tuple[int, int, int]]) -> list[int]:
    return [number for kind, _, number in out if kind == live.UNTIL and number != live.RELEASE_ALL]


def kinds(blocks: bytes) -> list[tuple[int, int, int]]:
    return [(kind, bus, number) for kind, bus, number, _, _ in live.heads(blocks)]


def test_a_block_is_sixteen_bytes_and_its_payload() -> None:
    assert live.block(live.GAP, 7) == struct.pack("<BBBBIq", 6, 7, 0, 0, 0, 0)
    assert live.name_block(1, "can1") == struct.pack("<BBBBIq", 1, 1, 0, 0, 4, 0) + b"can1"
    assert live.dropped_block(2, 5, which=1) == struct.pack("<BBBBIq", 4, 2, 1, 0, 0, 5)
    assert live.until_block(-3) == struct.pack("<BBBBIq", 5, 0, 0, 0, 0, -3)


OTHER_SYSTEM = """
import psutil  # Rerun's, and it believes its own eyes
import pkgutil, select, signal, socket, sys
sys.modules["fcntl"] = None
for name in ("AF_CAN", "AF_UNIX", "MSG_DONTWAIT"):
    delattr(socket, name)
del select.poll, select.POLLIN, signal.SIGHUP
import canalyze
for found in pkgutil.walk_packages(canalyze.__path__, "canalyze."):
    if not found.name.endswith("__main__"):
        __import__(found.name)
from canalyze.errors import SourceError
from canalyze.sources.socketcan import SocketCan
try:
    SocketCan(["can0"])
except SourceError as error:
    print(error.key)
"""


def test_everything_can_be_imported_where_there_is_no_socketcan() -> None:
    """As on Windows and macOS; what cannot be there says so."""
    done = subprocess.run([sys.executable, "-c", OTHER_SYSTEM], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "live.not_linux\n"), done.stderr


def test_one_source_passes_as_it_is_and_is_recorded() -> None:
    given = live.name_block(0, "can0") + frames(0, 3) + live.until_block(5)
    recording = Kept()
    bus = Made(given, frames(0, 1))
    with Live([bus], recording=recording) as one:
        assert one.name == "can0" and one.format == "live" and not one.regular
        assert read_out(one) == given + frames(0, 1) == recording.blocks
        assert one.read() == b""
        assert one.taken == len(given + frames(0, 1))
    assert bus.closed


def test_several_sources_have_the_time_of_the_one_behind() -> None:
    ready = threading.Event()

    def late() -> bytes:
        ready.wait(DEADLINE_S)
        return live.until_block(20)

    def ahead() -> bytes:
        ready.set()
        return b""

    buses = [
        Made(frames(0, 1) + live.until_block(50), ahead, endless=True),
        Made(late, live.until_block(40), first=1, names=("can1",), endless=True),
    ]
    with Live(buses) as one:
        said = times(read_until(one, lambda out: 40 in times(out)))
    assert sorted(set(said)) == [20, 40]
    assert said == sorted(said)


def test_a_full_queue_leaves_out_and_says_so() -> None:
    batches = [frames(0, 10) for _ in range(20)]
    recording = Kept()
    go = threading.Event()

    def waits() -> bytes:
        assert go.wait(DEADLINE_S)
        return frames(0, 1)

    bus = Made(live.name_block(0, "can0"), *batches, live.gap_block(0), waits)
    with Live([bus], recording=recording, most=5 * len(batches[0])) as one:
        one.start()
        until = time.monotonic() + DEADLINE_S
        while len(bus.steps) and time.monotonic() < until:
            time.sleep(0.01)
        first = one.read()
        go.set()
        out = kinds(first + read_out(one))
    assert recording.blocks == live.name_block(0, "can0") + b"".join(batches) + live.gap_block(0) + frames(0, 1)
    shown = sum(number for kind, _, number in out if kind == live.RECORDS)
    dropped = [number for kind, _, number in out if kind == live.DROPPED]
    assert dropped == [one.unshown] and shown + one.unshown == 201
    assert (live.GAP, 0, 0) in out
    assert out.index((live.DROPPED, 0, one.unshown)) < out.index((live.RECORDS, 0, 1))


def test_what_was_left_out_is_said_at_the_end_too() -> None:
    with Live([Made(*[frames(0, 10) for _ in range(9)])], most=len(frames(0, 25))) as one:
        one.start()
        for thread in one._threads:
            thread.join(DEADLINE_S)
        out = kinds(read_out(one))
    assert out[-1] == (live.DROPPED, 0, one.unshown) and one.unshown > 0


def test_a_lost_channel_ends_it_with_what_to_do() -> None:
    bus = Made(frames(0, 2), live.LinkLost("can0", SourceError("live.unplugged", channel="can0")), endless=True)
    with Live([bus]) as one:
        out = b""
        with pytest.raises(SourceError, match=r"can0: the interface is gone.*--reconnect"):
            while True:
                out += one.read()
                assert out
        assert one.read() == b""
        assert [kind for kind, _, _ in kinds(out)][:3] == [live.RECORDS, live.BUS, live.GAP]
        assert one.failure


def test_a_lost_channel_is_waited_for() -> None:
    bus = Made(
        frames(0, 2) + live.until_block(7_000), live.LinkLost("can0", OSError(5, "Input/output error")), frames(0, 3)
    )
    with Live([bus], reconnect=True) as one:
        bus.back = False
        blocks = b""
        while bus.reopened < 2:
            blocks += one.read()
        assert one.waiting
        bus.back = True
        blocks += read_out(one)
        told = [str(remark) for remark in one.remarks()]
    assert not one.waiting
    assert [number for kind, _, number in kinds(blocks) if kind == live.RECORDS] == [2, 3]
    said = times(kinds(blocks))
    assert said[0] == 7_000 and 7_000 < said[-1] < 60e9, "the frames' own time goes on while it is away"
    assert len(told) == 2 and "waiting for can0" in told[0] and told[1] == "can0: receiving again"


def test_others_are_received_while_one_is_lost() -> None:
    lost = live.LinkLost("can1", SourceError("live.unplugged", channel="can1"))
    bus = Made(lost, frames(0, 4), names=("can0", "can1"), endless=True)
    bus.back = False
    with Live([bus]) as one:
        out = read_until(one, lambda out: (live.RECORDS, 0, 4) in out)
        assert one.away == {"can1"} and not one.waiting, "can0 is there"
        assert [str(remark).count("waiting for can1") for remark in one.remarks()] == [1]
        bus.back = True
        deadline = time.monotonic() + DEADLINE_S
        while one.away and time.monotonic() < deadline:
            assert one.read()
        assert [str(remark) for remark in one.remarks()] == ["can1: receiving again"]
    assert (live.GAP, 1, 0) in out and one.failure is None


def test_it_ends_when_the_last_of_several_goes() -> None:
    gone = [live.LinkLost(name, SourceError("live.unplugged", channel=name)) for name in ("can0", "can1")]
    bus = Made(gone[0], frames(1, 4), gone[1], names=("can0", "can1"), endless=True)
    bus.back = False
    out = b""
    with Live([bus]) as one, pytest.raises(SourceError, match=r"can1: the interface is gone.*--reconnect"):
        while True:
            out += one.read()
    assert (live.RECORDS, 1, 4) in kinds(out), "what came between is given"


def test_it_ends_when_the_last_of_several_sources_goes() -> None:
    def later() -> bytes:
        time.sleep(0.5)
        return frames(1, 3)

    first = Made(live.LinkLost("can0", SourceError("live.unplugged", channel="can0")), endless=True)
    first.back = False
    lost = live.LinkLost("can1", SourceError("live.unplugged", channel="can1"))
    second = Made(later, lost, names=("can1",), first=1, endless=True)
    out = b""
    with Live([first, second]) as one, pytest.raises(SourceError, match=r"can1: the interface is gone.*--reconnect"):
        while True:
            out += one.read()
    assert (live.RECORDS, 1, 3) in kinds(out) and first.closed


def test_a_source_that_ends_leaves_no_one_waiting_alone() -> None:
    first = Made(live.LinkLost("can0", SourceError("live.unplugged", channel="can0")), endless=True)
    first.back = False
    second = Made(live.Ended(), names=("can1",), first=1)
    with Live([first, second]) as one, pytest.raises(SourceError, match="can0: the interface is gone"):
        while one.read():
            pass


def test_a_source_that_is_lost_holds_no_other_back() -> None:
    gone = Made(live.until_block(1), live.LinkLost("can0", "gone"), endless=True)
    gone.back = False

    def pause() -> bytes:
        time.sleep(0.3)
        return b""

    ticks = [live.until_block(number) for number in (10, 20, 30)]
    alive = Made(pause, *ticks, names=("can1",), first=1, endless=True)
    with Live([gone, alive], reconnect=True) as one:
        read_until(one, lambda out: {10, 20, 30} <= set(times(out)))


def test_a_thread_that_breaks_is_no_silent_bus() -> None:
    with Live([Made(frames(0, 1), ValueError("what a driver\nsays"), endless=True)]) as one:
        assert kinds(one.read())
        with pytest.raises(SourceError, match="can0: receiving failed: ValueError: what a driver says"):
            while one.read():
                pass


def test_one_failure_ends_the_others() -> None:
    other = Made(endless=True, names=("can1",), first=1)
    with Live([Made(RuntimeError("broken")), other]) as one, pytest.raises(SourceError, match="broken"):
        while one.read():
            pass
    assert other.closed


def test_the_reader_has_its_turn_on_a_silent_bus() -> None:
    with Live([Made(endless=True)]) as one:
        for _ in range(3):
            begun = time.monotonic()
            assert kinds(one.read()) == [(live.UNTIL, 0, live.RELEASE_ALL)]
            assert time.monotonic() - begun < DEADLINE_S


def test_the_time_is_up() -> None:
    begun = time.monotonic()
    with Live([Made(endless=True)], duration_s=0.3) as one:
        read_out(one)
    assert 0.3 <= time.monotonic() - begun < DEADLINE_S


def test_stop_gives_what_was_received() -> None:
    bus = Made(frames(0, 1), endless=True)
    with Live([bus]) as one:
        one.read()
        bus.steps += [frames(0, 2), frames(0, 3)]
        one.stop()
        out = kinds(read_out(one))
    assert sum(number for kind, _, number in out if kind == live.RECORDS) == 5


def test_what_had_come_is_taken_also_where_the_machine_stalls_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live, "_LAST_S", 0.0)
    bus = Made(frames(0, 1), endless=True)
    with Live([bus]) as one:
        one.read()
        bus.steps += [frames(0, 2), frames(0, 3)]
        one.stop()
        out = kinds(read_out(one))
    assert sum(number for kind, _, number in out if kind == live.RECORDS) == 5


def test_at_the_end_a_lost_channel_does_not_hide_the_others() -> None:
    enough = threading.Event()

    def last() -> bytes:
        assert enough.wait(DEADLINE_S)
        return b""

    bus = Made(frames(0, 1), last, live.LinkLost("can1", "gone"), frames(0, 2), names=("can0", "can1"), endless=True)
    with Live([bus]) as one:
        one.read()
        one.stop()
        enough.set()
        out = kinds(read_out(one))
    assert sum(number for kind, _, number in out if kind == live.RECORDS) == 2
    gone = Made(*[live.LinkLost("can0", "gone")] * 50, endless=True)
    gone.steps.insert(0, last)
    enough.clear()
    with Live([gone]) as one:
        one.start()
        one.stop()
        enough.set()
        read_out(one)
    assert len(gone.steps) >= 48, "one that is gone for good is not asked again and again"


def test_stop_at_once() -> None:
    with Live([Made(*[frames(0, 1)] * 10, endless=True)]) as one:
        one.read()
        one.stop(now=True)
        assert one.read() == b""


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timer here")
def test_ctrl_c_while_it_waits() -> None:
    class Pressed(Exception):
        pass

    def press(_: int, __: object) -> None:
        raise Pressed

    before = signal.signal(signal.SIGALRM, press)
    try:
        with Live([Made(endless=True)]) as one, pytest.raises(Pressed):
            signal.setitimer(signal.ITIMER_REAL, 0.25)
            read_out(one)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_a_source_that_hangs_is_left_alone() -> None:
    hang = threading.Event()
    begun = time.monotonic()

    def hangs() -> bytes:
        hang.wait(120)
        return b""

    with Live([Made(hangs)]) as one:
        assert one.read()
    assert time.monotonic() - begun < 30, "it was waited for"
    hang.set()


def test_remarks_of_a_recording_and_a_source_are_told() -> None:
    recording = Kept()
    recording.told.append(OutputError("live.any", channels="x"))
    with Live([Made()], recording=recording) as one:
        assert [str(remark) for remark in one.remarks()] == ["any: listening to x"]
        assert one.remarks() == []


def test_closed_before_it_began() -> None:
    bus = Made()
    with Live([bus]) as one:
        pass
    assert bus.closed and one.read() == b""
