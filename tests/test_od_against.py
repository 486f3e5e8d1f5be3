"""`canalyze od against`: a device that is as its description says differs in nothing; one change is reported as that.

The devices are made from descriptions (`simulated_device.py`): those of `eds/`, and those of other makers in
`../shared/corpus`, where that is there. Must not: take from the program what is expected of it.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path

import pytest
from captures import EDS, SHARED, CanFrame, log_text, session_output, spaced
from sdo_wire import Channel, expedited_download, expedited_upload
from simulated_device import NO_OBJECT, NO_SUB, NODE, READ_ONLY, Device, Held, device, encoded, refused, width

from canalyze.dictionary import SIGNED, Dictionary, Entry, load, packed
from canalyze.dictionary import read as read_description
from canalyze.dictionary.against import SEVERITIES, Comparison, compared
from canalyze.words import LANGUAGES, Words

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
    return compared(found, output, "can0", NODE)


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
        return whole and ((entry.access in ("rw", "const") and entry.index >= 0x2000) or entry.index == 0x1017)

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


def another_firmware(found: Dictionary, rng: random.Random) -> tuple[Device, Told]:
    """A device in which everything is changed once that can be, and what has to be told of it."""
    made, wanted = device(found), set[tuple[str, int, int | None]]()
    for seed in SEEDS:
        changed = deepcopy(made)
        more = seed(found, changed, rng) or set()
        if more and not {place[1:] for place in more} & {place[1:] for place in wanted}:
            made, wanted = changed, wanted | more
    return made, wanted


def hold_a_file(file: Path, tries: int) -> set[str]:
    """Raise AssertionError where more or less is reported than was changed; give the seeds that were tried."""
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
    made, wanted = another_firmware(found, random.Random(file.name))
    got = held(found, made)
    assert told(got) == wanted, got.differences
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


DRIVE = load(str(EDS / "drive.eds"), NODE)
CHANNEL = Channel(NODE)
BOOT = CanFrame("can0", 0x700 + NODE, b"\0")


def of(frames: list[CanFrame], found: Dictionary = DRIVE) -> Comparison:
    """The drive's description against a capture."""
    output = session_output([log_text(spaced(frames))], output_format="objects", lang="en")
    return compared(found, output, "can0", NODE)


def read(index: int, sub: int, data: bytes) -> list[CanFrame]:
    return expedited_upload(CHANNEL, index, sub, data)


def written(index: int, sub: int, data: bytes) -> list[CanFrame]:
    return expedited_download(CHANNEL, index, sub, data)


def test_a_default_counts_after_boot_up_and_before_any_write() -> None:
    other = read(0x1017, 0, b"\x90\1")
    assert told(of([BOOT, *other])) == {("default", 0x1017, 0)}
    assert told(of(other)) == set(), "it may have been configured before the capture began"
    assert told(of([BOOT, *written(0x1017, 0, b"\x90\1"), *other])) == set()
    assert told(of([*other, BOOT, *other])) == set(), "what was read before the boot-up is stored"


def test_a_default_does_not_count_behind_lost_frames() -> None:
    """A write may be among them."""
    drop = b"DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n"
    before, behind = log_text(spaced([BOOT])), log_text(spaced(read(0x1017, 0, b"\x90\1")))
    for text, expected in ((before + behind, {("default", 0x1017, 0)}), (before + drop + behind, set())):
        output = session_output([text], output_format="objects", lang="en")
        assert told(compared(DRIVE, output, "can0", NODE)) == expected


def test_a_real_that_its_type_does_not_hold(tmp_path: Path) -> None:
    file = tmp_path / "real.eds"
    keys = "ParameterName=Gain\nDataType=8\nAccessType=rw\nDefaultValue=-1e300\n"
    file.write_text(f"[ManufacturerObjects]\nSupportedObjects=1\n1=0x2000\n[2000]\n{keys}")
    found = load(str(file), NODE)
    assert packed(-1e300, 8, NODE) == struct.pack("<f", float("-inf"))
    (one,) = of([BOOT, *read(0x2000, 0, struct.pack("<f", 1.0))], found).differences
    assert (one.kind, one.filed, one.shown) == ("default", "-inf", "1.0")


def test_actual_values_have_no_default() -> None:
    """The statusword and the position are read; the default of an EDS says nothing of them."""
    assert (
        told(of([BOOT, *read(0x6041, 0, b"\x50\2"), *read(0x6064, 0, b"\1\2\3\4"), *read(0x1001, 0, b"\1")])) == set()
    )


