"""Capture files as other people's programs read them: python-can, asc2log, mcap with its ROS 2 decoder, tshark.

Why it exists: what `convert` writes is right when others read the frames out of it. What it must not do: use anything
of canalyze but the frame that both sides are compared in.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import can
from capture_frames import Recorded
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from other_writers import in_utc, run_program

Read = Callable[[Path], list[Recorded]]


def frame(message: can.Message) -> Recorded:
    """A message of python-can."""
    remote, error = message.is_remote_frame, message.is_error_frame
    bus = message.channel
    return Recorded(
        t_ns=round(message.timestamp * 1e6) * 1000,
        bus=bus if isinstance(bus, str) else f"can{bus or 0}",
        can_id=message.arbitration_id & 0x1FFF_FFFF,
        data=b"" if remote else bytes(message.data),
        kind="error" if error else "remote" if remote else "fd" if message.is_fd else "data",
        extended=message.is_extended_id and not error,
        asked=message.dlc if remote else 0,
        brs=message.bitrate_switch,
        esi=message.error_state_indicator,
        sent=not message.is_rx,
    )


def python_can(reader: Callable[..., Any], first_channel: int = 0) -> Read:
    """A reader of python-can, and from which number it counts channels."""

    def read(path: Path) -> list[Recorded]:
        with in_utc():
            source = reader(path)
            frames = [frame(message) for message in source]
            source.stop()
        numbered = [re.fullmatch(r"can(\d+)", one.bus) for one in frames]
        return [
            replace(one, bus=f"can{int(name[1]) - first_channel}") if name and first_channel else one
            for one, name in zip(frames, numbered, strict=True)
        ]

    return read


_LOG = re.compile(r"\((\d+)\.(\d+)\) (\S+) ([0-9A-F]+)#(#[0-9A-F])?(R)?([0-9A-F]*)(?: ([RT]))?")


def candump_log(text: str) -> list[Recorded]:
    """Candump's log form, read by the grammar that can-utils documents in lib.h."""
    frames = []
    for line in text.splitlines():
        match = _LOG.fullmatch(line.strip())
        if match is None:
            raise ValueError(f"no frame: {line!r}")
        seconds, fraction, bus, can_id, fd, remote, data, side = match.groups()
        number = int(can_id, 16)
        error = len(can_id) == 8 and bool(number & 0x2000_0000)
        flags = int(fd[1], 16) if fd else 0
        frames.append(
            Recorded(
                t_ns=int(seconds) * 1_000_000_000 + int(fraction.ljust(9, "0")[:9]),
                bus=bus,
                can_id=number & 0x1FFF_FFFF,
                data=b"" if remote else bytes.fromhex(data),
                kind="error" if error else "remote" if remote else "fd" if fd else "data",
                extended=len(can_id) == 8 and not error,
                asked=int(data or "0", 16) if remote else 0,
                brs=bool(flags & 1),
                esi=bool(flags & 2),
                sent=None if side is None else side == "T",
            )
        )
    return frames


def carried(text: str) -> str:
    """The text with each stamp of a whole second as one.

    Some versions of asc2log carry above 1,000,000 µs only, and write the second before with a fraction of seven digits.
    """
    return re.sub(r"^\((\d+)\.1000000\)", lambda stamp: f"({int(stamp[1]) + 1}.000000)", text, flags=re.MULTILINE)


def asc2log(path: Path) -> list[Recorded]:
    """can-utils' converter to candump's log form."""
    return candump_log(carried(run_program("asc2log", stdin=path.read_bytes()).decode()))


def mcap(path: Path) -> list[Recorded]:
    """Every message of a recording, decoded by its own schema, in the order of its log times."""
    frames = []
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, said in reader.iter_decoded_messages():
            moment = said.header.stamp.sec * 1_000_000_000 + said.header.stamp.nanosec
            assert (message.log_time, message.publish_time) == (moment, moment)
            frames.append(_decoded(channel.topic, moment, said))
    return frames


def _decoded(topic: str, moment: int, said: Any) -> Recorded:
    def flag(*names: str) -> bool:
        return any(getattr(said, name, False) for name in names)

    remote, error = flag("is_rtr", "rtr"), flag("is_error")
    fd = flag("fdf") or (not hasattr(said, "rtr") and not hasattr(said, "is_rtr"))
    length = getattr(said, "dlc", getattr(said, "len", len(said.data)))
    bus, _, side = topic.strip("/").partition("/")
    return Recorded(
        t_ns=moment,
        bus=bus,
        can_id=said.id,
        data=b"" if remote else bytes(said.data)[:length],
        kind="error" if error else "remote" if remote else "fd" if fd else "data",
        extended=flag("is_extended", "extended") and not error,
        asked=length if remote else 0,
        brs=flag("brs"),
        esi=flag("esi"),
        sent=side.startswith("to_") or side.endswith("_tx"),
    )


_FIELDS = (
    *("frame.time_epoch", "frame.interface_name", "can.id", "can.flags.xtd", "can.flags.rtr", "can.flags.err"),
    *("can.len", "data.data", "canfd.flags.brs", "canfd.flags.esi", "frame.packet_flags_direction"),
)


def tshark(path: Path) -> list[Recorded]:
    """Wireshark's dissection, field by field. Of an error frame it shows no bytes: only that it is one."""
    asked = [word for field in _FIELDS for word in ("-e", field)]
    shown = ["-T", "fields", "-E", "separator=;", "-E", "occurrence=f"]
    out = run_program("tshark", "-n", "-r", path, "--disable-protocol", "autosar-nm", *shown, *asked).decode()
    return [_dissected(line.split(";")) for line in out.splitlines()]


def _dissected(values: Sequence[str]) -> Recorded:
    epoch, bus, can_id, wide, remote, error, length, data, brs, esi, side = values
    fd, asks = brs != "", remote in ("1", "True")
    return Recorded(
        t_ns=int(Decimal(epoch) * 1_000_000_000),
        bus=bus,
        can_id=int(can_id or "0"),
        data=b"" if asks else bytes.fromhex(data),
        kind="error" if error in ("1", "True") else "remote" if asks else "fd" if fd else "data",
        extended=wide in ("1", "True"),
        asked=int(length) if asks else 0,
        brs=brs in ("1", "True"),
        esi=esi in ("1", "True"),
        sent={0: None, 1: False, 2: True}[int(side or "0", 0) & 3],
    )
