"""pcap and pcapng files as other programs write them, and what tshark reads in the same files.

Files packed here by hand are shown to tshark first: what it reads is what we have to read. Without Wireshark's programs
the tests that need them are skipped.
"""

from __future__ import annotations

import json
import random
import shutil
import struct
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from captures import SAMPLES, Row, analyze
from conftest import Runner

SOCKETCAN, SLL, SLL2 = 227, 113, 276
EXTENDED, REMOTE = 0x8000_0000, 0x4000_0000

PACKETS = [
    (0x601, 0, b"\x40\x08\x10\x00\x00\x00\x00\x00"),
    (EXTENDED | 0x1FFF_FFFF, 0, b"\x01"),
    (EXTENDED | 0x123, 0, b""),
    (REMOTE | 0x70A, 0, b"\0\0"),
    (0x123, 7, bytes(range(12))),
    (EXTENDED | 0x123, 5, bytes(range(64))),
    (0x123, 4, b""),
]
"""Identifier with its flags, FD flags (0: a classic frame), data."""

needs_tshark = pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed")
needs_editcap = pytest.mark.skipif(shutil.which("editcap") is None, reason="editcap is not installed")


def packet(order: str, link: int, can_id: int, flags: int, data: bytes) -> bytes:
    """One packet of that link type, in a file of that byte order."""
    room = 64 if flags else 8
    # Behind a cooked header the identifier is in the host's order.
    frame = struct.pack(">I" if link == SOCKETCAN else f"{order}I", can_id)
    frame += struct.pack(f"BBxx{room}s", len(data), flags, data)
    protocol = 0x000D if flags else 0x000C
    if link == SLL:
        return struct.pack(">HHH8sH", 4, 280, 0, b"", protocol) + frame
    if link == SLL2:
        return struct.pack(">HHIHBB8s", protocol, 0, 7, 280, 4, 0, b"") + frame
    return frame


def pcap(order: str, nano: bool, link: int, packets: Sequence[tuple[int, int, bytes]] = PACKETS) -> bytes:
    """A pcap file; its packets are 1 s and 5 units apart."""
    out = struct.pack(f"{order}IHHiIII", 0xA1B23C4D if nano else 0xA1B2C3D4, 2, 4, 0, 0, 65535, link)
    for no, (can_id, flags, data) in enumerate(packets):
        body = packet(order, link, can_id, flags, data)
        out += struct.pack(f"{order}IIII", 1_700_000_000 + no, 5 * no, len(body), len(body)) + body
    return out


def said(*command: str | Path) -> str:
    """Give what a program prints."""
    return subprocess.run(command, capture_output=True, check=True, text=True, timeout=60).stdout


def frames(canalyze: Runner, *names: str | Path) -> list[Row]:
    """Give the frames that we read; nothing may be complained of."""
    done = canalyze("decode", "--format", "jsonl", *map(str, names))
    assert done.err == ""
    rows = [json.loads(line) for line in done.lines]
    return [row for row in rows if row["kind"] == "frame"]


def short(row: Row) -> tuple[str, str, bool, bool, bool, str]:
    """What a frame is, without when and where."""
    return (row["id"], row["t"], row["ext"], row["rtr"], bool(row["fd"]), row["data"])


@pytest.mark.parametrize("link", [SOCKETCAN, SLL, SLL2])
@pytest.mark.parametrize("nano", [False, True])
@pytest.mark.parametrize("order", ["<", ">"])
def test_files_packed_by_hand(canalyze: Runner, tmp_path: Path, order: str, nano: bool, link: int) -> None:
    (tmp_path / "hand.pcap").write_bytes(pcap(order, nano, link))
    rows = frames(canalyze, "hand.pcap")
    assert len(rows) == len(PACKETS)
    for no, (row, (can_id, flags, data)) in enumerate(zip(rows, PACKETS, strict=True)):
        extended, remote = bool(can_id & EXTENDED), bool(can_id & REMOTE)
        digits = f"{can_id & 0x1FFF_FFFF:0{8 if extended else 3}X}"
        fraction = f"{5 * no:09d}" if nano else f"{5 * no:06d}"
        stamp = f"{1_700_000_000 + no}.{fraction}"
        shown = "" if remote else data.hex().upper()
        assert short(row) == (digits, stamp, extended, remote, bool(flags), shown)
        assert row["bus"] == ("if7" if link == SLL2 else "can0")
        assert row["dir"] == (None if link == SOCKETCAN else "tx")


