"""A device description as JSON lines. Keys are only ever added; a test freezes them.

kind `dictionary`, one a file:
    kind file form encoding node node_name bit_rate vendor vendor_number product product_number revision order_code
    file_name file_version file_revision eds_version description created modified comments bit_rates lss dummies objects
kind `object`, one a sub-object, in order:
    kind file line index sub object name type type_name access default parameter value offset mappable low high unit
    factor. `default`, `parameter` and `value` (what the device starts with) are null where they need a node-ID and none
    is known; `offset` is what is added to the node-ID in `value`, null where it does not depend on it.
kind `pdo`, one a PDO:
    kind file line pdo direction number cob_id base relative valid rtr extended assumed transmission inhibit event_timer
    sync_start multiplex bits mapped; inhibit in 100 us, event_timer in ms. `mapped` has objects with
    index sub offset bits name type dummy; offset is a bit position in the payload.
kind `defect`, one a defect:
    kind file line code effect facts

Indices, identifiers, type codes and bytes are hexadecimal strings, integers beyond 2^53 are decimal strings.
"""

import os
from collections.abc import Iterator
from typing import Final

from canalyze._core import Mapped, Pdo
from canalyze.dictionary.model import Dictionary, Entry, NodeOffset, Object, Value
from canalyze.dictionary.values import NAMES
from canalyze.output import jsonl

_EXACT: Final = 1 << 53


def lines(found: Dictionary) -> Iterator[str]:
    """Returns all lines of one description."""
    file = os.fsencode(found.file).decode("utf-8", "backslashreplace")
    yield _line("dictionary", file, _head(found))
    for thing in found.objects:
        for entry in thing.entries:
            yield _line("object", file, _entry(thing, entry, found.node))
    for pdo in found.pdos:
        yield _line("pdo", file, _pdo(pdo, found))
    for defect in found.defects:
        facts = {name: fact if isinstance(fact, int | float) else str(fact) for name, fact in defect.facts.items()}
        yield _line("defect", file, {"line": defect.line, "code": defect.code, "effect": defect.effect, "facts": facts})


def _line(kind: str, file: str, rest: dict[str, object]) -> str:
    return jsonl.text({"kind": kind, "file": file} | rest)


def _head(found: Dictionary) -> dict[str, object]:
    device, info = found.device, found.info
    return {
        "form": found.form,
        "encoding": found.encoding,
        "node": found.node,
        "node_name": found.node_name,
        "bit_rate": _number(found.bit_rate),
        "vendor": device.vendor_name,
        "vendor_number": _number(device.vendor_number),
        "product": device.product_name,
        "product_number": _number(device.product_number),
        "revision": _number(device.revision_number),
        "order_code": device.order_code,
        "file_name": info.name,
        "file_version": info.version,
        "file_revision": info.revision,
        "eds_version": info.eds_version,
        "description": info.description,
        "created": info.created,
        "modified": info.modified,
        "comments": list(found.comments),
        "bit_rates": list(device.bit_rates),
        "lss": device.lss,
        "dummies": [f"{kind:04X}" for kind in sorted(found.dummies)],
        "objects": len(found.objects),
    }


def _entry(thing: Object, entry: Entry, node: int | None) -> dict[str, object]:
    return {
        "line": entry.line,
        "index": f"{entry.index:04X}",
        "sub": entry.sub,
        "object": thing.name,
        "name": entry.name,
        "type": f"{entry.type:04X}",
        "type_name": NAMES.get(entry.type),
        "access": entry.access,
        "default": _value(entry.default, node),
        "parameter": _value(entry.parameter, node),
        "value": _value(entry.value, node),
        "offset": _number(entry.value.offset) if isinstance(entry.value, NodeOffset) else None,
        "mappable": entry.mappable,
        "low": _number(entry.low),
        "high": _number(entry.high),
        "unit": entry.unit,
        "factor": entry.factor,
    }


def _pdo(pdo: Pdo, found: Dictionary) -> dict[str, object]:
    cob = pdo.cob_id
    identifier = cob.at(found.node)
    communication = found.object(pdo.communication)
    return {
        "line": communication.line if communication else 0,
        "pdo": f"{pdo.direction.upper()}{pdo.number}",
        "direction": pdo.direction,
        "number": pdo.number,
        "cob_id": None if identifier is None else f"{identifier:X}",
        "base": f"{cob.base:X}",
        "relative": cob.relative,
        "valid": cob.valid,
        "rtr": cob.rtr_allowed,
        "extended": cob.extended,
        "assumed": cob.assumed,
        "transmission": pdo.transmission,
        "inhibit": pdo.inhibit,
        "event_timer": pdo.event_timer,
        "sync_start": pdo.sync_start,
        "multiplex": pdo.multiplex,
        "bits": pdo.bits,
        "mapped": [_mapped(one, found) for one in pdo.mapped],
    }


def _mapped(of: Mapped, found: Dictionary) -> dict[str, object]:
    entry = None if of.dummy else found.entry(of.index, of.sub)
    return {
        "index": f"{of.index:04X}",
        "sub": of.sub,
        "offset": of.offset,
        "bits": of.bits,
        "name": entry.name if entry else None,
        "type": f"{entry.type:04X}" if entry else None,
        "dummy": of.dummy,
    }


def _value(value: Value | None, node: int | None) -> object:
    if isinstance(value, NodeOffset):
        return None if node is None else _number(value.at(node))
    if isinstance(value, bytes):
        return value.hex().upper()
    return value if isinstance(value, str) else _number(value)


def _number(value: int | float | None) -> object:
    return str(value) if isinstance(value, int) and abs(value) > _EXACT else value
