"""Single changes of a SYNC and of the PDOs that answer it, drawn at random: faults by class, and what is none.

Why it exists: a fault that is found at one magnitude in one network says little about the next. What it must not do:
know what the program says of them; `test_sync_faults.py` does. Times are microseconds.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, replace

from captures import CanFrame
from distortions import Frames, late_echo, looks_sent_late, stalled
from faulty_captures import Faulty
from plants import as_made
from sync_sessions import SYNC, Answering, SyncRun, Tick, renumbered

LEAD, TAIL = 9, 6
"""Least number of SYNCs before and after a change."""


@dataclass(frozen=True, slots=True)
class Change:
    """A changed capture, the frames that the change is about, and its magnitude in words."""

    what: str
    faulty: Faulty


Draw = Callable[[SyncRun, random.Random], Change | None]
"""A change of a run; none where the run has no room for it."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A class of changes, with the beginnings of the codes that are right."""

    name: str
    codes: str
    draw: Draw
    share: float
    """The least share found by exactly one finding above info."""


def _about(frames: Frames, first_us: int, last_us: int) -> Faulty:
    numbers = [number for number, frame in enumerate(frames, 1) if first_us <= frame.t_us <= last_us]
    return Faulty(frames, numbers[0], numbers[-1])


def _place(run: SyncRun, chance: random.Random, lasts: int) -> int | None:
    """The number of the first SYNC of a change that lasts so many SYNCs."""
    last = len(run.syncs) - TAIL - lasts
    return chance.randint(LEAD, last) if last >= LEAD else None


def _shifted(ticks: list[Tick], at: int, gap_of: Callable[[int], int], count: int) -> list[Tick]:
    """Other gaps before so many SYNCs from one on; all later ones move with them."""
    new, moved = ticks[:at], 0
    for number in range(at, len(ticks)):
        if number < at + count:
            moved += gap_of(number) - (ticks[number].t_us - ticks[number - 1].t_us)
        new.append(replace(ticks[number], t_us=ticks[number].t_us + moved))
    return new


def _of_ticks(run: SyncRun, ticks: list[Tick], at: int, until: int, what: str) -> Change | None:
    """A change of the SYNCs from one to another."""
    frames = run.frames(ticks)
    first = ticks[at - 1].t_us
    if until + 3 >= len(ticks) or ticks[until + 3].t_us > frames[-1].t_us:
        return None
    return Change(f"{run.name}, SYNC {at}: {what}", _about(frames, first, ticks[until].t_us + 1))


def period(ratios: tuple[float, ...]) -> Draw:
    """Another period for some cycles."""

    def draw(run: SyncRun, chance: random.Random) -> Change | None:
        count, ratio = chance.choice((8, 10, 30, 60)), chance.choice(ratios)
        at = _place(run, chance, count)
        if at is None:
            return None
        gap_us = round(run.period_us * ratio)
        ticks = _shifted(run.ticks(), at, lambda _: gap_us, count)
        return _of_ticks(run, ticks, at, at + count, f"{ratio} periods {count} times")

    return draw


def late_once(run: SyncRun, chance: random.Random) -> Change | None:
    """One SYNC late, and the next ones as well, since none was sent in the meantime."""
    at = _place(run, chance, 2)
    if at is None:
        return None
    ticks = run.ticks()
    late = chance.choice((0.6, 0.7, 0.9, 1.3, 1.6, 2.5, 5.0, 15.0))
    new = _shifted(ticks, at, lambda _: round((1 + late) * run.period_us), 1)
    return _of_ticks(run, new, at, at + 1, f"{late} periods late, the next as well")


