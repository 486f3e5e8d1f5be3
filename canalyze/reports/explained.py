"""Explanations of frames, codes and terms on their way out; also of standard input, line by line."""

from typing import TYPE_CHECKING

from canalyze.errors import SourceError
from canalyze.output import Output, complain
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze import _core


class Explained:
    """Explanations on their way out, with a blank line between."""

    def __init__(self, words: Words, devices: "_core.Network | None") -> None:
        """Nothing explained yet. devices: what is known of them."""
        self.code = 0
        self._devices = devices
        self._words = words
        self._out = Output()
        self._between = ""

    def add(self, line: str, otherwise: str) -> None:
        """Explains one frame; what is none is answered with `otherwise`."""
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

    def lines(self, nothing: Exception | None) -> int:
        """Explains each line of standard input when it comes; blank lines and comments are skipped, as decode does.

        nothing: is raised without a line, if standard input was not asked for.
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
