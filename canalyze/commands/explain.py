"""`canalyze explain`: a frame field by field, a code or a term.

The core reads it and finds the words; this joins and asks.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from canalyze.configuration import network
from canalyze.configuration.options import EDS, argument, usage
from canalyze.errors import SourceError
from canalyze.output import Output, complain
from canalyze.output.help import simple_command
from canalyze.running.run import piped
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze import _core


def run(words: Words, *, frame: tuple[str, ...], eds: tuple[network.Description, ...]) -> int:
    """Explains what is asked for, or each line of standard input."""
    from canalyze._core import explain

    nothing = usage(words, "explain.nothing")
    if not frame and not piped():
        raise nothing
    devices, out = _devices(eds), Output()
    code, between = 0, ""
    if frame in ((), ("-",)):
        lines = _typed(words, None if frame else nothing)
    else:
        lines = ((line, words("explain.no_frame", line=line or repr(line))) for line in _frames(frame))
    for line, otherwise in lines:
        try:
            text = explain(line, words.lang, devices)
        except ValueError as error:  # meant as a frame: why it is none says more
            text, otherwise = None, str(error)
        if text is None:
            complain(f"canalyze: {otherwise}")
            code = 2
        else:
            out.text(between + text.rstrip("\n") + "\n")
            between = "\n"
    return code


def _typed(words: Words, nothing: Exception | None) -> Iterator[tuple[str, str]]:
    """Yields each line of standard input when it comes, with the message for one that cannot be explained.

    Blank lines and comments are skipped, as decode does. nothing: is raised without a line, if standard input was not
    asked for.
    """
    some = False
    try:
        with open(0, "rb", closefd=False) as stdin:
            for number, raw in enumerate(stdin, 1):
                line = raw.decode("utf-8", "replace").strip()
                if line and not line.startswith("#"):
                    some = True
                    yield line, words("explain.no_frame_at", name="stdin", number=number, line=line)
    except OSError as error:
        raise SourceError("source.read" if some else "source.open", name="stdin", error=error) from error
    if not some:
        raise nothing or SourceError("explain.empty", name="stdin")


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
