"""An MCAP that was written until its writer was killed: said where it is met, and made whole by `convert`.

Held against mcap's own reader. What it must not do: start a bus.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Runner

from canalyze.errors import OutputError
from canalyze.running.recording import Recording
from canalyze.words import Words

mcap = pytest.importorskip("mcap.reader")

FRAMES = "".join(f"({1700000000 + no / 1000:.6f}) can0 185#{no:04X}\n" for no in range(500))


@pytest.fixture
def unfinished(canalyze: Runner, tmp_path: Path) -> Path:
    """As `sniff --record` leaves it: whole chunks, no footer."""
    (tmp_path / "x.log").write_text(FRAMES)
    assert canalyze("convert", "x.log", "whole.mcap").code == 0
    whole = (tmp_path / "whole.mcap").read_bytes()
    (tmp_path / "x.mcap").write_bytes(whole[: len(whole) * 9 // 10])
    return tmp_path / "x.mcap"


def messages(path: Path) -> int:
    with path.open("rb") as file:
        return sum(1 for _ in mcap.make_reader(file).iter_messages())


def test_info_says_how_it_is_made_whole(unfinished: Path, canalyze: Runner, tmp_path: Path) -> None:
    with pytest.raises(Exception):  # noqa: B017 - mcap raises several kinds
        messages(unfinished)
    done = canalyze("--lang", "en", "info", "x.mcap")
    assert "canalyze convert x.mcap NEW.mcap writes a whole one" in done.out
    assert "canalyze convert x.mcap 新文件.mcap" in canalyze("--lang", "zh", "info", "x.mcap").out
    assert "NEW.mcap" not in canalyze("--lang", "en", "info", "whole.mcap").out
    assert canalyze("convert", "x.mcap", "y.mcap").code in (0, 1)
    lines = canalyze("decode", "x.mcap").lines
    there = sum("185" in line for line in lines if not line.startswith("#"))
    assert messages(tmp_path / "y.mcap") == there > 0


def test_a_recording_of_the_same_name_says_it(unfinished: Path, tmp_path: Path) -> None:
    with pytest.raises(OutputError) as error:
        Recording(str(unfinished), Words("en"))
    assert error.value.key == "record.unfinished"
    with pytest.raises(OutputError) as error:
        Recording(str(tmp_path / "whole.mcap"), Words("en"))
    assert error.value.key == "output.exists"
