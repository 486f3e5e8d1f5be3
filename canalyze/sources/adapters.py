"""Tables of python-can's interfaces: how each is made to listen only, and the packages each needs.

Checked against the installed python-can by a test. Must not: import that library, or open anything.
"""

from collections.abc import Mapping
from typing import Final

LISTEN_ONLY: Final[Mapping[str, Mapping[str, object]]] = {
    "cantact": {"monitor": True},
    "kvaser": {"driver_mode": False},
    "nixnet": {"listen_only": True},
    "pcan": {"state": "PASSIVE"},
    "seeedstudio": {"operation_mode": "silent"},
    "slcan": {"listen_only": True},
    "systec": {"state": "PASSIVE"},
    "vector": {"listen_only": True},
}
"""Settings that keep an adapter from acknowledging frames. Other adapters have no such switch."""

RATED: Final = frozenset({"etas", "gs_usb", "iscan", "ixxat", "neousys", "usb2can"})
"""Adapters that acknowledge and use a default bit rate where none is given; a wrong one disturbs the bus."""

WIRELESS: Final = frozenset({"udp_multicast", "virtual"})
"""Interfaces without an adapter: there is nothing to acknowledge."""

SOCKETCAN_ERRORS: Final = frozenset({"gs_usb", "socketcan", "socketcand", "udp_multicast", "virtual"})
"""Interfaces whose error frames have SocketCAN's layout. The content of others is ignored."""

DATA_RATE: Final[Mapping[str, str]] = {"nixnet": "fd_bitrate"}
"""Parameter names of the CAN FD data bit rate that differ from `data_bitrate`."""

TIMED: Final[Mapping[str, int]] = {"pcan": 80_000_000, "slcan": 80_000_000}
"""Interfaces that accept CAN FD rates only as bit timing, with their clock frequency in Hz."""

PIP: Final[Mapping[str, str]] = {
    "canalystii": "python-can[canalystii]",
    "cantact": "python-can[cantact]",
    "gs_usb": "python-can[gs-usb]",
    "neovi": "python-can[neovi]",
    "nixnet": "python-can[nixnet]",
    "robotell": "python-can[serial]",
    "seeedstudio": "python-can[seeedstudio]",
    "serial": "python-can[serial]",
    "slcan": "python-can[serial]",
    "udp_multicast": "python-can[multicast]",
}
"""The pip requirement of each interface."""

DRIVER: Final[Mapping[str, str]] = {
    "etas": "ETAS BOA (Windows)",
    "iscan": "Thorsis isCAN (Windows)",
    "ixxat": "HMS Ixxat VCI (Windows)",
    "kvaser": "Kvaser CANlib",
    "neousys": "Neousys WDT_DIO",
    "neovi": "Intrepid ICS neoVI",
    "nican": "NI-CAN (Windows)",
    "nixnet": "NI-XNET (Windows)",
    "pcan": "PEAK PCAN-Basic",
    "systec": "SYS TEC USB-CANmodul (Windows)",
    "usb2can": "8devices usb2can.dll (Windows)",
    "vector": "Vector XL Driver Library (Windows)",
}
"""Vendor libraries that an interface needs and that pip does not install."""
