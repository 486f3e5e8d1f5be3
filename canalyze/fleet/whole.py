"""The whole of a run: what is left to be done of its sources, the work, the reports, and the exit code.

Must not: know what is done with a capture.
"""

from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from time import monotonic
from typing import Any, NamedTuple

from canalyze.fleet import run as runs
from canalyze.fleet import sources as listing
from canalyze.fleet import summary
from canalyze.fleet.stores import place
from canalyze.fleet.task import Work, do
from canalyze.output import Progress, complain, open_output
from canalyze.running.pool import Pool, processors
from canalyze.running.run import Interrupt
from canalyze.words import Words


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
    every = listing.captures(sources, work.out, beside=work.beside)
    captures = [one for one in every if shard is None or one.in_shard(*shard)]
    done = runs.standing(work, captures, retry=how.retry)
    todo = [one for one in captures if one.id not in done]
    with ExitStack() as stack:
        out = stack.enter_context(open_output(None, color=how.color))
        progress = Progress(words, out, None, until_output=True)
        interrupt = stack.enter_context(Interrupt())
        if todo:
            executor = _executor(how, work, min(how.workers or processors(), len(todo)), interrupt)
            stack.callback(executor.close)
            began = monotonic()
            for count, one in enumerate(runs.run(executor, work, todo), 1):
                done[one.id] = one
                progress.show(partial(_far, count, len(todo), monotonic() - began, words))
                if interrupt.signal:
                    break
            progress.clear()
    if interrupt.signal:
        # a worker may have left a manifest and come no further
        done |= runs.standing(work, [one for one in todo if one.id not in done], retry=how.retry)
        complain(f"canalyze: {words('fleet.broken_off', done=len(done), files=len(captures))}")
        return 128 + interrupt.signal
    manifests = [done[one.id] for one in captures]
    name = work.action if shard is None else f"{work.action}-{shard[0]}-of-{shard[1]}"
    reports = summary.write(work.action, manifests, place(work.out), name, words, html=how.html)
    summary.show(work.action, manifests, out, words, whole=False)
    said = words("fleet.done", files=len(captures), before=len(captures) - len(todo))
    out.text(said + words("fleet.reports", where=work.out, names=words("fleet.then").join(reports)) + "\n")
    if any(one.failed for one in manifests):
        return 3
    return 1 if work.action == "check" and any(one.findings for one in manifests) else 0


def _executor(how: How, work: Work, width: int, interrupt: Interrupt) -> Any:
    """Returns what does the work: processes of this machine, or an engine."""
    one = partial(do, work)
    if how.on is None:
        return Pool(one, width, seconds=how.seconds, megabytes=how.megabytes, during=interrupt.during)
    from canalyze.fleet.clusters import ENGINES, Beside

    name, address = how.on
    return ENGINES[name](Beside(one, how.seconds, how.megabytes), address, width, interrupt.during)


def _far(count: int, total: int, seconds: float, words: Words) -> str:
    rate = count / max(seconds, 1e-3)
    left = round((total - count) / rate)
    clock = f"{left // 3600}:{left // 60 % 60:02}:{left % 60:02}"
    return words("fleet.progress", done=count, total=total, rate=f"{rate:.1f}", left=clock)
