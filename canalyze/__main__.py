"""The command `canalyze`, also as `python -m canalyze`: before anything else is imported, the end is made quiet.

Ctrl-C, SIGTERM and SIGHUP have an answer from here on, so that none of them ends in a traceback, however early or late
it comes: while nothing is at stake (imports, the interpreter's own end) the process just goes, with 130, 143 or 129; in
between the files that are being written are put in order first. While a capture is read, `run.Interrupt` has them.

Standard streams that the caller has closed are taken here, so that nothing else can get their numbers: a listing must
not be written to the socket of a bus.
"""

import gc
import os
import signal
import sys

TYPE_CHECKING = False  # `typing` takes as long as all the rest of this file
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType


def _go(number: int, _: object) -> None:
    os._exit(128 + number)


def _leave(number: int, _: object) -> None:
    raise SystemExit(128 + number)


def _answer(handler: "Callable[[int, FrameType | None], None]") -> None:
    """Take the signals, except one that the caller ignores (as a shell does for a command in the background)."""
    for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", None)):
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _keep_line_ends() -> None:
    """Let bytes through standard input and output as they are, where the system would else translate line ends."""
    if sys.platform == "win32":
        import contextlib
        import msvcrt

        for stream in (0, 1, 2):
            with contextlib.suppress(OSError):  # closed
                msvcrt.setmode(stream, os.O_BINARY)


def _take_closed_streams() -> None:
    """Open what refuses every use, as a closed stream does, where one is closed."""
    for stream in (0, 1, 2):
        try:
            os.fstat(stream)
        except OSError:
            opened = os.open(os.devnull, os.O_WRONLY if stream == 0 else os.O_RDONLY)
            if opened != stream:
                os.dup2(opened, stream)
                os.close(opened)


_answer(_go)
_take_closed_streams()
# What the start makes stays: to look through all of it for garbage again and again is a tenth of the start.
gc.set_threshold(50_000)


def main() -> int:
    """Run the command line; give the exit code."""
    from canalyze.cli import main as run

    _answer(_leave)
    _keep_line_ends()
    try:
        return run()
    finally:
        _answer(_go)


if __name__ == "__main__":
    sys.exit(main())
