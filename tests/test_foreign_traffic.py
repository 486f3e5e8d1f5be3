"""Traffic that is not CANopen raises nothing, alone or beside CANopen, and is named once; CANopen is never called so.

What it must not do: look at the wording.
"""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path

import pytest
from captures import SAMPLES, SHARED, Analysis, CanFrame, analyze, log_text, read_log, session_output
from conftest import Runner
from foreign_traffic import BUS, GENERATORS, START_US, in_order, sensor
from network_sessions import SESSIONS

STACKS = {
    path.stem: read_log(path.read_bytes())
    for folder in (SAMPLES / "stacks", SAMPLES / "network", SHARED / "stacks")
    for path in sorted(folder.glob("*.log"))
}
SEEDS = 20
CHANCE: dict[str, int] = {}
"""Captures of all seeds in which a random value is a message of CANopen by chance, at most, by generator."""
LISTED = {"battery": 1}
"""The same, in which a random value begins a transfer by chance."""
WHOLE = ["extended_sensors", "j1939", "uds", "uds_on_lss"]
FEW = 20
"""Fewer frames of an identifier may be of anything."""


def codes(said: Analysis) -> set[str]:
    return {finding["code"] for finding in said.findings}


@pytest.mark.parametrize("name", GENERATORS)
def test_other_protocols_raise_nothing_and_have_no_transfers(name: str) -> None:
    said = [analyze(log_text(GENERATORS[name](random.Random(seed)))) for seed in range(SEEDS)]
    loud = [one.complaint() for one in said if one.above_info()]
    assert len(loud) <= CHANCE.get(name, 0), "\n".join(loud)
    if name in WHOLE:
        assert [[finding["code"] for finding in one.findings] for one in said] == [["BUS009"]] * SEEDS
    listed = [[row["first_frame"] for row in one.transfers] for one in said if one.transfers]
    assert len(listed) <= LISTED.get(name, 0), listed


@pytest.mark.parametrize("name", WHOLE)
def test_what_is_not_canopen_is_not_called_clean(name: str, tmp_path: Path, canalyze: Runner) -> None:
    (tmp_path / "other.log").write_bytes(log_text(GENERATORS[name](random.Random(1))))
    for lang, word in (("zh", "不是CANopen, 未作判断"), ("en", "not CANopen, not judged")):
        done = canalyze("--lang", lang, "check", "other.log")
        assert done.code == 0
        first = done.out.splitlines()[0]
        assert word in first and not re.search("clean|合格|no failing", done.out)
        told = canalyze("--lang", lang, "diagnose", "other.log")
        assert told.code == 0 and told.out.startswith(("- not judged", "- 未作判断"))
        assert not re.search("✔|no problems|未发现问题", told.out)


def test_a_set_says_how_many_were_not_judged(tmp_path: Path, canalyze: Runner) -> None:
    (tmp_path / "other.log").write_bytes(log_text(GENERATORS["j1939"](random.Random(1))))
    heartbeats = [CanFrame(BUS, 0x705, b"\x05", START_US + turn * 100_000) for turn in range(20)]
    (tmp_path / "clean.log").write_bytes(log_text(heartbeats))
    whole = canalyze("--lang", "en", "check", "other.log", "clean.log").lines[-1]
    assert whole.endswith("no failing findings, 1 file not judged")
    assert "not judged" not in canalyze("--lang", "en", "check", "clean.log").out
    colours = [
        [line for line in canalyze("--lang", "en", *args, "--color", "always").lines if "judged" in line]
        for args in (("check", "other.log"), ("diagnose", "other.log"))
    ]
    assert colours and all("\x1b[38;5;166m" in line for lines in colours for line in lines), colours


@pytest.mark.parametrize("data", ["0908070605040302", "8A1A0DF213000007", "0020010000000000"])
def test_a_frame_like_an_emergency_is_none_where_nothing_is_canopen(data: str) -> None:
    frames = [CanFrame(BUS, 0x0C8, bytes.fromhex(data), START_US), CanFrame(BUS, 0x6F9, bytes(8), START_US + 500)]
    assert not codes(analyze(log_text(frames)))
    heartbeat = CanFrame(BUS, 0x748, b"\x05", START_US - 500)
    assert codes(analyze(log_text([heartbeat, *frames]))), "of a node that is heard it is one"


