"""Sessions as other tools write them: the meaning and the verdicts must be those of the candump form.

Why it exists: readers are tested frame by frame; here a whole session with the noise, the requests to send, the blocks
and the clocks of CANalyzer's ASC and of PCAN-View's TRC must be judged as it is without them. What it must not do: say
what a session means (the samples beside the sessions do).
"""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES, CanFrame, Row, log_text, read_log
from conftest import Runner

from canalyze import _core
from canalyze.running.reading import SessionOptions
from canalyze.sources import open_capture

SESSIONS = [
    SAMPLES / "stacks" / "a2-selfstart-heartbeat.log",
    SAMPLES / "stacks" / "c3-pdo-remap-master-sync.log",
    SAMPLES / "stacks" / "d2-lss-selective.log",
    SAMPLES / "network" / "guarding.log",
    SAMPLES / "network" / "multiplex-and-safety.log",
]
OWN = {0x000, 0x080, 0x7E5, *range(0x601, 0x680)}
"""What the tool's own node sends: the commands of a master."""
Form = Callable[[list[CanFrame]], bytes]


def session(path: Path) -> list[CanFrame]:
    """Its frames on one bus that every form has."""
    return [replace(frame, bus="can0") for frame in read_log(path.read_bytes())]


def date(us: int, german: bool) -> str:
    at = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC) + datetime.timedelta(microseconds=us)
    days = (
        ("Mon", "Die", "Mit", "Don", "Fre", "Sam", "Son")
        if german
        else ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")
    )
    months = (
        "Jan Feb Mär Apr Mai Jun Jul Aug Sep Okt Nov Dez"
        if german
        else "Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec"
    )
    begin = f"{days[at.weekday()]} {months.split()[at.month - 1]} {at.day}"
    ms = f"{at.microsecond // 1000:03d}"
    if german:
        return f"{begin} {at:%H:%M:%S}.{ms} {at.year}"
    return f"{begin} {(at.hour + 11) % 12 + 1:02d}:{at:%M:%S}.{ms} {'am' if at.hour < 12 else 'pm'} {at.year}"


