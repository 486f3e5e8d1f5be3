"""A device made from a description, and the frames of a master that reads and writes all of it.

Why it exists: whether a description is held rightly against traffic shows only where the device is known: it is the
description itself, or that with one thing changed. What it must not do: use what canalyze says of frames.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from captures import CanFrame, log_text, spaced
from sdo_wire import Channel, abort, expedited_download, expedited_upload, segmented_download, segmented_upload

from canalyze._core import DATA_TYPES
from canalyze.dictionary import BYTES, REAL, STRINGS, Dictionary, Entry, NodeOffset

Address = tuple[int, int]

NODE = 5
WRITE_ONLY, READ_ONLY, NO_OBJECT, NO_SUB = 0x06010001, 0x06010002, 0x06020000, 0x06090011


@dataclass(frozen=True)
class Held:
    """An object of the device."""

    data: bytes
    readable: bool
    writable: bool
    written: bytes | None = None
    """What the master writes, where it is not what the object holds."""


@dataclass
class Device:
    """Its objects, and the lengths of its PDOs by identifier."""

    objects: dict[Address, Held]
    pdos: dict[tuple[int, bool], int]
    absent: dict[Address, int] = field(default_factory=dict)
    """What it is asked for and does not have, with the abort code of that."""

    def change(self, address: Address, **changes: object) -> None:
        """Make one object another one, if it is there."""
        if address in self.objects:
            self.objects[address] = replace(self.objects[address], **changes)  # type: ignore[arg-type]

    def frames(self, *, sdo: bool = True) -> Iterator[CanFrame]:
        """Boot-up; every object read, then written; the node started; every PDO, twice."""
        channel = Channel(NODE)
        yield CanFrame("can0", 0x700 + NODE, b"\0")
        for address, held in sorted(self.objects.items()) if sdo else ():
            yield from read(channel, address, held)
        for address, code in self.absent.items():
            yield from refused(channel, address, 0x40, code)
        for address, held in sorted(self.objects.items()) if sdo else ():
            yield from write(channel, address, held)
        yield CanFrame("can0", 0, bytes([1, NODE]))
        for (can_id, extended), length in [*self.pdos.items()] * 2:
            yield CanFrame("can0", can_id, bytes(length), extended=extended)

    def log(self, *, sdo: bool = True) -> bytes:
        """The capture of it."""
        return log_text(spaced(self.frames(sdo=sdo)))


def read(channel: Channel, address: Address, held: Held) -> list[CanFrame]:
    """A read of an object, as its access lets it end."""
    if not held.readable:
        return refused(channel, address, 0x40, WRITE_ONLY)
    short = 1 <= len(held.data) <= 4
    return (expedited_upload if short else segmented_upload)(channel, *address, held.data)


def write(channel: Channel, address: Address, held: Held) -> list[CanFrame]:
    """A write of what it holds, or of another value."""
    data = held.data if held.written is None else held.written
    if not held.writable:
        return refused(channel, address, 0x23, READ_ONLY)
    short = 1 <= len(data) <= 4
    return (expedited_download if short else segmented_download)(channel, *address, data)


def refused(channel: Channel, address: Address, command: int, code: int) -> list[CanFrame]:
    """A request and the device's abort."""
    return [channel.client(struct.pack("<BHB", command, *address)), channel.server(abort(*address, code))]


def device(found: Dictionary) -> Device:
    """The device that a description describes."""
    objects = {
        (entry.index, entry.sub): Held(encoded(entry), entry.access != "wo", entry.access in ("wo", "rw", "rwr", "rww"))
        for thing in found.objects
        for entry in thing.entries
    }
    filed = found.device
    for sub, number in enumerate((filed.vendor_number, filed.product_number, filed.revision_number), 1):
        entry = found.entry(0x1018, sub)
        if entry is not None and entry.value is None and number:
            objects[0x1018, sub] = replace(objects[0x1018, sub], data=encoded(entry, number))
    pdos = {}
    for pdo in found.pdos:
        can_id = pdo.cob_id.at(NODE)
        if can_id is not None and pdo.cob_id.valid and 0 < pdo.bits <= 64 and not pdo.multiplex:
            pdos[can_id, pdo.cob_id.extended] = -(-pdo.bits // 8)
    return Device(objects, pdos)


def width(entry: Entry) -> int:
    """The size of an object in bytes; 0 for a type that has none."""
    return -(-(DATA_TYPES.get(entry.type, ("", 0))[1] or 0) // 8)


def encoded(entry: Entry, value: object = None) -> bytes:
    """A value as SDO carries it: by default what the object starts with, else what its type and limits allow."""
    if value is None:
        value = entry.value
    if isinstance(value, NodeOffset):
        value = value.at(NODE)
    if entry.type in STRINGS:
        text = value if isinstance(value, str) else "text"
        return text.encode("utf-16-le" if entry.type == 0x0B else "utf-8")
    if entry.type in BYTES:
        return value if isinstance(value, bytes) else b"\1\2\3\4\5"
    allowed = value if isinstance(value, int | float) else _near_zero(entry)
    if entry.type in REAL:
        return struct.pack({32: "<f", 64: "<d"}[REAL[entry.type]], float(allowed))
    size = width(entry) or 4
    return (int(allowed) & (1 << 8 * size) - 1).to_bytes(size, "little")


def _near_zero(entry: Entry) -> int | float:
    """The value within the limits of an entry that is nearest to 0."""
    low, high = entry.low or 0, entry.high or 0
    return low if low > 0 else high if entry.high is not None and high < 0 else 0
