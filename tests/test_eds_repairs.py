"""Every repair of a device description's objects: a small text of our own, and what it must say."""

from __future__ import annotations

from pathlib import Path

import pytest
from captures import DATA
from eds_texts import codes, default, load, name, variable

from canalyze.dictionary import load as load_file
from canalyze.dictionary import read
from canalyze.dictionary.model import EFFECTS, Dictionary
from canalyze.errors import SourceError
from canalyze.words import LANGUAGES, Words, sentences


def test_missing_keys() -> None:
    found = load("[2000]\nObjectType=7\n")
    entry = found.entry(0x2000, 0)
    assert entry is not None
    assert (entry.name, entry.type, entry.access) == ("2000", 0, "rw")
    keys = [defect.facts["key"] for defect in found.defects if defect.code == "missing-key"]
    assert sorted(map(str, keys)) == ["AccessType", "DataType", "ParameterName"]


def test_sub_zero_without_type_is_a_count() -> None:
    found = load("[2000]\nParameterName=x\nObjectType=8\n[2000sub0]\nParameterName=n\nAccessType=ro\nDefaultValue=2\n")
    entry = found.entry(0x2000, 0)
    assert entry is not None
    assert (entry.type, entry.default, codes(found)) == (5, 2, [(7, "missing-key")])


@pytest.mark.parametrize(
    ("text", "access", "defects"),
    [
        ("Const", "const", []),
        ("rwr", "rwr", []),
        ("R", "ro", ["access"]),
        ("read/write", "rw", ["access"]),
        ("ro ; fixed", "ro", ["access"]),
    ],
)
def test_access(text: str, access: str, defects: list[str]) -> None:
    found = variable(AccessType=text)
    entry = found.entry(0x2000, 0)
    assert entry is not None
    assert (entry.access, codes(found)) == (access, [(7, code) for code in defects])


def test_unknown_type_is_bytes() -> None:
    found = variable(DataType="0x40", DefaultValue="0x0")
    entry = found.entry(0x2000, 0)
    assert entry is not None
    assert (entry.type, entry.default, codes(found)) == (0x40, None, [(6, "unknown-type")])
    assert default(variable(DataType="0x40", DefaultValue="0A0B")) == b"\x0a\x0b"


def test_type_that_the_file_defines() -> None:
    text = (
        "[A0]\nParameterName=t\nObjectType=6\n[A0sub1]\nParameterName=t\nDataType=5\nAccessType=ro\nDefaultValue=0x3\n"
    )
    found = load(text + "[2000]\nParameterName=x\nDataType=0xA0\nAccessType=rw\nDefaultValue=0xFFFF\n")
    assert (default(found), codes(found)) == (-1, [])
    assert [thing.index for thing in found.objects] == [0x2000]


def test_variable_with_subs_is_a_record() -> None:
    found = load("[2000]\nParameterName=x\nObjectType=7\n[2000sub1]\nParameterName=y\nDataType=5\nAccessType=rw\n")
    thing = found.object(0x2000)
    assert thing is not None
    assert (thing.code, name(found, sub=1), codes(found)) == (9, "y", [(6, "object-type")])


def test_object_type_may_be_missing() -> None:
    found = load("[2000]\nParameterName=x\nSubNumber=1\n[2000sub1]\nParameterName=y\nDataType=5\nAccessType=rw\n")
    thing = found.object(0x2000)
    assert thing is not None
    assert (thing.code, found.defects) == (9, ())


def test_subs_before_their_index() -> None:
    found = load(
        "[2000sub1]\nParameterName=y\nDataType=5\nAccessType=rw\nDefaultValue=7\n"
        "[2000]\nParameterName=x\nObjectType=9\nSubNumber=1\n"
    )
    assert (default(found, sub=1), found.defects) == (7, ())


