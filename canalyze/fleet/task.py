"""One capture -> its manifest: the work of a worker, on any machine. All its arguments can be pickled.

Finished work is not repeated, even if an engine runs a task twice. The manifest is the record of a finished capture:
one JSON object, beside the results. It is written last and atomically, so a capture is done if its manifest says so,
however the run ended. A verdict is stored as JSON and restored for reports. Must not: retry, or print.
"""

import dataclasses
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, fields
from pathlib import Path
from time import monotonic
from typing import Any, Final, Literal, NamedTuple

from msgspec import convert, to_builtins
from msgspec.structs import replace

from canalyze import __version__
from canalyze.check import policy
from canalyze.check.baseline import Baseline
from canalyze.check.examination import Far, Job, Read, examine, read
from canalyze.check.policy import Policy
from canalyze.check.verdict import Counted, Verdict
from canalyze.configuration.network import carriers
from canalyze.configuration.options import known_of
from canalyze.errors import SourceError, as_error
from canalyze.fleet.stores import Capture, Place, content, fetched, place, stamp
from canalyze.records import of_rows
from canalyze.records.problems import KEYS, Problem
from canalyze.reports.diagnosis import Diagnosed
from canalyze.running.pool import Tell
from canalyze.sources.names import unpacked

_FINDINGS: Final = ("failures", "others", "consequences")


def stored(verdict: Verdict) -> dict[str, Any]:
    """Returns a verdict for `json`. Only the first finding of each kind keeps its context lines."""
    lists: dict[str, Any] = {name: tuple(map(_bare, getattr(verdict, name))) for name in _FINDINGS}
    made: dict[str, Any] = to_builtins(replace(verdict, **lists), str_keys=True)
    return made


def _bare(one: Counted) -> Counted:
    shown = (one.shown[0], *(replace(other, lines=()) for other in one.shown[1:]))
    return replace(one, shown=shown, consequences=tuple(map(_bare, one.consequences)))


def restored(row: dict[str, Any]) -> Verdict:
    """Restores a verdict. Raises ValueError for other data."""
    return convert(row, Verdict, str_keys=True)


_FOLDER: Final = "_manifest"
_AT_ONCE: Final = 16
"""Number of manifests read concurrently, because stores have a high latency."""

Reason = Literal["unreadable", "fetch", "died", "time", "memory", "raised"]
"""Reasons for an incomplete result: the capture is damaged or none, it could not be fetched, or the worker failed."""


@dataclass(frozen=True, slots=True)
class Manifest:
    """The record of one capture."""

    capture: str
    """Its name."""
    id: str
    """The name of its objects, see `Capture.id`."""
    content: str
    """Its content: hashes of a file, or ETag and size."""
    stamp: str
    """Size, times and inode of a file, to recognize it without reading; in a store the same as `content`."""
    version: str
    """The program's."""
    settings: str
    """Hash of all options, of the configuration, and of the files that they name."""
    failed: Reason | None
    """None if all of it was read."""
    error: str | None
    """The reason in words."""
    attempts: int
    frames: int
    findings: int
    """Number of findings; for check, of those that fail it."""
    seconds: float
    """The duration of the work."""
    result: Any
    """The result, as JSON."""

    def holds(self, version: str, settings: str) -> bool:
        """Returns true if the work would be the same now, for the same capture."""
        return (self.version, self.settings) == (version, settings)


def name_of(action: str, number: str) -> str:
    """Returns the name of the object."""
    return f"{_FOLDER}/{action}/{number}.json"


def kept(place: Place, action: str, number: str) -> Manifest | None:
    """Returns the manifest of a capture; None if there is no valid one."""
    data = place.get(name_of(action, number))
    try:
        row = json.loads(data or b"")
        return Manifest(**{field.name: row[field.name] for field in fields(Manifest)})
    except (ValueError, TypeError, LookupError):
        return None


def read_all(place: Place, action: str, numbers: Sequence[str]) -> dict[str, Manifest]:
    """Returns the manifests of captures that have one."""
    there = {name.removesuffix(".json") for name in place.names(f"{_FOLDER}/{action}")}
    wanted = [number for number in numbers if number in there]
    with ThreadPoolExecutor(_AT_ONCE) as threads:
        found = threads.map(lambda number: kept(place, action, number), wanted)
        return {one.id: one for one in found if one is not None}


