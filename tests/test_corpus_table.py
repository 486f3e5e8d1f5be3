"""The table of what is said of captures that other people published is the program's, where they are at hand."""

from __future__ import annotations

from pathlib import Path

import pytest
from corpus_table import CORPUS, TABLE, captures, row, table


@pytest.mark.skipif(not CORPUS.is_dir(), reason="no corpus of captures on this machine")
def test_the_table_is_that_of_the_program(tmp_path: Path) -> None:
    assert TABLE.read_text(encoding="utf-8") == table(tmp_path), "python tests/corpus_table.py"


@pytest.mark.skipif(not CORPUS.is_dir(), reason="no corpus of captures on this machine")
def test_every_capture_is_in_it(tmp_path: Path) -> None:
    files = captures()
    assert len(files) >= 30
    assert next(row(files[0], tmp_path)).count("/") == 1


def test_the_table_names_files_only() -> None:
    rows = [line for line in TABLE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")][1:]
    assert rows
    for line in rows:
        name, *rest = line.strip("| ").split(" | ")
        assert name.count("/") == 1 and not any("/" in cell or "#" in cell for cell in rest), line
