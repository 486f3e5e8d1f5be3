"""The sources of `canalyze.open`, as inputs that can be read again and again.

Files stay where they are; everything else is taken at once and kept as bytes. It must not know a format: what is in
bytes tells the reader, as of a file.
"""

import os
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from canalyze.library.plan import Plan, shown_as
from canalyze.sources.file import Source
from canalyze.sources.format import Capture, identified
from canalyze.sources.memory import Memory, is_mcap, is_message, mcap_file, records

if TYPE_CHECKING:
    from canalyze.sources.pythoncan import PythonCanCapture


@dataclass(frozen=True, slots=True)
class Input:
    """One file, or what is as good as one."""

    name: str
    """For people."""
    path: Path | None
    """The file, absolute; None for what is in memory."""
    data: bytes = b""
    """The content in memory."""
    form: str | None = None
    """Its format where it is known."""

    def open(self) -> "Capture | PythonCanCapture":
        """Opens it; SourceError if that fails."""
        if self.form == "packed":
            return Capture(Memory(self.name, self.data), self.form)
        source = Memory(self.name, self.data) if self.path is None else Source(str(self.path), self.name)
        return identified(source, self.form)


def inputs(source: Any, plan: Plan) -> tuple[Input, ...]:
    """Returns the inputs of a source; TypeError for another type, SourceError for a file that is missing."""
    if isinstance(source, str | os.PathLike):
        return (_file(source, plan),)
    if isinstance(source, bytes | bytearray | memoryview):
        return (Input("bytes", None, bytes(source), plan.input_format),)
    if hasattr(source, "iter_messages"):  # a reader of MCAP; in the order of its file, as a file is read
        return (Input("mcap", None, mcap_file(source.iter_messages(log_time_order=False)), "mcap"),)
    if hasattr(source, "read"):
        return (_open_file(source, plan),)
    if not isinstance(source, Iterable):
        raise TypeError(f"source: a file, bytes or messages are needed, not {type(source).__name__}")
    items = iter(source)
    first = next(items, None)
    if first is None:
        raise ValueError("source: no file, and no message")
    every = chain([first], items)
    if isinstance(first, str | os.PathLike):
        return tuple(_file(one, plan) for one in every)
    if is_message(first):
        return (Input("messages", None, records(every), "packed"),)
    if is_mcap(first):
        return (Input("mcap", None, mcap_file(every), "mcap"),)
    raise TypeError(f"source: files or messages are needed, not {type(first).__name__}")


def _file(name: Any, plan: Plan) -> Input:
    """Returns the input of a file; SourceError, before it is read, if it cannot be opened."""
    if not isinstance(name, str | os.PathLike):
        raise TypeError(f"source: files are needed, not {type(name).__name__}")
    path = plan.folder / os.fspath(name)
    if not path.is_fifo():  # opening it would take the writer's first bytes
        with Source(str(path), shown_as(path)):
            pass
    return Input(shown_as(path), path, form=plan.input_format)


def _open_file(file: Any, plan: Plan) -> Input:
    data = file.read()
    if not isinstance(data, bytes | bytearray):
        raise TypeError("source: a file that is open for text; open it for bytes, as open(name, 'rb')")
    name = getattr(file, "name", None)
    return Input(name if isinstance(name, str) else "bytes", None, bytes(data), plan.input_format)
