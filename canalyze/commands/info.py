"""`canalyze info`: what a file is, before anything is decoded. Each file is by itself; the core counts its frames."""

import json
from typing import Any, Unpack

import click

from canalyze.help import Command
from canalyze.options import (
    ANY_PATH,
    CaptureOptions,
    OneOf,
    format_option,
    inputs,
    open_session,
    output_options,
    topic_options,
)
from canalyze.output import Progress, open_output
from canalyze.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words


def command(words: Words) -> click.Command:
    """Build the command in one language."""
    from canalyze.sources.format import input_formats

    def run(files: tuple[str, ...], form: str, output: str | None, force: bool, **given: Unpack[CaptureOptions]) -> int:
        from canalyze.reports.info_text import show

        names = inputs(files, words)
        code = shown = 0
        with open_output(output, force=force) as out:
            progress = Progress(words, out, total_size(names))
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
                        "size": one.last.taken,
                    }
                    if form == "jsonl":
                        out.text(json.dumps(record, ensure_ascii=False, separators=(",", ":")) + "\n")
                    else:
                        show(record, out, words, first=not shown)
                    shown += 1
                if ended > 128:
                    break
            if not shown:
                out.drop()
        return code

    return Command(
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
