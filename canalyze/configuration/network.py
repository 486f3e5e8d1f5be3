"""The network as options and canalyze.toml describe it before its capture is read.

Values only: nothing here opens a file or prints. How a node, an identifier or a time is spelled the core knows
(`settings/spelled.rs`), which is loaded when the first one is read. A text that cannot be read is None; whoever has the
text says so in words.
"""

import re
from typing import Final, Literal, NamedTuple

NODES: Final = range(1, 128)

_INTEGER: Final = re.compile(r"0x[0-9a-f]{1,8}|[0-9]{1,8}", re.IGNORECASE)


class CanId(NamedTuple):
    """An identifier; `extended` is the 29-bit format."""

    value: int
    extended: bool


class Description(NamedTuple):
    """A file that describes a device, and who carries it."""

    bus: str | None
    """None is every bus."""
    nodes: tuple[int, ...]
    """None at all: the node that the file names, a DCF."""
    file: str


class Cob(NamedTuple):
    """Which PDO an identifier carries."""

    bus: str | None
    can_id: CanId
    node: int
    direction: Literal["tpdo", "rpdo"]
    number: int

    def overrules(self, other: "Cob") -> bool:
        """Returns true if both cannot hold: one PDO has one identifier, one identifier has one producer."""
        if not _covers(self.bus, other.bus):
            return False
        same_pdo = (self.node, self.direction, self.number) == (other.node, other.direction, other.number)
        return same_pdo or (self.can_id == other.can_id and self.direction == other.direction == "tpdo")


class PdoMapping(NamedTuple):
    """The mapping of a PDO, given by hand."""

    bus: str | None
    """None is every bus."""
    node: int
    direction: Literal["tpdo", "rpdo"]
    number: int
    objects: tuple[tuple[int, int, int], ...]
    """Index, sub-index and value of each object of its mapping parameter."""

    def overrules(self, other: "PdoMapping") -> bool:
        """Returns true if both cannot hold."""
        return _covers(self.bus, other.bus) and self[1:4] == other[1:4]


class NodeProfile(NamedTuple):
    """The profile of nodes without a description."""

    bus: str | None
    nodes: tuple[int, ...]
    number: int


class SdoChannel(NamedTuple):
    """The two identifiers of an SDO channel and the node-ID of its server."""

    bus: str | None
    client: CanId
    """Client to server."""
    server: CanId
    """Server to client."""
    node: int

    def overrules(self, other: "SdoChannel") -> bool:
        """Returns true if both cannot hold: an identifier belongs to one channel."""
        shared = {self.client, self.server} & {other.client, other.server}
        return bool(shared) and _covers(self.bus, other.bus)


class Known(NamedTuple):
    """All that was said in one place: on the command line, or in canalyze.toml."""

    descriptions: tuple[Description, ...] = ()
    cobs: tuple[Cob, ...] = ()
    sdos: tuple[SdoChannel, ...] = ()
    sync_period_ns: int | None = None
    sync_window_ns: int | None = None
    jitter_ns: int | None = None
    bitrate: int | None = None
    """In bit/s."""
    pdos: tuple[PdoMapping, ...] = ()
    profiles: tuple[NodeProfile, ...] = ()

    def overruled(self, by: "Known") -> "Known":
        """Returns what holds of both; descriptions of both, as the node of a DCF is not known yet."""

        def first(one: int | None, other: int | None) -> int | None:
            return other if one is None else one

        return Known(
            self.descriptions + by.descriptions,
            tuple(cob for cob in self.cobs if not any(other.overrules(cob) for other in by.cobs)) + by.cobs,
            tuple(sdo for sdo in self.sdos if not any(other.overrules(sdo) for other in by.sdos)) + by.sdos,
            first(by.sync_period_ns, self.sync_period_ns),
            first(by.sync_window_ns, self.sync_window_ns),
            first(by.jitter_ns, self.jitter_ns),
            first(by.bitrate, self.bitrate),
            tuple(pdo for pdo in self.pdos if not any(other.overrules(pdo) for other in by.pdos)) + by.pdos,
            self.profiles + by.profiles,
        )


def _covers(bus: str | None, other: str | None) -> bool:
    return bus is None or bus == other


def node(text: str) -> int | None:
    """Reads a node-ID."""
    from canalyze import _core

    return _core.node(text)


