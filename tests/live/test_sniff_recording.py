"""`canalyze sniff --record` on real SocketCAN: what is in the files, by other people's readers, whatever happens.

What it must not do: judge what is shown meanwhile (`test_sniff_beside_candump.py`), or speed.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

import pytest
from capture_frames import Recorded, read
from captures import sort_rows
from conftest import command, environment
from listeners import (
    DEADLINE_S,
    EVERYTHING,
    LAST,
    Listeners,
    cangen,
    cansend,
    finish,
    lines_of_frames,
    listeners,
    logged,
    need,
    send_all,
    sideless,
    wait_until,
)
from listeners import bus as bus
from mcap.exceptions import EndOfFile
from mcap.records import Message
from mcap.stream_reader import StreamReader
from other_readers import candump_log
from other_writers import run_program
from test_convert_read_by_others import READERS, Reader, same

FORMS = ["log", "asc", "mcap", "pcapng"]
RECORDS = [option for form in FORMS for option in ("--record", f"all.{form}")]


@pytest.fixture(autouse=True, scope="module")
def socketcan() -> None:
    need("vcan0", "vcan1")


def tellable(reader: Reader, frames: Sequence[Recorded]) -> list[Recorded]:
    """The frames without what that format or program does not have, and without their side."""
    kept = [frame for frame in frames if frame.kind in reader.kinds]
    if reader.suffix == "asc":
        kept = [replace(frame, bus=frame.bus.replace("vcan", "can")) for frame in kept]
    if reader.suffix == "mcap":
        kept = [replace(frame, brs=False, esi=False) for frame in kept]
    return sideless(kept)


def compare(name: str, path: Path, wanted: Sequence[Recorded]) -> None:
    """What another program reads in the file against candump's log."""
    reader = READERS[name]
    same(reader, tellable(reader, reader.read(path)), tellable(reader, wanted))


THEIRS = ["log by python-can", "asc by python-can", "asc by asc2log", "mcap by mcap-ros2-support", "pcapng by tshark"]


@pytest.mark.parametrize("shown", [[], ["--filter", "id=7FF"]], ids=["all", "filter"])
def test_recordings_have_what_candump_has_whatever_is_shown(shown: list[str], bus: Listeners) -> None:
    channels = ["vcan0,7FF:7FF", "vcan1,7FF:7FF"] if shown else ["vcan0", "vcan1"]
    sniff = bus.sniff(*channels, "-t", "a", *shown, *RECORDS, listens=["vcan0", "vcan1"])
    recorder = bus.candump(f"any{EVERYTHING}")
    for number in range(3):
        cangen("vcan0", "-m", "-n", "60", "-g", "2")
        cangen("vcan1", "-e", "-n", "30", "-g", "2")
        cansend("vcan0", f"20000004#000{number}000000000000", "123#R3", "123##0")
    _, ended = finish(recorder, sniff)
    assert ended.code == 0, ended.err
    wanted = logged(recorder)
    assert len(wanted) == 3 * 93 + 1
    fits = [frame for frame in wanted if frame.can_id == 0x7FF and not frame.extended]  # cangen may hit upon it too
    assert len(lines_of_frames(ended.out)) == len(fits if shown else wanted)
    assert sideless(candump_log((bus.directory / "all.log").read_text())) == wanted
    for name in THEIRS[1:]:  # python-can takes most error frames of a log for data
        compare(name, bus.directory / f"all.{READERS[name].suffix}", wanted)
    for form in ("mcap", "pcapng"):
        frames = sideless(read(bus.directory / f"all.{form}").frames)
        assert tellable(READERS["mcap by mcap-ros2-support"], frames) == tellable(
            READERS["mcap by mcap-ros2-support"], wanted
        )
        assert f"all.{form}" in ended.err, "the summary names what was recorded"


# -- several files


def parts(directory: Path, form: str) -> list[Path]:
    """The files of one recording, in their order."""
    return sorted(path for path in directory.iterdir() if re.fullmatch(rf"part-\d+\.{form}", path.name))


def frames_of(path: Path) -> list[Recorded]:
    """One file as this program reads it; of ASC the stamps begin with the file."""
    return [replace(frame, brs=False, esi=False) for frame in sideless(read(path).frames)]


def rotated(bus: Listeners, *options: str) -> list[Recorded]:
    """Records traffic of some 4 s in several files of each form; gives candump's frames."""
    records = [option for form in FORMS for option in ("--record", f"part.{form}")]
    sniff = bus.sniff("vcan0", *records, *options, "--filter", "id=7FF")
    recorder = bus.candump()
    cangen("vcan0", "-n", "700", "-g", "5")
    _, ended = finish(recorder, sniff)
    assert ended.code == 0, ended.err
    return [replace(frame, brs=False, esi=False) for frame in logged(recorder)]


