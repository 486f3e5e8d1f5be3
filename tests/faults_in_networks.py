"""Single faults in clean sessions of networks: for each the rule that is for it, and the places of its frames.

What it must not do: look at the wording, or at what a program says of a fault.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache

from captures import CanFrame
from network import (
    Fault,
    Frames,
    add,
    change,
    drop,
    drop_answers,
    drop_exchange,
    duplicate,
    find,
    from_there_on,
    payload,
    shift,
)
from network_sessions import SESSIONS

SYNC, NODE_HEARTBEAT, MASTER, SLAVE = 0x080, 0x705, 0x7E5, 0x7E4


def many(start: float, period: float, count: int, can_id: int, data: bytes) -> list[tuple[float, int, bytes | None]]:
    """The same frame in even steps."""
    return [(start + k * period, can_id, data) for k in range(count)]


def shift_from(can_id: int, number: int, milliseconds: float) -> Fault:
    """All frames of a CAN-ID later, from one on. One alone may as well be listed late by the capturing machine."""

    def fault(frames: Frames) -> tuple[Frames, list[int]]:
        at = find(frames, can_id, number)
        later = round(milliseconds * 1000)
        moved = [
            replace(frame, t_us=frame.t_us + later) if i >= at and frame.can_id == can_id else frame
            for i, frame in enumerate(frames)
        ]
        new = sorted(moved, key=lambda frame: frame.t_us)
        return new, [find(new, can_id, number - 1), find(new, can_id, number)]

    return fault


@dataclass(frozen=True)
class Case:
    """A row of the table."""

    name: str
    codes: str
    """Any of these is right; the first is the one meant."""
    session: str
    fault: Fault
    severity: str = "warning"
    """What the finding must at least be."""
    node: int | None = 5
    """Whose it is; None: not judged."""
    beside: str = ""
    """What may be said above info of the same fault too."""
    eds: dict[int, str] = field(default_factory=dict)
    """Descriptions by node, for rules that need them."""
    also: tuple[tuple[int, int], ...] = ()
    """Further right places: the n-th frame on a CAN-ID in the changed session."""


DRIVE = {5: "drive.eds"}

NMT = [
    Case("command specifier unknown", "NMT001", "states", add((0.7, 0x000, b"\x33\x05")), node=None),
    Case("node-ID above 127", "NMT001", "states", add((0.7, 0x000, b"\x01\x85")), node=None),
    Case("stop that nobody obeys", "NMT002", "states", add((0.66, 0x000, b"\x02\x05"), later=True), "info"),
    Case("start that nobody obeys", "NMT002", "states", add((0.2, 0x000, b"\x01\x06"), later=True), "info", node=6),
    Case("boot-up without a command", "NMT003", "states", drop(0x000, 1), also=((NODE_HEARTBEAT, 13),)),
    Case("operational without a command", "NMT004", "states", drop(0x000, 0), "info", also=((NODE_HEARTBEAT, 6),)),
    Case("stopped without a command", "NMT004", "stopped", drop(0x000, 1), "info"),
    Case("heartbeat 80 ms late", "HBT001", "states", shift(NODE_HEARTBEAT, 4, 80)),
    Case("five heartbeats missing", "HBT001 HBT002", "stopped", drop(0x706, 6, 5), node=6),
    Case("a node falls silent", "HBT002 HBT001", "states", drop(0x706, 8, 100), node=6),
    Case("state 42", "HBT003", "states", change(NODE_HEARTBEAT, 4, 0, 0x42), beside="NMT004"),
    Case(
        "a second node with the same node-ID",
        "HBT004",
        "states",
        add(*many(0.64, 0.1, 6, NODE_HEARTBEAT, b"\x7f"), later=True),
        beside="NMT004",
    ),
]

# after the boot-up (0) come request, answer, request, answer
GUARDING = [
    Case("toggle not toggled", "GRD001", "guarded", change(NODE_HEARTBEAT, 8, 0, 0x7F)),
    Case("two answers missing", "GRD002", "guarded", drop_answers(NODE_HEARTBEAT, 6), beside="GRD001"),
    Case(
        "heartbeats of a guarded node",
        "GRD003",
        "guarded",
        add(*many(0.78, 0.1, 8, NODE_HEARTBEAT, b"\x05"), later=True),
        beside="GRD001 HBT003 HBT004",
    ),
]

EMERGENCIES = [
    Case("a code with error register 0", "EMC001", "emergencies", change(0x085, 0, 2, 0x00)),
    Case("bit 6 of the error register", "EMC003", "emergencies", change(0x085, 0, 2, 0x45)),
    Case("EMCY while stopped", "EMC004", "stopped", add((1.56, 0x085, b"\x10\x32\x05\0\0\0\0\0"))),
    Case("EMCY between reset and boot-up", "EMC004", "states", add((1.4, 0x085, b"\x10\x32\x05\0\0\0\0\0"))),
    Case("EMCY inside the inhibit time", "EMC005", "emergencies", shift(0x085, 1, -45)),
    Case("more milliseconds than a day has", "TIM001", "times", change(0x100, 2, 3, 0x0F), node=None, beside="TIM002"),
    Case("an hour ahead", "TIM002", "times", change(0x100, 3, 2, 0x20), node=None),
]

LEFT = (MASTER, -1)
"""Where the slaves are sent back to waiting."""

LSS = [
    Case("unknown command", "LSS001", "lss_configured", add((0.115, MASTER, b"\x99" + bytes(7))), node=None),
    Case("answer to nothing", "LSS002", "lss_configured", add((1.55, SLAVE, b"\x11" + bytes(7))), node=None),
    Case(
        "node-ID for nobody", "LSS003", "lss_configured", add((0.5, MASTER, b"\x11\x22" + bytes(6))), "info", node=None
    ),
    Case("node-ID refused", "LSS004", "lss_configured", change(SLAVE, 2, 1, 1), node=None, beside="LSS005"),
    Case("store refused", "LSS004", "lss_configured", change(SLAVE, 3, 1, 2), node=None),
    Case(
        "no boot-up with the new node-ID",
        "LSS005",
        "lss_configured",
        drop(0x711, 0),
        "info",
        node=None,
        also=(LEFT, (SLAVE, 2)),
    ),
    Case("bit timing not activated", "LSS006", "lss_bit_timing", drop(MASTER, 2), "info", node=None, beside="HBT002"),
    Case("two slaves answer", "LSS007", "lss_configured", duplicate(SLAVE, 2, 0.2), node=None),
    Case("a frame in the switch delay", "LSS008", "lss_bit_timing", add((0.25, 0x706, b"\x7f")), "info", node=None),
]

SYNCS = [
    Case(
        "a SYNC without its counter",
        "SYN001",
        "synchronous_counted",
        payload(SYNC, 14, b""),
        node=None,
        beside="SYN002",
    ),
    Case("a counter that repeats", "SYN002", "synchronous_counted", change(SYNC, 14, 0, 4), node=None),
    Case("a counter of 0", "SYN002", "synchronous_counted", change(SYNC, 14, 0, 0), node=None),
    Case("a counter beyond the overflow value", "SYN002", "synchronous_counted", change(SYNC, 14, 0, 11), node=None),
    Case("a SYNC missing", "SYN003", "sync_alone", drop(SYNC, 20), node=None),
    Case("SYNC 7 ms late from one on", "SYN003", "sync_alone", shift_from(SYNC, 20, 7), node=None),
    Case("a PDO 4 ms after its SYNC", "SYN004", "synchronous", shift(0x385, 20, 4)),
    Case("a PDO before the first SYNC", "SYN005", "synchronous", add((0.065, 0x385, bytes(6))), "info"),
    Case(
        "a second producer",
        "SYN006",
        "sync_alone",
        add(*many(0.1137, 0.01, 30, SYNC, b""), later=True),
        node=None,
        beside="SYN003",
    ),
    Case(
        "a window as long as two cycles", "SYN007", "synchronous", payload(0x605, 1, bytes.fromhex("23071000204E0000"))
    ),
    Case("a PDO of type 1 missing", "SYN008", "synchronous", drop(0x385, 20)),
    Case("a PDO of type 4 missing", "SYN008 SYN010", "synchronous", drop(0x485, 5)),
    Case("a PDO twice in a cycle", "SYN009", "synchronous", duplicate(0x385, 20, 0.8)),
    Case("a PDO of type 4 one cycle early", "SYN010", "synchronous", shift(0x485, 5, -10), beside="SYN008"),
]


def both(first: Fault, second: Fault) -> Fault:
    """The second one is no fault, but stands beside the first."""

    def fault(frames: Frames) -> tuple[Frames, list[int]]:
        new, places = first(frames)
        marked = [new[place] for place in places]
        beside, _ = second(new)
        return beside, [beside.index(frame) for frame in marked]

    return fault


MISSING_AT = 0.216
"""When the SYNC is due that is missing."""

SYNCS_BESIDE_COMMANDS = [
    Case(
        f"a SYNC missing, {command.hex()} at {at:.3f}",
        "SYN003",
        "sync_alone",
        both(drop(SYNC, 20), add((at, 0x000, command), later=True)),
        node=None,
    )
    for at in (MISSING_AT - 0.013, MISSING_AT + 0.003, MISSING_AT + 0.013, MISSING_AT + 0.023)
    for command in (b"\x02\x09", b"\x82\x09")
]

PDOS = [
    Case("shorter than its mapping", "PDO001", "event_driven", payload(0x285, 8, bytes(6)), "error"),
    Case("an RPDO shorter than its mapping", "PDO001", "event_driven", payload(0x205, 4, b"\6\0"), "error"),
    Case("longer than its mapping", "PDO006", "event_driven", payload(0x185, 8, bytes(4))),
    Case("a TPDO in pre-operational", "PDO002", "event_driven", add((1.55, 0x185, b"\1\0"))),
    Case("an RPDO in pre-operational", "PDO003", "event_driven", add((1.55, 0x205, b"\6\0\1")), "info"),
    Case("inside the inhibit time", "PDO004", "event_driven", shift(0x185, 8, -45)),
    Case("one period of the event timer left out", "PDO005", "event_driven", drop(0x285, 8)),
    Case(
        "transmission type 245",
        "PDO008",
        "event_driven",
        payload(0x605, 2, bytes.fromhex("2F001802F5000000")),
        beside="PDO004",
    ),
    # requests: 0-4 the reads, then invalid, mapping sub 0, 1, 0, valid
    Case("mapping written while valid", "PDO009", "remapped", drop_exchange(5, 4)),
    Case("CAN-ID changed while valid", "PDO010", "moved", drop_exchange(5, 4)),
    Case("RTR that is not allowed", "PDO011", "event_driven", add((0.5, 0x185, None))),
    Case("longer than the EDS says", "PDO012 PDO006", "drive_described", payload(0x185, 2, b"\x33\2\0\0"), eds=DRIVE),
    Case("shorter than the EDS says", "PDO012 PDO001", "drive_described", payload(0x185, 2, b"\x33"), eds=DRIVE),
]

NORMAL = ((0x109, 8),)
"""The first frame of the pair whose second is the faulty one."""

DRIVES = [
    Case(
        "SDO with a stopped node",
        "SDO011",
        "stopped",
        add((1.56, 0x605, b"\x40\x00\x10" + bytes(5)), later=True),
        "info",
    ),
    Case("4 bytes for an UNSIGNED16", "SDO013", "drive_by_sdo", change(0x585, 0, 0, 0x43), eds=DRIVE),
    Case("1 byte for an UNSIGNED16", "SDO013", "drive_by_sdo", change(0x605, 1, 0, 0x2F), eds=DRIVE),
    Case(
        "write to an object that is ro",
        "SDO014",
        "drive_by_sdo",
        add(
            (0.075, 0x605, bytes.fromhex("2B41600034120000")),
            (0.0753, 0x585, bytes.fromhex("6041600000000000")),
            later=True,
        ),
        eds=DRIVE,
    ),
    Case("from ready to switch on to quick stop active", "DRV001", "drive", payload(0x185, 2, b"\x17\x02"), eds=DRIVE),
    Case("from switch on disabled to operation enabled", "DRV001", "drive", payload(0x185, 1, b"\x37\x02")),
    Case("switch on without effect", "DRV002", "drive_cyclic", from_there_on(0x185, 10, b"\x31\x02"), eds=DRIVE),
    Case("shutdown without effect", "DRV002", "drive_cyclic", add((1.12, 0x205, b"\x06\x00"), later=True)),
    Case("the second frame not inverted", "SRD001", "safety", change(0x10A, 8, 0, 0x00), "error", None, also=NORMAL),
    Case("the second frame 30 ms later", "SRD002", "safety", shift(0x10A, 8, 30), node=None, also=NORMAL),
    Case("the inverted frame first", "SRD004", "safety", shift(0x10A, 8, -9), "info", None, also=NORMAL),
]


def drop_pair(frames: Frames) -> tuple[Frames, list[int]]:
    """The ninth SRDO missing, both frames of it."""
    left, places = drop(0x109, 8)(frames)
    return drop(0x10A, 8)(left)[0], places


DRIVES.append(Case("a pair missing", "SRD003", "safety", drop_pair, node=None))

CASES = [*NMT, *GUARDING, *EMERGENCIES, *LSS, *SYNCS, *SYNCS_BESIDE_COMMANDS, *PDOS, *DRIVES]
RULES = {code for case in CASES for code in case.codes.split()}


@cache
def clean_frames(session: str) -> tuple[CanFrame, ...]:
    return tuple(SESSIONS[session]().frames())
