"""Captures as what a live bus gives: blocks of frames, and between them how late it is, as `sources/live.py` has them.

Why it exists: what is said live is compared with what is said of the file, and no clock of this machine may come into
it: the time is that of the stamps. What it must not do: judge.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from canalyze import _core
from canalyze.running.reading import SessionOptions
from canalyze.sources.live import RELEASE_ALL, dropped_block, name_block, records_block, until_block

TICK_NS = 100_000_000
"""How often a live source says how late it is."""
HEAD = 24
FRAME, BUS, DROPPED = 1, 2, 8


def records(text: bytes, form: str) -> Iterator[tuple[int, int, int | None, bytes]]:
    """Kind, bus, stamp and bytes of each record of a capture."""
    session = _core.Session(SessionOptions(format="convert", to="packed"))
    session.begin("capture", True, form)
    packed = b"".join([session.feed(text), session.end(), session.finish()])
    at = 0
    while at < len(packed):
        kind = packed[at]
        if kind == FRAME:
            flags, bus, size = packed[at + 1], packed[at + 2], packed[at + 6]
            (stamp,) = struct.unpack_from("<q", packed, at + 16)
            yield kind, bus, stamp if flags & 1 else None, packed[at : at + HEAD + size]
        else:
            bus, size = packed[at + 1], int.from_bytes(packed[at + 2 : at + 4], "little")
            yield kind, bus, None, packed[at : at + HEAD + size]
        at += HEAD + size


def blocks(text: bytes, *, form: str = "candump", tick_ns: int = TICK_NS) -> Iterator[bytes]:
    """The blocks of a capture, each frame in one; the time passes every `tick_ns` while none comes."""
    now: int | None = None
    for kind, bus, stamp, record in records(text, form):
        if kind == BUS:
            yield name_block(bus, record[HEAD:].decode())
        if kind == DROPPED:
            yield dropped_block(bus, int.from_bytes(record[16:24], "little"))
        if kind != FRAME:
            continue
        while now is not None and stamp is not None and now + tick_ns < stamp:
            now += tick_ns
            yield until_block(now)
        yield records_block(bus, record, 1)
        if stamp is not None:
            now = stamp if now is None else max(now, stamp)
            yield until_block(now)
        else:
            yield until_block(RELEASE_ALL)


def live_output(
    text: bytes,
    *,
    lang: str = "en",
    output_format: str = "jsonl",
    network: _core.Network | None = None,
    form: str = "candump",
    tick_ns: int = TICK_NS,
) -> bytes:
    """What `sniff` shows of a bus on which a capture comes."""
    session = _core.Session(SessionOptions(lang=lang, format=output_format, network=network, incidents=True))
    session.begin("live", False, "live")
    out = [session.feed(block) for block in blocks(text, form=form, tick_ns=tick_ns)]
    return b"".join([*out, session.end(), session.finish()])
