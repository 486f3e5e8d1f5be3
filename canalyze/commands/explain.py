"""`canalyze explain`: one frame, field by field. The core reads the frame and finds the words; this joins and asks."""

import sys

import click

from canalyze.help import Command
from canalyze.output import Output, complain
from canalyze.run import piped
from canalyze.words import Words


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(frame: tuple[str, ...]) -> int:
        if frame == ("-",) or (not frame and piped()):
            return _lines(words)
        if not frame:
            raise click.UsageError(words("explain.nothing"), click.get_current_context())
        from canalyze._core import explain

        line = " ".join(frame)
        text = explain(line, words.lang)
        if text is None:
            complain(f"canalyze: {words('explain.no_frame', line=line or repr(line))}")
            return 2
        Output().text(text.rstrip("\n") + "\n")
        return 0

    return Command(
        "explain",
        words,
        run,
        [click.Argument(["frame"], nargs=-1, type=click.UNPROCESSED, metavar="FRAME")],
    )


def _lines(words: Words) -> int:
    """Explain each line of standard input when it comes, with a blank line between; blank lines are skipped."""
    from canalyze._core import explain

    out = Output()
    code = 0
    between = ""
    for number, raw in enumerate(sys.stdin.buffer, 1):
        line = raw.decode("utf-8", "replace").strip()
        if not line:
            continue
        text = explain(line, words.lang)
        if text is None:
            complain(f"canalyze: {words('explain.no_frame_at', name='stdin', number=number, line=line)}")
            code = 2
            continue
        out.text(between + text.rstrip("\n") + "\n")
        between = "\n"
    if not between and not code:
        complain(f"canalyze: {words('source.empty', name='stdin')}")
        code = 2
    return code
