"""Descriptions of other makers: all load, and agree with python-canopen wherever it reads the file unaided.

Where they differ, the file is right: the expected values then stand here.
"""

from __future__ import annotations

import json
import logging
from pathlib import Path
from typing import Any

import canopen
import pytest
from canopen.objectdictionary import ODRecord, ODVariable
from eds_texts import pdos, pdos_of_the_library

from canalyze.dictionary import SIGNED, Dictionary, Entry, NodeOffset, load

SHARED = Path(__file__).parent.parent.parent / "shared/corpus"
NODE = 5
FILES = sorted((SHARED / "eds").glob("*")) if SHARED.is_dir() else []
DESCRIPTIONS = [file for file in FILES if file.suffix != ".xdd"]
UNREADABLE = {"faulhaber_mcbl_cp850.eds", "pycanopen_e35_vendor001.eds"}
"""What makes python-canopen raise."""
NOTHING: tuple[object, ...] = (None, "", b"")

pytestmark = pytest.mark.skipif(not FILES, reason="no descriptions of other makers here")


def by_name(file: Path) -> str:
    return file.name


def json_of(name: str) -> Any:
    return json.loads((SHARED / "transcripts" / name).read_text(encoding="utf-8"))


def at_node(value: object) -> object:
    return value.at(NODE) if isinstance(value, NodeOffset) else value


@pytest.mark.parametrize("file", FILES, ids=by_name)
def test_loads(file: Path) -> None:
    found = load(str(file))
    assert found.objects
    assert all(thing.entries == tuple(sorted(thing.entries, key=lambda entry: entry.sub)) for thing in found.objects)
    assert all(defect.line <= file.read_bytes().count(b"\n") + 1 for defect in found.defects)


@pytest.mark.parametrize("file", DESCRIPTIONS, ids=by_name)
def test_agrees_with_the_recorded_reference(file: Path) -> None:
    said = json_of("python_canopen_eds_reference.json")["files"][file.name]
    if "exception" in said:
        assert file.name in UNREADABLE
        return
    found = load(str(file), NODE)
    device = found.device
    assert len(found.objects) == said["objects"]
    assert device.product_name == said["product"] and device.vendor_number == said["vendor_number"]
    assert device.vendor_name == (said["vendor"] if said["vendor"] is not None else "ESAcademy")
    for place, value in said["cob"].items():
        index, sub = place.split(":")
        entry = found.entry(int(index, 16), int(sub))
        assert entry is not None and at_node(entry.default) == int(value, 16)
    for place, mapping in said["map"].items():
        thing = found.object(int(place, 16))
        assert thing is not None
        count = thing.entries[0].default
        subs = thing.entries[1 : 1 + count] if isinstance(count, int) else thing.entries[1:]
        assert [entry.default for entry in subs if entry.default] == [int(value, 16) for value in mapping]


@pytest.mark.parametrize("file", DESCRIPTIONS, ids=by_name)
def test_agrees_with_the_library_on_every_entry(file: Path) -> None:
    if file.name in UNREADABLE:
        with pytest.raises((UnicodeDecodeError, ValueError)), file.open(encoding="utf-8") as stream:
            canopen.import_od(stream, NODE)
        return
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    with file.open(encoding="utf-8") as stream:
        theirs = canopen.import_od(stream, NODE)
    ours = load(str(file), NODE)
    compared = 0
    for index, thing in theirs.indices.items():
        if index < 0x1000:
            assert index in ours.dummies
            continue
        found = ours.object(index)
        assert found is not None
        variables = [thing] if isinstance(thing, ODVariable) else list(thing.subindices.values())
        for variable in variables:
            entry = found.entry(variable.subindex)
            assert entry is not None
            compare(variable, entry)
            compared += 1
        if isinstance(thing, ODRecord) and not any(entry.line == found.line for entry in found.entries):
            assert len(found.entries) == len(variables)
    assert compared > 0


@pytest.mark.parametrize("file", DESCRIPTIONS, ids=by_name)
def test_the_library_finds_the_same_pdos(file: Path) -> None:
    found = load(str(file), NODE)
    if any(defect.code == "mapped-unknown" for defect in found.defects):
        pytest.skip("python-canopen leaves out what the description does not have")
    try:
        theirs = pdos_of_the_library(str(file), NODE)
    except (KeyError, TypeError, ValueError):
        pytest.skip("python-canopen cannot make them")
    assert pdos(found, NODE) == theirs


def compare(theirs: ODVariable, ours: Entry) -> None:
    """The library leaves the sign of defaults to others, and takes no value for an empty one."""
    assert (ours.index, ours.sub) == (theirs.index, theirs.subindex)
    if theirs.subindex or theirs.name != "Number of entries":  # else it made it for CompactSubObj, and left it bare
        assert (ours.name, ours.access) == (theirs.name.strip(), theirs.access_type)
    assert ours.type == theirs.data_type or ours.type > 0x1B
    assert ours.mappable == theirs.pdo_mappable
    assert (ours.unit, ours.factor) == (theirs.unit, theirs.factor)
    for value, expected in ((at_node(ours.default), theirs.default), (at_node(ours.parameter), theirs.value)):
        if isinstance(value, int) and isinstance(expected, int) and ours.type in SIGNED:
            assert (value - expected) % (1 << SIGNED[ours.type]) == 0
        elif expected not in NOTHING:
            assert value == expected
    for limit, bound in ((ours.low, theirs.min), (ours.high, theirs.max)):
        if bound is not None and limit is not None:
            assert limit == bound


