"""Seeds for the fuzz targets, made of the samples: `python seeds.py` fills corpus/ beside this file.

Why it exists: fuzzing starts from real sessions instead of finding them again by chance, and nobody keeps copies of
the samples. The layout of each target's input stands in the target.
"""

from __future__ import annotations

import re
import struct
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parents[2] / "samples"
LARGEST = 8192
"""A longer seed slows the fuzzer down and shows nothing new."""

_SMALLEST = 4
"""A shorter seed holds no frame."""

_FRAME = re.compile(rb"^\((\d+\.\d+)\) (\S+) ([0-9A-F]{3})#((?:[0-9A-F]{2})*)", re.MULTILINE)
_OPTIONS = (0, 2, 9, 14)
"""Values of the byte that sets a target's options."""
_WRITTEN = {0: "blf", 2: "trc"}
"""The forms in which python-can writes seeds, by the byte that sets the target's options."""
_NODES = 4
_GAPS_S = (0.0045, 0.005, 1.0)
"""Below each of them the gap of that number is taken, above all the last."""


def sdo(text: bytes, options: int) -> bytes:
    """The SDO, NMT and boot-up frames of a `candump -l` log, as the target `sdo` reads them."""
    return bytes([options]) + b"".join(_records(text))


_GAPS_NETWORK_S = (0.0001, 0.0006, 0.003, 0.007, 0.03, 0.3, 60.0)
_ANY_FRAME = re.compile(rb"^\((\d+\.\d+)\) (\S+) ([0-9A-F]{3})#(R\d?|(?:[0-9A-F]{2})*)", re.MULTILINE)


def network(text: bytes, options: int) -> bytes:
    """The frames with 11-bit identifiers of a `candump -l` log, as the target `network` reads them."""
    seed = bytearray([options])
    last = 0.0
    for seconds, _, digits, payload in _ANY_FRAME.findall(text):
        remote = payload.startswith(b"R")
        data = b"" if remote else bytes.fromhex(payload.decode())
        now = float(seconds)
        gap = sum(now - last >= limit for limit in _GAPS_NETWORK_S)
        last = now
        seed += (int(digits, 16) | (0x1000 if remote else 0)).to_bytes(2, "big")
        seed += bytes([gap, len(data)]) + data
    return bytes(seed)


def diff(text: bytes, options: int) -> bytes:
    """A capture and itself without some of its frames, as the target `diff` reads them."""
    lines = text.splitlines(keepends=True)
    one = network(b"".join(lines[:150]), 0)[1:]
    other = network(b"".join(line for place, line in enumerate(lines[:150]) if place % 7), 0)[1:]
    return bytes([options]) + len(one).to_bytes(2, "big") + one + other


_EXPECTED = """{"file":"x","sdo":[{"line":1,"node":5,"index":4119,"sub":0,"value":{"number":1000},"sequence":"a"}],
"state":[{"line":4,"node":5,"state":"operational","by_ns":5000000,"since":"boot-up","stays":true}],
"signal":[{"line":6,"select":"5.*","min":-1,"max":1.5,"period_ns":10000000,"tolerance_ns":1000000}],
"heartbeat":[{"line":7,"node":5,"period_ns":100000000,"tolerance_ns":0}],"emcy":[{"line":9,"occurs":"never"}],
"latency":[{"line":11,"of":"sdo","max_ns":0}],"load":[{"line":14,"max_percent":1,"bit_rate":125000}]}"""


def expectation(text: bytes, options: int) -> bytes:
    """Expectations, as JSON or to be drawn, and the frames of a log, as the target `expectation` reads them."""
    said = _EXPECTED.encode() if options & 4 else bytes(1 + (place * 37 + options) % 255 for place in range(120))
    return bytes([options]) + said + b"\0" + network(text, 0)[1:]


