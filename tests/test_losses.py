"""Faults in captures of which single frames were lost: a loss explains what it may have caused, and nothing else.

Why it exists: `test_distortions.py` shows what a loss is forgiven; here is what it must not hide. Frames are lost
outside a fault, over shares and seeds, and the fault must still be found as one of its own. What it must not do: lose
the frames that show the fault.
"""

from __future__ import annotations

import random
from collections import Counter
from itertools import islice

import pytest
from captures import CanFrame
from fault_table import TABLE, AnyFault
from faulty_captures import Faulty
from test_detection import findings

from canalyze import _core

SHARES = (0.005, 0.01, 0.02, 0.03)
CASES = 6
AROUND = 3
"""Frames around a fault that are not lost."""
UNLIKELY = (
    "node lost",
    "life guarding, the master stops for",
    "SDO abort",
    "SDO write refused",
    "SDO answered after",
    "EMCY",
    "drive",
    "error frame",
    "PDO length",
    "SYNC period",
    "TPDO while Pre-operational",
)
"""Faults that single losses do not explain."""
FOUND = 0.85
"""The least share of such faults that are found: the loss of a write leaves a mapping or a drive unknown."""


def with_losses(faulty: Faulty, share: float, seed: int) -> list[CanFrame]:
    """The capture without a share of the frames that are not part of the fault."""
    chance = random.Random(seed)
    part = range(faulty.first - AROUND, faulty.last + AROUND + 1)
    return [f for number, f in enumerate(faulty.frames, 1) if number in part or chance.random() >= share]


def has(fault: AnyFault, faulty: Faulty, network: _core.Network | None) -> bool:
    """Whether a finding of the fault's kind is no consequence."""
    codes = tuple(fault.codes.split())
    return any(row["code"].startswith(codes) for row in findings(faulty, network, fault.bit_rate))


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("name", UNLIKELY)
def test_a_loss_does_not_hide_what_it_has_not_caused(name: str, share: float) -> None:
    tried: Counter[bool] = Counter()
    for fault in TABLE:
        if fault.name == name:
            for seed, case in enumerate(islice(fault.cases(), CASES)):
                lossy = Faulty(with_losses(case.faulty, share, seed), 1, 1)
                before, after = (has(fault, frames, case.network) for frames in (case.faulty, lossy))
                tried[after] += before
    assert tried.total() > 0
    assert tried[True] >= FOUND * tried.total(), tried


def unanswered(name: str) -> list[AnyFault]:
    """Requests that a server leaves unanswered for long."""
    return [fault for fault in TABLE if fault.name == "SDO unanswered" and name in fault.row]


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("name", ["then aborted"])
def test_a_server_that_does_not_answer_is_no_loss(name: str, share: float) -> None:
    tried: Counter[bool] = Counter()
    for fault in unanswered(name):
        for seed, case in enumerate(islice(fault.cases(), CASES)):
            tried[has(fault, Faulty(with_losses(case.faulty, share, seed), 1, 1), case.network)] += 1
    assert tried.total() > 0
    assert tried[True] >= FOUND * tried.total(), tried
