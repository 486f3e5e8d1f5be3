"""Command lines run by forks of one process that has loaded canalyze already: as a shell would, without the loading.

Why it exists: the tests run some thousands of command lines, and most of the time of each would go into the start of
Python. A fork has streams, directory, environment, signals and an end of its own, as a process that was started. What
differs is that modules were loaded before: where a variable has a say in how Python starts, it is really started.
Three quarters of the time of a short command line go into the fork. Where hundreds of them are alike, `kept` has one
process answer them one after the other, with streams, directory and environment of their own. `start` forks
programs that listen meanwhile.
What it must not do: be used by tests of the start itself, or of what is loaded.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import select
import selectors
import signal
import socket
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import IO, Any, NoReturn

OF_PYTHON = ("PYTHON", "LC_", "LANG", "LD_")
"""How variables are called that have a say in how Python starts; LC_MESSAGES has none."""
_MOST = 1 << 16
_WORD = 8


def run(
    arguments: Sequence[str],
    *,
    stdin: bytes = b"",
    cwd: Path | None = None,
    env: Mapping[str, str],
    timeout_s: float,
    kept: bool = False,
) -> subprocess.CompletedProcess[bytes]:
    """Runs `canalyze` with these arguments to its end, all three streams being pipes.

    `kept`: in a process that has answered others before; for command lines that read and write, and no more.
    """
    wanted = of_python(env)
    if not forks(env):
        line = [sys.executable, "-m", "canalyze", *arguments]
        return subprocess.run(line, input=stdin, capture_output=True, cwd=cwd, env=env, timeout=timeout_s, check=False)
    forker = _forker(os.getpid(), tuple(sorted(wanted.items())), kept=kept)
    try:
        return forker.run(arguments, stdin, cwd or Path.cwd(), env, timeout_s)
    finally:
        if forker.ended:  # by this command line, or since it took too long: another one is kept for the next
            _forker.cache_clear()


def start(
    arguments: Sequence[str], *, cwd: Path, env: Mapping[str, str], stdout: IO[bytes], stderr: IO[bytes]
) -> subprocess.Popen[bytes] | Started:
    """Starts `canalyze` in a process group of its own, and does not wait for it; it reads nothing."""
    wanted = of_python(env)
    if not (forks(env) and hasattr(os, "pidfd_open")):
        line, nothing = [sys.executable, "-m", "canalyze", *arguments], subprocess.DEVNULL
        return subprocess.Popen(
            line, stdin=nothing, stdout=stdout, stderr=stderr, cwd=cwd, env=env, start_new_session=True
        )
    forker = _forker(os.getpid(), tuple(sorted(wanted.items())), kept=False)
    with open(os.devnull, "rb") as nothing_to_read:
        streams = [nothing_to_read.fileno(), stdout.fileno(), stderr.fileno()]
        return Started(forker, forker.start(arguments, streams, cwd, env, apart=True))


def forks(env: Mapping[str, str]) -> bool:
    """Whether a fork does for this environment: here there are forks, and Python starts in it as it started here."""
    return hasattr(os, "fork") and of_python(env) in (_GIVEN, _USUAL)


def of_python(env: Mapping[str, str]) -> dict[str, str]:
    """What has a say in how Python starts."""
    return {name: value for name, value in env.items() if name.startswith(OF_PYTHON) and name != "LC_MESSAGES"}


_GIVEN = of_python(os.environ)
"""As the tests were started."""
_USUAL = {name: value for name, value in _GIVEN.items() if name not in ("LC_ALL", "PYTHONIOENCODING", "PYTHONUTF8")}
"""The same without what would choose a language: `conftest.environment`."""


@cache
def _forker(process: int, wanted: tuple[tuple[str, str], ...], *, kept: bool) -> _Forker:
    """The one of this process, started with these variables."""
    found = _Forker(dict(wanted), kept=kept)
    atexit.register(found.close)
    return found


class _Forker:
    """The process that forks, or that is kept, seen from outside; it ends with who started it."""

    def __init__(self, wanted: Mapping[str, str], *, kept: bool) -> None:
        self._kept = kept
        others = {name: value for name, value in os.environ.items() if not name.startswith(OF_PYTHON)}
        self._asking, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, str(Path(__file__).resolve()), str(theirs.fileno()), "kept" if kept else "forks"],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                env=others | dict(wanted),
                pass_fds=[theirs.fileno()],
            )

    def close(self) -> None:
        self._asking.close()
        self._process.wait()

    def run(
        self, arguments: Sequence[str], stdin: bytes, cwd: Path, env: Mapping[str, str], timeout_s: float
    ) -> subprocess.CompletedProcess[bytes]:
        (stdin_end, to_stdin), (from_stdout, stdout_end), (from_stderr, stderr_end) = os.pipe(), os.pipe(), os.pipe()
        theirs = [stdin_end, stdout_end, stderr_end]
        try:
            process = self.start(arguments, theirs, cwd, env)
        finally:
            for end in theirs:
                os.close(end)
        try:
            out, err = _exchange(to_stdin, stdin, from_stdout, from_stderr, time.monotonic() + timeout_s)
        except TimeoutError:
            os.kill(process, signal.SIGKILL)
            raise subprocess.TimeoutExpired(list(arguments), timeout_s) from None
        finally:
            code = self.code(process)
        return subprocess.CompletedProcess(list(arguments), code, out, err)

    def start(
        self,
        arguments: Sequence[str],
        streams: Sequence[int],
        cwd: Path,
        env: Mapping[str, str],
        *,
        apart: bool = False,
    ) -> int:
        """Has a command line begin with these streams; its process, which is one `apart` in a session of its own."""
        asked = {"arguments": list(arguments), "cwd": str(cwd), "env": dict(env), "apart": apart}
        socket.send_fds(self._asking, [json.dumps(asked).encode()], streams)
        return int.from_bytes(self._asking.recv(_WORD), "little")

    def code(self, process: int) -> int:
        """Waits for its end; how it ended, as `subprocess` has it."""
        if not self._kept:
            self._asking.send(json.dumps({"reap": process}).encode())
        told = self._asking.recv(_WORD)
        return os.waitstatus_to_exitcode(int.from_bytes(told, "little")) if told else self._process.wait()

    @property
    def ended(self) -> bool:
        """True if the process has ended, as one that is kept where a command line ends it."""
        return self._process.poll() is not None


class Started:
    """A fork that runs, as `subprocess.Popen` shows a process."""

    def __init__(self, forker: _Forker, process: int) -> None:
        """One that this forker has forked."""
        self.pid = process
        self.returncode: int | None = None
        self._forker = forker
        self._end = os.pidfd_open(process)

    def poll(self) -> int | None:
        """The exit code; None while it runs."""
        return self._ended(0.0)

    def wait(self, timeout: float | None = None) -> int:
        """Waits for its end."""
        code = self._ended(timeout)
        if code is None:
            raise subprocess.TimeoutExpired(str(self.pid), timeout or 0)
        return code

    def send_signal(self, number: int) -> None:
        """Sends it a signal while it runs."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def _ended(self, within_s: float | None) -> int | None:
        if self.returncode is None and select.select([self._end], [], [], within_s)[0]:
            os.close(self._end)
            self.returncode = self._forker.code(self.pid)
        return self.returncode


