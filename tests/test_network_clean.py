"""Clean sessions of whole networks, however they were captured: nothing above info is said of them.

Recorded ones (`samples/network/`) and generated ones (`network_sessions.py`), with and without descriptions, with the
jitter of system stamps, with the sender's own frames listed one late, without stamps, and cut anywhere. What it must
not do: allow exceptions for what the program happens to say.
"""

from __future__ import annotations

import json

import pytest
from captures import (
    EDS,
    SAMPLES,
    Analysis,
    CanFrame,
    analyze,
    console_text,
    log_text,
    read_log,
    run_canalyze,
    sort_rows,
)
from network import cuts, echoed_late, jittered
from network_sessions import DESCRIBED, SESSIONS

RECORDED = sorted((SAMPLES / "network").glob("*.log"))
NAMES = [path.stem for path in RECORDED] + list(SESSIONS)
MASTERS = {0x000, 0x080, 0x100, 0x7E5, *range(0x201, 0x280), *range(0x301, 0x380), *range(0x401, 0x480)}
MASTERS |= {*range(0x501, 0x580), *range(0x601, 0x680)}
"""CAN-IDs that the capturing host sends where it is the master."""


def frames_of(name: str) -> list[CanFrame]:
    """A session, recorded or generated."""
    if name in SESSIONS:
        return SESSIONS[name]().frames()
    return read_log((SAMPLES / "network" / f"{name}.log").read_bytes())


def descriptions(name: str) -> dict[int, str]:
    """The dictionaries of its nodes, as far as they have any."""
    if name in SESSIONS:
        return DESCRIBED.get(name, {})
    truth = json.loads((SAMPLES / "network" / f"{name}.json").read_text())
    return {row["node"]: row["eds"] for row in truth["nodes"] if row["eds"]}


def clean(said: Analysis, frames: int) -> None:
    """Every frame is there, and nothing above info."""
    assert len(said.frames) == frames
    assert not said.above_info(), said.complaint()


def test_there_are_sessions_of_every_kind() -> None:
    assert len(RECORDED) >= 8
    assert len(NAMES) == len(set(NAMES))
    assert all(path.with_suffix(".json").exists() for path in RECORDED)
    assert all(path.stat().st_size <= 60_000 for path in RECORDED)


PLAIN = [(name, False) for name in NAMES]
DESCRIBED_TOO = [(name, True) for name in NAMES if descriptions(name)]
every_session = pytest.mark.parametrize(
    ("name", "described"),
    PLAIN + DESCRIBED_TOO,
    ids=lambda part: part if isinstance(part, str) else "eds" if part else "plain",
)
"""Each session without and, where its nodes have any, with descriptions."""


def said_of(text: bytes, name: str, described: bool, *, form: str = "log") -> Analysis:
    """What the program says, in process."""
    return analyze(text, name=f"capture.{form}", eds=descriptions(name) if described else {})


@every_session
def test_as_it_is(name: str, described: bool) -> None:
    frames = frames_of(name)
    clean(said_of(log_text(frames), name, described), len(frames))


@pytest.mark.parametrize("name", [path.stem for path in RECORDED])
def test_by_the_command(name: str) -> None:
    """The same by the command line, with `--eds`."""
    options = [word for node, eds in descriptions(name).items() for word in ("--eds", f"{node}={EDS / eds}")]
    capture = SAMPLES / "network" / f"{name}.log"
    output = run_canalyze(["decode", *options, capture, "--format", "jsonl", "--lang", "en"])
    clean(sort_rows(output), len(frames_of(name)))


@every_session
def test_without_stamps(name: str, described: bool) -> None:
    frames = frames_of(name)
    clean(said_of(console_text(frames), name, described, form="candump"), len(frames))


@every_session
def test_with_jitter(name: str, described: bool) -> None:
    for seed in range(3):
        frames = jittered(frames_of(name), seed=seed)
        clean(said_of(log_text(frames), name, described), len(frames))


@every_session
def test_with_late_echo(name: str, described: bool) -> None:
    for seed in range(3):
        frames = echoed_late(frames_of(name), MASTERS, seed=seed)
        clean(said_of(log_text(frames), name, described), len(frames))


@every_session
def test_cut_anywhere(name: str, described: bool) -> None:
    frames = frames_of(name)
    for start, end in cuts(len(frames)):
        said = said_of(log_text(frames[start:end]), name, described)
        assert not said.above_info(), f"frames {start} to {end}: {said.complaint()}"


def test_guarding_cut_anywhere_without_stamps() -> None:
    """The first answer's request is not there: the others are taken for late, and one of them stays alone."""
    frames = frames_of("guarding")
    for start in range(len(frames)):
        said = analyze(console_text(frames[start:]))
        assert not [finding for finding in said.findings if finding["code"].startswith("GRD")], (
            start,
            said.complaint(),
        )
