"""The records of the core, typed: the one form in which commands, reports and library have them.

They are decoded from the core's JSON lines and never made here: the meaning of a capture is the core's. Keys that a
record does not list are passed over; `tests/test_records.py` holds each against the schema of the core. It must not
read a capture, judge or print.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from sys import intern
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, TypeVar, Union, get_args

from msgspec import Struct, convert, field
from msgspec.json import Decoder, decode
from msgspec.structs import force_setattr

from canalyze.values import ObjectRef, Timed, object_ref

if TYPE_CHECKING:
    from canopen import ObjectDictionary

R = TypeVar("R", bound=Struct)

Severity = Literal["info", "warning", "error"]
SEVERITIES: Final[tuple[Severity, ...]] = get_args(Severity)
"""From harmless to bad: those of the core."""
Status = Literal["open", "unknown", "ended", "harmless"]
"""The status of a problem at the end: not ended, not known, ended, or explained by a command or by the recording."""
STATUSES: Final[tuple[Status, ...]] = get_args(Status)
FORMER_STATUSES: Final[Mapping[str, Status]] = {"stands": "open", "over": "ended"}
"""Former names, which are still accepted for a release."""
Impact = Literal["A", "B", "C", "D", "E"]
"""The consequence: something has stopped, does not start, works worse, is wrong on the wire only, is worth knowing."""
Grade = Literal["certain", "likely", "possible"]
"""The certainty of a problem or of a cause."""
State = Literal["boot-up", "stopped", "operational", "pre-operational"]
"""NMT states; boot-up is the message, after which a node is pre-operational."""
Value: TypeAlias = int | float | str | None
"""A number; bytes as hexadecimal text, an integer beyond 2^53 as decimal text; None where the payload is too short."""

if TYPE_CHECKING:
    Hex: TypeAlias = int
    HexBytes: TypeAlias = bytes
    Seconds: TypeAlias = float
else:

    class _FromText(type):
        """A type of values that are texts in JSON; `_converted` makes them."""

        def __instancecheck__(cls, value: object) -> bool:
            return True

    class Hex(metaclass=_FromText):
        """An integer, hexadecimal in JSON."""

    class HexBytes(metaclass=_FromText):
        """Bytes, hexadecimal in JSON."""

    class Seconds(metaclass=_FromText):
        """Seconds, a decimal string in JSON."""


def _converted(kind: Any, text: str) -> Any:
    if kind is Hex:  # first: each frame has one
        return int(text, 16)
    return bytes.fromhex(text) if kind is HexBytes else float(text)


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


class Fd(Struct, frozen=True, gc=False):
    """The flags of a CAN FD frame."""

    brs: bool
    esi: bool


class Frame(Timed, Struct, frozen=True, gc=False, tag_field="kind", tag="frame"):
    """A frame of the bus, and what it means given everything before it."""

    frame: int
    """Number in the capture, from 1, over all of its files."""
    line: int | None
    """The line of the file, from 1, where its format has lines."""
    file: str
    """The file."""
    t: str | None
    """Time in seconds as the capture has it, a decimal string with all its digits; None without stamps."""
    bus: str | None
    """The bus, where the capture names it."""
    direction: Literal["rx", "tx"] | None = field(name="dir")
    """Received or sent by the capturing host, where the capture tells."""
    id: Hex
    """The CAN identifier (COB-ID), 11 or 29 bits."""
    extended: bool = field(name="ext")
    """True if the identifier has 29 bits."""
    remote: bool = field(name="rtr")
    """True for a remote frame (RTR)."""
    _fd: Fd | bool = field(name="fd")
    error: bool = field(name="err")
    """True for an error frame of the interface, which was not on the bus as such."""
    length: int = field(name="len")
    """Bytes of data; of a remote frame those asked for."""
    _data: str = field(name="data")
    service: str
    """The service it belongs to, by the names of --filter: nmt, sync, emcy, pdo, sdo, heartbeat ..."""
    node: int | None
    """The node-ID, 1 to 127, where a node is concerned."""
    text: str
    """The meaning, in words."""
    findings: tuple[str, ...]
    """Codes of the findings raised at it; each follows as a `Finding`."""
    _rest: bytes = b""
    """The end of the object from its findings on: most readers never ask for it, and it is most of the work."""

    @property
    def data(self) -> bytes:
        """The data."""
        return bytes.fromhex(self._data)

    @property
    def fd(self) -> bool:
        """True for a CAN FD frame."""
        return self._fd is not False

    @property
    def brs(self) -> bool:
        """Bit rate switch, of CAN FD frames."""
        return isinstance(self._fd, Fd) and self._fd.brs

    @property
    def esi(self) -> bool:
        """Error state indicator, of CAN FD frames."""
        return isinstance(self._fd, Fd) and self._fd.esi

    @property
    def fields(self) -> Mapping[str, Any]:
        """The fields of its service, as the object of that name in `decode --format jsonl`."""
        rest = decode(b"{" + self._rest.removeprefix(b","), type=dict[str, Any]) if self._rest else {}
        return rest.get(self.service) or {}

    def __repr__(self) -> str:
        number = f"{self.id:08X}" if self.extended else f"{self.id:03X}"
        data = f" {self.data.hex(' ').upper()}" if self.data else ""
        return f"<Frame {self.frame}: {number} [{self.length}]{data}: {self.text}>"


class Note(Struct, frozen=True, gc=False, tag_field="kind", tag="note"):
    """A fact that became known only later, at the frame that proves it."""

    note: str
    """request_not_captured, lost_by_reset, node_id_changed ..."""
    frame: int
    """The frame that proves it."""
    line: int | None
    """Its line, where the format has lines."""
    about_frame: int
    """The earlier frame that it is about, or the same."""
    about_line: int | None
    """The line of that frame."""
    bus: str | None
    """The bus, where the capture names it."""
    node: int | None
    """The node-ID, where a node is concerned."""
    transfer: int | None
    """The number of the SDO transfer, where one is concerned."""
    text: str
    """The fact, in words."""
    facts: Mapping[str, Any]
    """The measured values, by the names of `decode --format jsonl`."""

    def __repr__(self) -> str:
        return f"<Note at frame {self.frame}, about frame {self.about_frame}: {self.text}>"


class Abort(Struct, frozen=True, gc=False):
    """The abort of an SDO transfer."""

    code: Hex
    """The SDO abort code (CiA 301 table 22)."""
    by: Literal["client", "server"]
    """The side that aborted it."""
    text: str | None
    """The meaning of the code; None for codes that the standard does not have."""

    def __str__(self) -> str:
        return f"{self.code:08X}h by the {self.by}" + (f": {self.text}" if self.text else "")


class Hole(Struct, frozen=True, gc=False):
    """Bytes of a transfer that the capture does not show."""

    offset: int
    """Their begin in the data of the transfer; their end where nothing behind was seen."""
    length: int | None
    """Their number. None: not known; such a hole takes no room in the data, and what stands behind it has no known
    offset in the object."""


class Transfer(Timed, Struct, frozen=True, gc=False, tag_field="kind", tag="transfer"):
    """An SDO or USDO transfer, as far as the capture has it."""

    number: int = field(name="transfer")
    """Number in the capture, from 1, in the order in which transfers begin."""
    bus: str | None
    """The bus, where the capture names it."""
    node: int
    """Node-ID of the server, 1 to 127."""
    client: int | None
    """Node-ID of the client of a USDO transfer (CANopen FD); None for SDO."""
    session: int | None
    """Session-ID of a USDO transfer, 1 to 255; None for SDO."""
    direction: Literal["upload", "download"]
    """upload reads from the server, download writes to it."""
    mode: str
    """expedited, segmented or block."""
    index: str | None
    """Index of the object, four hexadecimal digits; None where its first frame is not in the capture."""
    sub: int | None
    """Its sub-index."""
    name: str | None
    """The object's name, by the description of the node or the standard."""
    type: str | None
    """Its data type, such as UNSIGNED16, where it is known."""
    size_indicated: int | None
    """Bytes as announced, where they were."""
    size: int
    """Bytes that were transferred, up to the last one that was seen; holes of known length count."""
    data: HexBytes
    """The bytes, the first 65536 of them; 0 in holes."""
    value: int | float | str | bool | None
    """The value by its data type; None for bytes, for unknown types and for transfers that are not ok."""
    text: str
    """The value in words."""
    status: Literal["ok", "aborted", "incomplete", "failed"]
    """incomplete: the capture has not all of it, which is no fault."""
    abort: Abort | None
    """The abort, if it was aborted."""
    first_frame: int
    """Its first frame."""
    last_frame: int
    """Its last frame."""
    t: str | None
    """Time of its first frame in seconds, a decimal string with all its digits; None without stamps."""
    duration: Seconds | None
    """Seconds from its first frame to its last; None without stamps."""
    reordered: bool
    """True if a request was captured after its response."""
    retransmissions: int
    """Segments of a block transfer that were sent again."""
    crc_negotiated: bool | None
    """True if a block transfer has a CRC; None for other modes."""
    findings: tuple[str, ...]
    """Codes of the findings about it."""
    holes: tuple[Hole, ...] = ()
    """The missing parts of its data, by place: empty where nothing is, or where no byte was seen."""

    def __post_init__(self) -> None:
        """Makes integers of those beyond 2^53, which are texts in JSON."""
        if isinstance(self.value, str) and self.type and self.type.startswith(("INTEGER", "UNSIGNED")):
            force_setattr(self, "value", int(self.value))

    @property
    def object(self) -> ObjectRef | None:
        """The object as the standard writes it, 1017h:00; None where it is not known."""
        return object_ref(self.index, self.sub)

    @property
    def duration_ns(self) -> int | None:
        """Nanoseconds from its first frame to its last; None without stamps."""
        return None if self.duration is None else round(self.duration * 1e9)

    def __repr__(self) -> str:
        if self.status == "ok":
            shown = repr(self.value) if self.value is not None else f"{self.size} bytes"
            outcome = f"= {shown}"
        else:
            outcome = f"{self.status} {self.abort.code:08X}h" if self.abort else self.status
        frames = f"frames {self.first_frame}-{self.last_frame}"
        return f"<Transfer {self.number}: node {self.node} {self.direction} {self.object or '?'} {outcome}, {frames}>"


