"""Captures examined side by side, one process each, as many at once as there are processors.

A process that dies is an error of its capture only. Standard input, and a capture that is alone, are examined in this
process. Must not: know what a finding is.
"""

import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from time import monotonic
from typing import TYPE_CHECKING, Any, Final

from canalyze.check.examination import Job, examine
from canalyze.check.verdict import Examined
from canalyze.running.run import Interrupt, Meter
from canalyze.sources.file import STDIN
from canalyze.words import Words

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

_EVERY: Final = 0.2
"""Seconds between two words of a process on how far it is."""
_PATIENCE: Final = 5.0
"""Seconds that a process is given to clear up when the end is wished."""


def examine_all(names: Sequence[str], job: Job, progress: Meter) -> tuple[list[Examined | None], int]:
    """Examine captures; give what came of each, in their order, and the signal that ended the work, 0 for none.

    None: the end was wished before it was done.
    """
    if len(names) == 1:
        alone = examine(names[0], job, progress)
        return [alone], alone.signal
    return _side_by_side(names, job, progress)


@dataclass(slots=True)
class _Worker:
    """A process at work."""

    place: int
    process: "BaseProcess"
    frames: int = 0


def _side_by_side(names: Sequence[str], job: Job, progress: Meter) -> tuple[list[Examined | None], int]:
    import multiprocessing
    from multiprocessing.connection import wait

    found: list[Examined | None] = [None] * len(names)
    # The processors are shared by captures already.
    job = replace(job, given={**job.given, "threads": 1})
    waiting = [place for place, name in reversed(list(enumerate(names))) if name != STDIN]
    here = [place for place, name in enumerate(names) if name == STDIN]
    busy: dict[Connection, _Worker] = {}
    frames = 0
    # What can be forked has all that this process has read; elsewhere it starts anew.
    context: Any = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
    with Interrupt() as interrupt:
        try:
            while (waiting or busy or here) and not interrupt.signal:
                while waiting and len(busy) < _processors():
                    place = waiting.pop()
                    receiving, sending = context.Pipe(duplex=False)
                    process = context.Process(target=_work, args=(sending, names[place], job), daemon=True)
                    process.start()
                    sending.close()
                    busy[receiving] = _Worker(place, process)
                if here:
                    place = here.pop()
                    one = found[place] = examine(names[place], job, progress)
                    frames += one.frames
                    interrupt.signal = interrupt.signal or one.signal
                    continue
                ready = interrupt.during(lambda: wait(list(busy))) or ()
                for connection in [one for one in busy if one in ready]:
                    worker = busy[connection]
                    said = _heard(connection)
                    if isinstance(said, tuple):
                        size, worker.frames = said
                        progress.step(size, frames + sum(one.frames for one in busy.values()))
                        continue
                    del busy[connection]
                    connection.close()
                    worker.process.join()
                    found[worker.place] = said or _dead(names[worker.place], worker.process.exitcode or 0, job)
                    frames += said.frames if said else 0
        finally:
            _end(busy)
    return found, interrupt.signal


def _heard(connection: "Connection") -> Any:
    """Give what a process says: how far it is, or at last what it has found; None if it will say nothing more."""
    try:
        return connection.recv()
    except (EOFError, OSError):
        return None


def _dead(name: str, exit_code: int, job: Job) -> Examined:
    words = Words(job.lang)
    by = str(exit_code)
    with suppress(ValueError):
        by = signal.Signals(-exit_code).name
    error = words("check.died", name=name, by=by)
    return Examined(name, error=error, complaints=(f"canalyze: {error}",))


def _end(busy: "dict[Connection, _Worker]") -> None:
    """Let what is still at work clear up and go."""
    for connection, worker in busy.items():
        worker.process.terminate()
        connection.close()
    for worker in busy.values():
        worker.process.join(_PATIENCE)
        worker.process.kill()


class _Far:
    """Progress of a process, told to the one that started it."""

    def __init__(self, connection: "Connection") -> None:
        self._connection = connection
        self._size = 0
        self._next = monotonic() + _EVERY

    def step(self, size: int, frames: int) -> None:
        """Count `size` bytes more."""
        self._size += size
        if monotonic() >= self._next:
            self._connection.send((self._size, frames))
            self._size = 0
            self._next = monotonic() + _EVERY

    def clear(self) -> None:
        """Nothing is shown here."""


def _work(connection: "Connection", name: str, job: Job) -> None:
    """Examine one capture, in a process that does nothing else."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits for this one
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with suppress(BrokenPipeError):
        connection.send(examine(name, job, _Far(connection)))
    connection.close()


def _processors() -> int:
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
