"""A process in which canalyze listens to a bus with traffic on it: python-can's virtual bus is within one process.

    python virtual_bus.py TRAFFIC [ARGUMENTS OF canalyze]...

TRAFFIC is `session` (python-canopen's client and server), `stopped` (the same, then silence), `flood` (many frames at
once), `steady` (200 frames a second, without end), `unplug` (an adapter that goes and comes back), `silence`, or
the name of a capture in candump's log form, whose frames come when their stamps say.
After what has an end comes a Ctrl-C. The traffic begins when somebody listens on CHANNEL.
"""

from __future__ import annotations

import logging
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

from canalyze.cli import main
from canalyze.sources.bridge import library

library()  # else python-can loads what only MF4 needs, which takes longer than all the rest

import can  # noqa: E402
import canopen  # noqa: E402
from can.interfaces import virtual  # noqa: E402

CHANNEL = "bus"
NODE = 9
FLOOD = 20_000
TEXT = "a text that takes several segments, and some more of them"
DESCRIPTION = Path(__file__).with_name("data") / "virtual_bus.eds"


def frame(number: int) -> can.Message:
    """A TPDO that counts."""
    return can.Message(arbitration_id=0x185, data=number.to_bytes(4, "little"), is_extended_id=False)


def session() -> None:
    """A client configures a server, reads from it, and starts it."""
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    servers, client = canopen.Network(), canopen.Network()
    for network in (servers, client):
        network.connect(interface="virtual", channel=CHANNEL)
    server = servers.add_node(canopen.LocalNode(NODE, canopen.import_od(str(DESCRIPTION), NODE)))
    remote = client.add_node(canopen.RemoteNode(NODE, canopen.import_od(str(DESCRIPTION), NODE)))
    remote.sdo.RESPONSE_TIMEOUT = 10.0
    server.nmt.send_command(0)
    server.nmt.send_command(0x80)  # else its heartbeats begin with a second boot-up
    server.sdo["Manufacturer device name"].raw = TEXT
    remote.sdo["Producer heartbeat time"].raw = 100
    assert remote.sdo["Manufacturer device name"].raw == TEXT
    client.send_message(0x000, bytes([1, NODE]))
    for _ in range(3):
        client.sync.transmit()
        servers.send_message(0x180 + NODE, b"\x01\x02")
        time.sleep(0.1)
    server.nmt.stop_heartbeat()  # type: ignore[attr-defined]  # it is a slave, not what its type says


def stopped() -> None:
    """The same; then nothing more, for long."""
    session()
    silence()


def flood() -> None:
    """Frames as fast as they go."""
    with can.Bus(interface="virtual", channel=CHANNEL) as bus:
        for number in range(FLOOD):
            bus.send(frame(number))


def steady() -> None:
    """Frames at a rate that nothing has trouble with."""
    with can.Bus(interface="virtual", channel=CHANNEL) as bus:
        number = 0
        while True:
            bus.send(frame(number))
            number += 1
            time.sleep(0.005)


def unplug() -> None:
    """Some frames, then the adapter is gone for a while, then some frames again."""
    asked, back = threading.Semaphore(0), threading.Event()
    receive = virtual.VirtualBus._recv_internal

    def gone(*_: object, **__: object) -> tuple[None, bool]:
        asked.release()
        raise can.CanOperationError("the adapter is gone")

    def again(bus: virtual.VirtualBus, timeout: float | None) -> tuple[can.Message | None, bool]:
        back.set()
        return receive(bus, timeout)

    with can.Bus(interface="virtual", channel=CHANNEL) as bus:
        for number in range(20):
            bus.send(frame(number))
        all_taken(virtual.channels[CHANNEL][0])
        virtual.VirtualBus._recv_internal = gone  # type: ignore[method-assign]
        for _ in range(6):  # also when it is opened anew
            asked.acquire(timeout=30)
        virtual.VirtualBus._recv_internal = again  # type: ignore[method-assign, assignment]
        back.wait(30)
        for number in range(20, 40):
            bus.send(frame(number))
            time.sleep(0.01)


def all_taken(listening: queue.Queue[can.Message]) -> None:
    """Wait until who listens has taken all frames."""
    while listening in virtual.channels.get(CHANNEL, []) and not listening.empty():
        time.sleep(0.005)


def silence() -> None:
    """Nothing, for long."""
    time.sleep(60)


def replayed(path: str) -> None:
    """The frames of a log, as far apart as they were."""
    began = first = 0.0
    with can.Bus(interface="virtual", channel=CHANNEL) as bus, open(path, encoding="ascii") as log:
        for line in log:
            stamp, _, said = line.split()
            can_id, _, data = said.partition("#")
            at = float(stamp[1:-1])
            began, first = began or time.monotonic(), first or at
            time.sleep(max(0.0, began + at - first - time.monotonic()))
            bus.send(can.Message(arbitration_id=int(can_id, 16), data=bytes.fromhex(data), is_extended_id=False))


TRAFFIC: dict[str, Callable[[], None]] = {
    "session": session,
    "stopped": stopped,
    "flood": flood,
    "steady": steady,
    "unplug": unplug,
    "silence": silence,
}


def feed(traffic: str) -> None:
    """Wait for who listens, then begin."""
    while not (listening := list(virtual.channels.get(CHANNEL, []))):
        time.sleep(0.005)
    if traffic in TRAFFIC:
        TRAFFIC[traffic]()
    else:
        replayed(traffic)
    all_taken(listening[0])
    time.sleep(0.2)
    os.kill(os.getpid(), signal.SIGINT)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # also where a shell has it ignored
    threading.Thread(target=feed, args=(sys.argv[1],), daemon=True).start()
    sys.exit(main(sys.argv[2:]))
