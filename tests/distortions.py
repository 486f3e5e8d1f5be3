"""What a recording does to clean traffic: a distortion lists frames otherwise than they were on the bus.

Why it exists: a tolerance is right only if it was tried over all its magnitudes, anywhere in a capture, and for every
service at once. What it must not do: change what was on the bus; only the frames' stamps, order and number in the
listing are changed, as an adapter, a driver or a recorder does it.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

from captures import CanFrame, console_text, log_text
from plants import Session

Frames = list[CanFrame]
Variant = tuple[str, bytes]
"""Where or how in the capture, and the capture's text."""
Apply = Callable[[Session], Iterator[Variant]]


@dataclass(frozen=True, slots=True)
class Distortion:
    """A cell's column: a kind, its magnitude, and the captures that it makes of a session."""

    kind: str
    magnitude: str
    apply: Apply
    allowed: tuple[str, ...] = ()
    """Codes that are true of such a capture."""
    form: str = "log"

    @property
    def name(self) -> str:
        return f"{self.kind} {self.magnitude}"


def places(length: int, count: int) -> list[int]:
    """Frames spread over a capture: the second, the last, and even steps between."""
    return sorted({min(1, length - 1), *(length * k // (count + 1) for k in range(1, count + 1)), length - 1})


def late_echo(session: Session, most_us: int, share: float, seed: int) -> Frames:
    """The host's own frames listed late, up to so much, in their order; stamps are those of the listing.

    Physical limit: none. What the host sends waits in one queue, so that later ones are not listed before it.
    """
    chance = random.Random(seed)
    listed: list[tuple[int, int, CanFrame]] = []
    last_own = 0
    for number, frame in enumerate(session.frames):
        at = frame.t_us
        if frame.remote or (frame.can_id in session.own and not frame.extended):
            if chance.random() < share:
                at += chance.randint(most_us * 6 // 10, most_us)
            at = last_own = max(at, last_own)
        listed.append((at, number, frame))
    return [replace(frame, t_us=at) for at, _, frame in sorted(listed, key=lambda one: one[:2])]


def late_rows(frames: Frames, most_us: int, share: float, seed: int) -> Frames:
    """Rows listed late, up to so much, with their true stamps, as a recorder does that empties its queues in turn."""
    chance = random.Random(seed)
    late = [chance.randint(most_us * 6 // 10, most_us) if chance.random() < share else 0 for _ in frames]
    listed = sorted((frame.t_us + by, number) for number, (frame, by) in enumerate(zip(frames, late, strict=True)))
    return [frames[number] for _, number in listed]


def of_two_clocks(session: Session, apart_us: int, *, merged: bool) -> Frames:
    """The host's own frames stamped by another clock; `merged`: two recordings were joined by these stamps."""
    start = max(0, -apart_us)
    listed: Frames = []
    for frame in session.frames:
        own = frame.remote or (frame.can_id in session.own and not frame.extended)
        listed.append(replace(frame, t_us=frame.t_us + start + (apart_us if own else 0)))
    return sorted(listed, key=lambda frame: frame.t_us) if merged else listed


def copied(session: Session, apart_us: int) -> Frames:
    """Every frame a second time, as of a second adapter on the bus."""
    both = [(f.t_us, n, f) for n, f in enumerate(session.frames)]
    both += [(f.t_us + apart_us, n, f) for n, f in enumerate(session.frames)]
    return [replace(frame, t_us=at) for at, _, frame in sorted(both, key=lambda one: one[:2])]


def stalled(frames: Frames, at: int, lasts_us: int, gap_us: int) -> Frames:
    """The recorder stands still from a frame on: what came meanwhile is stamped when it goes on.

    The frames of the burst are so far apart, and later ones too, until the real time is caught up.
    """
    end = frames[at].t_us + lasts_us
    new = frames[:at]
    next_us = end
    for frame in frames[at:]:
        stamp = max(frame.t_us, next_us)
        new.append(replace(frame, t_us=stamp))
        next_us = stamp + gap_us if stamp > frame.t_us else 0
    return new


def sender(frame: CanFrame) -> int | None:
    """The node that sends a frame when its time has come (0: SYNC); none: it is sent for a reason, or is an answer."""
    if frame.extended or frame.remote:
        return None
    if 0x101 <= frame.can_id <= 0x180:
        return (frame.can_id - 0xFF) // 2
    if 0x700 < frame.can_id < 0x780 and frame.data == b"\0":
        return None
    own_time = 0x80 <= frame.can_id < 0x580 or 0x700 < frame.can_id < 0x780
    return frame.can_id & 0x7F if own_time and frame.can_id != 0x100 else None


def looks_sent_late(late: Frames, gap_us: int) -> bool:
    """Whether what a stall has delayed may have been sent at the time of its stamps.

    Physical limit: that needs a frame that came again too soon, one of a second sender that is late by something else,
    or frames closer to each other than they can be on a bus. Frames of one node, each CAN-ID but for emergencies once,
    look as sent late.
    """
    timed = [frame for frame in late if sender(frame) is not None]
    again = Counter(frame.can_id for frame in timed if not 0x80 < frame.can_id < 0x100)
    once = all(count == 1 for count in again.values())
    return gap_us > CLOSEST_US and once and len({sender(frame) for frame in timed}) == 1


def awaited(frames: Frames, at: int, lasts_us: int) -> set[int]:
    """The nodes that send within so long after a frame, by CAN-IDs that came before."""
    begin = frames[at - 1].t_us
    before = {frame.can_id for frame in frames[:at]}
    soon = (frame for frame in frames[at:] if frame.t_us < begin + lasts_us and frame.can_id in before)
    return {node for frame in soon if (node := sender(frame)) is not None}


def floored(frames: Frames, unit_us: int) -> Frames:
    """Stamps of a coarse clock."""
    return [replace(frame, t_us=frame.t_us // unit_us * unit_us) for frame in frames]


def fetched(frames: Frames, every_us: int) -> Frames:
    """An adapter that is asked for its frames at certain times: each is stamped as it is taken out."""
    listed: Frames = []
    for frame in frames:
        at = -(-frame.t_us // every_us) * every_us
        listed.append(replace(frame, t_us=max(at, listed[-1].t_us + 2) if listed else at))
    return listed


def drifted(frames: Frames, parts_per_million: int) -> Frames:
    """Stamps of a clock that is fast or slow."""
    start = frames[0].t_us
    return [replace(frame, t_us=frame.t_us + (frame.t_us - start) * parts_per_million // 1_000_000) for frame in frames]


def with_loss_announced(frames: Frames, at: int, lasts_us: int) -> bytes:
    """A piece of time whose frames the socket dropped, as candump tells it."""
    kept = [frame for frame in frames[at:] if frame.t_us >= frames[at].t_us + lasts_us]
    lost = len(frames) - at - len(kept)
    counted = f"dropped {lost} CAN frame{'s' * (lost != 1)} on '{frames[0].bus}' socket (total drops {lost})"
    return log_text(frames[:at]) + f"DROPCOUNT: {counted}\n".encode() + log_text(kept)


def lost(frames: Frames, share: float, seed: int) -> Frames:
    """Frames are missing here and there, and nothing says so."""
    chance = random.Random(seed)
    return [frame for frame in frames if chance.random() >= share]


def holed(frames: Frames, at: int, missing_us: int, lasts_us: int) -> Frames:
    """The recorder was off for a time: frames are missing, and the stamps of those behind them are later."""
    begin = frames[at].t_us
    behind = [frame for frame in frames[at:] if frame.t_us >= begin + missing_us]
    return [*frames[:at], *(replace(frame, t_us=frame.t_us + lasts_us - missing_us) for frame in behind)]


def set_by(frames: Frames, at: int, step_us: int) -> Frames:
    """The clock of the stamps is set at a frame; none becomes negative."""
    start = max(0, -step_us)
    before = [replace(frame, t_us=frame.t_us + start) for frame in frames[:at]]
    return [*before, *(replace(frame, t_us=frame.t_us + start + step_us) for frame in frames[at:])]


def is_sdo(frame: CanFrame) -> bool:
    """Whether a frame is on the CAN-ID of a default SDO."""
    return 0x580 < frame.can_id < 0x680 and not frame.extended


FILTERS: dict[str, Callable[[CanFrame], bool]] = {
    "only error control": lambda frame: 0x700 < frame.can_id < 0x780,
    "only SDO requests": lambda frame: is_sdo(frame) and frame.can_id > 0x600,
    "only SDO responses": lambda frame: is_sdo(frame) and frame.can_id < 0x600,
    "only SDO": is_sdo,
    "only PDOs": lambda frame: 0x180 < frame.can_id < 0x580,
    "without NMT": lambda frame: frame.can_id != 0,
    "without SYNC": lambda frame: frame.can_id != 0x80,
    "without error control": lambda frame: not 0x700 < frame.can_id < 0x780,
}
"""What a filter of the recorder lets through."""


def _lost(share: float) -> Apply:
    """Physical limit: fewer than four missing frames may as well be faults of a node each."""

    def apply(session: Session) -> Iterator[Variant]:
        for seed in range(4):
            frames = lost(list(session.frames), share, seed)
            if len(session.frames) - len(frames) > 3:
                yield f"seed {seed}", log_text(frames)

    return apply


def _hole(lasts_us: int, missing_us: int) -> Apply:
    """Physical limit: where one node alone is awaited, its silence looks like a fault of that node."""

    def apply(session: Session) -> Iterator[Variant]:
        frames = list(session.frames)
        for at in places(len(frames), 8):
            inside = frames[at].t_us + missing_us < frames[-1].t_us
            if inside and len(awaited(frames, at, lasts_us)) > 1:
                yield f"from frame {at + 1}", log_text(holed(frames, at, missing_us, lasts_us))

    return apply


def _set(step_us: int) -> Apply:
    """Physical limit: where one node alone is awaited, a clock set forth looks like a silence of that node."""

    def apply(session: Session) -> Iterator[Variant]:
        frames = list(session.frames)
        for at in places(len(frames), 6):
            if step_us > 0 and len(awaited(frames, at, step_us)) < 2:
                continue
            yield f"at frame {at + 1}", log_text(set_by(frames, at, step_us))

    return apply


def _filtered(passes: Callable[[CanFrame], bool]) -> Apply:
    def apply(session: Session) -> Iterator[Variant]:
        frames = [frame for frame in session.frames if passes(frame)]
        if frames:
            yield "all", log_text(frames)

    return apply


def _one_node() -> Apply:
    """The CAN-IDs of one node in the pre-defined connection set, for each of them."""

    def apply(session: Session) -> Iterator[Variant]:
        for node in sorted({frame.can_id & 0x7F for frame in session.frames if 0x700 < frame.can_id < 0x780}):
            frames = [frame for frame in session.frames if frame.can_id > 0x80 and frame.can_id & 0x7F == node]
            yield f"node {node}", log_text(frames)

    return apply


def _echo(most_us: int, share: float) -> Apply:
    def apply(session: Session) -> Iterator[Variant]:
        for seed in range(3):
            yield f"seed {seed}", log_text(late_echo(session, most_us, share, seed))

    return apply


def _late(most_us: int, share: float) -> Apply:
    def apply(session: Session) -> Iterator[Variant]:
        for seed in range(2):
            yield f"seed {seed}", log_text(late_rows(list(session.frames), most_us, share, seed))

    return apply


def _clocks(apart_us: int) -> Apply:
    def apply(session: Session) -> Iterator[Variant]:
        yield "as they came", log_text(of_two_clocks(session, apart_us, merged=False))
        yield "by stamp", log_text(of_two_clocks(session, apart_us, merged=True))

    return apply


def _copies(apart_us: int) -> Apply:
    def apply(session: Session) -> Iterator[Variant]:
        yield "all", log_text(copied(session, apart_us))

    return apply


def _stall(lasts_us: int, gap_us: int) -> Apply:
    def apply(session: Session) -> Iterator[Variant]:
        frames = list(session.frames)
        for at in places(len(frames), 6):
            listed = stalled(frames, at, lasts_us, gap_us)
            late = [one for one, other in zip(frames, listed, strict=True) if one.t_us != other.t_us]
            # Physical limit: a lone frame that is stamped late looks as one that was sent late.
            if len(late) > 1 and not looks_sent_late(late, gap_us):
                yield f"from frame {at + 1}", log_text(listed)

    return apply


def _whole(change: Callable[[Frames], Frames], text: Callable[[Frames], bytes] = log_text) -> Apply:
    def apply(session: Session) -> Iterator[Variant]:
        yield "all", text(change(list(session.frames)))

    return apply


def _cut(prefix: bool, suffix: bool) -> Apply:
    """Begin, end or both missing. Also right before and after each NMT command, where states are known least."""

    def apply(session: Session) -> Iterator[Variant]:
        frames = list(session.frames)
        commands = [at for at, frame in enumerate(frames) if frame.can_id == 0 and not frame.extended]
        cuts = sorted({*places(len(frames), 24), *commands, *(at + 1 for at in commands)})
        for at in cuts:
            first = at if prefix and not suffix else at // 2 if prefix else 0
            last = at if suffix else len(frames)
            if first < last:
                yield f"frames {first + 1} to {last}", log_text(frames[first:last])

    return apply


def _loss(lasts_us: int) -> Apply:
    def apply(session: Session) -> Iterator[Variant]:
        frames = list(session.frames)
        for at in places(len(frames), 8):
            yield f"from frame {at + 1}", with_loss_announced(frames, at, lasts_us)

    return apply


def _pause(lasts_us: int) -> Apply:
    """The network stood still and went on, or its clock was put on: where least was going on, all of it is later.

    Physical limit: where one node alone is awaited, its silence looks like a fault of that node.
    """

    def apply(session: Session) -> Iterator[Variant]:
        frames = list(session.frames)
        gaps = sorted(range(1, len(frames)), key=lambda at: frames[at - 1].t_us - frames[at].t_us)
        for at in [at for at in gaps if len(awaited(frames, at, lasts_us)) != 1][:8]:
            later = [replace(frame, t_us=frame.t_us + lasts_us) for frame in frames[at:]]
            yield f"before frame {at + 1}", log_text([*frames[:at], *later])

    return apply


def shown(us: int) -> str:
    """A time for people."""
    if us >= 3_600_000_000:
        return f"{us / 3_600_000_000:g} h"
    return f"{us} us" if us < 1000 else f"{us / 1000:g} ms" if us < 1_000_000 else f"{us / 1_000_000:g} s"


def shown_signed(us: int) -> str:
    """The same with its sign."""
    return f"{'-' if us < 0 else '+'}{shown(abs(us))}"


ECHOES_US = (500, 1000, 2500, 3000, 5000, 8000)
LATE_US = (1000, 2000, 5000, 10_000)
CLOCKS_US = (10_000, -2000, -10_000, 3000)
COPIES_US = (1, 100, 800, 2000, 5000, 8000)
STALLS_US = (15_000, 30_000, 70_000, 100_000, 600_000, 800_000, 1_100_000, 5_000_000, 60_000_000)
BURSTS_US = (20, 200, 1000)
CLOSEST_US = 44
"""No frame follows another within less, at 1 Mbit/s."""
UNITS_US = (
    *(1, 10, 100, 1000, 2000, 4000, 5000, 8000, 10_000, 20_000, 50_000, 100_000, 200_000, 500_000),
    *(1_000_000, 2_000_000, 10_000_000),
)
FETCHED_US = (1000, 2000, 5000, 10_000, 16_000, 50_000, 100_000)
LOSSES_US = (10_000, 100_000, 1_000_000)
PAUSES_US = (1_000_000, 10_000_000, 60_000_000)
LOST_SHARES = (0.001, 0.003, 0.01, 0.03)
HOLES_US = ((400_000, 400_000), (3_000_000, 3_000_000), (60_000_000, 1_000_000), (3_600_000_000, 1_234_567))
"""How long the recorder was off, and how much of a session is missing."""
STEPS_US = (30_000, 1_000_000, 3_600_000_000, 86_400_000_000)
FAR_COPIES_US = (15_000, 30_000)

DISTORTIONS: list[Distortion] = [
    *(
        Distortion("echo", f"{shown(most)}, {share:.0%} of the own frames", _echo(most, share))
        for most in ECHOES_US
        for share in (0.1, 0.3, 1.0)
    ),
    *(
        Distortion("late rows", f"{shown(most)}, {share:.0%} of the rows", _late(most, share))
        for most in LATE_US
        for share in (0.05, 0.15, 0.3)
    ),
    *(Distortion("two clocks", f"{shown_signed(apart)} apart", _clocks(apart)) for apart in CLOCKS_US),
    *(Distortion("copies", f"{shown(apart)} apart", _copies(apart)) for apart in COPIES_US),
    *(
        Distortion("stall", f"{shown(lasts)}, burst of {shown(gap)}", _stall(lasts, gap))
        for lasts in STALLS_US
        for gap in BURSTS_US
    ),
    *(Distortion("resolution", shown(unit), _whole(partial(floored, unit_us=unit))) for unit in UNITS_US),
    *(Distortion("fetched", f"every {shown(every)}", _whole(partial(fetched, every_us=every))) for every in FETCHED_US),
    Distortion("stamps", "none", _whole(list, console_text), form="candump"),
    Distortion("drift", "+1 %", _whole(partial(drifted, parts_per_million=10_000))),
    Distortion("drift", "-1 %", _whole(partial(drifted, parts_per_million=-10_000))),
    Distortion("cut", "beginning", _cut(True, False)),
    Distortion("cut", "end", _cut(False, True)),
    Distortion("cut", "both", _cut(True, True)),
    *(Distortion("announced loss", shown(lasts), _loss(lasts), allowed=("CAP002",)) for lasts in LOSSES_US),
    *(Distortion("silent loss", f"{share:.1%}", _lost(share), allowed=("CAP009", "SDO024")) for share in LOST_SHARES),
    *(Distortion("hole", shown(lasts), _hole(lasts, missing), allowed=("CAP",)) for lasts, missing in HOLES_US),
    *(Distortion("clock set", f"back by {shown(step)}", _set(-step), allowed=("CAP006",)) for step in STEPS_US),
    *(Distortion("clock set", f"forth by {shown(step)}", _set(step), allowed=("CAP",)) for step in STEPS_US[1:]),
    Distortion("joined", "twice the same", _whole(lambda frames: [*frames, *frames]), allowed=("CAP006",)),
    *(Distortion("copies", f"{shown(apart)} apart", _copies(apart)) for apart in FAR_COPIES_US),
    *(Distortion("filter", name, _filtered(passes)) for name, passes in FILTERS.items()),
    Distortion("filter", "only one node", _one_node()),
    *(Distortion("pause", shown(lasts), _pause(lasts), allowed=("CAP",)) for lasts in PAUSES_US),
]
"""A pause may be said once more as a step of the clock."""