def test_of_sizes_what_is_read_counts() -> None:
    long = written(0x1017, 0, b"\0\0\0\0")
    assert told(of(long)) == {("size", 0x1017, 0)}
    assert told(of([*long, *read(0x1017, 0, b"\0\0")])) == set(), "the device takes what is longer than its object"
    no_size = [CHANNEL.client(bytes.fromhex("4017100000000000")), CHANNEL.server(bytes.fromhex("4217100000000000"))]
    assert told(of(no_size)) == set()
    (one,) = of([*read(0x1017, 0, b"\0\0"), *read(0x1017, 0, b"\0")]).differences
    assert (one.kind, one.shown, one.filed) == ("size", "1-2", "UNSIGNED16")


def test_what_is_refused_for_another_reason_is_no_other_access() -> None:
    def no(command: int, index: int, sub: int, code: int) -> list[CanFrame]:
        return refused(CHANNEL, (index, sub), command, code)

    assert told(of([*no(0x23, 0x1017, 0, 0x08000022), *no(0x40, 0x1017, 0, 0x06010000)])) == set()
    assert told(of([*no(0x23, 0x1017, 0, READ_ONLY), *written(0x1017, 0, b"\0\0")])) == set(), "it can be written"
    (one,) = of(no(0x23, 0x1017, 0, READ_ONLY)).differences
    assert (one.kind, one.severity, one.frame) == ("not-writable", "warning", 2)
    (one,) = of(no(0x23, 0x1A00, 1, READ_ONLY)).differences
    assert (one.kind, one.severity) == ("not-writable", "info"), "the PDO may be in use"
    assert told(of([*no(0x40, 0x1017, 0, NO_OBJECT), *read(0x1017, 0, b"\0\0")])) == set(), "it is there"
    assert told(of(no(0x40, 0x2345, 0, NO_OBJECT))) == set(), "neither has it"


def test_a_mapping_that_is_configured_is_no_difference() -> None:
    """A master maps two other objects, and the PDO is as long as these."""
    first = read(0x1A00, 1, bytes.fromhex("10004160"))
    change = [
        *written(0x1800, 1, bytes.fromhex("85010080")),
        *written(0x1A00, 0, b"\0"),
        *written(0x1A00, 1, bytes.fromhex("20006460")),
        *written(0x1A00, 2, bytes.fromhex("10004160")),
        *written(0x1A00, 0, b"\2"),
        *written(0x1800, 1, bytes.fromhex("85010000")),
    ]
    pdo = CanFrame("can0", 0x180 + NODE, bytes(6))
    assert told(of([BOOT, *first, *change, pdo, *read(0x1A00, 1, bytes.fromhex("20006460"))])) == set()
    assert told(of([BOOT, *change, pdo])) == set()
    (one,) = of([BOOT, pdo]).differences
    assert (one.kind, one.severity, one.filed, one.shown) == ("pdo-length", "info", "2", "6")
    (one,) = of([BOOT, *read(0x1000, 0, encoded(entry_of(0x1000, 0))), pdo]).differences
    assert (one.kind, one.severity) == ("pdo-length", "warning"), "it has booted"
    (one,) = of([BOOT, *read(0x1A00, 1, bytes.fromhex("20006460"))]).differences
    assert (one.kind, one.severity, one.filed, one.shown) == ("mapping", "warning", "6041h:00/16", "6064h:00/32")
    (one,) = of(read(0x1A00, 0, b"\2")).differences
    assert (one.kind, one.severity, one.shown) == ("mapping", "info", "?, ?"), "configured before the capture, perhaps"


def entry_of(index: int, sub: int) -> Entry:
    entry = DRIVE.entry(index, sub)
    assert entry is not None
    return entry


@pytest.mark.parametrize(
    ("can_id", "lengths", "expected"),
    [
        (0x205, (2, 2), set()),
        (0x205, (3, 3), set()),  # a receiver takes what is longer
        (0x205, (1, 1), {("pdo-length", 0x1600, None)}),
        (0x185, (3, 3), {("pdo-length", 0x1A00, None)}),
        (0x185, (2, 3), set()),  # of two lengths neither is that of its mapping
        (0x186, (8, 8), set()),
    ],
)
def test_lengths_of_pdos(can_id: int, lengths: tuple[int, int], expected: Told) -> None:
    frames = [CanFrame("can0", can_id, bytes(length)) for length in lengths]
    assert told(of([BOOT, *frames])) == expected


def test_an_object_that_cannot_be_mapped() -> None:
    """1017h is in the mapping that a master writes, and comes with the PDO."""
    change = [*written(0x1A00, 1, bytes.fromhex("10001710")), *written(0x1A00, 0, b"\1")]
    assert told(of([BOOT, *change, CanFrame("can0", 0x180 + NODE, bytes(2))])) == {("mappable", 0x1017, 0)}
    change = [*written(0x1A00, 1, bytes.fromhex("10004160")), *written(0x1A00, 0, b"\1")]
    assert told(of([BOOT, *change, CanFrame("can0", 0x180 + NODE, bytes(2))])) == set()


