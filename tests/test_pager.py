"""The pager between a command and the terminal; the pagers here are small shell commands."""

import os
import shutil
import threading
from pathlib import Path

import pytest
from captures import SAMPLES
from conftest import NOTES
from test_cli_terminal import on_terminal

MARKED = "sed -u s/^/P:/"
"""A pager that marks each line."""
BROKEN = str(SAMPLES / "problems.log")
EXPEDITED = str(SAMPLES / "sdo-expedited.log")


@pytest.fixture(autouse=True)
def notes(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)


@pytest.mark.parametrize(
    "args",
    [
        ["decode", "notes.log"],
        ["notes.log"],
        ["diagnose", "."],
        ["check", "notes.log"],
        ["sdo", "notes.log"],
        ["summary", "notes.log"],
        ["od", "notes.log"],
        ["diff", "notes.log", BROKEN],
        ["info", "notes.log"],
        ["rules"],
        ["explain", "SDO"],
        ["help", "decode"],
        ["signals", "notes.log"],
        ["eds", str(SAMPLES.parent / "eds/drive.eds")],
    ],
    ids=" ".join,
)
def test_text_goes_through_the_pager(tmp_path: Path, args: list[str]) -> None:
    code, shown = on_terminal(tmp_path, *args, CANALYZE_PAGER=MARKED)
    lines = shown.decode().splitlines()
    assert lines and all(line.startswith("P:") for line in lines)
    without, plain = on_terminal(tmp_path, *args, "--no-pager", CANALYZE_PAGER=MARKED)
    assert (without, plain.decode().splitlines()) == (code, [line.removeprefix("P:") for line in lines])


@pytest.mark.parametrize(
    ("env", "paged"),
    [
        ({"CANALYZE_PAGER": "cat", "PAGER": MARKED}, False),
        ({"CANALYZE_PAGER": "", "PAGER": MARKED}, False),
        ({"CANALYZE_PAGER": MARKED, "PAGER": "cat"}, True),
        ({"PAGER": MARKED}, True),
        ({"PAGER": MARKED, "TERM": "dumb"}, False),
        ({"PAGER": ""}, False),
    ],
)
def test_which_pager(tmp_path: Path, env: dict[str, str], paged: bool) -> None:
    code, shown = on_terminal(tmp_path, "decode", "notes.log", only_err=False, **env)
    assert code == 0 and shown.startswith(b"P:") == paged


def test_input_that_still_comes_has_no_pager(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    writer = os.open(tmp_path / "pipe", os.O_RDWR)
    os.write(writer, NOTES.encode())
    threading.Timer(1, os.close, [writer]).start()
    code, shown = on_terminal(tmp_path, "decode", "pipe", CANALYZE_PAGER=MARKED)
    assert code == 0 and shown and b"P:" not in shown


def test_other_outputs_have_no_pager(tmp_path: Path) -> None:
    code, shown = on_terminal(tmp_path, "decode", "notes.log", "-o", "a.txt", CANALYZE_PAGER=MARKED)
    assert (code, shown) == (0, b"") and "P:" not in (tmp_path / "a.txt").read_text()
    code, shown = on_terminal(tmp_path, "decode", "notes.log", only_err=True, CANALYZE_PAGER=MARKED)
    assert (code, shown) == (0, b"")
    code, shown = on_terminal(tmp_path, "examples", CANALYZE_PAGER=MARKED)
    assert code == 0 and b"P:" not in shown


def test_nothing_written_begins_no_pager(tmp_path: Path) -> None:
    code, shown = on_terminal(tmp_path, "decode", "missing.log", CANALYZE_PAGER=MARKED)
    assert code == 2 and b"missing.log" in shown and b"P:" not in shown


def test_complaints_stay_among_the_lines(tmp_path: Path) -> None:
    (tmp_path / "odd.log").write_text(NOTES + "(1.0) can0 nonsense\n")
    code, shown = on_terminal(tmp_path, "decode", "odd.log", "missing.log", CANALYZE_PAGER=MARKED)
    (said,) = (line for line in shown.decode().splitlines() if "missing.log" in line)
    assert code == 2 and said.startswith("P:")


@pytest.mark.parametrize(("args", "code"), [(["check", BROKEN], 1), (["check", EXPEDITED], 0), (["decode", BROKEN], 0)])
@pytest.mark.parametrize("pager", [MARKED, "head -n 1", "true", "false"])
def test_exit_codes_are_those_of_the_command(tmp_path: Path, args: list[str], code: int, pager: str) -> None:
    ended, shown = on_terminal(tmp_path, *args, CANALYZE_PAGER=pager)
    assert ended == code and b"Traceback" not in shown


@pytest.mark.parametrize("pager", ["no-such-program -x", "'"])
def test_pager_that_cannot_be_begun(tmp_path: Path, pager: str) -> None:
    code, shown = on_terminal(tmp_path, "decode", "notes.log", "--lang", "en", PAGER=pager)
    said, *lines = shown.decode().splitlines()
    assert code == 0 and said.startswith("canalyze: cannot start the pager ")
    assert len(lines) >= len(NOTES.splitlines())


def test_colours_and_width_are_those_of_the_terminal(tmp_path: Path) -> None:
    args = ("sdo", str(SAMPLES / "sdo-abort.log"))
    paged = on_terminal(tmp_path, *args, CANALYZE_PAGER="tac -s never", COLUMNS="90")
    assert paged == on_terminal(tmp_path, *args, "--no-pager", COLUMNS="90") and b"\x1b[" in paged[1]


def test_less_is_set_up_as_by_git(tmp_path: Path) -> None:
    said = "sh -c 'echo LESS=$LESS $LESSCHARSET; cat'"
    assert on_terminal(tmp_path, "rules", CANALYZE_PAGER=said)[1].startswith(b"LESS=FRX utf-8\r\n")
    assert on_terminal(tmp_path, "rules", CANALYZE_PAGER=said, LESS="S")[1].startswith(b"LESS=S utf-8\r\n")


@pytest.mark.skipif(shutil.which("less") is None, reason="without less")
def test_less_ends_at_once_if_all_fits(tmp_path: Path) -> None:
    code, shown = on_terminal(tmp_path, "decode", "--frame", "2", EXPEDITED, PAGER="less")
    assert code == 0 and b"2000h:00" in shown


def test_interrupt_while_the_pager_is_read(tmp_path: Path) -> None:
    code, shown = on_terminal(
        tmp_path, "decode", "notes.log", CANALYZE_PAGER="sh -c 'cat; kill -INT $PPID; sleep 0.3; echo end'"
    )
    assert code == 0 and shown.endswith(b"end\r\n") and b"Traceback" not in shown


def test_interrupt_while_the_capture_is_read(tmp_path: Path) -> None:
    (tmp_path / "long.log").write_text("".join(f"({at}.5) can0 705#05\n" for at in range(400_000)))
    code, shown = on_terminal(
        tmp_path, "decode", "long.log", CANALYZE_PAGER="sh -c 'kill -INT $PPID; cat > /dev/null; echo end'"
    )
    assert code == 130 and b"end\r\n" in shown and b"Traceback" not in shown
