"""`canalyze check`: captures as regression tests, each by itself.

What a finding is, the core says; what counts, `policy`; how it is written, `reports`.

Exit codes: 0 nothing fails, 1 findings fail, 2 something could not be read.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from typing import Final, Unpack

import click

from canalyze.check import baseline, policy
from canalyze.check.examination import Job
from canalyze.check.verdict import Examined, Verdict
from canalyze.configuration.config import Config
from canalyze.configuration.options import (
    ANY_PATH,
    CaptureOptions,
    CoreUsageError,
    OneOf,
    bitrate_option,
    capture_options,
    clock,
    color_option,
    format_option,
    inputs,
    known_of,
    spelled,
    time_option,
)
from canalyze.errors import ConfigError, ReaderGone
from canalyze.output import FileOutput, Output, Progress, complain, open_output
from canalyze.output.help import Listing
from canalyze.sources.file import STDIN, total_size
from canalyze.sources.names import Named, expanded
from canalyze.words import Words

_STALE: Final = 5
"""Entries of the baseline that no longer occur and are named."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        form: str,
        junit: str | None,
        sarif: str | None,
        code_quality: str | None,
        markdown: str | None,
        update_baseline: bool,
        output: str | None,
        force: bool,
        expression: str | None,
        time: str | None,
        color: str,
        stamps: str,
        fail_on: policy.Threshold | None,
        select: tuple[tuple[str, ...], ...],
        ignore: tuple[tuple[str, ...], ...],
        baseline: str | None,
        expect: str | None,
        no_expect: bool,
        incidents: policy.Standing | None,
        **given: Unpack[CaptureOptions],
    ) -> int:
        from canalyze.check.workers import examine_all

        given["merge"] = False
        config = click.get_current_context().find_object(Config) or Config()
        asked = policy.Policy(fail_on, sum(select, ()), sum(ignore, ()), baseline, incidents=incidents)
        held = held_policy(config.check or policy.Policy(), asked, words)
        known = known_findings(held, words, update=update_baseline)
        if expect is not None and no_expect:
            problem = words("usage.exclusive", one="--expect", other="--no-expect")
            raise click.UsageError(problem, click.get_current_context())
        # Reports in files have the times of the capture, whatever a terminal shows.
        alone = not (junit or sarif or code_quality or markdown)
        settings = {"filter": expression, "stamps": stamps, "time": clock(time, form, output) if alone else time}
        job = tried(
            Job(words.lang, given, config.known, settings, expect, not no_expect, held.incidents is not None), words
        )
        named = list(expanded(inputs(files, words)))
        names = [one.name for one in named if one.error is None]
        with open_output(output, force=force, color=color, hangs=form == "text") as out:
            with ExitStack() as stack:
                named_reports = {"junit": junit, "sarif": sarif, "code-quality": code_quality, "markdown": markdown}
                reports = _reports(named_reports, stack, words, force=force)
                progress = Progress(words, out, total_size(tuple(names)), until_output=True)
                found, signal = examine_all(names, job, progress) if names else ([], 0)
                progress.clear()
                examined = _all(named, found, words)
                _say(examined, [one.file for known in (config.known, known_of(given)) for one in known.descriptions])
                read = not any(one.error for one in examined)
                if update_baseline:
                    known = _update(held, examined, words, whole=read and not signal)
                elif read and not signal:
                    _stale(held, known, examined, words)
                verdicts = [policy.judge(one, held, known) for one in examined]
                for report, document in reports:
                    if signal:  # half a set would pass for a whole one
                        report.drop()
                    else:
                        report.write(document(verdicts))
            if signal:
                complain(f"canalyze: {words('check.broken_off', count=len(names) - _whole(found))}")
                out.drop()
            with suppress(ReaderGone):  # who has read enough has not passed the check
                _write(form, verdicts, out, words)
        if signal:
            return 128 + signal
        return 2 if not read else 1 if any(verdict.failed for verdict in verdicts) else 0

    return Listing(
        "check",
        words,
        run,
        [
            *judging_options(words),
            click.Option(["--update-baseline"], is_flag=True, help=words("check.update_baseline")),
            format_option(words, "check", ("text", "jsonl", "github", "markdown")),
            time_option(words, "opt.clock"),
            color_option(words),
            click.Option(["--junit"], type=ANY_PATH, metavar="FILE", help=words("check.junit")),
            click.Option(["--sarif"], type=ANY_PATH, metavar="FILE", help=words("check.sarif")),
            click.Option(["--code-quality"], type=ANY_PATH, metavar="FILE", help=words("check.code_quality")),
            click.Option(["--markdown"], type=ANY_PATH, metavar="FILE", help=words("check.markdown")),
            bitrate_option(words),
            *(option for option in capture_options(words) if option.name != "merge"),
        ],
    )


