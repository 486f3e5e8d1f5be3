"""`--pdo` and `--profile`: PDOs of nodes without a description, and the profile that mappings show.

What it must not do: test how values are written.
"""

from __future__ import annotations

import pytest

from canalyze.configuration import network


@pytest.mark.parametrize(
    ("text", "pdo", "entries"),
    [
        (
            "181=6041:16,6064:32",
            (None, 1, "tpdo", 1),
            ((0x1A00, 0, 2), (0x1A00, 1, 0x60410010), (0x1A00, 2, 0x60640020)),
        ),
        ("5.RPDO3=6040:16", (None, 5, "rpdo", 3), ((0x1602, 0, 1), (0x1602, 1, 0x60400010))),
        (
            "can1:501=6401:01:16,0005:8",
            ("can1", 1, "rpdo", 4),
            ((0x1603, 0, 2), (0x1603, 1, 0x64010110), (0x1603, 2, 0x00050008)),
        ),
        ("5.TPDO512=2000:1:1", (None, 5, "tpdo", 512), ((0x1BFF, 0, 1), (0x1BFF, 1, 0x20000101))),
    ],
)
def test_what_a_pdo_carries_is_read(text: str, pdo: tuple[object, ...], entries: tuple[object, ...]) -> None:
    assert network.pdo_mapping(text) == (*pdo, entries)


@pytest.mark.parametrize(
    "text",
    [
        *("", "181", "181=", "181=6041", "181=6041:0", "181=6041:65", "181=6041:16,", "=6041:16", "180=6041:16"),
        *("581=6041:16", "1A5.TPDO1=6041:16", "5.TPDO513=6041:16", "200.TPDO1=6041:16", "5.TPDO1=6064:32,6041:33"),
        *("00000181=6041:16", ":181=6041:16", "181=60411:16"),
    ],
)
def test_what_is_none_is_none(text: str) -> None:
    assert network.pdo_mapping(text) is None


@pytest.mark.parametrize("text", ["", "5", "5=", "5=400", "0=402", "5=0x192", "=402", ":5=402"])
def test_a_profile_that_is_none(text: str) -> None:
    assert network.profile(text) is None
