"""SQLite databases as a bus leaves them: cut, half written, still open. Their files stay as they are.

What is in a whole one is proven with every other format in `test_formats.py`.
"""

import sqlite3
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import can
import pytest
from conftest import Runner
from test_pythoncan import told, written

from canalyze.sources.format import open_capture

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
