"""The user's own file: the language where nothing else says one, and nothing besides."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Runner


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A folder for the files of programs, with that of canalyze."""
    (tmp_path / "home/canalyze").mkdir(parents=True)
    (tmp_path / "home/canalyze/config.toml").write_text('lang = "en"\n')
    return tmp_path / "home"


def is_english(canalyze: Runner, own: Path, *args: str, **env: str) -> bool:
    done = canalyze("explain", "705#7F", *args, env={"XDG_CONFIG_HOME": str(own)} | env)
    assert done.code == 0, done.err
    return "heartbeat of node 5" in done.out


def test_it_says_the_language_where_nothing_else_does(canalyze: Runner, own: Path, tmp_path: Path) -> None:
    assert is_english(canalyze, own) and not is_english(canalyze, tmp_path / "nowhere")
    assert not is_english(canalyze, own, "--lang", "zh") and not is_english(canalyze, own, CANALYZE_LANG="zh")
    (tmp_path / "canalyze.toml").write_text("jitter_us = 1000\n")
    assert is_english(canalyze, own)
    (tmp_path / "canalyze.toml").write_text('lang = "zh"\n')
    assert not is_english(canalyze, own)


def test_it_is_looked_for_below_the_home_directory(canalyze: Runner, own: Path, tmp_path: Path) -> None:
    own.rename(tmp_path / ".config")
    for folder in ("", "relative/path"):
        env = {"XDG_CONFIG_HOME": folder, "HOME": str(tmp_path)}
        assert is_english(canalyze, own, **env) == (folder == "")


def test_nothing_but_the_language_can_be_set(canalyze: Runner, own: Path) -> None:
    file = own / "canalyze/config.toml"
    env = {"XDG_CONFIG_HOME": str(own)}
    for text, said in (
        ('lang = "en"\nbitrate = "500k"\n', "只能有 lang"),
        ("[check]\nfail_on = 'error'\n", "只能有 lang"),
        ("lang = \n", "TOML"),
        ('lang = "de"\n', "lang"),
    ):
        file.write_text(text)
        for more in ((), ("--config", "/dev/null")):
            done = canalyze("explain", "705#7F", *more, env=env)
            assert done.code == 2 and len(done.complaints) == 1 and str(file) in done.err and said in done.err
        assert canalyze("explain", "705#7F", "--lang", "en", env=env).code == 0  # then nothing asks for it
    file.write_text("")
    assert not is_english(canalyze, own)
