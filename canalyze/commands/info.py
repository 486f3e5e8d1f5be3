"""`canalyze info`: what a file is, before anything is decoded. Each file is by itself; the core counts its frames."""

import json
from typing import Any, Unpack

import click

from canalyze.configuration.options import (
    ANY_PATH,
    CaptureOptions,
    OneOf,
    format_option,
    inputs,
    open_session,
    output_options,
    topic_options,
)
from canalyze.output import Progress, jsonl, open_output, told
from canalyze.output.help import Listing
from canalyze.running.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words


def command(words: Words) -> click.Command:
    """Build the command in one language."""
    from canalyze.sources.format import input_formats

    def run(files: tuple[str, ...], form: str, output: str | None, force: bool, **given: Unpack[CaptureOptions]) -> int:
        from canalyze.reports.info_text import show

        names = inputs(files, words)
        code = shown = ended = 0
        with open_output(output, force=force) as out:
            total = total_size(names)
            progress = Progress(words, out, total)
            for name in names:
                results: list[bytes] = []
                one = Run(
                    open_session(words, given, format="info"), words, progress, results.append, given, frameless=True
                )
                ended = one.over((name,))
                code = ended or code
                if one.last is not None and (one.understood or ended > 128):
                    record: dict[str, Any] = json.loads(b"".join(results))
                    record |= {
                        "format": one.last.kind,
                        "compression": one.last.compression,
                        "checked": one.last.checked,
                        "size": one.last.taken,
                    }
                    if form == "jsonl":
                        out.write(jsonl.line(record, compact=True))
                    else:
                        show(record, out, words, first=not shown)
                    shown += 1
                if ended > 128:
                    break
            told(ended, out, words, stream=total is None, some=shown > 0)
            if not shown:
                out.drop()
        return code

    return Listing(
        "info",
        words,
        run,
        [
            click.Argument(["files"], nargs=-1, type=ANY_PATH, metavar="FILE"),
            format_option(words, "info"),
            click.Option(["--input-format"], type=OneOf(input_formats(), words), help=words("opt.input_format")),
            *topic_options(words),
            *output_options(words),
        ],
    )
