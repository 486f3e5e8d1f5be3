"""Problems of a capture, typed: what went wrong, to whom, from when to when, and why.

Read from the records of the core's diagnosis and never made here. It must not read a capture, judge or print.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, get_args

from canalyze.values import Timed

Status = Literal["open", "unknown", "ended", "harmless"]
"""The status of a problem at the end: not ended, not known, ended, or explained by a command or by the recording."""
Impact = Literal["A", "B", "C", "D", "E"]
"""What it means: something has stopped, does not start, works worse, is wrong on the wire only, is worth knowing."""
Grade = Literal["certain", "likely", "possible"]
"""How sure it is."""
KEYS: Final = (
    *(
        "kind",
        "phase",
        "id",
        "problem",
        "incident",
        "subject",
        "status",
        "impact",
        "grade",
        "begin",
        "noticed",
        "end",
        "cause",
    ),
    *("effects", "steps", "facts", "checks", "findings", "message", "repeats"),
)
"""Of a problem in JSON lines; `incident` is deprecated, the former name of `problem`."""
STATUSES: Final[tuple[Status, ...]] = get_args(Status)
FORMER_STATUSES: Final[Mapping[str, Status]] = {"stands": "open", "over": "ended"}
"""Former names, which records of former releases have."""


@dataclass(frozen=True, slots=True)
class Moment(Timed):
    """A frame and its time."""

    frame: int
    """Its number, from 1."""
    t: str | None
    """Seconds, a decimal string with all its digits; None without stamps."""


@dataclass(frozen=True, slots=True)
class Cause:
    """From what a problem comes."""

    id: int
    """The number of the problem that caused it."""
    link: str
    """The rule of cause, as L1."""
    grade: Grade


@dataclass(frozen=True, slots=True)
class Step(Timed):
    """A fact of a problem at a frame."""

    frame: int
    t: str | None
    role: Literal["sign", "reaction", "attempt", "recovery"]
    text: str
    """In words."""
    finding: str | None
    """The code of the rule that found it, where one did."""


@dataclass(frozen=True, slots=True)
class Problem:
    """What happened to one subject."""

    id: int
    """Its number, from 1: in the order of reading, or that in which problems were reported live."""
    kind: str
    """What it is, as `node-silent`."""
    bus: str | None
    node: int | None
    """The node; None where it happened to several, to the bus or to the capture."""
    nodes: tuple[int, ...]
    """All nodes concerned."""
    axis: int | None
    """The axis of a drive, from 1, where it is one."""
    pdo: str | None
    """A PDO of the node, as `TPDO1`."""
    status: Status
    impact: Impact
    grade: Grade
    begin: Moment
    """The first evidence: the last sign of life, the frame that is wrong."""
    noticed: Moment
    """The frame by which it could be known."""
    end: Moment | None
    """The frame by which it has ended."""
    cause: Cause | None
    effects: tuple[int, ...]
    """The numbers of the problems that it has caused."""
    steps: tuple[Step, ...]
    facts: Mapping[str, Any] = field(repr=False)
    """What was measured; times in nanoseconds have `_ns` in their names."""
    checks: tuple[str, ...]
    """What to look at first, in words."""
    findings: tuple[tuple[str, int], ...]
    """The codes of the rules that found what belongs to it, each with the frame that shows it; 0: none does."""
    message: str
    """What it says, in one line."""
    count: int
    """How often it happened."""
    is_root: bool
    """Whether nothing is known to have caused it."""

    def __repr__(self) -> str:
        return f"<Problem {self.id} {self.kind}, {self.status}, frame {self.begin.frame}: {self.message}>"

    @property
    def frames(self) -> tuple[int, ...]:
        """Returns the frames that are its evidence, ascending."""
        ends = [self.end.frame] if self.end else []
        return tuple(sorted({self.begin.frame, self.noticed.frame, *(step.frame for step in self.steps), *ends}))


def status(name: str) -> Status:
    """Return a status by its name, or its former name."""
    return next(one for one in STATUSES if one == FORMER_STATUSES.get(name, name))


def current(row: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a record of a problem as it is written today; those of former releases have other names."""
    if "problem" in row:
        return row
    return {**row, "kind": "problem", "problem": row["incident"], "status": status(row["status"])}


def problem(row: Mapping[str, Any]) -> Problem:
    """Read a record of the core."""
    subject = row["subject"]
    return Problem(
        **_told(row),
        **{name: subject.get(name) for name in ("node", "axis", "pdo")},
        **{name: row[name] for name in ("impact", "grade", "facts")},
        effects=tuple(row["effects"]),
        steps=tuple(Step(**step) for step in row["steps"]),
        checks=tuple(row["checks_text"]),
        findings=tuple((one["code"], one["frame"] or 0) for one in row["findings"]),
        count=row["repeats"]["count"],
        is_root=row["root"],
    )


@dataclass(frozen=True, slots=True)
class ProblemChange:
    """What has become known of a problem while a bus is listened to; it may still change."""

    phase: Literal["opened", "linked", "ended"]
    """It begins to show, its cause is known or another, or it has ended."""
    id: int
    """The number of the problem."""
    kind: str
    """What it is, as `node-silent`."""
    bus: str | None
    nodes: tuple[int, ...]
    """All nodes concerned."""
    status: Status
    begin: Moment
    noticed: Moment
    end: Moment | None
    cause: Cause | None
    message: str
    """What it says, in one line."""

    def __repr__(self) -> str:
        return f"<ProblemChange {self.id} {self.kind} {self.phase}, frame {self.begin.frame}: {self.message}>"


def problem_change(row: Mapping[str, Any]) -> ProblemChange:
    """Read a record of the core that came before the end."""
    return ProblemChange(phase=row["phase"], **_told(row))


def _told(row: Mapping[str, Any]) -> dict[str, Any]:
    """Returns what is known of a problem from its begin to its end."""
    subject, cause, end = row["subject"], row["cause"], row["end"]
    return {
        **{name: row[name] for name in ("id", "status", "message")},
        "kind": row["problem"],
        "bus": subject["bus"],
        "nodes": tuple(subject.get("nodes") or ([subject["node"]] if "node" in subject else [])),
        "begin": _moment(row["begin"]),
        "noticed": _moment(row["noticed"]),
        "end": None if end is None else _moment(end),
        "cause": None if cause is None else Cause(**cause),
    }


def _moment(row: Mapping[str, Any]) -> Moment:
    return Moment(row["frame"], row["t"])
