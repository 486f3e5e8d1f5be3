"""Pieces of work done side by side: in supervised processes of this machine, or on clusters of Dask and Ray.

A process does one piece at a time. One that dies, or takes too long or too much memory, costs the piece that it was at
and nothing else: another one takes its place. On a cluster, local or remote, the program must be installed on the
workers. Each worker does a piece in a child process, because these engines have no hard limits of their own, and a
piece that crashes its process affects neither the worker nor its state. Must not: know what the work is, try a piece
again, or print.
"""

import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, Protocol

from canalyze import __version__
from canalyze.errors import CanalyzeError, ConfigError, as_error

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

PATIENCE: Final = 5.0
"""Seconds that a process is given to clear up when the end is wished."""
_NEVER: Final = float("inf")

Tell = Callable[[Any], None]
"""The way a piece of work reports its progress."""
Work = Callable[[Any, Tell], Any]
"""The work on a piece; a function of a module, so that another process finds it."""

During = Callable[[Callable[[], Any]], Any]
"""Does what waits; gives None where the end was wished instead."""


def at_once(wait: Callable[[], Any]) -> Any:
    """Calls it."""
    return wait()


class Failure(NamedTuple):
    """Why there is no result."""

    kind: Literal["died", "time", "memory", "raised"]
    reason: Any = None
    """died: the name of the signal, or the exit code; raised: a CanalyzeError, or what else was raised, as a text."""


class Ended(NamedTuple):
    """A piece of work that came to its end."""

    piece: Any
    result: Any = None
    failure: Failure | None = None


class Executor(Protocol):
    """Does pieces of work at several places: this pool, Dask, Ray."""

    width: int
    """Maximum number of pieces at once."""

    def submit(self, piece: Any) -> None:
        """Submits a piece."""

    def completed(self) -> Iterator[Ended]:
        """Yields the pieces as they end, also those that are submitted meanwhile, until there are none left."""

    def close(self) -> None:
        """Ends what is under way."""


@dataclass(slots=True)
class _Worker:
    """A process, and what it is at."""

    process: "BaseProcess"
    piece: Any = None
    overdue: float = _NEVER
    """When it will have taken too long."""


class Pool:
    """Processes of this machine, started when there is work for them."""

    def __init__(
        self,
        work: Work,
        width: int,
        *,
        forked: bool = False,
        seconds: float | None = None,
        megabytes: int | None = None,
        progress: Callable[[Any, Any], None] = lambda piece, word: None,
        during: During = at_once,
    ) -> None:
        """Starts nothing yet.

        forked: where the system can, processes have all that this one has read. That must not be while it has threads.
        seconds, megabytes: what a piece may take; the limit of memory is there where the system has one. progress:
        gets a piece and how far its work says that it is. during: does what waits; where it gives None, `completed`
        ends.
        """
        import multiprocessing

        self.width = width
        self._context: Any = multiprocessing.get_context("fork" if forked and sys.platform == "linux" else "spawn")
        self._work = work
        self._seconds = seconds
        self._megabytes = megabytes
        self._progress = progress
        self._during = during
        self._waiting: deque[Any] = deque()
        self._idle: dict[Connection, _Worker] = {}
        self._busy: dict[Connection, _Worker] = {}

    def submit(self, piece: Any) -> None:
        """Submits a piece."""
        self._waiting.append(piece)
        self._dispatch()

    def completed(self) -> Iterator[Ended]:
        """Yields the pieces as they end, until there are none left, or the end is wished."""
        from multiprocessing.connection import wait

        while self._busy or self._waiting:
            self._dispatch()
            least = min(worker.overdue for worker in self._busy.values())
            timeout = None if least == _NEVER else max(0.0, least - monotonic())
            ready = self._during(partial(wait, list(self._busy), timeout))
            if ready is None:
                return
            for connection in ready:
                yield from self._heard(connection)
            now = monotonic()
            for connection in [one for one, worker in self._busy.items() if worker.overdue <= now]:
                yield self._lost(connection, "time")

    def close(self) -> None:
        """Has all processes clear up and end."""
        workers = self._busy | self._idle
        self._busy, self._idle = {}, {}
        for connection, worker in workers.items():
            worker.process.terminate()
            connection.close()
        for worker in workers.values():
            worker.process.join(PATIENCE)
            worker.process.kill()

    def _dispatch(self) -> None:
        while self._waiting and len(self._busy) < self.width:
            connection, worker = self._idle.popitem() if self._idle else self._started()
            try:
                connection.send(self._waiting[0])
            except OSError:  # it died with nothing to do
                self._buried(connection, worker)
                continue
            worker.piece = self._waiting.popleft()
            self._busy[connection] = worker

    def _started(self) -> "tuple[Connection, _Worker]":
        here, there = self._context.Pipe()
        given = there, self._work, self._megabytes, self._seconds is not None
        process = self._context.Process(target=_serve, args=given, daemon=True)
        process.start()
        there.close()
        return here, _Worker(process)

    def _heard(self, connection: "Connection") -> Iterator[Ended]:
        """Receives a message of a process about its piece."""
        worker = self._busy[connection]
        try:
            kind, said = connection.recv()
        except (EOFError, OSError):
            yield self._lost(connection, "died")
            return
        if kind == "begun":
            worker.overdue = monotonic() + (self._seconds or 0)
        elif kind == "progress":
            self._progress(worker.piece, said)
        elif kind == "memory":
            yield self._lost(connection, kind)
        else:
            self._idle[connection] = self._busy.pop(connection)
            piece, worker.piece, worker.overdue = worker.piece, None, _NEVER
            yield Ended(piece, said) if kind == "done" else Ended(piece, failure=Failure("raised", said))

    def _lost(self, connection: "Connection", kind: Literal["died", "time", "memory"]) -> Ended:
        """Abandons a process with the piece that it was at."""
        worker = self._busy.pop(connection)
        code = self._buried(connection, worker)
        if kind == "died" and self._megabytes is not None and code == -signal.SIGABRT:
            kind = "memory"  # how native code ends that gets none
        by = str(code)
        with suppress(ValueError):
            by = signal.Signals(-code).name
        return Ended(worker.piece, failure=Failure(kind, by))

    @staticmethod
    def _buried(connection: "Connection", worker: _Worker) -> int:
        connection.close()
        if worker.overdue != _NEVER:
            worker.process.kill()
        worker.process.join(PATIENCE)
        worker.process.kill()
        worker.process.join()
        return worker.process.exitcode or 0