def keep(place: Place, action: str, manifest: Manifest) -> None:
    """Writes a manifest atomically."""
    row = {field.name: getattr(manifest, field.name) for field in fields(Manifest)}  # not `asdict`, which copies deeply
    place.put(name_of(action, manifest.id), json.dumps(row, separators=(",", ":")).encode())


Action = Literal["check", "diagnose", "summary", "export"]


@dataclass
class Work:
    """The work for every capture, the same on all workers."""

    action: Action
    job: Job
    policy: Policy
    known: Baseline
    """Findings that are known already."""
    out: str
    """The place of the results: a folder or a URL."""
    tables: tuple[str, ...] = ()
    """The tables to export, of `exporting.TABLES`."""
    device_from: str = ""
    """A regular expression whose first group in a capture's name is its device."""
    force: bool = False
    """True if finished work is repeated."""
    scratch: str | None = None
    """A folder for downloads; None: the system's temporary folder."""
    settings: str = ""
    """Hash of the options, of the configuration, of the files that they name, and of the form of what is stored."""

    def __post_init__(self) -> None:
        """Hashes everything that a result depends on except the capture and the program."""
        said: list[Any] = [self.action, self.job.__reduce__(), self.policy, sorted(self.known.items(), key=repr)]
        said += [self.tables, self.device_from, Problem.__struct_encode_fields__]
        digest = hashlib.sha256(repr(said).encode("utf-8", "surrogateescape"))
        files = [one.file for known in (self.job.filed, known_of(self.job.given)) for one in known.descriptions]
        for file in [*files, *filter(None, [self.job.expect])]:
            with as_error(SourceError, "source.open", name=file):
                digest.update(hashlib.sha256(Path(file).read_bytes()).digest())
        self.settings = digest.hexdigest()[:32]

    @property
    def beside(self) -> bool:
        """True if expectations beside a capture count."""
        return self.action == "check" and self.job.beside and self.job.expect is None


class Piece(NamedTuple):
    """A capture and the number of this attempt."""

    capture: Capture
    attempt: int = 1


class Result(NamedTuple):
    """The result of reading a capture."""

    error: str | None
    frames: int
    findings: int
    stored: Any
    """As JSON."""


def do(work: Work, piece: Piece, tell: Tell) -> Manifest:
    """Processes a capture and writes its manifest.

    Raises SourceError if the capture cannot be fetched and OutputError if the manifest cannot be written.
    """
    began = monotonic()
    capture, to = piece.capture, place(work.out)
    last = before = kept(to, work.action, capture.id)
    if before is not None and (work.force or before.failed or not before.holds(__version__, work.settings)):
        before = None
    now = tag = capture.stamp
    if capture.store is None:
        now = stamp(capture.path, beside=work.beside)
        tag = before.content if before and before.stamp == now else content(capture.path, beside=work.beside)
    if before is not None and tag and before.content == tag:
        if before.stamp != now:
            before = dataclasses.replace(before, stamp=now)
            keep(to, work.action, before)
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
    keep(to, work.action, done)
    if last is not None and work.action == "export":
        for name in set(files_of(last)) - set(files_of(done)):
            to.remove(name)
    return done


def _check(work: Work, path: str, capture: Capture, tell: Tell) -> Result:
    job = replace(work.job, beside=work.beside and capture.store is None)
    examined = examine(path, job, Far(tell), capture.name)
    if examined.signal:  # the end was wished: a part would pass for all of it
        raise SystemExit(128 + examined.signal)
    verdict = policy.judge(examined, work.policy, work.known)
    findings = sum(one.count for one in verdict.failures) + len(verdict.problems)
    return Result(verdict.error, verdict.frames, findings, stored(verdict))


