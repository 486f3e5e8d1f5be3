"""Our own descriptions: without defects, and what the samples need of them."""

from __future__ import annotations

from pathlib import Path

import canopen
import pytest
from eds_texts import pdos, pdos_of_the_library

from canalyze.dictionary import load

OWN = Path(__file__).parent.parent / "eds"
NAMES = ["drive.eds", "encoder.eds", "io.eds"]


def test_nothing_else_is_there() -> None:
    assert sorted(path.name for path in OWN.iterdir()) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_has_no_defects(name: str) -> None:
    found = load(str(OWN / name))
    assert (found.defects, found.form, found.node, found.encoding) == ((), "eds", None, "utf-8")
    assert found.info.name == name
    assert (found.device.rpdos, found.device.tpdos) == tuple(
        sum(pdo.direction == direction for pdo in found.pdos) for direction in ("rpdo", "tpdo")
    )


@pytest.mark.parametrize("name", NAMES)
def test_the_library_reads_it_too(name: str) -> None:
    theirs = canopen.import_od(str(OWN / name), 5)
    ours = load(str(OWN / name), 5)
    assert [thing.index for thing in ours.objects] == sorted(index for index in theirs.indices if index >= 0x1000)


@pytest.mark.parametrize("name", NAMES)
def test_the_library_finds_the_same_pdos(name: str) -> None:
    found = pdos(load(str(OWN / name)), 5)
    assert found == pdos_of_the_library(str(OWN / name), 5) != []


@pytest.mark.parametrize("name", NAMES)
def test_mapped_objects_may_be_mapped(name: str) -> None:
    found = load(str(OWN / name))
    for pdo in found.pdos:
        assert pdo.cob_id.valid and not pdo.cob_id.assumed and pdo.mapped
        for mapped in pdo.mapped:
            entry = found.entry(mapped.index, mapped.sub)
            assert entry is not None and entry.mappable
            assert entry.access in (("rw", "rww") if pdo.direction == "rpdo" else ("ro", "rw", "rwr"))


def test_signals_of_the_drive() -> None:
    signals = {
        f"{pdo.direction}{pdo.number}": [(m.index, m.offset, m.bits) for m in pdo.mapped]
        for pdo in load(str(OWN / "drive.eds")).pdos
    }
    assert signals == {
        "rpdo1": [(0x6040, 0, 16)],
        "rpdo2": [(0x6040, 0, 16), (0x6060, 16, 8)],
        "rpdo3": [(0x6040, 0, 16), (0x607A, 16, 32)],
        "rpdo4": [(0x6040, 0, 16), (0x60FF, 16, 32)],
        "tpdo1": [(0x6041, 0, 16)],
        "tpdo2": [(0x6041, 0, 16), (0x6061, 16, 8)],
        "tpdo3": [(0x6041, 0, 16), (0x6064, 16, 32)],
        "tpdo4": [(0x6041, 0, 16), (0x606C, 16, 32), (0x6077, 48, 16)],
    }
