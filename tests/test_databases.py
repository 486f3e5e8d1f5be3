"""SQLite databases as a bus leaves them: cut, half written, still open. Their files stay as they are.

What is in a whole one is proven with every other format in `test_formats.py`.
"""

import contextlib
import os
import signal
import sqlite3
import struct
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import can
import pytest
from conftest import Runner
from test_pythoncan import told, written

from canalyze.sources import open_capture
from canalyze.sources.bridge.reading import heed, interruptible

COUNT = 400


def messages(count: int = COUNT) -> list[can.Message]:
    """Heartbeats and SDO, a second apart."""
    return [
        can.Message(timestamp=1_700_000_000.0 + n, arbitration_id=0x581 + n % 7, is_extended_id=False, data=bytes(8))
        for n in range(count)
    ]


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A database of some pages; its writer takes seconds."""
    return written("db", tmp_path_factory.mktemp("once") / "a.db", messages()).read_bytes()


@pytest.fixture
def database(tmp_path: Path, once: bytes) -> Path:
    """That database, in a file of the test's own."""
    path = tmp_path / "a.db"
    path.write_bytes(once)
    return path


def kept(directory: Path) -> dict[str, bytes]:
    """All files there are, and what is in them."""
    return {path.name: path.read_bytes() for path in directory.iterdir()}


def insert(connection: sqlite3.Connection, count: int) -> None:
    """Write further rows without a commit."""
    rows: Sequence[tuple[object, ...]] = [(2e9 + n, 1, 0, 0, 0, 8, bytes(8)) for n in range(count)]
    connection.executemany("INSERT INTO messages VALUES (?, ?, ?, ?, ?, ?, ?)", rows)


def test_a_cut_database_gives_the_rows_of_its_whole_pages(database: Path, tmp_path: Path) -> None:
    data = database.read_bytes()
    whole, complaints = told(open_capture(str(database)))
    assert (len(whole), complaints) == (COUNT, [])
    cut = tmp_path / "cut.db"
    seen = 0
    for size in range(len(data) - 1, 3 * 4096, -373):
        cut.write_bytes(data[:size])
        frames, complaints = told(open_capture(str(cut)))
        assert frames == whole[: len(frames)], size
        assert len(complaints) == 1, (size, complaints)
        assert "CAP005" in complaints[0], complaints
        seen = max(seen, len(frames))
        assert cut.read_bytes() == data[:size]
    assert seen > COUNT // 2


def test_a_page_of_zeros_is_told(database: Path) -> None:
    data = bytearray(database.read_bytes())
    data[4 * 4096 : 5 * 4096] = bytes(4096)
    database.write_bytes(data)
    frames, complaints = told(open_capture(str(database)))
    assert 0 < len(frames) < COUNT
    assert any("CAP004" in line for line in complaints)
    assert all(frame["id"] in {f"{0x581 + n:03X}" for n in range(7)} for frame in frames)


def test_what_was_not_committed_is_not_read_and_stays(database: Path, tmp_path: Path) -> None:
    connection = sqlite3.connect(database)
    connection.execute("PRAGMA cache_size = 1")
    insert(connection, 5000)  # more than is kept in memory: it stands in the file
    died = tmp_path / "died"
    died.mkdir()
    for path in (database, database.with_name("a.db-journal")):
        (died / path.name).write_bytes(path.read_bytes())
    connection.close()
    before = kept(died)
    assert len(before) == 2
    frames, complaints = told(open_capture(str(died / "a.db")))
    assert (len(frames), complaints) == (COUNT, [])
    assert kept(died) == before


def test_rows_that_stand_in_the_log_beside_it(database: Path, tmp_path: Path) -> None:
    connection = sqlite3.connect(database)
    connection.execute("PRAGMA journal_mode = WAL")
    insert(connection, 10)
    connection.commit()
    left = tmp_path / "left"
    left.mkdir()
    for path in (database, database.with_name("a.db-wal")):
        (left / path.name).write_bytes(path.read_bytes())
    connection.close()
    before = kept(left)
    frames, complaints = told(open_capture(str(left / "a.db")))
    assert (len(frames), complaints) == (COUNT + 10, [])
    assert kept(left) == before


def test_a_database_that_another_program_holds(canalyze: Runner, database: Path) -> None:
    connection = sqlite3.connect(database)
    connection.execute("BEGIN EXCLUSIVE")
    done = canalyze("decode", "a.db")
    connection.close()
    assert (done.code, done.out.count("[8]"), done.complaints) == (0, COUNT, [])


COLUMNS = "ts REAL, arbitration_id INTEGER, extended INTEGER, remote INTEGER, error INTEGER, dlc INTEGER"
ROW = "1.0 AS ts, 385 AS arbitration_id, 0 AS extended, 0 AS remote, 0 AS error, 8 AS dlc"