def test_subs_without_their_index() -> None:
    found = load("[2000sub1]\nParameterName=y\nDataType=5\nAccessType=rw\nDefaultValue=7\n")
    assert (default(found, sub=1), codes(found)) == (7, [(4, "no-index-section")])


@pytest.mark.parametrize(
    ("section", "sub"), [("2000Sub0", 0), ("2000sub01", 1), ("2000SUB1", 1), ("2000subA", 10), ("2000sub10", 16)]
)
def test_spellings_of_subs(section: str, sub: int) -> None:
    head = "[2000]\nParameterName=x\nObjectType=9\nSubNumber=1\n"
    found = load(head + f"[{section}]\nParameterName=y\nDataType=5\nAccessType=rw\nDefaultValue=3\n")
    assert (default(found, sub=sub), found.defects) == (3, ())


def test_two_spellings_of_one_sub() -> None:
    head = "[2000]\nParameterName=x\nObjectType=9\nSubNumber=1\n"
    found = load(
        head + "[2000sub1]\nParameterName=y\nDataType=5\nAccessType=rw\nDefaultValue=3\n[2000sub01]\nDefaultValue=4\n"
    )
    assert (default(found, sub=1), codes(found)) == (4, [(13, "duplicate-section")])


def test_counts_that_do_not_agree() -> None:
    text = "[OptionalObjects]\nSupportedObjects=3\n1=0x2000\n[2000]\nParameterName=x\nObjectType=9\nSubNumber=2\n"
    found = read(f"{text}[2000sub1]\nParameterName=y\nDataType=5\nAccessType=rw\n".encode(), "x.eds")
    assert codes(found) == [(2, "count"), (7, "count")]
    assert [(d.facts["said"], d.facts["found"]) for d in found.defects] == [(3, 1), (2, 1)]


def test_unlisted_and_listed_without_section() -> None:
    found = load("[2001]\nParameterName=x\nDataType=7\nAccessType=rw\n")
    assert name(found, 0x2001) == "x"
    assert codes(found) == [(3, "not-there"), (4, "unlisted")]


def test_a_fragment_without_lists() -> None:
    found = read(b"[2000]\nParameterName=x\nDataType=7\nAccessType=rw\n", "x.eds")
    assert (name(found), codes(found)) == ("x", [(0, "no-lists")])


COMPACT = "[2000]\nParameterName=x\nObjectType=8\nDataType=6\nAccessType=ro\nDefaultValue=3\nCompactSubObj=12\n"


def test_compact_subs() -> None:
    found = load(COMPACT)
    thing = found.object(0x2000)
    assert thing is not None
    assert [entry.sub for entry in thing.entries] == list(range(13))
    assert [entry.type for entry in thing.entries] == [5] + [6] * 12
    assert (default(found, sub=0), default(found, sub=12)) == (12, 3)
    assert (name(found, sub=1), name(found, sub=2), name(found, sub=12), found.defects) == ("x", "x_2", "x_c", ())


def test_compact_names_and_values_may_be_sparse() -> None:
    names = "[2000Name]\nNrOfEntries=2\n2=second\n12=twelfth\n"
    found = load(COMPACT + names + "[2000value]\nNrOfEntries=1\n12=0x10\n")
    assert (name(found, sub=2), name(found, sub=3), name(found, sub=12)) == ("second", "x_3", "twelfth")
    entry = found.entry(0x2000, 12)
    assert entry is not None
    assert (entry.default, entry.parameter, entry.value, found.defects) == (3, 16, 16, ())


def test_compact_names_of_what_is_not_there() -> None:
    found = load(COMPACT + "[2000Name]\nNrOfEntries=1\n13=x\n[2000Value]\nNrOfEntries=1\n200=1\n")
    assert codes(found) == [(13, "no-such-sub"), (16, "no-such-sub")]


def test_compact_says_what_is_odd_once() -> None:
    found = load(COMPACT.replace("DefaultValue=3", "DefaultValue=No"))
    assert codes(found) == [(9, "not-a-number")]


