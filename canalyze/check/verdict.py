"""The results of `check` for one capture, before and after it is judged: all reports are written from them.

Nothing here reads, judges or prints.
"""

from collections.abc import Mapping
from typing import NamedTuple

from msgspec import Struct, field

from canalyze.records import Finding, Problem


class Counted(Struct, frozen=True):
    """Findings of one kind: same rule, bus, node and object, of one expectation, consequences of one cause or none."""

    finding: Finding
    """The first of them, in the order of frames."""
    shown: tuple[Finding, ...]
    """The first ones, at most ten, `finding` among them."""
    count: int
    """How many there are; those that are not shown were only counted."""
    known: int = 0
    """How many of them the baseline allows; the finding counts only if there are more."""
    alike: int = 0
    """How many there are with those that the baseline counts as the same kind, being about another expectation."""
    consequences: tuple["Counted", ...] = ()
    """What these findings explain; none of it fails the check."""


class Examined(NamedTuple):
    """The findings of one capture, before anything is judged."""

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
    """What it has shown of its buses, as the core says it; `canopen` where one of them is."""
    incidents: tuple[Problem, ...] = ()
    """What went wrong, where that is asked for."""
    signal: int = 0
    """What ended the reading before its end: SIGINT or SIGTERM."""


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
    """How long the work took."""
    reasons: tuple[tuple[str, int], ...] = ()
    """Why overrides of the configuration changed findings, and how many each, in the order of the reasons."""

    expectations: str | None = None
    """The file of expectations that it was held against."""

    nature: str = "canopen"
    """What it has shown of its buses: `silent`, `foreign`, `unproven`, or `canopen` where one of them is."""

    incidents: tuple[Problem, ...] = ()
    """What went wrong, where that was asked for."""
    problems: tuple[int, ...] = ()
    """The numbers of those that fail the check."""
    known_problems: Mapping[int, int] = field(default_factory=dict)
    """How many of its kind the baseline allows, by the number of an incident that would fail without it."""

    @property
    def every_consequence(self) -> tuple[Counted, ...]:
        """All consequences, whatever explains them."""
        return (*(c for one in (*self.failures, *self.others) for c in one.consequences), *self.consequences)

    @property
    def stories(self) -> tuple[Problem, ...]:
        """The problems that nothing else has caused and that are more than harmless."""
        return tuple(one for one in self.incidents if one.is_root and one.status != "harmless")

    @property
    def excused(self) -> frozenset[int]:
        """The numbers of the problems that do not fail because the baseline allows as many of their kind."""
        return frozenset(self.known_problems) - frozenset(self.problems)

    @property
    def failed(self) -> bool:
        """True if anything fails the check; a capture that cannot be read is another matter."""
        return bool(self.failures or self.problems)

    @property
    def judged(self) -> bool:
        """True if the capture was checked at all: traffic that nothing shows to be CANopen is not."""
        return self.failed or self.nature == "canopen" or self.expectations is not None