class Signal(Timed, Struct, frozen=True, gc=False, tag_field="kind", tag="signal"):
    """One value of one signal."""

    t: str | None
    """Time of the frame in seconds, a decimal string with all its digits; None without stamps."""
    frame: int
    """Number of the frame, from 1."""
    bus: str | None
    """The bus, where the capture names it."""
    node: int
    """Node-ID of the PDO's owner."""
    pdo: str
    """The PDO: TPDO1."""
    signal: str
    """The signal's name, as a line of `decode` has it."""
    value: Value
    """The value with sign, type and factor applied, in `unit`."""
    raw: Value
    """The unsigned number in the payload."""
    unit: str | None
    """The unit, by the description of the device."""
    provenance: str
    """The source of the mapping: observed, option, dcf or eds."""
    index: str
    """Index of the mapped object, four hexadecimal digits."""
    sub: int
    """Its sub-index."""
    text: str | None
    """The value in words."""

    @property
    def object(self) -> ObjectRef:
        """The object as the standard writes it, 6041h:00."""
        return ObjectRef(int(self.index, 16), self.sub)

    def __repr__(self) -> str:
        value = f"{self.value!r} {self.unit}" if self.unit else repr(self.value)
        return f"<Signal {self.node}.{self.pdo}.{self.signal} = {value}, frame {self.frame}>"


