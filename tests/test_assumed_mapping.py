"""A PDO's mapping that only an EDS has is assumed: signals are shown by it as long as the frames bear it out.

Padded frames keep their signals. What the capture or a DCF shows needs no bearing out. What it must not do: test how
an EDS is read.
"""

from __future__ import annotations

import pytest
from captures import SAMPLES, Analysis, CanFrame, analyze, log_text, spaced
from test_unconfirmed import NODE, request, response

from canalyze import _core
from canalyze.dictionary import load

EDS = SAMPLES / "rules" / "PDO012.eds"
"""TPDO1 of node 5: one object of two bytes."""


def read(payloads: str, *before: CanFrame) -> Analysis:
    network = _core.Network(descriptions=[(None, NODE, load(str(EDS), NODE).table)])
    frames = [CanFrame("can0", 0x185, bytes.fromhex(data)) for data in payloads.split()]
    return analyze(log_text(spaced([*before, *frames], step_us=2_000)), network=network)


def shown(found: Analysis) -> str:
    """For each PDO: `+` with its signals, `-` where frames contradict the mapping."""
    pdos = [row["pdo"] for row in found.frames if row["service"] == "pdo"]
    assert all(bool(pdo["signals"]) == (pdo["unmapped"] is None) for pdo in pdos)
    assert all(pdo["unmapped"] in (None, "contradicted") for pdo in pdos)
    return "".join("+" if pdo["signals"] else "-" for pdo in pdos)


@pytest.mark.parametrize(
    ("payloads", "expected"),
    [
        ("0102 0103", "++"),
        ("01", "-"),
        ("0102 01 0103", "+-+"),
        ("0102000000000000 0103000000000000 0104000000000000", "+++"),
        ("0102FFFF 0103FFFF", "++"),
        ("0102000000 0103000000 0103000100 0103000000", "++--"),
        ("010200 010301 010300", "+--"),
        ("01020008", "-"),
    ],
)
def test_a_default_mapping_holds_as_long_as_the_frames_fit(payloads: str, expected: str) -> None:
    assert shown(read(payloads)) == expected


def test_the_difference_is_reported_as_before() -> None:
    found = read("01020008 01030008")
    assert [row["code"] for row in found.findings if row["code"] == "EDS001"]
    assert not found.above_info()


def test_a_mapping_that_was_written_is_kept() -> None:
    writes = (request(0x1A00, 0, 0, 1), request(0x1A00, 1, 0x20000010), request(0x1A00, 0, 1, 1))
    seen = read("01020008 01030109 01040208", *(frame for one in writes for frame in (one, response(one))))
    assert shown(seen) == "+++"
    assert "PDO006" in {row["code"] for row in seen.findings}
