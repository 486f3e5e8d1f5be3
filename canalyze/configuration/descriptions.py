"""The known network as the core's `Network`: reads each device description once and reports its defects.

The core and python-canopen are imported only where something is known, and where a description is given.
"""

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from canalyze.configuration.network import Known
from canalyze.errors import ConfigError, SourceError
from canalyze.output import complain
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze import _core
    from canalyze.dictionary import Dictionary, Row

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

    words: what is odd about a description is said in them, a line each to `say`; None: it was said before. read: has
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
