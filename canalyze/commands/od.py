"""`canalyze od`: the objects of the devices, by what the traffic shows of them. What that is, the core says."""

import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Unpack

import click

from canalyze.configuration import network
from canalyze.configuration.config import Config
from canalyze.configuration.descriptions import carriers
from canalyze.configuration.options import (
    ANY_PATH,
    CaptureOptions,
    Spelled,
    capture_options,
    color_option,
    format_option,
    inputs,
    known_of,
    moment,
    open_session,
    time_option,
)
from canalyze.errors import OutputError
from canalyze.output import Output, Progress, complain, open_output, told
from canalyze.output.help import Command
from canalyze.running.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.dictionary.model import Dictionary, Entry

FORMS: Final = {"text": "-text", "jsonl": "", "csv": "-csv"}
"""What --format adds to the core's name of what comes out."""
NO_OBJECT: Final = b'{"kind":"od_pdo"'
"""PDOs come behind all objects: what begins so has none."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        form: str,
        history: bool,
        at: float | None,
        node: int | None,
        dcf: str | None,
        dbc: str | None,
        against: str | None,
        unseen: bool,
        output: str | None,
        force: bool,
        expression: str | None,
        time: str | None,
        color: str,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        csv = {"--format csv": form == "csv"}
        _exclude(words, "--dcf", dcf, {"--history": history, "--against": against, "--output": output})
        _exclude(words, "--dbc", dbc, {"--history": history, "--against": against, "--output": output, "--dcf": dcf})
        _exclude(words, "--against", against, {"--history": history, **csv})
        _go_together(words, node, dcf, against, unseen=unseen)
        names = inputs(files, words)
        description = _described(against, node, words) if against else None
        read: dict[str, Any] = {}
        session = open_session(
            words,
            given,
            read=read,
            format="pdos" if dbc else ("history" if history else "objects") + ("" if dcf else FORMS[form]),
            stamps=stamps,
            filter=expression,
            time=time,
            until_ns=None if at is None else round(at * 1e9),
        )
        from canalyze.reports.od_text import History, show

        some = False
        with open_output(dbc or dcf or output, force=force, color=color) as out:
            total = total_size(names)
            gathered: list[bytes] = []
            listed = History(out, words, live=total is None) if history and form == "text" else None
            kept = dbc or dcf or against or form == "text"
            put = listed.put if listed else gathered.append if kept else out.write

            def take(result: bytes) -> None:
                nonlocal some
                some = some or (bool(result) and not result.startswith(NO_OBJECT))
                put(result)

            progress = Progress(words, out, total)
            code = Run(session, words, progress, take, given).over(names)
            if listed:
                listed.close()
            records = [json.loads(line) for line in b"".join(gathered).splitlines()]
            if dbc:
                from canalyze.reports import dbc as report

                progress.clear()
                report.write(out, words, dbc, records, partial(_entry, given, read))
            elif dcf and node is not None:
                progress.clear()
                _write(out, words, records, (dcf, node), _description(given, read, records, node))
            elif description and session.frames:
                progress.clear()
                code = max(code, _compare(out, words, records, description, form=form, unseen=unseen))
            else:
                show(records, out, words)
            told(code, out, words, stream=total is None, some=session.frames > 0)
            if session.frames == 0:
                out.drop()
        if not some and session.frames:
            complain(f"canalyze: {words('od.none', frames=session.frames)}")
        return code

    return Command(
        "od",
        words,
        run,
        [
            click.Option(["--history"], is_flag=True, help=words("od.history")),
            click.Option(["--at"], type=Spelled(moment, "moment", words), metavar="S", help=words("od.at")),
            click.Option(["--node"], type=Spelled(network.node, "node", words), metavar="N", help=words("od.dcf_node")),
            click.Option(["--dcf"], type=ANY_PATH, metavar="FILE", help=words("od.dcf")),
            click.Option(["--dbc"], type=ANY_PATH, metavar="FILE", help=words("od.dbc")),
            click.Option(["--against"], type=ANY_PATH, metavar="FILE", help=words("od.against")),
            click.Option(["--unseen"], is_flag=True, help=words("od.unseen")),
            format_option(words, "od", tuple(FORMS)),
            time_option(words),
            color_option(words),
            *capture_options(words),
        ],
    )


def _exclude(words: Words, option: str, given: object, others: dict[str, object]) -> None:
    """Raise a usage error for an option with what does not go with it."""
    for other in (other for other, value in others.items() if value and given):
        raise click.UsageError(words("usage.exclusive", one=option, other=other), click.get_current_context())


def _go_together(words: Words, node: int | None, dcf: str | None, against: str | None, *, unseen: bool) -> None:
    """Raise a usage error for options without that which they belong to."""
    context = click.get_current_context()
    if (dcf and node is None) or (node is not None and not (dcf or against)):
        raise click.UsageError(words("od.dcf_needs_node"), context)
    if unseen and not against:
        raise click.UsageError(words("od.unseen_needs"), context)


def _described(name: str, node: int | None, words: Words) -> "Dictionary":
    """Read the description of --against, and say what is odd about it."""
    from canalyze.configuration.descriptions import say_defects
    from canalyze.dictionary import load

    found = load(name, node)
    say_defects(found, words)
    return found


def _compare(
    out: Output, words: Words, records: list[dict[str, Any]], found: "Dictionary", *, form: str, unseen: bool
) -> int:
    """Write what the description and the device differ in; give the exit code."""
    from canalyze.dictionary.against import INFO, compared, device
    from canalyze.reports import against_text

    held = compared(found, records, *device(records, found), unseen=unseen)
    if form == "text":
        against_text.show(held, found.file, out, words)
    else:
        out.write(against_text.lines(held, found.file, words))
    return int(any(one.severity != INFO for one in held.differences))


def _description(
    given: CaptureOptions, read: dict[str, Any], records: list[dict[str, Any]], node: int
) -> tuple[bytes, str] | None:
    """Give the description of a node and its name; None where it has none."""
    if not read:
        return None
    from canalyze.dictionary import contents

    file = _carried(given, read, next((one["bus"] for one in records if one["node"] == node), None), node)
    if file is not None and read[file].form == "xdd":
        raise OutputError("od.dcf_xdd", name=file)
    return None if file is None else contents(file)


def _carried(given: CaptureOptions, read: dict[str, Any], bus: str | None, node: int) -> str | None:
    """Give the file that describes a node."""
    filed = (click.get_current_context().find_object(Config) or Config()).known
    carried = carriers(filed, known_of(given), read)
    return carried.get((bus, node), carried.get((None, node)))


def _entry(
    given: CaptureOptions, read: "dict[str, Dictionary]", bus: str | None, node: int, index: int, sub: int
) -> "Entry | None":
    """Give what the description of a node says of an object."""
    file = _carried(given, read, bus, node) if read else None
    return read[file].entry(index, sub) if file else None


def _write(
    out: Output, words: Words, records: list[dict[str, Any]], of: tuple[str, int], given: tuple[bytes, str] | None
) -> None:
    """Write the DCF of a node, and say what is in it. OutputError where there is nothing to be written."""
    from canalyze.dictionary.dcf import configured
    from canalyze.dictionary.skeleton import skeleton

    name, node = of
    heads = [one for one in records if one["kind"] == "od_node" and one["node"] == node]
    if len(heads) > 1:
        raise OutputError("od.dcf_buses", node=node, buses=", ".join(str(one["bus"]) for one in heads))
    objects = [one for one in records if one["kind"] == "od_object" and one["node"] == node]
    values = {(int(one["index"], 16), one["sub"]): _whole(one["configured"]) for one in objects if one["configured"]}
    if not values:
        raise OutputError("od.dcf_none", node=node)
    keys = {"FileName": Path(name).name}
    if given is None:
        made = configured(skeleton(heads[0], objects).encode(), name, values, node, keys)
    else:
        made = configured(*given, values, node, {**keys, "LastEDS": Path(given[1]).name})
    out.write(made.text.encode())
    complain(f"canalyze: {words('od.dcf_written', name=name, node=node, count=made.values)}")
    if made.left_out:
        missing = ", ".join(f"{index:04X}h:{sub:02X}" for index, sub in made.left_out)
        complain(f"canalyze: {words('od.dcf_left_out', name=name, objects=missing)}")


def _whole(held: dict[str, Any]) -> bytes:
    """Give the bytes of a value; none where not all of them are there, which no file can hold."""
    data = bytes.fromhex(held["data"])
    return data if len(data) == held["size"] else b""
