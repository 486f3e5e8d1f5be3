"""`canalyze sdo`: the table, JSON lines, and the data as files."""

import json
from pathlib import Path

import pytest
from conftest import NOTES, Runner

from canalyze.records import of_rows
from canalyze.records.transfers import Transfer
from canalyze.reports.sdo import row
from canalyze.words import Words


def transfer(**fields: object) -> Transfer:
    """A transfer as the core writes it."""
    given: dict[str, object] = {
        "kind": "transfer",
        "transfer": 3,
        "bus": "can0",
        "node": 5,
        "client": None,
        "session": None,
        "direction": "upload",
        "mode": "expedited",
        "index": "2000",
        "sub": 1,
        "name": None,
        "type": None,
        "size_indicated": None,
        "size": 0,
        "data": "",
        "value": None,
        "text": "",
        "status": "aborted",
        "abort": None,
        "first_frame": 7,
        "last_frame": 9,
        "t": "1.5",
        "duration": None,
        "reordered": False,
        "retransmissions": 0,
        "crc_negotiated": None,
        "findings": [],
    }
    return of_rows([given | fields], Transfer)[0]


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
    from canalyze.output.layout import width

    heading, row = canalyze("sdo", notes).lines
    assert width(heading[: heading.index("对象")]) == width(row[: row.index("1008h:00")])
    assert "上传" in row and "分段" in row and "完成" in row


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_nothing_is_shown_as_nothing(lang: str) -> None:
    """What an aborted transfer did not bring is no empty value; a stamp has the digits of the capture."""
    cells, order = row(transfer(), Words(lang))
    assert cells.count("-") == 4  # name, value, duration, findings
    assert "" not in cells and "1.5" in cells
    assert order == 7
    assert ("加速" if lang == "zh" else "expedited") in cells


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"abort": {"code": "06020000", "by": "server", "text": None}}, "aborted (server) 06020000h"),
        ({"abort": {"code": "05", "by": "client", "text": "x"}, "client": 9}, "aborted (client) 05h x"),
    ],
)
def test_an_abort_has_the_digits_of_its_service(fields: dict[str, object], said: str) -> None:
    cells, _ = row(transfer(**fields), Words("en"))
    assert said in cells


def test_rows_stand_in_order_of_their_first_frame(canalyze: Runner, tmp_path: Path) -> None:
    frames = NOTES.splitlines(keepends=True)
    other = "can1  602   [8]  40 00 10 00 00 00 00 00\ncan1  582   [8]  43 00 10 00 92 01 02 00\n"
    (tmp_path / "two.log").write_text("".join(frames[:4]) + other + "".join(frames[4:]))
    assert [json.loads(line)["first_frame"] for line in canalyze("sdo", "--format", "jsonl", "two.log").lines] == [5, 1]
    rows = canalyze("sdo", "two.log").lines[1:]
    assert [line.split()[-1] for line in rows] == ["1-12", "5-6"]


def test_pipe_cuts_nothing(canalyze: Runner) -> None:
    samples = Path(__file__).parent.parent / "samples"
    for lang in ("zh", "en"):
        for args in (
            ["rules"],
            ["sdo", str(samples / "sdo-abort.log")],
            ["sdo", str(samples / "string-100-bytes.log")],
        ):
            done = canalyze("--lang", lang, *args)
            assert done.code == 0
            assert "…" not in done.out
    rules = [json.loads(line) for line in canalyze("--lang", "en", "rules", "--format", "jsonl").lines]
    listed = canalyze("--lang", "en", "rules").out
    assert all(rule["message"] in listed for rule in rules)


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
    assert "1 file written to out/deep" in done.err
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
    file, holes = sorted((tmp_path / "out").iterdir())
    assert file.suffix == ".incomplete" and holes.name == f"{file.name}.holes.json"
    assert b"Zephyr RTOS/CANopenNode".startswith(file.read_bytes()[:7])


def test_extract_of_nothing_readable_says_only_that(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "prose.txt").write_text("no frame here\n")
    for name in ("prose.txt", "nowhere.log"):
        done = canalyze("sdo", name, "--extract", "out")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert name in done.err


def test_extract_into_a_file_is_one_line(canalyze: Runner, notes: str) -> None:
    done = canalyze("sdo", notes, "--extract", notes)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert notes in done.err
