"""`canalyze sniff` on buses that every machine has: python-can's virtual and multicast ones.

What it must not do: judge the annotation itself, which is that of `decode`; SocketCAN has tests of its own (`live/`).
"""

from __future__ import annotations

import json
import os
import pty
import re
import resource
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import can
import pytest
from captures import run_canalyze
from conftest import Done, Runner, command, environment
from virtual_bus import FLOOD, NODE, TEXT, frame

from canalyze import SourceError
from canalyze import open as open_capture

SCRIPT = Path(__file__).with_name("virtual_bus.py")
DEADLINE_S = 60.0
"""For what a user would see within seconds; a loaded machine may take its time."""
ATTEMPTS = 5
"""A machine may stall for so long that a heartbeat is late."""
EXPECTED = f"""\
[[sdo]]
node = {NODE}
direction = "download"
object = "1017:00"
value = 100

[[sdo]]
node = {NODE}
direction = "upload"
object = "1008:00"
value = "{TEXT}"

[[state]]
node = {NODE}
state = "operational"
"""


def process(traffic: str, *args: str, cwd: Path, lang: str = "en", **how: object) -> subprocess.Popen[bytes]:
    line = [sys.executable, str(SCRIPT), traffic, "--lang", lang, "sniff", "-i", "virtual", *args]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | how
    return subprocess.Popen(line, cwd=cwd, env=environment(), **pipes)  # type: ignore[call-overload, no-any-return]


def sniffed(traffic: str, *args: str, cwd: Path, lang: str = "en") -> Done:
    with process(traffic, *args, cwd=cwd, lang=lang) as running:
        out, err = running.communicate(timeout=DEADLINE_S)
    return Done(running.returncode, out.decode(), err.decode())


def without_end(out: str) -> list[str]:
    """Lines up to the last frame: what silence after it brings is not in a file."""
    lines = out.splitlines()
    while lines and lines[-1].startswith("#"):
        lines.pop()
    return lines


def frames_of(path: Path) -> list[str]:
    """The frames of a recording, as a log has them; formats differ in their digits."""
    out = path.with_name(path.name + ".again.log")
    run_canalyze(["convert", path, out, "--force"])
    return [
        re.sub(r"000\)", ")", line) if re.match(r"\(\d+\.\d{9}\)", line) else line
        for line in out.read_text().splitlines()
    ]


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_a_session_reads_as_its_recording_does(tmp_path: Path, lang: str) -> None:
    for _ in range(ATTEMPTS):
        options = ("--record", "bus.log", "--record", "bus.mcap", "--force")
        done = sniffed("session", "bus", *options, cwd=tmp_path, lang=lang)
        if "HBT" not in "".join(without_end(done.out)):
            break  # else the machine stalled: live that is told at once, of a file with the frame that comes late
    assert done.code == 0
    decoded = run_canalyze(["decode", "--lang", lang, tmp_path / "bus.log"]).decode()
    assert without_end(done.out) == without_end(decoded)
    assert len(without_end(done.out)) > 25
    assert frames_of(tmp_path / "bus.mcap") == frames_of(tmp_path / "bus.log")
    frames = len((tmp_path / "bus.log").read_text().splitlines())
    said = done.complaints
    assert re.match(rf"canalyze: bus[:：] ?{frames} ?(frames in|帧)", said[0])
    assert all(line.startswith("canalyze: ") for line in said)
    assert any(("2 completed" if lang == "en" else "完成2") in line for line in said)
    assert [name in done.err for name in ("bus.log", "bus.mcap")] == [True, True]
    assert len(said) <= 6


def test_a_session_in_colours_with_numbers(tmp_path: Path) -> None:
    done = sniffed("session", "bus", "-n", "--color", "always", "--record", "bus.log", cwd=tmp_path)
    assert done.code == 0 and "\x1b[" in done.out
    plain = re.sub(r"\x1b\[[0-9;]*m", "", done.out)
    numbers = [int(found[1]) for found in re.finditer(r"^ *([0-9]+):  \(", plain, re.MULTILINE)]
    assert numbers == list(range(1, len((tmp_path / "bus.log").read_text().splitlines()) + 1))
    assert "\x1b" not in sniffed("session", "bus", cwd=tmp_path).out


