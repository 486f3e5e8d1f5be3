"""Many captures in figures, for people: a line each, then which rules found something in how many; or a page.

The page loads nothing, and everything of a capture is escaped. It has no capture inside, as `canalyze.html` has: fleets
are larger than a page. Must not: count what the core counts, judge, or read a capture.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from html import escape
from typing import Final, TypeVar

from canalyze import html
from canalyze.check.verdict import Verdict
from canalyze.output import Output, dyed, printable
from canalyze.records.problems import Problem
from canalyze.records.summary import Bus, Capture, Node, Raised
from canalyze.records.summary import Record as Summarized
from canalyze.reports import table, wording
from canalyze.reports.diagnosis import Diagnosed
from canalyze.reports.table import EMPTY
from canalyze.words import Words

T = TypeVar("T")


def show(captures: Sequence[tuple[str, str | None, Sequence[Summarized]]], out: Output, words: Words) -> None:
    """Writes the tables. captures: name, why it was not read as a whole, records of `summary`."""
    right = ("frames", "seconds", "nodes", "transfers", "load", "findings")
    columns = table.columns(words, ["capture", *right], of="fleet", right=right, folds=["capture"])
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
        columns = table.columns(words, ["rule", "files", "count"], of="fleet", right=["files", "count"])
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
    right = ("node", "files", "open", "unknown", "ended")
    columns = table.columns(words, ["problem", *right, "worst"], of="fleet", right=right, folds=["worst"])
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
    columns = table.columns(words, ["table", "files", "rows"], of="fleet", right=["files", "rows"])
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


_SAID: Final = 20
"""Findings of one capture that are shown at most."""
_STATES: Final = {"unread": "unknown", "failing": "open", "passing": "ended"}
"""In the order in which captures are listed, with the class in the style of the page."""


def page(captures: Sequence[tuple[Verdict, int]], words: Words) -> bytes:
    """Returns the page. captures: each with the number of findings that count."""
    rows = sorted(
        ((_state(one), one, findings) for one, findings in captures), key=lambda row: [*_STATES].index(row[0])
    )
    states = [state for state, _, _ in rows]
    counts = " · ".join(f"{words(f'fleet.{state}')} {states.count(state)}" for state in _STATES)
    names = ("capture", "", "frames", "findings", "")
    head = "".join(f"<th>{escape(words(f'fleet.{name}')) if name else ''}</th>" for name in names)
    body = "\n".join(_row(*row, words) for row in rows)
    return html.static(
        words.lang,
        "canalyze fleet",
        f'<header class="fleet"><h1>canalyze fleet</h1><p id="verdict">{escape(counts)}</p></header>\n'
        f'<section id="index" class="fleet"><table>\n<tr>{head}</tr>\n{body}\n</table></section>',
    )


def _state(verdict: Verdict) -> str:
    return "unread" if verdict.error is not None else "failing" if verdict.failed else "passing"


def _row(state: str, verdict: Verdict, findings: int, words: Words) -> str:
    said = [wording.title(one.finding) + ": " + wording.sentence(one, words) for one in verdict.failures]
    said += [printable(one.message) for one in verdict.stories if one.id in verdict.problems]
    said = ([printable(verdict.error)] if verdict.error else []) + said[:_SAID]
    name, shown = escape(wording.capture_name(verdict.file)), escape(words(f"fleet.{state}"))
    lines = "<br>".join(map(escape, said))
    cells = f'<td>{name}</td><td class="{_STATES[state]}">{shown}</td><td>{verdict.frames}</td><td>{findings}</td>'
    return f"<tr>{cells}<td>{lines}</td></tr>"
