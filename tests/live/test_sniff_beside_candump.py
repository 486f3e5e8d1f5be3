"""`canalyze sniff` beside candump on real SocketCAN: the same frames, the same words, and what silence means.

Needs Linux with vcan0 and vcan1 up, and candump, cansend and cangen of can-utils; without them the tests are skipped,
unless CANALYZE_LIVE=required. No test judges speed.
"""

from __future__ import annotations

import json
import re
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import forked
import pytest
from capture_frames import Recorded, recorded
from captures import SAMPLES, Row, analyze, sort_rows
from conftest import command, environment
from listeners import (
    DEADLINE_S,
    EVERYTHING,
    LAST,
    Heartbeats,
    Listener,
    Listeners,
    Pulse,
    cangen,
    cansend,
    finish,
    lines_of_frames,
    logged,
    need,
    send_all,
    sideless,
    unless_the_machine_stalls,
    wait_until,
)
from listeners import bus as bus
from network_nodes import EDS
from other_readers import candump_log
from scripted import ATTEMPTS, CHANGES, EXPECTED, STALLS, SYNC_S, boot_configure_run, run, run_recorded


@pytest.fixture(autouse=True, scope="module")
def socketcan() -> None:
    need("vcan0", "vcan1")


def seen(out: bytes) -> list[Recorded]:
    """The frames in JSON lines, without their side."""
    return sideless(recorded(row) for row in sort_rows(out).frames)


# -- the same frames


GENERATED = {
    "mixed": ["-m", "-n", "150", "-g", "2"],
    "29-bit": ["-e", "-n", "40", "-g", "2"],
    "remote": ["-R", "-n", "40", "-g", "2"],
    "fd": ["-f", "-b", "-n", "40", "-g", "2"],
    "fd-esi": ["-f", "-E", "-n", "20", "-g", "2"],
    "lengths": ["-I", "i", "-L", "i", "-D", "i", "-n", "40", "-g", "2"],
    "burst": ["-I", "2F0", "-n", "400", "-g", "1", "-c", "100"],
}


def test_every_frame_in_candumps_order_and_with_its_stamp(bus: Listeners) -> None:
    rows, text = bus.sniff("vcan0", "--format", "jsonl"), bus.sniff("vcan0", "-t", "a")
    recorder = bus.candump()
    for options in GENERATED.values():
        cangen("vcan0", *options)
    cansend("vcan0", "123#", "123#R3", "00000123#01", "20000040#0000000000000000", "123##0", "123##312", "7E5#00")
    log, *ended = finish(recorder, rows, text)
    wanted = logged(recorder)
    assert len(wanted) == sum(int(options[options.index("-n") + 1]) for options in GENERATED.values()) + 8
    assert {frame.kind for frame in wanted} == {"data", "remote", "fd", "error"}
    assert seen(rows.out) == wanted
    assert len(lines_of_frames(text.out)) == len(wanted)
    assert [one.code for one in ended] == [0, 0]
    assert log.code == 0


def test_two_channels_merged_by_stamp_as_candump_any(bus: Listeners) -> None:
    sniff = bus.sniff("vcan0", "vcan1", "--format", "jsonl", listens=["vcan0", "vcan1"])
    recorder = bus.candump(f"any{EVERYTHING}")
    senders = [
        subprocess.Popen(["cangen", interface, "-n", "300", "-g", gap], stdout=subprocess.DEVNULL)
        for interface, gap in (("vcan0", "3"), ("vcan1", "4"))
    ]
    for sender in senders:
        assert sender.wait(timeout=4 * DEADLINE_S) == 0
    _, ended = finish(recorder, sniff)
    wanted, got = logged(recorder), seen(sniff.out)
    assert len(wanted) == 601
    for name in ("vcan0", "vcan1"):
        assert [frame for frame in got if frame.bus == name] == [frame for frame in wanted if frame.bus == name]
    assert [frame.t_ns for frame in got] == sorted(frame.t_ns for frame in wanted)
    assert ended.code == 0


