"""Files that are no text of candump are called by their name, in one line that says what to do."""

import bz2
import gzip
import lzma
from pathlib import Path

import pytest
from conftest import NOTES, Runner

TEXT = NOTES.encode()
PACKED = [
    ("gzip", gzip.compress(TEXT), "zcat {} | canalyze {} -"),
    ("xz", lzma.compress(TEXT), "xzcat {} | canalyze {} -"),
    ("zstd", b"\x28\xb5\x2f\xfd\x24\x17" + TEXT, "zstdcat {} | canalyze {} -"),
    ("bzip2", bz2.compress(TEXT), "bzcat {} | canalyze {} -"),
    ("bzip2", bz2.compress(b""), "bzcat {} | canalyze {} -"),
    ("UTF-16", NOTES.encode("utf-16"), "iconv -f UTF-16 -t UTF-8 {} | canalyze {} -"),
    ("UTF-16LE", NOTES.encode("utf-16-le"), "iconv -f UTF-16LE -t UTF-8 {} | canalyze {} -"),
    ("UTF-16BE", NOTES.encode("utf-16-be"), "iconv -f UTF-16BE -t UTF-8 {} | canalyze {} -"),
]
OTHERS = [
    ("pcap", bytes.fromhex("D4C3B2A1020004000000000000000000FFFF0000E3000000")),
    ("pcap", bytes.fromhex("A1B2C3D40002000400000000000000000000FFFF000000E3")),
    ("pcap", bytes.fromhex("4D3CB2A1020004000000000000000000FFFF0000E3000000")),
    ("pcapng", bytes.fromhex("0A0D0D0A1C0000004D3C2B1A01000000FFFFFFFFFFFFFFFF1C000000")),
    ("Vector ASC", b"date Tue Apr 20 10:11:12.123 am 2021\r\nbase hex  timestamps absolute\r\n"),
    ("Vector ASC", b"base hex  timestamps absolute\n"),
    ("MCAP", b"\x89MCAP0\r\n\x01" + bytes(20)),
]


@pytest.mark.parametrize(("kind", "content", "line"), PACKED)
@pytest.mark.parametrize("command", ["decode", "sdo"])
@pytest.mark.parametrize("lang", ["zh", "en"])
def test_what_undoes_it_is_said(
    canalyze: Runner, tmp_path: Path, kind: str, content: bytes, line: str, command: str, lang: str
) -> None:
    (tmp_path / "my log").write_bytes(content)
    done = canalyze("--lang", lang, command, "my log")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert kind in done.err
    assert done.err.endswith(line.format("'my log'", command) + "\n")


@pytest.mark.parametrize(("kind", "content"), OTHERS)
def test_other_captures_are_not_supported_yet(canalyze: Runner, tmp_path: Path, kind: str, content: bytes) -> None:
    (tmp_path / "capture").write_bytes(content)
    for lang, said in (("zh", "不支持"), ("en", "not supported yet: only candump text")):
        done = canalyze("--lang", lang, "decode", "capture")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert kind in done.err and said in done.err


def test_pipe_is_refused_in_one_line_too(canalyze: Runner) -> None:
    done = canalyze("decode", "-", stdin=gzip.compress(TEXT))
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "zcat | canalyze decode -" in done.err


def test_other_files_are_read_all_the_same(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    (tmp_path / "packed.gz").write_bytes(gzip.compress(TEXT))
    done = canalyze("decode", "packed.gz", notes)
    assert (done.code, len(done.complaints)) == (2, 1)
    assert done.out == canalyze("decode", notes).out
