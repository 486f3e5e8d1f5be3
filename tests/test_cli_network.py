"""--eds, --cob, --sdo and canalyze.toml as a user gives them, and `canalyze signals`."""

from __future__ import annotations

import csv
import io
import json
import re
from pathlib import Path

import pytest
from conftest import NOTES, Runner
from test_cli_help import CHINESE
from test_network_known import DCF

OWN = Path(__file__).parent.parent / "eds"
DRIVE = str(OWN / "drive.eds")
IO = str(OWN / "io.eds")
HEADING = "t,frame,bus,node,pdo,signal,value,raw,unit,provenance,object"
CAPTURE = """\
(1.000000) can0 385#37022A000000
(1.001000) can0 1A5#3702
(1.002000) can1 485#3702F6FFFFFF0500
(1.003000) can0 182#0102
"""
"""TPDO3 of node 5 (drive), something on 1A5h, TPDO4 of node 5 on another bus, TPDO1 of node 2 (I/O)."""


@pytest.fixture
def capture(tmp_path: Path) -> str:
    (tmp_path / "pdo.log").write_text(CAPTURE)
    return "pdo.log"


def values(text: str) -> dict[tuple[str, str, str, str], str]:
    """Give the values of a CSV by bus, node, PDO and signal."""
    return {
        (row["bus"], row["node"], row["pdo"], row["signal"]): row["value"] for row in csv.DictReader(io.StringIO(text))
    }


@pytest.mark.parametrize("name", ["decode", "sdo", "signals"])
@pytest.mark.parametrize(
    ("option", "value", "zh", "en"),
    [
        ("--eds", "5x=drive.eds", "5=drive.eds、1-4,7=io.eds", "write it as 5=drive.eds, 1-4,7=io.eds"),
        ("--eds", "128=drive.eds", "节点ID应为1到127", "node-IDs are 1 to 127"),
        ("--eds", "", '选项 --eds ""', '""'),
        ("--cob", "1A5=5", "1A5=5.TPDO1", "1A5=5.TPDO1"),
        ("--cob", "8FF=5.TPDO1", "ID为十六进制", "IDs are hexadecimal"),
        ("--sdo", "640=5", "640,5C0=5", "640,5C0=5"),
        ("--sync-period", "0", "大于0", "above 0"),
        ("--sync-window", "1h", "10ms", "10ms"),
        ("--jitter", "-1", "200（微秒）", "200 (microseconds)"),
    ],
)
def test_value_that_cannot_be(canalyze: Runner, name: str, option: str, value: str, zh: str, en: str) -> None:
    for lang, said in (("zh", zh), ("en", en)):
        done = canalyze("--lang", lang, name, f"{option}={value}", "x.log")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert f" {option}" in done.err and said in done.err and f"canalyze {name} --help" in done.err
        if lang == "en":
            assert not CHINESE.search(done.err)


@pytest.mark.parametrize("name", ["decode", "sdo", "signals"])
@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("5=missing.eds", "missing.eds"),
        ("5=notes.log", "notes.log"),
        ("5=.", "."),
        ("5=broken.xdd", "broken.xdd:1"),
        (DRIVE, "--eds 5="),
        (f"5={DRIVE}\n5={IO}", "io.eds"),
    ],
)
def test_description_that_cannot_be_used(
    canalyze: Runner, notes: str, tmp_path: Path, name: str, lang: str, value: str, said: str
) -> None:
    (tmp_path / "broken.xdd").write_text("<?xml version='1.0'?><ISO15745ProfileContainer>")
    options = [part for one in value.split("\n") for part in ("--eds", one)]
    done = canalyze("--lang", lang, name, *options, notes, "-o", "out")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert said in done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_configuration_that_cannot_be_is_one_line(canalyze: Runner, tmp_path: Path, notes: str, lang: str) -> None:
    (tmp_path / "canalyze.toml").write_text('[[eds]]\nfile = "a.eds"\nnode = 128\n')
    done = canalyze("--lang", lang, "decode", notes)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "canalyze.toml:3" in done.err and "eds.node" in done.err and "128" in done.err


def test_descriptions_of_the_configuration_are_read_by_captures_only(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "canalyze.toml").write_text('[[eds]]\nfile = "missing.eds"\nnode = 5\n')
    assert canalyze("rules").code == 0
    done = canalyze("decode", stdin=NOTES.encode())
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "missing.eds" in done.err


@pytest.mark.parametrize("name", ["decode", "sdo", "signals"])
def test_help_shows_the_options(canalyze: Runner, name: str) -> None:
    for lang in ("zh", "en"):
        page = canalyze(name, "--help", "--lang", lang).out
        for option in ("--eds [[BUS:]NODE=]FILE", "--cob [BUS:]ID=NODE.PDO", "--sdo [BUS:]ID,ID=NODE"):
            assert option in page
        for option in (
            "--sync-period US",
            "--sync-window US",
            "--jitter US",
            "1-4,7=io.eds",
            "1A5=5.TPDO1",
            "640,5C0=5",
        ):
            assert option in page