def judging_options(words: Words) -> list[click.Parameter]:
    """Give what says which findings count."""
    from canalyze._core import codes

    return [
        click.Option(["--fail-on"], type=OneOf(policy.THRESHOLDS, words), help=words("check.fail_on")),
        spelled(words, "--select", codes, "codes", "CODE,...", "check.select", multiple=True),
        spelled(words, "--ignore", codes, "codes", "CODE,...", "check.ignore", multiple=True),
        click.Option(["--baseline"], type=ANY_PATH, metavar="FILE", help=words("check.baseline")),
        click.Option(["--expect"], type=ANY_PATH, metavar="FILE", help=words("check.expect")),
        click.Option(["--no-expect"], is_flag=True, help=words("check.no_expect")),
        click.Option(["--problems", "incidents"], type=OneOf(policy.STANDINGS, words), help=words("check.by_problems")),
    ]


def held_policy(filed: policy.Policy, asked: policy.Policy, words: Words) -> policy.Policy:
    """Give what holds; codes that no rule has are a mistake of whoever wrote them."""
    from canalyze._core import rules

    catalogue = [rule.code for rule in rules(words.lang)]

    def facts(prefix: str) -> dict[str, object]:
        return {"value": prefix, "near": words("usage.or").join(policy.near(prefix, catalogue))}

    for option, prefixes in (("--select", asked.select), ("--ignore", asked.ignore)):
        if wrong := policy.unknown(prefixes, catalogue):
            raise click.UsageError(words("usage.no_rule", option=option, **facts(wrong)), click.get_current_context())
    places = dict(filed.at)
    filed_codes = [(f"check.{key}", prefixes, places.get(key, "")) for key, prefixes in _chosen(filed)]
    filed_codes += [("check.override.codes", override.codes, override.at) for override in filed.overrides]
    for key, prefixes, at in filed_codes:
        if wrong := policy.unknown(prefixes, catalogue):
            raise ConfigError("config.no_rule", file=at, key=key, **facts(wrong))
    return filed.overruled(asked)


def _chosen(filed: policy.Policy) -> list[tuple[str, tuple[str, ...]]]:
    return [("select", filed.select), ("ignore", filed.ignore)]


def known_findings(held: policy.Policy, words: Words, *, update: bool = False) -> baseline.Baseline:
    """Read the baseline; one that is to be written anew need not be there."""
    if held.baseline is None:
        if update:
            raise click.UsageError(words("check.no_baseline"), click.get_current_context())
        return {}
    if not update:
        return baseline.read(held.baseline)
    if not baseline.replaceable(held.baseline):
        raise ConfigError("baseline.other", file=held.baseline)
    return {}


def tried(job: Job, words: Words) -> Job:
    """Make sure that the core accepts what it will be told, before any capture is read."""
    try:
        job.know(words)
        job.open(STDIN)
    except ValueError as error:
        raise CoreUsageError(str(error), click.get_current_context()) from error
    return job


def _reports(
    names: Mapping[str, str | None], stack: ExitStack, words: Words, *, force: bool
) -> list[tuple[Output, Callable[[Sequence[Verdict]], bytes]]]:
    """Open the files of reports, by the names of their options, and give how each is written."""

    def as_junit(verdicts: Sequence[Verdict]) -> bytes:
        from canalyze.reports import junit

        return junit.document(verdicts, words)

    def as_sarif(verdicts: Sequence[Verdict]) -> bytes:
        from canalyze._core import rules
        from canalyze.reports import sarif

        return sarif.document(verdicts, rules(words.lang), words)

    def as_code_quality(verdicts: Sequence[Verdict]) -> bytes:
        from canalyze.reports import code_quality

        return code_quality.document(verdicts, words)

    def as_markdown(verdicts: Sequence[Verdict]) -> bytes:
        from canalyze.reports import markdown

        return "".join(f"{line}\n" for line in markdown.lines(verdicts, words)).encode("utf-8", "backslashreplace")

    writers = {"junit": as_junit, "sarif": as_sarif, "code-quality": as_code_quality, "markdown": as_markdown}
    for option in (option for option, name in names.items() if name == STDIN):
        problem = words("check.no_stdout", option=f"--{option}")
        raise click.UsageError(problem, click.get_current_context())
    return [
        (stack.enter_context(FileOutput(name, force=force)), writers[option])
        for option, name in names.items()
        if name is not None
    ]


