"""Captures and results in an object store: a server of S3 on this machine, which is busy or cuts bodies when asked to.

Nothing that came in part is taken for whole, and a store that is busy for a while costs nothing.
"""

from __future__ import annotations

import json
import logging
import os
import threading
import urllib.request
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES
from conftest import Runner
from test_fleet import finish, work

from canalyze.errors import ConfigError, SourceError
from canalyze.fleet import run as runs
from canalyze.fleet import stores, task
from canalyze.fleet.stores import captures, fetched, place
from canalyze.fleet.task import Piece, do
from canalyze.running.pool import Ended, Failure

pytest.importorskip("obstore", reason="canalyze[fleet] is not installed")
pytest.importorskip("moto", reason="moto is not installed")
pytestmark = pytest.mark.filterwarnings("default")  # other programs' warnings are theirs

CLEAN = (SAMPLES / "rules/SDO001.clean.log").read_bytes()
TOGGLE = (SAMPLES / "rules/SDO001.log").read_bytes()


class Server:
    """A server of S3 that can be made to misbehave."""

    def __init__(self) -> None:  # noqa: D107
        from moto.server import DomainDispatcherApplication, create_backend_app
        from werkzeug.serving import make_server  # of moto

        logging.getLogger("werkzeug").setLevel(logging.ERROR)
        self._app = DomainDispatcherApplication(create_backend_app)
        self._server = make_server("127.0.0.1", 0, self._answer, threaded=True)
        self.url = f"http://127.0.0.1:{self._server.server_port}"
        self.busy = 0
        """How many requests are still refused."""
        self.shorten: Callable[[str, bytes], bytes] = lambda path, body: body
        self.gets: list[str] = []
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def _answer(self, environ: dict[str, Any], start: Callable[..., Any]) -> Iterable[bytes]:
        if self.busy:
            self.busy -= 1
            start("503 Slow Down", [("Content-Type", "application/xml")])
            return [b"<Error><Code>SlowDown</Code></Error>"]
        if environ["PATH_INFO"] == "/plain/some.log":
            stamp = ("Last-Modified", "Wed, 21 Oct 2015 07:28:00 GMT")
            start("200 OK", [("ETag", '"tag"'), ("Content-Length", str(len(CLEAN))), stamp])
            return [CLEAN]
        if environ["REQUEST_METHOD"] != "GET" or environ["QUERY_STRING"]:
            return self._app(environ, start)  # type: ignore[no-any-return]  # moto has no types
        self.gets.append(environ["PATH_INFO"])
        head: list[Any] = []
        body = b"".join(self._app(environ, lambda *given: head.extend(given)))
        short = self.shorten(environ["PATH_INFO"], body)
        if short != body:
            head[1] = [(name, value) for name, value in head[1] if name.lower() != "content-length"]
            head[1].append(("Content-Length", str(len(short))))
        start(*head)
        return [short]

    def ask(self, method: str, path: str) -> None:
        urllib.request.urlopen(urllib.request.Request(f"{self.url}/{path}", b"", method=method)).close()

    def put(self, name: str, data: bytes) -> None:
        place("s3://caps").put(name, data)

    def close(self) -> None:
        self._server.shutdown()


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    """Give a server with a bucket `caps`, in which night/ holds three captures and something else."""
    server = Server()
    for name, value in {
        "AWS_ACCESS_KEY_ID": "a",
        "AWS_SECRET_ACCESS_KEY": "b",
        "AWS_DEFAULT_REGION": "us-east-1",
        "AWS_ENDPOINT_URL": server.url,
        "AWS_ALLOW_HTTP": "true",
    }.items():
        monkeypatch.setenv(name, value)
    quick = {"init_backoff": timedelta(milliseconds=1), "max_backoff": timedelta(milliseconds=5), "base": 2}
    monkeypatch.setattr(stores, "_RETRIES", {**stores._RETRIES, "backoff": quick, "max_retries": 4})
    stores.opened.cache_clear()
    server.ask("POST", "moto-api/reset")
    server.ask("PUT", "caps")
    files = {"night/clean.log": CLEAN, "night/deep er/toggle.log": TOGGLE, "night/b.log": CLEAN, "night/x.md": b"no"}
    for name, data in files.items():
        server.put(name, data)
    yield server
    server.close()


