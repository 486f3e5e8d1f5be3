"""What a terminal gets: its encoding, its language, tables, colour, progress."""

import os
import pty
import select
import subprocess
from pathlib import Path

import pytest
from conftest import NOTES, command, environment


def on_terminal(directory: Path, *args: str, only_err: bool = False, **env: str) -> tuple[int, bytes]:
    """Run on a terminal of its own; give the exit code and what the terminal showed."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        command(*args),
        stdin=theirs,
        stdout=subprocess.DEVNULL if only_err else theirs,
        stderr=theirs,
        cwd=directory,
        env=environment(**({"LANG": "C.UTF-8"} | env)),
    )
    os.close(theirs)
    shown = b""
    while select.select([ours], [], [], 60)[0]:
        try:
            piece = os.read(ours, 65536)
        except OSError:  # the other side is closed: how Linux says end of file here
            break
        if not piece:
            break
        shown += piece
    os.close(ours)
    return process.wait(timeout=60), shown


def test_terminal_in_utf8_shows_chinese(tmp_path: Path) -> None:
    code, shown = on_terminal(tmp_path, "--help")
    assert code == 0
    assert shown.decode().startswith("用法：")


def test_terminal_in_gbk_is_transcoded(tmp_path: Path) -> None:
    _, shown = on_terminal(tmp_path, "--help", PYTHONIOENCODING="gbk")
    assert shown.decode("gbk").startswith("用法：")


@pytest.mark.parametrize("env", [{"PYTHONIOENCODING": "latin-1"}, {"LC_ALL": "C"}, {"TERM": "linux"}])
def test_terminal_without_chinese_gets_english(tmp_path: Path, env: dict[str, str]) -> None:
    code, shown = on_terminal(tmp_path, "--help", only_err=False, **env)
    notice, usage, *_ = shown.decode("ascii").splitlines()
    assert code == 0
    assert "--lang" in notice
    assert usage.startswith("Usage:")


def test_chosen_language_stands(tmp_path: Path) -> None:
    _, shown = on_terminal(tmp_path, "--help", PYTHONIOENCODING="latin-1", CANALYZE_LANG="zh")
    assert b"Usage" not in shown and b"--lang" in shown


def test_pipe_is_utf8_whatever_the_locale(tmp_path: Path) -> None:
    done = subprocess.run(
        command("--help"),
        capture_output=True,
        env=environment(LC_ALL="C", PYTHONIOENCODING="latin-1"),
        cwd=tmp_path,
        check=True,
    )
    assert done.stdout.decode("utf-8").startswith("用法：")
    done = subprocess.run(
        command("deocde"),
        capture_output=True,
        env=environment(LC_ALL="C", PYTHONIOENCODING="latin-1"),
        cwd=tmp_path,
        check=False,
    )
    assert "没有命令" in done.stderr.decode("utf-8")


def test_table_on_a_terminal(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    code, shown = on_terminal(tmp_path, "sdo", "notes.log", COLUMNS="80")
    assert code == 0
    assert "1008h:00" in shown.decode()
    _, plain = on_terminal(tmp_path, "rules", NO_COLOR="1")
    for colour in range(30, 38):
        assert f"\x1b[{colour}m".encode() not in plain


def test_no_input_on_a_terminal_is_wrong_usage(tmp_path: Path) -> None:
    for name in ("decode", "sdo", "eds", "explain"):
        code, shown = on_terminal(tmp_path, name)
        assert code == 2
        assert len(shown.splitlines()) == 1


def test_short_work_shows_no_progress(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    assert on_terminal(tmp_path, "decode", "notes.log", only_err=True) == (0, b"")