def test_identity_by_degrees() -> None:
    told_of = {}
    for index, sub, value in ((0x1018, 3, 0x10001), (0x1018, 3, 0x20000), (0x1000, 0, 0x420192), (0x1000, 0, 0x191)):
        (one,) = of(read(index, sub, value.to_bytes(4, "little"))).differences
        told_of[value] = (one.kind, one.severity)
    assert told_of == {
        0x10001: ("revision", "info"),
        0x20000: ("revision", "warning"),
        0x420192: ("device-type", "warning"),
        0x191: ("identity", "error"),
    }
    assert told(of(read(0x1018, 1, b"\1\0\0\0"))) == set(), "the file has none"


def test_limits_that_are_none() -> None:
    def limited(low: str, high: str, default: str = "5") -> Dictionary:
        text = f"""[DeviceInfo]\n[ManufacturerObjects]\nSupportedObjects=1\n1=0x2000
[2000]\nParameterName=Gain\nObjectType=0x7\nDataType=0x0003\nAccessType=rw\nPDOMapping=0
LowLimit={low}\nHighLimit={high}\nDefaultValue={default}\n"""
        return read_description(text.encode(), "a.eds")

    values = [*read(0x2000, 0, b"\5\0"), *written(0x2000, 0, b"\xf6\xff"), *written(0x2000, 0, b"\7\0")]
    (one,) = of(values, limited("-5", "10")).differences
    assert (one.kind, one.filed, one.shown) == ("limits", "-5..10", "-10")
    (one,) = of(values, limited("", "6")).differences
    assert (one.filed, one.shown) == ("..6", "7")
    for low, high, default in (("-10", "7", "5"), ("0", "0", "5"), ("10", "-5", "5"), ("6", "10", "5"), ("", "", "5")):
        assert told(of(values, limited(low, high, default))) == set(), (low, high)


def test_a_dcf_is_what_the_device_is_to_hold() -> None:
    text = (EDS / "drive.eds").read_text().replace("[1017]", "[1017]\nParameterValue=500")
    dcf = read_description(text.encode(), "a.dcf")
    before, right, wrong = read(0x1017, 0, b"\0\0"), written(0x1017, 0, b"\xf4\1"), written(0x1017, 0, b"\xf5\1")
    assert told(of([BOOT, *before, *right], dcf)) == set()
    assert told(of([BOOT, *before, *wrong], dcf)) == {("parameter", 0x1017, 0)}
    assert told(of([BOOT, *before], dcf)) == {("parameter", 0x1017, 0)}
    text = text.replace("[6064]", "[6064]\nParameterValue=7").replace("[6041]", "[6041]\nParameterValue=7")
    exported = read_description(text.encode(), "a.dcf")
    actual = [*read(0x6064, 0, b"\1\2\3\4"), *read(0x6041, 0, b"\x50\2")]
    assert told(of([*right, *actual], exported)) == set(), "some tools export actual values, too"


def test_what_a_file_need_not_list() -> None:
    assert told(of([*read(0x0005, 0, b"\x08"), *read(0x1018, 0xFF, b"\7\x23\0\0")])) == set()
    assert told(of(read(0x1018, 7, b"\1\0\0\0"))) == {("unlisted", 0x1018, 7)}


def test_worst_first_and_never_seen_on_demand() -> None:
    frames = [BOOT, *read(0x1017, 0, b"\x90\1"), *read(0x2345, 0, b"\1"), *read(0x1000, 0, b"\x91\1\0\0")]
    found = of(frames)
    assert [one.severity for one in found.differences] == ["error", "warning", "info"]
    output = session_output([log_text(spaced(frames))], output_format="objects", lang="en")
    everything = compared(DRIVE, output, "can0", NODE, unseen=True)
    last = [one for one in everything.differences if one.kind == "unseen"]
    assert [(one.index, one.sub) for one in last] == list(found.unseen) and len(last) == len(found.unseen) > 100
    assert found.seen + len(found.unseen) == sum(len(thing.entries) for thing in DRIVE.objects)


@pytest.mark.parametrize("lang", LANGUAGES)
def test_every_kind_has_its_words(lang: str) -> None:
    words = Words(lang)
    said = {kind: words(f"against.{kind}", filed="1", shown="2") for kind in SEVERITIES}
    assert len(set(said.values())) == len(said)
