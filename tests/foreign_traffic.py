"""Traffic that is not CANopen, on identifiers that CANopen assigns too: generators, each by a seed.

Why it exists: nothing of CANopen may be said of it. What it must not do: use the program under test, or write a frame
that only a CANopen device would send in answer to another.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from captures import CanFrame

START_US = 1_700_000_000_000_000
BUS = "can0"
Generator = Callable[[random.Random], list[CanFrame]]


def in_order(*streams: Iterator[CanFrame] | Sequence[CanFrame]) -> list[CanFrame]:
    """Streams of frames on one bus, by time."""
    return sorted((frame for stream in streams for frame in stream), key=lambda frame: frame.t_us)


def checksum(body: bytes) -> int:
    """An 8-bit sum, as sensors append it."""
    return sum(body) & 0xFF


def sensor(rng: random.Random, can_id: int, period_us: int, seconds: float, length: int = 8) -> Iterator[CanFrame]:
    """A value that wanders, a counter of four bits and a sum, at a rate with jitter."""
    t_us = START_US + rng.randrange(period_us)
    value, speed, counter = rng.randrange(1 << 16), rng.randrange(-200, 200), rng.randrange(16)
    while t_us < START_US + seconds * 1_000_000:
        value = (value + speed + rng.randrange(-50, 51)) & 0xFFFF
        counter = (counter + 1) & 0x0F
        body = value.to_bytes(2, "big") + (value * 3 & 0xFFFF).to_bytes(2, "little") + rng.randbytes(2)
        body = (body + bytes([0x40 | counter]))[-max(length - 1, 0) :] if length else b""
        yield CanFrame(BUS, can_id, (body + bytes([checksum(body)]))[:length], t_us)
        t_us += period_us + rng.randrange(-period_us // 50, period_us // 50 + 1)


def extended_sensors(rng: random.Random) -> list[CanFrame]:
    """A proprietary bus with 29-bit identifiers only."""
    ids = [rng.randrange(0x800, 1 << 29) for _ in range(rng.randrange(3, 12))]
    streams = (sensor(rng, can_id, rng.choice([10_000, 20_000, 100_000]), 3) for can_id in ids)
    return [replace(frame, extended=True) for frame in in_order(*streams)]


def j1939(rng: random.Random) -> list[CanFrame]:
    """Engine, transmission and body controllers, an address claim, requests, and a broadcast (SAE J1939)."""
    frames: list[CanFrame] = []
    t_us = START_US

    def add(priority: int, pgn: int, source: int, data: bytes, at: int) -> None:
        can_id = priority << 26 | pgn << 8 | source
        frames.append(CanFrame(BUS, can_id, data, at, extended=True))

    for source in (0x00, 0x03, 0x21):
        add(6, 0xEEFF, source, rng.randbytes(8), t_us + source * 700)
    for pgn, source, period_us in (
        *((0xF004, 0x00, 10_000), (0xF003, 0x00, 50_000), (0xFEEE, 0x00, 1_000_000)),
        *((0xF002, 0x03, 10_000), (0xFEF1, 0x21, 100_000), (0xFECA, 0x00, 1_000_000)),
    ):
        at = t_us + 5_000 + rng.randrange(period_us)
        while at < START_US + 3_000_000:
            add(3 if period_us < 50_000 else 6, pgn, source, rng.randbytes(6) + b"\xff\xff", at)
            at += period_us
    message = rng.randbytes(40)
    add(7, 0xECFF, 0x00, bytes([32, 40, 0, 6, 255, 0xEB, 0xFE, 0]), t_us + 1_000_000)
    for number in range(6):
        part = message[number * 7 : number * 7 + 7].ljust(7, b"\xff")
        add(7, 0xEBFF, 0x00, bytes([number + 1]) + part, t_us + 1_050_000 + number * 50_000)
    return sorted(frames, key=lambda frame: frame.t_us)


def iso_tp(rng: random.Random, at: int, request: int, response: int, payload: bytes, *, padding: int) -> list[CanFrame]:
    """One message in the frames of ISO 15765-2, with the receiver's flow control."""

    def padded(data: bytes) -> bytes:
        return data.ljust(8, bytes([padding]))

    if len(payload) <= 7:
        return [CanFrame(BUS, request, padded(bytes([len(payload)]) + payload), at)]
    size = len(payload)
    frames = [CanFrame(BUS, request, bytes([0x10 | size >> 8, size & 0xFF]) + payload[:6], at)]
    at += rng.randrange(500, 5_000)
    frames.append(CanFrame(BUS, response, padded(bytes([0x30, rng.choice([0, 8]), rng.choice([0, 1, 10])])), at))
    for number, start in enumerate(range(6, size, 7), start=1):
        at += rng.randrange(300, 2_000)
        frames.append(CanFrame(BUS, request, padded(bytes([0x20 | number & 0x0F]) + payload[start : start + 7]), at))
    return frames


