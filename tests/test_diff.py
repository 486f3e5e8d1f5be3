"""`diff`: one session taken in other ways is the same; one fault in it is named first, where it is.

The faults are those of the tables by which the rules are proved. By stories: problems of one capture only, and those
that both have and that are others in each. Must not: look at the wording, or test what is diagnosed.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import faults_in_networks as of_network
import faults_of_sdo as of_sdo
import pytest
from captures import SAMPLES, SHARED, CanFrame, Row, console_text, described_beside, log_text, read_log
from comparing import Compared, compared, jittered, late_echoes, renamed
from conftest import Runner, runner

from canalyze import _core

BEYOND_DIFF = {
    "write to an object that is ro": "behind the end of the clean capture",
    "reserved bit of the upload request": "only info: the transfer is the same",
    "reserved bytes of the upload request": "only info: the transfer is the same",
    "reserved bytes of the download response": "only info: the transfer is the same",
    "reserved bit of a segment request": "only info: the transfer is the same",
    "padding of the last segment": "only info: the transfer is the same",
}
"""Faults that are no difference in CANopen terms, and why."""

SESSIONS = [
    path
    for folder in (SAMPLES, SAMPLES / "network", SAMPLES / "stacks")
    for path in sorted(folder.glob("*.log"))
    if path.stem not in ("services", "usdo", "zephyr-sdo", "zephyr-sdo-causal", "sdo-abort")
]
"""Sessions without faults, as far as they can be read here; in sdo-abort the order of frames is what is wrong."""


@pytest.fixture
def canalyze(tmp_path: Path) -> Runner:
    """One process runs all of them: there are many, and they only read and write."""
    return runner(tmp_path, kept=True)


def complaint(said: Compared) -> str:
    return f"{said.closing}\n{said.listed()}"


def frames_of(row: Row) -> set[int]:
    """The frames in either capture that a difference names."""
    places = [row["a_near"], row["b_near"]]
    places += [row[side][key] for side in "ab" if row[side] for key in ("frame", "last_frame")]
    return {place for place in places if place is not None}


@cache
def session(path: Path) -> tuple[CanFrame, ...]:
    return tuple(read_log(path.read_bytes()))


@pytest.mark.parametrize("path", SESSIONS, ids=lambda path: path.stem)
@pytest.mark.parametrize("way", ["itself", "late echoes", "another clock", "another bus", "no stamps"])
def test_another_adapter_is_no_difference(path: Path, way: str) -> None:
    frames = session(path)
    other = {
        "itself": lambda: log_text(frames),
        "late echoes": lambda: log_text(late_echoes(frames)),
        "another clock": lambda: log_text(jittered(frames)),
        "another bus": lambda: log_text(renamed(frames, "slcan")),
        "no stamps": lambda: console_text(frames),
    }[way]()
    network = described_beside(path)
    for pair in ((log_text(frames), other), (other, log_text(frames))):
        said = compared(*pair, network=network)
        assert not said.differences and said.closing["same"], complaint(said)


@pytest.mark.parametrize("path", SESSIONS, ids=lambda path: path.stem)
def test_a_part_of_a_session_is_no_difference(path: Path) -> None:
    frames = session(path)
    count = len(frames)
    network = described_beside(path)
    cuts = [(1, 0), (0, 1), (count // 4, 0), (count // 2, 0), (3 * count // 4, 0), (0, count // 4), (0, count // 2)]
    cuts += [(count // 5, count // 5), (count // 3, count // 8)]
    for begin, end in cuts:
        part = frames[begin : count - end]
        if count < 30 and len(part) < 8:
            continue  # too little to tell where it belongs
        for other in (log_text(part), log_text(jittered(part)), console_text(part)):
            said = compared(log_text(frames), other, network=network)
            assert said.closing["same"], f"{begin} {end} {complaint(said)}"
            mirrored = compared(other, log_text(frames), network=network)
            assert mirrored.closing["same"], f"{begin} {end} {complaint(mirrored)}"


RECORDED = [path for path in sorted((SAMPLES / "recorded").glob("session*.*")) if path.suffix != ".json"]


@pytest.mark.parametrize("path", RECORDED, ids=lambda path: path.name)
def test_however_candump_prints_a_session(path: Path, canalyze: Runner) -> None:
    done = canalyze("diff", "--lang", "en", str(SAMPLES / "recorded/session.log"), str(path))
    assert done.code == 0, done.out


@pytest.mark.parametrize("form", ["a.asc", "a.mcap", "a.pcapng", "a.txt", "a.blf", "a.trc"])
@pytest.mark.parametrize("name", ["network/sync-and-pdos.log", "network/boot-and-states.log", "sdo-block.log"])
def test_other_formats(form: str, name: str, canalyze: Runner, tmp_path: Path) -> None:
    path = str(SAMPLES / name)
    assert canalyze("convert", path, form).code == 0
    for pair in ((path, form), (form, path)):
        done = canalyze("diff", "--lang", "en", *pair)
        assert done.code == 0, done.out


@pytest.mark.skipif(not (SHARED / "stacks").is_dir(), reason="stacks' recordings are not here")
def test_two_recordings_of_one_session_of_a_stack(canalyze: Runner) -> None:
    for log in sorted((SHARED / "stacks").glob("*.log")):
        done = canalyze("diff", "--lang", "en", str(log), str(log.with_suffix(".tax.txt")))
        assert done.code == 0, f"{log.name}\n{done.out}"


def test_a_node_more_is_a_difference() -> None:
    frames = list(session(SAMPLES / "stacks/c3-pdo-remap-master-sync.log"))
    start = frames[0].t_us
    other = [CanFrame(frames[0].bus, 0x723, b"\x05", start + 50_000 * beat) for beat in range(8)]
    said = compared(log_text(frames), log_text(sorted([*frames, *other], key=lambda frame: frame.t_us)))
    assert [(row["what"], row["node"], row["a"]) for row in said.differences] == [("node", 0x23, None)]


@pytest.mark.parametrize("case", of_network.CASES, ids=lambda case: case.name.replace(" ", "-"))
def test_a_fault_in_a_network_is_named_first(case: of_network.Case) -> None:
    clean = list(of_network.clean_frames(case.session))
    frames, places = case.fault(list(clean))
    network = of_network_known(case)
    said = compared(log_text(clean), log_text(frames), network=network)
    if case.name in BEYOND_DIFF:
        assert not said.differences, complaint(said)
        return
    assert said.differences and not said.closing["same"]
    first = said.differences[0]
    near = [abs(frame - place - 1) for frame in frames_of(first) for place in places]
    # A finding stands at the frame that proves it.
    assert min(near) <= (5 if first["what"] == "finding" else 2), complaint(said)
    assert case.node is None or first["node"] == case.node, complaint(said)
    mirrored = compared(log_text(frames), log_text(clean), network=network)
    assert len(mirrored.differences) == len(said.differences), f"{complaint(said)}\n{complaint(mirrored)}"
    assert len(mirrored.incidents) == len(said.incidents), f"{complaint(said)}\n{complaint(mirrored)}"


def of_network_known(case: of_network.Case) -> _core.Network | None:
    from captures import described

    return described(tuple(sorted(case.eds.items())))


@pytest.mark.parametrize("fault", of_sdo.FAULTS, ids=lambda fault: fault.name.replace(" ", "-"))
def test_a_fault_in_a_transfer_is_named_first(fault: of_sdo.Fault) -> None:
    changed = list(fault.session)
    fault.change(changed, fault.at)
    clean, _ = of_sdo.in_company(list(fault.session))
    capture, numbers = of_sdo.in_company(changed)
    said = compared(log_text(clean), log_text(capture))
    if fault.name in BEYOND_DIFF:
        assert not said.differences, complaint(said)
        return
    assert said.differences
    first = said.differences[0]
    assert first["node"] == of_sdo.NODE.node, complaint(said)
    span = range(min(numbers) - 1, max(numbers) + 3)
    assert frames_of(first) & set(span), complaint(said)
    mirrored = compared(log_text(capture), log_text(clean))
    assert len(mirrored.differences) == len(said.differences), f"{complaint(said)}\n{complaint(mirrored)}"
    assert len(mirrored.incidents) == len(said.incidents), f"{complaint(said)}\n{complaint(mirrored)}"


def test_the_faults_that_diff_does_not_know_are_counted() -> None:
    names = [fault.name for fault in of_sdo.FAULTS] + [case.name for case in of_network.CASES]
    assert set(BEYOND_DIFF) <= set(names)
    assert (len(names), len(BEYOND_DIFF)) == (161, 6)


def exchange(t_us: int, request: str, answer: str) -> list[CanFrame]:
    return [
        CanFrame("can0", 0x605, bytes.fromhex(request), t_us),
        CanFrame("can0", 0x585, bytes.fromhex(answer), t_us + 300),
    ]


def polls(count: int, period_us: int, extra: list[CanFrame] | None = None, seed: int = 1) -> bytes:
    """A poll of the position, with values that vary."""
    frames = exchange(1_000_000, "2B17100064000000", "6017100000000000")
    for number in range(count):
        value = (number * 7919 * seed).to_bytes(4, "little").hex()
        frames += exchange(1_100_000 + number * period_us, "4064600000000000", f"43646000{value}")
    frames += exchange(1_200_000 + count * period_us, "2F60600001000000", "6060600000000000")
    return log_text(sorted([*frames, *(extra or [])], key=lambda frame: frame.t_us))


def test_a_poll_is_compared_by_its_pace_only() -> None:
    assert not compared(polls(100, 10_000), polls(101, 9_900, seed=3)).differences
    said = compared(polls(100, 10_000), polls(50, 20_000, seed=3))
    assert [(row["what"], row["index"]) for row in said.differences] == [("poll", "6064")], complaint(said)


READY, ON, ENABLED = 0x0231, 0x0233, 0x0237
"""Statuswords."""


def test_states_that_only_a_poll_shows() -> None:
    """A poll may miss a state between two others."""

    def run(*statuswords: int) -> bytes:
        frames = exchange(1_000_000, "2B17100064000000", "6017100000000000")
        for number, word in enumerate(statuswords):
            answer = f"4B416000{word.to_bytes(2, 'little').hex()}0000"
            frames += exchange(1_100_000 + number * 100_000, "4041600000000000", answer)
        return log_text(frames)

    assert not compared(run(*[READY] * 9, ON, *[ENABLED] * 10), run(*[READY] * 10, *[ENABLED] * 10)).differences


def driven(*statuswords: int, lost: int | None = None) -> bytes:
    """A drive whose TPDO1 has the statusword; frames are lost before the statusword of that number."""
    mapped = [
        ("2F001A0000000000", "60001A0000000000"),
        ("23001A0110004160", "60001A0100000000"),
        ("2F001A0001000000", "60001A0000000000"),
    ]
    frames = [frame for number, pair in enumerate(mapped) for frame in exchange(900_000 + number * 1_000, *pair)]
    before = len(frames)
    for number, word in enumerate(statuswords):
        frames.append(CanFrame("can0", 0x185, word.to_bytes(2, "little"), 1_000_000 + number * 10_000))
    lines = log_text(frames).decode().splitlines(keepends=True)
    if lost is not None:
        lines.insert(before + lost, "DROPCOUNT: dropped 5 CAN frames on 'can0' socket (total drops 5)\n")
    return "".join(lines).encode()


def test_a_state_that_pdos_show_is_a_difference() -> None:
    said = compared(driven(*[READY] * 30, ON, *[ENABLED] * 30), driven(*[READY] * 31, *[ENABLED] * 30))
    assert [row["what"] for row in said.differences] == ["drive_state"], complaint(said)


@pytest.mark.parametrize("lost", [30, 32])
def test_a_state_before_lost_frames_and_another_one_after_them(lost: int) -> None:
    states = [READY] * 30 + [ENABLED] * 30
    assert not compared(driven(*states), driven(*states, lost=lost)).differences
    said = compared(driven(*[READY] * 60, lost=lost), driven(*states, lost=lost))
    assert [row["what"] for row in said.differences] == ["drive_state"], complaint(said)


def polled(start: int, seed: int, share: tuple[float, float]) -> list[CanFrame]:
    """A part of a session in which only the values of a poll say where it belongs; the rest comes twice."""
    chance = random.Random(seed)
    frames: list[CanFrame] = []
    for number in range(120):
        t_us = start + number * 20_000 + chance.randrange(2000)
        frames += exchange(t_us, "4064600000000000", f"43646000{chance.randbytes(4).hex()}")
        if number in (30, 90):
            frames.append(CanFrame("can0", 0x085, bytes.fromhex("1032050000000000"), t_us + 5000))
            frames.append(CanFrame("can0", 0x000, bytes.fromhex("0105"), t_us + 7000))
            frames.append(CanFrame("can0", 0x085, bytes.fromhex("0000000000000000"), t_us + 9000))
    first, last = (int(part * len(frames)) for part in share)
    return frames[first:last]


@pytest.mark.parametrize("text", [log_text, console_text])
def test_what_each_part_shows_once_may_be_two(text: Callable[[list[CanFrame]], bytes]) -> None:
    one, other = polled(1_000_000, 1, (0, 0.7)), polled(900_000_000, 1, (0.4, 1))
    for pair in ((one, other), (other, one)):
        said = compared(log_text(pair[0]), text(pair[1]))
        assert not said.differences, complaint(said)
        assert said.closing["a"]["last_frame"] - said.closing["a"]["first_frame"] in range(70, 80)


def synced(late: bool) -> list[CanFrame]:
    """Polls and SYNC; on the producer's own host its echoes may come behind the frame that follows."""
    frames: list[CanFrame] = polled(1_000_000, 1, (0, 1))
    for number in range(240):
        t_us = 1_000_100 + number * 10_000
        frames.append(CanFrame("can0", 0x080, b"", t_us + (510 if late else 0)))
        frames.append(CanFrame("can0", 0x185, b"\1\2", t_us + 500))
    return sorted(frames, key=lambda frame: frame.t_us)


