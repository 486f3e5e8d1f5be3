"""The objects of devices, by what the traffic shows of them."""

from typing import Literal

from msgspec import Struct, field

from canalyze.records import Hex, HexBytes, Value


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
