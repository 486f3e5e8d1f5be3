"""A file before anything in it is decoded, and a capture in figures.

Times of the figures are in microseconds, rates in frames a second, loads in percent of the bit rate. All are None
without stamps, loads without a bit rate, peaks where the capture is shorter than their window.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from msgspec import Struct, field

from canalyze.records import Hex, Severity
from canalyze.values import Timed

if TYPE_CHECKING:
    from canopen import ObjectDictionary


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


State = Literal["boot-up", "stopped", "operational", "pre-operational"]
"""NMT states; boot-up is the message, after which a node is pre-operational."""


class Capture(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_capture"):
    """The capture as a whole."""

    files: int
    frames: int
    unstamped: int
    buses: int
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


class Sync(Struct, frozen=True, gc=False, tag_field="kind", tag="summary_sync"):
    """SYNC on a bus."""

    bus: str | None
    frames: int
    period: Spread | None
    counter_min: int | None
    counter_max: int | None
    counter_jumps: int | None


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
