"""EDS and DCF (CiA 306), XDD and concise DCF -> a frozen `Dictionary`.

The core reads them as they are found: repairs and unusable parts become a `Defect`. A file is an error
(`SourceError`) only if it contains no object at all or cannot be read. python-canopen is imported only where its
own objects are converted.
"""

import os
from typing import TYPE_CHECKING, Any, Final

from canalyze import _core
from canalyze.dictionary import model
from canalyze.dictionary.model import Access, Defect, Device, Dictionary, Entry, FileInfo, NodeOffset, Object
from canalyze.errors import SourceError

if TYPE_CHECKING:
    from canopen import ObjectDictionary

_NAMES: Final = (".eds", ".dcf", ".xdd", ".xdc", ".cdcf")
_HEAD: Final = 1 << 16
_LARGEST: Final = 8 << 20
_Filed = int | float | str | bytes | tuple[int] | None


def load(name: str, node: int | None = None) -> Dictionary:
    """Reads a file ('-' is standard input); `node` overrides the node-ID of a DCF."""
    return read(*contents(name), node)


def describes(name: str) -> bool:
    """Returns true if a file is a description and not a capture, by its name or its first bytes."""
    if name.lower().endswith(_NAMES):
        return True
    try:
        with open(name, "rb") as file:
            data = file.read(_HEAD)
    except OSError:  # standard input, or an unreadable file
        return False
    return _core.is_description(data)


def contents(name: str) -> tuple[bytes, str]:
    """Returns the bytes of a file ('-' is standard input), and its name for messages."""
    from canalyze.sources.file import Source

    data = bytearray()
    with Source(name) as source:
        while piece := source.read():
            data += piece
            if len(data) > _LARGEST:
                raise SourceError("eds.large", name=source.name, most=_LARGEST >> 20)
    return bytes(data), source.name


def read(data: bytes, name: str, node: int | None = None) -> Dictionary:
    """Reads a description from its bytes; `name` is used in messages."""
    try:
        form, encoding, info, device, comments, filed, node_name, rate, objects, dummies, table, pdos, defects = (
            _core.description(data, os.fsencode(name).decode("utf-8", "backslashreplace"))
        )
    except _core.DescriptionError as error:
        key, facts = error.args
        raise SourceError(key, name=name, **facts) from None
    return Dictionary(
        file=name,
        form=form,
        encoding=encoding,
        info=FileInfo(*info),
        device=Device(*device),
        comments=comments,
        node=filed if node is None else node,
        node_name=node_name,
        bit_rate=rate,
        objects=tuple(
            Object(index, title, code, tuple(_entry(*entry) for entry in entries), line)
            for index, title, code, entries, line in objects
        ),
        dummies=frozenset(dummies),
        table=table,
        pdos=tuple(pdos),
        defects=tuple(Defect(*defect) for defect in defects),
    )


def _entry(
    index: int,
    sub: int,
    name: str,
    kind: int,
    access: Access,
    default: _Filed,
    parameter: _Filed,
    *rest: Any,
) -> Entry:
    """Returns an entry of the core's; a tuple is an offset to the node-ID."""
    return Entry(
        index,
        sub,
        name,
        kind,
        access,
        NodeOffset(*default) if isinstance(default, tuple) else default,
        NodeOffset(*parameter) if isinstance(parameter, tuple) else parameter,
        *rest,
    )


def taken(given: "ObjectDictionary", name: str) -> Dictionary:
    """Converts a dictionary of python-canopen, through the EDS that it writes."""
    from canalyze.dictionary import library
    from canalyze.dictionary.library import table

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


__all__ = ["contents", "describes", "load", "model", "read", "taken"]
