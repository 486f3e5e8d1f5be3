"""The CAN interfaces of this host: their names, listening sockets, and errors that explain a failure.

Everything is queried from the kernel through sockets, so that it is right in a network namespace too. Must not: read
or send a frame, or change an interface. Linux only, but importing it is fine anywhere; the constants are those of
the kernel's generic headers.
"""

import errno
import os
import socket
import struct
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

from canalyze.errors import SourceError

BUFFER: Final = 16 << 20
"""Requested size of a socket's buffer in bytes: some 20 000 frames, a second of the fastest classic bus."""
TIMESTAMPNS, TIMESTAMPING, RXQ_OVFL = 35, 37, 40
"""Control messages of a frame: the kernel's stamp, the hardware's stamp, the drops of its socket so far."""
HOPELESS: Final = ("live.no_can", "live.not_linux", "live.forbidden", "live.not_can", "live.not_can_none")
"""Errors that waiting does not resolve."""

_AF_CAN, _CAN_RAW, _SOL_CAN_RAW = 29, 1, 101
_FILTER, _ERR_FILTER, _FD_FRAMES = 1, 2, 5
_ALL_ERRORS, _BUS_OFF = 0x1FFF_FFFF, 0x40
_RCVBUF, _RCVBUFFORCE = 8, 33
_RX_HARDWARE, _RX_SOFTWARE, _SOFTWARE, _RAW_HARDWARE = 4, 8, 16, 64
_GETLINK, _NEWLINK, _REQUEST = 18, 16, 1
_LINKINFO, _INFO_KIND, _INFO_DATA, _CAN_BITTIMING = 18, 1, 2, 1
_HEADS = 32
"""Bytes before the attributes of a link: nlmsghdr, ifinfomsg."""
_SIOCGIFFLAGS, _SIOCGIFHWADDR, _IFF_UP, _ARPHRD_CAN = 0x8913, 0x8927, 1, 280


def interfaces() -> tuple[list[str], list[str]]:
    """Returns the CAN interfaces of this host: those that are up, and those that are down."""
    up: list[str] = []
    down: list[str] = []
    with suppress(OSError):
        for _, name in socket.if_nameindex():
            if _is_can(name):
                (up if _is_up(name) else down).append(name)
    return up, down


def opened(name: str, *, hardware_stamps: bool = False) -> tuple[socket.socket, bool]:
    """Returns a socket that receives all frames of an interface, and true if its buffer is small.

    Raises SourceError if the interface cannot be listened to.
    """
    listening = can_socket(name)
    try:
        if _ask(name, _SIOCGIFFLAGS) is None:
            raise missing(name)
        if not _is_can(name):
            there = _listed()
            raise SourceError("live.not_can" if there else "live.not_can_none", channel=name, there=there)
        if not _is_up(name):
            raise SourceError("live.down", channel=name, command=bring_up(name))
        small = _set_up(listening, hardware_stamps=hardware_stamps)
        listening.bind((name,))
    except BaseException as error:
        listening.close()
        if isinstance(error, OSError):
            raise _refused(name, error) from error
        raise
    return listening, small


def watching(name: str) -> socket.socket | None:
    """Returns a socket that receives a frame only if the controller goes bus-off; None if the kernel refuses."""
    try:
        watch = can_socket(name)
    except SourceError:
        return None
    try:
        watch.setsockopt(_SOL_CAN_RAW, _FILTER, b"")
        watch.setsockopt(_SOL_CAN_RAW, _ERR_FILTER, struct.pack("@I", _BUS_OFF))
        watch.bind((name,))
    except OSError:
        watch.close()
        return None
    return watch


def bit_rate(name: str) -> int | None:
    """Returns the bit rate of an interface in bit/s; None if it has none (vcan) or it is unknown."""
    if not hasattr(socket, "AF_NETLINK"):
        return None
    try:
        asked = struct.pack("@IHHIIBxHiII", _HEADS, _GETLINK, _REQUEST, 1, 0, 0, 0, socket.if_nametoindex(name), 0, 0)
        with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0) as kernel:
            kernel.settimeout(0.5)
            kernel.send(asked)
            return told_bit_rate(kernel.recv(1 << 16))
    except OSError:
        return None


def told_bit_rate(answer: bytes) -> int | None:
    """Returns the bit rate in a link message of the kernel (RTM_NEWLINK)."""
    if len(answer) < _HEADS or struct.unpack_from("@H", answer, 4) != (_NEWLINK,):
        return None
    info = _attributes(_attributes(answer[_HEADS:]).get(_LINKINFO, b""))
    timing = _attributes(info.get(_INFO_DATA, b"")).get(_CAN_BITTIMING, b"")
    if info.get(_INFO_KIND, b"").rstrip(b"\0") != b"can" or len(timing) < 4:
        return None
    (rate,) = struct.unpack_from("@I", timing)
    return int(rate) or None