def diagnostics(rng: random.Random, request: int, response: int, rounds: int, *, padding: int) -> list[CanFrame]:
    """A tester and an ECU: sessions, identifiers read and written, memory flashed, tester present (ISO 14229)."""
    frames: list[CanFrame] = []
    at = START_US + rng.randrange(50_000)
    for _ in range(rounds):
        service = rng.choice([0x10, 0x22, 0x22, 0x2E, 0x31, 0x36, 0x3E, 0x27, 0x19])
        body = {0x10: b"\x03", 0x3E: b"\x00", 0x27: b"\x01", 0x19: b"\x02\xff"}.get(service, rng.randbytes(2))
        if service in {0x2E, 0x36}:
            body += rng.randbytes(rng.randrange(4, 130))
        frames += iso_tp(rng, at, request, response, bytes([service]) + body, padding=padding)
        at = frames[-1].t_us + rng.randrange(1_000, 25_000)
        if rng.random() < 0.15:
            answer = bytes([0x7F, service, rng.choice([0x11, 0x31, 0x33, 0x78])])
        else:
            answer = bytes([service | 0x40]) + body[:2] + rng.randbytes(rng.choice([0, 1, 4, 20, 60]))
        frames += iso_tp(rng, at, response, request, answer, padding=padding)
        at = frames[-1].t_us + rng.randrange(5_000, 200_000)
    return frames


def uds(rng: random.Random) -> list[CanFrame]:
    """UDS on its usual identifiers."""
    return diagnostics(rng, 0x7E0, 0x7E8, rng.randrange(20, 60), padding=rng.choice([0x00, 0x55, 0xAA, 0xCC]))


def uds_on_lss(rng: random.Random) -> list[CanFrame]:
    """UDS of the fifth and sixth ECU, on the identifiers of LSS."""
    return in_order(
        diagnostics(rng, 0x7E4, 0x7EC, 30, padding=0xAA),
        diagnostics(rng, 0x7E5, 0x7ED, 30, padding=rng.choice([0x00, 0x55])),
    )


def uds_on_sdo(rng: random.Random) -> list[CanFrame]:
    """UDS on physical identifiers of a maker's own choice, in the ranges of SDO and error control."""
    node = rng.randrange(1, 0x70)
    return in_order(
        diagnostics(rng, 0x600 + node, 0x580 + node, 40, padding=rng.choice([0x00, 0x55, 0xFF])),
        diagnostics(rng, 0x700 + node, 0x708 + node, 40, padding=rng.choice([0x00, 0xAA])),
    )


