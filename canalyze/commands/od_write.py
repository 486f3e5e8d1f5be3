"""`canalyze od write`: the objects of a node, or the PDOs, as files for other programs."""

from contextlib import ExitStack
from typing import Any, Final

from canalyze.configuration import network
from canalyze.configuration.network import carried
from canalyze.configuration.options import ANY_PATH, OUTPUT, SHORT, configured, known_of, option
from canalyze.errors import OutputError
from canalyze.output import Progress, open_output, told
from canalyze.running.passes import AT, Objects, Pass, capture_command, read_objects

MADE: Final = ("dcf", "concise_dcf", "skeleton")
"""Files of one node, by the names of their options."""


def run(one: Pass) -> int:
    """Reads, then writes each file."""
    _check(one)
    targets = {name: one.given[name] for name in ("dbc", *MADE) if one.given[name] is not None}
    read: dict[str, Any] = {}
    expression = one.expression if one.dbc is None or one.node is None else f"node={one.node} {one.expression or ''}"
    with ExitStack() as stack:
        total = one.total
        outs = {form: stack.enter_context(open_output(name, force=one.force)) for form, name in targets.items()}
        one.progress = Progress(one.words, next(iter(outs.values())), total)
        seen = read_objects(one, "objects" if one.dbc is None else "pdos", read=read, filter=expression)
        one.progress.clear()
        if one.dbc is None:
            from canalyze.dictionary import files

            of = files.of(seen.result, one.node, _description(one, read, seen))
            for form, out in outs.items():
                data, said = files.made(form, targets[form], of, one.words)
                out.write(data)
                for line in said:
                    one.complain(line)
        else:
            from canalyze.reports import dictionary

            def entry(bus: str | None, node: int, index: int, sub: int) -> Any:
                file = carried(configured().known, known_of(one.given), read, bus, node)
                return read[file].entry(index, sub) if file else None

            dictionary.write_dbc(outs["dbc"], one.words, one.dbc, seen.result, entry)
        for out in outs.values():
            told(seen.code, out, one.words, stream=total is None, some=seen.frames > 0)
            if not seen.frames:
                out.drop()
    if seen.frames and not seen.some:
        one.note("od.none", frames=seen.frames)
    return seen.code


def _check(one: Pass) -> None:
    """Raises a usage error for files that are missing, or do not go together."""
    made = [f"--{name.replace('_', '-')}" for name in MADE if one.given[name] is not None]
    if one.dbc is None and not made:
        raise one.usage("od_write.none")
    if one.dbc is not None and made:
        raise one.usage("usage.exclusive", one="--dbc", other=made[0])
    if made and one.node is None:
        raise one.usage("od.goes_with", one=made[0], other="--node")


def _description(one: Pass, read: dict[str, Any], seen: Objects) -> tuple[bytes, str] | None:
    """Returns the description of the node and its name; None without one."""
    from canalyze.dictionary import contents
    from canalyze.records import records
    from canalyze.records.objects import Head

    node = one.node
    bus = next((head.bus for head in records(seen.result, Head) if head.node == node), None)
    file = carried(configured().known, known_of(one.given), read, bus, node)
    if file is not None and read[file].form in ("xdd", "concise"):
        raise OutputError("od.dcf_xdd", name=file)
    return None if file is None else contents(file)


command = capture_command(
    "od write",
    run,
    *(option(name, "FILE", usual=0, type=ANY_PATH) for name in ("--dcf", "--concise-dcf", "--skeleton", "--dbc")),
    option("--node", "N", network.node, "node", topic="chosen", usual=0),
    AT,
    without=(SHORT[0], OUTPUT[0]),
)
