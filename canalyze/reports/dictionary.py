"""A device description for people: the device, its objects, PDOs, defects; as JSON lines; its PDOs as a DBC file.

What is in a DBC file, `canalyze/dictionary/files.py` decides. Keys of JSON are only ever added; a test freezes them.

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
from collections.abc import Iterable, Iterator
from typing import Final

from canalyze._core import CobId, Mapped, Pdo
from canalyze.dictionary import ARRAY, NAMES, RECORD, Defect, Dictionary, Entry, NodeOffset, Object, Value
from canalyze.dictionary.files import Described, database
from canalyze.output import Output, complain, fields, json_text, printable
from canalyze.output.layout import definitions, width
from canalyze.reports.table import columns, write
from canalyze.words import Words

_SHOWN: Final = range(0x1000, 0x102A)
"""Communication objects shown with their values."""
_AREAS: Final = (
    (range(0x1000, 0x2000), "communication"),
    (range(0x2000, 0x6000), "manufacturer"),
    (range(0x6000, 0xA000), "profile"),
    (range(0xA000, 0xB000), "network"),
    (range(0xB000, 0xC000), "system"),
    (range(0xC000, 0x10000), "reserved"),
)
"""CiA 301 7.4.1."""
_REPEATS: Final = 10
"""Defects of one code that are shown before the rest is only counted."""
_RUN: Final = 8
"""Entries in a row with one value that share a line."""
_PLAIN: Final = 10
"""Integers below are the same in hexadecimal."""

_TRANSMISSION: Final[dict[str, tuple[tuple[range, str], ...]]] = {
    "tpdo": (
        (range(1), "acyclic"),
        (range(1, 2), "every"),
        (range(2, 241), "cyclic"),
        (range(252, 253), "rtr_sync"),
        (range(253, 254), "rtr"),
        (range(254, 255), "event_manufacturer"),
        (range(255, 256), "event_profile"),
    ),
    "rpdo": ((range(241), "at_sync"), (range(254, 255), "at_once_manufacturer"), (range(255, 256), "at_once_profile")),
}
"""Transmission types, CiA 301 tables 66 and 72; all others are reserved."""


def show(found: Dictionary, out: Output, words: Words, *, every: bool) -> None:
    """Writes one description; `every` lists all objects."""
    _facts(found, out, words)
    _objects(found, out, words, every=every)
    _areas(found, out, words)
    _pdos(found, out, words)
    _defects(found, out, words)


def _heading(out: Output, text: str) -> None:
    out.text(f"\n{text}\n")


def _facts(found: Dictionary, out: Output, words: Words) -> None:
    device, info = found.device, found.info
    form = words("eds.concise") if found.form == "concise" else f"{found.form.upper()}, {found.encoding.upper()}"
    out.text(printable(f"{found.file}: {form}") + "\n")
    node = words("eds.no_node") if found.node is None else str(found.node)
    version = ".".join(part for part in (info.version, info.revision) if part)
    comments = [line for line in found.comments if line.strip()]
    rows = [
        ("vendor", _joined(device.vendor_name, device.vendor_number)),
        ("product", _joined(device.product_name, device.product_number)),
        ("revision", "" if device.revision_number is None else _integer(device.revision_number)),
        ("order_code", device.order_code or ""),
        ("node", f"{node} {found.node_name}".rstrip()),
        ("bit_rate", _rates([found.bit_rate]) if found.bit_rate else ""),
        ("bit_rates", _rates(device.bit_rates)),
        ("lss", "" if device.lss is None else words("eds.yes" if device.lss else "eds.no")),
        ("file_name", info.name),
        ("file_version", version),
        ("eds_version", info.eds_version),
        ("description", info.description),
        ("created", info.created),
        ("modified", info.modified),
        *zip(["comments"], comments, strict=False),
    ]
    rows += [("", line) for line in comments[1:]]
    left = max(width(words(f"device.{key}")) for key, _ in rows if key)
    shown = [(words(f"device.{key}") if key else "", printable(text)) for key, text in rows if text or not key]
    out.text("".join(f"{line}\n" for line in definitions(shown, left=left)))


def _joined(name: str | None, number: int | None) -> str:
    return " ".join(part for part in (name or "", "" if number is None else _integer(number)) if part)


def _rates(rates: Iterable[int | None]) -> str:
    joined = " ".join(f"{(rate or 0) / 1000:g}" for rate in rates)
    return f"{joined} kbit/s" if joined else ""


def _objects(found: Dictionary, out: Output, words: Words, *, every: bool) -> None:
    chosen = [thing for thing in found.objects if every or thing.index in _SHOWN]
    rows: list[list[str]] = []
    for thing in chosen:
        for first, last in _telling(thing, every):
            cells = _object(first, thing, found, words, every=every)
            rows.append(cells if first is last else [f"{cells[0]}-{last.sub:02X}", *cells[1:]])
    if not rows:
        return
    _heading(out, words("eds.objects" if every else "eds.communication_objects"))
    keys = ["object", "name", "type", "access", *(("pdo_mapping", "limits", "unit") if every else ()), "value"]
    write(columns(words, keys, folds={"name", "value"}), rows, out)


def _telling(thing: Object, every: bool) -> list[tuple[Entry, Entry]]:
    """Returns the entries worth a line, in an array those that hold something; long runs as their first and last."""
    if every or len(thing.entries) <= 1:
        return [(entry, entry) for entry in thing.entries]
    runs: list[list[Entry]] = []
    for entry in thing.entries:
        if entry.value is None or (entry.sub != 0 and entry.value == 0):
            continue
        before = runs[-1][-1] if runs else None
        if before and before.sub and before.value == entry.value and before.sub == entry.sub - 1:
            runs[-1].append(entry)
        else:
            runs.append([entry])
    pairs = []
    for run in runs:
        pairs += [(run[0], run[-1])] if len(run) >= _RUN else [(entry, entry) for entry in run]
    return pairs


def _object(entry: Entry, thing: Object, found: Dictionary, words: Words, *, every: bool) -> list[str]:
    single = thing.code not in (ARRAY, RECORD)
    place = f"{entry.index:04X}h" if single else f"{entry.index:04X}h:{entry.sub:02X}"
    name = entry.name if single or entry.sub != 0 else thing.name
    cells = [place, name, _type(entry), entry.access]
    if every:
        limits = [_shown(limit, None) for limit in (entry.low, entry.high)]
        cells += [words("eds.yes") if entry.mappable else "", _limits(limits), _unit(entry)]
    return [*cells, _shown(entry.value, found.node)]


def _limits(limits: list[str]) -> str:
    low, high = limits
    return f"{low}..{high}" if low or high else ""


def _unit(entry: Entry) -> str:
    factor = "" if entry.factor == 1 else f"{entry.factor:g} "
    return f"{factor}{entry.unit}".strip()


def _type(entry: Entry) -> str:
    return NAMES.get(entry.type) or f"{entry.type:04X}h"


def _shown(value: Value | None, node: int | None) -> str:
    """Returns a value as people read it, numbers in both bases."""
    if value is None:
        return ""
    if isinstance(value, NodeOffset):
        formula = f"$NODEID{'-' if value.offset < 0 else '+'}{abs(value.offset):X}h"
        return formula if node is None else f"{value.at(node):X}h ({formula})"
    if isinstance(value, bytes):
        return value.hex(" ").upper()
    if isinstance(value, str):
        return f'"{value}"'
    return _integer(value) if isinstance(value, int) else f"{value:g}"


def _integer(value: int) -> str:
    return str(value) if value < _PLAIN else f"{value} ({value:X}h)"


def _areas(found: Dictionary, out: Output, words: Words) -> None:
    rows = []
    for area, key in _AREAS:
        things = [thing for thing in found.objects if thing.index in area]
        if things:
            span = f"{area[0]:04X}h-{area[-1]:04X}h"
            entries = sum(len(thing.entries) for thing in things)
            rows.append([span, words(f"area.{key}"), str(len(things)), str(entries)])
    _heading(out, words("eds.areas"))
    write(columns(words, ["range", "area", "objects", "entries"], right={"objects", "entries"}), rows, out)


def _pdos(found: Dictionary, out: Output, words: Words) -> None:
    if not found.pdos:
        return
    keys = ["pdo", "cob_id", "state", "rtr", "transmission", "inhibit", "event_timer", "sync_start", "bits"]
    right = {"inhibit", "event_timer", "sync_start", "bits"}
    _heading(out, words("eds.pdos"))
    pdos = [_pdo(pdo, found.node, words) for pdo in found.pdos]
    write(columns(words, keys, right=right, folds={"transmission"}), pdos, out)
    rows = [row for pdo in found.pdos for row in _mapped(pdo, found, words)]
    if rows:
        _heading(out, words("eds.mapping"))
        keys = ["pdo", "bit", "object", "type", "signal"]
        write(columns(words, keys, right={"bit"}, folds={"signal"}), rows, out)


def _name(pdo: Pdo) -> str:
    return f"{pdo.direction.upper()}{pdo.number}"


def _pdo(pdo: Pdo, node: int | None, words: Words) -> list[str]:
    rtr = ""
    if pdo.direction == "tpdo":
        rtr = words("eds.yes" if pdo.cob_id.rtr_allowed else "eds.no")
    return [
        _name(pdo),
        _cob_id(pdo.cob_id, node, words),
        words("eds.valid" if pdo.cob_id.valid else "eds.invalid"),
        rtr,
        _transmission(pdo, words),
        f"{pdo.inhibit / 10:g} ms" if pdo.inhibit else "",
        f"{pdo.event_timer} ms" if pdo.event_timer else "",
        "" if pdo.sync_start is None else str(pdo.sync_start),
        pdo.multiplex.upper() + "-MPDO" if pdo.multiplex else str(pdo.bits),
    ]


def _cob_id(cob: CobId, node: int | None, words: Words) -> str:
    if cob.assumed and not cob.valid:
        return ""
    shown = f"$NODEID+{cob.base:X}h" if cob.relative else f"{cob.base:X}h"
    if cob.relative and node is not None:
        shown = f"{cob.at(node):X}h ({shown})"
    if cob.extended:
        shown += f" {words('eds.extended')}"
    return f"{shown} {words('eds.assumed')}" if cob.assumed else shown


def _transmission(pdo: Pdo, words: Words) -> str:
    if pdo.transmission is None:
        return ""
    key = next((key for span, key in _TRANSMISSION[pdo.direction] if pdo.transmission in span), "reserved")
    return f"{pdo.transmission} {words(f'transmission.{key}', n=pdo.transmission)}"


def _mapped(pdo: Pdo, found: Dictionary, words: Words) -> Iterable[list[str]]:
    name = _name(pdo)
    for mapped in pdo.mapped:
        entry = None if mapped.dummy else found.entry(mapped.index, mapped.sub)
        last = mapped.offset + mapped.bits - 1
        span = f"{mapped.offset}-{last}" if mapped.bits > 1 else str(mapped.offset)
        place = f"{mapped.index:04X}h:{mapped.sub:02X}"
        if entry:
            yield [name, span, place, _type(entry), entry.name]
        else:
            kind = NAMES.get(mapped.index, "") if mapped.dummy else ""
            yield [name, span, place, kind, words("eds.dummy" if mapped.dummy else "eds.unknown")]
        name = ""


def _defects(found: Dictionary, out: Output, words: Words) -> None:
    if not found.defects:
        out.text("\n" + words("eds.no_defects") + "\n")
        return
    _heading(out, words("eds.defects", count=len(found.defects)))
    seen: dict[str, int] = {}
    for defect in found.defects:
        seen[defect.code] = seen.get(defect.code, 0) + 1
        if seen[defect.code] <= _REPEATS:
            out.text(printable(defect_line(defect, found.file, words)) + "\n")
    for code, count in seen.items():
        if count > _REPEATS:
            out.text(words("eds.more_defects", code=code, count=count - _REPEATS) + "\n")


def defect_line(defect: Defect, file: str, words: Words) -> str:
    """Returns one defect as a line: file, line, effect, description."""
    place = f"{file}:{defect.line}" if defect.line else file
    said = words(f"defect.{defect.code}", **defect.facts)
    return f"{place}: {words(f'effect.{defect.effect}')}: {said} [{defect.code}]"


_EXACT: Final = 1 << 53


def json_lines(found: Dictionary) -> Iterator[str]:
    """Returns all lines of one description."""
    file = os.fsencode(found.file).decode("utf-8", "backslashreplace")
    yield _line("dictionary", file, _head(found))
    for thing in found.objects:
        for entry in thing.entries:
            yield _line("object", file, _entry_fields(thing, entry, found.node))
    for pdo in found.pdos:
        yield _line("pdo", file, _pdo_fields(pdo, found))
    for defect in found.defects:
        facts = {name: fact if isinstance(fact, int | float) else str(fact) for name, fact in defect.facts.items()}
        yield _line("defect", file, {"line": defect.line, "code": defect.code, "effect": defect.effect, "facts": facts})


def _line(kind: str, file: str, rest: dict[str, object]) -> str:
    return json_text({"kind": kind, "file": file} | rest)


def _head(found: Dictionary) -> dict[str, object]:
    device, info = found.device, found.info
    return {
        **fields(found, "form encoding"),
        **fields(found, "node node_name"),
        "bit_rate": _json_number(found.bit_rate),
        "vendor": device.vendor_name,
        "vendor_number": _json_number(device.vendor_number),
        "product": device.product_name,
        "product_number": _json_number(device.product_number),
        "revision": _json_number(device.revision_number),
        "order_code": device.order_code,
        "file_name": info.name,
        "file_version": info.version,
        "file_revision": info.revision,
        **fields(info, "eds_version description created modified"),
        "comments": list(found.comments),
        "bit_rates": list(device.bit_rates),
        "lss": device.lss,
        "dummies": [f"{kind:04X}" for kind in sorted(found.dummies)],
        "objects": len(found.objects),
    }


def _entry_fields(thing: Object, entry: Entry, node: int | None) -> dict[str, object]:
    return {
        "line": entry.line,
        "index": f"{entry.index:04X}",
        "sub": entry.sub,
        "object": thing.name,
        "name": entry.name,
        "type": f"{entry.type:04X}",
        "type_name": NAMES.get(entry.type),
        "access": entry.access,
        "default": _json_value(entry.default, node),
        "parameter": _json_value(entry.parameter, node),
        "value": _json_value(entry.value, node),
        "offset": _json_number(entry.value.offset) if isinstance(entry.value, NodeOffset) else None,
        "mappable": entry.mappable,
        "low": _json_number(entry.low),
        "high": _json_number(entry.high),
        **fields(entry, "unit factor"),
    }


def _pdo_fields(pdo: Pdo, found: Dictionary) -> dict[str, object]:
    cob = pdo.cob_id
    identifier = cob.at(found.node)
    communication = found.object(pdo.communication)
    return {
        "line": communication.line if communication else 0,
        "pdo": f"{pdo.direction.upper()}{pdo.number}",
        **fields(pdo, "direction number"),
        "cob_id": None if identifier is None else f"{identifier:X}",
        "base": f"{cob.base:X}",
        **fields(cob, "relative valid"),
        "rtr": cob.rtr_allowed,
        **fields(cob, "extended assumed"),
        **fields(pdo, "transmission inhibit event_timer sync_start multiplex bits"),
        "mapped": [_mapped_fields(one, found) for one in pdo.mapped],
    }


def _mapped_fields(of: Mapped, found: Dictionary) -> dict[str, object]:
    entry = None if of.dummy else found.entry(of.index, of.sub)
    return {
        "index": f"{of.index:04X}",
        **fields(of, "sub offset bits"),
        "name": entry.name if entry else None,
        "type": f"{entry.type:04X}" if entry else None,
        "dummy": of.dummy,
    }


def _json_value(value: Value | None, node: int | None) -> object:
    if isinstance(value, NodeOffset):
        return None if node is None else _json_number(value.at(node))
    if isinstance(value, bytes):
        return value.hex().upper()
    return value if isinstance(value, str) else _json_number(value)


def _json_number(value: int | float | None) -> object:
    return str(value) if isinstance(value, int) and abs(value) > _EXACT else value


def write_dbc(out: Output, words: Words, name: str, result: bytes, described: Described) -> None:
    """Writes the PDOs of one bus. CanalyzeError where that cannot be."""
    found = database(result, described)
    out.write(found.data)
    complain(f"canalyze: {words('dbc.written', name=name, messages=found.messages, signals=found.signals)}")
    for key, facts in found.said:
        complain(f"canalyze: {name}: {words(key, **facts)}")
