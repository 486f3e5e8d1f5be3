"""Captures read more than once: recordings that are diagnosed, and what options need beforehand.

Descriptions that devices hold themselves: what was read of 1021h, or written to it, becomes a file that counts as one
of `--eds` for its node. Only what is whole and reads as a description is used; any other is reported.

The short forms of --filter, as conditions of its expression: what they choose and what the expression chooses must both
hold. A problem is found by a diagnosis.

Recordings are diagnosed one, or several, each by itself: standard input is kept, files that follow one another are one.
Must not: overrule what the user has said of a node, judge, read an expression or an option's text.
"""

import json
import os
import re
import stat
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from canalyze.configuration.network import Carrier, Description, Known, carriers, network
from canalyze.configuration.options import PROBLEM, SHORT, configured, known_of, open_session, start_session, usage
from canalyze.errors import ReaderGone, SourceError, as_error
from canalyze.output import Output, Progress, complain, json_text, told
from canalyze.records import records
from canalyze.records.objects import Transfer
from canalyze.records.problems import KEYS, Problem, diagnosed, lines
from canalyze.records.summary import Info
from canalyze.reports import diagnosis, wording
from canalyze.reports.diagnosis import Chosen, Diagnosed, fails, near, select, tree
from canalyze.reports.wording import ranges
from canalyze.running.run import Interrupt, NoProgress, Run
from canalyze.sources import CHUNK, STDIN, total_size
from canalyze.sources.names import Span, below, expanded, recordings
from canalyze.values import nanoseconds
from canalyze.words import Words

if TYPE_CHECKING:
    import click

    from canalyze.running.passes import Pass

_STORED: Final = "1021"
_FORMAT: Final = "1022"
_OF_THESE: Final = re.compile(f"_({_STORED}|{_FORMAT})h_")
"""In the names that the core has for the data of a transfer."""


def describe(context: "click.Context", words: Words) -> None:
    """Adds the descriptions in the command's files to its `--eds`; a line each to standard error."""
    from tempfile import TemporaryDirectory

    from canalyze.dictionary import read

    names = context.params["files"]
    if not names or STDIN in names:
        raise usage(words, "stored.stdin")
    given: Any = context.params
    filed = configured().known
    told = carriers(filed, known_of(given), {})
    folder = Path(context.with_resource(TemporaryDirectory(prefix="canalyze-")))
    held, formats = _held(tuple(one.name for one in expanded(names) if one.error is None), words, context)
    if not held:
        complain(f"canalyze: {words('stored.none')}")
    for (bus, node), (data, status) in held.items():
        name = f"1021h-node{node}{'' if bus is None else re.sub('[^0-9A-Za-z]', '_', f'-{bus}')}.eds"
        facts = {"node": node, "size": len(data), "format": formats.get((bus, node), "?")}
        if (bus, node) in told or (None, node) in told:
            complain(f"canalyze: {words('stored.told', **facts)}")
        elif status != "ok":
            complain(f"canalyze: {words('stored.incomplete', **facts, status=words.of('status', status))}")
        else:
            try:
                objects = len(read(data, name).objects)
            except SourceError:
                complain(f"canalyze: {words('stored.unreadable', **facts)}")
                continue
            (folder / name).write_bytes(data)
            given["eds"] += (Description(None if bus is None else os.fsdecode(bus), (node,), str(folder / name)),)
            complain(f"canalyze: {words('stored.used', **facts, objects=objects)}")


def _held(
    names: tuple[str, ...], words: Words, context: "click.Context"
) -> tuple[dict[Carrier, tuple[bytes, str]], dict[Carrier, int]]:
    """Returns the last whole value of 1021h with its status, and of 1022h, its form."""
    given: Any = context.params
    sdos = network(Known(), Known(sdos=given["sdo"]), None)
    session = start_session(words, given, format="columns", extract=True, network=sdos)
    parts: defaultdict[str, bytes] = defaultdict(bytes)
    held: dict[Carrier, tuple[bytes, str]] = {}
    formats: dict[Carrier, int] = {}

    def take(_: bytes) -> None:
        for name, data, status, holes, line in session.extracted():
            if not (which := _OF_THESE.search(name)):
                continue
            parts[name] += data
            if not status:
                continue
            about = next(records(line.encode(), Transfer))
            carrier = about.bus, about.node
            if which[1] == _FORMAT and status == "ok" and isinstance(about.value, int):
                formats[carrier] = about.value
            elif which[1] == _STORED and (parts[name] or status == "ok"):
                ended = "incomplete" if holes else status
                if ended == "ok" or held.get(carrier, (b"", ""))[1] != "ok":
                    held[carrier] = parts[name], ended
            del parts[name]

    code = Run(session, words, NoProgress(), take, given, tell=lambda _: None).over(names)
    if code >= 128:
        context.exit(code)
    return held, formats


