"""Incidents of a capture, typed: what went wrong, to whom, from when to when, and why.

Read from the records of the core's diagnosis and never made here. It must not read a capture, judge or print.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, get_args

from canalyze.values import Timed

Status = Literal["stands", "unknown", "over", "harmless"]
"""How an incident stands at the end: not over, not known, over, or explained by a command or by the recording."""
Impact = Literal["A", "B", "C", "D", "E"]
"""What it means: something has stopped, does not start, works worse, is wrong on the wire only, is worth knowing."""
Grade = Literal["certain", "likely", "possible"]
"""How sure it is."""
KEYS: Final = (
    *("kind", "phase", "id", "incident", "subject", "status", "impact", "grade", "begin", "noticed", "end", "cause"),
    *("effects", "steps", "facts", "checks", "findings", "message", "repeats"),
)
"""Of an incident in JSON lines."""
STATUSES: Final[tuple[Status, ...]] = get_args(Status)


@dataclass(frozen=True, slots=True)
class Moment(Timed):
    """A frame and its time."""

    frame: int
    """Its number, from 1."""
    t: str | None
    """Seconds, a decimal string with all its digits; None without stamps."""


@dataclass(frozen=True, slots=True)
class Cause:
    """From what an incident comes."""

    id: int
    """The number of the incident that caused it."""
    link: str
    """The rule of cause, as L1."""
    grade: Grade


@dataclass(frozen=True, slots=True)
class Step(Timed):
    """A fact of an incident at a frame."""

    frame: int
    t: str | None
    role: Literal["sign", "reaction", "attempt", "recovery"]
    text: str
    """In words."""
    finding: str | None
    """The code of the rule that found it, where one did."""


@dataclass(frozen=True, slots=True)
class Incident:
    """What happened to one subject."""

    id: int
    """Its number, from 1: in the order of reading, or that in which problems were told live."""
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
    """The frame by which it could be told."""
    end: Moment | None
    """The frame by which it is over."""
    cause: Cause | None
    effects: tuple[int, ...]
    """The numbers of the incidents that it has caused."""
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

    @property
    def frames(self) -> tuple[int, ...]:
        """Give the frames that are its evidence, ascending."""
        ends = [self.end.frame] if self.end else []
        return tuple(sorted({self.begin.frame, self.noticed.frame, *(step.frame for step in self.steps), *ends}))


def incident(row: Mapping[str, Any]) -> Incident:
    """Read a record of the core."""
    subject = row["subject"]
    return Incident(
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
class IncidentChange:
    """What has become known of an incident while a bus is listened to; it may still change."""

    phase: Literal["opened", "linked", "ended"]
    """It begins to show, its cause is known or another, or it is over."""
    id: int
    """The number of the incident."""
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


def incident_change(row: Mapping[str, Any]) -> IncidentChange:
    """Read a record of the core that came before the end."""
    return IncidentChange(phase=row["phase"], **_told(row))


def _told(row: Mapping[str, Any]) -> dict[str, Any]:
    """Give what is known of an incident from its begin to its end."""
    subject, cause, end = row["subject"], row["cause"], row["end"]
    return {
        **{name: row[name] for name in ("id", "status", "message")},
        "kind": row["incident"],
        "bus": subject["bus"],
        "nodes": tuple(subject.get("nodes") or ([subject["node"]] if "node" in subject else [])),
        "begin": _moment(row["begin"]),
        "noticed": _moment(row["noticed"]),
        "end": None if end is None else _moment(end),
        "cause": None if cause is None else Cause(**cause),
    }


def _moment(row: Mapping[str, Any]) -> Moment:
    return Moment(row["frame"], row["t"])
