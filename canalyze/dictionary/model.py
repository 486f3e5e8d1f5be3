"""What a device description says, typed and frozen. Knows neither files nor python-canopen nor words.

`$NODEID` stays unresolved (`NodeOffset`), so that one description serves every node that carries it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

Access = Literal["ro", "wo", "rw", "rwr", "rww", "const"]
Direction = Literal["rpdo", "tpdo"]
Effect = Literal["repaired", "unused", "noted"]

NULL, DOMAIN, DEFTYPE, DEFSTRUCT, VAR, ARRAY, RECORD = 0, 2, 5, 6, 7, 8, 9
"""Object codes, CiA 301 7.4.3."""


@dataclass(frozen=True, slots=True)
class NodeOffset:
    """A number that stands for node-ID + offset."""

    offset: int

    def at(self, node: int) -> int:
        """Give the number for one node."""
        return self.offset + node


Value = int | float | str | bytes | NodeOffset


@dataclass(frozen=True, slots=True)
class Entry:
    """One sub-object, or an object that is a single variable (sub 0)."""

    index: int
    sub: int
    name: str
    type: int
    """Data type code as the file has it (CiA 301 7.4.7); 0 where it has none."""
    access: Access
    default: Value | None
    """DefaultValue, None if empty or missing."""
    parameter: Value | None
    """ParameterValue of a DCF, None if empty or missing."""
    mappable: bool
    low: int | float | None
    high: int | float | None
    unit: str
    factor: float
    line: int

    @property
    def value(self) -> Value | None:
        """What the device starts with: the parameter value of a DCF, else the default."""
        return self.default if self.parameter is None else self.parameter


@dataclass(frozen=True, slots=True)
class Object:
    """One index of the dictionary."""

    index: int
    name: str
    code: int
    """Object code: DOMAIN, VAR, ARRAY or RECORD."""
    entries: tuple[Entry, ...]
    """By sub-index, ascending."""
    line: int

    def entry(self, sub: int) -> Entry | None:
        """Give the entry of one sub-index."""
        return next((entry for entry in self.entries if entry.sub == sub), None)


@dataclass(frozen=True, slots=True)
class CobId:
    """A COB-ID entry of a PDO (CiA 301 7.5.2.35 and .37), taken apart."""

    valid: bool
    """Bit 31 is 0: the PDO exists."""
    rtr_allowed: bool
    """Bit 30 is 0; only of a TPDO."""
    extended: bool
    """Bit 29 is 1: a 29-bit identifier."""
    base: int
    """The identifier, without the node-ID where `relative`."""
    relative: bool
    """The node-ID is to be added."""
    assumed: bool = False
    """Not in the file: the pre-defined connection set, or no PDO at all."""

    def at(self, node: int | None) -> int | None:
        """Give the identifier for a node; None if that needs a node-ID and there is none."""
        if not self.relative:
            return self.base
        return None if node is None else self.base + node


@dataclass(frozen=True, slots=True)
class Mapped:
    """One entry of a mapping: `bits` bits of the payload from bit `offset` on."""

    index: int
    sub: int
    offset: int
    bits: int
    entry: Entry | None
    """The mapped object; None if the file does not have it, or for a dummy."""
    dummy: bool
    """The index is a data type: these bits are skipped."""


@dataclass(frozen=True, slots=True)
class Pdo:
    """One PDO as the device starts with it."""

    number: int
    direction: Direction
    cob_id: CobId
    transmission: int | None
    inhibit: int | None
    """In 100 us."""
    event_timer: int | None
    """In ms."""
    sync_start: int | None
    multiplex: Literal["sam", "dam"] | None
    """An MPDO: it has no mapping."""
    mapped: tuple[Mapped, ...]
    line: int

    @property
    def bits(self) -> int:
        """Length of the payload."""
        return sum(entry.bits for entry in self.mapped)


@dataclass(frozen=True, slots=True)
class FileInfo:
    """Section FileInfo, as written."""

    name: str = ""
    version: str = ""
    revision: str = ""
    eds_version: str = ""
    description: str = ""
    created: str = ""
    """Date, time and author."""
    modified: str = ""
    """Date, time and author."""


@dataclass(frozen=True, slots=True)
class Device:
    """Section DeviceInfo; None where the file does not say."""

    vendor_name: str | None
    vendor_number: int | None
    product_name: str | None
    product_number: int | None
    revision_number: int | None
    order_code: str | None
    bit_rates: tuple[int, ...]
    """In bit/s."""
    rpdos: int | None
    """NrOfRXPDO."""
    tpdos: int | None
    lss: bool | None


@dataclass(frozen=True, slots=True)
class Defect:
    """What had to be repaired, could not be used, or does not agree with itself."""

    line: int
    """0 where no line is to blame."""
    code: str
    """A key of EFFECTS; its words are `defect.CODE`."""
    facts: Mapping[str, object] = field(default_factory=dict)

    @property
    def effect(self) -> Effect:
        """What became of it."""
        return EFFECTS[self.code]


@dataclass(frozen=True, slots=True)
class Dictionary:
    """One device description."""

    file: str
    form: Literal["eds", "dcf", "xdd"]
    encoding: str
    info: FileInfo
    device: Device
    comments: tuple[str, ...]
    node: int | None
    """As asked for, else as a DCF says."""
    node_name: str
    bit_rate: int | None
    """Of a DCF, in bit/s."""
    objects: tuple[Object, ...]
    """By index, ascending."""
    dummies: frozenset[int]
    """Data types that may be mapped to skip bits."""
    pdos: tuple[Pdo, ...]
    """RPDOs, then TPDOs, by number."""
    defects: tuple[Defect, ...]
    """By line."""

    def object(self, index: int) -> Object | None:
        """Give the object of one index."""
        from bisect import bisect_left

        place = bisect_left(self.objects, index, key=lambda found: found.index)
        return self.objects[place] if place < len(self.objects) and self.objects[place].index == index else None

    def entry(self, index: int, sub: int) -> Entry | None:
        """Give one entry."""
        found = self.object(index)
        return found.entry(sub) if found else None


EFFECTS: Final[dict[str, Effect]] = {
    # The text.
    "encoding": "repaired",
    "bom": "repaired",
    "no-equals": "unused",
    "no-section": "unused",
    "section-bracket": "repaired",
    "section-name": "repaired",
    "section-unused": "unused",
    "duplicate-section": "repaired",
    "duplicate-key": "repaired",
    "commissioning": "repaired",
    "modules": "unused",
    "more": "noted",
    # Numbers and values.
    "not-a-number": "unused",
    "not-bytes": "unused",
    "octal": "repaired",
    "trailing-comment": "repaired",
    "nodeid-form": "repaired",
    "real-as-hex": "repaired",
    "wrapped": "repaired",
    "out-of-range": "unused",
    "node-id": "unused",
    # Objects.
    "missing-key": "repaired",
    "access": "repaired",
    "unknown-type": "repaired",
    "object-type": "repaired",
    "no-index-section": "repaired",
    "no-lists": "noted",
    "unlisted": "noted",
    "not-there": "unused",
    "count": "noted",
    "no-such-sub": "unused",
    "dummy-missing": "repaired",
    "too-many": "unused",
    # PDOs.
    "cob-id": "noted",
    "mapping-missing": "noted",
    "mapping-count": "noted",
    "mapping-length": "noted",
    "mapped-unknown": "noted",
    "mapped-size": "noted",
}
"""Every code of a defect and what became of what it names."""
