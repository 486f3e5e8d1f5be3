"""Values that python-canopen's client moved over a virtual bus must come out of canalyze unchanged.

Client and server of python-canopen for expedited and segmented transfers; for blocks, which its server does not
have, the small block server of these tests. A listener writes down the frames; the values are known from the calls.
"""

from __future__ import annotations

import logging
import random
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import can
import canopen
import pytest
from block_server import BlockServer
from captures import DATA, CanFrame, Row, analyze, log_text, run_canalyze, spaced
from test_contents import s_records

from canalyze.reports.extract import recognised

NODE, BLOCK_NODE, INDEX = 9, 10, 0x2000


SIZES = sorted({*range(1, 30), 63, 64, 126, 127, 889, 890, 2000, *random.Random(301).sample(range(30, 2000), 15)})


@dataclass
class Bench:
    """A client, its servers, and what goes over the bus between them."""

    ordinary: Any  # SdoClient; its methods have no types
    blocks: Any
    frames: list[CanFrame] = field(default_factory=list)
    wanted: list[Row] = field(default_factory=list)
    allowed: set[str] = field(default_factory=set)
    """Codes of findings that the client's own habits earn."""
    settle: Callable[[], None] = lambda: None
    """Waits until the listener has every frame that was sent."""

    def expect(self, direction: str, mode: str, node: int, value: bytes) -> None:
        self.wanted.append(
            {"direction": direction, "mode": mode, "node": node, "data": value.hex().upper(), "size": len(value)}
        )


class Recorder(can.Listener):
    """Keeps every frame of the virtual bus, in its order."""

    def __init__(self, frames: list[CanFrame]) -> None:
        """Keeps them in this list."""
        self.frames = frames
        self.settled = threading.Event()

    def on_message_received(self, msg: can.Message) -> None:
        """Called by the notifier."""
        if msg.arbitration_id == 0x7FF:
            self.settled.set()
        else:
            self.frames.append(CanFrame("can0", msg.arbitration_id, bytes(msg.data)))


def object_dictionary(node: int) -> canopen.ObjectDictionary:
    return canopen.import_od(str(DATA / "anything.eds"), node)


CAUSAL = ("listener", "servers", "client")
CLIENT_LATE = ("servers", "listener", "client")
"""A virtual bus hands a frame to its members in the order they joined. Where the servers come before the listener, an
answer can reach the listener before the client's request does: the same disorder as on a client's own host."""


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Iterator[Bench]:
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    channel = f"canalyze-{request.node.name}"
    servers, client = canopen.Network(), canopen.Network()
    listener_bus: can.BusABC | None = None
    for member in getattr(request, "param", CAUSAL):
        if member == "listener":
            listener_bus = can.Bus(interface="virtual", channel=channel)
        else:
            {"servers": servers, "client": client}[member].connect(interface="virtual", channel=channel)
    assert listener_bus is not None
    servers.add_node(canopen.LocalNode(NODE, object_dictionary(NODE)))
    block_server = BlockServer({(INDEX, 0): b""}, blksize=30)

    def answer(can_id: int, data: bytearray, timestamp: float) -> None:
        for payload in block_server.answer(bytes(data)):
            servers.send_message(0x580 + BLOCK_NODE, payload)

    servers.subscribe(0x600 + BLOCK_NODE, answer)
    sdo = [client.add_node(canopen.RemoteNode(node, object_dictionary(node))).sdo for node in (NODE, BLOCK_NODE)]
    for channel_client in sdo:
        channel_client.RESPONSE_TIMEOUT = 10.0
    bench = Bench(*sdo)
    recorder = Recorder(bench.frames)
    notifier = can.Notifier(listener_bus, [recorder])

    def settle() -> None:
        recorder.settled.clear()
        client.send_message(0x7FF, b"")
        assert recorder.settled.wait(10), "the listener never saw the end"

    bench.settle = settle
    try:
        yield bench
        settle()
        judge(bench)
    finally:
        notifier.stop()
        listener_bus.shutdown()
        client.disconnect()
        servers.disconnect()


def judge(bench: Bench) -> None:
    """The program must report exactly what the calls moved."""
    said = analyze(log_text(spaced(bench.frames)))
    assert len(said.frames) == len(bench.frames)
    assert len(said.transfers) == len(bench.wanted) > 0
    for node in (NODE, BLOCK_NODE):
        rows = [row for row in said.transfers if row["node"] == node]
        for row, wanted in zip(rows, (one for one in bench.wanted if one["node"] == node), strict=True):
            assert {name: row[name] for name in wanted} | {"data": row["data"].upper()} == wanted
            assert (row["status"], row["index"], row["sub"]) == ("ok", f"{INDEX:04X}", 0)
            assert set(row["findings"]) <= bench.allowed
    assert not said.above_info(), said.complaint()


