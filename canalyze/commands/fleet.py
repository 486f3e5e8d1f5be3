"""`canalyze fleet`: many captures, each by itself, on several processors or machines, into one place.

What is done with a capture stands in `canalyze/fleet/task.py`, how it is seen to that all are done in `run.py` there.

Exit codes: as those of `check`, and 3 where all is done but for captures that failed.
"""

import re
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from time import monotonic
from typing import Any, Final, Unpack

import click

from canalyze import exporting
from canalyze.check.examination import Job
from canalyze.check.policy import Policy, Standing, Threshold
from canalyze.commands.check import held_policy, judging_options, known_findings, tried
from canalyze.commands.export import table_option
from canalyze.configuration.config import Config
from canalyze.configuration.options import (
    ANY_PATH,
    CaptureOptions,
    OneOf,
    bitrate_option,
    color_option,
    positive,
    reading_options,
    spelled,
    time_option,
)
from canalyze.output import Progress, complain, open_output
from canalyze.output.help import Command
from canalyze.words import Words

_ACTIONS: Final = ("check", "diagnose", "export", "summary")
_CHECKS: Final = ("fail_on", "select", "ignore", "baseline", "expect", "no_expect", "incidents")
_OF: Final = dict.fromkeys(_CHECKS, "check") | dict.fromkeys(("tables", "signals", "device_from"), "export")
"""Options that are of one action only."""
_ENGINES: Final = ("dask", "ray")


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        action: Any,
        sources: tuple[str, ...],
        output: str | None,
        shard: tuple[int, int] | None,
        workers: int | None,
        on: tuple[str, str | None] | None,
        seconds: int | None,
        megabytes: int | None,
        tables: tuple[str, ...],
        signals: str | None,
        device_from: str | None,
        retry: bool,
        html: bool,
        force: bool,
        expression: str | None,
        time: str | None,
        color: str,
        stamps: str,
        fail_on: Threshold | None,
        select: tuple[tuple[str, ...], ...],
        ignore: tuple[tuple[str, ...], ...],
        baseline: str | None,
        expect: str | None,
        no_expect: bool,
        incidents: Standing | None,
        **given: Unpack[CaptureOptions],
    ) -> int:
        from canalyze.fleet import run as runs
        from canalyze.fleet import sources as listing
        from canalyze.fleet import summary
        from canalyze.fleet.stores import place
        from canalyze.fleet.task import Work
        from canalyze.running.run import Interrupt

        _agree(action, sources, output, words, expect=expect, no_expect=no_expect)
        assert output is not None
        given["merge"] = False
        given["threads"] = 1  # the processors are shared by captures already
        config = click.get_current_context().find_object(Config) or Config()
        asked = Policy(fail_on, sum(select, ()), sum(ignore, ()), baseline, incidents=incidents)
        held = held_policy(config.check or Policy(), asked, words)
        settings: dict[str, Any] = {"filter": expression, "stamps": stamps, "time": time}
        chosen = tuple(dict.fromkeys(tables)) or tuple(exporting.TABLES)
        if action == "export":
            exporting.require()
            settings |= {"tables": [exporting.TABLES[name] for name in chosen], "select": signals}
        job = tried(
            Job(words.lang, given, config.known, settings, expect, not no_expect, held.incidents is not None), words
        )
        with ExitStack() as stack:
            scratch = None if on else stack.enter_context(tempfile.TemporaryDirectory(prefix="canalyze-fleet-"))
            known = known_findings(held, words) if action == "check" else {}
            given_tables = chosen if action == "export" else ()
            work = Work(action, job, held, known, output, given_tables, device_from or "", force, scratch)
            every = listing.captures(sources, output, beside=work.beside)
            captures = [one for one in every if shard is None or one.in_shard(*shard)]
            done = runs.standing(work, captures, retry=retry)
            todo = [one for one in captures if one.id not in done]
            out = stack.enter_context(open_output(None, color=color))
            progress = Progress(words, out, None, until_output=True)
            interrupt = stack.enter_context(Interrupt())
            if todo:
                executor = _executor(on, work, min(workers or _processors(), len(todo)), seconds, megabytes, interrupt)
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
            done |= runs.standing(work, [one for one in todo if one.id not in done], retry=retry)
            complain(f"canalyze: {words('fleet.broken_off', done=len(done), files=len(captures))}")
            return 128 + interrupt.signal
        manifests = [done[one.id] for one in captures]
        name = action if shard is None else f"{action}-{shard[0]}-of-{shard[1]}"
        reports = summary.write(action, manifests, place(output), name, words, html=html)
        summary.show(action, manifests, out, words, whole=False)
        said = words("fleet.done", files=len(captures), before=len(captures) - len(todo))
        out.text(said + words("fleet.reports", where=output, names=words("fleet.then").join(reports)) + "\n")
        if any(one.failed for one in manifests):
            return 3
        return 1 if action == "check" and any(one.findings for one in manifests) else 0

    return Command(
        "fleet",
        words,
        run,
        [
            click.Argument(["action"], type=OneOf(_ACTIONS, words), metavar="|".join(_ACTIONS)),
            click.Argument(["sources"], nargs=-1, type=ANY_PATH, metavar="SOURCE..."),
            click.Option(["-o", "--output"], type=ANY_PATH, metavar="OUT", help=words("fleet.output")),
            spelled(words, "--workers", positive, "positive", "N", "fleet.workers"),
            spelled(words, "--shard", _shard, "shard", "K/N", "fleet.shard"),
            spelled(words, "--on", _engine, "engine", "ENGINE", "fleet.on"),
            spelled(words, "--timeout seconds", positive, "positive", "S", "fleet.timeout"),
            spelled(words, "--memory megabytes", positive, "positive", "MB", "fleet.memory"),
            click.Option(["--retry"], is_flag=True, help=words("fleet.retry")),
            click.Option(["--html"], is_flag=True, help=words("fleet.html")),
            click.Option(["--force"], is_flag=True, help=words("fleet.force")),
            *judging_options(words),
            table_option(words),
            click.Option(["--signals"], metavar="GLOBS", help=words("signals.select")),
            spelled(words, "--device-from", _group, "group", "REGEX", "fleet.device_from"),
            time_option(words),
            color_option(words),
            bitrate_option(words),
            *(option for option in reading_options(words) if option.name not in ("merge", "threads")),
        ],
    )


