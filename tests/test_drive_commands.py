"""Commands that a drive does not follow (CiA 402), over states, magnitudes and the ways in which a statusword is sent.

Must not: test the words of a problem.
"""

from __future__ import annotations

import struct

import pytest
from captures import Row, log_text
from diagnoses import ABOVE_HARMLESS, diagnosed
from kinds_of_drives import DISABLED, ENABLED, FAULT, ON, READY
from kinds_of_nodes import NODE
from network import START, Frames, Network

DISABLE_VOLTAGE, QUICK_STOP, SHUT_DOWN, SWITCH_ON, ENABLE, RESET = 0x00, 0x02, 0x06, 0x07, 0x0F, 0x80
STEPS = ((DISABLE_VOLTAGE, DISABLED), (SHUT_DOWN, READY), (SWITCH_ON, ON), (ENABLE, ENABLED))
LOCAL = ~0x0200


def problems(frames: Frames) -> list[Row]:
    """Each root above harmless, but for faults that no EMCY announces."""
    said = diagnosed(log_text(frames))
    return [one for one in said.incidents if not one["cause"] and one["status"] in ABOVE_HARMLESS]


def commanded(
    steps: tuple[tuple[int, int], ...],
    command: int,
    after: float | None,
    state: int,
    *,
    cyclic: bool = True,
    heartbeat: bool = True,
    mask: int = 0xFFFF,
) -> Frames:
    """A drive that follows `steps`, and then a command, which leads to a state `after` some seconds or never.

    The statusword is sent each 0.1 s, or where it changes; the command is sent once, and the capture goes on for 12 s.
    """
    net = Network().boot(NODE).read(NODE, 0x1000, 0, 0x0002_0192, 4)
    net.set_pdo(NODE, 1, [(0x6041, 0, 16)], kind=255, event=100 if cyclic else 0)
    net.set_pdo(NODE, 1, [(0x6040, 0, 16)], transmit=False).nmt(START, NODE)
    begin = net.now
    changes = [(number * 0.3, word & mask) for number, (_, word) in enumerate(steps)]
    for number, (controlword, _) in enumerate(steps):
        net.send(0x200 + NODE, struct.pack("<H", controlword), after=number * 0.3)
    ordered = len(steps) * 0.3 + 1
    net.send(0x200 + NODE, struct.pack("<H", command), after=ordered)
    if after is not None:
        changes.append((ordered + after, state & mask))
    for place, (since, word) in enumerate(changes):
        until = changes[place + 1][0] if place + 1 < len(changes) else ordered + 12
        for tick in range(round((until - since) * 10) if cyclic else 1):
            net.send(0x180 + NODE, struct.pack("<H", word), after=since + 0.005 + tick * 0.1)
    if heartbeat:
        net.now = begin
        net.live(NODE, period=0.5, seconds=ordered + 11, states=((0, 5),))
    return net.frames()


WITHOUT_EFFECT = [
    (STEPS, SHUT_DOWN, READY),
    (STEPS, SWITCH_ON, ON),
    (STEPS, DISABLE_VOLTAGE, DISABLED),
    (STEPS[:3], ENABLE, ENABLED),
    (STEPS[:2], SWITCH_ON, ON),
    (STEPS[:1], SHUT_DOWN, READY),
]
"""Steps before, a command, and the state to which it leads."""


@pytest.mark.parametrize("cyclic", [True, False])
@pytest.mark.parametrize(("steps", "command", "state"), WITHOUT_EFFECT)
def test_a_command_that_is_not_followed(
    steps: tuple[tuple[int, int], ...], command: int, state: int, *, cyclic: bool
) -> None:
    (one,) = problems(commanded(steps, command, None, state, cyclic=cyclic))
    assert (one["problem"], one["status"], one["subject"]["node"]) == ("not-enabled", "open", NODE)
    for after in (0.01, 0.4, 0.9):
        assert problems(commanded(steps, command, after, state, cyclic=cyclic)) == []


@pytest.mark.parametrize("cyclic", [True, False])
@pytest.mark.parametrize("after", [1.5, 3.0, 4.5])
def test_a_drive_that_brakes_first(after: float, *, cyclic: bool) -> None:
    for command, state in ((SHUT_DOWN, READY), (SWITCH_ON, ON)):
        assert problems(commanded(STEPS, command, after, state, cyclic=cyclic)) == []


@pytest.mark.parametrize("cyclic", [True, False])
def test_a_reset_that_does_not_end_a_fault(*, cyclic: bool) -> None:
    faulty = (*STEPS, (ENABLE, FAULT))
    (one,) = problems(commanded(faulty, RESET, None, DISABLED, cyclic=cyclic))
    assert (one["problem"], one["status"], "reset_in_vain" in one["facts"]) == ("axis-fault", "open", True)
    (one,) = problems(commanded(faulty, RESET, 0.1, DISABLED, cyclic=cyclic))
    assert "reset_in_vain" not in one["facts"]


def test_a_drive_that_is_not_heard_any_more_is_not_judged() -> None:
    assert problems(commanded(STEPS, DISABLE_VOLTAGE, None, DISABLED, cyclic=False, heartbeat=False)) == []


def test_a_drive_that_is_operated_locally_is_not_judged() -> None:
    for cyclic in (True, False):
        assert problems(commanded(STEPS, SHUT_DOWN, None, READY, cyclic=cyclic, mask=LOCAL & 0xFFFF)) == []
