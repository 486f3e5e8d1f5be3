"""`canalyze diagnose`, and `canalyze FILE` without a command: what went wrong, whether it still is, and why.

What went wrong, the core says; how it is laid out, `reports.diagnosis_text`.

Exit codes: 0, whatever was found; with --fail-on 1 where such a problem is there; 2 something could not be read.
"""

import json
import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, Unpack

import click

from canalyze.configuration import network
from canalyze.configuration.options import (
    ANY_PATH,
    SHORT,
    CaptureOptions,
    OneOf,
    bitrate_option,
    capture_options,
    color_option,
    format_option,
    inputs,
    moment,
    open_session,
    positive,
    spelled,
)
from canalyze.errors import ReaderGone, SourceError
from canalyze.output import Output, Progress, jsonl, open_output, told
from canalyze.output.help import Listing
from canalyze.records import KEYS, Overview, Problem, diagnosed, lines, records
from canalyze.reports import wording
from canalyze.running.run import Interrupt, Run
from canalyze.sources.file import CHUNK, STDIN, total_size
from canalyze.sources.names import below, expanded
from canalyze.sources.recordings import Span, recordings
from canalyze.values import nanoseconds
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.reports.diagnosis_text import Chosen

FAIL_ON: Final = {"open": ("open",), "unknown": ("open", "unknown"), "ended": ("open", "unknown", "ended")}
"""What makes the command fail, by --fail-on."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        form: str,
        number: int | None,
        everything: bool,
        join: bool,
        since: float | None,
        node: int | None,
        bus: str | None,
        fail_on: str | None,
        html: str | None,
        frames: str | None,  # of the page before this one, which now has all
        output: str | None,
        force: bool,
        expression: str | None,
        color: str,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        from canalyze.reports import diagnosis_text

        names = inputs(_listed(files), words)
        if expression is not None:  # what goes wrong is no matter of single frames
            raise click.UsageError(words("diagnose.no_filter"), click.get_current_context())
        if html == STDIN:
            raise click.UsageError(words("check.no_stdout", option="--html"), click.get_current_context())
        if html is not None:
            _can_write_page(names, words)
        if number is not None and form != "text":
            raise click.UsageError(words("usage.text_only", option="-n"), click.get_current_context())
        signalled = _keep_stdin() if STDIN in names and (number is not None or html is not None) else 0
        chosen = diagnosis_text.Chosen(node, bus, since)
        with open_output(output, force=force, color=color, hangs=form == "text") as out:
            found = [names] if join or given.get("merge") else _recordings(names, given, words, out)
            if len(found) > 1:
                if number is not None:
                    problem = words("diagnose.one_recording", option="-n", count=len(found))
                    raise click.UsageError(problem, click.get_current_context())
                reading = _Reading((), given, stamps, words)
                code, read = _each(found, reading, out, form, chosen, fail_on)
                if html is not None and read:
                    _write_page(html, read, reading, None, force=force)
                return code
            names = found[0]
            total = total_size(names)
            code, result = _diagnosed(_Reading(names, given, stamps, words), out)
            incidents, whole = diagnosed(result)
            if whole is not None and code < 128:
                _there(chosen, incidents, whole, words)
            shown = _chosen(incidents, whole, chosen)
            numbers = [one.id for one in incidents]
            if number is not None and number not in numbers:
                key = "diagnose.no_problem" if numbers else "diagnose.no_problems"
                problem = words(key, number=number, numbers=wording.ranges(numbers, ", "))
                raise click.UsageError(problem, click.get_current_context())
            with suppress(ReaderGone):  # `| head` has seen enough: of the page and the exit code nobody has said so
                if form == "jsonl":
                    _write_lines(result, shown, out)
                elif whole is not None:
                    every, some = (diagnosis_text.of_buses(those) for those in (incidents, shown))
                    named = tuple(name for name in names if name != STDIN)
                    if number is None:
                        diagnosis_text.show(some, whole, out, words, named, everything=everything, chosen=chosen)
                    else:
                        by_id = {one.id: one for one in every}
                        near = diagnosis_text.near(one for _, one in diagnosis_text.tree(by_id[number], by_id))
                        around = _lines(_Reading(names, given, stamps, words), near)
                        diagnosis_text.tell(number, every, whole, around, out, words, named)
            if html is not None and whole is not None:
                _write_page(html, [names], _Reading(names, given, stamps, words), number, force=force)
            told(code, out, words, stream=total is None, some=whole is not None)
            if whole is None:
                out.drop()
        return code or signalled or int(_fails(shown, fail_on))

    return Listing(
        "diagnose",
        words,
        run,
        [
            spelled(words, "-n number", positive, "positive", "N", "diagnose.number"),
            click.Option(["--all", "everything"], is_flag=True, help=words("diagnose.all")),
            click.Option(["--join"], is_flag=True, help=words("diagnose.join")),
            spelled(words, "--since", moment, "moment", "S", "diagnose.since"),
            spelled(words, "--node", network.node, "node", "N", "diagnose.node"),
            click.Option(["--bus"], metavar="NAME", help=words("diagnose.bus")),
            click.Option(["--html"], type=ANY_PATH, metavar="FILE", help=words("diagnose.html")),
            click.Option(["--frames"], type=OneOf(("near", "all"), words), hidden=True),
            click.Option(["--fail-on"], type=OneOf(tuple(FAIL_ON), words), help=words("diagnose.fail_on")),
            format_option(words, "diagnose"),
            color_option(words),
            bitrate_option(words),
            *_options(words),
        ],
    )


def _options(words: Words) -> Iterator[click.Parameter]:
    """Give what every command that reads captures has; --filter is known only to be refused."""
    own = {one.name for one in SHORT}
    for option in (one for one in capture_options(words) if one.name not in own):
        if isinstance(option, click.Option) and option.name == "expression":
            option.hidden = True
        yield option


def _listed(files: tuple[str, ...]) -> tuple[str, ...]:
    """Return the files, with the captures in a folder in its place; a folder without any stays, to be complained of."""
    return tuple(name for file in files for name in (tuple(below(file)) if Path(file).is_dir() else ()) or (file,))


def _recordings(names: tuple[str, ...], given: CaptureOptions, words: Words, out: Output) -> list[tuple[str, ...]]:
    """Return the files of each recording: files that follow one another are one."""
    every = [one.name for one in expanded(names)]
    # What is no file, as a pipe, can be read only once.
    once = any(name == STDIN or (Path(name).exists() and not Path(name).is_file()) for name in every)
    if len(every) < 2 or once:
        return [tuple(dict.fromkeys(names))]
    progress = Progress(words, out, total_size(names))
    return recordings(_span(name, given, words, progress) for name in every)


def _span(name: str, given: CaptureOptions, words: Words, progress: Progress) -> Span:
    """Return the time and the buses of a file. Its complaints come when it is diagnosed."""
    from canalyze.records.info import Info

    results: list[bytes] = []
    session = open_session(words, given, format="info")
    run = Run(session, words, progress, results.append, given, frameless=True, tell=lambda _: None)
    if (code := run.over((name,))) > 128:
        raise SystemExit(code)
    if (record := next(records(b"".join(results), Info), None)) is None:
        return Span(name, None, None, frozenset())
    buses = frozenset(one.bus for one in record.buses)
    return Span(name, nanoseconds(record.first_t), nanoseconds(record.last_t), buses)


def _diagnosed(reading: "_Reading", out: Output) -> tuple[int, bytes]:
    """Returns the exit code, and the JSON lines of the diagnosis; none if nothing could be read."""
    names, given, stamps, words = reading
    session = open_session(words, given, format="diagnosis", stamps=stamps)
    results: list[bytes] = []
    code = Run(session, words, Progress(words, out, total_size(names)), results.append, given).over(names)
    return code, b"" if code and not session.frames else b"".join(results)


def _each(
    found: list[tuple[str, ...]], reading: "_Reading", out: Output, form: str, chosen: "Chosen", fail_on: str | None
) -> tuple[int, list[tuple[str, ...]]]:
    """Diagnose recordings, each by itself; return the exit code, and the files of those that could be read."""
    from canalyze.reports import diagnosis_text

    rows: list[diagnosis_text.Diagnosed] = []
    worst = 0
    fails = False
    with suppress(ReaderGone):
        for names in found:
            code, result = _diagnosed(reading._replace(names=names), out)
            incidents, whole = diagnosed(result)
            worst = worst or code
            if code >= 128:
                worst = code
                told(code, out, reading.words, stream=False, some=bool(rows))
                break
            shown = _chosen(incidents, whole, chosen)
            fails = fails or _fails(shown, fail_on)
            if whole is None:
                continue
            if form == "jsonl":
                _write_lines(result, shown, out, names)
            rows.append(diagnosis_text.Diagnosed(names, shown, whole.order, whole.nature))
        if form == "text":
            diagnosis_text.show_each(rows, out, reading.words, chosen, unread=len(found) - len(rows))
            diagnosis_text.further_of_each(rows, out, reading.words)
    if not rows:
        out.drop()
    return worst or int(fails), [row.names for row in rows]


def _fails(shown: Iterable[Problem], fail_on: str | None) -> bool:
    fails = FAIL_ON.get(fail_on or "", ())
    return any(one.status in fails and one.is_root for one in shown)


def _there(chosen: "Chosen", incidents: list[Problem], whole: Overview, words: Words) -> None:
    """Raise where the bus or the node that is asked for is not in the capture."""
    places = {(one.bus, one.node) for one in whole.nodes}
    places |= {(one.bus, number) for one in incidents for number in _concerned(one)}
    buses = sorted({bus for bus in (*whole.buses, *(one.bus for one in incidents)) if bus})
    if chosen.bus is not None and chosen.bus not in buses:
        key = "diagnose.no_bus" if buses else "diagnose.no_buses"
        raise SourceError(key, bus=chosen.bus or '""', buses=words("reports.list").join(buses))
    nodes = {node for bus, node in places if chosen.bus in (None, bus)}
    if chosen.node is not None and chosen.node not in nodes:
        if not nodes:
            raise SourceError("diagnose.no_nodes", node=chosen.node)
        key = "diagnose.no_node" if chosen.bus is None else "diagnose.no_node_on"
        raise SourceError(key, node=chosen.node, bus=chosen.bus, nodes=wording.ranges(nodes, ", "))


def _concerned(one: Problem) -> tuple[int, ...]:
    """Returns the nodes of a problem."""
    return one.nodes if one.node is None else (one.node, *one.nodes)


def _write_lines(result: bytes, shown: Iterable[Problem], out: Output, names: tuple[str, ...] = ()) -> None:
    """Write a JSON object for each problem; names: with the files of its recording, where there are several."""
    wanted = {one.id for one in shown}
    for row in map(json.loads, result.splitlines()):
        if row["kind"] != "problem" or row["id"] not in wanted:
            continue
        record = {key: row[key] for key in KEYS} | ({"files": list(names)} if names else {})
        out.write(f"{jsonl.text(record)}\n".encode("utf-8", "backslashreplace"))


def _chosen(incidents: list[Problem], whole: Overview | None, chosen: "Chosen") -> list[Problem]:
    """Give the stories that are asked for, each with all that belongs to it."""
    from canalyze.reports.diagnosis_text import root

    node, bus, since = chosen
    begin = float((whole and whole.begin) or 0)
    by_id = {one.id: one for one in incidents}

    def fits(one: Problem) -> bool:
        late = since is None or one.end is None or one.end.t is None or float(one.end.t) - begin >= since
        about = node is None or node in _concerned(one)
        return late and about and (bus is None or one.bus == bus)

    roots = {root(one, by_id).id for one in incidents if fits(one)}
    return [one for one in incidents if root(one, by_id).id in roots]


class _Reading(NamedTuple):
    """How the capture is read again."""

    names: tuple[str, ...]
    given: CaptureOptions
    stamps: str
    words: Words


def _can_write_page(names: Iterable[str], words: Words) -> None:
    """Raise where the core for the page is missing, or where a capture cannot be read again to be put into it."""
    from canalyze.html import core

    core()
    for name in names:
        if name != STDIN and Path(name).exists() and not Path(name).is_file():
            problem = words("diagnose.html_once", name=wording.capture_name(name))
            raise click.UsageError(problem, click.get_current_context())


def _write_page(html: str, found: list[tuple[str, ...]], reading: _Reading, number: int | None, *, force: bool) -> None:
    """Write the page with the captures inside, which are read again. number: of the problem that it opens on."""
    from canalyze.commands import page

    if STDIN in reading.names:
        os.lseek(0, 0, os.SEEK_SET)
    _, given, stamps, words = reading
    page.write(html, page.pieces(found, given, stamps, words, some=True, problem=number), force=force)


def _keep_stdin() -> int:
    """Let standard input be read again: a pipe is read to its end, or to a signal, into a file without a name.

    Return the exit code that the signal asks for, 0 without one.
    """
    if _is_seekable():
        return 0
    from tempfile import TemporaryFile

    with TemporaryFile() as kept, Interrupt() as interrupt:
        try:
            while data := interrupt.during(lambda: os.read(0, CHUNK)):
                kept.write(data)
            kept.flush()
            os.dup2(kept.fileno(), 0)
        except OSError as error:
            raise SourceError("source.read", name="stdin", error=error) from error
    os.lseek(0, 0, os.SEEK_SET)
    return 128 + interrupt.signal if interrupt.signal else 0


def _is_seekable() -> bool:
    try:
        os.lseek(0, 0, os.SEEK_CUR)
    except OSError:
        return False
    return stat.S_ISREG(os.fstat(0).st_mode)


def _lines(reading: _Reading, wanted: set[int]) -> dict[int, str]:
    """Return the annotated lines of frames: the capture is read again, and complained of no more."""
    names, given, stamps, words = reading
    if STDIN in names:
        os.lseek(0, 0, os.SEEK_SET)
    found: dict[int, str] = {}

    def take(result: bytes) -> None:
        found.update((one.frame, one.text) for one in lines(result) if one.frame in wanted)

    session = open_session(words, given, format="lines", stamps=stamps, time="z")
    Run(session, words, Progress(words, Output(), total_size(names)), take, given, tell=lambda _: None).over(names)
    return found
