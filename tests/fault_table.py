"""The table of faults: each class at each of its magnitudes, with the codes that are right and where it can be told.

Why it exists: `detection.json` has a row for each of these, and reads as the list of what the program finds. What it
must not do: leave out a magnitude because it is not found.
"""

from __future__ import annotations

import struct

from captures import CanFrame
from faults_in_recordings import RECORDED, RecordedFault
from faults_of_control import (
    first_heartbeats_missing,
    guarding_toggle,
    guarding_unanswered,
    heartbeat_gap,
    life_guarding,
    node_lost,
    reset,
    sync_at_random,
    sync_missing,
    sync_never_as_configured,
    sync_of_two,
    sync_period,
    two_nodes,
)
from faults_of_data import (
    answered_after,
    block_left,
    bus_load,
    drive_fault,
    emergencies,
    error_frames,
    event_timer,
    frames_lost,
    inhibit_violated,
    interleaved,
    made_good,
    pdo_in_pre_operational,
    pdo_late,
    pdo_length,
    pdo_missing,
    pdo_twice,
    pdo_wrong_cycle,
    refused,
    repeated,
    sdo,
    second_sender,
    stamps_jump,
    until_client,
)
from faults_of_sdo import EPILOGUE, FAULTS, PROLOGUE
from faults_of_sdo import Fault as SdoFault
from faulty_captures import POSITIONS, Capture, Fault, Faulty, Make, quiet
from network import PRE_OPERATIONAL, RESET_COMMUNICATION, RESET_NODE
from plants import DRIVE, HEARTBEAT, IO, SYNC_PERIOD, Known, built
from sdo_wire import (
    Channel,
    abort,
    block_download,
    block_upload,
    expedited_upload,
    segmented_download,
    segmented_upload,
)

TOLD: tuple[Known, ...] = ("written", "described")
"""What is judged against a configuration that traffic alone does not show."""
ONCE: tuple[Known, ...] = ("written",)
NOT_AT_THE_END = tuple(POSITIONS)

SYNC = [
    *(
        Fault("SYNC period", f"off by {part} % for {cycles} cycles", "SYN", sync_period(1 + part / 100, cycles), lasts)
        for part in (5, 10, 20, 30, 100)
        for cycles in (8, 10, 30, 60)
        for lasts in ((cycles + 2) * SYNC_PERIOD * (1 + part / 100),)
    ),
    *(
        Fault("SYNC jitter", f"{part} % for 30 cycles", "SYN", sync_period(1 + part / 100, 30, wobble=True), 0.8)
        for part in (20, 40)
    ),
    Fault("SYNC jitter", "up to 40 % at random for 40 cycles", "SYN", sync_at_random(0.4, 40), 1.0),
    *(
        Fault(
            "SYNC never as in 1006h",
            f"off by {p} %",
            "SYN",
            sync_never_as_configured(1 + p / 100),
            0,
            TOLD,
            ("middle",),
        )
        for p in (5, 10, 20, 100)
    ),
    *(
        Fault("SYNC missing", f"{count} cycles", "SYN", sync_missing(count, pdos=False), count * SYNC_PERIOD)
        for count in (1, 3, 10)
    ),
    *(
        Fault("SYNC lost, its PDOs not", f"{count} cycles", "SYN", sync_missing(count, pdos=True), count * SYNC_PERIOD)
        for count in (1, 3, 10)
    ),
    Fault("SYNC ends", "for ever", "SYN", sync_missing(0, pdos=False), positions=NOT_AT_THE_END),
    *(Fault("two SYNC producers", f"phase {phase}", "SYN", sync_of_two(phase), 1.0) for phase in (0.1, 0.25, 0.5)),
    Fault("two SYNC producers", "periods 1 : 1.3", "SYN", sync_of_two(0.4, 1.3), 1.0),
]

