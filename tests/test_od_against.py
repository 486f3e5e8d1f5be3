"""`canalyze od --against`: a device that is as its description says differs in nothing; one change is told as that.

The devices are made from descriptions (`simulated_device.py`): those of `eds/`, and those of other makers in
`../shared/corpus`, where that is there. Must not: take from the program what is expected of it.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from captures import EDS, SAMPLES, SHARED, session_output
from conftest import Runner
from simulated_device import NO_OBJECT, NO_SUB, NODE, Address, Device, Held, device, encoded, width

from canalyze.dictionary import load
from canalyze.dictionary.against import SEVERITIES, Comparison, compared
from canalyze.dictionary.model import Dictionary, Entry
from canalyze.dictionary.values import SIGNED

CORPUS = SHARED / "corpus/eds"
OWN = sorted(EDS.glob("*.eds"))
OTHERS = sorted(CORPUS.glob("*.*"))
PDO_PARAMETERS = range(0x1400, 0x1C00)
IDENTITY = (0x1000, 0x1018)

Told = set[tuple[str, int, int | None]]
"""Kind, index and sub-index of each difference."""
Seed = Callable[[Dictionary, Device, random.Random], "Told | None"]
"""Changes the device; gives what has to be told of that, None where the description has nothing to change."""


def held(found: Dictionary, made: Device, *, sdo: bool = True) -> Comparison:
    """The description against the capture of a device."""
    output = session_output([made.log(sdo=sdo)], output_format="objects", lang="en")
    records = [json.loads(line) for line in output.splitlines()]
    return compared(found, records, "can0", NODE)


def told(of: Comparison) -> Told:
    return {(one.kind, one.index, one.sub) for one in of.differences}


def entries(found: Dictionary) -> Iterator[Entry]:
    """Those in which something can be changed that bears on nothing else: no identity, and nothing of PDOs."""
    carried = {(mapped.index, mapped.sub) for pdo in found.pdos for mapped in pdo.mapped}
    for thing in found.objects:
        for entry in thing.entries:
            if (entry.index, entry.sub) not in carried and entry.index not in (*PDO_PARAMETERS, *IDENTITY):
                yield entry


def one_of(found: Dictionary, rng: random.Random, wanted: Callable[[Entry], bool]) -> Entry | None:
    there = [entry for entry in entries(found) if wanted(entry)]
    return rng.choice(there) if there else None


def absent(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
    entry = one_of(found, rng, lambda _: True)
    if entry is None:
        return None
    address = (entry.index, entry.sub)
    del made.objects[address]
    made.absent[address] = rng.choice((NO_OBJECT, NO_SUB))
    return {("absent", *address)}


def unlisted(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
    listed = {thing.index for thing in found.objects}
    address = (next(index for index in range(0x2345, 0x6000) if index not in listed), rng.choice((0, 3)))
    made.objects[address] = Held(b"\1\2", readable=True, writable=False)
    return {("unlisted", *address)}


def other_size(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
    entry = one_of(found, rng, lambda entry: width(entry) > 0 and entry.access != "wo")
    if entry is None:
        return None
    size = rng.choice([size for size in (1, 2, 4, 8) if size != width(entry)])
    made.change((entry.index, entry.sub), data=encoded(entry)[:size].ljust(size, b"\0"))
    return {("size", entry.index, entry.sub)}


def access(kind: str, before: tuple[str, ...], **after: bool) -> Seed:
    """Another access than the description has."""

    def seed(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
        entry = one_of(found, rng, lambda entry: entry.access in before)
        if entry is None:
            return None
        made.change((entry.index, entry.sub), **after)
        return {(kind, entry.index, entry.sub)}

    seed.__name__ = kind
    return seed


def other_default(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
    """A parameter that is a number: configuration, or what CiA 301 makes constant."""

    def wanted(entry: Entry) -> bool:
        whole = isinstance(entry.value, int) and width(entry) > 0 and (entry.low, entry.high) == (None, None)
        return whole and (entry.access in ("rw", "const") and entry.index >= 0x2000 or entry.index == 0x1017)

    entry = one_of(found, rng, wanted)
    if entry is None:
        return None
    made.change((entry.index, entry.sub), data=bytes([encoded(entry)[0] ^ 1]) + encoded(entry)[1:])
    return {("default" if entry.parameter is None else "parameter", entry.index, entry.sub)}


def beyond_limits(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
    """The device takes a value that the description forbids."""

    def wanted(entry: Entry) -> bool:
        most = (1 << 8 * width(entry) - (entry.type in SIGNED)) - 1
        own = isinstance(entry.value, int) and entry.parameter is None
        limited = isinstance(entry.high, int) and isinstance(entry.low, int) and entry.low < entry.high < most
        return own and limited and entry.access in ("rw", "rwr", "rww") and entry.low <= entry.value <= entry.high  # type: ignore[operator]

    entry = one_of(found, rng, wanted)
    if entry is None or entry.high is None:
        return None
    made.change((entry.index, entry.sub), written=encoded(entry, entry.high + 1))
    return {("limits", entry.index, entry.sub)}


def swapped_mapping(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
    """Two entries of a mapping in the other order."""
    for index in (0x1A00, 0x1A01, 0x1A02, 0x1600, 0x1601, 0x1602):
        count = made.objects.get((index, 0), Held(b"\0", readable=True, writable=False)).data[0]
        first, second = made.objects.get((index, 1)), made.objects.get((index, 2))
        if 2 <= count <= 64 and first and second and first.data != second.data and first.readable:
            made.change((index, 1), data=second.data)
            made.change((index, 2), data=first.data)
            return {("mapping", index, None)}
    return None


def shorter_mapping(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
    """A mapping of one entry less."""
    for index in (0x1A00, 0x1A01, 0x1A02):
        number = made.objects.get((index, 0))
        if number and 2 <= number.data[0] <= 64 and number.readable:
            made.change((index, 0), data=bytes([number.data[0] - 1]))
            return {("mapping", index, None)}
    return None


def identity(sub: int, kind: str) -> Seed:
    """Another vendor, product or revision."""

    def seed(found: Dictionary, made: Device, rng: random.Random) -> Told | None:
        one = made.objects.get((0x1018, sub))
        device_info = found.device.vendor_number, found.device.product_number, found.device.revision_number
        said = int.from_bytes(one.data, "little") if one else 0
        if one is None or said in (0, 0xFFFFFFFF) or device_info[sub - 1] not in (None, 0, said, 0xFFFFFFFF):
            return None
        made.change((0x1018, sub), data=(said ^ 0x00550000).to_bytes(4, "little"))
        return {(kind, 0x1018, sub)}

    seed.__name__ = f"identity_{sub}"
    return seed


SEEDS: tuple[Seed, ...] = (
    absent,
    unlisted,
    other_size,
    access("writable", ("ro", "const"), writable=True),
    access("not-writable", ("rw", "rwr", "rww"), writable=False),
    access("readable", ("wo",), readable=True),
    access("not-readable", ("rw", "ro", "const"), readable=False),
    other_default,
    beyond_limits,
    swapped_mapping,
    shorter_mapping,
    identity(1, "identity"),
    identity(2, "identity"),
    identity(3, "revision"),
)

def hold_a_file(file: Path, tries: int) -> set[str]:
    """Raise AssertionError where more or less is told than was changed; give the seeds that were tried."""
    found = load(str(file), NODE)
    clean = held(found, device(found))
    assert told(clean) == set(), clean.differences
    assert clean.unseen == () and clean.seen == sum(len(thing.entries) for thing in found.objects)
    assert told(held(found, device(found), sdo=False)) == set()
    tried = set()
    for seed in SEEDS:
        for number in range(tries):
            made = device(found)
            wanted = seed(found, made, random.Random(f"{file.name} {number}"))
            if wanted is not None:
                tried.add(seed.__name__)
                got = held(found, made)
                assert told(got) == wanted, (seed.__name__, got.differences)
    lengths = device(found)
    for (can_id, extended), length in lengths.pdos.items():
        if length > 1:
            changed = device(found)
            changed.pdos[can_id, extended] = length - 1
            ((kind, index, sub),) = told(held(found, changed, sdo=False))
            assert (kind, index & 0xF800, sub) in (("pdo-length", 0x1800, None), ("pdo-length", 0x1000, None))
            tried.add("length")
            assert told(held(found, changed)) == set(), "the mapping was read and is that of the file"
    return tried


@pytest.mark.parametrize("file", OWN, ids=lambda file: file.name)
def test_a_device_against_its_own_description(file: Path) -> None:
    assert len(hold_a_file(file, 3)) > 9


def test_other_makers_devices() -> None:
    if not OTHERS:
        pytest.skip(f"{CORPUS} is not there")
    tried = {file.name: hold_a_file(file, 1) for file in OTHERS}
    assert set().union(*tried.values()) == {seed.__name__ for seed in SEEDS} | {"length"}
