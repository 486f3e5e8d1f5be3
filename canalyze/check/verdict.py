"""Findings of `check` in one capture, before and after they are judged: the form from which all reports are written.

Nothing here reads, judges or prints.
"""

from collections.abc import Mapping
from typing import NamedTuple

from msgspec import Struct, field

from canalyze.records.problems import Finding, Problem


class Counted(Struct, frozen=True):
    """Findings of one kind: same rule, bus, node and object, of one expectation, consequences of one cause or none."""

    finding: Finding
    """The first of them, in the order of frames."""
    shown: tuple[Finding, ...]
    """The first ones, at most ten, `finding` among them."""
    count: int
    """Number of them; those that are not shown were only counted."""
    known: int = 0
    """Number of them that the baseline allows; the finding counts only if there are more."""
    alike: int = 0
    """Number of them with those that the baseline counts as the same kind, for another expectation."""
    consequences: tuple["Counted", ...] = ()
    """Consequences of these findings; none of them fails the check."""


class Examined(NamedTuple):
    """Findings of one capture before they are judged."""

    file: str
    found: tuple[Counted, ...] = ()
    """In the order of the frames that they are about; what is about no frame comes first."""
    error: str | None = None
    """Why the capture, or the rest of it, could not be read."""
    complaints: tuple[str, ...] = ()
    """Lines for standard error."""
    frames: int = 0
    seconds: float = 0.0
    expectations: str | None = None
    """The file of expectations that it was held against."""
    nature: str = "canopen"
    """Kind of its buses, as in the core; `canopen` if one of them is."""
    incidents: tuple[Problem, ...] = ()
    """Problems, if they are asked for."""
    signal: int = 0
    """The signal that ended reading early: SIGINT or SIGTERM."""


class Verdict(Struct, frozen=True):
    """One capture, judged."""

    file: str
    """Its name as it was given, `-` for standard input."""
    failures: tuple[Counted, ...] = ()
    """Findings at or above the threshold, in the order of the frames that they are about."""
    others: tuple[Counted, ...] = ()
    """Findings below the threshold, or that the baseline allows."""
    consequences: tuple[Counted, ...] = ()
    """Those of causes that are no findings, or not judged; the others stand with their causes."""
    overruled: int = 0
    """Findings that an override, --select or --ignore took away."""
    error: str | None = None
    """Why the capture, or the rest of it, could not be read: one line, in the language of the run."""
    complaints: tuple[str, ...] = ()
    """Lines for standard error, in the language of the run."""
    frames: int = 0
    """Frames read."""
    seconds: float = 0.0
    """Duration of the work."""
    reasons: tuple[tuple[str, int], ...] = ()
    """Why overrides of the configuration changed findings, and how many each, in the order of the reasons."""

    expectations: str | None = None
    """The file of expectations that it was held against."""

    nature: str = "canopen"
    """Kind of its buses: `silent`, `foreign`, `unproven`, or `canopen` if one of them is."""

    incidents: tuple[Problem, ...] = ()
    """Problems, if they were asked for."""
    problems: tuple[int, ...] = ()
    """The numbers of those that fail the check."""
    known_problems: Mapping[int, int] = field(default_factory=dict)
    """Number of its kind that the baseline allows, by the number of a problem that would fail without it."""

    @property
    def every_consequence(self) -> tuple[Counted, ...]:
        """Returns all consequences."""
        return (*(c for one in (*self.failures, *self.others) for c in one.consequences), *self.consequences)

    @property
    def stories(self) -> tuple[Problem, ...]:
        """Returns the problems without a cause that are more than harmless."""
        return tuple(one for one in self.incidents if one.is_root and one.status != "harmless")

    @property
    def excused(self) -> frozenset[int]:
        """Returns the numbers of the problems that do not fail because the baseline allows as many of their kind."""
        return frozenset(self.known_problems) - frozenset(self.problems)

    @property
    def failed(self) -> bool:
        """Returns true if anything fails the check, apart from a capture that cannot be read."""
        return bool(self.failures or self.problems)

    @property
    def judged(self) -> bool:
        """Returns true if no failure means a passed check: traffic that is not shown to be CANopen is not checked."""
        return self.failed or self.nature == "canopen" or self.expectations is not None