@pytest.mark.parametrize("rotate", ["6kB", "1s"])
def test_rotation_loses_nothing_and_has_nothing_twice(rotate: str, bus: Listeners) -> None:
    wanted = rotated(bus, "--rotate", rotate)
    for form in FORMS:
        files = parts(bus.directory, form)
        assert len(files) >= 3, (form, sorted(path.name for path in bus.directory.iterdir()))
        pieces = [frames_of(path) for path in files]
        assert all(pieces), f"an empty part of {form}"
        got = [frame for piece in pieces for frame in piece]
        if form == "asc":
            got, wanted_here = ([replace(frame, t_ns=0) for frame in frames] for frames in (got, wanted))
        else:
            wanted_here = wanted
        assert got == wanted_here, form


def test_of_old_files_so_many_are_kept(bus: Listeners) -> None:
    wanted = rotated(bus, "--rotate", "6kB", "--keep", "2")
    for form in ("log", "mcap", "pcapng"):
        files = parts(bus.directory, form)
        assert len(files) == 2, form
        got = [frame for path in files for frame in frames_of(path)]
        assert got == wanted[-len(got) :], form


# -- killed


def mcap_messages(path: Path) -> list[int]:
    """Times of the messages in a file that has no end, by the mcap library."""
    times = []
    with path.open("rb") as file, suppress(EndOfFile):
        for record in StreamReader(file).records:
            if isinstance(record, Message):
                times.append(record.log_time)
    return times


def test_a_killed_process_leaves_readable_recordings(bus: Listeners) -> None:
    """But for the last second before that, for which a format may keep frames back."""
    sniff, recorder = bus.sniff("vcan0", *RECORDS), bus.candump()
    log_file = bus.directory / "all.log"

    def recorded() -> int:
        return log_file.read_bytes().count(b"\n")

    def newest() -> int:
        text = log_file.read_text()
        return candump_log(text[: text.rfind("\n") + 1])[-1].t_ns

    sender = subprocess.Popen(["cangen", "vcan0", "-g", "4"], stdout=subprocess.DEVNULL)
    try:
        wait_until(lambda: recorded() > 300, "300 frames")
        due, last_ns = recorded(), time.time_ns() + 1_000_000_000
        wait_until(lambda: newest() > last_ns, "those of a second more")
        sniff.send(signal.SIGKILL)
        assert sniff.ended().code == -signal.SIGKILL
    finally:
        sender.kill()
        sender.wait()
    recorder.stop()
    log = logged(recorder)
    for name in THEIRS:
        if name.startswith("mcap"):
            continue
        path = bus.directory / f"all.{READERS[name].suffix}"
        count = len(READERS[name].read(path))
        assert count >= due, name
        compare(name, path, log[:count])
    times = mcap_messages(bus.directory / "all.mcap")
    assert len(times) >= due
    assert times == [frame.t_ns for frame in log[: len(times)]]
    text = run_program("log2asc", "vcan0", stdin=(bus.directory / "all.log").read_bytes())
    assert text.count(b"vcan0") + text.count(b" Rx ") + text.count(b" Tx ") >= due
    for form in FORMS:
        reading = read(bus.directory / f"all.{form}")
        assert reading.code == 0, (form, reading.complaints)
        assert len(reading.frames) >= due
        plain = [replace(frame, t_ns=0, brs=False, esi=False) for frame in sideless(reading.frames)]
        assert plain == [replace(frame, t_ns=0, brs=False, esi=False) for frame in log[: len(plain)]], form


# -- disk full


@contextmanager
def small_disk(place: Path, size: str) -> Iterator[None]:
    """A file system of this size; only root of a guest may make one."""
    place.mkdir()
    if shutil.which("mount") is None or os.geteuid() != 0:
        pytest.skip("no file system can be mounted here")
    mounted = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(place)]
    if subprocess.run(mounted, capture_output=True, check=False).returncode != 0:
        pytest.skip("no file system can be mounted here")
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False)


def test_a_full_disk_is_told_and_ends_nothing_but_that_file(bus: Listeners) -> None:
    with small_disk(bus.directory / "small", "32k"):
        sniff = bus.sniff("vcan0", "-t", "a", "--record", "small/full.log", "--record", "all.log")
        recorder = bus.candump()
        cangen("vcan0", "-n", "1500", "-g", "0.5", "-L", "8")
        sniff.wait_for_complaint("full.log")
        cansend("vcan0", "705#05")
        _, ended = finish(recorder, sniff)
        full = sideless(candump_log((bus.directory / "small" / "full.log").read_text()))
    assert ended.code == 2
    complaint = next(line for line in ended.err.splitlines() if "full.log" in line)
    assert "no space left" in complaint
    wanted = logged(recorder)
    assert len(lines_of_frames(ended.out)) == len(wanted)
    assert sideless(candump_log((bus.directory / "all.log").read_text())) == wanted
    assert full and full == wanted[: len(full)]


