"""Colours of states, by the classes of the core: the same state has the same colour in every lane.

Green runs, amber waits, red is a fault, violet is lost, grey is unknown or off. Must not: know words for people.
"""

from typing import Final

_GREY, _LIGHT, _BLUE, _GREEN, _AMBER, _ORANGE, _RED, _VIOLET = (
    0x8A8F98FF,
    0x5B6470FF,
    0x3D85D6FF,
    0x3FA34DFF,
    0xE0A526FF,
    0xE8772EFF,
    0xD6453DFF,
    0x8E5BD0FF,
)

_DRIVE: Final = {
    "not-ready-to-switch-on": _LIGHT,
    "switch-on-disabled": _GREY,
    "ready-to-switch-on": _AMBER,
    "switched-on": _BLUE,
    "operation-enabled": _GREEN,
    "quick-stop-active": _ORANGE,
    "fault-reaction-active": _RED,
    "fault": _RED,
}

COLOURS: Final[dict[str, dict[str, int]]] = {
    "nmt": {
        "initialising": _BLUE,
        "pre-operational": _AMBER,
        "operational": _GREEN,
        "stopped": _RED,
        "lost": _VIOLET,
        "unknown": _GREY,
    },
    "drive": _DRIVE,
    "sdo": {"ok": _BLUE, "aborted": _RED, "failed": _RED, "incomplete": _GREY},
    "emcy": {"active": _RED},
    "problems": {"open": _RED, "unknown": _ORANGE, "ended": _AMBER, "harmless": _GREY},
    # A statusword's lane has the colours of the drive's.
    "value": {"0": _LIGHT, "1": _GREEN, **_DRIVE},
}
"""By kind of lane and class."""

FAULTS: Final = frozenset({"lost", "fault", "fault-reaction-active", "active"})
"""Classes of states that an engineer looks for first, without SDO transfers, which are too short to see in a lane."""

PLAIN: Final = (0x4F7CACFF, 0x3E8E8EFF, 0x8D6E63FF, 0x7A6FA8FF, 0x9C8A4AFF, 0x5F7A8AFF, 0xA0698AFF)
"""Colours of values of signals: distinct, and unlike running, waiting or a fault."""

WINDOW: Final = _RED
"""The synchronous window; values above it are late."""

LINES: Final = (
    0x3D85D6FF,
    0xE8772EFF,
    0x3FA34DFF,
    0xD6453DFF,
    0x8E5BD0FF,
    0x1FA6B8FF,
    0xD65A9DFF,
    0x9A9A2EFF,
    0xA9836BFF,
    0x7C8AA0FF,
)
"""Colours of lines that share a plot, in their order: distinct on black and on white."""
