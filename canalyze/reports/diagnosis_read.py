"""The records of a capture that its diagnosis needs: the problems, lines of frames, the content of a page.

A reader is handed over, so that commands and the library have it read in their own ways. Must not: judge.
"""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Protocol

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.reports.diagnosis_html import Told

Record = Mapping[str, Any]

AROUND: Final = 2
"""Frames that are shown before and behind a step of a problem."""


class Read(Protocol):
    """Reads the whole capture in one language."""

    def __call__(self, form: str, take: "Callable[[Session, bytes], None]", **settings: Any) -> "Session":
        """Read it through a session of a format of the core; `take` gets each result as it comes."""


def problems(read: Read) -> list[dict[str, Any]]:
    """Return the records of the problems, and at the end that of the whole capture."""
    results: list[bytes] = []
    read("diagnosis", lambda _, result: results.append(result))
    return records(results)


def records(results: Sequence[bytes]) -> list[dict[str, Any]]:
    """Return the problems, and at their end the record of the whole capture."""
    return [json.loads(line) for line in b"".join(results).splitlines()]


def near(incidents: Iterable[Record]) -> set[int]:
    """Return the numbers of the frames around each step."""
    return {
        frame + place
        for one in incidents
        for frame in (one["begin"]["frame"], *(step["frame"] for step in one["steps"]))
        for place in range(-AROUND, AROUND + 1)
    }


def lines(read: Read, wanted: set[int] | None) -> dict[int, str]:
    """Return the annotated lines of frames, by their numbers. wanted: None: of all."""
    kept: dict[int, str] = {}

    def take(_: "Session", result: bytes) -> None:
        for line in result.splitlines():
            record = json.loads(line)
            if wanted is None or record["frame"] in wanted:
                kept[record["frame"]] = record["text"]

    read("lines", take, time="z")
    return kept


def content(read: Read, incidents: Sequence[Record], whole: Record, *, every: bool) -> "Told":
    """Return the content of a page in the language of `read`, which reads twice. every: with all frames."""
    from canalyze.reports.diagnosis_html import Told
    from canalyze.reports.diagnosis_lanes import SIGNALS, TABLES, Gatherer

    gatherer = Gatherer(incidents, whole["order"])
    results: list[bytes] = []

    def take(session: "Session", result: bytes) -> None:
        results.append(result)
        gatherer.take(session.batches())

    select = gatherer.select
    session = read("diagnosis", take, tables=(*TABLES, SIGNALS) if select else TABLES, select=select)
    gatherer.take(session.batches(flush=True))
    found = records(results)
    of_problems = [one for one in found if one["kind"] == "problem"]
    frames = near(of_problems)
    listed = lines(read, None if every else frames)
    close = {number: line for number, line in listed.items() if number in frames}
    return Told(of_problems, found[-1], close, gatherer.beside(), listed if every else None)
