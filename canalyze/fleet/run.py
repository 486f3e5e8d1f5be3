"""The whole of a run: what is left to be done of its sources, the work, the reports, and the exit code.

All captures go through an executor: a few per worker at a time, repeated if a worker was lost. A capture that fails
three times is quarantined: its manifest records that, and the others continue. Reports have many captures in figures,
for people: a line each, then which rules found something in how many; or a page. The page loads nothing, and everything
of a capture is escaped; it has no capture inside, as `canalyze.html` has: fleets are larger than a page. Must not: know
where the work is done, what is done with a capture, or count what the core counts.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from html import escape
from itertools import islice
from operator import attrgetter
from time import monotonic
from typing import Any, Final, NamedTuple, TypeVar

from canalyze import __version__, html
from canalyze.check.verdict import Verdict
from canalyze.errors import CanalyzeError, ConfigError, OutputError, SourceError
from canalyze.fleet import stores, task
from canalyze.fleet.stores import Capture, Place, content, is_url, place
from canalyze.fleet.task import Action, Manifest, Piece, Work, do, problems_of, records_of, verdict_of
from canalyze.output import Kept, Output, Progress, complain, dyed, json_text, open_output, printable
from canalyze.records import of_rows, summary
from canalyze.records.problems import KEYS, Problem
from canalyze.records.summary import KINDS, Bus, Node, Raised
from canalyze.records.summary import Record as Summarized
from canalyze.reports import check, diagnosis, hosts, table, wording
from canalyze.reports.diagnosis import Diagnosed
from canalyze.reports.table import EMPTY
from canalyze.running.pool import Executor, Failure, Pool, processors
from canalyze.running.run import Interrupt
from canalyze.words import Words


class Done(NamedTuple):
    """The captures of a run, each with its verdict."""

    action: Action
    manifests: Sequence[Manifest]
    verdicts: Sequence[Verdict]


def show(done: Done, out: Output, words: Words, *, whole: bool) -> None:
    """Writes the text report. whole: for check with the findings of each capture, not only the totals."""
    action, manifests, verdicts = done
    if action == "check":
        check.show(verdicts, out, words, totals=not whole)
    elif action == "diagnose":
        rows = [row for one in manifests if (row := problems_of(one))]
        show_problems(rows, out, words)
        if whole:
            out.text("\n")
        diagnosis.show_each(
            rows, out, words, diagnosis.Chosen(None, None, None), unread=len(manifests) - len(rows), totals=not whole
        )
    elif action == "export":
        show_tables([(one.result or {}).get("rows", {}) for one in manifests], out, words)
    else:
        show_summaries([(one.capture, one.error, of_rows(records_of(one), *KINDS)) for one in manifests], out, words)
    show_failed([(one.capture, one.error or "", one.attempts) for one in manifests if one.failed], out, words)


def write(done: Done, place: Place, name: str, words: Words, *, html: bool) -> list[str]:
    """Writes all reports under a name; returns their names."""
    action, manifests, verdicts = done
    text = Kept()
    show(done, text, words, whole=True)
    lines = check.json_lines(verdicts) if action == "check" else _records(action, manifests)
    reports = {
        "txt": bytes(text.data),
        "jsonl": "".join(f"{line}\n" for line in lines).encode("utf-8", "backslashreplace"),
        "xml": hosts.junit(verdicts, words),
    }
    if html:
        reports["html"] = page([(one, kept.findings) for one, kept in zip(verdicts, manifests, strict=True)], words)
    for form, data in reports.items():
        place.put(f"{name}.{form}", data)
    return [f"{name}.{form}" for form in reports]


def _records(action: Action, done: Iterable[Manifest]) -> Iterable[str]:
    """Yields the records of summaries, problems and exports, each with its capture, and the reasons of failures."""
    for one in done:
        if action == "export" and one.result:
            yield json_text({"capture": one.capture, "kind": "export", **one.result}, compact=True)
        for problem in (one.result or {}).get("problems", ()) if action == "diagnose" else ():
            yield json_text({"capture": one.capture, **{key: problem[key] for key in KEYS}}, compact=True)
        for record in records_of(one) if action == "summary" else ():
            yield json_text({"capture": one.capture, **record}, compact=True)
        if one.failed:
            row = {"capture": one.capture, "kind": "failed", "reason": one.failed, "error": one.error}
            yield json_text(row, compact=True)


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
    of_all = Done(work.action, manifests, [verdict_of(work.action, one) for one in manifests])
    reports = write(of_all, place(work.out), name, words, html=how.html)
    show(of_all, out, words, whole=False)
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
    from canalyze.running.pool import ENGINES, Beside

    name, address = how.on
    return ENGINES[name](Beside(one, how.seconds, how.megabytes), address, width, interrupt.during)


def _far(count: int, total: int, seconds: float, words: Words) -> str:
    rate = count / max(seconds, 1e-3)
    left = round((total - count) / rate)
    clock = f"{left // 3600}:{left // 60 % 60:02}:{left % 60:02}"
    return words("fleet.progress", done=count, total=total, rate=f"{rate:.1f}", left=clock)


T = TypeVar("T")


def show_summaries(captures: Sequence[tuple[str, str | None, Sequence[Summarized]]], out: Output, words: Words) -> None:
    """Writes the tables. captures: name, why it was not read as a whole, records of `summary`."""
    right = ("frames", "seconds", "nodes", "transfers", "load", "findings")
    columns = table.columns(words, ["capture", *right], of="fleet", right=right, folds=["capture"])
    table.write(columns, ([name, *_figures(records)] for name, _, records in captures), out)
    found = Counter[str]()
    spread = Counter[str]()
    for _, _, records in captures:
        for one in _of(Raised, records):
            title = f"{one.code} {one.name}"
            found[title] += one.count
            spread[title] += 1
    if found:
        out.text("\n")
        columns = table.columns(words, ["rule", "files", "count"], of="fleet", right=["files", "count"])
        ordered = sorted(spread.items(), key=lambda row: (-row[1], row[0]))
        table.write(columns, ([title, str(files), str(found[title])] for title, files in ordered), out)
    frames = sum(one.frames for _, _, records in captures for one in _of(summary.Capture, records))
    hours = sum(float(one.seconds or 0) for _, _, records in captures for one in _of(summary.Capture, records)) / 3600
    out.text("\n" + words("fleet.figures", files=len(captures), frames=frames, hours=f"{hours:.2f}") + "\n")


def show_problems(captures: Sequence[Diagnosed], out: Output, words: Words) -> None:
    """Writes the kinds of problems by node, with the number of captures, the most open ones first."""
    spread: dict[tuple[str, str], list[tuple[str, Problem]]] = {}
    for row in captures:
        for one in row.roots:
            if one.status != "harmless":
                concerned = one.nodes if one.node is None else (one.node,)
                key = one.kind, wording.ranges(concerned, ", ") or EMPTY
                spread.setdefault(key, []).append((row.names[0], one))
    if not spread:
        return

    def figures(found: Sequence[tuple[str, Problem]]) -> list[int]:
        states = Counter(one.status for _, one in found)
        return [len({name for name, _ in found}), *(states[state] for state in ("open", "unknown", "ended"))]

    ordered = sorted(spread.items(), key=lambda item: (-figures(item[1])[1], -figures(item[1])[0], item[0]))
    right = ("node", "files", "open", "unknown", "ended")
    columns = table.columns(words, ["problem", *right, "worst"], of="fleet", right=right, folds=["worst"])
    rank = ("open", "unknown", "ended")
    rows = []
    for (kind, nodes), found in ordered:
        name, one = min(found, key=lambda entry: rank.index(entry[1].status))
        where = f"{wording.capture_name(name)} -n {one.id}"
        rows.append([kind, nodes, *map(str, figures(found)), where])
    table.write(columns, rows, out)
    out.text("\n")


def show_tables(captures: Sequence[Mapping[str, int]], out: Output, words: Words) -> None:
    """Writes the tables that were made. captures: rows by table, a wide one as signals/MESSAGE."""
    rows, files = Counter[str](), Counter[str]()
    for one in captures:
        rows.update(one)
        files.update(one.keys())
    columns = table.columns(words, ["table", "files", "rows"], of="fleet", right=["files", "rows"])
    table.write(columns, ([name, str(files[name]), str(rows[name])] for name in sorted(rows)), out)


def show_failed(failed: Sequence[tuple[str, str, int]], out: Output, words: Words) -> None:
    """Writes the captures that could not be read, or not as a whole: name, reason, number of attempts."""
    if failed:
        out.text("\n" + dyed(words("fleet.failed", files=len(failed)), "error", out=out) + "\n")
    for name, reason, attempts in failed:
        said = reason if name in reason else f"{name}: {reason}"
        tried = "" if attempts == 1 else words("fleet.tried", attempts=attempts)
        out.text(f"  {printable(said)}{tried}\n")


def _of(kind: type[T], records: Sequence[Summarized]) -> list[T]:
    return [one for one in records if isinstance(one, kind)]


def _figures(records: Sequence[Summarized]) -> list[str]:
    """Returns frames, seconds, nodes, transfers, peak of the load, findings; EMPTY where there is none of it."""
    if not _of(summary.Capture, records):
        return [EMPTY] * 6
    (whole,), nodes = _of(summary.Capture, records), _of(Node, records)
    loads = [one.load_peak_1s for one in _of(Bus, records) if one.load_peak_1s is not None]
    return [
        str(whole.frames),
        EMPTY if whole.seconds is None else f"{float(whole.seconds):.1f}",
        str(len(nodes)),
        str(sum(one.transfers for one in nodes)),
        f"{max(loads):.1f}%" if loads else EMPTY,
        str(sum(one.count for one in _of(Raised, records))),
    ]


_SAID: Final = 20
"""Findings of one capture that are shown at most."""
_STATES: Final = {"unread": "unknown", "failing": "open", "passing": "ended"}
"""In the order in which captures are listed, with the class in the style of the page."""


def page(captures: Sequence[tuple[Verdict, int]], words: Words) -> bytes:
    """Returns the page. captures: each with the number of findings that count."""
    rows = sorted(
        ((_state(one), one, findings) for one, findings in captures), key=lambda row: [*_STATES].index(row[0])
    )
    states = [state for state, _, _ in rows]
    counts = " · ".join(f"{words(f'fleet.{state}')} {states.count(state)}" for state in _STATES)
    names = ("capture", "", "frames", "findings", "")
    head = "".join(f"<th>{escape(words(f'fleet.{name}')) if name else ''}</th>" for name in names)
    body = "\n".join(_row(*row, words) for row in rows)
    return html.static(
        words.lang,
        "canalyze fleet",
        f'<header class="fleet"><h1>canalyze fleet</h1><p id="verdict">{escape(counts)}</p></header>\n'
        f'<section id="index" class="fleet"><table>\n<tr>{head}</tr>\n{body}\n</table></section>',
    )


def _state(verdict: Verdict) -> str:
    return "unread" if verdict.error is not None else "failing" if verdict.failed else "passing"


def _row(state: str, verdict: Verdict, findings: int, words: Words) -> str:
    said = [wording.title(one.finding) + ": " + wording.sentence(one, words) for one in verdict.failures]
    said += [printable(one.message) for one in verdict.stories if one.id in verdict.problems]
    said = ([printable(verdict.error)] if verdict.error else []) + said[:_SAID]
    name, shown = escape(wording.capture_name(verdict.file)), escape(words(f"fleet.{state}"))
    lines = "<br>".join(map(escape, said))
    cells = f'<td>{name}</td><td class="{_STATES[state]}">{shown}</td><td>{verdict.frames}</td><td>{findings}</td>'
    return f"<tr>{cells}<td>{lines}</td></tr>"
