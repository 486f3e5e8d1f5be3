"""What transfers carry: firmware, descriptions, packed files, each by its marks and sums; nothing by its looks."""

from __future__ import annotations

import bz2
import gzip
import io
import json
import lzma
import struct
import zipfile
from pathlib import Path

import pytest
from captures import EDS, SAMPLES, CanFrame, log_text, spaced
from conftest import Runner
from sdo_wire import Channel, block_download, block_upload, crc, expedited_upload, segmented_download, segmented_upload

from canalyze.reports.extract import recognised

NODE = Channel(10, "can0")
PROGRAM = bytes(range(256)) * 3
DRIVE = (EDS / "drive.eds").read_bytes()


def s_records(data: bytes, base: int, *, end: bool = True) -> bytes:
    """A Motorola S-record file of 32-bit addresses."""
    bodies = [("S0", b"\0\0canalyze")]
    bodies += [("S3", struct.pack(">I", base + at) + data[at : at + 32]) for at in range(0, len(data), 32)]
    bodies += [("S7", struct.pack(">I", base))] if end else []
    lines = []
    for kind, body in bodies:
        counted = bytes([len(body) + 1]) + body
        lines.append(kind + (counted + bytes([~sum(counted) & 0xFF])).hex().upper())
    return "".join(line + "\r\n" for line in lines).encode()


def intel_hex(data: bytes, base: int, *, end: bool = True) -> bytes:
    """An Intel HEX file with an extended linear address."""
    records = [(0, 4, struct.pack(">H", base >> 16))]
    records += [((base + at) & 0xFFFF, 0, data[at : at + 16]) for at in range(0, len(data), 16)]
    records += [(0, 1, b"")] if end else []
    lines = []
    for address, kind, body in records:
        whole = bytes([len(body)]) + struct.pack(">H", address) + bytes([kind]) + body
        lines.append(":" + (whole + bytes([-sum(whole) & 0xFF])).hex().upper())
    return "".join(line + "\n" for line in lines).encode()


def zipped(data: bytes) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        archive.writestr("program.bin", data)
    return made.getvalue()


def elf(order: str = "<") -> bytes:
    head = b"\x7fELF\x01" + (b"\x01" if order == "<" else b"\x02") + b"\x01" + bytes(9)
    return (head + struct.pack(order + "HHIIIIIHHHHHH", 2, 40, 1, 0, 0, 64, 0, 52, 0, 0, 40, 1, 0)).ljust(104, b"\0")


def changed(data: bytes, at: int) -> bytes:
    return data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]


CONCISE = struct.pack("<IHBIH", 1, 0x1017, 0, 2, 500)
FOUND: list[tuple[bytes, str, str, dict[str, object], tuple[str, dict[str, object]] | None]] = [
    (gzip.compress(PROGRAM), "packed", "gz", {"form": "gzip", "unpacked": 768}, None),
    (gzip.compress(PROGRAM)[:-9], "packed", "gz", {"form": "gzip"}, ("cut", {})),
    (changed(gzip.compress(PROGRAM), -6), "packed", "gz", {"form": "gzip"}, ("compression", {})),
    (lzma.compress(PROGRAM), "packed", "xz", {"form": "xz", "unpacked": 768}, None),
    (bz2.compress(PROGRAM), "packed", "bz2", {"form": "bzip2", "unpacked": 768}, None),
    (zipped(PROGRAM), "zip", "zip", {"files": 1}, None),
    (zipped(PROGRAM)[:-30], "zip", "zip", {"files": 0}, ("structure", {})),
    (changed(zipped(PROGRAM), 100), "zip", "zip", {"files": 1}, ("member", {"name": "program.bin"})),
    (elf(), "elf", "elf", {}, None),
    (elf(">"), "elf", "elf", {}, None),
    (elf()[:90], "elf", "elf", {}, ("cut", {})),
    (
        *(s_records(PROGRAM, 0x08000000), "srec", "s19"),
        *({"first": "08000000h", "last": "080002FFh", "size": 768}, None),
    ),
    (changed(s_records(PROGRAM, 0), 200), "srec", "s19", {}, ("lines", {"count": 1, "line": 4})),
    (s_records(PROGRAM, 0, end=False), "srec", "s19", {"size": 768}, ("end", {})),
    (intel_hex(PROGRAM, 0x0001F000), "hex", "hex", {"first": "0001F000h", "last": "0001F2FFh", "size": 768}, None),
    (changed(intel_hex(PROGRAM, 0), 20), "hex", "hex", {}, ("lines", {"count": 1, "line": 2})),
    (intel_hex(PROGRAM, 0)[:505], "hex", "hex", {}, ("lines", {"count": 1, "line": 13})),
    (DRIVE, "description", "eds", {"form": "EDS", "product": "Servo drive"}, None),
]


