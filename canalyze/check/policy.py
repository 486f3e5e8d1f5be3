"""Findings of a capture that count: the values behind [check] of canalyze.toml and behind the options of `check`.

Values and their rules only: nothing here opens a file, prints, or knows the core. Whether a code exists, whoever has
the catalogue says.
"""

import os
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from functools import cache
from pathlib import PurePath
from typing import Final, Literal, NamedTuple, get_args

from msgspec.structs import replace

from canalyze.check.baseline import Baseline, Kind, ProblemKind
from canalyze.check.verdict import Counted, Examined, Verdict
from canalyze.records import SEVERITIES, Severity
from canalyze.records.problems import Problem

Threshold = Severity | Literal["never"]
THRESHOLDS: Final[tuple[Threshold, ...]] = (*reversed(SEVERITIES), "never")
"""Values of --fail-on."""
Standing = Literal["open", "ended", "never"]
STANDINGS: Final[tuple[Standing, ...]] = get_args(Standing)
"""Values of --problems: which problems fail; `never`: they are only told."""
_FAILING: Final[dict[Standing, tuple[str, ...]]] = {
    "open": ("open",),
    "ended": ("open", "unknown", "ended"),
    "never": (),
}
FORMER: Final[dict[str, Standing]] = {"stands": "open", "over": "ended", "never": "never"}
"""Former spellings."""
Ruling = Severity | Literal["ignore"]
"""Severities that an override may give to a finding."""


def unknown(prefixes: Collection[str], catalogue: Sequence[str]) -> str | None:
    """Returns the first that begins no code of the catalogue."""
    return next((one for one in prefixes if not any(code.startswith(one) for code in catalogue)), None)


def near(prefix: str, catalogue: Sequence[str]) -> list[str]:
    """Returns similar codes, or families of codes."""
    from difflib import get_close_matches

    families = list(dict.fromkeys(code[:3] for code in catalogue))
    if len(prefix) > 3 and prefix[:3] in families:
        return get_close_matches(prefix, [code for code in catalogue if code.startswith(prefix[:3])], cutoff=0)
    return get_close_matches(prefix[:3], families, cutoff=0.3) or families


class Override(NamedTuple):
    """A change of some findings, with its reason: [[check.override]]."""

    codes: tuple[str, ...]
    severity: Ruling
    reason: str
    files: tuple[str, ...] = ()
    """Globs; none is every file."""
    nodes: tuple[int, ...] = ()
    """None is every node, and what is about no node."""
    bus: str | None = None
    """None is every bus."""
    at: str = ""
    """FILE:LINE of its codes."""

    def covers(self, found: Counted, file: str, directory: str) -> bool:
        """Returns true if it applies to a finding of this file; globs are relative to the directory."""
        finding = found.finding
        return (
            any(finding.code.startswith(prefix) for prefix in self.codes)
            and (not self.nodes or finding.node in self.nodes)
            and (self.bus is None or self.bus == finding.bus)
            and (not self.files or any(named(file, glob, directory) for glob in self.files))
        )


class Policy(NamedTuple):
    """All that was said in one place; `Policy().overruled(...)` of both is what holds."""

    fail_on: Threshold | None = None
    """The least severity that fails; None: warning."""
    select: tuple[str, ...] = ()
    """Codes, or their beginnings, of what is judged; none is all."""
    ignore: tuple[str, ...] = ()
    """Those of what is not."""
    baseline: str | None = None
    """The file of known findings."""
    overrides: tuple[Override, ...] = ()
    directory: str = "."
    """The directory that globs of overrides are relative to: that of canalyze.toml."""
    at: tuple[tuple[str, str], ...] = ()
    """FILE:LINE of `select` and `ignore`, by their keys."""
    incidents: Standing | None = None
    """Which problems fail; None: they are not asked for."""

    def overruled(self, by: "Policy") -> "Policy":
        """Returns the combination: `by` sets the threshold, the selection and the baseline, and adds to `ignore`."""
        return self._replace(
            fail_on=by.fail_on or self.fail_on,
            select=by.select or self.select,
            ignore=(*self.ignore, *by.ignore),
            baseline=by.baseline or self.baseline,
            incidents=by.incidents or self.incidents,
        )

    def fails(self, severity: Severity) -> bool:
        """Returns true if findings of this severity fail the check."""
        threshold = self.fail_on or "warning"
        return threshold != "never" and SEVERITIES.index(severity) >= SEVERITIES.index(threshold)

    def takes(self, code: str) -> bool:
        """Returns true if findings of this rule are judged: the longest of several prefixes counts, then `ignore`."""
        ignored = max((len(one) for one in self.ignore if code.startswith(one)), default=-1)
        selected = max((len(one) for one in self.select if code.startswith(one)), default=-1 if self.select else 0)
        return selected > ignored


