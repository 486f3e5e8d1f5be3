"""`canalyze od`: the objects of the devices, by what the traffic shows of them. What that is, the core says."""

import click

from canalyze.configuration import network
from canalyze.configuration.options import COLOR, FILES, SHORT, TIME, form, option
from canalyze.running.passes import AT, FORMS, Pass, capture_command, has_object, settings_of


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


class _FileOrPart(click.Path):
    """A file, completed by the shell also as a second word of the command."""

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list["click.shell_completion.CompletionItem"]:
        """Returns the second words that begin so, then files."""
        from click.shell_completion import CompletionItem

        from canalyze.cli import PARTS

        parts = () if ctx.params.get("files") else PARTS["od"]
        found = [CompletionItem(part) for part in parts if part.startswith(incomplete)]
        return [*found, *super().shell_complete(ctx, param, incomplete)]


command = capture_command(
    "od",
    run,
    FILES._replace(more={"nargs": -1, "type": _FileOrPart(allow_dash=True, readable=False)}),
    option("--history", usual=0),
    AT,
    option("--node", "N", network.node, "node", key="od.node_id", topic="chosen"),
    form(*FORMS),
    TIME,
    COLOR,
    without=(FILES, SHORT[0]),
)