def test_compact_beside_an_explicit_sub() -> None:
    found = load(COMPACT + "[2000sub3]\nParameterName=own\nDataType=6\nAccessType=rw\nDefaultValue=9\n")
    assert (name(found, sub=3), default(found, sub=3), default(found, sub=4)) == ("own", 9, 3)


def test_compact_cannot_blow_up() -> None:
    keys = "ParameterName=x\nObjectType=8\nDataType=5\nAccessType=ro\nCompactSubObj=254\n"
    found = load("".join(f"[{index:04X}]\n{keys}" for index in range(0x2000, 0x2000 + 119)))
    assert [len(thing.entries) for thing in found.objects] == [*[255] * 117, 165]
    assert [code for _, code in codes(found)][-4:] == ["unlisted", "too-many", "unlisted", "too-many"]
    assert {defect.facts["most"] for defect in found.defects if defect.code == "too-many"} == {30_000}


SIMPLE = "[2000]\nParameterName=x\nDataType=7\nAccessType=rw\nDefaultValue=1\nParameterValue=2\n"


def test_dummies() -> None:
    full = "[dummyusage]\n" + "".join(f"Dummy{kind:04d}={kind % 2}\n" for kind in range(1, 8))
    assert load(SIMPLE + full).dummies == {1, 3, 5, 7}
    assert load(SIMPLE + full + "Dummy0010=1\n").dummies == {1, 3, 5, 7, 16}
    found = load(SIMPLE + "[DummyUsage]\nDummy0005=0x1\nDummy0006=yes\nDummy0007=0x0\n")
    assert found.dummies == {5}
    assert codes(found) == [(10, "dummy-missing"), (12, "not-a-number")]
    assert load(SIMPLE).dummies == frozenset()


@pytest.mark.parametrize(
    ("text", "node", "defects"),
    [
        ("[DeviceComissioning]\nNodeID=0x38\n", 0x38, []),
        ("[DeviceComissioning]\nNODEID=7\n", 7, []),
        ("[devicecommissioning]\nNodeId=010\n", 8, ["commissioning", "octal"]),
        ("[DeviceComissioning]\nNodeID=255\n", None, []),
        ("[DeviceComissioning]\nNodeID=\n", None, []),
        ("[DeviceComissioning]\nNodeID=128\n", None, ["node-id"]),
        ("[DeviceComissioning]\nNodeID=five\n", None, ["not-a-number"]),
    ],
)
def test_node_of_a_dcf(text: str, node: int | None, defects: list[str]) -> None:
    found = load(SIMPLE + text)
    assert (found.form, found.node) == ("dcf", node)
    assert [code for _, code in codes(found)] == defects
    assert load(SIMPLE + text, 3).node == 3


def test_parameter_value_before_default() -> None:
    entry = load(SIMPLE).entry(0x2000, 0)
    assert entry is not None
    assert (entry.default, entry.parameter, entry.value) == (1, 2, 2)
    entry = load(SIMPLE.replace("=2\n", "=0\n")).entry(0x2000, 0)
    assert entry is not None
    assert entry.value == 0


def pdo_text(cob_id: str, mapping: list[str], first: int = 0x1800, count: str | None = None) -> str:
    def sub(index: int, number: int, kind: int, value: str) -> str:
        return f"[{index:04X}sub{number}]\nParameterName=s\nDataType={kind}\nAccessType=rw\nDefaultValue={value}\n"

    text = f"[{first:04X}]\nParameterName=c\nObjectType=9\n" + sub(first, 0, 5, "6") + sub(first, 1, 7, cob_id)
    text += sub(first, 2, 5, "0xF0") + sub(first, 3, 6, "100") + sub(first, 5, 6, "20") + sub(first, 6, 5, "7")
    second = first + 0x200
    text += f"[{second:04X}]\nParameterName=m\nObjectType=9\n" + sub(second, 0, 5, count or str(len(mapping)))
    text += "".join(sub(second, number, 7, value) for number, value in enumerate(mapping, 1))
    text += "[2000]\nParameterName=word\nDataType=6\nAccessType=ro\nPDOMapping=1\n"
    return text + "[2001]\nParameterName=long\nDataType=4\nAccessType=ro\nPDOMapping=1\n"


