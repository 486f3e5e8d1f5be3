"""The bridge to python-can: files that it alone reads, adapters, and messages in memory.

packed.py    messages as records of the core, and records as messages
reading.py   MF4, CSV and SQLite; database.py private copies of SQLite databases
buses.py     channels of adapters

Here python-can is imported, when it is needed, and what it logs is collected. It imports asammdf if that is installed,
which takes four times as long as everything else and is needed for MF4 alone; so it is hidden until then. Must not:
read or write anything.
"""

import importlib
import importlib.util
import io
import logging
import sys
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from types import ModuleType
from typing import Final

_MF4: Final = "can.io.mf4"
_ASAMMDF: Final = "asammdf"
REMARKS: Final = 20
"""Maximum number of lines of the libraries that are passed on."""


def library(*, mf4: bool = False) -> ModuleType:
    """Returns the module `can`. With `mf4` its MF4 classes work; raises ImportError if asammdf is not installed."""
    if not mf4:
        return _without_asammdf()
    import can

    importlib.import_module(_ASAMMDF)  # after python-can: it may import that, which then would miss it
    module = importlib.import_module(_MF4)
    if module.asammdf is None:  # python-can was imported without it
        module = importlib.reload(module)
        for name in ("MF4Reader", "MF4Writer"):
            setattr(can, name, getattr(module, name))
    return can


def has_asammdf() -> bool:
    """Returns true if asammdf is installed."""
    return importlib.util.find_spec(_ASAMMDF) is not None


def _without_asammdf() -> ModuleType:
    if "can" not in sys.modules and _ASAMMDF not in sys.modules:
        sys.modules[_ASAMMDF] = None  # type: ignore[assignment]  # as the import system has it: this cannot be imported
        try:
            return importlib.import_module("can")
        finally:
            del sys.modules[_ASAMMDF]
    return importlib.import_module("can")


class Heard(logging.Handler):
    """Collects what the libraries log, each line once."""

    def __init__(self) -> None:
        """Starts with no lines."""
        super().__init__(logging.WARNING)
        self.errors = False
        """True if an error was logged."""
        self._lines: dict[str, None] = {}
        self._new: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Collects a log record."""
        self._keep(record.getMessage())
        self.errors |= record.levelno >= logging.ERROR

    def _keep(self, text: object) -> None:
        line = " ".join(str(text).split())[:200]
        if line and line not in self._lines and len(self._lines) < REMARKS:
            self._lines[line] = None
            self._new.append(line)

    def take(self) -> list[str]:
        """Returns the lines since the last call."""
        self.acquire()  # as `emit` has it: channels have threads of their own
        try:
            new, self._new = self._new, []
        finally:
            self.release()
        return new

    @contextmanager
    def everything(self) -> Iterator[None]:
        """Within its block nothing but the collected lines is logged, and warnings and output are collected too."""
        printed = io.StringIO()
        with ExitStack() as stack:
            for name in ("can", _ASAMMDF):
                logger = logging.getLogger(name)
                stack.callback(setattr, logger, "handlers", logger.handlers)
                stack.callback(setattr, logger, "propagate", logger.propagate)
                logger.handlers, logger.propagate = [self], False
            stack.enter_context(redirect_stdout(printed))
            stack.enter_context(redirect_stderr(printed))
            stack.callback(setattr, sys, "unraisablehook", sys.unraisablehook)
            sys.unraisablehook = lambda _: None  # of objects half made
            stack.enter_context(warnings.catch_warnings())
            warnings.simplefilter("always")
            warnings.showwarning = lambda message, *_: self._keep(message)
            try:
                yield
            finally:
                for line in printed.getvalue().splitlines():
                    self._keep(line)
