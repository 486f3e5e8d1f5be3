"""`canalyze view` and `canalyze sniff --rerun`: viewers, files, who listens where, and ends of all kinds.

What stands on a timeline is tested by `test_timeline*.py`. What it must not do: need a display, but for the one test
that has a virtual one.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import signal
import subprocess
import sys
import termios
import threading
import time
import urllib.request
from array import array
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import parse_qs, urlparse

import pytest
from captures import SAMPLES
from conftest import Runner, command, environment
from recordings import recording, verified
from test_sniff import SCRIPT, without_end
from test_sniff import process as sniffing
from viewers import DEADLINE_S, free_pair, listeners, on_linux, sent_to, soon, viewer_of

from canalyze.cli import main
from canalyze.timeline.recording import Feed

CAPTURE = SAMPLES / "network" / "sync-and-pdos.log"
EDS = f"5={SAMPLES.parent / 'eds' / 'drive.eds'}"
LOCAL = "127.0.0.1"


@contextmanager
def viewing(*args: str, cwd: Path, **more: str) -> Iterator[subprocess.Popen[bytes]]:
    """A command that lasts; whatever comes, it does not outlive the test."""
    (cwd / "tmp").mkdir(exist_ok=True)
    given = environment(TMPDIR=str(cwd / "tmp"), **more)
    line = command("--lang", "en", *args)
    with subprocess.Popen(line, cwd=cwd, env=given, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        try:
            yield running
        finally:
            running.kill()


def told(running: subprocess.Popen[bytes], wanted: str) -> str:
    """The first line on standard error with this in it."""
    assert running.stderr is not None
    for line in running.stderr:
        if wanted.encode() in line:
            return line.decode().strip()
    pytest.fail(f"nothing was said of {wanted}")


def page_of(line: str) -> tuple[str, str]:
    """The address of the page, and where the viewer takes what it shows."""
    (url,) = re.findall(r"http://\S+", line)
    return url, parse_qs(urlparse(url).query)["url"][0]


def end(running: subprocess.Popen[bytes], by: signal.Signals = signal.SIGINT) -> int:
    """Ends it as a user does; gives the exit code."""
    running.send_signal(by)
    return running.wait(DEADLINE_S)


def here(capfd: pytest.CaptureFixture[str], *args: str) -> tuple[int, str]:
    """Runs a command line in this process, which takes a hundredth of the time; gives its code and what it said."""
    code = main(args)
    return code, capfd.readouterr().err


def rows(path: Path) -> int:
    """Annotated frames in a recording."""
    return len(recording(path).rows("/frames", "TextLog:text"))


# Files.


def test_a_file(canalyze: Runner, tmp_path: Path) -> None:
    done = canalyze("view", "--save", "out.rrd", "--eds", EDS, str(CAPTURE))
    assert (done.code, done.out) == (0, "")
    assert [path.name for path in tmp_path.iterdir()] == ["out.rrd"]
    verified(tmp_path / "out.rrd")
    assert rows(tmp_path / "out.rrd") == len(CAPTURE.read_text().splitlines())
    assert recording(tmp_path / "out.rrd").application.startswith("canalyze-")


def test_a_pipe_becomes_a_file(canalyze: Runner, tmp_path: Path) -> None:
    done = canalyze("view", "--save", "out.rrd", stdin=CAPTURE.read_bytes())
    assert done.code == 0
    assert rows(tmp_path / "out.rrd") > 0


def unread(pipe: BinaryIO) -> int:
    """Bytes in a pipe that its reader has not taken."""
    waiting = array("i", [0])
    fcntl.ioctl(pipe, termios.FIONREAD, waiting)
    return waiting[0]


def test_an_interrupted_one_stays_a_part(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with viewing("view", "--save", "out.rrd", "pipe", cwd=tmp_path) as running:
        with (tmp_path / "pipe").open("wb") as pipe:
            pipe.write(CAPTURE.read_bytes())
            pipe.flush()
            soon(lambda: list(tmp_path.glob("out.rrd.*.part")), "the file beside")
            soon(lambda: unread(pipe) == 0, "what it has read")
            time.sleep(1)  # what is read has yet to be taken, and nothing tells
            assert end(running) == 130
        assert (
            running.stderr is not None and b"interrupted; what was read so far is in out.rrd." in running.stderr.read()
        )
    (part,) = tmp_path.glob("out.rrd.*.part")
    assert sorted(path.name for path in tmp_path.iterdir()) == [part.name, "pipe", "tmp"]


# Words.


def test_a_disk_that_is_full(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rerun would wait without end for what it cannot write first."""
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=100_000))
    monkeypatch.chdir(tmp_path)
    said = "canalyze: out.rrd: cannot write: no space left on device\n"
    assert here(capfd, "view", "--lang", "en", "--save", "out.rrd", str(CAPTURE)) == (2, said)
    assert not list(tmp_path.iterdir())