@pytest.mark.parametrize("name", WHOLE)
def test_a_bus_that_is_not_canopen_has_no_nodes(name: str) -> None:
    capture = log_text(GENERATORS[name](random.Random(1)))
    kinds = [line.split(b'"')[3] for line in session_output([capture], output_format="summary").splitlines()]
    assert kinds.count(b"summary_identifier") >= 2
    assert {b"summary_node", b"summary_pdo", b"summary_sync"}.isdisjoint(kinds)


@pytest.mark.parametrize("name", STACKS)
def test_an_excerpt_of_canopen_is_canopen(name: str) -> None:
    frames = STACKS[name]
    lengths = [10, 40, len(frames)]
    for length in lengths:
        for start in range(0, max(len(frames) - length, 0) + 1, max(len(frames) // 20, 1)):
            said = analyze(log_text(frames[start : start + length]))
            assert "BUS009" not in codes(said), (start, length)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", sorted(set(SESSIONS) - {"lss_bit_timing"}))
def test_sensors_beside_a_clean_network(name: str, seed: int) -> None:
    frames, rng = SESSIONS[name]().frames(), random.Random(seed)
    used = {frame.can_id for frame in frames}
    free = [*range(0x081, 0x0FF), *range(0x701, 0x77F), *range(0x581, 0x5FF), *range(0x601, 0x67F), 0x100, 0x7E4, 0x7E5]
    ids = rng.sample([one for one in free if one not in used], 3)
    seconds = (frames[-1].t_us - frames[0].t_us) / 1_000_000
    streams = (sensor(rng, one, rng.choice([5_000, 10_000, 50_000]), seconds) for one in ids)
    beside = [[shifted(one, frames[0]) for one in stream] for stream in streams]
    said = analyze(log_text(in_order(frames, *beside)))
    assert not said.above_info(), said.complaint()
    assert {"BUS009", "SDO030", "LSS030"} & codes(said) or max(map(len, beside)) < FEW


def shifted(frame: CanFrame, first: CanFrame) -> CanFrame:
    """The frame of a generator on the bus and the clock of a recording."""
    return replace(frame, bus=first.bus, t_us=frame.t_us - START_US + first.t_us)


def test_a_device_that_repeats_a_wrong_frame_is_at_fault() -> None:
    pair = [
        CanFrame(BUS, 0x605, bytes.fromhex("4000100000000000"), START_US),
        CanFrame(BUS, 0x585, bytes.fromhex("4300100092010000"), START_US + 400),
    ]
    heartbeats = [CanFrame(BUS, 0x705, bytes.fromhex("0500"), START_US + turn * 100_000) for turn in range(1, 60)]
    said = analyze(log_text([*pair, *heartbeats]))
    assert [row["severity"] for row in said.findings if row["code"] == "HBT006"][:1] == ["warning"]
    assert "BUS009" not in codes(said)


@pytest.mark.parametrize("heartbeats", [True, False])
def test_a_drive_that_reports_errors_of_its_profile_is_heard(heartbeats: bool) -> None:
    """Codes of CiA 402, never reset: each is another frame, and none is of the classes of CiA 301 alone."""
    codes_raised = [0x8611, 0x7305, 0x8480, 0x7121, 0x8A00]
    frames = [CanFrame(BUS, 0x185, bytes.fromhex("37020000"), START_US + turn * 50_000) for turn in range(120)]
    if heartbeats:
        frames += [CanFrame(BUS, 0x705, b"\x05", START_US + 10_000 + turn * 100_000) for turn in range(60)]
    for turn, code in enumerate(codes_raised):
        data = code.to_bytes(2, "little") + b"\x21" + bytes(5)
        frames.append(CanFrame(BUS, 0x085, data, START_US + 1_005_000 + turn * 400_000))
    said = analyze(log_text(in_order(frames)))
    assert [row["code"] for row in said.findings].count("EMC007") == len(codes_raised), said.complaint()