def nodes(text: str) -> tuple[int, ...] | None:
    """Reads node-IDs: a list of single ones and of ranges such as 1-4."""
    from canalyze import _core

    return _core.nodes(text)


def no_node(text: str, form: str) -> str | None:
    """Returns a number in place of a node-ID that cannot be one, such as the 200 of `200=drive.eds`; None without one.

    form: what was to be read: eds (the node before the sign), cob or sdo (behind it).
    """
    before, _, behind = text.partition("=")
    meant = re.split("[,-]", before.rpartition(":")[2]) if form == "eds" else [behind.partition(".")[0]]
    return next((one.strip() for one in meant if _INTEGER.fullmatch(one.strip()) and node(one.strip()) is None), None)


def can_id(text: str) -> CanId | None:
    """Reads an identifier: up to three hexadecimal digits, or eight for the 29-bit format."""
    from canalyze import _core

    found = _core.can_id(text)
    return None if found is None else CanId(*found)


def pdo(text: str) -> tuple[Literal["tpdo", "rpdo"], int] | None:
    """Reads the name of a PDO, such as TPDO1."""
    from canalyze import _core

    return _core.pdo(text)


def address(text: str) -> tuple[int, int | None] | None:
    """Reads index and sub-index of an object in hexadecimal, 1017:00 (1017h:0, 0x1017:00); no sub-index: all."""
    from canalyze import _core

    return _core.address(text)


def period(text: str) -> int | None:
    """Reads a time above zero, in microseconds or with the suffix us, ms or s; returns nanoseconds."""
    return tolerance(text) or None


def tolerance(text: str) -> int | None:
    """Reads a time as `period` does, or zero."""
    from canalyze import _core

    return _core.tolerance(text)


def bit_rate(text: str) -> int | None:
    """Reads a bit rate in bit/s, or with the suffix k or M."""
    from canalyze import _core

    return _core.bit_rate(text)


def description(text: str) -> Description | None:
    """Reads [BUS:]NODES=FILE, or FILE alone.

    The text before the first "=" is part of the file's name only where it has a "/" and reads as no nodes.
    """
    left, equals, file = text.partition("=")
    bus, carriers = _on_bus(left)
    found = nodes(carriers)
    if equals and found is not None and bus != "":
        return Description(bus, found, file) if file not in ("", "-") else None
    if equals and "/" not in left:
        return None
    return Description(None, (), text) if text not in ("", "-") else None


def cob(text: str) -> Cob | None:
    """Reads [BUS:]ID=NODE.PDO."""
    left, _, right = text.partition("=")
    bus, identifier = _on_bus(left)
    producer, _, name = right.partition(".")
    found, number, which = can_id(identifier), node(producer), pdo(name)
    if bus == "" or found is None or number is None or which is None:
        return None
    return Cob(bus, found, number, *which)


def pdo_mapping(text: str) -> PdoMapping | None:
    """Reads [BUS:]PDO=INDEX[:SUB]:BITS,..., the PDO as a CAN-ID of the pre-defined connection set or as NODE.TPDO1."""
    from canalyze import _core

    left, equals, right = text.partition("=")
    bus, named = _on_bus(left)
    found = _core.pdo_mapping(f"{named}{equals}{right}")
    if bus == "" or found is None:
        return None
    node, direction, number, objects = found
    return PdoMapping(bus, node, direction, number, tuple(objects))


def profile(text: str) -> NodeProfile | None:
    """Reads [BUS:]NODES=PROFILE."""
    from canalyze import _core

    left, _, right = text.partition("=")
    bus, carriers = _on_bus(left)
    found, number = nodes(carriers), _core.profile(right)
    return None if bus == "" or not found or number is None else NodeProfile(bus, found, number)


def sdo_channel(text: str) -> SdoChannel | None:
    """Reads [BUS:]CLIENT,SERVER=NODE."""
    left, _, right = text.partition("=")
    bus, identifiers = _on_bus(left)
    client, server = (can_id(part.strip()) for part in (identifiers.partition(",")[::2]))
    number = node(right)
    if bus == "" or client is None or server is None or client == server or number is None:
        return None
    return SdoChannel(bus, client, server, number)


def _on_bus(text: str) -> tuple[str | None, str]:
    """Splits off the bus, which is before the last colon; None without one."""
    bus, colon, rest = text.rpartition(":")
    return (bus if colon else None), rest