def test_no_other_command_loads_rerun() -> None:
    """Nor this one before it needs it: it takes longer than all the rest."""
    loaded = "import sys; from canalyze.cli import COMMANDS, build; group = build('en')\n"
    loaded += "[group.get_command(None, name) for name in COMMANDS]\n"
    loaded += "print({'rerun', 'rerun_bindings', 'numpy', 'pyarrow'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", loaded], capture_output=True, check=True)
    assert done.stdout == b"set()\n"


def test_a_display_that_is_not_there(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "tmp").mkdir()
    env = {"DISPLAY": ":987", "WAYLAND_DISPLAY": "", "CANALYZE_LANG": "en", "TMPDIR": str(tmp_path / "tmp")}
    done = canalyze("view", str(CAPTURE), env=env)
    assert (done.code, done.out) == (2, "")
    assert len(done.complaints) == 1 and done.err.startswith("canalyze: the viewer exited (")
    assert not list((tmp_path / "tmp").iterdir())


# Viewers.


@on_linux
def test_a_page_is_for_this_machine_only(tmp_path: Path, canalyze: Runner) -> None:
    """It has what is on the bus, on the ports that were asked for; by its environment it sends nothing."""
    page = free_pair()
    args = ("view", "--web", "--port", str(page), "--eds", EDS, str(CAPTURE))
    with viewing(*args, cwd=tmp_path, NO_PROXY="*", FORCE_RERUN_ANALYTICS="1") as running:
        url, connect = page_of(told(running, "open in a browser"))
        with urllib.request.urlopen(url) as answer:
            assert answer.status == 200
        assert listeners(running.pid) == {(LOCAL, page), (LOCAL, page + 1)}
        assert (urlparse(url).port, urlparse(connect).port) == (page, page + 1)
        folders = list((tmp_path / "tmp").iterdir())
        assert {folder.stat().st_mode & 0o777 for folder in folders} == {0o700}
        done = canalyze("view", "--web", "--port", str(page + 1), "--lang", "en", "looked-at-later.log")
        said = f"canalyze: the viewer cannot listen on 127.0.0.1, port {page + 1}: "
        assert done.code == 2 and done.err.startswith(said)
        assert len(done.complaints) == 1
        sent_to(connect, tmp_path / "seen.rrd", lambda path: rows(path) == len(CAPTURE.read_text().splitlines()))
        viewer = viewer_of(running.pid)
        given = Path(f"/proc/{viewer}/environ").read_bytes().decode().split("\0")
        assert {f"TMPDIR={folder}" for folder in folders} & set(given)  # what it writes there goes, too
        assert {"CI=1", "ALL_PROXY=http://127.0.0.1:9", "https_proxy=http://127.0.0.1:9"} <= set(given)
        assert not [one for one in given if one.startswith(("NO_PROXY", "FORCE_RERUN"))]
        assert end(running) == 0
        assert not Path(f"/proc/{viewer}").exists()
    assert not list((tmp_path / "tmp").iterdir())


