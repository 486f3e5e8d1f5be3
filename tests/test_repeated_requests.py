"""Requests that a client sends again before they are answered: told at once, whatever is answered later.

SDO has no repetition: a client that gives up aborts. Beside it the clean captures that look alike: late echoes, frames
captured twice, a beginning in the midst.
"""

from __future__ import annotations

import struct

import pytest
from captures import analyze, log_text
from network import START, STOP, STOPPED, Network, echoed_late, find
from sdo_wire import Channel, segmented_upload


def request(net: Network, index: int = 0x6041) -> Network:
    """A read of an object of node 5."""
    return net.send(0x605, struct.pack("<BHB4x", 0x40, index, 0))


def answer(net: Network, index: int = 0x6041) -> Network:
    """The answer to one, of two bytes, and 1 ms."""
    return net.wait(0.0003).send(0x585, struct.pack("<BHBH2x", 0x4B, index, 0, 7)).wait(0.001)


def known() -> Network:
    """A server that has answered before."""
    return Network().boot(5).read(5, 0x1000, 0, 0x191, 4).wait(0.1)


def retried(net: Network, *, times: int = 1) -> Network:
    """The same read every 0.3 s; only the last one is answered."""
    for _ in range(times):
        request(net).wait(0.3)
    return answer(request(net))


def quiet(net: Network) -> None:
    said = analyze(log_text(net.frames()))
    assert not said.above_info(), said.complaint()


def told(net: Network, frame: int, cause: int) -> None:
    """One finding above info: the request that came again, about the one before it."""
    said = analyze(log_text(net.frames()))
    found = [(f["code"], f["frame"], f["cause_frame"]) for f in said.above_info()]
    assert found == [("SDO015", frame, cause)], said.complaint()


@pytest.mark.parametrize("times", [1, 3])
def test_a_request_that_was_not_answered(times: int) -> None:
    """However the capture goes on."""
    told(retried(known(), times=times).read(5, 0x1018, 1, 5, 4), 5, 4)
    told(request(retried(known(), times=times).wait(0.2)), 5, 4)
    told(retried(known(), times=times).wait(1.5).send(0x705, b"\x7f"), 5, 4)
    told(retried(Network().boot(5), times=times).read(5, 0x1018, 1, 5, 4), 3, 2)


def test_two_objects_in_a_row() -> None:
    net = retried(known()).wait(0.01)
    answer(request(request(net, 0x2018).wait(0.3), 0x2018), 0x2018).read(5, 0x1018, 1, 5, 4)
    said = analyze(log_text(net.frames()))
    found = [(f["code"], f["frame"], f["cause_frame"]) for f in said.above_info()]
    assert found == [("SDO015", 5, 4), ("SDO015", 8, 7)], said.complaint()


def test_a_request_of_each_kind() -> None:
    refused = request(request(known()).wait(0.3))
    refused.wait(0.001).send(0x585, b"\x80\x41\x60\0\0\0\x02\x06").wait(0.001)
    told(refused.read(5, 0x1018, 1, 5, 4), 5, 4)
    transfer = segmented_upload(Channel(5), 0x1008, 0, b"a device with a name")
    for at in range(0, len(transfer), 2):
        net = known()
        for number, frame in enumerate(transfer):
            if number == at:
                net.send(frame.can_id, frame.data).wait(0.3)
            net.send(frame.can_id, frame.data).wait(0.001)
        told(net.read(5, 0x1018, 1, 5, 4), 5 + at, 4 + at)


def test_a_polled_object_of_which_one_answer_is_missing() -> None:
    net = known()
    for value in range(8):
        net.read(5, 0x6041, 0, value, 2).wait(0.3)
    frames = net.frames()
    for number in range(1, 7):
        at = find(frames, 0x585, number)
        said = analyze(log_text([*frames[:at], *frames[at + 1 :]]))
        found = [(f["code"], f["frame"], f["cause_frame"]) for f in said.above_info()]
        assert found == [("SDO015", at + 1, at)], said.complaint()


def test_both_are_answered() -> None:
    """At once, or after the client has asked for something else: it did not wait for the first answer."""
    told(answer(retried(known())).read(5, 0x1018, 1, 5, 4), 5, 4)
    late = answer(request(retried(known()), 0x2018).wait(0.005))
    told(answer(late, 0x2018).wait(0.2).read(5, 0x1018, 2, 5, 4), 5, 4)


def test_what_cannot_be_known() -> None:
    """Twice on the bus or in the capture; the first frames of a capture."""
    quiet(answer(request(request(known()).wait(0.009))).read(5, 0x1018, 1, 5, 4))
    quiet(retried(Network()).read(5, 0x1018, 1, 5, 4))


def test_a_server_that_does_not_answer_at_all() -> None:
    net = Network().heartbeat(5, period=0.1, count=30)
    for _ in range(4):
        request(net).wait(0.3)
    said = analyze(log_text(net.frames()))
    assert [(f["code"], f["frame"]) for f in said.above_info()] == [("SDO031", 1)], said.complaint()


def test_a_node_that_booted_meanwhile() -> None:
    """It has forgotten what it was asked; that it booted is told as ever."""
    net = request(known()).wait(0.3)
    answer(request(net.boot(5).wait(0.1))).read(5, 0x1018, 1, 5, 4)
    said = analyze(log_text(net.frames()))
    assert {f["code"] for f in said.above_info()} <= {"NMT003"}, said.complaint()


