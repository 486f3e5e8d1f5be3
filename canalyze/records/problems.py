"""Findings, the annotated lines that they show, and problems with their causes, up to the overview of a diagnosis."""

from collections.abc import Iterator, Mapping
from typing import Any, Final, Literal, get_args

from msgspec import Struct, field

from canalyze.records import Severity, decoder, records
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


Status = Literal["open", "unknown", "ended", "harmless"]
"""The status of a problem at the end: not ended, not known, ended, or explained by a command or by the recording."""
STATUSES: Final[tuple[Status, ...]] = get_args(Status)
FORMER_STATUSES: Final[Mapping[str, Status]] = {"stands": "open", "over": "ended"}
"""Former names, which are still accepted for a release."""
Impact = Literal["A", "B", "C", "D", "E"]
"""The consequence: something has stopped, does not start, works worse, is wrong on the wire only, is worth knowing."""
Grade = Literal["certain", "likely", "possible"]
"""The certainty of a problem or of a cause."""


class Moment(Timed, Struct, frozen=True, gc=False):
    """A frame and its time."""

    frame: int
    """Its number, from 1."""
    t: str | None
    """Seconds, a decimal string with all its digits; None without stamps."""


class Cause(Struct, frozen=True, gc=False):
    """From what a problem comes."""

    id: int
    """The number of the problem that caused it."""
    link: str
    """The rule of cause, as L1."""
    grade: Grade


class Step(Timed, Struct, frozen=True, gc=False):
    """A fact of a problem at a frame."""

    frame: int
    t: str | None
    role: Literal["sign", "reaction", "attempt", "recovery"]
    text: str
    """In words."""
    finding: str | None
    """The code of the rule that found it, where one did."""


class Subject(Struct, frozen=True, gc=False, omit_defaults=True):
    """To whom a problem happened; what does not apply is None, or empty."""

    bus: str | None
    node: int | None = None
    nodes: tuple[int, ...] = ()
    axis: int | None = None
    pdo: str | None = None


class Cited(Struct, frozen=True, gc=False):
    """A finding that belongs to a problem."""

    code: str
    frame: int | None
    about_frame: int | None


class Repeats(Struct, frozen=True, gc=False):
    """The number of times that a problem happened."""

    count: int


class ProblemTexts(Struct, frozen=True, gc=False):
    """A problem in words; what there is nothing to say about is empty."""

    title: str = ""
    """Its message with the bus where there are several."""
    because: str = ""
    why: str = ""
    delay: str = ""
    after: str = ""
    """The time since its cause."""
    repeats: str = ""


class Sign(Struct, frozen=True, gc=False):
    """A sign that tells causes from each other."""

    told: bool
    """True if it is in the capture."""
    text: str


class _Happened(Struct, frozen=True, gc=False):
    """A problem as it is known from its begin to its end."""

    id: int
    """The number of the problem."""
    kind: str = field(name="problem")
    """The kind of problem, as `node-silent`."""
    subject: Subject
    status: Status
    begin: Moment
    """The first evidence: the last sign of life, the frame that is wrong."""
    noticed: Moment
    """The frame by which it could be known."""
    end: Moment | None
    """The frame by which it has ended."""
    cause: Cause | None
    message: str
    """The statement, in one line."""

    @property
    def bus(self) -> str | None:
        """The bus, where the capture names it."""
        return self.subject.bus

    @property
    def nodes(self) -> tuple[int, ...]:
        """All nodes concerned."""
        return self.subject.nodes or (() if self.subject.node is None else (self.subject.node,))


class Problem(_Happened, frozen=True, gc=False, tag_field="kind", tag="problem"):
    """A problem of one subject.

    `id` is its number, from 1: in the order of reading, or that in which problems were reported live.
    """

    impact: Impact
    grade: Grade
    effects: tuple[int, ...]
    """The numbers of the problems that it has caused."""
    steps: tuple[Step, ...]
    facts: Mapping[str, Any]
    """The measured values; times in nanoseconds have `_ns` in their names."""
    cited: tuple[Cited, ...] = field(name="findings")
    repeats: Repeats
    is_root: bool = field(name="root")
    """True if nothing is known to have caused it."""
    checks: tuple[str, ...] = field(name="checks_text", default=())
    """The checks to begin with, in words."""
    checks_left: tuple[str, ...] = ()
    """Those that the capture does not answer."""
    apart: tuple[Sign, ...] = ()
    texts: ProblemTexts = ProblemTexts()

    @property
    def node(self) -> int | None:
        """The node; None where it happened to several, to the bus or to the capture."""
        return self.subject.node

    @property
    def axis(self) -> int | None:
        """The axis of a drive, from 1, where it is one."""
        return self.subject.axis

    @property
    def pdo(self) -> str | None:
        """A PDO of the node, as `TPDO1`."""
        return self.subject.pdo

    @property
    def findings(self) -> tuple[tuple[str, int], ...]:
        """The codes of the rules that found what belongs to it, each with the frame that shows it; 0: none does."""
        return tuple((one.code, one.frame or 0) for one in self.cited)

    @property
    def count(self) -> int:
        """The number of times that it happened."""
        return self.repeats.count

    @property
    def frames(self) -> tuple[int, ...]:
        """The frames that are its evidence, ascending."""
        ends = [self.end.frame] if self.end else []
        return tuple(sorted({self.begin.frame, self.noticed.frame, *(step.frame for step in self.steps), *ends}))

    def __repr__(self) -> str:
        return f"<Problem {self.id} {self.kind}, {self.status}, frame {self.begin.frame}: {self.message}>"


class ProblemChange(_Happened, frozen=True, gc=False, tag_field="kind", tag="problem"):
    """A change of a problem while a bus is listened to; it may still change."""

    phase: Literal["opened", "linked", "ended"]
    """It begins to show, its cause is known or another, or it has ended."""

    def __repr__(self) -> str:
        return f"<ProblemChange {self.id} {self.kind} {self.phase}, frame {self.begin.frame}: {self.message}>"


class ProblemRow(Struct, frozen=True, gc=False):
    """A row of the table of problems."""

    id: int
    status: Status
    depth: int
    """The number of causes above it."""
    bus: str | None
    subject: str
    begin_frame: int
    """0 of the capture as a whole."""
    end_frame: int | None
    cause: int | None
    delay_ns: int | None
    message: str
    checks: str
    """A line each."""


class NodeView(Struct, frozen=True, gc=False):
    """A node on the first screen of a diagnosis."""

    bus: str | None
    node: int
    problem: int | None
    cells: tuple[str, ...]


class Overview(Struct, frozen=True, gc=False, tag_field="kind", tag="diagnosis"):
    """The whole capture, at the end of a diagnosis."""

    order: tuple[int, ...]
    """The numbers of the problems that come from no other, in the order of reading."""
    nature: str
    """The nature of its buses."""
    begin: str | None
    """The time of the first frame."""
    buses: tuple[str | None, ...]
    nodes: tuple[NodeView, ...]
    extent: str
    notice: str
    """The statement that something was not judged."""
    looked: str
    well: str
    loose_text: str


KEYS: Final = (
    *("kind", "phase", "id", "problem", "incident", "subject", "status", "impact", "grade", "begin", "noticed", "end"),
    *("cause", "effects", "steps", "facts", "checks", "findings", "message", "repeats"),
)
"""Of a problem in JSON lines; `incident` is deprecated, the former name of `problem`."""


def diagnosed(result: bytes) -> tuple[list[Problem], Overview | None]:
    """Returns the problems of a diagnosis, and the overview; None if the diagnosis did not come to its end."""
    return list(records(result, Problem)), next(records(result, Overview), None)