def late_alone(run: SyncRun, chance: random.Random) -> Change | None:
    """One SYNC late, the next ones at their times, and something else in between: no recorder stood still."""
    at = _place(run, chance, 2)
    if at is None or not run.knows_types:
        return None
    ticks, late = run.ticks(), chance.uniform(0.6, 0.85)
    moved = replace(ticks[at], t_us=ticks[at].t_us + round(late * run.period_us))
    change = _of_ticks(run, [*ticks[:at], moved, *ticks[at + 1 :]], at, at + 1, f"{late:.2f} periods late alone")
    # Physical limit: it shows that the recorder did not stand still only where it comes after SYNC was due.
    between = range(ticks[at].t_us + run.period_us // 10, moved.t_us - 100)
    return change if any(frame.t_us in between for frame in run.before) else None


def skipped(run: SyncRun, chance: random.Random) -> Change | None:
    """Some SYNCs that were not sent, and are not counted."""
    count = chance.choice((1, 2, 3, 5, 10))
    at = _place(run, chance, count)
    if at is None:
        return None
    ticks = run.ticks()
    new = [replace(tick, sent=not at <= number < at + count) for number, tick in enumerate(ticks)]
    new = renumbered(new, run.overflow)
    return _of_ticks(run, new, at, at + count, f"{count} not sent")


def lost(*, answered: bool) -> Draw:
    """Some SYNCs that the nodes had and the capture has not, or that were lost before the nodes."""

    def draw(run: SyncRun, chance: random.Random) -> Change | None:
        count = chance.choice((1, 2, 3, 5, 10))
        at = _place(run, chance, count)
        if at is None or (answered and not run.answering):
            return None
        ticks = run.ticks()
        new = [
            replace(tick, shown=False, heard=answered) if at <= number < at + count else tick
            for number, tick in enumerate(ticks)
        ]
        return _of_ticks(run, new, at, at + count, f"{count} lost{', but answered' if answered else ''}")

    return draw


def unsteady(parts: tuple[float, ...]) -> Draw:
    """SYNCs early and late in turns, or by chance, for some cycles."""

    def draw(run: SyncRun, chance: random.Random) -> Change | None:
        count, part = chance.choice((20, 30, 40)), chance.choice(parts)
        count = min(count, len(run.syncs) - TAIL - LEAD - 1)
        at = _place(run, chance, count)
        # Physical limit: without an answer to it, it may as well be its listing that is unsteady.
        if at is None or count < 20 or not run.answering:
            return None
        ticks, turns = run.ticks(), chance.random() < 0.5
        new = list(ticks)
        for number in range(at, at + count):
            off = part * (1 if number % 2 else -1) / 2 if turns else chance.uniform(-part, part)
            new[number] = replace(ticks[number], t_us=ticks[number].t_us + round(off * run.period_us))
        how = "in turns" if turns else "by chance"
        return _of_ticks(run, new, at, at + count, f"{part} of the period off {how}, {count} times")

    return draw


def stops(run: SyncRun, chance: random.Random) -> Change | None:
    """No SYNC any more, while the nodes go on."""
    at = _place(run, chance, 0)
    if at is None:
        return None
    ticks = run.ticks()
    least_us = max(20 * run.period_us, 300_000)
    if run.end_us - ticks[at - 1].t_us < least_us:
        return None
    frames = [frame for frame in run.frames(ticks[:at]) if frame.t_us <= run.end_us]
    rest = [f for f in run.before if f.t_us > frames[-1].t_us]
    alive = [f.t_us for f in rest if f.t_us - ticks[at - 1].t_us > least_us and f.can_id > 0x700]
    # Physical limit: the first frame after a silence does not show that the bus goes on without SYNC.
    if not alive or alive[-1] - alive[0] < 3 * run.period_us:
        return None
    frames = sorted([*frames, *rest], key=lambda frame: frame.t_us)
    return Change(f"{run.name}, SYNC {at}: no more", _about(frames, ticks[at - 1].t_us, run.end_us))


def extra(run: SyncRun, chance: random.Random) -> Change | None:
    """One SYNC more, anywhere between two."""
    at = _place(run, chance, 1)
    if at is None:
        return None
    ticks = run.ticks()
    part = chance.uniform(0.15, 0.85)
    again = replace(ticks[at - 1], t_us=ticks[at - 1].t_us + round(part * run.period_us), heard=False)
    new = [*ticks[:at], again, *ticks[at:]]
    return _of_ticks(run, new, at, at + 1, f"one more after {part:.2f} periods")


def two_producers(run: SyncRun, chance: random.Random) -> Change | None:
    """Another producer beside the first, with a counter of its own, that the nodes do not answer."""
    count = chance.choice((12, 30, 60))
    at = _place(run, chance, count)
    if at is None:
        return None
    phase, ratio = chance.choice((0.1, 0.25, 0.4, 0.5, 0.7, 0.9)), chance.choice((1.0, 1.0, 1.3))
    frames, ticks = run.frames(), run.ticks()
    first = ticks[at].t_us + round(phase * run.period_us)
    value = chance.randint(1, max(run.overflow, 1))
    added: Frames = []
    while (t_us := first + round(len(added) * ratio * run.period_us)) <= ticks[at + count].t_us:
        data = bytes([(value + len(added)) % run.overflow + 1]) if run.overflow else b""
        added.append(replace(run.syncs[0], t_us=t_us, data=data))
    frames = sorted([*frames, *added], key=lambda frame: frame.t_us)
    return Change(
        f"{run.name}, SYNC {at}: another at phase {phase}, period x {ratio}, {count} times",
        _about(frames, ticks[at - 1].t_us, ticks[at + count].t_us + run.period_us),
    )


def _answer(run: SyncRun, chance: random.Random, lasts: int, least_every: int = 1) -> tuple[Answering, int] | None:
    """A PDO and the number of one of its frames, with room for so many more."""
    fitting = [one for one in run.answering if one.every >= least_every and one.can_id & 0x80]
    fitting = [one for one in fitting if len(one.frames) - 3 - lasts >= 4]
    if not fitting or not run.knows_types:
        return None
    one = chance.choice(fitting)
    return one, chance.randint(4, len(one.frames) - 3 - lasts)


def _sync_of(run: SyncRun, one: Answering, number: int) -> CanFrame:
    return run.syncs[one.first + number * one.every]


def _of_pdo(run: SyncRun, new: dict[int, CanFrame | None], since: int, until: int, what: str) -> Change:
    """Frames in the place of others, by their identity; the change is about a time and its ends."""
    frames = [new.get(id(frame), frame) for frame in _unmoved(run)]
    kept = sorted((frame for frame in frames if frame is not None), key=lambda frame: frame.t_us)
    return Change(f"{run.name}, {what}", _about(kept, since, until))


def _unmoved(run: SyncRun) -> Frames:
    """The capture as it is, with the frames of the session themselves."""
    frames = [*run.before, *run.syncs, *(frame for one in run.answering for frame in one.frames)]
    return sorted(frames, key=lambda frame: frame.t_us)


def window(run: SyncRun, chance: random.Random) -> Change | None:
    """A PDO after the window of its SYNC, and before the next."""
    if run.knows_window_us is None or run.knows_window_us > run.period_us * 0.6:
        return None
    found = _answer(run, chance, 0)
    if found is None:
        return None
    one, number = found
    part = chance.uniform(0.15, 0.85)
    delay_us = round(run.knows_window_us + part * (run.period_us - run.knows_window_us))
    sync, frame = _sync_of(run, one, number), one.frames[number]
    new: dict[int, CanFrame | None] = {id(frame): replace(frame, t_us=sync.t_us + delay_us)}
    what = f"{one.can_id:X}h {delay_us} us after SYNC, window {run.knows_window_us} us of {run.period_us} us"
    return _of_pdo(run, new, sync.t_us, sync.t_us + delay_us, what)


def missing(run: SyncRun, chance: random.Random) -> Change | None:
    """Some frames of a PDO that did not come."""
    count = chance.choice((1, 2, 3, 5, 10))
    found = _answer(run, chance, count)
    if found is None:
        return None
    one, number = found
    new: dict[int, CanFrame | None] = {id(frame): None for frame in one.frames[number : number + count]}
    since, until = one.frames[number - 1].t_us, one.frames[number + count].t_us
    return _of_pdo(run, new, since, until, f"{one.can_id:X}h of every {one.every}: {count} missing at {number}")


def wrong_cycle(run: SyncRun, chance: random.Random) -> Change | None:
    """A PDO of a later SYNC, or of an earlier one, than its type asks for."""
    found = _answer(run, chance, 1, least_every=2)
    if found is None:
        return None
    one, number = found
    frame = one.frames[number]
    by = chance.choice((-1, 1))
    sync = run.syncs[one.first + number * one.every + by]
    moved = replace(frame, t_us=sync.t_us + one.delays_us[number])
    since, until = one.frames[number - 1].t_us, one.frames[number + 1].t_us
    return _of_pdo(run, {id(frame): moved}, since, until, f"{one.can_id:X}h of every {one.every}: {by:+} at {number}")


def twice(run: SyncRun, chance: random.Random) -> Change | None:
    """A PDO twice in its cycle."""
    found = _answer(run, chance, 0)
    if found is None:
        return None
    one, number = found
    frame = one.frames[number]
    data = bytes(byte ^ 1 for byte in frame.data)
    if run.knows_window_us is None:
        return None
    delay_us = (run.knows_window_us - one.delays_us[number]) * chance.uniform(0.2, 0.8)
    again = replace(frame, t_us=frame.t_us + round(delay_us), data=data)
    frames = sorted([*_unmoved(run), again], key=lambda one: one.t_us)
    return Change(f"{run.name}, {one.can_id:X}h twice at {number}", _about(frames, frame.t_us - 1, again.t_us))


KINDS = (
    Kind("sync-period", "SYN003", period((0.5, 0.7, 0.8, 1.2, 1.25, 1.5, 2.0, 3.0)), 0.99),
    Kind("sync-period, small", "SYN003", period((0.9, 0.95, 1.05, 1.1)), 0.85),
    Kind("sync-late-once", "SYN003", late_once, 0.99),
    Kind("sync-late-alone", "SYN003", late_alone, 0.75),
    Kind("sync-skipped", "SYN002 SYN003", skipped, 0.99),
    Kind("sync-lost", "SYN002 SYN003", lost(answered=False), 0.99),
    Kind("sync-lost, answered", "SYN002 SYN003", lost(answered=True), 0.99),
    Kind("sync-jitter", "SYN003", unsteady((0.3, 0.4, 0.45)), 0.85),
    Kind("sync-jitter, small", "SYN003", unsteady((0.15, 0.2)), 0.8),
    Kind("sync-stops", "SYN013", stops, 0.9),
    Kind("sync-extra", "SYN002 SYN003", extra, 0.99),
    Kind("two producers", "SYN003 SYN006", two_producers, 0.99),
    Kind("pdo-window", "SYN004", window, 0.99),
    Kind("pdo-sync-missing", "SYN008", missing, 0.99),
    Kind("pdo-wrong-cycle", "SYN008 SYN009 SYN010", wrong_cycle, 0.99),
    Kind("pdo-twice", "SYN009", twice, 0.95),
)


def slight(run: SyncRun, chance: random.Random) -> Change:
    """SYNCs early or late by some percent of the period, each anew."""
    part = chance.uniform(0.01, 0.03)
    ticks = [replace(t, t_us=t.t_us + round(chance.uniform(-part, part) * run.period_us)) for t in run.ticks()]
    return Change(f"{run.name}: jitter of {part:.1%}", Faulty(run.frames(ticks), 1, 1))


def recorder_stalls(run: SyncRun, chance: random.Random) -> Change | None:
    """The recorder stands still once."""
    frames = run.frames()
    lasts_us = round(10 ** chance.uniform(4.1, 6.7))
    gap_us = chance.choice((20, 100, 200, 500, 1000))
    at = chance.randrange(1, len(frames))
    listed = stalled(frames, at, lasts_us, gap_us)
    late = [one for one, other in zip(frames, listed, strict=True) if one.t_us != other.t_us]
    if len(late) < 2 or looks_sent_late(late, gap_us):
        return None
    # Physical limit: a buffer that empties hardly faster than it fills looks like traffic.
    if gap_us * (1 + len(run.answering)) * 3 > run.period_us:
        return None
    return Change(f"{run.name}: stall of {lasts_us} us at frame {at + 1}, then every {gap_us} us", Faulty(listed, 1, 1))


def network_pauses(run: SyncRun, chance: random.Random) -> Change:
    """Everything stands still, and goes on as it was."""
    frames = run.frames()
    by_us = round(10 ** chance.uniform(6, 7.5))
    at = max(range(1, len(frames)), key=lambda at: frames[at].t_us - frames[at - 1].t_us + chance.random())
    return Change(
        f"{run.name}: {by_us} us pass before frame {at + 1}",
        Faulty([*frames[:at], *(replace(frame, t_us=frame.t_us + by_us) for frame in frames[at:])], 1, 1),
    )


def echoes_late(run: SyncRun, chance: random.Random) -> Change:
    """What the host itself sends is listed late."""
    most_us, share = chance.choice((500, 1000, 2500, 5000, 8000)), chance.choice((0.1, 0.3, 1.0))
    most_us = min(most_us, run.period_us * 8 // 10)
    session = as_made(run.frames(), run.own)
    frames = late_echo(session, most_us, share, chance.randrange(1000))
    return Change(f"{run.name}: {share:.0%} of its own frames up to {most_us} us late", Faulty(frames, 1, 1))


HARMLESS: dict[str, Draw] = {
    "jitter": slight,
    "stall": recorder_stalls,
    "echo": echoes_late,
    "nothing": lambda run, _: Change(run.name, Faulty(run.frames(), 1, 1)),
}
assert SYNC == 0x80
