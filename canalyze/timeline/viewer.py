"""Rerun's viewer as a process of ours: a window, or a page for a browser; started, watched, and ended with us.

It listens on the address that it is given and on nothing else: Rerun's own ways of starting it listen on all of them,
without a question who connects. It sends nothing either, no usage data and no question for newer versions; what the
page does in a browser is the browser's. Must not: know what is shown.
"""

import errno
import importlib
import importlib.util
import ipaddress
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Final, Self
from urllib.parse import quote

from canalyze.errors import CanalyzeError, OutputError
from canalyze.output.writing import Part

LOCAL: Final = "127.0.0.1"
"""Where it listens unless something else is said: nobody but this machine gets there."""

_START_S: Final = 30.0
"""How long it may take until it listens."""
_SETTLE_S: Final = 2.0
"""How long it is waited for a viewer that has to end, before it is made to."""
_STEP_S: Final = 0.05
_SPOKEN: Final = 200
"""Lines of the viewer that are kept."""
_NOWHERE: Final = "http://127.0.0.1:9"
"""A proxy that is not there: whatever asks the world outside gets no further."""
_SILENT: Final = {
    "CI": "1",  # the viewer neither collects usage data then, nor writes a file about it
    **{name: _NOWHERE for one in ("http_proxy", "https_proxy", "all_proxy") for name in (one, one.upper())},
}
_UNSET: Final = frozenset({"NO_PROXY", "no_proxy", "FORCE_RERUN_ANALYTICS", "RUST_LOG"})
_TAKEN: Final = (errno.EADDRINUSE, errno.EACCES)
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
_FAULT: Final = re.compile(r"^Error: *|.*\bERROR\b *[\w:]*: *|.*panicked at [^:]*(?::\d+)*:? *")


def require() -> None:
    """Make sure that what a timeline needs is installed: an optional part; CanalyzeError where it is not."""
    if importlib.util.find_spec("rerun") is None or _program() is None:
        raise CanalyzeError("view.missing")


def load() -> None:
    """Load what a timeline is written with, which takes a while; CanalyzeError where that is not whole.

    It says what it thinks on standard error by itself: it is kept from that here, where it is first used. So it is from
    waiting without end, when this process ends, for a viewer that is gone: `Timeline` completes what it writes itself.
    """
    said = os.environ.get("RUST_LOG")
    os.environ["RUST_LOG"] = "off"
    try:
        importlib.import_module("rerun").unregister_shutdown()
    except ImportError as error:
        raise CanalyzeError("view.missing") from error
    finally:
        if said is None:
            del os.environ["RUST_LOG"]
        else:
            os.environ["RUST_LOG"] = said


def need_display() -> None:
    """Make sure that there is a screen for a window; CanalyzeError where there is none."""
    if sys.platform.startswith("linux") and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY"))):
        raise CanalyzeError("view.no_display")


def address(text: str) -> str | None:
    """Read an address to listen on; None for what is none."""
    try:
        return str(ipaddress.ip_address(text))
    except ValueError:
        return None


def _program() -> str | None:
    found = importlib.util.find_spec("rerun_cli")
    for folder in (found.submodule_search_locations or ()) if found else ():
        path = Path(folder) / ("rerun.exe" if sys.platform == "win32" else "rerun")
        if path.is_file():
            return str(path)
    return None


def completed(name: str) -> None:
    """Complete a recording that was written as it came: its pieces are joined, and an index stands at its end.

    What cannot be completed stays as it is, and can be read. OutputError where that is for want of room.
    """
    program = _program()
    if program is None:
        return
    try:
        part = Part(Path(name), replace=True)
        os.close(part.fd)
        try:
            arguments = [program, "rrd", "optimize", "-o", str(part.path), name]
            nothing = subprocess.DEVNULL
            done = subprocess.run(arguments, stdin=nothing, capture_output=True, env=_environment(), check=False)
            if done.returncode == 0:
                part.complete()
        finally:
            part.discard()
    except OSError as error:
        raise OutputError("output.write", name=name, error=error) from error


