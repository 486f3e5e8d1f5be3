"""A private copy of an SQLite database, so that nothing that reads it can change or lock the file.

Who opens a database rolls back what another program left half done in it, and writes that into the file. It happens
to the copy here. A database that is cut has its pages counted anew in the copy, so that rows of whole pages are still
read: else SQLite reads none, or takes a page's missing half for zeros and gives rows that nobody wrote. What a file
can make SQLite do has bounds: nothing is read that the file has computed, and a signal ends every query. Must not:
know more of a table than that it is one.
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
_LEAST_ROW: Final = 8
"""Bytes of a row of seven columns: there are more, whatever it holds."""
_LIMITS: Final = (
    (sqlite3.SQLITE_LIMIT_LENGTH, 1 << 16),
    (sqlite3.SQLITE_LIMIT_COLUMN, 100),
    (sqlite3.SQLITE_LIMIT_EXPR_DEPTH, 50),
    (sqlite3.SQLITE_LIMIT_COMPOUND_SELECT, 5),
    (sqlite3.SQLITE_LIMIT_ATTACHED, 0),
    (sqlite3.SQLITE_LIMIT_WORKER_THREADS, 0),
)
"""What a table of frames never comes near: a row of it has less than 200 bytes."""
_ERRORS: Final = (sqlite3.Error, UnicodeError)
"""What a damaged file makes SQLite say, which may be no text."""
_STEPS: Final = 10_000
"""Steps of SQLite between two looks at what else there is to do: less than a millisecond."""


class Copy:
    """A copy of a database, with what is known of its soundness."""

    def __init__(self, database: Path, original: Path | None) -> None:
        """Take a database as it was put down at `database`; `original`: the file whose copy it is, if it has one."""
        self.path = database
        self.cut: tuple[int, int] | None = None
        """Where a page is missing, and the bytes of it that are there; None if all are."""
        if not (original and _journals(original, database)):
            self.cut = _recounted(database)

        self.most_rows = database.stat().st_size // _LEAST_ROW
        """More rows than this are not in it: where there are, its pages go in circles."""

    def computes(self, table: str) -> bool:
        """Whether what seems to be a table is a view, or computed otherwise."""
        try:
            with contextlib.closing(sqlite3.connect(self.path)) as connection:
                bound(connection)
                kinds = connection.execute(
                    "SELECT type = 'table' AND rootpage > 0 FROM sqlite_master WHERE name = ? COLLATE NOCASE"
                    " AND type IN ('table', 'view')",
                    (table,),
                ).fetchall()
                hidden = connection.execute("SELECT max(hidden) FROM pragma_table_xinfo(?)", (table,)).fetchall()
        except _ERRORS as error:
            heed(error)
            return False  # whoever reads it says what is wrong with it
        return any(not stored for (stored,) in kinds) or any(most for (most,) in hidden)

    def sound(self) -> bool:
        """Whether all pages fit together, as SQLite itself judges."""
        try:
            with contextlib.closing(sqlite3.connect(self.path)) as connection:
                interruptible(connection)
                connection.execute("PRAGMA ignore_check_constraints = ON")  # they may compute what they like
                return connection.execute("PRAGMA quick_check(1)").fetchall() == [("ok",)]
        except _ERRORS as error:
            heed(error)
            return False


def bound(connection: sqlite3.Connection) -> None:
    """Set limits to what a file may make of a connection on which nothing was read yet."""
    for limit, most in _LIMITS:
        connection.setlimit(limit, most)
    interruptible(connection)


def interruptible(connection: sqlite3.Connection) -> None:
    """Let signals be answered while SQLite is at work; `heed` gives what they raise."""
    connection.set_progress_handler(lambda: 0, _STEPS)


def heed(error: BaseException) -> None:
    """Raise KeyboardInterrupt if that is why a query has ended: SQLite passes nothing on that is raised in it."""
    if isinstance(error, sqlite3.Error) and getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_INTERRUPT:
        raise KeyboardInterrupt from None


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
