"""Changes of the recording itself, under which the bus did what it always does.

Why it exists: these faults belong to no node, so that no node may be blamed for them. What it must not do: know codes;
`test_changes.py` does.
"""

from __future__ import annotations

from dataclasses import replace
from random import Random

from faulty_captures import Faulty
from traffic import Traffic


def stamps_forward(traffic: Traffic, rng: Random, seconds: float) -> Faulty | None:
    """The clock of the recording is put on."""
    place = rng.randrange(len(traffic.frames) // 8, len(traffic.frames) * 7 // 8)
    later = round(seconds * 1_000_000)
    moved = [replace(frame, t_us=frame.t_us + later) for frame in traffic.frames[place:]]
    return Faulty([*traffic.frames[:place], *moved], max(1, place - 2), min(place + 6, len(traffic.frames)))
