"""Judging as the command line asks for it, for `check` and `fleet`: options, the policy in force, the baseline.

The baseline is read, and rewritten; its entries that no longer occur are reported. Must not: read a capture.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import click

from canalyze.check import baseline, policy
from canalyze.check.examination import Job
from canalyze.check.policy import Policy
from canalyze.check.verdict import Examined
from canalyze.configuration.options import ANY_PATH, CoreUsageError, configured, option, reading_of, usage
from canalyze.errors import ConfigError
from canalyze.output import FileOutput, complain
from canalyze.sources.file import STDIN
from canalyze.words import Words


def _codes(text: str) -> object:
    from canalyze._core import codes

    return codes(text)


JUDGING: Final = (
    option("--fail-on", choices=policy.THRESHOLDS, key="check.fail_on", usual=0),
    option("--select", "CODE,...", _codes, "codes", key="check.select", topic="chosen", usual=3, multiple=True),
    option("--ignore", "CODE,...", _codes, "codes", key="check.ignore", multiple=True),
    option("--baseline", "FILE", key="check.baseline", usual=0, type=ANY_PATH),
    option("--expect", "FILE", key="check.expect", type=ANY_PATH),
    option("--no-expect", key="check.no_expect"),
    option("--problems incidents", choices=policy.STANDINGS, key="check.by_problems"),
)
"""Options for the findings that count."""


def held_policy(given: Mapping[str, Any], words: Words) -> Policy:
    """Returns what holds by options and canalyze.toml; codes that no rule has are an error in the one or the other."""
    from canalyze._core import rules

    filed = configured().check or Policy()
    asked = Policy(
        given["fail_on"],
        sum(given["select"], ()),
        sum(given["ignore"], ()),
        given["baseline"],
        incidents=given["incidents"],
    )

    catalogue = [rule.code for rule in rules(words.lang)]

    def facts(prefix: str) -> dict[str, object]:
        return {"value": prefix, "near": words("usage.or").join(policy.near(prefix, catalogue))}

    for name, prefixes in (("--select", asked.select), ("--ignore", asked.ignore)):
        if wrong := policy.unknown(prefixes, catalogue):
            raise usage(words, "usage.no_rule", option=name, **facts(wrong))
    places = dict(filed.at)
    chosen = (("select", filed.select), ("ignore", filed.ignore))
    filed_codes = [(f"check.{key}", prefixes, places.get(key, "")) for key, prefixes in chosen]
    filed_codes += [("check.override.codes", override.codes, override.at) for override in filed.overrides]
    for key, prefixes, at in filed_codes:
        if wrong := policy.unknown(prefixes, catalogue):
            raise ConfigError("config.no_rule", file=at, key=key, **facts(wrong))
    return filed.overruled(asked)


def known_findings(held: Policy, words: Words, *, update: bool = False) -> baseline.Baseline:
    """Reads the baseline; one that is to be written anew need not be there."""
    if held.baseline is None:
        if update:
            raise usage(words, "check.no_baseline")
        return {}
    if not update:
        return baseline.read(held.baseline)
    if not baseline.replaceable(held.baseline):
        raise ConfigError("baseline.other", file=held.baseline)
    return {}


def job_of(given: Mapping[str, Any], held: Policy, words: Words, settings: Mapping[str, Any]) -> Job:
    """Returns how captures are examined, once the core has accepted it; settings: as of `Job`."""
    expect, none = given["expect"], given["no_expect"]
    if expect is not None and none:
        raise usage(words, "usage.exclusive", one="--expect", other="--no-expect")
    settings = {"filter": given["expression"], "stamps": given["stamps"], **settings}
    reading = reading_of(given)
    reading["merge"] = False
    job = Job(words.lang, reading, configured().known, settings, expect, not none, held.incidents is not None)
    try:
        job.know(words)
        job.open(STDIN)
    except ValueError as error:
        raise CoreUsageError(str(error), click.get_current_context()) from error
    return job


_STALE: Final = 5
"""Entries of the baseline that no longer occur and are named."""


def updated(held: policy.Policy, examined: Sequence[Examined], words: Words, *, whole: bool) -> baseline.Baseline:
    """Writes the baseline again from all that would fail; not if something was not read, since that would be lost."""
    name = held.baseline or ""
    if not whole:
        complain(f"canalyze: {words('baseline.kept', name=name)}")
        return baseline.read(name) if Path(name).exists() else {}
    verdicts = [policy.judge(one, held, {}) for one in examined]
    known = baseline.most(
        policy.counted(verdict.failures) + policy.problems(policy.failing(held, verdict.incidents))
        for verdict in verdicts
    )
    with FileOutput(name, force=True) as out:
        out.write(baseline.text(known).encode())
    complain(f"canalyze: {words('baseline.written', name=name, count=len(known))}")
    return known


def report_stale(held: policy.Policy, known: baseline.Baseline, examined: Sequence[Examined], words: Words) -> None:
    """Reports which entries of the baseline no longer occur, or not as often."""
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
