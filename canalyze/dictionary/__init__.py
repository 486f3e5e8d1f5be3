"""EDS and DCF (CiA 306), XDD and concise DCF -> a frozen `Dictionary`, by a reader that takes them as they are found.

    bytes --encoding--> text --ini--> sections --objects, values--> objects --table--> the core's table, PDOs
      |                 XML  --xdd-----^
      +--concise--> entries of a concise DCF

What had to be repaired or could not be used becomes a `Defect`; only a file in which there is no object at all, or
which the system does not give, is an error (`SourceError`). python-canopen is imported only where its own objects are
taken or given.
"""

import re
from typing import TYPE_CHECKING, Final

from canalyze.configuration.network import NODES
from canalyze.dictionary import concise, model
from canalyze.dictionary.ini import Ini, Section, parse
from canalyze.dictionary.model import Device, Dictionary, FileInfo, Form
from canalyze.dictionary.values import Values, integer
from canalyze.errors import SourceError

if TYPE_CHECKING:
    from canopen import ObjectDictionary

_NAMES: Final = (".eds", ".dcf", ".xdd", ".xdc", ".cdcf")
_HEAD: Final = 1 << 16
_SECTION: Final = re.compile(rb"^[ \t]*\[(?:FileInfo|DeviceInfo|1000)\]", re.IGNORECASE | re.MULTILINE)
_LARGEST: Final = 8 << 20
_BIT_RATES: Final = (10, 20, 50, 125, 250, 500, 800, 1000)
_UNCONFIGURED: Final = 255
_DUMMIES: Final = range(1, 8)
_FURTHER_DUMMIES: Final = range(8, 0x20)


def load(name: str, node: int | None = None) -> Dictionary:
    """Read a file ('-' is standard input); `node` overrules the node-ID of a DCF."""
    return read(*contents(name), node)


def describes(name: str) -> bool:
    """Tell whether a file is a description, by its name or how it begins, and no capture."""
    if name.lower().endswith(_NAMES):
        return True
    try:
        with open(name, "rb") as file:
            data = file.read(_HEAD)
    except OSError:  # standard input, and what can be read by nobody
        return False
    return data.lstrip().startswith(b"<?xml") or bool(_SECTION.search(data)) or concise.entries(data) is not None


def contents(name: str) -> tuple[bytes, str]:
    """Give the bytes of a file ('-' is standard input), and its name for messages."""
    from canalyze.sources.file import Source

    data = bytearray()
    with Source(name) as source:
        while piece := source.read():
            data += piece
            if len(data) > _LARGEST:
                raise SourceError("eds.large", name=source.name, most=_LARGEST >> 20)
    return bytes(data), source.name


def read(data: bytes, name: str, node: int | None = None) -> Dictionary:
    """Read a description from its bytes; `name` is for messages."""
    from canalyze.dictionary.encoding import decode
    from canalyze.dictionary.objects import Objects
    from canalyze.dictionary.table import pdos, table

    if not data.strip():
        raise SourceError("source.empty", name=name)
    entries = concise.entries(data)
    text, encoding, marked = decode(data) if entries is None else ("", "binary", False)
    xml = text.lstrip("\ufeff \t\r\n").startswith("<")  # which no EDS looks like
    partial = entries is not None
    if entries is not None:
        ini = concise.sections(entries)
    elif xml:
        from canalyze.dictionary.xdd import sections

        ini = sections(data, name)
    else:
        ini = parse(text)
    if marked:
        ini.complain(1, "bom")
    if encoding not in ("utf-8", "binary") and not xml:
        ini.complain(_first_beyond_ascii(text), "encoding", encoding=encoding)
    values = Values(ini)
    device, mask = _device(ini, values)
    objects = Objects(ini, values, has_lists=not xml and not partial).read(mask, (device.rpdos or 0, device.tpdos or 0))
    if not objects:
        raise SourceError("eds.nothing", name=name)
    dummies = _dummies(ini, values)
    commissioning = _commissioning(ini)
    filed, node_name, rate = _node(commissioning, ini, values)
    configured = commissioning is not None or any(e.parameter is not None for o in objects.values() for e in o.entries)
    form: Form = "concise" if partial else "xdd" if xml else "dcf" if configured else "eds"
    _say_modules(ini, values)
    made = table(name, form, device.product_name, objects.values())
    found = tuple(
        pdos(made, dummies, objects, Ini() if partial else ini)
    )  # what a part of a configuration lacks is no defect
    return Dictionary(
        file=name,
        form=form,
        encoding=encoding,
        info=_info(ini),
        device=device,
        comments=_comments(ini),
        node=filed if node is None else node,
        node_name=node_name,
        bit_rate=rate,
        objects=tuple(objects.values()),
        dummies=dummies,
        table=made,
        pdos=found,
        defects=ini.defects,
    )


