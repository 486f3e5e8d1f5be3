"""The slave side of LSS (CiA 305) for the recordings.

Why it exists: python-canopen has only a master. What it must not do: answer in a state in which a slave is silent.
"""

from __future__ import annotations

import struct

import canopen
from network_nodes import INTERFACE, Device


class LssSlave:
    """The slave side of CiA 305 for one device; a device without node-ID (FF) comes up when it gets one."""

    def __init__(self, device: Device, identity: tuple[int, int, int, int], *, configured: bool) -> None:
        """identity: vendor-ID, product code, revision and serial number. The device must not be connected yet."""
        self.device, self.identity = device, identity
        self.node = device.id if configured else 0xFF
        self.pending = self.node
        self.configuring = False
        self._matched = 0
        self._identified = 0
        self._position = 0
        self.network = canopen.Network()
        self.network.subscribe(0x7E5, self._on_request)

    def connect(self) -> None:
        """Listens from now on."""
        self.network.connect(interface="socketcan", channel=INTERFACE)

    def _answer(self, *data: int) -> None:
        self.network.send_message(0x7E4, bytes(data).ljust(8, b"\0"))

    def _on_request(self, can_id: int, data: bytearray, timestamp: float) -> None:
        with self.device.account.lock:
            cs, value = data[0], int.from_bytes(data[1:5], "little")
            if cs == 0x04:
                self._switch(configuring=data[1] == 1)
            elif 0x40 <= cs <= 0x43:
                part = cs - 0x40
                right = self._matched == part and self.identity[part] == value
                self._matched = self._matched + 1 if right else 0
                if self._matched == 4:
                    self._matched, self.configuring = 0, True
                    self._answer(0x44)
            elif 0x46 <= cs <= 0x4B:
                self._identify(cs - 0x46, value)
            elif cs == 0x4C and self.node == 0xFF:
                self._answer(0x50)
            elif cs == 0x51 and self.node == 0xFF and not self.configuring:
                self._fastscan(value, data[5], data[6], data[7])
            elif self.configuring:
                self._configure(cs, data[1])

    def _switch(self, *, configuring: bool) -> None:
        left = self.configuring and not configuring
        self.configuring, self._matched = configuring, 0
        if left and self.node == 0xFF and self.pending != 0xFF:
            self.node = self.device.id = self.pending
            self.device.timers.after(0.02, self.device.boot)

    def _identify(self, step: int, value: int) -> None:
        part = (0, 1, 2, 2, 3, 3)[step]
        own = self.identity[part]
        right = own == value if step < 2 else (value <= own if step in (2, 4) else own <= value)
        self._identified = self._identified + 1 if right and self._identified == step else int(right and step == 0)
        if self._identified == 6:
            self._identified = 0
            self._answer(0x4F)

    def _fastscan(self, value: int, bit: int, sub: int, following: int) -> None:
        if bit == 0x80:
            self._position = 0
            self._answer(0x4F)
        elif bit < 0x20 and sub == self._position and (value ^ self.identity[sub]) >> bit == 0:
            self._answer(0x4F)
            if bit == 0 and following != sub:
                self._position = following
                self.configuring = following < sub

    def _configure(self, cs: int, value: int) -> None:
        if cs == 0x11:
            good = 1 <= value <= 127 or value == 0xFF
            if good:
                self.pending = value
                self.device.new_id = value if self.node != 0xFF else None
            self._answer(cs, 0 if good else 1)
        elif cs in (0x13, 0x17):
            self._answer(cs, 0)
        elif 0x5A <= cs <= 0x5D:
            self._answer(cs, *struct.pack("<I", self.identity[cs - 0x5A]))
        elif cs == 0x5E:
            self._answer(cs, self.device.id if self.node != 0xFF else 0xFF)
