"""`canalyze sdo`: the table, JSON lines, and the data as files."""

import json
from pathlib import Path

from conftest import NOTES, Runner


def test_table(canalyze: Runner, notes: str) -> None:
    done = canalyze("--lang", "en", "sdo", notes)
    assert (done.code, done.err) == (0, "")
    heading, row = done.lines
    wanted = "# time bus node direction object name value size mode duration outcome findings frames"
    assert heading.split() == wanted.split()
    for cell in ("can1", "10", "upload", "1008h:00", "segmented", "ok", "23"):
        assert cell in row
    assert row.index("1008h:00") == heading.index("object")


def test_columns_count_chinese_double(canalyze: Runner, notes: str) -> None:
    from canalyze.help import width

    heading, row = canalyze("sdo", notes).lines
    assert width(heading[: heading.index("对象")]) == width(row[: row.index("1008h:00")])
    assert "上传" in row and "分段" in row and "完成" in row


def test_jsonl(canalyze: Runner, notes: str) -> None:
    done = canalyze("sdo", "--format", "jsonl", notes)
    (transfer,) = map(json.loads, done.lines)
    assert transfer["kind"] == "transfer"
    assert (transfer["index"], transfer["sub"], transfer["node"]) == ("1008", 0, 10)
    assert (transfer["status"], transfer["size"]) == ("ok", 23)


def test_no_transfer_is_said(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "heartbeat.log").write_text("can1  70A   [1]  05\n")
    done = canalyze("--lang", "en", "sdo", "heartbeat.log")
    assert (done.code, done.out) == (0, "")
    assert "no SDO transfer" in done.err


def test_extract(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    done = canalyze("--lang", "en", "sdo", notes, "--extract", "out/deep")
    assert done.code == 0
    assert "files written to out/deep: 1" in done.err
    (file,) = (tmp_path / "out/deep").iterdir()
    assert file.read_bytes() == b"Zephyr RTOS/CANopenNode"

    file.write_bytes(b"mine")
    done = canalyze("sdo", notes, "--extract", "out/deep")
    assert done.code == 2
    assert "--force" in done.err
    assert file.read_bytes() == b"mine"
    assert list((tmp_path / "out/deep").iterdir()) == [file]

    assert canalyze("sdo", notes, "--extract", "out/deep", "--force").code == 0
    assert file.read_bytes() == b"Zephyr RTOS/CANopenNode"


def test_extract_names_what_did_not_succeed(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "cut.log").write_text("".join(NOTES.splitlines(keepends=True)[:7]))
    assert canalyze("sdo", "cut.log", "--extract", "out").code == 0
    (file,) = (tmp_path / "out").iterdir()
    assert file.suffix == ".incomplete"
    assert b"Zephyr RTOS/CANopenNode".startswith(file.read_bytes()[:7])


def test_extract_into_a_file_is_one_line(canalyze: Runner, notes: str) -> None:
    done = canalyze("sdo", notes, "--extract", notes)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert notes in done.err
