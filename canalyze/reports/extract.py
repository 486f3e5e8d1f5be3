"""The data of transfers as files in a directory, named by the kind of data that they hold.

Bytes go to disk as they come, into a part (`files`), and get their name when the transfer has ended: that of the
core, which is safe, with the name of the object and a suffix by what it holds; NAME.aborted and the like where the
transfer has not succeeded. Files that exist are kept.

A transfer of which the capture lacks a part never gets the plain name. Where the length of a hole is known, the file
has as many bytes FILL in its place, so that what stands behind has its offset; a hole at the end, or of unknown length,
takes no room. Which holes there are stands in a file beside it, NAME.STATUS.holes.json.

A transfer without a byte is a file only where it is complete: of thousands of requests that found no answer there is
nothing to keep.

The kinds of data are firmware, a description of a device, something packed, by their marks and sums. A form is
recognised where its marks say so, and then held against its own rules: sums of lines, the end that it must have, what
unpacks. Must not: take a text for a form because its first letters look alike.
"""

import binascii
import errno
import io
import json
import os
import re
import shutil
import struct
import zipfile
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Final, NamedTuple, TypeAlias

from canalyze import _core
from canalyze.dictionary import read
from canalyze.dictionary.files import identifier
from canalyze.errors import OutputError, SourceError, as_error
from canalyze.output import fields
from canalyze.output.files import Part
from canalyze.records import records
from canalyze.records.objects import Transfer
from canalyze.sources import Memory
from canalyze.sources.compressed import COMPRESSIONS, Unpacked
from canalyze.words import Words

FILL: Final = b"\0"
"""The byte in place of a missing one, here and in the data of JSON."""
Hole: TypeAlias = tuple[int, int | None]
"""Offset, and length where it is known."""
FILES: Final = frozenset({0x1021, 0x1023, 0x1F20, 0x1F22, 0x1F50})
"""Objects that hold files: stored EDS, OS commands, DCFs, programs."""
_SOFTWARE: Final = 0x1F56
"""Program software identification."""
_WRONG_CRC: Final = "SDO019"
_LONGEST: Final = 40


class Directory:
    """A directory that fills with files."""

    def __init__(self, name: str, words: Words, tell: Callable[[str], None], *, force: bool) -> None:
        """Makes the directory if it is not there; OutputError if that cannot be."""
        self.written = 0
        self.holed = 0
        self.code = 0
        self._path = Path(name)
        self._words = words
        self._tell = tell
        self._force = force
        self.files: list[dict[str, Any]] = []
        """Files for users of the device: firmware, descriptions, packed data."""
        self._software: dict[tuple[str | None, int, int], int] = {}
        """Values read from 1F56h, by bus, node and program."""
        self._open: dict[str, Part] = {}
        """By name, from the first byte on."""
        with as_error(OutputError, "output.write", name=name or '""'):
            if not name:
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
            if self._path.exists() and not self._path.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
            self._path.mkdir(parents=True, exist_ok=True)

    def add(self, pieces: Sequence[tuple[str, bytes, str, Sequence[Hole], str]]) -> None:
        """Adds (name, more bytes, status, holes, line of the transfer) as they come from the core."""
        for name, data, status, holes, line in pieces:
            about = next(records(line.encode(), Transfer), None)
            if about and about.object and about.object.index == _SOFTWARE and isinstance(about.value, int):
                self._software[about.bus, about.node, about.object.sub] = about.value
            with as_error(OutputError, "output.write", name=self._path / name):
                self._add(name, data, status, holes, about)

    def _add(self, name: str, data: bytes, status: str, holes: Sequence[Hole], about: Transfer | None) -> None:
        if name not in self._open:
            if not data and not (status == "ok" and not holes):
                return
            self._open[name] = self._part(self._path / name)
        if data:
            self._open[name].append(data)
        if status:
            self._end(name, status, holes, about)

    def _part(self, final: Path) -> Part:
        part = Part(final, replace=self._force)
        os.close(part.fd)  # thousands of transfers may be under way
        return part

    def _end(self, name: str, status: str, holes: Sequence[Hole] = (), about: Transfer | None = None) -> None:
        part = self._open.pop(name)
        file = _described(part.path, status, holes, about) if about and about.index is not None else None
        name = _named(name, file)
        final = self._path / (name if status == "ok" and not holes else f"{name}.{status}")
        beside = self._path / f"{final.name}.holes.json"
        if not self._free(final) or (holes and not self._free(beside)):
            part.discard()
            return
        try:
            if holes:
                self._list(_filled(part, holes), final, beside, holes)
            else:
                if self._force:
                    beside.unlink(missing_ok=True)
                part.complete(final)
            self.written += 1
            if file and (file["contents"] or int(file["index"], 16) in FILES):
                self.files.append({"kind": "file", "file": final.name, **file})
        except FileExistsError:  # another run was faster
            self._keep(final)
        finally:
            part.discard()

    def _list(self, filled: Part, final: Path, beside: Path, holes: Sequence[Hole]) -> None:
        """Returns a file with holes its name, and the list of them beside it."""
        try:
            known = [{"offset": offset, "length": length} for offset, length in holes]
            size = filled.path.stat().st_size
            said = {"file": final.name, "size": size, "fill": FILL.hex().upper(), "holes": known}
            listed = Part(beside, replace=self._force)
            try:
                os.close(listed.fd)
                listed.append(json.dumps(said).encode() + b"\n")
                listed.complete()
            finally:
                listed.discard()
            filled.complete(final)
            self.holed += 1
        finally:
            filled.discard()

    def _free(self, path: Path) -> bool:
        if self._force or not os.path.lexists(path):
            return True
        self._keep(path)
        return False

    def _keep(self, path: Path) -> None:
        self._tell(self._words("sdo.kept", name=path))
        self.code = 2

    def close(self) -> None:
        """Ends files that the core did not end because the run was cut short. OutputError where that cannot be."""
        for name in list(self._open):
            with as_error(OutputError, "output.write", name=self._path / name):
                self._end(name, "incomplete")

    def described(self) -> list[dict[str, Any]]:
        """Returns the files, each with what 1F56h says of its program."""
        for file in self.files:
            of = (file["bus"], file["node"], file["sub"])
            file["software"] = self._software.get(of) if file["index"] == f"{0x1F50:04X}" else None
        return self.files


