"""Files made from the objects of a device: an EDS, a DCF (CiA 306), a concise DCF (1F22h, CiA 302-3), a DBC file.

The EDS is for a device whose own is lost: it contains the objects that CiA 301 requires, with or without a value;
names, types and access as far as they are known. The DCF is a description with ParameterValue and a node-ID, inserted
by the core. The concise DCF contains values in the order in which a configuration manager writes them: the number of
entries (4 bytes), then for each entry index (2), sub-index (1), size (4) and data, little-endian. The DBC file has the
PDOs for other tools: they, the bits of their signals and their types come from the core; here they get names that are
valid there, and parts that it cannot hold are listed, each with a key of `words` and its facts. cantools is imported
only if one is written. Must not: contain more about a device than was seen, or decide what is configuration.
"""

import math
import re
import struct
import unicodedata
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from canalyze import _core
from canalyze.dictionary import BY_WIDTH, CODES, UNSIGNED8, UNSIGNED32, Address
from canalyze.errors import CanalyzeError, OutputError, SourceError, needed
from canalyze.records import records
from canalyze.records.objects import Head, MappedObject, MappedPdo, Object
from canalyze.words import Words

if TYPE_CHECKING:
    from cantools.database.can import Message, Signal
    from cantools.database.namedsignalvalue import NamedSignalValue

    from canalyze.dictionary import Entry

Described = Callable[[str | None, int, int, int], "Entry | None"]
"""Returns the entry of a description for bus, node-ID, index and sub-index."""
Said = tuple[str, dict[str, object]]
"""A key of `words`, and its facts."""

ENCODING: Final = "cp1252"
"""The encoding of DBC files."""
_MOST_BITS: Final = 64
_ADDRESS: Final = "address"
"""The first four bytes of a multiplex PDO."""
_ADDRESS_BITS: Final = 32
_CYCLIC: Final = range(1, 241)
_EVENTS: Final = (254, 255)
_SAYS: Final = {kind: f"dbc.{kind}" for kind in ("unknown", "contradicted", "disabled")}


class Made(NamedTuple):
    """A DBC file."""

    data: bytes
    messages: int
    signals: int
    said: tuple[Said, ...]
    """The parts of the PDOs that are missing or changed in the file."""


def database(result: bytes, described: Described) -> Made:
    """Returns the DBC of one bus, by JSON lines of the core.

    Raises CanalyzeError if cantools is not installed, and OutputError if there is nothing to write.
    """
    with needed(CanalyzeError, "cantools", "dbc"):
        from cantools.database.can import Database, Node
    pdos = list(records(result, MappedPdo))
    further = sum(one.further for one in pdos)
    said: list[Said] = [("dbc.further", {"count": further})] if further else []
    if len(buses := sorted({str(one.bus) for one in pdos})) > 1:
        raise OutputError("dbc.buses", buses=", ".join(buses))
    messages: list[Message] = []
    for _, group in groupby(pdos, lambda one: (one.extended, one.id)):
        message = _message(list(group), described, said)
        if message:
            if message.name in {one.name for one in messages}:  # a PDO that had another identifier, too
                message.name += f"_{message.frame_id:X}"
            messages.append(message)
    if not messages:
        raise OutputError("dbc.none")
    nodes = [Node(_node(node)) for node in sorted({one.node for one in pdos})]
    text = Database(messages, nodes, strict=True).as_dbc_string(sort_signals=None)
    data = text.encode(ENCODING, "replace")
    if data.decode(ENCODING) != text:
        said.append(("dbc.encoding", {}))
    return Made(data, len(messages), sum(len(one.signals) for one in messages), tuple(said))


