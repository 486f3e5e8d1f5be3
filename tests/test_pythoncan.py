"""The bridge to python-can: what it reads and writes, whole and damaged, against its own reading and against the files.

A session of every kind of frame goes through that library's writers and comes back frame by frame, as far as the form
keeps it; files under the shared corpus are read with the answers that stand there.
"""

import gzip
import io
import json
import marshal
import os
import pty
import random
import re
import struct
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import can
import pytest
from conftest import Runner, command, started

from canalyze._core import FORMATS, Session
from canalyze.errors import OutputError, SourceError
from canalyze.running.reading import SessionOptions
from canalyze.sinks import LOSSES, open_sink
from canalyze.sources import Capture, Source, bridge, open_capture
from canalyze.sources.bridge import Packer, reading
from canalyze.words import Words

CORPUS = Path(__file__).parent.parent.parent / "shared/corpus"
START = 1_700_000_000.0
FORMS = ("blf", "trc", "csv", "db", "mf4")


class Given(Source):
    """Bytes as if they came from a pipe, `step` at a time."""

    def __init__(self, data: bytes, step: int = 1 << 20) -> None:
        """Take the bytes."""
        self.name, self.taken = "given", 0
        self._data, self._step = data, step

    @property
    def regular(self) -> bool:
        return True

    @property
    def path(self) -> None:
        return None

    def read(self) -> bytes:
        data, self._data = self._data[: self._step], self._data[self._step :]
        self.taken += len(data)
        return data

    def close(self) -> None:
        pass


def told(capture: Any) -> tuple[list[dict[str, Any]], list[str]]:
    """Give the frames of a capture as the core's JSON has them, and what was complained of."""
    session = Session(SessionOptions(lang="en", format="jsonl"))
    session.begin(capture.name, True, capture.format)
    out, complaints = b"", []
    with capture:
        while data := capture.read():
            out += session.feed(data)
            complaints += session.complaints() + [str(remark) for remark in capture.remarks()]
    complaints += [str(remark) for remark in capture.remarks()]
    out += session.end() + session.finish()
    complaints += session.complaints()
    rows = [json.loads(line) for line in out.splitlines()]
    keep = ("line", "t", "bus", "dir", "id", "ext", "rtr", "fd", "err", "len", "data")
    return [{key: row[key] for key in keep} for row in rows if row["kind"] == "frame"], complaints


def given(data: bytes, form: str, step: int = 1 << 20) -> tuple[list[dict[str, Any]], list[str]]:
    """Read bytes as a form."""
    capture = Capture(Given(data, step), form)
    if form not in FORMATS:
        capture.bridge(form)
    return told(capture)


