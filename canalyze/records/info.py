"""A file before anything in it is decoded."""

from collections.abc import Mapping

from msgspec import Struct


class LeftOut(Struct, frozen=True, gc=False):
    """Rows that are missing by the file itself."""

    places: int
    uncounted: int
    """The number of places that do not tell how many."""
    rows: int


class BusFrames(Struct, frozen=True, gc=False):
    """The frames of a bus."""

    bus: str | None
    frames: int


class Unreadable(Struct, frozen=True, gc=False):
    """Lines that could not be read."""

    count: int
    first_line: int | None
    first_offset: int | None
    further_buses: int
    """Those on more buses than are kept apart."""


class Damage(Struct, frozen=True, gc=False):
    """A damaged part of the file."""

    kind: str
    line: int | None
    offset: int | None
    bytes: int | None
    frames: int | None


class PassedOver(Struct, frozen=True, gc=False):
    """Records of a kind that are no frames."""

    kind: str
    count: int


class Topic(Struct, frozen=True, gc=False):
    """A topic of an MCAP file."""

    name: str
    schema: str
    encoding: str
    messages: int
    read_as: str
    """The fields in which a message holds a frame, "" if it is not read as one."""
    bus: str | None


class Contents(Struct, frozen=True, gc=False):
    """The content of a file beside its frames."""

    dialect: Mapping[str, str]
    passed_over: tuple[PassedOver, ...]
    topics: tuple[Topic, ...]


class Info(Struct, frozen=True, gc=False, tag_field="kind", tag="info"):
    """A file; what is not known is None."""

    file: str
    frames: int
    buses: tuple[BusFrames, ...]
    kinds: Mapping[str, int]
    directions: Mapping[str, int]
    unstamped: int
    first_t: str | None
    last_t: str | None
    seconds: str | None
    first_date: str | None
    last_date: str | None
    zone: str | None
    decimals: tuple[int, int] | None
    """The fewest and the most digits behind the point of a stamp."""
    backward: int
    backward_most_us: float
    clamped_stamps: int
    unreadable: Unreadable | None
    gaps: int
    dropped: int
    error_markers: int
    left_out: LeftOut | None
    damage: tuple[Damage, ...]
    damages: int
    contents: Contents


class Opened(Struct, frozen=True, gc=False):
    """The facts of a file that its reader knows."""

    format: str
    compression: str | None
    checked: bool | None
    size: int
