"""The wire of recorded stories: one frame at a time, lowest identifier first, and cables that can be pulled.

Why it exists: vcan takes any number of frames at once and has no plugs. Here every participant has a socket of its own
and hands its frames to one arbiter, which lets them go at a bit rate as a bus would. What it must not do: change a
frame, or let one go that its sender would not have been able to send.
"""

from __future__ import annotations

import threading
import time
from typing import Any

import can
from can.interfaces.socketcan import SocketcanBus

INTERFACE = "vcan0"
BITS_BESIDE_DATA = 52
"""Of a frame with an 11-bit identifier, with the space behind it and a few stuff bits."""
EMCY_IDS = range(0x081, 0x100)


class Wire:
    """The arbiter, and the thread that lets frames go."""

    def __init__(self, bit_rate: int = 250_000) -> None:
        """bit_rate in bit/s."""
        self.bit_rate = bit_rate
        self._wake = threading.Condition()
        self._sockets: list[Socket] = []
        self._running = True
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def join(self, socket: Socket) -> None:
        """From now on this participant's frames go."""
        with self._wake:
            self._sockets.append(socket)

    def offer(self, socket: Socket, message: can.Message) -> None:
        """A frame that is to go when its turn comes."""
        with self._wake:
            if socket.plugged or message.arbitration_id in EMCY_IDS:
                socket.waiting.append(message)
            self._wake.notify()

    def plug(self, socket: Socket, plugged: bool) -> None:
        """Pulls or plugs the cable: what waits is lost but error reports, which a node keeps until they are out."""
        with self._wake:
            socket.plugged = plugged
            if not plugged:
                socket.waiting = [m for m in socket.waiting if m.arbitration_id in EMCY_IDS]
            self._wake.notify()

    def empty(self, socket: Socket) -> None:
        """The participant has lost its supply: nothing of it waits any more."""
        with self._wake:
            socket.waiting.clear()

    def stop(self) -> None:
        """Ends the thread; what still waits does not go."""
        with self._wake:
            self._running = False
            self._wake.notify()
        self._thread.join()

    def _next(self) -> tuple[Socket, can.Message] | None:
        ready = [(socket, message) for socket in self._sockets if socket.plugged for message in socket.waiting]
        return min(ready, key=lambda one: one[1].arbitration_id, default=None)

    def _run(self) -> None:
        free_at = 0.0
        while True:
            with self._wake:
                while self._running and (self._next() is None or free_at > time.monotonic()):
                    busy = free_at - time.monotonic() if self._next() is not None else None
                    self._wake.wait(max(busy, 0.0) if busy is not None else None)
                turn = self._next()
                if not self._running or turn is None:
                    return
                socket, message = turn
                socket.waiting.remove(message)
            socket.put_out(message)
            bits = BITS_BESIDE_DATA + (0 if message.is_remote_frame else 9 * len(message.data))
            free_at = max(free_at, time.monotonic() - 0.001) + bits / self.bit_rate


class Socket(SocketcanBus):
    """A participant's controller: what python-can sends through it waits for its turn on the wire."""

    def __init__(self, wire: Wire) -> None:
        """Plugged in."""
        super().__init__(channel=INTERFACE)
        self.wire = wire
        self.plugged = True
        self.waiting: list[can.Message] = []
        wire.join(self)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Waits its turn; does not block."""
        self.wire.offer(self, msg)

    def put_out(self, message: can.Message) -> None:
        """The arbiter's call: now."""
        super().send(message, 1.0)

    def recv(self, timeout: float | None = None) -> Any:
        """What comes while the cable is off is not received."""
        message = super().recv(timeout)
        return message if self.plugged else None
