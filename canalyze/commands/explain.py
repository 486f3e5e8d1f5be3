"""`canalyze explain`: a frame field by field, a code or a term.

The core reads it and finds the words; this joins and asks.
"""

from typing import TYPE_CHECKING

import click

from canalyze.configuration import network
from canalyze.configuration.options import EDS, argument, usage
from canalyze.output.help import simple_command
from canalyze.running.run import piped
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze import _core


def run(words: Words, *, frame: tuple[str, ...], eds: tuple[network.Description, ...]) -> int:
    """Explains what is asked for, or each line of standard input."""
    from canalyze.reports.explained import Explained

    nothing = usage(words, "explain.nothing")
    if not frame and not piped():
        raise nothing
    explained = Explained(words, _devices(eds))
    if frame == ("-",):
        return explained.lines(None)
    if not frame:
        return explained.lines(nothing)
    for line in _frames(frame):
        explained.add(line, words("explain.no_frame", line=line or repr(line)))
    return explained.code


def _devices(given: tuple[network.Description, ...]) -> "_core.Network | None":
    """Reads the descriptions; one without a node is used for objects and COB-IDs of any node."""
    if not given:
        return None
    from canalyze import _core
    from canalyze.dictionary import load

    descriptions = []
    for one in given:
        found = load(one.file)
        descriptions += [(one.bus, node, found.table) for node in one.nodes or (found.node or 0,)]
    return _core.Network(descriptions=descriptions)


def _frames(arguments: tuple[str, ...]) -> list[str]:
    """Returns the lines that the arguments are: each a frame or a code by itself, or together the words of one line."""
    line = " ".join(arguments)
    if all("#" in argument for argument in arguments):
        return list(arguments)
    # The name of a term has several words, and some of them are terms by themselves; behind a frame nothing counts.
    is_name = "[" not in line and "#" not in line and _is_known(line)
    if not is_name and all(map(_is_known, arguments)):
        return list(arguments)
    if (place := next((at for at, one in enumerate(arguments) if "#" in one[1:]), None)) is not None:
        head, *behind = " ".join(arguments[: place + 1]), *arguments[place + 1 :]
        if behind and not behind[0].startswith("#") and behind not in (["R"], ["T"]) and _is_known(head):
            return [head, *behind]
    several = not _is_known(line) and "[" not in line and any(map(_is_known, arguments))
    return list(arguments) if several else [line]


def _is_known(line: str) -> bool:
    """Returns true if a line can be explained."""
    from canalyze._core import explain

    try:
        return explain(line) is not None
    except ValueError:
        return False


command = simple_command(
    "explain",
    run,
    argument("frame", "FRAME", nargs=-1, type=click.UNPROCESSED),
    EDS._replace(key="explain.eds"),
    paged=True,
)
