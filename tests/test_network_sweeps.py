"""The same single fault at every fitting frame of the recorded networks.

The table of `test_network_faults.py` has one place for each fault; here every place of a recording gets it, so that a
verdict cannot rest on where in a session it stands. The finding must be at the faulty frame, or about it, or at the
frame that proves it. What it must not do: need descriptions; what is known, the recordings themselves show.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import pytest
from captures import SAMPLES, CanFrame, Row, analyze, log_text, read_log

NETWORK = SAMPLES / "network"


@cache
def recorded(name: str) -> tuple[CanFrame, ...]:
    return tuple(read_log((NETWORK / f"{name}.log").read_bytes()))


@cache
def truth(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((NETWORK / f"{name}.json").read_text())
    return found


def with_data(name: str, at: int, data: bytes) -> list[CanFrame]:
    """The recording with another payload in one frame."""
    frames = list(recorded(name))
    frames[at] = replace(frames[at], data=data)
    return frames


def flipped(name: str, at: int, byte: int, bits: int) -> list[CanFrame]:
    data = bytearray(recorded(name)[at].data)
    data[byte] ^= bits
    return with_data(name, at, bytes(data))


def without(name: str, at: int) -> list[CanFrame]:
    return [frame for i, frame in enumerate(recorded(name)) if i != at]


def twice(name: str, at: int, microseconds: int) -> list[CanFrame]:
    frames = list(recorded(name))
    copy = replace(frames[at], t_us=frames[at].t_us + microseconds)
    return sorted([*frames, copy], key=lambda frame: frame.t_us)


def named(frames: list[CanFrame], codes: str, first: int, last: int) -> list[Row]:
    """The findings of these codes between two indices, or about a frame between them."""
    lines = range(first + 1, last + 2)
    said = analyze(log_text(frames))
    right = [f for f in said.findings if f["code"] in codes.split()]
    return [f for f in right if f["frame"] in lines or f["cause_frame"] in lines]


def following(name: str, at: int, can_id: int) -> int | None:
    """The index of the next frame on a CAN-ID."""
    return next((i for i in range(at + 1, len(recorded(name))) if recorded(name)[i].can_id == can_id), None)


def places(name: str, can_id: int, *, remote: bool = False) -> list[int]:
    return [i for i, f in enumerate(recorded(name)) if f.can_id == can_id and f.remote == remote]


def missed(found: Iterator[tuple[int, bool]]) -> list[int]:
    """The places at which nothing was named, and a look that there were places."""
    results = list(found)
    print(f"{len(results)} places")
    assert results
    return [at + 1 for at, right in results if not right]


def test_toggle_of_every_guarding_answer() -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for at in places("guarding", 0x704):
            if recorded("guarding")[at].data == b"\0":
                continue
            end = following("guarding", at + 1, 0x704) or at
            yield at, bool(named(flipped("guarding", at, 0, 0x80), "GRD001", at, end + 1))

    assert not missed(found())


def test_every_two_guarding_answers_missing() -> None:
    """Of a single one the next toggle bit shows that it was sent."""

    def found() -> Iterator[tuple[int, bool]]:
        answers = places("guarding", 0x704)
        for at, behind in pairwise(answers[:-1]):
            if b"\0" not in (recorded("guarding")[at].data, recorded("guarding")[behind].data):
                left = [frame for i, frame in enumerate(recorded("guarding")) if i not in (at, behind)]
                yield at, bool(named(left, "GRD002", at - 1, behind + 12))

    assert not missed(found())


@pytest.mark.parametrize("wrong", [0, 9, 255])
def test_every_sync_counter(wrong: int) -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for at in places("sync-counter", 0x080)[1:-1]:
            end = following("sync-counter", at, 0x080) or at
            yield at, bool(named(with_data("sync-counter", at, bytes([wrong])), "SYN002", at, end))

    assert not missed(found())


def test_every_sync_without_its_counter() -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for at in places("sync-counter", 0x080):
            yield at, bool(named(with_data("sync-counter", at, b""), "SYN001 SYN002", at, at))

    assert not missed(found())


@pytest.mark.parametrize("name", ["sync-and-pdos", "sync-counter"])
def test_every_sync_missing(name: str) -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for before, at, after in zip(
            # The gap after the one that is missing shows that it was not only late.
            places(name, 0x080)[1:],
            places(name, 0x080)[2:],
            places(name, 0x080)[3:-1],
            strict=False,
        ):
            yield at, bool(named(without(name, at), "SYN003 SYN002", before, after - 1))

    assert not missed(found())


SYNCHRONOUS = [("sync-and-pdos", 0x287), ("sync-counter", 0x287), ("sync-counter", 0x385)]
"""Recordings, and CAN-IDs of TPDOs that they show to be of type 4, 4 and 2."""


@pytest.mark.parametrize(("name", "can_id"), SYNCHRONOUS)
def test_every_synchronous_pdo_missing(name: str, can_id: int) -> None:
    def found() -> Iterator[tuple[int, bool]]:
        # Two of them show the cycle; before that nothing is due.
        for at in places(name, can_id)[2:-1]:
            end = following(name, at, can_id) or at
            yield at, bool(named(without(name, at), "SYN008 SYN010", at - 1, end))

    assert not missed(found())


@pytest.mark.parametrize(("name", "can_id"), SYNCHRONOUS)
def test_every_synchronous_pdo_twice(name: str, can_id: int) -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for at in places(name, can_id)[1:-1]:
            yield at, bool(named(twice(name, at, 50), "SYN009 SYN010", at, at + 2))

    assert not missed(found())


def test_every_pdo_of_a_shown_mapping_too_short() -> None:
    """In `remapping`, from the line at which the capture has shown the mapping by an acknowledged write.

    Not the first one after a reset of communication: stacks differ in whether they keep what was written and not
    stored, so that only this frame shows which mapping holds now.
    """
    lines = {row["line"]: row for row in truth("remapping")["pdo"]}
    resets = [row["line"] for row in truth("remapping")["nmt"] if row["cs"] == "82" and row["node"] == 6]
    of_node = [line for line, row in lines.items() if (row["node"], row["pdo"]) == (6, "TPDO1")]
    uncertain = {min(line for line in of_node if line > reset) for reset in resets}
    shown = min(line for line, row in lines.items() if row["node"] == 6 and "6401:01" in row["signals"] and line > 60)

    def found() -> Iterator[tuple[int, bool]]:
        for line, row in lines.items():
            if line < shown or line in uncertain or (row["node"], row["pdo"]) not in {(6, "TPDO1"), (4, "TPDO5")}:
                continue
            data = recorded("remapping")[line - 1].data
            frames = with_data("remapping", line - 1, data[:-1])
            yield line - 1, bool(named(frames, "PDO001", line - 1, line - 1))

    assert not missed(found())


def test_every_pdo_of_a_shown_mapping_too_long() -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for at in places("remapping", 0x1C6) + places("remapping", 0x1C4):
            data = recorded("remapping")[at].data + b"\0"
            yield at, bool(named(with_data("remapping", at, data), "PDO006", at, at))

    assert not missed(found())


def test_every_emergency_with_register_0() -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for name in ("boot-and-states", "drive-states"):
            for row in truth(name)["emcy"]:
                at = row["line"] - 1
                if row["code"] != "0000":
                    data = bytearray(recorded(name)[at].data)
                    data[2] = 0
                    yield at, bool(named(with_data(name, at, bytes(data)), "EMC001", at, at))

    assert not missed(found())


def test_every_heartbeat_in_an_unknown_state() -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for can_id in (0x705, 0x706, 0x707):
            for at in places("boot-and-states", can_id):
                if recorded("boot-and-states")[at].data != b"\0":
                    frames = with_data("boot-and-states", at, b"\x33")
                    yield at, bool(named(frames, "HBT003", at, at))

    assert not missed(found())


def test_every_inverted_frame_of_the_srdo() -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for at in places("multiplex-and-safety", 0x108):
            frames = flipped("multiplex-and-safety", at, 1, 0x10)
            yield at, bool(named(frames, "SRD001", at - 1, at))

    assert not missed(found())


def test_every_srdo_pair_missing() -> None:
    name = "multiplex-and-safety"

    def found() -> Iterator[tuple[int, bool]]:
        for at in places(name, 0x107)[1:-1]:
            inverted = following(name, at, 0x108)
            frames = [frame for i, frame in enumerate(recorded(name)) if i not in (at, inverted)]
            yield at, bool(named(frames, "SRD003", at - 15, (following(name, at, 0x107) or at) + 1))

    assert not missed(found())


def test_every_lss_confirmation_with_an_error() -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for name in ("lss-selective", "lss-fastscan"):
            for row in truth(name)["lss"]:
                if row["dir"] == "answer" and row["cs"] in ("11", "17"):
                    at = row["line"] - 1
                    data = bytes([int(row["cs"], 16), 0xFF, 0x07]).ljust(8, b"\0")
                    yield at, bool(named(with_data(name, at, data), "LSS004", at, at))

    assert not missed(found())


def test_every_lss_command_unknown() -> None:
    def found() -> Iterator[tuple[int, bool]]:
        for at in places("lss-selective", 0x7E5):
            yield at, bool(named(with_data("lss-selective", at, b"\x99".ljust(8, b"\0")), "LSS001", at, at))

    assert not missed(found())


def test_every_boot_up_of_a_reset_is_spontaneous_without_it() -> None:
    """The command missing: nothing in the capture explains the boot-up any more."""

    def found() -> Iterator[tuple[int, bool]]:
        for name in ("boot-and-states", "remapping", "guarding"):
            boot_ups = truth(name)["boot_ups"]
            for row in truth(name)["nmt"]:
                if row["cs"] in ("81", "82"):
                    up = next(b["line"] for b in boot_ups if b["node"] == row["node"] and b["line"] > row["line"])
                    yield up - 1, bool(named(without(name, row["line"] - 1), "NMT003", up - 2, up - 2))

    assert not missed(found())
