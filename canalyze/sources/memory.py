"""A capture in memory as an input, with the interface of `file.Source`.

Messages of python-can become the records of `packed`, messages of MCAP's own reader an MCAP file. Must not: know a
format itself.
"""

import struct
from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

from canalyze.errors import SourceError
from canalyze.sources import packed
from canalyze.sources.file import CHUNK

if TYPE_CHECKING:
    from can import Message

_MESSAGE: Final = ("arbitration_id", "data", "timestamp", "dlc")
"""Attributes that only a message of python-can has together."""


class Memory:
    """Bytes with a name."""

    regular: Final = True
    damage: Final = None
    begins: Final = False
    path: Final = None

    def __init__(self, name: str, data: bytes) -> None:
        """Wraps `data`; `name` is used in messages."""
        self.name = name
        self.taken = 0
        self._data = memoryview(data)

    def read(self) -> bytes:
        """Returns the next bytes, b"" at the end."""
        given = bytes(self._data[self.taken : self.taken + CHUNK])
        self.taken += len(given)
        return given

    def rests(self) -> bool:
        """Returns false; everything is there."""
        return False

    def close(self) -> None:
        """Does nothing."""


def is_message(one: object) -> bool:
    """Returns true for a message of python-can, or an object with its attributes."""
    return all(hasattr(one, name) for name in _MESSAGE)


def is_mcap(one: object) -> bool:
    """Returns true for an item of MCAP's reader: schema, channel, message, and optionally the decoded message."""
    return isinstance(one, tuple) and len(one) in (3, 4) and hasattr(one[1], "topic") and hasattr(one[2], "log_time")


def bus_of(channel: object) -> str:
    """Returns the name of the bus for a message's channel; "" for None."""
    if channel is None:
        return ""
    from canalyze.sources.buses import bus_name

    return bus_name(str(channel))


def records(messages: Iterable["Message"]) -> bytes:
    """Returns messages as records of the core. Raises TypeError for other objects.

    If no message has a stamp above 0, all are without stamps.
    """
    packer = packed.Packer(6, directed=True, bus=bus_of)
    out = bytearray(packed.dialect("reader", "python-can"))
    for number, message in enumerate(_stamped(messages), 1):
        if not is_message(message):
            raise TypeError(f"source: item {number} is no can.Message but {type(message).__name__}")
        try:
            out += packer.frame(message)
        except packed.Unfit as unfit:
            out += packed.unreadable(unfit.reason, number)
        except (TypeError, ValueError, OverflowError, struct.error):
            out += packed.unreadable(packed.DATA, number)
    return bytes(out)


def _stamped(messages: Iterable["Message"]) -> Iterator["Message"]:
    """Yields the messages; if all stamps are 0, they were never set and are removed."""
    from copy import copy

    waiting: list[Message] = []
    rest = iter(messages)
    for message in rest:
        waiting.append(message)
        if getattr(message, "timestamp", 1.0) != 0:
            yield from chain(waiting, rest)
            return
    for message in waiting:
        bare = copy(message)
        bare.timestamp = float("nan")
        yield bare


def mcap_file(messages: Iterable[tuple[Any, ...]]) -> bytes:
    """Returns messages of MCAP's own reader as a file. Raises SourceError if the library is not installed."""
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise SourceError("library.extra", name="mcap", line="pip install 'canalyze[mcap]'") from error
    file = BytesIO()
    writer = Writer(file)
    writer.start()
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    for number, item in enumerate(messages, 1):
        if not is_mcap(item):
            raise TypeError(f"source: item {number} is no message of MCAP but {type(item).__name__}")
        schema, channel, message = item[:3]
        if channel.id not in channels:
            of = 0
            if schema is not None:
                if schema.id not in schemas:
                    schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
                of = schemas[schema.id]
            channels[channel.id] = writer.register_channel(
                channel.topic, channel.message_encoding, of, dict(channel.metadata)
            )
        writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()
