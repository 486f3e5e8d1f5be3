"""Rows listed late: the same is found as where they are listed in time, and what is printed keeps the file's order.

Why it exists: that clean traffic raises nothing where rows are listed late (`test_distortions.py`) says little if
faults raise nothing either. What it must not do: test clean traffic, or know what a finding is about.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from itertools import islice

import pytest
from captures import CanFrame, Row, log_text, session_output
from clean_sessions import sessions
from distortions import Frames, late_rows, of_two_clocks
from fault_table import TABLE, AnyFault
from plants import MASTERS, Session

from canalyze import _core

EVERY = 13
"""Only every 13th case of a fault is tried: they differ by place and by what is known."""

LATE = [(1000, 0.3), (5000, 0.05), (5000, 0.3), (9000, 0.15)]
"""By how many microseconds rows are late at most, and which share of them."""

Named = tuple[str, str, int | None, tuple[CanFrame | None, ...]]


def named(frames: Frames, network: _core.Network | None) -> Counter[Named]:
    """The findings above info of a capture, each with the frames that it names."""
    output = session_output([log_text(frames)], output_format="check", lang="en", network=network)

    def frame(number: int | None) -> CanFrame | None:
        return frames[number - 1] if number else None

    every: Iterator[Row] = map(json.loads, output.decode().splitlines())
    rows = (row for row in every if row["severity"] != "info")
    of = ("frame", "cause_frame", "because_of")
    return Counter((row["code"], row["severity"], row["node"], tuple(frame(row[key]) for key in of)) for row in rows)


@pytest.mark.parametrize("fault", TABLE, ids=lambda fault: fault.row)
def test_a_fault_is_found_as_in_order(fault: AnyFault) -> None:
    """Every finding of the capture in order, about the same frames, and no other."""
    for case in islice(fault.cases(), 0, None, EVERY):
        ordered = sorted(case.faulty.frames, key=lambda frame: frame.t_us)
        found = named(ordered, case.network)
        for most_us, share in LATE:
            listed = late_rows(ordered, most_us, share, 1)
            assert named(listed, case.network) == found, (case.where, most_us, share)


@pytest.mark.parametrize("name", ["plant described", "transfers", "sync-and-pdos"])
@pytest.mark.parametrize("output_format", ["jsonl", "text"])
def test_rows_are_printed_as_they_are_listed(name: str, output_format: str) -> None:
    listed = late_rows(list(sessions()[name].frames), 5000, 0.3, 1)
    assert listed != sorted(listed, key=lambda frame: frame.t_us)
    output = session_output([log_text(listed)], output_format=output_format, lang="en").decode()
    if output_format == "text":
        stamps = [line.split()[0] for line in output.splitlines() if line.startswith("(")]
        assert stamps == [line.split()[0] for line in log_text(listed).decode().splitlines()]
        return
    rows = [row for row in map(json.loads, output.splitlines()) if row["kind"] == "frame"]
    assert [row["frame"] for row in rows] == list(range(1, len(listed) + 1))
    assert [(int(row["id"], 16), row["data"]) for row in rows] == [
        (one.can_id, one.data.hex().upper()) for one in listed
    ]


@pytest.mark.parametrize("apart_us", [-2000, 3000])
def test_with_two_clocks_the_order_of_the_capture_holds(apart_us: int) -> None:
    """Each SDO request comes before its response there, and behind it by the stamps."""
    session = sessions()["calm traffic"]
    assert not named(of_two_clocks(session, apart_us, merged=False), None)


@pytest.mark.parametrize("fault", [one for one in TABLE if "stamps jump" not in one.name], ids=lambda fault: fault.row)
def test_a_fault_is_found_with_two_clocks(fault: AnyFault) -> None:
    """The host's stamps are early, and both recordings were joined by stamps."""
    for case in islice(fault.cases(), 0, None, EVERY):
        codes = {code for code, *_ in named(case.faulty.frames, case.network) if code.startswith(fault.codes)}
        session = Session(tuple(case.faulty.frames), MASTERS)
        for apart_us in (-2000, -9000):
            joined = named(of_two_clocks(session, apart_us, merged=True), case.network)
            assert codes <= {code for code, *_ in joined}, (case.where, apart_us)


def test_corrected_stamps_are_not_printed() -> None:
    listed = of_two_clocks(sessions()["calm traffic"], -5000, merged=True)
    output = session_output([log_text(listed)], output_format="text", lang="en").decode()
    stamps = [line.split()[0] for line in output.splitlines() if line.startswith("(")]
    assert stamps == [line.split()[0] for line in log_text(listed).decode().splitlines()]


def test_the_diagnosis_shows_stamps_of_the_capture() -> None:
    session = sessions()["transfers"]
    for apart_us in (-2000, -9000):
        listed = of_two_clocks(session, apart_us, merged=True)
        rows = session_output([log_text(listed)], output_format="diagnosis", lang="en").decode().splitlines()
        stamps = {f"{frame.t_us / 1e6:.6f}" for frame in listed}
        shown = [row["begin"]["t"] for row in map(json.loads, rows) if row["kind"] == "problem"]
        assert shown and stamps.issuperset(shown)
