"""`canalyze od --concise-dcf` and `--skeleton`: replayed into a device, they make it what the capture had configured.

The device is that of the made networks, and refuses what CiA 301 has it refuse. Concise DCFs are read by a second
reader here, and those of another writer by ours. Must not: take a value from the program that is not compared.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path

import canopen
import pytest
from captures import EDS, eds_options, run_canalyze
from network_nodes import Account, Device, Timers
from test_od_dcf import SESSIONS, Address, written

from canalyze._core import is_description
from canalyze.dictionary import load, read
from canalyze.dictionary.files import concise

UNSUPPORTED, CANNOT_BE_CHANGED = 0x0601_0000, 0x0609_0030
IN_USE = 0x8000_0000


def steps(data: bytes) -> Iterator[tuple[Address, bytes]]:
    """What a concise DCF writes, by the layout of CiA 302-3."""
    (count,), rest = struct.unpack("<I", data[:4]), data[4:]
    for _ in range(count):
        index, sub, size = struct.unpack("<HBI", rest[:7])
        yield (index, sub), rest[7 : 7 + size]
        rest = rest[7 + size :]
    assert not rest


class Strict(Device):
    """A device that takes a PDO apart and together as CiA 301 7.5.2.35 to 7.5.2.38 say, and in no other order."""

    def write(self, address: Address, data: bytes) -> None:
        index, sub = address
        number = int.from_bytes(data, "little")
        if 0x1400 <= index < 0x1C00:
            communication, mapping = index & ~0x200, index | 0x200
            in_use = not self.number(communication, 1) & IN_USE
            held = self.number(communication, 1)
            if (index, sub) == (communication, 1):
                refused = in_use and not number & IN_USE and number != held
            elif index == communication:
                refused = in_use and sub in (3, 6)
            else:
                refused = in_use or (sub > 0 and self.number(mapping, 0) > 0)
            if refused:
                raise canopen.SdoAbortedError(UNSUPPORTED)
        elif (
            index == 0x1014 and not self.number(index) & IN_USE and not number & IN_USE and number != self.number(index)
        ):
            raise canopen.SdoAbortedError(CANNOT_BE_CHANGED)
        self.local.set_data(index, sub, data, check_writable=True)


def device(node: int, description: Path) -> Strict:
    account = Account()
    made = Strict(account, Timers(account.lock), node, str(description))
    for index in [*range(0x1800, 0x1804), *range(0x1400, 0x1404)]:
        if index in made.local.object_dictionary:  # it starts with PDOs of its own, which are in use
            made.local.set_data(index, 1, (0x700 + index % 0x10).to_bytes(4, "little"))
            made.local.set_data(index | 0x200, 0, b"\1")
    return made


def described(log: Path) -> dict[int, Path]:
    options = eds_options(log)
    return {int(option[6:].split("=")[0]): Path(option.split("=", 2)[2]) for option in options}


CONFIGURED = [
    (log, node)
    for log in SESSIONS
    for known in (False, True)
    for node in written(log, described=known)
    if known == (node in described(log))
]


@pytest.mark.parametrize(("log", "node"), CONFIGURED, ids=lambda value: getattr(value, "stem", value))
def test_replayed_it_makes_the_device_what_it_was(log: Path, node: int, tmp_path: Path) -> None:
    known = described(log).get(node)
    truth = written(log, described=known is not None)[node]
    files = [tmp_path / name for name in ("a.cdcf", "a.eds", "a.dcf")]
    options = [part for pair in zip(("--concise-dcf", "--skeleton", "--dcf"), files, strict=True) for part in pair]
    run_canalyze(["od", log, "--node", str(node), *options, "--lang", "en", *eds_options(log)])
    target = device(node, known or files[1])
    order = list(steps(files[0].read_bytes()))
    for address, data in order:
        target.write(address, data)
    for address, data in truth.items():
        assert target.local.get_data(*address) == data, address
    assert {address for address, _ in order} == set(truth)
    told = json.loads(log.with_suffix(".json").read_text())["pdo"] if known else []
    sent = {(one["pdo"], *one["signals"]) for one in told if one["node"] == node}  # also what a reset took back
    for number in (index - 0x19FF for index, sub in truth if 0x1A00 <= index < 0x1C00 and sub == 0):
        if any(pdo == f"TPDO{number}" for pdo, *_ in sent):
            mapped = [f"{index:04X}:{sub:02X}" for (index, sub), _ in target.mapping(0x1A00, number)]
            assert (f"TPDO{number}", *mapped) in sent
    # Ours reads the same, and shows it as a description without defects; the DCF says the same.
    assert list(steps(files[0].read_bytes())) == order
    found, dcf = load(str(files[0])), load(str(files[2]))
    assert (found.form, found.defects) == ("concise", ())
    assert sum(len(thing.entries) for thing in found.objects) == len(truth)
    for address in truth:
        entry, other = found.entry(*address), dcf.entry(*address)
        assert entry and other and entry.parameter == other.parameter, address
    skeleton = load(str(files[1]))
    theirs = canopen.import_od(str(files[1]), node)
    assert (skeleton.form, skeleton.defects, skeleton.info.name) == ("eds", (), "a.eds")
    assert {thing.index for thing in skeleton.objects} == {index for index in theirs if index >= 0x1000}


def test_enough_is_replayed() -> None:
    assert len(CONFIGURED) > 10 and len({known for log, node in CONFIGURED if (known := described(log).get(node))}) > 2


def test_without_its_order_the_device_refuses() -> None:
    """The device of these tests is one that needs the order."""
    values = {(0x1A00, 1): struct.pack("<I", 0x60000108), (0x1800, 1): struct.pack("<I", 0x186)}
    for address in values:
        with pytest.raises(canopen.SdoAbortedError):
            device(6, EDS / "io.eds").write(address, values[address])


def test_the_order() -> None:
    """Of the capture, but for PDOs, which come together where their last value stands."""
    cob_id, number, entry = struct.pack("<I", 0x186), b"\1", struct.pack("<I", 0x60000108)
    values = {
        (0x2001, 0): b"\7",
        (0x1800, 1): cob_id,
        (0x1A00, 1): entry,
        (0x2000, 0): b"\5",
        (0x1A00, 0): number,
        (0x1800, 2): b"\xff",
        (0x1014, 0): struct.pack("<I", 0x86),
        (0x1801, 1): struct.pack("<I", 0x8000_0286),
        (0x1A01, 0): b"\0",
    }
    off = struct.pack("<I", 0x8000_0186)
    assert list(steps(concise(values))) == [
        ((0x2001, 0), b"\7"),
        ((0x2000, 0), b"\5"),
        *(((0x1800, 1), off), ((0x1800, 2), b"\xff"), ((0x1A00, 0), b"\0"), ((0x1A00, 1), entry)),
        *(((0x1A00, 0), number), ((0x1800, 1), cob_id)),
        *(((0x1014, 0), struct.pack("<I", 0x8000_0086)), ((0x1014, 0), struct.pack("<I", 0x86))),
        *(((0x1801, 1), struct.pack("<I", 0x8000_0286)), ((0x1A01, 0), b"\0")),
    ]
    # What was mapped, and how many, is not made up.
    assert list(steps(concise({(0x1A00, 1): entry}))) == [((0x1A00, 1), entry)]


def test_what_is_none() -> None:
    whole = concise({(0x1017, 0): b"\x64\0", (0x2000, 1): b"text that is long"})
    assert is_description(whole) and read(whole, "x").form == "concise"
    for other in (b"", whole[:-1], whole + b"\0", b"\3" + whole[1:], b"\0\0\0\0", whole[:4] + b"\1\0" + whole[6:]):
        assert not is_description(other)
    assert read((EDS.parent / "eds/drive.eds").read_bytes(), "x").form == "eds"
    assert not is_description((EDS.parent / "samples/stacks/a2-selfstart-heartbeat.log").read_bytes())


def test_types_are_those_of_the_standard_where_they_fit() -> None:
    values = {(0x1017, 0): b"\x64\0", (0x6060, 0): b"\xff", (0x2000, 1): b"a device", (0x2000, 2): bytes(9)}
    values |= {(0x1005, 0): b"\x80\0", (0x2000, 3): b"", (0x2000, 4): b"\xe8\3\0", (0x2000, 5): bytes(range(128, 140))}
    found = read(concise(values), "a.cdcf")
    kinds = {(e.index, e.sub): (e.type, e.parameter) for thing in found.objects for e in thing.entries}
    assert kinds[0x1017, 0] == (0x06, 100) and kinds[0x6060, 0] == (0x02, -1)
    assert kinds[0x1005, 0] == (0x06, 0x80)
    assert kinds[0x2000, 3][1] is None and kinds[0x2000, 4] == (0x16, 1000)
    assert kinds[0x2000, 5] == (0x0A, bytes(range(128, 140))) and kinds[0x2000, 2] == (0x0A, bytes(9))
    assert found.defects == ()
