"""The kinds of data in transfers: firmware, a description of a device, something packed; by their marks and sums.

A form is recognised where its marks say so, and then held against its own rules: sums of lines, the end that it must
have, what unpacks. Must not: take a text for a form because its first letters look alike.
"""

import io
import re
import struct
import zipfile
import zlib
from collections.abc import Callable
from typing import Final, NamedTuple

from canalyze import _core
from canalyze.dictionary import read
from canalyze.errors import SourceError
from canalyze.sources.compressed import COMPRESSIONS, Unpacked
from canalyze.sources.memory import Memory

MOST: Final = 1 << 28
"""Bytes of a file that is looked at; and most that are unpacked of one."""
CONCISE: Final = 0x1F22
"""The object that holds a concise DCF, which has no mark of its own."""
_LEAST: Final = 12
"""Bytes that a file has which is worth a look."""
_DESCRIPTION: Final = re.compile(rb"^\s*\[\s*(?:FileInfo|DeviceInfo|DeviceComm?issioning)\s*\]|<ISO15745", re.I | re.M)
_HEAD: Final = 1 << 16
_TEXT: Final = 512
"""Bytes by which a text is recognised."""
_ZIP: Final = (b"PK\x03\x04", b"PK\x05\x06")
_SUFFIXES: Final = {"gzip": "gz", "zstd": "zst", "bzip2": "bz2"}
_S_WIDTHS: Final = {0: 2, 1: 2, 2: 3, 3: 4, 5: 2, 6: 3, 7: 4, 8: 3, 9: 2}
"""Bytes of an address, by the type of an S-record."""
_ELF: Final = {1: ("I", 32, 46), 2: ("Q", 40, 58)}
"""Of the class of an ELF file: the form and the place of the offset of its section headers, and that of their size."""


_Damage = tuple[str, dict[str, object]]
"""The damage as `contents_damage.KIND`, and the values for its sentence."""


class Contents(NamedTuple):
    """Recognised data."""

    kind: str
    """As `words` has it: `contents.KIND`."""
    suffix: str
    facts: dict[str, object]
    """Values for its sentence."""
    damage: _Damage | None = None


def recognised(data: bytes, index: int | None) -> Contents | None:
    """Returns the kind of the data, None if unknown. index: of the object that holds them."""
    if not _LEAST <= len(data) <= MOST:
        return None
    packed = _core.sniff(data[:_HEAD], True)
    if packed in COMPRESSIONS:
        return _unpacked(data, packed)
    if data.startswith(_ZIP):
        return _zip(data)
    if data.startswith(b"\x7fELF"):
        return _elf(data)
    if index == CONCISE:
        return _concise(data)
    if _DESCRIPTION.search(data[:_HEAD]):
        return _description(data)
    if not data[:_TEXT].isascii():
        return None
    return _records(data, "srec", "s19", _s_record) or _records(data, "hex", "hex", _hex_record)


def _unpacked(data: bytes, form: str) -> Contents:
    layer, size = Unpacked(Memory(form, data), form), 0
    while size < MOST and (piece := layer.read()):
        size += len(piece)
    facts: dict[str, object] = {"form": form, "unpacked": size}
    damage: _Damage | None = (layer.damage.kind, {"offset": layer.damage.offset}) if layer.damage else None
    return Contents("packed", _SUFFIXES.get(form, form), facts, damage)


def _zip(data: bytes) -> Contents:
    files, wrong = 0, None
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            files = len(archive.infolist())
            if sum(one.file_size for one in archive.infolist()) <= MOST:
                wrong = archive.testzip()
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError):
        return Contents("zip", "zip", {"files": files}, ("structure", {}))
    except (NotImplementedError, RuntimeError):  # packed otherwise, or encrypted: nothing is known of it
        pass
    return Contents("zip", "zip", {"files": files}, ("member", {"name": wrong}) if wrong else None)


