"""Headlines and statuses of small captures on which false ones have been printed, each with its other side.

What it must not do: hold what only one layout of the report has.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import pytest
from captures import session_output

Line = tuple[float, str]
Told = list[tuple[str, str, str]]

READ, GIVEN_UP, DEVICE_TYPE = "4000100000000000", "8000100000000405", "4300100092010200"


def beats(node: int, state: int, begin: float, end: float, period: float = 0.5) -> list[Line]:
    count = round((end - begin) / period)
    return [(begin + number * period, f"{0x700 + node:03X}#{state:02X}") for number in range(count)]


def log(lines: Sequence[Line], bus: str = "can0") -> bytes:
    return "".join(f"({1_700_000_000 + at:.6f}) {bus} {frame}\n" for at, frame in sorted(lines)).encode()


def told(text: bytes) -> Told:
    """Status, kind and headline of each problem."""
    output = session_output([text], name="capture.log", output_format="diagnosis", lang="en")
    rows = [json.loads(line) for line in output.splitlines()]
    return [(row["status"], row["problem"], row["message"]) for row in rows if row["kind"] == "problem"]


@pytest.mark.parametrize(
    ("answer", "status", "words"),
    [("70B#00", "harmless", "before it booted at 3 s"), ("70B#7F", "ended", "first heard at 3 s")],
)
def test_a_node_that_comes_later_was_not_lost(answer: str, status: str, words: str) -> None:
    lines = [(0.0, f"60B#{READ}"), (1.0, f"60B#{GIVEN_UP}"), (3.0, answer)]
    lines += [(4.0, f"60B#{READ}"), (4.001, f"58B#{DEVICE_TYPE}"), *beats(11, 5, 4, 8)]
    [(stands, kind, message)] = told(log(lines))
    assert (stands, kind) == (status, "node-absent")
    assert words in message


@pytest.mark.parametrize(
    ("again", "status"), [([(2.1, f"609#{READ}"), (2.101, f"589#{DEVICE_TYPE}")], "ended"), ([], "open")]
)
def test_a_request_has_its_answer_once_it_is_repeated(again: list[Line], status: str) -> None:
    lines = [(0.0, "709#00"), (0.1, f"609#{READ}"), (2.0, f"609#{GIVEN_UP}"), *again, *beats(9, 0x7F, 3, 9)]
    assert [(stands, kind) for stands, kind, _ in told(log(lines))] == [(status, "request-unanswered")]


@pytest.mark.parametrize("late", [0.02, 0.1, 0.4])
def test_a_late_answer_is_an_answer(late: float) -> None:
    lines = [(0.0, f"602#{READ}"), (0.001, f"582#{DEVICE_TYPE}"), (1.0, f"602#{READ}"), (2.0, f"602#{GIVEN_UP}")]
    lines += [(2 + late, f"582#{DEVICE_TYPE}"), (3.0, f"602#{READ}"), (3.1, f"582#{DEVICE_TYPE}")]
    [(stands, kind, message)] = told(log(lines))
    assert (stands, kind) == ("ended", "late-answer")
    assert f"answered after {1 + late:g} s" in message and "given up after 1 s" in message


@pytest.mark.parametrize(("channel", "words"), [(0x600, "aborted by the client"), (0x580, "1 write refused")])
def test_only_a_server_refuses(channel: int, words: str) -> None:
    lines = [(0.0, "611#21501F0100100000"), (0.01, "591#60501F0100000000"), (0.02, "611#0001020304050607")]
    lines += [(0.03, "591#2000000000000000"), (0.5, f"{channel + 17:03X}#80501F0100000008"), *beats(17, 0x7F, 1, 9)]
    assert [words in message for _, _, message in told(log(lines))] == [True]


@pytest.mark.parametrize(
    ("first", "asked", "answer"),
    [(1, "", ""), (1, READ, DEVICE_TYPE), (9, "2B171000F4010000", "6017100000000000")],
    ids=["not asked", "read", "written"],
)
def test_who_resets_the_others_goes_on(first: int, asked: str, answer: str) -> None:
    """The controller boots and resets all, and a tool may read from it; or it is a device, since it is configured."""
    lines = [(0.0, f"{0x700 + first:03X}#00"), *beats(first, 5, 0.2, 2), (2.0, "000#8200"), *beats(first, 5, 2.2, 9)]
    lines += [
        (2.4, "703#00"),
        (2.5, f"603#{READ}"),
        (2.501, f"583#{DEVICE_TYPE}"),
        (2.6, "000#0103"),
        *beats(3, 5, 2.7, 9),
    ]
    if asked:
        lines += [(1.6, f"{0x600 + first:03X}#{asked}"), (1.601, f"{0x580 + first:03X}#{answer}")]
    assert any(status == "open" for status, _, _ in told(log(lines))) == (first == 9)


@pytest.mark.parametrize("started", [False, True])
def test_a_cause_is_open_as_long_as_what_follows_from_it(started: bool) -> None:
    lines = [(0.0, "605#2316100188130700"), (0.001, "585#6016100100000000")]
    lines += [
        *beats(7, 5, 0.1, 5, 1),
        *beats(5, 5, 0.2, 5, 1),
        (5.0, "000#8107"),
        (5.3, "707#00"),
        *beats(7, 5, 6, 16, 1),
    ]
    lines += [(5.301, "085#3081110000000000"), *beats(5, 0x7F, 5.6, 8 if started else 16, 1)]
    if started:
        lines += [(8.0, "085#0000000000000000"), (8.1, "000#0105"), *beats(5, 5, 8.6, 16, 1)]
    stands = {kind: status for status, kind, _ in told(log(lines))}
    assert ("open" in stands.values()) != started
    assert started or stands["commanded-reset"] == "open"


@pytest.mark.parametrize("started", [False, True])
def test_the_only_node_is_never_started(started: bool) -> None:
    lines = [
        (0.0, "701#00"),
        (0.001, "000#8200"),
        (0.3, "702#00"),
        (0.31, f"602#{READ}"),
        (0.311, f"582#{DEVICE_TYPE}"),
    ]
    lines += [(0.32, "602#4018100200000000"), (0.321, "582#4318100244460000"), *beats(1, 5, 1, 11)]
    lines += [(0.4 + number / 10, "080#") for number in range(105)]
    if started:
        lines += [(0.5, "000#0102")]
    lines += beats(2, 5 if started else 0x7F, 1.2, 11)
    found = told(log(lines))
    assert [kind for _, kind, _ in found] == ([] if started else ["not-started"])
    assert started or "its last step was 1018h:02" in found[0][2]


@pytest.mark.parametrize("factor", [1.0, 1.2, 1.5, 2.0, 3.0, 5.0])
@pytest.mark.parametrize("written", [False, True])
def test_a_slower_heartbeat_is_told_at_every_magnitude(factor: float, written: bool) -> None:
    """To the end it is open; of one that is as before in the end nothing is."""
    lines = [(0.0, "605#2B171000F4010000"), (0.001, "585#6017100000000000")] if written else beats(5, 5, 0.1, 10)
    begin = 0.6 if written else 10.1
    slow = beats(5, 5, begin, begin + 20, 0.5 * factor)
    others = beats(3, 5, 0, begin + 20)
    assert bool(told(log([*lines, *slow, *others]))) == (factor > 1)
    if factor in (1.2, 1.5) and not written:  # twice as slow, and back, looks like two nodes
        back = beats(5, 5, begin + 20, begin + 40)
        found = told(log([*lines, *slow, *back, *beats(3, 5, 0, begin + 40)]))
        assert {status for status, _, _ in found} <= {"ended"}


@pytest.mark.parametrize("canopen", [False, True])
def test_what_is_not_judged_is_no_problem(canopen: bool) -> None:
    lines = [(0.0, "0B1#1255AAFF00140000"), (0.01, "18FEF117#0011"), (0.02, "133#E40D11FE07000028")]
    if canopen:
        lines = [(0.0, "731#00"), *beats(49, 0x7F, 0.5, 3), (1.1, "0B1#12558100000000AA"), (2.0, f"631#{READ}")]
        lines += [(2.001, f"5B1#{DEVICE_TYPE}")]
    assert bool(told(log(lines))) == canopen


@pytest.mark.parametrize("cleared", [False, True])
def test_a_fault_whose_error_is_gone(cleared: bool) -> None:
    lines = [(0.0, "607#4041600000000000"), (0.001, "587#4B41600008020000"), (1.0, "087#10838100AA000000")]
    if cleared:
        lines += [(1.1, "607#2B40600080000000"), (1.101, "587#6040600000000000"), (1.2, "087#0000000000000000")]
    found = told(log([*lines, *beats(7, 5, 2, 9)]))
    assert {status == "open" for status, _, _ in found} == {not cleared}


def test_a_span_is_never_negative() -> None:
    output = session_output(
        [log([(4.0, "701#00")]) + log([(2.0, "702#00")], "can1")], output_format="diagnosis", lang="en"
    )
    whole = json.loads(output.splitlines()[-1])
    assert float(whole["end"]) - float(whole["begin"]) == 2
