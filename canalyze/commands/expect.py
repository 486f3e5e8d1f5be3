"""`canalyze expect`: writes a first version of a file of expectations from a good capture.

What was seen, the core says; how much room it gets, `expectations/draft.py`.
"""

import json
import shlex
from pathlib import PurePath
from typing import Unpack

import click

from canalyze.configuration.options import CaptureOptions, bitrate_option, capture_options, inputs, open_session
from canalyze.expectations.draft import Draft
from canalyze.output import Progress, complain, hint, open_output, told
from canalyze.output.help import Command
from canalyze.running.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        output: str | None,
        force: bool,
        expression: str | None,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        names = inputs(files, words)
        session = open_session(words, given, format="observed", incidents=True, stamps=stamps, filter=expression)
        draft = Draft()

        def take(result: bytes) -> None:
            for line in result.splitlines():
                draft.take(json.loads(line))

        with open_output(output, force=force) as out:
            total = total_size(names)
            code = Run(session, words, Progress(words, out, total), take, given).over(names)
            told(code, out, words, stream=total is None, some=draft.frames > 0)
            if draft.frames:
                out.write(draft.text(words, ", ".join(PurePath(name).name for name in names)).encode())
            else:
                out.drop()
        if draft.findings:
            complain(f"canalyze: {words('expect.not_good', codes=', '.join(draft.findings))}")
        if out.name is not None and draft.frames and not code:
            hint(f"canalyze: {words('expect.written', name=shlex.quote(out.name))}")
        return code

    return Command("expect", words, run, [bitrate_option(words), *capture_options(words)])