FILTERS = [
    "123:7FF",
    "123:7F0,400:700",
    "123~7FF",
    "120~7F0",
    "00000123:1FFFFFFF",
    "12345678:DFFFFFFF",
    "0:0,#FFFFFFFF",
    "#FFFFFFFF",
    "#40",
    "123:7FF,#40",
    "100:700,103~7FF,j",
    "100:700,103~7FF",
    "12345678:80000000",
    "40000000:40000000",
    "123:C00007FF",
    "7FF:7FF,123:7FF,00000123:9FFFFFFF",
]
"""Everything that candump takes behind a channel's comma."""

SENT = [
    *("123#", "123#11", "123#R", "124#22", "12F#33", "103#44", "100#55", "1FF#66", "456#77", "40F#88", "7FF#99"),
    *("00000123#01", "00000124#02", "12345678#03", "12345678#R2", "1FFFFFFF#04", "123##1AA", "00000123##0BB"),
    *("20000040#0000000000000000", "20000004#0001000000000000", "20000002#0000000000000000"),
]


def test_candumps_filters_show_what_candump_shows(bus: Listeners) -> None:
    everything, recorder = bus.sniff("vcan0", "-t", "a"), bus.candump()
    theirs = [bus.candump(f"vcan0,{text}") for text in FILTERS]
    ours = [bus.sniff(f"vcan0,{text}", "--format", "jsonl") for text in FILTERS]
    cansend("vcan0", *SENT)
    finish(recorder, everything)

    def as_many() -> bool:
        return all(len(seen(one.out)) >= len(logged(other)) for one, other in zip(ours, theirs, strict=True))

    wait_until(as_many, "as many frames as candump")
    time.sleep(0.5)
    wrong = {}
    for text, one, other in zip(FILTERS, ours, theirs, strict=True):
        assert one.stop().code == 0
        if seen(one.out) != logged(other):
            wrong[text] = ([frame.log_line() for frame in seen(one.out)], other.out.decode())
    assert not wrong
    assert len({other.out for other in theirs}) > len(FILTERS) / 2, "the table selects too little that differs"


# -- the same words


def rows_before_the_last_frame(out: bytes) -> list[Row]:
    """What was said before the frame that ends a session; without what names the file, and the side."""
    rows: list[Row] = [json.loads(line) for line in out.splitlines()]
    end = next(at for at, row in enumerate(rows) if row["kind"] == "frame" and row["data"] == LAST.partition("#")[2])
    return [
        {key: value for key, value in row.items() if key not in ("file", "line", "about_line", "cause_line", "dir")}
        for row in rows[:end]
    ]


def lines_before_the_last_frame(out: bytes) -> list[str]:
    """The same of text."""
    lines = [re.sub(r"  [TR]X [-B] [-E](?=  )", "", line) for line in out.decode().splitlines()]
    end = next(at for at, line in enumerate(lines) if re.search(r"  7FF   \[4\]  4C 41 53 54", line))
    return lines[:end]


SAID = {
    "boot-and-states": (("text", "zh"), ("text", "en"), ("jsonl", "zh"), ("jsonl", "en")),
    "sync-and-pdos": (("text", "zh"), ("jsonl", "en")),
    "lss-fastscan": (("text", "en"), ("jsonl", "zh")),
}
"""Sessions, and the forms and languages in which they are compared."""


def alone(out: bytes) -> bytes:
    """What is said of frames, without the lines of problems that only a live view has."""
    told = ("# ✖ ".encode(), "# ↳ ".encode(), "# ✔ ".encode(), b'{"kind":"problem"', b'{"kind":"diagnosis"')
    return b"".join(line for line in out.splitlines(keepends=True) if not line.startswith(told))