def _records(work: Work, path: str, capture: Capture, tell: Tell, form: str) -> tuple[Read, list[Any]]:
    """Reads a capture through a session of a form of JSON lines."""
    took: list[bytes] = []
    job = replace(work.job, beside=False)
    done = read(path, job, Far(tell), lambda _, result: took.append(result), form=form, shown=capture.name)
    if done.signal:
        raise SystemExit(128 + done.signal)
    return done, [json.loads(line) for line in b"".join(took).splitlines()]


def _diagnose(work: Work, path: str, capture: Capture, tell: Tell) -> Result:
    done, records = _records(work, path, capture, tell, "diagnosis")
    whole = next((one for one in records if one["kind"] == "diagnosis"), None)
    if whole is None or done.session is None:
        return Result(done.error, 0, 0, None)
    problems = [{key: one[key] for key in (*KEYS, "root")} for one in records if one["kind"] == "problem"]
    findings = sum(one["root"] and one["status"] == "open" for one in problems)
    kept = {"nature": done.session.nature, "order": whole["order"], "problems": problems}
    return Result(done.error, done.session.frames, findings, kept)


def _summary(work: Work, path: str, capture: Capture, tell: Tell) -> Result:
    done, records = _records(work, path, capture, tell, "summary")
    findings = sum(one["count"] for one in records if one["kind"] == "summary_finding")
    return Result(done.error, done.session.frames if done.session else 0, findings, records)


def _export(work: Work, path: str, capture: Capture, tell: Tell) -> Result:
    """Writes the tables to a temporary place, and moves them when all are complete."""
    from canalyze.exporting import FOLDER, Target
    from canalyze.exporting.export import About, Export

    match = re.search(work.device_from, capture.name) if work.device_from else None
    device = (match[1] or "") if match else ""
    name = re.sub(r"[^\w.-]+", "_", unpacked(capture.path).stem).lstrip(".")
    about = About(f"{name}-{capture.id[:8]}", device, (capture.name,), _described(work))
    to = place(work.out)
    with to.beside(capture.id, work.scratch) as folder:
        with Export(Target(folder, FOLDER, work.tables), about) as made:
            job = replace(work.job, beside=False)
            done = read(path, job, Far(tell), made.take, form="summary", shown=capture.name)
            if done.signal:
                raise SystemExit(128 + done.signal)
            if done.session is None or not done.session.frames:
                return Result(done.error, 0, 0, {"files": [], "rows": {}, "bytes": 0})
            made.take(done.session)
            written = made.complete(to.bring)
        files = [file.relative_to(folder).as_posix() for file in written.files]
    rows = dict(written.rows)
    result: dict[str, Any] = {"files": files, "rows": rows, "bytes": written.size}
    if made.left_out:
        result["left_out"] = dict(made.left_out)
    return Result(done.error, done.session.frames, rows.get("findings", 0), result)


def _described(work: Work) -> Mapping[tuple[str | None, int], str]:
    """Returns the descriptions by the nodes that use them; they are read once."""
    if work.settings not in _CARRIED:
        known = work.job.filed, known_of(work.job.given)
        _CARRIED[work.settings] = carriers(*known, {}) if any(one.descriptions for one in known) else {}
    return _CARRIED[work.settings]


_CARRIED: Final[dict[str, Mapping[tuple[str | None, int], str]]] = {}
"""By the settings of a work."""
_ACTIONS: Final = {"check": _check, "diagnose": _diagnose, "summary": _summary, "export": _export}


def verdict_of(action: Action, done: Manifest) -> Verdict:
    """Returns the result of a capture as a verdict for reports."""
    if action == "check" and done.result is not None:
        return restored({**done.result, "file": done.capture})
    return Verdict(done.capture, error=done.error, frames=done.frames, seconds=done.seconds)


def files_of(done: Manifest) -> list[str]:
    """Returns the names of the files that an export has written, relative to the place of the results."""
    return list((done.result or {}).get("files", ()))


def problems_of(done: Manifest) -> Diagnosed | None:
    """Returns the problems of a capture; None if it could not be read."""
    if done.result is None:
        return None
    kept = done.result
    return Diagnosed((done.capture,), of_rows(kept["problems"], Problem), kept["order"], kept["nature"])


def records_of(done: Manifest) -> list[Mapping[str, Any]]:
    """Returns the records of a summary."""
    return done.result or []
