"""A timeline is in English where no font has Chinese, and that is said in one line.

What it must not do: depend on the fonts of the machine that runs it.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from canalyze.running.viewing import drawn_in
from canalyze.timeline.viewer import has_chinese
from canalyze.words import Words


@pytest.fixture(autouse=True)
def linux(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "linux")


def says(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """A fontconfig of our own."""
    program = folder / "fc-list"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")


@pytest.mark.parametrize(
    ("script", "there"),
    [
        ('[ "$1" = :lang=zh ] && echo /usr/share/fonts/some.ttc', True),
        ("exit 0", False),
        ("exit 1", True),  # it does not know: nothing is said against Chinese
    ],
)
def test_fontconfig_is_asked(script: str, there: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    says(tmp_path, monkeypatch, script)
    assert has_chinese(web=False) is there


@pytest.mark.parametrize("name", ["some.ttf", "fonts/x/some.OTF", "readme.txt"])
def test_without_fontconfig_any_font_will_do(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / name).touch()
    monkeypatch.setenv("PATH", str(tmp_path / "nothing"))
    monkeypatch.setattr("canalyze.timeline.viewer._FOLDERS", (str(tmp_path), str(tmp_path / "none")))
    assert has_chinese(web=False) is not name.endswith("txt")


def test_a_page_has_no_chinese() -> None:
    assert not has_chinese(web=True)


def test_others_have_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "darwin")
    monkeypatch.setenv("PATH", "")
    assert has_chinese(web=False)


def test_it_is_said_once_and_then_english(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    says(tmp_path, monkeypatch, "exit 0")
    assert drawn_in(Words("zh"), said.append, web=False).lang == "en"
    assert drawn_in(Words("zh"), said.append, web=True).lang == "en"
    assert ["没有中文字体" in line for line in said] == [True, True]
    assert ["浏览器" in line for line in said] == [False, True]
    assert drawn_in(Words("en"), said.append, web=False).lang == "en"
    says(tmp_path, monkeypatch, "echo font")
    assert drawn_in(Words("zh"), said.append, web=False).lang == "zh"
    assert len(said) == 2