def obd(rng: random.Random) -> list[CanFrame]:
    """A reader that polls live data of two ECUs by functional addressing, beside the car's own traffic."""
    frames: list[CanFrame] = []
    at = START_US
    while at < START_US + 4_000_000:
        pid = rng.choice([0x0C, 0x0D, 0x05, 0x11, 0x2F, 0x00])
        frames.append(CanFrame(BUS, 0x7DF, bytes([2, 1, pid, 0, 0, 0, 0, 0]), at))
        for ecu in range(rng.randrange(1, 3)):
            value = rng.randbytes(2)
            frames.append(CanFrame(BUS, 0x7E8 + ecu, bytes([4, 0x41, pid]) + value + bytes(3), at + 3_000 + ecu * 900))
        at += rng.randrange(40_000, 110_000)
    own = [rng.randrange(0x080, 0x700) for _ in range(rng.randrange(8, 25))]
    streams = (sensor(rng, can_id, rng.choice([10_000, 20_000, 100_000, 1_000_000]), 4) for can_id in own)
    return in_order(frames, *streams)


def raw_sensors(rng: random.Random) -> list[CanFrame]:
    """Sensors at 1 to 1000 Hz on whatever identifiers."""
    ids = rng.sample(range(0x001, 0x800), rng.randrange(2, 12))
    return in_order(
        *(
            sensor(rng, one, 1_000_000 // rng.choice([1, 5, 50, 100, 1000]), 2, rng.choice([8, 8, 8, 4, 6]))
            for one in ids
        )
    )


def colliding_sensors(rng: random.Random) -> list[CanFrame]:
    """The same on identifiers of each service of CANopen."""
    node = rng.randrange(1, 0x78)
    services = [0x000, 0x080, 0x080 + node, 0x100, 0x180 + node, 0x200 + node, 0x580 + node, 0x600 + node]
    services += [0x700 + node, 0x701 + node, 0x7E4, 0x7E5, 0x071, 0x001, 0x101 + node % 0x7E]
    ids = sorted(set(rng.sample(services, rng.randrange(1, len(services)))))
    return in_order(
        *(sensor(rng, one, 1_000_000 // rng.choice([1, 10, 50, 100]), 4, rng.choice([8, 8, 8, 5, 3])) for one in ids)
    )


def body_bus(rng: random.Random) -> list[CanFrame]:
    """A car's bus: ids all over, frames of many lengths, most bytes constant, network management on 400h to 43Fh."""
    frames: list[Iterator[CanFrame] | list[CanFrame]] = []
    for can_id in rng.sample(range(0x010, 0x7DF), 30):
        length = rng.choice([1, 2, 3, 4, 5, 6, 7, 8, 8, 8, 8])
        still = rng.random() < 0.4
        stream = list(sensor(rng, can_id, rng.choice([10, 20, 50, 100, 200, 1000]) * 1000, 3, length))
        frames.append([replace(one, data=stream[0].data) for one in stream] if still else stream)
    ring = [0x400 + rng.randrange(0x40) for _ in range(4)]
    at = START_US
    alive = []
    while at < START_US + 3_000_000:
        for place, can_id in enumerate(ring):
            body = bytes([ring[(place + 1) % 4] & 0xFF, 0x02, 0, 0, 0, 0, 0, 0])
            alive.append(CanFrame(BUS, can_id, body, at + place * 100_000))
        at += 400_000
    return in_order(*frames, alive)


def battery(rng: random.Random) -> list[CanFrame]:
    """A battery and its inverter: 351h, 355h, 356h, 35Ah, 305h, and cell voltages on 181h and 601h up."""
    ids = [0x351, 0x355, 0x356, 0x35A, 0x35E, 0x305, *range(0x181, 0x18A), *range(0x601, 0x606)]
    return in_order(*(sensor(rng, one, rng.choice([100_000, 1_000_000]), 6) for one in ids))


def server_flood(rng: random.Random) -> list[CanFrame]:
    """Frames on the identifier of a node's SDO answers that nobody has asked for, many in a second."""
    node = rng.randrange(1, 0x78)
    return list(sensor(rng, 0x580 + node, rng.choice([1_000, 2_000, 5_000]), 3))


GENERATORS: dict[str, Generator] = {
    one.__name__: one
    for one in (
        *(extended_sensors, j1939, uds, uds_on_lss, uds_on_sdo, obd, raw_sensors, colliding_sensors, body_bus, battery),
        server_flood,
    )
}
