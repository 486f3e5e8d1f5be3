"""The data of transfers as files in a directory.

Bytes go to disk as they come, into NAME.part, and get their name when the transfer has ended: NAME, or NAME.aborted and
the like. Files that exist are kept. Names are the core's, and safe.
"""

import errno
import os
from collections.abc import Callable
from pathlib import Path

from canalyze.errors import OutputError
from canalyze.words import Words


class Directory:
    """A directory that fills with files."""

    def __init__(self, name: str, words: Words, tell: Callable[[str], None], *, force: bool) -> None:
        """Make the directory if it is not there; OutputError if that cannot be."""
        self.written = 0
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

    def add(self, pieces: list[tuple[str, bytes, str]]) -> None:
        """Take (name, more bytes, status) as the core gives them."""
        for name, data, status in pieces:
            try:
                self._add(name, data, status)
            except OSError as error:
                raise OutputError("output.write", name=self._path / name, error=error) from error

    def _add(self, name: str, data: bytes, status: str) -> None:
        part = self._path / f"{name}.part"
        if name not in self._open:
            self._open[name] = self._free(self._path / name)
            if self._open[name]:
                part.write_bytes(b"")
        if self._open[name] and data:
            with part.open("ab") as file:
                file.write(data)
        if status:
            self._end(name, status)

    def _end(self, name: str, status: str) -> None:
        if not self._open.pop(name):
            return
        final = self._path / (name if status == "ok" else f"{name}.{status}")
        if self._free(final):
            (self._path / f"{name}.part").replace(final)
            self.written += 1
        else:
            (self._path / f"{name}.part").unlink()

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
