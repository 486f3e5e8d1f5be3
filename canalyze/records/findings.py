"""Findings, and the annotated lines of a capture that they and others show."""

from collections.abc import Iterator, Mapping
from typing import Any

from msgspec import Struct, field

from canalyze.records import Severity, decoder
from canalyze.values import ObjectRef, Timed, object_ref


class Line(Struct, frozen=True, gc=False):
    """An annotated line of the capture."""

    frame: int
    """Number of its frame in the capture, from 1."""
    text: str
    """The line as `decode` writes it, in the language of the run, without line end."""


class Finding(Timed, Struct, frozen=True, gc=False, kw_only=True, tag_field="kind", tag="finding"):
    """Something that an engineer should know, at a frame."""

    code: str
    """The rule: SDO001."""
    name: str
    """The rule's name in kebab-case."""
    severity: Severity
    """The severity, with overrides of the configuration."""
    file: str
    """The capture."""
    frame: int | None
    """The frame that shows it, from 1; None where the finding is about the file before any frame."""
    line: int | None
    """The line of the file, from 1, where its format has lines."""
    t: str | None
    """Time of the frame in seconds, a decimal string with all its digits; None without stamps."""
    cause_frame: int | None
    """The earlier frame that it is about, if another."""
    cause_line: int | None
    """The line of that frame."""
    about: int | None = field(name="about_frame", default=None)
    """The frame that it is about, as the rule says; None: `cause_frame`, or else `frame`."""
    because_of: int | None = None
    """The frame of the event or finding that explains it: it is a consequence of that, and its severity is info."""
    bus: str | None
    """The bus, where the capture names it."""
    node: int | None
    """The node-ID, 1 to 127, where a node is concerned."""
    index: str | None
    """Index of the object, four hexadecimal digits, where an object is concerned."""
    sub: int | None
    """Its sub-index."""
    message: str
    """The statement about `about_frame`, in one sentence, in the language of the run."""
    facts: Mapping[str, Any] = field(default_factory=dict)
    """The measured values, by the names of the rule."""
    lines: tuple[Line, ...] = ()
    """The annotated lines of its context, oldest first, with that of its own frame; empty unless asked for."""

    @property
    def about_frame(self) -> int | None:
        """The frame that it is about: an earlier one than the one that shows it, or that one."""
        if self.about is not None:
            return self.about
        return self.frame if self.cause_frame is None else self.cause_frame

    @property
    def about_line(self) -> int | None:
        """The line of that frame."""
        return self.line if self.about_frame == self.frame else self.cause_line

    @property
    def object(self) -> ObjectRef | None:
        """The object as the standard writes it, 1017h:00; None where none is concerned."""
        return object_ref(self.index, self.sub)

    @property
    def expectation(self) -> str | None:
        """The expectation that is not met, boot.expect.toml:12; None for findings about anything else."""
        label = self.facts.get("expectation")
        return label if isinstance(label, str) else None

    def __repr__(self) -> str:
        where = f" at frame {self.about_frame}" if self.about_frame is not None else ""
        return f"<Finding {self.severity} {self.code}{where}: {self.message}>"


def lines(result: bytes) -> Iterator[Line]:
    """Yields the annotated lines of frames in JSON lines; those of one frame are one text."""
    yield from map(decoder(Line), result.splitlines())