def entry_of(found: Dictionary, index: int, sub: int = 0) -> Entry:
    entry = found.entry(index, sub)
    assert entry is not None
    return entry


def test_stated_expectations_of_the_sample() -> None:
    said = json_of("pycanopen_eds_expected.json")
    file = SHARED / said["file"]
    expected = said["expected"]
    found = load(str(file))
    assert found.node == expected["implicit node id (DeviceComissioning, file)"]
    assert found.bit_rate == expected["bitrate"]
    heartbeat = entry_of(found, 0x1017)
    assert heartbeat.name == expected["1017"]["name"]
    assert (heartbeat.type, heartbeat.access, heartbeat.default) == (6, "rw", expected["1017"]["default"])
    assert load(str(file), said["node_id"]).pdos[0].cob_id.at(2) == 514
    identity = found.object(0x1018)
    assert identity is not None
    assert len(identity.entries) == expected["1018 record length"]
    sensor = expected["3004"]
    assert entry_of(found, 0x3004, 1).name == sensor["sub1"]
    assert entry_of(found, 0x3004, 3).name == sensor["sub3"]
    assert entry_of(found, 0x3004, 3).default == sensor["sub3 default"]
    array = found.object(0x3003)
    assert array is not None
    assert array.name == expected["3003 name"]
    compact = found.object(0x3006)
    assert compact is not None
    assert (compact.name, len(compact.entries)) == (expected["3006 name"], 25)
    assert entry_of(found, 0x3006, 5).name == "Valve 1 % Open_5"
    assert entry_of(found, 0x3010).name == expected["3010 sub0 name (Sub with capital S)"]
    limits = {index: (entry_of(found, index).low, entry_of(found, index).high) for index in (0x3020, 0x3021)}
    assert limits == {0x3020: (0, 127), 0x3021: (2, 10)}
    assert (entry_of(found, 0x3030).low, entry_of(found, 0x3030).high) == (-2147483648, -1)
    assert (entry_of(found, 0x3040).low, entry_of(found, 0x3040).high) == (-10, 10)
    assert 3 in found.dummies and 1 not in found.dummies
    extended = entry_of(found, 0x3050, 1)
    assert (extended.factor, extended.unit) == (0.1, "mV")
    assert found.comments == ("|-------------|", "| Don't panic |", "|-------------|")


def test_code_page_850() -> None:
    found = load(str(SHARED / "eds/faulhaber_mcbl_cp850.eds"))
    assert (len(found.objects), found.encoding) == (75, "cp850")
    assert found.comments[2] == "71101 Schönaich"
    assert [(defect.line, defect.code) for defect in found.defects] == [(52, "encoding")]


def test_leading_zeros() -> None:
    with_zeros, later = (
        load(str(SHARED / "eds" / name)) for name in ("pycanopen_e35_vendor001.eds", "pycanopen_e35.eds")
    )
    assert (with_zeros.device.vendor_number, later.device.vendor_number) == (1, 101)
    assert with_zeros.objects == later.objects


def test_demo_device_maps_what_its_manual_says() -> None:
    found = load(str(SHARED / "eds/canopennode_demodevice.eds"))
    assert [(m.index, m.sub, m.offset, m.bits) for m in found.pdos[4].mapped] == [(0x6000, 1, 0, 8), (0x6000, 2, 8, 8)]
    assert [(pdo.direction, pdo.cob_id.at(4)) for pdo in found.pdos if pdo.cob_id.valid] == [
        ("rpdo", 0x204),
        ("rpdo", 0x304),
        ("tpdo", 0x184),
        ("tpdo", 0x284),
    ]


def test_xdd_says_what_the_eds_of_the_same_device_says() -> None:
    """One is generated from the other; only for DOMAIN has XDD no type."""
    eds, xdd = (load(str(SHARED / f"eds/canopennode_demodevice.{form}")) for form in ("eds", "xdd"))
    assert [pdo.cob_id for pdo in eds.pdos] == [pdo.cob_id for pdo in xdd.pdos]
    assert [[(m.index, m.sub, m.bits) for m in pdo.mapped] for pdo in eds.pdos] == [
        [(m.index, m.sub, m.bits) for m in pdo.mapped] for pdo in xdd.pdos
    ]
    assert (eds.device.bit_rates, eds.dummies, eds.device.lss) == (xdd.device.bit_rates, xdd.dummies, xdd.device.lss)
    compared = 0
    for thing in eds.objects:
        for entry in thing.entries:
            other = entry_of(xdd, entry.index, entry.sub)
            assert (entry.name, entry.mappable) == (other.name, other.mappable)
            assert entry.type == other.type or (entry.type, other.type) == (0x0F, 0x0A)
            if isinstance(entry.default, int | NodeOffset) and other.default is not None:
                assert entry.default == other.default
            compared += 1
    assert compared > 250


def test_parameter_values_beside_a_compact_object() -> None:
    found = load(str(SHARED / "eds/lely_master_compactsub.dcf"))
    assert (found.form, found.node) == ("dcf", 1)
    assert [entry_of(found, 0x1028, sub).value for sub in (1, 2, 3, 4)] == [0x80000000, 0x82, 0x83, 0x80000000]
    assert [(pdo.cob_id.at(None), [m.index for m in pdo.mapped]) for pdo in found.pdos] == [
        (0x182, [0x2000]),
        (0x183, [0x2001]),
        (0x202, [0x2200]),
        (0x203, [0x2201]),
    ]
