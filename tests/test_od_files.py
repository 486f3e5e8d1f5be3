"""`canalyze od write`: a DCF has the configuration that was accepted; replayed, other files make a device what it was.

What is in the DCF is read back by our reader and by python-canopen; what was written is what a second, strict reader
of SDO has read. The concise DCF and the EDS are replayed into a device, and make it what the capture had configured.
Must not: take a value from the program that is not compared.
"""

from __future__ import annotations

import json
import random
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import canopen
import pytest
from captures import EDS, SAMPLES, SHARED, eds_options, read_log, run_canalyze, session_output
from network_nodes import Account, Device, Timers
from sdo_reading import read_transfers

from canalyze._core import DATA_TYPES, is_description
from canalyze.dictionary import REAL, Dictionary, contents, decoded, load, read
from canalyze.dictionary.files import concise, configured, skeleton
from canalyze.records import records
from canalyze.records.objects import Head, Object

SESSIONS = [*sorted((SAMPLES / "network").glob("*.log")), *sorted((SAMPLES / "stacks").glob("*.log"))]
WIDTHS = {kind: width for kind, (_, width) in DATA_TYPES.items() if width}
COMMANDS = {0x1003, 0x1010, 0x1011, 0x6040}
"""Objects whose writing is a command, as far as the sessions have them."""
EVERY = [*sorted(EDS.glob("*.eds")), *sorted((SHARED / "corpus/eds").rglob("*.[eEdD][dDcC][sSfF]"))]

Address = tuple[int, int]


def written(log: Path, *, described: bool) -> dict[int, dict[Address, bytes]]:
    """What was written and accepted last, by node and object; of what RPDOs are described to write, too, nothing."""
    told = json.loads(log.with_suffix(".json").read_text())
    carried = {
        (pdo["node"], *(int(part, 16) for part in place.split(":")))
        for pdo in told["pdo"]
        if described and pdo["pdo"].startswith("RPDO")
        for place in pdo.get("signals", ())
    }
    if "sdo" in told:
        rows = [(one["dir"], one["result"], one, bytes.fromhex(one["data"])) for one in told["sdo"]]
    else:
        read_all = read_transfers(read_log(log.read_bytes()))
        rows = [(one.direction, one.status, asdict(one), bytes(one.data)) for one in read_all]
    found: dict[int, dict[Address, bytes]] = {}
    for direction, result, one, data in rows:
        address = (int(one["index"], 16), one["sub"])
        configures = address[0] not in COMMANDS and (one["node"], *address) not in carried
        if (direction, result) == ("download", "ok") and configures:
            found.setdefault(one["node"], {})[address] = data
    return found


def parameters(found: Dictionary) -> dict[Address, Any]:
    """The values that a DCF configures."""
    entries = (entry for thing in found.objects for entry in thing.entries)
    return {(entry.index, entry.sub): entry.parameter for entry in entries if entry.parameter is not None}


def number(data: bytes, found: Dictionary, address: Address) -> Any:
    """The value of bytes by the type that the DCF has."""
    (entry,) = (e for thing in found.objects for e in thing.entries if (e.index, e.sub) == address)
    if entry.type == 0x09:
        return data.rstrip(b"\0").decode()
    if entry.type in (0x0A, 0x0F):
        return data
    signed = entry.type in (0x02, 0x03, 0x04)
    return int.from_bytes(data, "little", signed=signed)


@pytest.mark.parametrize("described", [True, False], ids=["over an EDS", "from traffic"])
@pytest.mark.parametrize("log", SESSIONS, ids=lambda path: path.stem)
def test_what_was_accepted_is_in_it(log: Path, described: bool, tmp_path: Path) -> None:
    options = eds_options(log) if described else []
    nodes = {int(option[6:].split("=")[0]) for option in options}
    for node, values in written(log, described=described).items():
        if described != (node in nodes):
            continue
        out = tmp_path / f"{node}.dcf"
        run_canalyze(["od", log, "--node", str(node), "--dcf", out, "--lang", "en", *options])
        found = read(out.read_bytes(), out.name)
        assert (found.form, found.node, found.defects) == ("dcf", node, ())
        got = parameters(found)
        assert got == {address: number(data, found, address) for address, data in values.items()}
        theirs = canopen.import_od(str(out), node)
        assert theirs.node_id == node
        for address, value in got.items():
            given = theirs.get_variable(*address)
            assert given is not None
            assert isinstance(value, bytes) or given.value == value, address


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\r\r\n"])
def test_values_stand_in_their_sections_however_lines_end(end: str) -> None:
    text = (EDS / "drive.eds").read_text("utf-8").replace("\n", end)
    made = configured(text.encode(), "drive.eds", {(0x1017, 0): b"\x64\0"}, 5, {"FileName": "x.dcf"})
    found = read(made.text.encode(), "x.dcf")
    assert (made.values, parameters(found)[0x1017, 0], found.node, found.info.name) == (1, 100, 5, "x.dcf")
    before = read(text.encode(), "drive.eds")
    assert [(one.index, one.name) for one in found.objects] == [(one.index, one.name) for one in before.objects]