class Viewer:
    """A viewer that runs; a context manager that ends it."""

    def __init__(self, *, path: str | None = None, bind: str = LOCAL, port: int | None = None, web: bool = False):
        """Start its process; `ready` waits until it can be used. CanalyzeError where it cannot be started.

        path: a recording that it shows; without one it waits for what is sent to `connect`. port: of the page of the
        web viewer, whose data come through the next one, or of the window; None: one that is free. web: a page for a
        browser instead of a window.
        """
        program = _program()
        if program is None:
            raise CanalyzeError("view.missing")
        page, data = (0, *free_ports(bind, port, web=web))[-2:]
        host = f"[{bind}]" if ":" in bind else bind
        near = {"0.0.0.0": LOCAL, "::": "[::1]"}.get(bind, host)
        self.connect = f"rerun+http://{near}:{data}/proxy"
        """Where a recording is sent to."""
        self.page = f"http://{near}:{page}/?url={quote(self.connect, safe='')}" if web else ""
        """The page for a browser; "" where there is a window."""
        arguments = [program, "--bind", bind, "--port", str(data), "--hide-welcome-screen"]
        if web:
            origin = "*" if near != host else host
            arguments += ["--serve-web", "--web-viewer-port", str(page), "--server-memory-limit", "50%"]
            arguments += ["--cors-allow-origin", f"http://{origin}:{page}"]
        elif path is None:
            arguments.append("--expect-data-soon")
        if path is not None:
            arguments += ["--", path]
        self._said: deque[str] = deque(maxlen=_SPOKEN)
        self._asked_to_end = False
        self._address = {"0.0.0.0": LOCAL, "::": "::1"}.get(bind, bind)
        self._ports = (data, page) if web else (data,)
        self._folder = TemporaryDirectory(prefix="canalyze-viewer-", ignore_cleanup_errors=True)
        """What it leaves behind goes with it."""
        self._process = _start(arguments, self._folder.name)
        self._listener = threading.Thread(target=self._listen, name="canalyze-viewer", daemon=True)
        self._listener.start()

    @property
    def running(self) -> bool:
        """Whether it is still there: the user may close it at any time."""
        return self._process.poll() is None

    @property
    def failure(self) -> CanalyzeError | None:
        """Why it has ended by itself; None where it runs, or was closed."""
        code = self._process.poll()
        if not code or self._asked_to_end:
            return None
        return CanalyzeError("view.died", problem=self._problem(code))

    def ready(self, unless: Callable[[], bool] = lambda: False) -> None:
        """Wait until it listens; CanalyzeError where it does not come so far. unless: ends the waiting."""
        end = time.monotonic() + _START_S
        waiting = list(self._ports)
        while waiting and not unless():
            if not self.running:
                self._listener.join(_SETTLE_S)
                raise CanalyzeError("view.died", problem=self._problem(self._process.returncode))
            if time.monotonic() > end:
                raise CanalyzeError("view.silent", seconds=f"{_START_S:.0f}")
            try:
                socket.create_connection((self._address, waiting[0]), 1.0).close()
            except OSError:
                time.sleep(_STEP_S)
            else:
                del waiting[0]

    def wait(self) -> None:
        """Wait until the user has closed it."""
        while self.running:
            time.sleep(_STEP_S)

    def close(self) -> None:
        """End it; in bounded time, whatever it does. Twice is harmless."""
        self._asked_to_end = self._asked_to_end or self.running
        for end in (self._process.terminate, self._process.kill):
            if self.running:
                end()
                with suppress(subprocess.TimeoutExpired):
                    self._process.wait(_SETTLE_S)
        self._listener.join(_SETTLE_S)
        self._folder.cleanup()

    def __enter__(self) -> Self:
        """Give it."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """End it."""
        self.close()

    def _listen(self) -> None:
        """Take what it says, so that it can go on; little of that is worth telling."""
        assert self._process.stdout is not None
        with self._process.stdout as said:
            for line in said:
                self._said.append(_COLOUR.sub("", line.decode("utf-8", "replace")).strip())

    def _problem(self, code: int) -> str:
        """Give what it said last of what is wrong, on one line."""
        for line in reversed(self._said):
            if found := _FAULT.match(line):
                return line[found.end() :][:300] or line[:300]
        killed = signal.strsignal(-code) or "" if code < 0 else ""
        last = next((line for line in reversed(self._said) if line), "")
        return killed or last[:300] or str(code)


def free_ports(bind: str, port: int | None, *, web: bool) -> tuple[int, ...]:
    """Give the ports of a viewer, on which nobody listens yet; OutputError where somebody does.

    They are one after the other from `port` on. The viewer would hand what it is to show to whoever listens there.
    """
    family = socket.AF_INET6 if ":" in bind else socket.AF_INET
    count = 2 if web else 1
    wanted = [0] * count if port is None else range(port, port + count)
    held: list[socket.socket] = []
    try:
        for one in wanted:
            try:
                held.append(socket.create_server((bind, one), family=family))
            except OSError as error:
                key = "view.port_taken" if one and error.errno in _TAKEN else "view.no_address"
                plain = OSError(error.errno, os.strerror(error.errno)) if error.errno else error  # no more than why
                raise OutputError(key, address=bind, port=one, error=plain) from error
        return tuple(one.getsockname()[1] for one in held)
    finally:
        for server in held:
            server.close()


def _start(arguments: list[str], folder: str) -> "subprocess.Popen[bytes]":
    try:
        return subprocess.Popen(
            arguments,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=_environment() | dict.fromkeys(("TMPDIR", "TEMP", "TMP"), folder),
            start_new_session=True,  # Ctrl-C is for us: what was received has to be shown before it ends
            preexec_fn=_tied(),
        )
    except OSError as error:
        raise CanalyzeError("view.start", error=error) from error


def _environment() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name not in _UNSET} | _SILENT


def _tied() -> Callable[[], None] | None:
    """Give what ties a process to us where the system can: it ends with us also where we are killed."""
    if not sys.platform.startswith("linux"):
        return None
    import ctypes

    try:
        prctl = ctypes.CDLL(None).prctl
    except (OSError, AttributeError):
        return None
    return lambda: prctl(1, signal.SIGTERM, 0, 0, 0)  # PR_SET_PDEATHSIG