class Here:
    """An executor that does the work in this process."""

    width = 1

    def __init__(self, one: Any) -> None:  # noqa: D107
        self._work = one
        self._waiting: list[Piece] = []

    def submit(self, piece: Piece) -> None:
        self._waiting.append(piece)

    def completed(self) -> Iterator[Ended]:
        while self._waiting:
            piece = self._waiting.pop(0)
            try:
                yield Ended(piece, do(self._work, piece, lambda word: None))
            except SourceError as error:
                yield Ended(piece, failure=Failure("raised", error))

    def close(self) -> None: ...


def listing(*sources: str, out: str = "out") -> list[str]:
    return sorted(one.name for one in captures(sources, out, beside=False))


def test_sources_are_folders_patterns_and_single_objects(server: Server) -> None:
    night = [f"s3://caps/night/{name}" for name in ("b.log", "clean.log", "deep er/toggle.log")]
    assert listing("s3://caps/night/") == listing("s3://caps/night") == listing("s3://caps") == night
    assert listing("s3://caps/night/*.log") == night[:2]
    assert listing("s3://caps/night/**/*.log") == night
    assert listing("s3://caps/night/b.log", "s3://caps/night") == night
    assert listing("s3://caps", out="s3://caps/night/deep er") == night[:2]
    one = {one.name: one.id for one in captures(["s3://caps/night/b.log", "s3://caps"], "out", beside=False)}
    assert one == {one.name: one.id for one in captures(["s3://caps/"], "out", beside=False)}
    with pytest.raises(SourceError, match="no captures"):
        listing("s3://caps/day")


def test_an_address_of_the_web_is_one_capture(server: Server, tmp_path: Path) -> None:
    (one,) = captures([f"{server.url}/plain/some.log"], "out", beside=False)
    assert (one.name, one.stamp) == (f"{server.url}/plain/some.log", f'"tag" {len(CLEAN)}')
    with fetched(one, str(tmp_path)) as (path, _):
        assert Path(path).read_bytes() == CLEAN
    assert list(tmp_path.iterdir()) == []


def test_from_store_to_store_through_the_command(server: Server, canalyze: Runner, tmp_path: Path) -> None:
    env = {name: os.environ[name] for name in os.environ if name.startswith("AWS_")}
    line = ["fleet", "check", "s3://caps/night/", "-o", "s3://caps/out", "--lang", "en"]
    server.busy = 3
    done = canalyze(*line, env=env)
    assert (done.code, done.err) == (1, ""), done
    assert done.lines[-1].startswith("3 captures done, 0 of them before; reports in s3://caps/out: check.txt")
    report = place("s3://caps/out").get("check.txt")
    assert report is not None and b"s3://caps/night/deep er/toggle.log, 8 frames: 1 error" in report
    assert canalyze(*line, env=env).lines[-1].startswith("3 captures done, 3 of them before")
    server.put("night/b.log", TOGGLE)
    assert canalyze(*line, env=env).lines[-1].startswith("3 captures done, 2 of them before")


def test_a_busy_store_costs_nothing(server: Server, tmp_path: Path) -> None:
    one = work(tmp_path / "out", scratch=str(tmp_path))
    every = captures(["s3://caps/night"], one.out, beside=False)
    server.busy = 3
    found = finish(Here(one), one, every)
    assert [(done.failed, done.attempts) for done in found] == [(None, 1)] * 3
    assert server.busy == 0
    assert [path.name for path in tmp_path.iterdir()] == ["out"]  # what was fetched is gone


def test_a_store_that_stays_busy_is_not_the_captures_fault(server: Server, tmp_path: Path) -> None:
    one = work(tmp_path / "out", scratch=str(tmp_path))
    every = captures(["s3://caps/night/b.log"], one.out, beside=False)
    server.busy = 1000
    (failed,) = finish(Here(one), one, every)
    assert (failed.failed, failed.attempts) == ("fetch", 3)
    assert failed.error is not None and failed.error.startswith("s3://caps/night/b.log: ") and "503" in failed.error
    server.busy = 0
    assert runs.standing(one, every, retry=False) == {}  # the next run tries it again by itself
    (done,) = finish(Here(one), one, every)
    assert (done.failed, done.frames) == (None, 8)


