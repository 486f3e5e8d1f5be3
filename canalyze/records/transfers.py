"""The transfers of SDO and USDO."""

from typing import Literal

from msgspec import Struct, field
from msgspec.structs import force_setattr

from canalyze.records import HexBytes, Seconds
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
