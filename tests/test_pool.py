"""The pool of processes: what a piece of work does to its process costs that piece only, and no process is left."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import sys
import time
import weakref
from collections.abc import Iterator
from pathlib import Path

import fleet_works
import pytest

from canalyze._core import Session
from canalyze.running.pool import Ended, Pool
from canalyze.running.reading import SessionOptions
from canalyze.running.run import Run
from canalyze.words import Words


def done(pieces: list[str], **limits: int) -> dict[str, Ended]:
    pool = Pool(fleet_works.simple, 2, **limits)  # type: ignore[arg-type]  # by their names
    try:
        for piece in pieces:
            pool.submit(piece)
        return {one.piece: one for one in pool.completed()}
    finally:
        pool.close()


def test_a_process_that_dies_costs_its_piece_only() -> None:
    pieces = [f"do {number}" for number in range(20)]
    found = done([*pieces[:10], "die", *pieces[10:], "raise it"])
    assert {piece for piece, one in found.items() if one.failure is None} == set(pieces)
    died, raised = found["die"].failure, found["raise it"].failure
    assert died is not None and (died.kind, died.reason) == ("died", "SIGKILL")
    assert raised is not None and (raised.kind, raised.reason) == ("raised", "ValueError('it')")
    assert len({one.result for one in found.values() if one.result}) <= 3  # two, and one in the place of the dead


def test_time_is_limited_for_a_piece_and_not_for_all() -> None:
    found = done(["sleep 600", *(f"sleep 0.{number}" for number in range(4, 9))], seconds=2)
    failed = [piece for piece, one in found.items() if one.failure]
    assert failed == ["sleep 600"]
    assert found["sleep 600"].failure is not None and found["sleep 600"].failure.kind == "time"


@pytest.mark.skipif(sys.platform != "linux", reason="not every system has a limit")
def test_memory_is_limited_and_given_back() -> None:
    found = done(["take 2000", "take 50", "take 51", "take 52"], megabytes=300)
    assert found["take 2000"].failure is not None and found["take 2000"].failure.kind == "memory"
    assert sorted(piece for piece, one in found.items() if one.result) == ["take 50", "take 51", "take 52"]


def test_words_arrive_before_the_end() -> None:
    said: list[object] = []
    pool = Pool(fleet_works.simple, 1, progress=lambda piece, word: said.append((piece, word)))
    pool.submit("tell me")
    assert [one.failure for one in pool.completed()] == [None]
    pool.close()
    assert said == [("tell me", "me")]


@pytest.fixture
def idle() -> Iterator[tuple[Pool, int]]:
    pool = Pool(fleet_works.simple, 1)
    pool.submit("do")
    (one,) = pool.completed()
    yield pool, int(one.result.split()[1])
    pool.close()


def test_a_process_that_dies_with_nothing_to_do_costs_nothing(idle: tuple[Pool, int]) -> None:
    pool, process = idle
    os.kill(process, signal.SIGKILL)
    while multiprocessing.active_children():
        time.sleep(0.01)
    pool.submit("do it")
    assert [one.failure for one in pool.completed()] == [None]


def test_nothing_is_left(idle: tuple[Pool, int]) -> None:
    pool, process = idle
    pool.submit("sleep 600")
    pool.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


class _Still:
    def step(self, size: int, frames: int) -> None:
        """Show nothing."""

    def clear(self) -> None:
        """Nothing is shown."""


def test_what_has_read_a_capture_is_gone_with_its_session() -> None:
    """A process that examines one capture after the other does not keep them until its cycles are looked for."""
    sample = Path(__file__).parent.parent / "samples" / "zephyr-sdo.log"
    gc.disable()
    try:
        one = Run(Session(SessionOptions("en")), Words("en"), _Still(), lambda _: None, {})
        assert one.over((str(sample),)) == 0
        held = weakref.ref(one)
        del one
        assert held() is None
    finally:
        gc.enable()
