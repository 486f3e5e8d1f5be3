"""The target of a conversion: its format by its name or by request, and its writer.

The core returns the bytes of its own formats; those of `pythoncan.py` are written from the core's records. Must not:
know a frame.
"""

from collections.abc import Mapping
from pathlib import PurePath
from types import TracebackType
from typing import Final, NamedTuple

from canalyze.output import FileOutput, Output, open_output
from canalyze.sinks import pythoncan
from canalyze.sources.compressed import COMPRESSIONS


class CompressedOutput(FileOutput):
    """A compressed file; complete when its block ends without an error."""

    def __init__(self, name: str, compression: str, *, force: bool) -> None:
        """Creates the file `name`; `compression` is one of COMPRESSIONS."""
        self._compressor = COMPRESSIONS[compression].compressor()
        super().__init__(name, force=force)

    def write(self, data: bytes) -> None:
        """Compresses and writes."""
        super().write(self._compressor.compress(data))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Writes the remaining output of the compressor, then ends as every file."""
        if kind is None:
            try:
                super().write(self._compressor.flush())
            except BaseException as failure:
                super().__exit__(type(failure), failure, failure.__traceback__)
                raise
        super().__exit__(kind, error, at)


STDOUT: Final = "-"
RECORDS: Final = "packed"
"""The core's format for a writer outside of it."""

_SUFFIXES: Final[dict[str, tuple[str, ...]]] = {
    "candump": (".log", ".candump"),
    "console": (".txt",),
    "db": (".db", ".sqlite", ".sqlite3"),
}
"""Suffixes of formats whose suffix is not their name."""
_TEXT: Final = frozenset({"candump", "console", "asc"})
"""Formats that a terminal can show."""


class Target(NamedTuple):
    """A file or standard output with its format."""

    name: str
    form: str
    """One of `forms()`."""
    compression: str | None
    """One of COMPRESSIONS."""

    @property
    def written(self) -> str:
        """The format that the core has to write."""
        return self.form if self.form in _own() else RECORDS

    @property
    def fits_terminal(self) -> bool:
        """True if a terminal can show it."""
        return self.form in _TEXT


def _own() -> tuple[str, ...]:
    from canalyze._core import WRITERS

    return tuple(WRITERS)


def forms() -> tuple[str, ...]:
    """Returns the names of all formats that can be written."""
    return (*_own(), *pythoncan.LOSSES)


def suffixes() -> dict[str, str]:
    """Returns the formats by the suffixes of names."""
    return {suffix: form for form in forms() for suffix in _SUFFIXES.get(form, (f".{form}",))}


def compressions() -> dict[str, str]:
    """Returns the compressions by the suffixes of names."""
    return {one.suffix: name for name, one in COMPRESSIONS.items()}


def target(name: str, form: str | None) -> Target | None:
    """Returns the target of a name, with the requested format or that of its suffix; None if neither is known."""
    if name == STDOUT:
        return Target(name, form, None) if form else None
    path = PurePath(name)
    compression = compressions().get(path.suffix.lower())
    inner = path.with_suffix("") if compression else path
    form = form or suffixes().get(inner.suffix.lower())
    return Target(name, form, compression) if form else None


def open_target(where: Target, *, force: bool) -> tuple[Output, Mapping[str, int]]:
    """Returns the output for the core's bytes, a context manager, and its losses by names of the core's losses.

    Raises OutputError if the file exists and is not to be replaced, or cannot be written.
    """
    if where.written == RECORDS:
        sink = pythoncan.open_sink(where.name, where.form, force=force)
        return sink, sink.losses
    if where.compression:
        return CompressedOutput(where.name, where.compression, force=force), {}
    return open_output(where.name, force=force), {}
