"""The records that a diagnosis is made of: the problems, and lines of frames. Must not: judge."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

Record = Mapping[str, Any]

AROUND: Final = 2
"""Frames that are shown before and behind a step of a problem."""


def records(results: Sequence[bytes]) -> list[dict[str, Any]]:
    """Returns the problems, and at their end the record of the whole capture."""
    return [json.loads(line) for line in b"".join(results).splitlines()]


def near(incidents: Iterable[Record]) -> set[int]:
    """Returns the numbers of the frames around each step."""
    return {
        frame + place
        for one in incidents
        for frame in (one["begin"]["frame"], *(step["frame"] for step in one["steps"]))
        for place in range(-AROUND, AROUND + 1)
    }


def lines(result: bytes, wanted: set[int]) -> dict[int, str]:
    """Returns the annotated lines of frames, by their numbers. result: of a session with the format `lines`."""
    rows = (json.loads(line) for line in result.splitlines())
    return {row["frame"]: row["text"] for row in rows if row["frame"] in wanted}
