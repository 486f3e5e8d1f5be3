"""`canalyze signals`: the signals in PDOs, one value a line. What a signal is and which are kept, the core says."""

from typing import Final

from canalyze.configuration.options import PROBLEM, SELECT, TIME, filters_given, form
from canalyze.running.passes import Pass, capture_command

FORMS: Final = {"csv": "signals-csv", "jsonl": "signals"}
"""The core's names of the values of --format."""
HEADINGS: Final = {"csv": 1, "jsonl": 0}
"""Lines that are no value."""


def run(one: Pass) -> int:
    """Writes every value as it comes."""
    session = one.session(format=FORMS[one.form], select=one.select)
    lines = 0
    with one.opened() as out:

        def take(result: bytes) -> None:
            nonlocal lines
            if lines <= HEADINGS[one.form]:
                lines += result.count(b"\n")
            out.write(result)

        code = one.end(one.read(session, take), session.frames)
    if session.frames and lines <= HEADINGS[one.form]:
        options = " ".join(filters_given())
        key = "signals.none_kept" if options else "signals.none"
        one.note(key, frames=session.frames, options=options)
    return code


command = capture_command("signals", run, SELECT, form("csv", "jsonl"), TIME, PROBLEM)