def judge(examined: Examined, policy: Policy, known: Baseline) -> Verdict:
    """Returns the findings that fail the check: at or above the threshold, and more than the baseline allows."""
    ruled, away, reasons = _ruled(policy, examined.found, examined.file)
    judged = [one for one in ruled if one.finding.because_of is None]
    counts = counted(one for one in judged if policy.fails(one.finding.severity))
    failures: list[Counted] = []
    others: list[Counted] = []
    for one in judged:
        if not policy.fails(one.finding.severity):
            others.append(one)
            continue
        kind = Kind.of(one.finding)
        allowed = known.get(kind, 0)
        (failures if counts[kind] > allowed else others).append(replace(one, known=allowed, alike=counts[kind]))
    unlinked = [one for one in ruled if one.finding.because_of is not None]
    bad = failing(policy, examined.incidents)
    of_kind = problems(bad)
    allowed_problems = {one.id: known[ProblemKind.of(one)] for one in bad if ProblemKind.of(one) in known}
    failures, unlinked = _linked(failures, unlinked)
    others, unlinked = _linked(others, unlinked)
    return Verdict(
        examined.file,
        tuple(failures),
        tuple(others),
        tuple(unlinked),
        away,
        examined.error,
        examined.complaints,
        examined.frames,
        examined.seconds,
        tuple(sorted(reasons.items())),
        examined.expectations,
        examined.nature,
        examined.incidents,
        tuple(one.id for one in bad if of_kind[ProblemKind.of(one)] > allowed_problems.get(one.id, 0)),
        allowed_problems,
    )


def failing(policy: Policy, incidents: Iterable[Problem]) -> list[Problem]:
    """Returns the problems that fail a check without a baseline: those without a cause, by their status."""
    return [one for one in incidents if one.is_root and one.status in _FAILING[policy.incidents or "never"]]


def problems(incidents: Iterable[Problem]) -> Counter[Kind | ProblemKind]:
    """Counts the problems by kind, as a baseline has them."""
    return Counter(ProblemKind.of(one) for one in incidents)


def _linked(causes: Sequence[Counted], consequences: Sequence[Counted]) -> tuple[list[Counted], list[Counted]]:
    """Returns the causes with their consequences, and the consequences without a cause.

    The first cause that stands at the frame, or is about it, explains a consequence.
    """
    first: dict[int | None, int] = {}
    for place, cause in enumerate(causes):
        for finding in cause.shown:
            first.setdefault(finding.frame, place)
            first.setdefault(finding.cause_frame, place)
    first.pop(None, None)
    linked: dict[int, list[Counted]] = {}
    for one in consequences:
        if one.finding.because_of in first:
            linked.setdefault(first[one.finding.because_of], []).append(one)
    with_theirs = [replace(cause, consequences=tuple(linked.get(place, ()))) for place, cause in enumerate(causes)]
    return with_theirs, [one for one in consequences if one.finding.because_of not in first]


def counted(found: Iterable[Counted]) -> Counter[Kind | ProblemKind]:
    """Counts the findings by kind, as a baseline has them: expectations move in their file, so all of them are one.

    Consequences are in no baseline, since they cannot fail.
    """
    counts: Counter[Kind | ProblemKind] = Counter()
    for one in found:
        if one.finding.because_of is None:
            counts[Kind.of(one.finding)] += one.count
    return counts


def _ruled(policy: Policy, found: Sequence[Counted], file: str) -> tuple[list[Counted], int, Counter[str]]:
    """Returns the judged findings with severities, the number of others, and the numbers of overridden, by reason.

    Of several overrides that are about a finding the last one counts.
    """
    judged: list[Counted] = []
    away = 0
    reasons: Counter[str] = Counter()
    for one in found:
        if not policy.takes(one.finding.code):
            away += one.count
            continue
        about = [override for override in policy.overrides if override.covers(one, file, policy.directory)]
        # A consequence is info, whatever its rule is worth: it can only be left out.
        if not about or (one.finding.because_of is not None and about[-1].severity != "ignore"):
            judged.append(one)
            continue
        override = about[-1]
        reasons[override.reason] += one.count
        if override.severity == "ignore":
            away += one.count
            continue
        shown = tuple(replace(finding, severity=override.severity) for finding in one.shown)
        judged.append(replace(one, finding=shown[0], shown=shown))
    return judged, away, reasons


@cache
def named(file: str, glob: str, directory: str) -> bool:
    """Returns true if a glob matches a file: its name as given, its path from the directory, or its last part."""
    from canalyze.sources.names import matching  # not needed where a policy is only read

    names = [file, PurePath(file).as_posix(), _from(file, directory)]
    if "/" not in glob:
        names.append(PurePath(file).name)
    wanted = matching(glob.removeprefix("./"))
    return any(wanted.fullmatch(name.removeprefix("./")) for name in names)


def _from(file: str, directory: str) -> str:
    try:
        return PurePath(os.path.relpath(file, directory)).as_posix()
    except ValueError:  # another drive
        return file
