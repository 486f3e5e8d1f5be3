"""The command `canalyze`, also as `python -m canalyze`; handles signals before anything else is imported.

Ctrl-C, SIGTERM and SIGHUP never end in a traceback: during imports and at the interpreter's own end the process
exits at once with 130, 143 or 129; in between, open files are completed first. While a capture is read,
`run.Interrupt` handles them.

Standard streams that the caller has closed are opened here, so that nothing else can get their numbers: a listing
must not be written to the socket of a bus.
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
    """Sets the handler of all signals, except ignored ones (as a shell does for a command in the background)."""
    for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", None)):
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _keep_line_ends() -> None:
    """Switches the standard streams to binary mode, where the system would translate line ends."""
    if sys.platform == "win32":
        import contextlib
        import msvcrt

        for stream in (0, 1, 2):
            with contextlib.suppress(OSError):  # closed
                msvcrt.setmode(stream, os.O_BINARY)


def _take_closed_streams() -> None:
    """Opens the null device in the wrong mode in place of each closed stream, so that its use fails."""
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
    """Runs the command line; returns the exit code."""
    from canalyze.cli import main as run

    _answer(_leave)
    _keep_line_ends()
    try:
        return run()
    finally:
        _answer(_go)
        gc.freeze()  # what is left ends with the process: to look through it for garbage is a sixth of a short run


if __name__ == "__main__":
    sys.exit(main())
