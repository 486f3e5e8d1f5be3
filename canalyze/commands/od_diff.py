"""`canalyze od --diff`: the configurations of two sides compared, each a capture or a description."""

from contextlib import suppress
from typing import TYPE_CHECKING

from canalyze.configuration.descriptions import described
from canalyze.errors import ReaderGone
from canalyze.output import Progress
from canalyze.running.objects import FORMS, read_objects
from canalyze.running.passes import Pass
from canalyze.sources.file import total_size

if TYPE_CHECKING:
    from canalyze.dictionary.difference import Side
    from canalyze.dictionary.model import Dictionary


def run(one: Pass) -> int:
    """Reads both sides, then compares."""
    from canalyze.dictionary import describes
    from canalyze.dictionary.difference import captured, compare
    from canalyze.reports import od_diff

    code = 0
    sides: list[Side | Dictionary] = []
    with one.output() as out:
        one.progress = Progress(one.words, out, total_size((*one.names, one.diff)))
        for names in (one.names, (one.diff,)):
            if len(names) == 1 and describes(names[0]):
                sides.append(described(names[0], None, one.words))
                continue
            side = read_objects(one, "objects" + FORMS[one.form], names)
            code = max(code, side.code)
            if code >= 128 or not side.frames:
                out.drop()
                return code or 2
            sides.append(captured(side.records))
        found = compare(sides, one.node, filtered=one.expression is not None)
        if not found.pairs:
            a, b = (", ".join(str(node.node or "-") for node in side.nodes) or "-" for side in found.sides)
            if not any(found.alone):
                raise one.usage("od.no_pair", a=a, b=b)
            one.note("od.no_pair", a=a, b=b)
        with suppress(ReaderGone):  # who has read enough has not been told that they are alike
            if one.form == "jsonl":
                out.write(od_diff.lines(found, (one.names[0], one.diff)))
            else:
                od_diff.show(found, out, one.words, every=one.every)
    return code or int(od_diff.count(found) > 0)
