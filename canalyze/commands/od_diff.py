"""`canalyze od diff`: the configurations of two sides compared, each a capture or a description."""

from contextlib import suppress
from typing import TYPE_CHECKING

from canalyze.configuration import network
from canalyze.configuration.network import described
from canalyze.configuration.options import ANY_PATH, COLOR, FILES, SHORT, argument, form, inputs, option
from canalyze.errors import ReaderGone
from canalyze.output import Progress
from canalyze.running.passes import AT, FORMS, Pass, capture_command, read_objects
from canalyze.sources import total_size

if TYPE_CHECKING:
    from canalyze.dictionary import Dictionary
    from canalyze.dictionary.difference import Side


def run(one: Pass) -> int:
    """Reads both sides, then compares."""
    from canalyze.dictionary import describes
    from canalyze.dictionary.difference import captured, compare
    from canalyze.reports import od

    if not one.files:
        raise one.usage("od_diff.none")
    one.names = inputs(one.files[:-1], one.words)
    other = one.files[-1]
    code = 0
    sides: list[Side | Dictionary] = []
    with one.opened() as out:
        one.progress = Progress(one.words, out, total_size((*one.names, other)))
        for names in (one.names, (other,)):
            if len(names) == 1 and describes(names[0]):
                sides.append(described(names[0], None, one.words))
                continue
            side = read_objects(one, "objects" + FORMS[one.form], names)
            code = max(code, side.code)
            if code >= 128 or not side.frames:
                out.drop()
                return code or 2
            sides.append(captured(side.result))
        found = compare(sides, one.node, filtered=one.expression is not None)
        if not found.pairs:
            a, b = (", ".join(str(node.node or "-") for node in side.nodes) or "-" for side in found.sides)
            if not any(found.alone):
                raise one.usage("od.no_pair", a=a, b=b)
            one.note("od.no_pair", a=a, b=b)
        with suppress(ReaderGone):  # a closed pipe does not mean that they are alike
            if one.form == "jsonl":
                out.write(od.difference_lines(found, (one.names[0], other)))
            else:
                od.show_differences(found, out, one.words, every=one.every)
    return code or int(od.differences(found) > 0)


def _nodes(text: str) -> tuple[int, int] | None:
    """Reads a node-ID, or that of A and that of B as A=B."""
    a, equals, b = text.partition("=")
    one = network.node(a)
    two = network.node(b) if equals else one
    return None if one is None or two is None else (one, two)


command = capture_command(
    "od diff",
    run,
    argument("files", "A... B", nargs=-1, type=ANY_PATH),
    option("--node", "N|A=B", _nodes, "node", topic="chosen", usual=0),
    option("--all every", usual=0),
    AT,
    form("text", "jsonl"),
    COLOR,
    without=(FILES, SHORT[0]),
)
