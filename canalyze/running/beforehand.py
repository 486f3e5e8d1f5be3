"""Captures read for the options of a command, before it reads them for their own sake.

Descriptions that devices hold themselves: what was read of 1021h, or written to it, becomes a file that counts as one
of `--eds` for its node. Only what is whole and reads as a description is used; any other is reported.

The short forms of --filter, as conditions of its expression: what they choose and what the expression chooses must both
hold. A problem is found by a diagnosis. Must not: overrule what the user has said of a node, judge, or read an
expression.
"""

import os
import re
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any, Final

import click

from canalyze.configuration.descriptions import Carrier, carriers, network
from canalyze.configuration.network import Description, Known
from canalyze.configuration.options import PROBLEM, SHORT, configured, known_of, open_session, start_session, usage
from canalyze.dictionary import read
from canalyze.errors import SourceError
from canalyze.output import Output, Progress, complain
from canalyze.records import records
from canalyze.records.objects import Transfer
from canalyze.records.problems import Problem
from canalyze.reports.diagnosis import near, tree
from canalyze.reports.wording import ranges
from canalyze.running.run import NoProgress, Run
from canalyze.sources import STDIN, total_size
from canalyze.sources.names import expanded
from canalyze.words import Words

_STORED: Final = "1021"
_FORMAT: Final = "1022"
_OF_THESE: Final = re.compile(f"_({_STORED}|{_FORMAT})h_")
"""In the names that the core has for the data of a transfer."""


def describe(context: click.Context, words: Words) -> None:
    """Adds the descriptions in the command's files to its `--eds`; a line each to standard error."""
    names = context.params["files"]
    if not names or STDIN in names:
        raise usage(words, "stored.stdin")
    given: Any = context.params
    filed = configured().known
    told = carriers(filed, known_of(given), {})
    folder = Path(context.with_resource(tempfile.TemporaryDirectory(prefix="canalyze-")))
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
    names: tuple[str, ...], words: Words, context: click.Context
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


def choose(context: click.Context, words: Words) -> None:
    """Adds the conditions of the short forms before the expression of --filter."""
    given = context.params
    conditions = [given.get(one.name) for one in SHORT]
    if (number := given.get(PROBLEM.name)) is not None:
        conditions.append(_near(number, context, words))
    # An expression whose last quotation mark is missing goes on to its end: it comes last.
    given["expression"] = " ".join(filter(None, [*conditions, given["expression"]])) or None


def _near(number: int, context: click.Context, words: Words) -> str | None:
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