@pytest.mark.parametrize("name", SAID)
def test_a_session_is_said_as_decode_says_candumps_log(name: str, bus: Listeners) -> None:
    known = ["--eds", f"5={EDS}/drive.eds"] if name == "sync-and-pdos" else []
    options = {"text": ["-t", "a", *known], "jsonl": ["--format", "jsonl", *known]}
    sniffs = [bus.sniff("vcan0", *options[form], lang=lang, name=f"{form}-{lang}") for form, lang in SAID[name]]
    recorder = bus.candump()
    session = run_recorded(name)
    try:
        _, *ended = finish(recorder, *sniffs)
    finally:
        session.close()
    assert recorder.out.count(b"\n") > 100
    log = bus.directory / "session.log"
    log.write_bytes(recorder.out)
    # A machine that stalls makes nodes late, which is told when it is noticed: live between two frames, of a log at
    # the next one. What is said of the frames is the same all the same.
    late = codes(recorder.out) - codes((SAMPLES / "network" / f"{name}.log").read_bytes())
    for (form, lang), one in zip(SAID[name], ended, strict=True):
        line = ["--lang", lang, "decode", *options[form], str(log)]
        decoded = forked.run(line, env=environment(), timeout_s=4 * DEADLINE_S)
        assert decoded.returncode == 0
        said = lines_before_the_last_frame if form == "text" else rows_before_the_last_frame
        live, later = ([of_frame(x) if late else x for x in said(out)] for out in (alone(one.out), decoded.stdout))
        live, later = [x for x in live if x], [x for x in later if x]
        assert len(live) == len(later)
        for number, (ours, theirs) in enumerate(zip(live, later, strict=True), 1):
            assert ours == theirs, f"line {number} of {form} in {lang}"
        assert one.code == 0


def codes(log: bytes) -> set[str]:
    """Those of all findings in it: what a recording of the same session does not have comes of the machine."""
    return {finding["code"] for finding in analyze(log, eds={5: "drive.eds"}).findings}


def of_frame(said: Row | str) -> Row | str | None:
    """A frame's line or row without findings; None for what is none."""
    if isinstance(said, str):
        return None if said.startswith("#") else said
    return {key: value for key, value in said.items() if key != "findings"} if said["kind"] == "frame" else None


# -- expectations


def expectations_of(change: str, bus: Listeners, wanted: set[str]) -> tuple[int, list[Row]]:
    """Exit code and what was not met of the session with this change; run again where the machine stalled.

    What only its stalls make is left out where it stalls each time.
    """
    (bus.directory / "boot.expect.toml").write_text(EXPECTED)
    for _ in range(ATTEMPTS):
        sniff = bus.sniff("vcan0", "--expect", "boot.expect.toml", "--format", "jsonl")
        recorder = bus.candump()
        with Pulse() as pulse:
            session = run(lambda session: boot_configure_run(session, change))
        try:
            _, ended = finish(recorder, sniff)
        finally:
            session.close()
        findings = sort_rows(ended.out).findings
        failed = [row for row in findings if row["code"].startswith("EXP") and row["severity"] != "info"]
        codes = {row["code"] for row in failed}
        if codes == wanted or codes - wanted - STALLS or wanted - codes:
            break
    stalled = STALLS - wanted if wanted and pulse.longest > SYNC_S / 4 else set()
    return ended.code, [row for row in failed if row["code"] not in stalled]


def test_expectations_are_met(bus: Listeners) -> None:
    code, failed = expectations_of("", bus, set())
    assert (code, failed) == (0, [])


@pytest.mark.parametrize(("change", "wanted"), CHANGES.items(), ids=CHANGES)
def test_one_thing_changed_is_an_expectation_not_met(change: str, wanted: set[str], bus: Listeners) -> None:
    code, failed = expectations_of(change, bus, wanted)
    assert code == 1
    assert {row["code"] for row in failed} == wanted, failed


# -- silence

LOST_S = 40.0
"""By then a heartbeat that has stopped is reported, however loaded the machine."""


@pytest.fixture
def heartbeats() -> Iterator[Heartbeats]:
    ours = Heartbeats()
    yield ours
    ours.close()