@pytest.mark.parametrize("period", [0.004, 0.025, 0.3])
def test_polled_objects_whose_requests_are_listed_late(period: float) -> None:
    """Wherever the capture begins: an answer that stands before its request is no missing one."""
    for known_before in (False, True):
        net = Network().boot(5)
        if known_before:
            net.read(5, 0x1000, 0, 0x191, 4)
        for value in range(12):
            net.read(5, 0x6041, 0, value, 2).wait(period)
        for seed in range(20):
            late = echoed_late(net.frames(), {0x605}, seed=seed)
            for cut in range(4):
                said = analyze(log_text(late[cut:]))
                assert not said.above_info(), f"seed {seed}, from frame {cut + 1}: {said.complaint()}"


def stopped(*, heartbeats: bool) -> Network:
    """A server that was stopped, and shows that or not."""
    net = known().nmt(STOP, 5).wait(0.1)
    return net.heartbeat(5, period=0.1, count=1, state=STOPPED).wait(0.2) if heartbeats else net


@pytest.mark.parametrize("indices", [[0x6041], [0x6041, 0x6041, 0x6041], [0x6041, 0x2018, 0x2019]])
def test_a_server_that_is_stopped_owes_no_answer(indices: list[int]) -> None:
    """Told is the first request; where only the command shows that it is stopped, each that is not answered."""
    codes = {}
    for heartbeats in (True, False):
        net = stopped(heartbeats=heartbeats)
        for index in indices:
            request(net, index).wait(0.3)
        net.nmt(START, 5).send(0x705, b"\x05", after=0.02).wait(0.1).read(5, 0x1018, 1, 5, 4).wait(2)
        said = analyze(log_text(net.send(0x705, b"\x05").frames()))
        codes[heartbeats] = [f["code"] for f in said.above_info()]
    assert codes[True] == ["SDO011"]
    assert set(codes[False]) == {"SDO015" if len(set(indices)) < len(indices) else "SDO002"}


def test_a_server_that_was_stopped_answers_again() -> None:
    """Once it is started, a missing answer is a fault again."""
    net = request(stopped(heartbeats=True)).wait(0.3).nmt(START, 5).wait(0.1)
    net.send(0x705, b"\x05").wait(0.1).read(5, 0x1018, 1, 5, 4).wait(0.1)
    request(net, 0x2018).wait(0.3).read(5, 0x1018, 2, 5, 4)
    said = analyze(log_text(net.frames()))
    assert [f["code"] for f in said.above_info()] == ["SDO011", "SDO002"], said.complaint()


def test_a_request_before_the_server_was_stopped() -> None:
    net = request(known()).wait(0.3).nmt(STOP, 5).wait(0.1)
    said = analyze(log_text(net.heartbeat(5, period=0.1, count=20, state=STOPPED).frames()))
    assert [(f["code"], f["cause_frame"]) for f in said.above_info()] == [("SDO002", 4)], said.complaint()


def test_a_request_that_a_command_may_have_permitted() -> None:
    """The start stands right behind it, as where it was captured late: a missing answer is what is told."""
    net = request(stopped(heartbeats=True)).nmt(START, 5).send(0x705, b"\x05", after=0.02).wait(0.3)
    said = analyze(log_text(net.read(5, 0x1018, 1, 5, 4).wait(2).send(0x705, b"\x05").frames()))
    assert [(f["code"], f["cause_frame"]) for f in said.above_info()] == [("SDO002", 6)], said.complaint()


def mapped(answers: str, *, more: bytes = b"") -> list[str]:
    """The signals of a TPDO, with their provenance, whose mapping is enabled by a write that the client gave up.

    `answers` come after its next request: L the late one, N the next one's.
    """
    net = known()
    net.write(5, 0x1A00, 0, 0, 1).write(5, 0x1A00, 1, 0x20000008, 4)
    net.send(0x605, b"\x2f\x00\x1a\x00\x01\0\0\0").wait(0.3)
    net.send(0x605, more or b"\x2f\x00\x18\x02\x01\0\0\0").wait(0.001)
    for answer in answers:
        index, sub = (0x1A00, 0) if answer == "L" or more else (0x1800, 2)
        net.send(0x585, struct.pack("<BHB4x", 0x60, index, sub)).wait(0.001)
    net.wait(0.3).nmt(START, 5).send(0x705, b"\x05", after=0.02).wait(0.1).send(0x185, b"\x01")
    said = analyze(log_text(net.frames()))
    assert not [f for f in said.above_info() if f["code"] not in ("SDO002", "SDO015")], said.complaint()
    return [f"{signal['index']} {signal['provenance']}" for signal in said.frames[-1]["pdo"]["signals"]]


def test_a_late_answer_confirms_what_was_written() -> None:
    """As long as the server answers in order; what was not confirmed at all is not known to be written."""
    assert mapped("LN") == mapped("L") == ["2000 observed"]
    assert mapped("N") == mapped("NL") == mapped("") == ["2000 unconfirmed"]
    # Written again in the meantime with another value: the last one counts.
    again = b"\x2f\x00\x1a\x00\x00\0\0\0"
    assert mapped("NL", more=again) == mapped("N", more=again) == []
