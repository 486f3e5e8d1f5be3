"""Files joined by time: split recordings give what the whole one gives, in memory that does not grow with them.

Files that are one capture, with nothing recorded between them for any time: no node is blamed for that time, and what
is wrong within a file is found. Must not: test damaged files.
"""

from __future__ import annotations

import gzip
import json
import re
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from captures import SAMPLES, CanFrame, Row, log_text
from clean_sessions import beside, sessions
from conftest import Runner
from distortions import shown
from faulty_captures import Capture
from plants import IO, built
from processes import peak_kib
from test_distortions import happened, key

from canalyze import _core
from canalyze.running.reading import SessionOptions

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


APART_US = (
    *(1_000_000, 10_000_000, 60_000_000, 3_540_000_000, 3_660_000_000, 86_400_000_000),
    *(-1_000_000, -60_000_000, -3_540_000_000, -3_660_000_000, -86_400_000_000),
)
"""Below and above an hour, and the later file named first.

Physical limit: a silence that is no longer than those before it may as well be a node's that is late.
"""


def judged(files: list[list[CanFrame]], network: _core.Network | None = None) -> list[Row]:
    """The findings above info that are no consequence of another, but for findings about the capture."""
    session = _core.Session(SessionOptions(lang="en", format="check", depth="default", network=network))
    output = b""
    for number, frames in enumerate(files):
        session.begin(f"part{number}.log", True, "candump")
        output += session.feed(log_text(frames)) + session.end()
    rows: list[Row] = [json.loads(line) for line in (output + session.finish()).decode().splitlines()]
    above = [row for row in rows if row["severity"] != "info" and row.get("because_of") is None]
    return [row for row in above if not row["code"].startswith("CAP")]


def apart(frames: list[CanFrame], at: int, by_us: int) -> list[list[CanFrame]]:
    """Two files, the second one so much later."""
    return [frames[:at], [replace(frame, t_us=frame.t_us + by_us) for frame in frames[at:]]]


@pytest.mark.parametrize("by_us", APART_US, ids=shown)
def test_nobody_is_blamed_for_what_is_not_recorded(by_us: int) -> None:
    wrong = []
    for name, session in sessions().items():
        frames = list(session.frames)
        raised = {frame.can_id - 0x80 for frame in frames if 0x81 <= frame.can_id <= 0xFF}
        for network in beside(name):
            own = Counter(key(row) for row in judged([frames], network))
            for part in (0.2, 0.5, 0.8):
                at = min(max(round(len(frames) * part), 1), len(frames) - 1)
                found = judged(apart(frames, at, by_us), network)
                found = [row for row in found if not (happened(row) and row["node"] in raised)]
                more = Counter(map(key, found)) - own
                wrong += [(name, part, row["code"], row["message"]) for row in found if key(row) in more]
    assert not wrong


@pytest.mark.parametrize("by_us", [0, *APART_US], ids=shown)
def test_a_fault_within_a_file_is_found(by_us: int) -> None:
    """A node is silent for a second, in the second file as in the first one."""
    for since in (1.2, 4.3):
        capture = Capture(built("plant", "written"))
        capture.drop(since, since + 1.0, 0x700 + IO, 0x186, 0x286, 0x586, 0x606)
        at = next(n for n, frame in enumerate(capture.frames) if frame.t_us > capture.frames[0].t_us + 3_200_000)
        found = [row["code"] for row in judged(apart(capture.frames, at, by_us))]
        assert "HBT002" in found, (since, found)


@pytest.mark.parametrize("by_us", [0, 2000], ids=shown)
def test_a_fault_across_files_that_follow_each_other_is_found(by_us: int) -> None:
    """A recording is cut into files anywhere: the node is silent from before the cut on."""
    capture = Capture(built("plant", "written"))
    capture.drop(3.0, 4.5, 0x700 + IO, 0x186, 0x286, 0x586, 0x606)
    for cut_us in (3_050_000, 3_200_000, 4_000_000):
        at = next(n for n, frame in enumerate(capture.frames) if frame.t_us > capture.frames[0].t_us + cut_us)
        found = [row["code"] for row in judged(apart(capture.frames, at, by_us))]
        assert "HBT002" in found, (cut_us, found)
