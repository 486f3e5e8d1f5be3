"""What only follows from one wrong or missing frame is no second fault, and what is fine is none at all.

Configuration that was not acknowledged, commands and boot-ups that cannot be read, errors that explain nothing,
requests that a slave passed over. Beside each fault the same traffic without it. What it must not do: look at SDO
transfers by themselves, which `test_one_fault.py` does.
"""

from __future__ import annotations

import pytest
from captures import analyze, log_text
from network import OPERATIONAL, PRE_OP, PRE_OPERATIONAL, RESET_NODE, START, Frames, Network, find
from test_one_fault import flipped, only, with_data, without

NODE = 5
IDENTITY = (0x11, 0x22, 0x33, 0x44)


def remapped(*, wait: float = 0.01) -> Frames:
    """A node that sends nothing but its PDO, whose mapping is changed in use: of two bytes before, of three after."""
    net = Network().boot(NODE).set_pdo(NODE, 1, [(0x6000, 1, 8), (0x6000, 2, 8)], kind=254).nmt(START, NODE)
    net.cyclic(0x185, period=0.01, payloads=[bytes([k, 1]) for k in range(8)]).wait(0.1)
    net.nmt(PRE_OP, NODE).wait(wait).set_pdo(NODE, 1, [(0x6000, 1, 8), (0x6401, 1, 16)], kind=254).wait(wait)
    net.nmt(START, NODE).cyclic(0x185, period=0.01, payloads=[bytes([k, 1, 2]) for k in range(12)])
    return net.wait(0.2).read(NODE, 0x1000, 0, 0x191, 4).read(NODE, 0x1001, 0, 0, 1).frames()


def places(frames: Frames, *can_ids: int) -> list[int]:
    return [at for at, frame in enumerate(frames) if frame.can_id in can_ids]


def test_what_is_configured_without_a_sound_answer_judges_no_pdo() -> None:
    frames = remapped()
    assert not analyze(log_text(frames)).findings
    assert len(places(frames, 0x585)) > 10
    for at in places(frames, 0x585)[1:-1]:
        for changed in (without(frames, at), with_data(frames, at, b""), flipped(frames, at, 1, 1)):
            said = analyze(log_text(changed))
            assert {f["code"][:3] for f in said.above_info()} == {"SDO"}, f"answer {at + 1}: {said.complaint()}"
            assert len(said.above_info()) == 1, f"answer {at + 1}: {said.complaint()}"
    for at in places(frames, 0x605)[1:-1]:
        for changed in (without(frames, at), flipped(frames, at, 1, 0x10)):
            said = analyze(log_text(changed))
            assert len(said.above_info()) == 1, f"request {at + 1}: {said.complaint()}"


def test_a_refused_write_leaves_the_mapping_as_it_was() -> None:
    net = Network().boot(NODE).set_pdo(NODE, 1, [(0x6000, 1, 8)], kind=254)
    net.exchange(NODE, b"\x2f\x00\x1a\x00\x02", b"\x80\x00\x1a\x00\x22\x00\x00\x08").nmt(START, NODE)
    frames = net.cyclic(0x185, period=0.01, payloads=[bytes([k]) for k in range(5)]).frames()
    assert not analyze(log_text(frames)).above_info()
    at = find(frames, 0x185, 3)
    assert only(analyze(log_text(with_data(frames, at, b""))), "PDO001", frame=at + 1)


def test_pdos_after_a_start_that_cannot_be_read_or_was_lost() -> None:
    frames = remapped()
    at = find(frames, 0x000, 2)
    for data in (b"\x01", b"\x01\x05\0", b"\x33\x05", b"\x01\x85"):
        assert only(analyze(log_text(with_data(frames, at, data))), "NMT001", frame=at + 1)
    net = (
        Network()
        .boot(NODE)
        .nmt(PRE_OP, NODE)
        .wait(0.1)
        .live(NODE, period=0.1, seconds=1, states=[(0, PRE_OPERATIONAL)])
    )
    for number in range(1, 5):
        net.cyclic(0x085 + 0x100 * number, period=0.05, payloads=[bytes([k]) for k in range(10)])
    lost = net.frames()
    said = analyze(log_text(lost))
    assert only(said, "PDO002", frame=find(lost, 0x185, 0) + 1), said.complaint()