class StateChange(Timed, Struct, frozen=True, gc=False):
    """A node has entered a state."""

    state: State | None = field(name="name")
    """The state; None for a number that the standard does not have."""
    number: Hex = field(name="state")
    """The number of the state."""
    text: str | None
    """The state in words."""
    t: str | None
    """Time in seconds, a decimal string with all its digits; None without stamps."""
    frame: int
    """The frame that shows it."""
    commanded: bool
    """True if the node, which sends no state, was only told to enter it."""


class Spread(Struct, frozen=True, gc=False):
    """Times that were measured, in microseconds."""

    count: int
    """The number of them."""
    min_us: float
    """The least."""
    mean_us: float
    """The mean."""
    max_us: float
    """The greatest."""
    sigma_us: float
    """The standard deviation."""
    p99_us: float | None = None
    """99 % of them are not above this, which is at most 3.2 % too high; None where it is not kept."""


class Emcy(Struct, frozen=True, gc=False):
    """An EMCY error code that a node sent."""

    code: Hex
    """The error code, as 8130h."""
    text: str | None
    """The meaning of the code."""
    count: int
    """The number of times."""
    first_frame: int
    """The first frame with it."""
    last_frame: int
    """The last frame with it."""


class Aborts(Struct, frozen=True, gc=False):
    """SDO transfers that were aborted with one code by one side."""

    digits: str = field(name="code")
    """The abort code, hexadecimal: 8 digits of SDO, 2 of USDO."""
    by: Literal["client", "server"]
    """The side that aborted."""
    text: str | None
    """The meaning of the code."""
    count: int
    """The number of times."""
    first_frame: int
    """The first of these aborts."""
    last_frame: int
    """The last of them."""

    @property
    def code(self) -> int:
        """The abort code."""
        return int(self.digits, 16)