def findings(listener: Listener, code: str = "") -> list[tuple[str, int | None]]:
    """Codes and nodes of the findings above info, so far."""
    out = listener.out
    said = sort_rows(out[: out.rfind(b"\n") + 1])
    return [(row["code"], row["node"]) for row in said.above_info() if row["code"].startswith(code)]


def frames_of(listener: Listener, can_id: str) -> int:
    return listener.out.count(b'"id":"%s"' % can_id.encode())


def wait_until_known(listener: Listener, *can_ids: str) -> None:
    """Waits until the period of each heartbeat is known."""
    least = Heartbeats.SHOW_THE_PERIOD
    wait_until(lambda: all(frames_of(listener, can_id) > least for can_id in can_ids), f"heartbeats of {can_ids}")


def test_a_heartbeat_that_stops_is_told_while_the_bus_is_silent(bus: Listeners, heartbeats: Heartbeats) -> None:
    def judge() -> None:
        heartbeats.stop()
        rows, text = bus.sniff("vcan0", "--format", "jsonl"), bus.sniff("vcan0")
        heartbeats.start(5)
        wait_until_known(rows, "705")
        heartbeats.stop(5)
        wait_until(lambda: ("HBT002", 5) in findings(rows), "the lost heartbeat", within_s=LOST_S)
        text.wait_for(b"HBT002")
        count = frames_of(rows, "705")
        time.sleep(5 * Heartbeats.PERIOD_S)
        assert frames_of(rows, "705") == count, "the bus was not silent"
        assert findings(rows, "HBT002") == [("HBT002", 5)], "it is said once"
        assert rows.stop().code == 0 and text.stop().code == 0
        assert text.out.count(b"HBT002") == 1

    unless_the_machine_stalls(bus, judge)


def test_only_the_node_that_stops_is_told(bus: Listeners, heartbeats: Heartbeats) -> None:
    def judge() -> None:
        heartbeats.stop()
        rows = bus.sniff("vcan0", "--format", "jsonl")
        heartbeats.start(5, 6)
        wait_until_known(rows, "705", "706")
        heartbeats.stop(5)
        wait_until(lambda: findings(rows, "HBT002"), "the lost heartbeat", within_s=LOST_S)
        time.sleep(8 * Heartbeats.PERIOD_S)
        assert findings(rows, "HBT002") == [("HBT002", 5)]
        heartbeats.start(5)
        seen_again = frames_of(rows, "705")
        wait_until(lambda: frames_of(rows, "705") > seen_again + 3, "the node again")
        assert findings(rows, "HBT002") == [("HBT002", 5)]
        assert rows.stop().code == 0

    unless_the_machine_stalls(bus, judge)


def test_a_flood_is_told_though_the_client_is_silent(bus: Listeners) -> None:
    rows = bus.sniff("vcan0", "--format", "jsonl")
    cansend("vcan0", *3 * ["605#4018100400000000", "585#4318100407000000"])
    send_all("vcan0", 20 * [(0x585, bytes.fromhex("6000200100000000"))])  # cansend may take 50 ms a frame: no flood
    wait_until(lambda: findings(rows, "SDO002"), "the flood")
    assert findings(rows) == [("SDO002", 5)]
    assert rows.stop().code == 0
    (found,) = sort_rows(rows.out).above_info()
    assert found["facts"]["frames"] >= 4, found


# -- errors


def test_error_frames_and_bus_off_are_told(bus: Listeners) -> None:
    text = bus.sniff("vcan0", name="text")
    cansend("vcan0", "20000004#0004000000000000", "20000040#0000000000000000", "20000100#0000000000000000")
    text.wait_for(b"ERRORFRAME", times=3)
    ended = text.stop()
    assert ended.code == 0
    assert "bus off" in ended.out.decode()
    assert re.search(r"bus.off", ended.err), f"no hint what to do about bus-off: {ended.err!r}"
    assert re.search(r"\b3\b", ended.err), f"error frames are not counted in the summary: {ended.err!r}"


