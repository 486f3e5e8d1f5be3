"""The data of transfers as files in a directory.

Bytes go to disk as they come, into NAME.part, and get their name when the transfer has ended: NAME, or NAME.aborted and
the like. Files that exist are kept. Names are the core's, and safe.

A transfer of which the capture lacks a part never gets the plain name. Where the length of a hole is known, the file
has as many bytes FILL in its place, so that what stands behind has its offset; a hole at the end, or of unknown length,
takes no room. Which holes there are stands in a file beside it, NAME.STATUS.holes.json.
"""

import errno
import json
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import BinaryIO, Final, TypeAlias

from canalyze.errors import OutputError
from canalyze.words import Words

FILL: Final = b"\0"
"""What stands for a byte that is missing, here and in the data of JSON."""
Hole: TypeAlias = tuple[int, int | None]
"""Offset, and length where it is known."""


class Directory:
    """A directory that fills with files."""

    def __init__(self, name: str, words: Words, tell: Callable[[str], None], *, force: bool) -> None:
        """Make the directory if it is not there; OutputError if that cannot be."""
        self.written = 0
        self.holed = 0
        self.code = 0
        self._path = Path(name)
        self._words = words
        self._tell = tell
        self._force = force
        self._open: dict[str, bool] = {}  # name -> whether it is written, or the existing file is kept
        try:
            if self._path.exists() and not self._path.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
            self._path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError("output.write", name=name, error=error) from error

    def add(self, pieces: Sequence[tuple[str, bytes, str, Sequence[Hole]]]) -> None:
        """Take (name, more bytes, status, holes) as the core gives them."""
        for name, data, status, holes in pieces:
            try:
                self._add(name, data, status, holes)
            except OSError as error:
                raise OutputError("output.write", name=self._path / name, error=error) from error

    def _add(self, name: str, data: bytes, status: str, holes: Sequence[Hole]) -> None:
        part = self._path / f"{name}.part"
        if name not in self._open:
            self._open[name] = self._free(self._path / name)
            if self._open[name]:
                part.write_bytes(b"")
        if self._open[name] and data:
            with part.open("ab") as file:
                file.write(data)
        if status:
            self._end(name, status, holes)

    def _end(self, name: str, status: str, holes: Sequence[Hole] = ()) -> None:
        if not self._open.pop(name):
            return
        part = self._path / f"{name}.part"
        final = self._path / (name if status == "ok" and not holes else f"{name}.{status}")
        beside = self._path / f"{final.name}.holes.json"
        if not self._free(final) or (holes and not self._free(beside)):
            part.unlink()
            return
        if holes:
            _fill(part, holes)
            known = [{"offset": offset, "length": length} for offset, length in holes]
            size = part.stat().st_size
            said = {"file": final.name, "size": size, "fill": FILL.hex().upper(), "holes": known}
            beside.write_text(json.dumps(said) + "\n", encoding="utf-8")
            self.holed += 1
        elif self._force:
            beside.unlink(missing_ok=True)
        part.replace(final)
        self.written += 1

    def _free(self, path: Path) -> bool:
        if self._force or not path.exists():
            return True
        self._tell(self._words("sdo.kept", name=path))
        self.code = 2
        return False

    def close(self) -> None:
        """End what the core did not end: the run was cut short."""
        for name in list(self._open):
            self._end(name, "incomplete")


def _fill(path: Path, holes: Sequence[Hole]) -> None:
    """Put the bytes that were seen to their offsets."""
    left = path.stat().st_size
    inner = [(offset, length) for offset, length in holes if length]
    filled = path.with_name(f"{path.name}.filled")
    with path.open("rb") as seen, filled.open("wb") as file:
        for offset, length in inner:
            count = offset - file.tell()
            if count >= left:
                break
            _copy(seen, file, count)
            left -= count
            file.write(FILL * length)
        shutil.copyfileobj(seen, file)
    filled.replace(path)


def _copy(source: BinaryIO, target: BinaryIO, count: int) -> None:
    while count > 0:
        piece = source.read(min(count, 1 << 20))
        if not piece:
            return
        target.write(piece)
        count -= len(piece)
