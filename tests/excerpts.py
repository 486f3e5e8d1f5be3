"""Cuts of a capture whose truth is known, and what is said falsely about what is left.

Why it exists: what people paste is a part of a capture. Whatever is missing, nothing that is stated may differ from
what the whole capture shows: it is the same, or it is marked as not known. What it must not do: ask for completeness;
that a transfer which is there in one piece is decoded in full is asked apart.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

from captures import Analysis, CanFrame, Row, analyze, console_text, log_text
from clean_sessions import sessions as clean_sessions
from sdo_wire import (
    Channel,
    abort,
    block_download,
    block_upload,
    expedited_download,
    expedited_upload,
    is_client,
    segmented_download,
    segmented_upload,
)

LONGEST = 4000
"""Frames of a session that is cut: longer ones are cut from a part of this length."""


@dataclass(frozen=True, slots=True)
class Excerpt:
    """What is left of a capture, and where each of its frames stood."""

    frames: tuple[CanFrame, ...]
    origin: tuple[int, ...]
    """The place of each frame in the whole capture, from 0."""
    lost: tuple[tuple[int, int], ...] = ()
    """Announced holes: how many frames of the excerpt come before, and how many frames are missing."""
    stamped: bool = True

    def text(self) -> bytes:
        """The excerpt as a candump log, or without stamps as on a console."""
        if not self.stamped:
            return console_text(self.frames)
        lines: list[bytes] = []
        total = 0
        holes = dict(self.lost)
        for number in range(len(self.frames) + 1):
            if count := holes.get(number):
                total += count
                bus = self.frames[min(number, len(self.frames) - 1)].bus
                lines.append(
                    f"DROPCOUNT: dropped {count} CAN frames on '{bus}' socket (total drops {total})\n".encode()
                )
            if number < len(self.frames):
                lines.append(self.frames[number].log_line().encode())
        return b"".join(lines)


def excerpt(frames: Sequence[CanFrame], kept: Sequence[int], lost: Sequence[tuple[int, int]] = ()) -> Excerpt:
    """The frames at these places."""
    return Excerpt(tuple(frames[place] for place in kept), tuple(kept), tuple(lost))


# -- sessions


def _data(rng: random.Random, size: int) -> bytes:
    """Bytes of a file: random, text, zeros, or frames of SDO, which are the hardest to tell from commands."""
    kind = rng.randrange(5)
    if kind == 0:
        return bytes(size)
    if kind == 1:
        return bytes(rng.choice(b"firmware 1.0\n") for _ in range(size))
    if kind == 2:
        parts = [bytes([command, 0x00, 0x20, 0x01, 7, 0, 0]) for command in (0x40, 0x2F, 0x60, 0x43, 0x80, 0xA1, 0xC1)]
        return b"".join(rng.choice(parts) for _ in range(size // 7 + 1))[:size]
    return rng.randbytes(size)


def _transfer(rng: random.Random, channel: Channel, kind: str) -> list[CanFrame]:
    index, sub = rng.choice([0x1008, 0x2000, 0x2101, 0x6060, 0x1F50, 0x3210]), rng.randrange(4)
    match kind:
        case "expedited upload":
            return expedited_upload(channel, index, sub, rng.randbytes(rng.randint(1, 4)))
        case "expedited download":
            return expedited_download(channel, index, sub, rng.randbytes(rng.randint(1, 4)))
        case "segmented upload":
            return segmented_upload(channel, index, sub, _data(rng, rng.randint(5, 60)))
        case "segmented download":
            return segmented_download(channel, index, sub, _data(rng, rng.randint(5, 60)))
        case "refused":
            return [
                channel.client(bytes([0x40]) + abort(index, sub, 0)[1:]),
                channel.server(abort(index, sub, 0x0602_0000)),
            ]
        case _:
            block = block_upload if kind == "block upload" else block_download
            blksize = rng.choice([1, 2, 5, 16, 64, 127])
            size = rng.choice([rng.randint(1, 30), rng.randint(30, 400), rng.randint(400, 1500)])
            again = [rng.randint(1, blksize)] if rng.random() < 0.2 and blksize > 1 else []
            return block(
                channel, index, sub, _data(rng, size), blksize=blksize, with_crc=rng.random() < 0.7, acknowledged=again
            )


KINDS = (
    "expedited upload",
    "expedited download",
    "segmented upload",
    "segmented download",
    "refused",
    "block upload",
    "block download",
)


def generated(seed: int) -> list[CanFrame]:
    """Transfers of every kind with two nodes at a time, beside heartbeats."""
    rng = random.Random(seed)
    streams: list[list[CanFrame]] = []
    ends: dict[int, int] = {}
    for node in rng.sample(range(1, 128), 2):
        channel, now, frames = Channel(node), rng.randint(0, 50_000), []
        for _ in range(rng.randint(3, 7)):
            client = rng.choice([300, 800, 3000])
            for frame in _transfer(rng, channel, rng.choice(KINDS)):
                now += rng.randint(150, 400) if not is_client(frame) else rng.randint(client // 2, client)
                frames.append(replace(frame, t_us=now))
            now += rng.choice([2_000, 20_000, 200_000])
        streams.append(frames)
        ends[node] = now
    for node in ends:
        beats = range(rng.randint(0, 99_999), max(ends.values()), 100_000)
        streams.append([CanFrame("can0", 0x700 + node, b"\x05", beat) for beat in beats])
    return sorted((frame for stream in streams for frame in stream), key=lambda frame: frame.t_us)


@cache
def session(name: str) -> tuple[CanFrame, ...]:
    """A session by its name: `generated N`, or one of the clean ones."""
    if name.startswith("generated "):
        return tuple(generated(int(name.removeprefix("generated "))))
    return tuple(clean_sessions()[name].frames)


@cache
def truth(name: str) -> Analysis:
    """What the whole session shows."""
    return analyze(log_text(session(name)))


# -- cuts


def beginning(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """The capture begins later."""
    return excerpt(frames, range(rng.randrange(len(frames)), len(frames)))


def end(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """The capture ends sooner."""
    return excerpt(frames, range(rng.randint(1, len(frames))))


def window(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """Some frames out of the middle."""
    first = rng.randrange(len(frames))
    return excerpt(frames, range(first, min(len(frames), first + rng.choice([3, 10, 30, 100, 300]))))


def _piece(frames: Sequence[CanFrame], rng: random.Random) -> tuple[int, int]:
    count = min(rng.choice([1, 2, 5, 20, 100]), len(frames) - 1)
    first = rng.randint(0, len(frames) - count)
    return first, first + count


def announced(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """A piece is missing, and a drop counter says so."""
    first, last = _piece(frames, rng)
    return excerpt(frames, [*range(first), *range(last, len(frames))], [(first, last - first)])


def unannounced(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """A piece is missing, and nothing says so."""
    first, last = _piece(frames, rng)
    return excerpt(frames, [*range(first), *range(last, len(frames))])


def _where(frames: Sequence[CanFrame], kept: Callable[[CanFrame], bool]) -> Excerpt:
    return excerpt(frames, [place for place, frame in enumerate(frames) if kept(frame)])


def without_a_node(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """What one node sends is missing."""
    nodes = sorted({frame.can_id & 0x7F for frame in frames if 0x580 < frame.can_id < 0x600} or {1})
    node = rng.choice(nodes)
    return _where(frames, lambda frame: frame.can_id & 0x7F != node or 0x600 <= frame.can_id < 0x680)


def one_direction(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """All requests, or all responses, are missing; of a part of the capture."""
    base = rng.choice([0x580, 0x600])
    part = window(frames, rng)
    kept = [place for place in part.origin if not base <= frames[place].can_id < base + 0x80]
    return excerpt(frames, kept)


def one_identifier(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """Only one CAN-ID is shown."""
    one = rng.choice(sorted({frame.can_id for frame in frames}))
    return _where(frames, lambda frame: frame.can_id == one)


def client_late(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """A part, in which client frames are listed late: behind up to two server frames of the same node."""
    part = window(frames, rng)
    order = list(part.origin)
    for place in range(len(order) - 1):
        now, after = frames[order[place]], frames[order[place + 1]]
        if is_client(now) and after.can_id == now.can_id - 0x80 and rng.random() < 0.5:
            order[place], order[place + 1] = order[place + 1], order[place]
    stamps = sorted(frames[place].t_us for place in order)
    moved = [replace(frames[place], t_us=t_us) for place, t_us in zip(order, stamps, strict=True)]
    return Excerpt(tuple(moved), tuple(order))


def without_stamps(frames: Sequence[CanFrame], rng: random.Random) -> Excerpt:
    """A part as candump prints it without stamps."""
    return replace(window(frames, rng), stamped=False)


CUTS: dict[str, Callable[[Sequence[CanFrame], random.Random], Excerpt]] = {
    "beginning": beginning,
    "end": end,
    "window": window,
    "announced": announced,
    "unannounced": unannounced,
    "without a node": without_a_node,
    "one direction": one_direction,
    "one identifier": one_identifier,
    "client late": client_late,
    "without stamps": without_stamps,
}

# -- what is false

UNTOLD = {("foreign", "sdo"), ("foreign", "pdo"), ("heartbeat", "guarding"), ("guarding", "heartbeat")}
"""Services that only the frames before tell: COB-IDs that were written, the remote frame of node guarding."""

_VALUE = re.compile(r" = ([^;]+)(?:;|$)")


def _bare(value: str) -> str:
    """A value without what is said about it: `[...]` at its end, and its size."""
    return re.sub(r" \(\d+ bytes?\)$", "", re.sub(r"( \[[^\]]*\])+$", "", value))


def _key(row: Row, origin: Sequence[int]) -> int:
    return origin[int(row["frame"]) - 1]


def false_statements(whole: Analysis, said: Analysis, origin: Sequence[int]) -> Iterator[str]:
    """Everything that is said of an excerpt and is not so."""
    yield from _of_frames(whole, said, origin)
    yield from _of_transfers(whole, said, origin)
    known = {(row["code"], row["frame"] - 1) for row in whole.findings if row["frame"]}
    codes = {row["code"] for row in whole.findings}
    for row in said.above_info():
        place = _key(row, origin) if row["frame"] else None
        if (row["code"], place) not in known and row["code"] not in codes:
            yield f"finding {row['code']} at {place}: {row['message']}"


def _of_frames(whole: Analysis, said: Analysis, origin: Sequence[int]) -> Iterator[str]:
    values = "\n".join({row["text"] for row in whole.transfers})
    for row in said.frames:
        true = whole.frames[_key(row, origin)]
        where = f"frame {true['frame']} {true['id']}#{true['data']}"
        if (row["service"], true["service"]) not in UNTOLD and row["service"] != true["service"]:
            yield f"service {where}: {row['service']}, is {true['service']}"
        if row.get("sdo") is None or true.get("sdo") is None:
            continue
        ours, theirs = row["sdo"], true["sdo"]
        if ours["index"] is not None and (ours["index"], ours["sub"]) != (theirs["index"], theirs["sub"]):
            yield f"object {where}: {row['text']!r}, is {true['text']!r}"
        elif ours["command"] not in (theirs["command"], None, "undetermined"):
            yield f"command {where}: {row['text']!r}, is {true['text']!r}"
        elif "[incomplete]" in row["text"]:
            continue
        elif any(_bare(value) not in true["text"] + values for value in _VALUE.findall(row["text"])):
            yield f"value {where}: {row['text']!r}, is {true['text']!r}"


def _stands(row: Row, true: bytes) -> bool:
    """Whether bytes stand where the data has them, as far as their place is known; and it is told that others lack."""
    data = bytes.fromhex(row["data"])
    given: list[int | None] = list(data)
    begins, exact = [0], True
    for hole in row.get("holes", ()):
        offset, length = hole["offset"], hole["length"]
        exact &= length is not None
        if length is None:
            begins.append(offset)
        elif offset == len(data):
            if not exact or offset + length != len(true):
                return False
        else:
            given[offset : offset + length] = [None] * length
    if row.get("holes") == [{"offset": 0, "length": None}] and row["index"] is not None:
        # It is told that bytes lack, and not where.
        ends = {at for at in range(len(data) + 1) if true.endswith(data[at:])}
        return any(at in ends for at in range(len(data) + 1) if true.startswith(data[:at]))
    if row["status"] == "incomplete" and 0 < len(data) < len(true) and not row.get("holes"):
        return False
    for number, (begin, end) in enumerate(zip(begins, [*begins[1:], len(given)], strict=True)):
        run = given[begin:end]
        places = range(1 if number == 0 else len(true) - len(run) + 1)
        if not any(
            len(run) <= len(true) - at and all(byte in (None, true[at + step]) for step, byte in enumerate(run))
            for at in places
        ):
            return False
    return True


def _of_transfers(whole: Analysis, said: Analysis, origin: Sequence[int]) -> Iterator[str]:
    """Each transfer of the excerpt is one of the whole capture, and nothing else is said of it."""
    of_frame: dict[int, Row] = {}
    by_number = {row["transfer"]: row for row in whole.transfers}
    for frame in whole.frames:
        if frame.get("sdo") and frame["sdo"]["transfer"] in by_number:
            of_frame[frame["frame"] - 1] = by_number[frame["sdo"]["transfer"]]
    for row in said.transfers:
        first, last = origin[row["first_frame"] - 1], origin[row["last_frame"] - 1]
        true = of_frame.get(first)
        where = f"transfer of frames {first + 1}..{last + 1}"
        stated = f"{row['direction']} {row['index']}:{row['sub']} = {row['data']} {row['status']}"
        if true is None:
            yield f"phantom {where}: {stated}"
            continue
        being = f"{true['direction']} {true['index']}:{true['sub']} = {true['data']} {true['status']}"
        if of_frame.get(last) is not true and (row["status"], row["data"]) != (true["status"], true["data"]):
            yield f"joined {where}: {stated}, is {being}"
        if row["index"] is not None and (row["index"], row["sub"]) != (true["index"], true["sub"]):
            yield f"object {where}: {stated}, is {being}"
        if row["direction"] != true["direction"]:
            yield f"direction {where}: {stated}, is {being}"
        if row["status"] not in ("incomplete", "open", true["status"]):
            yield f"status {where}: {stated}, is {being}"
        if row["status"] == "ok" and (row["data"], row["value"]) != (true["data"], true["value"]):
            yield f"value {where}: {stated}, is {being}"
        if true["status"] == "ok" and not _stands(row, bytes.fromhex(true["data"])):
            yield f"bytes {where}: {stated} {row.get('holes', '')}, is {being}"
        if row["size_indicated"] is not None and row["size_indicated"] != true["size_indicated"]:
            yield f"size {where}: {row['size_indicated']}, is {true['size_indicated']}"
        if row["mode"] not in (None, true["mode"]) and row["status"] != "incomplete":
            yield f"mode {where}: {row['mode']} {stated}, is {true['mode']} {being}"