def test_an_echo_at_the_edge_of_the_other_capture_is_no_frame_more() -> None:
    here, there = synced(late=True), synced(late=False)
    for first in range(200, 230):
        for pair in ((here, there[first:-first]), (there, here[first:-first])):
            said = compared(log_text(pair[0]), log_text(pair[1]))
            assert not said.differences, complaint(said)


def test_two_runs_without_stamps_need_not_have_as_many_frames() -> None:
    def run(seed: int, count: int) -> bytes:
        frames = polled(1_000_000, seed, (0, 1))
        frames += [CanFrame("can0", 0x187, b"\5", 1_000_200 + number * 40_000) for number in range(count)]
        return console_text(sorted(frames, key=lambda frame: frame.t_us))

    assert not compared(run(1, 58), run(2, 60)).differences


def test_what_follows_from_a_fault_comes_behind_it() -> None:
    frames = list(of_network.clean_frames("states"))
    beats = [at for at, frame in enumerate(frames) if frame.can_id == 0x705]
    said = compared(log_text(frames), log_text([f for at, f in enumerate(frames) if at not in beats[4:8]]))
    assert [row["what"] for row in said.differences][:1] == ["frames"], complaint(said)
    assert said.differences[0]["a"]["frame"] == beats[4] + 1


def test_where_nothing_says_what_fits_it_is_said() -> None:
    beats = [CanFrame("can0", 0x000, b"\1\5", 1_000_000 + 50_000 * beat) for beat in range(12)]
    said = compared(console_text(beats), console_text(beats[:7]))
    assert not said.differences and not said.closing["placed"]
    assert "relative position is unknown" in said.text