# From here on end to end: what the core makes of it.


def test_decode_names_signals(canalyze: Runner, capture: str) -> None:
    done = canalyze("--lang", "en", "decode", "--eds", f"5={DRIVE}", capture)
    assert (done.code, done.err) == (0, "")
    assert "position actual value" in done.lines[0] and "42" in done.lines[0]
    assert "velocity actual value" in done.lines[2] and "-10" in done.lines[2]
    assert "position actual value" not in canalyze("--lang", "en", "decode", capture).out


def test_signals_as_csv(canalyze: Runner, capture: str) -> None:
    done = canalyze("signals", "--eds", f"5={DRIVE}", "--eds", f"2={IO}", capture)
    assert (done.code, done.err) == (0, "")
    assert done.lines[0] == HEADING
    assert values(done.out) == {
        ("can0", "5", "TPDO3", "statusword"): "567",
        ("can0", "5", "TPDO3", "position actual value"): "42",
        ("can1", "5", "TPDO4", "statusword"): "567",
        ("can1", "5", "TPDO4", "velocity actual value"): "-10",
        ("can1", "5", "TPDO4", "torque actual value"): "0.5",
        ("can0", "2", "TPDO1", "Inputs 1 to 8"): "1",
        ("can0", "2", "TPDO1", "Inputs 9 to 16"): "2",
    }


def test_signals_as_jsonl(canalyze: Runner, capture: str) -> None:
    done = canalyze("signals", "--format", "jsonl", "--eds", f"5={DRIVE}", capture)
    assert (done.code, done.err) == (0, "")
    rows = [json.loads(line) for line in done.lines]
    assert len(rows) == 5
    for row in rows:
        assert set(HEADING.split(",")) - {"object"} | {"index", "sub"} <= set(row)
    assert {row["provenance"] for row in rows} == {"eds"} or all("eds" in str(row["provenance"]) for row in rows)


def test_signals_selected(canalyze: Runner, capture: str) -> None:
    done = canalyze("signals", "--eds", f"5={DRIVE}", "--eds", f"2={IO}", "--select", "2.*,*Velocity*", capture)
    assert done.code == 0
    assert {signal for _, _, _, signal in values(done.out)} == {
        "Inputs 1 to 8",
        "Inputs 9 to 16",
        "velocity actual value",
    }


def test_description_of_one_bus(canalyze: Runner, capture: str) -> None:
    done = canalyze("signals", "--eds", f"can1:5={DRIVE}", capture)
    assert {bus for bus, _, _, _ in values(done.out)} == {"can1"}


def test_cob_says_whose_identifier_it_is(canalyze: Runner, capture: str) -> None:
    done = canalyze("signals", "--eds", f"5={DRIVE}", "--cob", "1A5=5.TPDO1", capture)
    assert values(done.out)["can0", "5", "TPDO1", "statusword"] == "567"


def test_sdo_says_whose_channel_it_is(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "other.log").write_text(NOTES.replace("60A", "640").replace("58A", "5C0"))
    done = canalyze("sdo", "--format", "jsonl", "--sdo", "640,5C0=5", "other.log")
    (transfer,) = [json.loads(line) for line in done.lines]
    assert (transfer["node"], transfer["value"]) == (5, "Zephyr RTOS/CANopenNode")


