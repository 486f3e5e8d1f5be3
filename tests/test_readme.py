"""The README is true: its listings are what the program says, and the files it names are there.

What it must not do: run the README's two commands; whoever installs from it does that.
"""

import re
from pathlib import Path

import pytest
from captures import SAMPLES, run_canalyze

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
LISTINGS = re.findall(r"^```\n(can1 .+?|vcan0 .+?)^```$", README, flags=re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("listing", LISTINGS, ids=lambda listing: listing.split()[0])
def test_listings_are_the_programs_own(listing: str) -> None:
    lang = "zh" if re.search("[\u4e00-\u9fff]", listing) else "en"
    if listing.startswith("can1"):
        arguments: list[str | Path] = [SAMPLES / "zephyr-sdo.log"]
    else:
        arguments = ["-t", "n", "--eds", f"5={ROOT / 'eds/drive.eds'}", SAMPLES / "network/sync-and-pdos.log"]
    said = run_canalyze(["decode", "--lang", lang, *arguments]).decode()
    for part in listing.split("...\n"):
        assert part in said


def test_there_are_listings_in_both_languages() -> None:
    assert len(LISTINGS) == 4


def test_named_files_exist() -> None:
    adding = README.split("## Adding to it")[1]
    named = set(re.findall(r"`((?:canalyze|tests|samples|checks|render|text)/[\w/.]*)`", adding))
    places = [ROOT, ROOT / "canalyze/core/src"]
    assert not [name for name in named if not any((place / name).exists() for place in places)]
    assert len(named) > 10