def test_the_same_transfers_in_another_order_are_not_the_same() -> None:
    written = [exchange(0, f"2F{number:02X}200001000000", f"60{number:02X}200000000000") for number in range(40)]

    def run(order: list[list[CanFrame]]) -> bytes:
        at = [(1_000_000 + 10_000 * place, one) for place, one in enumerate(order)]
        return log_text([replace(frame, t_us=since + frame.t_us) for since, one in at for frame in one])

    said = compared(run(written), run(written[::-1]))
    assert len(said.differences) >= 39 and said.closing["a"]["first_frame"] == 1, complaint(said)


def test_one_poll_of_many_that_is_aborted() -> None:
    abort = exchange(1_504_000, "4064600000000000", "8064600011000906")
    said = compared(polls(100, 10_000), polls(100, 10_000, abort, seed=3))
    assert [(row["what"], row["b"]["value"]["status"]) for row in said.differences] == [("transfer", "aborted")]
    assert said.differences[0]["b"]["frame"] in range(80, 90)


def test_a_value_that_is_written() -> None:
    one = polls(5, 10_000)
    said = compared(one, one.replace(b"2B17100064", b"2B171000C8"))
    (row,) = said.differences
    assert (row["what"], row["index"], row["sub"], row["direction"]) == ("value", "1017", 0, "download")
    assert (row["a"]["frame"], row["b"]["frame"]) == (1, 1)


