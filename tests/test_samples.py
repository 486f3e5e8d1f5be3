"""What the hand-made samples hold, against a table written from the worked examples, and the listing of the notes.

The table is the truth of the SDO samples; the goldens beside the samples only freeze the wording.
"""

from __future__ import annotations

import pytest
from captures import DATA, SAMPLES, Row, decoded, run_canalyze

Wanted = tuple[str, int, str, str, str, int, str]
"""Bus, node, direction, mode, index, sub, data."""


def wanted() -> dict[str, list[Wanted]]:
    """Returns the transfers by the sample."""
    found: dict[str, list[Wanted]] = {}
    for line in (DATA / "sample_transfers.txt").read_text().splitlines()[1:]:
        if line.startswith("  "):
            bus, node, way, mode, address, data = line.split()
            index, _, sub = address.partition(":")
            found[[*found][-1]].append((bus, int(node), way, mode, index, int(sub, 16), data))
        else:
            found[line.removesuffix(":")] = []
    return found


TRANSFERS = wanted()
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
