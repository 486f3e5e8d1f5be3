"""Runs Rerun's viewer as a child process: a window, or a page for a browser.

It listens only on the given address: Rerun's own functions to start it listen on all addresses, without access
control. It sends nothing, neither usage data nor a check for updates; requests of the page are the browser's. Must
not: know the content.
"""

import errno
import importlib
import importlib.util
import ipaddress
import os
import re
import shutil
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
from typing import Final, Self
from urllib.parse import quote

from canalyze.errors import CanalyzeError, OutputError, as_error
from canalyze.output.files import Part

_FOLDERS: Final = ("/usr/share/fonts", "/usr/local/share/fonts", "~/.fonts", "~/.local/share/fonts")
_LETTERS: Final = frozenset({".ttf", ".ttc", ".otf"})
_WAIT_S: Final = 10.0


def has_chinese(*, web: bool) -> bool:
    """Returns true if Chinese can be drawn, or if that is unknown.

    web: in a browser page, which has only its own fonts.
    """
    if web:
        return False
    if not sys.platform.startswith("linux"):
        return True
    program = shutil.which("fc-list")
    if program is None:
        # Without fontconfig: no font at all is no Chinese one.
        return any(_any_font(Path(folder).expanduser()) for folder in _FOLDERS)
    try:
        line = [program, ":lang=zh", "file"]
        found = subprocess.run(line, stdin=subprocess.DEVNULL, capture_output=True, timeout=_WAIT_S, check=False)
    except (OSError, subprocess.SubprocessError):
        return True
    return found.returncode != 0 or bool(found.stdout.strip())


def _any_font(folder: Path) -> bool:
    try:
        return any(one.suffix.lower() in _LETTERS for one in folder.rglob("*"))
    except OSError:
        return False


LOCAL: Final = "127.0.0.1"
"""The default address, which only this machine can reach."""

_START_S: Final = 30.0
"""Maximum time until it listens."""
_SETTLE_S: Final = 2.0
"""Maximum time for it to end before it is killed."""
_STEP_S: Final = 0.05
_SPOKEN: Final = 200
"""Maximum number of its output lines that are kept."""
_NOWHERE: Final = "http://127.0.0.1:9"
"""A proxy that does not exist, so that requests to other hosts fail."""
_SILENT: Final = {
    "CI": "1",  # the viewer neither collects usage data then, nor writes a file about it
    **{name: _NOWHERE for one in ("http_proxy", "https_proxy", "all_proxy") for name in (one, one.upper())},
}
_UNSET: Final = frozenset({"NO_PROXY", "no_proxy", "FORCE_RERUN_ANALYTICS", "RUST_LOG"})
_TAKEN: Final = (errno.EADDRINUSE, errno.EACCES)
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
_FAULT: Final = re.compile(r"^Error: *|.*\bERROR\b *[\w:]*: *|.*panicked at [^:]*(?::\d+)*:? *")


def require() -> None:
    """Checks that the extra of the timeline is installed. Raises CanalyzeError otherwise."""
    if importlib.util.find_spec("rerun") is None or _program() is None:
        raise CanalyzeError("view.missing")