START = 1_700_000_000_000_000


def beats(gaps: tuple[range, ...] = (), *, count: int = 80, more: tuple[CanFrame, ...] = ()) -> list[CanFrame]:
    """Heartbeats of nodes 5 and 6 every 100 ms, but for those of node 5 in some gaps; and further frames."""
    frames = [
        CanFrame("can0", 0x700 + node, b"\x05", START + beat * 100_000 + node * 500)
        for beat in range(count)
        for node in (5, 6)
        if node == 6 or not any(beat in gap for gap in gaps)
    ]
    # What tells one moment from another: each is written once.
    for number in range(0, count, 4):
        at, data = START + number * 100_000 + 7000, bytes([number, 0x20, 0, number])
        frames.append(CanFrame("can0", 0x606, b"\x2f" + data + bytes(3), at))
        frames.append(CanFrame("can0", 0x586, b"\x60" + data[:3] + bytes(4), at + 400))
    return sorted([*frames, *more], key=lambda frame: frame.t_us)


def told(said: Compared) -> list[tuple[str, int | None, list[str], bool, bool]]:
    return [
        (row["problem"], row["node"], row["differs"], row["a"] is not None, row["b"] is not None)
        for row in said.incidents
    ]


def emcy(beat: int, data: str, node: int = 5) -> CanFrame:
    return CanFrame("can0", 0x080 + node, bytes.fromhex(data), START + beat * 100_000 + 9000)


