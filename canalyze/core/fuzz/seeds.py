"""Seeds for the fuzz targets, made of the samples: `python seeds.py` fills corpus/ beside this file.

Why it exists: fuzzing starts from real sessions instead of finding them again by chance, and nobody keeps copies of
the samples. The layout of each target's input stands in the target.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parents[2] / "samples"
LARGEST = 8192
"""A longer seed slows the fuzzer down and shows nothing new."""

_FRAME = re.compile(rb"^\((\d+\.\d+)\) (\S+) ([0-9A-F]{3})#((?:[0-9A-F]{2})*)", re.MULTILINE)
_OPTIONS = (0, 2, 9, 14)
"""Values of the byte that sets a target's options."""
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


def main(corpus: Path) -> None:
    """Writes one seed of every sample for every target that takes it."""
    for path in sorted(SAMPLES.rglob("*.asc")):
        for options in _OPTIONS:
            place = corpus / "asc"
            place.mkdir(parents=True, exist_ok=True)
            (place / f"{path.name}.{options}").write_bytes((bytes([options]) + path.read_bytes())[:LARGEST])
    _mcap(corpus / "mcap")
    for path in sorted(SAMPLES.rglob("*")):
        if path.suffix not in {".log", ".candump"}:
            continue
        text = path.read_bytes()
        for options in _OPTIONS:
            seeds = {
                "candump": bytes([options]) + text,
                "network": network(text, options),
                "sdo": sdo(text, options),
                "session": bytes([options, 1, options]) + text,
            }
            for target, seed in seeds.items():
                place = corpus / target
                place.mkdir(parents=True, exist_ok=True)
                (place / f"{path.name}.{options}").write_bytes(seed[:LARGEST])


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "corpus")