NODES = [
    *(
        Fault("heartbeat gap", f"{periods:g} periods", "HBT", heartbeat_gap(periods), periods * HEARTBEAT)
        for periods in (1.5, 2, 3, 10)
    ),
    *(
        Fault("heartbeat gap after a burst of SDO", f"{n} periods", "HBT", heartbeat_gap(n, burst=True), n * HEARTBEAT)
        for n in (3, 10)
    ),
    *(
        Fault(
            "heartbeat gap after a late one",
            f"{n} periods",
            "HBT",
            heartbeat_gap(n, late_before=True),
            n * HEARTBEAT,
            beside="HBT001",
        )
        for n in (3, 10)
    ),
    *(
        Fault("first heartbeats after a boot-up missing", f"{n}", "HBT", first_heartbeats_missing(n), 0.4 + 0.1 * n)
        for n in (3, 10)
    ),
    *(
        Fault("heartbeat gap, calm bus", f"{n:g} periods", "HBT", heartbeat_gap(n, of="calm"), n * HEARTBEAT)
        for n in (1.5, 2, 3, 10)
    ),
    *(
        Fault(
            "heartbeat gap after a burst of SDO, calm bus",
            f"{n} periods",
            "HBT",
            heartbeat_gap(n, burst=True, of="calm"),
            n * HEARTBEAT,
        )
        for n in (3, 10)
    ),
    Fault("node lost, calm bus", "not asked", "HBT", node_lost(polled=False, of="calm"), 0.8),
    Fault(
        "node lost, calm bus",
        "just after 1017h was read",
        "HBT",
        node_lost(polled=False, touched="read", of="calm"),
        0.8,
    ),
    Fault(
        "never back after",
        "reset node, calm bus",
        "NMT HBT",
        reset(RESET_NODE, boot_up=False, back=False, of="calm"),
        1.5,
    ),
    Fault("two nodes with one node-ID", "half phase, calm bus", "HBT NMT", two_nodes(HEARTBEAT, of="calm"), 0.8),
    Fault("node lost", "still asked", "HBT", node_lost(polled=True), 0.8),
    Fault("node lost", "not asked", "HBT", node_lost(polled=False), 0.8),
    Fault("node lost", "just after 1017h was read", "HBT", node_lost(polled=False, touched="read"), 0.8),
    Fault("node lost", "just after 1017h was written", "HBT", node_lost(polled=False, touched="write"), 0.8),
    Fault("no boot-up after", "reset node", "NMT HBT", reset(RESET_NODE, boot_up=False), 0.7),
    Fault("no boot-up after", "reset communication", "NMT HBT", reset(RESET_COMMUNICATION, boot_up=False), 0.7),
    Fault("never back after", "reset node", "NMT HBT", reset(RESET_NODE, boot_up=False, back=False), 1.5),
    Fault(
        "never back after", "reset communication", "NMT HBT", reset(RESET_COMMUNICATION, boot_up=False, back=False), 1.5
    ),
    Fault("two nodes with one node-ID", "half phase", "HBT NMT", two_nodes(HEARTBEAT), 0.8),
    Fault("two nodes with one node-ID", "other period", "HBT NMT", two_nodes(0.13), 0.8),
    Fault("two nodes with one node-ID", "other state", "HBT NMT", two_nodes(HEARTBEAT, PRE_OPERATIONAL), 0.8),
    Fault("guarding", "one toggle bit", "GRD", guarding_toggle, plant="guarded"),
    *(
        Fault("guarding unanswered", f"{n} times", "GRD HBT", guarding_unanswered(n), 0.1 * n, plant="guarded")
        for n in (1, 3)
    ),
    Fault("guarding unanswered", "for ever", "GRD HBT", guarding_unanswered(0), 1.0, plant="guarded"),
    *(
        Fault(
            "life guarding, the master stops for",
            f"{s} s",
            "GRD NMT",
            life_guarding(s),
            min(s, 0.8),
            TOLD,
            plant="guarded",
        )
        for s in (0.4, 1.0, 10)
    ),
]

READ = expedited_upload(Channel(DRIVE), 0x2001, 0, b"\x01\0")
LONG = bytes(range(60))


def half(make: str, count: int, *, aborted: bool = False) -> Make:
    """A transfer of a kind that stops after the n-th frame of the client. aborted: by the client, soon after."""
    kinds = {
        "segmented upload": lambda c: segmented_upload(c, 0x1008, 0, LONG),
        "segmented download": lambda c: segmented_download(c, 0x2005, 0, LONG),
        "block upload": lambda c: block_upload(c, 0x2010, 0, LONG, blksize=4),
        "block download": lambda c: block_download(c, 0x2011, 0, LONG, blksize=4),
    }

    def frames(channel: Channel) -> list[CanFrame]:
        end = [channel.client(abort(0x2010, 0, 0x0504_0000))] if aborted else []
        return [*until_client(kinds[make](channel), count), *end]

    return sdo(frames, step=0.03 if aborted else 0.0004)


def unanswered_and_reset(known: Known, at: float) -> Faulty:
    """A request without response, and two seconds later a reset of its node."""
    capture, since = Capture(built("plant", known)), quiet(at)
    capture.frames = reset(RESET_NODE, boot_up=True)(known, since + 2.0).frames
    capture.drop(since, since + 2.8, 0x600 + IO, 0x580 + IO)
    capture.add(since, 0x600 + IO, READ[0].data)
    return capture.faulty(since, since + 0.0001)


