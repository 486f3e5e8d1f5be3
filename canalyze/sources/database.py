"""A private copy of an SQLite database, so that nothing that reads it can change or lock the file.

Who opens a database rolls back what another program left half done in it, and writes that into the file. It happens
to the copy here. A database that is cut has its pages counted anew in the copy, so that rows of whole pages are still
read: else SQLite reads none, or takes a page's missing half for zeros and gives rows that nobody wrote. Must not:
know a table.
"""

import contextlib
import shutil
import sqlite3
import struct
from pathlib import Path
from typing import Final

_HEAD: Final = 100
_JOURNALS: Final = ("-journal", "-wal")
"""What stands beside a database while it is written, and behind a program that died."""


class Copy:
    """A copy of a database, with what is known of its soundness."""

    def __init__(self, database: Path, original: Path | None) -> None:
        """Take a database as it was put down at `database`; `original`: the file whose copy it is, if it has one."""
        self.path = database
        self.cut: tuple[int, int] | None = None
        """Where a page is missing, and the bytes of it that are there; None if all are."""
        if not (original and _journals(original, database)):
            self.cut = _recounted(database)

    def sound(self) -> bool:
        """Whether all pages fit together, as SQLite itself judges."""
        try:
            with contextlib.closing(sqlite3.connect(self.path)) as connection:
                return connection.execute("PRAGMA quick_check(1)").fetchall() == [("ok",)]
        except sqlite3.Error:
            return False


def copied(original: Path, directory: Path) -> Copy:
    """Copy a database into a directory; OSError if that cannot be."""
    database = directory / "copy.sqlite"
    shutil.copyfile(original, database)
    return Copy(database, original)


def _journals(original: Path, database: Path) -> bool:
    """Copy what stands beside the database, behind it: what is written meanwhile is undone with it."""
    there = False
    for suffix in _JOURNALS:
        beside = original.with_name(original.name + suffix)
        with contextlib.suppress(FileNotFoundError):
            shutil.copyfile(beside, database.with_name(database.name + suffix))
            there |= beside.stat().st_size > 0
    return there


def _recounted(database: Path) -> tuple[int, int] | None:
    """Make a cut database one of its whole pages; tell where it was cut and what was behind, None if it is whole."""
    with database.open("r+b") as file:
        head = file.read(_HEAD)
        if len(head) < _HEAD:
            return None
        (size,) = struct.unpack_from(">H", head, 16)
        size = 65_536 if size == 1 else size
        if size < 512 or size & (size - 1):
            return None
        whole, rest = divmod(database.stat().st_size, size)
        changes, pages = struct.unpack_from(">II", head, 24)
        (valid_for,) = struct.unpack_from(">I", head, 92)
        counted = pages > 0 and changes == valid_for  # programs before 2010 do not count
        if whole == 0 or (whole >= pages if counted else rest == 0):
            return None
        file.seek(28)
        file.write(struct.pack(">I", whole))
        file.truncate(whole * size)
    return whole * size, rest
