"""`canalyze summary`: a capture in figures. What is counted and measured, the core says, all of it at the end."""

from typing import Unpack

import click

from canalyze.configuration.options import (
    CaptureOptions,
    bitrate_option,
    capture_options,
    color_option,
    format_option,
    inputs,
    open_session,
    problem_option,
    time_option,
)
from canalyze.output import Progress, open_output, told
from canalyze.output.help import Listing
from canalyze.running.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        form: str,
        output: str | None,
        force: bool,
        expression: str | None,
        time: str | None,
        color: str,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        names = inputs(files, words)
        session = open_session(words, given, format="summary", stamps=stamps, filter=expression, time=time)
        with open_output(output, force=force, color=color) as out:
            results: list[bytes] = []
            total = total_size(names)
            code = Run(session, words, Progress(words, out, total), results.append, given).over(names)
            records = b"".join(results)
            if form == "jsonl":
                out.write(records)
            else:
                from canalyze.reports.summary_text import show

                show(records, out, words, moments=time is None)
            told(code, out, words, stream=total is None, some=bool(records))
            if not records:
                out.drop()
        return code

    return Listing(
        "summary",
        words,
        run,
        [
            format_option(words, "summary"),
            time_option(words),
            color_option(words),
            bitrate_option(words),
            problem_option(words),
            *capture_options(words),
        ],
    )
