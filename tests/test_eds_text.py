"""Every repair of a device description's text, from its encoding to its numbers, and what it must say."""

from __future__ import annotations

import pytest
from eds_texts import LISTS, codes, default, load, name, variable

from canalyze.dictionary import read
from canalyze.dictionary.model import Dictionary, NodeOffset, Value


def encoded(text: str, encoding: str) -> Dictionary:
    data = (LISTS + f"[2000]\nParameterName={text}\nDataType=7\nAccessType=rw\n").encode(encoding)
    return read(data, "x.eds")


@pytest.mark.parametrize(
    ("encoding", "text"),
    [
        ("cp850", "Höhe in Köln"),
        ("cp850", "Überlastgröße für Öl"),
        ("cp850", "Temperatur in °C"),
        ("cp437", "Widerstand 10 Ω"),
        ("cp1252", "Höhe in Köln"),
        ("cp1252", "Größe der Änderung"),
        ("cp1252", "Durée de cycle à l’arrêt"),
        ("cp1252", "Automação, medição"),
        ("cp1252", "temperature 0.1 °C"),
        ("cp1252", "delay in µs"),
        ("cp1252", "Motor® \N{EN DASH} drive"),
        ("gb18030", "伺服驱动器"),
        ("gb18030", "位置 actual 值，单位：度"),
        ("gb18030", "EYOU伺服"),
        ("gb18030", "深圳市某某科技有限公司"),
    ],
)
def test_encoding_is_told_by_its_letters(encoding: str, text: str) -> None:
    found = encoded(text, encoding)
    assert name(found) == text
    assert found.encoding == encoding
    assert [(d.line, d.code, d.facts["encoding"]) for d in found.defects] == [(5, "encoding", encoding)]


def test_utf8_needs_no_repair() -> None:
    found = encoded("伺服 Größe", "utf-8")
    assert (name(found), found.encoding, found.defects) == ("伺服 Größe", "utf-8", ())


@pytest.mark.parametrize(("encoding", "more"), [("utf-8-sig", []), ("utf-16", [(5, "encoding")])])
def test_byte_order_mark(encoding: str, more: list[tuple[int, str]]) -> None:
    found = encoded("Größe", encoding)
    assert name(found) == "Größe"
    assert codes(found) == [(1, "bom"), *more]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\r\r\n"])
def test_line_ends(end: str) -> None:
    text = LISTS + "[2000]\nParameterName=x\nDataType=7\nAccessType=rw\nDefaultValue=No\n"
    found = read(text.replace("\n", end).encode(), "x.eds")
    assert codes(found) == [(8, "not-a-number")]


def test_mixed_line_ends_and_end_of_file_mark() -> None:
    found = load("[2000]\r\nParameterName=x\nDataType=7\r\nAccessType=rw\n\nDefaultValue=5\r\n\x1a")
    assert (default(found), found.defects) == (5, ())


def test_case_of_sections_and_keys() -> None:
    found = load("[2000]\nPARAMETERNAME=x\ndatatype=0X0007\nAccesstype=RW\nDEFAULTVALUE=0XfF\npdomapping=1\n")
    entry = found.entry(0x2000, 0)
    assert entry is not None
    assert (entry.name, entry.access, entry.default, entry.mappable, found.defects) == ("x", "rw", 255, True, ())


def test_indented_lines_and_blanks() -> None:
    found = load(
        "  [2000]  \n  ParameterName = x\n\tDataType =7\n  AccessType= rw \n ; a comment\n  DefaultValue = 3\n"
    )
    assert (name(found), default(found), found.defects) == ("x", 3, ())


def test_line_without_equals() -> None:
    found = load("[2000]\nParameterName=x\nDataType=7\nAccessType=rw\nthis is no key\nDefaultValue=1\n")
    assert (default(found), codes(found)) == (1, [(8, "no-equals")])


def test_line_before_any_section() -> None:
    found = read(b"FileName=x\n" + LISTS.encode() + b"[2000]\nParameterName=x\nDataType=7\nAccessType=rw\n", "x.eds")
    assert codes(found) == [(1, "no-section")]


