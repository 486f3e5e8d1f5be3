"""Changes of requests and answers, in SDO and LSS: one that is missing, one that comes twice.

Why it exists: these faults are about pairs of frames, and are visible only where nothing else runs between the two.
What it must not do: know codes; `test_changes.py` does.
"""

from __future__ import annotations

from dataclasses import replace
from random import Random

from faulty_captures import Faulty
from network import STOP
from traffic import MS, RESETS, Traffic, chosen

# SDO


def sdo_no_answer(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """An expedited transfer without its answer; the client asks this node nothing for a second, or to the end."""
    found = []
    for request, answer, node in traffic.exchanges:
        asked = traffic.frames[request]
        # What a write without answer leaves unknown is another matter.
        if asked.data[0] == 0x40 and traffic.end_us - asked.t_us > 1300 * MS:
            found.append((request, answer, node))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    request, answer, _ = drawn
    at = traffic.frames[request].t_us
    frames = [*traffic.frames[:answer], *traffic.frames[answer + 1 :]]
    return traffic.faulty(frames, at, at)


def unanswered_before_reset(traffic: Traffic, rng: Random, milliseconds: float) -> Faulty | None:
    """A read without answer, and so long after it a reset of its node, or of all."""
    found = []
    answering = {node for _, _, node in traffic.exchanges}
    for at, cs, to in traffic.commands:
        since = at - round(milliseconds * MS)
        if cs not in RESETS:
            continue
        for node in [to] if to else sorted(answering):
            busy = any(
                since - 20 * MS < when < at
                for can_id in (0x600 + node, 0x580 + node)
                for when in traffic.times.get(can_id, [])
            )
            stopped = [c for w, c, t in traffic.commands if w < since and t in (0, node)][-1:] == [STOP]
            gone = traffic.commanded(node, since, at - 1)
            heard = [b for b in traffic.times.get(0x700 + node, []) if b < since]
            if node in answering and not busy and not stopped and not gone and heard:
                found.append((node, since))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    node, since = drawn
    request = traffic.frame(0x600 + node, b"\x40\x01\x20\x00\0\0\0\0", since)
    return traffic.faulty([*traffic.frames, request], since, since)


def request_repeated(traffic: Traffic, rng: Random, milliseconds: float) -> Faulty | None:
    """A client that sends its request once more, so long after the answer; the server answers once."""
    return twin(traffic, rng, milliseconds, request=True)


def answer_repeated(traffic: Traffic, rng: Random, milliseconds: float) -> Faulty | None:
    """A server that sends its answer once more, so long after it."""
    return twin(traffic, rng, milliseconds, request=False)


def twin(traffic: Traffic, rng: Random, milliseconds: float, *, request: bool) -> Faulty | None:
    later = round(milliseconds * MS)
    found = []
    for asked, answered, node in traffic.exchanges:
        at = traffic.frames[answered].t_us
        channel = sorted(traffic.times[0x600 + node] + traffic.times[0x580 + node])
        following = [when for when in channel if when > at]
        free = not following or following[0] > at + later + MS
        # A request without answer at the end of a capture may be answered after it.
        ends = following[0] < traffic.end_us if following else traffic.end_us - at > 1500 * MS + later
        if free and (ends or not request):
            found.append((asked, answered))
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    asked, answered = drawn
    at = traffic.frames[answered].t_us
    again = replace(traffic.frames[asked if request else answered], t_us=at + later)
    return traffic.faulty([*traffic.frames, again], traffic.frames[asked].t_us, at + later)


# LSS

ANSWERED = {0x43: 0x44, 0x11: 0x11, 0x13: 0x13, 0x17: 0x17, 0x5A: 0x5A, 0x5B: 0x5B, 0x5C: 0x5C, 0x5D: 0x5D, 0x5E: 0x5E}
"""Requests of an LSS master that one slave answers, with the command of the answer."""


def lss_no_answer(traffic: Traffic, rng: Random, _: float) -> Faulty | None:
    """An LSS request to one slave without its answer."""
    found = []
    asked: int | None = None
    for place, frame in enumerate(traffic.frames):
        if frame.can_id == 0x7E5:
            asked = place
        elif frame.can_id == 0x7E4 and asked is not None:
            if ANSWERED.get(traffic.frames[asked].data[0]) == frame.data[0]:
                found.append((asked, place))
            asked = None
    drawn = chosen(rng, found)
    if drawn is None:
        return None
    request, answer = drawn
    frames = [*traffic.frames[:answer], *traffic.frames[answer + 1 :]]
    at = traffic.frames[request].t_us
    if traffic.end_us - at < 1100 * MS:
        return None
    return traffic.faulty(frames, at, at)
