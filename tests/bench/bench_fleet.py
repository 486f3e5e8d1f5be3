"""What a fleet costs beside the work itself, and what a second worker brings.

    python tests/bench/bench_fleet.py [--captures 200] [--frames 100000] [--on dask]
    python tests/bench/bench_fleet.py --grid [--store] [--on dask]

The second one shows how it grows: 1, 10, 100 and 1,000 captures by one worker and by two, from a folder or from a
server of S3 on this machine. In the first one captures of ten lines show what a capture costs beside its work: the same
work is done in this process first. Large ones show how two workers do: their times are of the machine as it is, so read
the load beside them. It must not be a test.
"""

from __future__ import annotations

import argparse
import os
import resource
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import bench_captures

from canalyze.check.examination import Job
from canalyze.check.policy import Policy
from canalyze.configuration.network import Known
from canalyze.fleet import run as runs
from canalyze.fleet.stores import Capture, captures, place
from canalyze.fleet.task import Piece, Work, do
from canalyze.running.pool import ENGINES, Beside, Pool, at_once


def made(folder: Path, count: int, frames: int) -> list[Capture]:
    """Captures with the same content, each a file of its own by name."""
    folder.mkdir()
    source = folder / "0.log"
    with source.open("w") as file:
        file.writelines(bench_captures.capture_lines(frames))
    for number in range(1, count):
        os.link(source, folder / f"{number}.log")
    return captures([str(folder)], f"{folder}-out", beside=False)


def work(out: Path | str) -> Work:
    """What `fleet check` does without options."""
    return Work("check", Job("en", {}, Known(), {}, beside=False), Policy(), {}, str(out))


def here(one: Work, every: list[Capture]) -> float:
    """Seconds of the work in this process, one capture after the other."""
    began = time.perf_counter()
    for capture in every:
        do(one, Piece(capture), lambda word: None)
    return time.perf_counter() - began


def elsewhere(one: Work, every: list[Capture], width: int, on: str | None) -> tuple[float, float]:
    """Seconds of all of it by workers, and of all after the first result, when they have started."""
    executor: Any
    if on is None:
        executor = Pool(partial(do, one), width)
    else:
        executor = ENGINES[on](Beside(partial(do, one)), None, width, at_once)
    began = first = time.perf_counter()
    for count, _ in enumerate(runs.run(executor, one, every)):
        first = first if count else time.perf_counter()
    ended = time.perf_counter()
    executor.close()
    return ended - began, ended - first


@contextmanager
def bucket() -> Iterator[str]:
    """Give the URL of a bucket of an S3 server in a process of its own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    line = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)]
    server = subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    url = f"http://127.0.0.1:{port}"
    os.environ |= {
        "AWS_ACCESS_KEY_ID": "a",
        "AWS_SECRET_ACCESS_KEY": "b",
        "AWS_DEFAULT_REGION": "us-east-1",
        "AWS_ENDPOINT_URL": url,
        "AWS_ALLOW_HTTP": "true",
    }
    try:
        while server.poll() is None:
            with suppress(OSError):
                urllib.request.urlopen(urllib.request.Request(f"{url}/caps", b"", method="PUT")).close()
                break
            time.sleep(0.1)
        yield "s3://caps"
    finally:
        server.kill()
        server.wait()


def grid(folder: Path, frames: int, on: str | None, store: str | None) -> None:
    """Print a line for each number of captures and of workers."""
    print(f"{'captures':>8} {'workers':>7} {'s':>7} {'M frames/s':>10} {'ms/capture':>10} {'MB/process':>10}")
    for count in (1, 10, 100, 1000):
        every = made(folder / str(count), count, frames)
        if store is not None:
            data = Path(every[0].path).read_bytes()
            for capture in every:
                place(store).put(f"{count}/{Path(capture.path).name}", data)
            every = captures([f"{store}/{count}/"], f"{store}/out", beside=False)
            assert len(every) == count
        for width in (1, 2):
            out = f"{store or folder}/out-{count}-{width}"
            seconds, _ = elsewhere(work(out), every, width, on)
            rate, each = count * frames / seconds / 1e6, seconds / count * 1000
            largest = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss >> 10
            print(f"{count:8} {width:7} {seconds:7.1f} {rate:10.2f} {each:10.1f} {largest:10}", flush=True)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--captures", type=int, default=200)
    parser.add_argument("--frames", type=int, default=100_000)
    parser.add_argument("--on", choices=("dask", "ray"))
    parser.add_argument("--grid", action="store_true", help="1, 10, 100 and 1,000 captures by one and two workers")
    parser.add_argument("--store", action="store_true", help="of the grid: from an S3 server on this machine (moto)")
    given = parser.parse_args()
    if given.grid:
        with tempfile.TemporaryDirectory(prefix="canalyze-bench-") as name, ExitStack() as stack:
            store = stack.enter_context(bucket()) if given.store else None
            grid(Path(name), given.frames, given.on, store)
        return
    count = given.captures
    with tempfile.TemporaryDirectory(prefix="canalyze-bench-") as name:
        folder = Path(name)
        small = made(folder / "small", count, 10)
        alone = here(work(folder / "a"), small)
        whole, started = elsewhere(work(folder / "b"), small, 1, given.on)
        print(f"{count} captures of ten lines, load {os.getloadavg()[0]:.1f}")
        print(f"  in this process {alone / count * 1000:.2f} ms a capture")
        print(f"  by one worker {whole / count * 1000:.2f} ms, without its start {started / (count - 1) * 1000:.2f} ms")
        large = made(folder / "large", count, given.frames)
        times = {}
        for width in (1, 2):
            times[width], _ = elsewhere(work(folder / f"large-{width}"), large, width, given.on)
            rate = count * given.frames / times[width] / 1e6
            print(f"{width} workers, {count} of {given.frames} frames: {times[width]:.1f} s, {rate:.2f} M frames/s")
        print(f"ratio {times[1] / times[2]:.2f}, load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
