"""The same faults in recorded sessions, at many places of each: real stacks answer, start and stop as they do.

Why it exists: a plant is as regular as its generator; a fault that is found in it may be missed where the gaps are
those of a real node. What it must not do: choose places by what is found there.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

from captures import CanFrame, Row, log_text, session_output
from clean_sessions import beside, recorded
from faults_of_sdo import sdo_places
from faulty_captures import Case, Faulty
from network import PRE_OP, START, STOP

PLACES = 6
"""In each recording, at most."""

Frames = list[CanFrame]
Put = Callable[[Frames], Iterator[tuple[int, Faulty]]]
"""Every place of a recording that fits, by its frame, with the capture that has the fault there."""


@dataclass(frozen=True, slots=True)
class RecordedFault:
    """A class of faults at one magnitude, in recordings."""

    name: str
    magnitude: str
    codes: str
    """As in `faulty_captures.Fault`."""
    put: Put
    beside: str = ""
    bit_rate: int | None = None

    @property
    def row(self) -> str:
        return f"{self.name}: {self.magnitude}"

    def cases(self) -> Iterator[Case]:
        """Some places of each recording, with what is known of its nodes and without."""
        for name, session in recorded().items():
            fitting = list(self.put(list(session.frames)))
            for at, faulty in fitting[:: max(1, -(-len(fitting) // PLACES))]:
                for number, network in enumerate(beside(name)):
                    where = f"{name} at frame {at + 1}{', described' * number}"
                    yield Case(where, faulty, network, own_findings(name)[number])


@cache
def own_findings(name: str) -> tuple[tuple[tuple[str, int | None], ...], ...]:
    """Code and node of what a recording says of itself above info, with each thing that is known of it."""
    text = log_text(recorded()[name].frames)
    found = []
    for network in beside(name):
        output = session_output([text], output_format="check", lang="en", network=network)
        rows: list[Row] = [json.loads(line) for line in output.decode().splitlines()]
        loud = [row for row in rows if row["severity"] != "info" and row.get("because_of") is None]
        found.append(tuple((row["code"], row["node"]) for row in loud))
    return tuple(found)


def trains(frames: Frames, wanted: Callable[[CanFrame], bool]) -> Iterator[list[int]]:
    """For each CAN-ID the places of its frames."""
    for can_id in dict.fromkeys(frame.can_id for frame in frames if wanted(frame)):
        yield [at for at, frame in enumerate(frames) if frame.can_id == can_id and wanted(frame)]


def is_heartbeat(frame: CanFrame) -> bool:
    return 0x701 <= frame.can_id <= 0x77F and not frame.remote and len(frame.data) == 1


def even(frames: Frames, places: list[int]) -> bool:
    """Whether the gaps between these frames are alike."""
    gaps = [frames[b].t_us - frames[a].t_us for a, b in pairwise(places)]
    return min(gaps) > 0 and max(gaps) < 1.2 * min(gaps)


def without(frames: Frames, missing: set[int], first: int, last: int) -> Faulty:
    """The capture without some frames; about those from a place to another, as they are numbered then."""
    left = [frame for at, frame in enumerate(frames) if at not in missing]
    number = {at: at - sum(gone < at for gone in missing) + 1 for at in (first, last)}
    return Faulty(left, number[first], number[last])


def missing_of(wanted: Callable[[CanFrame], bool], count: int) -> Put:
    """So many frames of an even train missing, from any place after the third frame on."""

    def put(frames: Frames) -> Iterator[tuple[int, Faulty]]:
        if any(frame.remote and is_heartbeat(replace(frame, data=b"\0", remote=False)) for frame in frames):
            return  # guarding: what looks like a heartbeat is asked for
        for places in trains(frames, wanted):
            for nth in range(3, len(places) - count):
                if even(frames, places[nth - 3 : nth + count + 1]):
                    gone = set(places[nth : nth + count])
                    yield places[nth], without(frames, gone, places[nth - 1], places[nth + count])

    return put


def node_lost(frames: Frames) -> Iterator[tuple[int, Faulty]]:
    """Nothing of a node any more, nor to it, for five of its heartbeats at least."""
    for places in trains(frames, is_heartbeat):
        node = frames[places[0]].can_id & 0x7F
        guarded = any(frame.remote and frame.can_id == 0x700 + node for frame in frames)
        for nth in range(3, len(places) - 5):
            if not guarded and even(frames, places[nth - 3 : nth + 5]):
                gone = {at for at in range(places[nth], len(frames)) if of_node(frames[at], node)}
                yield places[nth], without(frames, gone, places[nth - 1], len(frames) - 1)


def of_node(frame: CanFrame, node: int) -> bool:
    """Whether a frame is to or from a node, by the default identifiers, or a command to it alone."""
    if frame.can_id == 0:
        return frame.data[1:2] == bytes([node])
    return frame.can_id > 0x80 and frame.can_id & 0x7F == node


def boot_up_missing(frames: Frames) -> Iterator[tuple[int, Faulty]]:
    """The boot-up after a reset of one node, which is heard all the same.

    A device may obey a reset late, since it stores something first: a capture that ends within a second shows nothing.
    """
    for at, frame in enumerate(frames):
        lasts = frames[-1].t_us - frame.t_us > 1_000_000
        if lasts and frame.can_id == 0 and frame.data[0] in (0x81, 0x82) and frame.data[1]:
            node = frame.data[1]
            later = [i for i in range(at, len(frames)) if frames[i].can_id == 0x700 + node and not frames[i].remote]
            if later and frames[later[0]].data == b"\0":
                heard = [i for i in range(later[0] + 1, len(frames)) if of_node(frames[i], node)]
                if len(heard) > 2:
                    yield at, without(frames, {later[0]}, at, heard[min(4, len(heard) - 1)])


def sdo_missing(frames: Frames) -> Iterator[tuple[int, Faulty]]:
    """One frame of an SDO channel.

    Not one of several in a row from one side: a segment of a block after a lost one is sent again anyway, so that
    nothing shows that it was not there.
    """
    for at, _, neighbours in sdo_places(frames):
        beside_it = [frames[i].can_id for i in neighbours if i != at][:2]
        if neighbours[0] < at < neighbours[-1] and frames[at].can_id not in beside_it:
            yield at, without(frames, {at}, neighbours[0], neighbours[-1])


def sdo_short(frames: Frames) -> Iterator[tuple[int, Faulty]]:
    """One frame of an SDO channel with a byte less."""
    for at, _, _ in sdo_places(frames):
        new = [*frames[:at], replace(frames[at], data=frames[at].data[:-1]), *frames[at + 1 :]]
        yield at, Faulty(new, at + 1, at + 1)


def spread(frames: Frames) -> range:
    """Places all over a recording, but for its very ends."""
    return range(len(frames) // 6, len(frames) * 5 // 6, max(1, len(frames) // 10))


def inserted(*payloads: tuple[int, bytes], of_node: bool = False) -> Put:
    """Frames between others. of_node: on an identifier of the last node that sent a heartbeat, this one plus its ID."""

    def put(frames: Frames) -> Iterator[tuple[int, Faulty]]:
        for at in spread(frames):
            nodes = [frame.can_id & 0x7F for frame in frames[:at] if is_heartbeat(frame)]
            if nodes or not of_node:
                base, t_us = nodes[-1] if of_node else 0, frames[at - 1].t_us
                new = [
                    CanFrame(frames[0].bus, base + can_id, data.ljust(8, b"\0"), t_us, extended=can_id > 0x7FF)
                    for can_id, data in payloads
                ]
                yield at, Faulty([*frames[:at], *new, *frames[at:]], at + 1, at + len(new))

    return put


def stamps_jump(by_us: int) -> Put:
    """All stamps from a place on."""

    def put(frames: Frames) -> Iterator[tuple[int, Faulty]]:
        for at in spread(frames):
            moved = [replace(frame, t_us=frame.t_us + by_us) for frame in frames[at:]]
            if by_us > 0 or moved[0].t_us < frames[at - 1].t_us:
                yield at, Faulty([*frames[:at], *moved], at, at + 4)

    return put


def second_sync(frames: Frames) -> Iterator[tuple[int, Faulty]]:
    """Another producer in half phase, from a place to the end."""
    for places in trains(frames, lambda frame: frame.can_id == 0x080):
        for nth in range(6, len(places) - 8):
            between = [(frames[a].t_us + frames[b].t_us) // 2 for a, b in pairwise(places[nth:])]
            more = [replace(frames[places[nth]], t_us=t_us) for t_us in between]
            new = sorted([*frames, *more], key=lambda frame: frame.t_us)
            yield places[nth], Faulty(new, places[nth] + 1, len(new))


def pdo_after_command(milliseconds: float) -> Put:
    """One more TPDO of a node so long after it was taken out of Operational, as far as nothing else was commanded.

    After a reset it may have started itself.
    """

    def put(frames: Frames) -> Iterator[tuple[int, Faulty]]:
        for at, frame in enumerate(frames):
            if frame.can_id or frame.data[0] not in (PRE_OP, STOP):
                continue
            t_us = frame.t_us + round(milliseconds * 1000)
            before = [f for f in frames[:at] if 0x180 < f.can_id < 0x200 and frame.data[1] in (0, f.can_id & 0x7F)]
            moves = (START, 0x81, 0x82)
            moved = [f for f in frames[at:] if f.can_id == 0 and f.data[0] in moves and f.t_us < t_us + 50_000]
            if before and not moved and frame.t_us - before[-1].t_us < 500_000:
                late = replace(before[-1], t_us=t_us)
                new = sorted([*frames, late], key=lambda f: f.t_us)
                yield at, Faulty(new, at + 1, new.index(late) + 1)

    return put


def lost(count: int) -> Put:
    """So many frames missing, one after the other."""

    def put(frames: Frames) -> Iterator[tuple[int, Faulty]]:
        for at in spread(frames):
            if at + count + 30 < len(frames):
                yield at, Faulty([*frames[:at], *frames[at + count :]], at, at + 30)

    return put


def is_sync(frame: CanFrame) -> bool:
    return frame.can_id == 0x080


EMERGENCY = b"\x10\x32\x05"
RECORDED = [
    *(
        RecordedFault("recorded: heartbeats missing", f"{count}", "HBT", missing_of(is_heartbeat, count))
        for count in (1, 2, 4)
    ),
    RecordedFault("recorded: node lost", "for ever", "HBT", node_lost),
    RecordedFault("recorded: no boot-up", "after a reset", "NMT HBT", boot_up_missing),
    *(RecordedFault("recorded: SYNC missing", f"{count}", "SYN", missing_of(is_sync, count)) for count in (1, 3)),
    RecordedFault("recorded: two SYNC producers", "half phase", "SYN", second_sync),
    RecordedFault("recorded: SDO frame lost", "one", "SDO CAP", sdo_missing),
    RecordedFault("recorded: SDO frame", "a byte short", "SDO", sdo_short),
    *(
        RecordedFault("recorded: TPDO after a command that stops it", f"{ms} ms", "PDO", pdo_after_command(ms))
        for ms in (10, 45, 200)
    ),
    RecordedFault("recorded: EMCY", "raised", "EMC", inserted((0x080, EMERGENCY), of_node=True), "EMC005"),
    RecordedFault("recorded: error frame", "bus-off", "ERR BUS CAN CAP", inserted((0x2000_0040, b""))),
    RecordedFault("recorded: error frame", "error passive", "ERR BUS CAN CAP", inserted((0x2000_0004, b"\0\x20"))),
    *(
        RecordedFault("recorded: stamps jump", shown, "CAP", stamps_jump(by))
        for shown, by in (("back 30 ms", -30_000), ("back 5 s", -5_000_000), ("forth 5 s", 5_000_000))
    ),
    *(RecordedFault("recorded: frames lost silently", f"{count}", "CAP", lost(count)) for count in (30, 100)),
]
