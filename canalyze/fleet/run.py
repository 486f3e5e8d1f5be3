"""Runs all captures through an executor: a few per worker at a time, repeated if a worker was lost.

A capture that fails three times is quarantined: its manifest records that, and the others continue. Must not: know
where the work is done, or print.
"""

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Final

from canalyze import __version__
from canalyze.errors import CanalyzeError, ConfigError, OutputError, SourceError
from canalyze.fleet import manifest
from canalyze.fleet.manifest import Manifest
from canalyze.fleet.sources import Capture, content
from canalyze.fleet.stores import place
from canalyze.fleet.task import Piece, Work
from canalyze.running.pool import Executor, Failure
from canalyze.words import Words

ATTEMPTS: Final = 3
"""Maximum number of attempts per capture."""
_OTHERS: Final = ("fetch", "raised")
"""Failures that are not caused by the capture: those of the store, the cluster, the program."""
_AHEAD: Final = 3
"""Number of captures submitted per worker; the rest can still be submitted to other workers."""


def standing(work: Work, captures: Iterable[Capture], *, retry: bool) -> dict[str, Manifest]:
    """Returns the manifests that need no new work, as far as is known without reading a capture, by their ids.

    A failure stays until its capture changes, unless the capture did not cause it. retry: all failures are repeated.
    """
    if work.force:
        return {}
    by_id = {one.id: one for one in captures}
    there = manifest.read_all(place(work.out), work.action, list(by_id))
    again = (*_OTHERS, "unreadable", "died", "time", "memory") if retry else _OTHERS
    return {
        number: one
        for number, one in there.items()
        if one.holds(__version__, work.settings)
        and one.stamp
        and one.stamp == by_id[number].stamp
        and one.failed not in again
    }


def run(executor: Executor, work: Work, captures: Iterable[Capture]) -> Iterator[Manifest]:
    """Yields the manifests as the work ends. Raises OutputError if none can be written."""
    waiting = map(Piece, captures)
    for piece in islice(waiting, _AHEAD * executor.width):
        executor.submit(piece)
    for ended in executor.completed():
        piece, failure = ended.piece, ended.failure
        if failure is None:
            yield ended.result
        elif isinstance(failure.reason, OutputError | ConfigError):
            raise failure.reason
        elif piece.attempt < ATTEMPTS:
            executor.submit(piece._replace(attempt=piece.attempt + 1))
            continue
        else:
            yield _quarantined(work, piece, failure)
        for following in islice(waiting, 1):
            executor.submit(following)


def _quarantined(work: Work, piece: Piece, failure: Failure) -> Manifest:
    """Writes and returns a manifest with the reason of the failures."""
    capture, words = piece.capture, Words(work.job.lang)
    fetch = isinstance(failure.reason, SourceError)
    reason = failure.reason.in_words(words) if isinstance(failure.reason, CanalyzeError) else failure.reason
    key = "fleet.fetch" if fetch else "fleet.memory_out" if failure.kind == "memory" else f"fleet.{failure.kind}"
    tag = capture.stamp
    if capture.store is None and not fetch:
        tag = content(capture.path, beside=work.beside)
    done = Manifest(
        capture.name,
        capture.id,
        tag,
        capture.stamp,
        __version__,
        work.settings,
        "fetch" if fetch else failure.kind,
        words(key, name=capture.name, reason=reason, attempts=piece.attempt),
        piece.attempt,
        0,
        0,
        0.0,
        None,
    )
    manifest.write(place(work.out), work.action, done)
    return done
