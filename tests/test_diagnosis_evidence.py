"""What an incident may say of nodes and of values: each by the capture that shows it, and by the one that does not.

Two people who tried the program found these said falsely. What it must not do: test which rule is raised.
"""

from __future__ import annotations

import json

import pytest
from captures import session_output
from diagnoses import diagnosed

from canalyze import _core

BEGIN = 1_700_000_000
Line = tuple[float, str]


def log(lines: list[Line]) -> bytes:
    """A capture of frames with their times in s since its begin."""
    return "".join(f"({BEGIN + at:.6f}) can0 {frame}\n" for at, frame in sorted(lines)).encode()


def beats(node: int, begin: float, end: float, period: float = 0.1) -> list[Line]:
    """Heartbeats of a node that is Operational."""
    count = round((end - begin) / period)
    return [(begin + number * period, f"{0x700 + node:03X}#05") for number in range(count)]


def reset(controller: bool, under_way_ms: float | None) -> list[Line]:
    """All nodes are reset at 2 s: 5 and 6 boot again. A controller, node 127, goes on; a heartbeat may be under way."""
    lines = [*beats(5, 0, 2), *beats(6, 0.01, 2), (2.0, "000#8100")]
    for node in (5, 6):
        lines += [(2.4 + node / 100, f"{0x700 + node:03X}#00"), (2.6, "000#0100"), *beats(node, 2.7, 5)]
    if controller:
        lines += beats(127, 0.02, 5)
    if under_way_ms is not None:
        lines.append((2 + under_way_ms / 1000, "705#05"))
    return lines


@pytest.mark.parametrize("under_way_ms", [None, 0.2, 5, 90])
@pytest.mark.parametrize("controller", [True, False])
def test_the_controller_is_not_among_the_nodes_that_were_reset(controller: bool, under_way_ms: float | None) -> None:
    found = diagnosed(log(reset(controller, under_way_ms)))
    (one,) = [one for one in found.incidents if one["problem"] == "commanded-reset"]
    assert one["subject"]["nodes"] == [5, 6] and one["status"] == "harmless", one["message"]


ABORT = "585#8000620030000906"


def writes(*values: int, refused: int = 1) -> list[Line]:
    """Writes of one byte to 6200h:00 of node 5, of which the first are refused."""
    lines = beats(5, 0, 4)
    for number, value in enumerate(values):
        at = 1.005 + number * 0.2
        answer = ABORT if number < refused else "585#6000620000000000"
        lines += [(at, f"605#2F006200{value:02X}000000"), (at + 0.001, answer)]
    return lines


@pytest.mark.parametrize(
    ("values", "refused", "said"),
    [
        ((7, 7), 1, "all repeated successfully"),
        ((7, 8), 1, "other values accepted later"),
        ((7, 9, 9), 2, "all repeated successfully"),
        ((7, 9, 7), 2, "other values accepted later"),
        ((7,), 1, "1 write refused, the first to"),
    ],
)
def test_a_refused_write_is_repeated_only_by_its_value(values: tuple[int, ...], refused: int, said: str) -> None:
    found = diagnosed(log(writes(*values, refused=refused)))
    (one,) = [one for one in found.incidents if one["subject"].get("node") == 5]
    assert said in one["message"]


def mapping(count: int) -> list[Line]:
    """The number of mapped objects, 4, is refused; then the mapping is cleared, and has so many entries."""
    written = [4, 0, count]
    lines = beats(5, 0, 4)
    for number, value in enumerate(written):
        at = 1.005 + number * 0.2
        answer = "585#80001A0041000406" if number == 0 else "585#60001A0000000000"
        lines += [(at, f"605#2F001A00{value:02X}000000"), (at + 0.001, answer)]
    return lines


@pytest.mark.parametrize(("count", "said"), [(4, "all repeated successfully"), (2, "other values accepted later")])
def test_clearing_a_mapping_makes_nothing_good(count: int, said: str) -> None:
    text = log(mapping(count))
    (one,) = [one for one in diagnosed(text).incidents if one["subject"].get("node") == 5]
    frames = text.decode().splitlines()
    (taken,) = [step["frame"] for step in one["steps"] if step["role"] == "recovery"]
    assert said in one["message"]
    assert frames[taken - 2].endswith(f"605#2F001A00{count:02X}000000"), "the write that it was, not the clearing"


@pytest.mark.parametrize(("before", "kind"), [(True, "request-unanswered"), (False, "node-absent")])
def test_only_who_was_never_heard_is_absent(before: bool, kind: str) -> None:
    asked: list[Line] = [(3.0 + number, "605#4000100000000000") for number in range(3)]
    lines = [*beats(6, 0, 8), *(beats(5, 0, 2) if before else []), *asked]
    kinds = {one["problem"] for one in diagnosed(log(lines)).incidents if one["subject"].get("node") == 5}
    assert kind in kinds and ("node-absent" in kinds) == (kind == "node-absent"), kinds