@pytest.mark.parametrize(
    ("lang", "listens", "heading"),
    [("en", "listening to bus; Ctrl-C", "node  frames"), ("zh", "正在监听 bus；", "节点  帧数")],
)
@pytest.mark.parametrize("form", ["text", "jsonl"])
def test_on_a_terminal_it_says_that_it_listens_and_ends_with_its_nodes(
    tmp_path: Path, lang: str, listens: str, heading: str, form: str
) -> None:
    ours, theirs = pty.openpty()
    with process("session", "bus", "--format", form, cwd=tmp_path, lang=lang, stdout=theirs, stderr=theirs) as running:
        os.close(theirs)
        shown = b""
        with suppress(OSError):  # at the end there is no one at the other side
            while piece := os.read(ours, 65536):
                shown += piece
        assert running.wait(DEADLINE_S) == 0
    os.close(ours)
    said = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode()).replace("\r", "")
    assert said.count(listens) == 1
    assert said.count(f"\n{heading}") == (form == "text"), said[-2000:]
    if form == "text":
        assert len(re.findall(rf"\n +{NODE} +\d+ +(?:Operational|操作状态) +0 +0\n", said)) == 1


def test_a_session_as_json_lines(tmp_path: Path) -> None:
    done = sniffed("session", "bus", "--format", "jsonl", "--record", "bus.log", cwd=tmp_path)
    rows = [json.loads(line) for line in done.lines]
    frames = [row for row in rows if row["kind"] == "frame"]
    assert len(frames) == len((tmp_path / "bus.log").read_text().splitlines())
    assert {row["bus"] for row in frames} == {"bus"}
    values = [row["value"] for row in rows if row["kind"] == "transfer"]
    assert values == [100, TEXT]


def test_expectations_that_hold(tmp_path: Path) -> None:
    (tmp_path / "boot.expect.toml").write_text(EXPECTED)
    done = sniffed("session", "bus", "--expect", "boot.expect.toml", cwd=tmp_path)
    assert (done.code, re.findall("EXP[0-9]+", done.out)) == (0, [])
    assert "canalyze: expectations: all met" in done.complaints


@pytest.mark.parametrize("further", [[], ["--filter", "id=7FF"], ["--count", "1000"]])
def test_an_expectation_that_does_not_hold(tmp_path: Path, further: list[str]) -> None:
    (tmp_path / "boot.expect.toml").write_text(EXPECTED.replace("value = 100", "value = 200"))
    done = sniffed("session", "bus", "--expect", "boot.expect.toml", *further, cwd=tmp_path)
    assert done.code == 1
    assert re.findall("EXP[0-9]+", done.out) == ["EXP003"]
    assert "canalyze: expectations: 1 not met" in done.complaints


def test_a_heartbeat_that_stops_is_told_while_the_bus_is_silent(tmp_path: Path) -> None:
    """Not only at the end: no frame comes behind it."""
    (tmp_path / "boot.expect.toml").write_text(f"[[heartbeat]]\nnode = {NODE}\nperiod_ms = 100\ntolerance_ms = 500\n")
    with process("stopped", "bus", "--expect", "boot.expect.toml", cwd=tmp_path) as running:
        assert running.stdout is not None
        next(line for line in running.stdout if b"EXP009" in line and b"no heartbeat for " in line)
        assert running.poll() is None
        running.send_signal(signal.SIGINT)
        running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 1


def test_a_count_and_filters_of_candump_only_choose_what_is_shown(tmp_path: Path) -> None:
    done = sniffed("flood", "bus,185:7FF", "--count", "7", "--record", "bus.log", cwd=tmp_path)
    assert (done.code, len(done.lines)) == (0, 7)
    done = sniffed("session", "bus,580:780,600:780", "--record", "other.log", cwd=tmp_path)
    shown = {line.split()[5] for line in done.lines if not line.startswith("#")}
    assert shown == {"589", "609"}
    assert {line.split()[2][:3] for line in (tmp_path / "other.log").read_text().splitlines()} > {"000", "709", "080"}
    assert "of these shown" in done.err


