"""`canalyze od`: the objects of the devices, by what the traffic shows of them. What that is, the core says."""

from typing import TYPE_CHECKING

import click

from canalyze.configuration import network
from canalyze.configuration.options import ANY_PATH, COLOR, FILES, SHORT, TIME, form, option
from canalyze.running.passes import AT, FORMS, Pass, capture_command, has_object, settings_of

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem


def run(one: Pass) -> int:
    """Lists the objects."""
    expression = one.expression if one.node is None else f"node={one.node} {one.expression or ''}"
    kind = ("history" if one.history else "objects") + FORMS[one.form]
    session = one.session(format=kind, filter=expression, **settings_of(one))
    some = False
    with one.opened() as out:
        from canalyze.reports.od import History, show

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
        show(b"".join(gathered), out, one.words)
        one.end(code, session.frames)
    if not some and session.frames:
        one.note("od.none", frames=session.frames)
    return code


def _completed(context: click.Context, row: click.Parameter, begun: str) -> "list[CompletionItem]":
    """Returns the second words of the command that begin so, then files, for a shell."""
    from click.shell_completion import CompletionItem

    from canalyze.cli import PARTS

    parts = () if context.params.get("files") else PARTS["od"]
    found = [CompletionItem(part) for part in parts if part.startswith(begun)]
    return [*found, *ANY_PATH.shell_complete(context, row, begun)]


command = capture_command(
    "od",
    run,
    FILES._replace(more={**FILES.more, "shell_complete": _completed}),
    option("--history", usual=0),
    AT,
    option("--node", "N", network.node, "node", key="od.node_id", topic="chosen"),
    form(*FORMS),
    TIME,
    COLOR,
    without=(FILES, SHORT[0]),
)
