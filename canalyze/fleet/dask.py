"""An executor on a Dask cluster, local or remote. The program must be installed on its workers.

Each worker has the capture read in a child process, so that limits hold, and a capture that crashes its process
affects neither the worker nor its state. Must not: know the content of the work.
"""

import logging
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from typing import Any, Final

from canalyze.errors import ConfigError
from canalyze.fleet.beside import Beside, alike, version
from canalyze.running.pool import During, Ended, Failure, at_once

_LOST: Final = 2
"""Number of workers that may be lost under one piece before Dask gives it up."""


class Cluster:
    """Pieces of work as tasks of a cluster."""

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