@needs_tshark
@pytest.mark.parametrize("link", [SOCKETCAN, SLL, SLL2])
@pytest.mark.parametrize("order", ["<", ">"])
def test_tshark_reads_the_same(canalyze: Runner, tmp_path: Path, order: str, link: int) -> None:
    file = tmp_path / "hand.pcap"
    file.write_bytes(pcap(order, True, link))
    fields = ["frame.time_epoch", "can.id", "can.flags.xtd", "can.flags.rtr", "can.len"]
    text = said("tshark", "-r", file, "-T", "fields", *[arg for field in fields for arg in ("-e", field)])
    ours = [
        [row["t"], str(int(row["id"], 16)), str(int(row["ext"])), str(int(row["rtr"])), str(row["len"])]
        for row in frames(canalyze, file)
    ]
    # tshark shows no RTR flag of an FD frame.
    theirs = [[word or "0" for word in line.split("\t")] for line in text.splitlines()]
    assert theirs == ours


LOGS = sorted((SAMPLES / "stacks").glob("*.log"))


@needs_editcap
@pytest.mark.parametrize("form", ["pcapng", "pcap", "nsecpcap"])
@pytest.mark.parametrize("path", LOGS[:4], ids=lambda path: path.name)
def test_logs_that_editcap_converted(canalyze: Runner, tmp_path: Path, path: Path, form: str) -> None:
    text = b"".join(line for line in path.read_bytes().splitlines(True) if line.startswith(b"("))
    (tmp_path / "in.log").write_bytes(text)
    said("editcap", "-F", form, tmp_path / "in.log", tmp_path / "out")
    rows = [short(row) for row in frames(canalyze, "out")]
    zeros = "000" if form == "nsecpcap" else ""
    expected = [short(row) for row in analyze(text).frames]
    assert rows == [(first, f"{t}{zeros}", *rest) for first, t, *rest in expected]
    assert rows


@needs_editcap
def test_interfaces_that_mergecap_joined(canalyze: Runner, tmp_path: Path) -> None:
    for name, order in (("one", "<"), ("two", ">")):
        (tmp_path / f"{name}.pcap").write_bytes(pcap(order, True, SOCKETCAN))
        said("editcap", "-F", "pcapng", tmp_path / f"{name}.pcap", tmp_path / f"{name}.pcapng")
    said("mergecap", "-I", "none", "-w", tmp_path / "both.pcapng", tmp_path / "one.pcapng", tmp_path / "two.pcapng")
    rows = frames(canalyze, "both.pcapng")
    assert len(rows) == 2 * len(PACKETS)
    single = [short(row) for row in frames(canalyze, "one.pcap")]
    for bus in ("can0", "can1"):
        assert [short(row) for row in rows if row["bus"] == bus] == single


@needs_editcap
def test_snaplen_leaves_frames_that_cannot_be_read(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "hand.pcap").write_bytes(pcap("<", False, SOCKETCAN))
    said("editcap", "-F", "pcap", "-s", "16", tmp_path / "hand.pcap", tmp_path / "cut.pcap")
    done = canalyze("decode", "--lang", "en", "cut.pcap")
    assert len([line for line in done.lines if line.startswith("(")]) == len(PACKETS) - 2
    assert [line for line in done.complaints if "do not match the length" in line] == done.complaints[:2]


def test_a_cut_file_says_so_once(canalyze: Runner, tmp_path: Path) -> None:
    whole = pcap("<", False, SOCKETCAN)
    (tmp_path / "cut.pcap").write_bytes(whole[:-1])
    done = canalyze("decode", "--lang", "en", "cut.pcap")
    assert len([line for line in done.lines if line.startswith("(")]) == len(PACKETS) - 1
    assert len([line for line in done.complaints if "CAP005" in line]) == len(done.complaints) == 1