def test_the_sessions_configure_something() -> None:
    described = [values for log in SESSIONS for values in written(log, described=False).values()]
    assert sum(map(len, described)) > 60


@pytest.mark.parametrize("eds", EVERY, ids=lambda path: path.name)
def test_any_description_takes_values(eds: Path) -> None:
    """Seeded values are read back, every line of the file is still there, and nothing new is wrong with it."""
    data, name = contents(str(eds))
    before = read(data, name)
    source = random.Random(eds.name)
    entries = [e for thing in before.objects for e in thing.entries if not 0x1400 <= e.index < 0x1C00]
    chosen = [entry for entry in entries if entry.type in WIDTHS and entry.type not in REAL and entry.line]
    values = {
        (entry.index, entry.sub): source.randrange(1 << WIDTHS[entry.type]).to_bytes(
            -(-WIDTHS[entry.type] // 8), "little"
        )
        for entry in source.sample(chosen, min(50, len(chosen)))
    }
    made = configured(data, name, values, 5, {"FileName": "of 5.dcf"})
    assert made.values == len(values) - len(made.left_out) and len(made.left_out) < len(values) / 2
    after = read(made.text.encode(), "of 5.dcf")
    assert (after.form, after.node, after.info.name) == ("dcf", 5, "of 5.dcf")
    got = parameters(after)
    for address, value in values.items():
        if address not in made.left_out:
            assert got[address] == decoded(value, _entry(after, address).type), address
    kept = parameters(before)
    assert {address: got[address] for address in kept if address not in values} == {
        address: value for address, value in kept.items() if address not in values
    }
    new = Counter(one.code for one in after.defects) - Counter(one.code for one in before.defects)
    assert not new
    for line in made.text.splitlines():
        assert "\r" not in line


def _entry(found: Dictionary, address: Address) -> Any:
    return next(e for thing in found.objects for e in thing.entries if (e.index, e.sub) == address)


def test_an_array_without_sections_of_its_own() -> None:
    eds = b"""[DeviceInfo]\n[ManufacturerObjects]\nSupportedObjects=1\n1=0x2000
[2000]\nParameterName=Gain\nObjectType=0x8\nDataType=0x0006\nAccessType=rw\nCompactSubObj=4
[2000Value]\nNrOfEntries=1\n3=7\n"""
    made = configured(eds, "a.eds", {(0x2000, 1): b"\1\0", (0x2000, 3): b"\2\0", (0x2000, 5): b"\3\0"}, 5, {})
    assert (made.values, made.left_out) == (2, ((0x2000, 5),))
    assert parameters(read(made.text.encode(), "a.dcf")) == {(0x2000, 1): 1, (0x2000, 3): 2}
    assert "NrOfEntries=2" in made.text and "3=7" not in made.text


def test_what_a_file_cannot_hold_is_left_out() -> None:
    eds = (EDS / "drive.eds").read_bytes()
    values = {(0x1017, 0): b"\x64\0\0\1", (0x2345, 0): b"\1", (0x1008, 0): b"two\nlines", (0x1006, 0): b"\1\0\0\0"}
    made = configured(eds, "drive.eds", values, 5, {})
    assert made.left_out == ((0x1008, 0), (0x1017, 0), (0x2345, 0))
    assert parameters(read(made.text.encode(), "a.dcf")) == {(0x1006, 0): 1}


@pytest.mark.parametrize("folder", ["", "network", "stacks", "stories", "rules"])
def test_a_skeleton_has_what_was_seen_and_no_defect(folder: str) -> None:
    nodes = 0
    for log in sorted((SAMPLES / folder).glob("*.log")):
        output = session_output([log.read_bytes()], name=log.name, output_format="objects", lang="en")
        for node in records(output, Head):
            objects = [one for one in records(output, Object) if (one.bus, one.node) == (node.bus, node.node)]
            found = read(skeleton(node, objects).encode(), "seen.eds")
            assert found.defects == (), log
            there = {(entry.index, entry.sub): entry for thing in found.objects for entry in thing.entries}
            for one in objects:
                address = one.address
                assert one.exists is not True or address in there
                if one.exists and one.access in ("rw", "ro", "wo"):
                    assert there[address].access == one.access
            nodes += 1
    assert nodes > 3


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