def asc(
    *, decimal: bool = False, relative: bool = False, german: bool = False, blocks: int = 1, named: bool = False
) -> Form:
    """As CANalyzer logs it: two lines of each own frame, and lines of other events between the frames."""

    def lines(frames: list[CanFrame]) -> Iterator[str]:
        start = last = frames[0].t_us // 1000 * 1000
        yield f"date {date(start, german)}"
        yield f"base {'dec' if decimal else 'hex'}  timestamps {'relative' if relative else 'absolute'}"
        yield "internal events logged"
        yield "// version 9.0.0"
        for number, frame in enumerate(frames):
            if number % -(-len(frames) // blocks) == 0:
                if number:
                    yield "End TriggerBlock"
                yield f"Begin Triggerblock {date(frame.t_us, german)}"
            columns = f"{frame.can_id if decimal else format(frame.can_id, 'X')}{'x' * frame.extended}".ljust(15)
            columns += f" Msg_{frame.can_id:X}" * named
            data = " ".join(str(byte) if decimal else f"{byte:02X}" for byte in frame.data)
            rest = "r" if frame.remote else f"d {len(frame.data)} {data}"
            rest += (
                f"  Length = {240000 + number} BitCount = {100 + number % 30} ID = {frame.can_id}{'x' * frame.extended}"
            )
            events = [f"1  {columns} {'Tx  ' if frame.can_id in OWN else 'Rx  '} {rest}"]
            if frame.can_id in OWN:
                events.insert(0, f"1  {columns} TxRq {rest}")
            if number % 7 == 3:
                events.append("1  Statistic: D 12 R 0 XD 0 XR 0 E 0 O 0 B 12.12%")
                events.append("CAN 1 Status:chip status error active - TxErr: 0 RxErr: 0")
                events.append("Comment: 0 Prüfstand läuft: 601 Rx")
            for event in events:
                yield f"{(frame.t_us - (last if relative else start)) / 1e6:11.6f} {event}"
                last = frame.t_us
        yield "End TriggerBlock"

    return lambda frames: "".join(line + "\r\n" for line in lines(frames)).encode("cp1252")


def trc(version: str) -> Form:
    """As PCAN-View traces it, with rows of the bus's state between the frames; numbers of rows begin anew."""
    columns = {"2.0": ";$COLUMNS=O,T,I,d,l,D\n", "2.1": ";$COLUMNS=N,O,T,B,I,d,R,L,D\n"}.get(version, "")

    def row(number: int, ms: float, frame: CanFrame | None, way: str) -> str:
        if frame is None:
            return {
                "1.1": f"{number}) {ms:.1f}  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY ",
                "1.3": f"{number}) {ms:.3f} 1  Warng  FFFFFFFF -  4    00 00 00 08  BUSHEAVY ",
                "2.0": f" {ms:.3f} ST          Rx    00 00 00 08 ",
                "2.1": f"{number} {ms:.3f} ST 1      -  Rx -  4    00 00 00 08 ",
            }[version]
        can_id = f"{frame.can_id:08X}" if frame.extended else f"    {frame.can_id:04X}"
        data, size = frame.data.hex(" ").upper(), len(frame.data)
        kind = "RR" if frame.remote else "DT"
        shown = "RTR" if frame.remote else data
        return {
            "1.1": f"{number}) {ms:.1f}  {way}  {can_id}  {size}  {shown} ",
            "1.3": f"{number}) {ms:.3f} 1  {way}  {can_id} -  {size}    {shown} ",
            "2.0": f" {ms:.3f} {kind} {can_id} {way} {size}  {data} ",
            "2.1": f"{number} {ms:.3f} {kind} 1  {can_id} {way} -  {size}    {data} ",
        }[version]

    def text(frames: list[CanFrame]) -> bytes:
        start = frames[0].t_us // 1000 * 1000
        lines = [f";$FILEVERSION={version}\n;$STARTTIME={25569 + start / 86_400e6:.10f}\n{columns};   Müller.trc\n"]
        for number, frame in enumerate(frames, 1):
            ms = (frame.t_us - start) / 1000
            lines.append(row(number % 100, ms, frame, "Tx" if frame.can_id in OWN else "Rx") + "\n")
            if number % 9 == 4:
                lines.append(row(number % 100, ms, None, "Rx") + "\n")
        return "".join(lines).replace("\n", "\r\n").encode("cp1252")

    return text


FORMS: dict[str, Form] = {
    "ASC": asc(),
    "ASC, decimal, German": asc(decimal=True, german=True, named=True),
    "ASC, relative": asc(relative=True, german=True),
    "ASC, blocks": asc(blocks=4),
    "ASC, relative, blocks": asc(relative=True, blocks=4, decimal=True),
    **{f"TRC {version}": trc(version) for version in ("1.1", "1.3", "2.0", "2.1")},
}


def rows_of(path: Path) -> list[Row]:
    """What `decode --format jsonl` says, in process."""
    session = _core.Session(SessionOptions(lang="en", format="jsonl"))
    output = []
    with open_capture(str(path)) as capture:
        session.begin(capture.name, True, capture.format)
        while data := capture.read():
            output.append(session.feed(data))
        output += [session.end(), session.finish()]
    return [json.loads(line) for line in b"".join(output).splitlines()]


def said(text: bytes, path: Path, *, stamped: bool = True) -> list[Row]:
    """All that is said, without what only the form tells; times from the first frame on."""
    path.write_bytes(text)
    rows = rows_of(path)
    start = next(Decimal(row["t"]) for row in rows if row["kind"] == "frame")

    def bare(value: Any) -> Any:
        if isinstance(value, dict):
            left = ("file", "line", "about_line", "cause_line", "first_line", "last_line", "dir") + (
                () if stamped else ("t", "text", "pdo", "duration", "age_ns")
            )
            return {key: bare(kept) for key, kept in value.items() if key not in left}
        return [bare(one) for one in value] if isinstance(value, list) else value

    found = [bare(row) for row in rows]
    for row in found:
        if row.get("t") is not None:
            row["t"] = Decimal(row["t"]) - start
    return found


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("path", SESSIONS, ids=lambda path: path.stem)
def test_a_session_means_the_same_in_every_form(path: Path, form: str, tmp_path: Path) -> None:
    frames = session(path)
    stamped = form != "TRC 1.1"  # its stamps have a tenth of a ms
    expected = said(log_text(frames), tmp_path / "candump", stamped=stamped)
    assert said(FORMS[form](frames), tmp_path / "other", stamped=stamped) == expected


@pytest.mark.parametrize("form", ["ASC", "ASC, decimal, German", "TRC 1.1", "TRC 2.1"])
@pytest.mark.parametrize("change", ["dropped", "twice", "bit", "short"])
def test_a_fault_is_named_the_same_in_every_form(change: str, form: str, tmp_path: Path) -> None:
    frames = session(SAMPLES / "stacks" / "b6-sdo-block-retransmission.log")[:140]
    at = 30
    one = frames[at]
    frames[at : at + 1] = {
        "dropped": [],
        "twice": [one, one],
        "bit": [replace(one, data=bytes([one.data[0] ^ 0x10]) + one.data[1:])],
        "short": [replace(one, data=one.data[:-1])],
    }[change]
    expected = said(log_text(frames), tmp_path / "candump", stamped=False)
    assert any(row["kind"] == "finding" and row["severity"] != "info" for row in expected)
    assert said(FORMS[form](frames), tmp_path / "other", stamped=False) == expected


def frames_in(path: Path) -> list[tuple[Any, ...]]:
    """Its frames."""
    return [(row["id"], row["rtr"], row["data"]) for row in rows_of(path) if row["kind"] == "frame"]


@pytest.mark.parametrize("form", ["ASC", "ASC, decimal, German", "TRC 1.1", "TRC 1.3", "TRC 2.0", "TRC 2.1"])
def test_the_end_of_a_cut_file_is_no_other_frame(form: str, tmp_path: Path) -> None:
    frames = [
        CanFrame("can0", 0x701, b"\x7f", 1_700_000_000_001_000),
        CanFrame("can0", 0x701, b"", 1_700_000_000_001_100, remote=True),
        CanFrame("can0", 0x181, b"\x7f\xff", 1_700_000_000_002_000),
    ]
    whole = FORMS[form](frames)
    path = tmp_path / "cut"
    path.write_bytes(whole)
    expected = frames_in(path)
    assert len(expected) == len(frames)
    for end in range(whole.index(b"ller.trc") if form.startswith("TRC") else whole.index(b"Begin"), len(whole)):
        path.write_bytes(whole[:end])
        found = frames_in(path)
        assert found == expected[: len(found)], whole[:end][-80:]


# Clocks.

START = 1_700_000_000_123_000


def beats(first: int, count: int) -> list[CanFrame]:
    """Heartbeats of node 1, one every 100 ms."""
    return [CanFrame("can0", 0x701, b"\x05", START + number * 100_000) for number in range(first, first + count)]


def test_the_date_of_a_file_counts_where_times_are_absolute(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "x.asc").write_bytes(asc()(beats(0, 5)))
    lines = canalyze("decode", "-t", "A", "x.asc").lines
    assert lines[1].startswith("(2023-11-14 22:13:20.223000) ")
    assert canalyze("decode", "-t", "a", "x.asc").lines[1].startswith("(1700000000.223000) ")
    assert canalyze("decode", "-t", "z", "x.asc").lines[1].startswith("(000.100000) ")
    assert canalyze("decode", "x.asc").lines[1].startswith("(0.100000) ")
    shown = canalyze("decode", "-t", "n", "--filter", "t=1700000000.2..1700000000.35", "x.asc").lines
    assert shown == canalyze("decode", "-t", "n", "--filter", "t=0.1..0.2", "x.asc").lines
    assert len(shown) == 2


@pytest.mark.parametrize("dated_first", [True, False])
def test_dated_and_absolute_files_follow_one_another(dated_first: bool, canalyze: Runner, tmp_path: Path) -> None:
    forms: list[Form] = [asc(), log_text]
    names = []
    for number, form in enumerate(forms if dated_first else forms[::-1]):
        names.append(f"part{number}")
        (tmp_path / names[-1]).write_bytes(form(beats(10 * number, 10)))
    done = canalyze("decode", "-t", "A", *names)
    assert done.code == 0 and not done.err, done.err
    assert [line[1:24] for line in done.lines[9:11]] == ["2023-11-14 22:13:21.023", "2023-11-14 22:13:21.123"]
    rows = [json.loads(line) for line in canalyze("decode", "--format", "jsonl", *names).lines]
    assert not [row for row in rows if row["kind"] == "finding"]
    assert float(rows[10]["t"]) - float(rows[9]["t"]) == pytest.approx(0.1)
