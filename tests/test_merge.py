"""Files joined by time: split recordings give what the whole one gives, in memory that does not grow with them."""

from __future__ import annotations

import gzip
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from captures import SAMPLES
from conftest import Runner
from processes import peak_kib

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


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak of memory stands in /proc")
def test_memory_is_flat(tmp_path: Path) -> None:
    peaks = []
    for size in (40_000, 400_000):
        lines = [f"(1700000000.{n:09d}) can0 1FF#{n:016X}\n" for n in range(size)]
        written(tmp_path, by_turns(lines))
        parts = ("part0.log", "part1.log", "part2.log")
        peaks.append(peak_kib(tmp_path, "decode", "--merge", *parts, "-o", "out", "--force"))
        assert (tmp_path / "out").read_text().count("1FF ") == size
    assert peaks[1] < peaks[0] * 1.5
