"""SDO transfers that their client leaves without an abort (SDO026), at each step and after each time.

Beside them those that it does not leave. The client is the next to send: a request that is not answered is the
server's. What ends in time, is aborted, or is cut by the end of the capture is not left.
"""

from __future__ import annotations

import pytest
from captures import analyze
from test_neighbouring_verdicts import Frames, beats, log

READ = ["605#4008100000000000", "585#410810001E000000"]
for number in range(4):
    toggle, last = number % 2 * 0x10, number == 3
    READ += [f"605#{0x60 + toggle:02X}00000000000000", f"585#{toggle + last:02X}41424344454647"]
READ[1] = "585#410810001C000000"
WRITE = ["605#210020001C000000", "585#6000200000000000"]
for number in range(4):
    toggle, last = number % 2 * 0x10, number == 3
    WRITE += [f"605#{toggle + last:02X}41424344454647", f"585#{0x20 + toggle:02X}00000000000000"]
BLOCK = ["605#C20020001C000000", "585#A000200004000000"]
BLOCK += [f"605#{number + 0x80 * (number == 4):02X}41424344454647" for number in range(1, 5)]
BLOCK += ["585#A204040000000000", "605#C100000000000000", "585#A100000000000000"]
BLOCK_READ = ["605#A000200004000000", "585#C20020001C000000", "605#A300000000000000"]
BLOCK_READ += [f"585#{number + 0x80 * (number == 4):02X}41424344454647" for number in range(1, 5)]
BLOCK_READ += ["605#A204040000000000", "585#C100000000000000", "605#A100000000000000"]
BEFORE: Frames = [(0.1, "605#4000100000000000"), (0.101, "585#4300100092010000")]


def left(frames: list[str], after: float, more: Frames | None = None) -> bool:
    """Returns true if SDO026 is raised for these frames, where the capture goes on for a time in s."""
    rows: Frames = [(1.0 + place / 1000, frame) for place, frame in enumerate(frames)]
    said = analyze(log(BEFORE, rows, more or [], beats(5, 0.1, 1.0 + after))).findings
    return any(one["code"] == "SDO026" for one in said)


STEPS = [(frames, step) for frames in (READ, WRITE, BLOCK, BLOCK_READ) for step in range(2, len(frames))]
STEPS.remove((BLOCK_READ, len(BLOCK_READ) - 1))  # an end that is not confirmed is SDO012


@pytest.mark.parametrize(("frames", "step"), STEPS)
@pytest.mark.parametrize("after", [6.0, 60.0])
def test_a_client_that_stops(frames: list[str], step: int, after: float) -> None:
    client_is_next = frames[step].startswith("605")
    assert left(frames[:step], after) is client_is_next
    # It may go on later, as far as the capture shows.
    assert not left(frames[:step], 4.5)
    abort = f"605#80{frames[0][6:12]}00000008"
    assert not left([*frames[:step], abort], after)
    # It asks for something else: SDO008.
    assert not left(frames[:step], after, [(3.0, "605#4000100000000000"), (3.001, "585#4300100092010000")])
    # The server boots.
    assert not left(frames[:step], after, [(2.0, "705#00")])


@pytest.mark.parametrize("frames", [READ, WRITE, BLOCK, BLOCK_READ])
def test_a_transfer_that_ends(frames: list[str]) -> None:
    assert not left(frames, 60.0)
