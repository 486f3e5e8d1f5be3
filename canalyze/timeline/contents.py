"""What of a capture stands in a Rerun recording by now: what a first layout is made from.

Plain facts, kept by those who write and read by the layout. Must not: import Rerun, or know what a state means.
"""

from dataclasses import dataclass, field
from typing import Final

_SEEN: Final = 4000
"""A transfer that takes more of the capture than one part in so many leaves a mark in its lane."""
_INFORMED: Final = 10
"""Rows of a log that are only information and leave room for others."""


@dataclass(slots=True)
class Series:
    """One line of a plot: a signal of a PDO that is a quantity."""

    name: str
    """As the line is called, with its unit: 速度实际值 [rpm]."""
    unit: str
    """Its unit; "" where none is known."""
    described: bool
    """It has a name, of the standard or of a description, not just an index."""
    least: float = float("inf")
    """The least value so far; NaN is none."""
    greatest: float = float("-inf")
    """The greatest value so far."""
    kind: str = ""
    """What kind of quantity it is, as the core calls it; "" where that is not known."""

    @property
    def varies(self) -> bool:
        """Whether it has shown more than one value."""
        return self.least < self.greatest


@dataclass(slots=True)
class Plot:
    """The quantities of one PDO by one mapping: one entity with a row a frame."""

    entity: str
    """Path of the entity: /pdo/can0/node5/TPDO1."""
    bus: str
    """The bus's name; "" where the capture names none."""
    node: int
    """Node-ID."""
    pdo: str
    """TPDO1."""
    series: list[Series]
    """Its lines, in the order in which they stand in the entity's rows."""
    rows: int = 0
    """Rows so far."""


@dataclass(slots=True)
class Lane:
    """A lane of states."""

    entity: str
    """Path of the entity: /nmt/can0/node5; its first part is the kind of lane."""
    rows: int = 0
    """Changes so far."""
    fault: bool = False
    """It has shown a fault: a lost heartbeat, a drive in fault, an emergency."""

    @property
    def kind(self) -> str:
        """Give nmt, sdo, drive, emcy, incidents or value."""
        return self.entity.split("/")[1]


@dataclass(slots=True)
class Contents:
    """All of it, in the order in which it came."""

    plots: dict[str, Plot] = field(default_factory=dict)
    """By entity."""
    lanes: dict[str, Lane] = field(default_factory=dict)
    """By entity."""
    sync: set[str] = field(default_factory=set)
    """Buses of which SYNC periods are shown: /sync/can0/period, and the window at /sync/can0/window."""
    delays: dict[str, None] = field(default_factory=dict)
    """Entities of synchronous PDOs' delays: /sync/can0/delay/node5/TPDO1."""
    durations: dict[str, None] = field(default_factory=dict)
    """Entities of how long SDO transfers took: /sdo_duration/can0/node5."""
    transfers: int = 0
    """How many transfers these have."""
    transferring_ns: float = 0.0
    """How long all of them took."""
    load: dict[str, bool] = field(default_factory=dict)
    """Buses whose load is shown at /load/can0, and whether in percent; else in frames a second."""
    peaks: dict[str, float] = field(default_factory=dict)
    """The greatest load of each bus so far, in percent."""
    windows: set[str] = field(default_factory=set)
    """Buses whose synchronous window is known."""
    frames: int = 0
    """Rows of annotated frames, at /frames."""
    logged: dict[str, int] = field(default_factory=dict)
    """Rows of findings and emergencies, at /log/..., by level: ERROR, WARN, INFO."""
    findings: int = 0
    """Rows of findings, at /log/findings/..."""
    told: dict[tuple[str, int], dict[str, None]] = field(default_factory=dict)
    """Entities with findings and emergencies of a node, by its bus as paths have it and the node."""
    listed: dict[str, set[str]] = field(default_factory=dict)
    """Entities with SDO transfers in words, and their levels: /sdo_list/can0/node5."""
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    """The least and the greatest value of entities that are no PDO's."""
    timed: bool = False
    """Something has a stamp: there is a timeline `time_since_start`; else there is only `frame`."""
    dated: bool = False
    """Stamps are dates: there is a timeline `capture_time`."""
    cycles: bool = False
    """There are SYNC cycles: there is a timeline `sync_cycle`."""
    first_ns: int = 0
    """Elapsed time of the first row, in ns."""
    last_ns: int = 0
    """Elapsed time of the last row, in ns."""
    first_frame: int = 0
    last_frame: int = 0
    summary: bool = False
    """There is a summary, at /summary."""
    stories: bool = False
    """There are stories of what went wrong, at /stories."""

    def widen(self, entity: str, least: float, greatest: float) -> None:
        """Take values of an entity: the least and the greatest of some."""
        if least <= greatest:
            before = self.ranges.get(entity, (least, greatest))
            self.ranges[entity] = min(before[0], least), max(before[1], greatest)

    @property
    def brief(self) -> bool:
        """Whether SDO transfers are too short to be seen in their lanes."""
        return self.transferring_ns * _SEEN < self.transfers * (self.last_ns - self.first_ns)

    @property
    def crowded(self) -> bool:
        """Whether what has failed is out of sight in a log, below what is only information."""
        return self.logged.get("INFO", 0) > _INFORMED and len(self.logged) > 1
