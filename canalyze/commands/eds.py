"""`canalyze eds`: what a device description says, and what is wrong with it."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from canalyze.configuration import network
from canalyze.configuration.options import ANY_PATH, FILES, OUTPUT, form, inputs, option, usage
from canalyze.errors import CanalyzeError
from canalyze.output import Output, complain, open_output
from canalyze.output.help import simple_command
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.dictionary.model import Dictionary


def run(
    words: Words,
    *,
    files: tuple[str, ...],
    node: int | None,
    dbc: str | None,
    every: bool,
    form: str,
    output: str | None,
    force: bool,
) -> int:
    """Shows each description, or writes a DBC file of one."""
    from canalyze.dictionary import load

    names = inputs(files, words)
    if dbc:
        return _dbc(words, names, node, dbc, force=force, others={"--all": every, "--output": output is not None})
    code = shown = 0
    with open_output(output, force=force) as out:
        show = _jsonl(out) if form == "jsonl" else _text(out, words, every)
        for name in names:
            try:
                found = load(name, node)
            except CanalyzeError as error:
                complain(f"canalyze: {error.in_words(words)}")
                code = error.exit_code
                continue
            if shown and form == "text":
                out.text("\n")
            show(found)
            shown += 1
        if not shown:
            out.drop()
    return code


def _dbc(
    words: Words, names: tuple[str, ...], node: int | None, dbc: str, *, force: bool, others: dict[str, bool]
) -> int:
    """Writes the PDOs of one description, as the core knows them before a capture."""
    from canalyze import _core
    from canalyze.dictionary import load
    from canalyze.reports import dictionary

    for other in (other for other, given in others.items() if given):
        raise usage(words, "usage.exclusive", one="--dbc", other=other)
    if len(names) > 1:
        raise usage(words, "eds.dbc_one")
    found = load(names[0], node)
    if found.node is None:
        raise usage(words, "eds.dbc_node")
    pdos = _core.Network(descriptions=[(None, found.node, found.table)]).pdos().encode()
    with open_output(dbc, force=force) as out:
        dictionary.write_dbc(out, words, dbc, pdos, lambda _, __, *at: found.entry(*at))
    return 0


def _jsonl(out: Output) -> "Callable[[Dictionary], None]":
    from canalyze.reports.dictionary import json_lines

    return lambda found: out.write("".join(line + "\n" for line in json_lines(found)).encode())


def _text(out: Output, words: Words, every: bool) -> "Callable[[Dictionary], None]":
    from canalyze.reports.dictionary import show

    return lambda found: show(found, out, words, every=every)


command = simple_command(
    "eds",
    run,
    FILES,
    option("--node", "N", network.node, "node", topic="chosen"),
    option("--dbc", "FILE", type=ANY_PATH),
    option("--all every", usual=0),
    form("text", "jsonl"),
    *OUTPUT,
    paged=True,
)