def test_section_without_its_bracket() -> None:
    found = load("[2000\nParameterName=x\nDataType=7\nAccessType=rw\n")
    assert (name(found), codes(found)) == ("x", [(4, "section-bracket")])


def test_duplicate_key_the_later_counts() -> None:
    found = load("[2000]\nParameterName=x\nDataType=7\nAccessType=rw\nDefaultValue=1\nDefaultValue=2\n")
    assert (default(found), codes(found)) == (2, [(9, "duplicate-key")])
    facts = found.defects[0].facts
    assert (facts["first"], facts["used"], facts["other"]) == (8, "2", "1")


def test_duplicate_section_is_joined() -> None:
    found = load("[2000]\nParameterName=x\nDataType=7\n[2000]\nAccessType=ro\nDefaultValue=2\n")
    entry = found.entry(0x2000, 0)
    assert entry is not None
    assert (entry.name, entry.access, entry.default) == ("x", "ro", 2)
    assert codes(found) == [(7, "duplicate-section")]


def test_percent_and_semicolon_in_names() -> None:
    found = variable(ParameterName="Level 90 % of tank %(x)s ; spare # 2")
    assert (name(found), found.defects) == ("Level 90 % of tank %(x)s ; spare # 2", ())


def test_odd_section_names() -> None:
    found = load(
        "[0x2000]\nParameterName=x\nObjectType=9\nSubNumber=1\n"
        "[2000 SUB 1]\nParameterName=y\nDataType=5\nAccessType=rw\n"
    )
    assert (name(found, sub=1), codes(found)) == ("y", [(4, "section-name"), (8, "section-name")])


def test_section_names_that_cannot_be() -> None:
    found = load("[2000]\nParameterName=x\nDataType=7\nAccessType=rw\n[2000subXY]\nParameterName=y\n")
    assert codes(found) == [(8, "section-unused")]


def test_modules_are_said() -> None:
    found = load("[2000]\nParameterName=x\nDataType=7\nAccessType=rw\n[SupportedModules]\nNrOfEntries=2\n")
    assert codes(found) == [(8, "modules")]


@pytest.mark.parametrize(
    ("text", "value", "defects"),
    [
        ("0x3EF", 0x3EF, []),
        ("0X3ef", 0x3EF, []),
        ("1005", 1005, []),
        ("", None, []),
        ("001", 1, []),
        ("010", 8, ["octal"]),
        ("0777", 511, ["octal"]),
        ("089", 89, ["octal"]),
        ("0x3EF ; not yet", 0x3EF, ["trailing-comment"]),
        ("0x07 # VAR", 7, ["trailing-comment"]),
        ("12//twelve", 12, ["trailing-comment"]),
        ("No", None, ["not-a-number"]),
        ("1_000", None, ["not-a-number"]),
        ("1.5", None, ["not-a-number"]),
        ("0x", None, ["not-a-number"]),
        ("0x100000000", None, ["out-of-range"]),
        ("-1", 0xFFFFFFFF, ["wrapped"]),
        ("-0x80000001", None, ["out-of-range"]),
    ],
)
def test_numbers(text: str, value: int | None, defects: list[str]) -> None:
    found = variable(DefaultValue=text)
    assert default(found) == value
    assert codes(found) == [(8, code) for code in defects]


@pytest.mark.parametrize(
    ("text", "offset", "defects"),
    [
        ("$NODEID+0x180", 0x180, []),
        ("$NODEID+384", 384, []),
        ("0x180+$NODEID", 0x180, []),
        ("1280+$NODEID", 1280, []),
        ("$NodeID + 0x200", 0x200, []),
        ("0x180  +  $nodeid", 0x180, []),
        ("$NODEID", 0, []),
        ("$NODEID+0x40000180", 0x40000180, []),
        ("0x80+$NODEID+0x100", 0x180, ["nodeid-form"]),
        ("$NODEID+0x80+256", 0x180, ["nodeid-form"]),
        ("NODEID+0x180", 0x180, ["nodeid-form"]),
        ("$NODEID+0x180 ; default", 0x180, ["trailing-comment"]),
        ("$NODEID+0600", 0x180, ["octal"]),
    ],
)
def test_node_id_in_all_forms(text: str, offset: int, defects: list[str]) -> None:
    found = variable(DefaultValue=text)
    assert default(found) == NodeOffset(offset)
    assert NodeOffset(offset).at(5) == offset + 5
    assert codes(found) == [(8, code) for code in defects]


