"""`canalyze eds`: what a device description says, and what is wrong with it."""

from canalyze.configuration import network
from canalyze.configuration.options import ANY_PATH, FILES, OUTPUT, form, option
from canalyze.errors import CanalyzeError
from canalyze.output import open_output
from canalyze.running.passes import Pass, pass_command


def run(one: Pass) -> int:
    """Shows each description, or writes a DBC file of one."""
    from canalyze.dictionary import load
    from canalyze.reports import dictionary

    names = one.names
    if one.dbc:
        return _dbc(one)
    code = shown = 0
    with open_output(one.output, force=one.force) as out:
        for name in names:
            try:
                found = load(name, one.node)
            except CanalyzeError as error:
                one.complain(error.in_words(one.words))
                code = error.exit_code
                continue
            if one.form == "jsonl":
                out.write("".join(line + "\n" for line in dictionary.json_lines(found)).encode())
            else:
                if shown:
                    out.text("\n")
                dictionary.show(found, out, one.words, every=one.every)
            shown += 1
        if not shown:
            out.drop()
    return code


def _dbc(one: Pass) -> int:
    """Writes the PDOs of one description, as the core knows them before a capture."""
    from canalyze import _core
    from canalyze.dictionary import load
    from canalyze.reports import dictionary

    others = {"--all": one.every, "--output": one.output is not None}
    for other in (other for other, given in others.items() if given):
        raise one.usage("usage.exclusive", one="--dbc", other=other)
    if len(one.names) > 1:
        raise one.usage("eds.dbc_one")
    found = load(one.names[0], one.node)
    if found.node is None:
        raise one.usage("eds.dbc_node")
    pdos = _core.Network(descriptions=[(None, found.node, found.table)]).pdos().encode()
    with open_output(one.dbc, force=one.force) as out:
        dictionary.write_dbc(out, one.words, one.dbc, pdos, lambda _, __, *at: found.entry(*at))
    return 0


command = pass_command(
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