WELL, LOST, BACK = beats(), beats((range(30, 80),)), beats((range(30, 42),))
RAISED = emcy(20, "1023030000000000")
BRIEFLY, LONGER = (emcy(beat, "0000000000000000") for beat in (26, 40))


def test_a_problem_of_one_capture_only() -> None:
    said = compared(log_text(WELL), log_text(LOST))
    assert told(said) == [("node-silent", 5, [], False, True)]
    assert said.closing["problems"] == 1 and not said.closing["same"]
    assert said.incidents[0]["b"]["status"] == "open"
    assert LOST[said.incidents[0]["b"]["frame"] - 1].can_id == 0x705
    assert told(compared(log_text(LOST), log_text(WELL))) == [("node-silent", 5, [], True, False)]
    assert said.text.startswith("differing problems: 1\n  only in B:\n    node 5: ")


def test_what_both_have_is_no_difference() -> None:
    for frames in (LOST, BACK, beats(more=(RAISED, BRIEFLY))):
        said = compared(log_text(frames), log_text(renamed(frames, "slcan")))
        assert not said.incidents and said.closing["same"]


def test_how_it_stands_and_how_long_it_lasted() -> None:
    def errors(*more: CanFrame) -> bytes:
        return log_text(beats(more=(RAISED, *more)))

    said = compared(log_text(BACK), log_text(LOST))
    assert told(said) == [("node-silent", 5, ["status"], True, True)]
    assert "in both but different:" in said.text and "status A ended, B open" in said.text
    assert told(compared(errors(BRIEFLY), errors(LONGER))) == [("device-error", 5, ["duration"], True, True)]
    both = compared(errors(BRIEFLY), errors(LONGER)).incidents[0]
    assert (both["a"]["duration_ns"], both["b"]["duration_ns"]) == (600_000_000, 2_000_000_000)
    assert "duration A 600 ms, B 2000 ms" in compared(errors(BRIEFLY), errors(LONGER)).text
    assert told(compared(errors(BRIEFLY), errors())) == [("device-error", 5, ["status"], True, True)]


