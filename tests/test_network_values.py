"""What is said of a network, as text: every spelling that is read, and what is refused."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from canalyze.configuration import network
from canalyze.configuration.network import CanId, Cob, Description, Known, SdoChannel

DESCRIPTIONS = {
    "5=drive.eds": Description(None, (5,), "drive.eds"),
    "0x10=drive.eds": Description(None, (16,), "drive.eds"),
    "1-4,7=io.eds": Description(None, (1, 2, 3, 4, 7), "io.eds"),
    "0x10-0x12=io.eds": Description(None, (16, 17, 18), "io.eds"),
    "7,1-3,2=io.eds": Description(None, (7, 1, 2, 3), "io.eds"),
    "can1:5=drive.eds": Description("can1", (5,), "drive.eds"),
    "a:b:5=drive.eds": Description("a:b", (5,), "drive.eds"),
    "/can1:5=drive.eds": Description("/can1", (5,), "drive.eds"),
    "5=a=b.eds": Description(None, (5,), "a=b.eds"),
    "5=C:drive.eds": Description(None, (5,), "C:drive.eds"),
    "drive.dcf": Description(None, (), "drive.dcf"),
    "of can1:5.dcf": Description(None, (), "of can1:5.dcf"),
    "./a=b.dcf": Description(None, (), "./a=b.dcf"),
    "5": Description(None, (), "5"),
}
COBS = {
    "1A5=5.TPDO1": Cob(None, CanId(0x1A5, False), 5, "tpdo", 1),
    "0x1a5=0x05.tpdo1": Cob(None, CanId(0x1A5, False), 5, "tpdo", 1),
    "can1:1A5=5.RPDO512": Cob("can1", CanId(0x1A5, False), 5, "rpdo", 512),
    "000001A5=5.TPDO1": Cob(None, CanId(0x1A5, True), 5, "tpdo", 1),
    "1FFFFFFF=127.TPDO12": Cob(None, CanId(0x1FFFFFFF, True), 127, "tpdo", 12),
    "1=1.TPDO1": Cob(None, CanId(1, False), 1, "tpdo", 1),
}
CHANNELS = {
    "640,5C0=5": SdoChannel(None, CanId(0x640, False), CanId(0x5C0, False), 5),
    "640, 5C0=0x10": SdoChannel(None, CanId(0x640, False), CanId(0x5C0, False), 16),
    "can1:00000640,000005C0=5": SdoChannel("can1", CanId(0x640, True), CanId(0x5C0, True), 5),
}
PERIODS = {
    "1000": 1_000_000,
    "1000us": 1_000_000,
    "1000 us": 1_000_000,
    "1000\u00b5s": 1_000_000,
    "0.1ms": 100_000,
    ".5ms": 500_000,
    "10MS": 10_000_000,
    "0.01s": 10_000_000,
    "0.25": 250,
    "4294967295": 4_294_967_295_000,
}
RATES = {"500000": 500_000, "125k": 125_000, "1M": 1_000_000, "83.333k": 83_333, "0.8M": 800_000}

GOOD: list[tuple[Callable[[str], object], str, object]] = [
    (read, text, value)
    for read, table in (
        (network.description, DESCRIPTIONS),
        (network.cob, COBS),
        (network.sdo_channel, CHANNELS),
        (network.period, PERIODS),
        (network.tolerance, PERIODS | {"0": 0, "0ms": 0}),
        (network.bit_rate, RATES),
    )
    for text, value in table.items()
]
BAD: dict[Callable[[str], object], list[str]] = {
    network.description: [
        *("", "-", "=", "5=", "5=-", "=a.eds", "0=a.eds", "128=a.eds", "0x80=a.eds", "5x=a.eds", "4-1=a.eds"),
        *("1-=a.eds", "-4=a.eds", "1,,2=a.eds", "1-200=a.eds", ":5=a.eds", "can1:=a.eds", "can1=a.eds", "\u0665=a.eds"),
    ],
    network.cob: [
        *("", "1A5", "1A5=5", "1A5=TPDO1", "1A5=5.TPDO", "1A5=5.TPDO0", "1A5=5.TPDO513", "1A5=5.PDO1", "800=5.TPDO1"),
        *("01A5=5.TPDO1", "20000000=5.TPDO1", "G=5.TPDO1", "1A5=0.TPDO1", "1A5=128.TPDO1", ":1A5=5.TPDO1", "=5.TPDO1"),
        *("5.TPDO1=1A5", "1A5=1,2.TPDO1"),
    ],
    network.sdo_channel: [
        *("", "640=5", "640,640=5", "640,5C0", "640,5C0=0", "640,5C0,5C1=5", "800,5C0=5", ":640,5C0=5", ",=5")
    ],
    network.period: ["", "0", "0ms", "-1", "1m", "1min", "x", "1e3", "ms", "1,5ms", "4294967296", "5000s", "0.0001us"],
    network.tolerance: ["", "-1", "x", "1 2", "4295s"],
    network.bit_rate: ["", "0", "125", "2M", "x", "125kbit", "-125k", "0.0001M"],
}


@pytest.mark.parametrize(("read", "text", "value"), GOOD)
def test_read(read: Callable[[str], object], text: str, value: object) -> None:
    assert read(text) == value


@pytest.mark.parametrize(("read", "text"), [(read, text) for read, texts in BAD.items() for text in texts])
def test_refused(read: Callable[[str], object], text: str) -> None:
    assert read(text) is None


def cobs(*texts: str) -> Known:
    return Known(cobs=tuple(cob for text in texts if (cob := network.cob(text))))


@pytest.mark.parametrize(
    ("filed", "given", "held"),
    [
        ("1A5=5.TPDO1", "1B5=6.TPDO1", ["1A5=5.TPDO1", "1B5=6.TPDO1"]),
        ("1A5=5.TPDO1", "1B5=5.TPDO1", ["1B5=5.TPDO1"]),
        ("1A5=5.TPDO1", "1A5=6.TPDO2", ["1A5=6.TPDO2"]),
        ("1A5=5.TPDO1", "1A5=6.RPDO1", ["1A5=5.TPDO1", "1A5=6.RPDO1"]),
        ("1A5=6.RPDO1", "1A5=7.RPDO1", ["1A5=6.RPDO1", "1A5=7.RPDO1"]),
        ("000001A5=5.TPDO1", "1A5=6.TPDO1", ["000001A5=5.TPDO1", "1A5=6.TPDO1"]),
        ("can0:1A5=5.TPDO1", "1A5=6.TPDO1", ["1A5=6.TPDO1"]),
        ("1A5=5.TPDO1", "can0:1A5=6.TPDO1", ["1A5=5.TPDO1", "can0:1A5=6.TPDO1"]),
    ],
)
def test_option_overrules_only_what_cannot_hold_beside_it(filed: str, given: str, held: list[str]) -> None:
    assert cobs(filed).overruled(cobs(given)) == cobs(*held)


def test_option_overrules_a_channel_that_shares_an_identifier_and_every_time() -> None:
    filed = Known(sdos=(CHANNELS["640,5C0=5"],), sync_period_ns=1, sync_window_ns=2, jitter_ns=3, bitrate=4)
    other = SdoChannel(None, CanId(0x641, False), CanId(0x5C0, False), 6)
    far = SdoChannel(None, CanId(0x641, False), CanId(0x5C1, False), 6)
    given = Known(sdos=(other,), sync_period_ns=10, jitter_ns=0)
    assert filed.overruled(given) == Known(sdos=(other,), sync_period_ns=10, sync_window_ns=2, jitter_ns=0, bitrate=4)
    assert filed.overruled(Known(sdos=(far,))).sdos == (CHANNELS["640,5C0=5"], far)
