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


EXAMPLES = re.findall(r"^```python\n(.+?)^```$", README, flags=re.DOTALL | re.MULTILINE)


@pytest.fixture
def boot(tmp_path: Path) -> Path:
    """Give a folder with the files that the examples name."""
    (tmp_path / "boot.log").write_bytes((SAMPLES / "network/sync-and-pdos.log").read_bytes())
    (tmp_path / "drive.eds").write_bytes((ROOT / "eds/drive.eds").read_bytes())
    (tmp_path / "boot.expect.toml").write_text('[[sdo]]\nnode = 5\nobject = "1017:00"\nvalue = 100\n')
    return tmp_path


def test_the_example_of_the_library_holds(boot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (example,) = (example for example in EXAMPLES if "import canalyze" in example)
    monkeypatch.chdir(boot)
    exec(example, {})


def test_the_example_of_pytest_holds(boot: Path, pytester: pytest.Pytester) -> None:
    (example,) = (example for example in EXAMPLES if "def test_" in example)
    (boot / "test_boot.py").write_text(example)
    done = pytester.runpytest_subprocess("--canalyze-update", "-p", "no:cacheprovider", str(boot))
    done.assert_outcomes(passed=1)
    (boot / "test_boot.py").write_text(example + "    " + _failing() + "\n")
    done = pytester.runpytest_subprocess("-p", "no:cacheprovider", str(boot))
    done.assert_outcomes(failed=1)
    shown = README.split("shows the annotated lines that it is about:\n\n```\n")[1].split("```")[0]
    for line in shown.splitlines():
        assert line.strip(" >-") in done.stdout.str()


def _failing() -> str:
    return README.split("\n>       ")[1].split("\n")[0]


def test_there_are_listings_in_both_languages() -> None:
    assert len(LISTINGS) == 4


def test_named_files_exist() -> None:
    adding = README.split("## Adding to it")[1]
    named = set(re.findall(r"`((?:canalyze|tests|samples|checks|render|text)/[\w/.]*)`", adding))
    places = [ROOT, ROOT / "canalyze/core/src"]
    assert not [name for name in named if not any((place / name).exists() for place in places)]
    assert len(named) > 10
