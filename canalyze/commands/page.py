"""`canalyze page`: the program as one HTML file, empty or with captures inside."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import click

from canalyze.configuration.config import Config
from canalyze.configuration.options import (
    ANY_PATH,
    SHORT,
    CaptureOptions,
    bitrate_option,
    known_of,
    output_options,
    reading_options,
)
from canalyze.errors import SourceError
from canalyze.output import FileOutput, Output
from canalyze.output.help import Command
from canalyze.reports import wording
from canalyze.sources.format import open_capture
from canalyze.sources.names import expanded
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.html import Part


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...], output: str | None, force: bool, stamps: str, **given: Unpack[CaptureOptions]
    ) -> int:
        if output is None:
            raise click.UsageError(words("page.needs_output"), click.get_current_context())
        names = []
        for one in expanded(files):
            if one.error is not None:
                raise one.error
            names.append(one.name)
        made = page([tuple(names)] if given.get("merge") else [(name,) for name in names], given, stamps, words)
        with FileOutput(output, force=force) as file:
            file.write(made)
        name = wording.capture_name(output)
        Output().text(words("page.written", name=name, megabytes=f"{len(made) / 1e6:.1f}") + "\n")
        return 0

    return Command(
        "page",
        words,
        run,
        [
            click.Argument(["files"], nargs=-1, type=ANY_PATH, metavar="FILE"),
            *_reading_options(words),
            bitrate_option(words),
            *output_options(words),
        ],
    )


def _reading_options(words: Words) -> Iterator[click.Parameter]:
    """Return how captures are read, as far as the page reads them again."""
    left_out = {"expression", "threads", *(one.name for one in SHORT)}
    return (one for one in reading_options(words) if one.name not in left_out)


def page(
    recordings: Iterable[Sequence[str]], given: CaptureOptions, stamps: str, words: Words, *, some: bool = False
) -> bytes:
    """Return the page with captures inside, each of the files of a recording, read as the options say.

    some: files that cannot be read are left out; they were complained of.
    """
    from canalyze import html
    from canalyze.configuration.descriptions import network_rows

    filed = (click.get_current_context().find_object(Config) or Config()).known
    options: dict[str, Any] = {
        "stamps": stamps,
        "topics": list(given.get("topic", ())),
        "time_source": given.get("time_source"),
        "mcap_maps": list(given.get("mcap_map", ())),
        "network": network_rows(filed, known_of(given)),
    }
    form = given.get("input_format")
    captures = [list(_parts(names, form, some=some)) for names in recordings]
    return html.page(words.lang, options, captures, merge=given.get("merge", False))


def _parts(names: Iterable[str], form: str | None, *, some: bool) -> Iterator["Part"]:
    for name in names:
        try:
            yield _part(name, form)
        except SourceError:
            if not some:
                raise


def _part(name: str, form: str | None) -> "Part":
    """Read a file whole, unpacked, as a session is fed."""
    from canalyze.html import Part

    with open_capture(name, form) as capture:
        data = b"".join(iter(capture.read, b""))
        damage = None
        if capture.damage:
            kind, offset, lost, since = capture.damage
            kind, offset = (kind, offset) if since is None else ("doubtful", since)
            damage = {"kind": kind, "offset": offset, "bytes": lost}
        return Part(Path(name).name, capture.format, data, damage)