def _elf(data: bytes) -> Contents | None:
    form = _ELF.get(data[4])
    if form is None or data[5] not in (1, 2) or len(data) < 64:
        return Contents("elf", "elf", {}, ("cut", {})) if form else None
    order = "<" if data[5] == 1 else ">"
    kind, place, sizes = form
    (offset,) = struct.unpack_from(order + kind, data, place)
    size, count = struct.unpack_from(order + "HH", data, sizes)
    return Contents("elf", "elf", {}, ("cut", {}) if offset + size * count > len(data) else None)


def _concise(data: bytes) -> Contents:
    """CiA 302-3: a count, then index, sub-index, size and data of each value."""
    said, at, found = int.from_bytes(data[:4], "little"), 4, 0
    while at + 7 <= len(data) and at + 7 + (size := int.from_bytes(data[at + 3 : at + 7], "little")) <= len(data):
        at, found = at + 7 + size, found + 1
    whole = (said, at) == (found, len(data))
    return Contents("concise", "bin", {"values": said}, None if whole else ("values", {"found": found}))


def _description(data: bytes) -> Contents | None:
    try:
        found = read(data, "")
    except SourceError:
        return None
    facts = {"form": found.form.upper(), "product": found.device.product_name or "?", "objects": len(found.objects)}
    missing = sum(defect.code == "not-there" for defect in found.defects)
    return Contents("description", found.form, facts, ("objects", {"missing": missing}) if missing else None)


class _Line(NamedTuple):
    """A line of a file of hexadecimal records."""

    address: int
    size: int
    role: str
    """data | base (the address is that of all that follows) | end | other."""


def _s_record(text: str) -> _Line | None:
    """Reads an S-record; None where it is none, or its sum is wrong."""
    body = _body(text[2:])
    if text[:1] not in ("S", "s") or not body or not text[1].isdigit() or sum(body) & 0xFF != 0xFF:
        return None
    kind = int(text[1])
    width = _S_WIDTHS.get(kind)
    if width is None or body[0] != len(body) - 1 or len(body) < width + 2:
        return None
    role = "data" if kind in (1, 2, 3) else "end" if kind in (7, 8, 9) else "other"
    return _Line(int.from_bytes(body[1 : 1 + width], "big"), body[0] - width - 1, role)


def _hex_record(text: str) -> _Line | None:
    """Reads a record of Intel HEX; None where it is none, or its sum is wrong."""
    body = _body(text[1:])
    if text[:1] != ":" or len(body) < 5 or body[0] != len(body) - 5 or sum(body) & 0xFF:
        return None
    kind = body[3]
    if kind in (2, 4):
        return _Line(int.from_bytes(body[4:-1], "big") << (4 if kind == 2 else 16), 0, "base")
    role = {0: "data", 1: "end", 3: "other", 5: "other"}.get(kind)
    return _Line(int.from_bytes(body[1:3], "big"), body[0], role) if role else None


def _body(text: str) -> bytes:
    return bytes.fromhex(text) if re.fullmatch(r"(?:[0-9A-Fa-f]{2}){3,}", text) else b""


def _records(data: bytes, kind: str, suffix: str, parse: Callable[[str], _Line | None]) -> Contents | None:
    """Reads a file of records, where most of its lines are such."""
    lines = [(number, text.strip()) for number, text in enumerate(data.decode("latin-1").split("\n"), 1)]
    lines = [(number, text) for number, text in lines if text.strip("\0\r\x1a")]
    found = [parse(text) for _, text in lines[:8]]
    if 2 * sum(one is not None for one in found) < max(len(found), 1):
        return None
    wrong: list[int] = []
    base, size, ended = 0, 0, False
    least, greatest = None, 0
    for number, text in lines:
        line = parse(text)
        if line is None:
            wrong.append(number)
            continue
        ended = ended or line.role == "end"
        base = line.address if line.role == "base" else base
        if line.role == "data" and line.size:
            begin = base + line.address
            least = begin if least is None else min(least, begin)
            greatest = max(greatest, begin + line.size - 1)
            size += line.size
    facts = {"first": f"{least or 0:08X}h", "last": f"{greatest:08X}h", "size": size}
    if wrong:
        return Contents(kind, suffix, facts, ("lines", {"count": len(wrong), "line": wrong[0]}))
    return Contents(kind, suffix, facts, None if ended else ("end", {}))