def _records(text: bytes) -> Iterator[bytes]:
    buses: list[bytes] = []
    nodes: list[int] = []
    last = 0.0
    for seconds, bus, digits, payload in _FRAME.findall(text):
        can_id, data, now = int(digits, 16), bytes.fromhex(payload.decode()), float(seconds)
        base, node = can_id & 0x780, can_id & 0x7F
        if base not in (0x000, 0x580, 0x600, 0x700) or (base == 0x700 and data != b"\0"):
            continue
        if bus not in buses:
            buses.append(bus)
        if node not in nodes:
            nodes.append(node)
        gap = sum(now - last >= limit for limit in _GAPS_S)
        last = now
        side = 0x80 if base == 0x580 else 0
        control = side | buses.index(bus) % 2 << 6 | nodes.index(node) % _NODES << 4 | gap << 2
        match base:
            case 0x000:
                yield bytes([control | 3, 0]) + data[:2]
            case 0x700:
                yield bytes([control | 3, 1]) + data[:1]
            case _ if len(data) == 8:
                yield bytes([control]) + data
            case _:
                yield bytes([control | 2, len(data)]) + data


def _mcap(place: Path) -> None:
    """Captures in MCAP form: as files, and the records of their chunks (which are not packed) alone."""
    place.mkdir(parents=True, exist_ok=True)
    for path in sorted(SAMPLES.rglob("*.mcap")):
        data = path.read_bytes()
        (place / path.name).write_bytes((b"\0\x20" + data)[:LARGEST])
        records, at = b"", data.find(b"\x06", 8)
        while data[at : at + 1] in (b"\x06", b"\x07"):
            size = int.from_bytes(data[at + 1 : at + 9], "little")
            if data[at] == 6:  # 40 bytes of head before the records
                records += data[at + 49 : at + 9 + size]
            at += 9 + size
        for options in (1, 3):
            (place / f"{path.name}.records.{options}").write_bytes((bytes([options, 0x10]) + records)[:LARGEST])


_ANY_ID = re.compile(rb"^\((\d+)\.(\d{6})\) (\S+) ([0-9A-F]{3}|[0-9A-F]{8})#((?:[0-9A-F]{2})*)\r?$", re.MULTILINE)


