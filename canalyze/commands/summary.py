"""`canalyze summary`: a capture in figures. What is counted and measured, the core says, all of it at the end."""

import json
from typing import Unpack

import click

from canalyze.help import Command
from canalyze.options import CaptureOptions, bitrate_option, capture_options, format_option, inputs, open_session
from canalyze.output import Progress, open_output, told
from canalyze.run import Run
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
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        names = inputs(files, words)
        session = open_session(words, given, format="summary", stamps=stamps, filter=expression)
        with open_output(output, force=force) as out:
            results: list[bytes] = []
            total = total_size(names)
            code = Run(session, words, Progress(words, out, total), results.append, given).over(names)
            records = b"".join(results)
            if form == "jsonl":
                out.write(records)
            else:
                from canalyze.reports.summary_text import show

                show(map(json.loads, records.splitlines()), out, words)
            told(code, out, words, stream=total is None, some=bool(records))
            if not records:
                out.drop()
        return code

    return Command(
        "summary",
        words,
        run,
        [
            format_option(words, "summary"),
            bitrate_option(words),
            *capture_options(words),
        ],
    )