def pdo_codes(found: Dictionary) -> list[str]:
    return [defect.code for defect in found.defects if defect.code != "no-lists"]


def test_pdo() -> None:
    found = read(pdo_text("$NODEID+0x40000180", ["0x20000010", "0x20010020"]).encode(), "x.eds")
    (pdo,) = found.pdos
    cob = pdo.cob_id
    assert (pdo.number, pdo.direction, pdo.transmission, pdo.inhibit) == (1, "tpdo", 240, 100)
    assert (pdo.event_timer, pdo.sync_start, pdo.bits, pdo.multiplex) == (20, 7, 48, None)
    assert (cob.valid, cob.rtr_allowed, cob.extended, cob.assumed) == (True, False, False, False)
    assert (cob.base, cob.at(5), cob.at(None)) == (0x180, 0x185, None)
    assert [(m.index, m.sub, m.offset, m.bits, m.dummy) for m in pdo.mapped] == [
        (0x2000, 0, 0, 16, False),
        (0x2001, 0, 16, 32, False),
    ]
    assert [entry.name for m in pdo.mapped if (entry := found.entry(m.index, m.sub))] == ["word", "long"]
    assert pdo_codes(found) == []


@pytest.mark.parametrize(
    ("text", "valid", "extended", "identifier", "assumed"),
    [
        ("0x181", True, False, 0x181, False),
        ("0x80000181", False, False, 0x181, False),
        ("0x20012345", True, True, 0x12345, False),
        ("$NODEID+0x80000000", False, False, 5, False),
        ("", True, False, 0x185, True),
    ],
)
def test_cob_ids(text: str, valid: bool, extended: bool, identifier: int, assumed: bool) -> None:
    (pdo,) = read(pdo_text(text, []).encode(), "x.eds").pdos
    cob = pdo.cob_id
    assert (cob.valid, cob.extended, cob.at(5), cob.assumed) == (valid, extended, identifier, assumed)


def test_pdo_beyond_the_fourth_without_cob_id_is_none() -> None:
    (pdo,) = read(pdo_text("", [], first=0x1404).encode(), "x.eds").pdos
    assert (pdo.number, pdo.direction, pdo.cob_id.valid, pdo.cob_id.assumed) == (5, "rpdo", False, True)


@pytest.mark.parametrize(
    ("mapping", "count", "bits", "defects"),
    [
        (["0x20000010", "0x20010020"], "1", 16, []),
        (["0x20000010", "0x20010020"], "0", 0, []),
        (["0x20000010"], "3", 16, ["mapping-count"]),
        (["0x20000010", "0x20030020"], None, 48, ["mapped-unknown"]),
        (["0x20000008"], None, 8, ["mapped-size"]),
        (["0x00050008", "0x00000000", "0x20000010"], None, 24, []),
        (["0x00090008"], None, 8, ["mapped-unknown"]),
        (["0x20010020", "0x20010020", "0x20000010"], None, 80, ["mapping-length"]),
    ],
)
def test_mappings(mapping: list[str], count: str | None, bits: int, defects: list[str]) -> None:
    found = read(pdo_text("0x181", mapping, count=count).encode(), "x.eds")
    assert (found.pdos[0].bits, pdo_codes(found)) == (bits, defects)


@pytest.mark.parametrize(("count", "kind"), [("254", "sam"), ("255", "dam")])
def test_multiplex_pdos(count: str, kind: str) -> None:
    (pdo,) = read(pdo_text("0x181", [], count=count).encode(), "x.eds").pdos
    assert (pdo.multiplex, pdo.mapped) == (kind, [])


