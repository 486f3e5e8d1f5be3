"""`canalyze signals`: the signals in PDOs, one value a line. What a signal is and which are kept, the core says."""

from typing import Any, Final, Unpack

import click

from canalyze.configuration.options import (
    CaptureOptions,
    capture_options,
    filters_given,
    format_option,
    inputs,
    open_session,
    problem_option,
    time_option,
)
from canalyze.output import Progress, complain, open_output, told
from canalyze.output.help import Listing
from canalyze.running.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words

FORMS: Final = {"csv": "signals-csv", "jsonl": "signals"}
"""What --format is called in the core."""
HEADINGS: Final = {"csv": 1, "jsonl": 0}
"""Lines that are no value."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        select: str | None,
        form: str,
        output: str | None,
        force: bool,
        expression: str | None,
        time: str | None,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        names = inputs(files, words)
        shown: dict[str, Any] = {"filter": expression, "time": time, "select": select}
        session = open_session(words, given, format=FORMS[form], stamps=stamps, **shown)
        lines = 0
        with open_output(output, force=force) as out:

            def take(result: bytes) -> None:
                nonlocal lines
                if lines <= HEADINGS[form]:
                    lines += result.count(b"\n")
                out.write(result)

            total = total_size(names)
            code = Run(session, words, Progress(words, out, total), take, given).over(names)
            told(code, out, words, stream=total is None, some=session.frames > 0)
            if session.frames == 0:
                out.drop()
        if session.frames and lines <= HEADINGS[form]:
            options = " ".join(filters_given())
            key = "signals.none_kept" if options else "signals.none"
            complain(f"canalyze: {words(key, frames=session.frames, options=options)}")
        return code

    return Listing(
        "signals",
        words,
        run,
        [
            click.Option(["--select"], metavar="GLOBS", help=words("signals.select")),
            format_option(words, "signals", ("csv", "jsonl")),
            time_option(words),
            problem_option(words),
            *capture_options(words),
        ],
    )