def _described(path: Path, status: str, holes: Sequence[Hole], about: Transfer) -> dict[str, Any]:
    """Returns the kind of the data of a transfer. Incomplete data are not called damaged."""
    data = path.read_bytes() if path.stat().st_size <= MOST else b""
    found = recognised(data, int(about.index or "0", 16))
    whole = status == "ok" and not holes
    damage = found.damage if found and whole else None
    summed = whole and about.mode == "block" and about.crc_negotiated
    return {
        "transfer": about.number,
        **fields(about, "bus node direction index sub name status"),
        "complete": whole,
        **fields(about, "size size_indicated"),
        "contents": found and {"kind": found.kind, **found.facts},
        "damage": damage and {"kind": damage[0], **damage[1]},
        "suffix": found.suffix if found else None,
        "crc": f"{binascii.crc_hqx(data, 0):04X}" if summed else None,
        "crc_ok": _WRONG_CRC not in about.findings if summed else None,
    }


def _named(name: str, file: dict[str, Any] | None) -> str:
    """Returns the name of a file: with that of its object, and a suffix by what it holds."""
    if file is None:
        return name
    stem, _, suffix = name.rpartition(".")
    return f"{'_'.join(filter(None, (stem, identifier(file['name'] or '')[:_LONGEST])))}.{file.pop('suffix') or suffix}"


def _filled(part: Part, holes: Sequence[Hole]) -> Part:
    """Returns the bytes that were seen at their offsets."""
    left = part.path.stat().st_size
    inner = [(offset, length) for offset, length in holes if length]
    filled = Part(part.final, replace=part.replace)
    try:
        with part.path.open("rb") as seen, os.fdopen(filled.fd, "wb") as file:
            for offset, length in inner:
                count = offset - file.tell()
                if count >= left:
                    break
                _copy(seen, file, count)
                left -= count
                file.write(FILL * length)
            shutil.copyfileobj(seen, file)
    except OSError:
        filled.discard()
        raise
    return filled


def _copy(source: BinaryIO, target: BinaryIO, count: int) -> None:
    while count > 0:
        piece = source.read(min(count, 1 << 20))
        if not piece:
            return
        target.write(piece)
        count -= len(piece)


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