def _exchange(to_stdin: int, stdin: bytes, from_stdout: int, from_stderr: int, end: float) -> tuple[bytes, bytes]:
    """Gives what it reads and takes what it writes, until it has closed both; all three are closed here."""
    told: dict[int, list[bytes]] = {from_stdout: [], from_stderr: []}
    rest = memoryview(stdin)
    open_ = {from_stdout, from_stderr, to_stdin}
    try:
        with selectors.DefaultSelector() as ready:
            for one in told:
                ready.register(one, selectors.EVENT_READ)
            os.set_blocking(to_stdin, False)
            ready.register(to_stdin, selectors.EVENT_WRITE)

            def closed(one: int) -> None:
                ready.unregister(one)
                open_.discard(one)
                os.close(one)

            while open_ & told.keys():
                if not (found := ready.select(end - time.monotonic())) and time.monotonic() > end:
                    raise TimeoutError
                for key, _ in found:
                    if key.fd != to_stdin:
                        piece = os.read(key.fd, _MOST)
                        told[key.fd].append(piece)
                        if not piece:
                            closed(key.fd)
                        continue
                    try:
                        rest = rest[os.write(to_stdin, rest[:_MOST]) :] if rest else rest
                    except BrokenPipeError:
                        rest = rest[:0]
                    if not rest:
                        closed(to_stdin)
    finally:
        for one in open_:
            os.close(one)
    return b"".join(told[from_stdout]), b"".join(told[from_stderr])


