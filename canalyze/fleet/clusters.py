"""Executors on clusters of Dask and Ray, local or remote. The program must be installed on their workers.

Each worker has the capture read in a child process, because these engines have no hard limits of their own, and a
capture that crashes its process affects neither the worker nor its state. Must not: know the content of the work.
"""

import logging
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import current_process
from typing import Any, Final
from uuid import uuid4

from canalyze import __version__
from canalyze.errors import ConfigError
from canalyze.running.pool import During, Ended, Executor, Failure, Pool, Work, at_once

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
    key: str = field(default_factory=lambda: uuid4().hex)
    """Distinguishes this run from others of the same worker."""

    def __call__(self, piece: Any) -> Ended:
        """Does a piece."""
        key, pool = getattr(_HERE, "pool", (None, None))
        if pool is None or key != self.key:
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
        try:
            import dask
            from distributed import Client, LocalCluster, as_completed
        except ImportError as error:
            raise ConfigError("fleet.needs", error=error, name="Dask", extra="dask") from error
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
        try:
            import ray
        except ImportError as error:
            raise ConfigError("fleet.needs", error=error, name="Ray", extra="ray") from error
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
