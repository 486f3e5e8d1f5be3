"""Collects what python-can and asammdf log, warn and print, as lines, and keeps it off the terminal.

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
"""Maximum number of lines of the libraries that are passed on."""


class Heard(logging.Handler):
    """A context manager that collects the log, warnings and output of the libraries."""

    def __init__(self) -> None:
        """Starts with no lines."""
        super().__init__(logging.WARNING)
        self.errors = False
        """True if an error was logged."""
        self._lines: dict[str, None] = {}
        self._stack = contextlib.ExitStack()
        self._printed = io.StringIO()
        self._total = 0

    def emit(self, record: logging.LogRecord) -> None:
        """Collects a log record."""
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
        """Returns the lines since the last call, without duplicates."""
        lines, self._lines = list(self._lines), {}
        return lines

    def __enter__(self) -> Self:
        """Begins to collect."""
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
        """Restores logging, warnings and output."""
        self._stack.close()
        for warning in self._caught:
            self._keep(str(warning.message))
        for line in self._printed.getvalue().splitlines():
            self._keep(line)
        self._printed.seek(0)
        self._printed.truncate()
