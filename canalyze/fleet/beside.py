"""Does work in a child process of a cluster's worker, because cluster engines have no hard limits of their own.

Must not: know an engine, or the content of the work.
"""

import threading
from collections.abc import Iterable
from dataclasses import dataclass, field
from multiprocessing import current_process
from typing import Any, Final
from uuid import uuid4

from canalyze import __version__
from canalyze.errors import ConfigError
from canalyze.running.pool import Ended, Pool, Work

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
