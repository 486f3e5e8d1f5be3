"""A piece of work done in a process beside the worker of an engine, which has no hard limits of its own.

Must not: know an engine, or what the work is.
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
"""The pool of one process that each thread of a worker has, with the key of its work."""


def version() -> str:
    """Give that of the program, where a worker runs this."""
    return __version__


def alike(found: Iterable[str], address: str | None) -> None:
    """Make sure that all workers have this program; ConfigError where one has another."""
    for other in set(found) - {__version__}:
        raise ConfigError("fleet.other_version", name=address, version=other, own=__version__)


@dataclass(frozen=True)
class Beside:
    """How it is done; sent to the workers."""

    work: Work
    seconds: float | None = None
    megabytes: int | None = None
    key: str = field(default_factory=lambda: uuid4().hex)
    """What tells this run from others of one worker."""

    def __call__(self, piece: Any) -> Ended:
        """Do a piece."""
        key, pool = getattr(_HERE, "pool", (None, None))
        if pool is None or key != self.key:
            if pool is not None:
                pool.close()
            current_process().daemon = False  # as workers of Dask are, which then may start no other process
            pool = Pool(self.work, 1, seconds=self.seconds, megabytes=self.megabytes)
            _HERE.pool = (self.key, pool)
        pool.submit(piece)
        return next(iter(pool.completed()))
