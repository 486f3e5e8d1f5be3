"""Files joined by time: split recordings give what the whole one gives, in memory that does not grow with them."""

from __future__ import annotations

import gzip
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from captures import SAMPLES
from conftest import Runner, environment

NETWORK = sorted((SAMPLES / "network").glob("*.log"))
WHOLE = SAMPLES / "network" / "sync-and-pdos.log"
COMMANDS = ["decode", "sdo", "signals", "summary"]


def by_turns(lines: list[str]) -> list[list[str]]:
    return [lines[number::3] for number in range(3)]


def by_time(lines: list[str]) -> list[list[str]]:
    third = len(lines) // 3
    return [lines[2 * third :], lines[:third], lines[third : 2 * third]]


def in_runs(lines: list[str]) -> list[list[str]]:
    """Overlapping files of very different size."""
    parts: list[list[str]] = [[], []]
    for number, line in enumerate(lines):
        parts[number % 41 == 0].append(line)
    return parts


def stamped(lines: list[str]) -> list[str]:
    """Give every line a stamp of its own, in its order: which of equal ones came first, files cannot tell."""
    return [re.sub(r"^\(\d+\.\d+\)", f"(1700000000.{number:06d})", line) for number, line in enumerate(lines)]


def without_lines(out: str) -> str:
    """Leave out the numbers of lines, which are those of the parts."""
    return re.sub(r'_line":\d+', '_line":0', out)


def written(folder: Path, parts: list[list[str]]) -> list[str]:
    names = []
    for number, part in enumerate(parts):
        names.append(f"part{number}.log")
        (folder / names[-1]).write_text("".join(part))
    return names


@pytest.mark.parametrize("capture", NETWORK, ids=lambda path: path.stem)
@pytest.mark.parametrize("split", [by_turns, by_time, in_runs])
def test_a_split_log_is_the_whole_one(
    canalyze: Runner, tmp_path: Path, capture: Path, split: Callable[[list[str]], list[list[str]]]
) -> None:
    lines = stamped(capture.read_text().splitlines(keepends=True))
    (whole,) = written(tmp_path, [lines])
    expected = canalyze("decode", "--explain", whole)
    names = written(tmp_path, split(lines))
    assert canalyze("decode", "--merge", "--explain", *names) == expected


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_joins(canalyze: Runner, tmp_path: Path, command: str) -> None:
    lines = stamped(WHOLE.read_text().splitlines(keepends=True))
    (tmp_path / "whole.log").write_text("".join(lines))
    expected = canalyze("--lang", "en", command, "whole.log")
    names = written(tmp_path, by_turns(lines))
    joined = canalyze("--lang", "en", command, *names, "--merge")
    assert (joined.code, joined.err) == (expected.code, expected.err)
    assert joined.out.replace("(3 files)", "(1 file)") == expected.out


def test_split_by_bus(canalyze: Runner, tmp_path: Path) -> None:
    lines = [
        line.replace("vcan0", f"can{number % 7 % 3}")
        for number, line in enumerate(stamped(WHOLE.read_text().splitlines(keepends=True)))
    ]
    (tmp_path / "whole.log").write_text("".join(lines))
    # Named against the order in which the buses appear, which is that of the whole one all the same.
    parts = [[line for line in lines if f" can{number} " in line] for number in (2, 1, 0)]
    names = written(tmp_path, parts)
    for args in (["decode"], ["summary", "--format", "jsonl", "--bitrate", "500k"]):
        expected, joined = canalyze(*args, "whole.log"), canalyze(*args, "--merge", *names)
        assert without_lines(joined.out.replace('"files":3', '"files":1')) == without_lines(expected.out)


