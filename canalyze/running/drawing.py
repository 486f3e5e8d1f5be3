"""A capture as a timeline: read to its end, written to a file, and shown from it.

Must not: know what is on a timeline.
"""

import shlex
import signal
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import TYPE_CHECKING

from canalyze.errors import OutputError
from canalyze.output import FileOutput, Output, Progress, complain, hint, told
from canalyze.running.passes import Pass
from canalyze.running.run import Interrupt
from canalyze.running.viewing import ViewingOptions, configuration, open_viewer, opened
from canalyze.sources.file import STDIN
from canalyze.timeline.viewer import load
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session


def save(one: Pass, session: "Session", name: str) -> int:
    """Writes the timeline to a file that is there when it is complete; returns the exit code."""
    with Interrupt() as ended, FileOutput(name, force=one.force) as out:
        try:
            code = write(one, session, out.path, out, one.words, ended)
        except OutputError as error:  # it knows the file by the name that it has until it is complete
            raise OutputError(error.key, **error.facts | {"name": name}) from error
        code = 128 + ended.signal if ended.signal else code
        if session.frames == 0:
            out.drop()
        # A stream, too, has lanes without their ends here.
        told(code, out, one.words, stream=False, some=session.frames > 0 and Path(out.path).stat().st_size > 0)
    if not code and session.frames:
        hint(f"canalyze: {one.words('view.ready_to_open', save=shlex.quote(name))}")
    return code


def write(one: Pass, session: "Session", path: str, out: Output, drawn: Words, ended: Interrupt) -> int:
    """Reads captures to their end and writes their timeline; returns the exit code.

    drawn: the language of the timeline. ended: a signal before this.
    """
    load()
    from canalyze.timeline.recording import Timeline

    if ended.signal:
        return 128 + ended.signal
    one.progress = Progress(one.words, out, one.total)
    timeline = Timeline(drawn, name=readable(one.names), save=path, configuration=configuration(one.given))
    summary: list[bytes] = []
    # The core reads on while its last rows are written; never further, so that memory does not grow.
    underway: Future[None] = Future()
    underway.set_result(None)

    def take(result: bytes) -> None:
        nonlocal underway
        summary.append(result)
        batches = session.batches()
        underway.result()
        underway = writer.submit(timeline.take, batches)

    complete = False
    with ThreadPoolExecutor(1, "canalyze-timeline") as writer:
        try:
            code = one.read(session, take)
            underway.result()
            complete = code < 128 and session.frames > 0
            if complete:
                timeline.finish(b"".join(summary))
        finally:
            if not complete:
                wait([underway])
                timeline.close()
    return code


def show(path: str, given: ViewingOptions, words: Words) -> int:
    """Shows a recording until the user has seen enough; returns the exit code."""
    with Interrupt() as interrupt, open_viewer(given, path) as viewer:
        interrupt.during(viewer.ready)
        if not interrupt.signal:
            lines = opened(viewer, given, words)
            for line in [*lines, *([words("view.until")] if viewer.page else [])]:
                complain(f"canalyze: {line}")
        interrupt.during(viewer.wait)
        if failure := viewer.failure:
            raise failure
    return 128 + interrupt.signal if interrupt.signal not in (0, signal.SIGINT) else 0


def readable(names: tuple[str, ...]) -> str:
    """Returns the name of the recording."""
    first = "stdin" if names[0] == STDIN else Path(names[0]).name
    return first if len(names) == 1 else f"{first}+{len(names) - 1}"
