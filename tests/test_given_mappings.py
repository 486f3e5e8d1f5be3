"""`--pdo` and `--profile`: PDOs of nodes without a description, and the profile that mappings show.

What it must not do: test how values are written.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from captures import SAMPLES, Row
from conftest import Runner

from canalyze.configuration import network

DRIVE = "(1.0) can0 185#3700\n(1.1) can0 385#370000010000\n(1.2) can0 405#0F0010000000\n"
IO = "(1.0) can0 186#0102030405060708\n(1.1) can0 286#0100FFFF03000400\n"


@pytest.mark.parametrize(
    ("text", "pdo", "entries"),
    [
        (
            "181=6041:16,6064:32",
            (None, 1, "tpdo", 1),
            ((0x1A00, 0, 2), (0x1A00, 1, 0x60410010), (0x1A00, 2, 0x60640020)),
        ),
        ("5.RPDO3=6040:16", (None, 5, "rpdo", 3), ((0x1602, 0, 1), (0x1602, 1, 0x60400010))),
        (
            "can1:501=6401:01:16,0005:8",
            ("can1", 1, "rpdo", 4),
            ((0x1603, 0, 2), (0x1603, 1, 0x64010110), (0x1603, 2, 0x00050008)),
        ),
        ("5.TPDO512=2000:1:1", (None, 5, "tpdo", 512), ((0x1BFF, 0, 1), (0x1BFF, 1, 0x20000101))),
    ],
)
def test_what_a_pdo_carries_is_read(text: str, pdo: tuple[object, ...], entries: tuple[object, ...]) -> None:
    assert network.pdo_mapping(text) == (*pdo, entries)


@pytest.mark.parametrize(
    "text",
    [
        *("", "181", "181=", "181=6041", "181=6041:0", "181=6041:65", "181=6041:16,", "=6041:16", "180=6041:16"),
        *("581=6041:16", "1A5.TPDO1=6041:16", "5.TPDO513=6041:16", "200.TPDO1=6041:16", "5.TPDO1=6064:32,6041:33"),
        *("00000181=6041:16", ":181=6041:16", "181=60411:16"),
    ],
)
def test_what_is_none_is_none(text: str) -> None:
    assert network.pdo_mapping(text) is None


@pytest.mark.parametrize("text", ["", "5", "5=", "5=400", "0=402", "5=0x192", "=402", ":5=402"])
def test_a_profile_that_is_none(text: str) -> None:
    assert network.profile(text) is None


def _signals(canalyze: Runner, *args: str) -> list[tuple[int, str, str, object, str]]:
    rows: list[Row] = [json.loads(line) for line in canalyze("signals", "--format", "jsonl", "a.log", *args).lines]
    return [
        (row["frame"], row["pdo"], f"{row['index']}:{row['sub']:02X}", row["value"], row["provenance"]) for row in rows
    ]


@pytest.mark.parametrize("profile", ["5=402", "can0:5=402", "1-9=402"])
def test_a_drive_without_a_description(canalyze: Runner, tmp_path: Path, profile: str) -> None:
    (tmp_path / "a.log").write_text(DRIVE)
    assert _signals(canalyze) == []
    assert _signals(canalyze, "--profile", profile) == [
        (1, "TPDO1", "6041:00", 0x37, "profile"),
        (2, "TPDO3", "6041:00", 0x37, "profile"),
        (2, "TPDO3", "6064:00", 256, "profile"),
        (3, "RPDO3", "6040:00", 15, "profile"),
        (3, "RPDO3", "607A:00", 16, "profile"),
    ]
    assert _signals(canalyze, "--profile", "can1:5=402") == [], "of another bus"
    assert "default mapping of the profile" in canalyze("--lang", "en", "decode", "a.log", "--profile", profile).out


def test_inputs_without_a_description(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(IO)
    rows = _signals(canalyze, "--profile", "6=401")
    assert [(row[2], row[3]) for row in rows[8:]] == [("6401:01", 1), ("6401:02", -1), ("6401:03", 3), ("6401:04", 4)]
    assert [row[3] for row in rows[:8]] == [1, 2, 3, 4, 5, 6, 7, 8]


def test_a_default_mapping_that_frames_contradict_is_not_used(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text("(1.0) can0 385#3700\n(1.1) can0 385#370000010000\n")
    assert [row[0] for row in _signals(canalyze, "--profile", "5=402")] == [2, 2]
    assert canalyze("check", "a.log", "--profile", "5=402").code == 0, "an assumption is no fault of the node"


def test_the_mapping_by_hand_is_the_users(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(DRIVE)
    rows = _signals(canalyze, "--pdo", "185=6041:16", "--pdo", "5.TPDO3=0006:16,6064:32")
    assert rows == [(1, "TPDO1", "6041:00", 0x37, "option"), (2, "TPDO3", "6064:00", 256, "option")]
    done = canalyze("--lang", "en", "check", "a.log", "--pdo", "385=6041:16,6064:32,6061:8")
    assert done.code == 1 and "PDO001" in done.out, "too short for what the user says"


def test_what_the_capture_shows_comes_first(canalyze: Runner, tmp_path: Path) -> None:
    written = ["2F001A0000000000", "23001A0120006460", "2F001A0001000000"]
    answers = ["60001A0000000000", "60001A0100000000", "60001A0000000000"]
    steps = "".join(
        f"(0.{n}0) can0 605#{request}\n(0.{n}1) can0 585#{answer}\n"
        for n, (request, answer) in enumerate(zip(written, answers, strict=True), 1)
    )
    (tmp_path / "a.log").write_text(steps + "(1.0) can0 185#00010000\n")
    for option in (("--profile", "5=402"), ("--pdo", "185=6041:16")):
        assert _signals(canalyze, *option) == [(7, "TPDO1", "6064:00", 256, "observed")]


def test_a_wrong_spelling_is_one_line(canalyze: Runner) -> None:
    for option, value in (("--pdo", "781=6041:16"), ("--pdo", "185=6041"), ("--profile", "5=403")):
        done = canalyze("--lang", "en", "decode", option, value, "a.log")
        assert done.code == 2 and len(done.complaints) == 1 and option in done.err


@pytest.mark.parametrize(
    ("mapped", "name"),
    [("6000:1:8", "read input 8-bit"), ("6401:1:16", "read analogue input"), ("6041:16", "statusword")],
)
def test_mappings_show_the_profile(canalyze: Runner, tmp_path: Path, mapped: str, name: str) -> None:
    """A node without a device type is what its PDOs carry."""
    (tmp_path / "a.log").write_text("(1.0) can0 185#3700\n")
    assert name in canalyze("--lang", "en", "decode", "a.log", "--pdo", f"185={mapped}").out


@pytest.mark.parametrize(
    ("object_", "value", "raised"),
    [
        ("1018:01", "77000000", False),
        ("1018:01", "78000000", True),
        ("1018:02", "78000000", False),
        ("1018:03", "05000200", False),
        ("1018:03", "FFFF0200", False),
        ("1018:03", "05000300", True),
        ("1000:00", "92010200", False),
    ],
)
def test_what_a_controller_expects(canalyze: Runner, tmp_path: Path, object_: str, value: str, raised: bool) -> None:
    """The vendor-ID exactly, the major number of the revision, and nothing where its description has no value."""
    index, _, sub = object_.partition(":")
    where = f"{index[2:]}{index[:2]}{sub}"
    lines = [f"(1.0) can0 604#40{where}00000000", f"(1.1) can0 584#43{where}{value}", ""]
    (tmp_path / "a.log").write_text("\n".join(lines))
    dcf = SAMPLES / "rules" / "EDS004-controller.dcf"
    found = canalyze("check", "a.log", "--eds", f"5={dcf}", "--format", "jsonl").out
    assert ("EDS004" in found) == raised
    other = canalyze("check", "a.log", "--eds", f"4={dcf}", "--format", "jsonl").out
    assert "controller" not in other, "a node expects nothing of itself"
