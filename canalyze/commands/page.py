"""`canalyze page`: the program as one HTML file, empty or with captures inside."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from canalyze.configuration.options import (
    BITRATE,
    FILES,
    FILTER,
    OUTPUT,
    READING,
    SHORT,
    THREADS,
    CaptureOptions,
    configured,
    known_of,
    open_session,
)
from canalyze.errors import SourceError
from canalyze.output import FileOutput, Output
from canalyze.reports import wording
from canalyze.running.passes import Pass, pass_command
from canalyze.running.reading import Counted
from canalyze.sources import open_capture
from canalyze.sources.names import expanded
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.html import Part


def run(one: Pass) -> int:
    """Writes the page."""
    if one.output is None:
        raise one.usage("page.needs_output")
    names = []
    for found in expanded(one.files):
        if found.error is not None:
            raise found.error
        names.append(found.name)
    recordings = [tuple(names)] if one.merge else [(name,) for name in names]
    size = write(one.output, pieces(recordings, one.given, one.stamps, one.words), force=one.force)
    name = wording.capture_name(one.output)
    Output().text(one.words("page.written", name=name, megabytes=f"{size / 1e6:.1f}") + "\n")
    return 0


def write(name: str, page: Iterable[bytes], *, force: bool) -> int:
    """Writes a page to a file and return its size; nothing stays of a page that fails."""
    size = 0
    with FileOutput(name, force=force) as file:
        for piece in page:
            file.write(piece)
            size += len(piece)
    return size


def pieces(
    recordings: Iterable[Sequence[str]],
    given: CaptureOptions,
    stamps: str,
    words: Words,
    *,
    some: bool = False,
    problem: int | None = None,
) -> Iterator[bytes]:
    """Returns the page with captures inside, each of the files of a recording, read as the options say.

    some: what cannot be read is left out; it was complained of. Else SourceError, also where there is no frame.
    problem: the number of the one that the page opens on.
    """
    from canalyze import html
    from canalyze.configuration.network import network_rows

    filed = configured().known
    options: dict[str, Any] = {
        "stamps": stamps,
        "topics": list(given.get("topic", ())),
        "time_source": given.get("time_source"),
        "mcap_maps": list(given.get("mcap_map", ())),
        "network": network_rows(filed, known_of(given)),
    }
    form = given.get("input_format")
    count = None if some else partial(open_session, words, given, format="info")
    captures = (_opened(names, form, words, count) for names in recordings)
    merge = given.get("merge", False)
    return html.pieces(words.lang, options, captures, merge=merge, some=some, problem=problem)


def _opened(
    names: Iterable[str], form: str | None, words: Words, count: "Callable[[], Session] | None"
) -> Iterator["Part"]:
    """Opens files one after the other, each until the next is wanted; count: what holds no frame is an error."""
    for name in names:
        try:
            with open_capture(name, form) as capture:
                yield Counted(capture, count(), words, given_format=form is not None) if count else capture
        except SourceError:
            if count:
                raise


# How captures are read, as far as the page reads them again.
command = pass_command(
    "page", run, FILES, *(row for row in READING if row not in (FILTER, THREADS, *SHORT)), BITRATE, *OUTPUT
)
