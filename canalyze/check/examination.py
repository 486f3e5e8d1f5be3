"""Captures examined, and judged as the command line asks for it, for `check` and `fleet`.

Captures are read through sessions of their own, their findings typed and counted by kind. As many at once as there are
processors: the same work is done in this process and in others, so all that it needs can be sent there and all that
comes of it can be sent back. A process that dies is an error of its capture only. Standard input, and a capture that is
alone, are examined in this process. Beside it, the options, the policy in force and the baseline, which is read and
rewritten; its entries that no longer occur are reported.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from msgspec import Struct, field
from msgspec.structs import astuple, replace

from canalyze import expectations
from canalyze.check import baseline, policy
from canalyze.check.baseline import Kind
from canalyze.check.policy import Policy
from canalyze.check.verdict import Counted, Examined
from canalyze.configuration import network
from canalyze.configuration.options import (
    ANY_PATH,
    CaptureOptions,
    accepted,
    configured,
    known_of,
    option,
    reading_of,
    start_session,
    usage,
)
from canalyze.errors import CanalyzeError, ConfigError
from canalyze.output import FileOutput, complain
from canalyze.records import records
from canalyze.records.problems import Finding, Problem
from canalyze.running.run import Interrupt, Meter, Run
from canalyze.sources import STDIN
from canalyze.sources.names import Named
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session
    from canalyze.running.pool import Tell

_SHOWN: Final = 10
"""Findings of one kind that are kept; further ones are counted."""
_KINDS: Final = 4096
"""Kinds that are kept apart in one capture; findings of further ones are counted by their rule."""
_LINES: Final = 200
"""Complaints that are kept of one capture."""


class Job(Struct):
    """Settings of an examination, equal in this process and in others."""

    lang: str
    given: CaptureOptions
    filed: network.Known
    """The network by canalyze.toml."""
    settings: Mapping[str, Any]
    """Other settings of the core: filter, stamps."""
    expect: str | None = None
    """A file of expectations for every capture."""
    beside: bool = True
    """Without that file, the one that lies beside a capture counts."""
    incidents: bool = False
    """True if problems are asked for."""
    _network: list[Any] = field(default_factory=list)
    """That network, once it is known."""

    def know(self, words: Words | None) -> None:
        """Reads the descriptions of the network, and reports their defects."""
        from canalyze.configuration.network import network as known

        self._network = [known(self.filed, known_of(self.given), words)]

    def settings_for(self, name: str) -> Mapping[str, Any]:
        """Returns the settings of the core for this capture, with its expectations.

        It is asked in the process that examines the capture. A CanalyzeError is an error of this capture only.
        """
        file = self.expectations_for(name)
        return self.settings if file is None else {**self.settings, "expectations": expectations.read(file)}

    def expectations_for(self, name: str) -> Path | None:
        """Returns the file of expectations of this capture."""
        if self.expect is not None:
            return Path(self.expect)
        return expectations.beside(name) if self.beside else None

    def open(self, name: str, form: str = "check") -> "Session":
        """Starts a session of that form for this capture; ValueError for settings that the core refuses."""
        if not self._network:
            self.know(None)
        settings = {"format": form, "network": self._network[0], "incidents": self.incidents, **self.settings_for(name)}
        return start_session(Words(self.lang), self.given, **settings)

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        """Leaves out what cannot be sent to another process, which reads the descriptions itself."""
        return Job, astuple(self)[:-1]


class _Kinds:
    """The findings of a capture, by kind; those of each expectation, and the consequences of each cause, are apart."""

    def __init__(self) -> None:
        self._found: dict[tuple[Kind, str | None, int | None], tuple[list[Finding], int]] = {}
        self.incidents: list[Problem] = []

    def take(self, result: bytes) -> None:
        """Adds JSON lines of the core."""
        found: Iterator[Finding | Problem] = records(result, Finding, Problem)
        for finding in found:
            if isinstance(finding, Problem):
                self.incidents.append(finding)
                continue
            kind = (Kind.of(finding), finding.expectation, finding.because_of)
            if kind not in self._found and len(self._found) >= _KINDS:
                kind = (Kind(finding.code, None, None, None), None, finding.because_of and 0)
            shown, count = self._found.get(kind, ([], 0))
            repeated = finding.facts.get("repeated")
            if repeated is None and len(shown) < _SHOWN:
                shown.append(finding)
            self._found[kind] = (shown, count + (1 if repeated is None else int(repeated)))

    def counted(self) -> tuple[Counted, ...]:
        """Returns them in the order of their frames."""
        found = [Counted(shown[0], tuple(shown), count) for shown, count in self._found.values() if shown]
        return tuple(sorted(found, key=lambda one: one.finding.about_frame or 0))


class Read(NamedTuple):
    """A capture that was read to its end, or as far as that went."""

    session: "Session | None"
    error: str | None
    """Why it, or the rest of it, could not be read."""
    complaints: tuple[str, ...]
    """Lines for standard error."""
    signal: int = 0
    """The signal that ended reading early."""


def read(
    name: str,
    job: Job,
    progress: Meter,
    take: "Callable[[Session, bytes], None]",
    *,
    form: str = "check",
    shown: str | None = None,
) -> Read:
    """Reads one capture through a session of that form; errors are in the result.

    take: gets each result of the session. shown: the capture's name.
    """
    words = Words(job.lang)
    complaints: list[str] = []

    def tell(line: str) -> None:
        if len(complaints) < _LINES:
            complaints.append(line)

    try:
        session = job.open(name, form)
    except CanalyzeError as error:  # what lies beside this capture; what holds for all was tried before
        reason = error.in_words(words)
        return Read(None, reason, (f"canalyze: {reason}",))
    run = Run(session, words, progress, partial(take, session), job.given, tell=tell, shown=shown)
    code = run.over((name,))
    return Read(session, run.failure, tuple(complaints), code - 128 if code > 128 else 0)


def examine(name: str, job: Job, progress: Meter, shown: str | None = None) -> Examined:
    """Reads one capture to its end; errors are in the result. shown: its name."""
    began = monotonic()
    kinds = _Kinds()
    done = read(name, job, progress, lambda _, result: kinds.take(result), shown=shown)
    if done.session is None:
        return Examined(shown or name, error=done.error, complaints=done.complaints)
    held_against = job.expectations_for(name)
    return Examined(
        shown or name,
        kinds.counted(),
        done.error,
        done.complaints,
        done.session.frames,
        monotonic() - began,
        None if held_against is None else str(held_against),
        done.session.nature,
        tuple(kinds.incidents),
        done.signal,
    )


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
            partial(_examined, names, job),
            min(processors(), len(names)),
            forked=True,
            progress=progressed,
            during=interrupt.during,
        )
        try:
            # The largest first, so that no process is left alone with it at the end.
            for place in sorted(range(len(names)), key=lambda place: _size(names[place]), reverse=True):
                if names[place] != STDIN:
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


def _size(name: str) -> int:
    """Returns the size of a file in bytes; 0 if it is unknown."""
    try:
        return os.stat(name).st_size  # noqa: PTH116 - pathlib is a tenth of the start
    except (OSError, ValueError):
        return 0


def _dead(name: str, by: object, job: Job) -> Examined:
    error = Words(job.lang)("check.died", name=name, by=by)
    return Examined(name, error=error, complaints=(f"canalyze: {error}",))


def _examined(names: Sequence[str], job: Job, place: int, tell: "Tell") -> Examined:
    """Does the work of a process on a capture, by its place."""
    return examine(names[place], job, Far(tell))


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
    """Reads the baseline; one that is to be written may be missing."""
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
    with accepted():
        job.know(words)
        job.open(STDIN)
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
