"""PDOs -> a DBC file, written by cantools, for decoding by other tools.

PDOs, the bits of their signals and their types come from the core; here they get names that are valid in a DBC. Parts
that a DBC cannot hold are listed, each with a key of `words` and its facts. cantools is imported only if a file is
written.
"""

import math
import re
import unicodedata
from collections import OrderedDict
from collections.abc import Callable, Iterator
from itertools import groupby
from typing import TYPE_CHECKING, Final, NamedTuple

from canalyze.errors import CanalyzeError, OutputError
from canalyze.records import records
from canalyze.records.objects import MappedObject, MappedPdo

if TYPE_CHECKING:
    from cantools.database.can import Message, Signal
    from cantools.database.namedsignalvalue import NamedSignalValue

    from canalyze.dictionary.model import Entry

Described = Callable[[str | None, int, int, int], "Entry | None"]
"""Returns the entry of a description for bus, node-ID, index and sub-index."""
Said = tuple[str, dict[str, object]]
"""A key of `words`, and its facts."""

ENCODING: Final = "cp1252"
"""The encoding of DBC files."""
_MOST_BITS: Final = 64
_ADDRESS: Final = "address"
"""The first four bytes of a multiplex PDO."""
_ADDRESS_BITS: Final = 32
_CYCLIC: Final = range(1, 241)
_EVENTS: Final = (254, 255)
_SAYS: Final = {kind: f"dbc.{kind}" for kind in ("unknown", "contradicted", "disabled")}


class Made(NamedTuple):
    """A DBC file."""

    data: bytes
    messages: int
    signals: int
    said: tuple[Said, ...]
    """The parts of the PDOs that are missing or changed in the file."""


def made(result: bytes, described: Described) -> Made:
    """Returns the DBC of one bus, by JSON lines of the core.

    Raises CanalyzeError if cantools is not installed, and OutputError if there is nothing to write.
    """
    try:
        from cantools.database.can import Database, Node
    except ImportError as error:
        raise CanalyzeError("library.extra", name="cantools", line="pip install 'canalyze[dbc]'") from error
    pdos = list(records(result, MappedPdo))
    further = sum(one.further for one in pdos)
    said: list[Said] = [("dbc.further", {"count": further})] if further else []
    if len(buses := sorted({str(one.bus) for one in pdos})) > 1:
        raise OutputError("dbc.buses", buses=", ".join(buses))
    messages: list[Message] = []
    for _, group in groupby(pdos, lambda one: (one.extended, one.id)):
        message = _message(list(group), described, said)
        if message:
            if message.name in {one.name for one in messages}:  # a PDO that had another identifier, too
                message.name += f"_{message.frame_id:X}"
            messages.append(message)
    if not messages:
        raise OutputError("dbc.none")
    nodes = [Node(_node(node)) for node in sorted({one.node for one in pdos})]
    text = Database(messages, nodes, strict=True).as_dbc_string(sort_signals=None)
    data = text.encode(ENCODING, "replace")
    if data.decode(ENCODING) != text:
        said.append(("dbc.encoding", {}))
    return Made(data, len(messages), sum(len(one.signals) for one in messages), tuple(said))


def _message(group: list[MappedPdo], described: Described, said: list[Said]) -> "Message | None":
    """Returns the message of an identifier from the PDOs that use it."""
    from cantools.database.can import Message

    group.sort(key=lambda one: (bool(one.signals), one.frames, one.transmit), reverse=True)
    first = group[0]
    sender = next((one for one in group if one.transmit), None)
    facts: dict[str, object] = {"id": first.id, "pdo": first.pdo, "node": first.node}
    for other in group[1:]:
        if other.signals and (other.transmit or sender is None):
            said.append(("dbc.shared", {**facts, "other": other.pdo, "other_node": other.node}))
    if first.content in _SAYS:
        said.append((_SAYS[first.content], {**facts, "frames": first.frames}))
        return None
    if first.changes:
        said.append(("dbc.changed", {**facts, "changes": first.changes}))
    if first.bits > _MOST_BITS:
        said.append(("dbc.long", {**facts, "bits": first.bits}))
        return None
    receivers = [_node(one.node) for one in group if not one.transmit]
    signals = list(_signals(first, receivers, described, facts, said))
    if not signals:
        said.append(("dbc.empty", facts))
        return None
    multiplexed = first.content != "mapped"
    return Message(
        int(first.id, 16),
        f"{_node((sender or first).node)}_{(sender or first).pdo}",
        8 if multiplexed else math.ceil(first.bits / 8),
        signals,
        senders=[_node(sender.node)] if sender else [],
        cycle_time=_cycle(sender) if sender else None,
        is_extended_frame=first.extended,
        strict=True,
    )


