"""CANopen sessions for the live tests: one with everything that expectations hold, and its variations.

Why it exists: the same boot, configuration, SYNC and heartbeats must run again and again with one thing changed. The
nodes and the master are those of `record_network.py`. Periods are long, so that a loaded machine keeps them within
the tolerances of `EXPECTED`. What it must not do: know how sniff says anything.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import canopen
from network_nodes import U16, Drive
from record_network import DRIVE, IO, SESSIONS, START, Session

HEARTBEAT_MS, SYNC_S = 400, 0.2
NAME = b"canalyze test drive, revision B"
"""Longer than four bytes: read in segments."""

EXPECTED = Path(__file__).with_name("scripted.expect.toml").read_text()
"""What the session without a change meets."""

CHANGES = {
    "no-start": {"EXP005", "EXP016"},  # nor does its signal come
    "mapping": {"EXP003", "EXP016"},
    "text": {"EXP003"},
    "signal": {"EXP007"},
    "heartbeat": {"EXP009"},
    "sync": {"EXP010"},
    "emcy": {"EXP012"},
}
"""What can be changed, and the findings that say so."""

STALLS = {"EXP009", "EXP010"}
"""What a machine that stalls for half a second makes of any session."""
ATTEMPTS = 5


def boot_configure_run(session: Session, change: str = "") -> None:
    """Boot, segmented SDO, remapping by SDO, start, SYNC, PDOs and heartbeats; with one thing changed."""
    drive, io = session.device(DRIVE, "drive.eds", Drive), session.device(IO, "io.eds")
    drive.boot()
    io.boot()
    drive.local.set_data(0x1008, 0, b"another drive of another revision" if change == "text" else NAME)
    session.master[DRIVE].sdo.upload(0x1008, 0)
    session.write(IO, 0x1017, 0, HEARTBEAT_MS, U16)
    if change == "heartbeat":
        io.local.set_data(0x1017, 0, (1000).to_bytes(2, "little"))  # not what it acknowledged
        io._heartbeats()
    first = (0x6401, 2) if change == "mapping" else (0x6401, 1)
    session.set_tpdo(IO, 1, mapping=[first, (0x6000, 2)])
    io.values |= {(0x6401, 1): 100}
    for node in (DRIVE,) if change == "no-start" else (DRIVE, IO):
        session.nmt(START, node)
    session.master.sync.start(0.6 if change == "sync" else SYNC_S)
    for step in range(6):
        io.show({(0x6401, 1): (200 if change == "signal" and step == 5 else 100) + step, (0x6000, 2): step})
        if change == "emcy" and step == 5:
            drive.emcy(0x8110, 0x11)
        time.sleep(0.3)
    session.master.sync.stop()


def run(script: Callable[[Session], None]) -> Session:
    """Runs one on the bus and stops short of closing it: its last frame is sent. Whoever calls closes it."""
    session = Session()
    try:
        script(session)
    except BaseException:
        session.close()
        raise
    return session


def run_recorded(name: str) -> Session:
    """One of the sessions of `record_network.py`, whatever the machine's load does to its timing.

    One that did not come to its end stands on the bus before the one that did.
    """
    for _ in range(ATTEMPTS):
        with suppress(canopen.SdoCommunicationError, canopen.lss.LssError):
            return run(SESSIONS[name])
    raise TimeoutError(f"{name}: the machine is too busy")
