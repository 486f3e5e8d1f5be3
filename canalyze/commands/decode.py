"""`canalyze decode`: the annotated listing. It only passes bytes on; every word of a line is the core's."""

import re
from typing import Final, Unpack

import click

from canalyze.configuration.options import (
    CaptureOptions,
    capture_options,
    clock,
    depth_of,
    filters_given,
    inputs,
    listing_options,
    open_session,
    problem_option,
    spelled,
)
from canalyze.output import Progress, open_output, told
from canalyze.output.help import Listing
from canalyze.running.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words

_AROUND: Final = 10
"""Frames that are shown before and behind one that is asked for."""


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
        number: bool | None,
        color: str,
        around: tuple[str, ...],
        frame: tuple[str, ...],
        incidents: bool,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        depth = depth_of(form, words, brief=brief, explain=explain, number=number)
        names = inputs(files, words)
        if ranges := ",".join(around + frame):
            expression = f"{expression or ''} frame={ranges}"
        near = ranges != "" or "--problem" in filters_given()
        with open_output(output, force=force, color=color, hangs=form == "text") as out:
            text = form == "text"
            session = open_session(
                words,
                given,
                stamps=stamps,
                incidents=incidents,
                format=form,
                depth=depth,
                time=clock(time, form, output),
                filter=expression,
                numbered=text and (near or out.is_terminal) if number is None else number,
                coloured=text and out.coloured,
            )
            total = total_size(names)
            take = out.shown if text else out.write
            code = Run(session, words, Progress(words, out, total), take, given).over(names)
            told(code, out, words, stream=total is None, some=session.frames > 0)
            if session.frames == 0:
                out.drop()
        return code

    return Listing(
        "decode",
        words,
        run,
        [
            *listing_options(words),
            spelled(words, "--around", _around, "around", "N[:K]", "decode.around", multiple=True),
            spelled(words, "--frame", _span, "frame", "A-B", "decode.frame", multiple=True),
            click.Option(["--problems", "incidents"], is_flag=True, help=words("decode.problems")),
            problem_option(words),
            *capture_options(words),
        ],
    )


def _around(text: str) -> str | None:
    """Read `N` or `N:K`; give the range of frames as filters have it."""
    if not (found := re.fullmatch(r"([1-9][0-9]{0,9})(?::([0-9]{1,9}))?", text)):
        return None
    number, near = int(found[1]), int(found[2] or _AROUND)
    return f"{max(1, number - near)}-{number + near}"


def _span(text: str) -> str | None:
    """Read `A` or `A-B`; give it as it is."""
    found = re.fullmatch(r"([1-9][0-9]{0,9})(?:-([1-9][0-9]{0,9}))?", text)
    return text if found and int(found[1]) <= int(found[2] or found[1]) else None
