"""The contents of a Rerun recording so far, from which the layout is made.

Plain data, updated by the writers and read by the layout. Must not: import Rerun, or know the meaning of a state.
"""

from dataclasses import dataclass, field
from typing import Final

_SEEN: Final = 4000
"""A transfer that takes more than this fraction of the capture is visible in its lane."""
_INFORMED: Final = 10
"""Maximum number of informational rows of a log that leave room for others."""


@dataclass(slots=True)
class Series:
    """One line of a plot: a signal of a PDO that is a quantity."""

    name: str
    """The name of the line with its unit: 速度实际值 [rpm]."""
    unit: str
    """Its unit; "" if unknown."""
    described: bool
    """True if it has a name, from the standard or a description, and not just an index."""
    least: float = float("inf")
    """The least value so far, ignoring NaN."""
    greatest: float = float("-inf")
    """The greatest value so far."""
    kind: str = ""
    """The core's kind of quantity; "" if unknown."""

    @property
    def varies(self) -> bool:
        """True if it has had more than one value."""
        return self.least < self.greatest


@dataclass(slots=True)
class Plot:
    """The quantities of one PDO by one mapping: one entity with a row per frame."""

    entity: str
    """Path of the entity: /pdo/can0/node5/TPDO1."""
    bus: str
    """The bus's name; "" if the capture has no names."""
    node: int
    """Node-ID."""
    pdo: str
    """TPDO1."""
    series: list[Series]
    """Its lines, in their order in the entity's rows."""
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
    """True if it has had a fault: a lost heartbeat, a drive in fault, an emergency."""

    @property
    def kind(self) -> str:
        """nmt, sdo, drive, emcy, problems or value."""
        return self.entity.split("/")[1]


@dataclass(slots=True)
class Contents:
    """The contents, in the order in which they came."""

    plots: dict[str, Plot] = field(default_factory=dict)
    """By entity."""
    lanes: dict[str, Lane] = field(default_factory=dict)
    """By entity."""
    sync: set[str] = field(default_factory=set)
    """Buses with SYNC periods at /sync/can0/period, and the window at /sync/can0/window."""
    delays: dict[str, None] = field(default_factory=dict)
    """Entities of the delays of synchronous PDOs: /sync/can0/delay/node5/TPDO1."""
    durations: dict[str, None] = field(default_factory=dict)
    """Entities of the durations of SDO transfers: /sdo_duration/can0/node5."""
    transfers: int = 0
    """Number of transfers in them."""
    transferring_ns: float = 0.0
    """Their total duration."""
    load: dict[str, bool] = field(default_factory=dict)
    """Buses with a load at /load/can0: true in percent, false in frames per second."""
    peaks: dict[str, float] = field(default_factory=dict)
    """The maximum load of each bus so far, in percent."""
    windows: set[str] = field(default_factory=set)
    """Buses with a known synchronous window."""
    frames: int = 0
    """Rows of annotated frames, at /frames."""
    logged: dict[str, int] = field(default_factory=dict)
    """Rows of findings and emergencies, at /log/..., by level: ERROR, WARN, INFO."""
    findings: int = 0
    """Rows of findings, at /log/findings/..."""
    told: dict[tuple[str, int], dict[str, None]] = field(default_factory=dict)
    """Entities with findings and emergencies of a node, by the bus as in paths and the node."""
    listed: dict[str, set[str]] = field(default_factory=dict)
    """Entities with SDO transfers in words, and their levels: /sdo_list/can0/node5."""
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    """The least and the greatest value of entities of no PDO."""
    timed: bool = False
    """True if there is a stamp, and so a timeline `time_since_start`; otherwise there is only `frame`."""
    dated: bool = False
    """True if stamps are dates, and so there is a timeline `capture_time`."""
    cycles: bool = False
    """True if there are SYNC cycles, and so a timeline `sync_cycle`."""
    first_ns: int = 0
    """Elapsed time of the first row, in ns."""
    last_ns: int = 0
    """Elapsed time of the last row, in ns."""
    first_frame: int = 0
    last_frame: int = 0
    summary: bool = False
    """True if there is a summary, at /summary."""
    diagnosis: bool = False
    """True if there is a diagnosis in words, at /diagnosis."""

    def widen(self, entity: str, least: float, greatest: float) -> None:
        """Extends the range of an entity by the least and the greatest of some values."""
        if least <= greatest:
            before = self.ranges.get(entity, (least, greatest))
            self.ranges[entity] = min(before[0], least), max(before[1], greatest)

    @property
    def brief(self) -> bool:
        """True if SDO transfers are too short to be visible in their lanes."""
        return self.transferring_ns * _SEEN < self.transfers * (self.last_ns - self.first_ns)

    @property
    def crowded(self) -> bool:
        """True if errors may be out of sight in a log, below informational rows."""
        return self.logged.get("INFO", 0) > _INFORMED and len(self.logged) > 1
