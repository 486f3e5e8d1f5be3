"""Reads MF4 in a separate process, because asammdf may crash the process on a damaged file.

The parent runs this file's `main` in a child process and reads its output piece by piece: a tag, a size and the
payload. If the child ends without a final piece, it has crashed. Must not: know a format.
"""

import os
import signal
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

from canalyze.errors import CanalyzeError

RECORDS: Final = b"R"
REMARK: Final = b"S"
REFUSED: Final = b"X"
_END: Final = b"E"
_HEAD: Final = struct.Struct("<cI")
_START: Final = "import sys; sys.path[:] = sys.argv[2:]; from canalyze.sources.apart import main; main(sys.argv[1])"


class BroughtDown(Exception):
    """The child process crashed; the message is the name of the signal, or its exit code."""


def pieces(path: Path, scratch: Path) -> Iterator[tuple[bytes, bytes]]:
    """Yields the tagged pieces that the child process writes for a file. Raises BroughtDown if it crashes.

    scratch: a directory for the temporary files of the child process.
    """
    # Not in this session: a Ctrl-C is for this process, which ends the other one.
    with subprocess.Popen(
        [sys.executable, "-c", _START, str(path), *sys.path],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"TMPDIR": str(scratch)},
        start_new_session=True,
    ) as process:
        assert process.stdout is not None
        try:
            while len(head := process.stdout.read(_HEAD.size)) == _HEAD.size:
                tag, size = _HEAD.unpack(head)
                piece = process.stdout.read(size)
                if tag == _END:
                    return
                if len(piece) == size:
                    yield tag, piece
            code = process.wait()
        finally:
            process.kill()
    name = str(code)
    with suppress(ValueError):
        name = signal.Signals(-code).name
    raise BroughtDown(name)


def here(path: Path, _: Path | None = None) -> Iterator[tuple[bytes, bytes]]:
    """Yields the same pieces as `pieces`, read in this process."""
    from canalyze.sources.file import Source
    from canalyze.sources.format import Opened
    from canalyze.sources.pythoncan import PythonCanCapture

    opened = Opened(Source(str(path)))
    with PythonCanCapture(opened, opened.head, "mf4", trusting=True) as capture:
        data, refusal = b"-", None
        while data and not refusal:
            try:
                data = capture.read()
            except CanalyzeError as error:
                refusal = error
            for remark in capture.remarks():
                yield REMARK, _problem(remark)
            if refusal:
                yield REFUSED, _problem(refusal)
            elif data:
                yield RECORDS, data


def _problem(error: CanalyzeError) -> bytes:
    return str(error.facts.get("problem", error)).encode("utf-8", "replace")


def main(name: str) -> None:
    """Reads a file and writes the pieces to standard output; the entry point of the child process."""
    out = sys.stdout.buffer
    for tag, piece in here(Path(name)):
        out.write(_HEAD.pack(tag, len(piece)) + piece)
        out.flush()
    out.write(_HEAD.pack(_END, 0))
    out.flush()