def taken(given: "ObjectDictionary", name: str) -> Dictionary:
    """Take what python-canopen has read or a program has put together, by way of the EDS that it writes."""
    from canalyze.dictionary import library
    from canalyze.dictionary.table import table

    found = read(library.written(given).encode(), name)
    objects = []
    for one in found.objects:  # of what that EDS leaves out, the unit and the factor count
        variables = library.variables(given, one.index)
        entries = (
            entry._replace(unit=variables[entry.sub].unit, factor=float(variables[entry.sub].factor))
            if entry.sub in variables
            else entry
            for entry in one.entries
        )
        objects.append(one._replace(entries=tuple(entries)))
    made = table(name, found.form, found.device.product_name, objects)
    return found._replace(objects=tuple(objects), table=made, node=given.node_id)


def _first_beyond_ascii(text: str) -> int:
    """Give the line on which the encoding first mattered."""
    return next((number for number, line in enumerate(text.splitlines(), 1) if not line.isascii()), 1)


def _text(section: Section | None, key: str) -> str:
    return (section.text(key) if section else None) or ""


def _info(ini: Ini) -> FileInfo:
    section = ini.section("FileInfo")

    def joined(*keys: str) -> str:
        return " ".join(text for key in keys if (text := _text(section, key)))

    return FileInfo(
        name=joined("FileName"),
        version=joined("FileVersion"),
        revision=joined("FileRevision"),
        eds_version=joined("EDSVersion"),
        description=joined("Description"),
        created=joined("CreationDate", "CreationTime", "CreatedBy"),
        modified=joined("ModificationDate", "ModificationTime", "ModifiedBy"),
    )


def _device(ini: Ini, values: Values) -> tuple[Device, int]:
    """Give the device, and the mask of CompactPDO."""
    section = ini.section("DeviceInfo") or Section("DeviceInfo", 0)

    def whole(key: str) -> int | None:
        return values.whole(section.get(key))

    rates = tuple(rate * 1000 for rate in _BIT_RATES if whole(f"BaudRate_{rate}"))
    lss = whole("LSS_Supported")
    device = Device(
        section.text("VendorName"),
        whole("VendorNumber"),
        section.text("ProductName"),
        whole("ProductNumber"),
        whole("RevisionNumber"),
        section.text("OrderCode"),
        rates,
        whole("NrOfRXPDO"),
        whole("NrOfTXPDO"),
        None if lss is None else bool(lss),
    )
    return device, whole("CompactPDO") or 0


def _dummies(ini: Ini, values: Values) -> frozenset[int]:
    """Give the data types that DummyUsage allows; the first seven have to be named."""
    section = ini.section("DummyUsage")
    if section is None:
        return frozenset()
    missing = [f"Dummy{kind:04X}" for kind in _DUMMIES if f"dummy{kind:04x}" not in section.keys]
    if missing:
        ini.complain(section.line, "dummy-missing", keys=", ".join(missing))
    kinds = (*_DUMMIES, *_FURTHER_DUMMIES)
    return frozenset(kind for kind in kinds if values.whole(section.get(f"Dummy{kind:04X}")))


def _commissioning(ini: Ini) -> Section | None:
    """Find the section that CiA 306 spells with one m in the middle, and people with two."""
    section = ini.section("DeviceComissioning")
    other = ini.section("DeviceCommissioning")
    if other is not None:
        ini.complain(other.line, "commissioning", section=other.name)
    return section or other


def _node(section: Section | None, ini: Ini, values: Values) -> tuple[int | None, str, int | None]:
    """Give node-ID, name and bit rate of a DCF."""
    if section is None:
        return None, "", None
    key = section.get("NodeID")
    node = values.whole(key)
    if key and node is not None and node not in NODES:
        if node not in (0, _UNCONFIGURED):
            ini.complain(key.line, "node-id", value=key.value[:60])
        node = None
    rate = values.whole(section.get("Baudrate"))
    return node, _text(section, "NodeName"), rate * 1000 if rate and rate > 0 else None


def _comments(ini: Ini) -> tuple[str, ...]:
    section = ini.section("Comments")
    lines = section.keys.values() if section else ()
    numbered = [(int(key.name[4:]), key.value) for key in lines if key.name[:4].lower() == "line" and _digits(key.name)]
    return tuple(text for _, text in sorted(numbered))


def _digits(name: str) -> bool:
    return name[4:].isascii() and name[4:].isdigit() and len(name) <= 8


def _say_modules(ini: Ini, values: Values) -> None:
    """Modular devices (CiA 306 4.8): what their modules add is not read."""
    section = ini.section("SupportedModules")
    number = integer(_text(section, "NrOfEntries"))
    if section and number and number.value > 0:
        ini.complain(section.line, "modules", section=section.name, count=number.value)


__all__ = ["contents", "describes", "load", "model", "read", "taken"]
