"""Names of captures as they were given: patterns that no shell has expanded become the files that they name.

Must not: open a file.
"""

import glob
import os
import shlex
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from canalyze.errors import SourceError
from canalyze.sources.file import STDIN


class Named(NamedTuple):
    """A capture to read."""

    name: str
    error: SourceError | None = None
    """Why there is none of that name."""


def expanded(names: Iterable[str]) -> Iterator[Named]:
    """Give every file once, in the order given, those of a pattern sorted; `**` goes through directories."""
    seen: set[str] = set()
    for name in names:
        if name == STDIN or not glob.has_magic(name) or os.path.lexists(name):
            found = [name]
        else:
            # Not pathlib's, which gives other names than a shell: without ./ and, before 3.13, with hidden files.
            found = sorted(one for one in glob.glob(name, recursive=True) if not Path(one).is_dir())  # noqa: PTH207
            if not found:
                yield Named(name, SourceError("source.no_match", name=name))
        if found == [name] and Path(name).is_dir():  # what in it is a capture, nobody said
            pattern = shlex.quote(str(Path(name, "**", "*.log")))
            yield Named(name, SourceError("source.directory", name=name, pattern=pattern))
            continue
        for one in found:
            if one not in seen:
                seen.add(one)
                yield Named(one)
