"""SDO of nodes that report their state, so that the default CAN-IDs are SDO before any exchange has succeeded.

Servers that answer otherwise than they are asked, and requests that are too short to be answered. Beside them captures
of one direction, scans, and other protocols on these CAN-IDs.
"""

from __future__ import annotations

import pytest
from captures import analyze
from test_neighbouring_verdicts import Frames, beats, log

REQUESTS = {"upload": "4041600000000000", "download": "2B40600006000000", "block": "C6501F0114000000"}
ANSWERS = ["60", "4B", "20", "A0", "C6"]
OWN = {"upload": ("4B",), "download": ("60",), "block": ("A0", "60")}


def codes(*frames: Frames, node: int = 6) -> set[str]:
    """The codes of the findings above info about SDO of a node, beside another one whose server answers."""
    other = [(0.1, "605#4000100000000000"), (0.101, "585#4300100092010000")]
    said = analyze(log(other, beats(5, 0.5, 8.0), *frames)).findings
    return {one["code"] for one in said if one["node"] == node and one["severity"] != "info"}


def exchanges(request: str, answer: str | None, count: int) -> Frames:
    rows: Frames = []
    for place in range(count):
        rows.append((2.0 + place * 0.2, f"606#{request}"))
        if answer:
            rows.append((2.001 + place * 0.2, f"586#{answer}"))
    return rows


@pytest.mark.parametrize("count", [1, 3, 10, 20])
@pytest.mark.parametrize("request_", REQUESTS)
@pytest.mark.parametrize("answer", ANSWERS)
def test_an_answer_of_another_kind(request_: str, answer: str, count: int) -> None:
    sent = REQUESTS[request_]
    rows = exchanges(sent, answer + sent[2:8] + "37060000", count)
    if answer not in OWN[request_]:
        assert codes(rows, beats(6, 0.5, 8.0))


@pytest.mark.parametrize("length", [2, 4, 5, 7])
@pytest.mark.parametrize("count", [2, 5, 12])
def test_requests_that_are_too_short(length: int, count: int) -> None:
    rows = exchanges(REQUESTS["upload"][: 2 * length], None, count)
    told = codes(rows, beats(6, 0.5, 8.0))
    assert "SDO031" in told if length >= 4 else not told - {"SDO023"}


def test_one_direction_alone() -> None:
    """The other direction may have been left out by a filter."""
    objects = [(2.0 + place / 100, f"606#40{place:02X}200000000000") for place in range(30)]
    assert not codes(objects, beats(6, 0.5, 8.0))
    answers = [(2.0 + place / 100, f"586#4B{place:02X}200037060000") for place in range(30)]
    assert not codes(answers, beats(6, 0.5, 8.0))


@pytest.mark.parametrize("count", [3, 30])
def test_another_protocol_of_a_node_that_reports_nothing(count: int) -> None:
    rows: Frames = []
    for place in range(count):
        rows.append((2.0 + place * 0.2, f"606#{place:02X}41600012345678"))
        rows.append((2.001 + place * 0.2, f"586#{place * 7 % 256:02X}11223344556677"))
    assert not codes(rows) - {"SDO030"}
