"""What the hand-made samples hold, against a table written from the worked examples, and the listing of the notes.

The table is the truth of the SDO samples; the goldens beside the samples only freeze the wording.
"""

from __future__ import annotations

import pytest
from captures import SAMPLES, Row, decoded, run_canalyze

NAME = b"Zephyr RTOS/CANopenNode".hex().upper()
TWENTY = bytes(range(20)).hex().upper()
EIGHT = bytes(range(8)).hex().upper()
SENTENCE = b"The quick brown fox jumps over the lazy dog; pack my box with five dozen liquor jugs, then rest. END"

Wanted = tuple[str, int, str, str, str, int, str]
"""Bus, node, direction, mode, index, sub, data."""

TRANSFERS: dict[str, list[Wanted]] = {
    "zephyr-sdo": [("can1", 10, "upload", "segmented", "1008", 0, NAME)],
    "zephyr-sdo-causal": [("can1", 10, "upload", "segmented", "1008", 0, NAME)],
    "string-5-bytes": [("can0", 5, "upload", "segmented", "1009", 0, b"V1.23".hex().upper())],
    "string-100-bytes": [("can0", 33, "upload", "segmented", "2100", 1, SENTENCE.hex().upper())],
    "sdo-expedited": [
        ("can0", 10, "upload", "expedited", "2000", 0, "78563412"),
        ("can0", 10, "upload", "expedited", "2001", 0, "EFBE"),
        ("can0", 10, "upload", "expedited", "2002", 0, "5A"),
        ("can0", 10, "download", "expedited", "2000", 0, "0A000000"),
        ("can0", 10, "download", "expedited", "2001", 0, "3412"),
        ("can0", 10, "download", "expedited", "2002", 0, "01"),
    ],
    "sdo-segmented": [
        ("can0", 10, "upload", "segmented", "2003", 0, "8877665544332211"),
        ("can0", 10, "download", "segmented", "2004", 0, TWENTY),
        ("can0", 10, "download", "segmented", "2003", 0, EIGHT),
    ],
    "sdo-block": [
        ("can0", 10, "upload", "block", "2004", 0, TWENTY),
        ("can0", 10, "upload", "block", "2004", 0, TWENTY),
        ("can0", 10, "download", "block", "2004", 0, TWENTY),
        ("can0", 10, "upload", "block", "2004", 0, TWENTY),
        ("can0", 10, "upload", "block", "2004", 0, TWENTY),
        ("can0", 10, "upload", "block", "1008", 0, NAME),
        ("can0", 10, "upload", "segmented", "1008", 0, NAME),
        ("can0", 10, "upload", "block", "1008", 0, NAME),
    ],
    "roboteq": [
        ("can0", 1, "download", "expedited", "2003", 2, "0A000000"),
        ("can0", 12, "download", "expedited", "200C", 0, "01"),
        ("can0", 1, "upload", "expedited", "210D", 2, "9001"),
        ("can0", 1, "upload", "expedited", "1000", 0, "00000000"),
        ("can0", 12, "upload", "expedited", "1000", 0, "00000000"),
    ],
    "two-nodes-interleaved": [
        ("can0", 5, "download", "segmented", "2004", 0, TWENTY),
        ("can1", 10, "upload", "segmented", "100A", 0, b"2.1.0-rc3".hex().upper()),
        ("can0", 10, "upload", "segmented", "1008", 0, NAME),
    ],
    "services": [
        ("can0", 10, "download", "expedited", "1A00", 0, "FF"),
        ("can0", 10, "download", "expedited", "1A01", 0, "FE"),
        ("can1", 5, "upload", "expedited", "1018", 0, "78563412"),
    ],
}

ABORTS = ["06010002", "06010001", "06020000", "06090011", "06070012"]
"""The aborts of E8, in the order of sdo-abort.log."""
LATER_ABORTS = ["05030000", "05030000", "05030000", "06070013", "05040004", "06070012", "05040002", "05040001"]
"""The aborts of E9, E10, E16, E17 and E33 after them."""

FINDINGS: dict[str, set[str]] = {
    "sdo-segmented": {"SDO005"},
    "sdo-abort": {"SDO001", "SDO006", "SDO008", "SDO012", "SDO017", "SDO019"},
    "roboteq": {"SDO021", "SDO022"},
}
"""The codes that a sample must raise at least."""

CLEAN = sorted(set(TRANSFERS) - {"roboteq"})


def in_order(transfers: list[Row]) -> list[Row]:
    return sorted(transfers, key=lambda row: int(row["first_frame"]))


@pytest.mark.parametrize("name", TRANSFERS)
def test_the_transfers_of_a_sample(name: str) -> None:
    rows = in_order(decoded(SAMPLES / f"{name}.log").transfers)
    given = [
        (row["bus"], row["node"], row["direction"], row["mode"], row["index"], row["sub"], row["data"].upper())
        for row in rows
    ]
    if name == "roboteq":  # how these count is a matter of the quirk's name; the values are not
        given = [(bus, node, way, "expedited", index, sub, data) for bus, node, way, _, index, sub, data in given]
    assert given == TRANSFERS[name]
    assert all(row["status"] == "ok" for row in rows)


@pytest.mark.parametrize("name", CLEAN)
def test_a_clean_sample_has_nothing_above_info(name: str) -> None:
    said = decoded(SAMPLES / f"{name}.log")
    assert not said.above_info(), said.complaint()


@pytest.mark.parametrize("name", FINDINGS)
def test_a_sample_raises_its_findings(name: str) -> None:
    assert FINDINGS[name] <= {finding["code"] for finding in decoded(SAMPLES / f"{name}.log").findings}


def test_the_aborts() -> None:
    rows = [row for row in in_order(decoded(SAMPLES / "sdo-abort.log").transfers) if row["abort"] is not None]
    assert [row["abort"]["code"] for row in rows] == [*ABORTS, *LATER_ABORTS]
    assert all((row["status"], row["abort"]["by"]) == ("aborted", "server") for row in rows)


def test_the_late_requests_of_the_notes_are_seen_as_reordered() -> None:
    late, causal = (decoded(SAMPLES / f"{name}.log") for name in ("zephyr-sdo", "zephyr-sdo-causal"))
    assert late.transfers[0]["reordered"]
    assert not causal.transfers[0]["reordered"]
    assert late.transfers[0]["size"] == late.transfers[0]["size_indicated"] == 23


def test_the_listing_of_the_notes() -> None:
    output = run_canalyze(["decode", SAMPLES / "zephyr-sdo.log", "--brief", "--lang", "zh"])
    assert output == (SAMPLES / "zephyr-sdo.brief.zh.txt").read_bytes()


def test_every_frame_of_the_services_has_a_line_and_a_service() -> None:
    path = SAMPLES / "services.log"
    said = decoded(path)
    assert len(said.frames) == sum(1 for line in path.read_text().splitlines() if not line.startswith("#"))
    assert all(row["service"] and row["text"] for row in said.frames if not row["err"])
