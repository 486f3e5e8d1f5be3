"""The summary of a capture as a document of a recording, in Markdown.

Which blocks there are and what stands in them, `reports/summary_text.py` says. Must not: count or measure.
"""

import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, Final

from canalyze.output import printable
from canalyze.records import records
from canalyze.records.summary import Capture
from canalyze.reports.summary_text import LEFT, report
from canalyze.words import Words

_SPECIAL: Final = re.compile(r"([\\`*_{}\[\]<>#|~])")
_FACTS: Final = ("files", "frames", "first_t", "last_t", "seconds", "bit_rate", "dropped", "unreadable")


def markdown(result: bytes, words: Words, *, dated: bool = False) -> str:
    """Give the JSON lines of one capture as a document. dated: its stamps are dates, which are written as such."""
    sheet = _Markdown()
    report(result, sheet, words, stamp=_date if dated else str)
    return "".join(sheet.parts)


def listed(lines: Sequence[str], words: Words) -> str:
    """Give a summary that is in words already as a document, an item each."""
    items = "".join(f"- {_plain(line)}\n" for line in lines)
    return f"# {_plain(words('timeline.summary'))}\n\n{items}"


def facts(result: bytes) -> dict[str, Any]:
    """Give what a recording has as its properties; what is not known is left out."""
    capture = next(records(result, Capture))
    return {key: fact for key in _FACTS if (fact := getattr(capture, key)) is not None}


def story_list(incidents: Sequence[Mapping[str, Any]], words: Words) -> str:
    """Give what went wrong as a document: a chapter a status, an item a problem, its consequences below it.

    incidents: rows of the core's table, in the order of reading, each with `caused` in words.
    """
    lines = [f"# {_plain(words('timeline.diagnosis'))}\n"]
    heading = ""
    for one in incidents:
        if not one["depth"] and one["status"] != heading:
            heading = one["status"]
            lines.append(f"\n## {_plain(words.of('problem_heading', heading))}\n\n")
        indent = "  " * one["depth"]
        caused = f" ({_plain(one['caused'])})" if one["caused"] else ""
        lines.append(f"{indent}- **\\#{one['id']}** {_plain(one['message'])}{caused}\n")
        if not one["depth"] and one["checks"] and one["status"] != "harmless":
            checks = words("diagnose.between").join(one["checks"].split("\n"))
            lines.append(f"{indent}  - {_plain(words('diagnose.check_first', said=checks))}\n")
    return "".join(lines)


def _date(stamp: str) -> str:
    """Write a stamp as the viewer does: date and time of day."""
    seconds, _, fraction = str(stamp).partition(".")
    try:
        day = datetime.fromtimestamp(int(seconds), UTC)
    except (ValueError, OverflowError, OSError):  # no date after all
        return str(stamp)
    return f"{day:%Y-%m-%d %H:%M:%S}" + (f".{fraction}" if fraction else "")


class _Markdown:
    """Blocks as chapters."""

    def __init__(self) -> None:
        self.parts: list[str] = []

    def facts(self, heading: str, rows: Sequence[tuple[str, str]]) -> None:
        lines = "".join(f"- {_plain(term)}: {_plain(text)}\n" if term else f"- {_plain(text)}\n" for term, text in rows)
        self.parts.append(f"# {_plain(heading)}\n\n{lines}")

    def table(self, heading: str, keys: Sequence[str], names: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        sides = [":--" if key in LEFT else "--:" for key in keys]
        lines = "".join(f"| {' | '.join(cells)} |\n" for cells in (map(_plain, row) for row in rows))
        head = f"| {' | '.join(map(_plain, names))} |\n|{'|'.join(sides)}|\n"
        self.parts.append(f"\n## {_plain(heading)}\n\n{head}{lines}")

    def line(self, text: str) -> None:
        if text:
            self.parts.append(f"\n{_plain(text)}\n")


def _plain(text: str) -> str:
    """Give a text that Markdown shows as it is."""
    return _SPECIAL.sub(r"\\\1", printable(text))
