"""`canalyze decode`: the annotated listing. It only passes bytes on; every word of a line is the core's."""

import re
from typing import Final

from canalyze.configuration.options import LISTING, PROBLEM, clock, depth_of, filters_given, option
from canalyze.running.passes import Pass, capture_command

_AROUND: Final = 10
"""Frames that are shown before and behind one that is asked for."""


def run(one: Pass) -> int:
    """Lists every frame."""
    text = one.form == "text"
    depth = depth_of(one.form, one.words, brief=one.brief, explain=one.explain, number=one.number)
    ranges = ",".join(one.around + one.frame)
    near = ranges != "" or "--problem" in filters_given()
    with one.opened(hangs=text) as out:
        session = one.session(
            incidents=one.incidents,
            format=one.form,
            depth=depth,
            time=clock(one.time, one.form, one.output),
            filter=f"{one.expression or ''} frame={ranges}" if ranges else one.expression,
            numbered=text and (near or out.is_terminal) if one.number is None else one.number,
            coloured=text and out.coloured,
        )
        code = one.read(session, out.shown if text else out.write)
        return one.end(code, session.frames)


def _around(text: str) -> str | None:
    """Reads `N` or `N:K`; returns the range of frames as filters have it."""
    if not (found := re.fullmatch(r"([1-9][0-9]{0,9})(?::([0-9]{1,9}))?", text)):
        return None
    number, near = int(found[1]), int(found[2] or _AROUND)
    return f"{max(1, number - near)}-{number + near}"


def _span(text: str) -> str | None:
    """Reads `A` or `A-B`; returns it as it is."""
    found = re.fullmatch(r"([1-9][0-9]{0,9})(?:-([1-9][0-9]{0,9}))?", text)
    return text if found and int(found[1]) <= int(found[2] or found[1]) else None


command = capture_command(
    "decode",
    run,
    *LISTING,
    option("--around", "N[:K]", _around, "around", topic="chosen", multiple=True),
    option("--frame", "A-B", _span, "frame", topic="chosen", multiple=True),
    option("--problems incidents"),
    PROBLEM,
)
