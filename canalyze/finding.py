"""A finding of the core, typed, for commands, reports and library.

It is read from the core's JSON lines and never created here.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, get_args

from canalyze.values import ObjectRef, Timed, object_ref

Severity = Literal["info", "warning", "error"]
SEVERITIES: Final[tuple[Severity, ...]] = get_args(Severity)
"""The core's severities, ascending."""


@dataclass(frozen=True, slots=True)
class Line:
    """An annotated line of the capture."""

    frame: int
    """Number of its frame in the capture, from 1."""
    text: str
    """The line as `decode` writes it, in the language of the run, without line end."""


@dataclass(frozen=True, slots=True)
class Finding(Timed):
    """An event at a frame that an engineer should know."""

    code: str
    """The rule: SDO001."""
    name: str
    """The rule's name in kebab-case."""
    severity: Severity
    """Its severity, with the overrides of the configuration."""
    file: str
    """The capture."""
    frame: int | None
    """The frame that shows it, from 1; None for a finding about the file before any frame."""
    line: int | None
    """The line of the file, from 1, if its format has lines."""
    t: str | None
    """Time of the frame in seconds, a decimal string with all its digits; None without stamps."""
    cause_frame: int | None
    """The earlier frame that it is about, if different."""
    cause_line: int | None
    """The line of that frame."""
    bus: str | None
    """The bus, if the capture names it."""
    node: int | None
    """The node-ID, 1 to 127, if it concerns a node."""
    index: str | None
    """Index of the object, four hexadecimal digits, if it concerns an object."""
    sub: int | None
    """Its sub-index."""
    message: str
    """The sentence about `about_frame`, in the language of the run."""
    facts: Mapping[str, Any] = field(default_factory=dict)
    """Measured values, by the names of the rule."""
    lines: tuple[Line, ...] = ()
    """The annotated lines of its context, oldest first, including its own frame's; empty unless requested."""
    because_of: int | None = None
    """The frame of the event or finding that causes it; a consequence has the severity info."""
    about: int | None = None
    """The frame that it is about, from the rule; None: `cause_frame`, or else `frame`."""

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> "Finding":
        """Creates a finding from one object of the core (`"kind": "finding"`); unknown keys are ignored."""
        known = {name: row[name] for name in _SIMPLE}
        lines = tuple(Line(line["frame"], line["text"]) for line in row.get("lines", ()))
        return cls(**known, facts=row.get("facts") or {}, lines=lines, about=row.get("about_frame"))

    @property
    def about_frame(self) -> int | None:
        """The frame that it is about: the one that shows it, or an earlier one."""
        if self.about is not None:
            return self.about
        return self.frame if self.cause_frame is None else self.cause_frame

    @property
    def about_line(self) -> int | None:
        """The line of that frame."""
        return self.line if self.about_frame == self.frame else self.cause_line

    @property
    def object(self) -> ObjectRef | None:
        """The object as the standard writes it, 1017h:00; None if it concerns none."""
        return object_ref(self.index, self.sub)

    @property
    def expectation(self) -> str | None:
        """The expectation that is not met, boot.expect.toml:12; None for other findings."""
        label = self.facts.get("expectation")
        return label if isinstance(label, str) else None

    def __repr__(self) -> str:
        where = f" at frame {self.about_frame}" if self.about_frame is not None else ""
        return f"<Finding {self.severity} {self.code}{where}: {self.message}>"


_SIMPLE: Final = (
    *("code", "name", "severity", "file", "frame", "line", "t", "cause_frame", "cause_line", "bus", "node"),
    *("index", "sub", "message", "because_of"),
)