def write(bench: Bench, value: bytes) -> None:
    bench.ordinary.download(INDEX, 0, value)
    bench.expect("download", "expedited" if 1 <= len(value) <= 4 else "segmented", NODE, value)


def write_in_segments(bench: Bench, value: bytes) -> None:
    bench.ordinary.download(INDEX, 0, value, force_segment=True)
    bench.expect("download", "segmented", NODE, value)


def write_and_read(bench: Bench, value: bytes) -> None:
    write(bench, value)
    assert bench.ordinary.upload(INDEX, 0) == value
    bench.expect("upload", "expedited" if len(value) <= 4 else "segmented", NODE, value)


def write_block(bench: Bench, value: bytes, *, with_crc: bool = True) -> None:
    with bench.blocks.open(
        INDEX, 0, "wb", size=len(value), block_transfer=True, request_crc_support=with_crc
    ) as stream:
        stream.write(value)
    bench.expect("download", "block", BLOCK_NODE, value)


def write_and_read_block(bench: Bench, value: bytes) -> None:
    write_block(bench, value)
    with bench.blocks.open(INDEX, 0, block_transfer=True) as stream:
        assert stream.read() == value
    bench.expect("upload", "block", BLOCK_NODE, value)


def write_and_read_block_without_checksum(bench: Bench, value: bytes) -> None:
    write_block(bench, value, with_crc=False)
    with bench.blocks.open(INDEX, 0, block_transfer=True, request_crc_support=False) as stream:
        assert stream.read() == value
    bench.expect("upload", "block", BLOCK_NODE, value)


MOVES: list[Callable[[Bench, bytes], None]] = [
    write_and_read,
    write_in_segments,
    write_and_read_block,
    write_and_read_block_without_checksum,
]


@pytest.mark.parametrize("bench", [CLIENT_LATE], indirect=True, ids=["client late"])
@pytest.mark.parametrize("move", [write_and_read, write_in_segments, write_block], ids=lambda move: move.__name__)
def test_values_of_every_size_with_late_frames(bench: Bench, move: Callable[[Bench, bytes], None]) -> None:
    """Not for reads in blocks: there a late frame may be late by a whole sub-block, which is beyond the law."""
    source = random.Random(2021)
    for size in SIZES:
        move(bench, source.randbytes(size))


@pytest.mark.parametrize("move", MOVES, ids=lambda move: move.__name__)
def test_values_of_every_size(bench: Bench, move: Callable[[Bench, bytes], None]) -> None:
    source = random.Random(1008)
    for size in SIZES:
        move(bench, source.randbytes(size))


def test_a_program_that_the_client_writes_is_recognised(bench: Bench, tmp_path: Path) -> None:
    """Byte for byte, in blocks and in segments; one of them is damaged."""
    program = s_records(bytes(range(256)), 0x1000)
    write_block(bench, program)
    write_in_segments(bench, program.replace(b"S3", b"S4", 1))
    bench.settle()
    (tmp_path / "both.log").write_bytes(log_text(spaced(bench.frames)))
    run_canalyze(["sdo", "both.log", "--extract", "out"], folder=tmp_path)
    whole, damaged = sorted((tmp_path / "out").iterdir())
    assert (whole.suffix, whole.read_bytes(), damaged.suffix) == (".s19", program, ".s19")
    found = recognised(damaged.read_bytes(), None)
    assert found and found.damage == ("lines", {"count": 1, "line": 2})


def test_nothing_at_all_in_segments(bench: Bench) -> None:
    write_in_segments(bench, b"")


def test_size_not_announced(bench: Bench) -> None:
    """The client does not know which segment is the last before it closes: it sends short ones."""
    bench.allowed.add("SDO005")
    value = bytes(range(40))
    with bench.ordinary.open(INDEX, 0, "wb", buffering=7, size=None) as stream:
        stream.write(value)
    bench.expect("download", "segmented", NODE, value)


def test_two_servers_at_the_same_time(bench: Bench) -> None:
    """Two threads of clients, so that an ordinary and a block transfer run side by side."""
    source = random.Random(1018)
    values = [source.randbytes(source.randrange(5, 400)) for _ in range(12)]
    lanes: dict[int, list[Row]] = {}

    def run(node: int, move: Callable[[Bench, bytes], None]) -> None:
        own = Bench(bench.ordinary, bench.blocks)
        for value in values:
            move(own, value)
        lanes[node] = own.wanted

    threads = [
        threading.Thread(target=run, args=(NODE, write_and_read)),
        threading.Thread(target=run, args=(BLOCK_NODE, write_and_read_block)),
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    bench.wanted += [row for lane in lanes.values() for row in lane]