def _message(group: list[MappedPdo], described: Described, said: list[Said]) -> "Message | None":
    """Returns the message of an identifier from the PDOs that use it."""
    from cantools.database.can import Message

    group.sort(key=lambda one: (bool(one.signals), one.frames, one.transmit), reverse=True)
    first = group[0]
    sender = next((one for one in group if one.transmit), None)
    facts: dict[str, object] = {"id": first.id, "pdo": first.pdo, "node": first.node}
    for other in group[1:]:
        if other.signals and (other.transmit or sender is None):
            said.append(("dbc.shared", {**facts, "other": other.pdo, "other_node": other.node}))
    if first.content in _SAYS:
        said.append((_SAYS[first.content], {**facts, "frames": first.frames}))
        return None
    if first.changes:
        said.append(("dbc.changed", {**facts, "changes": first.changes}))
    if first.bits > _MOST_BITS:
        said.append(("dbc.long", {**facts, "bits": first.bits}))
        return None
    receivers = [_node(one.node) for one in group if not one.transmit]
    signals = list(_signals(first, receivers, described, facts, said))
    if not signals:
        said.append(("dbc.empty", facts))
        return None
    multiplexed = first.content != "mapped"
    return Message(
        int(first.id, 16),
        f"{_node((sender or first).node)}_{(sender or first).pdo}",
        8 if multiplexed else math.ceil(first.bits / 8),
        signals,
        senders=[_node(sender.node)] if sender else [],
        cycle_time=_cycle(sender) if sender else None,
        is_extended_frame=first.extended,
        strict=True,
    )


def _signals(
    pdo: MappedPdo, receivers: list[str], described: Described, facts: dict[str, object], said: list[Said]
) -> "Iterator[Signal]":
    from cantools.database.can import Signal
    from cantools.database.conversion import BaseConversion

    if pdo.content != "mapped" and pdo.signals:
        yield Signal(_ADDRESS, 0, _ADDRESS_BITS, is_multiplexer=True, receivers=receivers)
    taken = {_ADDRESS}
    for one in pdo.signals:
        factor = float(one.factor)
        if one.number == "bytes" or not math.isfinite(factor):
            said.append(("dbc.bytes", {**facts, "signal": one.name, "bits": one.bits}))
            continue
        entry = described(pdo.bus, one.node or 0, int(one.index, 16), one.sub)
        limits = (entry.low, entry.high) if entry else ()
        factor = int(factor) if factor.is_integer() else factor
        ends = sorted(limit * factor for limit in limits if limit is not None)
        choices = OrderedDict[int, "str | NamedSignalValue"]((word.value, word.text) for word in one.words)
        yield Signal(
            _unique(one, pdo, taken),
            one.offset,
            one.bits,
            is_signed=one.number == "signed",
            conversion=BaseConversion.factory(factor, 0, choices or None, is_float=one.number == "real"),
            minimum=ends[0] if len(ends) == 2 else None,
            maximum=ends[1] if len(ends) == 2 else None,
            unit=_plain(one.unit or "") or None,
            comment=_plain(" ".join(dict.fromkeys((f"{one.index}h:{one.sub:02X}", one.name)))),
            receivers=receivers,
            multiplexer_ids=None if one.address is None else [one.address],
            multiplexer_signal=None if one.address is None else _ADDRESS,
        )


def identifier(text: str) -> str:
    """Returns the letters and digits of a text, joined by _."""
    letters = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return re.sub("[^0-9A-Za-z]+", "_", letters).strip("_")


def _node(node: int) -> str:
    return f"Node{node}"


def _cycle(pdo: MappedPdo) -> int | None:
    """Returns the cycle time in ms, if it is known and a whole number as a DBC requires."""
    if pdo.type is not None and pdo.type in _CYCLIC and pdo.sync_ns:
        time, rest = divmod(pdo.type * pdo.sync_ns, 1_000_000)
        return None if rest else time
    return (pdo.event_timer or None) if pdo.type in _EVENTS else None


def _unique(one: MappedObject, pdo: MappedPdo, taken: set[str]) -> str:
    """Returns a valid name of a signal that is unique in its message."""
    name = identifier(one.name)
    place = f"{one.index}h_{one.sub:02X}"
    names = [name if re.match("[A-Za-z]", name) else f"Obj_{place}"]
    names += [f"{names[0]}_{place}", f"{names[0]}_{place}_Node{one.node or 0}"]
    numbered = (f"{names[0]}_{number}" for number in range(2, 2 + len(taken)))
    found = next(name for name in (*names, *numbered) if name not in taken)
    taken.add(found)
    return found


def _plain(text: str) -> str:
    """Returns a text without the characters that are invalid within quotes."""
    return "".join(char if char.isprintable() else " " for char in text).replace('"', "'").replace("\\", "/")


class Configured(NamedTuple):
    """A DCF."""

    text: str
    values: int
    """Number of values in it."""
    left_out: tuple[Address, ...]
    """Objects that are not in the description, or whose value it cannot hold."""