# -- a reader that does not read


def segmented_reads(count: int) -> list[tuple[int, bytes]]:
    """Reads of 1008h from node 10 in the order of cause and effect."""
    exchange = [
        (0x60A, "4008100000000000"),
        (0x58A, "410810000E000000"),
        (0x60A, "6000000000000000"),
        (0x58A, "00416E2065787472"),
        (0x60A, "7000000000000000"),
        (0x58A, "1161206C6F6E6720"),
    ]
    return [(can_id, bytes.fromhex(data)) for _ in range(count) for can_id, data in exchange]


def unread(bus: Listeners, line: Sequence[str]) -> tuple[subprocess.Popen[bytes], Path]:
    """Starts a sniffer whose output nobody reads yet."""
    before = listeners("vcan0")
    errors = bus.directory / "unread.err"
    with errors.open("wb") as stderr:
        process = subprocess.Popen(
            line, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=stderr, cwd=bus.directory, env=environment()
        )
    wait_until(lambda: listeners("vcan0") > before or process.poll() is not None, f"it listens: {errors.read_text()}")
    return process, errors


def test_a_terminal_that_does_not_read_loses_nothing(bus: Listeners) -> None:
    recorder = bus.candump()
    process, errors = unread(bus, command("--lang", "en", "sniff", "vcan0", "--format", "jsonl", "--record", "all.log"))
    sent = segmented_reads(1200)
    send_all("vcan0", sent)
    cansend("vcan0", LAST)
    recording = bus.directory / "all.log"
    wait_until(lambda: LAST.encode() in recording.read_bytes(), "the last frame in the recording")
    recorder.wait_for(LAST.encode())
    time.sleep(1)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=2 * DEADLINE_S)
    recorder.stop()
    assert process.returncode == 0, errors.read_text()
    wanted = logged(recorder)
    assert len(wanted) == len(sent) + 1
    assert sideless(candump_log(recording.read_text())) == wanted
    assert out.count(b'"kind":"frame"') <= len(wanted)
    said = sort_rows(out[: out.rfind(b"\n") + 1])
    assert not [row for row in said.above_info() if row["code"] != "CAP002"], said.complaint()


SMALL_QUEUE = """
import sys
from canalyze.sources.live import Live
Live.__init__.__kwdefaults__["most"] = 1 << 17
from canalyze.cli import main
sys.exit(main(sys.argv[1:]))
"""
"""The program with room for some five hundred frames, so that a slow reader shows at once."""


def test_what_a_slow_reader_misses_is_told_and_no_finding(bus: Listeners) -> None:
    line = [sys.executable, "-c", SMALL_QUEUE, "--lang", "en", "sniff", "vcan0", "--format", "jsonl"]
    process, errors = unread(bus, [*line, "--record", "all.log"])
    sent = segmented_reads(1200)
    send_all("vcan0", sent)
    recording = bus.directory / "all.log"
    wait_until(lambda: recording.read_bytes().count(b"\n") >= len(sent), "all frames in the recording")
    # it reads again: what comes now is shown
    assert process.stdout is not None
    os.set_blocking(process.stdout.fileno(), False)
    out = b""

    def reading(wanted: Callable[[], bool], what: str) -> None:
        nonlocal out

        def more() -> bool:
            nonlocal out
            out += process.stdout.read() or b""  # type: ignore[union-attr]
            return wanted()

        wait_until(more, what)

    reading(lambda: b'"CAP002"' in out, "the loss is told: from here on there is room")
    send_all("vcan0", segmented_reads(3))
    cansend("vcan0", LAST)
    reading(lambda: LAST.partition("#")[2].encode() in out, "the last frame")
    process.send_signal(signal.SIGINT)
    os.set_blocking(process.stdout.fileno(), True)
    rest, _ = process.communicate(timeout=2 * DEADLINE_S)
    said = sort_rows(out + rest)
    missed = len(sent) + 19 - len(said.frames)
    assert missed > 1000, "nothing was missed: the test proves nothing"
    assert process.returncode == 0, errors.read_text()
    told = errors.read_text()
    assert str(missed) in told.replace(",", "").replace(" ", "") or str(missed) in told, told
    assert not [row for row in said.above_info() if row["code"] != "CAP002"], said.complaint()
    assert [row["code"] for row in said.above_info()], "the loss is no finding"
    assert not [row for row in said.transfers if row["status"] in ("failed", "aborted")]
    assert [row["status"] for row in said.transfers[-3:]] == ["ok"] * 3
    assert len(candump_log(recording.read_text())) == len(sent) + 19
