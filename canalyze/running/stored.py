"""Descriptions that devices hold themselves (1021h), taken out of captures before these are read for their own sake.

What was read of 1021h, or written to it, becomes a file that counts as one of `--eds` for its node. Only what is whole
and reads as a description is used; any other is reported. Must not: overrule what the user has said of a node.
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
from canalyze.configuration.options import configured, known_of, start_session, usage
from canalyze.dictionary import read
from canalyze.errors import SourceError
from canalyze.output import complain
from canalyze.records import records
from canalyze.records.transfers import Transfer
from canalyze.running.run import NoProgress, Run
from canalyze.sources.file import STDIN
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