class SdoCounts(Struct, frozen=True, gc=False):
    """The SDO transfers of a node by how they ended."""

    transfers: int
    ok: int
    aborted: int
    failed: int
    incomplete: int


class Node(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_node"):
    """A node that was seen or addressed."""

    bus: str | None
    """The bus, where the capture names it."""
    node: int
    """The node-ID, 1 to 127."""
    name: str | None
    """The device's name, by its description or by 1008h; None where neither is known."""
    frames: int
    """Frames that belong to it."""
    sent: int
    """Frames that it sent."""
    tpdos: int = field(name="tpdo")
    """PDOs that it sent."""
    rpdos: int = field(name="rpdo")
    """PDOs that it was sent."""
    tpdo_rate: float | None
    """Those that it sent in a second; None without stamps."""
    rpdo_rate: float | None
    """Those that it was sent in a second; None without stamps."""
    state: State | None = field(name="state_name")
    """The last NMT state; None where nothing tells."""
    state_number: Hex | None = field(name="state")
    """The number of that state."""
    state_text: str | None
    """That state in words."""
    lost: bool
    """Its heartbeats, or answers to node guarding, stopped and did not come back: `state` is that before."""
    states: tuple[StateChange, ...]
    """The states that it entered, in order, the first 64."""
    changes: int
    """The number of times that it entered a state."""
    boot_ups: int
    """Boot-up messages."""
    error_control: Literal["heartbeat", "guarding"] | None
    """The kind of monitoring; None where it is not monitored."""
    heartbeats: int
    """Heartbeats, or answers to node guarding."""
    heartbeat: Spread | None
    """Time from heartbeat to heartbeat; None where nothing was measured."""
    sdo: SdoCounts
    response: Spread | None
    """Time from an SDO request to its response; None where nothing was measured."""
    aborts: tuple[Aborts, ...]
    """SDO aborts by code, at most 32 kinds."""
    emcy_count: int = field(name="emcys")
    """EMCY messages."""
    emcys: tuple[Emcy, ...] = field(name="emcy")
    """EMCYs by error code, at most 32 kinds."""
    _dictionary: Any = None

    @property
    def transfers(self) -> int:
        """SDO transfers with it as the server."""
        return self.sdo.transfers

    @property
    def ok(self) -> int:
        """Its SDO transfers that came to their end."""
        return self.sdo.ok

    @property
    def aborted(self) -> int:
        """Its SDO transfers that were aborted."""
        return self.sdo.aborted

    @property
    def failed(self) -> int:
        """Its SDO transfers that broke the protocol or had no answer."""
        return self.sdo.failed

    @property
    def incomplete(self) -> int:
        """Its SDO transfers that are cut by an end of the capture, which is no fault."""
        return self.sdo.incomplete

    @property
    def dictionary(self) -> "ObjectDictionary | None":
        """Its description as python-canopen has it, made when it is asked for; None where none was given.

        An `ObjectDictionary` that was given is that one itself; of a file, values that depend on the node-ID are those
        of this node.
        """
        return self._dictionary and self._dictionary(self.bus, self.node)  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        bus = f" on {self.bus}" if self.bus else ""
        name = f" {self.name!r}" if self.name else ""
        return f"<Node {self.node}{bus}{name}: {self.state or 'state unknown'}, {self.frames} frames>"


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


Event: TypeAlias = Frame | Note | Finding | Transfer | ProblemChange
"""Anything that a capture yields, in order; a `ProblemChange` only while it is listened to."""

KEYS: Final = (
    *("kind", "phase", "id", "problem", "incident", "subject", "status", "impact", "grade", "begin", "noticed", "end"),
    *("cause", "effects", "steps", "facts", "checks", "findings", "message", "repeats"),
)
"""Of a problem in JSON lines; `incident` is deprecated, the former name of `problem`."""


@cache
def _decoder(*kinds: type[Struct]) -> Callable[[bytes], Any]:
    return Decoder(Union[kinds], dec_hook=_converted).decode  # noqa: UP007  as many as there are


@cache
def _begins(*kinds: type[Struct]) -> tuple[bytes, ...]:
    return tuple(f'{{"kind":"{kind.__struct_config__.tag}"'.encode() for kind in kinds)


def records(result: bytes, *kinds: type[R]) -> Iterator[R]:
    """Yields the records of these kinds in complete JSON lines of the core."""
    read, begins = _decoder(*kinds), _begins(*kinds)
    for line in result.splitlines():
        if line.startswith(begins):
            yield read(line)


def lines(result: bytes) -> Iterator[Line]:
    """Yields the annotated lines of frames in JSON lines; those of one frame are one text."""
    yield from map(_decoder(Line), result.splitlines())


def diagnosed(result: bytes) -> tuple[list[Problem], Overview | None]:
    """Returns the problems of a diagnosis, and the overview; None if the diagnosis did not come to its end."""
    return list(records(result, Problem)), next(records(result, Overview), None)


def of_rows(rows: Any, *kinds: type[R]) -> list[R]:
    """Returns the records of these kinds that were decoded as JSON, as those that a fleet has stored."""
    found: list[R] = convert(rows, list[Union[kinds]], dec_hook=_converted)  # type: ignore[valid-type]  # noqa: UP007
    return found


_FRAME: Final = b'{"kind":"frame",'
_CHANGE: Final = b'{"kind":"problem","phase":'
_FINAL: Final = b'{"kind":"problem","phase":"final"'
_FINDINGS: Final = b',"findings":['
"""Stands in a frame's object once: within a text its quotes would be escaped."""


def events(result: bytes) -> Iterator[Event | Problem | Overview]:
    """Yields everything in complete JSON lines of the core, at their end the problems and the overview."""
    frame, change = _decoder(Frame), _decoder(ProblemChange)
    other = _decoder(Note, Finding, Transfer, Problem, Overview)
    for line in result.splitlines():
        if line.startswith(_FRAME):
            one: Frame = frame(line)
            # There are few different words, and each frame has its own copy.
            force_setattr(one, "file", intern(one.file))
            force_setattr(one, "service", intern(one.service))
            if one.bus is not None:
                force_setattr(one, "bus", intern(one.bus))
            force_setattr(one, "_rest", line[line.index(_FINDINGS) :])
            yield one
        elif line.startswith(_CHANGE) and not line.startswith(_FINAL):
            yield change(line)
        else:
            yield other(line)