@pytest.mark.parametrize(("lang", "said"), [("en", r"canalyze: bus: no frames in (\d+\.\d) s"), ("zh", "没有收到帧")])
def test_a_duration_of_silence(tmp_path: Path, lang: str, said: str) -> None:
    began = time.monotonic()
    done = sniffed("silence", "bus", "--duration", "300ms", cwd=tmp_path, lang=lang)
    took = time.monotonic() - began
    assert (done.code, done.out) == (0, "")
    found = re.search(said, done.err)
    assert found and all(0.3 <= float(seconds) < took + 0.1 for seconds in found.groups())


def lines_from(running: subprocess.Popen[bytes], count: int) -> list[bytes]:
    assert running.stdout is not None
    return [running.stdout.readline() for _ in range(count)]


def test_lines_come_at_once(tmp_path: Path) -> None:
    """The traffic goes on for ever: that a line can be read at all says that it is not held back."""
    with process("steady", "bus", "-t", "a", cwd=tmp_path) as running:
        late = [60.0] * 20
        end = time.monotonic() + DEADLINE_S
        while sorted(late)[10] > 0.5 and time.monotonic() < end:  # where the machine stalls, those after it
            (line,) = lines_from(running, 1)
            late = [*late[1:], time.time() - float(line.split()[0][1:-1])]
        running.send_signal(signal.SIGINT)
        _, err = running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 0
    assert sorted(late)[10] <= 0.5
    assert b"canalyze: bus: " in err


def test_sigterm(tmp_path: Path) -> None:
    with process("steady", "bus", "--record", "bus.log", cwd=tmp_path) as running:
        lines_from(running, 5)
        running.send_signal(signal.SIGTERM)
        _, err = running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 143
    assert b"canalyze: recorded bus.log: " in err


def test_a_terminal_that_goes(tmp_path: Path) -> None:
    """A connection that is lost, for one: what was recorded is whole, also of a format that holds frames back."""
    with process("steady", "bus", "--record", "bus.mcap", "--record", "bus.log", cwd=tmp_path) as running:
        lines_from(running, 5)
        running.send_signal(signal.SIGHUP)
        _, err = running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 129
    assert b"canalyze: recorded bus.log: " in err
    assert frames_of(tmp_path / "bus.mcap") == frames_of(tmp_path / "bus.log")


def test_a_second_ctrl_c_ends_at_once(tmp_path: Path) -> None:
    """Nobody reads what is shown, so one cannot end it; the other one follows the flood."""
    with process("flood", "bus", "--record", "bus.log", cwd=tmp_path) as running:
        lines_from(running, 1)
        time.sleep(1)
        assert running.poll() is None
        end = time.monotonic() + DEADLINE_S
        while running.poll() is None and time.monotonic() < end:  # two that come at once are one
            running.send_signal(signal.SIGINT)
            time.sleep(0.5)
        _, err = running.communicate(timeout=10)
    assert running.returncode == 130
    assert b"canalyze: bus: " in err and b"canalyze: recorded bus.log: " in err


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_an_adapter_that_is_unplugged_ends_it(tmp_path: Path, lang: str) -> None:
    done = sniffed("unplug", "bus", "--record", "bus.log", cwd=tmp_path, lang=lang)
    assert (done.code, len(done.lines)) == (2, 20)
    assert "--reconnect" in done.complaints[0] and "the adapter is gone" in done.complaints[0]
    assert re.search("recorded bus.log|已录制 bus.log", done.err)


def test_an_adapter_that_is_unplugged_is_waited_for(tmp_path: Path) -> None:
    done = sniffed("unplug", "bus", "--record", "bus.log", "--reconnect", cwd=tmp_path)
    assert done.code == 0
    assert len([line for line in done.lines if not line.startswith("#")]) == 40
    assert len((tmp_path / "bus.log").read_text().splitlines()) == 40
    told = [line for line in done.complaints if not line.startswith("canalyze: ")]
    assert len(told) == 2
    assert "waiting" in told[0] and "the adapter is gone" in told[0] and "receiving again" in told[1]