@pytest.mark.parametrize(
    "schema",
    [
        f"CREATE VIEW messages AS SELECT {ROW}, zeroblob(900000000) AS data",
        f"CREATE VIEW Messages AS WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r) "
        f"SELECT {ROW}, x'00' AS data FROM r WHERE n < 0",
        f"CREATE TABLE messages ({COLUMNS}, data BLOB GENERATED ALWAYS AS (zeroblob(900000000)) VIRTUAL)",
        "CREATE VIRTUAL TABLE messages USING fts5(ts, arbitration_id, extended, remote, error, dlc, data)",
    ],
    ids=["large", "endless", "column", "virtual"],
)
@pytest.mark.parametrize("command", ["decode", "info", "check", "summary"])
def test_what_a_file_computes_is_not_read(canalyze: Runner, tmp_path: Path, schema: str, command: str) -> None:
    with contextlib.closing(sqlite3.connect(tmp_path / "a.db")) as connection:
        connection.execute(schema)
        if "GENERATED" in schema:
            connection.execute("INSERT INTO messages VALUES (1.0, 385, 0, 0, 0, 8)")
        connection.commit()
    done = canalyze(command, "--lang", "en", "a.db")
    assert done.code == 2
    said = "a.db: not read, its messages is a view or has computed columns"
    assert said in done.out + done.err
    assert "Traceback" not in done.err


def test_a_row_that_is_too_large_ends_the_reading(canalyze: Runner, database: Path) -> None:
    with contextlib.closing(sqlite3.connect(database)) as connection:
        connection.execute("INSERT INTO messages VALUES (2e9, 1, 0, 0, 0, 8, zeroblob(100000))")
        connection.commit()
    done = canalyze("decode", "--lang", "en", "a.db")
    # Python's cursor is a row ahead of what it gives.
    assert done.out.count("[8]") >= COUNT - 1
    assert "CAP004" in done.err


def test_pages_in_circles_end(canalyze: Runner, tmp_path: Path, database: Path) -> None:
    """Pages that name one page again and again would give its rows for ages."""
    with contextlib.closing(sqlite3.connect(database)) as connection:
        (root,) = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'messages'").fetchone()
    data = bytearray(database.read_bytes())
    (size,) = struct.unpack_from(">H", data, 16)
    start = (root - 1) * size
    assert data[start] == 5, "an inner page"
    (leaf,) = struct.unpack_from(">I", data, start + struct.unpack_from(">H", data, start + 12)[0])
    count = 300
    first = len(data) // size + 1
    levels = [*range(first, first + 8), leaf]
    for below in levels[1:]:
        page = bytearray(size)
        cells = size - 6 * count
        struct.pack_into(">BHHHBI", page, 0, 5, 0, count, cells, 0, below)
        for no in range(count):
            struct.pack_into(">H", page, 12 + 2 * no, cells + 6 * no)
            struct.pack_into(">IBB", page, cells + 6 * no, below, 0x81, no % 0x80)
        data += page
    struct.pack_into(">I", data, start + 8, first)
    for no in range(struct.unpack_from(">H", data, start + 3)[0]):
        struct.pack_into(">I", data, start + struct.unpack_from(">H", data, start + 12 + 2 * no)[0], first)
    struct.pack_into(">I", data, 28, len(data) // size)
    (tmp_path / "circles.db").write_bytes(data)
    done = canalyze("decode", "--lang", "en", "circles.db")
    assert "CAP004" in done.err
    assert done.out.count("[8]") < len(data) // 8 + 1


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_a_signal_ends_what_sqlite_is_at(tmp_path: Path) -> None:
    def wish(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, wish)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        started = time.monotonic()
        with contextlib.closing(sqlite3.connect(tmp_path / "a.db")) as connection:
            interruptible(connection)
            endless = "WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r) SELECT n FROM r WHERE n < 0"
            with pytest.raises(KeyboardInterrupt):
                try:
                    connection.execute(endless).fetchall()
                except sqlite3.Error as error:
                    heed(error)
        assert time.monotonic() - started < 1.2
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_a_signal_leaves_no_copy_behind(tmp_path: Path, database: Path) -> None:
    """The check of all pages is what takes long: of a table that is not read."""
    with contextlib.closing(sqlite3.connect(database)) as connection:
        connection.execute("CREATE TABLE other (number INTEGER, text TEXT)")
        rows = "WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r LIMIT 2000000) SELECT n, n FROM r"
        connection.execute(f"INSERT INTO other {rows}")
        connection.execute("CREATE INDEX both ON other (text, number)")
        connection.commit()
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    command = [sys.executable, "-m", "canalyze", "decode", str(database)]
    environment = os.environ | {"TMPDIR": str(scratch)}
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment) as process:
        while not any(scratch.rglob("*.sqlite")) and process.poll() is None:
            time.sleep(0.01)
        time.sleep(0.1)
        asked = time.monotonic()
        process.terminate()
        code = process.wait(10)
    assert time.monotonic() - asked < 1.5
    assert code in (0, -signal.SIGTERM, 128 + signal.SIGTERM)  # it may have been done already
    assert not list(scratch.iterdir())


def test_asammdf_is_imported_for_mf4_alone(database: Path, tmp_path: Path) -> None:
    pytest.importorskip("asammdf")
    script = """
import sys
from canalyze.cli import main
def run(*args):
    try:
        main(list(args))
    except SystemExit as end:
        assert not end.code, end.code
run("convert", "a.db", "a.blf")
run("decode", "-o", "a.txt", "a.blf")
assert "can" in sys.modules and "asammdf" not in sys.modules
run("convert", "a.blf", "a.mf4")
run("decode", "-o", "b.txt", "a.mf4")
assert "asammdf" in sys.modules
"""
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert [(tmp_path / name).read_text().count("[8]") for name in ("a.txt", "b.txt")] == [COUNT, COUNT]