def configured(
    description: bytes, name: str, values: Mapping[Address, bytes], node: int, keys: Mapping[str, str]
) -> Configured:
    """Inserts values, as SDO transfers them, into a description read from `name`. Raises SourceError for other files.

    keys: entries of [FileInfo].
    """
    try:
        text, left_out = _core.configured(description, values, node, list(keys.items()))
    except _core.DescriptionError as error:
        key, facts = error.args
        raise SourceError(key, name=name, **facts) from None
    return Configured(text, len(values) - len(left_out), tuple(left_out))


_COUNT: Final = struct.Struct("<I")
_ENTRY: Final = struct.Struct("<HBI")
_PDOS: Final = range(0x1400, 0x1C00)
_MAPPING: Final = 0x200
"""The index bit in which the mapping parameter of a PDO differs from its communication parameter."""
_INVALID: Final = 0x80
"""Bit 31 of a COB-ID, in its last byte: not in use."""


def concise(values: Mapping[Address, bytes]) -> bytes:
    """Returns a concise DCF; `values` are in the order in which the device accepted them.

    A PDO is configured by the rules of CiA 301 (7.5.2.36, 7.5.2.38), at the place of its last value: its COB-ID
    disables it, the number of mapped objects is set to 0, and both get their values after all others. A COB-ID that
    may not be changed while in use is disabled first.
    """
    written = list(_written(values))
    return _COUNT.pack(len(written)) + b"".join(_ENTRY.pack(*address, len(data)) + data for address, data in written)


def _written(values: Mapping[Address, bytes]) -> Iterator[tuple[Address, bytes]]:
    """Yields all values to write, in order."""
    pdos: dict[int, list[Address]] = {}
    for index, sub in values:
        if index in _PDOS:
            pdos.setdefault(index & ~_MAPPING, []).append((index, sub))
    for address, data in values.items():
        communication = address[0] & ~_MAPPING
        if address[0] not in _PDOS:
            if _is_fixed_in_use(address) and _invalid(data) != data:
                yield address, _invalid(data)
            yield address, data
        elif address == pdos[communication][-1]:
            yield from _pdo(communication, {one: values[one] for one in pdos[communication]})


def _pdo(communication: int, values: dict[Address, bytes]) -> Iterator[tuple[Address, bytes]]:
    """Yields the values of one PDO."""
    cob_id, number = (communication, 1), (communication | _MAPPING, 0)
    last = {address: values.pop(address) for address in (number, cob_id) if address in values}
    first = {cob_id: _invalid(last[cob_id])} if cob_id in last else {}
    parameters = {address: data for address, data in values.items() if address[0] == communication}
    mapped = {address: data for address, data in values.items() if address[0] != communication}
    if number in last:
        mapped = {number: bytes(len(last[number])), **mapped}
    yield from {**first, **parameters, **mapped}.items()
    yield from ((address, data) for address, data in last.items() if {**first, **mapped}.get(address) != data)


def _invalid(cob_id: bytes) -> bytes:
    return cob_id[:3] + bytes([cob_id[3] | _INVALID]) if len(cob_id) == 4 else cob_id


def _is_fixed_in_use(address: Address) -> bool:
    """Returns true for a COB-ID, other than that of a PDO, that may not be changed while in use."""
    return address == (0x1014, 0) or (0x1201 <= address[0] <= 0x12FF and address[1] in (1, 2))


_OCTETS: Final = 0x0A
_ACCESS: Final = {"rw": "rw", "ro": "ro", "wo": "wo", "r": "ro"}
"""An object that was read and never written is not known to be writable."""
_RECORDS: Final = frozenset({0x1003, 0x1010, 0x1011, 0x1016, 0x1018, 0x1028, 0x1029})
_RECORD_RANGES: Final = (range(0x1200, 0x1400), range(0x1400, 0x1C00))
"""Objects that are no variable even if only sub-index 0 is known."""
_MANDATORY: Final = {
    (0x1000, 0): ("Device type", UNSIGNED32),
    (0x1001, 0): ("Error register", UNSIGNED8),
    (0x1018, 1): ("Vendor-ID", UNSIGNED32),
}
_TITLES: Final = {0x1018: "Identity object"}
_FIXED: Final = range(0x1000, 0x2000)
"""Objects whose value is the default if it was read and never written."""

_Keys = dict[str, str]


