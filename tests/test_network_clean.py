"""Clean sessions of whole networks, however they were captured: nothing above info is said of them.

Recorded ones (`samples/network/`) and generated ones (`network_sessions.py`), with and without descriptions, with the
jitter of system stamps, with the sender's own frames listed one late, without stamps, and cut anywhere. What it must
not do: allow exceptions for what the program happens to say.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from captures import SAMPLES, Analysis, CanFrame, analyze, console_text, log_text, read_log, run_canalyze, sort_rows
from network import cuts, echoed_late, jittered
from network_sessions import DESCRIBED, SESSIONS

EDS = Path(__file__).resolve().parent.parent / "eds"
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
    assert all(path.with_suffix(".json").exists() for path in RECORDED)
    assert all(path.stat().st_size <= 60_000 for path in RECORDED)


@pytest.mark.parametrize("name", NAMES)
def test_as_it_is(name: str) -> None:
    frames = frames_of(name)
    clean(analyze(log_text(frames)), len(frames))


@pytest.mark.parametrize("name", [name for name in NAMES if descriptions(name)])
def test_with_descriptions(name: str, tmp_path: Path) -> None:
    frames = frames_of(name)
    capture = tmp_path / "capture.log"
    capture.write_bytes(log_text(frames))
    options = [word for node, eds in descriptions(name).items() for word in ("--eds", f"{node}={EDS / eds}")]
    output = run_canalyze(["decode", *options, capture, "--format", "jsonl", "--lang", "en"])
    clean(sort_rows(output), len(frames))


@pytest.mark.parametrize("name", NAMES)
def test_without_stamps(name: str) -> None:
    frames = frames_of(name)
    clean(analyze(console_text(frames), name="capture.candump"), len(frames))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", NAMES)
def test_with_jitter(name: str, seed: int) -> None:
    frames = jittered(frames_of(name), seed=seed)
    clean(analyze(log_text(frames)), len(frames))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", NAMES)
def test_with_late_echo(name: str, seed: int) -> None:
    frames = echoed_late(frames_of(name), MASTERS, seed=seed)
    clean(analyze(log_text(frames)), len(frames))


@pytest.mark.parametrize("name", NAMES)
def test_cut_anywhere(name: str) -> None:
    frames = frames_of(name)
    for start, end in cuts(len(frames)):
        said = analyze(log_text(frames[start:end]))
        assert not said.above_info(), f"frames {start} to {end}: {said.complaint()}"
