"""Files of transfers: names by outcome, nothing overwritten, nothing left half named."""

import json
from pathlib import Path

import pytest

from canalyze.errors import OutputError
from canalyze.reports.extract import Directory
from canalyze.words import Words


def directory(path: Path, told: list[str], *, force: bool = False) -> Directory:
    """Give a directory that tells into a list."""
    return Directory(str(path), Words("en"), told.append, force=force)


def names(path: Path) -> list[str]:
    """Give the files there."""
    return sorted(file.name for file in path.iterdir())


def test_name_follows_the_outcome(tmp_path: Path) -> None:
    files = directory(tmp_path, [])
    files.add(
        [
            ("a.bin", b"12", "", [], ""),
            ("b.bin", b"x", "", [], ""),
            ("a.bin", b"34", "ok", [], ""),
            ("b.bin", b"", "aborted", [], ""),
        ]
    )
    assert names(tmp_path) == ["a.bin", "b.bin.aborted"]
    assert (tmp_path / "a.bin").read_bytes() == b"1234"
    assert (files.written, files.code) == (2, 0)


def test_bytes_are_on_disk_while_the_transfer_runs(tmp_path: Path) -> None:
    files = directory(tmp_path, [])
    files.add([("a.bin", b"12", "", [], "")])
    (part,) = tmp_path.glob("a.bin.*.part")
    assert part.read_bytes() == b"12"
    files.close()
    assert names(tmp_path) == ["a.bin.incomplete"]


def test_part_of_an_earlier_run_is_not_continued(tmp_path: Path) -> None:
    (tmp_path / "a.bin.part").write_bytes(b"old")
    directory(tmp_path, []).add([("a.bin", b"new", "ok", [], "")])
    assert (tmp_path / "a.bin").read_bytes() == b"new"


@pytest.mark.parametrize(("taken", "status"), [("a.bin", "ok"), ("a.bin.failed", "failed")])
def test_existing_file_is_kept(tmp_path: Path, taken: str, status: str) -> None:
    (tmp_path / taken).write_bytes(b"mine")
    told: list[str] = []
    files = directory(tmp_path, told)
    files.add([("a.bin", b"12", "", [], ""), ("a.bin", b"34", status, [], "")])
    assert (tmp_path / taken).read_bytes() == b"mine"
    assert names(tmp_path) == [taken]
    assert (files.written, files.code, len(told)) == (0, 2, 1)
    directory(tmp_path, told, force=True).add([("a.bin", b"12", status, [], "")])
    assert (tmp_path / taken).read_bytes() == b"12"


def test_directory_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(OutputError):
        directory(tmp_path / "file" / "below", [])


def test_a_hole_is_filled_and_listed(tmp_path: Path) -> None:
    files = directory(tmp_path, [])
    files.add([("a.bin", b"1234", "", [], ""), ("a.bin", b"56", "incomplete", [(2, 3), (7, None), (9, 4)], "")])
    assert names(tmp_path) == ["a.bin.incomplete", "a.bin.incomplete.holes.json"]
    assert (tmp_path / "a.bin.incomplete").read_bytes() == b"12\0\0\x003456"
    assert json.loads((tmp_path / "a.bin.incomplete.holes.json").read_text()) == {
        "file": "a.bin.incomplete",
        "size": 9,
        "fill": "00",
        "holes": [{"offset": 2, "length": 3}, {"offset": 7, "length": None}, {"offset": 9, "length": 4}],
    }
    assert (files.written, files.holed) == (1, 1)


def test_a_list_of_holes_that_exists_is_kept(tmp_path: Path) -> None:
    (tmp_path / "a.bin.incomplete.holes.json").write_text("mine")
    files = directory(tmp_path, [])
    files.add([("a.bin", b"12", "incomplete", [(2, None)], "")])
    assert names(tmp_path) == ["a.bin.incomplete.holes.json"]
    assert (files.written, files.code) == (0, 2)
    directory(tmp_path, [], force=True).add([("a.bin", b"12", "incomplete", [], "")])
    assert names(tmp_path) == ["a.bin.incomplete"]


def test_without_a_byte_only_what_is_complete_is_a_file(tmp_path: Path) -> None:
    files = directory(tmp_path, [])
    files.add(
        [("a.bin", b"", "", [], ""), ("b.bin", b"", "incomplete", [(0, 7)], ""), ("c.bin", b"", "aborted", [], "")]
    )
    assert names(tmp_path) == []
    files.add([("a.bin", b"", "ok", [], "")])
    files.close()
    assert names(tmp_path) == ["a.bin"]
    assert (files.written, files.holed) == (1, 0)