def skeleton(node: Head, objects: Sequence[Object], name: str = "") -> str:
    """Returns the EDS of a node; `name` is that of the file."""
    pdos = _pdos(objects)
    titles = {pdo.communication: f"{pdo.direction.upper()} communication parameter" for pdo in pdos}
    titles |= {_mapping(pdo): f"{pdo.direction.upper()} mapping parameter" for pdo in pdos} | _TITLES
    entries = _entries(objects, pdos)
    by_index: dict[int, dict[int, _Keys]] = {}
    for (index, sub), keys in sorted(entries.items()):
        by_index.setdefault(index, {})[sub] = keys
    lists = {
        "MandatoryObjects": [index for index in by_index if any(index == one for one, _ in _MANDATORY)],
        "OptionalObjects": [],
        "ManufacturerObjects": [index for index in by_index if 0x2000 <= index < 0x6000],
    }
    listed = {index for indices in lists.values() for index in indices}
    lists["OptionalObjects"] = [index for index in by_index if index not in listed]
    sections = {
        "FileInfo": {"FileName": name, "FileVersion": "1", "FileRevision": "0", "EDSVersion": "4.0"},
        "DeviceInfo": _device(node, pdos),
        "DummyUsage": {f"Dummy{kind:04X}": "0" if kind == 1 else "1" for kind in range(1, 8)},
    }
    for name, indices in lists.items():
        numbered = {str(number): f"{index:#06x}" for number, index in enumerate(indices, 1)}
        sections[name] = {"SupportedObjects": str(len(indices)), **numbered}
        for index in indices:
            sections |= _object(index, by_index[index], titles.get(index))
    return "\n".join(
        f"[{name}]\n" + "".join(f"{key}={value}\n" for key, value in keys.items()) for name, keys in sections.items()
    )


def _pdos(objects: Sequence[Object]) -> "list[_core.Pdo]":
    """Returns the PDOs that the objects configure, from the core."""
    rows = [
        (*one.address, "", CODES.get(one.type or "", 0), "rw", one.value, False, True, False, "", 1.0)
        for one in objects
        if isinstance(one.value, int) and one.type_from in ("standard", "eds")
    ]
    return _core.Dictionary(file="", form="dcf", device="", rows=rows).pdos(range(1, 0x20))


def _device(node: Head, pdos: "Sequence[_core.Pdo]") -> _Keys:
    numbers = {"VendorNumber": node.vendor_id, "ProductNumber": node.product_code, "RevisionNumber": node.revision}
    return {
        "VendorName": "",
        "ProductName": _line(node.device_name or ""),
        **{key: f"0x{number}" for key, number in numbers.items() if number},
        **{f"BaudRate_{rate}": "0" for rate in (10, 20, 50, 125, 250, 500, 800, 1000)},
        "Granularity": "8",
        "NrOfRXPDO": str(sum(pdo.direction == "rpdo" for pdo in pdos)),
        "NrOfTXPDO": str(sum(pdo.direction == "tpdo" for pdo in pdos)),
        "LSS_Supported": "0",
    }


def _mapping(pdo: "_core.Pdo") -> int:
    return _core.mapping_parameter(pdo.direction, pdo.number)


def _entries(objects: Sequence[Object], pdos: "Sequence[_core.Pdo]") -> dict[tuple[int, int], _Keys]:
    """Returns the keys of all entries: objects in the traffic, mapped objects, and mandatory objects."""
    entries: dict[tuple[int, int], _Keys] = {}
    for one in objects:
        if one.exists:
            entries[one.address] = _seen(one, one.address[0])
    for pdo in pdos:
        entries.setdefault((_mapping(pdo), 0), _keys("Number of mapped objects", UNSIGNED8, "rw"))
        for mapped in (mapped for mapped in pdo.mapped if not mapped.dummy):
            made = _keys(_named(mapped.index, mapped.sub), BY_WIDTH.get(mapped.bits, _OCTETS), "rw")
            entries.setdefault((mapped.index, mapped.sub), made)["PDOMapping"] = "1"
    for address, (name, kind) in _MANDATORY.items():
        entries.setdefault(address, _keys(name, kind, "ro"))
    for index in {index for index, sub in entries if sub}:
        most = max(sub for one, sub in entries if one == index)
        entries.setdefault(
            (index, 0), {**_keys("Highest sub-index supported", UNSIGNED8, "ro"), "DefaultValue": str(most)}
        )
    return entries