@on_linux
@pytest.mark.parametrize("bind", ["0.0.0.0", "127.0.0.2"])
def test_another_address_only_where_it_was_asked_for(tmp_path: Path, bind: str) -> None:
    """What was written before is shown as it is."""
    assert main(["view", "--save", str(tmp_path / "out.rrd"), str(CAPTURE)]) == 0
    with viewing("view", "--web", "--bind", bind, "out.rrd", cwd=tmp_path) as running:
        told(running, "open in a browser")
        assert {address for address, _ in listeners(running.pid)} == {bind}
        said = told(running, "the viewer listens on" if bind == "0.0.0.0" else "Ctrl-C ends it")
        assert ("without a password" in said) == (bind == "0.0.0.0")
        viewer = soon(lambda: viewer_of(running.pid), "a viewer")
        if bind == "0.0.0.0":
            os.kill(viewer, signal.SIGKILL)
            assert running.wait(DEADLINE_S) == 2
            told(running, "the viewer exited")
        else:
            assert end(running, signal.SIGTERM) == 143
        assert not _alive(viewer)


@on_linux
def test_no_viewer_outlives_a_command_that_is_killed(tmp_path: Path) -> None:
    assert main(["view", "--save", str(tmp_path / "out.rrd"), str(CAPTURE)]) == 0
    with viewing("view", "--web", "out.rrd", cwd=tmp_path) as running:
        told(running, "open in a browser")
        viewer = viewer_of(running.pid)
        running.kill()
        running.wait()
        soon(lambda: not _alive(viewer), "the viewer goes too")