def load() -> None:
    """Imports Rerun, which takes a while. Raises CanalyzeError if it is incomplete.

    Its messages on standard error are suppressed, and so is its wait at the end of this process for a viewer that is
    gone: `Timeline` completes its output itself.
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
    """Checks that there is a display for a window. Raises CanalyzeError otherwise."""
    if sys.platform.startswith("linux") and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY"))):
        raise CanalyzeError("view.no_display")


def address(text: str) -> str | None:
    """Returns an address to listen on; None for invalid text."""
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
    """Completes a recording that was written live: joins its pieces and appends an index.

    If that fails, the recording stays as it is, and is readable. Raises OutputError if the disk is full.
    """
    program = _program()
    if program is None:
        return
    with as_error(OutputError, "output.write", name=name):
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


class Viewer:
    """A running viewer; a context manager that ends it."""

    def __init__(self, *, path: str | None = None, bind: str = LOCAL, port: int | None = None, web: bool = False):
        """Starts the process; `ready` waits until it can be used. Raises CanalyzeError if it cannot be started.

        path: a recording to show; without one it waits for data at `connect`. port: of the page of the web viewer,
        which uses the next one for its data, or of the window; None: any free one. web: a page for a browser instead
        of a window.
        """
        program = _program()
        if program is None:
            raise CanalyzeError("view.missing")
        page, data = (0, *free_ports(bind, port, web=web))[-2:]
        host = f"[{bind}]" if ":" in bind else bind
        near = {"0.0.0.0": LOCAL, "::": "[::1]"}.get(bind, host)
        self.connect = f"rerun+http://{near}:{data}/proxy"
        """The address for recordings."""
        self.page = f"http://{near}:{page}/?url={quote(self.connect, safe='')}" if web else ""
        """The page for a browser; "" for a window."""
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
        """A temporary folder for its files."""
        self._process = _start(arguments, self._folder.name)
        self._listener = threading.Thread(target=self._listen, name="canalyze-viewer", daemon=True)
        self._listener.start()

    @property
    def running(self) -> bool:
        """True while it runs; the user may close it at any time."""
        return self._process.poll() is None

    @property
    def failure(self) -> CanalyzeError | None:
        """The reason for which it ended by itself; None if it runs, or was closed."""
        code = self._process.poll()
        if not code or self._asked_to_end:
            return None
        return CanalyzeError("view.died", problem=self._problem(code))

    def ready(self, unless: Callable[[], bool] = lambda: False) -> None:
        """Waits until it listens. Raises CanalyzeError if it fails. unless: ends the wait."""
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
        """Waits until the user closes it."""
        while self.running:
            time.sleep(_STEP_S)

    def close(self) -> None:
        """Ends it, in bounded time. Calling it twice is harmless."""
        self._asked_to_end = self._asked_to_end or self.running
        for end in (self._process.terminate, self._process.kill):
            if self.running:
                end()
                with suppress(subprocess.TimeoutExpired):
                    self._process.wait(_SETTLE_S)
        self._listener.join(_SETTLE_S)
        self._folder.cleanup()

    def __enter__(self) -> Self:
        """Returns the viewer."""
        return self

    def __exit__(self, *_: object) -> None:
        """Ends it."""
        self.close()

    def _listen(self) -> None:
        """Reads its output, so that it does not block, and keeps the last lines."""
        assert self._process.stdout is not None
        with self._process.stdout as said:
            for line in said:
                self._said.append(_COLOUR.sub("", line.decode("utf-8", "replace")).strip())

    def _problem(self, code: int) -> str:
        """Returns its last error message, on one line."""
        for line in reversed(self._said):
            if found := _FAULT.match(line):
                return line[found.end() :][:300] or line[:300]
        killed = signal.strsignal(-code) or "" if code < 0 else ""
        last = next((line for line in reversed(self._said) if line), "")
        return killed or last[:300] or str(code)


def free_ports(bind: str, port: int | None, *, web: bool) -> tuple[int, ...]:
    """Returns free consecutive ports for a viewer, from `port` on. Raises OutputError if one is in use.

    The viewer would send its data to any process that listens there.
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
    with as_error(CanalyzeError, "view.start"):
        return subprocess.Popen(
            arguments,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=_environment() | dict.fromkeys(("TMPDIR", "TEMP", "TMP"), folder),
            start_new_session=True,  # Ctrl-C is for us: what was received has to be shown before it ends
            preexec_fn=_tied(),
        )


def _environment() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name not in _UNSET} | _SILENT


def _tied() -> Callable[[], None] | None:
    """Returns a function that makes a child process end with this one, even if this one is killed, where supported."""
    if not sys.platform.startswith("linux"):
        return None
    import ctypes

    try:
        prctl = ctypes.CDLL(None).prctl
    except (OSError, AttributeError):
        return None
    return lambda: prctl(1, signal.SIGTERM, 0, 0, 0)  # PR_SET_PDEATHSIG