def pcap(text: bytes, options: int) -> bytes:
    """The data frames of a `candump -l` log as pcapng, or as cooked pcap of either version, for the target `pcap`."""
    order = "<" if options & 2 else ">"
    packets = []
    for seconds, micros, _, digits, payload in _ANY_ID.findall(text):
        data = bytes.fromhex(payload.decode())
        flag = 0x8000_0000 if len(digits) == 8 else 0
        packets.append((int(seconds), int(micros), int(digits, 16) | flag, data[:8]))

    def socketcan(can_id: int, data: bytes, id_order: str) -> bytes:
        return struct.pack(f"{id_order}IB3x8s", can_id, len(data), data)

    def block(kind: int, body: bytes) -> bytes:
        return struct.pack(f"{order}II", kind, len(body) + 12) + body + struct.pack(f"{order}I", len(body) + 12)

    if options & 8:
        out = block(0x0A0D0D0A, struct.pack(f"{order}IHHq", 0x1A2B3C4D, 1, 0, -1))
        out += block(1, struct.pack(f"{order}HHIHH4sHH4x", 227, 0, 0, 2, 4, b"can0", 9, 1))
        for seconds, micros, can_id, data in packets:
            high, low = divmod(seconds * 1_000_000 + micros, 1 << 32)
            head = struct.pack(f"{order}IIIII", 0, high, low, 16, 16)
            flags = struct.pack(f"{order}HHIHHQ", 2, 4, 1, 4, 8, 1)
            out += block(6, head + socketcan(can_id, data, ">") + flags)
        return bytes([options]) + out
    link, head = (276, b"\0\x0c" + bytes(18)) if options & 2 else (113, bytes(14) + b"\0\x0c")
    out = struct.pack(f"{order}IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, link)
    for seconds, micros, can_id, data in packets:
        body = head + socketcan(can_id, data, order)
        out += struct.pack(f"{order}IIII", seconds, micros, len(body), len(body)) + body
    return bytes([options]) + out


def live(text: bytes, options: int) -> bytes:
    """The data frames of a `candump -l` log as a 64-bit host's receivers have them, for the target `live`.

    The layout of blocks and messages stands in `readers/live/`.
    """

    def block(kind: int, bus: int, number: int, body: bytes = b"") -> bytes:
        return struct.pack("<BBBBIq", kind, bus, options & 1 if kind == 2 else 0, 0, len(body), number) + body

    out, buses = b"", []
    for place, (seconds, micros, bus, digits, payload) in enumerate(_ANY_ID.findall(text)):
        if bus not in buses:
            buses.append(bus)
            out += block(1, len(buses) - 1, 0, bus)
        index, data, flag = buses.index(bus), bytes.fromhex(payload.decode())[:8], 0x8000_0000 * (len(digits) == 8)
        control = struct.pack("=QIIqq", 32, 1, 35, int(seconds), int(micros) * 1000)
        control += struct.pack("=QIIIxxxx", 20, 1, 40, place // 20) if options & 8 else b""
        header = struct.pack("=40xQIxxxxIxxxx", len(control), 4 * (place % 2), 16)
        slot = struct.pack("=IB3x8s", int(digits, 16) | flag, len(data), data).ljust(72, b"\0")
        out += block(2, index, 1, header + slot + control.ljust(128, b"\0"))
        if place % 5 == 4:
            out += block(5, 0, int(seconds) * 10**9 + int(micros) * 1000)
        if place % 40 == 39:
            out += block(4 + options % 4, index, 0)
    return bytes([options, 5 if options & 4 else 0]) + out


def rows(text: bytes, options: int) -> bytes:
    """The data frames of a `candump -l` log as one of four programs lists them, for the target `rows`."""
    out = bytearray()
    for place, (seconds, micros, bus, digits, payload) in enumerate(_ANY_ID.findall(text)):
        data = bytes.fromhex(payload.decode())[:8]
        time, spaced = f"{int(seconds) % 1000}.{micros.decode()}", data.hex(" ").upper()
        can_id, extended = digits.decode(), len(digits) == 8
        match options:
            case 0:
                heading = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8"
                cells = [*(f"{byte:02X}" for byte in data), *[""] * (8 - len(data))]
                micro = int(seconds) % 1000 * 1_000_000 + int(micros)
                line = f"{micro},{can_id.zfill(8)},{str(extended).lower()},Rx,0,{len(data)},{','.join(cells)}"
            case 2:
                heading = ""
                kind = "X" if extended else "S"
                line = f"Timestamp: {time}    ID: {can_id:>8}    {kind} Rx                DL:  {len(data)}    {spaced}"
                line += f"     Channel: {bus.decode(errors='replace')}"
            case 9:
                heading = "| No. | Time | ID | DLC | Data |\n| --- | --- | --- | --- | --- |"
                line = f"| {place + 1} | {time} | 0x{can_id} | {len(data)} | {spaced} |"
            case _:
                heading, line = "", f"{can_id} {spaced}"
        if not place and heading:
            out += heading.encode() + b"\n"
        out += line.encode() + b"\n"
    return bytes([options]) + bytes(out)


def _written(text: bytes, suffix: str) -> bytes:
    """The data frames of a `candump -l` log as python-can writes them in a file with this suffix, not packed."""
    frames = _ANY_ID.findall(text)[:100]
    if not frames:
        return b""
    import can

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"one.{suffix}")
        packing = {"compression_level": 0} if suffix == "blf" else {}
        with can.Logger(path, **packing) as writer:
            for seconds, micros, _, digits, payload in frames:
                stamp, data = int(seconds) + int(micros) / 1e6, bytes.fromhex(payload.decode())[:8]
                writer.on_message_received(
                    can.Message(stamp, int(digits, 16), is_extended_id=len(digits) == 8, data=data, channel=1)
                )
        return path.read_bytes()


_FD_FRAME = re.compile(rb"^\((\d+\.\d+)\) \S+ ([0-9A-F]{3})##[0-9A-F]((?:[0-9A-F]{2})*)", re.MULTILINE)
_GAPS_USDO_S = (0.0045, 0.005, 1.0)


def usdo(text: bytes, options: int) -> bytes:
    """The USDO frames of a `candump -l` log, as the target `usdo` reads them: with the target's own nodes."""
    seed, nodes, last = bytearray([options]), [], 0.0
    for seconds, digits, payload in _FD_FRAME.findall(text):
        can_id, data = int(digits, 16), bytes.fromhex(payload.decode())
        if can_id & 0x780 not in (0x580, 0x600) or len(data) < 3:
            continue
        sender, receiver = can_id & 0x7F, data[0]
        nodes += [node for node in (sender, receiver) if node not in nodes]
        gap = sum(float(seconds) - last >= limit for limit in _GAPS_USDO_S)
        last = float(seconds)
        of_server = can_id & 0x780 == 0x580
        client, server = (receiver, sender) if of_server else (sender, receiver)
        body = data[1:2] + data[3:]
        seed += bytes([of_server << 7 | nodes.index(client) % 4 << 5 | gap << 3])
        seed += bytes([nodes.index(server) % 4 << 6 | data[2] & 63, len(body)]) + body
    return bytes(seed)


def _settings(place: Path) -> None:
    """Files that users write: expectations beside the samples, and the examples of the pages."""
    place.mkdir(parents=True, exist_ok=True)
    for path in sorted(SAMPLES.rglob("*.toml")):
        (place / path.name).write_bytes(path.read_bytes()[:LARGEST])
    for path in sorted((HERE.parents[1] / "pages" / "en").glob("*.md")):
        examples = re.findall(rb"^```toml[^\n]*\n(.*?)^```", path.read_bytes(), re.MULTILINE | re.DOTALL)
        for number, example in enumerate(examples):
            (place / f"{path.name}.{number}").write_bytes(example[:LARGEST])


def _descriptions(place: Path) -> None:
    """The descriptions of `eds/`, and of samples, whole."""
    place.mkdir(parents=True, exist_ok=True)
    for path in sorted((SAMPLES.parent / "eds").iterdir()):
        (place / path.name).write_bytes(path.read_bytes())
    for path in sorted(path for path in SAMPLES.rglob("*") if path.suffix in {".eds", ".dcf", ".xdd"}):
        (place / path.name).write_bytes(path.read_bytes())


def main(corpus: Path) -> None:
    """Writes one seed of every sample for every target that takes it."""
    for path in sorted(SAMPLES.rglob("*.asc")):
        for options in _OPTIONS:
            place = corpus / "asc"
            place.mkdir(parents=True, exist_ok=True)
            (place / f"{path.name}.{options}").write_bytes((bytes([options]) + path.read_bytes())[:LARGEST])
    _mcap(corpus / "mcap")
    _settings(corpus / "settings")
    _descriptions(corpus / "description")
    for path in sorted(SAMPLES.rglob("*")):
        if path.suffix not in {".log", ".candump"}:
            continue
        text = path.read_bytes()
        for options in _OPTIONS:
            seeds = {
                "candump": bytes([options]) + text,
                "diff": diff(text, options),
                "expectation": expectation(text, options),
                "live": live(text, options),
                "network": network(text, options),
                "pcap": pcap(text, options),
                "rows": rows(text, options),
                "sdo": sdo(text, options),
                "session": bytes([options, 1, options]) + text,
                "usdo": usdo(text, options),
            }
            if options in _WRITTEN:
                suffix = _WRITTEN[options]
                seeds[suffix] = bytes([options]) + _written(text, suffix)
            for target, seed in seeds.items():
                if len(seed) < _SMALLEST:
                    continue
                place = corpus / target
                place.mkdir(parents=True, exist_ok=True)
                (place / f"{path.name}.{options}").write_bytes(seed[:LARGEST])


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "corpus")