def test_pdo_without_mapping_and_odd_cob_id() -> None:
    text = pdo_text("0x1181", []).replace("[1A00]", "[3A00]").replace("[1A00sub", "[3A00sub")
    assert pdo_codes(read(text.encode(), "x.eds")) == ["mapping-missing", "cob-id"]


def test_compact_pdo() -> None:
    head = "[DeviceInfo]\nNrOfRxPDO=5\nNrOfTxPDO=1\nCompactPDO=0x13\n"
    found = load(head + "[2000]\nParameterName=x\nDataType=7\nAccessType=rw\n")
    assert [(pdo.direction, pdo.number) for pdo in found.pdos] == [*(("rpdo", n) for n in range(1, 6)), ("tpdo", 1)]
    assert [pdo.cob_id.at(5) for pdo in found.pdos if pdo.cob_id.valid] == [0x205, 0x305, 0x405, 0x505, 0x185]
    thing = found.object(0x1400)
    assert thing is not None
    assert [entry.sub for entry in thing.entries] == [0, 1, 2, 5]
    assert found.defects == ()


def test_defects_are_bounded() -> None:
    found = load("[2000]\nParameterName=x\nDataType=7\nAccessType=rw\n" + "no key\n" * 3000)
    assert len(found.defects) == 1001
    assert (found.defects[0].code, found.defects[0].facts) == ("more", {"code": "no-equals", "count": 2000})


def test_a_file_too_large(tmp_path: Path) -> None:
    (tmp_path / "large.eds").write_bytes(b"; nothing\n" * (1 << 20))
    with pytest.raises(SourceError) as raised:
        load_file(str(tmp_path / "large.eds"))
    assert raised.value.key == "eds.large"


@pytest.mark.parametrize(
    ("data", "key"),
    [
        (b"", "source.empty"),
        (b" \r\n ", "source.empty"),
        (b"[FileInfo]\nFileName=x\n", "eds.nothing"),
        (b"\x7fELF\x02\x01\x01\0\0\0", "eds.nothing"),
        (b"can0  60A   [8]  40 08 10 00 00 00 00 00\n", "eds.nothing"),
        (b"<?xml version='1.0'?><a><b></a>", "eds.xml"),
        (b"<?xml version='1.0'?><a/>", "eds.nothing"),
        (b"<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>", "eds.doctype"),
    ],
)
def test_file_that_cannot_be_used(data: bytes, key: str) -> None:
    with pytest.raises(SourceError) as raised:
        read(data, "x.eds")
    assert raised.value.key == key
    for lang in LANGUAGES:
        assert "\n" not in raised.value.in_words(Words(lang))


def test_xdd() -> None:
    found = read((DATA / "small.xdd").read_bytes(), "x.xdd")
    assert (found.form, found.device.vendor_name, found.device.vendor_number) == ("xdd", "Firma Ü", 18)
    assert (found.device.bit_rates, found.device.rpdos, found.device.tpdos) == ((500_000,), 2, 3)
    assert (found.device.lss, found.info.name, sorted(found.dummies)) == (True, "d.xdd", [5])
    entries = [(e.index, e.sub, e.name, e.type, e.access, e.default) for o in found.objects for e in o.entries]
    assert entries == [
        (0x2000, 0, "x", 5, "rw", 7),
        (0x2001, 10, "y", 1, "ro", 1),
        (0x2002, 0, "z", 3, "ro", -5),
    ]
    entry = found.entry(0x2002, 0)
    assert entry is not None
    assert (entry.low, entry.line) == (-9, 13)


def test_every_defect_has_words() -> None:
    keys = sentences("defect", "en").keys() | sentences("effect", "en").keys()
    for code, effect in EFFECTS.items():
        assert {f"defect.{code}", f"effect.{effect}"} <= keys