@pytest.mark.parametrize("form", ["log", "asc", "mcap", "pcapng"])
def test_a_killed_process_leaves_a_readable_recording(tmp_path: Path, form: str) -> None:
    path = tmp_path / f"bus.{form}"
    shown, least = (400, 150) if form == "mcap" else (100, 100)  # of MCAP the last second is not there
    with process("steady", "bus", "--record", path.name, cwd=tmp_path) as running:
        lines_from(running, shown)
        running.kill()
        running.communicate(timeout=DEADLINE_S)
    numbers = [int.from_bytes(bytes.fromhex(line.split("#")[1][:8]), "little") for line in frames_of(path)]
    assert numbers == list(range(len(numbers)))
    assert len(numbers) >= least


def test_a_slow_terminal_costs_the_recording_nothing(tmp_path: Path) -> None:
    with process("flood", "bus", "--record", "bus.log", cwd=tmp_path) as running:
        time.sleep(1.5)  # nobody reads
        out, err = running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 0
    assert len((tmp_path / "bus.log").read_text().splitlines()) == FLOOD
    shown = [line for line in out.splitlines() if not line.startswith(b"#")]
    assert len(shown) == FLOOD or b"neither shown nor checked" in err


def test_a_reader_that_has_seen_enough(tmp_path: Path) -> None:
    with process("steady", "bus", "--record", "bus.log", cwd=tmp_path) as running:
        assert running.stdout is not None and running.stderr is not None
        lines_from(running, 3)
        running.stdout.close()
        assert running.wait(DEADLINE_S) == 0
        (said,) = running.stderr.read().splitlines()
    assert said.startswith(b"canalyze: recorded bus.log: "), "the recording ends with it, which is told"
    assert len((tmp_path / "bus.log").read_text().splitlines()) >= 3


def test_standard_output_that_is_closed(tmp_path: Path) -> None:
    with process("steady", "bus", cwd=tmp_path, stdout=None, preexec_fn=lambda: os.close(1)) as running:
        _, err = running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 2
    assert err.decode().splitlines()[0].startswith("canalyze: standard output: cannot write")


def test_closed_streams_are_nobody_elses(tmp_path: Path, multicast: tuple[can.BusABC, list[str]]) -> None:
    """A listing goes neither into a recording nor onto a bus whose file descriptor would be that of the output."""
    bus, listen = multicast
    program = [sys.executable, "-m", "canalyze", *listen, "--record", "bus.log"]

    def close() -> None:
        for stream in (0, 1, 2):
            os.close(stream)

    with subprocess.Popen(program, cwd=tmp_path, env=environment(), preexec_fn=close) as running:
        deadline = time.monotonic() + DEADLINE_S
        while running.poll() is None:
            bus.send(frame(1))
            time.sleep(0.01)
            if time.monotonic() > deadline:
                running.kill()
    assert running.returncode == 2
    recorded = (tmp_path / "bus.log").read_text().splitlines()
    assert recorded and all(re.fullmatch(r"\(\d+\.\d{6,9}\) \S+ 185#[0-9A-F]{8}( [RT])?", line) for line in recorded)


def test_a_silent_bus_meets_no_expectation(tmp_path: Path) -> None:
    """A cable that is not plugged in must not pass."""
    (tmp_path / "boot.expect.toml").write_text(EXPECTED)
    done = sniffed("silence", "bus", "--duration", "300ms", "--expect", "boot.expect.toml", cwd=tmp_path)
    assert done.code == 2
    assert "canalyze: expectations: not checked, no frames received" in done.complaints


