"""`canalyze od diff` over captures of made networks and real stacks, with one value changed where it is wanted.

Must not: take a difference from the program that is not put in here.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from captures import SHARED, CanFrame, eds_options, log_text, read_log
from conftest import Runner
from test_od_files import EVERY, SESSIONS, written

from canalyze.dictionary import Dictionary, load
from canalyze.dictionary.difference import compare, standard_nature

Rows = list[dict[str, Any]]


def told(canalyze: Runner, *args: str | Path) -> tuple[int, Rows, dict[str, Any]]:
    """Exit code, the rows that count, and the summary, whose counts are those of the rows."""
    done = canalyze("--lang", "zh", "od", "--format", "jsonl", *map(str, args))
    assert all("canalyze eds" in line for line in done.complaints), done.err  # what is odd about a description
    *rows, last = map(json.loads, done.lines)
    counting = [row for row in rows if row.get("reason") is None]
    assert (last["kind"], last["differences"], last["same"]) == ("od_diff", len(counting), not counting)
    assert sum(last["ignored"].values()) == len(rows) - len(counting)
    return done.code, counting, last


def places(rows: Rows) -> list[str]:
    return [f"{row['node']} {row['index']}:{row['sub']:02X}" for row in rows]


def changed(frames: list[CanFrame], place: int) -> list[CanFrame]:
    """The same capture with another value in one expedited download."""
    frame = frames[place]
    return [
        *frames[:place],
        replace(frame, data=frame.data[:4] + bytes([frame.data[4] ^ 1]) + frame.data[5:]),
        *frames[place + 1 :],
    ]


def downloads(frames: list[CanFrame]) -> Iterator[int]:
    """Places of expedited downloads that are accepted and configure something, each the last one of its object."""
    last: dict[tuple[int, bytes], int] = {}
    for place, frame in enumerate(frames):
        answer = next((one for one in frames[place + 1 :] if one.can_id == frame.can_id - 0x80), None)
        if 0x601 <= frame.can_id <= 0x67F and frame.data[0] & 0xE3 == 0x23 and answer and answer.data[0] == 0x60:
            last[frame.can_id, frame.data[1:4]] = place
    for (_, address), place in last.items():
        index = int.from_bytes(address[:2], "little")
        if standard_nature((index, address[2]), 402) is None and not 0x1400 <= index < 0x1C00:
            yield place


@pytest.mark.parametrize("log", [*SESSIONS, *sorted((SHARED / "stacks").glob("*.log"))], ids=lambda path: path.stem)
def test_a_capture_and_itself_are_the_same(canalyze: Runner, log: Path) -> None:
    code, rows, last = told(canalyze, log, "--diff", log)
    if not last["compared"]:
        pytest.skip("nothing but heartbeats")
    assert (code, rows, last["ignored"]) == (0, [], {})


@pytest.mark.parametrize(
    "log", [path for path in SESSIONS if written(path, described=True)], ids=lambda path: path.stem
)
def test_one_value_is_found_and_nothing_else(canalyze: Runner, log: Path, tmp_path: Path) -> None:
    frames = read_log(log.read_bytes())
    seeded = list(downloads(frames))[:4]
    for place in seeded:
        (tmp_path / "other.log").write_bytes(log_text(changed(frames, place)))
        frame = frames[place]
        index, sub = int.from_bytes(frame.data[1:3], "little"), frame.data[3]
        code, rows, _ = told(canalyze, log, "--diff", "other.log")
        assert code == 1
        # Reads of what was written there show the old value, which is then the last one of neither.
        assert places(rows) == [f"{frame.can_id - 0x600} {index:04X}:{sub:02X}"]
        (row,) = rows
        a, b = (bytes.fromhex(row[side]["data"]) for side in "ab")
        assert a[0] ^ b[0] == 1 and a[1:] == b[1:] and row["a"]["configured"]


def test_enough_is_seeded() -> None:
    assert sum(len(list(downloads(read_log(log.read_bytes())))[:4]) for log in SESSIONS) > 12


@pytest.mark.parametrize("log", SESSIONS, ids=lambda path: path.stem)
def test_a_device_is_as_the_files_that_were_made_of_it(canalyze: Runner, log: Path) -> None:
    """Over its EDS and without one, in both directions; and the files are the same among themselves."""
    options = eds_options(log)
    known = {int(option[6:].split("=")[0]) for option in options}
    for node in written(log, described=False):
        given = options if node in known else []
        wanted = ("--node", str(node))
        made = ("--dcf", f"{node}.dcf", "--concise-dcf", f"{node}.cdcf", "--skeleton", f"{node}.eds")
        if canalyze("od", str(log), *wanted, *made, *given).code:
            continue  # what is written there, RPDOs write too
        pairs: list[tuple[str | Path, ...]] = [
            (log, f"{node}.dcf", *given),
            (f"{node}.dcf", log, *given),
            (log, f"{node}.cdcf", *given),
            (f"{node}.dcf", f"{node}.cdcf"),
            (log, f"{node}.eds", *given),
        ]
        for pair in pairs:
            code, rows, last = told(canalyze, pair[0], "--diff", *pair[1:], *wanted)
            assert (code, rows) == (0, []), (pair, rows)
            assert last["compared"] > 0 or str(pair[1]).endswith("eds"), pair


@pytest.mark.parametrize("eds", EVERY, ids=lambda path: path.name)
def test_any_description_is_the_same_as_itself(eds: Path) -> None:
    found = load(str(eds))
    same = compare([found, found], None, filtered=False)
    assert [pair.differences for pair in same.pairs] == [[]] and same.alone == ([], [])
    carried = {(one.index, one.sub) for pdo in found.pdos for one in pdo.mapped}
    for thing in found.objects[::7]:
        for entry in thing.entries[-1:]:
            address, default = (entry.index, entry.sub), entry.default
            by_nature = address in carried or standard_nature(address, 402) or entry.access != "rw"
            if by_nature or not isinstance(default, int) or entry.type not in (5, 6, 7) or entry.parameter is not None:
                continue
            (pair,) = compare([found, with_default(found, *address, default ^ 1)], None, filtered=False).pairs
            assert [(one.address, one.reason) for one in pair.differences] == [(address, None)]


def with_default(found: Dictionary, index: int, sub: int, value: int) -> Dictionary:
    things = tuple(
        one._replace(entries=tuple(e._replace(default=value) if e.sub == sub else e for e in one.entries))
        if one.index == index
        else one
        for one in found.objects
    )
    return found._replace(objects=things)
