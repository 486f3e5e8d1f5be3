"""Many captures as one page for a browser: nothing is loaded, everything of a capture is escaped.

It has no capture inside, as `canalyze.html` has: fleets are larger than a page. Must not: judge, or read a capture.
"""

from collections.abc import Sequence
from html import escape
from typing import Final

from canalyze import html
from canalyze.check.verdict import Verdict
from canalyze.output import printable
from canalyze.reports import wording
from canalyze.words import Words

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
