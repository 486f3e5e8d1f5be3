"""No false statement about an excerpt: cuts of every session, and what is said of what is left.

Each session is cut in every way of `excerpts`, at places that are the same in every run. `python test_excerpts.py
[SEEDS] [CUTS]` tries more of them and counts what is false.
"""

from __future__ import annotations

import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator

import pytest
from captures import CanFrame, analyze, console_text, log_text
from clean_sessions import sessions as clean_sessions
from excerpts import CUTS, excerpt, false_statements, session, truth

SEEDS = 40
"""Generated sessions that are cut."""
EACH = 4
"""Cuts of each kind, of each session."""
UNANNOUNCED = "unannounced"
"""A hole that nothing announces may look like a fault, or join two transfers: how often is counted."""
HOLES = 10
"""Such holes in each generated session."""
FALSE_BEHIND_HOLES = 47
"""Of these, the ones of which something false is said; it may only fall."""
MISSING = {"CAP002", "SDO024", "SDO031"}
"""What is true of every excerpt that lacks frames: so many were lost, and requests have no response in it."""
HEARTBEATS = {"HBT001", "HBT002"}
LEFT_OUT = {"without a node": {"NMT006"}, "one direction": HEARTBEATS, "one identifier": HEARTBEATS}
"""A node of which no frame is shown has sent no boot-up that could be seen. Without the commands, the silence around a
boot-up has no reason."""
LACKING = {"CAP007", "CAP009", "HBT001", "HBT002", "SDO002", "SDO008"}
"""What is true of a capture where nothing announces what it lacks: no response, no heartbeat, no end is in it."""
BESIDE = {"b6-sdo-block-retransmission": "segments were lost on this bus: its parts can be read in more than one way"}
"""Sessions whose faults hide what a part of them is."""


def said_falsely(name: str, cut: str, number: int) -> list[str]:
    """What is said falsely of one excerpt."""
    rng = random.Random(f"{name} {cut} {number}")
    part = CUTS[cut](session(name), rng)
    if not part.frames:
        return []
    allowed = MISSING | LEFT_OUT.get(cut, LACKING if cut == UNANNOUNCED else set())
    found = false_statements(truth(name), analyze(part.text()), part.origin)
    return [one for one in found if not (one.startswith("finding ") and one.split()[1] in allowed)]


def names(seeds: int) -> Iterator[str]:
    """The sessions that are cut."""
    yield from (name for name in clean_sessions() if name not in BESIDE)
    yield from (f"generated {seed}" for seed in range(seeds))


@pytest.mark.parametrize(("shown", "told"), [(1, False), (2, True), (3, True)])
@pytest.mark.parametrize("write", [log_text, console_text])
def test_a_node_may_be_about_to_obey_when_an_excerpt_begins(
    write: Callable[[list[CanFrame]], bytes], shown: int, told: bool
) -> None:
    """Its first heartbeat shows the state before a command that is not in the excerpt; a second one does not."""
    frames = [CanFrame("can0", 0x080, b"", 0)]
    frames += [CanFrame("can0", 0x705, b"\5" if at < shown else b"\x7f", 3000 + at * 100_000) for at in range(8)]
    frames += [CanFrame("can0", 0x706, b"\x7f", 7000 + at * 100_000) for at in range(8)]
    said = analyze(write(sorted(frames, key=lambda frame: frame.t_us)))
    assert ("NMT004" in {finding["code"] for finding in said.findings}) == told


@pytest.mark.parametrize("cut", [cut for cut in CUTS if cut != UNANNOUNCED])
@pytest.mark.parametrize("name", list(names(SEEDS)))
def test_nothing_false_is_said(name: str, cut: str) -> None:
    false = [f"{number}: {one}" for number in range(EACH) for one in said_falsely(name, cut, number)]
    assert not false, "\n".join(false[:12])


def test_what_is_false_behind_holes_that_nothing_announces_only_falls() -> None:
    holes = [(f"generated {seed}", number) for seed in range(SEEDS) for number in range(HOLES)]
    false = [(name, number) for name, number in holes if said_falsely(name, UNANNOUNCED, number)]
    assert len(false) == FALSE_BEHIND_HOLES, false


@pytest.mark.parametrize("seed", range(SEEDS))
def test_a_whole_session_is_clean(seed: int) -> None:
    """Else nothing that is said of its parts could be false."""
    whole = truth(f"generated {seed}")
    assert not whole.above_info(), whole.complaint()
    assert {row["status"] for row in whole.transfers} <= {"ok", "aborted"}


@pytest.mark.parametrize("seed", range(SEEDS))
def test_what_is_there_in_one_piece_is_decoded(seed: int) -> None:
    """The capture begins with a transfer's first frame, and ends with its last one."""
    name = f"generated {seed}"
    for row in truth(name).transfers:
        part = excerpt(session(name), range(row["first_frame"] - 1, row["last_frame"]))
        (found,) = [one for one in analyze(part.text()).transfers if one["first_frame"] == 1]
        keys = ("direction", "mode", "index", "sub", "size", "data", "value", "status", "abort")
        assert {key: found[key] for key in keys} == {key: row[key] for key in keys}


def test_a_false_statement_is_seen() -> None:
    """The judge of these tests: another capture's truth is not this one's."""
    name = "generated 0"
    said = analyze(log_text(session(name)))
    assert not list(false_statements(truth(name), said, range(len(said.frames))))
    said.transfers[0]["data"] = "00" + said.transfers[0]["data"]
    said.frames[0]["sdo"]["index"] = "1234"
    kinds = [one.split()[0] for one in false_statements(truth(name), said, range(len(said.frames)))]
    assert kinds == ["object", "value", "bytes"]


def main(arguments: list[str]) -> None:
    """Try more, and count: the generated sessions, the excerpts of each kind, and the kinds (default: all)."""
    seeds, each = (int(one) for one in [*arguments[:2], *("200", "20")[len(arguments) :]])
    kinds = arguments[2:] or list(CUTS)
    tried: Counter[str] = Counter()
    false: Counter[str] = Counter()
    for name in names(seeds):
        for cut in kinds:
            for number in range(each):
                found = said_falsely(name, cut, number)
                tried[cut] += 1
                false[cut] += bool(found)
                if found:
                    print(f"{name}, {cut} {number}: {found[0]}"[:400])
    for cut, count in tried.items():
        print(f"{cut}: {false[cut]} of {count} excerpts with a false statement")


if __name__ == "__main__":
    main(sys.argv[1:])