def test_a_recording_that_cannot_go_on(tmp_path: Path) -> None:
    """The listing is whole, the recording ends with a whole frame, and the exit code tells."""

    def small() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    with process("flood", "bus", "--record", "bus.log", cwd=tmp_path, preexec_fn=small) as running:
        out, err = running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 2
    assert len([line for line in out.splitlines() if not line.startswith(b"#")]) == FLOOD
    said = err.decode().splitlines()
    assert said[0].startswith("bus.log: cannot write: file too large; ")
    assert said[0].endswith("recording stopped, listening continues")
    assert "interrupted" in said[-1]
    recorded = (tmp_path / "bus.log").read_bytes()
    assert recorded.endswith(b"\n") and len(recorded) > 20_000


def test_rotation(tmp_path: Path) -> None:
    options = ("--record", "bus.log", "--rotate", "200kB", "--keep", "2")
    done = sniffed("flood", "bus", *options, cwd=tmp_path)
    assert done.code == 0
    files = sorted(tmp_path.iterdir())
    assert len(files) == 2 and all(re.fullmatch(r"bus-000\d\.log", file.name) for file in files)
    frames = sum(len(file.read_text().splitlines()) for file in files)
    assert f"recorded {files[0].name} to {files[1].name}: {frames} frames, 2 files" in done.err
    assert f"older files deleted ({FLOOD - frames} frames)" in done.err


@pytest.mark.parametrize(
    ("name", "said"), [("pkan", "no such interface: pkan (did you mean pcan?)"), ("xyzzy", "xyzzy; available: ")]
)
def test_interfaces_are_those_of_python_can(canalyze: Runner, name: str, said: str) -> None:
    done = canalyze("--lang", "en", "sniff", "bus", "-i", name)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1) and said in done.err
    done = canalyze("sniff", "bus", "-i", name)
    assert (done.code, len(done.complaints)) == (2, 1) and re.search("[\u4e00-\u9fff]", done.err)


def test_a_channel_is_no_capture() -> None:
    with pytest.raises(SourceError, match="canalyze sniff vcan1"):
        list(open_capture("vcan1"))


def test_an_interface_that_is_not_installed(canalyze: Runner, tmp_path: Path) -> None:
    done = canalyze("--lang", "en", "sniff", "-i", "canalystii", "0", "--bitrate", "500k", "--record", "a.log")
    assert (done.code, len(done.complaints)) == (2, 1)
    assert "pip install 'python-can[canalystii]'" in done.err
    assert not list(tmp_path.iterdir())


@pytest.fixture
def multicast() -> Iterator[tuple[can.BusABC, list[str]]]:
    """Give a bus that is really between processes, and how it is listened to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("", 0))
        port = free.getsockname()[1]
    group = "239.74.163.2"
    try:
        bus = can.Bus(interface="udp_multicast", channel=group, port=port)
        bus.send(can.Message(arbitration_id=0x7FF))
    except (can.CanError, OSError, RuntimeError) as error:
        pytest.skip(f"no multicast here: {error}")
    with bus:
        yield bus, ["sniff", "-i", "udp_multicast", group, "--option", f"port={port}"]


def test_multicast(tmp_path: Path, multicast: tuple[can.BusABC, list[str]]) -> None:
    bus, listen = multicast
    line = [*command("--lang", "en", *listen), "--record", "bus.log", "--count", "100", "--filter", "id=185"]
    recorded = tmp_path / "bus.log"
    with subprocess.Popen(
        line, cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        deadline = time.monotonic() + DEADLINE_S
        while not (recorded.exists() and recorded.stat().st_size) and time.monotonic() < deadline:  # until it listens
            bus.send(can.Message(arbitration_id=0x7FF, is_extended_id=False))
            time.sleep(0.05)
        for number in range(100):
            data = number.to_bytes(4, "little")
            bus.send(can.Message(arbitration_id=0x185, data=data, is_extended_id=False))
            time.sleep(0.001)
        out, _ = running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 0
    numbers = re.findall(r" 185   \[4\]  (\w\w) ", out.decode())
    assert [int(number, 16) for number in numbers] == list(range(100))
    assert "239.74.163.2 185#00000000 R" in recorded.read_text()
