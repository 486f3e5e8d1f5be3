"""Records one session of python-canopen with candump, in many of its option combinations at once.

    python tests/record/record_session.py [DIRECTORY]

Needs Linux with an interface vcan0 that is up (`ip link add dev vcan0 type vcan && ip link set vcan0 up`), candump
of can-utils, and the packages canopen and python-can. Everything runs in one process: a python-canopen LocalNode
(node 5), a server of block transfers (node 6) and a python-canopen client and master. DIRECTORY (default:
samples/recorded) gets one file for each combination of options, `session.log` for `-l`, and `session.json`: what
the client asked for and what it got.

What it must not do: decode anything; the values in session.json are those the client's calls took and returned.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import can
import canopen
from block_server import BlockServer

INTERFACE = "vcan0"

RECORDINGS: dict[str, list[str]] = {
    "session.log": ["-l"],
    "session.L-tz.log": ["-L", "-t", "z"],
    "session.L-x.log": ["-L", "-x"],
    "session.plain.candump": [],
    "session.ta.candump": ["-t", "a"],
    "session.td.candump": ["-t", "d"],
    "session.tz.candump": ["-t", "z"],
    "session.tA.candump": ["-t", "A"],
    "session.x.candump": ["-x"],
    "session.a.candump": ["-a"],
    "session.c.candump": ["-c"],
    "session.cc.candump": ["-c", "-c"],
    "session.S.candump": ["-S"],
    "session.i.candump": ["-i"],
    "session.e.candump": ["-e"],
    "session.d.candump": ["-d"],
    "session.ta-x-a.candump": ["-t", "a", "-x", "-a"],
    "session.tz-S-a.candump": ["-t", "z", "-S", "-a"],
    "session.td-i-a.candump": ["-t", "d", "-i", "-a"],
    "session.tA-c-e-x.candump": ["-t", "A", "-c", "-e", "-x"],
}

NODE, BLOCK_NODE = 5, 6
PATIENCE_S = 10.0
"""For an answer; python-canopen's 0.3 s are over where a machine stalls."""


def description() -> canopen.ObjectDictionary:
    """The object dictionary of the node."""
    return canopen.import_od(str(Path(__file__).with_name("recorded.eds")), NODE)


class Client:
    """The asking side; keeps what was asked and answered."""

    def __init__(self, network: canopen.Network) -> None:
        """Takes its two remote nodes from the network."""
        self.asked: list[dict[str, Any]] = []
        self.sdo = {node: network.add_node(canopen.RemoteNode(node, description())).sdo for node in (NODE, BLOCK_NODE)}
        for one in self.sdo.values():
            one.RESPONSE_TIMEOUT = PATIENCE_S

    def _keep(self, node: int, direction: str, mode: str, index: int, sub: int, data: bytes, abort: int | None) -> None:
        row = {"node": node, "direction": direction, "mode": mode, "index": f"{index:04X}", "sub": sub}
        row |= {"abort": f"{abort:08X}"} if abort is not None else {"data": data.hex().upper()}
        self.asked.append(row)

    def read(self, index: int, sub: int = 0, *, mode: str = "expedited") -> None:
        """An ordinary read from node 5."""
        data, abort = b"", None
        try:
            with self.sdo[NODE].open(index, sub, buffering=0) as stream:
                data = stream.read()
        except canopen.SdoAbortedError as refusal:
            abort = refusal.code
        self._keep(NODE, "upload", mode, index, sub, data, abort)

    def write(self, index: int, sub: int, data: bytes, *, mode: str = "expedited") -> None:
        """An ordinary write to node 5."""
        abort = None
        try:
            self.sdo[NODE].download(index, sub, data, force_segment=mode == "segmented")
        except canopen.SdoAbortedError as refusal:
            abort = refusal.code
        self._keep(NODE, "download", mode, index, sub, data, abort)

    def read_block(self, index: int, *, with_crc: bool = True) -> None:
        """A read in blocks from node 6."""
        data, abort = b"", None
        try:
            with self.sdo[BLOCK_NODE].open(index, 0, block_transfer=True, request_crc_support=with_crc) as stream:
                data = stream.read()
        except canopen.SdoAbortedError as refusal:
            abort = refusal.code
        self._keep(BLOCK_NODE, "upload", "block", index, 0, data, abort)

    def write_block(self, index: int, data: bytes) -> None:
        """A write in blocks to node 6."""
        abort = None
        try:
            with self.sdo[BLOCK_NODE].open(index, 0, "wb", size=len(data), block_transfer=True) as stream:
                stream.write(data)
        except canopen.SdoAbortedError as refusal:
            abort = refusal.code
        self._keep(BLOCK_NODE, "download", "block", index, 0, data, abort)