def _attributes(text: bytes) -> dict[int, bytes]:
    """Parses netlink attributes: each a length including its head of 4 bytes, a kind, padded to 4 bytes."""
    found: dict[int, bytes] = {}
    at = 0
    while at + 4 <= len(text):
        length, kind = struct.unpack_from("@HH", text, at)
        if length < 4:
            break
        found[kind & 0x3FFF] = text[at + 4 : at + length]
        at += (length + 3) & ~3
    return found


def _set_up(listening: socket.socket, *, hardware_stamps: bool) -> bool:
    """Sets the options of a socket; returns true if its buffer is smaller than requested."""
    options: list[tuple[int, int, int]] = [
        (_SOL_CAN_RAW, _FD_FRAMES, 1),
        (_SOL_CAN_RAW, _ERR_FILTER, _ALL_ERRORS),
        (socket.SOL_SOCKET, TIMESTAMPNS, 1),
        (socket.SOL_SOCKET, RXQ_OVFL, 1),
    ]
    if hardware_stamps:
        wished = _RX_HARDWARE | _RX_SOFTWARE | _SOFTWARE | _RAW_HARDWARE
        options.append((socket.SOL_SOCKET, TIMESTAMPING, wished))
    for level, option, value in options:
        with suppress(OSError):  # an older kernel does without
            listening.setsockopt(level, option, value)
    try:
        listening.setsockopt(socket.SOL_SOCKET, _RCVBUFFORCE, BUFFER)
    except OSError:
        listening.setsockopt(socket.SOL_SOCKET, _RCVBUF, BUFFER)
    return listening.getsockopt(socket.SOL_SOCKET, _RCVBUF) < 2 * BUFFER  # the kernel doubles what it is asked for


def can_socket(name: str) -> socket.socket:
    """Returns a new CAN socket. Raises SourceError for that interface if that fails."""
    if not hasattr(socket, "AF_CAN"):
        raise SourceError("live.not_linux", channel=name)
    try:
        return socket.socket(_AF_CAN, socket.SOCK_RAW, _CAN_RAW)
    except OSError as error:
        raise _refused(name, error) from error


def _refused(name: str, error: OSError) -> SourceError:
    """Returns the error for a socket that cannot be opened."""
    if error.errno in (errno.EAFNOSUPPORT, errno.EPROTONOSUPPORT):
        return SourceError("live.no_can", channel=name)
    if error.errno in (errno.EPERM, errno.EACCES):
        return SourceError("live.forbidden", channel=name)
    if error.errno == errno.ENODEV:
        return missing(name)
    return SourceError("live.refused", channel=name, error=error)


def missing(name: str) -> SourceError:
    """Returns the error for an unknown interface, with the interfaces that exist."""
    there = _listed()
    if there:
        return SourceError("live.missing", channel=name, there=there)
    return SourceError("live.no_interface", channel=name)


def went(name: str, error: OSError) -> SourceError:
    """Returns the error for an interface that was lost."""
    if _ask(name, _SIOCGIFFLAGS) is None:
        return SourceError("live.unplugged", channel=name)
    if error.errno == errno.ENETDOWN or not _is_up(name):
        return SourceError("live.went_down", channel=name, command=bring_up(name))
    if error.errno == errno.ENODEV:
        return SourceError("live.unplugged", channel=name)
    return SourceError("live.lost", channel=name, error=error)


def _listed() -> str:
    up, down = interfaces()
    return ", ".join((*up, *down))


def bring_up(name: str) -> str:
    """Returns the command that brings an interface up; a virtual one has no bit rate."""
    virtual = "/virtual/" in os.path.realpath(Path("/sys/class/net", name)) or name.startswith(("v", "slcan"))
    return f"sudo ip link set {name} up" + ("" if virtual else " type can bitrate 500000")


def _is_can(name: str) -> bool:
    return _ask(name, _SIOCGIFHWADDR) == _ARPHRD_CAN


def _is_up(name: str) -> bool:
    flags = _ask(name, _SIOCGIFFLAGS)
    return flags is not None and bool(flags & _IFF_UP)


def _ask(name: str, request: int) -> int | None:
    """Queries a number of an interface from the kernel; returns None if there is no such interface."""
    if sys.platform == "win32":
        return None
    import fcntl

    asked = os.fsencode(name)
    if not 0 < len(asked) < 16 or b"\0" in asked:
        return None
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as any_socket:
        try:
            answer = fcntl.ioctl(any_socket, request, struct.pack("@16sH22x", asked, 0))
        except OSError:
            return None
    (value,) = struct.unpack_from("@H", answer, 16)
    return int(value)
