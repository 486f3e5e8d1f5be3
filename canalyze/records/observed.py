"""The figures of a capture from which expectations can be written; times in microseconds, as an expectation judges."""

from msgspec import Struct


class Period(Struct, frozen=True, gc=False):
    """The times from one to the next."""

    count: int
    min_us: float | None
    """The least of those that may be too short."""
    mean_us: float
    max_us: float


class _Train(Struct, frozen=True, gc=False):
    bus: str | None
    silence_us: float | None
    """The time from the last one to the end of the capture; None where something has stopped them."""
    period: Period | None


class Sync(_Train, frozen=True, gc=False, tag_field="kind", tag="observed_sync"):
    """SYNC of a bus."""


class Heartbeat(_Train, frozen=True, gc=False, tag_field="kind", tag="observed_heartbeat"):
    """Heartbeats of a node."""

    node: int


class Pdo(_Train, frozen=True, gc=False, tag_field="kind", tag="observed_pdo"):
    """A PDO."""

    node: int
    pdo: str


class Signal(Struct, frozen=True, gc=False, tag_field="kind", tag="observed_signal"):
    """A signal, and the range of its values."""

    bus: str | None
    node: int
    pdo: str
    signal: str
    select: str
    """Its name in every language."""
    unit: str | None
    min: float | None
    """None where it is no quantity."""
    max: float | None


class NodeState(Struct, frozen=True, gc=False, tag_field="kind", tag="observed_state"):
    """An NMT state of a node."""

    bus: str | None
    node: int
    state: str
    since_boot_up_ns: int | None


class DriveState(NodeState, frozen=True, gc=False, tag_field="kind", tag="observed_drive"):
    """A state of an axis of a drive."""

    axis: int


class Emcy(Struct, frozen=True, gc=False, tag_field="kind", tag="observed_emcy"):
    """An EMCY error code of a node."""

    bus: str | None
    node: int
    code: str
    count: int