@pytest.mark.parametrize(("data", "kind", "suffix", "facts", "damage"), FOUND)
def test_a_form_is_told_by_its_marks_and_sums(
    data: bytes, kind: str, suffix: str, facts: dict[str, object], damage: tuple[str, dict[str, object]] | None
) -> None:
    found = recognised(data, 0x1F50)
    assert found and (found.kind, found.suffix) == (kind, suffix)
    assert facts.items() <= found.facts.items()
    assert (found.damage and found.damage[0]) == (damage and damage[0])
    assert found.damage is None or damage is None or damage[1].items() <= found.damage[1].items()


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PK",
        b"Zephyr RTOS/CANopenNode",
        b"S1 is the first station\nS2 is the second station\n",
        b"S0123456789ABCDEF0123456789ABCDEF",
        b":-) a text that begins with a colon\n:10 items\n",
        b":0123456789ABCDEF0123456789ABCDEF",
        b"[Settings]\nSpeed=1\n[1000]\nvalue=2\n",
        b"the [FileInfo] section is described elsewhere\n",
        b"[FileInfo]\nFileName=nothing in it\n",
        bytes(64),
        PROGRAM,
    ],
)
def test_nothing_is_told_by_its_looks(data: bytes) -> None:
    assert recognised(data, 0x1F50) is None


def test_a_concise_dcf_is_told_by_its_object() -> None:
    found = recognised(CONCISE, 0x1F22)
    assert found and (found.kind, found.facts, found.damage) == ("concise", {"values": 1}, None)
    assert recognised(CONCISE, 0x2000) is None
    found = recognised(CONCISE[:-1], 0x1F22)
    assert found and found.damage == ("values", {"found": 0})


def capture(tmp_path: Path, *transfers: list[CanFrame]) -> str:
    (tmp_path / "files.log").write_bytes(log_text(spaced([frame for frames in transfers for frame in frames])))
    return "files.log"


PROGRAM_FILE = s_records(PROGRAM, 0x08000000)


def test_files_are_named_and_described(canalyze: Runner, tmp_path: Path) -> None:
    name = capture(
        tmp_path,
        block_download(NODE, 0x1F50, 1, PROGRAM_FILE),
        segmented_download(NODE, 0x1F50, 2, gzip.compress(PROGRAM)[:-9]),
        segmented_upload(NODE, 0x1021, 0, DRIVE[:3000]),
        segmented_upload(NODE, 0x1008, 0, b"a name of some length"),
        expedited_upload(NODE, 0x1F56, 1, bytes.fromhex("78563412")),
        block_upload(NODE, 0x1F50, 1, PROGRAM)[:-30],
        segmented_download(Channel(11, "can0"), 0x1F50, 1, PROGRAM_FILE)[:-40],
    )
    done = canalyze("sdo", "--format", "jsonl", name, "--extract", "out")
    assert done.code == 0
    assert sorted(file.name for file in (tmp_path / "out").iterdir() if "holes" not in file.name) == [
        "00001_can0_node10_1F50h_01_program_data.s19",
        "00002_can0_node10_1F50h_02_program_data.gz",
        "00003_can0_node10_1021h_00_store_EDS.eds",
        "00004_can0_node10_1008h_00_manufacturer_device_name.bin",
        "00005_can0_node10_1F56h_01_program_software_identification.bin",
        "00006_can0_node10_1F50h_01_program_data.bin.incomplete",
        "00007_can0_node11_1F50h_01_program_data.s19.incomplete",
    ]
    assert (tmp_path / "out/00001_can0_node10_1F50h_01_program_data.s19").read_bytes() == PROGRAM_FILE
    files = [row for row in map(json.loads, done.lines) if row["kind"] == "file"]
    assert [(row["transfer"], row["complete"], row["software"]) for row in files] == [
        (1, True, 0x12345678),
        (2, True, None),
        (3, True, None),
        (6, False, 0x12345678),
        (7, False, None),
    ]
    first = files[0]
    assert (first["index"], first["sub"], first["name"]) == ("1F50", 1, "program data")
    assert first["contents"] == {"kind": "srec", "first": "08000000h", "last": "080002FFh", "size": 768}
    assert (first["crc"], first["crc_ok"]) == (f"{crc(PROGRAM_FILE):04X}", True)
    assert (files[1]["damage"]["kind"], files[1]["crc"]) == ("cut", None)
    assert files[2]["damage"]["kind"] == "objects"
    assert files[3]["contents"] is None and files[3]["crc"] is None
    assert (files[4]["contents"]["kind"], files[4]["damage"]) == ("srec", None), "what is cut is not damaged"


