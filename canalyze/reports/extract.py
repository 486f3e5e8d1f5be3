"""The data of transfers as files in a directory.

Bytes go to disk as they come, into a part (`writing`), and get their name when the transfer has ended: that of the
core, which is safe, with the name of the object and a suffix by what it holds (`contents`); NAME.aborted and the like
where the transfer has not succeeded. Files that exist are kept.

A transfer of which the capture lacks a part never gets the plain name. Where the length of a hole is known, the file
has as many bytes FILL in its place, so that what stands behind has its offset; a hole at the end, or of unknown length,
takes no room. Which holes there are stands in a file beside it, NAME.STATUS.holes.json.

A transfer without a byte is a file only where it is complete: of thousands of requests that found no answer there is
nothing to keep.
"""

import binascii
import errno
import json
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Final, TypeAlias

from canalyze.dictionary.dbc import identifier
from canalyze.errors import OutputError
from canalyze.output.writing import Part
from canalyze.records import records
from canalyze.records.transfers import Transfer
from canalyze.reports import contents
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
        try:
            if not name:
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
            if self._path.exists() and not self._path.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
            self._path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError("output.write", name=name or '""', error=error) from error

    def add(self, pieces: Sequence[tuple[str, bytes, str, Sequence[Hole], str]]) -> None:
        """Adds (name, more bytes, status, holes, line of the transfer) as they come from the core."""
        for name, data, status, holes, line in pieces:
            about = next(records(line.encode(), Transfer), None)
            if about and about.object and about.object.index == _SOFTWARE and isinstance(about.value, int):
                self._software[about.bus, about.node, about.object.sub] = about.value
            try:
                self._add(name, data, status, holes, about)
            except OSError as error:
                raise OutputError("output.write", name=self._path / name, error=error) from error

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
            try:
                self._end(name, "incomplete")
            except OSError as error:
                raise OutputError("output.write", name=self._path / name, error=error) from error

    def described(self) -> list[dict[str, Any]]:
        """Returns the files, each with what 1F56h says of its program."""
        for file in self.files:
            of = (file["bus"], file["node"], file["sub"])
            file["software"] = self._software.get(of) if file["index"] == f"{0x1F50:04X}" else None
        return self.files


def _described(path: Path, status: str, holes: Sequence[Hole], about: Transfer) -> dict[str, Any]:
    """Returns the kind of the data of a transfer. Incomplete data are not called damaged."""
    data = path.read_bytes() if path.stat().st_size <= contents.MOST else b""
    found = contents.recognised(data, int(about.index or "0", 16))
    whole = status == "ok" and not holes
    damage = found.damage if found and whole else None
    summed = whole and about.mode == "block" and about.crc_negotiated
    return {
        "transfer": about.number,
        **{key: getattr(about, key) for key in ("bus", "node", "direction", "index", "sub", "name", "status")},
        "complete": whole,
        **{key: getattr(about, key) for key in ("size", "size_indicated")},
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