def processors() -> int:
    """Returns the number of processors that this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _serve(connection: "Connection", work: Work, megabytes: int | None, timed: bool) -> None:
    """Does pieces of work one after the other, in a process that does nothing else.

    timed: the beginning of each is reported.
    """
    import threading

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits for this one
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_follow, daemon=True).start()
    if megabytes is not None:
        _limit(megabytes << 20)
    with suppress(EOFError, OSError):  # the process that waits for it has ended
        while True:
            piece = connection.recv()
            if timed:
                connection.send(("begun", None))
            try:
                said = "done", work(piece, lambda word: connection.send(("progress", word)))
            except MemoryError:
                said = "memory", None
            except Exception as error:
                said = "raised", error if isinstance(error, CanalyzeError) else repr(error)
            connection.send(said)
            if said[0] == "memory":
                return


def _follow() -> None:
    """Ends with the process that has started this one, so that its work is not done twice."""
    import multiprocessing
    from multiprocessing.connection import wait

    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


def _limit(size: int) -> None:
    """Limit the memory of this process, where the system can; native code that gets none says so on standard error."""
    if sys.platform == "win32":
        return
    import resource

    which = resource.RLIMIT_DATA if sys.platform == "linux" else resource.RLIMIT_AS
    with suppress(OSError, ValueError):
        resource.setrlimit(which, (size, size))
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


_LOST: Final = 2
"""Number of workers that may be lost under one piece before it is given up."""
_HERE: Final = threading.local()
"""The pool of one process of each thread of a worker, with the key of its work."""


def version() -> str:
    """Returns the version of the program, on a worker."""
    return __version__


def alike(found: Iterable[str], address: str | None) -> None:
    """Checks that all workers run the same version of the program. Raises ConfigError otherwise."""
    for other in set(found) - {__version__}:
        raise ConfigError("fleet.other_version", name=address, version=other, own=__version__)


@dataclass(frozen=True)
class Beside:
    """The work and its limits; sent to the workers."""

    work: Work
    seconds: float | None = None
    megabytes: int | None = None
    key: str = field(default_factory=lambda: os.urandom(16).hex())
    """Distinguishes this run from others of the same worker."""

    def __call__(self, piece: Any) -> Ended:
        """Does a piece."""
        key, pool = getattr(_HERE, "pool", (None, None))
        if pool is None or key != self.key:
            from multiprocessing import current_process

            if pool is not None:
                pool.close()
            current_process().daemon = False  # as workers of Dask are, which then may start no other process
            pool = Pool(self.work, 1, seconds=self.seconds, megabytes=self.megabytes)
            _HERE.pool = (self.key, pool)
        pool.submit(piece)
        return next(iter(pool.completed()))


class DaskCluster:
    """Pieces of work as tasks of a Dask cluster."""

    def __init__(self, beside: Beside, address: str | None, width: int, during: During = at_once) -> None:
        """Connects to a cluster. address: that of the scheduler; None: `width` local processes."""
        import logging

        with as_error(ConfigError, "fleet.needs", ImportError, name="Dask", extra="dask"):
            import dask
            from distributed import Client, LocalCluster, as_completed
        dask.config.set({"distributed.scheduler.allowed-failures": _LOST})
        self._cluster: Any = None
        if address is None:
            quiet: Any = {"dashboard_address": None, "silence_logs": logging.CRITICAL}
            self._cluster = LocalCluster(n_workers=width, threads_per_worker=1, **quiet)
        try:
            self._client = Client(self._cluster or address, timeout="15s")
            alike(self._client.run(version).values(), address)
        except (OSError, ValueError, ImportError) as error:
            raise ConfigError("fleet.no_cluster", name=address, problem=str(error)) from error
        self.width = max(1, sum(self._client.nthreads().values()))
        self._beside = beside
        self._during = during
        self._pieces: dict[str, Any] = {}
        self._completed = as_completed()

    def submit(self, piece: Any) -> None:
        """Schedules a piece."""
        future = self._client.submit(self._beside, piece, pure=False, retries=0)
        self._pieces[future.key] = piece
        self._completed.add(future)

    def completed(self) -> Iterator[Ended]:
        """Yields the pieces as they end; their results on the workers are released at once."""
        from distributed import KilledWorker

        while self._pieces:
            future = self._during(partial(next, self._completed))
            if future is None:
                return
            piece = self._pieces.pop(future.key)
            if future.status == "finished":
                ended = future.result()
            else:
                error = future.exception()
                lost = isinstance(error, KilledWorker)
                ended = Ended(piece, failure=Failure("died" if lost else "raised", repr(error)))
            future.release()
            yield ended._replace(piece=piece)

    def close(self) -> None:
        """Leaves the cluster; a local one is stopped."""
        for future in list(self._pieces):
            with suppress(Exception):
                self._client.cancel(future)
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()


class RayCluster:
    """Pieces of work as tasks of a Ray cluster."""

    def __init__(self, beside: Beside, address: str | None, width: int, during: During = at_once) -> None:
        """Connects to a cluster. address: that of the cluster; None: `width` local processes."""
        import logging

        with as_error(ConfigError, "fleet.needs", ImportError, name="Ray", extra="ray"):
            import ray
        self._ray = ray
        own: dict[str, Any] = {"num_cpus": width, "include_dashboard": False} if address is None else {}
        try:
            ray.init(address or "local", log_to_driver=False, logging_level=logging.ERROR, **own)
            alike([ray.get(ray.remote(version).remote())], address)
        except (OSError, ValueError, RuntimeError, ray.exceptions.RayError) as error:
            raise ConfigError("fleet.no_cluster", name=address, problem=str(error)) from error
        self.width = max(1, int(ray.cluster_resources().get("CPU", width)))
        self._do = ray.remote(max_retries=_LOST, num_cpus=1)(_done)
        self._beside = ray.put(beside)
        self._during = during
        self._pieces: dict[Any, Any] = {}

    def submit(self, piece: Any) -> None:
        """Schedules a piece."""
        self._pieces[self._do.remote(self._beside, piece)] = piece

    def completed(self) -> Iterator[Ended]:
        """Yields the pieces as they end."""
        while self._pieces:
            waited = self._during(partial(self._ray.wait, list(self._pieces), num_returns=1))
            if waited is None:
                return
            for one in waited[0]:
                piece = self._pieces.pop(one)
                try:
                    ended = self._ray.get(one)
                except self._ray.exceptions.RayError as error:
                    raised = isinstance(error, self._ray.exceptions.RayTaskError)
                    said = (str(error).strip().splitlines() or [""])[-1]
                    ended = Ended(piece, failure=Failure("raised" if raised else "died", said))
                yield ended._replace(piece=piece)

    def close(self) -> None:
        """Leaves the cluster; a local one is stopped."""
        for one in self._pieces:
            with suppress(Exception):
                self._ray.cancel(one, force=True)
        self._ray.shutdown()


def _done(beside: Beside, piece: Any) -> Ended:
    return beside(piece)


ENGINES: Final[dict[str, Callable[[Beside, str | None, int, During], Executor]]] = {
    "dask": DaskCluster,
    "ray": RayCluster,
}
"""The executors by the names of their engines."""