def test_compressed_and_piped_parts(canalyze: Runner, tmp_path: Path) -> None:
    lines = stamped(WHOLE.read_text().splitlines(keepends=True))
    one, two, three = ("".join(part) for part in by_turns(lines))
    (tmp_path / "whole.log").write_text("".join(lines))
    (tmp_path / "one.log.gz").write_bytes(gzip.compress(one.encode()))
    (tmp_path / "two.txt").write_text(two, encoding="utf-16")
    joined = canalyze("decode", "--merge", "one.log.gz", "two.txt", "-", stdin=three.encode())
    assert joined == canalyze("decode", "whole.log")


def test_equal_stamps_keep_the_order_of_the_command_line(canalyze: Runner, tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / name).write_text("".join(f"(1.000000) {name} 70{n}#05\n" for n in range(1, 4)))
    for names in ("ab", "ba"):
        lines = canalyze("decode", "--merge", *names).lines
        assert [line.split()[1] for line in lines] == [names[0]] * 3 + [names[1]] * 3


def test_rows_name_their_file_and_line(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a").write_text("(1.000000) can0 701#05\nnonsense here\n(3.000000) can0 701#05\n")
    (tmp_path / "b").write_text("# b\n(2.000000) can0 702#05\n(4.000000) can0 702#0\n(5.000000) can0 702#05\n")
    done = canalyze("--lang", "en", "decode", "--merge", "--format", "jsonl", "a", "b")
    rows = [json.loads(line) for line in done.lines]
    frames = [(row["frame"], row["file"], row["line"], row["t"]) for row in rows if row["kind"] == "frame"]
    assert frames == [
        (1, "a", 1, "1.000000"),
        (2, "b", 2, "2.000000"),
        (3, "a", 3, "3.000000"),
        (4, "b", 4, "5.000000"),
    ]
    unreadable = [(row["file"], row["line"]) for row in rows if row["kind"] == "finding" and row["code"] == "CAP001"]
    assert sorted(unreadable) == [("a", 2), ("b", 3)]
    assert sorted(line.partition(": ")[0] for line in done.complaints) == ["a:2", "b:3"]


def test_damage_belongs_to_its_file(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a").write_text("".join(f"({n}.000000) can0 701#05\n" for n in range(1, 50)))
    packed = gzip.compress("".join(f"({n}.500000) can0 702#05\n" for n in range(1, 50)).encode())
    (tmp_path / "b.gz").write_bytes(packed[:-20])
    done = canalyze("--lang", "en", "decode", "--merge", "--format", "jsonl", "a", "b.gz")
    rows = [json.loads(line) for line in done.lines]
    assert [(row["file"], row["code"]) for row in rows if row["kind"] == "finding" and row["code"] == "CAP005"] == [
        ("b.gz", "CAP005")
    ]
    assert [row["t"] for row in rows if row["kind"] == "frame"] == sorted(
        (row["t"] for row in rows if row["kind"] == "frame"), key=float
    )
    assert done.code == 0


def test_files_that_cannot_be_read_do_not_stop_the_others(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a").write_text("(1.000000) can0 701#05\n(3.000000) can0 701#05\n")
    (tmp_path / "b").write_text("(2.000000) can0 702#05\n")
    (tmp_path / "empty").write_text("")
    (tmp_path / "prose").write_text("nothing of it\n")
    done = canalyze("--lang", "en", "decode", "--merge", "a", "missing", "empty", "b", "prose")
    assert done.code == 2
    assert [line.split()[2] for line in done.lines] == ["701", "702", "701"]
    for name in ("missing", "empty", "prose"):
        assert [line for line in done.complaints if line.startswith(f"canalyze: {name}: ")]
    assert canalyze("decode", "--merge", "a").code == 0


@pytest.mark.parametrize("command", COMMANDS)
def test_files_without_a_common_clock_are_refused(canalyze: Runner, tmp_path: Path, command: str) -> None:
    (tmp_path / "absolute").write_text("(1700000000.000000) can0 701#05\n")
    (tmp_path / "zero").write_text("(1.000000) can0 701#05\n")
    (tmp_path / "bare").write_text("can0  701   [1]  05\n")
    for names, said in (
        (("zero", "absolute"), "absolute has absolute timestamps, those of zero"),
        (("zero", "bare"), "bare: no timestamps"),
    ):
        done = canalyze("--lang", "en", command, "--merge", *names)
        assert (done.code, done.out.strip(), len(done.complaints)) == (2, done.out.strip(), 1)
        assert said in done.err
        assert "701" not in done.out


def test_files_named_out_of_order_are_worth_a_word(canalyze: Runner, tmp_path: Path) -> None:
    for number in range(4):
        stamps = range(1700000000 + 10 * number, 1700000010 + 10 * number)
        (tmp_path / f"{number}").write_text("".join(f"({t}.000000) can0 701#05\n" for t in stamps))
    done = canalyze("--lang", "en", "decode", "0", "1", "3", "2")
    assert (done.code, len(done.complaints)) == (0, 1)
    assert done.err.startswith("2: first timestamp is 19.000 s before the last one of 3;") and "--merge" in done.err
    assert canalyze("decode", "--merge", "3", "2", "1", "0") == canalyze("decode", "0", "1", "2", "3")


HOUR = 3600


def _beats(begin: int) -> str:
    """Ten seconds of a node that is Operational, and of one that is watched with it."""
    return "".join(
        f"({begin + t}.{part}00000) can0 {node}#05\n" for t in range(10) for part, node in ((0, 701), (5, 702))
    )


@pytest.mark.parametrize(
    ("later", "said"),
    [
        (50 * HOUR, "b.log: begins 2 days after the last frame of a.log; all files are read as one capture"),
        (-5 * HOUR, "b.log: begins 5 h before the last frame of a.log; all files are read as one capture"),
    ],
)
def test_files_that_are_far_apart_may_be_no_one_capture(
    canalyze: Runner, tmp_path: Path, later: int, said: str
) -> None:
    (tmp_path / "a.log").write_text(_beats(1_700_000_000))
    for name in ("b.log", "c.log"):
        (tmp_path / name).write_text(_beats(1_700_000_000 + later * (1 if name == "b.log" else 2)))
    done = canalyze("--lang", "en", "diagnose", "--join", "a.log", "b.log", "c.log")
    assert done.code == 0 and len(done.complaints) == 1, "once, however many files there are"
    assert done.err.startswith(said) and "canalyze check" in done.err
    assert ("--merge" in done.err) == (later < 0), "what is in order needs none"
    assert "no problems found" in done.out and "silent" not in done.out, "nothing is judged across that time"
    apart = canalyze("--lang", "zh", "diagnose", "--join", "a.log", "b.log")
    assert "canalyze check" in apart.err and ("天" in apart.err) == (later > 0)


def test_parts_of_a_recording_say_nothing_and_go_on(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(_beats(1_700_000_000))
    (tmp_path / "b.log").write_text(_beats(1_700_000_010).replace("702#05", "703#05"))
    done = canalyze("--lang", "en", "diagnose", "a.log", "b.log")
    assert (done.code, done.err) == (0, "") and "node 2: silent since" in done.out, (
        "a node that is lost between two parts"
    )


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak of memory stands in /proc")
def test_memory_is_flat(tmp_path: Path) -> None:
    peaks = []
    for size in (40_000, 400_000):
        lines = [f"(1700000000.{n:09d}) can0 1FF#{n:016X}\n" for n in range(size)]
        written(tmp_path, by_turns(lines))
        script = (
            "from canalyze.cli import main\n"
            "main(['decode', '--merge', 'part0.log', 'part1.log', 'part2.log', '-o', 'out', '--force'])\n"
            "print(next(line for line in open('/proc/self/status') if line.startswith('VmHWM')))\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, check=True, text=True, env=environment()
        )
        peaks.append(int(done.stdout.split()[1]))
        assert (tmp_path / "out").read_text().count("1FF ") == size
    assert peaks[1] < peaks[0] * 1.5