@pytest.mark.parametrize("text", ["$NODEID+$NODEID", "$NODEID+x", "2*$NODEID", "$NODEID 5", "$NODEID++5", "+$NODEID+"])
def test_node_id_that_makes_no_sum(text: str) -> None:
    found = variable(DefaultValue=text)
    assert (default(found), codes(found)) == (None, [(8, "not-a-number")])


@pytest.mark.parametrize(
    ("kind", "text", "value", "defects"),
    [
        (2, "0xFF", -1, []),
        (3, "0xFFFF", -1, []),
        (3, "-5", -5, []),
        (3, "0x7FFF", 32767, []),
        (3, "65535", -1, ["wrapped"]),
        (3, "0x10000", None, ["out-of-range"]),
        (4, "0x80000000", -(1 << 31), []),
        (0x10, "0xFFFFFE", -2, []),
        (0x15, "0xFFFFFFFFFFFFFFF6", -10, []),
        (0x1B, "0xFFFFFFFFFFFFFFFF", (1 << 64) - 1, []),
        (1, "1", 1, []),
        (1, "2", None, ["out-of-range"]),
        (5, "256", None, ["out-of-range"]),
        (8, "1.5", 1.5, []),
        (8, "5.200000", 5.2, []),
        (8, "-2", -2.0, []),
        (8, "0x0", 0.0, []),
        (8, "0x3FC00000", 1.5, ["real-as-hex"]),
        (0x11, "1e3 ; thousand", 1000.0, ["trailing-comment"]),
        (8, "nan", None, ["not-a-number"]),
        (8, "1e999", None, ["not-a-number"]),
        (8, "one", None, ["not-a-number"]),
        (9, "text ; all of it", "text ; all of it", []),
        (0x0B, "Zé", "Zé", []),
        (0x0A, "00 01 fe", b"\0\1\xfe", []),
        (0x0F, "0001FE", b"\0\1\xfe", []),
        (0x0A, "no bytes", None, ["not-bytes"]),
        (0x0A, "012", None, ["not-bytes"]),
        (0x0F, "0", None, []),
        (0x0A, "0x0", None, []),
        (0x0C, "12345", 12345, []),
    ],
)
def test_values_by_type(kind: int, text: str, value: Value | None, defects: list[str]) -> None:
    found = variable(DataType=f"{kind:#06x}", DefaultValue=text)
    assert default(found) == value
    assert codes(found) == [(8, code) for code in defects]


@pytest.mark.parametrize(
    ("kind", "low", "high", "limits"),
    [
        (4, "0x80000000", "0xFFFFFFFF", (-(1 << 31), -1)),
        (0x15, "0xFFFFFFFFFFFFFFF6", "0x0A", (-10, 10)),
        (0x10, "0xFFFFFE", "2", (-2, 2)),
        (8, "-1.5", "1.5", (-1.5, 1.5)),
        (5, "", "010", (None, 8)),
    ],
)
def test_limits(kind: int, low: str, high: str, limits: tuple[float | None, float | None]) -> None:
    entry = variable(DataType=kind, LowLimit=low, HighLimit=high).entry(0x2000, 0)
    assert entry is not None
    assert (entry.low, entry.high) == limits


def test_numbers_of_the_device() -> None:
    head = "[DeviceInfo]\nVendorname=v\nVendorNumber=001\nProductNumber=free text\nNrOfRxPDO=0x2\nnroftxpdo=03\n"
    found = load(head + "BaudRate_125=1\nBaudRate_500=0x1\n[2000]\nParameterName=x\nDataType=7\nAccessType=rw\n")
    device = found.device
    assert (device.vendor_name, device.vendor_number, device.product_number) == ("v", 1, None)
    assert (device.rpdos, device.tpdos, device.bit_rates) == (2, 3, (125_000, 500_000))
    assert codes(found) == [(7, "not-a-number")]
