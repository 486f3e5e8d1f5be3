"""`canalyze eds`: text, JSON lines, several files, errors."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import Runner, environment

from canalyze.output.layout import width

OWN = Path(__file__).parent.parent / "eds"
DRIVE = str(OWN / "drive.eds")
ODD = """\
[DeviceInfo]
VendorName=厂商
[DeviceComissioning]
NodeID=7
[MandatoryObjects]
SupportedObjects=1
1=0x1000
[1000]
ParameterName=\x1b[31mtype
DataType=7
AccessType=ro
DefaultValue=No
"""

KEYS = {
    "dictionary": {
        *("kind", "file", "form", "encoding", "node", "node_name", "bit_rate", "vendor", "vendor_number", "product"),
        *("product_number", "revision", "order_code", "file_name", "file_version", "file_revision", "eds_version"),
        *("description", "created", "modified", "comments", "bit_rates", "lss", "dummies", "objects"),
    },
    "object": {
        *("kind", "file", "line", "index", "sub", "object", "name", "type", "type_name", "access", "default"),
        *("parameter", "value", "offset", "mappable", "low", "high", "unit", "factor"),
    },
    "pdo": {
        *("kind", "file", "line", "pdo", "direction", "number", "cob_id", "base", "relative", "valid", "rtr"),
        *("extended", "assumed", "transmission", "inhibit", "event_timer", "sync_start", "multiplex", "bits", "mapped"),
    },
    "defect": {"kind", "file", "line", "code", "effect", "facts"},
}
"""Keys may be added here, none may be renamed or go."""


@pytest.fixture
def odd(tmp_path: Path) -> str:
    (tmp_path / "odd.dcf").write_text(ODD, encoding="utf-8")
    return "odd.dcf"


def test_text_in_english(canalyze: Runner) -> None:
    done = canalyze("--lang", "en", "eds", "--node", "5", DRIVE)
    assert (done.code, done.err) == (0, "")
    assert done.lines[0] == f"{DRIVE}: EDS, UTF-8"
    for part in (
        "  vendor               canalyze 0",
        "  node-ID              5",
        "  supported bit rates  10 20 50 125 250 500 1000 kbit/s",
        "1014h     COB-ID EMCY                         UNSIGNED32      rw      85h ($NODEID+80h)",
        "6000h-9FFFh  device profile       38       42",
        "RPDO1  205h ($NODEID+200h)  valid       255 event-driven, immediate (device profile)",
        "TPDO3  385h ($NODEID+380h)  valid  no   1 synchronous, every SYNC",
        "       16-47  6064h:00  INTEGER32   Position actual value",
        "No defects",
    ):
        assert any(line.startswith(part) for line in done.lines), part
    assert "10 ms       500 ms" in done.out


def test_text_in_chinese_is_aligned(canalyze: Runner) -> None:
    done = canalyze("eds", DRIVE)
    assert (done.code, done.err) == (0, "")
    heading = next(line for line in done.lines if line.startswith("PDO ") and "COB-ID" in line)
    rows = [line for line in done.lines if line.startswith(("RPDO", "TPDO")) and "$NODEID" in line]
    assert len(rows) == 8
    for row in rows:
        assert width(row[: row.index("有效")]) == width(heading[: heading.index("状态")])
        assert width(row[: row.index(" 事件") if "事件" in row else row.index(" 同步")]) > 0
    assert "$NODEID+180h" in rows[4] and "事件驱动(设备规范定义)" in rows[4]
    assert "1 同步循环, 每个SYNC" in rows[6]
    assert done.lines[-1] == "无缺陷"
    for english in ("vendor", "valid", "signal", "defects"):
        assert english not in done.out


def test_all_lists_every_object(canalyze: Runner) -> None:
    short, full = (canalyze("--lang", "en", "eds", DRIVE, *more) for more in ((), ("--all",)))
    assert "60FFh     Target velocity" in full.out and "60FFh     " not in short.out
    row = next(line for line in full.lines if line.startswith("2000h "))
    assert "0.1 degC" in row and "yes" in row
    row = next(line for line in full.lines if line.startswith("6060h "))
    assert "-128..10 (Ah)" in row


def test_jsonl_has_its_keys(canalyze: Runner, odd: str) -> None:
    done = canalyze("eds", "--format", "jsonl", "--node", "0x05", DRIVE, odd)
    assert (done.code, done.err) == (0, "")
    rows = [json.loads(line) for line in done.lines]
    assert {row["kind"] for row in rows} == set(KEYS)
    for row in rows:
        assert set(row) == KEYS[row["kind"]]
    (pdo,) = (row for row in rows if row.get("pdo") == "TPDO4")
    assert (pdo["cob_id"], pdo["base"], pdo["relative"], pdo["rtr"], pdo["bits"]) == ("485", "480", True, False, 64)
    assert pdo["mapped"][2] == {
        "index": "6077",
        "sub": 0,
        "offset": 48,
        "bits": 16,
        "name": "Torque actual value",
        "type": "0003",
        "dummy": False,
    }
    (entry,) = (row for row in rows if row.get("index") == "1014")
    assert (entry["default"], entry["value"], entry["offset"]) == (0x85, 0x85, 0x80)
    (defect,) = (row for row in rows if row["kind"] == "defect")
    assert (defect["file"], defect["line"], defect["code"], defect["effect"]) == (odd, 12, "not-a-number", "unused")


def test_node_of_the_file_and_defects(canalyze: Runner, odd: str) -> None:
    done = canalyze("--lang", "en", "eds", odd)
    assert (done.code, done.err) == (0, "")
    assert any(line.split() == ["node-ID", "7"] for line in done.lines)
    assert done.lines[-1] == "odd.dcf:12: not used: DefaultValue=No is not a number [not-a-number]"
    assert "\x1b" not in done.out and "\\x1b[31mtype" in done.out
    assert any(line.split() == ["node-ID", "9"] for line in canalyze("--lang", "en", "eds", "--node=9", odd).lines)
    assert "odd.dcf:12: 未采用: DefaultValue=No 不是数 [not-a-number]" in canalyze("eds", odd).lines


def test_repeats_are_folded(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "many.eds").write_text(ODD.encode("ascii", "ignore").decode() + "no key\n" * 25)
    done = canalyze("--lang", "en", "eds", "many.eds")
    assert sum("[no-equals]" in line for line in done.lines) == 10
    assert done.lines[-1] == "... 15 more of no-equals"
    assert "Defects: 26" in done.lines


def test_runs_of_one_value_share_a_line(canalyze: Runner, tmp_path: Path) -> None:
    array = (
        "ParameterName=consumer\nObjectType=8\nDataType=7\nAccessType=rw\nDefaultValue=0x80000000\nCompactSubObj=20\n"
    )
    (tmp_path / "run.eds").write_text(f"[1028]\n{array}[1028Value]\nNrOfEntries=1\n3=0x81\n")
    rows = [line for line in canalyze("--lang", "en", "eds", "run.eds").lines if line.startswith("1028h")]
    assert [row.split()[0] for row in rows] == ["1028h:00", "1028h:01", "1028h:02", "1028h:03", "1028h:04-14"]


def test_one_bad_file_does_not_stop_the_others(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "bad.eds").write_text("can0  60A   [8]  40 08 10 00 00 00 00 00\n")
    done = canalyze("--lang", "en", "eds", "bad.eds", "missing.eds", DRIVE)
    assert (done.code, len(done.complaints)) == (2, 2)
    assert "bad.eds: no CANopen objects" in done.err
    assert "missing.eds: cannot open: no such file or directory" in done.err
    assert done.lines[0] == f"{DRIVE}: EDS, UTF-8"


@pytest.mark.parametrize("node", ["0", "128", "x", "", "0x80"])
def test_node_that_cannot_be(canalyze: Runner, node: str) -> None:
    done = canalyze("eds", f"--node={node}", DRIVE)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "--node" in done.err and "1到127" in done.err


def test_standard_input_and_output_file(canalyze: Runner, tmp_path: Path) -> None:
    done = canalyze("eds", "-o", "out.txt", "-", stdin=Path(DRIVE).read_bytes())
    assert (done.code, done.out, done.err) == (0, "", "")
    assert (tmp_path / "out.txt").read_text(encoding="utf-8").startswith("stdin: EDS, UTF-8\n")
    assert canalyze("eds", "-o", "out.txt", DRIVE).code == 2
    assert canalyze("eds", "missing.eds", "-o", "none.txt").code == 2
    assert not (tmp_path / "none.txt").exists()


def test_reader_that_goes_away(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    process = subprocess.run(
        [sys.executable, "-m", "canalyze", "eds", DRIVE],
        stdout=writer,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
        env=environment(),
        check=False,
    )
    os.close(writer)
    assert (process.returncode, process.stderr) == (0, b"")
