"""Many captures in figures, for people: a line each, then which rules found something in how many of them.

Must not: count what the core counts, or judge.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TypeVar

from canalyze.output import Output, dyed, printable
from canalyze.records.problems import Problem
from canalyze.records.summary import Bus, Capture, Node, Raised
from canalyze.records.summary import Record as Summarized
from canalyze.reports import table, wording
from canalyze.reports.diagnosis_text import Diagnosed
from canalyze.reports.table import EMPTY, Column
from canalyze.words import Words

T = TypeVar("T")


def show(captures: Sequence[tuple[str, str | None, Sequence[Summarized]]], out: Output, words: Words) -> None:
    """Writes the tables. captures: name, why it was not read as a whole, records of `summary`."""
    right = ("frames", "seconds", "nodes", "transfers", "load", "findings")
    columns = [
        Column(words("fleet.capture"), folds=True),
        *(Column(words(f"fleet.{name}"), right=True) for name in right),
    ]
    table.write(columns, ([name, *_figures(records)] for name, _, records in captures), out)
    found = Counter[str]()
    spread = Counter[str]()
    for _, _, records in captures:
        for one in _of(Raised, records):
            title = f"{one.code} {one.name}"
            found[title] += one.count
            spread[title] += 1
    if found:
        out.text("\n")
        columns = [
            Column(words("fleet.rule")),
            *(Column(words(f"fleet.{name}"), right=True) for name in ("files", "count")),
        ]
        ordered = sorted(spread.items(), key=lambda row: (-row[1], row[0]))
        table.write(columns, ([title, str(files), str(found[title])] for title, files in ordered), out)
    frames = sum(one.frames for _, _, records in captures for one in _of(Capture, records))
    hours = sum(float(one.seconds or 0) for _, _, records in captures for one in _of(Capture, records)) / 3600
    out.text("\n" + words("fleet.figures", files=len(captures), frames=frames, hours=f"{hours:.2f}") + "\n")


def show_problems(captures: Sequence[Diagnosed], out: Output, words: Words) -> None:
    """Writes the kinds of problems by node, with the number of captures, the most open ones first."""
    spread: dict[tuple[str, str], list[tuple[str, Problem]]] = {}
    for row in captures:
        for one in row.roots:
            if one.status != "harmless":
                concerned = one.nodes if one.node is None else (one.node,)
                key = one.kind, wording.ranges(concerned, ", ") or EMPTY
                spread.setdefault(key, []).append((row.names[0], one))
    if not spread:
        return

    def figures(found: Sequence[tuple[str, Problem]]) -> list[int]:
        states = Counter(one.status for _, one in found)
        return [len({name for name, _ in found}), *(states[state] for state in ("open", "unknown", "ended"))]

    ordered = sorted(spread.items(), key=lambda item: (-figures(item[1])[1], -figures(item[1])[0], item[0]))
    columns = [
        Column(words("fleet.problem")),
        Column(words("fleet.node"), right=True),
        *(Column(words(f"fleet.{name}"), right=True) for name in ("files", "open", "unknown", "ended")),
        Column(words("fleet.worst"), folds=True),
    ]
    rank = ("open", "unknown", "ended")
    rows = []
    for (kind, nodes), found in ordered:
        name, one = min(found, key=lambda entry: rank.index(entry[1].status))
        where = f"{wording.capture_name(name)} -n {one.id}"
        rows.append([kind, nodes, *map(str, figures(found)), where])
    table.write(columns, rows, out)
    out.text("\n")


def show_tables(captures: Sequence[Mapping[str, int]], out: Output, words: Words) -> None:
    """Writes the tables that were made. captures: rows by table, a wide one as signals/MESSAGE."""
    rows, files = Counter[str](), Counter[str]()
    for one in captures:
        rows.update(one)
        files.update(one.keys())
    right = (Column(words(f"fleet.{name}"), right=True) for name in ("files", "rows"))
    columns = [Column(words("fleet.table")), *right]
    table.write(columns, ([name, str(files[name]), str(rows[name])] for name in sorted(rows)), out)


def show_failed(failed: Sequence[tuple[str, str, int]], out: Output, words: Words) -> None:
    """Writes the captures that could not be read, or not as a whole: name, reason, number of attempts."""
    if failed:
        out.text("\n" + dyed(words("fleet.failed", files=len(failed)), "error", out=out) + "\n")
    for name, reason, attempts in failed:
        said = reason if name in reason else f"{name}: {reason}"
        tried = "" if attempts == 1 else words("fleet.tried", attempts=attempts)
        out.text(f"  {printable(said)}{tried}\n")


def _of(kind: type[T], records: Sequence[Summarized]) -> list[T]:
    return [one for one in records if isinstance(one, kind)]


def _figures(records: Sequence[Summarized]) -> list[str]:
    """Returns frames, seconds, nodes, transfers, peak of the load, findings; EMPTY where there is none of it."""
    if not _of(Capture, records):
        return [EMPTY] * 6
    (whole,), nodes = _of(Capture, records), _of(Node, records)
    loads = [one.load_peak_1s for one in _of(Bus, records) if one.load_peak_1s is not None]
    return [
        str(whole.frames),
        EMPTY if whole.seconds is None else f"{float(whole.seconds):.1f}",
        str(len(nodes)),
        str(sum(one.transfers for one in nodes)),
        f"{max(loads):.1f}%" if loads else EMPTY,
        str(sum(one.count for one in _of(Raised, records))),
    ]
