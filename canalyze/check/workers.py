"""Captures examined side by side, as many at once as there are processors.

A process that dies is an error of its capture only. Standard input, and a capture that is alone, are examined in this
process. Must not: know what a finding is.
"""

from collections.abc import Iterator, Sequence
from time import monotonic
from typing import TYPE_CHECKING, Any, Final

from msgspec.structs import replace

from canalyze.check.examination import Job, examine
from canalyze.check.verdict import Examined
from canalyze.running.run import Interrupt, Meter
from canalyze.sources.file import STDIN
from canalyze.sources.names import Named
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.running.pool import Tell

_EVERY: Final = 0.2
"""Seconds between two words of a process on how far it is."""


def examine_all(names: Sequence[str], job: Job, progress: Meter) -> tuple[list[Examined | None], int]:
    """Examines captures; returns the results in their order, and the signal that ended the work, 0 for none.

    None: the end was wished before it was done.
    """
    if len(names) == 1:
        alone = examine(names[0], job, progress)
        return [alone], alone.signal
    return _side_by_side(names, job, progress)


def _side_by_side(names: Sequence[str], job: Job, progress: Meter) -> tuple[list[Examined | None], int]:
    from canalyze.running.pool import Pool, processors

    found: list[Examined | None] = [None] * len(names)
    # The processors are shared by captures already.
    job = replace(job, given={**job.given, "threads": 1})
    frames = [0] * len(names)

    def progressed(place: int, word: Any) -> None:
        size, frames[place] = word
        progress.step(size, sum(frames))

    with Interrupt() as interrupt:
        pool = Pool(
            _Examination(names, job),
            min(processors(), len(names)),
            forked=True,
            progress=progressed,
            during=interrupt.during,
        )
        try:
            for place, name in enumerate(names):
                if name != STDIN:
                    pool.submit(place)
            if STDIN in names:
                place = names.index(STDIN)
                one = found[place] = examine(STDIN, job, progress)
                frames[place] = one.frames
                interrupt.signal = interrupt.signal or one.signal
            for ended in pool.completed():
                by = ended.failure and ended.failure.reason
                one = found[ended.piece] = ended.result or _dead(names[ended.piece], by, job)
                frames[ended.piece] = one.frames
        finally:
            pool.close()
    return found, interrupt.signal


def _dead(name: str, by: object, job: Job) -> Examined:
    error = Words(job.lang)("check.died", name=name, by=by)
    return Examined(name, error=error, complaints=(f"canalyze: {error}",))


class _Examination:
    """The work of a process on a capture, by its place."""

    def __init__(self, names: Sequence[str], job: Job) -> None:
        self._names = names
        self._job = job

    def __call__(self, place: int, tell: "Tell") -> Examined:
        return examine(self._names[place], self._job, Far(tell))


class Far:
    """Progress of a process, told to the one that started it."""

    def __init__(self, tell: "Tell") -> None:
        """Reports this progress now and then."""
        self._tell = tell
        self._size = 0
        self._next = monotonic() + _EVERY

    def step(self, size: int, frames: int) -> None:
        """Adds `size` bytes."""
        self._size += size
        if monotonic() >= self._next:
            self._tell((self._size, frames))
            self._size = 0
            self._next = monotonic() + _EVERY

    def clear(self) -> None:
        """Nothing is shown here."""


def in_order(named: Sequence[Named], found: Sequence[Examined | None], words: Words) -> list[Examined]:
    """Returns results in the order of the command line, with an error for each file that is missing."""
    waiting = iter(found)
    every: list[Examined] = []
    for one in named:
        if one.error is not None:
            reason = one.error.in_words(words)
            every.append(Examined(one.name, error=reason, complaints=(f"canalyze: {reason}",)))
        elif (examined := next(waiting)) is not None:
            every.append(examined)
    return every


def complaints(examined: Sequence[Examined], descriptions: Sequence[str]) -> Iterator[str]:
    """Yields the complaints about captures, a line each.

    That a node is in no capture is worth a line; that it is not in each capture of a set is none.
    """
    about_nodes = tuple(f"{file}: " for file in descriptions)
    read = [set(one.complaints) for one in examined if one.frames]
    common = set.intersection(*read) if read else set()
    said: set[str] = set()
    for one in examined:
        for line in one.complaints:
            if line.startswith(about_nodes):
                if line in common and line not in said:
                    yield line
                    said.add(line)
            else:
                yield line
