"""What lies in a PDO, beside two other opinions: one line of arithmetic, and python-canopen where it is right.

Mappings are random; the program learns each from the SDO writes before the frame. python-canopen reads an entry
mapped shorter than its type, a signed bit field at its most negative value and a field across its type's size wrongly,
so it is asked only about entries of whole types at byte boundaries.
"""

from __future__ import annotations

import json
import random
import struct
from dataclasses import dataclass

import canopen
import pytest
from captures import CanFrame, Row, analyze, log_text, spaced

from canalyze import _core
from canalyze.running.reading import SessionOptions

NODE = 5
TYPES = {
    # code: (bits, signed)
    0x01: (1, False),
    0x02: (8, True),
    0x03: (16, True),
    0x04: (32, True),
    0x05: (8, False),
    0x06: (16, False),
    0x07: (32, False),
    0x10: (24, True),
    0x15: (64, True),
    0x16: (24, False),
    0x1B: (64, False),
}
REALS = {0x08: (32, "<f"), 0x11: (64, "<d")}


@dataclass(frozen=True)
class Field:
    """An entry of a mapping: object, data type code, length in bits."""

    index: int
    code: int
    bits: int


def write(index: int, sub: int, value: int, size: int) -> list[CanFrame]:
    """An acknowledged expedited download."""
    command = {1: 0x2F, 2: 0x2B, 4: 0x23}[size]
    head = struct.pack("<HB", index, sub)
    request = bytes([command]) + head + value.to_bytes(4, "little")
    return [CanFrame("can0", 0x600 + NODE, request), CanFrame("can0", 0x580 + NODE, b"\x60" + head + bytes(4))]


def session(fields: list[Field], payload: bytes) -> bytes:
    frames = write(0x1A00, 0, 0, 1)
    for sub, one in enumerate(fields, 1):
        frames += write(0x1A00, sub, one.index << 16 | one.bits, 4)
    frames += write(0x1A00, 0, len(fields), 1)
    frames.append(CanFrame("can0", 0x180 + NODE, payload))
    return log_text(spaced(frames))


def signals(fields: list[Field], payload: bytes) -> list[Row]:
    (frame,) = [frame for frame in analyze(session(fields, payload)).frames if frame["service"] == "pdo"]
    found: list[Row] = frame["pdo"]["signals"]
    return found


def number(value: int | str) -> int:
    return int(value)


@pytest.mark.parametrize("seed", range(150))
def test_raw_values_are_bits_of_one_number(seed: int) -> None:
    source = random.Random(seed)
    fields: list[Field] = []
    while (left := 64 - sum(one.bits for one in fields)) and (not fields or source.random() < 0.9):
        bits = source.randint(1, left) if source.random() < 0.6 else min(left, source.choice([1, 4, 8, 16, 32]))
        fields.append(Field(0x2000 + len(fields), 0, bits))
    length = -(-sum(one.bits for one in fields) // 8)
    payload = source.randbytes(length)
    offset = 0
    given = signals(fields, payload)
    assert len(given) == len(fields)
    for one, row in zip(fields, given, strict=True):
        assert number(row["raw"]) == int.from_bytes(payload, "little") >> offset & (1 << one.bits) - 1
        assert (row["bit"], row["bits"]) == (offset, one.bits)
        offset += one.bits


def test_python_canopen_reads_the_same() -> None:
    """Whole types at byte boundaries, described by a dictionary on both sides."""
    source = random.Random(402)
    compared = 0
    for _ in range(200):
        fields: list[Field] = []
        while len(fields) < 8:
            fitting = [
                code
                for code, bits in {
                    **{c: b for c, (b, _) in TYPES.items()},
                    **{c: b for c, (b, _) in REALS.items()},
                }.items()
                if bits % 8 == 0 and bits <= 64 - sum(one.bits for one in fields)
            ]
            if not fitting or (fields and source.random() < 0.15):
                break
            code = source.choice(fitting)
            fields.append(Field(0x2000 + len(fields), code, TYPES[code][0] if code in TYPES else REALS[code][0]))
        payload = source.randbytes(sum(one.bits for one in fields) // 8)
        dictionary = canopen.ObjectDictionary()  # type: ignore[no-untyped-call]
        for one in fields:
            variable = canopen.objectdictionary.ODVariable(f"v{one.index:X}", one.index)
            variable.data_type = one.code
            dictionary.add_object(variable)
        described = _core.Dictionary(
            file="x.eds",
            form="eds",
            device="",
            rows=[
                (one.index, 0, f"v{one.index:X}", one.code, "rw", None, False, False, True, "", 1.0) for one in fields
            ],
        )
        core = _core.Session(
            SessionOptions(lang="en", format="signals", network=_core.Network(descriptions=[(None, NODE, described)]))
        )
        core.begin("x.log", True)
        text = core.feed(session(fields, payload)) + core.finish()
        rows = [json.loads(line) for line in text.splitlines()]
        node = canopen.RemoteNode(NODE, dictionary)
        mapping = canopen.pdo.base.PdoMap(node.tpdo, None, None)  # type: ignore[no-untyped-call]
        for one in fields:
            mapping.add_variable(one.index, 0, one.bits)
        mapping.data = bytearray(payload)
        for row, mapped in zip(rows, mapping.map, strict=True):
            theirs = mapped.raw
            if isinstance(theirs, float):
                assert row["value"] is None or row["value"] == pytest.approx(theirs, rel=1e-6, nan_ok=True)
            else:
                assert number(row["value"]) == theirs
            compared += 1
    print(f"{compared} values compared")
    assert compared > 300


def test_signs_and_reals() -> None:
    cases = [
        (0x02, 4, b"\x08", -8),
        (0x02, 4, b"\x09", -7),
        (0x03, 13, b"\x02\x1f", -254),
        (0x10, 24, b"\xfe\xff\xff", -2),
        (0x08, 32, b"\x00\x00\xc0\x3f", 1.5),
        (0x11, 64, b"\x00\x00\x00\x00\x00\x00\x00\xc0", -2.0),
        (0x07, 16, b"\xaa\xbb", 0xBBAA),
        (0x05, 8, b"\xff", 255),
    ]
    for code, bits, payload, wanted in cases:
        row = (0x2000, 0, "v", code, "rw", None, False, False, True, "", 1.0)
        described = _core.Dictionary(file="x.eds", form="eds", device="", rows=[row])
        core = _core.Session(
            SessionOptions(format="signals-csv", network=_core.Network(descriptions=[(None, NODE, described)]))
        )
        core.begin("x.log", True)
        text = core.feed(session([Field(0x2000, code, bits)], payload)) + core.finish()
        assert float(text.decode().splitlines()[1].split(",")[6]) == wanted
