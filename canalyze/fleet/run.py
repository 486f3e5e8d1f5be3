"""The whole of a run: what is left to be done of its sources, the work, the reports, and the exit code.

All captures go through an executor: a few per worker at a time, repeated if a worker was lost. A capture that fails
three times is quarantined: its manifest records that, and the others continue. Must not: know where the work is done,
or what is done with a capture.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from functools import partial
from itertools import islice
from operator import attrgetter
from time import monotonic
from typing import Any, Final, NamedTuple

from canalyze import __version__
from canalyze.errors import CanalyzeError, ConfigError, OutputError, SourceError
from canalyze.fleet import stores, task
from canalyze.fleet.stores import Capture, Place, content, is_url, place
from canalyze.fleet.task import Action, Manifest, Piece, Work, do, problems_of, records_of, verdict_of
from canalyze.output import Kept, Output, Progress, complain, open_output
from canalyze.output import jsonl as json_lines
from canalyze.records import of_rows
from canalyze.records.problems import KEYS
from canalyze.records.summary import KINDS
from canalyze.reports import check, diagnosis, fleet, hosts
from canalyze.running.pool import Executor, Failure, Pool, processors
from canalyze.running.run import Interrupt
from canalyze.words import Words


def show(action: Action, done: Sequence[Manifest], out: Output, words: Words, *, whole: bool) -> None:
    """Writes the text report. whole: for check with the findings of each capture, not only the totals."""
    if action == "check":
        check.show([verdict_of(action, one) for one in done], out, words, totals=not whole)
    elif action == "diagnose":
        rows = [row for one in done if (row := problems_of(one))]
        fleet.show_problems(rows, out, words)
        if whole:
            out.text("\n")
        diagnosis.show_each(
            rows, out, words, diagnosis.Chosen(None, None, None), unread=len(done) - len(rows), totals=not whole
        )
    elif action == "export":
        fleet.show_tables([(one.result or {}).get("rows", {}) for one in done], out, words)
    else:
        fleet.show([(one.capture, one.error, of_rows(records_of(one), *KINDS)) for one in done], out, words)
    fleet.show_failed([(one.capture, one.error or "", one.attempts) for one in done if one.failed], out, words)


def write(action: Action, done: Sequence[Manifest], place: Place, name: str, words: Words, *, html: bool) -> list[str]:
    """Writes all reports under a name; returns their names."""
    verdicts = [verdict_of(action, one) for one in done]
    text = Kept()
    show(action, done, text, words, whole=True)
    lines = check.json_lines(verdicts) if action == "check" else _records(action, done)
    reports = {
        "txt": bytes(text.data),
        "jsonl": "".join(f"{line}\n" for line in lines).encode("utf-8", "backslashreplace"),
        "xml": hosts.junit(verdicts, words),
    }
    if html:
        reports["html"] = fleet.page([(verdict_of(action, one), one.findings) for one in done], words)
    for form, data in reports.items():
        place.put(f"{name}.{form}", data)
    return [f"{name}.{form}" for form in reports]


def _records(action: Action, done: Iterable[Manifest]) -> Iterable[str]:
    """Yields the records of summaries, problems and exports, each with its capture, and the reasons of failures."""
    for one in done:
        if action == "export" and one.result:
            yield json_lines.text({"capture": one.capture, "kind": "export", **one.result}, compact=True)
        for problem in (one.result or {}).get("problems", ()) if action == "diagnose" else ():
            yield json_lines.text({"capture": one.capture, **{key: problem[key] for key in KEYS}}, compact=True)
        for record in records_of(one) if action == "summary" else ():
            yield json_lines.text({"capture": one.capture, **record}, compact=True)
        if one.failed:
            row = {"capture": one.capture, "kind": "failed", "reason": one.failed, "error": one.error}
            yield json_lines.text(row, compact=True)


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
    there = task.read_all(place(work.out), work.action, list(by_id))
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
    task.keep(place(work.out), work.action, done)
    return done


class How(NamedTuple):
    """The way the work is done, by the names of options."""

    on: tuple[str, str | None] | None
    """An engine and its address; None: processes of this machine."""
    workers: int | None
    seconds: int | None
    """The longest that a capture may take."""
    megabytes: int | None
    """The most memory that it may need."""
    shard: tuple[int, int] | None
    """The part of the captures, and the number of parts."""
    retry: bool
    html: bool
    color: str


def complete(work: Work, sources: Sequence[str], how: How, words: Words) -> int:
    """Works on every capture that is not done, and reports on all of them; returns the exit code."""
    shard = how.shard
    every = stores.captures(sources, work.out, beside=work.beside)
    captures = [one for one in every if shard is None or one.in_shard(*shard)]
    done = standing(work, captures, retry=how.retry)
    todo = [one for one in captures if one.id not in done]
    todo.sort(key=attrgetter("size"), reverse=True)  # so that no process is left alone with a long one at the end
    with ExitStack() as stack:
        out = stack.enter_context(open_output(None, color=how.color))
        progress = Progress(words, out, None, until_output=True)
        interrupt = stack.enter_context(Interrupt())
        if todo:
            executor = _executor(how, work, todo, interrupt)
            stack.callback(executor.close)
            began = monotonic()
            for count, one in enumerate(run(executor, work, todo), 1):
                done[one.id] = one
                progress.show(partial(_far, count, len(todo), monotonic() - began, words))
                if interrupt.signal:
                    break
            progress.clear()
    if interrupt.signal:
        # a worker may have left a manifest and come no further
        done |= standing(work, [one for one in todo if one.id not in done], retry=how.retry)
        complain(f"canalyze: {words('fleet.broken_off', done=len(done), files=len(captures))}")
        return 128 + interrupt.signal
    manifests = [done[one.id] for one in captures]
    name = work.action if shard is None else f"{work.action}-{shard[0]}-of-{shard[1]}"
    reports = write(work.action, manifests, place(work.out), name, words, html=how.html)
    show(work.action, manifests, out, words, whole=False)
    said = words("fleet.done", files=len(captures), before=len(captures) - len(todo))
    out.text(said + words("fleet.reports", where=work.out, names=words("fleet.then").join(reports)) + "\n")
    if any(one.failed for one in manifests):
        return 3
    return 1 if work.action == "check" and any(one.findings for one in manifests) else 0


def _executor(how: How, work: Work, todo: Sequence[Capture], interrupt: Interrupt) -> Any:
    """Returns what does the work: processes of this machine, or an engine."""
    one, width = partial(do, work), min(how.workers or processors(), len(todo))
    if how.on is None:
        # Clients of stores have threads, and so may what writes tables; a limit of memory is for the work alone.
        alone = work.action != "export" and not is_url(work.out) and all(one.store is None for one in todo)
        alone = alone and how.megabytes is None
        limits: dict[str, Any] = {"seconds": how.seconds, "megabytes": how.megabytes}
        return Pool(one, width, forked=alone, during=interrupt.during, **limits)
    from canalyze.fleet.clusters import ENGINES, Beside

    name, address = how.on
    return ENGINES[name](Beside(one, how.seconds, how.megabytes), address, width, interrupt.during)


def _far(count: int, total: int, seconds: float, words: Words) -> str:
    rate = count / max(seconds, 1e-3)
    left = round((total - count) / rate)
    clock = f"{left // 3600}:{left // 60 % 60:02}:{left % 60:02}"
    return words("fleet.progress", done=count, total=total, rate=f"{rate:.1f}", left=clock)