def damaged(fault: SdoFault) -> Make:
    """One of the damaged transfers of `faults_of_sdo.py`, between whole ones."""

    def make(known: Known, at: float) -> Faulty:
        capture, since = Capture(built("plant", known)), quiet(at)
        session = list(fault.session)
        fault.change(session, fault.at)
        first = since + (len(PROLOGUE) + max(fault.at - 1, 0)) * 0.0007
        capture.place(since, [*PROLOGUE, *session, *EPILOGUE], 0.0007)
        return capture.faulty(first - 0.0001, since + (len(PROLOGUE) + len(session)) * 0.0007 + 0.0001)

    return make


def other_object(channel: Channel) -> list[CanFrame]:
    """A read that is aborted with another object's index."""
    return [channel.client(b"\x40\x01\x20"), channel.server(abort(0x2002, 0, 0x0602_0000))]


SDO = [
    Fault("SDO unanswered", "a read", "SDO", sdo(lambda c: expedited_upload(c, 0x2001, 0, b"\1")[:1]), 1.2),
    Fault(
        "SDO unanswered",
        "a read, the client's last",
        "SDO",
        sdo(lambda c: expedited_upload(c, 0x2001, 0, b"\1")[:1], pause=9),
    ),
    Fault(
        "SDO unanswered",
        "by a node that is never heard",
        "SDO",
        sdo(lambda c: expedited_upload(c, 0x2001, 0, b"\1")[:1], node=9),
    ),
    Fault(
        "SDO unanswered",
        "a read, then aborted",
        "SDO",
        sdo(lambda c: [c.client(b"\x40\x01\x20"), c.client(abort(0x2001, 0, 0x0504_0000))], step=0.3),
        1.2,
    ),
    *(
        Fault("SDO unanswered", f"in a {kind}", "SDO", half(kind, count), 1.2)
        for kind, count in (
            ("segmented upload", 3),
            ("segmented download", 3),
            ("block upload", 3),
            ("block download", 6),
        )
    ),
    *(
        Fault("SDO unanswered", f"in a {kind}, then aborted", "SDO", half(kind, count, aborted=True), 1.2)
        for kind, count in (("segmented upload", 3), ("block upload", 3), ("block download", 6))
    ),
    Fault("SDO unanswered", "a read, then the node is reset", "SDO", unanswered_and_reset, 2.8),
    *(Fault("SDO answered after", f"{s} s", "SDO", answered_after(s), s + 0.2) for s in (1, 2, 3)),
    Fault("SDO abort", "names another object", "SDO", sdo(other_object)),
    Fault("SDO request repeated", "one answer", "SDO", sdo(repeated(1), step=0.02)),
    Fault("SDO request repeated", "two answers", "SDO", sdo(repeated(2), step=0.02)),
    Fault("SDO write refused", "never made good", "SDO", sdo(refused)),
    Fault("another client on the channel", "both read in segments", "SDO", sdo(interleaved)),
    Fault("SDO block download unacknowledged", "then a block upload", "SDO", sdo(block_left)),
    *(
        Fault("SDO damaged", fault.name, "SDO", damaged(fault), known=ONCE)
        for fault in FAULTS
        if fault.severity != "info" and "dropped" not in fault.name
    ),
    *(
        Fault("SDO frame lost", fault.name, "SDO CAP", damaged(fault), known=ONCE)
        for fault in FAULTS
        if fault.severity != "info" and "dropped" in fault.name
    ),
]

PDO = [
    *(Fault("PDO after its SYNC", f"{f} x the window", "SYN PDO", pdo_late(f), known=TOLD) for f in (1.1, 1.5, 3)),
    *(
        Fault("synchronous PDO missing", f"{n} cycles", "SYN PDO", pdo_missing(n), n * SYNC_PERIOD, TOLD)
        for n in (1, 3, 10)
    ),
    Fault(
        "synchronous PDO missing",
        "3 cycles after a refused write",
        "SYN PDO",
        pdo_missing(3, True),
        0.3,
        TOLD,
        beside="SDO018",
    ),
    Fault("synchronous PDO", "twice in a cycle", "SYN PDO", pdo_twice, known=TOLD),
    Fault("synchronous PDO", "in a wrong cycle", "SYN PDO", pdo_wrong_cycle, 0.2, TOLD),
    *(
        Fault("PDO length", f"{by:+d} byte, {word}", "PDO SYN", pdo_length(by, lasting=lasting), 0.3)
        for by in (-1, 1)
        for word, lasting in (("once", False), ("from there on", True))
    ),
    *(
        Fault("TPDO while Pre-operational", f"{ms} ms after the command", "PDO", pdo_in_pre_operational(ms), 0.5)
        for ms in (1, 5, 10, 45, 200)
    ),
    *(Fault("inhibit time violated", f"by {p} %", "PDO", inhibit_violated(p / 100), 0.2, TOLD) for p in (10, 50, 90)),
    Fault(
        "inhibit time violated",
        "by 50 % after a write to another PDO",
        "PDO",
        inhibit_violated(0.5, written=True),
        0.2,
        TOLD,
    ),
    *(Fault("event timer exceeded", f"{f:g} x", "PDO", event_timer(f), f * 0.1 + 0.1, TOLD) for f in (1.2, 2, 5)),
    Fault("event timer exceeded", "2 x after a write to another PDO", "PDO", event_timer(2, written=True), 0.3, TOLD),
    Fault("second sender of a PDO's COB-ID", "14 frames", "PDO", second_sender, 1.0),
]