# -- how it ends


def test_ctrl_c_is_the_normal_end(bus: Listeners) -> None:
    sniff = bus.sniff("vcan0", "-t", "n")
    cansend("vcan0", "60A#4008100000000000")
    sniff.wait_for(b"60A")
    ended = sniff.stop()
    assert ended.code == 0
    assert ended.out.endswith(b"\n") and b"60A   [8]  40 08 10" in ended.out
    assert "vcan0" in ended.err and "Traceback" not in ended.err, "no summary"


def test_sigterm(bus: Listeners) -> None:
    sniff = bus.sniff("vcan0", "-t", "n")
    cansend("vcan0", "705#05")
    sniff.wait_for(b"705")
    ended = sniff.stop(signal.SIGTERM)
    assert ended.code == 143
    assert "Traceback" not in ended.err


def test_duration(bus: Listeners) -> None:
    def judge() -> None:
        before = time.monotonic()
        sniff = bus.sniff("vcan0", "--duration", "2s")
        cansend("vcan0", "705#05")
        ended = sniff.ended()
        assert ended.code == 0
        assert time.monotonic() - before >= 2
        assert len(lines_of_frames(ended.out)) == 1

    unless_the_machine_stalls(bus, judge)


def test_count_of_shown_frames(bus: Listeners) -> None:
    sniff = bus.sniff("vcan0", "--count", "5", "--filter", "id=123", "--record", "all.log")
    send_all("vcan0", [(can_id, bytes([n])) for n in range(20) for can_id in (0x123, 0x124)])
    ended = sniff.ended()
    assert ended.code == 0
    assert [line.split()[-2:] for line in lines_of_frames(ended.out)] == [["[1]", f"{n:02X}"] for n in range(5)]
    written = candump_log((bus.directory / "all.log").read_text())
    assert {frame.can_id for frame in written} == {0x123, 0x124}, "the recording is filtered"


def test_the_reader_of_a_pipe_that_goes_away(bus: Listeners) -> None:
    sender = subprocess.Popen(["cangen", "vcan0", "-g", "20"], stdout=subprocess.DEVNULL)
    try:
        line = " ".join(command("--lang", "en", "sniff", "vcan0"))
        done = subprocess.run(
            ["bash", "-o", "pipefail", "-c", f"{line} | head -n 3"],
            capture_output=True,
            timeout=2 * DEADLINE_S,
            env=environment(),
            cwd=bus.directory,
            check=False,
        )
    finally:
        sender.kill()
        sender.wait()
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(b"\n") == 3
    assert b"Traceback" not in done.stderr and b"Error" not in done.stderr, done.stderr


def test_it_sends_nothing(bus: Listeners) -> None:
    recorder = bus.candump("vcan1", f"vcan0{EVERYTHING}")
    before = [sent("vcan0"), sent("vcan1")]
    sniff = bus.sniff("vcan0", "vcan1", "--duration", "1.5", listens=["vcan0", "vcan1"])
    assert sniff.ended().code == 0
    assert recorder.out == b""
    assert [sent("vcan0"), sent("vcan1")] == before


def sent(interface: str) -> int:
    """Frames that this host has sent."""
    return int(Path("/sys/class/net", interface, "statistics/tx_packets").read_text())


def test_open_transfers_are_told_at_the_end(bus: Listeners) -> None:
    sniff = bus.sniff("vcan0", "--format", "jsonl")
    cansend("vcan0", "60A#4008100000000000", "58A#4108100017000000", "60A#6000000000000000", "58A#005A657068797220")
    wait_until(lambda: frames_of(sniff, "58A") == 2, "the frames")
    ended = sniff.stop()
    (transfer,) = sort_rows(ended.out).transfers
    assert (transfer["status"], transfer["index"], transfer["node"]) == ("incomplete", "1008", 10)
    assert not sort_rows(ended.out).above_info()
    assert ended.code == 0