def _seen(one: Object, index: int) -> _Keys:
    kind = CODES.get(one.type or "") or BY_WIDTH.get(one.bits or 0, _OCTETS)
    keys = _keys(_line(one.name or "") or _named(index, one.sub), kind, _ACCESS.get(one.access or "", "rw"))
    if one.tpdo or one.rpdo:
        keys["PDOMapping"] = "1"
    fixed = index in _FIXED and one.read and not one.written
    if fixed and isinstance(one.value, int | str):
        keys["DefaultValue"] = str(int(one.value) if isinstance(one.value, int) else _line(one.value))
    return keys


def _keys(name: str, kind: int, access: str) -> _Keys:
    return {"ParameterName": name, "DataType": f"{kind:#06x}", "AccessType": access, "PDOMapping": "0"}


def _named(index: int, sub: int) -> str:
    return f"{index:04X}h:{sub:02X}"


def _line(text: str) -> str:
    """Returns a text that is valid as a value of a key."""
    return "".join(char for char in text if char.isprintable()).strip()


def _object(index: int, subs: Mapping[int, _Keys], title: str | None) -> Iterator[tuple[str, _Keys]]:
    """Yields the sections of an object."""
    record = len(subs) > 1 or index in _RECORDS or any(index in one for one in _RECORD_RANGES)
    if not record:
        yield f"{index:04X}", {"ObjectType": "0x7", **subs[0]}
        return
    first = next((keys["ParameterName"] for sub, keys in subs.items() if sub), subs[0]["ParameterName"])
    yield f"{index:04X}", {"ParameterName": title or first, "ObjectType": "0x9", "SubNumber": str(len(subs))}
    for sub, keys in subs.items():
        yield f"{index:04X}sub{sub:X}", {"ObjectType": "0x7", **keys}


class Of(NamedTuple):
    """The data that files are made of."""

    node: int
    head: Head
    objects: list[Object]
    values: dict[Address, bytes]
    """Values that were written and accepted, in that order; no bytes where not all of them are there."""
    description: tuple[bytes, str] | None
    """The device's own, and its name."""


class File(NamedTuple):
    """A file that is made."""

    data: bytes
    said: str
    """Key of the sentence that says what is in it."""
    size: int
    """Values, or objects, in it."""
    left_out: Sequence[Address] = ()


def of(result: bytes, node: int, description: tuple[bytes, str] | None) -> Of:
    """Chooses what belongs to a node in JSON lines; OutputError where there is none, or there are several."""
    heads = [one for one in records(result, Head) if one.node == node]
    if len(heads) > 1:
        raise OutputError("od.buses", node=node, buses=", ".join(str(one.bus) for one in heads))
    if not heads:
        raise OutputError("od.no_node", node=node)
    objects = [one for one in records(result, Object) if one.node == node]
    written = [(one.configured, one.address) for one in objects if one.configured]
    written.sort(key=lambda row: row[0].frame)
    values = {address: held.whole or b"" for held, address in written}
    return Of(node, heads[0], objects, values, description)


def made(form: str, name: str, of: Of, words: Words) -> tuple[bytes, list[str]]:
    """Makes the file of that name; give its content and the line about it. form: one of FORMS.

    OutputError where there is nothing to be written.
    """
    file = FORMS[form](name, of)
    said = [words(file.said, name=name, node=of.node, count=file.size)]
    if file.left_out:
        missing = ", ".join(f"{index:04X}h:{sub:02X}" for index, sub in file.left_out)
        said.append(words("od.left_out", name=name, objects=missing))
    return file.data, said


def _dcf(name: str, of: Of) -> File:
    _configured(of)
    keys = {"FileName": Path(name).name}
    if of.description is not None:
        keys["LastEDS"] = Path(of.description[1]).name
    description = of.description or (skeleton(of.head, of.objects).encode(), name)
    found = configured(*description, of.values, of.node, keys)
    return File(found.text.encode(), "od.written", found.values, found.left_out)


def _concise(_: str, of: Of) -> File:
    _configured(of)
    values = {address: data for address, data in of.values.items() if data}
    return File(concise(values), "od.written", len(values), sorted(set(of.values) - set(values)))


def _skeleton(name: str, of: Of) -> File:
    return File(skeleton(of.head, of.objects, Path(name).name).encode(), "od.skeleton_written", len(of.objects))


def _configured(of: Of) -> None:
    if not of.values:
        raise OutputError("od.dcf_none", node=of.node)


FORMS: Final[dict[str, Callable[[str, Of], File]]] = {"dcf": _dcf, "concise_dcf": _concise, "skeleton": _skeleton}
"""By the names of their options."""
