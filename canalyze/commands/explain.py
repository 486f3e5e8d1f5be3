"""`canalyze explain`: a frame field by field, a code or a term.

The core reads it and finds the words; this joins and asks.
"""

from typing import TYPE_CHECKING

import click

from canalyze.configuration import network
from canalyze.configuration.options import spelled
from canalyze.errors import SourceError
from canalyze.output import Output, complain
from canalyze.output.help import Listing
from canalyze.running.run import piped
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze import _core


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(frame: tuple[str, ...], eds: tuple[network.Description, ...]) -> int:
        nothing = click.UsageError(words("explain.nothing"), click.get_current_context())
        if not frame and not piped():
            raise nothing
        explained = _Explained(words, _devices(eds))
        if frame == ("-",):
            return explained.lines(None)
        if not frame:
            return explained.lines(nothing)
        for line in _frames(frame):
            explained.add(line, words("explain.no_frame", line=line or repr(line)))
        return explained.code

    return Listing(
        "explain",
        words,
        run,
        [
            click.Argument(["frame"], nargs=-1, type=click.UNPROCESSED, metavar="FRAME"),
            spelled(words, "--eds", network.description, "eds", "[[BUS:]NODE=]FILE", "explain.eds", multiple=True),
        ],
    )


def _devices(given: tuple[network.Description, ...]) -> "_core.Network | None":
    """Read the descriptions; one of which nobody says whose it is holds for objects and COB-IDs of any node."""
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
    """Give the lines that the arguments are: each a frame or a code by itself, or together the words of one line."""
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
    """Tell whether a line can be explained."""
    from canalyze._core import explain

    try:
        return explain(line) is not None
    except ValueError:
        return False


class _Explained:
    """Explanations on their way out, with a blank line between."""

    def __init__(self, words: Words, devices: "_core.Network | None") -> None:
        """Nothing explained yet. devices: what is known of them."""
        self.code = 0
        self._devices = devices
        self._words = words
        self._out = Output()
        self._between = ""

    def add(self, line: str, otherwise: str) -> None:
        """Explain one frame; what is none is answered with `otherwise`."""
        from canalyze._core import explain

        try:
            text = explain(line, self._words.lang, self._devices)
        except ValueError as error:  # meant as a frame: why it is none says more
            text, otherwise = None, str(error)
        if text is None:
            complain(f"canalyze: {otherwise}")
            self.code = 2
            return
        self._out.text(self._between + text.rstrip("\n") + "\n")
        self._between = "\n"

    def lines(self, nothing: click.UsageError | None) -> int:
        """Explain each line of standard input when it comes; blank lines and comments are skipped, as decode does.

        nothing: what is wrong when there is no line, if standard input was not asked for.
        """
        words = self._words
        some = False
        try:
            with open(0, "rb", closefd=False) as stdin:
                for number, raw in enumerate(stdin, 1):
                    line = raw.decode("utf-8", "replace").strip()
                    if line and not line.startswith("#"):
                        some = True
                        self.add(line, words("explain.no_frame_at", name="stdin", number=number, line=line))
        except OSError as error:
            raise SourceError("source.read" if some else "source.open", name="stdin", error=error) from error
        if not some:
            raise nothing or SourceError("explain.empty", name="stdin")
        return self.code
