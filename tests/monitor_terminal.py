"""`canalyze monitor` on a terminal of its own, typed to and looked at.

Why it exists: tests of the command line and those on a real bus need the same terminal. What it must not do: judge more
than that the terminal is left as it was.
"""

from __future__ import annotations

import os
import pty
import select
import struct
import termios
import time
from collections.abc import Callable
from fcntl import ioctl
from pathlib import Path

from conftest import environment, started

ON, OFF = b"\x1b[?1049h", b"\x1b[?1049l"
"""The screen of a program begins, and ends."""
QUIET_S = 0.5
"""For so long nothing may come of a program that has ended until all is taken for read: the terminal is a queue."""


class Terminal:
    """The program on a terminal of its own."""

    def __init__(self, directory: Path, *args: str, **env: str) -> None:
        """Start it, on 80 columns and 24 lines."""
        self._ours, theirs = pty.openpty()
        ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        self.before = termios.tcgetattr(theirs)
        self._theirs = theirs
        self.process = started(
            directory,
            "--lang",
            "en",
            "monitor",
            *args,
            stdin=theirs,
            stdout=theirs,
            env=environment(**({"LANG": "C.UTF-8", "TERM": "xterm-256color"} | env)),
            start_new_session=True,
        )
        self.shown = b""

    def until(self, holds: Callable[[bytes], bool], seconds: float = 60) -> bool:
        """Read what is shown until something holds of it."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if holds(self.shown):
                return True
            ended = self.process.poll() is not None
            if not self._more(QUIET_S if ended else 0.1) and ended:
                return holds(self.shown)
        return False

    def _more(self, within_s: float) -> bool:
        """Read what is shown by now; tell whether there was anything."""
        if not select.select([self._ours], [], [], within_s)[0]:
            return False
        self.shown += os.read(self._ours, 65536)
        return True

    def type(self, keys: bytes) -> None:
        os.write(self._ours, keys)

    def close(self) -> int:
        """Let the terminal go, as a window that is closed; give the exit code."""
        os.close(self._theirs)
        os.close(self._ours)
        assert self.process.stderr is not None
        self.process.stderr.close()
        return self.process.wait(30)

    def is_restored(self) -> bool:
        return termios.tcgetattr(self._theirs) == self.before

    def end(self, *, screen: bool = True) -> tuple[int, str]:
        """Wait for the end; give the exit code and standard error."""
        self.until(lambda shown: self.process.poll() is not None and shown.count(ON) == shown.count(OFF))
        assert self.process.stderr is not None
        with self.process.stderr as pipe:
            said = pipe.read().decode()
        code = self.process.wait(10)
        assert self.is_restored(), "the terminal is not what it was"
        assert (ON in self.shown) == screen
        assert self.shown.count(ON) == self.shown.count(OFF)
        os.close(self._ours)
        os.close(self._theirs)
        return code, said


def drawn(text: bytes) -> Callable[[bytes], bool]:
    return lambda shown: text in shown
