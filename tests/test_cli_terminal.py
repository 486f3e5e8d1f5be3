"""What a terminal gets: its encoding, its language, tables, colour, progress."""

import itertools
import os
import pty
import re
import select
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import NOTES, environment, ran, started

from canalyze import output
from canalyze.output import Output
from canalyze.output.layout import width
from canalyze.reports.sdo import COLUMNS
from canalyze.reports.sdo import columns as sdo_columns
from canalyze.reports.table import Row, Table
from canalyze.words import Words


def on_terminal(directory: Path, *args: str, only_err: bool = False, **env: str) -> tuple[int, bytes]:
    """Run on a terminal of its own; give the exit code and what the terminal showed."""
    ours, theirs = pty.openpty()
    process = started(
        directory,
        *args,
        stdin=theirs,
        stdout=subprocess.DEVNULL if only_err else theirs,
        stderr=theirs,
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


HINT = "English: canalyze --lang en, or CANALYZE_LANG=en"


@pytest.mark.parametrize("locale", ["en_US.UTF-8", "C.UTF-8", "de_DE.UTF-8", ""])
@pytest.mark.parametrize(
    "args",
    [
        ["--help"],
        ["convert", "--help"],
        ["decode", "notes.log"],
        ["notes.log"],
        ["deocde"],
        ["notes.log", "--", "--format=x"],
    ],
)
def test_who_may_not_read_chinese_is_told_of_english_once(tmp_path: Path, args: list[str], locale: str) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    _, shown = on_terminal(tmp_path, *args, LC_MESSAGES=locale)
    first, *others = shown.decode().splitlines()
    assert first == HINT
    assert HINT not in others and re.search("[\u4e00-\u9fff]", "".join(others))


@pytest.mark.parametrize(
    ("args", "env"),
    [
        ([], {"LC_MESSAGES": "zh_TW.UTF-8"}),
        ([], {"LC_MESSAGES": "", "LANG": "zh_CN.UTF-8", "PYTHONIOENCODING": "utf-8"}),
        ([], {"LC_MESSAGES": "en_US.UTF-8", "CANALYZE_LANG": "zh"}),
        ([], {"LC_MESSAGES": "en_US.UTF-8", "PYTHONIOENCODING": "latin-1"}),
        (["--lang", "zh"], {"LC_MESSAGES": "en_US.UTF-8"}),
        (["--lang", "en"], {"LC_MESSAGES": "en_US.UTF-8"}),
        (["--format", "jsonl"], {"LC_MESSAGES": "en_US.UTF-8"}),
        (["--format=jsonl"], {"LC_MESSAGES": "en_US.UTF-8"}),
    ],
)
def test_who_has_chosen_is_told_nothing_of_english(tmp_path: Path, args: list[str], env: dict[str, str]) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    code, shown = on_terminal(tmp_path, "decode", "notes.log", *args, only_err=False, **env)
    assert code == 0 and shown
    assert HINT not in shown.decode("utf-8", "replace")


def test_configured_language_is_a_choice(tmp_path: Path) -> None:
    (tmp_path / "canalyze.toml").write_text('lang = "zh"\n')
    _, shown = on_terminal(tmp_path, "rules", LC_MESSAGES="en_US.UTF-8")
    assert HINT not in shown.decode()


def test_version_and_pipes_have_no_hint(tmp_path: Path) -> None:
    _, shown = on_terminal(tmp_path, "--version", LC_MESSAGES="en_US.UTF-8")
    assert HINT.encode() not in shown
    _, shown = on_terminal(tmp_path, "deocde", only_err=True, LC_MESSAGES="en_US.UTF-8")
    assert shown and HINT.encode() not in shown
    done = ran(tmp_path, "rules", check=True, env=environment(LC_MESSAGES="en_US.UTF-8"))
    assert done.stdout and not done.stderr


def test_chosen_language_stands(tmp_path: Path) -> None:
    _, shown = on_terminal(tmp_path, "--help", PYTHONIOENCODING="latin-1", CANALYZE_LANG="zh")
    assert b"Usage" not in shown and b"--lang" in shown


def test_pipe_is_utf8_whatever_the_locale(tmp_path: Path) -> None:
    done = ran(tmp_path, "--help", env=environment(LC_ALL="C", PYTHONIOENCODING="latin-1"), check=True)
    assert done.stdout.decode("utf-8").startswith("用法：")
    done = ran(tmp_path, "deocde", env=environment(LC_ALL="C", PYTHONIOENCODING="latin-1"))
    assert "没有命令" in done.stderr.decode("utf-8")


def test_table_on_a_terminal(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    code, shown = on_terminal(tmp_path, "sdo", "notes.log", COLUMNS="80")
    assert code == 0
    assert "1008h:00" in shown.decode()
    _, plain = on_terminal(tmp_path, "rules", NO_COLOR="1")
    for colour in range(30, 38):
        assert f"\x1b[{colour}m".encode() not in plain


@pytest.mark.parametrize("columns", [80, 100, 120, 160, 300])
@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize(
    "name", ["sdo-abort.log", "sdo-block.log", "string-100-bytes.log", "two-nodes-interleaved.log"]
)
def test_table_is_as_wide_as_the_terminal(tmp_path: Path, name: str, lang: str, columns: int) -> None:
    capture = Path(__file__).parent.parent / "samples" / name
    code, shown = on_terminal(tmp_path, "sdo", str(capture), "--lang", lang, COLUMNS=str(columns), NO_COLOR="1")
    assert code == 0
    heading, *lines = shown.decode().splitlines()
    assert max(map(width, [heading, *lines])) <= columns
    assert "…" not in shown.decode()
    starts = [place for place, line in enumerate(lines) if re.search("[0-9A-F]{4}h:[0-9A-F]{2} ", line)]
    heights = [after - before for before, after in itertools.pairwise([*starts, len(lines)])]
    if name != "string-100-bytes.log":
        assert max(heights) <= 3
    for word in ("object", "value", "outcome") if lang == "en" else ("对象", "值", "结果"):
        assert word in heading


@pytest.mark.parametrize("form", ["a", "z", "A"])
@pytest.mark.parametrize("columns", [80])
def test_times_that_are_asked_for_stay(tmp_path: Path, form: str, columns: int) -> None:
    capture = str(Path(__file__).parent.parent / "samples/sdo-abort.log")
    _, whole = on_terminal(tmp_path, "sdo", capture, "--lang", "en", "-t", form, COLUMNS="300", NO_COLOR="1")
    code, shown = on_terminal(tmp_path, "sdo", capture, "--lang", "en", "-t", form, COLUMNS=str(columns), NO_COLOR="1")
    heading, *lines = shown.decode().splitlines()
    assert code == 0 and "time" in heading.split() and max(map(width, [heading, *lines])) <= columns
    place = whole.decode().splitlines()[0].index("time") + 4
    moments = [line[:place].split()[-1] for line in whole.decode().splitlines()[1:]]
    assert len(set(moments)) > 1 and all(moment in shown.decode() for moment in moments)
    _, unasked = on_terminal(tmp_path, "sdo", capture, "--lang", "en", COLUMNS="60", NO_COLOR="1")
    assert "time" not in unasked.decode().splitlines()[0].split()


def table(columns: int, monkeypatch: pytest.MonkeyPatch, rows: list[Row], *, live: bool = False) -> list[str]:
    """Lay out a table of the columns of `sdo` on a terminal so wide."""
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("NO_COLOR", "1")
    written: list[str] = []
    out = Output()
    out.is_terminal = True
    monkeypatch.setattr(out, "text", written.append)
    grid = Table(sdo_columns(Words("en")), out, live=live)
    for row in rows:
        grid.add([row])
    grid.close()
    return "".join(written).splitlines()


def cells(number: int, bus: str = "can0", value: str = "5") -> Row:
    """Give a row of `sdo`."""
    first = [str(number), f"1700000000.{number:06}", bus, "10", "upload", "2000h:00", "-", value]
    return Row([*first, "4", "expedited", "0.400 ms", "ok", "-", "1-2"], number)


def test_columns_leave_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [cells(number) for number in (2, 1)]
    heading, first, second = table(200, monkeypatch, rows)
    assert heading.split() == ["#", *COLUMNS[1:]]
    assert (first.split()[0], second.split()[0]) == ("1", "2")
    left = ["bus", "frames", "size", "time"]  # name and findings are empty: they go first
    for columns in range(110, 70, -1):
        heading = table(columns, monkeypatch, rows)[0]
        gone = [name for name in left if name not in heading.split()]
        assert gone == left[: len(gone)]
    assert gone == left and "relative" in heading


def test_bus_stays_where_there_are_two(monkeypatch: pytest.MonkeyPatch) -> None:
    assert " bus " in table(80, monkeypatch, [cells(1), cells(2, bus="can1")])[0]


def test_long_value_without_blanks_is_folded(monkeypatch: pytest.MonkeyPatch) -> None:
    value = "值" * 150
    lines = table(80, monkeypatch, [cells(1, value=value)])
    assert max(map(width, lines)) <= 80
    assert "".join(lines).count("值") == 150


def test_many_rows_keep_the_layout(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = table(80, monkeypatch, [cells(number) for number in range(1, 2500)])
    assert len(lines) == 2500
    assert max(map(width, lines)) <= 80


def test_live_rows_fit_too(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = table(100, monkeypatch, [cells(1), cells(2, value="00 11 22 33 " * 9)], live=True)
    assert max(map(width, lines)) <= 100
    assert "".join(lines).count("11") >= 9


def test_what_was_written_is_said_on_a_terminal(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    args = ("expect", "notes.log", "-o", "a b.toml", "--lang", "en")
    code, shown = on_terminal(tmp_path, *args, only_err=True)
    assert code == 0 and b"canalyze: 'a b.toml' written; check other captures with: canalyze check" in shown
    code, shown = on_terminal(tmp_path, "view", "notes.log", "--save", "a.rrd", "--lang", "en", only_err=True)
    assert code == 0 and b"a.rrd written; open it with: canalyze view a.rrd" in shown


def test_no_input_on_a_terminal_is_wrong_usage(tmp_path: Path) -> None:
    for name in ("decode", "sdo", "eds", "explain"):
        code, shown = on_terminal(tmp_path, name)
        assert code == 2
        assert len(shown.splitlines()) == 1


def test_short_work_shows_no_progress(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    assert on_terminal(tmp_path, "decode", "notes.log", only_err=True) == (0, b"")


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_progress_keeps_to_a_narrow_terminal(monkeypatch: pytest.MonkeyPatch, lang: str) -> None:
    shown: list[str] = []
    monkeypatch.setattr(output, "_put", shown.append)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(output.Progress, "_columns", staticmethod(lambda: 20))
    quiet = output.Output()
    quiet.is_quiet = True
    progress = output.Progress(Words(lang), quiet, 43_000_000)
    progress._next = 0.0
    progress.step(7_300_000, 170_767)
    (line,) = shown
    line = line.removeprefix("\r").removesuffix("\x1b[K")
    assert "7.3/43.0 MB" in line and width(line) < 20