def choose(context: "click.Context", words: Words) -> None:
    """Adds the conditions of the short forms before the expression of --filter."""
    given = context.params
    conditions = [given.get(one.name) for one in SHORT]
    if (number := given.get(PROBLEM.name)) is not None:
        conditions.append(_near(number, context, words))
    # An expression whose last quotation mark is missing goes on to its end: it comes last.
    given["expression"] = " ".join(filter(None, [*conditions, given["expression"]])) or None


def _near(number: int, context: "click.Context", words: Words) -> str | None:
    """Returns the condition for the frames around a problem and what comes from it; None if nothing could be read."""
    given: Any = context.params
    names = given["files"]
    if not names or STDIN in names:
        raise usage(words, "opt.problem_stdin")
    session = open_session(words, given, format="diagnosis", stamps=given["stamps"])
    results: list[bytes] = []
    progress = Progress(words, Output(), total_size(names), until_output=True)
    code = Run(session, words, progress, results.append, given, tell=lambda _: None).over(names)
    if code >= 128:
        context.exit(code)
    if not session.frames:
        return None
    by_id = {one.id: one for one in records(b"".join(results), Problem)}
    if number not in by_id:
        key = "diagnose.no_problem" if by_id else "diagnose.no_problems"
        raise usage(words, key, number=number, numbers=ranges(by_id, ", "))
    frames = near(one for _, one in tree(by_id[number], by_id))
    return f"frame={ranges((frame for frame in frames if frame > 0), ',')}"


def diagnose(one: "Pass", names: tuple[str, ...] = ()) -> tuple[int, bytes]:
    """Returns the exit code, and the JSON lines of the diagnosis; none if nothing could be read."""
    session = one.session(format="diagnosis")
    results: list[bytes] = []
    one.progress = Progress(one.words, one.out, total_size(names or one.names))
    code = one.read(session, results.append, names)
    return code, b"" if code and not session.frames else b"".join(results)


def each(one: "Pass", found: list[tuple[str, ...]], chosen: Chosen) -> tuple[int, list[tuple[str, ...]]]:
    """Diagnoses recordings, each by itself; returns the exit code, and the files of those that could be read."""
    rows: list[Diagnosed] = []
    worst = 0
    failing = False
    with suppress(ReaderGone):
        for names in found:
            code, result = diagnose(one, names)
            incidents, whole = diagnosed(result)
            worst = worst or code
            if code >= 128:
                worst = code
                told(code, one.out, one.words, stream=False, some=bool(rows))
                break
            shown = select(incidents, whole, chosen)
            failing = failing or fails(shown, one.fail_on)
            if whole is None:
                continue
            if one.form == "jsonl":
                write_lines(result, shown, one.out, names)
            rows.append(Diagnosed(names, shown, whole.order, whole.nature))
        if one.form == "text":
            diagnosis.show_each(rows, one.out, one.words, chosen, unread=len(found) - len(rows))
            diagnosis.further_of_each(rows, one.out, one.words)
    if not rows:
        one.out.drop()
    return worst or int(failing), [row.names for row in rows]


def write_lines(result: bytes, shown: Iterable[Problem], out: Output, names: tuple[str, ...] = ()) -> None:
    """Writes a JSON object for each problem; names: with the files of its recording, where there are several."""
    wanted = {one.id for one in shown}
    for row in map(json.loads, result.splitlines()):
        if row["kind"] != "problem" or row["id"] not in wanted:
            continue
        record = {key: row[key] for key in KEYS} | ({"files": list(names)} if names else {})
        out.write(f"{json_text(record)}\n".encode("utf-8", "backslashreplace"))


AROUND: Final = 3
"""Frames that are shown before and behind one."""


