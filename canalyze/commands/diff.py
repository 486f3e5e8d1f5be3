"""`canalyze diff`: two captures compared as CANopen. What differs, and in which words, the core says.

The lines around the first difference are read in a second pass, of that part only; a pipe cannot be read twice and has
none.
"""

import os
from contextlib import suppress
from typing import Final

from canalyze.configuration.options import ANY_PATH, MERGE, OUTPUT, READING, argument, form, option, usage
from canalyze.errors import ReaderGone
from canalyze.running.diagnosing import around
from canalyze.running.passes import Pass, pass_command
from canalyze.sources import STDIN
from canalyze.words import Words

_MOST: Final = 1000.0
"""The greatest tolerance in percent."""


def run(one: Pass) -> int:
    """Reads both, then compares."""
    from canalyze._core import Comparison

    files = one.files
    if len(files) != 2 or files == (STDIN, STDIN):
        raise one.usage("diff.two", count=len(files))
    sessions = [one.session(format="digest") for _ in files]
    code = 0
    with one.opened() as out:
        for name, session in zip(files, sessions, strict=True):
            ended = one.read(session, lambda _: None, (name,))
            code = max(code, ended)
            if ended >= 128:
                break
        one.report_end(code, some=False)
        if code >= 128 or not all(session.frames for session in sessions):
            out.drop()
            return code or 2
        names = [os.fsencode(name).decode("utf-8", "backslashreplace") for name in files]
        found = Comparison(
            *sessions,
            names=(names[0], names[1]),
            lang=one.words.lang,
            tolerance=one.tolerance / 100,
            buses=list(one.bus),
        )
        _there(one.bus, found.buses, one.words)
        with suppress(ReaderGone):  # a closed pipe does not mean that they are alike
            if one.form == "jsonl":
                out.write(found.jsonl())
            else:
                out.shown(found.head())
                for side, name, frame in zip("AB", files, found.first(), strict=True):
                    lines = around(one, name, frame)
                    out.shown(b"".join(b"  %s %s\n" % (side.encode(), line) for line in lines))
                out.shown(found.body())
    return code or int(found.differences > 0)


def _there(pairs: tuple[tuple[str, str], ...], buses: tuple[list[str], list[str]], words: Words) -> None:
    """Raises UsageError for a bus that is not in its capture: what was meant would silently not hold."""
    for pair in pairs:
        for side, name, there in zip("AB", pair, buses, strict=True):
            if name not in there:
                known = words("check.between").join(there) or words("diff.unnamed")
                raise usage(words, "diff.no_bus", side=side, name=name, there=known)


def _percent(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if 0 <= value <= _MOST else None


def _buses(text: str) -> tuple[str, str] | None:
    a, equals, b = text.partition("=")
    return (a, b) if equals else None


command = pass_command(
    "diff",
    run,
    argument("files", "A B", nargs=-1, type=ANY_PATH),
    form("text", "jsonl"),
    option("--tolerance", "PERCENT", _percent, "percent", usual=4, default="10"),
    option("--bus", "A=B", _buses, "bus_pair", topic="chosen", multiple=True),
    *(row for row in READING if row is not MERGE),
    *OUTPUT,
    paged=True,
)
