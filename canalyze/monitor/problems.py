"""The view of problems in the order of `diagnose`: the most important first, each cause above its effects.

Open ones show their duration so far; harmless ones are folded to one row. Each leads to its first evidence. Must
not: judge, or sort again.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from canalyze.monitor.grid import BLANK, Cell, Column, Row, cell, period, texts
from canalyze.records.live import Node, NodeProblem, Problem, Snapshot
from canalyze.words import Words

FOLD: Final = "harmless"
"""The key of the row for the folded harmless problems."""
_LOOKS: Final = {"open": "error", "unknown": "warning", "ended": "good", "harmless": "dim"}
_OPEN: Final = ("open", "unknown")
"""Not ended, as far as is known."""
_LOUD: Final = ("A", "B")
"""Something has stopped, or does not start."""


def columns(words: Words, *, buses: bool) -> list[Column]:
    """Returns the columns; that of the bus only with several buses."""
    given = [
        Column(words("monitor.number"), right=True),
        Column(words("col.state"), least=6, most=12),
        Column(words("monitor.lasts"), most=9, right=True, leaves=2),
        Column(words("monitor.frame"), right=True, leaves=1),
        Column(words("monitor.problem"), least=30, most=400),
    ]
    return [given[0], Column(words("col.bus"), most=10), *given[1:]] if buses else given


def rows(snapshot: Snapshot, words: Words, *, buses: bool, unfolded: bool) -> list[Row]:
    """Returns one row per problem; unfolded: including the harmless ones."""
    found = snapshot.problems
    harmless = _harmless(found)
    shown = [_row(one, snapshot, words, buses=buses) for one in found if unfolded or one.id not in harmless]
    if not harmless:
        return shown
    place = next(place for place, one in enumerate(found) if one.id in harmless)
    key = "monitor.hide_harmless" if unfolded else "monitor.show_harmless"
    text = words(key, count=sum(one.id in harmless and not one.depth for one in found))
    cells = [(), (), (), (), cell(text, "dim")]
    fold = Row(FOLD, ((), *cells) if buses else tuple(cells), text)
    return [*shown[:place], fold, *shown[place:]]


def changing(snapshot: Snapshot) -> bool:
    """Returns true if rows change with time alone, because a problem has not ended."""
    return any(one.end_ns is None for one in snapshot.problems)


def open_roots(snapshot: Snapshot) -> list[Problem]:
    """Returns the root problems that are open, or whose status is not known yet."""
    roots = (one for one in snapshot.problems if not one.depth)
    return [one for one in roots if one.status == "open" or (one.status == "unknown" and one.provisional)]


def newest(snapshot: Snapshot) -> Cell:
    """Returns the number of open problems and the title of the newest one; empty if there are none."""
    found = open_roots(snapshot)
    if not found:
        return ()
    last = max(found, key=lambda one: (one.noticed, one.id))
    return ((f"✖{len(found)} ", "error"), (last.text + _mark(last), "error"))


def loud(snapshot: Snapshot) -> set[tuple[object, ...]]:
    """Returns identifiers of the problems that have stopped something, or keep it from starting."""
    found = (one for one in snapshot.problems if one.impact in _LOUD and one.status != "harmless")
    return {(one.bus, one.kind, one.frame) for one in found}


def of_node(node: Node) -> str:
    """Returns the word for the problem of a node, or ""."""
    one = node.problem
    return f"{one.word}{_mark(one)}" if one else ""


def _harmless(found: Sequence[Problem]) -> set[int]:
    """Returns the ids of the harmless problems and their effects."""
    under: set[int] = set()
    for one in found:
        if (one.status == "harmless" and not one.depth) or one.cause in under:
            under.add(one.id)
    return under


def _mark(one: Problem | NodeProblem) -> str:
    return "?" if one.provisional else ""


def _row(one: Problem, snapshot: Snapshot, words: Words, *, buses: bool) -> Row:
    status = _status(one, words)
    look = _LOOKS.get(one.status, "")
    told = f"{'  ' * (one.depth - 1)}→ {one.text}" if one.depth else one.text
    cells = [
        cell(one.id),
        cell(status, look),
        cell(_lasts(one, snapshot.now_ns)),
        cell(one.frame),
        (*cell(told, look if one.status in _OPEN else ""), *cell("".join(_cause(one, words)), "dim")),
    ]
    if buses:
        cells.insert(1, cell(one.bus))
    checks = words("diagnose.between").join(one.checks)
    caused = words("monitor.caused", number=one.cause) if one.cause is not None else ""
    whole = texts(
        [
            one.id,
            status,
            one.text + "".join(_cause(one, words)),
            caused,
            words("diagnose.check_first", said=checks) if checks else "",
        ]
    )
    return Row(one.id, tuple(cells), whole, leads=one.frame)


def _status(one: Problem, words: Words) -> str:
    """Returns the status in words; a provisional unknown status is shown as open."""
    known = "open" if one.provisional and one.status == "unknown" else one.status
    return words.of("problem_status", known) + _mark(one)


def _lasts(one: Problem, now: int | None) -> str:
    end = now if one.end_ns is None else one.end_ns
    if end is None or one.t_ns is None:
        return BLANK
    return period(max(0, end - one.t_ns))


def _cause(one: Problem, words: Words) -> Iterator[str]:
    """Yields the delay after its cause, and the confidence of that."""
    if one.cause_grade is None:
        return
    if one.delay_ns is not None and one.delay_ns >= 0:
        yield words("diagnose.after", ms=f"{one.delay_ns / 1e6:.0f}")
    yield f"  {words.of('problem_grade', one.cause_grade)}"
