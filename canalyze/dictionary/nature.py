"""Volatile objects of the standards, whose values are no configuration: states, clocks, actual values.

Only objects defined by the standards are listed. Must not: look at a value.
"""

from functools import cache
from typing import Final, Literal

from canalyze.dictionary.model import Address

Nature = Literal["state", "history", "time", "command", "serial", "process", "set-point"]

_BATTERY: Final[dict[Nature, str]] = {
    "state": "6000-6001 6090",
    "process": "6010 6050-6054 6060 6070 6080-6081",
    "serial": "6030-6031 6040-6041",
}
_TABLE: Final[dict[int, dict[Nature, str]]] = {
    0: {
        "state": "1001-1002 1F57",
        "history": "1003",
        "time": "1013 1020",
        "command": "1010-1011 1023-1026 1F25 1F50-1F51 1F82-1F83",
    },
    401: {
        "process": "6000 6020-6027 6100 6120 6400-6403",
        "set-point": "6200 6220-6227 6300 6320 6410-6413",
        "state": "6422",
    },
    402: {
        "state": "603F 6041 6061 60B9",
        "command": "6040",
        "process": "6043 6044 6053 6054 6062-6064 6069 606B 606C 6074 6077-6079"
        " 60BA-60BD 60D1-60D8 60F4 60FA 60FC 60FD",
        "set-point": "6042 6071 607A 60C1 60FE-60FF",
    },
    404: {"process": "6100 6130 6140", "state": "6150"},
    406: {
        "process": "6004 6008 600C 6020 6030 6040 6050",
        "state": "6300 6400 6500 6503 6505",
        "time": "6508",
        "serial": "650B",
    },
    410: {"process": "6010 6020 6110 6120"},
    418: _BATTERY,
    419: _BATTERY,
}
"""By profile, 0 for all devices: indices, and ranges of them, in hexadecimal."""
_PROFILES: Final = range(0x6000, 0xA000)
_SERIAL_NUMBER: Final = (0x1018, 4)
_AXIS: Final = 0x800
"""Distance between the objects of two axes of a drive."""


def standard_nature(address: Address, profile: int) -> Nature | None:
    """Returns the reason for which an object's value is no configuration; None if it may be.

    profile: that of the device; with 0 (unknown) its objects are read as those of a drive.
    """
    index = address[0]
    if address == _SERIAL_NUMBER:
        return "serial"
    if index not in _PROFILES:
        return _natures(0).get(index)
    if profile in (0, 402):
        return _natures(402).get(_PROFILES[index % _AXIS])
    return _natures(profile).get(index)


@cache
def _natures(profile: int) -> dict[int, Nature]:
    found: dict[int, Nature] = {}
    for nature, spans in _TABLE.get(profile, {}).items():
        for span in spans.split():
            first, _, last = span.partition("-")
            found |= dict.fromkeys(range(int(first, 16), int(last or first, 16) + 1), nature)
    return found
