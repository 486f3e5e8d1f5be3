"""Files that are no text of candump are called by their name, in one line."""

from pathlib import Path

import pytest
from conftest import Runner

OTHERS = [
    ("pcap", bytes.fromhex("D4C3B2A1020004000000000000000000FFFF0000E3000000")),
    ("pcap", bytes.fromhex("A1B2C3D40002000400000000000000000000FFFF000000E3")),
    ("pcap", bytes.fromhex("4D3CB2A1020004000000000000000000FFFF0000E3000000")),
    ("pcapng", bytes.fromhex("0A0D0D0A1C0000004D3C2B1A01000000FFFFFFFFFFFFFFFF1C000000")),
    ("Vector ASC", b"date Tue Apr 20 10:11:12.123 am 2021\r\nbase hex  timestamps absolute\r\n"),
    ("Vector ASC", b"base hex  timestamps absolute\n"),
]


@pytest.mark.parametrize(("kind", "content"), OTHERS)
def test_other_captures_are_not_supported_yet(canalyze: Runner, tmp_path: Path, kind: str, content: bytes) -> None:
    (tmp_path / "capture").write_bytes(content)
    for lang, said in (("zh", "不支持"), ("en", "not supported yet: only candump text")):
        done = canalyze("--lang", lang, "decode", "capture")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert kind in done.err and said in done.err