@pytest.mark.parametrize(("end", "lost"), [(2.0, True), (5.9, False)])
@pytest.mark.parametrize("back", [True, False])
def test_a_node_that_stopped_is_lost_until_it_is_back(end: float, lost: bool, back: bool) -> None:
    configured: list[Line] = [(0.001, "605#2B17100064000000"), (0.002, "585#6017100000000000")]
    lines = [*configured, *beats(5, 0.1, end), *beats(6, 0.05, 6), *(beats(5, 5, 6) if back and lost else [])]
    output = session_output([log(lines)], output_format="summary", lang="en").decode().splitlines()
    nodes = {row["node"]: row for row in map(json.loads, output) if row["kind"] == "summary_node"}
    assert nodes[5]["lost"] == (lost and not back) and not nodes[6]["lost"]
    assert nodes[5]["state_name"] == "operational", "the state is that before"


def loss(delay: float, stamps: bool = True) -> bytes:
    """Node 3 watches node 5 with 700 ms and reports its loss so long after its last frame; node 5 boots later."""
    lines: list[Line] = [
        (0.001, "603#23161001BC020500"),
        (0.002, "583#6016100100000000"),
        *beats(3, 0.01, 9, 0.3),
        *beats(5, 0.02, 4, 0.3),
    ]
    last = max(at for at, frame in lines if frame.startswith("705"))
    lines += [(last + delay, "083#3081100000000000"), (8.0, "705#00"), *beats(5, 8.1, 9, 0.3)]
    text = log(lines)
    return text if stamps else b"".join(b"(0.000000)" + line[line.index(b")") + 1 :] for line in text.splitlines(True))


FITS, DIFFERS = "in the capture and fits the delay", "in the capture but does not fit the delay"


@pytest.mark.parametrize(("delay", "said"), [(0.45, FITS), (0.71, FITS), (0.15, DIFFERS), (2.5, DIFFERS)])
def test_a_known_limit_is_compared_with_the_delay(delay: float, said: str) -> None:
    (one,) = [one for one in diagnosed(loss(delay)).incidents if one["problem"] == "heartbeat-consumer-error"]
    told = " ".join(tell["text"] for tell in one["apart"])
    assert said in told and {FITS: DIFFERS, DIFFERS: FITS}[said] not in told, one


def test_without_stamps_no_cause_stands_after_its_effect() -> None:
    found = diagnosed(loss(0.71, stamps=False)).incidents
    (one,) = [one for one in found if one["problem"] == "heartbeat-consumer-error"]
    by_id = {other["id"]: other for other in found}
    cause = one["cause"] and by_id[one["cause"]["problem"]]
    assert cause is None or cause["frame"] <= one["frame"], cause


@pytest.mark.parametrize("stops", [True, False])
def test_a_pdo_has_a_delay_only_while_sync_runs(stops: bool) -> None:
    lines: list[Line] = [(0.001, "605#2F00140201000000"), (0.002, "585#6000140200000000")]
    for number in range(100):
        at = 0.1 + number * 0.01
        lines.append((at + 0.002, "205#0102"))
        if not stops or number < 50:
            lines.append((at, "080#"))
    rows = [json.loads(row) for row in session_output([log(lines)], output_format="summary", lang="en").splitlines()]
    (pdo,) = [row for row in rows if row["kind"] == "summary_pdo"]
    assert pdo["frames"] == 100 and pdo["synchronous"] == pdo["delay"]["count"]
    assert pdo["delay"]["count"] in (range(50, 52) if stops else range(100, 101))
    assert float(pdo["delay"]["max_us"]) < 15_000, pdo


def spread(bursts: int) -> bytes:
    """Ten PDOs every 10 ms: `bursts` cycles at 500 kbit/s without a gap, then evenly, as if 125 kbit/s were full."""
    lines: list[Line] = [line for node in range(1, 9) for line in beats(node, 0.0051 * node, 5, period=0.8)]
    bits = [55 + 8 * (7 + number % 2) for number in range(10)]
    for cycle in range(490):
        at = cycle * 0.01
        for number, size in enumerate(bits):
            lines.append((at, f"{0x181 + number % 8 + 0x100 * (number // 8):03X}#{'5A' * (7 + number % 2)}"))
            at += size * 2e-6 if cycle < bursts else 0.01 * size / sum(bits)
    return log(lines)


@pytest.mark.parametrize(("bursts", "given", "loaded"), [(0, None, True), (200, None, False), (200, 125_000, True)])
def test_the_bit_rate_is_bounded_by_the_shortest_gaps(bursts: int, given: int | None, loaded: bool) -> None:
    network = _core.Network(bitrate=given) if given else None
    output = session_output([spread(bursts)], output_format="diagnosis", lang="en", network=network)
    kinds = [json.loads(line).get("problem") for line in output.splitlines()]
    assert ("overload" in kinds) == loaded
