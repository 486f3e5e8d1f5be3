"""The transfers of SDO and USDO, and the objects of devices by what the traffic shows of them."""

from typing import Literal

from msgspec import Struct, field
from msgspec.structs import force_setattr

from canalyze.records import Hex, HexBytes, Seconds, Value
from canalyze.values import ObjectRef, Timed, object_ref


class Abort(Struct, frozen=True, gc=False):
    """The abort of an SDO transfer."""

    digits: str = field(name="code")
    """The abort code, hexadecimal: 8 digits of SDO, 2 of USDO."""
    by: Literal["client", "server"]
    """The side that aborted it."""
    text: str | None
    """The meaning of the code; None for codes that the standard does not have."""

    @property
    def code(self) -> int:
        """The abort code (CiA 301 table 22)."""
        return int(self.digits, 16)

    def __str__(self) -> str:
        return f"{self.code:08X}h by the {self.by}" + (f": {self.text}" if self.text else "")


class Hole(Struct, frozen=True, gc=False):
    """Bytes of a transfer that the capture does not show."""

    offset: int
    """Their begin in the data of the transfer; their end where nothing behind was seen."""
    length: int | None
    """Their number. None: not known; such a hole takes no room in the data, and the bytes after it have no known
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


class Head(Struct, frozen=True, gc=False, tag_field="kind", tag="od_node"):
    """A device; its objects follow. Numbers of its identity are hexadecimal texts."""

    bus: str | None
    node: int
    objects: int
    values: int
    further: int
    """Objects for which there was no room."""
    booted: bool
    device_type: str | None
    vendor_id: str | None
    product_code: str | None
    revision: str | None
    serial: str | None
    profile: int | None
    device_name: str | None


class Refusal(Struct, frozen=True, gc=False):
    """Aborts of transfers of one object, with one code by one side."""

    request: Literal["upload", "download"]
    code: str
    by: Literal["client", "server"]
    text: str | None
    count: int
    frame: int


class Written(Struct, frozen=True, gc=False):
    """The last value that was written to an object and accepted; `data` may have less than `size` bytes."""

    data: HexBytes
    size: int
    frame: int

    @property
    def whole(self) -> bytes | None:
        """The data; None if a part of them is missing."""
        return self.data if len(self.data) == self.size else None


class First(Struct, frozen=True, gc=False):
    """The first value that was read of an object before it was written."""

    data: HexBytes
    size: int
    booted: bool
    """True if the node has booted in the capture before."""
    frame: int


class Held(Struct, frozen=True, gc=False):
    """The value of an object if it is known."""

    text: str | None


class Sizes(Struct, frozen=True, gc=False):
    """The least and the greatest number of bytes that were transferred."""

    read: tuple[int, int] | None
    written: tuple[int, int] | None


class Object(Struct, frozen=True, gc=False, tag_field="kind", tag="od_object"):
    """An object of a device, with its last value. What is not known is None."""

    bus: str | None
    node: int
    index: str
    sub: int
    name: str | None
    type: str | None
    type_from: str | None
    bits: int | None
    access: str | None
    readable: bool | None
    writable: bool | None
    exists: bool | None
    value: int | float | str | bool | None
    text: str | None
    data: HexBytes | None
    source: str | None
    t: str | None
    frame: int | None
    values: int
    varies: bool
    read: int
    written: int
    tpdo: int
    rpdo: int
    emcy: int
    refused: int
    unconfirmed: int
    requested: Value
    configured: Written | None
    aborts: tuple[Refusal, ...]
    in_force: Held | None
    first: First | None
    sizes: Sizes
    extremes: tuple[HexBytes, ...]
    """The least and the greatest value, where they are numbers."""
    last_frame: int

    @property
    def address(self) -> tuple[int, int]:
        """Index and sub-index."""
        return int(self.index, 16), self.sub


class Pdo(Struct, frozen=True, gc=False, tag_field="kind", tag="od_pdo"):
    """A PDO that was seen on the wire."""

    bus: str | None
    node: int
    id: Hex
    extended: bool = field(name="ext")
    length_min: int
    length_max: int


class RefusedValue(Struct, frozen=True, gc=False):
    """Why there is no value."""

    code: str
    text: str | None


class ObjectValue(Struct, frozen=True, gc=False, tag_field="kind", tag="od_value"):
    """One value of an object, or a request that was refused."""

    bus: str | None
    node: int
    index: str
    sub: int
    name: str | None
    source: str
    text: str
    t: str | None
    frame: int
    abort: RefusedValue | None


class Word(Struct, frozen=True, gc=False):
    """The name of a value."""

    value: int
    text: str


class MappedObject(Struct, frozen=True, gc=False):
    """An object in a PDO."""

    node: int | None
    address: int | None
    """The value of the first four bytes under which a multiplexed PDO has it."""
    index: str
    sub: int
    name: str
    offset: int
    bits: int
    number: str
    """unsigned, signed, real or bytes."""
    unit: str | None
    factor: str
    words: tuple[Word, ...]


class MappedPdo(Struct, frozen=True, gc=False, tag_field="kind", tag="pdo"):
    """A PDO with its communication parameter and its content."""

    bus: str | None
    node: int
    id: str
    extended: bool = field(name="ext")
    transmit: bool
    pdo: str
    frames: int
    content: str
    """mapped, a kind of multiplexed PDO, or why nothing is known."""
    changes: int
    further: int
    type: int | None
    event_timer: int | None
    sync_ns: int | None
    bits: int
    signals: tuple[MappedObject, ...]