def test_pdos_that_a_late_command_might_have_permitted_are_told_when_they_go_on() -> None:
    net = Network().boot(NODE).live(NODE, period=0.1, seconds=2, states=[(0, PRE_OPERATIONAL)]).nmt(PRE_OP, NODE)
    net.wait(0.55).cyclic(0x185, period=0.1, payloads=[bytes([k]) for k in range(10)])
    frames = net.wait(0.003).nmt(PRE_OP, NODE).frames()
    said = analyze(log_text(frames))
    assert only(said, "PDO002"), said.complaint()


@pytest.mark.parametrize("data", [b"", b"\x10", b"\x80", b"\x01", b"\0\0"])
def test_a_boot_up_that_cannot_be_read_is_not_missing(data: bytes) -> None:
    net = Network().boot(NODE).live(NODE, period=0.1, seconds=1, states=[(0, PRE_OPERATIONAL)]).wait(1.05)
    net.nmt(RESET_NODE, NODE).wait(0.05).boot(NODE)
    frames = net.live(NODE, period=0.1, seconds=3, states=[(0, PRE_OPERATIONAL)]).frames()
    assert not analyze(log_text(frames)).findings
    at = find(frames, 0x705, 11)
    assert frames[at].data == b"\0"
    assert only(analyze(log_text(with_data(frames, at, data))), "HBT003 HBT006", frame=at + 1)


def test_a_boot_up_is_missing_whatever_is_commanded_next() -> None:
    net = Network().boot(NODE).nmt(START, NODE).live(NODE, period=0.1, seconds=1, states=[(0, OPERATIONAL)]).wait(1.05)
    net.nmt(RESET_NODE, NODE).wait(0.05).boot(NODE)
    net.live(NODE, period=0.1, seconds=1, states=[(0, PRE_OPERATIONAL), (0.35, OPERATIONAL)])
    frames = net.wait(0.32).nmt(START, NODE).frames()
    assert not analyze(log_text(frames)).findings
    at = find(frames, 0x705, 11)
    assert frames[at].data == b"\0"
    said = analyze(log_text(without(frames, at)))
    assert only(said, "NMT002", frame=at + 1), said.complaint()


def test_an_emergency_after_heartbeats_is_not_before_the_boot_up() -> None:
    net = Network().nmt(RESET_NODE, NODE).live(NODE, period=0.1, seconds=0.5, states=[(0, PRE_OPERATIONAL)]).wait(0.7)
    frames = net.emcy(NODE, 0x3210, 5).wait(0.03).boot(NODE).frames()
    assert "EMC004" not in {f["code"] for f in analyze(log_text(frames)).findings}


def test_a_node_that_was_only_asked_for_is_not_addressed_by_all() -> None:
    net = Network().send(0x605, b"\x40\x18\x10\x04".ljust(8, b"\0")).wait(2).nmt(0x82).wait(0.9)
    frames = net.live(NODE, period=0.25, seconds=2, states=[(0, PRE_OPERATIONAL)]).frames()
    assert {row["code"] for row in analyze(log_text(frames)).above_info()} == {"SDO031"}


def states_and_error(before: int, after: int, *, code: int = 0x3210, beats: int = 5) -> Frames:
    """Heartbeats that change the state without command, 10 ms after an emergency, and back after some of them."""
    net = Network().boot(NODE).nmt(START if before == OPERATIONAL else PRE_OP, NODE)
    states = [(0.0, before), (1.95, after), (1.95 + 0.1 * beats, before)]
    net.live(NODE, period=0.1, seconds=4, states=states)
    return net.wait(1.988).emcy(NODE, code, 1).frames()


