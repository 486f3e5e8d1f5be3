"""The state of a bus that is listened to. Times are in ns, rates by the second; unknown ones are None."""

from collections.abc import Mapping
from typing import Literal

from msgspec import Struct, field

from canalyze.records import Severity
from canalyze.records.objects import Abort
from canalyze.records.problems import Grade, Impact, Status
from canalyze.values import ObjectRef, object_ref


class CountedBus(Struct, frozen=True, gc=False):
    """The frames of a bus."""

    name: str
    frames: int
    error_frames: int
    dropped: int


class Expected(Struct, frozen=True, gc=False):
    """The result of expectations so far."""

    missed: int


class Tally(Struct, frozen=True, gc=False):
    """Counts of a session so far."""

    frames: int
    shown: int
    """Frames that passed the filters."""
    findings: Mapping[str, int]
    """By severity."""
    transfers: Mapping[str, int]
    """By status."""
    expectations: Expected | None
    buses: tuple[CountedBus, ...]


class CountedNode(Struct, frozen=True, gc=False):
    """Counts of a node so far."""

    bus: str
    node: int
    state_text: str
    silent: str
    frames: int
    errors: int
    warnings: int


class Bus(CountedBus, frozen=True, gc=False):
    """A bus of a snapshot."""

    frames_per_s: float | None
    load_percent: float | None
    state: str | None
    """error-warning, error-passive or bus-off."""


class Emergency(Struct, frozen=True, gc=False):
    """The last emergency of a node."""

    code: str
    text: str
    t_ns: int | None
    active: int
    """The number of errors that are present."""


class NodeProblem(Struct, frozen=True, gc=False):
    """The first problem that concerns a node and has not ended."""

    word: str
    provisional: bool


class Node(Struct, frozen=True, gc=False):
    """A node of a snapshot."""

    bus: str
    node: int
    name: str
    state: str | None
    """The byte of the last heartbeat."""
    state_text: str
    frames_per_s: float | None
    unknown: bool
    """True if the bus was away since."""
    heartbeat_age_ns: int | None
    heartbeat_period_ns: int | None
    silent: str | None
    """heartbeat or guarding where it should have been heard since and was not."""
    emcy: Emergency | None
    boot_ups: int
    drive: str | None
    findings: Mapping[str, int]
    problem: NodeProblem | None


class Object(Struct, frozen=True, gc=False):
    """A COB-ID of a snapshot, with its last frame."""

    bus: str
    id: str
    rtr: bool
    service: str
    node: int | None
    name: str
    count: int
    last_ns: int | None
    period_ns: int | None
    jitter_ns: int | None
    """The greatest difference of one of the last periods from their mean."""
    rate: float | None
    data: str
    changed: str
    """FF for a byte that has changed lately, else 00."""
    text: str
    severity: Severity | None


class _Transfer(Struct, frozen=True, gc=False):
    bus: str
    node: int
    direction: Literal["upload", "download"]
    mode: str
    index: str | None
    sub: int | None
    name: str | None

    @property
    def object(self) -> ObjectRef | str:
        """The object, "" where it is not known."""
        return object_ref(self.index, self.sub) or ""


class Running(_Transfer, frozen=True, gc=False):
    """An SDO transfer that has not ended."""

    size: int | None
    bytes: int
    since_ns: int | None


class Done(_Transfer, frozen=True, gc=False):
    """An SDO transfer that has ended."""

    number: int = field(name="transfer")
    size: int
    text: str
    status: Literal["ok", "aborted", "incomplete", "failed"]
    abort: Abort | None
    first_frame: int
    last_frame: int
    t_ns: int | None
    duration_ns: int | None


class Transfers(Struct, frozen=True, gc=False):
    """The SDO transfers of a snapshot, oldest first."""

    running: tuple[Running, ...]
    done: tuple[Done, ...]


class Finding(Struct, frozen=True, gc=False):
    """A finding of a snapshot, which may stand for several."""

    code: str
    severity: Severity
    frame: int | None
    t_ns: int | None
    bus: str
    node: int | None
    text: str
    count: int


class Problem(Struct, frozen=True, gc=False):
    """A problem of a snapshot."""

    id: int
    kind: str
    status: Status
    provisional: bool
    """True if it may still change."""
    impact: Impact
    bus: str
    frame: int
    t_ns: int | None
    noticed: int
    end_ns: int | None
    depth: int
    """The number of causes above it."""
    cause: int | None
    cause_grade: Grade | None
    delay_ns: int | None
    text: str
    checks: tuple[str, ...]


class Snapshot(Struct, frozen=True, gc=False):
    """The state of a session at a moment, without its frames."""

    now_ns: int | None
    start_ns: int | None
    tally: Tally
    buses: tuple[Bus, ...]
    nodes: tuple[Node, ...]
    objects: tuple[Object, ...]
    objects_more: int
    """The number of those for which there was no room."""
    transfers: Transfers
    findings: tuple[Finding, ...]
    problems: tuple[Problem, ...]
    """In the order of reading, each cause before its effects."""


class NamedObject(Struct, frozen=True, gc=False):
    """An object with its name."""

    index: str
    sub: int
    name: str | None

    @property
    def object(self) -> ObjectRef:
        """The object as the standard writes it."""
        return ObjectRef(int(self.index, 16), self.sub)


class ReadObject(NamedObject, frozen=True, gc=False):
    """An object that was read of a node."""

    text: str


class MappedObject(NamedObject, frozen=True, gc=False):
    """An object in a PDO."""

    bits: int


class Pdo(Struct, frozen=True, gc=False):
    """A PDO of a node."""

    pdo: str
    id: str
    valid: bool
    type: int | None
    origin: str | None = field(name="from")
    """The source of the mapping."""
    objects: tuple[MappedObject, ...]


class NodeDetails(Struct, frozen=True, gc=False):
    """The identity of a node and its PDOs."""

    identity: tuple[ReadObject, ...]
    pdos: tuple[Pdo, ...]
