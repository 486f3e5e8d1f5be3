"""Every kind of problem: found in its sample, not in the clean neighbour, and with words in both languages.

Those of a controller and of the nodes that answer it are found over magnitudes, and beside each is what is none. Must
not: test causes, or how problems are ranked or laid out.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from captures import SAMPLES, described_beside, log_text
from conftest import Runner
from diagnoses import ABOVE_HARMLESS, Diagnosed, diagnosed
from kind_row import Node
from kind_samples import FURTHER, TABLE, Further
from kinds_of_control import reads, resets, rpdo
from network import find
from test_first_screen import DEVICE_TYPE, READ, Line, Told, beats, log, told

from canalyze import _core

KINDS = list(_core.PROBLEMS)
CASES = [
    pytest.param(kind, marks=[pytest.mark.xfail(strict=True, reason=sample.defect)] if sample.defect else [])
    for kind, sample in TABLE.items()
]


FURTHER_CASES = [
    pytest.param(case, id=name, marks=[pytest.mark.xfail(strict=True, reason=case.defect)] if case.defect else [])
    for name, case in FURTHER.items()
]


def found(kind: str, *, faulty: bool, lang: str = "en") -> Diagnosed:
    sample = TABLE[kind]
    network = None if sample.described is None else described_beside(sample.described)
    return diagnosed(sample.text(faulty), network, lang)


def every(said: Diagnosed) -> str:
    """All incidents in one line each, for messages."""
    return "\n".join(
        f"{one['problem']} {one['status']} #{one['begin']['frame']} {one['subject']} {one['message']}"
        for one in said.incidents
    )


def concerns(subject: dict[str, object], node: Node) -> bool:
    """Whether an incident is about this node, these nodes, or none."""
    if isinstance(node, tuple):
        return "node" not in subject and subject.get("nodes") == list(node)
    return subject.get("node") == node and (node is not None or not subject.get("nodes"))


def test_there_is_a_sample_of_each_kind() -> None:
    assert sorted(TABLE) == sorted(KINDS)


@pytest.mark.parametrize("kind", CASES)
def test_a_kind_is_told_of_its_sample(kind: str) -> None:
    sample, said = TABLE[kind], found(kind, faulty=True)
    told = [one for one in said.incidents if one["problem"] == kind]
    assert [one["status"] for one in told] == [sample.status], every(said)
    (one,) = told
    assert concerns(one["subject"], sample.node), one["subject"]
    assert sample.begin is None or one["begin"]["frame"] == sample.begin_frame(), every(said)


@pytest.mark.parametrize("kind", KINDS)
def test_a_clean_neighbour_has_no_incident(kind: str) -> None:
    said = found(kind, faulty=False)
    harmless = TABLE[kind].status == "harmless"
    told = [one for one in said.incidents if harmless and one["problem"] == kind]
    wrong = [*told, *(one for one in said.incidents if one["status"] in ABOVE_HARMLESS)]
    assert not wrong, every(said)


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_has_words_in_both_languages(kind: str, lang: str) -> None:
    said = [one for one in found(kind, faulty=True, lang=lang).incidents if one["problem"] == kind]
    explained = _core.explain(kind, lang)
    assert explained is not None and kind in explained
    for text in [explained, *(one["message"] for one in said)]:
        assert text.strip() and not re.search(r"[{}]|%[sd]|None|Some\(", text), text
    chinese = re.compile(r"[\u4e00-\u9fff]")
    for one in said:
        assert bool(chinese.search(one["message"])) == (lang == "zh"), one["message"]


@pytest.mark.parametrize("path", sorted(SAMPLES.rglob("*.log")), ids=lambda path: str(path.relative_to(SAMPLES)))
def test_what_has_ended_does_not_go_on_in_its_title(path: Path) -> None:
    for one in diagnosed(path.read_bytes()).incidents:
        if one["end"] and one["status"] == "ended":
            assert not re.search(r"(^|[ ,])since \d", one["message"]), one["message"]


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_all_kinds_are_explained(canalyze: Runner, lang: str) -> None:
    explained = canalyze("explain", "--lang", lang, *KINDS)
    assert (explained.code, explained.err) == (0, "")
    for kind in KINDS:
        (first, *_) = (_core.explain(kind, lang) or "").splitlines()
        assert first in explained.out


@pytest.mark.parametrize("case", FURTHER_CASES)
def test_a_kind_is_told_as_it_stands(case: Further) -> None:
    frames = case.make()
    said = diagnosed(log_text(frames))
    told = [one for one in said.incidents if one["problem"] == case.kind]
    assert [one["status"] for one in told] == list(case.statuses), every(said)
    assert not case.unsaid or all(case.unsaid not in one["message"] for one in told), every(said)
    assert case.end is None or told[-1]["end"]["frame"] == find(frames, *case.end) + 1, told[-1]["end"]


def kinds(said: Told) -> list[tuple[str, str]]:
    return [(status, kind) for status, kind, _ in said if status != "harmless"]


def written(at: float, node: int, index: int, sub: int, value: int, size: int = 4) -> list[Line]:
    """An expedited write and its confirmation."""
    head = bytes([index & 0xFF, index >> 8, sub])
    request = bytes([{1: 0x2F, 2: 0x2B, 4: 0x23}[size]]) + head + value.to_bytes(4, "little")
    answer = b"\x60" + head + bytes(4)
    return [(at, f"{0x600 + node:03X}#{request.hex()}"), (at + 0.001, f"{0x580 + node:03X}#{answer.hex()}")]


def cyclic(frame: str, begin: float, end: float, period: float) -> list[Line]:
    return [(begin + number * period, frame) for number in range(round((end - begin) / period))]


@pytest.mark.parametrize("times", [1, 4, 5, 20])
def test_reads_that_are_always_refused(times: int) -> None:
    assert kinds(told(log_text(reads(times)))) == [("open", "read-in-vain")] * (times >= 5)
    ended = kinds(told(log_text(reads(times + 1, succeeds=True))))
    assert ended == [("ended", "read-in-vain")] * (times >= 5)


@pytest.mark.parametrize(("times", "pause"), [(1, 2), (2, 2), (3, 2), (8, 0.5), (4, 40)])
def test_resets_again_and_again(times: int, pause: float) -> None:
    """Those that are far apart have nothing to do with each other."""
    said = kinds(told(log_text(resets(times, pause))))
    assert said == [("open", "reset-again-and-again")] * (times >= 3 and pause < 30)


@pytest.mark.parametrize(("cycles", "status"), [(100, None), (85, None), (75, "open"), (30, "open"), (10, None)])
def test_an_rpdo_that_stops(cycles: int, status: str | None) -> None:
    """A pause of some cycles is none; nor does one stop that has not come in each cycle for long enough."""
    assert kinds(told(log_text(rpdo(cycles)))) == ([(status, "rpdo-stopped")] if status else [])


@pytest.mark.parametrize(("changes", "cycles", "stops"), [(False, 60, True), (True, 60, False), (True, 250, True)])
def test_a_tpdo_that_stops(changes: bool, cycles: int, stops: bool) -> None:
    """One that is sent by changes does not stop where nothing changes any more."""
    said = kinds(told(log_text(rpdo(cycles, of=cycles + 40, transmit=True, changes=changes))))
    assert said == [("open", "pdo-missing")] * stops


@pytest.mark.parametrize("silence", [0.3, 0.7, 1.17, 1.45, 1.6, 4.0])
def test_a_restart_is_found_whatever_the_silence_before_it(silence: float) -> None:
    lines = [*beats(5, 5, 0, 6), *beats(4, 5, 0.1, 16), (5.5 + silence, "705#00")]
    lines += [(5.8 + silence, "000#0105"), *beats(5, 5, 6 + silence, 16)]
    assert any(kind in ("node-restarted", "node-silent") for _, kind in kinds(told(log(lines))))


@pytest.mark.parametrize(("since", "shared"), [(None, False), (50, True), (95, False)])
def test_two_senders_of_one_rpdo(since: int | None, shared: bool) -> None:
    assert kinds(told(log_text(rpdo(100, second=since)))) == [("open", "shared-cob-id")] * shared


@pytest.mark.parametrize("reports", [True, False])
def test_a_heartbeat_that_is_switched_off(reports: bool) -> None:
    """It is no problem but by what its consumer does."""
    lines = [*written(0.05, 4, 0x1016, 1, 5 << 16 | 500), *written(0.1, 5, 0x1017, 0, 200, 2), (0.3, "000#0100")]
    lines += [*beats(5, 5, 0.4, 5, 0.2), *beats(4, 5, 0.45, 20), *written(5, 5, 0x1017, 0, 0, 2)]
    lines += [(5.5, "084#3081110000000000")] if reports else []
    said = told(log(lines))
    assert ("heartbeat switched off" in said[0][2]) and said[0][0] == ("open" if reports else "harmless")


@pytest.mark.parametrize(("delay", "value", "two"), [(0.0004, 2, True), (0.0004, 1, False), (0.3, 2, False)])
def test_two_servers_with_one_node_id(delay: float, value: int, two: bool) -> None:
    """The same response again is of one server that repeats itself; one that comes later is of another request."""
    lines = [*beats(5, 5, 0.6, 9)]
    for second in range(1, 7):
        lines += [(second, "605#4018100400000000"), (second + 0.001, "585#4318100401000000")]
        lines += [(second + 0.001 + delay, f"585#43181004{value:02X}000000")]
    assert ("duplicate-node-id" in [kind for _, kind in kinds(told(log(lines)))]) == two


@pytest.mark.parametrize("apart", [0.004, 0.1])
def test_nodes_of_one_supply_are_one_problem(apart: float) -> None:
    lines = [(0, "704#00"), (0.01, "705#00"), (0.02, "706#00"), (0.5, "000#0100"), *beats(6, 5, 0.7, 14)]
    lines += [*beats(4, 5, 0.6, 5), *beats(5, 5, 0.65, 5), (5, "084#2031040000000000"), (7, "704#00"), (7.02, "705#00")]
    lines += [(5 + apart, "085#2031040000000000"), (7.2, "000#0104"), (7.21, "000#0105")]
    lines += [*beats(4, 5, 7.4, 14), *beats(5, 5, 7.45, 14)]
    assert told(log(lines))[0][1] == "supply-voltage"
    assert "supply-voltage" not in [
        kind for _, kind in kinds(told(log([one for one in lines if "#2031" not in one[1]])))
    ]


@pytest.mark.parametrize(("heard", "status"), [(False, ["open"]), (True, [])])
def test_a_monitored_node_that_is_not_there(heard: bool, status: list[str]) -> None:
    lines = [(0, "705#00"), (0.01, "704#00"), *written(0.1, 5, 0x1016, 1, 9 << 16 | 1000), (0.5, "000#0100")]
    lines += [*beats(5, 5, 0.6, 12), *beats(4, 5, 0.62, 12), *(beats(9, 5, 0.3, 12) if heard else [])]
    assert [one for one, kind in kinds(told(log(lines))) if kind == "watched-node-absent"] == status


def test_a_monitored_node_is_missed_also_while_its_consumer_is_written_to() -> None:
    lines = [(0.0, "705#00"), (0.01, "704#00"), *written(0.1, 5, 0x1016, 1, 9 << 16 | 1000), (0.5, "000#0100")]
    lines += [*beats(5, 5, 0.6, 12), *beats(4, 5, 0.62, 12)]
    lines += [line for second in range(1, 12) for line in written(second + 0.03, 5, 0x2000, 0, second)]
    assert kinds(told(log(lines))) == [("open", "watched-node-absent")]


@pytest.mark.parametrize("back", [False, True])
def test_frames_that_an_rpdo_takes_again(back: bool) -> None:
    """RPDO1 has another COB-ID for some time, or for good."""
    lines = [(0.0, "705#00"), *written(0.1, 5, 0x1400, 1, 0x80000205), *written(0.15, 5, 0x1400, 1, 0x305)]
    lines += [(0.5, "000#0105"), *beats(5, 5, 0.6, 12), *cyclic("205#0F00", 1, 11, 0.1)]
    lines += [*written(6, 5, 0x1400, 1, 0x80000305), *written(6.01, 5, 0x1400, 1, 0x205)] if back else []
    assert kinds(told(log(lines))) == [("ended" if back else "open", "frames-not-taken")]


def test_stamps_far_apart_are_no_problem_of_arithmetic() -> None:
    """Heartbeats centuries apart, and one before the other."""
    for first, second in ((0, 9_000_000_000), (9_000_000_000, 0)):
        text = (
            f"({first}.0) can0 705#05\n({second}.0) can0 705#05\n({second}.1) can0 705#00\n({second}.2) can0 704#05\n"
        )
        assert isinstance(told(text.encode()), list)


@pytest.mark.parametrize(("times", "heard", "absent"), [(1, False, False), (2, False, True), (2, True, False)])
def test_commands_to_a_node_that_is_not_there(times: int, heard: bool, absent: bool) -> None:
    lines = [(0, "705#00"), (0.01, "704#00"), (0.5, "000#0105"), (0.6, "000#0104"), *beats(5, 5, 0.7, 12)]
    lines += [*beats(4, 5, 0.72, 12), *((1 + 2 * time, "000#0109") for time in range(times))]
    lines += beats(9, 5, 6, 12) if heard else []
    assert ([kind for _, kind in kinds(told(log(lines)))] == ["node-absent"]) == absent


@pytest.mark.parametrize(("bits", "fits"), [(0x20, False), (0x08, True)])
def test_a_mapping_that_needs_more_than_its_producer_sends(bits: int, fits: bool) -> None:
    lines = [(0, "705#00"), (0.01, "706#00"), *written(0.05, 5, 0x1800, 1, 0xC0000185)]
    lines += [
        *written(0.06, 5, 0x1A00, 0, 0, 1),
        *written(0.1, 5, 0x1A00, 1, 0x62000110),
        *written(0.13, 5, 0x1A00, 0, 1, 1),
    ]
    lines += [*written(0.14, 5, 0x1800, 1, 0x40000185), *written(0.18, 6, 0x1400, 1, 0x80000185)]
    lines += [*written(0.2, 6, 0x1600, 0, 0, 1), *written(0.22, 6, 0x1600, 1, 0x62000100 | bits)]
    lines += [*written(0.24, 6, 0x1600, 0, 1, 1), *written(0.26, 6, 0x1400, 1, 0x185), (0.5, "000#0100")]
    lines += [*beats(5, 5, 0.6, 8), *beats(6, 5, 0.61, 8), *cyclic("185#1122", 1, 8, 0.1)]
    said = told(log(lines))
    assert kinds(said) == ([] if fits else [("open", "pdo-length")])
    assert fits or "node 6's RPDO1 needs 4" in said[0][2]


@pytest.mark.parametrize(("statusword", "told_of"), [("5002", True), ("3702", False)])
def test_a_drive_that_is_commanded_in_vain(statusword: str, told_of: bool) -> None:
    lines = [(0, "70A#00"), *written(0.05, 10, 0x1800, 1, 0xC000018A), *written(0.06, 10, 0x1A00, 0, 0, 1)]
    lines += [*written(0.1, 10, 0x1A00, 1, 0x60410010), *written(0.12, 10, 0x1A00, 0, 1, 1)]
    lines += [*written(0.14, 10, 0x1800, 1, 0x4000018A), *written(0.16, 10, 0x1400, 1, 0x8000020A)]
    lines += [*written(0.2, 10, 0x1600, 0, 0, 1), *written(0.24, 10, 0x1600, 1, 0x60400010)]
    lines += [*written(0.26, 10, 0x1600, 0, 1, 1), *written(0.28, 10, 0x1400, 1, 0x20A), (0.5, "000#010A")]
    lines += beats(10, 5, 0.6, 12)
    for number in range(110):
        word = (6, 7, 15, 15, 15, 15, 15, 15)[number % 8] if told_of else 15
        lines += [(1 + number * 0.1, f"20A#{word:02X}00"), (1.01 + number * 0.1, f"18A#{statusword}")]
    said = told(log(lines))
    assert kinds(said) == [("open", "not-enabled")] * told_of
    assert not told_of or "0250h switch on disabled" in said[0][2]


@pytest.mark.parametrize("answer", [f"605#{DEVICE_TYPE}", f"3C5#{DEVICE_TYPE}", f"585#{DEVICE_TYPE}"])
def test_a_response_with_another_can_id(answer: str) -> None:
    lines = [(0, "705#00"), *beats(5, 5, 0.5, 9)]
    for second in (1, 3, 5):
        lines += [(second, f"605#{READ}"), (second + 0.002, answer)]
        lines += [] if answer.startswith("585") else [(second + 0.9, "605#8000100000000405")]
    said = told(log(lines))
    assert ("answer-on-another-id" in [kind for _, kind in kinds(said)]) == (not answer.startswith("585"))