def _signals(
    pdo: MappedPdo, receivers: list[str], described: Described, facts: dict[str, object], said: list[Said]
) -> "Iterator[Signal]":
    from cantools.database.can import Signal
    from cantools.database.conversion import BaseConversion

    if pdo.content != "mapped" and pdo.signals:
        yield Signal(_ADDRESS, 0, _ADDRESS_BITS, is_multiplexer=True, receivers=receivers)
    taken = {_ADDRESS}
    for one in pdo.signals:
        factor = float(one.factor)
        if one.number == "bytes" or not math.isfinite(factor):
            said.append(("dbc.bytes", {**facts, "signal": one.name, "bits": one.bits}))
            continue
        entry = described(pdo.bus, one.node or 0, int(one.index, 16), one.sub)
        limits = (entry.low, entry.high) if entry else ()
        factor = int(factor) if factor.is_integer() else factor
        ends = sorted(limit * factor for limit in limits if limit is not None)
        choices = OrderedDict[int, "str | NamedSignalValue"]((word.value, word.text) for word in one.words)
        yield Signal(
            _unique(one, pdo, taken),
            one.offset,
            one.bits,
            is_signed=one.number == "signed",
            conversion=BaseConversion.factory(factor, 0, choices or None, is_float=one.number == "real"),
            minimum=ends[0] if len(ends) == 2 else None,
            maximum=ends[1] if len(ends) == 2 else None,
            unit=_plain(one.unit or "") or None,
            comment=_plain(" ".join(dict.fromkeys((f"{one.index}h:{one.sub:02X}", one.name)))),
            receivers=receivers,
            multiplexer_ids=None if one.address is None else [one.address],
            multiplexer_signal=None if one.address is None else _ADDRESS,
        )


def identifier(text: str) -> str:
    """Returns the letters and digits of a text, joined by _."""
    letters = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return re.sub("[^0-9A-Za-z]+", "_", letters).strip("_")


def _node(node: int) -> str:
    return f"Node{node}"


def _cycle(pdo: MappedPdo) -> int | None:
    """Returns the cycle time in ms, if it is known and a whole number as a DBC requires."""
    if pdo.type is not None and pdo.type in _CYCLIC and pdo.sync_ns:
        time, rest = divmod(pdo.type * pdo.sync_ns, 1_000_000)
        return None if rest else time
    return (pdo.event_timer or None) if pdo.type in _EVENTS else None


def _unique(one: MappedObject, pdo: MappedPdo, taken: set[str]) -> str:
    """Returns a valid name of a signal that is unique in its message."""
    name = identifier(one.name)
    place = f"{one.index}h_{one.sub:02X}"
    names = [name if re.match("[A-Za-z]", name) else f"Obj_{place}"]
    names += [f"{names[0]}_{place}", f"{names[0]}_{place}_Node{one.node or 0}"]
    numbered = (f"{names[0]}_{number}" for number in range(2, 2 + len(taken)))
    found = next(name for name in (*names, *numbered) if name not in taken)
    taken.add(found)
    return found


def _plain(text: str) -> str:
    """Returns a text without the characters that are invalid within quotes."""
    return "".join(char if char.isprintable() else " " for char in text).replace('"', "'").replace("\\", "/")