def start_block_node(network: canopen.Network) -> None:
    """Node 6: block transfers only."""
    server = BlockServer({(0x2010, 0): bytes(range(200)), (0x2011, 0): b"blocks of text"}, blksize=9)

    def on_request(can_id: int, data: bytearray, timestamp: float) -> None:
        for payload in server.answer(bytes(data)):
            network.send_message(0x580 + BLOCK_NODE, payload)

    network.subscribe(0x600 + BLOCK_NODE, on_request)


def run_session(nodes: canopen.Network, master: Any) -> list[dict[str, Any]]:
    """Everything that goes over the bus; the return value is what the client asked."""
    local: Any = nodes.add_node(canopen.LocalNode(NODE, description()))
    start_block_node(nodes)
    client = Client(master)

    local.nmt.send_command(0x81)  # sends the boot-up; the local state is then that of the pre-operational node
    local.nmt.send_command(0x80)
    nodes.send_message(0x700 + BLOCK_NODE, b"\0")
    time.sleep(0.05)

    client.read(0x1000)
    client.read(0x1001)
    client.read(0x1018, 1)
    client.read(0x1008, mode="segmented")
    client.read(0x2001)
    client.read(0x2002)
    client.read(0x2003, mode="segmented")
    client.write(0x2000, 0, (-100000).to_bytes(4, "little", signed=True))
    client.write(0x2001, 0, b"\x34\x12")
    client.write(0x2002, 0, b"\x05")
    client.write(0x2003, 0, bytes(range(8)), mode="segmented")
    client.write(0x2004, 0, b"a recipe: 2 eggs, '3' apples # and <flour>", mode="segmented")
    client.read(0x2004, mode="segmented")
    client.write(0x2001, 0, b"\x01\x00", mode="segmented")

    client.read(0x5000)
    client.read(0x1018, 9)
    client.write(0x1000, 0, b"\0\0\0\0")
    client.read(0x2005)

    client.write_block(0x2010, bytes(reversed(range(150))))
    client.read_block(0x2010)
    client.read_block(0x2011, with_crc=False)
    client.read_block(0x2012)

    # one of everything that a listing may show: 29-bit, remote, and error frames
    bus = master.bus
    assert bus is not None
    bus.send(can.Message(arbitration_id=0x18FEF121, data=b"29 bits", is_extended_id=True))
    bus.send(
        can.Message(
            arbitration_id=0x4, data=bytes.fromhex("0008000000006000"), is_error_frame=True, is_extended_id=False
        )
    )

    client.write(0x1017, 0, (40).to_bytes(2, "little"))
    master.nmt.send_command(0x01)
    time.sleep(0.1)
    master.sync.start(0.02)
    for value in range(6):
        time.sleep(0.02)
        nodes.send_message(0x180 + NODE, (1000 + value).to_bytes(8, "little"))
    master.sync.stop()
    bus.send(can.Message(arbitration_id=0x280 + NODE, is_remote_frame=True, dlc=4, is_extended_id=False))
    nodes.send_message(0x280 + NODE, b"\x01\x02\x03\x04")
    master.time.transmit(1_700_000_000.125)
    local.emcy.send(0x8110, 0x11, b"lost")
    local.emcy.reset()
    master.send_message(0x200 + NODE, b"\xff\x00")
    master.nmt.send_command(0x80)
    time.sleep(0.1)
    client.write(0x1017, 0, b"\0\0")
    time.sleep(0.05)
    return client.asked


def start_candumps(directory: Path) -> dict[str, subprocess.Popen[bytes]]:
    """One candump for each recording, all of them with error frames so that they see the same."""
    running = {}
    for name, options in RECORDINGS.items():
        scratch = directory / name.replace(".", "-")
        scratch.mkdir()
        with (scratch / "stdout").open("wb") as stdout:
            command = ["candump", *options, f"{INTERFACE},0:0,#FFFFFFFF"]
            running[name] = subprocess.Popen(command, stdout=stdout, stderr=subprocess.DEVNULL, cwd=scratch)
    time.sleep(1.5)
    return running


def main() -> None:
    """Records into the directory of the command line."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2] / "samples" / "recorded"
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        running = start_candumps(Path(scratch))
        nodes, master = canopen.Network(), canopen.Network()
        nodes.connect(interface="socketcan", channel=INTERFACE)
        master.connect(interface="socketcan", channel=INTERFACE)
        asked = run_session(nodes, master)
        time.sleep(0.5)
        nodes.disconnect()
        master.disconnect()
        for name, process in running.items():
            process.terminate()
            process.wait()
            made = [path for path in (Path(scratch) / name.replace(".", "-")).iterdir() if path.stat().st_size]
            if len(made) != 1:
                raise SystemExit(f"{name}: candump wrote {len(made)} files")
            (target / name).write_bytes(made[0].read_bytes())
    truth = {"bus": INTERFACE, "sdo": asked}
    (target / "session.json").write_text(json.dumps(truth, indent=1) + "\n")


if __name__ == "__main__":
    main()
