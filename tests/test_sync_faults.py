"""Faults of SYNC and of what answers it, drawn at random: each is said once, and its harmless neighbours are not.

    python tests/test_sync_faults.py [--count N] [--show WORD]

The draw is fixed; CANALYZE_DRAW=NUMBER makes another. A fault is found if exactly one finding above info that is no
consequence stands at a frame of the fault, or names one as its cause, and none is said beside it. Each class has the
least share of its draws that must be found. What it must not do: know why something is not found.
"""

from __future__ import annotations

import os
import random
import sys
from collections.abc import Iterator
from functools import cache

import pytest
from captures import Row
from faulty_captures import Faulty
from sync_faults import HARMLESS, KINDS, Change, Draw, Kind
from sync_sessions import SyncRun, sync_runs
from test_detection import findings

DRAWN = int(os.environ.get("CANALYZE_DRAW", "1"))
NETWORKS = 12
COUNT = 60
"""Draws of each class."""


@cache
def runs() -> tuple[SyncRun, ...]:
    return sync_runs(tuple(range(DRAWN * 1000, DRAWN * 1000 + NETWORKS)))


def draws(name: str, draw: Draw, count: int) -> Iterator[tuple[SyncRun, Change]]:
    """So many changes of a class; runs without room for it are passed over."""
    chance = random.Random(f"{name} {DRAWN}")
    for _ in range(count):
        for _ in range(50):
            run = chance.choice(runs())
            change = draw(run, chance)
            if change is not None:
                yield run, change
                break


def is_about(finding: Row, codes: str, faulty: Faulty) -> bool:
    about = [number for number in (finding["frame"], finding["cause_frame"]) if number is not None]
    here = any(faulty.first <= number <= faulty.last for number in about)
    return here and finding["code"].startswith(tuple(codes.split()))


def judged(kind: Kind, count: int = COUNT) -> Iterator[tuple[Change, list[Row], list[Row]]]:
    """Each change of a class with the right findings and the others."""
    for run, change in draws(kind.name, kind.draw, count):
        raised = findings(change.faulty, run.network)
        right = [finding for finding in raised if is_about(finding, kind.codes, change.faulty)]
        yield change, right, [finding for finding in raised if finding not in right]


def is_found(right: list[Row], others: list[Row]) -> bool:
    return len(right) == 1 and not others


def listed(change: Change, right: list[Row], others: list[Row]) -> str:
    lines = [f"{change.what} (frames {change.faulty.first} to {change.faulty.last})"]
    for mark, rows in (("right", right), ("extra", others)):
        lines += [
            f"    {mark} {f['code']} frame {f['frame']} cause {f['cause_frame']}: {f['message']}" for f in rows[:6]
        ]
    return "\n".join(lines)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_fault_is_said_once(kind: Kind) -> None:
    results = list(judged(kind))
    wrong = [result for result in results if not is_found(*result[1:])]
    assert len(results) - len(wrong) >= kind.share * len(results), "\n".join(listed(*one) for one in wrong)


@pytest.mark.parametrize("name", HARMLESS)
def test_a_harmless_neighbour_raises_nothing(name: str) -> None:
    wrong = []
    for run, change in draws(name, HARMLESS[name], COUNT):
        raised = findings(change.faulty, run.network)
        if raised:
            wrong.append(listed(change, [], raised))
    assert not wrong, "\n".join(wrong)


def main(arguments: list[str]) -> None:
    """Measure every class; show what is not found of some."""
    count = int(arguments[arguments.index("--count") + 1]) if "--count" in arguments else COUNT
    word = arguments[arguments.index("--show") + 1] if "--show" in arguments else None
    for kind in KINDS:
        if word is not None and word not in kind.name:
            continue
        results = list(judged(kind, count))
        found = sum(is_found(right, others) for _, right, others in results)
        noticed = sum(bool(right) for _, right, _ in results)
        extra = sum(max(len(right) - 1, 0) + len(others) for _, right, others in results)
        share = found / max(len(results), 1)
        print(f"{kind.name}: {found} of {len(results)} found ({share:.1%}), {noticed} noticed, {extra} extra")
        if word is not None:
            print("\n".join(listed(*one) for one in results if not is_found(*one[1:])))
    for name, draw in HARMLESS.items():
        if word is not None and word not in name:
            continue
        drawn = [(change, findings(change.faulty, run.network)) for run, change in draws(name, draw, count)]
        alarms = [(change, raised) for change, raised in drawn if raised]
        print(f"harmless {name}: {len(alarms)} of {len(drawn)} with a finding")
        if word is not None:
            print("\n".join(listed(change, [], raised) for change, raised in alarms))


if __name__ == "__main__":
    main(sys.argv[1:])
