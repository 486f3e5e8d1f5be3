"""The bit rate of a CAN interface, as the kernel tells it; on literal bytes, since no test has a real interface."""

import sys

import pytest

from canalyze.sources.netdevices import bit_rate, told_bit_rate

LITTLE = pytest.mark.skipif(sys.byteorder != "little", reason="the bytes are those of a little-endian machine")
HEAD = "78000000 1000 0000 01000000 07000000"  # nlmsghdr: 120 bytes, RTM_NEWLINK
LINK = "0000 1801 03000000 c1000400 00000000"  # ifinfomsg: ARPHRD_CAN, index 3
NAME = "0900 0300 63616e3000 000000"  # IFLA_IFNAME "can0", filled up
KIND = "0800 0100 63616e00"  # IFLA_INFO_KIND "can"
TIMING = "2400 0100 20a10700 6b030000 7d000000 06000000 07000000 02000000 01000000 0a000000"  # 500000 bit/s, 0.875
STATE = "0800 0400 00000000"  # IFLA_CAN_STATE, before the timing in what the kernel gives


def answer(info: str, head: str = HEAD) -> bytes:
    return bytes.fromhex(head + LINK + NAME + info)


DATA = "3000 0280" + STATE + TIMING  # IFLA_INFO_DATA, marked as nested


@LITTLE
def test_it_is_found_among_the_attributes() -> None:
    assert told_bit_rate(answer("3c00 1200" + KIND + DATA)) == 500_000


@LITTLE
@pytest.mark.parametrize(
    "info",
    [
        "",
        "0d00 1200 0900 0100 7663616e00 000000",  # vcan has no data
        "3d00 1200 0900 0100 7663616e00 000000" + DATA,  # another kind's data mean something else
        "1400 1200" + KIND + "0800 0280 00000000",
        "3c00 1200" + KIND + "3000 0280" + STATE + TIMING.replace("20a10700", "00000000"),  # not set yet
        "0000 0000",
        "ffff 1200" + KIND,
    ],
)
def test_where_there_is_none(info: str) -> None:
    assert told_bit_rate(answer(info)) is None


@LITTLE
def test_an_error_or_half_an_answer_says_nothing() -> None:
    whole = answer("3c00 1200" + KIND + DATA)
    assert told_bit_rate(answer("3c00 1200" + KIND + DATA, HEAD.replace("1000 0000", "0200 0000"))) is None
    for length in range(len(whole)):
        assert told_bit_rate(whole[:length]) in (None, 500_000)


def test_of_no_interface() -> None:
    assert bit_rate("no-such-interface") is None and bit_rate("lo") is None