LISTENER = "ERR BUS CAN CAP"
RAISED = (0.0, 0x3210, 0x05)
OVER = (0.3, 0x0000, 0x00)

OTHERS = [
    Fault("error frame", "bus-off", LISTENER, error_frames(0x040, b"")),
    Fault("error frame", "bus-off, restarted", LISTENER, error_frames(0x040, b"", restarted=True), 0.2),
    Fault("error frame", "restarted", LISTENER, error_frames(0x100, b"")),
    Fault("error frame", "error passive", LISTENER, error_frames(0x004, b"\0\x20")),
    Fault("error frame", "warning level", LISTENER, error_frames(0x004, b"\0\x08")),
    Fault("error frame", "receive overflow", LISTENER, error_frames(0x004, b"\0\x01")),
    Fault("error frame", "no acknowledge, 20 times", LISTENER, error_frames(0x020, b"", 20)),
    Fault("error frame", "bus error, 100 times", LISTENER, error_frames(0x088, b"\0\0\x04\x08", 100), 0.2),
    Fault("EMCY", "raised and reset", "EMC", emergencies(RAISED, OVER), 0.4),
    Fault("EMCY", "raised", "EMC", emergencies(RAISED)),
    Fault("EMCY", "two raised, one reset", "EMC", emergencies(RAISED, (0.1, 0x4210, 0x0D), (0.3, 0, 0x05)), 0.4),
    Fault(
        "EMCY",
        "40 in 0.2 s",
        "EMC",
        emergencies(*((0.005 * k, 0x3210 + k % 2, 0x05) for k in range(40)), (0.5, 0, 0)),
        0.6,
    ),
    Fault("drive", "fault with EMCY", "DRV EMC", drive_fault(emergency=True), plant="drive"),
    Fault("drive", "fault without EMCY", "DRV", drive_fault(emergency=False), known=TOLD, plant="drive"),
    Fault(
        "drive", "fault, device type 0", "DRV", drive_fault(emergency=False, device_type=0), known=ONCE, plant="drive"
    ),
    Fault(
        "drive", "fault, then reset", "DRV EMC", drive_fault(emergency=True, reset_after=0.5), 0.8, TOLD, plant="drive"
    ),
    Fault(
        "drive",
        "fault reset without effect",
        "DRV",
        drive_fault(emergency=False, reset_after=0.5, effect=False),
        1.5,
        TOLD,
        beside="DRV EMC",
        plant="drive",
    ),
    *(
        Fault("stamps jump", f"{word} {shown}", "CAP", stamps_jump(sign * by))
        for word, sign in (("back", -1), ("forth", 1))
        for shown, by in (("10 ms", 0.01), ("30 ms", 0.03), ("5 s", 5), ("1 h", 3600))
    ),
    *(Fault("frames lost silently", f"{n}", "CAP", frames_lost(n), n * 0.007) for n in (30, 100, 300)),
    Fault("bus load 100 %", "for 0.5 s", "EXP014 BUS CAP", bus_load(0.5), 0.6, bit_rate=125_000),
]

AnyFault = Fault | RecordedFault
TABLE: list[AnyFault] = [*SYNC, *NODES, *SDO, *PDO, *OTHERS, *RECORDED]

NOTHING_WRONG: dict[str, Make] = {
    "a node is reset and boots": reset(RESET_NODE, boot_up=True),
    "its communication is reset and it boots": reset(RESET_COMMUNICATION, boot_up=True),
    "a node out of Operational and back": pdo_in_pre_operational(0),
    "a transfer that was refused and then made good": sdo(made_good),
    "transfers of every kind": sdo(
        lambda c: [
            *segmented_download(c, 0x2005, 0, bytes(20)),
            *block_download(c, 0x2011, 0, bytes(60), blksize=4),
            *block_upload(c, 0x2010, 0, bytes(60), blksize=4),
        ]
    ),
    "1017h is read": sdo(lambda c: expedited_upload(c, 0x1017, 0, struct.pack("<H", round(HEARTBEAT * 1000)))),
}
"""The same changes without a fault: nothing above info may be said of them."""
