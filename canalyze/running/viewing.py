"""The options of commands that show a timeline, and captures and a live bus on their way to where that is shown.

From options to viewers and files, and to their end; usage errors in the words of the run. A capture is read to its end,
its timeline written to a file, and shown from it. Must not: know what a timeline is made of.
"""

import os
import shlex
import signal
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self, TypedDict

from canalyze.configuration.options import ANY_PATH, CaptureOptions, configured, known_of, option, usage
from canalyze.errors import CanalyzeError, OutputError
from canalyze.output import FileOutput, Output, Progress, complain, hint, told
from canalyze.output.files import in_place
from canalyze.running.passes import Pass
from canalyze.running.run import Interrupt
from canalyze.sources import STDIN
from canalyze.timeline.viewer import (
    LOCAL,
    Viewer,
    address,
    completed,
    free_ports,
    has_chinese,
    load,
    need_display,
    require,
)
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Batch, Session
    from canalyze.timeline.recording import Feed

SUFFIX: Final = ".rrd"
"""Suffix of a timeline's file: Rerun opens no other."""
_EVERY_S: Final = 0.1
"""Interval at which new rows are handed on: ten times a second."""
_STEP_S: Final = 0.1


class ViewingOptions(TypedDict, total=False):
    """The parameters of `VIEWING`, by their names."""

    save: str | None
    web: bool
    bind: str | None
    port: int | None


def port(text: str) -> int | None:
    """Reads the number of a port; those that only the system may use are not accepted."""
    number = int(text) if text.isdecimal() and len(text) < 6 else 0
    return number if 1024 <= number <= 65534 else None


VIEWING: Final = (
    option("--save", "FILE.rrd", topic="timeline", usual=8, type=ANY_PATH),
    option("--web", key="view.web", topic="timeline"),
    option("--bind", "ADDRESS", address, "bind", key="view.bind", topic="timeline"),
    option("--port", "PORT", port, "port", key="view.port", topic="timeline"),
)
"""`ViewingOptions`; --save is in the words of the command."""


def check(given: ViewingOptions, words: Words, *, shown: bool, why_not: tuple[str, str], drawn: bool = True) -> None:
    """Raises for options that do not fit each other, and where this machine cannot do it, before anything is opened.

    shown: there is to be a viewer; else an option of it is a usage error, in the words `why_not` (key, other option).
    drawn: there is to be a timeline at all.
    """
    key, other = why_not
    for name in () if shown else ("web", "bind", "port"):
        if given.get(name):
            raise usage(words, key, one=f"--{name}", option=f"--{name}", other=other)
    save = given.get("save")
    if save is not None and (Path(save).suffix.lower() != SUFFIX or save == "-"):
        raise usage(words, "view.suffix", name=save or '""')
    if drawn:
        require()
    if shown and not given.get("web"):
        need_display()
    if shown:
        free_ports(given.get("bind") or LOCAL, given.get("port"), web=given.get("web", False))


def configuration(given: CaptureOptions) -> list[str]:
    """Returns the known network as texts, so that one can be told from another."""
    known = configured().known.overruled(known_of(given))
    return [str(one) for one in (*known.descriptions, *known.cobs, *known.pdos, *known.profiles, *known.sdos)]


def open_viewer(given: ViewingOptions, path: str | None = None) -> Viewer:
    """Starts a viewer as the options say; CanalyzeError where that cannot be."""
    return Viewer(path=path, bind=given.get("bind") or LOCAL, port=given.get("port"), web=given.get("web", False))


def drawn_in(words: Words, tell: Callable[[str], None], *, web: bool) -> Words:
    """Returns the words of a timeline that is shown: English where no font has Chinese; `tell` gets a line then."""
    if words.lang != "zh" or has_chinese(web=web):
        return words
    tell(words("view.no_font_page" if web else "view.no_font"))
    return Words("en")


def opened(viewer: Viewer, given: ViewingOptions, words: Words) -> list[str]:
    """Returns what is to be reported of a viewer that is ready, a line each."""
    lines = [words("view.page", url=viewer.page)] if viewer.page else []
    bind = given.get("bind") or LOCAL
    if not (bind.startswith("127.") or bind == "::1"):
        lines.append(words("view.exposed", address=bind))
    return lines


class _Way(NamedTuple):
    """Where a live bus goes."""

    feed: "Feed"
    file: str
    """The file that is written; "" for the viewer."""