def _group(text: str) -> str | None:
    """Read a regular expression with a group."""
    try:
        return text if re.compile(text).groups else None
    except re.error:
        return None


def _shard(text: str) -> tuple[int, int] | None:
    """Read K/N, K from 1 to N."""
    number, of = (positive(part) for part in text.partition("/")[::2])
    return (number, of) if number and of and number <= of else None


def _engine(text: str) -> tuple[str, str | None] | None:
    """Read ENGINE or ENGINE=ADDRESS."""
    name, equals, address = text.partition("=")
    return (name, address or None) if name in _ENGINES and (address or not equals) else None


def _agree(
    action: str, sources: Sequence[str], output: str | None, words: Words, *, expect: str | None, no_expect: bool
) -> None:
    """Say what is missing, and what does not go together."""
    context = click.get_current_context()
    given = {param.name: param for param in context.command.params}
    typed = click.core.ParameterSource.COMMANDLINE
    stray = [name for name, of in _OF.items() if of != action and context.get_parameter_source(name) == typed]
    if not sources:
        raise click.UsageError(words("usage.missing", what="SOURCE"), context)
    if output is None:
        raise click.UsageError(words("fleet.no_output"), context)
    if stray:
        option = given[stray[0]].opts[0]
        raise click.UsageError(words("fleet.other", option=option, action=_OF[stray[0]]), context)
    if expect is not None and no_expect:
        raise click.UsageError(words("usage.exclusive", one="--expect", other="--no-expect"), context)


def _executor(
    on: tuple[str, str | None] | None, work: Any, width: int, seconds: int | None, megabytes: int | None, interrupt: Any
) -> Any:
    """Give what does the work: processes of this machine, or an engine."""
    from canalyze.fleet.task import do
    from canalyze.running.pool import Pool

    one = partial(do, work)
    if on is None:
        return Pool(one, width, seconds=seconds, megabytes=megabytes, during=interrupt.during)
    from canalyze.fleet.clusters import ENGINES, Beside

    beside = Beside(one, seconds, megabytes)
    return ENGINES[on[0]](beside, on[1], width, interrupt.during)


def _processors() -> int:
    from canalyze.running.pool import processors

    return processors()


def _far(count: int, total: int, seconds: float, words: Words) -> str:
    rate = count / max(seconds, 1e-3)
    left = round((total - count) / rate)
    clock = f"{left // 3600}:{left // 60 % 60:02}:{left % 60:02}"
    return words("fleet.progress", done=count, total=total, rate=f"{rate:.1f}", left=clock)