def test_canalyze_toml_and_what_overrules_it(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    (tmp_path / "net").mkdir()
    (tmp_path / "net" / "drive.eds").write_bytes(Path(DRIVE).read_bytes())
    (tmp_path / "net" / "canalyze.toml").write_text(
        '[[eds]]\nnode = 5\nfile = "drive.eds"\n[[cob]]\nid = "1A5"\nnode = 5\npdo = "TPDO1"\n'
    )
    done = canalyze("--config", "net/canalyze.toml", "signals", capture)
    assert (done.code, done.err) == (0, "")
    assert {pdo for _, _, pdo, _ in values(done.out)} == {"TPDO1", "TPDO3", "TPDO4"}
    done = canalyze("--config", "net/canalyze.toml", "signals", "--eds", f"5={IO}", capture)
    assert not {signal for *_, signal in values(done.out)} & {"状态字", "position actual value"}


def test_dcf_names_its_node_and_is_said_of_another(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    (tmp_path / "five.dcf").write_text(DCF)
    assert canalyze("--lang", "en", "decode", "--eds", "five.dcf", capture).code == 0
    done = canalyze("--lang", "en", "decode", "--eds", "6=five.dcf", capture)
    assert done.code == 0
    (line,) = [line for line in done.complaints if "node 5" in line]
    assert "used for 6" in line


def test_defects_are_one_line(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    text = Path(DRIVE).read_text() + "\n" + "no equals\n" * 30
    (tmp_path / "odd.eds").write_text(text)
    for lang, said in (("zh", "未采用30处"), ("en", "30 entries not used")):
        done = canalyze("--lang", lang, "decode", "--eds", "5=odd.eds", capture)
        assert (done.code, len(done.complaints)) == (0, 1)
        assert said in done.err and "canalyze eds odd.eds" in done.err


@pytest.mark.parametrize("form", ["csv", "jsonl"])
def test_nothing_decoded_is_said(canalyze: Runner, capture: str, form: str) -> None:
    for lang in ("zh", "en"):
        done = canalyze("--lang", lang, "signals", "--format", form, capture)
        assert (done.code, len(done.complaints)) == (0, 1)
        assert "--eds 5=drive.eds" in done.err and "4" in done.err
        assert done.out in ("", HEADING + "\n")
        done = canalyze("--lang", lang, "signals", "--eds", f"5={DRIVE}", "--select", "xyz", "--format", form, capture)
        assert (done.code, len(done.complaints)) == (0, 1)
        assert re.search(r"--select\b", done.err)


def test_nothing_readable_says_only_that(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "prose.txt").write_text("no frame here\n")
    done = canalyze("signals", "prose.txt", "-o", "out.csv")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert not (tmp_path / "out.csv").exists()


def test_signals_write_a_file(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    done = canalyze("signals", "--eds", f"5={DRIVE}", capture, "-o", "out.csv")
    assert (done.code, done.out, done.err) == (0, "", "")
    assert (tmp_path / "out.csv").read_text(encoding="utf-8").startswith(HEADING + "\n")


def test_what_is_known_of_a_network_loads_no_library(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    import subprocess
    import sys

    from conftest import environment

    for more in (["--cob", "1A5=5.TPDO1", "--sync-period", "10ms"], ["--eds", f"5={DRIVE}"]):
        done = subprocess.run(
            [sys.executable, "-X", "importtime", "-m", "canalyze", "decode", *more, capture],
            capture_output=True,
            cwd=tmp_path,
            env=environment(),
            check=True,
        )
        loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.decode().splitlines()}
        assert not {"canopen", "can"} & loaded


def test_a_node_that_is_not_there_is_said(canalyze: Runner, capture: str) -> None:
    done = canalyze("--lang", "en", "decode", "--eds", f"5,30-32={DRIVE}", capture)
    assert (done.code, done.complaints) == (0, [f"{DRIVE}: no frames of nodes 30-32 in the capture"])
    done = canalyze("decode", "--eds", f"can9:5={DRIVE}", capture)
    assert done.complaints == [f"{DRIVE}: 记录中没有节点5的帧"]


MULTIPLEX = """\
(1.000000) can0 604#2F001A00FF000000
(1.001000) can0 584#60001A0000000000
(1.002000) can0 184#857A600039300000
(1.003000) can0 184#050020002A00EEEE
(1.004000) can0 184#890020012A000000
"""
"""Node 4's TPDO1 becomes a multiplex one: it writes 607Ah of node 5, shows its 2000h, and writes to node 9."""


def test_multiplex_pdo_by_the_description_of_the_addressed_node(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "mpdo.log").write_text(MULTIPLEX)
    known = ("--eds", f"5={DRIVE}", "mpdo.log")
    lines = canalyze("decode", *known).lines[2:]
    assert [line.split("  # ")[1] for line in lines if "  # " in line][:3] == [
        "节点4的TPDO1: DAM-MPDO, 写节点5的607Ah:00 目标位置 = 12345",
        "节点4的TPDO1: SAM-MPDO, 生产者节点5的2000h:00 Motor temperature = 4.2 degC",
        "节点4的TPDO1: DAM-MPDO, 写节点9的2000h:01 = 2A 00 00 00 (42)",
    ]
    assert "write to node 5: 607Ah:00 target position = 12345" in canalyze("--lang", "en", "decode", *known).out

    done = canalyze("signals", *known)
    assert done.lines == [
        HEADING,
        "1.002000,3,can0,4,TPDO1,target position,12345,12345,,observed,607A:00",
        "1.003000,4,can0,4,TPDO1,Motor temperature,4.2,42,degC,observed,2000:00",
        "1.004000,5,can0,4,TPDO1,2000h:01,42,42,,observed,2000:01",
    ]
    chosen = canalyze("signals", "--select", "4.TPDO1.*position,2000:01", "--format", "jsonl", *known)
    assert [json.loads(line)["index"] for line in chosen.lines] == ["607A", "2000"]

    rows = [json.loads(line) for line in canalyze("decode", "--format", "jsonl", *known).lines]
    found = [row["pdo"]["mpdo"] for row in rows if row["kind"] == "frame" and row["service"] == "pdo"]
    assert [(one["name"], one["type"], one["value"], one["unit"], one["text"]) for one in found] == [
        ("target position", "INTEGER32", 12345, None, "12345"),
        ("Motor temperature", "INTEGER16", 4.2, "degC", "4.2 degC"),
        (None, None, None, None, None),
    ]
