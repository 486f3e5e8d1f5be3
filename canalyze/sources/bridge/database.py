"""A private copy of an SQLite database, so that reading cannot change or lock the file.

Opening a database rolls back an unfinished transaction of another program and writes to the file; here this happens
to the copy. In the copy of a truncated database the number of pages is corrected, so that the rows of whole pages
can still be read: SQLite itself would read none, or take the missing half of a page for zeros. The work that a
file can cause in SQLite is bounded: nothing that the file computes is read, and a signal ends every query.
Must not: know the columns of a table.
"""

import contextlib
import shutil
import sqlite3
import struct
from pathlib import Path
from typing import Final

_HEAD: Final = 100
_JOURNALS: Final = ("-journal", "-wal")
"""Suffixes of the files beside a database that is being written, or whose writer has crashed."""
_LEAST_ROW: Final = 8
"""Minimum size of a row of seven columns, in bytes."""
_LIMITS: Final = (
    (sqlite3.SQLITE_LIMIT_LENGTH, 1 << 16),
    (sqlite3.SQLITE_LIMIT_COLUMN, 100),
    (sqlite3.SQLITE_LIMIT_EXPR_DEPTH, 50),
    (sqlite3.SQLITE_LIMIT_COMPOUND_SELECT, 5),
    (sqlite3.SQLITE_LIMIT_ATTACHED, 0),
    (sqlite3.SQLITE_LIMIT_WORKER_THREADS, 0),
)
"""Limits well above the needs of a table of frames, whose rows have less than 200 bytes."""
_ERRORS: Final = (sqlite3.Error, UnicodeError)
"""Exceptions that SQLite raises for damaged files, also for undecodable text."""
_STEPS: Final = 10_000
"""Steps of SQLite between two checks for signals: less than a millisecond."""


class Copy:
    """A copy of a database, and where it is truncated."""

    def __init__(self, original: Path, directory: Path) -> None:
        """Copies a database to a directory, unless it is there already. Raises OSError if that fails."""
        self.path = original if original.parent == directory else directory / "copy.sqlite"
        if self.path != original:
            shutil.copyfile(original, self.path)
        self.cut: tuple[int, int] | None = None
        """The place of an incomplete page, and the bytes of it that are there; None if the database is whole."""
        if self.path == original or not _journals(original, self.path):
            self.cut = _recounted(self.path)
        self.most_rows = self.path.stat().st_size // _LEAST_ROW
        """Maximum number of rows; more mean that its pages form a circle."""

    def computes(self, table: str) -> bool:
        """Returns true if `table` is a view or has computed columns."""
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
            return False  # the reader reports it
        return any(not stored for (stored,) in kinds) or any(most for (most,) in hidden)

    def sound(self) -> bool:
        """Returns true if SQLite's quick check finds no damage."""
        try:
            with contextlib.closing(sqlite3.connect(self.path)) as connection:
                interruptible(connection)
                connection.execute("PRAGMA ignore_check_constraints = ON")  # they may compute what they like
                return connection.execute("PRAGMA quick_check(1)").fetchall() == [("ok",)]
        except _ERRORS as error:
            heed(error)
            return False


def bound(connection: sqlite3.Connection) -> None:
    """Limits the work that a file can cause on a new connection."""
    for limit, most in _LIMITS:
        connection.setlimit(limit, most)
    interruptible(connection)


def interruptible(connection: sqlite3.Connection) -> None:
    """Makes queries of a connection interruptible by signals; `heed` raises their exceptions."""
    connection.set_progress_handler(lambda: 0, _STEPS)


def heed(error: BaseException) -> None:
    """Raises KeyboardInterrupt if it ended the query, because SQLite swallows exceptions raised in its callbacks."""
    if isinstance(error, sqlite3.Error) and getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_INTERRUPT:
        raise KeyboardInterrupt from None


def _journals(original: Path, database: Path) -> bool:
    """Copies the journals of a database after it, so that changes made meanwhile are rolled back with them."""
    there = False
    for suffix in _JOURNALS:
        beside = original.with_name(original.name + suffix)
        with contextlib.suppress(FileNotFoundError):
            shutil.copyfile(beside, database.with_name(database.name + suffix))
            there |= beside.stat().st_size > 0
    return there


def _recounted(database: Path) -> tuple[int, int] | None:
    """Reduces a truncated database to its whole pages.

    Returns where it was cut and the number of bytes behind, or None if it is whole.
    """
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