def test_how_often_it_came() -> None:
    often = beats((range(20, 30), range(40, 50), range(60, 70)))
    rows = told(compared(log_text(beats((range(20, 30),))), log_text(often)))
    assert [(kind, node) for kind, node, *_ in rows] == [("node-silent", 5)]
    assert "count" in rows[0][2]


def test_from_what_it_comes() -> None:
    """Node 6 watches node 5 (1016h) and reports its loss; the same report without one comes from nothing."""
    setup = (
        CanFrame("can0", 0x606, bytes.fromhex("23161001C8000500"), START + 1000),
        CanFrame("can0", 0x586, bytes.fromhex("6016100100000000"), START + 1400),
    )
    report = CanFrame("can0", 0x086, bytes.fromhex("3081110000000000"), START + 2_900_000 + 2500 + 202_000)
    caused, alone = beats((range(30, 80),), more=(*setup, report)), beats(more=(*setup, report))
    said = compared(log_text(caused), log_text(alone))
    assert ("heartbeat-consumer-error", 6, ["cause"], True, True) in told(said), told(said)
    (row,) = (row for row in said.incidents if row["node"] == 6)
    assert (row["a"]["cause"], row["b"]["cause"]) == ("node-silent", None)
    # What follows from a story that one capture lacks is told with that story.
    assert told(compared(log_text(caused), log_text(beats(more=setup)))) == [("node-silent", 5, [], True, False)]


def test_what_the_other_capture_does_not_cover_is_not_judged() -> None:
    for part in (WELL[: len(WELL) // 3], [frame for frame in WELL if frame.t_us > START + 4_000_000]):
        for pair in ((LOST, part), (part, LOST)):
            said = compared(*map(log_text, pair))
            assert not said.incidents, told(said)
    assert not compared(log_text(LOST), console_text(WELL)).incidents, "without stamps silence does not show"


def test_captures_that_do_not_begin_together() -> None:
    """What shows by its own frames is judged at once; what something before may explain is not."""
    early = tuple(CanFrame("can0", 0x705, b"\x05", START - 900_000 + beat * 100_000) for beat in range(9))
    for at in (2, 40):
        said = compared(log_text(beats(more=early)), log_text(beats(more=(emcy(at, "1023030000000000"),))))
        assert told(said) == [("device-error", 5, [], False, True)]
    soon, late = beats((range(20, 30),)), beats((range(50, 60),))
    assert not compared(log_text(beats(more=early)), log_text(soon)).incidents
    said = compared(log_text(beats(more=early)), log_text(late))
    assert told(said) == [("node-silent", 5, [], False, True)]


def test_it_is_a_difference_in_both_languages(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_bytes(log_text(BACK))
    (tmp_path / "b.log").write_bytes(log_text(LOST))
    for lang, words in (("en", "differing problems: 1"), ("zh", "问题的差异: 1")):
        done = canalyze("diff", "--lang", lang, "a.log", "b.log")
        assert done.code == 1 and done.lines[0] == words
    rows = [json.loads(line) for line in canalyze("diff", "--format", "jsonl", "a.log", "b.log").lines]
    assert rows[0]["kind"] == "problem_difference" and rows[-1]["problems"] == 1
    filtered = canalyze("diff", "--filter", "node=6", "a.log", "b.log")
    assert filtered.code == 0, "behind a filter problems are not compared"


RULES = ["HBT002", "GRD005", "EMC008", "DRV005", "SDO002"]


@pytest.mark.parametrize("code", RULES)
def test_samples_of_rules_against_their_neighbours(code: str, canalyze: Runner) -> None:
    pair = [str(SAMPLES / "rules" / f"{code}{suffix}.log") for suffix in ("", ".clean")]
    rows: list[Row] = [json.loads(line) for line in canalyze("diff", "--format", "jsonl", *pair).lines]
    assert rows[0]["kind"] == "problem_difference" and rows[0]["b"] is None
    other = [json.loads(line) for line in canalyze("diff", "--format", "jsonl", *pair[::-1]).lines]
    assert [row["b"]["text"] for row in other if row["kind"] == "problem_difference"] == [
        row["a"]["text"] for row in rows if row["kind"] == "problem_difference"
    ]
