"""`canalyze od`: the objects of each node as a table, JSON lines and CSV, at a time, and all of their values."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from captures import EDS, SAMPLES, run_canalyze
from conftest import Runner

import canalyze as library

NETWORK = SAMPLES / "network/sync-and-pdos.log"

NAME = "Drive <M1>"
SEGMENTS = NAME.encode().ljust(14, b"\0")
CAPTURE = f"""\
(1.000000) can0 705#00
(1.010000) can0 605#4000100000000000
(1.011000) can0 585#4300100092010200
(1.020000) can0 605#4018100100000000
(1.021000) can0 585#431810014D030000
(1.030000) can0 605#4008100000000000
(1.031000) can0 585#410810000E000000
(1.032000) can0 605#6000000000000000
(1.033000) can0 585#00{SEGMENTS[:7].hex()}
(1.034000) can0 605#7000000000000000
(1.035000) can0 585#11{SEGMENTS[7:].hex()}
(1.100000) can0 605#2B171000F4010000
(1.101000) can0 585#6017100000000000
(1.110000) can0 605#2300180185010000
(1.111000) can0 585#6000180100000000
(1.200000) can0 605#2F00200001000000
(1.201000) can0 585#8000200002000106
(1.210000) can0 605#2F00200001000000
(1.211000) can0 585#8000200002000106
(1.220000) can0 605#4000200000000000
(1.221000) can0 585#4F00200007000000
(1.230000) can0 605#4001200000000000
(1.231000) can0 585#8001200000000206
(1.300000) can0 605#4B02200000000000
(1.310000) can0 605#4003200000000000
(1.311000) can0 585#4B032000FEFF0000
(1.320000) can0 605#4003200000000000
(1.321000) can0 585#4B03200003000000
(1.330000) can0 085#0081110000000000
(2.000000) can0 000#8105
(2.010000) can0 705#00
(2.500000) can0 605#2F04200009000000
"""
"""A device that is read, written, refuses, is reset, and is written once more without an answer."""


@pytest.fixture
def log(tmp_path: Path) -> str:
    """Give the name of the capture."""
    (tmp_path / "device.log").write_text(CAPTURE)
    return "device.log"


def rows(canalyze: Runner, *args: str) -> dict[str, dict[str, Any]]:
    """Give the objects by index and sub-index."""
    done = canalyze("--lang", "en", "od", "--format", "jsonl", *args)
    assert (done.code, done.err) == (0, "")
    found = [json.loads(line) for line in done.lines]
    return {f"{one['index']}:{one['sub']:02X}": one for one in found if one["kind"] == "od_object"}


def test_a_node_is_named_by_what_it_says(canalyze: Runner, log: str) -> None:
    node = json.loads(canalyze("od", "--format", "jsonl", log).lines[0])
    assert node["kind"] == "od_node"
    assert (node["device_type"], node["profile"], node["vendor_id"]) == ("00020192", 402, "0000034D")
    assert (node["product_code"], node["serial"], node["device_name"]) == (None, None, NAME)
    heading = canalyze("--lang", "en", "od", log).out.split("\n\n")[0]
    for said in ("node 5 on can0: 11 objects", "00020192h (CiA 402)", "0000034Dh"):
        assert said in heading
    assert "product code" not in heading


def test_where_from_and_access(canalyze: Runner, log: str) -> None:
    found = rows(canalyze, log)
    heartbeat, refused, absent = found["1017:00"], found["2000:00"], found["2001:00"]
    assert (heartbeat["written"], heartbeat["access"], heartbeat["value"]) == (1, "w", 500)
    assert (refused["refused"], refused["read"], refused["access"], refused["value"]) == (2, 1, "ro", 7)
    assert [(one["request"], one["code"], one["count"]) for one in refused["aborts"]] == [("download", "06010002", 2)]
    assert (absent["exists"], absent["value"], absent["access"]) == (False, None, None)
    register = found["1001:00"]
    assert (register["emcy"], register["value"], register["access"]) == (1, 0x11, None)


def test_a_type_that_only_values_tell_is_marked(canalyze: Runner, log: str) -> None:
    found = rows(canalyze, log)
    one = found["2003:00"]
    assert (one["type"], one["type_from"], one["bits"], one["value"]) == ("INTEGER16", "inferred", 16, 3)
    assert (found["1017:00"]["type"], found["1017:00"]["type_from"]) == ("UNSIGNED16", "standard")
    for lang, said in (("en", "INTEGER16 (inferred)"), ("zh", "INTEGER16（推断）")):
        (line,) = (line for line in canalyze("--lang", lang, "od", log).lines if line.startswith("2003h:00"))
        assert said in line
        (line,) = (line for line in canalyze("--lang", lang, "od", log).lines if line.startswith("1017h:00"))
        assert said[9:] not in line


def test_a_write_without_an_answer_is_no_value(canalyze: Runner, log: str) -> None:
    one = rows(canalyze, log)["2004:00"]
    assert (one["unconfirmed"], one["value"], one["requested"], one["exists"]) == (1, None, 9, None)
    assert "requested 9, not confirmed" in canalyze("--lang", "en", "od", log).out


def test_what_a_reset_took_is_not_in_force(canalyze: Runner, log: str) -> None:
    before, after = rows(canalyze, log, "--at", "0.9"), rows(canalyze, log)
    assert before["1800:01"]["in_force"] == {"value": 0x185, "text": before["1800:01"]["text"], "from": "observed"}
    assert after["1800:01"]["in_force"] == {"value": None, "text": None, "from": None}
    assert after["1800:01"]["value"] == 0x185
    # What was read before any write is what the device comes up with.
    assert after["1018:01"]["in_force"]["value"] == 0x34D
    assert after["2003:00"]["in_force"] is None
    assert "in force" in canalyze("--lang", "en", "od", log).out
    assert "in force" not in canalyze("--lang", "en", "od", "--at", "0.9", log).out


def test_at_a_time_is_what_was_known_then(canalyze: Runner, log: str) -> None:
    found = rows(canalyze, log, "--at", "0.1005")
    # The write of 1017h has no answer yet; the capture goes on with one.
    assert (found["1017:00"]["written"], found["1017:00"]["unconfirmed"], found["1017:00"]["requested"]) == (0, 1, 500)
    assert set(found) == {"1000:00", "1018:01", "1008:00", "1017:00"}
    assert rows(canalyze, log, "--at", "0.101")["1017:00"]["written"] == 1
    assert rows(canalyze, log, "--at", "99") == rows(canalyze, log)
    done = canalyze("--lang", "en", "od", "--at", "soon", log)
    assert done.code == 2 and len(done.complaints) == 1 and "seconds" in done.err


def test_without_stamps_there_is_no_time(canalyze: Runner, notes: str) -> None:
    done = canalyze("--lang", "en", "od", "--at", "1", notes)
    assert done.code == 0 and "no timestamps in the capture" in done.err
    assert done.out == canalyze("--lang", "en", "od", notes).out
    assert "timestamps" not in canalyze("--lang", "en", "od", notes).err


def test_history(canalyze: Runner, log: str) -> None:
    done = canalyze("--lang", "en", "od", "--history", "--format", "jsonl", log, "--filter", "object=2000-2003")
    found = [json.loads(line) for line in done.lines]
    assert [(one["index"], one["source"], one["value"], one["frame"]) for one in found[:4]] == [
        ("2000", "refused", 1, 17),
        ("2000", "refused", 1, 19),
        ("2000", "read", 7, 21),
        ("2001", "refused", None, 23),
    ]
    assert [one["data"] for one in found if one["index"] == "2003"] == ["FEFF", "0300"]
    table = canalyze("--lang", "en", "od", "--history", log)
    assert table.lines[0].split()[:4] == ["time", "bus", "node", "object"]
    assert sum("2000h:00" in line for line in table.lines) == 3
    assert "06010002h attempt to write a read-only object" in table.out


def test_csv_is_the_same_in_every_language(canalyze: Runner, log: str) -> None:
    for more in ([], ["--history"]):
        both = [canalyze("--lang", lang, "od", log, "--format", "csv", *more).out for lang in ("zh", "en")]
        assert both[0] == both[1]
        found = list(csv.DictReader(both[0].splitlines()))
        assert all(None not in one and None not in one.values() for one in found)
    by_object = {one["object"]: one for one in csv.DictReader(canalyze("od", log, "--format", "csv").out.splitlines())}
    assert by_object["2000:00"]["aborts"] == "download:06010002:2"
    assert (by_object["1800:01"]["in_force"], by_object["1800:01"]["in_force_from"]) == ("", "unknown")


def test_a_filter_takes_nodes_and_objects(canalyze: Runner) -> None:
    """A PDO that carries an object that is asked for carries others, too: these are not shown."""
    given = [f"--eds=5={EDS / 'drive.eds'}", str(NETWORK)]
    found = rows(canalyze, "--filter", "node=5 object=6041", *given)
    assert set(found) == {"6041:00"}
    assert found["6041:00"] == rows(canalyze, *given)["6041:00"]
    assert {one["node"] for one in rows(canalyze, "--filter", "node=6,7", *given).values()} == {6, 7}


def test_nothing_is_said(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "heartbeat.log").write_text("can1  70A   [1]  05\n")
    for more in ([], ["--history"], ["--format", "csv"]):
        done = canalyze("--lang", "en", "od", "heartbeat.log", *more)
        assert (done.code, done.out) == (0, "")
        assert "no objects in 1 frame" in done.err


def test_pdos_without_objects_are_no_objects(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "pdos.log").write_text("(1.0) can1 18A#0102\n(1.1) can1 18A#01\n")
    done = canalyze("--lang", "en", "od", "pdos.log")
    assert (done.code, done.out) == (0, "") and "no objects in 2 frames" in done.err
    done = canalyze("--lang", "en", "od", "pdos.log", "--format", "jsonl")
    (pdo,) = map(json.loads, done.lines)
    assert (pdo["kind"], pdo["node"], pdo["pdo"], pdo["id"], pdo["frames"]) == ("od_pdo", 10, "TPDO1", "18A", 2)
    assert (pdo["length_min"], pdo["length_max"]) == (1, 2) and "no objects in 2 frames" in done.err


def test_a_pipe_is_read_to_its_end(canalyze: Runner, log: str) -> None:
    for more in ([], ["--history"]):
        piped = canalyze("--lang", "en", "od", "-", *more, stdin=CAPTURE.encode())
        assert piped.out == canalyze("--lang", "en", "od", log, *more).out


def test_a_mapping_that_only_a_consumer_has_shows_the_consumers_objects(canalyze: Runner, tmp_path: Path) -> None:
    """TPDO1 of node 5, of which nothing is known, is RPDO1 of node 6, whose mapping is written."""
    lines = ["2300140185010080", "2F00160000000000", "2300160108000062", "2F00160001000000", "2300140185010000"]
    text, at = "(1.000000) can0 706#00\n", 1.0
    for line in lines:
        at += 0.01
        text += f"({at:.6f}) can0 606#{line}\n({at + 0.001:.6f}) can0 586#60{line[2:8]}00000000\n"
    text += f"({at + 0.1:.6f}) can0 185#2A\n"
    (tmp_path / "consumer.log").write_text(text)
    one = rows(canalyze, "consumer.log")["6200:00"]
    assert (one["node"], one["rpdo"], one["tpdo"], one["value"], one["access"]) == (6, 1, 0, 42, "w")


def test_the_table_of_columns_is_the_same() -> None:
    given = {5: EDS / "drive.eds", 6: EDS / "io.eds", 7: EDS / "encoder.eds"}
    options = [f"--eds={node}={path}" for node, path in given.items()]
    said = run_canalyze(["od", NETWORK, "--format", "jsonl", "--lang", "en", *options]).splitlines()
    records = [one for one in map(json.loads, said) if one["kind"] == "od_object"]
    with library.open(NETWORK, eds=given) as capture:
        table = capture.tables("od")["od"].to_pandas().to_dict("records")
    assert len(table) == len(records) > 40
    for row, record in zip(table, records, strict=True):
        assert f"{row['index']:04X}" == record["index"]
        alike = (
            *("bus", "node", "sub", "name", "type", "type_from", "access", "exists", "text", "source", "frame", "bits"),
            *("values", "read", "written", "tpdo", "rpdo", "emcy", "refused", "unconfirmed", "first_frame"),
        )
        assert {key: row[key] for key in alike} == {key: record[key] for key in alike}
        assert row["data"].hex().upper() == record["data"]
        held = record["in_force"]
        assert (row["in_force_from"] if held else None) == (held and held["from"])
    scaled = next(row for row in table if (row["node"], row["index"]) == (5, 0x6077))
    assert (scaled["value"], scaled["text"]) == (-3.1, "-3.1 %")