class Showing:
    """A live bus in a viewer, in a file, or both, as it comes; a context manager."""

    def __init__(self, given: ViewingOptions, words: Words, *, shown: bool, force: bool) -> None:
        """Starts the viewer if it is to be shown, and claims the file; CanalyzeError for what cannot be."""
        self._given = given
        self._words = words
        self._file = _claim(given.get("save"), force=force)
        self._viewer = open_viewer(given) if shown else None
        self._ways: list[_Way] = []
        self._every: list[_Way] = []
        self._next = 0.0

    def begin(
        self, name: str, settings: CaptureOptions, tell: Callable[[str], None], unless: Callable[[], bool]
    ) -> None:
        """Waits until the viewer is ready; CanalyzeError where it never is.

        tell: gets what is to be known of it. unless: ends the waiting; nothing is shown then.
        """
        load()
        from canalyze.timeline.recording import Feed, Timeline

        facts: dict[str, Any] = {"name": name, "configuration": configuration(settings), "live": True}
        if self._viewer is not None:
            self._viewer.ready(unless)
            if not unless():
                for line in opened(self._viewer, self._given, self._words):
                    tell(line)
                self._ways.append(_Way(Feed(Timeline(self._words, connect=self._viewer.connect, **facts)), ""))
        if self._file is not None:
            self._ways.append(_Way(Feed(Timeline(self._words, save=self._file, **facts)), self._file))
        self._every = list(self._ways)

    def step(self, session: "Session", tell: Callable[[str], None]) -> None:
        """Hands on what came, ten times a second at most; never waits. tell: gets what has gone wrong."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _EVERY_S
        self._give(session.batches(flush=True), tell)

    def complete(self, session: "Session", seen: Sequence[str], tell: Callable[[str], None]) -> list[str]:
        """Hands on the rest and completes the file; returns what is to be reported of it, a line each.

        seen: what there was, for the summary on the timeline.
        """
        self._give(session.batches(), tell)
        for way in self._every:
            way.feed.end(seen)
        lines = []
        for feed, file in self._every:
            if file:
                while not feed.ended(_STEP_S):
                    pass
                self._complain(feed, file, tell)
                self._join(feed, file, tell)
                if feed.failure is None and (size := _size(file)):
                    lines.append(self._words("view.written", name=file, size=f"{size / 1e6:.1f}"))
            if feed.left_out:
                key = "view.left_out_file" if file else "view.left_out"
                lines.append(self._words(key, count=feed.left_out, name=file))
        return lines

    @property
    def failed(self) -> bool:
        """True if the file was broken off."""
        return any(way.file and way.feed.failure for way in self._every)

    @property
    def stays(self) -> str:
        """The line about a viewer that is still open; "" without one."""
        if self._viewer is None or not self._viewer.running or all(way.file for way in self._every):
            return ""
        return self._words("view.stays_page" if self._viewer.page else "view.stays", url=self._viewer.page)

    def wait(self) -> None:
        """Waits until the user has closed the viewer."""
        if self._viewer is not None:
            self._viewer.wait()

    def close(self) -> None:
        """Ends the viewer, and what was on its way to it; in bounded time."""
        if self._viewer is not None:
            self._viewer.close()
        for way in self._every:
            way.feed.end()
            way.feed.ended(1.0)
        if self._file is not None and _size(self._file) == 0:  # nothing came
            with suppress(OSError):
                Path(self._file).unlink()

    def __enter__(self) -> Self:
        """Returns it."""
        return self

    def __exit__(self, *_: object) -> None:
        """Ends it."""
        self.close()

    def _give(self, batches: "Iterable[tuple[str, Batch]]", tell: Callable[[str], None]) -> None:
        given = list(batches)
        for way in list(self._ways):
            if way.feed.failure is not None or (not way.file and not self._watched(tell)):
                self._ways.remove(way)
                self._complain(*way, tell)
            else:
                way.feed.give(given)

    def _join(self, feed: "Feed", file: str, tell: Callable[[str], None]) -> None:
        """Puts a file that was written in pieces in order, and ends it."""
        if feed.failure is None and _size(file):
            try:
                completed(file)
            except OutputError as error:
                tell(error.in_words(self._words))

    def _watched(self, tell: Callable[[str], None]) -> bool:
        """Returns true if the viewer is still open."""
        if self._viewer is None or self._viewer.running:
            return True
        failure = self._viewer.failure
        tell(self._words("view.lost", **failure.facts) if failure else self._words("view.closed"))
        return False

    def _complain(self, feed: "Feed", file: str, tell: Callable[[str], None]) -> None:
        error = feed.failure
        if error is None or (not file and self._viewer is not None and not self._viewer.running):
            return
        if isinstance(error, CanalyzeError):
            tell(error.in_words(self._words))
        else:
            problem = " ".join(f"{type(error).__name__}: {error}".split())[:300]
            tell(self._words("view.broken", name=file or self._words("view.viewer"), problem=problem))


def _claim(name: str | None, *, force: bool) -> str | None:
    """Claims the file that is written; OutputError if it exists and is not to be replaced, or cannot be written.

    It is written in its place, as recordings are: a process that is killed leaves what was seen.
    """
    if name is None:
        return None
    try:
        os.close(in_place(name, force=force, typed=True))
    except FileExistsError as error:
        raise OutputError("output.exists", name=name) from error
    except (OSError, ValueError) as error:
        raise OutputError("output.write", name=name, error=error) from error
    return name


def _size(name: str) -> int:
    try:
        return Path(name).stat().st_size
    except OSError:
        return 0


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