def session() -> Iterator[can.Message]:
    """One of every kind of frame, on two buses, in both directions, µs apart."""
    kinds: list[dict[str, Any]] = [
        {"arbitration_id": 0x60A, "is_extended_id": False, "data": bytes.fromhex("4008100000000000")},
        {"arbitration_id": 0x58A, "is_extended_id": False, "data": bytes.fromhex("43081000"), "is_rx": False},
        {"arbitration_id": 0x12345, "data": b"\x01"},
        {"arbitration_id": 0, "is_extended_id": False},
        {"arbitration_id": 0x70A, "is_extended_id": False, "is_remote_frame": True, "dlc": 1},
        {"arbitration_id": 0x123, "is_extended_id": False, "is_fd": True, "data": bytes(range(64))},
        {"arbitration_id": 0x124, "is_extended_id": False, "is_fd": True, "data": bytes(12), "bitrate_switch": True},
        {"arbitration_id": 0x125, "is_fd": True, "data": b"\x05", "error_state_indicator": True},
        {"arbitration_id": 0x4, "is_extended_id": False, "is_error_frame": True, "data": bytes(8)},
    ]
    for number in range(60):
        kind = kinds[number % len(kinds)]
        yield can.Message(timestamp=START + number * 0.001_003, channel=number // 20 % 2, **kind)


def written(form: str, path: Path, messages: list[can.Message], **options: Any) -> Path:
    """Have python-can write a file."""
    writer: Any = {
        "blf": can.BLFWriter,
        "trc": can.TRCWriter,
        "csv": can.CSVWriter,
        "db": can.SqliteWriter,
        "mf4": can.MF4Writer,
    }[form](str(path), **options)
    for message in messages:
        writer.on_message_received(message)
    if form == "db":
        while writer.num_frames < len(messages):
            pass
    writer.stop()
    return path


def expected(message: can.Message, form: str) -> dict[str, Any] | None:
    """What a form keeps of a message; None if nothing."""
    directed, tabular = form in ("blf", "trc", "mf4"), form in ("csv", "db")
    if form == "trc" and (message.is_fd or message.is_remote_frame or message.is_error_frame):
        return None  # as the library's writer has it
    fd = message.is_fd and not (tabular and len(message.data) <= 8)
    flags = {"brs": message.bitrate_switch and not tabular, "esi": message.error_state_indicator and not tabular}
    return {
        "bus": "can0" if tabular else f"can{message.channel}",
        "dir": ("rx" if message.is_rx else "tx") if directed else None,
        "id": f"{message.arbitration_id:0{8 if message.is_extended_id else 3}X}",
        "ext": message.is_extended_id,
        "rtr": message.is_remote_frame,
        "fd": flags if fd else False,
        "err": message.is_error_frame,
        "len": message.dlc,
        "data": bytes(message.data).hex().upper(),
    }


def need(form: str) -> None:
    if form == "mf4":
        pytest.importorskip("asammdf")


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("form", FORMS)
def test_what_python_can_writes_is_read(form: str, tmp_path: Path) -> None:
    need(form)
    messages = list(session())
    path = written(form, tmp_path / f"session.{form}", messages)
    frames, complaints = told(open_capture(str(path)))
    assert complaints == []
    kept = [(message, wanted) for message in messages if (wanted := expected(message, form))]
    assert len(frames) == len(kept)
    for frame, (message, wanted) in zip(frames, kept, strict=True):
        assert {key: frame[key] for key in wanted} == wanted
        since = message.timestamp - (START if form in ("blf", "trc") else 0)
        # python-can's writers cut digits off; what is shown has no more than is sure.
        assert float(frame["t"]) == pytest.approx(since, abs=1.1e-6)
    digits = {len(frame["t"].partition(".")[2]) for frame in frames}
    assert digits <= ({9} if form == "blf" else {6}), digits


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("form", FORMS)
def test_what_is_written_is_read_back(form: str, tmp_path: Path) -> None:
    need(form)
    packer = Packer(9, directed=True, bus=lambda channel: f"can{channel}")
    records = b"".join(packer.frame(message) for message in session())
    path = tmp_path / f"out.{form}"
    with open_sink(str(path), form, force=False) as sink:
        for at in range(0, len(records), 1000):  # in any chunking
            sink.write(records[at : at + 1000])
    assert [child.name for child in tmp_path.iterdir()] == [path.name]
    frames, complaints = told(open_capture(str(path)))
    assert complaints == []
    losses = {name: count for name, count in sink.losses.items() if count}
    assert set(losses) <= set(LOSSES[form])
    kept = [message for message in session() if not (form == "trc" and message.is_error_frame)]
    assert len(frames) == len(kept)
    for frame, message in zip(frames, kept, strict=True):
        wanted = expected(message, "blf" if form == "trc" else form)
        assert wanted is not None
        assert {key: frame[key] for key in wanted} == wanted
        us = round(message.timestamp * 1e6) - (round(START * 1e6) if form in ("blf", "trc") else 0)
        assert round(float(frame["t"]) * 1e6) == us
    count = len(list(session()))
    fd_short = sum(message.is_fd and len(message.data) <= 8 for message in session())
    assert (
        losses
        == {
            "blf": {},
            "mf4": {},
            "trc": {"error_frame": count // 9},
            "csv": {"direction": count, "bus_name": 20, "fd_format": fd_short, "fd_flags": count // 9},
            "db": {"direction": count, "bus_name": 20, "fd_format": fd_short, "fd_flags": count // 9},
        }[form]
    )
    with pytest.raises(OutputError, match="exists"):
        open_sink(str(path), form, force=False)


def test_blf_keeps_every_ns(tmp_path: Path) -> None:
    packer = Packer(9, directed=True, bus=lambda _: "can0")
    rng = random.Random(4)
    stamps = sorted(1_700_000_000_123_456_789 + rng.randrange(10**14) for _ in range(500))
    record = packer.frame(can.Message(arbitration_id=0x701, is_extended_id=False, data=b"\x05", channel=0))
    name, frame = record[:28], record[28:]
    path = tmp_path / "ns.blf"
    with open_sink(str(path), "blf", force=False) as sink:
        sink.write(name)
        for ns in stamps:
            sink.write(frame[:16] + ns.to_bytes(8, "little") + frame[24:])
    assert not sum(sink.losses.values())
    frames, _ = told(open_capture(str(path)))
    date = 1_700_000_000_000_000_000 + min(stamps) % 10**9 // 10**6 * 10**6
    read = [int(frame["t"].replace(".", "")) for frame in frames]
    assert min(stamps) // 10**6 * 10**6 >= date
    assert [ns - stamps[0] for ns in stamps] == [ns - read[0] for ns in read]


def test_a_bus_gets_a_channel_of_its_own(tmp_path: Path) -> None:
    packer = Packer(9, directed=True, bus=lambda channel: str(channel))
    names = ["vcan1", "can1", "can0", "left", "can1"]
    path = tmp_path / "names.blf"
    with open_sink(str(path), "blf", force=False) as sink:
        for name in names:
            sink.write(packer.frame(can.Message(timestamp=1.0, arbitration_id=1, channel=name)))
    frames, _ = told(open_capture(str(path)))
    assert [frame["bus"] for frame in frames] == ["can1", "can0", "can2", "can3", "can0"]
    assert sink.losses["bus_name"] == 5


def test_a_sink_that_fails_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(KeyError), open_sink(str(tmp_path / "a.blf"), "blf", force=False) as sink:
        sink.write(bridge.dialect("reader", "x"))
        raise KeyError
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(OutputError):
        open_sink(str(tmp_path / "none" / "a.blf"), "blf", force=False)


def shown(frame: dict[str, Any]) -> str:
    """A frame in the form of the reference, without stamp and channel."""
    kind = "E" if frame["err"] else "R" if frame["rtr"] else "D"
    way = "Tx" if frame["dir"] == "tx" else "Rx"
    ident = f"{int(frame['id'], 16):X}" + ("x" if frame["ext"] else "")
    return f"{way} {ident} {kind} {frame['data']}"


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the shared corpus is not here")
@pytest.mark.parametrize("kind", ["blf", "trc"])
def test_corpus(kind: str) -> None:
    reference = json.loads((CORPUS / "transcripts/python_can_reference.json").read_text())["files"]
    for name, wanted in reference.items():
        if not name.startswith(kind):
            continue
        frames, complaints = told(open_capture(str(CORPUS / name)))
        assert complaints == [], name
        assert len(frames) == wanted["frames"], name
        for frame, line in zip(frames, wanted["list"], strict=True):
            seconds, channel, way, ident, mark, _, *data = line.split(" ")
            if kind == "trc":
                assert frame["bus"] == f"can{int(channel.removeprefix('ch=')) - 1}"
                assert shown(frame) == f"{way} {ident} {mark} {''.join(data)}", name
                # The reference has the header's date added; digits behind it say the same.
                assert frame["line"] is not None
                assert float(frame["t"]) <= float(seconds)
            elif "Fd" in name:  # an FD frame is no remote frame, and has its data
                assert (frame["fd"], frame["rtr"]) == ({"brs": True, "esi": True}, False)
                assert frame["data"] == bytes(range(64)).hex().upper()
            elif "Error" in name:  # what a Vector tool says of it is no error class
                assert (frame["err"], frame["id"], frame["len"]) == (True, "000", 0)
            else:
                assert frame["data"] == "".join(data)
                assert frame["bus"] == f"can{channel.removeprefix('ch=')}"


TRC = """\
;$FILEVERSION={version}
;$STARTTIME=44548.6028595139
{columns};
{rows}
"""


@pytest.mark.parametrize(
    ("version", "columns", "row"),
    [
        ("1.1", "", "1) 17535.4 Tx 0100 8 00 00 00 00 00 00 00 2A"),
        ("1.2", "", "1) 17535.4 2 Tx 0100 8 00 00 00 00 00 00 00 2A"),
        ("1.3", "", "1) 17535.4 2 Tx 0100 - 8 00 00 00 00 00 00 00 2A"),
        ("2.0", ";$COLUMNS=N,O,T,I,d,l,D\n", "1 17535.4 DT 0100 Tx 8 00 00 00 00 00 00 00 2A"),
        ("2.1", ";$COLUMNS=N,O,T,B,I,d,R,L,D\n", "1 17535.4 DT 2 0100 Tx - 8 00 00 00 00 00 00 00 2A"),
    ],
)
def test_every_version_of_trc_in_any_chunking(version: str, columns: str, row: str) -> None:
    text = TRC.format(version=version, columns=columns, rows="\n".join([row] * 3)).encode()
    frames, complaints = given(text, "trc")
    assert complaints == []
    bus = "can1" if version in ("1.2", "1.3", "2.1") else "can0"
    assert [(frame["t"], frame["bus"], frame["dir"], frame["data"]) for frame in frames] == [
        ("17.5354", bus, "tx", "000000000000002A")
    ] * 3
    for step in (1, 7, 40):
        assert given(text, "trc", step)[0] == frames


def test_lines_of_trc_that_are_no_frames() -> None:
    rows = [
        "1) 17535.4 1 Rx 0100 - 2 01 02",
        "2) 17540.3 1 Warng FFFFFFFF - 4 00 00 00 08 BUSHEAVY",
        "3) 17541.0 2 Error 0008 - 0",
        "4) 17541.5 1 Rx 0100 - 2 01 ZZ",
        "5) 17542.0 1 Rx 01",
        "rubbish",
        "6) 17543.0 1 Rx 0100 - 2 03 04",
    ]
    text = TRC.format(version="1.3", columns="", rows="\n".join(rows)).encode()
    frames, complaints = given(text, "trc")
    assert [(frame["err"], frame["bus"], frame["data"], frame["line"]) for frame in frames] == [
        (False, "can0", "0102", 4),
        (True, "can1", "", 6),
        (False, "can0", "0304", 10),
    ]
    named = [line for line in complaints if "given:" in line]
    assert [line.split(":")[1] for line in named[:3]] == ["7", "8", "9"], complaints


def test_trc_of_no_known_version_is_one_damage() -> None:
    text = TRC.format(version="9.9", columns="", rows="1) 1.0 x").encode()
    frames, complaints = given(text, "trc")
    assert (frames, len(complaints)) == ([], 1)
    assert "CAP004" in complaints[0]


@pytest.mark.parametrize("step", [1, 13, 1 << 20])
def test_rows_of_csv_that_are_none(step: int) -> None:
    rows = [
        "timestamp,arbitration_id,extended,remote,error,dlc,data",
        "1.5,0x701,0,0,0,1,BQ==",
        "1.6,0x701,0,0",
        "1.7,nothing,0,0,0,1,BQ==",
        "1.8,0x701,0,0,0,3,BQ==",
        "nan,0x701,0,0,0,1,BQ==",
        "1.9,0xFFFFFFFFFF,0,0,0,1,BQ==",
        "x" * 100_000,
        "2.25,0x701,0,0,0,1,BQ==",
    ]
    frames, complaints = given("\n".join(rows).encode(), "csv", step)
    assert [(frame["line"], frame["t"]) for frame in frames] == [(2, "1.500000"), (6, None), (9, "2.250000")]
    assert [line.split(":")[1] for line in complaints[:5]] == ["3", "4", "5", "7", "8"], complaints


def blf(tmp_path: Path) -> tuple[bytes, list[dict[str, Any]]]:
    """A BLF of many small containers, and its frames."""
    path = written("blf", tmp_path / "damage.blf", list(session()), max_container_size=400)
    data = path.read_bytes()
    frames, complaints = given(data, "blf")
    assert (len(frames), complaints) == (60, [])
    return data, frames


def test_blf_cut_at_every_byte(tmp_path: Path) -> None:
    data, frames = blf(tmp_path)
    last = 0
    for end in range(1, len(data)):
        read, complaints = given(data[:end], "blf")
        assert read == frames[: len(read)], end
        assert len(read) >= last, end
        last = len(read)
        if end > 4 and data[end:].strip(b"\0"):
            assert len(complaints) == 1, (end, complaints)
            assert "CAP005" in complaints[0], (end, complaints)
    assert last == len(frames)


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the shared corpus is not here")
def test_corpus_blf_cut_and_flipped() -> None:
    for path in sorted((CORPUS / "blf").iterdir()):
        data = path.read_bytes()
        for at in range(len(data)):
            given(data[:at], "blf")
            given(data[:at] + bytes([data[at] ^ 0xFF]) + data[at + 1 :], "blf")


def test_blf_of_flipped_bytes(tmp_path: Path) -> None:
    data, frames = blf(tmp_path)
    for at in range(144, len(data)):
        mask = (0xFF, 0x01, 0x80)[at % 3]
        read, complaints = given(data[:at] + bytes([data[at] ^ mask]) + data[at + 1 :], "blf")
        # Two objects at each end of a container are shared with its neighbours.
        assert len(read) >= len(frames) - 20, (at, mask, len(read), complaints)
        known = [frame for frame in read if frame in frames]
        assert len(known) == len(read), (at, mask)
        assert complaints or len(read) == len(frames), (at, mask)


def test_blf_of_random_bytes(tmp_path: Path) -> None:
    data, _ = blf(tmp_path)
    rng = random.Random(402)
    for _ in range(300):
        changed = bytearray(data)
        for _ in range(rng.randrange(1, 30)):
            changed[rng.randrange(len(changed))] = rng.randrange(256)
        given(bytes(changed), "blf", rng.choice((17, 1000, 1 << 20)))


def stored(*objects: bytes) -> bytes:
    """A BLF file of one container that is not compressed."""
    inner = b"".join(objects)
    header = struct.pack("<4sL4B4BQQLL8H8H", b"LOGG", 144, *[0] * 8, 0, 0, 0, 0, *[0] * 16).ljust(144, b"\0")
    return header + struct.pack("<4sHHLLH6xL4x", b"LOBJ", 16, 1, 32 + len(inner), 10, 0, len(inner)) + inner


def blf_object(kind: int, body: bytes, *, size: int | None = None, flags: int = 1, stamp: int = 150_000) -> bytes:
    real = 32 + len(body)
    sizes = real if size is None else size
    return struct.pack("<4sHHLLLHHQ", b"LOBJ", 32, 1, sizes, kind, flags, 0, 0, stamp) + body


HEARTBEAT = bytes.fromhex("0100 00 01 01070000 0500000000000000")


@pytest.mark.parametrize("size", [0, 1, 16, 31, 40, 5000, 0xFFFF_FFFF])
def test_blf_objects_of_absurd_size(size: int) -> None:
    good, bad = blf_object(1, HEARTBEAT), blf_object(1, HEARTBEAT, size=size)
    frames, complaints = given(stored(good, bad, good), "blf")
    assert [frame["t"] for frame in frames] == ["1.50000"] * 2
    assert len(complaints) == 1
    assert "CAP004" in complaints[0]


def test_blf_error_frames_that_python_can_does_not_know() -> None:
    objects = [blf_object(2, bytes.fromhex("0200000000000000")), blf_object(104, b"\x03" + bytes(50))]
    frames, complaints = given(stored(*objects, blf_object(1, HEARTBEAT), blf_object(65, bytes(20))), "blf")
    assert [(frame["err"], frame["bus"]) for frame in frames] == [(True, "can1"), (True, "can2"), (False, "can0")]
    assert complaints == []


def test_blf_objects_outside_containers() -> None:
    data = stored()
    frames, complaints = given(data[:144] + blf_object(1, HEARTBEAT) * 3, "blf")
    assert (len(frames), complaints) == (3, [])


def test_a_database_that_is_none(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "broken.db").write_bytes(b"SQLite format 3\0" + bytes(84))
    done = canalyze("decode", "--lang", "en", "broken.db")
    assert done.code == 2
    assert len(done.complaints) == 1
    assert done.complaints[0].startswith("canalyze: broken.db: cannot be read as SQLite (python-can: ")


@pytest.mark.parametrize("form", ["csv", "db"])
def test_a_reader_that_raises_half_way(form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(form, tmp_path / f"half.{form}", list(session()))
    taken = 0

    def fails(*given: Any, **named: Any) -> can.Message:
        nonlocal taken
        taken += 1
        if taken == 7 or taken > 30:
            raise MemoryError("what\nnow")
        return can.Message(*given, **named)

    module = sys.modules["can.io.csv" if form == "csv" else "can.io.sqlite"]
    monkeypatch.setattr(module, "Message", fails)
    frames, complaints = told(open_capture(str(path)))
    if form == "csv":  # a line costs only itself
        assert len(frames) == 29
    else:
        assert len(frames) == 6
        assert any("CAP004" in line for line in complaints)
        assert "python-can: MemoryError: what now" in "".join(complaints)
    assert all("\n" not in line for line in complaints)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("form", FORMS)
def test_standard_input(form: str, canalyze: Runner, tmp_path: Path) -> None:
    need(form)
    data = written(form, tmp_path / f"in.{form}", list(session())).read_bytes()
    named = canalyze("decode", f"in.{form}")
    piped = canalyze("decode", "-", stdin=data)
    asked = canalyze("decode", "--input-format", form, "-", stdin=data)
    assert named.code == piped.code == asked.code == 0
    assert named.lines == piped.lines == asked.lines
    assert len(named.lines) >= 25
    assert named.complaints == piped.complaints == []


def test_mf4_without_asammdf_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    path = tmp_path / "a.mf4"
    path.write_bytes(b"MDF     4.10    " + bytes(100))
    with pytest.raises(SourceError) as caught:
        open_capture(str(path))
    assert str(caught.value) == f"{path}: MF4 needs asammdf; install it: pip install 'canalyze[mf4]'"
    assert "pip install" in caught.value.in_words(Words("zh"))
    with pytest.raises(OutputError, match="needs asammdf"):
        open_sink(str(tmp_path / "b.mf4"), "mf4", force=False)
    assert [child.name for child in tmp_path.iterdir()] == ["a.mf4"]


def on_terminal(*args: str) -> tuple[int, str]:
    """Run a command whose terminal is a real one."""
    pid, terminal = pty.fork()
    if pid == 0:
        os.execv(sys.executable, command(*args))
    shown = b""
    try:
        while piece := os.read(terminal, 65536):
            shown += piece
    except OSError:  # the other side is gone
        pass
    os.close(terminal)
    progress = re.compile(r"\r[^\r\n]*\x1b\[K")  # of what takes longer
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), progress.sub("", shown.decode())


@pytest.mark.filterwarnings("ignore")
def test_a_terminal_sees_no_more_than_one_line_of_a_damaged_mf4(tmp_path: Path) -> None:
    need("mf4")
    data = written("mf4", tmp_path / "a.mf4", list(session())).read_bytes()
    out, path = str(tmp_path / "out.txt"), tmp_path / "b.mf4"
    rng = random.Random(403)
    for turn in range(4):
        changed = bytearray(data if turn else data[: len(data) // 2])
        for _ in range(10 * turn):
            changed[rng.randrange(64, len(changed))] ^= 255
        path.write_bytes(changed)
        _, shown = on_terminal("info", "--lang", "en", "--force", "-o", out, str(path))
        lines = [line for line in shown.splitlines() if line.strip()]
        assert len(lines) <= 1, lines
        assert "Traceback" not in shown
    converted = on_terminal("convert", "--lang", "en", str(tmp_path / "a.mf4"), str(tmp_path / "c.mf4"))
    assert converted == (0, "")


@pytest.mark.parametrize("form", ["blf", "trc", "csv", "db"])
def test_a_file_unpacked_in_part_has_one_damage(form: str, canalyze: Runner, tmp_path: Path) -> None:
    packed_up = gzip.compress(written(form, tmp_path / f"a.{form}", list(session())).read_bytes())
    (tmp_path / "cut.gz").write_bytes(packed_up[: len(packed_up) * 3 // 4])
    done = canalyze("decode", "--lang", "en", "cut.gz")
    damage, *rest = done.complaints
    assert "CAP005" in damage
    assert [line for line in rest if "cannot be read as SQLite" not in line] == []
    assert done.code == (2 if form == "db" else 0)


def test_damage_of_which_nothing_came_is_told(canalyze: Runner, tmp_path: Path) -> None:
    data, _ = blf(tmp_path)
    (tmp_path / "bad.blf").write_bytes(data[:144] + bytes(range(1, 200)))
    done = canalyze("decode", "--lang", "en", "bad.blf")
    assert done.code == 2
    assert "CAP004" in done.err
    assert "no CAN frames" in done.err


def test_info_says_nothing_of_a_file_that_cannot_be_read(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "broken.db").write_bytes(b"SQLite format 3\0" + bytes(84))
    done = canalyze("info", "broken.db")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)


@pytest.mark.filterwarnings("ignore")
def test_asammdf_that_takes_its_process_down(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    need("mf4")
    path = written("mf4", tmp_path / "a.mf4", list(session()))
    begin = "import os, signal, sys\nput = sys.stdout.buffer.write\n"
    head = bridge.dialect("reader", "python-can")
    frames = b"".join(map(Packer(6, directed=True, bus=str).frame, session()))
    for pieces, count in (([], 0), ([head], 0), ([head, frames], 60)):
        puts = [f"put({marshal.dumps((reading.RECORDS, piece))!r})\n" for piece in pieces]
        end = "sys.stdout.flush()\nos.kill(os.getpid(), signal.SIGSEGV)\n"
        monkeypatch.setattr(reading, "_START", begin + "".join(puts) + end)
        if count:
            read, complaints = told(open_capture(str(path)))
            assert len(read) == count
            assert any("asammdf: SIGSEGV" in line for line in complaints), complaints
            assert any("CAP004" in line for line in complaints), complaints
        else:
            with pytest.raises(SourceError, match=r"cannot be read as MF4 .*asammdf: SIGSEGV"):
                told(open_capture(str(path)))


def test_what_was_read_before_a_crash_has_been_written(monkeypatch: pytest.MonkeyPatch) -> None:
    out = io.BytesIO()

    def pieces(_: Path) -> Iterator[tuple[str, bytes]]:
        for number in range(3):
            yield reading.RECORDS, bytes([number])
            assert out.getvalue().endswith(marshal.dumps((reading.RECORDS, bytes([number]))))

    monkeypatch.setattr(reading, "from_this_process", pieces)
    monkeypatch.setattr(sys, "stdout", types.SimpleNamespace(buffer=out))
    reading.main("a.mf4")
    out.seek(0)
    assert [marshal.load(out)[0] for _ in range(4)] == [*[reading.RECORDS] * 3, "end"]


def test_a_pipe_is_answered_when_lines_come() -> None:
    import subprocess

    with subprocess.Popen(command("decode", "-"), stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin
        assert process.stdout
        process.stdin.write(TRC.format(version="1.1", columns="", rows="1) 1.0 Rx 0701 1 05").encode())
        process.stdin.flush()
        assert b"701" in process.stdout.readline()
        process.stdin.write(b"2) 2.0 Rx 0702 1 05\n")
        process.stdin.flush()
        assert b"702" in process.stdout.readline()
        process.stdin.close()
    assert process.returncode == 0


@pytest.mark.filterwarnings("ignore")
def test_nothing_is_left_behind_after_ctrl_c(tmp_path: Path) -> None:
    import signal

    need("mf4")
    messages = [can.Message(timestamp=1.5, arbitration_id=0x701, is_extended_id=False, data=b"\x05")] * 60_000
    path = written("mf4", tmp_path / "long.mf4", messages)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    with started(None, "decode", str(path), env=os.environ | {"TMPDIR": str(scratch)}, stderr=None) as process:
        assert process.stdout
        process.stdout.readline()
        assert list(scratch.iterdir()) != []
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode == 130
    assert list(scratch.iterdir()) == []


@pytest.mark.parametrize("form", ["blf", "csv"])
def test_ctrl_c_keeps_what_was_read(form: str, tmp_path: Path) -> None:
    import signal
    import subprocess

    messages = [can.Message(timestamp=1.5, arbitration_id=0x701, is_extended_id=False, data=b"\x05")] * 60_000
    path = written(form, tmp_path / f"long.{form}", messages)
    with subprocess.Popen(
        command("decode", "--lang", "en", str(path)), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert 0 < out.count(b"\n") < 60_000
    assert b"Traceback" not in err and b"CAP" not in err


@pytest.mark.parametrize("form", FORMS)
def test_damage_is_told_and_never_raises(form: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    need(form)
    data = written(form, tmp_path / f"a.{form}", list(session())).read_bytes()
    rng = random.Random(402)
    path = tmp_path / "b"
    capfd.readouterr()
    for turn in range(6 if form == "mf4" else 60):  # each in a process of its own
        changed = bytearray(data[: rng.randrange(1, len(data))] if turn % 3 == 0 else data)
        for _ in range(0 if turn % 3 == 0 else rng.choice((1, 1, 5, 50))):
            changed[rng.randrange(len(changed))] ^= rng.choice((255, 1, 128))
        path.write_bytes(changed)
        try:
            _, complaints = told(open_capture(str(path), form))
        except SourceError as error:
            complaints = [str(error)]
        assert all("\n" not in line for line in complaints)
    assert capfd.readouterr().err == ""
