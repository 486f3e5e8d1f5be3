"""MF4 read in a process of its own: of a damaged file asammdf may bring the whole process down, and not only raise.

The process that is asked runs this file's `main` in another one, and takes from it what its bridge gives, piece by
piece: a tag, a size, and the piece. Where that process ends without a last piece, it was brought down. Must not: know
a format.
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
    """The other process ended where it should not; its message says by what."""


def pieces(path: Path, scratch: Path) -> Iterator[tuple[bytes, bytes]]:
    """Give what the bridge in the other process gives of a file, each with its tag; BroughtDown where it breaks off.

    scratch: a directory for what that process puts down and may leave behind.
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
    """Give the same as `pieces`, in this process."""
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
    """Read a file and write the pieces to standard output, in a process that does nothing else."""
    out = sys.stdout.buffer
    for tag, piece in here(Path(name)):
        out.write(_HEAD.pack(tag, len(piece)) + piece)
        out.flush()
    out.write(_HEAD.pack(_END, 0))
    out.flush()
