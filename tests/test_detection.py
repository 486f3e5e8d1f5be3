"""How many faults are found: classes of faults by magnitude, over places in a capture and over what is known of it.

    python tests/test_detection.py [--write] [--show WORD]

A fault is found if exactly one finding above info that is no consequence of another stands at a frame of the fault, or
names one as its cause, and none is said beside it. `detection.json` has a row for each class and magnitude:

    cases    captures with this fault
    found    by exactly one finding
    noticed  by one finding at least, whatever is said beside it
    extra    findings above info beside the right one

Fractions may only rise: the test fails where a row is worse than the file, and where it is better and was not written.
`--write` writes what got better and refuses what got worse; with `--fall` it takes that, too, which needs a reason.
What it must not do: know why something is not found.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache

import pytest
from captures import TESTS, Row, log_text, session_output
from fault_table import NOTHING_WRONG, TABLE, AnyFault
from faulty_captures import POSITIONS, Faulty
from plants import EVERY, PLANTS, Known, built

from canalyze import _core

KEPT = TESTS / "detection.json"
Fractions = dict[str, int]
BETTER_HIGH = ("found", "noticed")


@cache
def expected(bit_rate: int | None) -> _core.Expectations | None:
    """Less than 90 % load, where a bit rate is known."""
    if bit_rate is None:
        return None
    return _core.Expectations(b"[[load]]\nmax_percent = 90\nbitrate = %d\n" % bit_rate, "load.expect.toml")


def findings(faulty: Faulty, network: _core.Network | None, bit_rate: int | None = None) -> list[Row]:
    """The findings above info that are no consequence of another."""
    text = log_text(faulty.frames)
    output = session_output([text], output_format="check", lang="en", network=network, expectations=expected(bit_rate))
    rows: list[Row] = [json.loads(line) for line in output.decode().splitlines()]
    return [row for row in rows if row["severity"] != "info" and row.get("because_of") is None]


def is_right(finding: Row, fault: AnyFault, faulty: Faulty) -> bool:
    """Whether a finding is about the fault."""
    about = [number for number in (finding["frame"], finding["cause_frame"]) if number is not None]
    here = any(faulty.first <= number <= faulty.last for number in about)
    return here and finding["code"].startswith(tuple(fault.codes.split()))


def cases(fault: AnyFault) -> Iterator[tuple[str, list[Row], list[Row]]]:
    """Each capture with the fault: its name, the right findings, and the others."""
    excused = tuple(fault.beside.split())
    for case in fault.cases():
        raised = findings(case.faulty, case.network, fault.bit_rate)
        right = [finding for finding in raised if is_right(finding, fault, case.faulty)]
        own = Counter(case.own)
        others = []
        for finding in (finding for finding in raised if finding not in right):
            key = finding["code"], finding["node"]
            own[key] -= 1
            if own[key] < 0 and not (excused and finding["code"].startswith(excused)):
                others.append(finding)
        yield f"{fault.row}, {case.where}", right, others


def measured(fault: AnyFault) -> Fractions:
    """A row of the table."""
    row = Counter({"cases": 0, "found": 0, "noticed": 0, "extra": 0})
    for _, right, others in cases(fault):
        row["cases"] += 1
        row["found"] += len(right) == 1 and not others
        row["noticed"] += bool(right)
        row["extra"] += max(len(right) - 1, 0) + len(others)
    return dict(row)


def kept() -> dict[str, Fractions]:
    """The table in the repository."""
    found: dict[str, Fractions] = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    return found


def worse(now: Fractions, before: Fractions) -> list[str]:
    """What fell: fewer of the cases found, or more said beside them."""
    fallen = [key for key in BETTER_HIGH if now[key] * before["cases"] < before[key] * now["cases"]]
    return fallen + ["extra"] * (now["extra"] * before["cases"] > before["extra"] * now["cases"])


@pytest.mark.parametrize("fault", TABLE, ids=lambda fault: fault.row)
def test_detection_only_rises(fault: AnyFault) -> None:
    before, now = kept()[fault.row], measured(fault)
    assert now == before, (
        f"{'fell' if worse(now, before) else 'rose; keep it with --write'}: {before} before, {now} now"
    )


def test_the_table_has_the_rows_of_today() -> None:
    assert list(kept()) == [fault.row for fault in TABLE]
    assert len({fault.row for fault in TABLE}) == len(TABLE)
    assert len(POSITIONS) >= 4


@pytest.mark.parametrize("known", EVERY)
@pytest.mark.parametrize("name", PLANTS)
def test_without_a_fault_nothing_is_said(name: str, known: Known) -> None:
    session = built(name, known)
    assert not findings(Faulty(list(session.frames), 1, 1), session.network)


@pytest.mark.parametrize("known", EVERY)
@pytest.mark.parametrize("name", NOTHING_WRONG)
def test_the_same_change_without_a_fault(name: str, known: Known) -> None:
    for where, at in POSITIONS.items():
        raised = findings(NOTHING_WRONG[name](known, at), built("plant", known).network)
        assert not raised, f"{where}: {[(f['code'], f['frame'], f['message']) for f in raised]}"


def show(fault: AnyFault) -> None:
    """Print what is said of each case of a row."""
    for name, right, others in cases(fault):
        print(f"{name}: {'found' if len(right) == 1 and not others else 'noticed' if right else 'missed'}")
        for mark, rows in (("right", right), ("extra", others)):
            for f in rows[:8]:
                print(f"    {mark} {f['code']} frame {f['frame']} cause {f['cause_frame']}: {f['message']}")


def main(arguments: list[str]) -> None:
    """Measure every row; show the cases of some, or write the table."""
    if "--show" in arguments:
        word = arguments[arguments.index("--show") + 1]
        for fault in TABLE:
            if word in fault.row:
                show(fault)
        return
    before = kept()
    table = {fault.row: measured(fault) for fault in TABLE}
    fallen = {row: worse(now, before[row]) for row, now in table.items() if row in before and worse(now, before[row])}
    for name in dict.fromkeys(fault.name for fault in TABLE):
        rows = Counter[str]()
        for fault in TABLE:
            rows.update(table[fault.row] if fault.name == name else {})
        print(f"{name}: {rows['found']} of {rows['cases']} found, {rows['noticed']} noticed, {rows['extra']} extra")
    for row, what in fallen.items():
        print(f"fell: {row}: {', '.join(what)}; {before[row]} before, {table[row]} now")
    if "--write" in arguments and (not fallen or "--fall" in arguments):
        lines = ",\n".join(f" {json.dumps(row)}: {json.dumps(numbers)}" for row, numbers in table.items())
        KEPT.write_text(f"{{\n{lines}\n}}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