@on_linux
@pytest.mark.parametrize("name", ["view", "sniff"])
def test_ctrl_c_while_rerun_is_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Of `sniff` it is the usual end, as ever; `view` does not read what nobody wants any more."""
    monkeypatch.setenv("PYTHONPATH", str(slow_to_load(tmp_path)), prepend=os.pathsep)
    if name == "view":
        os.mkfifo(tmp_path / "pipe")  # reading it would wait
        with viewing("view", "--web", "pipe", cwd=tmp_path) as running:
            soon(lambda: (tmp_path / "loading").exists(), "it loads")
            running.send_signal(signal.SIGINT)
            (tmp_path / "signalled").touch()
            assert running.wait(DEADLINE_S) == 130
        assert not list((tmp_path / "tmp").iterdir())
        return
    args = ("bus", "--rerun", "--web", "--save", "out.rrd", "--record", "bus.log")
    began = time.monotonic()
    with sniffing("steady", *args, cwd=tmp_path) as running:
        recorded = tmp_path / "bus.log"
        soon(lambda: (tmp_path / "loading").exists() and recorded.read_bytes().count(b"\n") > 20, "frames as it loads")
        running.send_signal(signal.SIGINT)
        (tmp_path / "signalled").touch()
        out, err = running.communicate(timeout=DEADLINE_S)
    assert running.returncode == 0
    said = err.decode().splitlines()
    listened = re.match(r"canalyze: bus: \d+ frames in (\d+\.\d) s", said[0])
    assert listened and float(listened[1]) < float((tmp_path / "seen").read_text()) - began + 0.1
    assert len(said) == 3 and said[1].startswith("canalyze: recorded bus.log: ")
    assert said[2].startswith("canalyze: out.rrd: timeline, ")
    assert rows(tmp_path / "out.rrd") == len(without_end(out.decode())) > 20


def slow_to_load(folder: Path) -> Path:
    """A `rerun` that says when it begins to be loaded, takes a second more after a signal, and is the real one."""
    slow = folder / "slow"
    slow.mkdir()
    (slow / "rerun.py").write_text(
        "import importlib, pathlib, sys, time\n"
        "pathlib.Path('loading').touch()\n"
        "while not pathlib.Path('signalled').exists():\n"
        "    time.sleep(0.01)\n"
        "pathlib.Path('seen').write_text(str(time.monotonic()))\n"
        "time.sleep(1)\n"
        f"sys.path.remove({str(slow)!r})\n"
        "del sys.modules['rerun']\n"
        "importlib.import_module('rerun')\n"
    )
    return slow


@on_linux
@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="no xvfb-run for a virtual display")
@pytest.mark.parametrize("name", ["view", "sniff"])
def test_a_window_is_for_this_machine_only(tmp_path: Path, name: str) -> None:
    from rerun.experimental import ViewerClient

    live = [sys.executable, str(SCRIPT), "steady", "sniff", "-i", "virtual", "bus", "--rerun", "--duration", "60"]
    inner = " ".join(command("view", str(CAPTURE)) if name == "view" else live)
    given = environment(TMPDIR=str(tmp_path))
    line = ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24", "sh", "-c", f"exec {inner} >shown"]
    with subprocess.Popen(line, cwd=tmp_path, env=given, stderr=subprocess.PIPE, start_new_session=True) as running:
        try:
            viewer = soon(lambda: viewer_of(running.pid) or running.poll() is not None, "a viewer")
            if running.poll() is not None:  # no Vulkan here
                assert running.stderr is not None
                pytest.skip(running.stderr.read().decode())
            (found,) = soon(lambda: listeners(viewer), "it listens")
            assert found[0] == LOCAL
            client = soon(lambda: _client(ViewerClient, found[1]), "it answers")
            soon(lambda: client.get_state().recordings, "it shows the capture")
            assert {address for address, _ in listeners(viewer)} == {LOCAL}
        finally:
            os.killpg(running.pid, signal.SIGKILL)


def _client(kind: Any, port: int) -> Any:
    try:
        return kind.connect(f"rerun+http://{LOCAL}:{port}/proxy")
    except Exception:
        return None


def _alive(pid: int | None) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


# Live.


@on_linux
def test_a_live_bus_in_a_viewer_and_a_file(tmp_path: Path) -> None:
    """Both have every frame; nobody else can look; the viewer stays until the user has seen enough."""
    args = ("bus", "--rerun", "--web", "--save", "out.rrd", "--record", "bus.log", "--duration", "3")
    with sniffing("stopped", *args, cwd=tmp_path) as running:
        try:
            _, connect = page_of(told(running, "open in a browser"))
            assert {address for address, _ in listeners(running.pid)} == {LOCAL}
            assert "out.rrd: timeline, " in told(running, "timeline")
            told(running, "stays")
            frames = len((tmp_path / "bus.log").read_text().splitlines())
            assert rows(tmp_path / "out.rrd") == frames
            verified(tmp_path / "out.rrd")
            (summary,) = recording(tmp_path / "out.rrd").static("/summary", "TextDocument:text")
            assert summary.startswith("# Summary\n\n- bus: ") and f" {frames} frames in " in summary
            sent_to(connect, tmp_path / "seen.rrd", lambda path: rows(path) == frames)
            assert {address for address, _ in listeners(running.pid)} == {LOCAL}
            assert running.poll() is None
            viewer = viewer_of(running.pid)
            assert end(running) == 0
            assert not _alive(viewer)
        finally:
            running.kill()


@on_linux
def test_a_file_of_a_live_bus_needs_no_listener(tmp_path: Path) -> None:
    args = ("bus", "--save", "out.rrd", "--record", "bus.log")
    with sniffing("steady", *args, cwd=tmp_path) as running:
        try:
            soon(lambda: (tmp_path / "out.rrd").exists() and (tmp_path / "out.rrd").stat().st_size, "rows in the file")
            found = set()
            until = time.monotonic() + 1
            while time.monotonic() < until:
                found |= listeners(running.pid)
                time.sleep(0.05)
            assert end(running) == 0
            _, err = running.communicate()
        finally:
            running.kill()
    assert found == set()
    assert "canalyze: out.rrd: timeline, " in err.decode()
    verified(tmp_path / "out.rrd")
    assert rows(tmp_path / "out.rrd") == len((tmp_path / "bus.log").read_text().splitlines())


def test_a_file_of_a_silent_bus(tmp_path: Path) -> None:
    with sniffing("silence", "bus", "--save", "out.rrd", "--duration", "1", cwd=tmp_path) as running:
        _, err = running.communicate(timeout=60)
    assert running.returncode == 0 and b"Traceback" not in err


def test_a_live_file_that_exists_stays(tmp_path: Path) -> None:
    (tmp_path / "out.rrd").write_text("mine")
    with sniffing("session", "bus", "--save", "out.rrd", cwd=tmp_path) as running:
        _, err = running.communicate(timeout=60)
    assert (running.returncode, err.decode()) == (2, "canalyze: out.rrd: file exists; use --force to overwrite\n")
    with sniffing("stopped", "bus", "--save", "out.rrd", "--force", "--duration", "1", cwd=tmp_path) as running:
        running.communicate(timeout=60)
    assert running.returncode == 0
    verified(tmp_path / "out.rrd")


@on_linux
@pytest.mark.parametrize("what", [signal.SIGKILL, signal.SIGSTOP])
def test_whatever_the_viewer_does_the_listening_goes_on(tmp_path: Path, what: signal.Signals) -> None:
    shown: list[str] = []
    with sniffing("steady", "bus", "--rerun", "--web", "--save", "out.rrd", cwd=tmp_path) as running:
        try:
            reading = threading.Thread(target=lambda: shown.extend(line.decode() for line in running.stdout or ()))
            reading.start()
            told(running, "open in a browser")
            viewer = soon(lambda: viewer_of(running.pid), "a viewer")
            os.kill(viewer, what)
            before = len(shown)
            if what == signal.SIGKILL:
                assert "listening continues" in told(running, "the viewer exited")
            soon(lambda: len(shown) > before + 200, "frames after that")
            running.send_signal(signal.SIGINT)
            if what == signal.SIGSTOP:
                told(running, "stays")
                running.send_signal(signal.SIGINT)
            assert running.wait(DEADLINE_S) == 0
            reading.join(DEADLINE_S)
            assert not _alive(viewer)
        finally:
            running.kill()
    numbers = [int(found[::-1].hex(), 16) for found in map(_payload, without_end("".join(shown))) if found]
    assert numbers == list(range(len(numbers))) and len(numbers) > 200
    assert rows(tmp_path / "out.rrd") == len(numbers)


def _payload(line: str) -> bytes | None:
    found = re.search(r"185 +\[4\] +((?:[0-9A-F]{2} ){3}[0-9A-F]{2})", line)
    return bytes.fromhex(found[1]) if found else None


# The feed of a live timeline.


class _Batch:
    def __init__(self, num_rows: int) -> None:
        self.num_rows = num_rows


class _Slow:
    """A timeline that takes nothing until it may."""

    def __init__(self, error: Exception | None = None) -> None:
        self.may = threading.Event()
        self.rows = 0
        self.complete = False
        self._error = error

    def take(self, batches: Sequence[tuple[str, Any]]) -> None:
        self.may.wait(10)
        if self._error:
            raise self._error
        self.rows += sum(batch.num_rows for _, batch in batches)

    def finish(self, summary: bytes = b"", lines: Sequence[str] = ()) -> None:
        self.complete = True


def test_a_slow_timeline_is_not_waited_for_and_what_it_misses_is_counted() -> None:
    slow = _Slow()
    feed = Feed(slow, most=100)
    began = time.monotonic()
    for _ in range(30):
        feed.give([("log", _Batch(10))])  # type: ignore[list-item]
    assert time.monotonic() - began < 5
    assert feed.left_out == 200 and not feed.ended(0.01)
    slow.may.set()
    feed.end()
    assert feed.ended(10) and slow.complete
    assert slow.rows + feed.left_out == 300


def test_a_timeline_that_fails_is_not_given_more() -> None:
    broken = _Slow(OSError("no room"))
    broken.may.set()
    feed = Feed(broken)
    feed.give([("log", _Batch(10))])  # type: ignore[list-item]
    assert feed.ended(10)
    assert str(feed.failure) == "no room" and not broken.complete
    feed.give([("log", _Batch(10))])  # type: ignore[list-item]
    feed.end()
