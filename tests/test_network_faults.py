"""One fault in a clean session of a network: the rule that is for it says so, at the right frame, of the right node.

A table of single faults. The finding's frame, or the frame it names as the cause, must be among the places of the
fault; nothing above info may be said beside it but what the row allows. The other half of the proof, that the same
session without the fault raises none of these, is here too. What it must not do: look at the wording.
"""

from __future__ import annotations

import pytest
from captures import Analysis, Row, analyze, log_text
from faults_in_networks import CASES, RULES, Case, clean_frames
from network import Frames, find
from network_sessions import DESCRIBED, SESSIONS

SEVERITIES = ("info", "warning", "error")


def listed(findings: list[Row]) -> str:
    """For messages."""
    rows = [f"{f['code']} {f['severity']} at {f['frame']} of {f['cause_frame']} node {f['node']}" for f in findings]
    return ", ".join(rows) or "none"


def named(case: Case, said: Analysis) -> list[Row]:
    """The findings that name the fault by its code and are bad enough."""
    least = SEVERITIES.index(case.severity)
    codes = case.codes.split()
    return [f for f in said.findings if f["code"] in codes and SEVERITIES.index(f["severity"]) >= least]


def answers(frames: Frames, places: list[int]) -> list[int]:
    """Where the places are SDO requests, their answers are right places too."""
    found = []
    for place in places:
        server = frames[place].can_id - 0x80
        if 0x581 <= server <= 0x5FF:
            found += [at for at in range(place, len(frames)) if frames[at].can_id == server][:1]
    return found


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.codes.split()[0]}-{case.name.replace(' ', '-')}")
def test_a_fault_is_named_where_it_is(case: Case) -> None:
    frames, places = case.fault(list(clean_frames(case.session)))
    said = analyze(log_text(frames), eds=case.eds)
    assert len(said.frames) == len(frames)
    right = named(case, said)
    assert right, f"no {case.codes}, but: {listed(said.findings)}"
    lines = {place + 1 for place in [*places, *answers(frames, places), *(find(frames, *one) for one in case.also)]}
    assert any({f["frame"], f["cause_frame"]} & lines for f in right), f"not at {sorted(lines)}: {listed(right)}"
    if case.node is not None:
        assert {f["node"] for f in right} == {case.node}, listed(right)
    allowed = {*case.codes.split(), *case.beside.split()}
    others = [f for f in said.above_info() if f["code"] not in allowed]
    assert not others, f"also said: {listed(others)}"


@pytest.mark.parametrize("session", sorted(SESSIONS))
def test_without_the_fault_none_is_named(session: str) -> None:
    text = log_text(clean_frames(session))
    for eds in (DESCRIBED[session], {}) if session in DESCRIBED else ({},):
        said = analyze(text, eds=eds)
        assert not said.above_info(), said.complaint()
        wrong = [f for f in said.findings if f["code"] in RULES]
        assert not wrong, listed(wrong)
