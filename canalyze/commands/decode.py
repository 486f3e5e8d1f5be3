"""`canalyze decode`: the annotated listing. It only passes bytes on; every word of a line is the core's."""

from typing import Unpack

import click

from canalyze.help import Command
from canalyze.options import CaptureOptions, capture_options, depth_of, inputs, listing_options, open_session
from canalyze.output import Progress, open_output, told
from canalyze.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        brief: bool,
        explain: bool,
        form: str,
        output: str | None,
        force: bool,
        expression: str | None,
        time: str | None,
        incidents: bool,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        depth = depth_of(form, words, brief=brief, explain=explain)
        names = inputs(files, words)
        shown = {"format": form, "depth": depth, "time": time, "filter": expression}
        session = open_session(words, given, stamps=stamps, incidents=incidents, **shown)
        with open_output(output, force=force) as out:
            total = total_size(names)
            take = out.shown if form == "text" else out.write
            code = Run(session, words, Progress(words, out, total), take, given).over(names)
            told(code, out, words, stream=total is None, some=session.frames > 0)
            if session.frames == 0:
                out.drop()
        return code

    return Command(
        "decode",
        words,
        run,
        [
            *listing_options(words),
            click.Option(["--incidents"], is_flag=True, help=words("decode.incidents")),
            *capture_options(words),
        ],
    )
