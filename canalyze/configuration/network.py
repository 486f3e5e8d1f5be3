"""The network as options and canalyze.toml describe it before its capture is read, and as the core's `Network`.

How a node, an identifier or a time is spelled the core knows (`settings/spelled.rs`), which is loaded when the first
one is read. A text that cannot be read is None; whoever has the text says so in words. Each device description is read
once and its defects are reported; the core and python-canopen are imported only where something is known, and where a
description is given.
"""

import os
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

from canalyze.errors import ConfigError, SourceError
from canalyze.output import complain
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze import _core
    from canalyze.dictionary import Dictionary, Row

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
    """The PDO that an identifier carries."""

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


Carrier = tuple[str | None, int]
"""Bus (None is every bus) and node-ID."""


def network(
    filed: Known,
    given: Known,
    words: Words | None,
    say: Callable[[str], None] = complain,
    read: "dict[str, Dictionary] | None" = None,
) -> "_core.Network | None":
    """Returns what the core is to know, None for nothing; `given` (options) overrules `filed` (canalyze.toml).

    words: those of the complaints about descriptions, a line each to `say`; None: they were reported before. read: has
    descriptions that are no files, by their names, and gets those that are read. SourceError
    and ConfigError for a description that cannot be used; ValueError is the core's.
    """
    known = filed.overruled(given)
    if known == Known():
        return None
    from canalyze import _core

    read = {} if read is None else read
    carried = carriers(filed, given, read) if known.descriptions else {}
    for file in dict.fromkeys(carried.values()):
        if words is not None:
            nodes = [node for (_, node), other in carried.items() if other == file]
            _say_other_nodes(read[file], nodes, words, say)
            say_defects(read[file], words, say)
    return _core.Network(
        descriptions=[(_name(bus), node, read[file].table) for (bus, node), file in carried.items()], **_further(known)
    )


def network_rows(filed: Known, given: Known, read: "dict[str, Dictionary] | None" = None) -> dict[str, Any]:
    """Returns the same as plain rows for a core that is elsewhere. Defects of descriptions are not reported."""
    from canalyze.dictionary import arguments

    known = filed.overruled(given)
    read = {} if read is None else read
    carried = carriers(filed, given, read) if known.descriptions else {}
    files = list(dict.fromkeys(carried.values()))
    tables = ((one.file, one.form, one.device.product_name, one.objects) for one in map(read.__getitem__, files))
    return {
        "descriptions": [(_name(bus), node, files.index(file)) for (bus, node), file in carried.items()],
        "dictionaries": [
            {name: _in_64_bits(value) if name == "rows" else value for name, value in arguments(*table).items()}
            for table in tables
        ],
        **_further(known),
    }


def _in_64_bits(rows: "list[Row]") -> "list[Row]":
    """Returns rows whose values are the numbers of 64 bits that the core makes of them."""
    return [(*row[:5], None if row[5] is None else row[5] & (1 << 64) - 1, *row[6:]) for row in rows]


def _further(known: Known) -> dict[str, Any]:
    """Returns what is known beside descriptions, by the arguments of the core."""
    return {
        "cobs": [(_name(cob.bus), *cob.can_id, cob.node, cob.direction, cob.number) for cob in known.cobs],
        "values": [(_name(pdo.bus), pdo.node, *value) for pdo in known.pdos for value in pdo.objects],
        "profiles": [(_name(one.bus), node, one.number) for one in known.profiles for node in one.nodes],
        "sdos": [(_name(sdo.bus), *sdo.client, *sdo.server, sdo.node) for sdo in known.sdos],
        "sync_period_ns": known.sync_period_ns,
        "sync_window_ns": known.sync_window_ns,
        "jitter_ns": known.jitter_ns,
        "bitrate": known.bitrate,
    }


def carriers(filed: Known, given: Known, read: "dict[str, Dictionary]") -> dict[Carrier, str]:
    """Returns the file of each node; what is read goes to `read`, by the name of its file.

    An option for a node puts aside what canalyze.toml says of it; two files of one origin for one node are an error.
    """
    from canalyze.dictionary import load

    chosen: dict[Carrier, str] = {}
    for known in (given, filed):
        overruled = frozenset(chosen)
        for description in known.descriptions:
            bus, file = description.bus, description.file
            nodes = [node for node in description.nodes if not _among(overruled, bus, node)]
            if description.nodes and not nodes:
                continue
            if file not in read:
                read[file] = load(file)
            if not nodes:
                own = read[file].node
                if own is None:
                    raise SourceError("network.no_node", name=file)
                nodes = [] if _among(overruled, bus, own) else [own]
            for node in nodes:
                other = chosen.setdefault((bus, node), file)
                if other != file:
                    raise ConfigError("network.twice", node=node, one=other, other=file)
    return chosen


def carried(filed: Known, given: Known, read: "dict[str, Dictionary]", bus: str | None, node: int) -> str | None:
    """Returns the file that describes a node; None without one, or where no description was read."""
    found = carriers(filed, given, read) if read else {}
    return found.get((bus, node), found.get((None, node)))


def described(name: str, node: int | None, words: Words) -> "Dictionary":
    """Returns a description that is compared, and reports what is odd about it."""
    from canalyze.dictionary import load

    found = load(name, node)
    say_defects(found, words)
    return found


def _among(chosen: frozenset[Carrier], bus: str | None, node: int) -> bool:
    return (None, node) in chosen or (bus, node) in chosen


def _say_other_nodes(found: "Dictionary", nodes: list[int], words: Words, say: Callable[[str], None]) -> None:
    """Reports that a DCF is used for other nodes than its own."""
    others = sorted({node for node in nodes if node != found.node})
    if found.form == "dcf" and found.node is not None and others:
        shown = ", ".join(map(str, others))
        say(f"canalyze: {words('network.other_node', name=found.file, own=found.node, nodes=shown)}")


def say_defects(found: "Dictionary", words: Words, say: Callable[[str], None] = complain) -> None:
    """Reports the defects of a file in one line."""
    import shlex
    from collections import Counter

    from canalyze.dictionary import EFFECTS

    effects: Counter[str] = Counter()
    for defect in found.defects:
        if defect.code == "more":  # further ones that are not listed
            effects[EFFECTS[str(defect.facts["code"])]] += int(str(defect.facts["count"]))
        else:
            effects[defect.effect] += 1
    keys = {"repaired": "network.repaired", "unused": "network.unused"}
    if said := [words(key, count=effects[effect]) for effect, key in keys.items() if effects[effect]]:
        command = f"canalyze eds {shlex.quote(found.file)}"
        listed = words("network.then").join(said)
        say(f"canalyze: {words('network.defects', name=found.file, said=listed, command=command)}")


def _name(bus: str | None) -> str | None:
    """Returns the name of a bus as text, also where the command line had bytes that are no UTF-8."""
    return None if bus is None else os.fsencode(bus).decode("utf-8", "backslashreplace")
