"""Objects that the traffic shows -> an EDS of them, for a device whose own is lost: all that it says was seen.

What CiA 301 has every device have is there, with or without a value; names, types and access as far as they are known.
Must not: say more of a device than what was seen.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from canalyze import _core
from canalyze.dictionary.values import BY_WIDTH, CODES, UNSIGNED8, UNSIGNED32
from canalyze.records.inventory import Head, Object

_OCTETS: Final = 0x0A
_ACCESS: Final = {"rw": "rw", "ro": "ro", "wo": "wo", "r": "ro"}
"""Of what was read and never written it is not known that it can be."""
_RECORDS: Final = frozenset({0x1003, 0x1010, 0x1011, 0x1016, 0x1018, 0x1028, 0x1029})
_RECORD_RANGES: Final = (range(0x1200, 0x1400), range(0x1400, 0x1C00))
"""Objects whose sub-index 0 alone does not make them a variable."""
_MANDATORY: Final = {
    (0x1000, 0): ("Device type", UNSIGNED32),
    (0x1001, 0): ("Error register", UNSIGNED8),
    (0x1018, 1): ("Vendor-ID", UNSIGNED32),
}
_TITLES: Final = {0x1018: "Identity object"}
_FIXED: Final = range(0x1000, 0x2000)
"""Where what was read and never written is what the device starts with."""

_Keys = dict[str, str]


def skeleton(node: Head, objects: Sequence[Object], name: str = "") -> str:
    """Give the EDS of a node; name: that of the file."""
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
    """Let the core give the PDOs that the objects configure."""
    rows = [
        (
            *one.address,
            "",
            CODES.get(one.type or "", 0),
            "rw",
            one.value,
            False,
            True,
            False,
            "",
            1.0,
        )
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
    """Give the keys of all entries: what was seen, what is mapped, and what every device has."""
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
    """Give a text as it can stand behind a key."""
    return "".join(char for char in text if char.isprintable()).strip()


def _object(index: int, subs: Mapping[int, _Keys], title: str | None) -> Iterator[tuple[str, _Keys]]:
    """Give the sections of an object."""
    record = len(subs) > 1 or index in _RECORDS or any(index in one for one in _RECORD_RANGES)
    if not record:
        yield f"{index:04X}", {"ObjectType": "0x7", **subs[0]}
        return
    first = next((keys["ParameterName"] for sub, keys in subs.items() if sub), subs[0]["ParameterName"])
    yield f"{index:04X}", {"ParameterName": title or first, "ObjectType": "0x9", "SubNumber": str(len(subs))}
    for sub, keys in subs.items():
        yield f"{index:04X}sub{sub:X}", {"ObjectType": "0x7", **keys}
