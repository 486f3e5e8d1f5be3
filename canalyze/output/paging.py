"""A pager between standard output and the terminal, as git has one.

It is started by the first output, so that a command without output has none. Until its end it also gets standard
error if that is the terminal. Must not: know the content.
"""

import os
import signal
import sys
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from canalyze.output import Output

if TYPE_CHECKING:
    import subprocess

_STDOUT: Final = 1
_STDERR: Final = 2
_USUAL: Final = "less -FRX"
_OPTIONS: Final = "FRX"
"""Options for a `less` that the user has chosen without options: it ends if all fits the screen, and keeps colours."""


def program() -> list[str]:
    """Returns the command line of the pager that the environment selects; empty for none."""
    import shlex
    import shutil

    found = os.environ.get
    asked = next((value for name in ("CANALYZE_PAGER", "PAGER") if (value := found(name)) is not None), None)
    if asked is None:
        return _USUAL.split() if shutil.which("less") else []
    try:
        words = shlex.split(asked, posix=os.name == "posix")
    except ValueError:
        words = [asked]
    return [] if words == ["cat"] else words


class Pager:
    """The pager of this process; a context manager that waits for it at the end."""

    def __init__(self, unusable: Callable[[str, OSError], None]) -> None:
        """Prepares the pager. unusable: called if it cannot be started."""
        self._unusable = unusable
        self._process: subprocess.Popen[bytes] | None = None
        self._kept: dict[int, int] = {}
        self._columns: str | None = None

    def __enter__(self) -> Self:
        """Lets standard output start the pager."""
        Output.pager = self
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Restores the terminal, and waits until the user closes the pager."""
        Output.pager = None
        if self._process is None:
            return
        for stream, kept in self._kept.items():
            os.dup2(kept, stream)
            os.close(kept)
        if self._columns is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = self._columns
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is the pager's, which has the terminal
        try:
            self._process.wait()
        finally:
            if self._process.poll() is None:
                self._process.terminate()
            signal.signal(signal.SIGINT, before)

    def begin(self) -> None:
        """Starts the pager, if one is configured and the terminal can show it."""
        import shutil
        import subprocess

        Output.pager = None
        line = program()
        if not line or os.environ.get("TERM", "dumb") == "dumb":
            return
        wide = str(shutil.get_terminal_size().columns)
        environment = {"LESS": _OPTIONS} | os.environ
        if (sys.stdout.encoding or "").lower().replace("_", "-") in ("utf-8", "utf8"):
            environment = {"LESSCHARSET": "utf-8"} | environment
        try:
            self._process = subprocess.Popen(line, stdin=subprocess.PIPE, env=environment)
        except OSError as error:
            self._unusable(line[0], error)
            return
        assert self._process.stdin is not None
        pipe = self._process.stdin
        for stream in (_STDOUT, _STDERR):
            if os.isatty(stream):
                self._kept[stream] = os.dup(stream)
                os.dup2(pipe.fileno(), stream, inheritable=False)
        pipe.close()
        # Layouts still use the terminal's width, although standard output is a pipe now.
        self._columns = os.environ.get("COLUMNS")
        os.environ["COLUMNS"] = wide