@pytest.mark.parametrize(
    ("lang", "said"),
    [
        ("en", ["Motorola S-record, 08000000h to 080002FFh, 768 bytes", "damaged: it ends too early", "12345678h"]),
        ("zh", ["Motorola S-record，08000000h到080002FFh，768字节", "损坏：不完整", "12345678h"]),
    ],
)
def test_files_in_words(canalyze: Runner, tmp_path: Path, lang: str, said: list[str]) -> None:
    name = capture(
        tmp_path,
        block_download(NODE, 0x1F50, 1, PROGRAM_FILE),
        segmented_download(NODE, 0x1F50, 2, gzip.compress(PROGRAM)[:-9]),
        expedited_upload(NODE, 0x1F56, 1, bytes.fromhex("78563412")),
    )
    done = canalyze("sdo", "--lang", lang, name, "--extract", "out")
    assert done.code == 0
    listing = done.out.split("\n\n")[1]
    assert all(text in listing for text in said)
    assert f"{crc(PROGRAM_FILE):04X}h" in listing
    (tmp_path / "strings.log").write_bytes(log_text(spaced(segmented_upload(NODE, 0x1008, 0, b"a longer name"))))
    done = canalyze("sdo", "--lang", lang, "strings.log", "--extract", "strings")
    assert "\n\n" not in done.out, "what is no file is not listed as one"


def test_a_wrong_crc_is_said(canalyze: Runner, tmp_path: Path) -> None:
    frames = block_download(NODE, 0x1F50, 1, PROGRAM)
    end = next(frame for frame in frames if frame.data[0] & 0xE3 == 0xC1 and frame.can_id == 0x60A)
    wrong = CanFrame(end.bus, end.can_id, changed(end.data, 1))
    name = capture(tmp_path, [wrong if frame is end else frame for frame in frames])
    done = canalyze("sdo", "--format", "jsonl", name, "--extract", "out")
    (file,) = [row for row in map(json.loads, done.lines) if row["kind"] == "file"]
    assert (file["crc_ok"], file["status"]) in ((False, "ok"), (None, "failed"))


STORED = [
    (segmented_upload(Channel(5, "vcan0"), 0x1021, 0, DRIVE), True, "the EDS in the capture is used (1021h"),
    (block_upload(Channel(5, "vcan0"), 0x1021, 0, DRIVE), True, "the EDS in the capture is used (1021h"),
    (segmented_upload(Channel(5, "vcan0"), 0x1021, 0, DRIVE)[:-4], False, "is not used: transfer incomplete"),
    (
        [
            *segmented_upload(Channel(5, "vcan0"), 0x1021, 0, gzip.compress(DRIVE)),
            *expedited_upload(Channel(5, "vcan0"), 0x1022, 0, b"\x01"),
        ],
        False,
        "is not used: no EDS, perhaps compressed (store format 1022h: 1)",
    ),
    ([], False, "no 1021h (store EDS) in the capture"),
]


@pytest.mark.parametrize(("transfer", "used", "said"), STORED, ids=["segmented", "block", "cut", "packed", "none"])
def test_the_eds_of_the_device_is_its_description(
    canalyze: Runner, tmp_path: Path, transfer: list[CanFrame], used: bool, said: str
) -> None:
    """What is decoded by it is what `--eds` decodes; the EDS may come last."""
    network = (SAMPLES / "network/sync-and-pdos.log").read_bytes()
    (tmp_path / "both.log").write_bytes(network + log_text(spaced(transfer, start_us=1_795_232_040_000_000)))
    wanted = canalyze("signals", "both.log", *(["--eds", f"5={EDS / 'drive.eds'}"] if used else []))
    for command in ("signals", "decode", "od", "check", "summary"):
        done = canalyze(command, "--lang", "en", "both.log", "--eds-from-traffic")
        assert done.code in (0, 1) and said in done.err
        assert "Traceback" not in done.err
        if command == "signals":
            assert done.out == wanted.out


def test_what_the_user_says_comes_first(canalyze: Runner, tmp_path: Path) -> None:
    stored = segmented_upload(Channel(5, "can0"), 0x1021, 0, DRIVE)
    frames = [*spaced(stored), CanFrame("can0", 0x185, b"\x37\x02", 1_700_000_100_000_000)]
    (tmp_path / "both.log").write_bytes(log_text(frames))
    done = canalyze("decode", "--lang", "en", "both.log", "--eds-from-traffic", "--eds", f"5={EDS / 'io.eds'}")
    assert "node 5: the EDS in the capture (1021h" in done.err and "is not used, the node has a description" in done.err
    assert "statusword" not in done.lines[-1]


def test_standard_input_is_no_file(canalyze: Runner) -> None:
    done = canalyze("decode", "--lang", "en", "-", "--eds-from-traffic")
    assert done.code == 2 and "cannot be used with standard input" in done.err