# What follows runs in the process that forks, or is kept.


def _serve(asked: socket.socket, *, kept: bool) -> None:
    from canalyze import __main__, cli

    group = cli.build("en")
    for name in cli.COMMANDS:
        group.get_command(None, name)  # type: ignore[arg-type]
    _load()
    gc.freeze()
    while True:
        text, streams, *_ = socket.recv_fds(asked, 1 << 20, 3)
        if not text:
            return
        request = json.loads(text)
        if "reap" in request:
            asked.send(os.waitpid(request["reap"], 0)[1].to_bytes(_WORD, "little"))
            continue
        if kept:
            asked.send(os.getpid().to_bytes(_WORD, "little"))
            asked.send((_kept_run(request, streams) << 8).to_bytes(_WORD, "little"))
            continue
        process = os.fork()
        if process == 0:
            asked.close()
            if request["apart"]:
                os.setsid()
            _enter(request, streams)
            _end(_run(__main__.main))
        for stream in streams:
            os.close(stream)
        while request["apart"] and os.getpgid(process) != process:  # who asked may end its group at once
            time.sleep(0.001)
        asked.send(process.to_bytes(_WORD, "little"))


def _enter(request: dict[str, Any], streams: Sequence[int]) -> None:
    """Makes a request's streams, directory and environment those of this process."""
    from canalyze import __main__

    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    sys.argv = [str(__main__.__file__), *request["arguments"]]
    sys.path[0] = request["cwd"]
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["env"])
    time.tzset()


def _kept_run(request: dict[str, Any], streams: Sequence[int]) -> int:
    """Runs a command line in this process, and leaves it as it was; its exit code."""
    from canalyze import __main__

    _enter(request, streams)
    opened = sys.stdin, sys.stdout, sys.stderr
    handlers = [(one, signal.getsignal(one)) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGPIPE)]
    for name, file, mode in zip(("stdin", "stdout", "stderr"), opened, "rww", strict=True):
        fresh = open(file.fileno(), mode, encoding=file.encoding, errors=file.errors, closefd=False)  # noqa: SIM115
        setattr(sys, name, fresh)
    code = _finished(_run(__main__.main))
    for thread in threading.enumerate():
        if thread is not threading.main_thread() and not thread.daemon:
            thread.join()
    sys.stdin, sys.stdout, sys.stderr = opened
    for one, handler in handlers:
        signal.signal(one, handler)
    nothing = os.open(os.devnull, os.O_RDWR)
    for number in range(3):
        os.dup2(nothing, number)
    os.close(nothing)
    return code


def _load() -> None:
    """Loads what commands load when they need it, so that not every one of them has to: python-can takes longest."""
    import canalyze
    from canalyze.sources.bridge import library

    with suppress(ImportError):  # it may have been hidden
        library()
    for room in ("check", "dictionary", "expectations", "reports", "running", "sinks", "sources"):
        for module in iter_modules([str(Path(canalyze.__path__[0]) / room)]):
            with suppress(ImportError):
                import_module(f"canalyze.{room}.{module.name}")


def _run(main: object) -> object:
    try:
        return main()  # type: ignore[operator]
    except SystemExit as ended:
        return ended.code
    except BaseException:
        traceback.print_exc()
        return 1


def _end(code: object) -> NoReturn:
    """Ends as the interpreter does."""
    threading._shutdown()  # type: ignore[attr-defined]
    os._exit(_finished(code))


def _finished(code: object) -> int:
    """The exit code of what has returned or raised this, once all is written."""
    if code is not None and not isinstance(code, int):
        print(code, file=sys.stderr)
        code = 1
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            code = code or 120
    return (code or 0) & 0xFF


if __name__ == "__main__":
    _serve(socket.socket(fileno=int(sys.argv[1])), kept=sys.argv[2] == "kept")
