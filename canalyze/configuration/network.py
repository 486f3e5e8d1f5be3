"""What a user says of a network before its capture is read: the values behind the options and behind canalyze.toml.

Values only: nothing here opens a file, prints, or knows the core. A text that cannot be read is None; whoever has the
text says so in words. COB-IDs are written in hexadecimal, node-IDs in decimal or in hexadecimal with 0x.
"""

import re
from typing import Final, Literal, NamedTuple

NODES: Final = range(1, 128)
MOST_PDOS: Final = 512
BIT_RATES: Final = range(1_000, 1_000_001)
"""Of classic CAN, in bit/s: 125 for 125k is a slip, no rate."""

_LONGEST_US: Final = 0xFFFF_FFFF
"""The range of 1006h and 1007h, which are UNSIGNED32 in microseconds."""
_STANDARD: Final = 0x7FF
_EXTENDED: Final = 0x1FFF_FFFF
_MICROSECONDS: Final = {"": 1, "us": 1, "\u00b5s": 1, "\u03bcs": 1, "ms": 1_000, "s": 1_000_000}
_BITS: Final = {"": 1, "k": 1_000, "m": 1_000_000}

_INTEGER: Final = re.compile(r"0x[0-9a-f]{1,8}|[0-9]{1,8}", re.IGNORECASE)
_IDENTIFIER: Final = re.compile(r"(?:0x)?([0-9a-f]{1,3}|[0-9a-f]{8})", re.IGNORECASE)
_PDO: Final = re.compile(r"([tr]pdo)([0-9]{1,3})", re.IGNORECASE)
_OBJECT: Final = re.compile(r"(?:0x)?([0-9a-f]{4})h?(?::(?:0x)?([0-9a-f]{1,2})h?)?", re.IGNORECASE)
_AMOUNT: Final = re.compile(r"([0-9]{1,12}(?:\.[0-9]{1,12})?|\.[0-9]{1,12})\s*([a-z\u00b5\u03bc]*)", re.IGNORECASE)


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
        """Tell whether both cannot hold: one PDO has one identifier, one identifier has one producer."""
        if not _covers(self.bus, other.bus):
            return False
        same_pdo = (self.node, self.direction, self.number) == (other.node, other.direction, other.number)
        return same_pdo or (self.can_id == other.can_id and self.direction == other.direction == "tpdo")


class SdoChannel(NamedTuple):
    """The two identifiers of an SDO channel and the node-ID of its server."""

    bus: str | None
    client: CanId
    """Client to server."""
    server: CanId
    """Server to client."""
    node: int

    def overrules(self, other: "SdoChannel") -> bool:
        """Tell whether both cannot hold: an identifier belongs to one channel."""
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

    def overruled(self, by: "Known") -> "Known":
        """Give what holds of both; descriptions of both, for which node a DCF names is not known yet."""

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
        )


def _covers(bus: str | None, other: str | None) -> bool:
    return bus is None or bus == other


def node(text: str) -> int | None:
    """Read a node-ID."""
    if not _INTEGER.fullmatch(text):
        return None
    number = int(text, 16 if text[:2].lower() == "0x" else 10)
    return number if number in NODES else None


def nodes(text: str) -> tuple[int, ...] | None:
    """Read node-IDs: a list of single ones and of ranges such as 1-4."""
    found: dict[int, None] = {}
    for part in text.split(","):
        first, dash, last = (end.strip() for end in part.partition("-"))
        low, high = node(first), node(last if dash else first)
        if low is None or high is None or low > high:
            return None
        found.update(dict.fromkeys(range(low, high + 1)))
    return tuple(found)


def no_node(text: str, form: str) -> str | None:
    """Give the number that stands for a node-ID and is none, such as the 200 of `200=drive.eds`; None if none does.

    form: what was to be read: eds (the node before the sign), cob or sdo (behind it).
    """
    before, _, behind = text.partition("=")
    meant = re.split("[,-]", before.rpartition(":")[2]) if form == "eds" else [behind.partition(".")[0]]
    return next((one.strip() for one in meant if _INTEGER.fullmatch(one.strip()) and node(one.strip()) is None), None)


def can_id(text: str) -> CanId | None:
    """Read an identifier: up to three hexadecimal digits, or eight for the 29-bit format."""
    match = _IDENTIFIER.fullmatch(text)
    if match is None:
        return None
    extended = len(match[1]) == 8
    value = int(match[1], 16)
    return CanId(value, extended) if value <= (_EXTENDED if extended else _STANDARD) else None


def pdo(text: str) -> tuple[Literal["tpdo", "rpdo"], int] | None:
    """Read the name of a PDO, such as TPDO1."""
    match = _PDO.fullmatch(text)
    if match is None or not 1 <= int(match[2]) <= MOST_PDOS:
        return None
    return ("tpdo" if match[1].lower() == "tpdo" else "rpdo"), int(match[2])


def address(text: str) -> tuple[int, int | None] | None:
    """Read index and sub-index of an object, 1017:00 in hexadecimal (1017h:0, 0x1017:00); no sub-index: all of them."""
    match = _OBJECT.fullmatch(text)
    if match is None:
        return None
    return int(match[1], 16), None if match[2] is None else int(match[2], 16)


def period(text: str) -> int | None:
    """Read a time above zero, in microseconds or with the suffix us, ms or s; give it in nanoseconds."""
    return tolerance(text) or None


def tolerance(text: str) -> int | None:
    """Read a time as `period` does, or zero."""
    amount = _scaled(text, _MICROSECONDS)
    return None if amount is None else nanoseconds(amount)


def nanoseconds(us: float) -> int | None:
    """Give microseconds, which may have decimals, in nanoseconds; None if no object could hold them."""
    return round(us * 1000) if 0 <= us <= _LONGEST_US else None


def bit_rate(text: str) -> int | None:
    """Read a bit rate in bit/s, or with the suffix k or M."""
    rate = _scaled(text, _BITS)
    return int(rate) if rate is not None and rate in BIT_RATES else None


def _scaled(text: str, units: dict[str, int]) -> float | None:
    """Read a number with a unit; in decimal, so that 0.1 ms is exactly that."""
    from fractions import Fraction

    match = _AMOUNT.fullmatch(text)
    unit = units.get(match[2].lower()) if match else None
    if match is None or unit is None:
        return None
    scaled = Fraction(match[1]) * unit
    return scaled.numerator if scaled.denominator == 1 else float(scaled)


def description(text: str) -> Description | None:
    """Read [BUS:]NODES=FILE, or FILE alone.

    What stands before the first "=" is part of the file's name only where it has a "/" and reads as no nodes.
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
    """Read [BUS:]ID=NODE.PDO."""
    left, _, right = text.partition("=")
    bus, identifier = _on_bus(left)
    producer, _, name = right.partition(".")
    found, number, which = can_id(identifier), node(producer), pdo(name)
    if bus == "" or found is None or number is None or which is None:
        return None
    return Cob(bus, found, number, *which)


def sdo_channel(text: str) -> SdoChannel | None:
    """Read [BUS:]CLIENT,SERVER=NODE."""
    left, _, right = text.partition("=")
    bus, identifiers = _on_bus(left)
    client, server = (can_id(part.strip()) for part in (identifiers.partition(",")[::2]))
    number = node(right)
    if bus == "" or client is None or server is None or client == server or number is None:
        return None
    return SdoChannel(bus, client, server, number)


def _on_bus(text: str) -> tuple[str | None, str]:
    """Split off the bus, which stands before the last colon; None if there is none."""
    bus, colon, rest = text.rpartition(":")
    return (bus if colon else None), rest
