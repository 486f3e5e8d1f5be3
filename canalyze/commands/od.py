"""`canalyze od`: the objects of the devices, by what the traffic shows of them. What that is, the core says."""

from collections.abc import Callable
from contextlib import ExitStack, suppress
from functools import partial
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
    spelled,
    time_option,
)
from canalyze.errors import OutputError, ReaderGone
from canalyze.output import Output, Progress, complain, open_output, told
from canalyze.output.help import Listing
from canalyze.running.run import Run
from canalyze.sources.file import total_size
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.dictionary.difference import Side
    from canalyze.dictionary.model import Dictionary, Entry

FORMS: Final = {"text": "-text", "jsonl": "", "csv": "-csv"}
"""What --format adds to the core's name of what comes out."""
_MADE: Final = ("--dcf", "--concise-dcf", "--skeleton")
"""Options that make files of one node."""
EXCLUSIVE: Final = (
    (_MADE, ("--against", "--diff", "--history", "--output")),
    (("--against",), ("--diff", "--history", "--format csv")),
    (("--diff",), ("--history", "--format csv")),
    (("--dbc",), (*_MADE, "--against", "--diff", "--history", "--output")),
)
"""Options, and those that none of them can be used with."""
GO_WITH: Final = (
    *((option, ("--node",)) for option in _MADE),
    ("--node A=B", ("--diff",)),
    ("--unseen", ("--against",)),
    ("--all", ("--diff",)),
)
"""Options, and those of which each needs one."""
NO_OBJECT: Final = b'{"kind":"od_pdo"'
"""PDOs come behind all objects: what begins so has none."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        form: str,
        history: bool,
        at: float | None,
        node: tuple[int, int] | None,
        dcf: str | None,
        concise_dcf: str | None,
        skeleton: str | None,
        dbc: str | None,
        against: str | None,
        unseen: bool,
        diff: str | None,
        every: bool,
        output: str | None,
        force: bool,
        expression: str | None,
        time: str | None,
        color: str,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        wanted: dict[str, Any] = {"dcf": dcf, "concise_dcf": concise_dcf, "skeleton": skeleton}
        targets = {form: name for form, name in wanted.items() if name is not None}
        two = node is not None and node[0] != node[1]
        chosen = {f"--{form.replace('_', '-')}": name for form, name in wanted.items()}
        chosen |= {"--node": node, "--against": against, "--dbc": dbc, "--diff": diff, "--output": output}
        chosen |= {"--history": history, "--unseen": unseen, "--all": every}
        chosen |= {"--format csv": form == "csv", "--node A=B": two}
        _go_together(words, {option for option, value in chosen.items() if value not in (None, False)})
        names = inputs(files, words)
        if node is not None and not targets and against is None and diff is None:
            expression = f"node={node[0]} {expression or ''}"
        description = None if against is None else _described(against, node[0] if node else None, words)
        read: dict[str, Any] = {}
        kind = "pdos" if dbc else ("history" if history else "objects") + ("" if targets else FORMS[form])

        def session() -> "Session":
            return open_session(
                words,
                given,
                read=read,
                format=kind,
                stamps=stamps,
                filter=expression,
                time=time,
                until_ns=None if at is None else round(at * 1e9),
            )

        if diff is not None:
            with open_output(output, force=force, color=color) as out:
                return _compare(out, words, (names, diff), (node, expression, form, every), given, session)
        reading = session()
        from canalyze.reports.od_text import History, show

        some = False
        with ExitStack() as stack:
            outs = {one: stack.enter_context(open_output(name, force=force)) for one, name in targets.items()}
            outs = outs or {"": stack.enter_context(open_output(dbc or output, force=force, color=color))}
            out = next(iter(outs.values()))
            total = total_size(names)
            gathered: list[bytes] = []
            listed = History(out, words, live=total is None) if history and form == "text" else None
            kept = dbc or targets or description or form == "text"
            put = listed.put if listed else gathered.append if kept else out.write

            def take(result: bytes) -> None:
                nonlocal some
                some = some or (bool(result) and not result.startswith(NO_OBJECT))
                put(result)

            progress = Progress(words, out, total)
            code = Run(reading, words, progress, take, given).over(names)
            if listed:
                listed.close()
            result = b"".join(gathered)
            if dbc:
                from canalyze.reports import dbc as report

                progress.clear()
                report.write(out, words, dbc, result, partial(_entry, given, read))
            elif targets and node:
                progress.clear()
                _write(outs, words, result, targets, node[0], _description(given, read, result, node[0]))
            elif description and reading.frames:
                progress.clear()
                code = max(code, _hold_against(out, words, result, description, form=form, unseen=unseen))
            else:
                show(result, out, words)
            for written in outs.values():
                told(code, written, words, stream=total is None, some=reading.frames > 0)
                if reading.frames == 0:
                    written.drop()
        if not some and reading.frames:
            complain(f"canalyze: {words('od.none', frames=reading.frames)}")
        return code

    return Listing(
        "od",
        words,
        run,
        [
            click.Option(["--history"], is_flag=True, help=words("od.history")),
            click.Option(["--at"], type=Spelled(moment, "moment", words), metavar="S", help=words("od.at")),
            spelled(words, "--node", _nodes, "node", "N", "od.node_id"),
            click.Option(["--dcf"], type=ANY_PATH, metavar="FILE", help=words("od.dcf")),
            click.Option(["--concise-dcf"], type=ANY_PATH, metavar="FILE", help=words("od.concise_dcf")),
            click.Option(["--skeleton"], type=ANY_PATH, metavar="FILE", help=words("od.skeleton")),
            click.Option(["--dbc"], type=ANY_PATH, metavar="FILE", help=words("od.dbc")),
            click.Option(["--against"], type=ANY_PATH, metavar="FILE", help=words("od.against")),
            click.Option(["--unseen"], is_flag=True, help=words("od.with_unseen")),
            click.Option(["--diff"], type=ANY_PATH, metavar="FILE", help=words("od.diff")),
            click.Option(["--all", "every"], is_flag=True, help=words("od.all")),
            format_option(words, "od", tuple(FORMS)),
            time_option(words),
            color_option(words),
            *(option for option in capture_options(words) if option.name != "filter_node"),
        ],
    )


def _nodes(text: str) -> tuple[int, int] | None:
    """Read a node-ID, or that of A and that of B as A=B."""
    a, equals, b = text.partition("=")
    one = network.node(a)
    two = network.node(b) if equals else one
    return None if one is None or two is None else (one, two)


def _go_together(words: Words, chosen: set[str]) -> None:
    """Raise a usage error for options that cannot be used together, or not without each other."""
    context = click.get_current_context()
    for options, others in EXCLUSIVE:
        for one in (one for one in options if one in chosen):
            for other in (other for other in others if other in chosen):
                raise click.UsageError(words("usage.exclusive", one=one, other=other), context)
    for one, needs in GO_WITH:
        if one in chosen and not chosen & set(needs):
            raise click.UsageError(words("od.goes_with", one=one, other=", ".join(needs)), context)


def _described(name: str, node: int | None, words: Words) -> "Dictionary":
    """Read a description that is compared, and say what is odd about it."""
    from canalyze.configuration.descriptions import say_defects
    from canalyze.dictionary import load

    found = load(name, node)
    say_defects(found, words)
    return found


def _hold_against(out: Output, words: Words, result: bytes, found: "Dictionary", *, form: str, unseen: bool) -> int:
    """Write what the description and the device differ in; give the exit code."""
    from canalyze.dictionary.against import INFO, compared, device
    from canalyze.reports import against_text

    held = compared(found, result, *device(result, found), unseen=unseen)
    if form == "text":
        against_text.show(held, found.file, out, words)
    else:
        out.write(against_text.lines(held, found.file, words))
    return int(any(one.severity != INFO for one in held.differences))


def _description(given: CaptureOptions, read: dict[str, Any], result: bytes, node: int) -> tuple[bytes, str] | None:
    """Give the description of a node and its name; None where it has none."""
    if not read:
        return None
    from canalyze.dictionary import contents
    from canalyze.records import records
    from canalyze.records.inventory import Head

    file = _carried(given, read, next((one.bus for one in records(result, Head) if one.node == node), None), node)
    if file is not None and read[file].form in ("xdd", "concise"):
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
    outs: dict[str, Output],
    words: Words,
    result: bytes,
    names: dict[str, str],
    node: int,
    description: tuple[bytes, str] | None,
) -> None:
    """Write the files of a node, and say what is in them. OutputError where there is nothing to be written."""
    from canalyze.reports import od_files

    of = od_files.of(result, node, description)
    for form, out in outs.items():
        data, said = od_files.made(form, names[form], of, words)
        out.write(data)
        for line in said:
            complain(f"canalyze: {line}")


def _compare(
    out: Output,
    words: Words,
    files: tuple[tuple[str, ...], str],
    wanted: tuple[tuple[int, int] | None, str | None, str, bool],
    given: CaptureOptions,
    session: Callable[[], "Session"],
) -> int:
    """Compare the configurations of two sides; give the exit code."""
    from canalyze.dictionary import describes
    from canalyze.dictionary.difference import captured, compare
    from canalyze.reports import od_diff

    nodes, expression, form, every = wanted
    code = 0
    sides: list[Side | Dictionary] = []
    progress = Progress(words, out, total_size((*files[0], files[1])))
    for inputs_of in (files[0], (files[1],)):
        if len(inputs_of) == 1 and describes(inputs_of[0]):
            sides.append(_described(inputs_of[0], None, words))
            continue
        gathered: list[bytes] = []
        reading = session()
        code = max(code, Run(reading, words, progress, gathered.append, given).over(inputs_of))
        if code >= 128 or reading.frames == 0:
            out.drop()
            return code or 2
        sides.append(captured(b"".join(gathered)))
    found = compare(sides, nodes, filtered=expression is not None)
    if not found.pairs:
        a, b = (", ".join(str(node.node or "-") for node in side.nodes) or "-" for side in found.sides)
        if not any(found.alone):
            raise click.UsageError(words("od.no_pair", a=a, b=b), click.get_current_context())
        complain(f"canalyze: {words('od.no_pair', a=a, b=b)}")
    with suppress(ReaderGone):  # who has read enough has not been told that they are alike
        if form == "jsonl":
            out.write(od_diff.lines(found, (files[0][0], files[1])))
        else:
            od_diff.show(found, out, words, every=every)
    return code or int(od_diff.count(found) > 0)
