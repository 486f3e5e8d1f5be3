"""What python-can and asammdf log, warn of and print while they work: a line each, and nothing on the terminal.

Must not: judge it, or write it anywhere.
"""

import contextlib
import io
import logging
import sys
import warnings
from types import TracebackType
from typing import Final, Self

_REMARKS: Final = 20
"""Most lines of the libraries' that are passed on."""


class Heard(logging.Handler):
    """Keep what the libraries log, warn of and print, while they work, from the terminal; a context manager."""

    def __init__(self) -> None:
        """Nothing was heard."""
        super().__init__(logging.WARNING)
        self.errors = False
        """Something was logged as an error."""
        self._lines: dict[str, None] = {}
        self._stack = contextlib.ExitStack()
        self._printed = io.StringIO()
        self._total = 0

    def emit(self, record: logging.LogRecord) -> None:
        """Keep what is logged."""
        # Of a line of text that cannot be read the core says more.
        if record.name != "can.io.trc":
            self._keep(record.getMessage())
            self.errors |= record.levelno >= logging.ERROR

    def _keep(self, text: str) -> None:
        line = " ".join(text.split())[:200]
        if line and line not in self._lines and self._total < _REMARKS:
            self._total += 1
            self._lines[line] = None

    def take(self) -> list[str]:
        """Give the lines since the last call, each once."""
        lines, self._lines = list(self._lines), {}
        return lines

    def __enter__(self) -> Self:
        """Begin to listen."""
        for name in ("can", "asammdf"):
            logger = logging.getLogger(name)
            self._stack.callback(setattr, logger, "handlers", logger.handlers)
            self._stack.callback(setattr, logger, "propagate", logger.propagate)
            logger.handlers, logger.propagate = [self], False
        self._stack.enter_context(contextlib.redirect_stdout(self._printed))
        self._stack.enter_context(contextlib.redirect_stderr(self._printed))
        self._stack.callback(setattr, sys, "unraisablehook", sys.unraisablehook)
        sys.unraisablehook = lambda _: None  # of objects half made
        caught = self._stack.enter_context(warnings.catch_warnings(record=True))
        warnings.simplefilter("always")
        self._caught = caught or []
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Let the libraries speak for themselves again."""
        self._stack.close()
        for warning in self._caught:
            self._keep(str(warning.message))
        for line in self._printed.getvalue().splitlines():
            self._keep(line)
        self._printed.seek(0)
        self._printed.truncate()
