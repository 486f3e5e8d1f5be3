"""Listings on a terminal: one clock, numbers of frames, lines as wide as the terminal. Elsewhere they are as ever."""

import re
from pathlib import Path

import pytest
from captures import SAMPLES
from conftest import Runner
from test_cli_terminal import on_terminal

from canalyze.commands.examples import FOLDER
from canalyze.output.layout import hanging, width

LOST = "node-lost.log"
COLOUR = re.compile("\x1b\\[[0-9;]*m")


@pytest.fixture(autouse=True)
def lost(tmp_path: Path) -> None:
    (tmp_path / LOST).write_bytes((FOLDER / LOST).read_bytes())


def listed(tmp_path: Path, *args: str, columns: int = 300) -> list[str]:
    """Return the lines of a command on a terminal, in English."""
    _, shown = on_terminal(tmp_path, *args, "--lang", "en", COLUMNS=str(columns), NO_COLOR="1")
    return shown.decode().splitlines()


def test_decode_has_numbers_and_the_time_since_the_start(tmp_path: Path, canalyze: Runner) -> None:
    lines = listed(tmp_path, "decode", LOST)
    assert lines[0].startswith("     1:  (000.000000)  can0  703 ")
    assert lines == canalyze("decode", "--lang", "en", "-n", "-t", "z", LOST).lines
    assert listed(tmp_path, "decode", LOST, "-t", "a", "--no-number") == canalyze("decode", "--lang", "en", LOST).lines
    assert (
        listed(tmp_path, "decode", "--format", "jsonl", LOST)
        == canalyze("decode", "--lang=en", "--format=jsonl", LOST).lines
    )
    assert listed(tmp_path, "decode", LOST, "--frame", "7", "--no-number")[0].startswith("(000.121100)")


def test_other_outputs_have_neither(tmp_path: Path, canalyze: Runner) -> None:
    plain = canalyze("decode", "--lang", "en", LOST)
    assert plain.lines[0].startswith("(1700000000.000000)")
    assert listed(tmp_path, "decode", LOST, "-o", "out.txt") == []
    assert (tmp_path / "out.txt").read_text() == plain.out
    assert canalyze("decode", "--lang", "en", "--no-number", "--frame", "7", LOST).out.startswith("(1700000000.121100)")
    assert listed(tmp_path, "check", LOST, "--junit", "with.xml")
    assert canalyze("check", "--lang", "en", LOST, "--junit", "without.xml").code == 1
    times = re.compile(r'time="[^"]*"')  # how long the check took
    with_terminal, without = (times.sub("", (tmp_path / name).read_text()) for name in ("with.xml", "without.xml"))
    assert with_terminal == without and "(1700000005.461000)" in without


def test_one_clock(tmp_path: Path, canalyze: Runner) -> None:
    assert "(005.461000)" in "\n".join(listed(tmp_path, "decode", LOST))
    assert "(005.461000)" in "\n".join(listed(tmp_path, "check", LOST))
    assert "5.461 s" in "\n".join(listed(tmp_path, "diagnose", LOST))
    for columns in (300, 92):
        heading, first, *_ = listed(tmp_path, "sdo", LOST, columns=columns)
        assert "time" in heading.split() and first.split()[1] == "0.100000"
    assert "1700000005.461000" in "\n".join(listed(tmp_path, "check", "-t", "a", LOST))
    assert "1700000000.100000" in "\n".join(listed(tmp_path, "sdo", "-t", "a", LOST))
    assert "1700000000.100000" in canalyze("sdo", LOST).out and "1700000005.461000" in canalyze("check", LOST).out


@pytest.mark.parametrize("columns", [60, 80, 100, 140])
@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize(
    "args", [["decode"], ["decode", "--explain", "--problems"], ["check"], ["diagnose", "-n", "1"]], ids=" ".join
)
def test_no_line_is_wider_than_the_terminal(
    tmp_path: Path, canalyze: Runner, args: list[str], lang: str, columns: int
) -> None:
    code, shown = on_terminal(tmp_path, *args, LOST, "--lang", lang, COLUMNS=str(columns))
    lines = COLOUR.sub("", shown.decode()).splitlines()
    assert max(map(width, lines)) <= columns
    options = ["-n", "-t", "z"] if args[0] == "decode" else ["-t", "z"] if args[0] == "check" else []
    whole = canalyze(*args, *options, LOST, "--lang", lang)
    assert code == whole.code and len(lines) > len(whole.lines)
    marks = re.compile(r"[\s#]+")
    assert marks.sub("", "".join(lines)) == marks.sub("", whole.out)


def test_an_annotation_hangs_below_its_first_word() -> None:
    line = b"(000.1)  can0  084   [8]  30 81  # EMCY of node 4: heartbeat error\n"
    assert hanging(line, 66) == line
    assert hanging(line, 65).decode().splitlines() == [
        "(000.1)  can0  084   [8]  30 81  # EMCY of node 4: heartbeat",
        "                                   error",
    ]
    assert hanging(line, 40).decode().splitlines() == [
        "(000.1)  can0  084   [8]  30 81  #",
        "    EMCY of node 4: heartbeat error",
    ]


def test_a_comment_stays_one() -> None:
    assert hanging(b"#   HBT002 error: node 4 is silent\n", 30) == b"#   HBT002 error: node 4\n#     is silent\n"


def test_chinese_is_measured_and_kept_from_its_punctuation() -> None:
    line = "#   节点4: 没有心跳，已经很久了。\n"
    shown = hanging(line.encode(), 24).decode().splitlines()
    assert max(map(width, shown)) <= 24 and not any(one[6:].startswith(("，", "。")) for one in shown[1:])
    assert "".join(one.removeprefix("#     ") for one in shown).replace(" ", "") == line.strip().replace(" ", "")


def test_each_line_has_its_colour() -> None:
    line = "can0  \x1b[31m084\x1b[0m  # \x1b[32mone two three four five six\x1b[0m\n"
    assert hanging(line.encode(), 42) == line.encode()
    assert hanging(b"\x1b[1;31m#   one two three four five six seven\x1b[0m\n", 30).decode().splitlines() == [
        "\x1b[1;31m#   one two three four\x1b[0m",
        "#     \x1b[1;31mfive six seven\x1b[0m",
    ]


def test_a_terminal_that_is_too_narrow_breaks_lines_itself() -> None:
    assert hanging(b"#   one two three four five six seven\n", 20) == b"#   one two three four five six seven\n"


def test_only_line_ends_end_lines() -> None:
    line = "#   one\u2028two\x85three\x0bfour\n".encode()
    assert hanging(line, 80) == line


def test_damaged_names_are_kept(tmp_path: Path) -> None:
    assert hanging(b"\xff" + b" a" * 40 + b"\n", 30).startswith(b"\\xff a")
    assert listed(tmp_path, "decode", str(SAMPLES / "string-100-bytes.log"), columns=70)
