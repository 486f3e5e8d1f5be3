"""The room of problems, as `diagnose` orders them: what stands first, each cause above what it has caused.

Standing ones show for how long by now; harmless ones are one row until they are asked for. Each leads to its first
evidence. Must not: judge, or order anew.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from canalyze.monitor.figures import BLANK, period
from canalyze.monitor.grid import Cell, Column, Row, cell, texts
from canalyze.words import Words

FOLD: Final = "harmless"
"""The key of the row that stands for the harmless ones."""
_LOOKS: Final = {"open": "error", "unknown": "warning", "ended": "good", "harmless": "dim"}
_OPEN: Final = ("open", "unknown")
"""Not over, as far as is known."""
_LOUD: Final = ("A", "B")
"""Something has stopped, or does not start."""

Incident = Mapping[str, Any]


def columns(words: Words, *, buses: bool) -> list[Column]:
    """Give the columns; that of the bus only where there are several."""
    given = [
        Column(words("monitor.number"), right=True),
        Column(words("col.state"), least=6, most=12),
        Column(words("monitor.lasts"), most=9, right=True, leaves=2),
        Column(words("monitor.frame"), right=True, leaves=1),
        Column(words("monitor.problem"), least=30, most=400),
    ]
    return [given[0], Column(words("col.bus"), most=10), *given[1:]] if buses else given


def rows(snapshot: dict[str, Any], words: Words, *, buses: bool, unfolded: bool) -> list[Row]:
    """Give a row a problem; unfolded: the harmless ones have rows, too."""
    found = snapshot["problems"]
    harmless = _harmless(found)
    shown = [_row(one, snapshot, words, buses=buses) for one in found if unfolded or one["id"] not in harmless]
    if not harmless:
        return shown
    place = next(place for place, one in enumerate(found) if one["id"] in harmless)
    key = "monitor.hide_harmless" if unfolded else "monitor.show_harmless"
    text = words(key, count=sum(one["id"] in harmless and not one["depth"] for one in found))
    cells = [(), (), (), (), cell(text, "dim")]
    fold = Row(FOLD, ((), *cells) if buses else tuple(cells), text)
    return [*shown[:place], fold, *shown[place:]]


def changing(snapshot: dict[str, Any]) -> bool:
    """Tell whether time alone changes the rows: something is not over."""
    return any(one["end_ns"] is None for one in snapshot["problems"])


def standing(snapshot: dict[str, Any]) -> list[Incident]:
    """Give the roots that are not over: those that stand, and those of which that may still turn out."""
    roots = (one for one in snapshot["problems"] if not one["depth"])
    return [one for one in roots if one["status"] == "open" or (one["status"] == "unknown" and one["provisional"])]


def newest(snapshot: dict[str, Any]) -> Cell:
    """Give how many stand and the title of the one that was noticed last; nothing where none does."""
    found = standing(snapshot)
    if not found:
        return ()
    last = max(found, key=lambda one: (one["noticed"], one["id"]))
    return ((f"✖{len(found)} ", "error"), (last["text"] + _mark(last), "error"))


def loud(snapshot: dict[str, Any]) -> set[tuple[object, ...]]:
    """Give what tells those apart that have stopped something, or keep it from starting."""
    found = (one for one in snapshot["problems"] if one["impact"] in _LOUD and one["status"] != "harmless")
    return {(one["bus"], one["kind"], one["frame"]) for one in found}


def of_node(node: dict[str, Any]) -> str:
    """Give the word of the problem of a node; "" where it has none."""
    one = node.get("problem")
    return f"{one['word']}{_mark(one)}" if one else ""


def _harmless(found: Sequence[Incident]) -> set[int]:
    """Give the numbers of what is harmless, and of what follows from it."""
    under: set[int] = set()
    for one in found:
        if (one["status"] == "harmless" and not one["depth"]) or one["cause"] in under:
            under.add(one["id"])
    return under


def _mark(one: Incident) -> str:
    return "?" if one["provisional"] else ""


def _row(one: Incident, snapshot: dict[str, Any], words: Words, *, buses: bool) -> Row:
    status = _status(one, words)
    look = _LOOKS.get(one["status"], "")
    told = f"{'  ' * (one['depth'] - 1)}→ {one['text']}" if one["depth"] else one["text"]
    cells = [
        cell(one["id"]),
        cell(status, look),
        cell(_lasts(one, snapshot["now_ns"])),
        cell(one["frame"]),
        (*cell(told, look if one["status"] in _OPEN else ""), *cell("".join(_cause(one, words)), "dim")),
    ]
    if buses:
        cells.insert(1, cell(one["bus"]))
    checks = words("diagnose.between").join(one["checks"])
    caused = words("monitor.caused", number=one["cause"]) if one["cause"] is not None else ""
    whole = texts(
        [
            one["id"],
            status,
            one["text"] + "".join(_cause(one, words)),
            caused,
            words("diagnose.check_first", said=checks) if checks else "",
        ]
    )
    return Row(one["id"], tuple(cells), whole, leads=one["frame"])


def _status(one: Incident, words: Words) -> str:
    """Give how it stands; while more may come, what is not known yet stands as it was told."""
    known = "open" if one["provisional"] and one["status"] == "unknown" else one["status"]
    return words.of("problem_status", known) + _mark(one)


def _lasts(one: Incident, now: int | None) -> str:
    end = now if one["end_ns"] is None else one["end_ns"]
    if end is None or one["t_ns"] is None:
        return BLANK
    return period(max(0, end - one["t_ns"]))


def _cause(one: Incident, words: Words) -> Iterator[str]:
    """Give how long after its cause it began, and how sure that is."""
    if one["cause"] is None:
        return
    if one["delay_ns"] is not None and one["delay_ns"] >= 0:
        yield words("diagnose.after", ms=f"{one['delay_ns'] / 1e6:.0f}")
    yield f"  {words.of('problem_grade', one['cause_grade'])}"
