"""Several captures at once: which are parts of one recording, and how the others are diagnosed.

What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest
from conftest import Runner
from test_diagnosis import lost

from canalyze.sources.names import APART_NS, Span, recordings

S = 1_000_000_000
T = 1_700_000_000 * S
CAN0 = frozenset({"can0"})


def _span(name: str, begin: int | None, end: int | None, buses: frozenset[str] = CAN0, at: int = T) -> Span:
    return Span(name, None if begin is None else at + begin, None if end is None else at + end, buses)


@pytest.mark.parametrize("apart_ns", [0, 1, S, APART_NS])
def test_files_that_follow_one_another_are_one_recording(apart_ns: int) -> None:
    first, second = _span("a.10", 5 * S, 9 * S), _span("a.9", 0, 5 * S - apart_ns)
    assert recordings([first, second]) == [("a.9", "a.10")], "in the order of time, however they are named"


@pytest.mark.parametrize(
    "second",
    [
        _span("b", 5 * S + APART_NS + 1, 90 * S),
        _span("b", 5 * S - 1, 9 * S),
        _span("b", 0, 5 * S),
        _span("b", 5 * S, 9 * S, frozenset({"can1"})),
        _span("b", None, None),
    ],
    ids=["too late", "too early", "at the same time", "another bus", "without stamps"],
)
def test_others_are_recordings_of_their_own(second: Span) -> None:
    assert recordings([_span("a", 0, 5 * S), second]) == [("a",), ("b",)]


def test_clocks_that_begin_at_zero_tell_nothing() -> None:
    assert recordings([_span("a", 0, 5 * S, at=0), _span("b", 5 * S, 9 * S, at=0)]) == [("a",), ("b",)]


def test_a_file_of_the_same_time_is_no_part_and_parts_nothing() -> None:
    """Of two networks with one name of their bus nobody knows which part follows which."""
    parts = [_span("a", 0, 5 * S), _span("b", 5 * S, 9 * S), _span("other", 6 * S, 9 * S)]
    assert recordings(parts) == [("a",), ("b",), ("other",)]
    later = _span("later", 20 * S, 30 * S)
    assert recordings([*parts[:2], later]) == [("a", "b"), ("later",)]


def test_two_recorders_that_were_split_are_told_apart() -> None:
    can1 = frozenset({"can1"})
    parts = [_span("a1", 0, 5), _span("b1", 1, 6, can1), _span("a2", 6, 9), _span("b2", 7, 9, can1)]
    assert recordings(parts) == [("a1", "a2"), ("b1", "b2")]


@pytest.fixture
def captures(tmp_path: Path) -> Path:
    """A node that is lost, twice, an hour apart; a healthy capture; and what is no capture."""
    folder = tmp_path / "captures"
    (folder / "night").mkdir(parents=True)
    (folder / "lost.log").write_bytes(lost(20))
    (folder / "night" / "well.log").write_text("".join(f"({1_600_000_000 + n}.5) can0 702#05\n" for n in range(9)))
    (folder / "notes.md").write_text("nothing")
    return folder


def test_what_can_be_read_once_is_read_once(canalyze: Runner, captures: Path, tmp_path: Path) -> None:
    """A named pipe is read as part of one recording, as it was."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    content = (captures / "lost.log").read_bytes()
    writer = threading.Thread(target=pipe.write_bytes, args=(content,))
    writer.start()
    done = canalyze("--lang", "en", "captures/night/well.log", "pipe")
    writer.join()
    assert done.code == 0 and "silent since" in done.out and "recordings" not in done.out
