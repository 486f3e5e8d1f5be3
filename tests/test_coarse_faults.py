"""Faults in captures with coarse stamps: what the stamps still show is found, and what they do not show is not said.

Why it exists: that clean traffic raises nothing under coarse stamps (`test_distortions.py`) says little if faults raise
nothing either. Each is put in at magnitudes around what a resolution shows. What it must not do: test clean traffic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from captures import CanFrame, log_text
from distortions import fetched, floored, shown
from faulty_captures import Capture
from plants import DRIVE, HEARTBEAT, INHIBITED_PDO, IO, Session, built, slow
from test_distortions import findings

Frames = list[CanFrame]
Change = Callable[[Frames, int], Frames]
FORMS: dict[str, Change] = {"coarse": floored, "fetched": fetched}


def silent(session: Session, node: int, since: float, until: float) -> Frames:
    """A node that sends nothing from a time to another."""
    capture = Capture(session)
    capture.drop(since, until, 0x700 + node, 0x180 + node, 0x280 + node, 0x580 + node, 0x600 + node)
    return capture.frames


def codes(frames: Frames, session: Session) -> set[str]:
    return {finding["code"] for finding in findings(log_text(frames), session.network)}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("unit_us", [1000, 10_000, 100_000, 1_000_000])
@pytest.mark.parametrize("lasts", [8.0, 20.0, 60.0])
def test_a_silent_node_is_found(form: str, unit_us: int, lasts: float) -> None:
    """A node with a heartbeat of 1 s, silent for longer than three of them and what the stamps leave open."""
    session = slow()
    for since in (20.3, 50.3):
        faulty = silent(session, DRIVE, since, since + lasts)
        assert "HBT002" in codes(FORMS[form](faulty, unit_us), session), f"{shown(unit_us)}, {since} s"


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("unit_us", [1000, 10_000, 50_000, 100_000])
@pytest.mark.parametrize("known", ["traffic", "written", "described"])
def test_a_node_that_never_comes_back_is_found(form: str, unit_us: int, known: str) -> None:
    """A heartbeat of 100 ms, gone for seconds: also where stamps are as coarse as its period."""
    session = built("plant", known)
    for since in (1.4, 4.3):
        found = codes(FORMS[form](silent(session, IO, since, 9.0), unit_us), session)
        assert "HBT002" in found, f"{shown(unit_us)}, {since} s: {found}"


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("unit_us", [1, 1000, 5000])
@pytest.mark.parametrize("missing", [1, 3, 10])
def test_missing_syncs_are_found(form: str, unit_us: int, missing: int) -> None:
    """A period of 25 ms: the stamps are finer."""
    session = built("plant", "written")
    for since in (1.5, 4.3):
        capture = Capture(session)
        capture.drop(since, since + 0.6, 0x80, 0x185, 0x285, most=missing)
        first = capture.next(0x80, since)
        capture = Capture(session)
        capture.drop(since, first - 0.001, 0x80, 0x185, 0x285)
        found = codes(FORMS[form](capture.frames, unit_us), session)
        assert found & {"SYN003", "SYN013"}, f"{shown(unit_us)}, {since} s: {found}"


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("unit_us", "found"), [(1, True), (1000, True), (5000, True), (50_000, False), (100_000, False)]
)
def test_two_sync_producers_are_found_while_stamps_show_them(form: str, unit_us: int, found: bool) -> None:
    """A second SYNC, 8 ms behind the first, with a period of 25 ms: a stamp that is longer does not tell it."""
    session = built("plant", "written")
    capture = Capture(session)
    first = [
        frame for frame in session.frames if frame.can_id == 0x80 and frame.t_us > session.frames[0].t_us + 3_000_000
    ]
    capture.frames += [replace(frame, t_us=frame.t_us + 8000) for frame in first[:60]]
    frames = sorted(capture.frames, key=lambda frame: frame.t_us)
    raised = codes(FORMS[form](frames, unit_us), session)
    assert ("SYN006" in raised) == found, f"{shown(unit_us)}: {raised}"


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("unit_us", "found"), [(1, True), (1000, True), (10_000, True), (50_000, False), (100_000, False)]
)
def test_an_inhibit_time_is_judged_as_far_as_stamps_show(form: str, unit_us: int, found: bool) -> None:
    """PDOs 12 ms apart, inhibit time 50 ms."""
    session = built("plant", "written")
    capture = Capture(session)
    for at in (1.45, 2.05, 4.55):
        capture.add(capture.next(INHIBITED_PDO, at) + 0.012, INHIBITED_PDO, b"\1\2")
    frames = sorted(capture.frames, key=lambda frame: frame.t_us)
    raised = codes(FORMS[form](frames, unit_us), session)
    assert ("PDO004" in raised) == found, f"{shown(unit_us)}: {raised}"


def test_a_late_heartbeat_is_none_where_a_stamp_is_longer() -> None:
    """The same gap is one by exact stamps."""
    session = built("plant", "traffic")
    first = Capture(session).next(0x700 + IO, 1.45)
    capture = Capture(session)
    capture.drop(first - 0.001, first + HEARTBEAT / 2, 0x700 + IO)
    assert "HBT001" in codes(capture.frames, session)
    assert "HBT001" not in codes(floored(capture.frames, 200_000), session)


def test_one_stall_does_not_make_stamps_coarse() -> None:
    """Frames of one burst come faster than a bus can carry them; what comes long after it is judged as ever."""
    session = built("plant", "written")
    frames = list(session.frames)
    at = next(number for number, frame in enumerate(frames) if frame.t_us > frames[0].t_us + 1_000_000)
    until = frames[at].t_us + 200_000
    burst = [
        replace(frame, t_us=until + number) for number, frame in enumerate(f for f in frames[at:] if f.t_us < until)
    ]
    listed = [*frames[:at], *burst, *(frame for frame in frames[at:] if frame.t_us >= until + len(burst))]
    capture = Capture(session)
    capture.frames = listed
    capture.add(capture.next(INHIBITED_PDO, 4.5) + 0.02, INHIBITED_PDO, b"\1\2")
    raised = codes(sorted(capture.frames, key=lambda frame: frame.t_us), session)
    assert "PDO004" in raised, raised
