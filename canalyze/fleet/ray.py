"""An executor on a Ray cluster, local or remote. The program must be installed on its workers.

As on Dask, a worker has the capture read in a child process. Must not: know the content of the work.
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
"""Number of times that Ray repeats a piece whose worker was lost."""


class Cluster:
    """Pieces of work as tasks of a cluster."""

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