@pytest.mark.parametrize("times", [1, 2, 100])
def test_a_body_that_was_cut_is_never_taken_for_whole(server: Server, tmp_path: Path, times: int) -> None:
    """Cut at the end of a line, with a length that fits: only what the listing said tells it."""
    left = times

    def shorten(path: str, body: bytes) -> bytes:
        nonlocal left
        if "toggle" in path and left and body.count(b"\n") > 1:
            left -= 1
            return b"".join(body.splitlines(keepends=True)[:-1])
        return body

    server.shorten = shorten
    one = work(tmp_path / "out", scratch=str(tmp_path))
    (done,) = finish(Here(one), one, captures(["s3://caps/night/deep er/"], one.out, beside=False))
    if times < 3:
        assert (done.failed, done.frames, done.attempts) == (None, 8, times + 1)
    else:
        assert (done.failed, done.frames, done.attempts) == ("fetch", 0, 3)
        assert done.error is not None and "bytes came" in done.error


def test_an_object_that_was_written_meanwhile_is_known_as_what_it_was(server: Server, tmp_path: Path) -> None:
    one = work(tmp_path / "out")
    every = captures(["s3://caps/night/b.log"], one.out, beside=False)
    server.put("night/b.log", TOGGLE + TOGGLE)
    (done,) = finish(Here(one), one, every)
    assert (done.failed, done.frames) == (None, 16)
    now = captures(["s3://caps/night/b.log"], one.out, beside=False)
    assert len(runs.standing(one, now, retry=False)) == 1


def test_a_task_that_an_engine_repeats_reads_nothing_again(server: Server, tmp_path: Path) -> None:
    one = work("s3://caps/out", scratch=str(tmp_path))
    (capture,) = captures(["s3://caps/night/b.log"], one.out, beside=False)
    first = do(one, Piece(capture), lambda word: None)
    server.gets.clear()
    again = do(one, Piece(capture, 2), lambda word: None)
    assert again.result == json.loads(json.dumps(first.result))
    assert replace(again, result=None) == replace(first, result=None)
    assert server.gets == [f"/caps/out/_manifest/check/{capture.id}.json"]
    assert task.read_all(place(one.out), "check", [capture.id]) == {capture.id: again}


def test_results_are_whole_objects(tmp_path: Path, server: Server) -> None:
    for name in ("s3://caps/out", str(tmp_path / "out")):
        to = place(name)
        assert to.get("a/b.json") is None and to.names("a") == []
        to.put("a/b.json", b"one")
        to.put("a/b.json", b"two" * 3_000_000)
        assert to.get("a/b.json") == b"two" * 3_000_000 and to.names("a") == ["b.json"]
        with to.beside("1", str(tmp_path)) as folder:
            (folder / "c").write_bytes(b"three" * 3_000_000)  # in several parts
            to.bring(folder / "c", "a/c")
        assert to.get("a/c") == b"three" * 3_000_000 and not folder.exists()
        to.remove("a/b.json")
        to.remove("a/b.json")
        assert to.names("a") == ["c"]


def test_tables_come_into_a_store(server: Server, canalyze: Runner) -> None:
    pytest.importorskip("pyarrow")
    env = {name: os.environ[name] for name in os.environ if name.startswith("AWS_")}
    done = canalyze("fleet", "export", "s3://caps/night/", "-o", "s3://caps/lake", "--table", "frames", env=env)
    assert (done.code, done.err) == (0, ""), done
    found = [path for path, *_ in stores.listed("s3://caps/lake", "frames")]
    assert len(found) == 3 and all(path.endswith(".parquet") for path in found)


def test_what_is_missing_is_said(monkeypatch: pytest.MonkeyPatch, server: Server) -> None:
    import sys

    with pytest.raises(SourceError, match="s3://none/: "):
        listing("s3://none/")
    with pytest.raises(SourceError, match="s4://x"):
        listing("s4://x/y.log")
    monkeypatch.setitem(sys.modules, "obstore.store", None)
    stores.opened.cache_clear()
    with pytest.raises(ConfigError, match=r"canalyze\[fleet\]"):
        listing("s3://caps/")
