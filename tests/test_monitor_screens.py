"""The screen of `canalyze monitor`, whole, in both languages: `python tests/regenerate.py` writes it anew."""

from pathlib import Path

import pytest
from monitor_screens import FOLDER, SCREENS, SIZES, golden, goldens, screens
from rich.cells import cell_len


@pytest.mark.parametrize(("capture", "size", "lang"), goldens(), ids=lambda one: getattr(one, "stem", str(one)))
def test_screen_is_the_golden_one(capture: Path, size: tuple[int, int], lang: str) -> None:
    assert screens(capture, size, lang) == golden(capture, size, lang).read_text()


@pytest.mark.parametrize(("capture", "size", "lang"), goldens(), ids=lambda one: getattr(one, "stem", str(one)))
def test_golden_screen_fits_the_terminal(capture: Path, size: tuple[int, int], lang: str) -> None:
    pages = golden(capture, size, lang).read_text().split("--- ")[1:]
    assert len(pages) == 8
    for page in pages:
        lines = page.splitlines()[1:]
        assert len(lines) == size[1]
        assert all(cell_len(line) <= size[0] for line in lines)


def test_every_golden_screen_is_compared() -> None:
    assert {path.name for path in FOLDER.iterdir()} == {golden(*one).name for one in goldens()}
    assert len(SCREENS) * len(SIZES) * 2 == len(goldens())
