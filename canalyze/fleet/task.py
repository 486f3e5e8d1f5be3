"""One capture -> its manifest: what a worker does, on this machine or another. All that it needs can be sent there.

What is done already is not done again, also where an engine has a task run twice. Must not: try again, or print.
"""

import hashlib
import json
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic
from typing import Any, Final, Literal, NamedTuple

from canalyze import __version__
from canalyze.check import policy
from canalyze.check.baseline import Baseline
from canalyze.check.examination import Job, examine, read
from canalyze.check.policy import Policy
from canalyze.check.verdict import Verdict
from canalyze.check.workers import Far
from canalyze.configuration.options import known_of
from canalyze.errors import SourceError
from canalyze.fleet import manifest, stored
from canalyze.fleet.manifest import Manifest
from canalyze.fleet.sources import Capture, content, fetched, stamp
from canalyze.fleet.stores import place
from canalyze.running.pool import Tell

Action = Literal["check", "summary"]


@dataclass
class Work:
    """What is done with every capture, alike everywhere."""

    action: Action
    job: Job
    policy: Policy
    known: Baseline
    """What of the findings is known."""
    out: str
    """Where the results go: a folder or a URL."""
    force: bool = False
    """Whether what is done is done again."""
    scratch: str | None = None
    """A folder for what is fetched; None: the one of the machine."""
    settings: str = ""
    """Hash of the options, of the configuration, and of the files that they name."""

    def __post_init__(self) -> None:
        """Hash what a result depends on, beside the capture and the program."""
        said = [self.action, self.job.__getstate__(), self.policy, sorted(self.known.items(), key=repr)]
        digest = hashlib.sha256(repr(said).encode("utf-8", "surrogateescape"))
        files = [one.file for known in (self.job.filed, known_of(self.job.given)) for one in known.descriptions]
        for file in [*files, *filter(None, [self.job.expect])]:
            try:
                digest.update(hashlib.sha256(Path(file).read_bytes()).digest())
            except OSError as error:
                raise SourceError("source.open", name=file, error=error) from error
        self.settings = digest.hexdigest()[:32]

    @property
    def beside(self) -> bool:
        """Whether expectations beside a capture count."""
        return self.action == "check" and self.job.beside and self.job.expect is None


class Piece(NamedTuple):
    """A capture, and how often it was tried with this time."""

    capture: Capture
    attempt: int = 1


class Result(NamedTuple):
    """What came of reading a capture."""

    error: str | None
    frames: int
    findings: int
    stored: Any
    """As JSON."""


def do(work: Work, piece: Piece, tell: Tell) -> Manifest:
    """Work on a capture and leave its manifest.

    SourceError where the capture does not come, OutputError where the manifest cannot be written: nothing is done then.
    """
    began = monotonic()
    capture, to = piece.capture, place(work.out)
    before = None if work.force else manifest.read(to, work.action, capture.id)
    if before is not None and (before.failed or not before.holds(__version__, work.settings)):
        before = None
    now = tag = capture.stamp
    if capture.store is None:
        now = stamp(capture.path, beside=work.beside)
        tag = before.content if before and before.stamp == now else content(capture.path, beside=work.beside)
    if before is not None and tag and before.content == tag:
        if before.stamp != now:
            before = replace(before, stamp=now)
            manifest.write(to, work.action, before)
        return before
    with fetched(capture, work.scratch) if capture.store else nullcontext((capture.path, tag)) as (path, came):
        found = _ACTIONS[work.action](work, path, capture, tell)
    done = Manifest(
        capture.name,
        capture.id,
        came,
        came if capture.store else now,
        __version__,
        work.settings,
        None if found.error is None else "unreadable",
        found.error,
        piece.attempt,
        found.frames,
        found.findings,
        round(monotonic() - began, 3),
        found.stored,
    )
    manifest.write(to, work.action, done)
    return done


def _check(work: Work, path: str, capture: Capture, tell: Tell) -> Result:
    job = replace(work.job, beside=work.beside and capture.store is None)
    examined = examine(path, job, Far(tell), capture.name)
    if examined.signal:  # the end was wished: a part would pass for all of it
        raise SystemExit(128 + examined.signal)
    verdict = policy.judge(examined, work.policy, work.known)
    findings = sum(one.count for one in verdict.failures) + len(verdict.problems)
    return Result(verdict.error, verdict.frames, findings, stored.row(verdict))


def _summary(work: Work, path: str, capture: Capture, tell: Tell) -> Result:
    took: list[bytes] = []
    done = read(path, replace(work.job, beside=False), Far(tell), took.append, form="summary", shown=capture.name)
    if done.signal:
        raise SystemExit(128 + done.signal)
    records = [json.loads(line) for line in b"".join(took).splitlines()]
    findings = sum(one["count"] for one in records if one["kind"] == "summary_finding")
    return Result(done.error, done.session.frames if done.session else 0, findings, records)


_ACTIONS: Final = {"check": _check, "summary": _summary}


def verdict_of(action: Action, done: Manifest) -> Verdict:
    """Give what came of a capture as reports have it."""
    if action == "check" and done.result is not None:
        return replace(stored.verdict(done.result), file=done.capture)
    return Verdict(done.capture, error=done.error, frames=done.frames, seconds=done.seconds)


def records_of(done: Manifest) -> list[Mapping[str, Any]]:
    """Give the records of a summary."""
    return done.result or []
