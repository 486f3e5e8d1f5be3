"""A capture in figures. Times are in microseconds, rates in frames a second, loads in percent of the bit rate.

All are None without stamps, loads without a bit rate, peaks where the capture is shorter than their window.
"""

from collections.abc import Mapping
from typing import TypeAlias

from msgspec import Struct

from canalyze.records import Node, Severity, Spread


class LeftOut(Struct, frozen=True, gc=False):
    """Rows that are missing by the file itself."""

    places: int
    uncounted: int
    """The number of places that do not tell how many."""
    rows: int


class Capture(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_capture"):
    """The capture as a whole."""

    files: int
    frames: int
    unstamped: int
    first_t: str | None
    last_t: str | None
    seconds: str | None
    backward: int
    backward_most_us: float | None
    pause_us: float | None
    """The longest time without a frame, and the frame that ended it."""
    pause_frame: int | None
    reordered: int
    unreadable: int
    gaps: int
    dropped: int
    left_out: LeftOut | None
    damages: int
    bit_rate: int | None


class Burst(Struct, frozen=True, gc=False):
    """The most frames without a pause between them."""

    frames: int
    length_us: float


class Bus(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_bus"):
    """The traffic of a bus."""

    bus: str | None
    frames: int
    rate: float | None
    peak_rate_1s: float | None
    peak_rate_100ms: float | None
    fd_switched: int
    """Frames with a switched bit rate."""
    errors: int
    services: Mapping[str, int]
    load: float | None
    load_peak_1s: float | None
    load_peak_100ms: float | None
    burst: Burst | None


class Sync(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_sync"):
    """SYNC on a bus."""

    bus: str | None
    frames: int
    period: Spread | None
    counter_min: int | None
    counter_max: int | None
    counter_jumps: int | None


class Pdo(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_pdo"):
    """The traffic of a PDO."""

    bus: str | None
    node: int
    pdo: str
    id: str
    frames: int
    rate: float | None
    interval: Spread | None
    synchronous: int
    before_sync: int
    delay: Spread | None


class Identifier(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_identifier"):
    """The traffic of an identifier that is not CANopen."""

    bus: str | None
    id: str
    frames: int
    rate: float | None
    interval: Spread | None
    length_min: int
    length_max: int


class Raised(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_finding"):
    """The findings of a rule."""

    code: str
    name: str
    severity: Severity
    message: str
    count: int
    first_frame: int | None
    first_line: int | None
    last_frame: int | None
    last_line: int | None
    buses: tuple[str, ...]
    nodes: tuple[int, ...]


Record: TypeAlias = Capture | Bus | Sync | Node | Pdo | Identifier | Raised
KINDS = (Capture, Bus, Sync, Node, Pdo, Identifier, Raised)
