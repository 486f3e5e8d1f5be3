"""`canalyze diff`: two captures compared as CANopen. What differs, and in which words, the core says.

The lines around the first difference are read in a second pass, of that part only; a pipe cannot be read twice and has
none.
"""

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Unpack

import click

from canalyze.configuration.options import (
    ANY_PATH,
    CaptureOptions,
    format_option,
    open_session,
    output_options,
    reading_options,
    spelled,
)
from canalyze.errors import ReaderGone
from canalyze.output import Progress, open_output, told
from canalyze.output.help import Listing
from canalyze.running.run import Run
from canalyze.sources.file import STDIN, total_size
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session

AROUND: Final = 3
"""Frames that are shown before and behind the first difference."""
_MOST: Final = 1000.0
"""The greatest tolerance in percent."""


class _Enough(Exception):
    """Ends the second pass behind the frames that are shown."""


class _Silent(Run):
    """A second pass: what is to be complained of was said in the first."""

    def complain(self, line: str) -> None:
        """Say nothing."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        form: str,
        tolerance: float,
        bus: tuple[tuple[str, str], ...],
        output: str | None,
        force: bool,
        expression: str | None,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        from canalyze._core import Comparison

        if len(files) != 2 or files == (STDIN, STDIN):
            raise click.UsageError(words("diff.two", count=len(files)), click.get_current_context())
        sessions = [open_session(words, given, format="digest", stamps=stamps, filter=expression) for _ in files]
        code = 0
        with open_output(output, force=force) as out:
            total = total_size(files)
            progress = Progress(words, out, total)
            for name, session in zip(files, sessions, strict=True):
                ended = Run(session, words, progress, lambda _: None, given).over((name,))
                code = max(code, ended)
                if ended >= 128:
                    break
            told(code, out, words, stream=total is None, some=False)
            if code >= 128 or not all(session.frames for session in sessions):
                out.drop()
                return code or 2
            found = Comparison(
                *sessions, names=_names(files), lang=words.lang, tolerance=tolerance / 100, buses=list(bus)
            )
            _there(bus, found.buses, words)
            with suppress(ReaderGone):  # who has read enough has not been told that they are alike
                if form == "jsonl":
                    out.write(found.jsonl())
                else:
                    out.shown(found.head())
                    for side, name, frame in zip("AB", files, found.first(), strict=True):
                        lines = _around(name, frame, words, stamps, given)
                        out.shown(b"".join(b"  %s %s\n" % (side.encode(), line) for line in lines))
                    out.shown(found.body())
        return code or int(found.differences > 0)

    return Listing(
        "diff",
        words,
        run,
        [
            click.Argument(["files"], nargs=-1, type=ANY_PATH, metavar="A B"),
            format_option(words, "diff"),
            spelled(words, "--tolerance", _percent, "percent", "PERCENT", "diff.tolerance", default="10"),
            spelled(words, "--bus", _buses, "bus_pair", "A=B", "diff.bus", multiple=True),
            *(option for option in reading_options(words) if option.name != "merge"),
            *output_options(words),
        ],
    )


def _there(pairs: tuple[tuple[str, str], ...], buses: tuple[list[str], list[str]], words: Words) -> None:
    """Raise UsageError for a bus that is not in its capture: what was meant would silently not hold."""
    for pair in pairs:
        for side, name, there in zip("AB", pair, buses, strict=True):
            if name not in there:
                known = words("check.between").join(there) or words("diff.unnamed")
                problem = words("diff.no_bus", side=side, name=name, there=known)
                raise click.UsageError(problem, click.get_current_context())


def _percent(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if 0 <= value <= _MOST else None


def _buses(text: str) -> tuple[str, str] | None:
    a, equals, b = text.partition("=")
    return (a, b) if equals else None


def _names(files: tuple[str, ...]) -> tuple[str, str]:
    a, b = (os.fsencode(name).decode("utf-8", "backslashreplace") for name in files)
    return a, b


def _around(name: str, frame: int | None, words: Words, stamps: str, given: CaptureOptions) -> Iterator[bytes]:
    """Give the annotated lines around a frame, that of the frame itself marked."""
    if frame is None or name == STDIN or not Path(name).is_file():
        return
    first, last = max(1, frame - AROUND), frame + AROUND
    session = open_session(words, given, format="text", stamps=stamps, filter=f"frame={first}-{last}")
    number = first - 1
    for line in _lines(session, name, last, words, given):
        is_frame = not line.startswith(b"#")
        number += is_frame
        yield (b"> " if is_frame and number == frame else b"  ") + line


def _lines(session: "Session", name: str, last: int, words: Words, given: CaptureOptions) -> list[bytes]:
    from canalyze.output import Output

    taken: list[bytes] = []

    def take(result: bytes) -> None:
        taken.append(result)
        if session.frames > last:
            raise _Enough

    quiet: Any = Progress(words, Output(), 0)
    quiet.step = lambda *_: None
    with suppress(_Enough):
        _Silent(session, words, quiet, take, given).over((name,))
    return b"".join(taken).splitlines()
