"""`canalyze view`: a capture as a timeline, in Rerun's viewer or in a file for it.

What is on the timeline stands in `timeline/`, which alone needs Rerun. The capture is read to its end first and written
to a file beside; the viewer shows that file, which goes when the viewer is closed.
"""

import shlex
import signal
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final, Unpack

import click
from click.core import ParameterSource

from canalyze.configuration.options import (
    ANY_PATH,
    CaptureOptions,
    bitrate_option,
    inputs,
    open_session,
    problem_option,
    reading_options,
)
from canalyze.errors import OutputError, SourceError
from canalyze.output import FileOutput, Output, Progress, complain, hint, told
from canalyze.output.help import Command
from canalyze.running.run import Interrupt, Run
from canalyze.running.viewing import (
    SUFFIX,
    ViewingOptions,
    check,
    configuration,
    drawn_in,
    open_viewer,
    opened,
    viewing_options,
)
from canalyze.sources.file import STDIN, total_size
from canalyze.timeline import TABLES
from canalyze.timeline.viewer import load
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session

_OF_VIEWER: Final = frozenset({"files", *ViewingOptions.__annotations__})
"""Parameters that say how a timeline is shown, not what is on it."""
_MAGIC: Final = b"RRF"
"""How the files of Rerun begin."""


class _Given(CaptureOptions, ViewingOptions, total=False):
    """What the command is given."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(files: tuple[str, ...], force: bool, expression: str | None, stamps: str, **given: Unpack[_Given]) -> int:
        save = given.get("save")
        check(given, words, shown=save is None, why_not=("usage.exclusive", "--save"))
        names = inputs(files, words)
        _check_names(names, save)
        if _suffix(names[0]) == SUFFIX:
            _check_options(words)
            return _show(_timeline(names[0]), given, words)
        drawn = words if save is not None else drawn_in(words, _tell, web=given.get("web", False))
        session = open_session(drawn, given, format="summary", tables=TABLES, stamps=stamps, filter=expression)
        if save is not None:
            return _save(session, names, save, given, words, force=force)
        # Whatever ends it, and when: the folder goes, and the viewer with it.
        with (
            Interrupt() as ended,
            TemporaryDirectory(prefix="canalyze-", ignore_cleanup_errors=True) as folder,
        ):
            path = str(Path(folder) / f"{_readable(names)}{SUFFIX}")
            progress = Progress(words, Output(), total_size(names))
            code = _write(session, names, path, progress, given, (words, drawn), ended)
            if ended.signal or session.frames == 0 or code >= 128:
                return 128 + ended.signal if ended.signal else code
            return _show(path, given, words) or code

    return Command(
        "view",
        words,
        run,
        [
            click.Argument(["files"], nargs=-1, type=ANY_PATH, metavar="FILE"),
            *viewing_options(words, "view"),
            bitrate_option(words),
            problem_option(words),
            *reading_options(words),
            click.Option(["--force"], is_flag=True, help=words("opt.force")),
        ],
    )


def _tell(line: str) -> None:
    complain(f"canalyze: {line}")


def _suffix(name: str) -> str:
    return Path(name).suffix.lower()


def _check_names(names: tuple[str, ...], save: str | None) -> None:
    """Make sure that what this command has written is not taken for a capture; SourceError where it is."""
    for name in names:
        if _suffix(name) == SUFFIX and (len(names) > 1 or save is not None):
            raise SourceError("view.ready", name=name)


def _check_options(words: Words) -> None:
    """Make sure that nothing is asked of a timeline that is ready: what is on it is there already."""
    context = click.get_current_context()
    for param in context.command.params:
        given = context.get_parameter_source(param.name or "") is ParameterSource.COMMANDLINE
        if given and param.name not in _OF_VIEWER:
            raise click.UsageError(words("view.too_late", option=param.opts[0]), context)


def _save(session: "Session", names: tuple[str, ...], save: str, given: _Given, words: Words, *, force: bool) -> int:
    """Write the timeline to a file that is there when it is complete; give the exit code."""
    with Interrupt() as ended, FileOutput(save, force=force) as out:
        try:
            progress = Progress(words, out, total_size(names))
            code = _write(session, names, out.path, progress, given, (words, words), ended)
        except OutputError as error:  # it knows the file by the name that it has until it is complete
            raise OutputError(error.key, **error.facts | {"name": save}) from error
        code = 128 + ended.signal if ended.signal else code
        if session.frames == 0:
            out.drop()
        # A stream, too, has lanes without their ends here.
        told(code, out, words, stream=False, some=session.frames > 0 and Path(out.path).stat().st_size > 0)
    if not code and session.frames:
        hint(f"canalyze: {words('view.ready_to_open', save=shlex.quote(save))}")
    return code


def _write(
    session: "Session",
    names: tuple[str, ...],
    path: str,
    progress: Progress,
    given: _Given,
    languages: tuple[Words, Words],
    ended: Interrupt,
) -> int:
    """Read captures to their end and write their timeline; give the exit code.

    languages: that of the run, and that of the timeline.
    """
    load()
    from canalyze.timeline.recording import Timeline

    if ended.signal:
        return 128 + ended.signal
    words, drawn = languages
    timeline = Timeline(drawn, name=_readable(names), save=path, configuration=configuration(given))
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
            code = Run(session, words, progress, take, given).over(names)
            underway.result()
            complete = code < 128 and session.frames > 0
            if complete:
                timeline.finish(b"".join(summary))
        finally:
            if not complete:
                wait([underway])
                timeline.close()
    return code


def _show(path: str, given: _Given, words: Words) -> int:
    """Show a recording until the user has seen enough; give the exit code."""
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


def _readable(names: tuple[str, ...]) -> str:
    """Give what the recording is called."""
    first = "stdin" if names[0] == STDIN else Path(names[0]).name
    return first if len(names) == 1 else f"{first}+{len(names) - 1}"


def _timeline(name: str) -> str:
    """Make sure that a file is a timeline already; SourceError where it is not."""
    try:
        with Path(name).open("rb") as file:
            head = file.read(len(_MAGIC))
    except (OSError, ValueError) as error:
        raise SourceError("source.open", name=name, error=error) from error
    if head != _MAGIC:
        raise SourceError("view.no_timeline", name=name)
    return name
