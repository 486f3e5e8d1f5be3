"""`canalyze decode`: the annotated listing. It only passes bytes on; every word of a line is the core's."""

from typing import Unpack

import click

from canalyze.help import Command
from canalyze.options import CaptureOptions, OneOf, capture_options, format_option, inputs, open_session
from canalyze.output import Progress, open_output
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
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        context = click.get_current_context()
        if brief and explain:
            raise click.UsageError(words("usage.exclusive", one="--brief", other="--explain"), context)
        if form != "text" and (brief or explain):
            option = "--brief" if brief else "--explain"
            raise click.UsageError(words("usage.text_only", option=option), context)
        names = inputs(files, words)
        depth = "brief" if brief else "explain" if explain else "default"
        session = open_session(words, given, format=form, depth=depth, stamps=stamps, time=time, filter=expression)
        with open_output(output, force=force) as out:
            code = Run(session, words, Progress(words, out, total_size(names)), out.write, given).over(names)
            if session.frames == 0:
                out.drop()
        return code

    return Command(
        "decode",
        words,
        run,
        [
            click.Option(["--brief"], is_flag=True, help=words("decode.brief")),
            click.Option(["--explain"], is_flag=True, help=words("decode.explain")),
            format_option(words, "decode"),
            click.Option(["-t", "time"], type=OneOf(("a", "d", "z", "A", "n"), words), help=words("decode.time")),
            *capture_options(words),
        ],
    )