def test_other_link_types_are_no_fault(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "eth.pcap").write_bytes(pcap("<", False, 1))
    done = canalyze("decode", "--lang", "en", "eth.pcap")
    assert done.out == ""
    assert not [line for line in done.complaints if "CAP" in line]


def test_standard_input_and_any_name(canalyze: Runner, tmp_path: Path) -> None:
    file = pcap(">", False, SOCKETCAN)
    (tmp_path / "capture.log").write_bytes(file)
    expected = [short(row) for row in frames(canalyze, "capture.log")]
    done = canalyze("decode", "--format", "jsonl", "-", stdin=file)
    assert [short(row) for row in map(json.loads, done.lines) if row["kind"] == "frame"] == expected


def swapped(file: bytes) -> bytes:
    """The same pcap file with its identifiers in the other byte order, as programs write it that pack it themselves."""
    out, at = bytearray(file), 24
    while at < len(out):
        out[at + 16 : at + 20] = out[at + 16 : at + 20][::-1]
        at += 16 + struct.unpack_from("<I", out, at + 8)[0]
    return bytes(out)


def of_pcapng(file: bytes) -> bytes:
    """The packets of a pcap file in a pcapng file."""

    def block(kind: int, body: bytes) -> bytes:
        body += bytes(-len(body) % 4)
        size = struct.pack("<I", len(body) + 12)
        return struct.pack("<I", kind) + size + body + size

    out = block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)) + block(1, struct.pack("<HHI", SOCKETCAN, 0, 0))
    at = 24
    while at < len(file):
        _, _, size, _ = struct.unpack_from("<IIII", file, at)
        out += block(6, struct.pack("<IIIII", 0, 0, at, size, size) + file[at + 16 : at + 16 + size])
        at += 16 + size
    return out


@pytest.mark.parametrize("change", [bytes, of_pcapng], ids=["pcap", "pcapng"])
@pytest.mark.parametrize("ids", [(0x601, 0x581), (0x181, 0x182, 0x80), (0x701,), (EXTENDED | 0x181, 0x60A, 0x58A)])
def test_identifiers_in_the_wrong_byte_order_are_read(
    canalyze: Runner, tmp_path: Path, ids: Sequence[int], change: Callable[[bytes], bytes]
) -> None:
    data = bytes.fromhex("4000100000000000")
    right = pcap("<", False, SOCKETCAN, [(ids[at % len(ids)], 0, data) for at in range(50)])
    (tmp_path / "right.pcap").write_bytes(change(right))
    (tmp_path / "wrong.pcap").write_bytes(change(swapped(right)))
    expected = [short(row) for row in frames(canalyze, "right.pcap")]
    assert [int(one[0], 16) for one in expected][: len(ids)] == [can_id & 0x1FFF_FFFF for can_id in ids]
    rows = map(json.loads, canalyze("decode", "--format", "jsonl", "wrong.pcap").lines)
    assert [short(row) for row in rows if row["kind"] == "frame"] == expected
    for lang, words in (("en", "are little-endian, the format requires big-endian"), ("zh", "小端序")):
        said, clean = (canalyze("summary", "--lang", lang, name) for name in ("wrong.pcap", "right.pcap"))
        assert ([words in line for line in said.complaints], clean.err) == ([True], "")
    assert "identifiers: little-endian" in canalyze("info", "--lang", "en", "wrong.pcap").out
    assert "identifiers" not in canalyze("info", "--lang", "en", "right.pcap").out


@pytest.mark.parametrize("change", [bytes, of_pcapng], ids=["pcap", "pcapng"])
def test_packets_that_hold_no_identifiers_are_refused(
    canalyze: Runner, tmp_path: Path, change: Callable[[bytes], bytes]
) -> None:
    source = random.Random(227)
    for seed in range(20):
        ids = [source.randrange(1 << 32) if seed % 2 else 0x0102_0304 + at for at in range(300)]
        (tmp_path / "a.pcap").write_bytes(change(pcap("<", False, SOCKETCAN, [(one, 0, b"\1") for one in ids])))
        done = canalyze("decode", "--lang", "en", "a.pcap")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1), seed
        assert "no CAN identifier in either byte order" in done.err
