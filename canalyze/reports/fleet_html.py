"""Many captures as one page for a browser: nothing is loaded, everything of a capture is escaped.

The template is in `templates`. Must not: judge, or read a capture.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from canalyze.check.verdict import Verdict
from canalyze.errors import OutputError
from canalyze.output import printable
from canalyze.reports import wording
from canalyze.words import Words

_TEMPLATES: Final = Path(__file__).with_name("templates")
_SAID: Final = 20
"""Findings of one capture that are shown at most."""


def page(captures: Sequence[tuple[Verdict, int]], words: Words) -> bytes:
    """Give the page. captures: each with the number of findings that count. OutputError without jinja2."""
    try:
        from jinja2 import Environment, FileSystemLoader, select_autoescape
        from markupsafe import Markup
    except ImportError as error:
        raise OutputError("diagnose.needs_html", error=error) from error

    environment = Environment(loader=FileSystemLoader(_TEMPLATES), autoescape=select_autoescape(default=True))
    rows = [_row(one, findings, words) for one, findings in captures]
    made = environment.get_template("fleet.html").render(
        words=words,
        style=Markup((_TEMPLATES / "diagnosis.css").read_text(encoding="utf-8")),
        rows=sorted(rows, key=lambda row: _STATES.index(row["state"])),
        counts={state: sum(row["state"] == state for row in rows) for state in _STATES},
    )
    return made.encode("utf-8", "backslashreplace")


_STATES: Final = ("unread", "failing", "passing")


def _row(verdict: Verdict, findings: int, words: Words) -> dict[str, Any]:
    said = [wording.title(one.finding) + ": " + wording.sentence(one, words) for one in verdict.failures]
    said += [printable(one.message) for one in verdict.stories if one.id in verdict.problems]
    said = ([printable(verdict.error)] if verdict.error else []) + said[:_SAID]
    return {
        "name": wording.capture_name(verdict.file),
        "state": "unread" if verdict.error is not None else "failing" if verdict.failed else "passing",
        "frames": verdict.frames,
        "findings": findings,
        "said": said,
    }