class _Enough(Exception):
    """Ends the second pass behind the frames that are shown."""


def listed(files: tuple[str, ...]) -> tuple[str, ...]:
    """Returns the files, with the captures in a folder in its place; a folder without any stays, which is an error."""
    return tuple(name for file in files for name in (tuple(below(file)) if Path(file).is_dir() else ()) or (file,))


def recordings_of(one: "Pass") -> list[tuple[str, ...]]:
    """Returns the files of each recording: files that follow one another are one."""
    every = [found.name for found in expanded(one.names)]
    # What is no file, as a pipe, can be read only once.
    once = any(name == STDIN or (Path(name).exists() and not Path(name).is_file()) for name in every)
    if len(every) < 2 or once:
        return [tuple(dict.fromkeys(one.names))]
    return recordings(_span(one, name) for name in every)


def _span(one: "Pass", name: str) -> Span:
    """Returns the time and the buses of a file. Its complaints come when it is diagnosed."""
    results: list[bytes] = []
    session = open_session(one.words, one.given, format="info")
    if (code := one.read(session, results.append, (name,), frameless=True, tell=lambda _: None)) > 128:
        raise SystemExit(code)
    if (record := next(records(b"".join(results), Info), None)) is None:
        return Span(name, None, None, frozenset())
    buses = frozenset(found.bus for found in record.buses)
    return Span(name, nanoseconds(record.first_t), nanoseconds(record.last_t), buses)


def keep_stdin() -> int:
    """Lets standard input be read again: a pipe is read to its end, or to a signal, into a file without a name.

    Returns the exit code that the signal asks for, 0 without one.
    """
    if _is_seekable():
        return 0
    from tempfile import TemporaryFile

    with TemporaryFile() as kept, Interrupt() as interrupt, as_error(SourceError, "source.read", name="stdin"):
        while data := interrupt.during(lambda: os.read(0, CHUNK)):
            kept.write(data)
        kept.flush()
        os.dup2(kept.fileno(), 0)
    os.lseek(0, 0, os.SEEK_SET)
    return 128 + interrupt.signal if interrupt.signal else 0


def _is_seekable() -> bool:
    try:
        os.lseek(0, 0, os.SEEK_CUR)
    except OSError:
        return False
    return stat.S_ISREG(os.fstat(0).st_mode)


def rewind(one: "Pass") -> None:
    """Lets standard input that was kept be read from its beginning."""
    if STDIN in one.names:
        os.lseek(0, 0, os.SEEK_SET)


def can_write_page(one: "Pass") -> None:
    """Raises where the core for a page is missing, or where a capture cannot be read again to be put into it."""
    from canalyze.html import core

    core()
    for name in one.names:
        if name != STDIN and Path(name).exists() and not Path(name).is_file():
            raise one.usage("diagnose.html_once", name=wording.capture_name(name))


def lines_of(one: "Pass", wanted: set[int]) -> dict[int, str]:
    """Returns the annotated lines of frames: the capture is read again, and complained of no more."""
    rewind(one)
    found: dict[int, str] = {}

    def take(result: bytes) -> None:
        found.update((line.frame, line.text) for line in lines(result) if line.frame in wanted)

    session = open_session(one.words, one.given, format="lines", stamps=one.stamps, time="z")
    progress = Progress(one.words, Output(), one.total)
    Run(session, one.words, progress, take, one.given, tell=lambda _: None).over(one.names)
    return found


def around(one: "Pass", name: str, frame: int | None) -> Iterator[bytes]:
    """Yields the annotated lines around a frame, that of the frame itself marked."""
    if frame is None or name == STDIN or not Path(name).is_file():
        return
    first, last = max(1, frame - AROUND), frame + AROUND
    taken: list[bytes] = []

    def take(result: bytes) -> None:
        taken.append(result)
        if session.frames > last:
            raise _Enough

    session = one.session(format="text", filter=f"frame={first}-{last}")

    with suppress(_Enough):
        Run(session, one.words, NoProgress(), take, one.given, tell=lambda _: None).over((name,))
    number = first - 1
    for line in b"".join(taken).splitlines():
        is_frame = not line.startswith(b"#")
        number += is_frame
        yield (b"> " if is_frame and number == frame else b"  ") + line
