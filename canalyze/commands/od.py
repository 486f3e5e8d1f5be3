"""`canalyze od`: the objects of the devices, by what the traffic shows of them. What that is, the core says."""

import json
from typing import Final

from canalyze.commands import od_against, od_diff, od_write
from canalyze.configuration import network
from canalyze.configuration.options import ANY_PATH, COLOR, SHORT, TIME, form, moment, option
from canalyze.running.objects import FORMS, has_object, settings_of
from canalyze.running.passes import Pass, capture_command

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
    *((name, ("--node",)) for name in _MADE),
    ("--node A=B", ("--diff",)),
    ("--unseen", ("--against",)),
    ("--all", ("--diff",)),
)
"""Options, and those of which each needs one."""


def run(one: Pass) -> int:
    """Lists the objects, or makes of them what an option says."""
    _go_together(one)
    if one.diff is not None:
        return od_diff.run(one)
    if one.against is not None:
        return od_against.run(one)
    if one.dbc is not None or any(one.given[name] is not None for name in od_write.MADE):
        return od_write.run(one)
    expression = one.expression if one.node is None else f"node={one.node[0]} {one.expression or ''}"
    kind = ("history" if one.history else "objects") + FORMS[one.form]
    session = one.session(format=kind, filter=expression, **settings_of(one))
    some = False
    with one.output() as out:
        from canalyze.reports.od_text import History, show

        text = one.form == "text"
        listed = History(out, one.words, live=one.total is None) if one.history and text else None
        gathered: list[bytes] = []
        put = listed.put if listed else gathered.append if text else out.write

        def take(result: bytes) -> None:
            nonlocal some
            some = some or has_object(result)
            put(result)

        code = one.read(session, take)
        if listed:
            listed.close()
        show([json.loads(line) for line in b"".join(gathered).splitlines()], out, one.words)
        one.end(code, session.frames)
    if not some and session.frames:
        one.note("od.none", frames=session.frames)
    return code


def _nodes(text: str) -> tuple[int, int] | None:
    """Reads a node-ID, or that of A and that of B as A=B."""
    a, equals, b = text.partition("=")
    one = network.node(a)
    two = network.node(b) if equals else one
    return None if one is None or two is None else (one, two)


def _go_together(one: Pass) -> None:
    """Raises a usage error for options that cannot be used together, or not without each other."""
    names = ("dcf", "concise_dcf", "skeleton", "node", "against", "dbc", "diff", "output", "history", "unseen")
    given = {f"--{name.replace('_', '-')}" for name in names if one.given[name] not in (None, False)}
    given |= {"--all"} if one.every else set()
    given |= {"--format csv"} if one.form == "csv" else set()
    given |= {"--node A=B"} if one.node is not None and one.node[0] != one.node[1] else set()
    for options, others in EXCLUSIVE:
        for name in (name for name in options if name in given):
            for other in (other for other in others if other in given):
                raise one.usage("usage.exclusive", one=name, other=other)
    for name, needs in GO_WITH:
        if name in given and not given & set(needs):
            raise one.usage("od.goes_with", one=name, other=", ".join(needs))


command = capture_command(
    "od",
    run,
    option("--history", usual=0),
    option("--at", "S", moment, "moment", usual=0),
    option("--node", "N", _nodes, "node", key="od.node_id", topic="chosen"),
    option("--dcf", "FILE", type=ANY_PATH),
    option("--concise-dcf", "FILE", type=ANY_PATH),
    option("--skeleton", "FILE", type=ANY_PATH),
    option("--dbc", "FILE", type=ANY_PATH),
    option("--against", "FILE", type=ANY_PATH),
    option("--unseen", key="od.with_unseen"),
    option("--diff", "FILE", usual=-2, type=ANY_PATH),
    option("--all every", usual=-1),
    form(*FORMS),
    TIME,
    COLOR,
    without=SHORT[:1],
)