def _whole(found: Sequence[Examined | None]) -> int:
    """Count what was read to its end."""
    return sum(1 for one in found if one is not None and not one.signal)


def _all(named: Sequence[Named], found: Sequence[Examined | None], words: Words) -> list[Examined]:
    """Put what was examined, and what there is none of, in the order in which it was named."""
    waiting = iter(found)
    every: list[Examined] = []
    for one in named:
        if one.error is not None:
            reason = one.error.in_words(words)
            every.append(Examined(one.name, error=reason, complaints=(f"canalyze: {reason}",)))
        elif (examined := next(waiting)) is not None:
            every.append(examined)
    return every


def _say(examined: Sequence[Examined], descriptions: Sequence[str]) -> None:
    """Hand on what is complained of.

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
                    complain(line)
                    said.add(line)
            else:
                complain(line)


def _update(held: policy.Policy, examined: Sequence[Examined], words: Words, *, whole: bool) -> baseline.Baseline:
    """Write the baseline anew, of what would fail; not where something was not read, since that would be forgotten."""
    name = held.baseline or ""
    if not whole:
        complain(f"canalyze: {words('baseline.kept', name=name)}")
        return baseline.read(name) if baseline.exists(name) else {}
    verdicts = [policy.judge(one, held, {}) for one in examined]
    known = baseline.most(
        policy.counted(verdict.failures) + policy.problems(policy.failing(held, verdict.incidents))
        for verdict in verdicts
    )
    with FileOutput(name, force=True) as out:
        out.write(baseline.text(known).encode())
    complain(f"canalyze: {words('baseline.written', name=name, count=len(known))}")
    return known


def _stale(held: policy.Policy, known: baseline.Baseline, examined: Sequence[Examined], words: Words) -> None:
    """Say which entries of the baseline no longer occur, or not as often."""
    most = baseline.most(
        policy.counted(capture.found) + policy.problems(policy.failing(held, capture.incidents)) for capture in examined
    )
    judged = [kind for kind in known if isinstance(kind, baseline.Kind) or held.incidents not in (None, "never")]
    gone = sorted((kind for kind in judged if most.get(kind, 0) < known[kind]), key=lambda kind: kind.order)
    for kind in gone[:_STALE]:
        whose = (
            kind.subject
            if isinstance(kind, baseline.ProblemKind)
            else kind.node and words("check.node", node=kind.node)
        )
        where = [kind.bus, whose, kind.object]
        shown = " ".join([kind[0], words("check.then").join(str(part) for part in where if part)]).rstrip()
        key = "baseline.fewer" if kind in most else "baseline.gone"
        said = words(key, name=held.baseline, entry=shown, count=most.get(kind, 0), known=known[kind])
        complain(f"canalyze: {said}")
    if len(gone) > _STALE:
        complain(f"canalyze: {words('baseline.more_gone', name=held.baseline, count=len(gone) - _STALE)}")


def _write(form: str, verdicts: Sequence[Verdict], out: Output, words: Words) -> None:
    if form == "text":
        from canalyze.reports import check_text

        check_text.show(verdicts, out, words)
        return
    if form == "jsonl":
        from canalyze.reports import check_jsonl

        lines = check_jsonl.lines(verdicts)
    elif form == "markdown":
        from canalyze.reports import markdown

        lines = markdown.lines(verdicts, words)
    else:
        from canalyze.reports import github

        lines = github.lines(verdicts, words)
    for line in lines:
        out.write(f"{line}\n".encode("utf-8", "backslashreplace"))
