"""`canalyze explain` of codes: what a number from a manual or a display is.

What it must not do: test how frames are explained.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from captures import TESTS
from conftest import Runner

from canalyze._core import explain, rules

CODES = {
    "06020000h": ("SDO abort code", "object does not exist"),
    "0x06040041": ("SDO abort code", "cannot be mapped"),
    "8130h": ("EMCY error code", "heartbeat"),
    "emcy 2310": ("EMCY error code", "current"),
    "1016h": ("object 1016h", "heartbeat time"),
    "1016h:01": ("object 1016h:01", "heartbeat time"),
    "0x1F80": ("object 1F80h", ""),
    "register 11": ("generic error", "communication error"),
    "register 00": ("error register", "no error"),
    "statusword 0218": ("statusword 0218h", "fault"),
    "statusword FFFF": ("statusword FFFFh", "no state"),
    "controlword 000F": ("controlword 000Fh", "enable operation"),
    "state 7F": ("NMT state 7Fh", "Pre-operational"),
    "182": ("COB-ID 182h", "node 2"),
    "70Ah": ("COB-ID 70Ah", "node 10"),
    "000": ("COB-ID 000h", "NMT"),
    "node-silent": ("node-silent", "impact A", "usual cause", "ended when", "HBT002", "CiA 301 7.2.8.3.2.2"),
    "rpdo-timeout": ("impact A", "140xh:05"),
    "inhibit-time": ("PDO004", "impact C", "100 µs"),
    "heartbeat consumer time": ("1016h", "usual mistakes", "CiA 301 7.2.8.3.2.2, 7.5.2.19"),
    "SYNC window": ("1007h", "synchronous PDOs"),
    "toggle bit": ("05030000h",),
    "life guarding": ("100Ch",),
    "Node-Guarding": ("remote frame",),
    "block transfer": ("CRC",),
    "event timer": ("180xh:05",),
    "COB-ID": ("bit 31",),
    "lss": ("7E5h",),
    "rpdo": ("140xh",),
    "tpdo": ("180xh",),
    "mpdo": ("8230h",),
    "srdo": ("SRVT",),
    "1017h": ("producer heartbeat time", "CiA 301 7.5.2.20", "turns it off"),
    "1018h:04": ("serial number", "UNSIGNED32"),
}


@pytest.mark.parametrize("code", CODES)
def test_a_code_is_explained_in_both_languages(code: str) -> None:
    said = explain(code, "en")
    assert said is not None
    for part in CODES[code]:
        assert part.lower() in said.lower()
    assert explain(code, "zh") not in (None, said)


@pytest.mark.parametrize("index", ["1000h", "1016h", "1800h", "0x1F80"])
def test_an_object_of_the_communication_area_is_not_told_as_a_generic_error(index: str) -> None:
    said, asked = explain(index, "en"), explain(f"emcy {index}", "en")
    assert said is not None and said.startswith("object") and "EMCY error code" not in said
    assert asked is not None and asked.startswith("EMCY error code") and "object" not in asked


def test_what_no_object_has_is_an_error_code() -> None:
    for code in ("1E00h", "3100h"):
        said = explain(code, "en")
        assert said is not None and said.startswith("EMCY error code")


def test_every_rule_is_explained() -> None:
    for rule in rules("en"):
        for name in (rule.code, rule.code.lower()):
            said = explain(name, "en")
            assert said is not None and rule.meaning in said and rule.cause in said


@pytest.mark.parametrize(
    "text", ["", "foo", "register", "emcy zz", "statusword 12345", "register 111", "800:1:2", "1FFFFFFFF"]
)
def test_what_is_no_code(text: str) -> None:
    assert explain(text, "en") is None


def test_terms_are_found_in_both_languages() -> None:
    assert explain("同步窗口", "zh") == explain("sync window", "zh")
    assert explain("synchronous window length", "en") == explain("同步窗口长度", "en")


def test_devices_are_described(canalyze: Runner, tmp_path: Path) -> None:
    shutil.copy(TESTS.parent / "eds" / "drive.eds", tmp_path / "drive.eds")
    of_node = canalyze("explain", "--lang", "en", "--eds", "5=drive.eds", "2000h:00", "185", "1014h")
    assert of_node.code == 0
    assert "drive.eds, node 5: 2000h:00 Motor temperature, INTEGER16, ro" in of_node.out
    assert "node 5: TPDO1: 6041h:00 Statusword" in of_node.out
    assert "default 00000085h (133)" in of_node.out
    assert canalyze("explain", "2000h:00").code == 2, "no standard knows it"
    of_any = canalyze("explain", "--lang", "en", "--eds", "drive.eds", "186", "1014h")
    assert "TPDO1, where the node-ID is 6: 6041h:00 Statusword" in of_any.out
    assert "default $NODEID+00000080h" in of_any.out


def test_a_frame_is_read_by_its_device(canalyze: Runner, tmp_path: Path) -> None:
    shutil.copy(TESTS.parent / "eds" / "drive.eds", tmp_path / "drive.eds")
    described = canalyze("explain", "--lang", "en", "--eds", "5=drive.eds", "185#3702")
    assert "statusword=0237h operation enabled" in described.out
    assert "statusword" not in canalyze("explain", "--lang", "en", "185#3702").out
    assert "statusword" not in canalyze("explain", "--lang", "en", "--eds", "drive.eds", "185#3702").out
    missing = canalyze("explain", "--eds", "no.eds", "185")
    assert missing.code == 2 and "no.eds" in missing.err


def test_several_codes(canalyze: Runner) -> None:
    done = canalyze("explain", "--lang", "en", "06020000h", "8130h", "register 11")
    assert done.code == 0
    assert "object does not exist" in done.out and "communication error" in done.out
    assert canalyze("explain", "--lang", "en", "sync", "window").out.startswith("SYNC window")
    mixed = canalyze("explain", "--lang", "en", "8130h", "foo")
    assert mixed.code == 2 and "EMCY" in mixed.out and "foo" in mixed.err
    behind = canalyze("explain", "--lang", "en", "70A#05", "foo", "182")
    assert behind.code == 2 and "heartbeat" in behind.out and "TPDO1" in behind.out and "foo" in behind.err
    copied = canalyze("explain", "(1.0)", "can0", "70A#05", "# heartbeat")
    assert (copied.code, copied.err) == (0, "")
    assert canalyze("explain", "--lang", "en", "emcy", "8130").out.startswith("EMCY error code")
    assert "node 10" in canalyze("explain", "--lang", "en", "-", stdin=b"70A\n").out


ROWS = [
    "60A 40 08 10 00 00 00 00 00",
    "60A 8 40 08 10 00 00 00 00 00",
    "1,60A,8,40,08,10,00,00,00,00,00",
    "t60A84008100000000000",
    "12.5 ms  Rx  0x60A  8  40 08 10 00 00 00 00 00",
]


@pytest.mark.parametrize("row", ROWS)
def test_a_row_of_a_listing_is_explained_as_a_frame(row: str) -> None:
    said = explain(row, "en")
    assert said is not None
    assert "read 1008h:00" in said


@pytest.mark.parametrize("words", ["182 185", "6040h 0006", "1017 0", "hello world 12", "60A 8 40 08 10"])
def test_what_is_no_row_is_not_guessed(words: str) -> None:
    assert explain(words, "en") is None
