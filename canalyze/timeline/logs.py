"""Texts of a recording: annotated frames, findings and emergencies as lines; summary and diagnosis as documents.

The lines are the core's; the blocks of the summary come from `reports/summary.py`. Must not: count or measure.
"""

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from canalyze.output import printable
from canalyze.records import records
from canalyze.records.problems import ProblemRow
from canalyze.records.summary import Capture
from canalyze.reports.summary import LEFT, report
from canalyze.timeline.contents import Contents
from canalyze.timeline.stream import LEVEL, TEXT, Stream, mapped, path, places, plain, words
from canalyze.timeline.stream import part as part_of
from canalyze.words import Words

_SPECIAL: Final = re.compile(r"([\\`*_{}\[\]<>#|~])")
_FACTS: Final = ("files", "frames", "first_t", "last_t", "seconds", "bit_rate", "dropped", "unreadable")


def markdown(result: bytes, words: Words, *, dated: bool = False) -> str:
    """Returns the JSON lines of one capture as a document. dated: stamps are dates, and formatted as such."""
    sheet = _Markdown()
    report(result, sheet, words, stamp=_date if dated else str)
    return "".join(sheet.parts)


def listed(lines: Sequence[str], words: Words) -> str:
    """Returns a summary in words as a document with an item per line."""
    items = "".join(f"- {_plain(line)}\n" for line in lines)
    return f"# {_plain(words('timeline.summary'))}\n\n{items}"


def facts(result: bytes) -> dict[str, Any]:
    """Returns the properties of a recording; unknown ones are left out."""
    capture = next(records(result, Capture))
    return {key: fact for key in _FACTS if (fact := getattr(capture, key)) is not None}


def problem_list(problems: Sequence[tuple[ProblemRow, str]], words: Words) -> str:
    """Returns the diagnosis as a document: a chapter per status, an item per problem, its consequences below it.

    problems: in the order of reading, each with its cause in words.
    """
    lines = [f"# {_plain(words('timeline.diagnosis'))}\n"]
    heading = ""
    for one, cause in problems:
        if not one.depth and one.status != heading:
            heading = one.status
            lines.append(f"\n## {_plain(words.of('problem_heading', heading))}\n\n")
        indent = "  " * one.depth
        caused = f" ({_plain(cause)})" if cause else ""
        lines.append(f"{indent}- **\\#{one.id}** {_plain(one.message)}{caused}\n")
        if not one.depth and one.checks and one.status != "harmless":
            checks = words("diagnose.between").join(one.checks.split("\n"))
            lines.append(f"{indent}  - {_plain(words('diagnose.check_first', said=checks))}\n")
    return "".join(lines)


def _date(stamp: str) -> str:
    """Returns a stamp as the viewer formats it: date and time of day."""
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
    """Returns a text with Markdown's special characters escaped."""
    return _SPECIAL.sub(r"\\\1", printable(text))


_LEVELS: Final[dict[str | None, str]] = {"error": "ERROR", "warning": "WARN", "info": "INFO", None: "TRACE"}
_SOURCES: Final = {"finding": "findings", "emcy": "emcy"}
"""The second part of their paths, by the core's names; the third is the bus, then comes the node."""


class LogWriter:
    """Writes lines to a recording."""

    def __init__(self, stream: Stream, contents: Contents) -> None:
        """Writes rows to `stream` and updates `contents`."""
        self._stream = stream
        self._contents = contents
        self._buses: set[str] = set()

    def frames(self, batch: pa.RecordBatch) -> None:
        """Appends annotated frames, prefixed with the bus if there are several."""
        if not len(batch):
            return
        lines, buses = batch.column("line"), batch.column("bus")
        self._buses |= words(buses)
        if len(self._buses) > 1:
            lines = pc.binary_join_element_wise(plain(buses).fill_null("-"), lines, "  ")
        self._contents.frames += len(batch)
        levels = mapped(batch.column("severity"), _LEVELS)
        self._stream.texts("/frames", places(batch), [(TEXT, lines), (LEVEL, levels)])

    def log(self, batch: pa.RecordBatch) -> None:
        """Appends findings and emergencies."""
        rows, sources = places(batch), np.asarray(plain(batch.column("source")), object)
        coded = pc.binary_join_element_wise(plain(batch.column("code")), batch.column("text"), "  ")
        levels = mapped(batch.column("level"), _LEVELS)
        buses = np.asarray(plain(batch.column("bus")).fill_null(""), object)
        nodes = np.asarray(batch.column("node").fill_null(0))
        for source, kind in _SOURCES.items():
            (every,) = np.nonzero(sources == source)
            for bus, node in dict.fromkeys(zip(buses[every].tolist(), nodes[every].tolist(), strict=True)):
                some = every[(buses[every] == bus) & (nodes[every] == node)]
                entity = path("log", kind, bus, *([f"node{node}"] if node else []))
                if node:
                    self._contents.told.setdefault((part_of(bus), node), {})[entity] = None
                taken = pa.array(some)
                told = levels.take(taken)
                for one in told.value_counts().to_pylist():
                    self._contents.logged[one["values"]] = self._contents.logged.get(one["values"], 0) + one["counts"]
                self._contents.findings += len(some) if source == "finding" else 0
                # The text of an emergency has its code.
                texts = batch.column("text") if source == "emcy" else coded
                self._stream.texts(entity, rows[some], [(TEXT, texts.take(taken)), (LEVEL, told)])