def test_an_error_takes_a_node_out_of_operational_and_does_nothing_else() -> None:
    def codes(frames: Frames) -> set[str]:
        return {f["code"] for f in analyze(log_text(frames)).findings}

    down = states_and_error(OPERATIONAL, PRE_OPERATIONAL, beats=100)
    assert codes(down) == {"EMC007", "EMC009", "NMT005"}
    up = states_and_error(PRE_OPERATIONAL, OPERATIONAL, beats=100)
    assert only(analyze(log_text(up)), "NMT004", frame=find(up, 0x705, 20) + 1)
    over = states_and_error(OPERATIONAL, PRE_OPERATIONAL, code=0, beats=100)
    assert only(analyze(log_text(over)), "NMT004", frame=find(over, 0x705, 20) + 1)
    once = states_and_error(OPERATIONAL, PRE_OPERATIONAL, beats=1)
    assert only(analyze(log_text(once)), "NMT004", frame=find(once, 0x705, 20) + 1)


def test_one_heartbeat_with_bit_7_before_a_boot_up() -> None:
    for reset in (1, 2, 3, 5):
        net = Network().live(NODE, period=0.1, seconds=0.1 * reset, states=[(0, OPERATIONAL)]).wait(0.1 * reset + 0.05)
        net.nmt(RESET_NODE, NODE).wait(0.2).boot(NODE)
        frames = net.live(NODE, period=0.1, seconds=2, states=[(0, PRE_OPERATIONAL)]).frames()
        assert not analyze(log_text(frames)).findings
        for at in range(reset):
            said = analyze(log_text(flipped(frames, at, 0, 0x80)))
            assert only(said, "HBT003", frame=at + 1), f"{reset} heartbeats, number {at + 1}: {said.complaint()}"


def test_pdos_that_start_in_a_capture_without_commands() -> None:
    """NMT was filtered out: only that the node stays what it was says that its PDOs should not be."""
    net = Network().read(NODE, 0x1000, 0, 0x191, 4)
    net.live(NODE, period=0.1, seconds=1, states=[(0, PRE_OPERATIONAL), (0.45, OPERATIONAL)])
    started = net.wait(0.42).cyclic(0x185, period=0.01, payloads=[bytes([k]) for k in range(20)]).frames()
    assert not analyze(log_text(started)).above_info()
    net = Network().read(NODE, 0x1000, 0, 0x191, 4).live(NODE, period=0.1, seconds=1, states=[(0, PRE_OPERATIONAL)])
    stayed = net.wait(0.42).cyclic(0x185, period=0.01, payloads=[bytes([k]) for k in range(20)]).frames()
    assert only(analyze(log_text(stayed)), "PDO002", frame=find(stayed, 0x185, 0) + 1)


def test_a_late_sync_has_its_finding_at_its_frame() -> None:
    frames = Network().boot(NODE).sync(period=0.01, count=40).frames()
    for number in range(8, 30):
        at = find(frames, 0x080, number)
        said = analyze(log_text(without(frames, at)))
        assert only(said, "SYN003", frame=at + 1), said.complaint()


def quick_configuration() -> Frames:
    """A master that goes on the moment it has an answer."""
    net = Network().lss_select(*IDENTITY)
    for request, answer in (([0x5E], [0x5E, 7]), ([0x5D], [0x5D, 0x44]), ([0x11, 9], [0x11]), ([0x17], [0x17])):
        net.lss(*request, answer=answer).wait(-0.0195)
    return net.lss(0x04, 0).wait(0.1).nmt(0x82, 7).wait(0.1).boot(9).frames()


def test_an_lss_request_that_was_passed_over() -> None:
    frames = quick_configuration()
    assert not analyze(log_text(frames)).above_info()
    for number in range(1, 5):
        at = find(frames, 0x7E4, number)
        said = analyze(log_text(without(frames, at)))
        assert only(said, "LSS009", frame=at), said.complaint()
        said = analyze(log_text(flipped(frames, at, 0, 1)))
        assert len(said.above_info()) == 1, said.complaint()


def test_one_part_of_an_lss_address_that_is_out_of_order() -> None:
    frames = Network().lss_select(*IDENTITY).lss_select(*IDENTITY).frames()
    assert not analyze(log_text(frames)).above_info()
    for number in (5, 6):
        at = find(frames, 0x7E5, number)
        said = analyze(log_text(flipped(frames, at, 0, 3)))
        assert {f["code"] for f in said.above_info()} <= {"LSS011", "LSS007"}, said.complaint()
        assert [f["code"] for f in said.above_info()].count("LSS011") == 1, said.complaint()
